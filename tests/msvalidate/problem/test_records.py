"""Every record prints as one short line that says what it is, whatever arrays it holds."""

import importlib
import pkgutil

import pandas as pd
import pytest

import msvalidate as ms
import reference_fem
from msvalidate.bench.judging.evidence import Evidence, Observed, Tolerance
from msvalidate.problem.records import LONGEST_REPR, short_repr

ELSEWHERE = {
    "msvalidate.bench.output.front",
    "msvalidate.bench.output.page",
}  # rows of pages: texts alone
BOX = ms.Box((1.0, 1.0))
PULL = ms.Traction(BOX.side("right"), (10.0, 0.0))
HELD = ms.Support(BOX.side("left"), (0.0, 0.0))
PROBLEM = ms.Problem(BOX, ms.Isotropic(3e3, 1 / 3), (HELD,), (PULL,))


def records_of(package):
    """Data classes that a package defines, wherever they stand in it."""
    for kind in vars(package).values():
        ours = isinstance(kind, type) and kind.__module__ == package.__name__
        if ours and "__dataclass_fields__" in vars(kind):
            yield kind
    for module in pkgutil.iter_modules(getattr(package, "__path__", ())):
        if module.name not in {"__main__", "study", "studies"}:
            yield from records_of(importlib.import_module(f"{package.__name__}.{module.name}"))


@pytest.mark.parametrize(("package", "least"), [(ms, 100), (reference_fem, 30)])
def test_no_record_keeps_the_long_repr(package, least):
    found = list(records_of(package))
    assert len(found) > least
    long = [kind for kind in found if kind.__repr__ is not short_repr]
    assert {kind.__module__ for kind in long} <= ELSEWHERE


@pytest.mark.parametrize("n", [5, 99])
def test_a_record_of_any_size_prints_in_a_line(n):
    lattice = ms.square(BOX, n)
    network = ms.lattice_network(PROBLEM, lattice)
    body = reference_fem.box_discretisation(BOX, n, "Q1")
    mesh = ms.Mesh(body.points, body.cells, "quad")
    limits = tuple(Tolerance(f"gap {i}", 0.5, "m", "so") for i in range(n))
    gaps = {row.quantity: Observed(0.0) for row in limits}
    frame = {"t": pd.DataFrame({"x": range(n)})}
    evidence = Evidence(frame, gaps, limits, columns={"x": "m"}, findings=("f" * 300,) * n)
    records = [lattice, lattice.pattern, network, network.layout, ms.equilibrium(network), evidence]
    records += [body, reference_fem.solve_problem(PROBLEM, body), mesh]
    records += [ms.State(network.points, network.displacement)]
    records += [ms.Problem(mesh, PROBLEM.material, (HELD,), (PULL,))]
    for text in map(repr, records):
        assert "\n" not in text
        assert len(text) <= LONGEST_REPR, text


def test_a_print_says_what_is_in_a_record():
    network = ms.lattice_network(PROBLEM, ms.square(BOX, 5))
    assert "points=<36x2: 0 to 1>, springs=<110x2>, stiffness=<110: 1125 to 2250>" in repr(network)
    assert "material=Isotropic(...), supports=(Support(...),)" in repr(PROBLEM)
    assert "constants=(2250, 1125)" in repr(ms.calibrate(3e3, 1 / 3, ms.patterns.square()))
