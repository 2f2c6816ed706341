"""Floor 2: relaxation: the rest position found by letting the network move; when a run is at rest.

A method is a generator that moves a `Run` step by step; `relax` looks at the run now and then, ends
it at rest, and refuses one that diverges or does not arrive. Methods are in `viscous`, the report's
Algorithm 1 among them, and in `relaxations`.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from tqdm import tqdm

from msvalidate import kernels
from msvalidate.equilibrium import Equilibrium, at_rest, is_stable, refuse_mechanism
from msvalidate.integrate import SPECTRUM_ERROR
from msvalidate.linear import is_factored
from msvalidate.multigrid import Cycle, cycle_of, restrained
from msvalidate.network import Network, force_roundoff, force_scale
from msvalidate.problem import (
    Array,
    ProblemError,
    SolverError,
    finite,
    instance,
    positive,
    refuse_free_motions,
    shown,
    whole,
)
from msvalidate.spectrum import extreme_frequencies
from msvalidate.volumes import stiffness_met

SAFETY = 0.9
"""Part of the stability limit used: the tangent stiffens a little as the network deforms."""
LOOK_EVERY = 20
"""Steps between two looks at residual and energy: for all but the smallest networks the looks then
cost less than the steps."""
PATIENCE = 20
"""Multiple of the predicted number of steps after which a run is given up."""
MOST_STEPS = 10**9
"""Predicted steps, patience included, that nobody would wait for."""
LOOSEST = 0.01
"""Largest tolerance: above it a start under full load would soon count as rest."""
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
        Where it rests; its iterations are the steps taken.
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
    `most_steps`, after how many it has failed, if frequencies do not say so. It may leave `cycle`,
    a multigrid cycle of a tangent, for the judge of stability.
    """

    def __init__(
        self,
        network: Network,
        title: str,
        tolerance: float,
        frequencies: tuple[float, float] | None = None,
    ) -> None:
        self.network, self.title, self.tolerance = network, title, tolerance
        self._given = frequencies
        self.displacement = np.array(network.displacement)
        self.velocity = np.zeros_like(self.displacement)
        self.inertia = np.repeat(network.mass[:, None], network.dim, axis=1)
        self.dt, self.rate, self.limit = 0.0, np.zeros(1), math.inf
        self.steps, self.evaluations, self.until = 0, 0, 0
        self.most_steps = self._critically_damped
        self.cycle: Cycle | None = None
        self.stored = 0.0
        self._force = np.empty_like(self.displacement)
        self._known = False
        self._held = np.flatnonzero(network.held)
        self._at_lengths = 4 * force_roundoff(network, 0.0)
        self._per_metre = 4 * force_roundoff(network, 1.0) - self._at_lengths
        self._softest = float(network.stiffness[network.stiffness > 0].min(initial=np.inf))
        self._stiffest, self._loaded = _stiffest(network), float(np.abs(network.force).max())
        self._floor = self._at_lengths
        self._met = math.inf, self.displacement
        self._reach = DIVERGED * float(np.ptp(network.points, axis=0).max())

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
        if not is_factored(~network.held):
            self.cycle = cycle_of(restrained(network, network.points), network, network.points)
        lowest, highest = extreme_frequencies(network, tolerance=SPECTRUM_ERROR, cycle=self.cycle)
        if lowest <= SLOWEST * highest:  # a mechanism, or masses far apart
            try:
                refuse_mechanism(network)
            except SolverError as error:
                raise SolverError(
                    f"{self.title}: lowest frequency {lowest:g} rad/s: the network is a mechanism "
                    "and never comes to rest; add springs or supports"
                ) from error
        return lowest, highest

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

        Bounds of the forces that meet at a point are asked first: to sum them takes as long as many
        steps.
        """
        rounding = self.rounding
        still = max(self.tolerance**2 * self.stored, rounding / self._softest * rounding)
        if look[2] > still:  # the usual case, and the cheapest question
            return False
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
        return bool((np.abs(self.balance()) <= small).all())

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
            equilibrium=at_rest(self.network, self.position, self.steps),
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


Watch = Callable[[Run], bool]
"""Shown the run at every look; True ends it there. It must not change the run."""


@dataclass(frozen=True)
class Method:
    """A way to rest.

    Parameters
    ----------
    name, title
        Its name in tables, and in sentences.
    source
        The paper that it and its parameters come from.
    walk
        Moves a run for ever, from one `yield` to the next, each where a look may be taken: the
        first before any step, the others at most `Run.block` steps on.
    look_every
        Steps between two looks.
    """

    name: str
    title: str
    source: str
    walk: Callable[[Run], Iterator[None]]
    look_every: int = LOOK_EVERY


def relax(
    network: Network,
    method: Method,
    *,
    tolerance: float = 1e-10,
    max_steps: int | None = None,
    watch: Watch | None = None,
    look_every: int | None = None,
    frequencies: tuple[float, float] | None = None,
) -> Relaxation:
    """Bring a network to rest by any method.

    It starts at rest, with the prescribed displacements imposed at once; Newton's method imposes
    them with its first steps.

    Parameters
    ----------
    network
        Its supports must hold every rigid motion.
    method
        One of `relaxations.RELAXATIONS`.
    tolerance
        The run ends when the largest residual force is below `tolerance` times the forces that
        meet at a point, and the kinetic energy below `tolerance`² times the energy stored in the
        springs; neither is asked to fall below rounding.
    max_steps
        By default 20 times what the slowest mode is predicted to need; a number of their own where
        methods ask for no frequencies.
    watch
        Shown every look; it may end the run before rest.
    look_every
        Steps between two looks; by default the method's own.
    frequencies
        Lowest and highest natural frequency (rad/s), where they are known; else they are solved for
        if the method asks for them.

    Raises
    ------
    ProblemError
        If an argument is out of range or a rigid motion is free.
    SolverError
        If the run diverges, is not at rest within `max_steps`, or rests where it is unstable.
    """
    instance("network", network, Network)
    instance("method", method, Method)
    if positive("tolerance", tolerance) > LOOSEST:
        raise ProblemError(f"tolerance: {tolerance}; above {LOOSEST} any start would count as rest")
    if max_steps is not None:
        whole("max_steps", max_steps, 1)
    stride = whole("look_every", method.look_every if look_every is None else look_every, 1)
    refuse_free_motions("network", network.points, network.held)
    if not (watch is None or callable(watch)):
        raise ProblemError(f"watch: {shown(watch)}; give a function of the run, or None")
    run = Run(network, method.title, tolerance, _known(frequencies))
    if network.held.all():
        return run.result([], 0.0)
    with np.errstate(over="ignore", invalid="ignore"):  # a diverged run is refused as such
        found, at_ease = _walked(run, method, (max_steps, stride), watch)
    if at_ease and not is_stable(network, found.equilibrium.position, run.cycle):
        raise SolverError(
            f"{method.title} came to rest after {found.steps} steps where the network is unstable "
            "(some motion from there meets no stiffness, or less); disturb the symmetry or reduce "
            "the load"
        )
    return found


def _known(frequencies: tuple[float, float] | None) -> tuple[float, float] | None:
    """Frequencies that a caller gives, checked."""
    if frequencies is None:
        return None
    given = finite("natural frequencies", frequencies)
    if given.shape != (2,) or not 0 < given[0] <= given[1]:
        raise ProblemError(
            f"natural frequencies: {shown(frequencies)}; give the lowest and the highest in rad/s, "
            "above zero"
        )
    return float(given[0]), float(given[1])


def patiently(needed: float) -> int:
    """Steps after which a run that should need so many has failed."""
    return PATIENCE * max(LOOK_EVERY, math.ceil(needed))


def _walked(
    run: Run, method: Method, steps: tuple[int | None, int], watch: Watch | None
) -> tuple[Relaxation, bool]:
    """The run at its end, and whether that is rest."""
    given, look_every = steps
    walk = method.walk(run)
    next(walk)  # prepares
    allowed = given or run.most_steps()
    started = time.perf_counter()
    looks = [run.look()]
    with tqdm(
        total=1.0,
        desc=method.title,
        delay=1.0,
        disable=None,
        leave=False,
        bar_format="{desc}: {percentage:3.0f}% of the way to rest{postfix} [{elapsed}]",
    ) as bar:
        while True:
            at_ease = run.resting(looks[-1])
            enough = watch is not None and watch(run)
            if at_ease or enough:
                return run.result(looks, time.perf_counter() - started), at_ease
            if run.steps >= allowed:
                raise SolverError(run.unfinished(looks[-1]))
            run.until = min(run.steps + look_every, allowed)
            while run.block > 0:
                next(walk)
            looks.append(run.look())
            if not bar.disable:
                run.show(bar, looks)
