"""Meshes of boxes and of outlines of equilateral triangles: coverage, lines, refinement."""

from __future__ import annotations

import numpy as np
import pytest
import skfem

import reference_fem
from msvalidate.problem import (
    Anisotropic,
    Box,
    Isotropic,
    Polygon,
    Problem,
    ProblemError,
    Region,
    Segment,
    Support,
    Traction,
)
from msvalidate.springs.lattice import trapezium, triangular, zigzag_block
from reference_fem.mesh.elements import ELEMENTS, of_dimension
from tests.reference_fem.by_hand import SKEW
from tests.table import refused, table

# A library's warning on the way to an answer is a failure here.
pytestmark = pytest.mark.filterwarnings("error")

NAN = float("nan")
PLANE = of_dimension(2)
BOX = Box((1.2, 0.8))
BAR = trapezium(0.2, (5, 3))
BLOCK = zigzag_block(1.0, (6, 5))
ROW = np.sqrt(3) / 2


# --- boxes ----------------------------------------------------------------------------------------


@table(
    ("arguments", "fragment"),
    [
        ((BOX, 4, "Q3"), "Q3 .*one of Q1, Q2"),
        ((BOX, (4, 4, 4)), "give one or two whole numbers"),
        ((Box((1.0, 1.0, 1.0)), 4), "Q2 in a box 1 x 1 x 1 m; in 3D, give one of H1, H2, T1, T2"),
        ((BOX, 4, "H1"), f"H1 in a box 1.2 x 0.8 m; in 2D, give one of {', '.join(PLANE)}"),
        ((BAR, 4), "in a polygon of 4 vertices, 1.6 x 0.519615 m; give a Box"),
        ((BOX, 0), "mesh cells: 0; give a whole number, 1 or more"),
        ((BOX, (4, -1)), "mesh cells: -1; give a whole number"),
        ((BOX, 2.5), "mesh cells: 2.5; give a whole number"),
        ((BOX, 4, "Q1", 0.5), "mesh grading: 0.5; it must be 1 or more"),
        ((BOX, 4, "Q1", float("nan")), "mesh grading: nan"),
    ],
)
def test_bad_mesh_is_named(arguments, fragment):
    with pytest.raises(ProblemError, match=fragment):
        reference_fem.box_discretisation(*arguments)


def test_a_mesh_too_fine_to_tell_its_nodes_apart_is_refused():
    with pytest.raises(ProblemError, match="nearer than two places are told apart"):
        reference_fem.box_discretisation(Box((1.0, 1.0)), 64, "Q1", 8.0)


# --- boxes with lines through given places --------------------------------------------------------


def lines(body, axis):
    """Coordinates of the mesh lines along an axis, those of mid-side nodes left out."""
    found = np.unique(body.points[:, axis])
    return found[:: body.element.degree]


@pytest.mark.parametrize("towards", ["both", "high"])
@pytest.mark.parametrize("grading", [1.0, 2.5])
@pytest.mark.parametrize("element", PLANE)
def test_lines_pass_exactly_through_the_places(element, grading, towards):
    through = ((0.3, 0.7), (0.8 / 3,))
    body = reference_fem.box_discretisation(BOX, (12, 6), element, grading, towards, through)
    x, y = lines(body, 0), lines(body, 1)
    assert (len(x), len(y)) == (13, 7)
    # Not to rounding but to the last digit: a loaded part ends at the very place it names.
    np.testing.assert_array_equal(x[[0, 3, 7, 12]], [0.0, 0.3, 0.7, 1.2])
    np.testing.assert_array_equal(y[[0, 2, 6]], [0.0, 0.8 / 3, 0.8])
    one = skfem.LinearForm(lambda v, _: v).assemble(body.basis)
    assert one.sum() == pytest.approx(BOX.volume, rel=1e-13)


def test_each_part_is_graded_as_the_whole_would_be():
    box = Box((3.0, 1.0))
    found = [
        lines(reference_fem.box_discretisation(box, (12, 1), "Q1", 2.0, towards, ((1.0,), ())), 0)
        for towards in ("both", "high")
    ]
    both = np.array([0, 0.125, 0.5, 0.875, 1])  # s² from either end
    assert found[0][:5] == pytest.approx(both, abs=1e-15)
    assert found[0][4:] == pytest.approx(1 + 2 * np.array([0, 1, 4, 9, 16, 23, 28, 31, 32]) / 32)
    high = 1 - np.linspace(1, 0, 5) ** 2
    assert found[1][:5] == pytest.approx(high, abs=1e-15)
    assert found[1][4:] == pytest.approx(1 + 2 * (1 - np.linspace(1, 0, 9) ** 2), abs=1e-15)


