"""Meshes, elements and interpolation, on distorted cells with straight edges."""

from __future__ import annotations

import numpy as np
import pytest
import skfem
from hypothesis import given, settings
from hypothesis import strategies as st

import reference_fem
from msvalidate.problem import Box, ProblemError
from reference_fem.mesh import make_discretisation
from reference_fem.mesh.elements import ELEMENTS, of_dimension
from tests.table import table

# A library's warning on the way to an answer is a failure here.
pytestmark = pytest.mark.filterwarnings("error")

PLANE = of_dimension(2)
ROUNDING = 1e-12
"""Relative: interpolation sums at most nine products; the inverse map is iterated to 1e-12."""


def distorted(element, seed=0, n=4):
    """Points and cells (VTK order) of a unit square, inner corners moved by up to a fifth of h."""
    rng = np.random.default_rng(seed)
    y, x = np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1), indexing="ij")
    corners = np.column_stack([x.ravel(), y.ravel()])
    inner = ((corners > 0) & (corners < 1)).all(axis=1)
    corners[inner] += rng.uniform(-0.2 / n, 0.2 / n, (inner.sum(), 2))
    k = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    cells = np.stack([k[:-1, :-1], k[:-1, 1:], k[1:, 1:], k[1:, :-1]], axis=-1).reshape(-1, 4)
    kind = ELEMENTS[element]
    if kind.simplex:
        cells = np.vstack([cells[:, [0, 1, 2]], cells[:, [0, 2, 3]]])
    if kind.degree == 1:
        return corners, cells
    edges = np.sort(np.stack([cells, np.roll(cells, -1, axis=1)], axis=2), axis=2)
    ends, which = np.unique(edges.reshape(-1, 2), axis=0, return_inverse=True)
    points = [corners, corners[ends].mean(axis=1)]
    columns = [cells, len(corners) + which.reshape(cells.shape)]
    if any(len(amid) == 4 for amid in kind.middles):
        points.append(corners[cells].mean(axis=1))
        columns.append(len(corners) + len(ends) + np.arange(len(cells))[:, None])
    return np.vstack(points), np.hstack(columns)


def renumbered(points, cells, seed=0):
    """The same mesh under other node numbers: an index used in place of another must show."""
    new = np.random.default_rng(seed).permutation(len(points))
    moved = np.empty_like(points)
    moved[new] = points
    return moved, new[cells]


def monomials(element):
    """Exponents (p, q) of x^p y^q that the element holds on any mesh with straight edges.

    On a quadrilateral that is no parallelogram, these are those of the triangle: the map is
    bilinear, so x^2 y^2 is not a biquadratic of the reference square [ArnoldBoffiFalk2002].
    """
    degree = ELEMENTS[element].complete
    return [(p, q) for p in range(degree + 1) for q in range(degree + 1 - p)]


# --- interpolation --------------------------------------------------------------------------------


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
@pytest.mark.parametrize("element", PLANE)
def test_interpolation_holds_polynomials_of_the_degree(element, seed):
    points, cells = renumbered(*distorted(element, seed), seed)
    body = make_discretisation(points, cells, element)
    places = np.random.default_rng(seed).random((40, 2))
    matrix = body.interpolation(places)
    for p, q in monomials(element):
        nodal, wanted = (x[:, 0] ** p * x[:, 1] ** q for x in (points, places))
        assert np.abs(matrix @ nodal - wanted).max() <= ROUNDING


@pytest.mark.parametrize("element", PLANE)
def test_interpolation_holds_nothing_higher(element):
    # The bound above would also hold for an element of higher degree under the wrong name.
    points, cells = distorted(element)
    degree = ELEMENTS[element].degree
    places = np.random.default_rng(5).random((40, 2))
    error = make_discretisation(points, cells, element).interpolation(places) @ points[:, 0] ** (
        degree + 1
    )
    assert np.abs(error - places[:, 0] ** (degree + 1)).max() > 1e-3


@pytest.mark.parametrize("element", PLANE)
def test_interpolation_reproduces_nodal_values(element):
    points, cells = renumbered(*distorted(element))
    body = make_discretisation(points, cells, element)
    identity = body.interpolation(points).toarray()
    assert np.abs(identity - np.eye(len(points))).max() <= ROUNDING


