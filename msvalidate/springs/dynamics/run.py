"""State, convergence test and result of a relaxation run."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from functools import cached_property

import numpy as np

from msvalidate.linear_algebra.multigrid import Cycle
from msvalidate.linear_algebra.norms import max_abs
from msvalidate.problem import Array, SolverError
from msvalidate.problem.records import dataclass, field, replace
from msvalidate.springs import kernels
from msvalidate.springs.dynamics.divergence import SPECTRUM_ERROR
from msvalidate.springs.dynamics.spectrum import extreme_frequencies
from msvalidate.springs.network import Configuration, Network
from msvalidate.springs.network.inverse import Solver
from msvalidate.springs.network.laws.linear import LINEAR
from msvalidate.springs.network.laws.quadratic import QUADRATIC
from msvalidate.springs.network.laws.volumes import stiffness_magnitudes
from msvalidate.springs.network.multigrid import make_cycle, restrained_tangent
from msvalidate.springs.network.residual import force_scale
from msvalidate.springs.statics.equilibrium import Equilibrium
from msvalidate.springs.statics.supports import impose_supports
from msvalidate.springs.statics.tangents import refuse_mechanism

LOOK_EVERY = 20
"""Steps between two looks at residual and energy, at the least."""
LOOK_AFTER = 0.2
"""Number of steps between two checks, relative to √κ.

κ is the squared ratio of the highest frequency to the lowest. Critically damped motion needs
½√κ·ln(1/tolerance) steps, so that a check comes every few per cent of the run. A check sums forces
and energies of all springs and takes as long as ten steps on a uniform lattice.
"""
PATIENCE = 20
"""Multiple of the predicted number of steps after which a run is given up."""
MOST_STEPS = 10**9
"""Predicted steps, patience included, that nobody would wait for."""
DIVERGED = 1e3
"""Displacement, in sizes of the body, that no equilibrium of interest has."""
MAX_FRAMES, MAX_FRAME_POINTS = 100, 20_000
"""Maximum number of stored displacements, and of points of their network.

