"""Number of relaxation steps to a displacement error, predicted and counted."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress

from scipy.optimize import brentq

from msvalidate.problem import Array, SolverError
from msvalidate.springs.dynamics.relax import relax
from msvalidate.springs.dynamics.run import Method, Run
from msvalidate.springs.dynamics.step_limits import SAFETY
from msvalidate.springs.network import Network

THRESHOLDS = (1e-3, 1e-6)
"""Errors that are counted to, relative to the largest displacement."""
TIGHT = min(THRESHOLDS)
AT_REST = 1e-13
"""Tolerance of a run, far below what the thresholds need: they end it."""
LOOKS = 100
"""Number of checks before the first threshold, for a count accurate to about 1 %."""
BUDGET = 50
"""Ratio of actual to predicted steps after which a run has failed."""


def predict_steps(root_kappa: float, threshold: float) -> int:
    """Steps after which the slowest mode, critically damped, is left with `threshold`.

    x(t) = (1 + ωt) exp(-ωt) from rest, and ω dt = 2·SAFETY/√κ.
    """
    s = float(brentq(lambda s: math.log1p(s) - s - math.log(threshold), 0.0, 100.0))
    return math.ceil(s * root_kappa / (2 * SAFETY))


def count_steps(
    method: Method,
    network: Network,
    frequencies: tuple[float, float],
    error: Callable[[Array], float],
    thresholds: tuple[float, ...] = THRESHOLDS,
) -> dict[float, tuple[int, int]]:
    """Count steps and force evaluations until the error is below each threshold.

    `frequencies` are the lowest and the highest (rad/s), `error` is that of displacements (n, d).
    `thresholds` are errors that `error` is compared with.
    """
    root_kappa = frequencies[1] / frequencies[0]
    reached: dict[float, tuple[int, int]] = {}

    def watch(run: Run) -> bool:
        now = error(run.displacement)
        for threshold in thresholds:
            if now <= threshold:
                reached.setdefault(threshold, (run.steps, run.evaluations))
        return len(reached) == len(thresholds)

    stride = max(1, predict_steps(root_kappa, max(thresholds)) // LOOKS)
    with suppress(SolverError):  # what was not reached is told as such
        relax(
            network,
            method,
            tolerance=AT_REST,
            max_steps=BUDGET * predict_steps(root_kappa, min(thresholds)),
            watch=watch,
            look_every=1 if method.look_every == 1 else stride,
            frequencies=frequencies,
        )
    return reached
