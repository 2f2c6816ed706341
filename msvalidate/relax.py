"""Floor 2: relaxation: the rest position found by letting the network move.

Algorithm 1 of the report: Euler-Cromer with a virtual viscosity until the body is at rest. The
report's loop runs ``while max(velocity) > eps``, which never starts from rest and stops wrongly
wherever a swinging body turns round; here both the residual force and the kinetic energy must be
small.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from tqdm import tqdm

from msvalidate import kernels
from msvalidate.equilibrium import Equilibrium, at_rest, is_stable
from msvalidate.integrate import damping_rate
from msvalidate.integrators import EULER_CROMER, stability_limit
from msvalidate.network import Network, force_roundoff, force_scale
from msvalidate.problem import (
    Array,
    ProblemError,
    SolverError,
    instance,
    positive,
    refuse_free_motions,
    whole,
)
from msvalidate.spectrum import extreme_frequencies

SAFETY = 0.9
"""Part of the stability limit used: the tangent stiffens a little as the network deforms."""
SPECTRUM_ERROR = 1e-4
"""Of the squared frequencies that set step and damping: a thousandth of what `SAFETY` leaves."""
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


@dataclass(frozen=True, eq=False)
class Relaxation:
    """A run that came to rest.

    Parameters
    ----------
    equilibrium
        Where it rests; its iterations are the time steps taken.
    dt, damping, stability_limit
        Time step (s), largest damping rate (1/s), and the largest stable step (s) at rest.
    history
        (looks, 3): step, residual force (N), kinetic energy (J).
    """

    equilibrium: Equilibrium
    dt: float
    damping: float
    stability_limit: float
    history: Array

    @property
    def steps(self) -> int:
        """Time steps taken."""
        return self.equilibrium.iterations


def algorithm1(
    network: Network,
    *,
    dt: float | None = None,
    damping: ArrayLike | None = None,
    tolerance: float = 1e-10,
    max_steps: int | None = None,
) -> Relaxation:
    """Relax a network by the report's Algorithm 1: Euler-Cromer with virtual viscosity.

    It starts at rest, with the prescribed displacements imposed at once.

    Parameters
    ----------
    network
        Its supports must hold every rigid motion.
    dt
        Time step (s); by default 0.9 of the stability limit for the network's highest frequency.
    damping
        Rate (1/s), one number or (n,): F = -damping·m·v. A viscosity c in N·s/m is c/m. By default
        twice the lowest frequency, which damps the slowest mode critically.
    tolerance
        The run ends when the largest residual force is below `tolerance` times the forces that
        meet at a point, and the kinetic energy below `tolerance`² times the energy stored in the
        springs; neither is asked to fall below rounding.
    max_steps
        By default 20 times what the slowest mode is predicted to need.

    Raises
    ------
    ProblemError
        If an argument is out of range or a rigid motion is free.
    SolverError
        If the run diverges, or is not at rest within `max_steps`.
    """
    instance("network", network, Network)
    refuse_free_motions("network", network.points, network.held)
    _refuse_bad_options(network, dt, damping, tolerance, max_steps)
    if network.held.all():
        still = at_rest(network, network.start, 0)
        return Relaxation(still, 0.0, 0.0, math.inf, np.zeros((0, 3)))
    lowest, highest = extreme_frequencies(network, tolerance=SPECTRUM_ERROR)
    if lowest <= 1e-7 * highest:
        raise SolverError(
            f"Algorithm 1: lowest frequency {lowest:g} rad/s: the network is a mechanism and never "
            "comes to rest; add springs or supports"
        )
    rate = damping_rate(network, 2 * lowest if damping is None else damping)
    strongest = float(rate.max())
    limit = stability_limit(EULER_CROMER, lowest, highest, strongest)
    step = SAFETY * limit if dt is None else dt
    allowed = max_steps or _predicted_steps(lowest, rate, step, tolerance)
    with np.errstate(over="ignore", invalid="ignore"):  # a diverged run is refused as such
        found = _Run(network, rate, step, limit, tolerance).until_rest(allowed)
    if not is_stable(network, found.equilibrium.position):
        raise SolverError(
            f"Algorithm 1 came to rest after {found.steps} steps where the network is unstable "
            "(its tangent stiffness has a negative mode); disturb the symmetry or reduce the load"
        )
    return found


def _refuse_bad_options(
    network: Network,
    dt: float | None,
    damping: ArrayLike | None,
    tolerance: float,
    max_steps: int | None,
) -> None:
    if positive("tolerance", tolerance) > LOOSEST:
        raise ProblemError(f"tolerance: {tolerance}; above {LOOSEST} any start would count as rest")
    if dt is not None:
        positive("time step dt", dt, "s")
    if damping is not None:
        damping_rate(network, damping)
    if max_steps is not None:
        whole("max_steps", max_steps, 1)


def _predicted_steps(lowest: float, rate: Array, dt: float, tolerance: float) -> int:
    """`PATIENCE` times the steps in which the slowest mode decays to `tolerance`."""
    slow = float(rate.min()) / 2
    strong = float(rate.max()) / 2
    # The slower root of an overdamped mode, strong - √(strong² - lowest²), without cancellation.
    decay = slow
    if strong > lowest:
        decay = min(slow, lowest**2 / (strong + math.sqrt(strong**2 - lowest**2)))
    if decay <= 0:
        raise ProblemError(
            f"damping: {2 * slow:g} 1/s with no max_steps: the motion never ends, or none can say "
            "when; give a positive rate, leave it out, or set max_steps"
        )
    needed = -math.log(min(tolerance, 0.5))
    if PATIENCE * needed > MOST_STEPS * decay * dt:
        raise ProblemError(
            f"damping: {rate.max():.4g} 1/s: the slowest motion would take more than "
            f"{MOST_STEPS / PATIENCE:.2g} steps of {dt:.4g} s to die out; leave damping and dt to "
            "their defaults, or set max_steps"
        )
    return PATIENCE * max(LOOK_EVERY, math.ceil(needed / (decay * dt)))


class _Run:
    """The state of one run. Kept out of sight: `algorithm1` is the function of this module."""

    def __init__(
        self, network: Network, rate: Array, dt: float, limit: float, tolerance: float
    ) -> None:
        self.network, self.rate, self.dt, self.limit = network, rate, dt, limit
        self.tolerance = tolerance
        self.displacement = np.array(network.displacement)
        self.velocity = np.zeros_like(self.displacement)
        self.force = np.empty_like(self.displacement)
        self.stored = 0.0
        self.floor = np.zeros((len(network.points), 1))
        self.at_lengths = 4 * force_roundoff(network, 0.0)
        self.per_metre = 4 * force_roundoff(network, 1.0) - self.at_lengths
        self.softest = float(network.stiffness[network.stiffness > 0].min(initial=np.inf))
        self.reach = DIVERGED * float(np.ptp(network.points, axis=0).max())

    @property
    def position(self) -> Array:
        return self.network.points + self.displacement

    def until_rest(self, allowed: int) -> Relaxation:
        done, looks = 0, [self.look(0)]
        with tqdm(
            total=1.0,
            desc="Algorithm 1",
            delay=1.0,
            disable=None,
            leave=False,
            bar_format="{desc}: {percentage:3.0f}% of the way to rest{postfix} [{elapsed}]",
        ) as bar:
            while not self.resting(looks[-1]):
                if done >= allowed:
                    raise SolverError(self.unfinished(done, looks[-1]))
                steps = min(LOOK_EVERY, allowed - done)
                kernels.euler_cromer(
                    self.network, self.displacement, self.velocity, self.rate, self.dt, steps
                )
                done += steps
                looks.append(self.look(done))
                if not bar.disable:
                    self.show(bar, looks)
        return Relaxation(
            equilibrium=at_rest(self.network, self.position, done),
            dt=self.dt,
            damping=float(self.rate.max()),
            stability_limit=self.limit,
            history=np.array(looks),
        )

    def look(self, step: int) -> tuple[int, float, float]:
        """Step, residual force (N) and kinetic energy (J); raises if the run has diverged."""
        self.stored = kernels.force_and_energy(self.network, self.displacement, self.force)
        balance = np.where(self.network.held, 0.0, self.force + self.network.force)
        residual = float(np.abs(balance).max())
        kinetic = float(0.5 * self.network.mass @ (self.velocity**2).sum(axis=1))
        moved = np.abs(self.displacement).max()
        self.floor = self.at_lengths + moved * self.per_metre
        if not (math.isfinite(residual) and math.isfinite(kinetic) and moved < self.reach):
            raise SolverError(
                f"Algorithm 1 diverged by step {step}: time step {self.dt:.4g} s, stability limit "
                f"{self.limit:.4g} s at damping {self.rate.max():.4g} 1/s; "
                + (
                    "take a smaller dt or leave it out"
                    if self.dt > self.limit
                    else "the network stiffens or collapses under this load: reduce dt or the load"
                )
            )
        return step, residual, kinetic

    def resting(self, look: tuple[int, float, float]) -> bool:
        rounding = float(self.floor.max())
        still = max(self.tolerance**2 * self.stored, rounding / self.softest * rounding)
        if look[2] > still:  # the usual case, and the cheaper question
            return False
        scale = force_scale(self.network, self.position)
        balance = np.where(self.network.held, 0.0, self.force + self.network.force)
        return bool((np.abs(balance) <= np.maximum(self.tolerance * scale, self.floor)).all())

    def unfinished(self, done: int, look: tuple[int, float, float]) -> str:
        _, residual, kinetic = look
        return (
            f"Algorithm 1 is not at rest after {done} steps of {self.dt:.4g} s (stability limit "
            f"{self.limit:.4g} s, damping {self.rate.max():.4g} 1/s): residual {residual:.3g} N, "
            f"kinetic energy {kinetic:.3g} J; "
            + (
                "take a smaller dt or leave it out"
                if self.dt > self.limit
                else "raise max_steps, leave damping to its default, or loosen tolerance"
            )
        )

    def show(self, bar: Any, looks: list[tuple[int, float, float]]) -> None:
        largest = looks[0][1]
        if not largest:
            return
        scale = force_scale(self.network, self.position)
        target = max(self.tolerance * scale, float(self.floor.max()))
        way = math.log(largest / max(looks[-1][1], target)) / math.log(max(largest / target, 2))
        bar.n = max(bar.n, min(way, 1.0))
        bar.set_postfix(step=looks[-1][0], residual=f"{looks[-1][1]:.2g} N", refresh=False)
        bar.update(0)