They need at most 48 MB; an animation of more points shows no springs.
"""
SLOWEST = 1e-7
"""Relative frequency below which the lowest one may be rounding of zero."""


@dataclass(frozen=True, eq=False)
class Relaxation:
    """Result of a relaxation that converged, or that its `watch` ended.

    Parameters
    ----------
    equilibrium
        Final state; its iterations are the number of steps. Its error is infinite if `watch` ended
        the run.
    dt, damping, stability_limit
        Largest time step (s), largest damping rate (1/s) and stability limit (s) at equilibrium; 0,
        0 and infinite for a method without them, or one that adapts them.
    history
        Step, residual force (N) and kinetic energy (J) at every check, shape (checks, 3). For a
        staggered scheme the kinetic energy is that of half a step earlier.
    evaluations
        Number of evaluations of all spring forces, or of their curvature along a direction. A
        multigrid cycle counts as one, a factorisation as none; checks are not counted.
    seconds
        Wall-clock time of the steps and checks, without preparation and final tests.
    network
        Network that was relaxed.
    frames
        Step -> displacement (m), shape (n, d), at up to `MAX_FRAMES` of the checks; empty for
        networks with more than `MAX_FRAME_POINTS` points.
    """

    equilibrium: Equilibrium
    dt: float
    damping: float
    stability_limit: float
    history: Array
    evaluations: int
    seconds: float
    network: Network
    frames: Mapping[int, Array] = field(default_factory=dict)

    @property
    def displacement(self) -> Array:
        """Displacement (n, d) in m of the final state."""
        return self.equilibrium.displacement

    @property
    def steps(self) -> int:
        """Steps taken: time steps, or iterations of a method without time."""
        return self.equilibrium.iterations


class Run:
    """State of a relaxation, and the settings that methods and checks share.

    A method changes `displacement` and `velocity` in place, tells `moved` of it, and asks `balance`
    for forces. Before its first `yield` it may set `dt` (s), `rate` (1/s) and `limit` (s), that
    messages name; `inertia`; `most_steps`, after how many it has failed, if frequencies do not say
    so; and `look_every`, if it knows how long its way is. It may leave `cycle`, a multigrid cycle
    of a tangent, for the judge of stability. It may take `block` steps before the next look, which
    is at step `until`. `test` is the convergence test.

    Attributes
    ----------
    begun
        (n, d) displacement (m) before what is held was moved.
    displacement, velocity
        (n, d) in m and m/s.
    inertia
        (n, d) mass (kg) of each component, the network's own unless a method sets others.
    steps, evaluations
        Steps taken, and times that the forces of all springs were computed for them.
    stored
        Energy (J) of springs and cells, as of the last `balance`.
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
        self.begun = np.zeros(network.points.shape) if start is None else start
        self.displacement = impose_supports(network, self.begun)
        self.velocity = np.zeros_like(self.displacement)
        self.inertia = np.repeat(network.mass[:, None], network.dim, axis=1)
        self.steps, self.evaluations, self.stored = 0, 0, 0.0
        self.dt, self.rate, self.limit = 0.0, np.zeros(1), math.inf
        self.most_steps = self._critically_damped
        self.look_every, self.until = 0, 0
        self.cycle: Cycle | None = None
        self._applied = frequencies
        self._force = np.empty_like(self.displacement)
        self._known = False
        self.test = ConvergenceTest(self)

    @cached_property
    def motion(self) -> kernels.Motion:
        """Compiled loops that advance the run and compute its forces."""
        return kernels.Motion(self.network)

    @property
    def kinetic(self) -> float:
        """Kinetic energy (J)."""
        return 0.5 * float(np.vdot(self.inertia * self.velocity, self.velocity))

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
            self._force[self.network.fixed] = 0.0
            self._known = True
        return self._force

    @cached_property
    def frequencies(self) -> tuple[float, float]:
        """Lowest and highest natural frequency (rad/s) at the reference points.

        Frequencies that the caller gave are returned as they are. Raises `SolverError` if the
        network is a mechanism or unstable there.
        """
        if self._applied is not None:
            return self._applied
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
        """Time step and stability limit in words; empty without a time step."""
        if not self.dt:
            return ""
        return (
            f"time step {self.dt:.4g} s, stability limit {self.limit:.4g} s at damping "
            f"{self.rate.max():.4g} 1/s; "
        )


