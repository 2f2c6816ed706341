"""Cells that are flat or inside out are seen, and those that are not are left alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import Delaunay

from msvalidate.problem import ProblemError
from msvalidate.springs.dynamics.integrate import State, euler_cromer, motion
from msvalidate.springs.dynamics.integrators import INTEGRATORS
from msvalidate.springs.network import spring_network
from msvalidate.springs.network.folds import count_folded, folded_cells
from msvalidate.springs.network.laws.volumes import cell_volumes
from msvalidate.springs.statics.equilibrium import equilibrium
from tests.table import table


def quadrilateral(corners):
    """One cell with springs along its sides."""
    sides = [[0, 1], [1, 2], [2, 3], [3, 0], [0, 2]]
    return spring_network(corners, sides, 1.0, cells=[[0, 1, 2, 3]])


def test_a_corner_pushed_in_is_a_fold_though_the_area_is_above_zero():
    cell = quadrilateral([[0, 0], [0.37, 0], [0.37, 0.37], [0, 0.37]])
    arrow = np.array([[0, 0], [0.37, 0], [0.13, 0.13], [0, 0.37]])
    assert cell_volumes(arrow, [[0, 1, 2, 3]])[0] > 0
    assert count_folded(cell.simplices, arrow) == 1
    arrow[2] += 0.2
    assert count_folded(cell.simplices, arrow) == 0
    assert count_folded(cell.simplices, np.array(cell.points)) == 0


def test_a_turned_and_moved_body_is_not_folded_and_its_mirror_image_is(lattice_body):
    body = lattice_body((0.37, 0.37), 4)
    turn = np.array([[0.0, 1.0], [-1.0, 0.0]])
    assert count_folded(body.simplices, body.points @ turn + 1e6) == 0
    assert count_folded(body.simplices, body.points * [-1, 1]) == 16


def scattered(n=60):
    """Delaunay triangles of random points, as springs only, the triangles, and a position."""
    rng = np.random.default_rng(3)
    points = rng.uniform(0, 0.37, (n, 2))
    triangles = Delaunay(points).simplices
    pairs = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    network = spring_network(points, np.unique(pairs, axis=0), 1.0)
    return network, triangles, points + rng.normal(0, 0.02, points.shape)


def test_triangles_of_springs_are_found_where_no_cells_are_known():
    network, triangles, position = scattered()
    expected = set()
    for corners in triangles:
        a, b, c = network.points[corners]
        sides = [np.hypot(*(b - a)), np.hypot(*(c - b)), np.hypot(*(a - c))]
        height = abs(np.linalg.det([b - a, c - a])) / max(sides)
        (p, q, r), turned = position[corners], np.sign(np.linalg.det([b - a, c - a]))
        widest = abs(np.linalg.det([b - a, c - a])) / np.prod(sorted(sides)[:2])
        over = turned * np.linalg.det([q - p, r - p]) <= 0
        if height >= 0.25 * max(sides) and widest >= 0.25 and over:
            expected.add(frozenset(corners.tolist()))
    simplices = network.simplices
    cells = folded_cells(simplices, position)
    found = [frozenset(simplices.corners[simplices.cell == cell][0].tolist()) for cell in cells]
    assert len(found) > 3
    assert set(found) == expected


def test_a_linear_answer_counts_its_folds_and_is_not_refused(lattice_body):
    """It goes on in proportion to its load: under enough of it any body is inside out."""
    body = lattice_body((1.0, 1.0), 4)
    force = np.zeros(body.points.shape)
    force[-1] = [-5.0, -5.0]
    assert equilibrium(replace(body, force=force)).folded > 0


@pytest.mark.parametrize("path", ["auto", "plain"])
def test_a_motion_reports_the_cells_that_its_end_has_folded(lattice_body, path):
    body = lattice_body((1.0, 1.0), 4)
    velocity = np.zeros(body.points.shape)
    velocity[12] = [100.0, 0.0]  # the middle, past the point beside it in 3 ms
    start = State(body.points, velocity)
    end = euler_cromer(body, start, 1e-3, 4, path=path, warn=False)
    grid = end.position.reshape(5, 5, 2)
    assert grid[2, 2, 0] > grid[2, 3, 0]
    assert end.folded == 2  # those above and below the side that it has run along
    slow = State(body.points, velocity / 100)
    assert motion(body, slow, INTEGRATORS["leapfrog"], 1e-3, 4, warn=False).folded == 0


@table(
    ("cells", "message"),
    [
        ([[0, 1]], r"cells: \(1, 2\) of points \(4, 2\); give triangles or quadrilaterals"),
        ([0, 1, 2], r"cells: \(3,\)"),
        ([[0, 1, 2, 4]], r"cells: \[0 1 2 4\] at index 0; there are 4 points"),
        ([[0, 1, 2, 0.5]], "cells: .*whole numbers"),
    ],
)
def test_cells_that_do_not_fit_are_refused(cells, message):
    with pytest.raises(ProblemError, match=message):
        spring_network([[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1]], 1.0, cells=cells)
