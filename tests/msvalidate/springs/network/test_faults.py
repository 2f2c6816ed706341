"""Known faults do what their names say, in proportion to their size; the candidate's answers."""

import numpy as np
import pytest

from msvalidate.bench.judging.candidate import solve_springs
from msvalidate.problem import BodyForce, Box, Isotropic, Problem, Support, Traction
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.constants.isotropic import isotropic_constants
from msvalidate.springs.lattice import patterns, square
from msvalidate.springs.network import faults

CELLS = 4
BOX = Box((1.0, 1.0))
MATERIAL = Isotropic(E=1e5, nu=1 / 3, state="plane_stress", density=1000.0)
CONSTANTS = isotropic_constants(MATERIAL, patterns.square(), 1.0)


def body(*loads):
    problem = Problem(BOX, MATERIAL, (Support(BOX.side("left"), (0.0, 0.0)),), loads)
    return problem, lattice_network(problem, square(BOX, CELLS), CONSTANTS)


PULL = Traction(BOX.side("right"), (100.0, 50.0))


@pytest.fixture
def pulled():
    return body(PULL)


def test_one_spring(pulled):
    network = pulled[1]
    lost = network.stiffness - faults.weaken_one_spring(network, 1.0).stiffness
    assert np.count_nonzero(lost) == 1
    assert lost.max() in network.stiffness
    half = network.stiffness - faults.weaken_one_spring(network, 0.5).stiffness
    np.testing.assert_allclose(half, lost / 2)


def test_diagonals(pulled):
    network = pulled[1]
    changed = faults.stiffen_diagonals(network, 0.01).stiffness != network.stiffness
    np.testing.assert_array_equal(changed, network.rest_length > 1.2 / CELLS)
    assert changed.sum() == 2 * CELLS**2


def test_boundary_springs_come_to_equal(pulled):
    problem, network = pulled
    equal = lattice_network(problem, square(BOX, CELLS), CONSTANTS, weights="equal")
    spoilt = faults.stiffen_boundary(network, 1.0)
    np.testing.assert_allclose(spoilt.stiffness, equal.stiffness, rtol=1e-14)


def test_lumped_tractions(pulled):
    problem, network = pulled
    spoilt = faults.lump_tractions(problem, network, 1.0)
    right = network.points[:, 0] == 1
    np.testing.assert_allclose(spoilt.force[right], np.tile((20.0, 10.0), (CELLS + 1, 1)))
    np.testing.assert_allclose(spoilt.force.sum(axis=0), network.force.sum(axis=0))
    small = faults.lump_tractions(problem, network, 1e-3).force - network.force
    np.testing.assert_allclose(small, 1e-3 * (spoilt.force - network.force), atol=1e-12)


@pytest.mark.parametrize(
    "loads",
    [(PULL, BodyForce((0.0, -9.81))), (Traction(BOX.side("right"), lambda x: 1e2 * x),)],
)
def test_other_loads_are_left_alone(loads):
    problem, network = body(*loads)
    assert faults.lump_tractions(problem, network, 1.0) is network


@pytest.mark.parametrize(
    "fault",
    [
        faults.stiffen_all,
        faults.stiffen_diagonals,
        faults.weaken_one_spring,
        faults.stiffen_boundary,
    ],
)
def test_no_fault_of_size_zero(pulled, fault):
    network = pulled[1]
    np.testing.assert_array_equal(fault(network, 0.0).stiffness, network.stiffness)


def test_answers_of_the_candidate(pulled):
    """Small loads: the three differ by the square of the strain, or by where the run stops."""
    linear, nonlinear, relaxed = (
        solve_springs(*pulled, a) for a in ("linear", "nonlinear", "relaxed")
    )
    size = np.abs(linear).max()
    geometric = np.abs(nonlinear - linear).max() / size
    assert 1e-5 < geometric < 1e-2
    assert np.abs(relaxed - nonlinear).max() / size < 1e-8
