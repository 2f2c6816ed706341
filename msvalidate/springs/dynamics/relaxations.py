"""Relaxation methods, one generator each, with the sources of their parameters.

Those that weigh points against each other use the network's own masses: in the coordinates √m·u
they are what their papers write for equal masses.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial

import numpy as np

from msvalidate.linear_algebra.norms import max_abs
from msvalidate.problem import Array, SolverError
from msvalidate.springs import kernels
from msvalidate.springs.dynamics.integrators import LEAPFROG
from msvalidate.springs.dynamics.newton import NEWTON, NEWTON_MULTIGRID
from msvalidate.springs.dynamics.run import Method, Run, step_limit
from msvalidate.springs.dynamics.step_limits import SAFETY
from msvalidate.springs.dynamics.viscous import ALGORITHM1, viscous
from msvalidate.springs.network import tangent

# FIRE's numbers are the paper's.
FIRE_DELAY = 5
"""N_min: steps downhill before the time step grows."""
FIRE_GROWTH, FIRE_CUT = 1.1, 0.5
"""f_inc, f_dec: factors on the time step."""
FIRE_MIX, FIRE_MIX_DECAY = 0.1, 0.99
"""α_start, f_α: part of the velocity that is turned towards the force, and its decay."""
FIRE_FIRST = 0.1
"""First time step over the largest one."""
FIRE_LARGEST = 1.0
"""Largest time step times highest frequency, a parameter that FIRE leaves open.

Near 2, the limit of stability, stiff modes hardly decay, and their uphill motion stops the slow
ones.
"""
STEPS_A_POINT = 50
"""Estimated number of steps of adaptive relaxation, per point.

√κ is at most of the order of the number of points, except for beams with one row of cells.
"""
STRONGEST = 1.9
"""Adaptive damping in pseudo-time, whose critical value for the stiffest mode is 2."""
SLOPE_LEFT = 0.5
"""Largest relative slope after a line search: the second Wolfe condition.

