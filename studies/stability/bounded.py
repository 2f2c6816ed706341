"""The largest step at which a motion stays bounded, found by running a scheme's own step.

No formula for a limit enters: the bracket is the same for all. Trial steps are taken in parallel,
one a column, and the bracket is narrowed to the gap between the last that stays bounded and the
first that grows.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from msvalidate import kit
from msvalidate.springs.dynamics.scheme import Integrator, MotionState

from .networks import Linear

CHUNK = 64
"""Steps between two looks at the energy's peak: no column overflows in so few."""
FEWEST = 8
"""Chunks of the shortest run."""
REACH = 6.0
"""Steps of a run times the gap between trials, relative: where growth is slowest, explicit Euler at
a damping ratio of 0.05, an energy at one gap above the limit grows by 2 % in the second half."""
RISEN, FALLEN = 1e4, 1e-4
"""Energy's peak over the first one from which, or to which, a column need not run on. Near its
limit an undamped motion has a thousandfold energy in some phases, but it never decays; and the
lowest mode, which may be the one that grows, begins with a hundredth of the energy."""
GROWN = 1.005
GROWN_UNDAMPED = 4.0
"""Late peak over that at half time, in energy, from which a motion counts as growing. Under damping
what is bounded decays, and any rise is growth. Without it, steps may fall on the same few phases of
each period for long and miss up to half of a peak; but growth is by percents a step there."""


class Search(NamedTuple):
    """Bracket of the limit in h·ω of the highest frequency, trials a round, and rounds."""

    low: float = 0.04
    high: float = 6.0
    trials: int = 4
    rounds: int = 5

    @property
    def resolution(self) -> float:
        """Largest error of the limit, relative: half the last gap between trials."""
        return 0.5 * math.log(self.high / self.low) * float(self.trials + 1) ** -self.rounds


def measured_limit(
    scheme: Integrator, body: Linear, damping: kit.Array, search: Search, seed: int
) -> kit.Array:
    """Largest stable steps (d,) in s at dampings (d,) in 1/s.

    Where all trials grow or none does, the end of the bracket.
    """
    # In logarithms, so that gaps are relative.
    low = np.full(len(damping), math.log(search.low / body.omega[1]))
    high = np.full(len(damping), math.log(search.high / body.omega[1]))
    part = np.arange(1, search.trials + 1) / (search.trials + 1)
    rates = np.repeat(damping, search.trials)
    for _ in range(search.rounds):
        trials = low[:, None] + (high - low)[:, None] * part
        gap = (high - low).max() / (search.trials + 1)
        chunks = max(FEWEST, math.ceil(REACH / gap / CHUNK))
        h = np.exp(trials.ravel())
        growing = grows(scheme, body, h, rates, chunks, seed).reshape(trials.shape)
        ends = np.column_stack([low, trials, high])
        first = np.where(growing.any(axis=1), growing.argmax(axis=1), search.trials)
        low, high = np.take_along_axis(ends, np.array([first, first + 1]).T, axis=1).T
    return np.asarray(np.exp(0.5 * (low + high)))


def grows(
    scheme: Integrator, body: Linear, h: kit.Array, c: kit.Array, chunks: int, seed: int
) -> kit.Mask:
    """Whether the energy of a free motion grows, a column (n,) of steps (s) and dampings (1/s)."""
    growing = np.zeros(len(h), dtype=bool)
    running = np.arange(len(h))
    x = np.repeat(body.start(seed), len(h), axis=1)
    now = MotionState(x, np.zeros_like(x), body.acceleration(x))
    peaks = np.zeros((chunks, len(h)))
    with np.errstate(over="ignore", invalid="ignore"):  # what overflows has grown
        for chunk in range(chunks):
            now, peaks[chunk, running] = _peak(scheme, body, now, h[running], c[running])
            change = peaks[chunk, running] / peaks[0, running]
            up, down = ~(change < RISEN), change < FALLEN
            growing[running[up]] = True
            keep = ~(up | down)
            running = running[keep]
            if not len(running):
                return growing
            if not keep.all():
                now = MotionState(*(value[:, keep] for value in now))
    middle, late = (slice(int(a * chunks), int(b * chunks)) for a, b in ((0.4, 0.6), (0.8, 1.0)))
    enough = np.where(c > 0, GROWN, GROWN_UNDAMPED)
    risen = peaks[late].max(axis=0) > enough * peaks[middle].max(axis=0)
    growing[running] = risen[running]
    return growing


def _peak(
    scheme: Integrator, body: Linear, now: MotionState, h: kit.Array, c: kit.Array
) -> tuple[MotionState, kit.Array]:
    """State after a chunk of steps, and the largest energy (J) on the way, a column."""
    peak = np.zeros(len(h))
    for _ in range(CHUNK // 2):
        # At every other step: what flips its sign in each has the same energy in both.
        now = scheme.step(body.acceleration, now, h, c)  # type: ignore[arg-type]
        now = scheme.step(body.acceleration, now, h, c)  # type: ignore[arg-type]
        peak = np.maximum(peak, energy(body, now))
    return now, peak


def energy(body: Linear, now: MotionState) -> kit.Array:
    """Kinetic and elastic energy (columns,) in J."""
    # a = -K x / m, so that x·K x needs no product of its own.
    return np.asarray(0.5 * (body.inertia @ (now.v**2 - now.x * now.a)))
