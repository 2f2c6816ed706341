"""Motion of a network in time.

Euler-Cromer is the loop of the report's Algorithm 1: the velocity first, with the old velocity in
the viscous force, then the position with the new velocity.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from msvalidate.problem import Array, ProblemError, SolverError
from msvalidate.problem.checks import (
    finite,
    finite_coordinates,
    format_value,
    positive_number,
    require_type,
    whole_number,
)
from msvalidate.problem.records import dataclass
from msvalidate.springs import kernels
from msvalidate.springs.dynamics.divergence import (
    Stepping,
    is_at_rest,
    largest_reach,
    refuse_diverged,
    refuse_long_step,
    refuse_lost_digits,
    warn_beyond_limit,
)
from msvalidate.springs.dynamics.implicit import NetworkAcceleration
from msvalidate.springs.dynamics.integrators import EULER_CROMER, choose_integrator, step_factors
from msvalidate.springs.dynamics.scheme import Integrator, MotionState, stagger, synchronise
from msvalidate.springs.dynamics.spectrum import extreme_frequencies, highest_frequency
from msvalidate.springs.dynamics.step_limits import SAFETY, stability_limit
from msvalidate.springs.network import Network
from msvalidate.springs.network.breakage import Breakage
from msvalidate.springs.network.folds import count_folded
from msvalidate.springs.network.ground import Ground


@dataclass(frozen=True, eq=False)
class State:
    """Positions and velocities of a network at one time.

    Parameters
    ----------
    position
        Positions (m) of the points, shape (n, d).
    velocity
        Velocities (m/s) of the points at the same time, shape (n, d).
    folded
        Number of flat or inverted cells at the end of a motion. None if there are no cells to
        check, and in states before the end.

    Examples
    --------
    >>> import numpy as np
    >>> from msvalidate import State
    >>> start = State(position=np.array([[0.0, 0.0], [0.37, 0.0]]), velocity=np.zeros((2, 2)))
    """

    position: Array
    velocity: Array
    folded: int | None = None


def motion(
    network: Network,
    state: State,
    integrator: Integrator | str,
    dt: float,
    steps: int,
    damping: ArrayLike = 0.0,
    watch: Callable[[int, State], None] | None = None,
    *,
    warn: bool = True,
    ground: Ground | None = None,
    breakage: Breakage | None = None,
) -> State:
    """Integrate the equations of motion of a network over a number of time steps.

    This is the NumPy reference implementation for every scheme; fixed components do not move.
    ``euler_cromer`` of this module is the compiled implementation of its scheme.
    Source: the schemes are those of [HairerLubichWanner2006] and [Cromer1981], among others.

    Parameters
    ----------
    network
        Network with n points in d dimensions.
    state
        Initial state. Position and velocity belong to the same time; a staggered scheme shifts the
        velocity by half a step at the start and back in every state that it returns.
    integrator
        Time integration scheme, a record of `INTEGRATORS` or its name.
    dt
        Time step (s), > 0.
    steps
        Number of steps, 0 or more.
    damping
        Rate c (1/s) of mass-proportional (Rayleigh) damping, one number or shape (n,), >= 0. The
        viscous force on a point of mass m is -c·m·v.
    watch
        Function of the step number and the `State`, called after every step.
    warn
        True to warn if the time step exceeds the stability limit at the reference positions.
    ground
        Penalty springs of an obstacle, for schemes with one velocity per step. Friction has a
        memory, so that each motion needs a new one.
    breakage
        Springs of this network that break; they are checked before every step.

    Returns
    -------
    State
        State after the last step, with positions (n, d) in m and velocities (n, d) in m/s.

    Raises
    ------
    ProblemError
        If an argument is out of its range, or an array does not have the shape of the network.
    SolverError
        If the motion diverges, or rounding of the positions hides it.

    Examples
    --------
    Two points of 1 kg, joined by a spring of 4 N/m, reach the opposite state after half a period:

    >>> import numpy as np
    >>> from msvalidate import INTEGRATORS, State, motion, spring_network
    >>> network = spring_network([[0.0, 0.0], [0.37, 0.0]], [[0, 1]], 4.0, mass=1.0)
    >>> start = State(network.points + [[-0.01, 0.0], [0.01, 0.0]], np.zeros((2, 2)))
    >>> half_period = np.pi / np.sqrt(2 * 4.0 / 1.0)  # s
    >>> end = motion(network, start, INTEGRATORS["velocity_verlet"], half_period / 100, 100)
    >>> (end.position - network.points)[:, 0].round(4).tolist()
    [0.01, -0.01]
    """
    integrator = choose_integrator("integrator", integrator)
    if not (watch is None or callable(watch)):
        raise ProblemError(
            f"watch: {format_value(watch)}; give a function of step and state, or None"
        )
    rate = _check_arguments(network, state, dt, steps, damping)
    if ground is not None and integrator.factors is None:
        raise ProblemError(
            f"{integrator.name}: takes no ground springs, for it looks at forces more than once a "
            "step or solves for them; take euler_cromer or leapfrog"
        )
    run = Stepping(network, integrator, dt, steps, rate, ground)
    if warn:
        warn_beyond_limit(run)
    free, acceleration = ~network.fixed, NetworkAcceleration(network, ground)
    x = np.array(state.position, dtype=float) - network.points
    with np.errstate(over="ignore", invalid="ignore"):  # refused by refuse_diverged
        if breakage is not None:
            breakage.look(x)
            acceleration.network = breakage.whole(network)
        start = MotionState(x, np.where(free, state.velocity, 0.0), acceleration(x))
        reach = largest_reach(run, start)
        at_rest = is_at_rest(network, start)
        half = 0.5 * dt if integrator.staggered and not at_rest else 0.0
        now = stagger(start, half, rate[:, None])
        for step in range(1, steps + 1):
            if breakage is not None and breakage.look(now.x):
                acceleration.network = breakage.whole(network)
                now = now._replace(a=acceleration(now.x))
            try:
                now = now if at_rest else integrator.step(acceleration, now, dt, rate[:, None])
            except SolverError as error:
                refuse_long_step(run, start, error)
                raise
            refuse_diverged(run, start, now, reach)
            if watch is not None:
                v = synchronise(now, half, rate[:, None]).v
                watch(step, State(network.points + now.x, v))
    now = synchronise(now, half, rate[:, None])
    if steps and not at_rest:
        refuse_lost_digits(network, integrator.name, start, now, 0.0)
    end = network.points + now.x
    return State(end, now.v, count_folded(network.simplices, end))


def recommended_time_step(
    network: Network,
    integrator: Integrator | str,
    *,
    damping: ArrayLike = 0.0,
    ground: Ground | None = None,
) -> float:
    """Return 0.9 of the critical time step of a scheme for a network.

    The critical time step (stability limit, CFL condition) follows from the highest natural
    frequency at the reference positions; explicit Euler needs the lowest one too. For undamped
    leapfrog it is 2 over the highest angular frequency. Source: roots of the one-step matrix inside
    the unit circle [Jury1964].

    Parameters
    ----------
    network
        Network with n points.
    integrator
        Conditionally stable scheme, a record of `INTEGRATORS` or its name.
    damping
        Rate (1/s) of mass-proportional damping, one number or shape (n,), >= 0.
    ground
        Penalty springs of an obstacle, counted with their largest stiffness.

    Returns
    -------
    float
        Time step (s).

    Raises
    ------
    ProblemError
        If the scheme is stable at no time step or at every one, or a rigid-body motion is free.
    SolverError
        If the network is a mechanism or unstable.

    Examples
    --------
    >>> from msvalidate import INTEGRATORS, Box, Isotropic, Problem, Support
    >>> from msvalidate import lattice_network, natural_frequencies, recommended_time_step, square
    >>> box = Box((0.4, 0.1))
    >>> clamp = Support(box.side("left"), (0.0, 0.0))
    >>> problem = Problem(box, Isotropic(E=1e5, nu=1 / 3), supports=(clamp,))
    >>> network = lattice_network(problem, square(box, (4, 1)))
    >>> dt = recommended_time_step(network, INTEGRATORS["leapfrog"])
    >>> _, highest = natural_frequencies(network, 1)
    >>> print(f"{dt * highest:.3f}")
    1.800
    """
    integrator = choose_integrator("integrator", integrator)
    rate = damping_rate(network, damping)
    if np.ptp(rate) > 0 and integrator.limit(0.0) == 0:
        raise ProblemError(
            f"{integrator.name}: damping from {rate.min():g} to {rate.max():g} 1/s; it needs its "
            "damping, so give one rate for all points"
        )
    if math.isinf(integrator.limit(0.0)):
        raise ProblemError(
            f"{integrator.name}: stable at any step, so that no step is recommended; choose it by "
            "accuracy, as a twentieth of the shortest period that matters"
        )
    if ground is None:
        lowest, highest = extreme_frequencies(network)
    else:  # the body may be free
        highest = lowest = math.hypot(highest_frequency(network), ground.frequency)
    limit = stability_limit(integrator, lowest, highest, rate)
    if limit == 0:
        raise ProblemError(
            f"{integrator.name}: unstable at any step with damping {rate.max():g} 1/s; take another"
            " scheme"
        )
    return SAFETY * limit


def euler_cromer(
    network: Network,
    state: State,
    dt: float,
    steps: int,
    damping: ArrayLike = 0.0,
    *,
    warn: bool = True,
    threads: int = 1,
    path: kernels.Path = "auto",
    ground: Ground | None = None,
    breakage: Breakage | None = None,
) -> State:
    """State after `steps` Euler-Cromer steps of `dt` (s); held components do not move.

    Source: [Cromer1981]; it is the loop of Algorithm 1 of [Report].

    Parameters
    ----------
    network, state
        Positions and velocities must have the shape of the network's points.
    dt
        Time step (s). Stable below `stability_limit`.
    steps
        Number of steps, 0 or more.
    damping
        Rate (1/s), one number or (n,): the viscous force is -damping·m·v. A viscosity c in N·s/m
        is the rate c/m.
    warn, ground, breakage
        As in `motion`.
    threads, path
        As in `springs.kernels.Motion`; "plain" is the oracle of the compiled form.

    Raises
    ------
    ProblemError
        If an argument is out of range.
    SolverError
        If the motion grows beyond all numbers, or rounding of positions or of springs' lengths
        hides it.
    """
    rate = _check_arguments(network, state, dt, steps, damping)
    run = Stepping(network, EULER_CROMER, dt, steps, rate, ground)
    if warn:
        warn_beyond_limit(run)
    u = np.array(state.position, dtype=float) - network.points
    v = np.where(network.fixed, 0.0, state.velocity)
    force = np.empty_like(u)
    with np.errstate(over="ignore", invalid="ignore"):  # refused by refuse_diverged
        if breakage is not None:
            breakage.look(u)
        moving = kernels.Motion(
            network, path=path, threads=threads, ground=ground, breakage=breakage
        )
        moving.force_and_energy(u, force)
        if ground is not None:
            force[ground.points] += ground.push(u[ground.points])
        pushed = np.where(network.fixed, 0.0, (force + network.force) / network.mass[:, None])
        start = MotionState(u.copy(), v.copy(), pushed)
        if steps and not is_at_rest(network, start):
            reach = largest_reach(run, start)
            moving.advance(u, v, *step_factors(EULER_CROMER)(dt, rate), dt, steps)
            now = MotionState(u, v, pushed)
            refuse_diverged(run, start, now, reach)
            longest = float(network.distance.max())
            refuse_lost_digits(network, EULER_CROMER.name, start, now, longest)
    end = network.points + u
    return State(end, v, count_folded(network.simplices, end))


def _check_arguments(
    network: Network, state: State, dt: float, steps: int, damping: ArrayLike
) -> Array:
    """The damping (n,) in 1/s of a motion whose arguments are in range."""
    require_type("network", network, Network)
    refuse_obstacle(network)
    require_type("state", state, State)
    positive_number("time step dt", dt, "s")
    whole_number("steps", steps, 0)
    shape, need = network.points.shape, f"give {network.points.shape}"
    finite_coordinates("position", state.position, *shape, need=need)
    finite("velocity", state.velocity, *shape, need=need)
    return damping_rate(network, damping)


def refuse_obstacle(network: Network) -> None:
    """Raise `ProblemError` for a network whose problem has an obstacle, which motions ignore."""
    if network.body is not None and network.body.problem.contacts:
        raise ProblemError("network: its body touches an obstacle; take solve(network)")


def damping_rate(network: Network, damping: ArrayLike) -> Array:
    """Damping (n,) in 1/s from one number or one value a point.

    Raises `ProblemError` if a value is negative or not finite, or their number is not that of the
    points.
    """
    require_type("network", network, Network)
    rate = finite("damping", damping)
    if rate.ndim and rate.shape != (len(network.points),):
        raise ProblemError(
            f"damping: shape {rate.shape}; give one number or {len(network.points)} values"
        )
    if (rate < 0).any():
        raise ProblemError(f"damping: {rate.min():g} 1/s; a negative rate feeds the motion")
    return np.full(len(network.points), rate) if not rate.ndim else np.array(rate)
