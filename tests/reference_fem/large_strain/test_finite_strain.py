"""Solids at large strain: independent values, patch test, rates, differences, what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from msvalidate.problem import Anisotropic, Box, Isotropic, ProblemError, SolverError
from reference_fem import box_discretisation, make_discretisation
from reference_fem.elasticity import solve_on
from reference_fem.large_strain import (
    NeoHookean,
    Solid,
    deform,
    neo_hookean,
    square_fibres,
    st_venant_kirchhoff,
)
from reference_fem.mesh.elements import ELEMENTS, of_dimension

pytestmark = pytest.mark.filterwarnings("error")

DATA = Path(__file__).parents[2] / "data" / "finite_strain"
LAWS = {"NH": neo_hookean, "StVK": st_venant_kirchhoff}
ALL_LAWS = {
    "neo-Hookean": neo_hookean(Isotropic(1.0, 0.3, "plane_strain")),
    "St Venant-Kirchhoff": st_venant_kirchhoff(Isotropic(1.0, 0.3, "plane_strain")),
    "fibres": square_fibres(1.0, 0.5),
}


def block(element="Q2", cells=3, law="neo-Hookean", size=(1.0, 1.0)):
    body = box_discretisation(Box(size), cells, element)
    held = np.zeros(body.points.shape, dtype=bool)
    held[body.points[:, 1] == 0] = True
    return Solid(body, ALL_LAWS[law], held)


def nothing(solid):
    return np.zeros(solid.body.points.shape)


# --- independent values ---------------------------------------------------------------------------


@pytest.mark.parametrize("name", LAWS)
def test_independent_values(name):
    path = DATA / f"block6_stretch_clamped_{name}_Q1_plane_strain.json"
    case = json.loads(path.read_text(encoding="utf-8"))
    law = case["material"]
    assert (law["model"], case["nodal_forces"]) == (name, [])
    body = make_discretisation(case["nodes"], case["cells"], case["element"])
    held, wanted = np.zeros(body.points.shape, dtype=bool), np.zeros(body.points.shape)
    for node, axis, value in case["fixed"]:
        held[node, axis], wanted[node, axis] = True, value
    material = Isotropic(law["E"], law["nu"], law["state"])
    found = deform(Solid(body, LAWS[name](material), held, case["thickness"]), wanted, 0 * wanted)
    expected = np.array(case["displacements"])
    # Both sides solve one system to rounding, 1e-15, and its condition is 1e3.
    assert np.abs(found.displacement - expected).max() <= 1e-9 * np.abs(expected).max()
    assert found.residual <= 1e-11


# --- derivatives ----------------------------------------------------------------------------------


def shaken(solid, size=0.02):
    return np.random.default_rng(1).uniform(-size, size, solid.body.points.shape)


@pytest.mark.parametrize("law", ALL_LAWS)
@pytest.mark.parametrize("element", of_dimension(2))
def test_forces_and_tangent_are_derivatives_of_the_energy(law, element):
    solid = block(element, 2, law)
    u, way = shaken(solid), shaken(solid, 1.0)[::-1].copy()
    step = 1e-6
    high, low = u + step * way, u - step * way
    slope = (solid.energy(high) - solid.energy(low)) / (2 * step)
    assert (solid.internal_force(u)[0] * way).sum() == pytest.approx(slope, rel=1e-7)
    change = (solid.internal_force(high)[0] - solid.internal_force(low)[0]) / (2 * step)
    found = (solid.tangent(u) @ way.T.ravel()).reshape(2, -1).T
    assert np.abs(found - change).max() <= 1e-7 * np.abs(change).max()
    K = solid.tangent(u)
    assert abs(K - K.T).max() == 0


# --- patch test and small strain ------------------------------------------------------------------

CRANKED = np.array([(0, 0), (1, 0), (1, 1), (0, 1), (0.2, 0.3), (0.7, 0.2), (0.8, 0.7), (0.3, 0.7)])
AROUND = [(0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7), (4, 5, 6, 7)]
UNIFORM = np.array([[1.4, 0.3], [-0.2, 0.8]])


@pytest.mark.parametrize("law", ALL_LAWS)
@pytest.mark.parametrize("element", ["Q1", "P1"])
def test_patch(law, element):
    cells = AROUND
    if element == "P1":
        cells = [t for a, b, c, d in AROUND for t in ((a, b, c), (a, c, d))]
    body = make_discretisation(CRANKED, cells, element)
    held = np.zeros(body.points.shape, dtype=bool)
    held[:4] = True
    expected = body.points @ (UNIFORM - np.eye(2)).T
    found = deform(Solid(body, ALL_LAWS[law], held), expected, 0 * expected)
    assert np.abs(found.displacement - expected).max() <= 1e-12
    # The outline carries P N, N at rest: the lower edge's whole force is -P e_y.
    P = ALL_LAWS[law].stress(UNIFORM[None])[0]
    assert found.reaction.sum(axis=0) == pytest.approx([0.0, 0.0], abs=1e-13)
    assert (found.reaction.T @ body.points) == pytest.approx(P, abs=1e-12)


# --- rates ----------------------------------------------------------------------------------------


def manufactured(solid):
    """u = a sin(πx) sin(πy) on the unit square's outline 0, and the force that holds it there.

    The body force is -Div P, here by differences of the stress.
    """

    def u_of(x):
        shape = np.sin(np.pi * x[:, 0]) * np.sin(np.pi * x[:, 1])
        return shape[:, None] * (0.06, -0.05)

    def F_of(x):
        slope = np.pi * np.column_stack(
            [
                np.cos(np.pi * x[:, 0]) * np.sin(np.pi * x[:, 1]),
                np.sin(np.pi * x[:, 0]) * np.cos(np.pi * x[:, 1]),
            ]
        )
        return np.eye(2) + np.array([0.06, -0.05])[None, :, None] * slope[:, None, :]

    def divergence(x, step=1e-4):
        ahead = [
            (solid.law.stress(F_of(x + e)) - solid.law.stress(F_of(x - e)))[:, :, axis]
            for axis, e in enumerate(step * np.eye(2))
        ]
        return sum(ahead) / (2 * step)

    basis = solid.body.quadrature(8)
    x = np.asarray(basis.global_coordinates())
    b = -divergence(x.reshape(2, -1).T).T.reshape(x.shape)
    value = np.array([np.broadcast_to(np.asarray(f), basis.dx.shape) for (f,) in basis.basis])
    each = np.einsum("kcq,acq,cq->kca", value, b, basis.dx)
    force = np.zeros(solid.body.points.shape)
    np.add.at(force, solid.body.nodes_of(np.arange(len(solid.body.cells))), each)
    error_at = (x.reshape(2, -1).T, value, basis)
    return u_of, force, error_at


def l2_error(element, cells, law):
    body = box_discretisation(Box((1.0, 1.0)), cells, element)
    x, y = body.points.T
    edge = np.isclose(x * (1 - x) * y * (1 - y), 0)
    solid = Solid(body, ALL_LAWS[law], np.repeat(edge[:, None], 2, axis=1))
    u_of, force, (places, value, basis) = manufactured(solid)
    found = deform(solid, nothing(solid), force).displacement
    nodes = body.nodes_of(np.arange(len(body.cells)))
    at = np.einsum("kcq,kca->acq", value, found[nodes])
    gap = at - u_of(places).T.reshape(at.shape)
    return np.sqrt(((gap**2).sum(axis=0) * basis.dx).sum())


@pytest.mark.parametrize("law", ALL_LAWS)
@pytest.mark.parametrize(("element", "order", "level"), [("Q1", 2, 1e-3), ("P1", 2, 4e-3)])
def test_rate_of_linear_elements(law, element, order, level):
    errors = [l2_error(element, cells, law) for cells in (8, 16)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.1)
    assert level / 4 < errors[0] < level


@pytest.mark.parametrize("law", ALL_LAWS)
@pytest.mark.parametrize("element", [e for e in of_dimension(2) if ELEMENTS[e].degree == 2])
def test_rate_of_quadratic_elements(law, element):
    errors = [l2_error(element, cells, law) for cells in (8, 16)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(3, abs=0.1)


# --- far, and too far -----------------------------------------------------------------------------


def test_far_loads_take_parts_and_meet_the_same_end():
    solid = block(cells=2, law="neo-Hookean")
    force = nothing(solid)
    force[solid.body.points[:, 1] == 1] = (0.08, 0.0)
    whole, parted = deform(solid, 0 * force, force), deform(solid, 0 * force, force, parts=7)
    assert parted.parts > whole.parts
    assert np.abs(whole.displacement).max() > 0.3
    assert np.abs(parted.displacement - whole.displacement).max() <= 1e-9
    again = deform(solid, 0 * force, force, start=whole.displacement)
    assert again.iterations == 1


def test_a_body_pressed_flat_by_fibres_is_refused():
    # Fibres let a cell turn inside out: their force is bounded, and twice that is no equilibrium's.
    solid = block(law="fibres", cells=2)
    force = nothing(solid)
    force[solid.body.points[:, 1] == 1] = (0.0, -1.0)
    with pytest.raises(SolverError, match="no stable equilibrium found beyond 0\\.") as caught:
        deform(solid, nothing(solid), force)
    assert "\n" not in str(caught.value)


def test_a_column_is_stable_below_its_critical_load_alone():
    # Clamped at one end, free at the other: Euler's π² E I / (4 L²), in plane strain, and less for
    # shear and for its shortening; a slenderness of 10 leaves some per cent.
    solid = block("Q2", (1, 8), size=(1.0, 10.0))
    E = 1 / (1 - 0.3**2)
    critical = np.pi**2 * E / (12 * 4 * 10**2)
    top = solid.body.points[:, 1] == 10
    share = np.array([1.0, 4.0, 1.0]) / 6  # of a uniform pressure
    results = []
    for part in (0.9, 1.1):
        force = nothing(solid)
        force[top, 1] = -part * critical * share
        try:
            deform(solid, nothing(solid), force)
            results.append("stable")
        except SolverError as error:
            results.append("without stiffness" if "without stiffness" in str(error) else str(error))
    assert results == ["stable", "without stiffness"]


# --- bad input ------------------------------------------------------------------------------------


def test_bad_solids_are_refused():
    body = box_discretisation(Box((1.0, 1.0)), 2)
    held = np.ones(body.points.shape, dtype=bool)
    law = ALL_LAWS["neo-Hookean"]
    with pytest.raises(ProblemError, match="held: of float64"):
        Solid(body, law, held.astype(float))
    with pytest.raises(ProblemError, match="held: shape"):
        Solid(body, law, held[1:])
    with pytest.raises(ProblemError, match="law: 'rubber'; give a NeoHookean"):
        Solid(body, "rubber", held)
    with pytest.raises(ProblemError, match="law: 3D, the body 2D"):
        Solid(body, NeoHookean(1.0, 1.0, 3), held)
    with pytest.raises(ProblemError, match="thickness"):
        Solid(body, law, held, 0.0)
    with pytest.raises(ProblemError, match="rotation about"):
        Solid(body, law, held & (body.points == 0).all(axis=1)[:, None])


def test_bad_loads_are_refused():
    solid = block(cells=1)
    rest = nothing(solid)
    with pytest.raises(ProblemError, match="solid: None"):
        deform(None, rest, rest)
    with pytest.raises(ProblemError, match="force: shape"):
        deform(solid, rest, rest[1:])
    with pytest.raises(ProblemError, match="force: holds values that are not finite"):
        deform(solid, rest, rest + np.nan)
    with pytest.raises(ProblemError, match="start: turns a cell inside out"):
        deform(solid, rest, rest, start=solid.body.points * (-2, 0))
    with pytest.raises(ProblemError, match="parts of the load"):
        deform(solid, rest, rest, parts=0)
    with pytest.raises(ProblemError, match="tolerance"):
        deform(solid, rest, rest, tolerance=-1.0)


# --- small strains, and what an answer says of itself ---------------------------------------------

PAIRS = ((0, 0), (1, 1), (0, 1))


@pytest.mark.parametrize("strain", [1e-6, 1e-9, 1e-12])
@pytest.mark.parametrize("name", ALL_LAWS)
def test_small_strains_are_the_linear_ones(name, strain):
    law = ALL_LAWS[name]
    box = Box((0.37, 0.37))
    body = box_discretisation(box, 4, "Q2")
    held = np.repeat(body.points[:, :1] == 0, 2, axis=1)
    force = np.zeros(held.shape)
    force[body.points[:, 0] == 0.37] = strain * 0.37 / 9 * np.array([0.3, 1.0])
    found = deform(Solid(body, law, held), 0 * force, force)
    A = law.tangent(np.eye(2)[None])[0]
    C = np.array([[A[i, j, k, m] for k, m in PAIRS] for i, j in PAIRS])
    linear = solve_on(body, Anisotropic(C), held, 0 * force, force)
    apart = np.abs(found.displacement - linear).max() / np.abs(linear).max()
    # They differ by squares of the displacement's gradients, which are a few times the load's.
    assert apart <= 100 * strain + found.error
    assert found.error <= 1e-9


def test_a_large_turn_with_a_small_strain_is_at_rest():
    law = neo_hookean(Isotropic(1e6, 0.3, "plane_strain"))
    body = box_discretisation(Box((0.37, 0.37)), 2, "Q2")
    turn = np.array([[0.0, -1.0], [1.0, 0.0]]) * (1 + 1e-9)
    right = body.points @ (turn - np.eye(2)).T
    held = np.zeros(right.shape, dtype=bool)
    held[np.unique(body.surface)] = True
    found = deform(Solid(body, law, held), right, 0 * right, start=right)
    assert np.abs(found.displacement - right).max() <= found.error * np.abs(right).max() + 1e-15
    assert found.error <= 1e-9


def test_a_body_too_slender_for_its_cells_is_no_matter_of_the_load():
    body = box_discretisation(Box((1e4, 1.0)), (300, 1), "Q2")
    held = np.repeat(body.points[:, :1] == 0, 2, axis=1)
    force = np.where(held, 0.0, 1e-9)
    law = neo_hookean(Isotropic(1e6, 0.3, "plane_strain"))
    with pytest.raises(SolverError, match="fewer and longer cells"):
        deform(Solid(body, law, held), 0 * force, force)


def test_a_uniform_strain_that_is_met_at_once_is_looked_at_where_it_is():
    # nu = 0, St. Venant-Kirchhoff: dP/ds = E (3 s² - 1)/2 is below 0 from a stretch of 0.577 down.
    # The first step from rest lands on the uniform state, whose tangent no later step would see.
    body = box_discretisation(Box((0.37, 0.37)), 2, "Q2")
    x = body.points[:, 0]
    ends = np.repeat(((x == 0) | (x == x.max()))[:, None], 2, axis=1)
    law = st_venant_kirchhoff(Isotropic(1e6, 0.0, "plane_strain", thickness=0.2))
    solid = Solid(body, law, ends)
    along = np.where(ends, body.points * [1.0, 0.0], 0.0)
    assert deform(solid, -0.2 * along, nothing(solid)).error < 2e-12
    with pytest.raises(SolverError, match="no stable equilibrium"):
        deform(solid, -0.6 * along, nothing(solid))
