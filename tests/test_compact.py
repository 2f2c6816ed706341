"""The source report in one file, examples/compact.py: an oracle that shares nothing with ours.

Its particles rest where Newton's method puts our network, its integrators take the steps of ours,
and docs/teaching.md says what it prints.
"""

from __future__ import annotations

import re
import runpy
import sys
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from examples import compact
from msvalidate import (
    INTEGRATORS,
    Box,
    Isotropic,
    Problem,
    State,
    Support,
    Traction,
    equilibrium,
    homogenise,
    lattice_network,
    motion,
    natural_frequencies,
    patterns,
    square,
)
from msvalidate.springs.dynamics import variants
from msvalidate.springs.dynamics.step_limits import stability_limit
from tests.table import table

ROOT = Path(__file__).resolve().parents[1]
PROGRAM = ROOT / "examples" / "compact.py"
PAGE = (ROOT / "docs" / "teaching.md").read_text("utf-8")
ROWS = re.findall(r"^\| `(--.*?)` \| (.*?) \| (.*?) ?\| (.*?) ?\|$", PAGE, re.MULTILINE)
CELLS, PULL, DAMPING, STEP = (
    compact.NUMBERS[name] for name in ("cells", "pull", "damping", "step")
)
SAME_REST = 1e-9
"""Of the displacement. Force and speed stop at 1e-11 of the pull on each of 72 components, so the
springs are out of balance by 1.3e-10 of it in all; over the least stiffness, 0.065 N/m, that is
2e-9 m for 1 N/m of pull, under which the displacement is 3.7 m."""
SAME_STEPS = 0.02
"""Of a number of steps: where rounding of another processor's would let a threshold fall."""
PRINTED = {
    "algorithm1": INTEGRATORS["euler_cromer"],
    "euler": INTEGRATORS["explicit_euler"],
    "euler-cromer": variants.EULER_CROMER_AS_PRINTED,
    "verlet": variants.VERLET_AS_PRINTED,
}


def network(k2=0.5, weights="shared"):
    """Ours of the same block, 36 particles of 1 kg."""
    box = Box((CELLS, CELLS))
    problem = Problem(
        domain=box,
        material=Isotropic(E=4 / 3, nu=1 / 3, density=(CELLS + 1) ** 2 / CELLS**2),
        supports=(
            Support(box.side("left"), (0.0, None)),
            Support(box.side("bottom"), (None, 0.0)),
        ),
        loads=(Traction(box.side("right"), (PULL, 0.0)),),
    )
    lattice = square(box, (CELLS, CELLS))
    return lattice_network(problem, lattice, (1.0, k2), weights=weights, mass="equal")


def at_points(u, points):
    i, j = points.round().astype(int).T
    return u[i, j]


def rest(**options):
    *_, u = compact.algorithm1(**compact.NUMBERS | options)
    return u


def distance(u, v):
    return abs(u - v).max() / abs(v).max()


def ratio(network, u):
    """Of the right side's mean displacement to the upper side's."""
    x, y = network.points.T
    return -u[y == y.max(), 1].mean() / u[x == x.max(), 0].mean()


def started(capsys, monkeypatch, options):
    """Exit code and what is printed."""
    monkeypatch.setattr(sys, "argv", [str(PROGRAM), *options.split()])
    code = 0
    try:
        runpy.run_path(str(PROGRAM), run_name="__main__")
    except SystemExit as end:
        code = end.code
    return code, *capsys.readouterr()


@pytest.mark.parametrize(("k2", "weights"), [*product((0.5, 2.0), ("shared", "equal"))])
def test_it_rests_where_newton_does(k2, weights):
    ours = network(k2, weights)
    newton = equilibrium(ours, geometry="nonlinear").displacement
    theirs = at_points(rest(k2=k2, whole=weights == "equal"), ours.points)
    assert distance(theirs, newton) < SAME_REST
    assert abs(ratio(ours, theirs) - ratio(ours, newton)) < SAME_REST
    # A fault as small as a thousandth of one constant, or the other rule at the edge, is seen.
    others = (
        network(k2 * 1.001, weights),
        network(k2, {"shared": "equal", "equal": "shared"}[weights]),
    )
    for other in others:
        moved = equilibrium(other, geometry="nonlinear").displacement
        assert distance(theirs, moved) > 1e4 * SAME_REST


def test_elements_are_the_uniform_strain_of_the_lattice():
    for k2 in (0.5, 1.0, 2.0):
        C = homogenise(patterns.square(), (1.0, k2)).tensor
        strain = np.linalg.solve(C[:2, :2], (PULL, 0.0))
        x = np.indices((CELLS + 1, CELLS + 1)).transpose(1, 2, 0)
        assert distance(compact.elements(CELLS, k2, PULL), strain * x) < 1e-12  # rounding


