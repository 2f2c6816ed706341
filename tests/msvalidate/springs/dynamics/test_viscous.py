"""Algorithm 1: it rests where the equilibrium is, at its documented step, or says why not."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
import pytest

from msvalidate.problem import (
    BodyForce,
    Box,
    PointForce,
    ProblemError,
    SolverError,
    Support,
    Traction,
)
from msvalidate.springs.dynamics.divergence import StabilityWarning
from msvalidate.springs.dynamics.relax import algorithm1
from msvalidate.springs.network import internal_force, spring_network
from msvalidate.springs.statics.equilibrium import equilibrium
from tests.table import table

NAN = float("nan")
SHEET = Box((2.0, 1.0))
FRICTION = np.random.default_rng(1).uniform(0.02, 0.1, 45)
"""Rates (1/s) of the 45 points of a sheet of 8 × 4 cells; twice its lowest frequency is 0.014."""


def sheet(lattice_body, *loads, supports=None, **rules):
    return lattice_body((2.0, 1.0), (8, 4), supports=supports, loads=loads, **rules)


def chain(count=9):
    """Points along x between two fixed ends that move along x only: ω = 2 sin(jπ/2(n + 1))."""
    points = np.stack([np.arange(count + 2.0), np.zeros(count + 2)], axis=1)
    springs = np.stack([np.arange(count + 1), np.arange(1, count + 2)], axis=1)
    held = np.zeros(points.shape, dtype=bool)
    held[[0, -1], 0], held[:, 1] = True, True
    force = np.where(held, 0.0, 0.01)
    return spring_network(points, springs, 1.0, fixed=held, force=force)


def oscillator():
    """One point of 1 kg on one spring of 1 N/m, pulled: ω = 1 rad/s."""
    held = [[True, True], [False, True]]
    return spring_network([[0, 0], [1, 0]], [[0, 1]], 1.0, fixed=held, force=[[0, 0], [0.1, 0]])


# Where it rests -------------------------------------------------------------------------------

PUSH = Traction(SHEET.side("top"), (0.004, -0.01))
STRETCH = (Support(SHEET.side("left"), (0.0, 0.0)), Support(SHEET.side("right"), (0.3, None)))
CASES = {
    "point and body force": lambda body, _: (sheet(body, PointForce((2.0, 0.5), (0.02, 0.03)),
        BodyForce((0.0, -0.01))), {}),
    "damping per point": lambda body, _: (sheet(body, PUSH), {"damping": FRICTION}),
    "underdamped": lambda body, _: (sheet(body, PUSH), {"damping": 0.003}),
    "overdamped": lambda body, _: (sheet(body, PUSH), {"damping": 0.1}),
    "smaller steps": lambda body, _: (sheet(body, PUSH), {"dt": 1.0}),
    "in space, damping per point": lambda _, read: (read("s2")[0],
        {"damping": 0.02 / read("s2")[0].mass}),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_it_rests_in_nonlinear_equilibrium(lattice_body, independent, case):
    network, options = CASES[case](lattice_body, independent)
    expected = equilibrium(network, "nonlinear").displacement
    rest = algorithm1(network, **options).equilibrium
    # A residual of 1e-10 of the forces over the softest mode's stiffness.
    within = 1e-8 * np.abs(expected).max()
    np.testing.assert_allclose(rest.displacement, expected, rtol=0, atol=within)


def test_what_it_returns_describes_where_it_is(lattice_body):
    network = sheet(lattice_body, supports=STRETCH)
    run = algorithm1(network)
    rest = run.equilibrium
    np.testing.assert_array_equal(rest.position, network.points + rest.displacement)
    np.testing.assert_array_equal(rest.position[network.fixed], network.start[network.fixed])
    balance = internal_force(network, rest.position) + network.force
    # Positions are rounded; reactions and residual are those of the displacement.
    rounding = 4 * network.rounding(np.abs(network.points).max()).max()
    expected = np.where(network.fixed, -balance, 0.0)
    np.testing.assert_allclose(rest.reaction, expected, rtol=0, atol=rounding)
    assert rest.residual == pytest.approx(np.abs(balance[~network.fixed]).max(), abs=rounding)
    assert run.steps == rest.iterations == run.history[-1, 0]


# Its step and damping -------------------------------------------------------------------------


def test_a_given_damping_lowers_the_step_by_its_largest_rate():
    highest = 2 * np.sin(9 * np.pi / 20)
    rates = np.linspace(0.5, 3.0, 11)
    run = algorithm1(chain(), damping=rates)
    zeta = 3.0 / (2 * highest)
    assert run.damping == 3.0
    assert run.dt == pytest.approx(1.8 / highest * (np.sqrt(1 + zeta**2) - zeta), rel=1e-12)


def test_max_steps_is_reached_and_not_passed():
    needed = algorithm1(chain()).steps
    assert algorithm1(chain(), max_steps=needed).steps == needed
    # It looks every 20 steps, so it had looked then.
    with pytest.raises(SolverError, match=f"not at rest after {needed - 20} steps"):
        algorithm1(chain(), max_steps=needed - 20)


# When it cannot -------------------------------------------------------------------------------


def refused(options, kind, *fragments):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", StabilityWarning)
        with pytest.raises(kind) as caught:
            algorithm1(oscillator(), **options)
    assert caught.type is kind
    for fragment in fragments:
        assert fragment in str(caught.value)


def test_a_run_that_diverges_says_at_which_step_and_what_to_do():
    refused(
        {"dt": 5.0},
        SolverError,
        "Algorithm 1 diverged by step 20: time step 5 s",
        "stability limit 0.8284 s at damping 2 1/s",
        "take a smaller dt or leave it out",
    )


def test_a_run_beyond_its_limit_is_warned_of_before_it_starts():
    message = "Algorithm 1: time step 5 s, stability limit 0.8284 s at damping 2 1/s; the motion"
    with pytest.warns(StabilityWarning, match=message), pytest.raises(SolverError):
        algorithm1(oscillator(), dt=5.0)


def test_a_run_that_diverges_below_the_limit_blames_the_load(lattice_body):
    # Without diagonals, rows of springs pulled tight stiffen sideways far above the rest state.
    box = Box((1.0, 1.0))
    supports = (
        Support(box.side("left"), (0.0, None)),
        Support(box.side("bottom"), (None, 0.0)),
    )
    shear = Traction(box.side("top"), (0.1, 0.0))
    network = lattice_body((1.0, 1.0), 10, supports=supports, loads=(shear,), constants=(1.0, 0.0))
    with pytest.raises(SolverError, match=r"diverged by step.*reduce dt or the load"):
        algorithm1(network)


def test_an_unstable_run_that_stays_in_bounds_is_told_to_take_a_smaller_step():
    # A point that flies through its fixed end turns round on the other side, for ever.
    refused({"dt": 0.8367}, SolverError, "stability limit 0.8284 s", "smaller dt")


def test_too_few_steps_say_what_is_left_and_what_to_do():
    refused(
        {"max_steps": 5},
        SolverError,
        "Algorithm 1 is not at rest after 5 steps: time step 0.7456 s",
        "stability limit 0.8284 s at damping 2 1/s",
        "residual 0.00858 N, kinetic energy 0.000166 J",
        "raise max_steps, leave damping to its default, or loosen tolerance",
    )


def test_an_undamped_run_never_rests():
    refused(
        {"damping": 0.0, "max_steps": 500},
        SolverError,
        "not at rest after 500 steps: time step 1.8 s, stability limit 2 s at damping 0 1/s",
    )
    refused(
        {"damping": 0.0},
        ProblemError,
        "damping: 0 1/s with no max_steps: the motion never ends",
        "give a positive rate, leave it out, or set max_steps",
    )


@table(
    ("options", "message"),
    [
        ({"damping": -1.0}, "damping: -1 1/s; a negative rate feeds the motion"),
        ({"dt": 0.0}, "time step dt: 0.0 s; it must be above zero"),
        ({"dt": -1.0}, "time step dt: -1.0 s; it must be above zero"),
        ({"dt": NAN}, "time step dt: nan; every value must be finite"),
        ({"tolerance": NAN}, "tolerance: nan; every value must be finite"),
    ],
)
def test_bad_options_are_refused(options, message):
    refused(options, ProblemError, message)


@pytest.mark.parametrize("max_steps", [NAN, 2.5])
def test_a_number_of_steps_is_whole(max_steps):
    refused({"max_steps": max_steps}, ProblemError, "max_steps")


def test_bad_options_are_refused_even_with_nothing_to_move():
    network = replace(oscillator(), fixed=np.ones((2, 2), dtype=bool))
    for options in ({"damping": -1.0}, {"dt": NAN}, {"max_steps": 0}):
        with pytest.raises(ProblemError):
            algorithm1(network, **options)


def slack(lattice_body):
    """A block without diagonals, held below and pushed sideways above."""
    box = Box((1.0, 1.0))
    below = (Support(box.side("bottom"), (0.0, 0.0)),)
    shear = Traction(box.side("top"), (0.1, 0.0))
    return lattice_body((1.0, 1.0), 2, supports=below, loads=(shear,), constants=(1.0, 0.0))


def test_a_mechanism_is_refused_whatever_the_damping(lattice_body):
    with pytest.raises(SolverError, match="mechanism"):
        algorithm1(slack(lattice_body), damping=1.0)


def test_an_unstable_start_is_refused():
    # Compressed at its reference points, the string has no frequency to choose a step from.
    string = spring_network(
        [[0, 0], [1, 0], [2, 0]],
        [[0, 1], [1, 2]],
        1.0,
        rest_length=[1.1, 1.1],
        fixed=[[True, True], [False, False], [True, True]],
    )
    with pytest.raises(SolverError, match="the network is unstable there"):
        algorithm1(string)
