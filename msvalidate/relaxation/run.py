"""A run to rest: what a relaxation moves, what is seen of it, and when it is at rest."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from msvalidate import kernels
from msvalidate.dynamics.integrate import SPECTRUM_ERROR
from msvalidate.dynamics.spectrum import extreme_frequencies
from msvalidate.network import Network
from msvalidate.network.laws.volumes import stiffness_met
from msvalidate.network.residual import force_roundoff, force_scale
from msvalidate.problem import Array, SolverError
from msvalidate.statics.equilibrium import Equilibrium, at_rest
from msvalidate.statics.imposing import imposed
from msvalidate.statics.tangents import refuse_mechanism
from msvalidate.tangent.inverse import Solver
from msvalidate.tangent.multigrid import Cycle, cycle_of, restrained

SAFETY = 0.9
"""Part of the stability limit used: the tangent stiffens a little as the network deforms."""
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
DIVERGED = 1e3
"""Displacement, in sizes of the body, that no equilibrium of interest has."""
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


class Run:
    """What a method moves: displacement, velocity, and the counts of its work.

    A method changes `displacement` and `velocity` (n, d) in place, tells `moved` of it, and asks
    `balance` for forces. Before its first `yield` it may set `dt`, `rate` and `limit`, in seconds,
    that messages name; `inertia` (n, d), if its masses are not the network's; and
    `most_steps`, after how many it has failed, if frequencies do not say so; and `look_every`, if
    it knows how long its way is. It may leave `cycle`, a multigrid cycle of a tangent, for the
    judge of stability. `begun` (n, d) is the displacement before what is held was moved.
    """

    def __init__(
        self,
        network: Network,
        title: str,
        tolerance: float,
        frequencies: tuple[float, float] | None = None,
        start: Array | None = None,
    ) -> None:
        self.network, self.title, self.tolerance = network, title, tolerance
        self._given = frequencies
        self.begun = np.zeros(network.points.shape) if start is None else start
        self.displacement = imposed(network, self.begun)
        self.velocity = np.zeros_like(self.displacement)
        self.inertia = np.repeat(network.mass[:, None], network.dim, axis=1)
        self.dt, self.rate, self.limit = 0.0, np.zeros(1), math.inf
        self.steps, self.evaluations, self.until = 0, 0, 0
        self.most_steps = self._critically_damped
        self.look_every = 0
        self.cycle: Cycle | None = None
        self.stored = 0.0
        self._force = np.empty_like(self.displacement)
        self._known = False
        self._held = np.flatnonzero(network.held)
        self._at_lengths = 4 * force_roundoff(network, 0.0)
        self._per_metre = 4 * force_roundoff(network, 1.0) - self._at_lengths
        # A lattice is stepped as if springs that lead the same way were the same: in the network
        # each component of their vectors, and their lengths, may differ by 4 roundings of the
        # largest coordinate.
        self._apart = np.zeros_like(self._at_lengths)
        if self.motion.path == "lattice":
            self._apart = 4 * (1 + math.sqrt(network.dim)) * force_roundoff(network)
        self._softest = float(network.stiffness[network.stiffness > 0].min(initial=np.inf))
        self._stiffest, self._loaded = _stiffest(network), float(np.abs(network.force).max())
        self._floor = self._at_lengths
        self._met = math.inf, self.displacement
        self._reach = DIVERGED * max(float(np.ptp(x)) for x in network.points.T)

    @cached_property
    def motion(self) -> kernels.Motion:
        """What advances displacement and velocity, and knows the forces."""
        return kernels.Motion(self.network)

    @cached_property
    def frequencies(self) -> tuple[float, float]:
        """Lowest and highest natural frequency (rad/s) at the reference points."""
        if self._given is not None:
            return self._given
        network = self.network
        if not Solver(network).is_direct:
            self.cycle = cycle_of(restrained(network, network.points), network, network.points)
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
        return patiently(needed)

    @property
    def position(self) -> Array:
        """(n, d) in m."""
        return self.network.points + self.displacement

    def look_seldom(self) -> None:
        """Look every few per cent of the way that the slowest mode has to rest."""
        lowest, highest = self.frequencies
        self.look_every = int(min(LOOK_AFTER * highest / max(lowest, 1e-300), MOST_STEPS))

    @property
    def block(self) -> int:
        """Steps that a method may take before the next look."""
        return self.until - self.steps

    def moved(self, steps: int = 0, evaluations: int = 0) -> None:
        """Say that the displacement has changed; count its steps and the evaluations they need."""
        self.steps += steps
        self.evaluations += evaluations
        self._known = False

    def balance(self) -> Array:
        """Out-of-balance force (n, d) in N at the present displacement, 0 where it is held."""
        if not self._known:
            self.stored = self.motion.force_and_energy(self.displacement, self._force)
            self._force += self.network.force
            self._force.ravel()[self._held] = 0.0
            self._known = True
        return self._force

    def look(self) -> tuple[int, float, float]:
        """Step, residual force (N) and kinetic energy (J); raises if the run has diverged."""
        residual = largest(self.balance())
        kinetic = 0.5 * float(np.vdot(self.inertia * self.velocity, self.velocity))
        moved = largest(self.displacement)
        self._floor = self._at_lengths + moved * self._per_metre
        if not (math.isfinite(residual) and math.isfinite(kinetic) and moved < self._reach):
            raise SolverError(self._diverged)
        return self.steps, residual, kinetic

    def resting(self, look: tuple[int, float, float]) -> bool:
        """Whether residual and kinetic energy are both below what the tolerance asks for.

        A lattice may also be so as it is stepped, and as the network is but for what the two are
        apart. Bounds of the forces that meet at a point are asked first: to sum them takes as long
        as many steps.
        """
        rounding = self.rounding
        still = max(self.tolerance**2 * self.stored, rounding / self._softest * rounding)
        if look[2] > still:  # the usual case, and the cheapest question
            return False
        rounding += largest(self._apart)
        # Forces that meet at a point add up to √(2·energy·Σk) at most, by Cauchy and Schwarz.
        bound = math.sqrt(2 * self.stored * self._stiffest) if self._stiffest else math.inf
        if look[1] > max(self.tolerance * (bound + 2 * self._loaded), rounding):
            return False
        if look[1] > max(self.tolerance * self._most_met(), rounding):
            return False
        held = self.network.held
        if (self.displacement[held] != self.network.displacement[held]).any():
            return False
        small = np.maximum(self.tolerance * self.force_met(), self._floor)
        excess = np.abs(self.balance()) - small
        if not (excess <= self._apart).all():
            return False
        if (excess > 0).any():  # as the network is
            excess = np.abs(self.motion.balance(self.displacement)) - small
        return bool((excess <= 0).all())

    def force_met(self) -> float:
        """Largest sum of force magnitudes (N) that meet at a free point now."""
        self._met = force_scale(self.network, self.position), self.displacement.copy()
        return self._met[0]

    def _most_met(self) -> float:
        """What that sum (N) cannot exceed: a spring's force changes by k times its ends' moves.

        Where cells stand beside springs they stiffen as they are deformed; rest is then seen a few
        looks later, never too early.
        """
        met, there = self._met
        if not self._stiffest or not math.isfinite(met):
            return math.inf
        return met + 2 * self._stiffest * largest(self.displacement - there)

    def result(self, looks: list[tuple[int, float, float]], seconds: float) -> Relaxation:
        """The run as it is now."""
        return Relaxation(
            equilibrium=at_rest(self.network, self.displacement.copy(), self.steps, error=math.inf),
            dt=self.dt,
            damping=float(self.rate.max()),
            stability_limit=self.limit,
            history=np.array(looks),
            evaluations=self.evaluations,
            seconds=seconds,
        )

    def unfinished(self, look: tuple[int, float, float]) -> str:
        """What to say of a run that has used up its steps."""
        return (
            f"{self.title} is not at rest after {self.steps} steps: {self.time_step}residual "
            f"{look[1]:.3g} N, kinetic energy {look[2]:.3g} J; "
            + (
                "take a smaller dt or leave it out"
                if self.dt > self.limit
                else "raise max_steps, leave damping to its default, or loosen tolerance"
                if self.rate.any()
                else "raise max_steps or loosen tolerance"
            )
        )

    @property
    def _diverged(self) -> str:
        remedy = "the network stiffens or collapses under this load: reduce dt or the load"
        if self.dt > self.limit:
            remedy = "take a smaller dt or leave it out"
        elif not self.dt:
            remedy = "the network collapses under this load: reduce it"
        return f"{self.title} diverged by step {self.steps}: {self.time_step}{remedy}"

    @property
    def rounding(self) -> float:
        """Largest force (N) on a point that is rounding, as of the last look."""
        return float(self._floor.max())

    @property
    def time_step(self) -> str:
        """Its time step beside the limit, in words; nothing where a method has none."""
        if not self.dt:
            return ""
        return (
            f"time step {self.dt:.4g} s, stability limit {self.limit:.4g} s at damping "
            f"{self.rate.max():.4g} 1/s; "
        )

    def show(self, bar: Any, looks: list[tuple[int, float, float]]) -> None:
        """Show how far it is on the way to rest, in logarithms of the residual."""
        largest = looks[0][1]
        if not largest:
            return
        scale = self._met[0] if math.isfinite(self._met[0]) else self.force_met()
        target = max(self.tolerance * scale, self.rounding)
        way = math.log(largest / max(looks[-1][1], target)) / math.log(max(largest / target, 2))
        bar.n = max(bar.n, min(way, 1.0))
        bar.set_postfix(step=looks[-1][0], residual=f"{looks[-1][1]:.2g} N", refresh=False)
        bar.update(0)


def together(runs: list[Relaxation]) -> Relaxation:
    """Runs one after the other as one: where the last rests, and the work of all."""
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


def largest(values: Array) -> float:
    """Largest magnitude, NaN if there is one, without an array of magnitudes."""
    return float(max(values.max(), -values.min())) if values.size else 0.0


def _stiffest(network: Network) -> float:
    """Largest stiffness (N/m) that meets at a point; 0 where cells may give energy back.

    Energies of both signs bound no force.
    """
    k = np.repeat(network.stiffness, 2)
    met = 1.0 * np.bincount(network.springs.ravel(), k, len(network.points))
    if network.volumes is not None:
        if network.volumes.stiffness.min() < 0:
            return 0.0
        met = met + stiffness_met(network.volumes)
    return float(met.max())


def patiently(needed: float) -> int:
    """Steps after which a run that should need so many has failed."""
    return PATIENCE * max(LOOK_EVERY, math.ceil(needed))
