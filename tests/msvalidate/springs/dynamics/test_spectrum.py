"""Natural frequencies: independent values, closed forms, both solvers."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import Delaunay

from msvalidate.linear_algebra import choice
from msvalidate.problem import ProblemError, SolverError
from msvalidate.springs.dynamics import spectrum
from msvalidate.springs.dynamics.spectrum import extreme_frequencies, natural_frequencies
from msvalidate.springs.network import spring_network
from msvalidate.springs.statics.equilibrium import equilibrium
from tests.table import table


@pytest.fixture(params=["dense", "factor", "multigrid"], autouse=True)
def solver(request, monkeypatch):
    """Every test runs through all solvers."""
    monkeypatch.setattr(spectrum, "DENSE", 10**9 if request.param == "dense" else 0)
    if request.param == "multigrid":
        monkeypatch.setattr(choice, "MOST_PRODUCTS", 0)
    return request.param


def chain(count, stiffness=3.0, mass=0.5):
    """Points along x between two fixed ends, 1 m apart, that move along x only."""
    points = np.stack([np.arange(count + 2.0), np.zeros(count + 2)], axis=1)
    springs = np.stack([np.arange(count + 1), np.arange(1, count + 2)], axis=1)
    held = np.zeros(points.shape, dtype=bool)
    held[[0, -1], 0], held[:, 1] = True, True
    return spring_network(points, springs, stiffness, mass=mass, fixed=held)


def test_modes_of_a_tetrahedral_network_against_independent_values(independent):
    network, record = independent("s4")
    lowest, highest = natural_frequencies(network, 10)
    np.testing.assert_allclose(lowest, record["modes"]["omega_lowest"], rtol=1e-10)
    assert highest == pytest.approx(record["modes"]["omega_highest"], rel=1e-10)


def test_modes_of_a_prestressed_network_at_equilibrium_against_independent_values(independent):
    network, record = independent("s3")
    position = equilibrium(network, "nonlinear").position
    expected = record["modes_at_equilibrium"]
    lowest, highest = natural_frequencies(replace(network, points=position), 10)
    np.testing.assert_allclose(lowest, expected["omega_lowest"], rtol=1e-10)
    assert highest == pytest.approx(expected["omega_highest"], rel=1e-10)


def test_a_chain_has_its_closed_form():
    # 2√(k/m) sin(jπ/2(n + 1)), j = 1 … n.
    omega = 2 * np.sqrt(3.0 / 0.5) * np.sin(np.arange(1, 41) * np.pi / 82)
    lowest, highest = natural_frequencies(chain(40), 7)
    # ω² is exact to 1e-16 of the largest, 700 times the smallest.
    np.testing.assert_allclose(lowest, omega[:7], rtol=1e-11)
    assert highest == pytest.approx(omega[-1], rel=1e-12)
    assert extreme_frequencies(chain(40)) == pytest.approx((omega[0], omega[-1]), rel=1e-11)


@table(
    ("tolerance", "message"),
    [
        (-1e-4, "tolerance of the frequencies: -0.0001; give a relative error, 0 <= tolerance < 1"),
        (1.0, "tolerance of the frequencies: 1.0; give a relative error"),
        (float("nan"), "tolerance of the frequencies: nan; every value must be finite"),
        (None, "tolerance of the frequencies: expected numbers, got None"),
    ],
)
def test_a_tolerance_that_is_no_relative_error_is_refused(tolerance, message):
    with pytest.raises(ProblemError, match=re.escape(message)):
        extreme_frequencies(chain(5), tolerance=tolerance)


def test_a_free_body_has_its_rigid_motions_at_zero(lattice_body):
    network = lattice_body((2.0, 1.0), (8, 4))
    free = replace(network, fixed=np.zeros(network.points.shape, dtype=bool))
    with pytest.raises(ProblemError, match="free to move as a rigid body in 3 ways; hold one"):
        natural_frequencies(free, 4)
    lowest, highest = natural_frequencies(free, 4, rigid=True)
    np.testing.assert_array_equal(lowest[:3], 0.0)
    assert lowest[3] > 1e-2 * highest


def test_a_free_part_is_named_beside_one_that_is_held():
    # A triangle of sides 0.37 m held at two points, and a free one: equal masses at its corners.
    side = 0.37
    points = side * np.array([[0, 0], [1, 0], [0.5, np.sqrt(0.75)]])
    springs = np.array([[0, 1], [1, 2], [2, 0]])
    held = np.zeros((6, 2), dtype=bool)
    held[:2] = True
    network = spring_network(
        np.concatenate([points, points + 2.0]),
        np.concatenate([springs, springs + 3]),
        2.0,
        fixed=held,
    )
    with pytest.raises(ProblemError, match=r"the part of point 3 is free to move .* in 3 ways"):
        natural_frequencies(network, 1)
    lowest, highest = natural_frequencies(network, 8, rigid=True)
    np.testing.assert_array_equal(lowest[:3], 0.0)
    # The free triangle's own modes: 3k/2m twice and, breathing, 3k/m; the held one's point sees
    # springs at 60 degrees: k/2 and 3k/2 over m.
    np.testing.assert_allclose(lowest[3:] ** 2, [1.0, 3.0, 3.0, 3.0, 6.0], rtol=1e-12)
    assert highest**2 == pytest.approx(6.0, rel=1e-12)


def test_an_unstable_position_is_refused():
    # A chain free across, its springs too long for their places: it buckles sideways.
    straight = chain(40)
    held = straight.fixed.copy()
    held[1:-1, 1] = False
    crowded = replace(straight, fixed=held, rest_length=1.02 * straight.rest_length)
    with pytest.raises(SolverError, match=r"omega² = -.*the network is unstable there"):
        natural_frequencies(crowded, 3)


def test_one_strongly_unstable_point_is_refused(lattice_body):
    network = lattice_body((8.0, 4.0), (16, 8))
    around = (network.springs == len(network.points) // 2).any(axis=1)
    swollen = replace(network, rest_length=np.where(around, 3.0, 1.0) * network.rest_length)
    with pytest.raises(SolverError, match="the network is unstable there"):
        natural_frequencies(swollen, 3)


@table("count", [0, -1, 6])
def test_a_count_outside_the_free_components_is_refused(count):
    message = f"count: {count} frequencies; this network has 5 free components"
    with pytest.raises(ProblemError, match=re.escape(message)):
        natural_frequencies(chain(5), count)


def test_a_network_held_everywhere_has_no_frequencies():
    network = chain(5)
    fixed = replace(network, fixed=np.ones(network.points.shape, dtype=bool))
    with pytest.raises(ProblemError, match="every component is held; nothing can move"):
        natural_frequencies(fixed, 1)


def test_what_multigrid_cannot_tell_from_rounding_is_left_to_a_factor(solver):
    """Stiffnesses nine decades apart, spring by spring: the iteration comes to no end."""
    if solver == "dense":
        return
    points = np.random.default_rng(0).random((120, 2))
    corners = Delaunay(points).simplices
    springs = np.unique(
        np.sort(corners[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0
    )
    stiffness = 10.0 ** (9 * np.random.default_rng(1).random(len(springs)))
    held = np.repeat(points[:, :1] < 0.2, 2, axis=1)
    network = spring_network(points, springs, stiffness, fixed=held)
    expected, _ = natural_frequencies(network, 3, solver="direct")
    found, _ = natural_frequencies(network, 3)
    np.testing.assert_array_equal(found, expected)
    with pytest.raises(SolverError, match=r"close to rounding.*; take solver 'direct'$"):
        natural_frequencies(network, 3, solver="multigrid")
