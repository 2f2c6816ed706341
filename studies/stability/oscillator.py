"""One oscillator of frequency 1 rad/s with plain numbers: a million steps in a second or two."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

from msvalidate.springs.dynamics.scheme import Integrator, MotionState


class Oscillator:
    """The acceleration -x of plain numbers, which `implicit.ModeAcceleration` has for arrays."""

    linear = True

    def __call__(self, x: float) -> float:
        """Acceleration (m/s²)."""
        return -x

    def solve(self, _x: float, residual: float, p: float, q: float, *, fresh: bool) -> float:  # noqa: ARG002
        """The δ in m of (p + q)·δ = residual."""
        return residual / (p + q)


def states(scheme: Integrator, h: float, damping: float = 0.0) -> Iterator[tuple[float, float]]:
    """Position and velocity at the same moment, step by step, from rest at 1; steps of `h` (s).

    The velocity of a staggered scheme starts half a step earlier, and is shown as the mean of the
    two around the moment.
    """
    acceleration = Oscillator()
    now = MotionState(1.0, 0.5 * h if scheme.staggered else 0.0, -1.0)  # type: ignore[arg-type]
    step = scheme.step
    while True:
        after = step(acceleration, now, h, damping)  # type: ignore[arg-type]
        yield now.x, 0.5 * (now.v + after.v) if scheme.staggered else now.v  # type: ignore[misc]
        now = after


def swing(scheme: Integrator, steps: int, angle: float, ratio: float = 0.0) -> float:
    """Position after `angle` (rad), in so many steps, at a damping ratio."""
    x, _ = next(islice(states(scheme, angle / steps, 2 * ratio), steps, None))
    return float(x)
