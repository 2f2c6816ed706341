"""Floor 2: static equilibrium of a network, by one linear solve or by Newton's method."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.linalg import splu

from msvalidate.network import Network, force_roundoff, force_scale, spring_force, tangent
from msvalidate.problem import AXES, Array, Index, ProblemError, SolverError, refuse_free_motions

TOLERANCE = 1e-11
"""Newton stops at this residual, relative to the forces that meet at a point (and not below their
rounding). Convergence is quadratic, so what is reached is usually rounding."""
ITERATIONS = 25
"""Newton steps a load increment may take: far more than quadratic convergence needs."""
SMALLEST_INCREMENT = 2.0**-12
SINGULAR = 1e-13
"""Ratio of pivots below which the tangent is called singular: a condition number of 1e13 leaves
three digits."""


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """A network at rest under its supports and loads.

    Parameters
    ----------
    displacement
        (n, d) from the reference points (m).
    position
        (n, d) in m.
    reaction
        (n, d) force (N) of the supports on the held components, 0 elsewhere.
    residual
        Largest out-of-balance force (N) on a free component.
    iterations
        Linear solves that it took, or time steps.
    """

    displacement: Array
    position: Array
    reaction: Array
    residual: float
    iterations: int


def equilibrium(
    network: Network, geometry: Literal["linear", "nonlinear"] = "linear"
) -> Equilibrium:
    """Static equilibrium of a network.

    Parameters
    ----------
    network
        Supports must hold every rigid motion.
    geometry
        "linear": one solve with the tangent at the reference points, valid to first order in the
        displacement. "nonlinear": Newton's method, in load increments where one step is too many;
        the result is stable (no negative pivot of the tangent).

    Raises
    ------
    ProblemError
        If supports leave a rigid motion free; the message names it.
    SolverError
        If the network is a mechanism, or no stable equilibrium is found at full load.
    """
    refuse_free_motions("network", network.points, network.held)
    if geometry == "linear":
        return _linear(network)
    if geometry == "nonlinear":
        return _nonlinear(network)
    raise ProblemError(f"geometry: {geometry!r}; choose linear or nonlinear")


def at_rest(network: Network, position: Array, iterations: int) -> Equilibrium:
    """The equilibrium at `position` (n, d) in m, with the residual and reactions found there."""
    balance = spring_force(network, position) + network.force
    return Equilibrium(
        displacement=position - network.points,
        position=position,
        reaction=np.where(network.held, -balance, 0.0),
        residual=_largest(balance[~network.held]),
        iterations=iterations,
    )


def _linear(network: Network) -> Equilibrium:
    K = tangent(network, network.points)
    load = spring_force(network, network.points) + network.force
    move, _ = _solve(network, K, load, network.displacement)
    balance = load - (K @ move.ravel()).reshape(move.shape)
    residual = _largest(balance[~network.held])
    scale = abs(K).max() * np.abs(move).max(initial=0.0) + np.abs(load).max(initial=0.0)
    if not residual <= 1e-9 * scale:
        raise SolverError(f"linear equilibrium: residual {residual:g} N; the tangent is singular")
    return Equilibrium(
        displacement=move,
        position=network.points + move,
        reaction=np.where(network.held, -balance, 0.0),
        residual=residual,
        iterations=1,
    )


def _nonlinear(network: Network) -> Equilibrium:
    """Raise load and prescribed displacement together, in halves of what would not converge."""
    position, reached, increment, iterations = network.points, 0.0, 1.0, 0
    while reached < 1:
        target = min(1.0, reached + increment)
        found, taken = _newton(network, position, target)
        iterations += taken
        if found is not None:
            position, reached, increment = found, target, 2 * increment
            continue
        increment /= 2
        if increment < SMALLEST_INCREMENT:
            raise SolverError(
                f"nonlinear equilibrium: no stable equilibrium beyond {reached:.4g} of the load "
                f"(after {iterations} linear solves); reduce the load or stiffen the network"
            )
    return at_rest(network, position, iterations)


def _newton(network: Network, position: Array, fraction: float) -> tuple[Array | None, int]:
    """Equilibrium at a fraction of the load, None if there is none near; and the solves made."""
    x = position
    floor = 4 * force_roundoff(network)
    limit = 10 * (np.abs(network.points).max() + np.abs(network.displacement).max())
    for iteration in range(1, ITERATIONS + 1):
        balance = spring_force(network, x) + fraction * network.force
        ahead = network.points + fraction * network.displacement - x
        try:
            move, stable = _solve(network, tangent(network, x), balance, ahead)
        except SolverError:
            if iteration == 1:  # singular where we stand: smaller steps cannot help
                raise
            return None, iteration
        x = x + move
        if not np.isfinite(x).all() or np.abs(x).max() > limit:
            return None, iteration
        balance = spring_force(network, x) + fraction * network.force
        if _largest(balance[~network.held]) <= TOLERANCE * force_scale(network, x) + floor:
            return (x if stable else None), iteration
    return None, ITERATIONS


def _solve(network: Network, K: csr_array, load: Array, held: Array) -> tuple[Array, bool]:
    """Move (n, d) that balances `load`, held components moving by `held`; is K positive."""
    free = np.flatnonzero(~network.held.ravel())
    move = np.where(network.held, held, 0.0).ravel()
    if not len(free):
        return move.reshape(load.shape), True
    rows = K[free]
    factor = _factorised(network, rows[:, free], free)
    move[free] = factor.solve(load.ravel()[free] - rows @ move)
    return move.reshape(load.shape), bool((factor.U.diagonal() > 0).all())


def _factorised(network: Network, K: csr_array, free: Index) -> Any:
    """Sparse factor that pivots on the diagonal, so the signs of its pivots are K's inertia."""
    stiffness = np.abs(K.diagonal())
    loose = np.flatnonzero(stiffness <= SINGULAR * stiffness.max())
    if len(loose):
        _refuse_mechanism(network, int(free[loose[0]]))
    try:
        factor = splu(
            K.tocsc(),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
    except RuntimeError as error:
        raise SolverError(
            "equilibrium: the network is a mechanism, its tangent stiffness is singular; "
            "add springs or supports"
        ) from error
    pivots = np.abs(factor.U.diagonal())
    if pivots.min() <= SINGULAR * pivots.max():
        _refuse_mechanism(network, int(free[np.argsort(factor.perm_c)[pivots.argmin()]]))
    return factor


def _refuse_mechanism(network: Network, component: int) -> None:
    point, axis = divmod(component, network.dim)
    raise SolverError(
        f"equilibrium: the network is a mechanism: nothing resists point {point} moving along "
        f"{AXES[axis]}; add springs or supports"
    )


def _largest(values: Array) -> float:
    return float(np.abs(values).max(initial=0.0))
