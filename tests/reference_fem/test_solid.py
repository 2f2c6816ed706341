"""Bodies in space: patch, manufactured solution, loads, meshes, interpolation, bad input."""

from __future__ import annotations

import re

import numpy as np
import pytest
import skfem

import reference_fem
from msvalidate.problem import (
    SIDES,
    VOIGT,
    Anisotropic,
    Box,
    Isotropic,
    Problem,
    ProblemError,
    Region,
    SolverError,
    Support,
    Traction,
)
from reference_fem.body import nodal_forces
from reference_fem.elasticity import full_tensor, stiffness
from reference_fem.mesh import ELEMENTS, make_discretisation
from reference_fem.mesh.elements import CUBE, of_dimension
from tests.reference_fem.by_hand import (
    compliance,
    convergence,
    indexed,
    manufactured,
    moment,
)
from tests.table import table

# A library's warning on the way to an answer is a failure here.
pytestmark = pytest.mark.filterwarnings("error")

SOLIDS = of_dimension(3)
BOX = Box((1.2, 0.8, 1.0))
ROUNDING = 1e-12
"""Relative: a direct solve of a few hundred unknowns leaves 1e-14."""
# Every strain couples to every stress, each by its own amount: no index can be swapped unseen.
MIXED = np.random.default_rng(3).uniform(-0.3, 0.3, (6, 6))
SKEW = np.diag([3.0, 2.0, 2.5, 1.1, 0.9, 1.3]) + MIXED + MIXED.T
MATERIALS = {"isotropic": Isotropic(2.0, 0.3, "solid"), "anisotropic": Anisotropic(SKEW)}


TENSORS = {"isotropic": np.linalg.inv(compliance(2.0, 0.3)), "anisotropic": SKEW}


def distorted(element, seed=0, n=3, box=BOX):
    """Points and cells of a box, its inner corners moved by up to a sixth of a cell."""
    body = reference_fem.box_discretisation(box, n, element)
    points, kind = body.points.copy(), body.element
    inner = ((points > 0) & (points < box.size)).all(axis=1)
    step = np.array(box.size) / n / 6
    points[inner] += np.random.default_rng(seed).uniform(-step, step, (inner.sum(), 3))
    # What lies amid corners stays amid them, so that edges stay straight.
    points[body.cells] = np.einsum("ik,ckd->cid", kind.means, points[body.cells[:, : kind.corners]])
    return points, body.cells.copy()


# After [MacNealHarder1985]: a hexahedron and six about it.
SQUARE = [(0, 0), (1, 0), (1, 1), (0, 1)]
OUTER = [(x, y, z) for z in (0, 1) for x, y in SQUARE]
INNER = [
    *[(0.25, 0.34, 0.19), (0.83, 0.29, 0.29), (0.85, 0.65, 0.26), (0.27, 0.75, 0.23)],
    *[(0.32, 0.26, 0.64), (0.68, 0.30, 0.68), (0.79, 0.69, 0.64), (0.17, 0.74, 0.70)],
]
AROUND = [[*(corner + 8 for corner in face), *face] for face in CUBE]
SEVEN = np.array(OUTER + INNER, dtype=float), np.array([range(8, 16), *AROUND])
MESHES = {
    "seven": ("H1", *SEVEN),
    **{element: (element, *distorted(element)) for element in SOLIDS},
}
meshes = pytest.mark.parametrize("mesh", MESHES)
materials = pytest.mark.parametrize("name", MATERIALS)
solids = pytest.mark.parametrize("element", SOLIDS)


# --- patch ----------------------------------------------------------------------------------------

GRADIENT = 1e-3 * np.array([[1.0, 0.5, 0.3], [-0.2, -0.7, 0.4], [0.1, 0.8, 0.6]])
"""∂u_k/∂x_l: six strains and three rotations, none of them alike."""


def strain_energy(name, volume):
    C = indexed(TENSORS[name], 3)
    return volume * np.einsum("ij,ijkl,kl", GRADIENT, C, GRADIENT) / 2


@meshes
@materials
def test_patch(name, mesh):
    element, points, cells = MESHES[mesh]
    exact = points @ GRADIENT.T
    outside = ((points == points.min(axis=0)) | (points == points.max(axis=0))).any(axis=1)
    assert (~outside).sum() >= 8  # else nothing is solved
    fixed = [(n, axis, exact[n, axis]) for n in np.flatnonzero(outside) for axis in range(3)]
    found = reference_fem.solve(points, cells, element, MATERIALS[name], fixed, [])
    assert np.abs(found - exact).max() <= ROUNDING * np.abs(exact).max()
    # Uniform stress: no force inside, and the energy of one strain over the whole volume.
    K = stiffness(make_discretisation(points, cells, element), MATERIALS[name])
    u = found.T.ravel()
    force = (K @ u).reshape(3, -1).T
    assert np.abs(force[~outside]).max() <= ROUNDING * np.abs(force).max()
    volume = np.ptp(points, axis=0).prod()
    assert u @ force.T.ravel() / 2 == pytest.approx(strain_energy(name, volume), rel=ROUNDING)


