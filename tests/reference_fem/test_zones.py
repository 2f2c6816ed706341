"""Elements of several materials: bars exact, and the closed form of a disc."""

from __future__ import annotations

import re

import numpy as np
import pytest
from scipy.optimize import brentq

import reference_fem
from msvalidate.problem import (
    Box,
    Isotropic,
    Problem,
    ProblemError,
    Region,
    SolverError,
    Support,
    Traction,
    Zone,
    prescribed_displacements,
)
from reference_fem.elasticity import elastic_tensor, solve_on, stiffness
from reference_fem.large_strain import Solid, deform, laws_of
from reference_fem.materials import materials_of
from reference_fem.mesh.elements import of_dimension
from tests.inclusion import disc, disc_mesh, moduli
from tests.table import table

ROUNDING = 1e-13
BOX = Box((2.0, 1.0))
STEP = 1e-4
"""Of central differences, whose error is then 1e-8 and whose rounding 1e-12."""
DISCS = {
    "stiff": (Isotropic(1.0, 0.3), Isotropic(10.0, 0.2)),
    "soft": (Isotropic(1.0, 0.3, "plane_strain"), Isotropic(0.1, 0.45, "plane_strain")),
    "rubber about": (Isotropic(1.0, 0.4999, "plane_strain"), Isotropic(1.0, 0.3, "plane_strain")),
}
TENSIONS = {"uniform": (1.0, 0.0), "shear": (0.0, 1.0)}


# Discs --------------------------------------------------------------------------------------------


def stress_of(field, x, material):
    """Stress (n, d, d) of a displacement field by central differences and Lamé's constants."""
    d = x.shape[1]
    slope = [(field(x + STEP * e) - field(x - STEP * e)) / (2 * STEP) for e in np.eye(d)]
    strain = np.stack(slope, axis=2)
    strain = (strain + strain.transpose(0, 2, 1)) / 2
    mu, K, _ = moduli(material)
    trace = np.trace(strain, axis1=1, axis2=2)[:, None, None] * np.eye(d)
    return 2 * mu * strain + (K - 2 * mu / d) * trace


def around(mesh, field, outer, inner):
    """A mesh moved all round as a field is."""
    parts = tuple((lambda x, axis=axis: field(x)[:, axis]) for axis in range(mesh.dim))
    held = (Support(mesh.whole_surface, parts),)
    return Problem(mesh, outer, held, zones=(Zone(mesh.zone("disc"), inner),))


@pytest.mark.parametrize("mixed", [False, True])
@pytest.mark.parametrize("tension", TENSIONS)
@table("name", DISCS)
def test_discs_are_met_to_third_order(name, tension, mixed):
    outer, inner = DISCS[name]
    if mixed and outer.state == "plane_stress":
        return
    errors = []
    for n in (2, 4, 8):
        mesh = disc_mesh(n)
        field = lambda x: disc(x, outer, inner, *TENSIONS[tension])  # noqa: E731
        body = reference_fem.mesh_discretisation(mesh)
        found = reference_fem.solve_problem(around(mesh, field, outer, inner), body, mixed=mixed)
        wanted = field(mesh.points)
        errors.append(np.abs(found.displacement - wanted).max() / np.abs(wanted).max())
    lost = name == "rubber about" and not mixed  # quadratic elements lose an order near nu = 1/2
    assert np.log2(errors[0] / errors[-1]) / 2 > (1.2 if lost else 2.8)
    assert errors[-1] < (6e-3 if lost else 3e-4)
    if lost:
        return
    # Uniform inside, and the same on its rim as seen from the cells there.
    places = np.array([[0.0, 0.0], [0.1, 0.2], [0.3, 0.3]])
    stress = found.stress(places)
    wanted = stress_of(field, places, inner)
    np.testing.assert_allclose(stress[:, [0, 1, 2]], wanted[:, [0, 1, 0], [0, 1, 1]], atol=2e-3)


# Bars ---------------------------------------------------------------------------------------------


def bar(series, state="plane_strain", nu=(0.2, 0.4)):
    soft, hard = Isotropic(1e5, nu[0], state), Isotropic(3e5, nu[1], state)
    rollers = [Support(BOX.side("left"), (0.0, None)), Support(BOX.side("bottom"), (None, 0.0))]
    if series:
        rollers.append(Support(BOX.side("top"), (None, 0.0)))
        loads = (Traction(BOX.side("right"), (3.0, 0.0)),)
        region = Region(((1.0, 2.0), None))
    else:
        rollers.append(Support(BOX.side("right"), (0.01, None)))
        loads, region = (), Region((None, (0.5, 1.0)))
    return Problem(BOX, soft, tuple(rollers), loads, zones=(Zone(region, hard),))


