"""Multigrid on networks: solutions of a factor, verdicts of its pivots, cycles that do not grow."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from msvalidate.linear_algebra import choice, factor
from msvalidate.linear_algebra.conjugate_gradients import conjugate_gradients
from msvalidate.linear_algebra.factor import factorise
from msvalidate.problem import Box, Region, SolverError, Traction
from msvalidate.springs.dynamics.relax import relax
from msvalidate.springs.dynamics.relaxations import RELAXATIONS
from msvalidate.springs.network import Configuration, configuration_at, spring_network, tangent
from msvalidate.springs.network.multigrid import make_cycle, restrained_tangent
from msvalidate.springs.statics.equilibrium import equilibrium
from msvalidate.springs.statics.tangents import is_stable, refuse_mechanism

SHEET = Box((2.0, 1.0))
PUSH = Traction(SHEET.side("top"), (0.004, -0.01))
MULTIGRID = RELAXATIONS["newton_multigrid"]


def sheet(lattice_body, n, **rules):
    return lattice_body((2.0, 1.0), (2 * n, n), loads=(PUSH,), **rules)


def system(network, position=None):
    """The restrained tangent of a network, and its cycle."""
    position = network.points if position is None else position
    at = configuration_at(network, position)
    A = restrained_tangent(at)
    return A, make_cycle(A, at)


without_factors = pytest.mark.usefixtures("only_multigrid")


@pytest.fixture
def only_multigrid(monkeypatch):
    """Every network counts as too large for a factor."""
    monkeypatch.setattr(choice, "MOST_PRODUCTS", 0)


def test_cycles_of_a_solution_and_of_a_verdict_do_not_grow(lattice_body):
    """Sixteen times the components: the verdict asks for 1.2 digits more, others for none."""
    cycles = []
    for n in (12, 48):
        network = sheet(lattice_body, n)
        A, cycle = system(network)
        force = np.where(network.fixed, 0.0, network.force).ravel()
        cycles.append(conjugate_gradients(A, force, cycle, 1e-8).steps)
    assert cycles[1] <= cycles[0] + 6  # a digit takes one and a half cycles or two
    assert cycles[1] < 24


def test_newton_solves_no_further_than_the_next_tangent_can_use(lattice_body):
    """Turned by a hundredth: all its solves together cost less than two to the last digit."""
    network = sheet(lattice_body, 32)
    network = replace(network, force=0.02 * network.force)
    A, cycle = system(network)
    force = np.where(network.fixed, 0.0, network.force).ravel()
    one = conjugate_gradients(A, force, cycle, 1e-12).steps
    run = relax(network, MULTIGRID)
    assert run.steps >= 3
    assert run.evaluations - run.steps < 2 * one


def test_a_load_that_is_none_takes_no_cycle(lattice_body):
    A, cycle = system(sheet(lattice_body, 4))
    found = conjugate_gradients(A, np.zeros(A.shape[0]), cycle, 1e-3)
    assert (found.steps, found.reduction) == (0, 0.0)
    assert not found.solution.any()


def test_numbers_of_points_are_no_matter(lattice_body):
    """Numbered at random: as many cycles but for one or two; unsorted ones take 4 to 9 more."""
    network = sheet(lattice_body, 40)
    new = np.random.default_rng(0).permutation(len(network.points))
    old = np.argsort(new)
    moved = spring_network(
        network.points[old],
        new[network.springs],
        network.stiffness,
        fixed=network.fixed[old],
        force=network.force[old],
    )
    cycles = []
    for one in (network, moved):
        A, cycle = system(one)
        force = np.where(one.fixed, 0.0, one.force).ravel()
        cycles.append(conjugate_gradients(A, force, cycle, 1e-8).steps)
    assert cycles[1] <= cycles[0] + 2
    np.testing.assert_allclose(
        equilibrium(moved, solver="multigrid").displacement[new],
        equilibrium(network, solver="direct").displacement,
        rtol=0,
        atol=1e-14,
    )


# --- verdicts without a factor ----------------------------------------------------------------


def column(lattice_body, over, cells=(80, 8)):
    """A clamped column and its straight place under `over` times its Euler load (N).

    π²EI/4L² with the bending stiffness of a lattice, 1 + ((2 - nu)/(1 + nu))/n² times EI for n
    cells through the height: as in `test_equilibrium`.
    """
    euler = np.pi**2 / 12 / 400 * (1 + 1.25 / cells[1] ** 2)
    squeeze = Traction(Region((10.0, None)), (-over * euler, 0.0))
    network = lattice_body((10.0, 1.0), cells, loads=(squeeze,))
    # Uniform compression, the first order of what the traction makes: load over E of 1 Pa.
    strain = over * euler
    nu = 1 / 3
    middle = network.points - [0.0, 0.5]
    return network, network.points + middle * [-strain, nu * strain]


@without_factors
@pytest.mark.parametrize(("over", "stable"), [(0.5, True), (0.9, True), (1.2, False), (5, False)])
def test_a_column_is_stable_up_to_its_euler_load(lattice_body, over, stable):
    network, straight = column(lattice_body, over)
    free = np.flatnonzero(~network.fixed.ravel())
    K = tangent(network, straight)[free][:, free]
    assert (factorise(K).negative == 0) is stable  # the pivots' verdict
    assert is_stable(configuration_at(network, straight)) is stable
    # So it is by a cycle of the network at rest, as a relaxation hands it on.
    assert is_stable(configuration_at(network, straight), system(network)[1]) is stable


@pytest.mark.parametrize("name", [name for name in RELAXATIONS if name != "newton"])
def test_methods_take_the_same_steps_without_factors(lattice_body, monkeypatch, name):
    """What large networks ask of multigrid: frequencies to plan by, and a verdict at rest."""
    network = sheet(lattice_body, 20)  # too large for dense frequencies as well
    by_factor = relax(network, RELAXATIONS[name], tolerance=1e-8)
    monkeypatch.setattr(choice, "MOST_PRODUCTS", 0)
    monkeypatch.setattr(factor, "splu", None)
    by_multigrid = relax(network, RELAXATIONS[name], tolerance=1e-8)
    assert by_multigrid.steps == pytest.approx(by_factor.steps, rel=0.01)
    np.testing.assert_allclose(
        by_multigrid.equilibrium.displacement, by_factor.equilibrium.displacement, atol=1e-7
    )


@without_factors
@pytest.mark.parametrize("name", ["viscous_leapfrog", "newton_multigrid"])
def test_a_column_that_rests_straight_beyond_its_euler_load_is_refused(lattice_body, name):
    """Exactly straight, nothing disturbs it: only the verdict knows."""
    network, _ = column(lattice_body, 1.5, cells=(40, 4))
    with pytest.raises(SolverError, match=r"unstable|negative mode|not positive"):
        relax(network, RELAXATIONS[name], max_steps=100_000)


@without_factors
def test_what_buckles_in_one_place_is_refused(lattice_body):
    network = sheet(lattice_body, 16)
    around = (network.springs == len(network.points) // 2).any(axis=1)
    swollen = replace(network, rest_length=np.where(around, 3.0, 1.0) * network.rest_length)
    assert not is_stable(Configuration(swollen))
    assert not is_stable(Configuration(swollen), system(network)[1])


@without_factors
@pytest.mark.parametrize("n", [2, 5, 20, 70])
def test_a_mechanism_is_not_stable(hinged_blocks, n):
    """Of 70 cells a side its stiffness is rounded up, and a random load meets nothing negative."""
    network = hinged_blocks(n)
    assert not is_stable(Configuration(network))
    assert not is_stable(Configuration(network), system(network)[1])
    with pytest.raises(SolverError, match=r"mechanism: nothing resists point .* moving along"):
        equilibrium(network, solver="multigrid")


@without_factors
@pytest.mark.parametrize("turn", [0.0, 0.7])
def test_a_point_on_one_spring_is_named(lattice_body, turn):
    """What it meets across is 0, or the rounding of a turn; by multigrid and by a factor."""
    block = lattice_body((1.0, 1.0), 12)
    n = len(block.points)
    c, s = np.cos(turn), np.sin(turn)
    network = spring_network(
        np.vstack([block.points, [1.05, 0.5]]) @ [[c, s], [-s, c]],
        np.vstack([block.springs, [n // 2, n]]),
        np.append(block.stiffness, 1.0),
        fixed=np.vstack([block.fixed, [False, False]]),
        force=np.vstack([block.force, [0.001 * -s, 0.001 * c]]),
    )
    with pytest.raises(SolverError, match=f"nothing resists point {n} at"):
        relax(network, MULTIGRID)
    with pytest.raises(SolverError, match=f"nothing resists point {n} at"):
        equilibrium(network)


@without_factors
def test_a_column_that_buckles_is_no_mechanism(lattice_body):
    """Unstable is not loose: its springs resist every motion, some by falling."""
    network, straight = column(lattice_body, 1.5, cells=(40, 4))
    squeezed = replace(network, points=straight)
    refuse_mechanism(network)
    refuse_mechanism(squeezed)
    assert not is_stable(configuration_at(squeezed, straight))


@without_factors
def test_prestress_alone_may_make_a_network_stable():
    """A string of unstressed springs is loose across; pulled, it is not."""
    points = np.stack([np.arange(50.0), np.zeros(50)], axis=1)
    springs = np.stack([np.arange(49), np.arange(1, 50)], axis=1)
    held = np.zeros(points.shape, dtype=bool)
    held[[0, -1]] = True
    for rest, stable in ((1.0, False), (0.9, True), (1.1, False)):
        string = spring_network(points, springs, 2.0, rest_length=rest, fixed=held)
        assert is_stable(Configuration(string)) is stable


@without_factors
def test_the_verdict_at_rest_is_that_of_the_pivots(lattice_body, independent):
    for network in (sheet(lattice_body, 16), independent("s3")[0], independent("s2")[0]):
        assert is_stable(configuration_at(network, equilibrium(network, "nonlinear").position))


@without_factors
def test_a_matrix_that_is_negative_is_told_by_its_motion():
    """Two points on a line, one spring that pushes: its motion across falls."""
    pair = spring_network(
        [[0, 0], [1, 0]], [[0, 1]], 1.0, rest_length=2.0, fixed=[[True, True], [False, False]]
    )
    A, cycle = system(pair)
    assert cycle.indefinite_motion is not None
    assert cycle.indefinite_motion @ (A @ cycle.indefinite_motion) < 0
    assert not is_stable(Configuration(pair))
