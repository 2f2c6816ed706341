"""Mixed elements: independent values, manufactured solution, no locking, what they refuse."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import reference_fem
from msvalidate.problem import (
    SIDES,
    Anisotropic,
    BodyForce,
    Box,
    Isotropic,
    Mesh,
    Problem,
    ProblemError,
    SolverError,
    Support,
    Traction,
)
from reference_fem.elasticity import check_arrays
from reference_fem.mesh import Facets, make_discretisation
from reference_fem.mesh.elements import ELEMENTS
from reference_fem.mixed import solve_mixed_on
from tests.table import table

# A library's warning on the way to an answer is a failure here.
pytestmark = pytest.mark.filterwarnings("error")

CASES = sorted((Path(__file__).parents[1] / "data" / "fem").glob("*_TaylorHood_*.json"))
QUADRATIC = [name for name, kind in ELEMENTS.items() if kind.degree == 2]
PLANE = [name for name in QUADRATIC if ELEMENTS[name].dim == 2]


# --- independent values ---------------------------------------------------------------------------


def arguments(path):
    case = json.loads(path.read_text(encoding="utf-8"))
    law = case["material"]
    material = Isotropic(law["E"], law["nu"], law["state"], thickness=case["thickness"])
    rows = case["fixed"], case["nodal_forces"]
    return case, (case["nodes"], case["cells"], case["element"], material, *rows)


def solve_mixed(points, cells, element, material, fixed, forces):
    """On a mesh as arrays, of elements by the names of both parts."""
    body = make_discretisation(points, cells, element.split("-")[0])
    return solve_mixed_on(body, material, *check_arrays(body, fixed, forces))


def test_there_are_independent_values_for_three_ratios():
    assert [arguments(path)[0]["material"]["nu"] for path in CASES] == [0.49, 0.4999, 0.5]


@pytest.mark.parametrize("path", CASES, ids=lambda path: path.stem)
def test_independent_values(path):
    case, asked = arguments(path)
    displacement, pressure = solve_mixed(*asked)
    for found, name in ((displacement, "displacements"), (pressure, "pressure_at_vertices")):
        wanted = np.array(case[name])
        assert found.shape == wanted.shape
        # Both sides solve one linear system exactly; left is rounding times its condition, 1e-12.
        assert np.abs(found - wanted).max() <= 1e-9 * np.abs(wanted).max()


# --- manufactured solution ------------------------------------------------------------------------

SIZE = (1.2, 0.8, 1.0)
E = 2.0
WAVES = {2: np.array([2.1, 1.3]), 3: np.array([2.1, 1.3, -0.8])}
ACROSS = {2: np.array([-1.3, 2.1]) / 2, 3: np.array([[0.5, -1.0, 0.7]])[0]}
SWELL = {2: np.array([1.1, -1.7]), 3: np.array([1.1, -1.7, 0.9])}


def across(d):
    """A direction at right angles to the wave, so that its displacement has no divergence."""
    k, a = WAVES[d], ACROSS[d]
    return a - (a @ k) / (k @ k) * k


def constants(nu):
    return E / (2 * (1 + nu)), (1 + nu) * (1 - 2 * nu) / (E * nu)


def pressure(x):
    return np.sin(x @ SWELL[x.shape[1]] + 0.3)


def displacement(nu, x):
    """A shear wave, and as much of a pressure wave as p = λ div u asks for: none at nu = 1/2."""
    d = x.shape[1]
    q = SWELL[d]
    shear = np.sin(x @ WAVES[d] - 0.4)[:, None] * across(d)
    return shear - constants(nu)[1] * np.cos(x @ q + 0.3)[:, None] * q / (q @ q)


def gradient(nu, x):
    d = x.shape[1]
    q = SWELL[d]
    shear = np.cos(x @ WAVES[d] - 0.4)[:, None, None] * np.outer(across(d), WAVES[d])
    return shear + constants(nu)[1] * pressure(x)[:, None, None] * np.outer(q, q) / (q @ q)


def stress(nu, x):
    g = gradient(nu, x)
    mu, _ = constants(nu)
    return mu * (g + g.transpose(0, 2, 1)) + pressure(x)[:, None, None] * np.eye(x.shape[1])


def body_force(nu, x):
    """-div σ, with div 2με = μ(∇²u + ∇ div u)."""
    d = x.shape[1]
    mu, inverse = constants(nu)
    k, q = WAVES[d], SWELL[d]
    shear = mu * (k @ k) * np.sin(x @ k - 0.4)[:, None] * across(d)
    return shear - (1 + 2 * mu * inverse) * np.cos(x @ q + 0.3)[:, None] * q


def manufactured(d, nu):
    """Held on all sides but the right one, which is loaded."""
    box = Box(SIZE[:d])
    fields = tuple((lambda x, axis=axis: displacement(nu, x)[:, axis]) for axis in range(d))
    loads = (
        BodyForce(lambda x: body_force(nu, x)),
        Traction(box.side("right"), lambda x: stress(nu, x)[:, :, 0]),
    )
    sides = [side for side, (axis, _) in SIDES.items() if axis < d and side != "right"]
    supports = tuple(Support(box.side(side), fields) for side in sides)
    return Problem(box, Isotropic(E, nu, "plane_strain" if d == 2 else "solid"), supports, loads)


def errors(d, nu, element, n):
    """Those of `off`, at places at random."""
    problem = manufactured(d, nu)
    body = reference_fem.box_discretisation(problem.domain, n, element)
    found = reference_fem.solve_problem(problem, body, mixed=True)
    x = np.random.default_rng(7).random((4000, d)) * SIZE[:d]
    return off(found, nu, x)


def off(found, nu, x):
    """Root mean squares of what is off at places (n, d): displacement, stress and pressure."""
    d = x.shape[1]
    wanted = stress(nu, x)[:, *np.transpose([(a, a) for a in range(d)])]
    return np.sqrt(
        [
            ((found.at(x) - displacement(nu, x)) ** 2).sum(axis=1).mean(),
            ((found.stress(x)[:, :d] - wanted) ** 2).sum(axis=1).mean(),
            ((found.pressure_at(x) - pressure(x)) ** 2).mean(),
        ]
    )


RATES = {
    # axes, whether simplices: cells to start from, least and largest order of stress, of pressure
    (2, True): (8, (1.9, 2.1), (2.0, 2.9)),
    (2, False): (8, (1.9, 2.1), (1.9, 2.1)),
    (3, True): (4, (1.9, 2.5), (2.0, 3.4)),
    (3, False): (3, (1.9, 2.2), (2.0, 2.7)),
}
"""The pressure's error has a part of the third order too, from the displacement's, which is the
larger on coarse meshes: the order of P2-P1 is 2.78 from 8 to 16 cells, then 2.49 and 2.26."""


def rates_of(element):
    kind = ELEMENTS[element]
    return RATES[kind.dim, kind.simplex]


@pytest.mark.parametrize("element", QUADRATIC)
@pytest.mark.parametrize("nu", [0.3, 0.4999, 0.5])
def test_rates_of_the_manufactured_solution(element, nu):
    d = ELEMENTS[element].dim
    cells, *bounds = rates_of(element)
    coarse, fine = (errors(d, nu, element, n) for n in (cells, 2 * cells))
    orders = np.log2(coarse / fine)
    for order, (low, high) in zip(orders, [(2.85, 3.15), *bounds], strict=True):
        assert low <= order <= high, orders


def bulged(points):
    """The box with bent sides; only the right one stays straight, and where it was."""
    x, rest = points[:, 0], points[:, 1:] / SIZE[1 : points.shape[1]]
    moved = points.copy()
    moved[:, 0] += 0.1 * (1 - x / SIZE[0]) * np.sin(np.pi * rest).sum(axis=1)
    moved[:, 1:] += 0.1 * np.sin(np.pi * x / SIZE[0])[:, None]
    return moved


@pytest.mark.parametrize("element", PLANE)
def test_rates_on_curved_cells(element):
    d, nu = 2, 0.5
    cells, *bounds = rates_of(element)
    straight = manufactured(d, nu)

    def errors_on(n):
        box = reference_fem.box_discretisation(straight.domain, n, element)
        mesh = Mesh(bulged(box.points), box.cells, box.element.shape)
        right = (box.points[mesh.surface][..., 0] == SIZE[0]).all(axis=1)
        mesh = mesh.named({"right": mesh.surface[right], "rest": mesh.surface[~right]})
        held = Support(mesh.side("rest"), straight.supports[0].displacement)
        body_load, pull = straight.loads
        loads = (body_load, Traction(mesh.side("right"), pull.traction))
        body = reference_fem.mesh_discretisation(mesh)
        assert body.curved
        problem = Problem(mesh, straight.material, (held,), loads)
        found = reference_fem.solve_problem(problem, body, mixed=True)
        x = bulged((0.2 + 0.6 * np.random.default_rng(7).random((4000, d))) * SIZE[:d])
        return off(found, nu, x)

    orders = np.log2(errors_on(cells) / errors_on(2 * cells))
    for order, (low, high) in zip(orders, [(2.85, 3.15), *bounds], strict=True):
        assert low <= order <= high, orders


# --- locking --------------------------------------------------------------------------------------


def cylinder(nu, element, mixed, n=4):
    """Error of the displacement at the nodes of a thick cylinder under pressure, plane strain.

    [LameClapeyron1833]: u = (1 + nu) p a²/(E (b² - a²)) ((1 - 2nu) r + b²/r), a = 1, b = 2.
    """
    flat = reference_fem.box_discretisation(Box((1.0, 1.0)), (n, 2 * n), element)
    radius, angle = 1 + flat.points[:, 0], np.pi / 2 * flat.points[:, 1]
    points = radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    body = make_discretisation(points, flat.cells, element)
    inner = (flat.points[body.surface][:, :, 0] == 0).all(axis=1)
    facets = Facets(body, body.surface[inner])
    force = facets.integrated(-facets.normals)
    held = np.abs(points) < 1e-12
    law = Isotropic(E, nu, "plane_strain")
    if mixed:
        found, _ = solve_mixed_on(body, law, held, 0 * points, force)
    else:
        rows = [(n, k, 0.0) for n, k in np.argwhere(held)]
        loads = [(n, k, force[n, k]) for n, k in np.argwhere(force)]
        mesh = points, body.cells, element
        found = reference_fem.solve(*mesh, law, rows, loads, allow_locked=True)
    wanted = (1 + nu) / (3 * E) * ((1 - 2 * nu) * radius + 4 / radius)
    exact = wanted[:, None] * points / radius[:, None]
    return np.linalg.norm(found - exact) / np.linalg.norm(exact)


@pytest.mark.parametrize("element", PLANE)
def test_mixed_elements_do_not_lock_and_linear_ones_do(element):
    easy = cylinder(0.3, element, mixed=True)
    for nu in (0.49, 0.4999, 0.499999, 0.5):
        assert cylinder(nu, element, mixed=True) <= 2 * easy
    linear = ELEMENTS[element].first.name
    assert cylinder(0.3, linear, mixed=False) < 0.05
    assert cylinder(0.4999, linear, mixed=False) > 0.2


@pytest.mark.parametrize("nu", [0.3, 0.4999])
def test_a_body_whose_nodes_are_all_held_has_the_pressure_of_its_strain(nu):
    body = reference_fem.box_discretisation(Box((1.0, 1.0)), 2, "P2")
    given = body.points * [0.01, 0.02]
    rows = [(node, axis, given[node, axis]) for node, axis in np.ndindex(*given.shape)]
    law = Isotropic(E, nu, "plane_strain")
    found, p = solve_mixed(body.points, body.cells, "P2-P1", law, rows, [])
    assert np.array_equal(found, given)
    assert p == pytest.approx(0.03 / constants(nu)[1], rel=1e-12)  # λ div u


# --- what they refuse -----------------------------------------------------------------------------

SQUARE = Box((1.0, 1.0))
LEFT = (Support(SQUARE.side("left"), (0.0, 0.0)),)


@table(
    ("material", "element", "message"),
    [
        (Isotropic(1.0, 0.5), "P2", "plane stress leaves thickness free to change"),
        (Isotropic(1.0, 0.0, "plane_strain"), "P2", r"nu = 0 has no pressure .*nu above 0"),
        (Isotropic(1.0, -0.3, "plane_strain"), "P2", r"nu = -0.3 has no pressure"),
        (Isotropic(1.0, 0.5, "plane_strain"), "Q1", "Q1 has displacements of degree 1; take one"),
        (Anisotropic(np.eye(3)), "P2", "anisotropic; take displacement elements"),
    ],
)
def test_other_bodies_are_refused(material, element, message):
    body = reference_fem.box_discretisation(SQUARE, 2, element)
    with pytest.raises(ProblemError, match=message):
        reference_fem.solve_problem(Problem(SQUARE, material, LEFT), body, mixed=True)


def test_a_solid_material_in_the_plane_is_refused():
    body = reference_fem.box_discretisation(SQUARE, 2, "P2")
    held = np.ones(body.points.shape, dtype=bool)
    with pytest.raises(ProblemError, match="material: 3D, the body 2D"):
        solve_mixed_on(body, Isotropic(1, 0.5, "solid"), held, 0.0 * held, 0.0 * held)


def test_the_refusal_of_displacement_elements_names_mixed_ones():
    problem = Problem(SQUARE, Isotropic(1.0, 0.5, "plane_strain"), LEFT)
    body = reference_fem.box_discretisation(SQUARE, 2, "P2")
    with pytest.raises(ProblemError, match="or mixed elements"):
        reference_fem.solve_problem(problem, body)
    assert not reference_fem.solve_problem(problem, body, mixed=True).displacement.any()


def held_all_round(nu, element="P2"):
    supports = tuple(
        Support(SQUARE.side(side), (0.0, 0.0)) for side in ("left", "right", "bottom", "top")
    )
    problem = Problem(
        SQUARE, Isotropic(1.0, nu, "plane_strain"), supports, (BodyForce((0.0, -1.0)),)
    )
    body = reference_fem.box_discretisation(SQUARE, 6, element)
    return reference_fem.solve_problem(problem, body, mixed=True)


@table("element", PLANE)
def test_an_incompressible_body_held_all_round_is_refused(element):
    with pytest.raises(SolverError, match="at nu = 1/2 the pressure of a body held all round"):
        held_all_round(0.5, element)
    assert np.isfinite(held_all_round(0.49999, element).pressure).all()


def test_a_hinge_is_refused():
    points = [[0, 0], [2, 0], [2, 2], [0, 2], [1, 0], [2, 1], [1, 2], [0, 1], [1, 1]]
    other = [[4, 2], [4, 4], [2, 4], [3, 2], [4, 3], [3, 4], [2, 3], [3, 3]]
    cells = [range(9), [2, 9, 10, 11, 12, 13, 14, 15, 16]]
    clamp = [(node, axis, 0.0) for node in (0, 3, 7) for axis in (0, 1)]
    law = Isotropic(1.0, 0.5, "plane_strain")
    with pytest.raises(SolverError, match="a part that hangs by a corner can move"):
        solve_mixed(points + other, cells, "Q2-Q1", law, clamp, [(9, 1, -1.0)])


def test_displacement_elements_have_no_pressure():
    problem = Problem(SQUARE, Isotropic(1.0, 0.3, "plane_strain"), LEFT)
    body = reference_fem.box_discretisation(SQUARE, 2, "P2")
    with pytest.raises(ProblemError, match="displacement elements have none"):
        reference_fem.solve_problem(problem, body).pressure_at([[0.5, 0.5]])