@pytest.mark.parametrize("series", [True, False], ids=["series", "parallel"])
@table("element, mixed", [*((name, 0) for name in of_dimension(2)), ("Q2", 1), ("P2", 1)])
def test_bars_of_two_materials_are_exact(element, mixed, series):
    problem = bar(series)
    body = reference_fem.box_discretisation(BOX, (4, 2), element)
    found = reference_fem.solve_problem(problem, body, mixed=bool(mixed))
    C = [elastic_tensor(material) for material in problem.materials]
    x, y = body.points.T
    if series:
        wanted = 3 * np.minimum(x, 1) / C[0][0, 0] + 3 * np.maximum(x - 1, 0) / C[1][0, 0]
        wanted = np.column_stack([wanted, 0 * x])
        stress = [(3.0, 3.0 * c[0, 1] / c[0, 0], 0.0) for c in C]
    else:
        ratio = [c[0, 1] / c[0, 0] for c in C]
        down = ratio[0] * np.minimum(y, 0.5) + ratio[1] * np.maximum(y - 0.5, 0)
        wanted = 0.005 * np.column_stack([x, -down])
        stress = [
            (0.005 * (c[0, 0] - r * c[0, 1]), 0.0, 0.0) for c, r in zip(C, ratio, strict=True)
        ]
    assert np.abs(found.displacement - wanted).max() <= ROUNDING * np.abs(wanted).max()
    # Each side of the interface has its own, and a node on it the mean of its cells.
    places = [[0.9, 0.2], [1.1, 0.8], [1.0, 0.5]]
    size, mean = np.abs(stress).max(), np.mean(stress, axis=0)
    got = found.stress(places)
    np.testing.assert_allclose(got[:2], stress, atol=1e-11 * size)
    if element.startswith("Q"):
        np.testing.assert_allclose(got[2], mean, atol=1e-11 * size)


def test_a_bar_of_two_materials_at_large_strain():
    # In series the stretches a and b of the halves have one stress and add up to what is asked for.
    problem = bar(series=True)
    body = reference_fem.box_discretisation(BOX, (4, 2), "Q2")
    law = laws_of(problem, body)
    first, second = law.laws

    def pull(part, stretch):
        return part.stress(np.diag([stretch, 1.0])[None])[0, 0, 0]

    a = brentq(lambda a: pull(first, a) - pull(second, 3.0 - a), 1.0, 2.0, xtol=1e-15)
    end = Support(BOX.side("right"), (1.0, None))
    moved = Problem(BOX, problem.material, (*problem.supports, end), zones=problem.zones)
    held, displacement = prescribed_displacements(moved, body.points)
    found = deform(Solid(body, law, held), displacement, np.zeros_like(displacement), parts=4)
    x = body.points[:, 0]
    wanted = (a - 1) * np.minimum(x, 1) + (2 - a) * np.maximum(x - 1, 0)
    np.testing.assert_allclose(found.displacement[:, 0], wanted, atol=1e-9)
    reaction = found.reaction[x == 2, 0].sum()
    assert reaction == pytest.approx(pull(first, a), rel=1e-9)
    # At small strain it is the linear body's.
    small, force = 1e-7 * displacement, np.zeros_like(displacement)
    linear = solve_on(body, materials_of(problem, body), held, small, force)
    np.testing.assert_allclose(
        deform(Solid(body, law, held), small, force).displacement, linear, atol=1e-13
    )


@table("solve, kind, message", [
    (lambda p: reference_fem.solve_problem(p, reference_fem.box_discretisation(BOX, (3, 2))),
        ProblemError, "zone (1 <= x <= 2): it ends inside 2 of 6 cells"),
    (lambda p: stiffness(reference_fem.box_discretisation(BOX, (4, 2)), materials_of(p,
        reference_fem.box_discretisation(BOX, (2, 1)))), ProblemError,
        "materials: of (2,) cells; the mesh has 8"),
    (lambda p: Solid(reference_fem.box_discretisation(BOX, (2, 2)), laws_of(p,
        reference_fem.box_discretisation(BOX, (4, 2))), np.ones((25, 2), dtype=bool)), ProblemError,
        "laws: of 8 cells; the mesh has 4"),
    (lambda _: reference_fem.solve_problem(bar(True, nu=(0.2, 0.4999999)),
        reference_fem.box_discretisation(BOX, (4, 2), "Q1")), SolverError, "lock"),
    (lambda _: reference_fem.solve_problem(bar(True, "plane_stress"),
        reference_fem.box_discretisation(BOX, (4, 2), "Q2"), mixed=True), ProblemError,
        "mixed elements: plane stress"),
    (lambda _: reference_fem.solve_problem(bar(True, nu=(0.2, -0.1)),
        reference_fem.box_discretisation(BOX, (4, 2), "Q2"), mixed=True), ProblemError,
        "nu = -0.1"),
])  # fmt: skip
def test_what_is_refused(solve, kind, message):
    with pytest.raises(kind, match=re.escape(message)) as refused:
        solve(bar(series=True))
    assert "\n" not in str(refused.value)