@pytest.mark.parametrize("element", PLANE)
def test_interpolation_is_continuous_across_edges(element):
    points, cells = distorted(element)
    body = make_discretisation(points, cells, element)
    corners = cells[:, : ELEMENTS[element].corners]
    ends = np.sort(np.stack([corners, np.roll(corners, -1, axis=1)], axis=2), axis=2)
    ends, uses = np.unique(ends.reshape(-1, 2), axis=0, return_counts=True)
    a, b = points[ends[uses == 2]].transpose(1, 0, 2)
    step = 1e-9 * (b - a)[:, ::-1] * [-1, 1]  # across the edge, either way
    values = np.random.default_rng(2).normal(size=len(points))
    above, below = (body.interpolation(0.37 * a + 0.63 * b + s) @ values for s in (step, -step))
    # 1e-9 of an edge, times slopes of up to ten values per edge.
    assert np.abs(above - below).max() <= 1e-7


@table("place", [(1.01, 0.5), (0.5, -0.01), (-3.0, -3.0), (2.0, 2.0)])
@table("element", PLANE)
def test_point_outside_is_refused(element, place):
    body = make_discretisation(*distorted(element), element)
    with pytest.raises(ProblemError, match="must lie in the body"):
        body.interpolation(np.array([[0.5, 0.5], place]))


def test_point_that_is_no_number_is_refused():
    body = make_discretisation(*distorted("Q1"), "Q1")
    with pytest.raises(ProblemError, match="finite"):
        body.interpolation(np.array([[0.5, np.nan]]))


# --- integrals ------------------------------------------------------------------------------------


def gradients(body):
    """Matrices [c][d] of ∫ ∂φi/∂xc ∂φj/∂xd."""
    return [[body.pattern.matrix(entries) for entries in row] for row in body.gradients]


@pytest.mark.parametrize("element", PLANE)
def test_gradient_integrals_are_those_of_polynomials(element):
    points, cells = renumbered(*distorted(element))
    G = gradients(make_discretisation(points, cells, element))
    x, y = points.T
    one = np.ones_like(x)
    # Over the unit square, each derivative is 1 along its own axis and 0 along the other.
    for a, u in enumerate((x, y)):
        for b, v in enumerate((x, y)):
            for c in (0, 1):
                for d in (0, 1):
                    wanted = float(a == c and b == d)
                    assert u @ G[c][d] @ v == pytest.approx(wanted, abs=ROUNDING)
    for row in G:
        for block in row:
            assert np.abs(block @ one).max() <= ROUNDING
            assert np.abs(one @ block).max() <= ROUNDING


@pytest.mark.parametrize("element", [name for name in PLANE if ELEMENTS[name].complete == 2])
def test_gradient_integrals_of_parabolas(element):
    # The Gauss rule must be exact for what a quadratic element holds: ∫(2x)² = 4/3, ∫ 2x·x = 1/2...
    points, cells = distorted(element)
    G = gradients(make_discretisation(points, cells, element))
    x, y = points.T
    assert x**2 @ G[0][0] @ x**2 == pytest.approx(4 / 3, rel=ROUNDING)
    assert (x * y) @ G[0][1] @ (x * y) == pytest.approx(1 / 4, rel=ROUNDING)  # ∫ y·x
    assert y**2 @ G[1][0] @ (x * y) == pytest.approx(2 / 3, rel=ROUNDING)  # ∫ 2y·y


@pytest.mark.parametrize("element", PLANE)
def test_blocks_are_transposes_of_each_other(element):
    G = gradients(make_discretisation(*distorted(element), element))
    for a in (0, 1):
        for b in (0, 1):
            assert np.abs(G[a][b] - G[b][a].T).max() <= ROUNDING


def test_integrals_do_not_depend_on_the_rule_once_it_is_exact():
    # Triangles with straight edges: products of gradients are polynomials of degree 2 (degree - 1).
    for element in ("P1", "P2"):
        points, cells = distorted(element)
        body = make_discretisation(points, cells, element)
        finer = skfem.Basis(body.basis.mesh, body.basis.elem, intorder=8)
        form = skfem.BilinearForm(lambda u, v, _: u.grad[0] * v.grad[0])
        wanted = form.assemble(finer).toarray()
        found = gradients(body)[0][0].toarray()[np.ix_(body.node, body.node)]
        assert np.abs(found - wanted).max() <= ROUNDING * np.abs(wanted).max()


# --- numbering ------------------------------------------------------------------------------------


