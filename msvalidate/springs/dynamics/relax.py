"""Relaxation: the rest position found by letting the network move.

A method is a generator that moves a `Run` step by step; `relax` looks at the run now and then, ends
it at rest, and refuses one that diverges or does not arrive. Methods are in `viscous`, the report's
Algorithm 1 among them, and in `relaxations`.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from msvalidate.linear_algebra.norms import max_abs
from msvalidate.problem import Array, ProblemError, SolverError, refuse_free_motions
from msvalidate.problem.checks import (
    choose_entry,
    finite,
    format_value,
    positive_number,
    require_type,
    whole_number,
)
from msvalidate.problem.progress import report_step
from msvalidate.springs.dynamics.integrate import damping_rate, refuse_obstacle
from msvalidate.springs.dynamics.integrators import EULER_CROMER
from msvalidate.springs.dynamics.relaxations import RELAXATIONS
from msvalidate.springs.dynamics.run import (
    DIVERGED,
    MAX_FRAME_POINTS,
    MAX_FRAMES,
    Method,
    Relaxation,
    Run,
    join_runs,
)
from msvalidate.springs.dynamics.viscous import ALGORITHM1, viscous
from msvalidate.springs.network import Configuration, Network
from msvalidate.springs.statics.equilibrium import (
    Equilibrium,
    equilibrium_at,
    refuse_folded,
    start_displacement,
)
from msvalidate.springs.statics.path import LoadPath, Path, load_path
from msvalidate.springs.statics.refinement import error_of_displacement
from msvalidate.springs.statics.tangents import is_stable

STOPOVER = 1e-4
"""Tolerance of equilibrium at intermediate stops of a path.

