"""Meshes as bodies: their volume, their surface, and parts of it."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest

from msvalidate.problem import (
    SHAPES,
    Boundary,
    Box,
    Isotropic,
    Mesh,
    PointForce,
    Problem,
    Region,
    Segment,
    Support,
    Traction,
    corners_of,
    measure_of,
    prescribed_displacements,
)
from msvalidate.problem.normals import is_faceted
from msvalidate.problem.shapes import area_vectors
from msvalidate_check import elastic_case
from tests.table import refused, table

CELLS = [name for name, shape in SHAPES.items() if shape.dim > 1]
every_shape = pytest.mark.parametrize("shape", CELLS)
ROUNDING = 1e-12
"""Sums of a hundred terms of size one, each rounded by 1e-16."""


def left(x):
    return x[:, 0] == 0


def right(x):
    return np.abs(x[:, 0] - 2) < 1e-9


# --- volume and surface ---------------------------------------------------------------------------


@every_shape
def test_box_has_its_volume_and_sides(shape, box_mesh):
    mesh = box_mesh(shape, left=left, right=right)
    d = mesh.dim
    assert mesh.volume == pytest.approx(math.prod((2.0, 1.0, 0.5)[:d]), rel=ROUNDING)
    assert mesh.span == Box((2.0, 1.0, 0.5)[:d]).span
    for name in ("left", "right"):
        side = mesh.side(name)
        assert side.measure(mesh.span) == pytest.approx(1.0 if d == 2 else 0.5, rel=ROUNDING)
        _, normal = area_vectors(side.places)
        outward = normal.sum(axis=(0, 1))
        assert np.sign(outward[0]) == (1 if name == "right" else -1)
    total = 6.0 if d == 2 else 2 * (2 + 1 + 0.5)
    assert mesh.whole_surface.measure(mesh.span) == pytest.approx(total, rel=ROUNDING)


# --- parts of the surface -------------------------------------------------------------------------


def test_unknown_name_lists_the_names(box_mesh):
    mesh = box_mesh("quad", left=left, right=right)
    with refused("boundary 'top': the mesh has 'left', 'right'; choose one of them"):
        mesh.side("top")
    with refused("boundary 'top': the mesh has no boundary by name; give a Region"):
        box_mesh("quad").side("top")


def test_region_over_a_whole_side_is_its_facets():
    # Cook's outline: the right side is 16 long, the body's span 60.
    corners = np.array([[0, 0], [48, 44], [48, 60], [0, 44.0]])
    mesh = Mesh(corners, np.array([[0, 1, 2, 3]]), "quad")
    side = Region((48.0, None))
    assert measure_of(side, mesh) == pytest.approx(16)
    assert np.array_equal(corners_of(side, mesh), [[48, 44], [48, 60]])
    slope = Segment((0.0, 0.0), (48.0, 44.0))
    assert measure_of(slope, mesh) == pytest.approx(math.hypot(48, 44))


@pytest.mark.parametrize(
    ("region", "message"),
    [
        (Region((1.0, None)), "no facet of the mesh of 4 quad cells, 2 x 1 m lies there"),
        (Region((0.0, (0.0, 0.3))), "no facet of the mesh"),
        (Region((0.0, (0.0, 0.7))), "ends between the ends of a facet"),
        (Region((3.0, None)), "reaches outside the body"),
        (Region((0.0, (0.0, 1.5))), "reaches outside the body"),
        (Segment((0.0, 0.0), (0.0, 0.7)), "0.5 of its 0.7 m are facets"),
        (Segment((0.0, 0.0), (2.0, 1.0)), "no facet of the mesh"),
        (Region((0.0, None, None)), "has 3 axes, the body 2"),
    ],
)
def test_regions_that_are_no_part_of_a_side(region, message, box_mesh):
    with refused(message):
        corners_of(region, box_mesh("quad"))


def ell():
    """An L of three unit squares around a corner at (1, 1)."""
    x = np.array([[0, 0], [1, 0], [2, 0], [0, 1], [1, 1], [2, 1], [0, 2], [1, 2.0]])
    return Mesh(x, np.array([[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 7, 6]]), "quad")


def test_region_that_goes_on_inside_is_refused():
    assert measure_of(Region((2.0, None)), ell()) == pytest.approx(1)
    assert measure_of(Region((1.0, (1.0, 2.0))), ell()) == pytest.approx(1)
    with refused("region (x = 1): it goes on inside the body of the mesh of 3 quad cells"):
        corners_of(Region((1.0, None)), ell())


def test_a_side_above_a_slope_is_not_taken_to_go_on_inside():
    # Cells below the slope from (1, 1) to (2, 1.5) reach past x = 1 and above y = 1, not both.
    x = np.array([[0, 0], [0.9, 0], [2, 0], [2, 1.5], [1, 1], [1, 2], [0, 2]])
    cells = np.array([[0, 1, 4], [1, 2, 3], [1, 3, 4], [0, 4, 5], [0, 5, 6]])
    mesh = Mesh(x, cells, "triangle")
    assert measure_of(Region((1.0, (1.0, 2.0))), mesh) == pytest.approx(1)
    for longer in (Region((1.0, None)), Region((1.0, (0.9, 2.0)))):
        with refused("it goes on inside the body of the mesh of 5 triangle cells"):
            corners_of(longer, mesh)


def test_line_of_a_solid_ends_at_points(box_mesh):
    mesh = box_mesh("hexahedron")
    assert np.array_equal(corners_of(Region((0.0, 0.0, None)), mesh)[:, 2], [0, 0.25, 0.5])
    assert np.array_equal(corners_of(Region((0.0, 0.0, (0.0, 0.25))), mesh)[:, 2], [0, 0.25])
    with refused("the points of the mesh of 8 hexahedron cells, 2 x 1 x 0.5 m there run from z"):
        corners_of(Region((0.0, 0.0, (0.0, 0.4))), mesh)
    with refused("no point of the mesh"):
        corners_of(Region((0.3, 0.0, None)), mesh)


def test_problem_on_a_mesh(box_mesh):
    mesh = box_mesh("quad9", left=left, right=right)
    clamp = Support(mesh.side("left"), (0.0, 0.0))
    problem = Problem(
        mesh,
        Isotropic(E=1e6, nu=0.3),
        (clamp,),
        (Traction(mesh.side("right"), (1.0, 0.0)), PointForce((2.0, 1.0), (0.0, 1.0))),
    )
    held, _ = prescribed_displacements(problem, mesh.points)
    assert np.array_equal(held.all(axis=1), left(mesh.points))
    with refused("support on boundary 'left': the discretised body has points from y = 0 to 0.5"):
        prescribed_displacements(problem, mesh.points[mesh.points[:, 1] < 0.7])
    with refused("supports leave the body free: translation along y"):
        roller = Support(mesh.side("left"), (0.0, None))
        Problem(mesh, problem.material, (roller,)).refuse_free_body()


def test_each_piece_of_a_mesh_is_held_by_itself(box_mesh):
    one = box_mesh("quad", (1, 1))
    apart, n = np.array([3.0, 0.0]), len(one.points)
    both = Mesh(
        np.concatenate([one.points, one.points + apart]),
        np.concatenate([one.cells, one.cells + n]),
        "quad",
    )
    np.testing.assert_array_equal(both.pieces, np.repeat([0, 1], n))
    ends = [Support(Region((x, None)), (0.0, 0.0)) for x in (0.0, 3.0)]
    law = Isotropic(1e6, 0.3)
    Problem(both, law, tuple(ends)).refuse_free_body()
    for held, where in ((ends[0], "(4, 0.5)"), (ends[1], "(1, 0.5)")):
        with refused(f"the mesh is in 2 pieces, and of that around {where} m: the supports leave"):
            Problem(both, law, (held,)).refuse_free_body()


def test_boundary_of_another_body_is_refused(box_mesh):
    mesh, other = (
        box_mesh("quad", left=left),
        box_mesh("quad", size=(4.0, 1.0), far=lambda x: x[:, 0] > 3.9),
    )
    strange = other.side("far")
    with refused("region boundary 'far' reaches outside the body"):
        Problem(mesh, Isotropic(1e6, 0.3), (Support(strange, (0.0, 0.0)),))
    inner = Boundary("inner", np.array([[[0.0, 0.0], [2.0, 1.0]]]))
    with refused("support on boundary 'inner': from (0, 0) to (1, 0.5) m it is not on one side"):
        Problem(box_mesh("quad", (1, 1)), Isotropic(1e6, 0.3), (Support(inner, (0.0, 0.0)),))


def test_meshes_are_equal_by_their_cells(box_mesh):
    mesh, same = box_mesh("tetra", left=left), box_mesh("tetra")
    assert mesh == same
    assert hash(mesh) == hash(same)
    assert mesh != box_mesh("tetra", (2, 2, 1))
    assert mesh != "mesh"
    again = pickle.loads(pickle.dumps(mesh))  # noqa: S301 - our own bytes, as a sweep sends them
    assert again == mesh
    assert again.side("left").measure(again.span) == pytest.approx(0.5)
    with pytest.raises(ValueError, match="read-only"):
        mesh.points[0] = 1.0


@table(
    "name, mesh, faceted",
    [
        ("lame_ring", "tri3_2", True),
        ("plate_hole", "quad4_2", True),
        ("block_pull", "tet4_2", False),
        ("cook", "tri3_3", False),
    ],
)
def test_facets_that_stand_for_a_curve_are_seen(name, mesh, faceted):
    case = elastic_case(name, 0.3, mesh)
    shape = {3: "triangle", 4: "tetra" if case.points.shape[1] == 3 else "quad"}
    assert is_faceted(Mesh(case.points, case.cells, shape[case.cells.shape[1]])) == faceted
