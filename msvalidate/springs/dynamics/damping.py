"""Viscous damping for the fastest relaxation of a loaded network.

To first order the way to rest is a sum of modes, which a damping F = -c·m·v does not couple. Let go
at the distance 1 from rest with no velocity, with s = c/2 and r = √(s² - ω²), real or imaginary, a
mode of frequency ω is at the distance

    x(t) = [(r + s)·exp(-(s - r)t) + (r - s)·exp(-(s + r)t)] / 2r,

which at the critical c = 2ω is (1 + ωt)·exp(-ωt). Below it the envelope falls with c/2; above it
the slow root s - r = ω²/(s + r), about ω²/c, is what is left.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import eigh

from msvalidate.linear_algebra.norms import max_abs
from msvalidate.problem import Array, ProblemError, SolverError, refuse_free_motions
from msvalidate.problem.checks import finite_number, require_type
from msvalidate.problem.records import dataclass
from msvalidate.springs.network import Configuration, Network
from msvalidate.springs.network.inverse import Solver
from msvalidate.springs.network.multigrid import NotConvergedError
from msvalidate.springs.network.residual import is_unloaded
from msvalidate.springs.network.stability import negative_modes
from msvalidate.springs.statics.refinement import SOFTEST_REFINED, explain_rounding

VECTORS = 8
"""Number of Ritz vectors, each of which needs a solve.

The rate is within 1 % of that with sixty vectors, the time within 2 %, also for a force at one
point of a strip that is 67 times as long as high and fixed along its length.
"""
EXHAUSTED = 1e-8
"""Relative size of a new Ritz vector that is rounding."""
STEP = 1.005
"""Ratio of successive trial rates.

