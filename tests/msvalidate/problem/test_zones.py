"""Zones of another material: which is where, and what is refused in one line."""

from __future__ import annotations

import re

import numpy as np
import pytest
import shapely
from scipy.optimize import linprog

from msvalidate.problem import (
    SHAPES,
    Anisotropic,
    Ball,
    Box,
    Isotropic,
    Mesh,
    Problem,
    ProblemError,
    Region,
    Support,
    Weight,
    Zone,
    cut_cells,
    materials_at,
    materials_of_cells,
)
from reference_fem import box_discretisation
from tests.inclusion import BALL, DISC, ball_mesh, disc_mesh
from tests.table import table

BOX = Box((2.0, 1.0))
SOFT, HARD = Isotropic(1e5, 1 / 3), Isotropic(3e5, 0.2, density=3000.0)
SOLID = Isotropic(1.0, 0.3, "solid")
HALF = Region(((1.0, 2.0), None))
CLAMP = Support(BOX.side("left"), (0.0, 0.0))


def sheet(*zones, material=SOFT):
    return Problem(BOX, material, (CLAMP,), zones=zones)


def of_cells(problem, cells, element="Q1"):
    body = box_discretisation(problem.domain, cells, element)
    return materials_of_cells(problem, body.points[body.cells], SHAPES[body.element.shape])


@pytest.mark.parametrize(("make", "round_"), [(disc_mesh, DISC), (ball_mesh, BALL)])
def test_named_cells_are_those_within_the_ball_that_they_fill(make, round_):
    mesh = make(1)
    law = SOFT if mesh.dim == 2 else SOLID
    held = (Support(mesh.whole_surface, (0.0,) * mesh.dim),)
    places = mesh.points[mesh.cells]
    found = [
        materials_of_cells(Problem(mesh, law, held, zones=(Zone(region, law),)), places, mesh.kind)
        for region in (mesh.zone("disc"), round_)
    ]
    np.testing.assert_array_equal(found[0], np.isin(np.arange(len(places)), mesh.zones["disc"]))
    np.testing.assert_array_equal(found[1], found[0])


def test_named_cells_in_another_mesh_of_the_same_body():
    coarse = disc_mesh(1)
    problem = Problem(
        coarse,
        SOFT,
        (Support(coarse.whole_surface, (0.0, 0.0)),),
        zones=(Zone(coarse.zone("disc"), HARD),),
    )
    square = np.array([[[-0.9, 0.7], [-0.6, 0.7], [-0.6, 0.9], [-0.9, 0.9]]])
    inner = square * [0.3, 0.3] + [0.2, -0.2]
    across, about = square + np.array([0.5, -0.3]), np.sign(square - square.mean(axis=1)) * 0.99
    given = (square, inner, across, about)
    found = [cut_cells(problem, each, SHAPES["quad"])[0] for each in given]
    assert found == [False, False, True, True]
    assert materials_at(problem, np.array([[0.0, 0.0], [0.45, 0.0], [0.45, 0.45]])).tolist() == [
        1,
        1,
        0,
    ]


REGION = Region(((0.3, 0.7), (0.35, 0.6)))


@pytest.mark.parametrize("shape", ["triangle", "quad"])
def test_cells_that_a_region_ends_in_are_found(shape):
    # By shapely's areas: cells of which some part, but not all, lies in the region.
    rng, kind = np.random.default_rng(1), SHAPES[shape]
    size = rng.choice([0.05, 0.3, 1.5], (400, 1, 1))
    turn = rng.normal(size=(400, 2, 2))
    places = 0.5 + size * (np.einsum("cij,kj->cki", turn, kind.nodes - kind.middle)) / 2
    places += rng.uniform(-0.3, 0.3, (400, 1, 2))
    places[np.linalg.det(turn) < 0] = places[np.linalg.det(turn) < 0][:, ::-1]
    problem = Problem(
        Box((1.0, 1.0)),
        SOFT,
        (Support(Region((0.0, None)), (0.0, 0.0)),),
        zones=(Zone(REGION, HARD),),
    )
    area = shapely.polygons(places)
    part = shapely.area(shapely.intersection(area, shapely.box(0.3, 0.35, 0.7, 0.6)))
    wanted = (part > 1e-12) & (part < shapely.area(area) * (1 - 1e-12))
    np.testing.assert_array_equal(cut_cells(problem, places, kind), wanted)
    assert 50 < wanted.sum() < 350


