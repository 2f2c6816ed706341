"""Energy of cells' volumes: exact volumes, bodies of any Poisson's ratio, bad input."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from msvalidate.problem import ProblemError
from msvalidate.springs.network import spring_network
from msvalidate.springs.network.laws import volumes
from msvalidate.springs.network.laws.volumes import SURFACES, Volumes, cell_volumes
from tests.table import table

CUBE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
CELLS = {
    (2, 3): np.array([[0.0, 0], [1, 0], [0, 1]]),
    (2, 4): CUBE[:, :2],
    (3, 4): np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]),
    (3, 8): np.concatenate([CUBE, CUBE + np.array([0, 0, 1])]),
}
every_cell = pytest.mark.parametrize("kind", CELLS, ids=str)


def one_cell(points, kappa=1.0):
    points = np.asarray(points, dtype=float)
    return Volumes(points, np.arange(len(points))[None], np.array([kappa]))


def cell_network(points, kappa=1.0):
    pairs = [(i, j) for i in range(len(points)) for j in range(i)]
    return spring_network(points, pairs, 1e-3, volumes=one_cell(points, kappa))


def test_every_kind_of_cell_is_tried():
    assert set(CELLS) == set(SURFACES)


@every_cell
def test_affine_cells_have_the_determinants_volume(kind):
    rng = np.random.default_rng(1)
    reference = {(2, 3): 1 / 2, (2, 4): 1.0, (3, 4): 1 / 6, (3, 8): 1.0}[kind]
    F = np.eye(kind[0]) + 0.3 * rng.normal(size=(kind[0],) * 2)
    F[:, 0] *= np.sign(np.linalg.det(F))
    points = CELLS[kind] @ F.T + 7.0
    volume = cell_volumes(points, np.arange(kind[1])[None])
    assert volume == pytest.approx(reference * np.linalg.det(F), rel=1e-13)


def test_a_warped_hexahedron_has_the_volume_of_its_trilinear_map():
    points = CELLS[3, 8] + 0.2 * np.random.default_rng(2).normal(size=(8, 3))
    # Two Gauss points an axis are exact: the Jacobian is quadratic along each.
    gauss = 0.5 + np.array([-1, 1]) / np.sqrt(12)
    total = 0.0
    for place in np.stack(np.meshgrid(gauss, gauss, gauss), axis=-1).reshape(-1, 3):
        value = np.where(CELLS[3, 8] == 1, place, 1 - place)
        slope = [
            (2 * CELLS[3, 8][:, a] - 1) * np.delete(value, a, axis=1).prod(axis=1) for a in range(3)
        ]
        total += np.linalg.det(np.array(slope) @ points) / 8
    assert cell_volumes(points, [np.arange(8)]) == pytest.approx(total, rel=1e-13)


SQUARE = CELLS[2, 4]


@table(
    ("given_", "said"),
    [
        ({"cells": [[0, 3, 2, 1]]}, "cell 0 has volume -1; list its corners counter-clockwise"),
        ({"cells": [[0, 1, 2, 9]]}, "cells: .* at index 0; there are 4 points"),
        ({"cells": [[0, 1]]}, "give triangles or quadrilaterals"),
        ({"cells": [[0, 1, 2, 2.5]]}, "whole numbers"),
        ({"stiffness": [np.nan]}, "stiffness"),
        ({"stiffness": [1.0, 2.0]}, r"shape \(2,\); these cells need \(1,\)"),
        ({"cells": 3}, "give triangles or quadrilaterals"),
        ({"points": SQUARE[:, :1]}, "points of cells"),
    ],
)
def test_what_is_no_cell_is_refused(given_, said):
    usual = {"points": SQUARE, "cells": [[0, 1, 2, 3]], "stiffness": [1.0]}
    with pytest.raises(ProblemError, match=said):
        Volumes(**(usual | given_))


def test_cells_of_other_points_are_refused():
    network = cell_network(SQUARE)
    with pytest.raises(ProblemError, match="volumes: of other points than the network's"):
        replace(network, points=network.points + 1.0)


def test_cells_that_are_none_are_refused_where_volumes_are_asked():
    with pytest.raises(ProblemError, match="give triangles or quadrilaterals"):
        cell_volumes(SQUARE, 3)


@table(
    "asked",
    [
        volumes.energy,
        volumes.force,
        volumes.force_magnitudes,
        volumes.tangent_entries,
        lambda v, u: volumes.force_change(v, u, SQUARE),
        lambda v, u: volumes.force_change(v, SQUARE, u),
        volumes.dilatation,
        lambda v, u: volumes.dilatation(v, u, linear=True),
    ],
)
@table("given_", [SQUARE[:3], np.concatenate([SQUARE, SQUARE]), np.nan * SQUARE])
def test_displacements_that_do_not_fit_are_refused(asked, given_):
    with pytest.raises(ProblemError, match=r"give an array \(4, 2\)|every value must be finite"):
        asked(one_cell(SQUARE), given_)