# --- stiffness and materials ----------------------------------------------------------------------


@pytest.mark.parametrize("mesh", ["seven", "H1", "T1", "one H1", "one T1"])
@materials
def test_stiffness_is_symmetric_and_only_rigid_motions_are_free(name, mesh):
    element, points, cells = MESHES[mesh.removeprefix("one ")]
    if mesh.startswith("one"):  # what makes a body whose cells hang together by faces no mechanism
        points, cells = points[cells[0]], np.arange(len(cells[0]))[None]
    K = stiffness(make_discretisation(points, cells, element), MATERIALS[name]).toarray()
    assert np.abs(K - K.T).max() <= ROUNDING * np.abs(K).max()
    energies = np.linalg.eigvalsh(K)
    assert np.abs(energies[:6]).max() <= ROUNDING * energies[-1]
    assert energies[6] > 1e-4 * energies[-1]  # an hourglass would be a seventh
    spin = np.array([[0.0, -0.3, 0.2], [0.3, 0.0, -0.5], [-0.2, 0.5, 0.0]])
    rigid = (points @ spin.T + [1.0, 2.0, -1.0]).T.ravel()
    assert np.abs(K @ rigid).max() <= ROUNDING * np.abs(K).max()


def test_full_tensor_follows_the_stated_order():
    assert VOIGT[3] == ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
    np.testing.assert_allclose(full_tensor(SKEW), indexed(SKEW, 3), rtol=1e-15)


# --- manufactured solution ------------------------------------------------------------------------


def verdict(element, orders, levels, nearest, farthest):
    """What is wrong: nothing, for a sound solver. Bounded below too: too good is wrong as well."""
    degree = ELEMENTS[element].degree
    checks = {
        "order of the displacement": abs(orders[0] - degree - 1) <= 0.1,
        "order of the gradient": abs(orders[1] - degree) <= 0.1,
        "level of the displacement": nearest <= levels[0] <= farthest,
        "level of the gradient": 0.999 <= levels[1] <= {1: 1.01, 2: 1.03}[degree],
    }
    return [name for name, held in checks.items() if not held]


CELLS = {1: 6, 2: 3}
ALL_HELD = {"H1": (0.94, 0.955), "T1": (1.0, 1.04), "H2": (0.995, 1.01), "T2": (1, 1.025)}


@pytest.mark.parametrize(
    ("element", "loaded", "level"),
    [
        ("H1", (), ALL_HELD["H1"]),
        ("H1", ("right", "top", "front"), (0.86, 0.95)),
        ("T1", (), ALL_HELD["T1"]),
        # With three loaded sides the order comes from below: 1.73, then 1.89 and 1.93 at 32 cells.
        ("T1", ("right",), (0.97, 1.02)),
        ("T1", ("top",), (1.02, 1.09)),
        ("H2", (), ALL_HELD["H2"]),
        ("H2", ("right", "top", "front"), (0.99, 1.035)),
        ("T2", (), ALL_HELD["T2"]),
        ("T2", ("right",), (1, 1.025)),
    ],
)
@materials
def test_manufactured_solution(name, element, loaded, level):
    problem = manufactured(BOX, MATERIALS[name], TENSORS[name], loaded)
    orders, levels = convergence(problem, element, CELLS[ELEMENTS[element].degree])
    assert verdict(element, orders, levels, *level) == [], (orders, levels)


@pytest.mark.parametrize("fault", [-0.02, 0.02])
@solids
def test_manufactured_solution_notices_a_body_force_a_fiftieth_off(element, fault):
    problem = manufactured(BOX, MATERIALS["anisotropic"], SKEW, (), fault)
    orders, levels = convergence(problem, element, CELLS[ELEMENTS[element].degree])
    assert verdict(element, orders, levels, *ALL_HELD[element]) != []


# --- loads ----------------------------------------------------------------------------------------

HELD = (Support(BOX.side("left"), (0.0, 0.0, 0.0)),)


def forces(load, element, cells=(3, 4, 2), grading=1.5):
    """Points and nodal forces of one load on the box."""
    body = reference_fem.box_discretisation(BOX, cells, element, grading)
    return body.points, nodal_forces(Problem(BOX, MATERIALS["isotropic"], HELD, (load,)), body)


