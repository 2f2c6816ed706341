"""Relaxations with a known fault, for the negative controls of this study."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np
from scipy.sparse import csc_array
from scipy.sparse.linalg import spsolve

from msvalidate import kit
from msvalidate.springs.dynamics.integrators import LEAPFROG, step_factors
from msvalidate.springs.dynamics.relaxations import RELAXATIONS
from msvalidate.springs.dynamics.run import Method, Run
from msvalidate.springs.dynamics.step_limits import SAFETY
from msvalidate.springs.dynamics.viscous import viscous
from msvalidate.springs.network import configuration_at, tangent

from .dynamic_relaxation import METHOD, steps_at_best_damping

Walk = Callable[[Run], Iterator[None]]


def _half_damped(run: Run) -> Iterator[None]:
    lowest, _ = run.frequencies
    yield from viscous(LEAPFROG, damping=lowest).walk(run)


def _half_kick(h: float, c: kit.Array) -> tuple[kit.Array, kit.Array]:
    keep, push = step_factors(LEAPFROG)(h, c)
    return keep, push / 2


def _lagging(run: Run) -> Iterator[None]:
    """Leapfrog whose force is that of the position before."""
    lowest, highest = run.frequencies
    run.rate, run.dt, run.limit = np.array([2 * lowest]), SAFETY * 2 / highest, 2 / highest
    keep, push = step_factors(LEAPFROG)(run.dt, run.rate)
    mass = run.network.mass[:, None]
    before = run.balance().copy()
    while True:
        yield
        force = run.balance().copy()
        run.velocity *= keep
        run.velocity += push * before / mass
        run.displacement += run.dt * run.velocity
        run.moved(1, 1)
        before = force


def _wrong_tangent(run: Run) -> Iterator[None]:
    """Newton's method whose tangent has the tension's part with a wrong sign."""
    network = run.network
    free = np.flatnonzero(~network.fixed.ravel())
    run.displacement[:] = network.displacement
    run.moved()
    while True:
        yield
        position = network.points + run.displacement
        length = configuration_at(network, position).length
        # Of springs that are at rest as they lie, the tangent is its elastic part alone.
        elastic = tangent(replace(network, rest_length=length), position)
        wrong = csc_array(2 * elastic - tangent(network, position))[free][:, free]
        run.displacement.reshape(-1)[free] += spsolve(wrong, run.balance().ravel()[free])
        run.moved(1, 1)


def _damped_by_spacing(run: Run) -> Iterator[None]:
    """Damping that is a part of the highest frequency: right for one size, not for finer ones."""
    _, highest = run.frequencies
    yield from viscous(LEAPFROG, damping=OF_HIGHEST * highest).walk(run)


OF_HIGHEST = 0.1
"""Of the highest frequency is twice the lowest, where a cube has six cells along an edge."""
HALF_KICK = replace(LEAPFROG, factors=_half_kick)
BY_SPACING = replace(RELAXATIONS["viscous_leapfrog"], walk=_damped_by_spacing)
WRONG_TANGENT = replace(RELAXATIONS["newton"], walk=_wrong_tangent)
WALKS: tuple[tuple[str, str, Walk, Walk], ...] = (
    ("damping halved", "steps", _half_damped, partial(steps_at_best_damping, LEAPFROG, 0.5)),
    (
        "a wrong kick: half the force",
        "dynamic_relaxation",
        viscous(HALF_KICK).walk,
        partial(steps_at_best_damping, HALF_KICK, 1),
    ),
    ("a lagged force", "dynamic_relaxation", _lagging, _lagging),
)
"""Fault, the question that notices it, and how leapfrog and dynamic relaxation step with it."""
FAULTS: dict[str, tuple[str, dict[str, Method]]] = {
    name: (
        question,
        {
            "viscous_leapfrog": replace(RELAXATIONS["viscous_leapfrog"], walk=leapfrog),
            METHOD.name: replace(METHOD, walk=relaxing),
        },
    )
    for name, question, leapfrog, relaxing in WALKS
} | {
    "a damping that follows the spacing and not the body": (
        "steps",
        {"viscous_leapfrog": BY_SPACING},
    ),
    "the geometric part of the tangent with a wrong sign": ("strained", {"newton": WRONG_TANGENT}),
}
"""Fault -> the question that notices it, and the methods that have it, by name."""
