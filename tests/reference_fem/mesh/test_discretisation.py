"""Meshes, elements and interpolation, on distorted cells with straight edges."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import reference_fem
from msvalidate.problem import Box, ProblemError
from reference_fem.mesh import make_discretisation
from reference_fem.mesh.elements import ELEMENTS, of_dimension
from tests.reference_fem.by_hand import with_middles
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
    return with_middles(corners, cells, element)


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


@pytest.mark.parametrize("start", range(4))
def test_quadrilateral_may_start_at_any_corner(start):
    points, cells = distorted("Q1")
    still = gradients(make_discretisation(points, cells, "Q1"))[0][1]
    cells[7] = np.roll(cells[7], start)
    again = gradients(make_discretisation(points, cells, "Q1"))[0][1]
    assert np.abs(again - still).max() <= ROUNDING


# --- meshes that would be solved wrongly ----------------------------------------------------------


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