@solids
@pytest.mark.parametrize("side", SIDES)
def test_traction_has_its_resultant_and_moment(side, element):
    region, p = BOX.side(side), np.array([2.0, -3.0, 1.0])
    points, force = forces(Traction(region, tuple(p)), element)
    on_side = region.select(points, BOX.tolerance)
    total = BOX.volume / BOX.size[SIDES[side][0]] * p
    centre = (points[on_side].min(axis=0) + points[on_side].max(axis=0)) / 2
    assert not force[~on_side].any()
    assert force.sum(axis=0) == pytest.approx(total, rel=1e-13)
    assert moment(points, force) == pytest.approx(np.cross(centre, total), rel=1e-13)


@pytest.mark.parametrize("grading", [1.0, 3.0, 6.0])
def test_traction_on_part_of_a_face_that_the_lines_end_at(grading):
    # Cells graded as far as this are smaller than the library can look for points in.
    box = Box((1.0, 1.0, 1.0))
    part = Region(((0.25, 0.5), 1.0, (0.5, 1.0)))
    problem = Problem(
        box,
        MATERIALS["isotropic"],
        (Support(box.side("bottom"), (0.0, 0.0, 0.0)),),
        (Traction(part, (0.0, 2.0, 1.0)),),
    )
    body = reference_fem.box_discretisation(
        box, (16, 4, 8), "H1", grading, through=((0.25, 0.5), (), (0.5,))
    )
    force = nodal_forces(problem, body)
    assert force.sum(axis=0) == pytest.approx([0, 0.25, 0.125], rel=1e-12, abs=1e-15)
    turning = np.cross((0.375, 1.0, 0.75), (0, 0.25, 0.125))
    assert moment(body.points, force) == pytest.approx(turning, rel=1e-12)


@solids
def test_traction_that_ends_inside_a_face_is_refused(element):
    part = Region(((0.3, 0.7), BOX.size[1], None))
    with pytest.raises(ProblemError, match="covers no whole number of mesh faces; choose cells"):
        forces(Traction(part, (0.0, 1.0, 0.0)), element)


# --- meshes ---------------------------------------------------------------------------------------


@solids
def test_lines_are_graded_and_pass_through_the_places(element):
    box = Box((1.0, 2.0, 4.0))
    body = reference_fem.box_discretisation(box, 4, element, 2.0, "high", ((0.5,), (), ()))
    x, y, z = (np.unique(column) for column in body.points[body.vertices].T)
    assert x == pytest.approx([0, 0.375, 0.5, 0.875, 1])
    assert y == pytest.approx(2 * (1 - np.linspace(1, 0, 5) ** 2))
    assert z == pytest.approx(2 * y)


@table(
    ("arguments", "message"),
    [
        ((BOX, 2), "mesh: Q2 in a box 1.2 x 0.8 x 1 m; in 3D, give one of H1, H2, T1, T2"),
        ((BOX, 2, "P1"), "mesh: P1 in a box 1.2 x 0.8 x 1 m; in 3D, give one of H1, H2, T1, T2"),
        ((Box((1.0, 1.0)), 2, "T1"), "mesh: T1 in a box 1 x 1 m; in 2D, give one of Q1, Q2"),
        ((BOX, (2, 2), "H1"), "mesh cells: (2, 2); give one or three whole numbers, 1 or more"),
        ((BOX, 1000, "H1"), "mesh of 1000 x 1000 x 1000 cells: 1e+09 points, and the most is"),
        ((BOX, 40, "H2"), "mesh of 40 x 40 x 40 cells: 5.31e+05 points, and the most is 4e+05"),
        ((BOX, 2, "H1", 1.0, "both", ((), ())), "mesh lines through ((), ()): give coordinates"),
        ((BOX, 40, "H1", 8.0), "nearer than two places are told apart"),
    ],
)
def test_a_bad_mesh_of_a_box_is_named(arguments, message):
    with pytest.raises(ProblemError, match=re.escape(message)):
        reference_fem.box_discretisation(*arguments)


# --- interpolation --------------------------------------------------------------------------------


@pytest.mark.parametrize("place", [(1.21, 0.5, 0.5), (0.5, -0.01, 0.5), (0.5, 0.5, 2.0)])
@solids
def test_point_outside_is_refused(element, place):
    body = make_discretisation(*distorted(element), element)
    with pytest.raises(ProblemError, match="must lie in the body"):
        body.interpolation(np.array([[0.5, 0.5, 0.5], place]))


# --- bad meshes -----------------------------------------------------------------------------------

CUBES = [(x, y, z) for x in (0, 1, 2) for z in (0, 1) for x, y in [(x, 0), (x, 1)]]
TWO = [[0, 4, 5, 1, 2, 6, 7, 3], [4, 8, 9, 5, 6, 10, 11, 7]]
TETS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)]
PAIR = [[0, 1, 2, 3], [1, 4, 2, 3]]