The first condition, a decrease of the energy, is not required: near equilibrium rounding hides it.
"""
TRIALS = 40
ROUNDED = 100
"""Residual, in units of rounding, at which an unsuccessful search has converged."""


def _kinetic_damping(run: Run) -> Iterator[None]:
    """Undamped leapfrog; where the kinetic energy has passed a peak, all velocities are zeroed.

    The restart is midway between the positions before and after the largest velocity, as in
    Barnes. From a position of the steps themselves a mode of h·ω = √2, which two steps
    take from one turning point to the other, would never decay.

    Source: [Cundall1976], [Barnes1999].
    """
    _, highest = run.frequencies
    run.limit = 2 / highest
    run.dt = h = SAFETY * run.limit
    run.look_seldom()
    keep, push = np.ones(len(run.inertia)), np.full(len(run.inertia), h)
    kinetic = 0.0
    while True:
        yield
        still = kinetic == 0
        done, energy, fell = run.motion.advance(
            run.displacement,
            run.velocity,
            keep,
            # From a standstill the first kick is half as long; a whole one diverges above √2/ω.
            push / 2 if still else push,
            h,
            1 if still else run.block,
            kinetic=kinetic,
            to_peak=not still,
        )
        kinetic = energy
        run.moved(done, done)
        if fell:
            run.displacement -= h * run.velocity
            # The last kick undone gives the largest velocity; half a step back along it.
            run.motion.advance(run.displacement, run.velocity, keep, -push, -0.5 * h, 1)
            run.moved(0, 1)
            run.velocity[:], kinetic = 0.0, 0.0


def _fire(run: Run) -> Iterator[None]:
    """Semi-implicit Euler steps, the velocity turned towards the force; uphill it is zeroed.

    Source: [Bitzek2006].
    """
    _, highest = run.frequencies
    run.limit = 2 / highest
    run.dt = FIRE_LARGEST / highest
    velocity, dt, mix, downhill = run.velocity, FIRE_FIRST * run.dt, FIRE_MIX, 0
    acceleration, product = np.empty_like(velocity), np.empty_like(velocity)
    while True:
        yield
        force = run.balance()
        np.divide(force, run.inertia, out=acceleration)
        power, turned = np.vdot(force, velocity), 0.0
        if power > 0:
            speed = np.vdot(np.multiply(run.inertia, velocity, out=product), velocity)
            turned = mix * np.sqrt(speed / np.vdot(force, acceleration))
            velocity *= 1 - mix
            downhill += 1
            if downhill > FIRE_DELAY:
                dt, mix = min(FIRE_GROWTH * dt, run.dt), FIRE_MIX_DECAY * mix
        elif velocity.any():
            velocity[:], dt, mix, downhill = 0.0, FIRE_CUT * dt, FIRE_MIX, 0
        acceleration *= turned + dt
        velocity += acceleration
        run.displacement += np.multiply(velocity, dt, out=product)
        run.moved(1, 1)


def _adaptive_relaxation(run: Run) -> Iterator[None]:
    """Pseudo-time of step 1, masses by Gershgorin's circles, damping by Rayleigh's quotient.

    The local stiffness of a component is the change of its force over its last move; the quotient
    of the displacement with it estimates the frequency of the motion that is left. No frequencies
    are solved for: it is given up after the steps of a slender chain of as many points.

    Source: [Underwood1983], [Papadrakakis1981].
    """
    network = run.network
    run.most_steps = partial(step_limit, STEPS_A_POINT * len(network.points))
    rows = abs(tangent(network, network.points)).sum(axis=1).reshape(network.points.shape)
    run.inertia = np.where(rows > 0, rows, 1.0) / (2 * SAFETY) ** 2  # ω² ≤ Σ|K|/m = 4·SAFETY²
    run.dt, run.limit = 1.0, 1 / SAFETY
    last = np.zeros_like(run.velocity)
    while True:
        yield
        acceleration = run.balance() / run.inertia
        if run.steps:
            damping = min(_critical_damping(run, last - acceleration), STRONGEST)
            run.velocity *= (2 - damping) / (2 + damping)
            run.velocity += 2 / (2 + damping) * acceleration
        else:
            run.velocity += 0.5 * acceleration
        last = acceleration
        run.displacement += run.velocity
        run.moved(1, 1)


def _critical_damping(run: Run, change: Array) -> float:
    """Critical damping 2ω of the motion left, ω² from the change of acceleration over the move.

    Source: [Underwood1983].
    """
    moving = run.velocity != 0  # never so of what is held
    local = np.divide(change, run.velocity, out=np.zeros_like(change), where=moving)
    weight = run.inertia * run.displacement
    weight *= run.displacement
    stored = float(np.vdot(weight, local))
    return 2 * math.sqrt(stored / float(np.vdot(weight, moving))) if stored > 0 else 0.0


def _conjugate_gradients(run: Run) -> Iterator[None]:
    """Directions by Polak and Ribière, step lengths by the springs' own curvature along them.

    Scaled by the tangent's diagonal at the reference points: rest does not depend on masses.

    Source: [PolakRibiere1969], restarted as in [NocedalWright2006], section 5.2.
    """
    network = run.network
    run.most_steps = partial(step_limit, network.points.size)  # in exact arithmetic, so many
    stiffness = np.abs(tangent(network, network.points).diagonal()).reshape(network.points.shape)
    stiffness[stiffness == 0] = 1.0
    direction, before = np.zeros_like(run.displacement), 0.0
    old = np.zeros_like(direction)
    while True:
        yield
        force = run.balance().copy()
        steepest = force / stiffness
        turned = float(np.vdot(force - old, steepest))
        direction *= max(0.0, turned / before) if before else 0.0
        direction += steepest
        if np.vdot(force, direction) <= 0 or not _line_search(run, direction):
            direction[:] = steepest
            if not _line_search(run, direction) and max_abs(force) > ROUNDED * run.test.rounding:
                raise SolverError(
                    f"{run.title}: no step along the force lowers its slope at iteration "
                    f"{run.steps + 1}; the network collapses under this load: reduce it"
                )
        old, before = force, float(np.vdot(force, steepest))
        run.moved(1)


def _line_search(run: Run, direction: Array) -> bool:
    """Move along `direction` until at most half of the slope remains; return True if moved.

    No component moves by more than half the length of the shortest spring. A move as far as that is
    accepted with any positive slope.
    """
    slope = float(np.vdot(run.balance(), direction))
    if slope == 0:
        return False
    bend = kernels.curvature(run.network, run.displacement, direction)
    run.moved(evaluations=1)
    farthest = 0.5 * float(run.network.distance.min()) / max_abs(direction)
    length = min(slope / bend, farthest) if bend > 0 else farthest
    start, near, far = run.displacement.copy(), 0.0, math.inf
    for _ in range(TRIALS):
        run.displacement[:] = start + length * direction
        run.moved(evaluations=1)
        left = float(np.vdot(run.balance(), direction))
        if abs(left) <= SLOPE_LEFT * slope or (left > 0 and length == farthest):
            return True
        near, far = (length, far) if left > 0 else (near, length)
        length = 0.5 * (near + far) if math.isfinite(far) else min(2 * length, farthest)
    run.displacement[:] = start
    run.moved()
    return False


RELAXATIONS = {
    method.name: method
    for method in (
        ALGORITHM1,
        viscous(LEAPFROG, name="viscous_leapfrog"),
        Method("kinetic_damping", "kinetic damping", _kinetic_damping),
        Method("fire", "FIRE", _fire),
        Method("adaptive", "adaptive dynamic relaxation", _adaptive_relaxation),
        Method("conjugate_gradients", "nonlinear conjugate gradients", _conjugate_gradients, 1),
        NEWTON,
        NEWTON_MULTIGRID,
    )
}
"""Name -> method."""