The residual is a ten-thousandth of the next load step.
"""
FEW_UNITS = 16.0
"""Units of rounding of positions, of which a displacement is no motion."""
BALANCED = 1e-6
"""Fraction of a load that prestress may leave out of balance."""
LOOSEST = 0.01
"""Largest tolerance: above it a start under full load would soon count as rest."""

Watch = Callable[[Run], bool]
"""Function of an unchanged run, called at every check; True ends the run."""


def relax(
    network: Network,
    method: Method | str,
    *,
    tolerance: float = 1e-10,
    max_steps: int | None = None,
    watch: Watch | None = None,
    look_every: int | None = None,
    frequencies: tuple[float, float] | None = None,
    path: Path | None = None,
    start: Equilibrium | Array | None = None,
    allow_folded: bool = False,
) -> Relaxation:
    """Find the static equilibrium of a network by dynamic relaxation or iteration.

    The run starts at zero velocity with the prescribed displacements imposed: on the fixed
    components only if they move little, otherwise also on the free points by interpolation.

    Parameters
    ----------
    network
        Network with n points in d dimensions, whose supports prevent every rigid-body motion.
    method
        Relaxation method, a record of `RELAXATIONS` or its name.
    tolerance
        Convergence criterion, 0 < tolerance <= 0.01. The residual force must fall below `tolerance`
        times the largest sum of force magnitudes at a point, and the kinetic energy below its
        square times the elastic energy; rounding is allowed for.
    max_steps
        Maximum number of steps, for each stage of a path. Default: 20 times the predicted number,
        or a limit of the method's own.
    watch
        Function of the run, called at every check; the run ends if it returns True.
    look_every
        Number of steps between two checks. Default: chosen by the method.
    frequencies
        Lowest and highest natural frequency (rad/s) if they are known.
    path
        Load path, as for `equilibrium`. Steps and seconds of all stages are added.
    start
        Equilibrium, or displacement (m) of shape (n, d), at which the run starts.
    allow_folded
        True to accept flat or inverted cells at the end.

    Returns
    -------
    Relaxation
        Its field `equilibrium` has the displacement (n, d) in m; ``steps``, ``evaluations``,
        ``seconds`` and ``history`` describe the run.

    Raises
    ------
    ProblemError
        If an argument is out of its range, or a rigid-body motion is free.
    SolverError
        If the run diverges, does not converge within `max_steps`, or converges to an unstable
        state, to folded cells or to a displacement whose error is as large as itself.

    Examples
    --------
    >>> from msvalidate import RELAXATIONS, Box, Isotropic, Problem, Support, Traction
    >>> from msvalidate import lattice_network, relax, square
    >>> box = Box((0.4, 0.1))
    >>> clamp = Support(box.side("left"), (0.0, 0.0))
    >>> pull = Traction(box.side("right"), (100.0, 0.0))
    >>> problem = Problem(box, Isotropic(E=1e5, nu=1 / 3), supports=(clamp,), loads=(pull,))
    >>> network = lattice_network(problem, square(box, (8, 2)))
    >>> result = relax(network, RELAXATIONS["fire"])
    >>> print(f"{result.equilibrium.displacement[:, 0].max():.3e} m")
    3.970e-04 m
    """
    require_type("network", network, Network)
    refuse_obstacle(network)
    method = choose_entry("method", method, Method, RELAXATIONS)
    _check_stopping(tolerance, max_steps, look_every, watch)
    require_type("allow_folded", allow_folded, bool)
    refuse_free_motions("network", network.points, network.fixed)
    begun = start_displacement(network, start)
    stages = [network] if path is None else _load_stages(load_path(network, path, begun))
    known, done = _check_frequencies(frequencies), []
    for stage in stages:
        loose = tolerance if stage is network else max(tolerance, STOPOVER)
        run = Run(stage, method.title, loose, known, begun)
        with np.errstate(over="ignore", invalid="ignore"):  # a diverged run is refused as such
            found, at_ease = _run_to_rest(run, method, (max_steps, look_every), watch)
        done.append(found)
        begun = found.equilibrium.displacement
        if not at_ease:  # ended by its watcher
            return join_runs(done)
    return _judge(join_runs(done), run, allow_folded=allow_folded)


def algorithm1(
    network: Network,
    *,
    dt: float | None = None,
    damping: ArrayLike | None = None,
    tolerance: float = 1e-10,
    max_steps: int | None = None,
) -> Relaxation:
    """Relax a network by Algorithm 1 of the report: Euler-Cromer with viscous damping.

    Source: [Report], section 4, Algorithm 1; Euler-Cromer (semi-implicit Euler) is that of
    [Cromer1981].

    Parameters
    ----------
    network
        Network with n points, whose supports prevent every rigid-body motion.
    dt
        Time step (s). Default: 0.9 of the stability limit. A longer step than the limit gives a
        warning.
    damping
        Rate (1/s) of mass-proportional damping, one number or shape (n,). Default: twice the lowest
        natural frequency, the critical damping of that mode.
    tolerance, max_steps
        Convergence criterion and maximum number of steps, as for `relax`.

    Returns
    -------
    Relaxation
        Its field `equilibrium` has the displacement (n, d) in m; `dt`, `damping` and ``steps``
        describe the run.

    Raises
    ------
    ProblemError
        If an argument is out of its range, or a rigid-body motion is free.
    SolverError
        If the run diverges or does not converge, as for `relax`.

    Examples
    --------
    >>> from msvalidate import Box, Isotropic, Problem, Support, Traction
    >>> from msvalidate import algorithm1, lattice_network, square
    >>> box = Box((0.4, 0.1))
    >>> clamp = Support(box.side("left"), (0.0, 0.0))
    >>> pull = Traction(box.side("right"), (100.0, 0.0))
    >>> problem = Problem(box, Isotropic(E=1e5, nu=1 / 3), supports=(clamp,), loads=(pull,))
    >>> network = lattice_network(problem, square(box, (8, 2)))
    >>> result = algorithm1(network)
    >>> result.steps > 100, result.dt < result.stability_limit
    (True, True)
    """
    if damping is not None:
        damping_rate(network, damping)
    method = viscous(EULER_CROMER, dt=dt, damping=damping, title=ALGORITHM1.title)
    return relax(network, method, tolerance=tolerance, max_steps=max_steps)


def _judge(result: Relaxation, run: Run, *, allow_folded: bool) -> Relaxation:
    """A run at rest with the error of where it rests; refused where that is no answer."""
    network = run.network
    if not is_stable(Configuration(network, result.equilibrium.displacement), run.cycle):
        raise SolverError(
            f"{run.title} came to rest after {result.steps} steps where the network is unstable "
            "(some motion from there meets no stiffness, or less); disturb the symmetry or reduce "
            "the load"
        )
    if not allow_folded:
        refuse_folded(network, result.equilibrium, f"{run.title} after {result.steps} steps")
    error = error_of_displacement(network, result.equilibrium.displacement, run.cycle)
    _refuse_inaccurate(network, result, error, run.title)
    return replace(result, equilibrium=replace(result.equilibrium, error=error))


def _refuse_inaccurate(network: Network, result: Relaxation, error: float, title: str) -> None:
    """Raise `SolverError` where an error is as large as what moved, or a load moved nothing.

    What its prestress balances where it lies need not move, so that nothing is said by an error
    relative to that.
    """
    rest = result.equilibrium
    load = max_abs(network.force[~network.fixed])
    moved = max_abs(rest.displacement)
    seen = moved > FEW_UNITS * np.finfo(float).eps * max_abs(network.points)
    if error < 1 or not (seen or rest.residual > BALANCED * load):
        return
    off = f"{error:.2g} times its displacement" if math.isfinite(error) else "nobody knows how far"
    raise SolverError(
        f"{title} came to rest after {result.steps} steps, {rest.residual:.3g} N short of balance, "
        f"where it is off by {off}: the load is no larger than what "
        "rounding hides, or the body too slender; tighten tolerance, raise the load, or take "
        "`equilibrium`"
    )


def _load_stages(path: LoadPath) -> list[Network]:
    """The networks with what is applied at each stop of a path."""
    held = path.network.fixed
    early = [
        replace(
            path.network, force=path.force(t), displacement=np.where(held, path.prescribed(t), 0.0)
        )
        for t in path.stops[:-1]
    ]
    return [*early, path.network]


def _check_stopping(
    tolerance: float, max_steps: int | None, look_every: int | None, watch: Watch | None
) -> None:
    """Check the arguments that control the end and the monitoring of a run."""
    if positive_number("tolerance", tolerance) > LOOSEST:
        raise ProblemError(f"tolerance: {tolerance}; above {LOOSEST} any start would count as rest")
    for name, steps in (("max_steps", max_steps), ("look_every", look_every)):
        if steps is not None:
            whole_number(name, steps, 1)
    if not (watch is None or callable(watch)):
        raise ProblemError(f"watch: {format_value(watch)}; give a function of the run, or None")


def _check_frequencies(frequencies: tuple[float, float] | None) -> tuple[float, float] | None:
    """Lowest and highest natural frequency (rad/s) of a caller.

    None stays None. Raises `ProblemError` unless they are two finite numbers above 0, the lowest
    first.
    """
    if frequencies is None:
        return None
    given = finite("natural frequencies", frequencies)
    if given.shape != (2,) or not 0 < given[0] <= given[1]:
        raise ProblemError(
            f"natural frequencies: {format_value(frequencies)}; give the lowest and the highest in "
            f"rad/s, "
            "above zero"
        )
    return float(given[0]), float(given[1])


def _run_to_rest(
    run: Run, method: Method, steps: tuple[int | None, int | None], watch: Watch | None
) -> tuple[Relaxation, bool]:
    """The run at its end, and whether that is rest; what is held at every point is not asked."""
    if run.network.fixed.all():
        return Monitor(run).result(0.0), False
    given, stride = steps
    walk = method.walk(run)
    next(walk)  # prepares
    allowed = given or run.most_steps()
    look_every = stride or max(method.look_every, run.look_every)
    started, monitor = time.perf_counter(), Monitor(run)
    while True:
        seen = monitor.record()
        monitor.report()
        at_ease = run.test.is_converged(seen.residual, seen.kinetic)
        enough = watch is not None and watch(run)
        if at_ease or enough:
            return monitor.result(time.perf_counter() - started), at_ease
        if run.steps >= allowed:
            raise SolverError(monitor.unfinished)
        run.until = min(run.steps + look_every, allowed)
        while run.block > 0:
            next(walk)


class HistoryRow(NamedTuple):
    """Step, residual force (N) and kinetic energy (J) of a run at one moment."""

    step: int
    residual: float
    kinetic: float


class Monitor:
    """Monitor of a run, with a `history` from step 0 on.

    It does not change the run.
    """

    def __init__(self, run: Run) -> None:
        self.run = run
        self.history: list[HistoryRow] = []
        self.frames, self._stride = dict[int, Array](), 1
        self._reach = DIVERGED * max(float(np.ptp(x)) for x in run.network.points.T)

    def record(self) -> HistoryRow:
        """Add the state of a run to the history; raise `SolverError` on divergence."""
        run = self.run
        seen = HistoryRow(run.steps, max_abs(run.balance()), run.kinetic)
        near = max_abs(run.displacement) < self._reach
        if not (math.isfinite(seen.residual) and math.isfinite(seen.kinetic) and near):
            raise SolverError(self._diverged)
        if len(self.history) % self._stride == 0 and len(run.displacement) <= MAX_FRAME_POINTS:
            self.frames[run.steps] = run.displacement.copy()
        if len(self.frames) == MAX_FRAMES:  # every second one is kept, and from now on stored
            self.frames = dict(list(self.frames.items())[::2])
            self._stride *= 2
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
        """Error message for a run that has used all its steps."""
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
        run, last = self.run, self.run.displacement.copy()
        return Relaxation(
            equilibrium=equilibrium_at(run.network, last, run.steps, error=math.inf),
            dt=run.dt,
            damping=float(run.rate.max()),
            stability_limit=run.limit,
            history=np.array(self.history, dtype=float).reshape(-1, len(HistoryRow._fields)),
            evaluations=run.evaluations,
            seconds=seconds,
            network=run.network,
            frames=self.frames | ({run.steps: last} if self.frames else {}),
        )

    def report(self) -> None:
        """Report how far the run is on the way to rest, in logarithms of the residual."""
        first, last = self.history[0].residual, self.history[-1]
        target = self.run.test.target()
        if not (first and target):
            return
        way = math.log(first / max(last.residual, target)) / math.log(max(first / target, 2))
        text = "%s: %.0f %% of the way to rest, step %d, residual %.2g N"
        report_step(text, self.run.title, 100 * min(max(way, 0.0), 1.0), last.step, last.residual)