def changed(rows, at, value):
    return [value if index == at else row for index, row in enumerate(rows)]


BAD = {
    "points in the plane": (([p[:2] for p in CUBES], TWO, "H1"), "shape (12, 2); H1 needs (n, 3)"),
    "plane element": ((CUBES, TWO, "Q1"), "points: shape (12, 3); Q1 needs (n, 2)"),
    "mirrored": ((CUBES, changed(TWO, 1, [*TWO[1][4:], *TWO[1][:4]]), "H1"),
        "cell 1 is inverted, flat or folded; list its corners in VTK order: counter-clockwise"),
    "rows out of order": ((CUBES, changed(TWO, 0, [0, 4, 1, 5, 2, 6, 3, 7]), "H1"),
        "cell 0 is inv"),
    "flat": (([(x, y, 0) for x, y, _ in CUBES], TWO, "H1"), "cell 0 is inverted, flat or folded"),
    "corner drawn in": ((changed(CUBES, 11, (0.9, 0.1, 0.1)), TWO, "H1"),
        "cell 1 is inverted, flat or folded"),
    "inverted tetrahedron": ((TETS, [[0, 1, 2, 3], [1, 2, 4, 3]], "T1"),
        "cell 1 is inverted, flat or folded; list its corners in VTK order: counter-clockwise"),
    "flat tetrahedron": ((changed(TETS, 3, (1, 1, 0)), PAIR[:1], "T1"), "cell 0 is inverted, fl"),
    "turned and listed twice": ((CUBES, [*TWO, [*TWO[0][1:4], TWO[0][0], *TWO[0][5:], TWO[0][4]]],
        "H1"), "overlaps another on one of its faces"),
    "on the same side of a face": (([*TETS[:4], (0.2, 0.2, 0.9)], [[0, 1, 2, 3], [0, 1, 2, 4]],
        "T1"), "overlaps another on one of its faces; list it once"),
}  # fmt: skip


@pytest.mark.parametrize(("arguments", "message"), BAD.values(), ids=BAD)
def test_bad_mesh_is_named(arguments, message):
    with pytest.raises(ProblemError, match=re.escape(message)):
        make_discretisation(*arguments)


def test_a_cell_folded_between_its_corners_is_refused():
    # Turned by half a turn, and stretched thrice across: with J = (1 - 2z)(1 - 4z) upright at every
    # corner and outside in between.
    low = np.array([(*place, 0.0) for place in SQUARE]) - [0.5, 0.5, 0]
    high = low * [-1, -3, 1] + [0, 0, 1]
    points = np.vstack([low, high])
    body = skfem.MeshHex(points.T, np.array([ELEMENTS["H1"].order]).T)
    corners = body.mapping().detDF(body.elem.doflocs.T)
    assert corners.min() > 0
    with pytest.raises(ProblemError, match="cell 0 is inverted, flat or folded"):
        make_discretisation(points, [range(8)], "H1")


# --- bodies that the residual alone would pass ----------------------------------------------------

LAW = Isotropic(1.0, 0.3, "solid")


def joined_at(shared):
    """Two cubes of which the second shares an edge, a corner or nothing with the first."""
    start = {"edge": (1, 1, 0), "corner": (1, 1, 1), "nothing": (3, 0, 0)}[shared]
    cube = np.array([(x, y, z) for x in (0, 1) for z in (0, 1) for y in (0, 1)])
    points, cells = np.unique(np.vstack([cube, cube + start]), axis=0, return_inverse=True)
    return points, cells.ravel().reshape(2, 8)[:, [0, 4, 5, 1, 2, 6, 7, 3]]


@pytest.mark.parametrize("most", [0, np.inf])
@pytest.mark.parametrize("shared", ["edge", "corner", "nothing"])
def test_a_part_that_can_move_is_refused_even_under_balanced_loads(shared, most, monkeypatch):
    monkeypatch.setattr("msvalidate.linear_algebra.choice.MOST_PRODUCTS", most)
    points, cells = joined_at(shared)
    fixed = [(node, axis, 0.0) for node in cells[0, [0, 3, 4, 7]] for axis in range(3)]
    middle = points[cells[1]].mean(axis=0)
    balanced = [(node, 0, float(points[node, 0] - middle[0])) for node in cells[1]]
    with pytest.raises(SolverError, match="without strain"):
        reference_fem.solve(points, cells, "H1", LAW, fixed, balanced)


@solids
def test_an_incompressible_solid_is_refused(element):
    problem = Problem(BOX, Isotropic(1.0, 0.5, "solid"), HELD)
    with pytest.raises(ProblemError, match=r"take nu = 0\.4999, or mixed"):
        reference_fem.solve_problem(problem, reference_fem.box_discretisation(BOX, 2, element))
