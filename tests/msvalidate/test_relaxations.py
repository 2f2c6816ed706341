"""Every way to rest: where the equilibrium is, counted honestly, or refused for what it is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from msvalidate.equilibrium import equilibrium, is_stable
from msvalidate.integrators import INTEGRATORS, LEAPFROG
from msvalidate.network import force_scale, spring_network
from msvalidate.problem import Box, PointForce, ProblemError, Region, SolverError, Support, Traction
from msvalidate.relax import Method, relax, viscous
from msvalidate.relaxations import RELAXATIONS
from msvalidate.spectrum import extreme_frequencies

SHEET = Box((2.0, 1.0))
PUSH = Traction(SHEET.side("top"), (0.004, -0.01))
STRETCH = (Support(SHEET.side("left"), (0.0, 0.0)), Support(SHEET.side("right"), (0.3, None)))
every_method = pytest.mark.parametrize("method", RELAXATIONS.values(), ids=RELAXATIONS.keys())


def sheet(lattice_body, *loads, supports=None, cells=(8, 4), **rules):
    return lattice_body((2.0, 1.0), cells, supports=supports, loads=loads, **rules)


CASES = {
    "tractions": lambda body, _: sheet(body, PUSH),
    "a large point force": lambda body, _: sheet(body, PointForce((2.0, 0.5), (0.02, 0.03))),
    "prescribed displacement": lambda body, _: sheet(body, supports=STRETCH),
    "equal weights and masses": lambda body, _: sheet(body, PUSH, weights="equal", mass="equal"),
    "masses apart": lambda body, _: replace(
        sheet(body, PUSH), mass=np.random.default_rng(2).uniform(0.2, 5, 45)
    ),
    "prestressed, pulled far": lambda _, read: read("s3")[0],
    "in space": lambda _, read: read("s2")[0],
}


@every_method
@pytest.mark.parametrize("case", CASES)
def test_it_rests_in_nonlinear_equilibrium(method, lattice_body, independent, case):
    network = CASES[case](lattice_body, independent)
    expected = equilibrium(network, "nonlinear").displacement
    run = relax(network, method)
    # A residual of 1e-10 of the forces over the softest mode's stiffness.
    within = 1e-8 * np.abs(expected).max()
    np.testing.assert_allclose(run.equilibrium.displacement, expected, rtol=0, atol=within)
    assert run.evaluations >= run.steps > 0
    assert run.seconds > 0


@every_method
def test_a_body_without_a_load_or_held_everywhere_rests_at_once(method, lattice_body):
    assert not relax(sheet(lattice_body), method).equilibrium.displacement.any()
    held = replace(sheet(lattice_body, PUSH), held=np.ones((45, 2), dtype=bool))
    assert relax(held, method).steps == 0


@every_method
def test_too_few_steps_are_not_rest(method, lattice_body):
    with pytest.raises(SolverError, match=f"{method.title} is not at rest after 1 steps: .*residu"):
        relax(sheet(lattice_body, PUSH), method, max_steps=1)


@every_method
def test_a_watcher_sees_every_look_and_may_end_the_run(method, lattice_body):
    network, seen = sheet(lattice_body, PUSH), []

    def watch(run):
        assert run.displacement.shape == network.points.shape
        seen.append(run.steps)
        return len(seen) == 3

    run = relax(network, method, watch=watch, look_every=1)
    assert seen == [0, 1, 2]
    assert run.steps == 2
    assert run.equilibrium.residual == pytest.approx(run.history[-1, 1], rel=1e-6)


@every_method
def test_looking_changes_nothing_but_the_count_of_evaluations(method, lattice_body):
    network, places = sheet(lattice_body, PUSH), []
    for every in (1, 7):
        stop = 21 if method.look_every > 1 else 7
        run = relax(network, method, watch=lambda run, s=stop: run.steps >= s, look_every=every)
        places.append(run.equilibrium.position)
    # A compiled block of steps rounds like its steps one by one.
    np.testing.assert_allclose(*places, rtol=0, atol=1e-13)


def refused_or_at_true_rest(network, method):
    """In balance where every motion meets stiffness, or one line that says what failed."""
    try:
        rest = relax(network, method, max_steps=3000).equilibrium
    except SolverError:
        return None
    assert rest.residual <= 1e-9 * force_scale(network, rest.position)
    assert is_stable(network, rest.position)
    return rest


@every_method
@pytest.mark.parametrize("n", [2, 5])
def test_a_mechanism_is_refused_or_swings_to_rest(method, hinged_blocks, n):
    """Pulled along no stiffness, the second block may come round to hang along the force."""
    network = hinged_blocks(n)
    rest = refused_or_at_true_rest(network, method)
    assert rest is None or np.abs(rest.displacement).max() > 0.1


def test_a_mechanism_is_refused_by_what_asks_for_frequencies(hinged_blocks):
    for name in ("algorithm1", "viscous_leapfrog", "kinetic_damping", "fire"):
        with pytest.raises(SolverError, match="the network is a mechanism and never comes to rest"):
            relax(hinged_blocks(2), RELAXATIONS[name])


@every_method
def test_free_motions_are_refused_by_name(method):
    free = spring_network([[0, 0], [1, 0]], [[0, 1]], 1.0, held=[[True, True], [False, False]])
    with pytest.raises(ProblemError, match="leave the body free"):
        relax(free, method)


@every_method
def test_a_collapse_is_refused_or_ends_in_true_rest(method, lattice_body):
    """Pushed to a hundredth of its length, a sheet may fold; no method may stop halfway."""
    crush = Traction(SHEET.side("right"), (-50.0, 0.0))
    refused_or_at_true_rest(sheet(lattice_body, crush), method)


@every_method
def test_a_column_beyond_its_euler_load_does_not_rest_straight(method, lattice_body):
    # 0.005 N is more than twice the load at which the column buckles.
    squeeze = Traction(Region((10.0, None)), (-0.005, 0.0))
    network = lattice_body((10.0, 1.0), (20, 2), loads=(squeeze,))
    try:
        tip = relax(network, method).equilibrium.displacement[-1]
    except SolverError:
        return
    assert np.abs(tip).max() > 1.0


def test_numbering_and_place_change_nothing(lattice_body):
    """Relaxed in another order of points and springs, moved and turned: the same displacement."""
    network = sheet(lattice_body, PUSH)
    rng = np.random.default_rng(5)
    order, springs = rng.permutation(len(network.points)), rng.permutation(len(network.springs))
    number = np.argsort(order)
    quarter = np.array([[0.0, 1.0], [-1.0, 0.0]])  # what is held stays along an axis

    def turned(values):
        return values[order] @ quarter

    other = spring_network(
        turned(network.points) + 4.0,
        number[network.springs[springs]],
        network.stiffness[springs],
        mass=network.mass[order],
        held=network.held[order],
        force=turned(network.force),
    )
    for method in RELAXATIONS.values():
        one, two = (relax(n, method, tolerance=1e-11).equilibrium for n in (network, other))
        size = np.abs(one.displacement).max()
        # What is left at 1e-11 of the forces, which rounding may stop elsewhere.
        np.testing.assert_allclose(two.displacement, turned(one.displacement), atol=1e-8 * size)


@pytest.mark.parametrize(("n", "steps"), [(8, 240), (16, 440), (32, 830)])
def test_steps_of_dynamic_relaxation(lattice_body, n, steps):
    """Leapfrog with centred damping at its best step and damping, unit masses, a sheared plate.

    Counts of an independent program: relative residual 1e-6, looked at every 10 steps.
    """
    shear = Traction(Region((1.0, None)), (0.0, -1e-6))
    network = lattice_body((1.0, 1.0), n, loads=(shear,))
    network = replace(network, mass=np.ones(len(network.points)))
    lowest, highest = extreme_frequencies(network)
    method = viscous(LEAPFROG, dt=2 / np.hypot(lowest, highest), damping=2 * lowest)
    first = float(np.linalg.norm(network.force[~network.held]))
    left = []

    def watch(run):
        left.append(np.linalg.norm(run.balance()) / first)
        return left[-1] <= 1e-6

    found = relax(network, method, watch=watch, look_every=10).steps
    assert found == pytest.approx(steps, rel=0.05)


def test_frequencies_that_are_known_serve(lattice_body):
    network = sheet(lattice_body, PUSH)
    for method in RELAXATIONS.values():
        known = relax(network, method, frequencies=extreme_frequencies(network))
        assert known.steps == pytest.approx(relax(network, method).steps, rel=0.05)


def test_a_scheme_with_two_velocities_is_refused():
    with pytest.raises(ProblemError, match="velocity_verlet: more than one velocity a step"):
        viscous(INTEGRATORS["velocity_verlet"])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"tolerance": 0.0}, "tolerance: 0.0; it must be above zero"),
        ({"tolerance": 0.5}, "above 0.01 any start would count as rest"),
        ({"max_steps": 0}, "max_steps: 0; give a whole number, 1 or more"),
        ({"look_every": 0}, "look_every: 0; give a whole number, 1 or more"),
        ({"method": "fire"}, "method: 'fire'"),
        ({"frequencies": (2.0, 1.0)}, "natural frequencies: 2 and 1 rad/s; lowest first"),
        ({"frequencies": (0.0, 1.0)}, "natural frequency: 0.0 rad/s; it must be above zero"),
    ],
)
def test_bad_options_are_refused(lattice_body, options, message):
    usual = {"method": RELAXATIONS["fire"]} | options
    with pytest.raises(ProblemError, match=message):
        relax(sheet(lattice_body, PUSH), **usual)


def test_every_method_names_its_source():
    for name, method in RELAXATIONS.items():
        assert isinstance(method, Method)
        assert len(method.source) > 20, name