@table(("through", "message"), [
    # shapes and types
    ((), "mesh lines through (): give coordinates for each axis, as ((), (0.4, 0.6))"),
    (((0.4,),), "mesh lines through ((0.4,),): give coordinates for each axis"),
    (4, "mesh lines through 4: give coordinates for each axis"),
    ((0.4, ()), "mesh lines through 0.4: give coordinates in order, between 0 and 1.2 m"),
    ((("a",), ()), "mesh lines through: expected numbers, got ('a',)"),
    (((), (NAN,)), "mesh lines through: nan at index 0; every value must be finite"),
    # places
    (((0.6, 0.4), ()), "mesh lines through (0.6, 0.4): give coordinates in order, between 0"),
    (((1.3,), ()), "mesh lines through (1.3,): give coordinates in order, between 0 and 1.2 m"),
    (((), (0.9,)), "mesh lines through (0.9,): give coordinates in order, between 0 and 0.8 m"),
    (((0.0,), ()), "mesh lines through (0.0,): give coordinates in order"),
    (((1.2,), ()), "mesh lines through (1.2,): give coordinates in order"),
    # counts
    (((0.05,), ()), "mesh lines through (0.05,): 6 cells do not divide among the parts; choose"),
    (((0.3, 0.9), ()), "mesh lines through (0.3, 0.9): 6 cells do not divide among the parts"),
    (((), tuple(0.1 * k for k in range(1, 8))), "4 cells do not divide among the parts"),
    # Parts of next to no length. Above, halves of a cell go up on either side alike.
    (((0.4, 0.4 + 1e-12), ()), "6 cells do not divide among the parts"),
])  # fmt: skip
def test_bad_places_for_lines_are_named(through, message):
    with refused(message):
        reference_fem.box_discretisation(BOX, (6, 4), "Q1", through=through)


def test_a_side_to_grade_towards_is_one_of_two():
    with refused("mesh grading towards 'low'; choose both or high"):
        reference_fem.box_discretisation(BOX, 4, "Q1", 2.0, "low")


# --- outlines of equilateral triangles ------------------------------------------------------------


def edges(outline):
    following = (*outline.vertices[1:], outline.vertices[0])
    return [Segment(a, b) for a, b in zip(outline.vertices, following, strict=True)]


def turned(outline, angle=0.7, shift=(0.3, -0.1)):
    c, s = np.cos(angle), np.sin(angle)
    corners = outline.corners @ np.array([[c, s], [-s, c]]) + shift
    return Polygon(tuple(map(tuple, corners.tolist())))


OUTLINES = {
    "bar": BAR,
    "block": BLOCK,
    "turned bar": turned(BAR),
    "turned block": turned(BLOCK, -2.0),
    "triangle": Polygon(((0.0, 0.0), (0.8, 0.0), (0.4, 0.8 * ROW))),
    # A hexagon without one of its six triangles: one corner inside, of 300 degrees.
    "open hexagon": Polygon(tuple((0.6 * float(r * np.cos(a)), 0.6 * float(r * np.sin(a))) for r,
        a in [(0, 0), *((1, k * np.pi / 3) for k in range(6))])),
}  # fmt: skip
outlines = pytest.mark.parametrize("outline", OUTLINES.values(), ids=OUTLINES)
triangles = pytest.mark.parametrize("element", [e for e in PLANE if ELEMENTS[e].simplex])


def refined(outline, element, depth, rings=1, spacing=0.2):
    return reference_fem.polygon_discretisation(
        outline, spacing, element, towards=outline.corners, depth=depth, rings=rings
    )


def corners(body):
    """Corners (c, 3, 2) of the triangles."""
    return body.points[body.cells[:, :3]]


def angles(body):
    """Angles (c, 3) in degrees at the corners of the triangles."""
    x = corners(body)
    ahead, back = np.roll(x, -1, axis=1) - x, np.roll(x, 1, axis=1) - x
    cosine = (ahead * back).sum(axis=2) / np.linalg.norm(ahead, axis=2)
    return np.degrees(np.arccos(cosine / np.linalg.norm(back, axis=2)))


def sides(body):
    """Lengths (c, 3) in m."""
    x = corners(body)
    return np.linalg.norm(np.roll(x, -1, axis=1) - x, axis=2)