They range from 0.2 of 2ω of the slowest mode to 3 times that of the largest one.
"""
LOOKS = 500
"""Number of times at equal ratios where the distance is evaluated."""


@dataclass(frozen=True)
class Damping:
    """A damping `rate` (1/s), F = -rate·m·v, and what it does; see `quickest_damping`.

    After `seconds` the distance from rest stays below `accuracy` of its start. `omega` (rad/s) is
    the lowest frequency up to which modes together make more than `accuracy` of the way.
    """

    rate: float
    seconds: float
    omega: float
    accuracy: float


def quickest_damping(network: Network, *, accuracy: float = 1e-3) -> Damping:
    """Damping rate (1/s) with which a network reaches equilibrium fastest.

    It starts with zero velocity.

    To first order and for small time steps, loads and prescribed displacements applied at once.
    The distance from rest is √(Σ m|u|²), in which modes add up by their squares. Just below the
    best rate the first overshoot must die out too, which takes a third longer: so a rate is given
    whose neighbour 0.5 % below is nearly as good. Modes that make less than a third of `accuracy`
    of the way, at the end 5 % of the distance at most, are left out.

    Source: Ritz vectors of the load, by Lanczos' iteration with the inverse, [Lanczos1950],
    [GolubVanLoan2013], chapter 10.

    Raises
    ------
    ProblemError
        If nothing moves the network, or freely, or the accuracy is not between 1e-6 and 0.5.
    SolverError
        If the network is a mechanism or unstable, or rounding hides its softest motion.
    """
    require_type("network", network, Network)
    if not 1e-6 <= finite_number("accuracy of rest", accuracy) <= 0.5:
        raise ProblemError(f"accuracy of rest: {accuracy:g}; give a part of the way, 1e-6 to 0.5")
    refuse_free_motions("network", network.points, network.fixed)
    at, solver = Configuration(network), Solver(network)
    force = (at.force() + at.force_change(network.displacement) + network.force)[~network.fixed]
    if is_unloaded(network) or not force.any():
        raise ProblemError(
            "quickest damping: no load or prescribed displacement acts on what is free to move; "
            "apply one"
        )
    try:
        omegas, shares = _excited_modes(at, force, solver)
    except NotConvergedError as error:
        solver.fall_back_to_factor(error)
        omegas, shares = _excited_modes(at, force, solver)
    slower = np.sqrt(np.cumsum(shares**2))
    omega, seen = float(omegas[slower > accuracy][0]), slower > accuracy / 3
    omegas, shares = omegas[seen], shares[seen]
    low, high = 0.2 * 2 * omegas[0], 3 * 2 * omegas[shares.argmax()]
    rates = low * STEP ** np.arange(np.log(high / low) / np.log(STEP))
    seconds = np.array([_time_to_rest(omegas, shares, rate, accuracy) for rate in rates])
    best = 1 + int(np.maximum(seconds[1:], seconds[:-1]).argmin())
    return Damping(float(rates[best]), float(seconds[best]), omega, accuracy)


def _excited_modes(at: Configuration, force: Array, solver: Solver) -> tuple[Array, Array]:
    """Frequencies (k,) in rad/s, ascending, of what a force (f,) excites; shares (k,) of the way.

    Squares of shares add up to 1.
    """
    network, found = at.network, solver.regular(at)
    if negative_modes(found):
        raise SolverError(
            "quickest damping: the network is unstable at its reference points; relieve its "
            "prestress or stiffen its cells"
        )
    if abs(found.softness) < SOFTEST_REFINED:
        why = explain_rounding(network, found.softness)
        raise SolverError(f"quickest damping: rounding hides the softest motion: {why}")
    root = np.sqrt(np.repeat(network.mass, network.dim)[~network.fixed.ravel()])
    vector = root * found.inverse.solve(force / max_abs(force))
    basis, images = np.empty((2, 0, len(root)))
    for _ in range(VECTORS):
        before = np.linalg.norm(vector)
        for _ in range(2):
            vector = vector - basis.T @ (basis @ vector)
        size = np.linalg.norm(vector)
        if size <= EXHAUSTED * before:
            break
        basis = np.vstack([basis, vector / size])
        vector = root * found.inverse.solve(root * basis[-1])
        images = np.vstack([images, vector])
    inverses, modes = eigh((basis @ images.T + images @ basis.T) / 2)
    inverses = np.maximum(inverses, EXHAUSTED * inverses[-1])  # a solver's error, of no share
    return 1 / np.sqrt(inverses[::-1]), np.abs(modes[0, ::-1])


def _time_to_rest(omegas: Array, shares: Array, damping: float, accuracy: float) -> float:
    """Time (s) after which the distance from rest stays below `accuracy` of its start."""
    # Five e-foldings more than asked for: what a double root or a phase adds to the envelope.
    longest = (5 - np.log(accuracy)) / decay(omegas[0], damping)
    times = np.geomspace(0.01 / omegas[shares.argmax()], longest, LOOKS)
    left = np.linalg.norm(shares[:, None] * approach(omegas[:, None], damping, times), axis=0)
    last = int(np.flatnonzero(left > accuracy)[-1])
    return float(np.interp(-accuracy, -left[last : last + 2], times[last : last + 2]))


def approach(omega: ArrayLike, damping: float, times: ArrayLike) -> Array:
    """Distance from rest (1) of modes let go at 1 without velocity, at times (s)."""
    w, t, s = np.asarray(omega, dtype=float), np.asarray(times, dtype=float), damping / 2
    r = np.sqrt(s**2 - w**2 + 0j)
    critical = abs(r) < 1e-6 * w
    r = np.where(critical, 1.0, r)
    slow, fast = w**2 / (s + r), s + r  # s - r, without cancellation
    both = (r + s) * np.exp(-slow * t) + (r - s) * np.exp(-fast * t)
    return np.asarray(np.where(critical, (1 + w * t) * np.exp(-w * t), (both / (2 * r)).real))


def decay(omega: float, damping: float) -> float:
    """Rate (1/s) at which the slower part of a mode dies out."""
    s = damping / 2
    return float((omega**2 / (s + np.sqrt(s**2 - omega**2 + 0j))).real)
