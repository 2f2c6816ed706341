"""Energy of cells' volumes: exact volumes, bodies of any Poisson's ratio, bad input."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from msvalidate import kernels
from msvalidate.bodies.lattice_network import lattice_network
from msvalidate.lattice import fill, patterns
from msvalidate.network import energy, internal_force, spring_network
from msvalidate.network.laws import volumes
from msvalidate.network.laws.volumes import SURFACES, Volumes, cell_volumes
from msvalidate.problem import Anisotropic, Box, Isotropic, Problem, ProblemError, Support
from msvalidate.relaxation.relax import relax
from msvalidate.relaxation.relaxations import RELAXATIONS
from msvalidate.statics.equilibrium import equilibrium
from tests.table import table

examples = settings(max_examples=25, deadline=None)
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


@every_cell
def test_a_quarter_turn_and_a_shift_cost_nothing(kind):
    network = cell_network(CELLS[kind], 3.0)
    turn = np.eye(kind[0])
    turn[:2, :2] = [[0, -1], [1, 0]]
    moved = network.points @ turn.T + 4.0
    assert energy(network, moved) < 1e-27  # squares of an eps of positions up to 5 m
    np.testing.assert_allclose(internal_force(network, moved), 0, atol=1e-13)
    bent = 1.1 * network.points + 0.1 * network.points[:, :1] ** 2
    turned = bent @ turn.T + 4.0
    assert energy(network, turned) == pytest.approx(energy(network, bent), rel=1e-12)


@every_cell
def test_swelling_stores_half_kappa_times_the_square_of_the_dilatation(kind):
    volumes = one_cell(2.0 * CELLS[kind], 3.0)
    network = spring_network(volumes.points, [[0, 1]], 0.0, volumes=volumes)
    stored = 0.5 * 3.0 * volumes.rest_volume[0] * (1.1 ** kind[0] - 1) ** 2
    assert energy(network, 1.1 * volumes.points) == pytest.approx(stored, rel=1e-12)


@every_cell
def test_small_moves_far_away_keep_their_digits(kind):
    # A move of 1e-9 of the cell: V and V0 share nine digits, and coordinates of 1000 m three more.
    volumes = one_cell(CELLS[kind] + 1000.0, 1.0)
    network = spring_network(volumes.points, [[0, 1]], 0.0, volumes=volumes)
    move = 1e-9 * CELLS[kind]
    out = np.empty_like(move)
    stored = kernels.force_and_energy(network, move, out)
    expected = 0.5 * volumes.rest_volume[0] * ((1 + 1e-9) ** kind[0] - 1) ** 2
    assert stored == pytest.approx(expected, rel=1e-6)


def stretched(pattern, cells, C, constants, kappa):
    """Mean strains across over that along of a box pulled along x, its other sides free."""
    size = tuple(float(n) for n in cells)
    box = Box(size)
    held = [
        Support(box.side(side), _along(axis, len(size), 0.0))
        for axis, side in enumerate(("left", "bottom", "back")[: len(size)])
    ]
    held.append(Support(box.side("right"), _along(0, len(size), 1e-3 * size[0])))
    problem = Problem(box, Anisotropic(C), tuple(held))
    network = lattice_network(problem, fill(pattern, box, cells), constants, volume=kappa)
    rest = equilibrium(network)
    move, points = rest.displacement, network.points
    strain = [move[points[:, a] == size[a], a] / size[a] for a in range(len(size))]
    pull = rest.reaction[points[:, 0] == size[0], 0].sum() / np.prod(size[1:])
    return strain, pull / 1e-3


def _along(axis, dim, value):
    return tuple(value if a == axis else None for a in range(dim))


@pytest.mark.parametrize("nu", [-0.5, 0.0, 0.2, 1 / 3, 0.45, 0.499])
def test_a_square_block_has_any_ratio_of_the_plane(nu):
    mu = 1 / (2 * (1 + nu))
    kappa = (3 * nu - 1) / (2 * (1 - nu**2))
    C = np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]]) / (1 - nu**2)
    strain, modulus = stretched(patterns.square(), (5, 5), C, (2 * mu, mu), kappa)
    np.testing.assert_allclose(-strain[1] / 1e-3, nu, atol=1e-9)
    assert modulus == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("nu", [0.0, 0.25, 0.4, 0.49])
def test_a_cube_has_any_ratio_of_space(nu):
    mu, lam = 1 / (2 * (1 + nu)), nu / ((1 + nu) * (1 - 2 * nu))
    C = np.diag([2 * mu] * 3 + [mu] * 3)
    C[:3, :3] += lam
    strain, modulus = stretched(patterns.cubic18(), (3, 3, 3), C, (mu, mu), lam - mu)
    np.testing.assert_allclose(-np.array(strain[1:]) / 1e-3, nu, atol=1e-9)
    assert modulus == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("nu", [0.0, 0.45])
@pytest.mark.parametrize("name", RELAXATIONS)
def test_every_relaxation_ends_where_newton_does(name, nu):
    box = Box((3.0, 1.0))
    supports = (Support(box.side("left"), (0.0, 0.0)), Support(box.side("right"), (0.3, 0.1)))
    problem = Problem(box, Isotropic(1.0, nu), supports)
    mu, kappa = 1 / (2 * (1 + nu)), (3 * nu - 1) / (2 * (1 - nu**2))
    grid = fill(patterns.square(), box, (6, 2))
    network = lattice_network(problem, grid, (2 * mu, mu), volume=kappa)
    wanted = equilibrium(network, "nonlinear").displacement
    found = relax(network, RELAXATIONS[name], tolerance=1e-10).equilibrium.displacement
    # A slow mode makes up to a hundred times as much displacement of a residual.
    np.testing.assert_allclose(found, wanted, atol=1e-8)


@examples
@given(data=st.data(), seed=st.integers(0, 2**32 - 1))
def test_curvature_is_the_second_difference_of_energy(networks, data, seed):
    network, position = data.draw(networks(stressed=True))
    way = np.random.default_rng(seed).normal(size=position.shape)
    bend = kernels.curvature(network, position - network.points, way)
    ahead, here, behind = (energy(network, position + t * way) for t in (1e-4, 0.0, -1e-4))
    scale = network.stiffness.sum() + (network.volumes.stiffness.sum() if network.volumes else 0)
    assert bend == pytest.approx((ahead - 2 * here + behind) / 1e-8, abs=1e-4 * scale * way.size)


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
        ({"stiffness": [-1e308]}, r"5e\+307 N/m meet at a point; choose units"),
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
        volumes.tangent,
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


def test_stiffness_that_meets_has_its_value_in_the_largest_units():
    # At a corner of a cube ∂V/∂x is h²/4 along each of three axes.
    for h in (1e-90, 1.0, 1e90):
        met = volumes.stiffness_magnitudes(one_cell(h * CELLS[3, 8], 2.0))
        np.testing.assert_allclose(met, 2.0 * h * 3 / 16, rtol=1e-13)