@table("name", compact.INTEGRATORS)
def test_integrators_take_our_steps(name):
    ours, steps = network(), 40
    at = [at_points(u, ours.points) for u, _ in zip(
        compact.algorithm1(**compact.NUMBERS, integrator=name), range(steps + 1), strict=False
    )]  # fmt: skip
    start = State(ours.points, np.zeros_like(ours.points))
    end = motion(ours, start, PRINTED[name], STEP, steps, DAMPING, warn=False)
    assert distance(at[-1], end.position - ours.points) < 1e-11  # rounding of positions, 40 times
    others = [s for s in PRINTED.values() if s.step is not PRINTED[name].step]
    ends = [motion(ours, start, s, STEP, steps, DAMPING, warn=False).position for s in others]
    differ = [distance(at[-1], x - ours.points) > 1e-3 for x in ends]
    assert differ.count(False) == name.startswith("euler")  # as printed one of them is the other


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row[0])
def test_the_page_prints_what_it_prints(row, capsys, monkeypatch):
    options, steps, poisson, difference = row
    code, out, err = started(capsys, monkeypatch, options)
    if steps == "never":
        assert (code, out) == (3, "")
        assert re.fullmatch(r"compact.py: unstable after \d+ steps: reduce --step\n", err)
    else:
        assert f"ratio of the springs {poisson}, " in out
        assert f"elements: {difference} " in out
        assert int(steps) == pytest.approx(int(out.split()[3]), rel=SAME_STEPS)


def test_the_page_shows_it_as_it_is(capsys, monkeypatch):
    shown = re.search(r"```text\n(.*?)```", PAGE, re.DOTALL)[1]
    code, out, err = started(capsys, monkeypatch, "")
    steps = re.compile(r"(?<=^at rest after )\d+")
    assert (code, steps.sub("", out), err) == (0, steps.sub("", shown), "")
    assert int(steps.search(shown)[0]) == pytest.approx(int(steps.search(out)[0]), rel=SAME_STEPS)
    assert len(PROGRAM.read_text("utf-8").splitlines()) <= 80
    assert len(ROWS) >= 4 * 3


@pytest.mark.parametrize("options", ["--k2 20 --step 0.1", "--k2 2 --step 0.02"])
def test_rounding_of_stiff_springs_and_of_small_steps_is_rest(options, capsys, monkeypatch):
    code, out, _ = started(capsys, monkeypatch, options)
    assert code == 0
    assert float(out.split("beside elements: ")[1].split()[0]) < 1e-3


def number(pattern):
    return float(re.search(pattern, PAGE)[1])


def test_the_page_explains_what_is_so():
    found = {options: tuple(map(float, rest)) for options, *rest in ROWS if rest[0] != "never"}
    for options, (_, _, difference) in found.items():
        if options.startswith("--pull"):  # E = 4/3; the next term weighs the strain
            assert difference == pytest.approx(float(options.split()[1]) * 0.75 / 3, rel=0.06)
        if options.startswith("--whole"):
            cells = int(options.partition("--cells ")[2] or CELLS)
            larger = 0.5 / (1 + 1 / cells + 0.5)
            assert found[options][1] == pytest.approx(larger, rel=0.02 if cells > 1 else 1e-3)
    C = homogenise(patterns.square(), (1.0, 2.0)).tensor
    along = C[0, 0] + C[0, 1]
    nu = (along - 2 * C[2, 2]) / (along + 2 * C[2, 2])
    assert nu == pytest.approx(1 / number(r"the ratio 1/(\d)"))
    (slowest, *_), fastest = natural_frequencies(network())
    assert number(r"excites has ω = ([\d.]+)") == pytest.approx(slowest, abs=5e-4)
    assert number(r"c = 2ω is ([\d.]+)") == pytest.approx(2 * slowest, abs=5e-3)
    assert number(r"at ω = ([\d.]+)") == pytest.approx(fastest, abs=5e-4)
    assert number(r"here ([\d.]+) s") == pytest.approx(DAMPING / fastest**2, abs=5e-4)
    least, usual, most = (found[f"--damping {c}"][0] for c in ("0.17", "0.5", "1.5"))
    assert usual < least < most
    limit = stability_limit(PRINTED["algorithm1"], slowest, fastest, number(r"From ([\d.]+) kg/s"))
    assert limit == pytest.approx(STEP, rel=5e-3)


@pytest.mark.parametrize(
    "options",
    ["--k2 nan", "--k2 0", "--cells 2.5", "--cells 21", "--step -1", "--integrator no", "--who"],
)
def test_bad_options_take_one_line(options, capsys, monkeypatch):
    code, out, err = started(capsys, monkeypatch, options)
    assert (code, out) == (2, "")
    assert re.fullmatch(r"compact.py: error: .*\n", err)