@pytest.mark.parametrize("element", PLANE)
def test_every_degree_of_freedom_sits_at_its_node(element):
    points, cells = renumbered(*distorted(element))
    body = make_discretisation(points, cells, element)
    assert sorted(body.node) == list(range(len(points)))
    assert np.abs(body.points[body.node] - body.basis.doflocs.T).max() <= 1e-14
    np.testing.assert_array_equal(body.points, points)


def test_callers_arrays_stay_the_callers():
    points, cells = distorted("Q1")
    body = make_discretisation(points, cells, "Q1")
    before = body.points.copy()
    points += 1
    np.testing.assert_array_equal(body.points, before)
    with pytest.raises(ValueError, match="read-only"):
        body.points[0] = 0


# --- bad meshes -----------------------------------------------------------------------------------


def test_quadratic_element_of_linear_points_is_refused():
    # Corners alone, repeated to fill the columns: no middle node exists.
    points, cells = distorted("Q1")
    with pytest.raises(ProblemError, match=r"cell 0 names point \d+ twice; Q2 lists corners, mid-"):
        make_discretisation(points, np.hstack([cells, cells, cells[:, :1]]), "Q2")


@table("order", [(0, 1, 3, 2), (0, 2, 1, 3), (3, 2, 1, 0), (0, 3, 2, 1)])
def test_quadrilateral_out_of_order_is_refused(order):
    points, cells = distorted("Q1")
    cells[7] = cells[7, list(order)]
    with pytest.raises(ProblemError, match="cell 7 is inverted, flat or not convex"):
        make_discretisation(points, cells, "Q1")


@pytest.mark.parametrize("start", range(4))
def test_quadrilateral_may_start_at_any_corner(start):
    points, cells = distorted("Q1")
    still = gradients(make_discretisation(points, cells, "Q1"))[0][1]
    cells[7] = np.roll(cells[7], start)
    again = gradients(make_discretisation(points, cells, "Q1"))[0][1]
    assert np.abs(again - still).max() <= ROUNDING


def test_clockwise_triangle_is_refused():
    points, cells = distorted("P1")
    cells[3] = cells[3, ::-1]
    with pytest.raises(ProblemError, match="cell 3 is inverted"):
        make_discretisation(points, cells, "P1")


def test_orphan_and_coincident_points_are_named():
    points, cells = distorted("P1")
    with pytest.raises(ProblemError, match=f"point {len(points)} belongs to no cell"):
        make_discretisation(np.vstack([points, [[0.5, 0.51]]]), cells, "P1")
    seam = cells.copy()
    seam[0][seam[0] == cells[0, 1]] = len(points)
    with pytest.raises(ProblemError, match="remove or merge it"):
        make_discretisation(np.vstack([points, points[cells[0, 1]]]), seam, "P1")


# --- meshes that would be solved wrongly ----------------------------------------------------------

TWO_CELLS = [[0, 0], [1, 0], [2, 0], [0, 1], [1, 1], [2, 1]]


def test_a_cell_listed_twice_is_refused():
    cells = [[0, 1, 4, 3], [1, 2, 5, 4], [1, 2, 5, 4]]
    with pytest.raises(ProblemError, match="overlaps another on one of its edges; list it once"):
        make_discretisation(TWO_CELLS, cells, "Q1")


def test_nodes_that_are_not_those_of_the_cell_are_refused():
    body = reference_fem.box_discretisation(Box((1.0, 1.0)), 2, "Q2")
    cells = body.cells.copy()
    cells[1, 4:] = cells[2, 4:]
    with pytest.raises(ProblemError, match="cell 1 is inverted or folded: its curved sides turn"):
        make_discretisation(body.points, cells, "Q2")


def test_a_point_off_the_edge_by_rounding_is_on_it():
    body = reference_fem.box_discretisation(Box((0.3, 0.3)), 4)
    weights = body.interpolation(np.array([[0.1 * 3, 0.15]]))  # 0.30000000000000004
    assert weights.sum() == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("grading", [1.0, 2.25, 3.0])
def test_interpolation_near_a_graded_corner(grading):
    body = reference_fem.box_discretisation(Box((1.0, 1.0)), 64, "Q2", grading)
    places = 1 - 1e-4 * np.random.default_rng(1).random((300, 2))
    found = body.interpolation(places) @ body.points
    assert np.abs(found - places).max() < 1e-12, "coordinates are in the element's space"