class ConvergenceTest:
    """Residual force and kinetic energy of a run against what its tolerance allows.

    The residual may be `tolerance` times the forces that meet at a point, the kinetic energy
    `tolerance`² times the energy stored; neither is asked to fall below rounding.

    A lattice may be at rest as it is stepped, and as the network is but for what the two are apart.
    """

    def __init__(self, run: Run) -> None:
        self.run, network = run, run.network
        self._at_lengths = 4 * network.rounding(0.0)
        self._per_metre = 4 * network.rounding(1.0) - self._at_lengths
        # A lattice is stepped as if springs that lead the same way were the same: in the network
        # each component of their vectors, and their lengths, may differ by 4 roundings of the
        # largest coordinate.
        self._misfit = np.zeros_like(self._at_lengths)
        if run.motion.path == "lattice":
            apart = network.rounding(max_abs(network.points))
            self._misfit = 4 * (1 + math.sqrt(network.dim)) * apart
        k = np.abs(network.axial_stiffness)
        self._softest = float(k[k > 0].min(initial=np.inf))
        self._stiffest = _largest_point_stiffness(network)
        self._residual_ok = math.inf, run.displacement

    def is_converged(self, residual: float, kinetic: float) -> bool:
        """Return True if the run has reached equilibrium.

        The arguments are the residual force (N) and the kinetic energy (J).

        A bound of the forces that meet at a point is asked first: to sum them takes as long as
        many steps.
        """
        run, rounding = self.run, self.rounding
        still = max(run.tolerance**2 * run.stored, rounding / self._softest * rounding)
        if kinetic > still:  # the usual case, and the cheapest question
            return False
        if residual > max(run.tolerance * self._all_converged(), rounding + max_abs(self._misfit)):
            return False
        held = run.network.fixed
        if (run.displacement[held] != run.network.displacement[held]).any():
            return False
        return self._balanced()

    def _balanced(self) -> bool:
        """Return True if every point is in balance, relative to the forces there."""
        run = self.run
        small = np.maximum(run.tolerance * self._force_converged(), self._floor)
        excess = np.abs(run.balance()) - small
        if not (excess <= self._misfit).all():
            return False
        if (excess > 0).any():  # as the network is
            excess = np.abs(run.motion.balance(run.displacement)) - small
        return bool((excess <= 0).all())

    @property
    def rounding(self) -> float:
        """Largest force (N) on a point that is rounding."""
        return float(self._floor.max())

    @property
    def _floor(self) -> Array:
        """Force (n, 1) in N due to rounding of positions and of displacements."""
        return np.asarray(self._at_lengths + max_abs(self.run.displacement) * self._per_metre)

    def allowed(self) -> float:
        """Residual force (N) that is small enough at the points where most forces meet, now."""
        return max(self.run.tolerance * self._force_converged(), self.rounding)

    def target(self) -> float:
        """Approximate `allowed` from the last sum of forces.

        It is accurate enough to choose the method's parameters.
        """
        met = self._residual_ok[0]
        known = math.isfinite(met)
        return max(self.run.tolerance * met, self.rounding) if known else self.allowed()

    def _force_converged(self) -> float:
        """Largest sum of force magnitudes (N) that meet at a free point now."""
        u = self.run.displacement.copy()
        self._residual_ok = force_scale(Configuration(self.run.network, u)), u
        return self._residual_ok[0]

    def _all_converged(self) -> float:
        """Upper bound (N) of the sum of forces at a point.

        A spring's force changes by k times the motion of its ends.

        Where cells stand beside springs they stiffen as they are deformed; rest is then seen a few
        looks later, never too early.
        """
        met, there = self._residual_ok
        if not self._stiffest or not math.isfinite(met):
            return math.inf
        return met + 2 * self._stiffest * max_abs(self.run.displacement - there)


def _largest_point_stiffness(network: Network) -> float:
    """Largest stiffness (N/m) that meets at a point; 0 where it may grow.

    Or where cells may give energy back: energies of both signs bound no force.
    """
    cells = network.volumes
    if network.law is not LINEAR or (
        cells and (cells.law is not QUADRATIC or cells.stiffness.min() < 0)
    ):
        return 0.0
    k = np.repeat(network.stiffness, 2)
    met = 1.0 * np.bincount(network.springs.ravel(), k, len(network.points))
    return float((met + network.of_cells(stiffness_magnitudes)).max())


def join_runs(runs: list[Relaxation]) -> Relaxation:
    """Combine consecutive runs: final state of the last, total work of all."""
    last = runs[-1]
    if len(runs) == 1:
        return last
    before = np.cumsum([0, *(run.steps for run in runs)])
    looks, frames = [], dict[int, Array]()
    for run, steps in zip(runs, before, strict=False):
        shifted = np.array(run.history)
        shifted[:, 0] += steps
        looks.append(shifted)
        frames |= {int(steps) + step: u for step, u in run.frames.items()}
    return replace(
        last,
        equilibrium=replace(last.equilibrium, iterations=int(before[-1])),
        history=np.concatenate(looks),
        evaluations=sum(run.evaluations for run in runs),
        seconds=sum(run.seconds for run in runs),
        frames=frames,
    )


def step_limit(needed: float) -> int:
    """Number of steps after which a run that should need `needed` steps counts as failed."""
    return PATIENCE * max(LOOK_EVERY, math.ceil(needed))


@dataclass(frozen=True)
class Method:
    """Relaxation method.

    Parameters
    ----------
    name, title
        Name in tables, and in sentences.
    walk
        Generator that moves a run without end and yields wherever a check may be made: first before
        any step, then after at most `Run.block` steps.
    look_every
        Minimum number of steps between two checks.
    """

    name: str
    title: str
    walk: Callable[[Run], Iterator[None]]
    look_every: int = LOOK_EVERY
