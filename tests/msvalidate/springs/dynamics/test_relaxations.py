"""Every way to rest: where the equilibrium is, counted honestly, or refused for what it is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from msvalidate.problem import Box, PointForce, ProblemError, Region, SolverError, Support, Traction
from msvalidate.springs import kernels
from msvalidate.springs.dynamics.integrators import INTEGRATORS, LEAPFROG
from msvalidate.springs.dynamics.relax import relax
from msvalidate.springs.dynamics.relaxations import RELAXATIONS
from msvalidate.springs.dynamics.spectrum import extreme_frequencies
from msvalidate.springs.dynamics.viscous import viscous
from msvalidate.springs.network import configuration_at, internal_force, spring_network, tangent
from msvalidate.springs.network.residual import force_scale
from msvalidate.springs.statics.equilibrium import equilibrium
from msvalidate.springs.statics.tangents import is_stable
from tests.table import table

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
    "a large stretch of cells": lambda body, _: sheet(
        body, supports=STRETCH, constants=(0.8, 0.4), volume=0.3
    ),
    "a large stretch of cells that help": lambda body, _: sheet(
        body, supports=STRETCH, constants=(1.0, 0.5), volume=-0.5
    ),
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
    held = replace(sheet(lattice_body, PUSH), fixed=np.ones((45, 2), dtype=bool))
    assert relax(held, method).steps == 0


@every_method
@pytest.mark.parametrize("times", [1e-12, 1e-18, 1e-40])
def test_a_load_that_rounding_hides_is_refused_or_answered_within_its_error(
    method, lattice_body, times
):
    # Positions of some 1 m have no digits for it, and rest is seen at once, where nothing moves.
    network = sheet(lattice_body, PUSH)
    small = replace(network, force=times * network.force)
    expected = equilibrium(small).displacement
    try:
        rest = relax(small, method).equilibrium
    except SolverError as error:
        assert "off by" in str(error)  # noqa: PT017
        return
    apart = np.abs(rest.displacement - expected).max() / np.abs(rest.displacement).max()
    assert apart <= rest.error < 1


@every_method
def test_a_body_whose_prestress_holds_its_load_stays_where_it_is(method, lattice_body):
    network = sheet(lattice_body, PUSH)
    found = equilibrium(network, "nonlinear")
    again = replace(network, points=found.position)
    assert np.abs(relax(again, method).equilibrium.displacement).max() <= 1e-9


@every_method
def test_too_few_steps_are_not_rest(method, lattice_body):
    with pytest.raises(SolverError, match=f"{method.title} is not at rest after 1 steps: .*residu"):
        relax(sheet(lattice_body, PUSH), method, max_steps=1)


@every_method
def test_looking_changes_nothing_but_the_count_of_evaluations(method, lattice_body):
    network, places = sheet(lattice_body, PUSH), []
    for every in (1, 7):
        stop = 21 if method.look_every > 1 else 7
        options = {"tolerance": 1e-13, "look_every": every}  # a look may end Newton's method before
        run = relax(network, method, watch=lambda run, s=stop: run.steps >= s, **options)
        places.append(run.equilibrium.position)
    # A compiled block of steps rounds like its steps one by one.
    np.testing.assert_allclose(*places, rtol=0, atol=1e-13)


def refused_or_at_true_rest(network, method):
    """In balance where every motion meets stiffness, or one line that says what failed."""
    try:
        rest = relax(network, method, max_steps=3000).equilibrium
    except SolverError:
        return None
    assert rest.residual <= 1e-9 * force_scale(configuration_at(network, rest.position))
    assert is_stable(configuration_at(network, rest.position))
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
    free = spring_network([[0, 0], [1, 0]], [[0, 1]], 1.0, fixed=[[True, True], [False, False]])
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


def plain(network, displacement):
    """Acceleration (n, d) by the plain NumPy form."""
    force = internal_force(network, network.points + displacement) + network.force
    return np.where(network.fixed, 0.0, force) / network.mass[:, None]


def after(method, network, steps):
    run = relax(network, method, watch=lambda run: run.steps >= steps, look_every=1)
    assert run.steps == steps
    return run.equilibrium.displacement


def test_fire_is_that_of_the_paper(lattice_body):
    """Forty steps written from Bitzek et al., with equal masses and semi-implicit Euler steps."""
    network = replace(sheet(lattice_body, PUSH), mass=np.full(45, 0.3))
    largest = 1.0 / extreme_frequencies(network)[1]
    u, v = np.zeros((45, 2)), np.zeros((45, 2))
    dt, alpha, positive = 0.1 * largest, 0.1, 0
    for _ in range(40):
        a = plain(network, u)
        if (a * v).sum() > 0:
            positive += 1
            v = (1 - alpha) * v + alpha * a / np.linalg.norm(a) * np.linalg.norm(v)
            if positive > 5:
                dt, alpha = min(1.1 * dt, largest), 0.99 * alpha
        elif v.any():
            v, dt, alpha, positive = 0 * v, 0.5 * dt, 0.1, 0
        v = v + dt * a
        u = u + dt * v
    np.testing.assert_allclose(after(RELAXATIONS["fire"], network, 40), u, atol=1e-12)


def test_kinetic_damping_is_that_of_the_paper(lattice_body):
    """Leapfrog from a half kick; past a peak, back to x - 3/2·h·v + h²/2·a, and at rest again."""
    network = sheet(lattice_body, PUSH)
    h = 0.9 * 2 / extreme_frequencies(network)[1]
    u, v, last, steps = np.zeros((45, 2)), None, 0.0, 0
    while steps < 60:
        a = plain(network, u)
        v = 0.5 * h * a if v is None else v + h * a
        kinetic = 0.5 * network.mass @ (v**2).sum(axis=1)
        u, steps = u + h * v, steps + 1
        if kinetic < last:
            u, v, kinetic = u - 1.5 * h * v + 0.5 * h * h * a, None, 0.0
        last = kinetic
    np.testing.assert_allclose(after(RELAXATIONS["kinetic_damping"], network, 60), u, atol=1e-12)


def test_adaptive_relaxation_is_that_of_the_paper(lattice_body):
    """Forty steps written from Underwood: lumped row sums, local stiffness, Rayleigh's quotient."""
    network = sheet(lattice_body, PUSH)
    free = ~network.fixed
    rows = np.abs(tangent(network, network.points).toarray()).sum(axis=1).reshape(45, 2)
    mass = rows / (4 * 0.9**2)
    u, v, before = np.zeros((45, 2)), np.zeros((45, 2)), None
    for _ in range(40):
        a = plain(network, u) * network.mass[:, None] / mass
        if before is None:
            v = 0.5 * a
        else:
            moving = v[free] != 0
            local = mass[free] * (before - a)[free]
            local = np.divide(local, v[free], out=np.zeros_like(local), where=moving)
            quotient = (u[free] ** 2 * local).sum() / (u[free] ** 2 * mass[free] * moving).sum()
            c = min(2 * np.sqrt(max(quotient, 0.0)), 1.9)
            v = ((2 - c) * v + 2 * a) / (2 + c)
        before = a
        u = u + v
    np.testing.assert_allclose(after(RELAXATIONS["adaptive"], network, 40), u, atol=1e-11)


