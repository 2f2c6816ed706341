"""A run to rest: what a relaxation moves, and what comes of it.

`state` is where the network is, `convergence` when it is at rest, `monitor` what is seen of it.
"""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np

from msvalidate.dynamics.convergence import ConvergenceTest
from msvalidate.dynamics.divergence import SPECTRUM_ERROR
from msvalidate.dynamics.spectrum import extreme_frequencies
from msvalidate.dynamics.state import State
from msvalidate.linear_algebra.multigrid import Cycle
from msvalidate.network import Configuration, Network
from msvalidate.network.inverse import Solver
from msvalidate.network.multigrid import make_cycle, restrained_tangent
from msvalidate.problem import Array, SolverError
from msvalidate.problem.records import dataclass, replace
from msvalidate.statics.equilibrium import Equilibrium
from msvalidate.statics.tangents import refuse_mechanism

LOOK_EVERY = 20
"""Steps between two looks at residual and energy, at the least."""
LOOK_AFTER = 0.2
"""Steps between two looks over √κ, the ratio of the highest frequency to the lowest: critically
damped motion needs ½√κ·ln(1/tolerance) steps, so that looks come every few per cent of the way. A
look sums forces and energies of all springs, as long as ten steps take on a uniform lattice."""
PATIENCE = 20
"""Multiple of the predicted number of steps after which a run is given up."""
MOST_STEPS = 10**9
"""Predicted steps, patience included, that nobody would wait for."""
SLOWEST = 1e-7
"""Of the highest frequency: below it a lowest one may be the rounding of none at all."""


@dataclass(frozen=True, eq=False)
class Relaxation:
    """A run that came to rest, or that its watcher ended.

    Parameters
    ----------
    equilibrium
        Where it rests; its iterations are the steps taken. Its error is infinite where the watcher
        ended the run.
    dt, damping, stability_limit
        Largest time step (s), largest damping rate (1/s), and the largest stable step (s) at rest;
        0, 0 and infinite where a method has none, or changes it as it goes.
    history
        (looks, 3): step, residual force (N), kinetic energy (J), which by a staggered velocity is
        that of half a step before.
    evaluations
        Times that the method computed the forces of all springs, or their curvature along a
        direction; a cycle of multigrid, though several products, counts as one, and a factor as
        none. Those of the looks are not counted.
    seconds
        Wall-clock time of the steps and looks, without what prepares them and what judges the end.
    """

    equilibrium: Equilibrium
    dt: float
    damping: float
    stability_limit: float
    history: Array
    evaluations: int
    seconds: float

    @property
    def steps(self) -> int:
        """Steps taken: time steps, or iterations of a method without time."""
        return self.equilibrium.iterations


class Run(State):
    """What a method moves: the state of a network, and what the method and its judges agree on.

    A method changes `displacement` and `velocity` (n, d) in place, tells `moved` of it, and asks
    `balance` for forces. Before its first `yield` it may set `dt`, `rate` and `limit`, in seconds,
    that messages name; `inertia` (n, d), if its masses are not the network's; and
    `most_steps`, after how many it has failed, if frequencies do not say so; and `look_every`, if
    it knows how long its way is. It may leave `cycle`, a multigrid cycle of a tangent, for the
    judge of stability. It may take `block` steps before the next look, which is at step `until`.
    `test` is the convergence test.
    """

    def __init__(
        self,
        network: Network,
        title: str,
        tolerance: float,
        frequencies: tuple[float, float] | None = None,
        start: Array | None = None,
    ) -> None:
        super().__init__(network, np.zeros(network.points.shape) if start is None else start)
        self.title, self.tolerance = title, tolerance
        self.test = ConvergenceTest(self, tolerance)
        self.dt, self.rate, self.limit = 0.0, np.zeros(1), math.inf
        self.most_steps = self._critically_damped
        self.look_every, self.until = 0, 0
        self.cycle: Cycle | None = None
        self._given = frequencies

    @cached_property
    def frequencies(self) -> tuple[float, float]:
        """Lowest and highest natural frequency (rad/s) at the reference points."""
        if self._given is not None:
            return self._given
        network = self.network
        if not Solver(network).is_direct:
            at = Configuration(network)
            self.cycle = make_cycle(restrained_tangent(at), at)
        try:
            lowest, highest = extreme_frequencies(
                network, tolerance=SPECTRUM_ERROR, cycle=self.cycle
            )
        except SolverError:
            self._refuse_mechanism(0.0)
            raise
        if lowest <= SLOWEST * highest:  # a mechanism, or masses far apart
            self._refuse_mechanism(lowest)
        return lowest, highest

    def _refuse_mechanism(self, lowest: float) -> None:
        try:
            refuse_mechanism(self.network)
        except SolverError as error:
            raise SolverError(
                f"{self.title}: lowest frequency {lowest:g} rad/s: the network is a mechanism "
                "and never comes to rest; add springs or supports"
            ) from error

    def _critically_damped(self) -> int:
        """Steps in which critical damping brings the slowest mode to rest: ½√κ·ln(1/tolerance)."""
        lowest, highest = self.frequencies
        needed = -0.5 * highest / max(lowest, 1e-300) * math.log(min(self.tolerance, 0.5))
        if PATIENCE * needed > MOST_STEPS:
            raise SolverError(
                f"{self.title}: natural frequencies from {lowest:.3g} to {highest:.3g} rad/s: the "
                f"slowest mode takes more than {MOST_STEPS / PATIENCE:.2g} steps; bring masses or "
                "stiffnesses closer together, take Newton's method, or set max_steps"
            )
        return step_limit(needed)

    def look_seldom(self) -> None:
        """Look every few per cent of the way that the slowest mode has to rest."""
        lowest, highest = self.frequencies
        self.look_every = int(min(LOOK_AFTER * highest / max(lowest, 1e-300), MOST_STEPS))

    @property
    def block(self) -> int:
        """Steps that a method may take before the next look."""
        return self.until - self.steps

    @property
    def time_step(self) -> str:
        """Its time step beside the limit, in words; nothing where a method has none."""
        if not self.dt:
            return ""
        return (
            f"time step {self.dt:.4g} s, stability limit {self.limit:.4g} s at damping "
            f"{self.rate.max():.4g} 1/s; "
        )


def join_runs(runs: list[Relaxation]) -> Relaxation:
    """Several runs in sequence as one: the final state of the last, the work of all."""
    last = runs[-1]
    if len(runs) == 1:
        return last
    before = np.cumsum([0, *(run.steps for run in runs)])
    looks = []
    for run, steps in zip(runs, before, strict=False):
        shifted = np.array(run.history)
        shifted[:, 0] += steps
        looks.append(shifted)
    return replace(
        last,
        equilibrium=replace(last.equilibrium, iterations=int(before[-1])),
        history=np.concatenate(looks),
        evaluations=sum(run.evaluations for run in runs),
        seconds=sum(run.seconds for run in runs),
    )


def step_limit(needed: float) -> int:
    """Number of steps after which a run that should need `needed` steps counts as failed."""
    return PATIENCE * max(LOOK_EVERY, math.ceil(needed))