def area(body):
    (x1, y1), (x2, y2) = (corners(body)[:, 1:] - corners(body)[:, :1]).transpose(1, 2, 0)
    assert (x1 * y2 > x2 * y1).all()  # counter-clockwise, all of them
    return 0.5 * (x1 * y2 - x2 * y1).sum()


@triangles
@pytest.mark.parametrize("spacing", [0.2, 0.1])
@outlines
def test_triangles_cover_the_outline(outline, spacing, element):
    body = reference_fem.polygon_discretisation(outline, spacing, element)
    assert area(body) == pytest.approx(outline.volume, rel=1e-12)
    assert body.basis.dx.sum() == pytest.approx(outline.volume, rel=1e-12)
    assert angles(body) == pytest.approx(60, rel=1e-12)
    assert sides(body) == pytest.approx(spacing, rel=1e-12)
    cells = outline.volume / (np.sqrt(3) / 4 * spacing**2)
    around = sum(edge.measure(()) for edge in edges(outline)) / spacing
    # Euler: vertices = edges - cells + 1, and edges = (3 cells + boundary edges)/2.
    joints = (3 * cells + around) / 2
    nodes = joints - cells + 1 + (joints if element == "P2" else 0)
    assert (len(body.cells), len(body.points)) == pytest.approx((cells, nodes), rel=1e-12)


@pytest.mark.parametrize("rings", [1, 2, 3])
@outlines
def test_refined_triangles_stay_well_shaped(outline, rings):
    # Halves of equilateral triangles at worst: 30, 60 and 90 degrees, or 30, 30 and 120.
    found = angles(refined(outline, "P1", 8, rings))
    assert found.min() > 30 - 1e-9
    assert found.max() < 120 + 1e-9


@triangles
def test_nothing_to_refine_towards_or_no_depth_is_the_even_mesh(element):
    even = reference_fem.polygon_discretisation(BAR, 0.1, element)
    for options in (
        {"towards": BAR.reentrant, "depth": 5},  # it has none
        {"towards": [(0.0, 0.0)]},
        {"towards": [(0.0, 0.0)], "depth": 0, "rings": 3},
    ):
        body = reference_fem.polygon_discretisation(BAR, 0.1, element, **options)
        np.testing.assert_array_equal(body.points, even.points)
        np.testing.assert_array_equal(body.cells, even.cells)


def test_a_place_named_twice_is_one_place():
    once, twice = (
        reference_fem.polygon_discretisation(BAR, 0.1, towards=places, depth=3)
        for places in ([(0.0, 0.0)], [(0.0, 0.0), (0.0, 0.0)])
    )
    np.testing.assert_array_equal(once.points, twice.points)


STACK = Polygon(
    (
        *((0.0, 0.0), (4.0, 0.0), (4.5, ROW), (4.75, ROW), (5.25, 2 * ROW), (5.0, 2 * ROW)),
        *((5.5, 3 * ROW), (6.0, 3 * ROW), (6.5, 4 * ROW), (2.5, 4 * ROW), (2.0, 3 * ROW)),
        *((1.5, 3 * ROW), (1.0, 2 * ROW), (1.25, 2 * ROW), (0.75, ROW), (0.5, ROW)),
    )
)
"""Four strips four sides long, moved along by parts of a side: the triangles whose middles they
hold have the very area and perimeter of the outline."""


