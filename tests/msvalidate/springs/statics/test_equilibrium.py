"""Static equilibrium: patch tests, independent values, closed forms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from msvalidate.problem import Box, PointForce, Region, Support, Traction
from msvalidate.springs.network import energy, spring_network
from msvalidate.springs.statics.equilibrium import equilibrium

SHEET = Box((2.0, 1.0))
SIZES = [(2, 1), (4, 2), (10, 5)]
GEOMETRIES = ["linear", "nonlinear"]


# Independent values ---------------------------------------------------------------------------


def test_a_prestressed_network_pulled_far_against_an_independent_solution(independent):
    network, record = independent("s3")
    rest, expected = equilibrium(network, "nonlinear"), record["equilibrium"]
    np.testing.assert_allclose(rest.position, expected["positions"], rtol=0, atol=1e-10)
    stored = energy(network, rest.position)
    assert stored == pytest.approx(expected["spring_energy"], rel=1e-11)
    reactions = rest.reaction[expected["reaction_nodes"]]
    np.testing.assert_allclose(reactions, expected["reactions"], rtol=0, atol=1e-9)
    assert rest.residual < 1e-10  # N, of loads of 2 N


@pytest.mark.parametrize(("rows", "deflection"), [(4, -246.78), (8, -261.48), (16, -265.61)])
def test_cantilever_deflections_found_before(lattice_body, rows, deflection):
    shear = Traction(Region((4.0, None)), (0.0, -1.0))
    network = lattice_body((4.0, 1.0), (4 * rows, rows), loads=(shear,))
    tip = np.flatnonzero((network.points == [4.0, 0.5]).all(axis=1))
    found = equilibrium(network).displacement[tip, 1]
    assert found == pytest.approx([deflection], abs=0.005)  # the values have two decimals


# Patch tests ----------------------------------------------------------------------------------


@pytest.mark.parametrize("cells", SIZES)
@pytest.mark.parametrize("weights", ["shared", "equal", "per_cell"])
def test_an_affine_boundary_gives_an_affine_interior(lattice_body, cells, weights):
    # MacNeal and Harder's field; inside, a square lattice is centrosymmetric under every rule.
    field = (lambda p: 1e-3 * (p[:, 0] + p[:, 1] / 2), lambda p: 1e-3 * (p[:, 1] + p[:, 0] / 2))
    supports = tuple(
        Support(SHEET.side(side), field) for side in ("left", "right", "bottom", "top")
    )
    network = lattice_body((2.0, 1.0), cells, supports=supports, weights=weights)
    expected = np.stack([component(network.points) for component in field], axis=1)
    found = equilibrium(network).displacement
    # A condition number of some hundred times rounding.
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())


# Linear and nonlinear -------------------------------------------------------------------------


def test_linear_equilibrium_releases_a_small_prestress_to_first_order(lattice_body):
    network = lattice_body((2.0, 1.0), (4, 2))
    pattern = np.random.default_rng(0).uniform(-1, 1, len(network.springs))
    apart = []
    for strain in (1e-4, 5e-5):
        stressed = replace(network, rest_length=(1 + strain * pattern) * network.rest_length)
        linear, nonlinear = (
            equilibrium(stressed, geometry).displacement for geometry in GEOMETRIES
        )
        assert np.abs(linear).max() > 0.1 * strain
        apart.append(np.abs(nonlinear - linear).max())
    assert np.log2(apart[0] / apart[1]) == pytest.approx(2.0, abs=0.05)


def test_linear_response_is_proportional_and_reciprocal(lattice_body):
    near, far = (1.0, 1.0), (2.0, 0.5)
    first = lattice_body((2.0, 1.0), (4, 2), loads=(PointForce(near, (1.0, 0.3)),))
    second = lattice_body((2.0, 1.0), (4, 2), loads=(PointForce(far, (0.0, -2.0)),))
    u, v = equilibrium(first).displacement, equilibrium(second).displacement
    both = equilibrium(replace(first, force=3 * first.force + second.force)).displacement
    np.testing.assert_allclose(both, 3 * u + v, atol=1e-12 * np.abs(both).max())
    # Betti: each force does the same work on the other's displacement.
    assert np.vdot(first.force, v) == pytest.approx(np.vdot(second.force, u), rel=1e-12)


@pytest.mark.parametrize("geometry", GEOMETRIES)
def test_equilibrium_does_not_depend_on_numbering_or_place(independent, geometry):
    network, _ = independent("s3")
    expected = equilibrium(network, geometry).displacement
    rng = np.random.default_rng(0)
    order = rng.permutation(len(expected))
    listed = rng.permutation(len(network.springs))
    moved = spring_network(
        network.points[order] + [0.3, -0.2],
        np.argsort(order)[network.springs[listed]][:, ::-1],
        network.stiffness[listed],
        rest_length=network.rest_length[listed],
        fixed=network.fixed[order],
        force=network.force[order],
    )
    found = equilibrium(moved, geometry).displacement
    np.testing.assert_allclose(found, expected[order], rtol=0, atol=1e-11)


def test_a_body_held_everywhere_only_reacts():
    network = spring_network(
        [[0, 0], [1, 0]],
        [[0, 1]],
        2.0,
        fixed=np.ones((2, 2), dtype=bool),
        displacement=[[0, 0], [0.5, 0]],
        force=[[0, 0], [0, 3.0]],
    )
    for geometry in GEOMETRIES:
        np.testing.assert_array_equal(equilibrium(network, geometry).reaction, [[-1, 0], [1, -3]])