def test_tetrahedra_that_a_region_enters_are_found():
    # By linear programming: the deepest place that is inside both.
    rng = np.random.default_rng(2)
    size = rng.choice([0.2, 1.0, 3.0], (150, 1, 1))
    places = 0.5 + size * rng.normal(size=(150, 4, 3)) / 2
    box = Box((1.0, 1.0, 1.0))
    region = Region(((0.3, 0.7), (0.45, 0.55), (0.4, 0.6)))
    problem = Problem(
        box, SOLID, (Support(box.side("left"), (0.0,) * 3),), zones=(Zone(region, SOLID),)
    )
    low, high = np.array(region.extent).T
    deepest, whole = [], []
    for corners in places:
        T = np.linalg.inv(np.column_stack([corners, np.ones(4)]))  # barycentric rows
        A = np.vstack([-T[:3].T, np.eye(3), -np.eye(3)])
        b = np.concatenate([T[3], high, -low])
        A = np.column_stack([A, np.linalg.norm(A, axis=1)])
        found = linprog([0, 0, 0, -1], A, b, bounds=[(None, None)] * 4)
        deepest.append(found.x[3])
        whole.append(bool(((corners > low) & (corners < high)).all()))
    wanted = (np.array(deepest) > 1e-9) & ~np.array(whole)
    np.testing.assert_array_equal(cut_cells(problem, places, SHAPES["tetra"]), wanted)
    assert 20 < wanted.sum() < 140


THIN = Region(((1.1, 1.2), None))
OTHER = disc_mesh(1)


@table("make, message", [
    (lambda: Ball((0.0, 0.0), 0.0), "ball: radius"),
    (lambda: Ball([0.0, 0.0], 1.0), "ball: centre [0.0, 0.0]; give a tuple of 2 or 3"),
    (lambda: Ball((0.0, 0.0, 0.0, 0.0), 1.0), "give a tuple of 2 or 3 coordinates"),
    (lambda: Zone("left", HARD), "zone: region 'left'; give a Region of intervals"),
    (lambda: Zone(BOX.side("left"), HARD), "zone: region (x = 0) has no extent"),
    (lambda: Zone(HALF, 3.0), "zone (1 <= x <= 2): material: 3.0; give"),
    (lambda: Zone(HALF, SOLID), "a 3D material in 2D"),
    (lambda: sheet(HALF), "problem: zones (Region"),
    (lambda: Problem(BOX, SOFT, (CLAMP,), zones=[HALF]), "give a list of Zone"),
    (lambda: sheet(Zone(HALF, Isotropic(1.0, 0.3, "plane_strain"))),
        "material in plane_strain, the body in plane_stress; give both one state"),
    (lambda: sheet(Zone(HALF, Isotropic(1.0, 0.3, thickness=2.0))), "2 m thick, the body 1 m"),
    (lambda: sheet(Zone(HALF, Anisotropic(np.eye(3), thickness=2.0))), "2 m thick"),
    (lambda: sheet(Zone(Region(((2.0, 3.0), None)), HARD)), "outside the body"),
    (lambda: Weight((1.0,)), "give 2 or 3 components in m/s²"),
    (lambda: Weight([0.0, -9.81]), "weight: acceleration: [0.0, -9.81]; give a tuple"),
    (lambda: Problem(BOX, SOFT, (CLAMP,), (Weight((0.0, 0.0, 1.0)),)), "give 2 components"),
    (lambda: sheet(Zone(Ball((3.0, 3.0), 1.0), HARD)), "outside the body"),
    (lambda: sheet(Zone(OTHER.zone("disc"), HARD)), "not of the problem's own box"),
    (lambda: OTHER.zone("ring"), "zone 'ring': the mesh has 'disc'; choose one of them"),
    (lambda: of_cells(sheet(Zone(HALF, HARD)), (3, 1)), "it ends inside 1 of 3 cells"),
    (lambda: of_cells(sheet(Zone(THIN, HARD)), (2, 1)), "or a mesh with named cells"),
    (lambda: of_cells(sheet(Zone(Ball((0.5, 0.5), 0.4), HARD)), (2, 1)), "ends inside"),
    (lambda: of_cells(sheet(Zone(Ball((0.5, 0.0), 0.1), HARD)), (2, 1)), "no cell lies in it"),
    (lambda: OTHER.named({}, {"a": [99]}), "mesh zone 'a': cells 99 to 99; there are 9, from 0"),
    (lambda: OTHER.named({}, {"a": []}), "mesh zone 'a': shape (0,)"),
    (lambda: OTHER.named({}, {"a": [[1]]}), "mesh zone 'a': shape (1, 1)"),
    (lambda: OTHER.named({}, {"a\n": [1]}), "printable letters on one line"),
    (lambda: OTHER.named({}, [1]), "mesh zones: [1]; give cells by their names"),
    (lambda: Mesh(OTHER.points, OTHER.cells, OTHER.shape, {}, {"a": [0.5]}), "mesh zone 'a'"),
])  # fmt: skip
def test_what_is_refused(make, message):
    with pytest.raises(ProblemError, match=re.escape(message)) as refused:
        make()
    assert "\n" not in str(refused.value)
    assert len(str(refused.value)) < 300
