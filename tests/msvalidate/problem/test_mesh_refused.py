"""What is no mesh, or no boundary of one, and is refused."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from msvalidate.problem import SHAPES, Boundary, Mesh, ProblemError
from tests.table import refused, stored_rows, table

BENT = [name for name, shape in SHAPES.items() if shape.dim > 1 and shape.degree == 2]
examples = settings(max_examples=25, deadline=None)
seeds = st.integers(0, 2**32 - 1)
ROUNDING = 1e-12
"""Sums of a hundred terms of size one, each rounded by 1e-16."""


@table(
    ("points", "cells", "shape", "message"),
    [
        *stored_rows("meshes"),
        (np.zeros((4, 2)), np.empty((0, 4), int), "quad", "mesh cells: shape (0, 4)"),
    ],
)
def test_bad_meshes_are_refused(points, cells, shape, message):
    with refused(message):
        Mesh(points, cells, shape)


def test_mid_sides_that_fold_a_cell_are_refused(box_mesh):
    mesh = box_mesh("triangle6", (1, 1))
    for step, good in ((0.05, True), (0.6, False)):
        x = mesh.points.copy()
        x[(np.abs(x - [1.0, 0.5]) < 1e-9).all(axis=1)] += (step, -step)
        if good:
            assert Mesh(x, mesh.cells, "triangle6").volume == pytest.approx(2, rel=ROUNDING)
        else:
            with refused("is inverted, flat or folded"):
                Mesh(x, mesh.cells, "triangle6")


@given(seeds, st.sampled_from(BENT[:3]))
@examples
def test_a_cell_is_refused_if_and_only_if_it_folds(seed, shape):
    rng = np.random.default_rng(seed)
    kind = SHAPES[shape]
    nodes = kind.nodes + rng.uniform(-0.2, 0.2, kind.nodes.shape)
    x = rng.uniform(size=(5000, kind.dim))
    if kind.simplex:
        x = rng.dirichlet(np.full(kind.dim + 1, 0.5), 5000)[:, : kind.dim]
    columns = np.einsum("qke,kd->qde", kind.slopes(np.vstack([x, kind.nodes])), nodes)
    least = np.linalg.det(columns).min()
    try:
        Mesh(nodes, np.arange(len(nodes))[None], shape)
        assert least > 0
    except ProblemError:
        assert least < 0.05  # the unit cell's is 1; samples miss the least by little


def test_a_body_within_the_bulge_of_another_is_refused(ring_mesh):
    # A speck near the middle of an arc: beyond its chord, on either side of the arc.
    mesh = ring_mesh("triangle6", (1, 2))
    middle = np.array([np.cos(np.pi / 8), np.sin(np.pi / 8)])
    cells = np.vstack([mesh.cells, np.arange(6) + len(mesh.points)])
    for radius, overlaps in ((1.95, True), (2.001, False)):
        assert radius > 2 * np.cos(np.pi / 8)
        speck = radius * middle + 0.01 * SHAPES["triangle6"].nodes
        points = np.vstack([mesh.points, speck])
        if overlaps:
            with refused("cells must meet in whole sides, and not overlap"):
                Mesh(points, cells, "triangle6")
        else:
            assert Mesh(points, cells, "triangle6").volume > mesh.volume


def test_neighbours_share_their_mid_sides(box_mesh):
    mesh = box_mesh("triangle6", (1, 1))
    shared = int(np.flatnonzero((np.abs(mesh.points - [1.0, 0.5]) < 1e-9).all(axis=1))[0])
    cells = mesh.cells.copy()
    cells[1][cells[1] == shared] = len(mesh.points)
    with refused("cells 0 and 1 share corners but not the mid-sides between them"):
        Mesh(np.vstack([mesh.points, [1.05, 0.5]]), cells, "triangle6")


@table(("boundaries", "message"), [
    ({"in": [[1, 2]]}, "boundary 'in': facet [1, 2] is not on the surface"),
    ({"no": [[0, 3]]}, "boundary 'no': facet [0, 3] is not on the surface"),
    ({"no": [[0, 99]]}, "boundary 'no': facet [0, 99] is not on the surface"),
    ({"none": np.empty((0, 2), int)},
        "boundary 'none': shape (0, 2); triangle needs (f, 2), or none"),
    ({"odd": [[0, 1, 2]]}, "boundary 'odd': shape (1, 3); triangle needs (f, 2)"),
    ({"": [[0, 1]]}, "give 1 to 100 printable letters on one line"),
    ({3: [[0, 1]]}, "give 1 to 100 printable letters on one line"),
    ([[0, 1]], "mesh boundaries: [[0, 1]]; give facets by their names"),
])  # fmt: skip
def test_bad_boundaries_are_refused(boundaries, message):
    points = np.array([[0, 0], [1, 0], [0, 1], [1, 1.0]])
    with refused(message):
        Mesh(points, [[0, 1, 2], [1, 3, 2]], "triangle", boundaries)
    with refused(message):
        Mesh(points, [[0, 1, 2], [1, 3, 2]], "triangle").named(boundaries)


@table(
    ("places", "message"),
    [(np.zeros((0, 2, 2)), "places (0, 2, 2)"), (np.zeros((1, 5, 2)), "places (1, 5, 2)")],
)
def test_bad_boundary_places(places, message):
    with refused(message):
        Boundary("side", places)