@table(("arguments", "options", "message"), [
    ((BAR, 0.2, "Q2"), {}, "mesh: Q2 in a polygon of 4 vertices, 1.6 x 0.519615 m; give a"),
    ((BOX, 0.2), {}, "mesh: P2 in a box 1.2 x 0.8 m; give a Polygon and P1 or P2"),
    # spacing
    ((BAR, 0.0), {}, "mesh spacing: 0.0 m; it must be above zero"),
    ((BAR, -0.2), {}, "mesh spacing: -0.2 m; it must be above zero"),
    ((BAR, NAN), {}, "mesh spacing: nan; every value must be finite"),
    ((BAR, 0.3), {}, "mesh spacing: triangles of side 0.3 m cover 0.701481 of 0.6755 m²"),
    ((BAR, 0.1999), {}, "choose one that divides every edge"),
    ((BLOCK, 0.25), {}, "choose one that divides every edge"),
    ((BAR, 100.0), {}, "mesh spacing: triangles of side 100 m cover 0 of 0.6755 m²"),
    # Whole triangles make the area, but not the outline.
    ((Polygon(((0.0, 0.0), (4.0, 0.0), (4.0, 2 * ROW), (0.0, 2 * ROW))), 1.0), {},
        "mesh spacing: triangles of side 1 m cover 7.79423 of 6.9282 m²"),
    ((STACK, 1.0), {},
        "have their edges on 0 of 0.25 m of edge 2 of the outline, ((4.5, 0.866025) to (4.75, "),
    # places
    ((BAR, 0.2), {"towards": [(0.0, NAN)]}, "places to refine towards: nan at index (0, 1)"),
    ((BAR, 0.2), {"towards": (0.0, 0.0)}, "towards: shape (2,); give (p, 2)"),
    ((BAR, 0.2), {"towards": np.zeros((2, 3))}, "towards: shape (2, 3); give (p, 2)"),
    ((BAR, 0.2), {"depth": 5}, "mesh depth: 5 and no places to refine towards; give towards"),
    ((BAR, 0.2), {"towards": [(0.2, 0.0), (0.5, 0.0)]},
        "towards: (0.5, 0) is 0.1 m from the nearest vertex of the mesh; choose vertices"),
    ((BAR, 0.2), {"towards": [(9.0, 0.0)]}, "(9, 0) is 7.4 m from the nearest vertex"),
    # depth and rings, whether there is a place or not
    ((BAR, 0.2), {"depth": -1}, "mesh depth: -1; give a whole number, 0 or more"),
    ((BAR, 0.2), {"depth": 1.0}, "mesh depth: 1.0; give a whole number, 0 or more"),
    ((BAR, 0.2), {"depth": True}, "mesh depth: True; give a whole number, 0 or more"),
    ((BAR, 0.2), {"rings": 0}, "mesh rings: 0; give a whole number, 1 or more"),
    ((BAR, 0.2), {"towards": [(0.0, 0.0)], "depth": 40},
        "mesh depth: 40 puts vertices 1.8e-13 m apart, nearer than two places are told apart"),
])  # fmt: skip
def test_a_bad_mesh_of_triangles_is_named(arguments, options, message):
    with refused(message):
        reference_fem.polygon_discretisation(*arguments, **options)


# --- exact answers on polygons --------------------------------------------------------------------

MATERIALS = {
    "isotropic": Isotropic(2.0, 0.3, "plane_stress", thickness=0.25),
    "anisotropic": Anisotropic(SKEW, thickness=0.25),
}
VOIGT = {
    "isotropic": np.linalg.inv(np.array([[1, -0.3, 0], [-0.3, 1, 0], [0, 0, 2.6]]) / 2.0),
    "anisotropic": SKEW,
}
materials = pytest.mark.parametrize("name", MATERIALS)


@triangles
@materials
@pytest.mark.parametrize("depth", [0, 3])
@outlines
def test_uniform_stress_from_tractions_on_segments(outline, depth, name, element):
    # Any stress, put on every edge as its traction, must give the strain that it belongs to.
    sxx, syy, sxy = stress = np.array([0.7, -0.4, 0.3])
    loads = []
    for edge in edges(outline):
        x, y = np.subtract(edge.end, edge.start) / edge.measure(())
        loads.append(Traction(edge, (sxx * y - sxy * x, sxy * y - syy * x)))
    exx, eyy, exy = np.linalg.solve(VOIGT[name], stress)
    origin, other = outline.corners[0], outline.corners[1]

    def exact(points):
        x, y = (points - origin).T
        return np.column_stack([exx * x + exy / 2 * y, exy / 2 * x + eyy * y])

    # Three components at two corners: which of the second's, so that no turn is left free.
    axis = int(np.abs(other - origin).argmin())
    second = [None, None]
    second[axis] = float(exact(other[None])[0, axis])
    supports = (
        Support(Region(outline.vertices[0]), (0.0, 0.0)),
        Support(Region(outline.vertices[1]), tuple(second)),
    )
    problem = Problem(outline, MATERIALS[name], supports, tuple(loads))
    body = refined(outline, element, depth)
    solution = reference_fem.solve_problem(problem, body)
    size = np.abs(exact(body.points)).max()
    # Held at two points only, the system has a condition of 1e5, times rounding.
    assert np.abs(solution.displacement - exact(body.points)).max() <= 1e-11 * size
    places = triangular(outline, 0.05).points
    assert np.abs(solution.at(places) - exact(places)).max() <= 1e-11 * size
