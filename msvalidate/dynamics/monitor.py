"""What is seen of a relaxation: its history, whether it diverges, and how far it has come."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from tqdm import tqdm

from msvalidate.dynamics.run import Relaxation, Run
from msvalidate.linear_algebra.norms import max_abs
from msvalidate.problem import SolverError
from msvalidate.statics.equilibrium import equilibrium_at

DIVERGED = 1e3
"""Displacement, in sizes of the body, that no equilibrium of interest has."""


class HistoryRow(NamedTuple):
    """Step, residual force (N) and kinetic energy (J) of a run at one moment."""

    step: int
    residual: float
    kinetic: float


class Monitor:
    """Watches a run, which is not changed; `history` has all rows so far, the first of no step."""

    def __init__(self, run: Run) -> None:
        self.run = run
        self.history: list[HistoryRow] = []
        self._reach = DIVERGED * max(float(np.ptp(x)) for x in run.network.points.T)

    def record(self) -> HistoryRow:
        """Add the run as it is now to the history; raise `SolverError` if it has diverged."""
        run = self.run
        seen = HistoryRow(run.steps, max_abs(run.balance()), run.kinetic)
        near = max_abs(run.displacement) < self._reach
        if not (math.isfinite(seen.residual) and math.isfinite(seen.kinetic) and near):
            raise SolverError(self._diverged)
        self.history.append(seen)
        return seen

    @property
    def _diverged(self) -> str:
        run = self.run
        remedy = "the network stiffens or collapses under this load: reduce dt or the load"
        if run.dt > run.limit:
            remedy = "take a smaller dt or leave it out"
        elif not run.dt:
            remedy = "the network collapses under this load: reduce it"
        return f"{run.title} diverged by step {run.steps}: {run.time_step}{remedy}"

    @property
    def unfinished(self) -> str:
        """What to say of a run that has used up its steps."""
        run, last = self.run, self.history[-1]
        return (
            f"{run.title} is not at rest after {run.steps} steps: {run.time_step}residual "
            f"{last.residual:.3g} N, kinetic energy {last.kinetic:.3g} J; "
            + (
                "take a smaller dt or leave it out"
                if run.dt > run.limit
                else "raise max_steps, leave damping to its default, or loosen tolerance"
                if run.rate.any()
                else "raise max_steps or loosen tolerance"
            )
        )

    def result(self, seconds: float) -> Relaxation:
        """The run as it is now, and its history."""
        run = self.run
        return Relaxation(
            equilibrium=equilibrium_at(
                run.network, run.displacement.copy(), run.steps, error=math.inf
            ),
            dt=run.dt,
            damping=float(run.rate.max()),
            stability_limit=run.limit,
            history=np.array(self.history, dtype=float).reshape(-1, len(HistoryRow._fields)),
            evaluations=run.evaluations,
            seconds=seconds,
        )

    def show(self, bar: tqdm[None]) -> None:
        """Show how far it is on the way to rest, in logarithms of the residual."""
        first, last = self.history[0].residual, self.history[-1]
        if not first:
            return
        target = self.run.test.target()
        way = math.log(first / max(last.residual, target)) / math.log(max(first / target, 2))
        bar.n = max(bar.n, min(way, 1.0))
        bar.set_postfix(step=last.step, residual=f"{last.residual:.2g} N", refresh=False)
        bar.update(0)