def test_conjugate_gradients_end_in_few_steps_on_few_points(lattice_body):
    """In exact arithmetic of a linear body, as many as components; masses have no part in it."""
    for cells in ((2, 1), (4, 2)):
        network = sheet(lattice_body, PointForce((2.0, 0.0), (0.0, 1e-6)), cells=cells)
        run = relax(network, RELAXATIONS["conjugate_gradients"])
        assert run.steps <= 2 * network.points.size
        uneven = np.geomspace(1e-9, 1, len(network.points))
        other = relax(replace(network, mass=uneven), RELAXATIONS["conjugate_gradients"])
        assert other.steps == run.steps


@pytest.mark.parametrize("force", [5e-4, 1e-3])
def test_conjugate_gradients_follow_a_network_that_softens(force):
    arch = spring_network(
        [[-1, 0], [0, 0.1], [1, 0]],
        [[0, 1], [1, 2]],
        1.0,
        fixed=[[True, True], [True, False], [True, True]],
        force=[[0, 0], [0, -force], [0, 0]],
    )
    height = 0.1 + relax(arch, RELAXATIONS["conjugate_gradients"]).equilibrium.displacement[1, 1]
    length = np.hypot(1, height)
    # Both springs, in balance with the force; below, the arch has snapped through.
    assert 2 * (length - np.hypot(1, 0.1)) * height / length == pytest.approx(-force, rel=1e-8)
    assert height < 0.1


def test_newton_is_given_up_after_its_own_number_of_steps(lattice_body):
    crush = Traction(SHEET.side("right"), (-50.0, 0.0))
    with pytest.raises(
        SolverError, match=r"negative mode|no stiffness, or less|not at rest after 50 steps"
    ):
        relax(sheet(lattice_body, crush), RELAXATIONS["newton"])


@pytest.mark.parametrize("name", RELAXATIONS)
def test_a_lattice_far_from_the_origin_comes_to_rest(name, lattice_body):
    """Its springs are alike there but for the rounding of coordinates, some 1e-12 m."""
    here = sheet(lattice_body, PUSH, cells=(10, 5))
    far = replace(here, points=here.points + 1e4)
    assert kernels.Motion(far).path == "lattice"
    runs = [relax(network, RELAXATIONS[name], tolerance=1e-12) for network in (here, far)]
    u = [r.equilibrium.position - n.points for r, n in zip(runs, (here, far), strict=True)]
    # 1e-12 a spring, over strains of 1e-2, times the softness of the sheet beside a spring.
    np.testing.assert_allclose(*u, rtol=0, atol=1e-7 * np.abs(u[0]).max())


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
    first = float(np.linalg.norm(network.force[~network.fixed]))
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


@table(
    ("options", "message"),
    [
        ({"tolerance": 0.0}, "tolerance: 0.0; it must be above zero"),
        ({"tolerance": 0.5}, "above 0.01 any start would count as rest"),
        ({"max_steps": 0}, "max_steps: 0; give a whole number, 1 or more"),
        ({"look_every": 0}, "look_every: 0; give a whole number, 1 or more"),
        ({"method": "fir"}, "method: 'fir'; did you mean 'fire'"),
        ({"frequencies": (2.0, 1.0)}, r"natural frequencies: \(2.0, 1.0\); give the lowest and"),
        ({"frequencies": (0.0, 1.0)}, "natural frequencies: .*above zero"),
        ({"frequencies": (1.0,)}, "natural frequencies: .*above zero"),
        ({"frequencies": 1.0}, "natural frequencies: .*above zero"),
        ({"frequencies": (np.nan, 1.0)}, "natural frequencies: nan"),
        ({"watch": 5}, "watch: 5; give a function of the run"),
    ],
)
def test_bad_options_are_refused(lattice_body, options, message):
    usual = {"method": RELAXATIONS["fire"]} | options
    with pytest.raises(ProblemError, match=message):
        relax(sheet(lattice_body, PUSH), **usual)
