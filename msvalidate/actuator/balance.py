"""Balance of springs, loads and charges: what is left over, how it changes, and Newton's method."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array, csr_array

from msvalidate.actuator.device import Actuator
from msvalidate.actuator.models import Electric
from msvalidate.linear import Factor, factorised
from msvalidate.network import internal_force, tangent
from msvalidate.problem import Array
from msvalidate.residual import force_roundoff, force_scale
from msvalidate.tangents import LARGEST_TURN, largest_turn

ITERATIONS = 25
"""Newton steps to one voltage: several times what quadratic convergence needs."""


class Found(NamedTuple):
    """Where a search came to rest: positions (n, 2) in m, charges there, linear solves it took."""

    position: Array
    electric: Electric
    solves: int


def out_of_balance(actuator: Actuator, x: Array, electric: Electric) -> Array:
    """Force (n, 2) in N of springs, loads and charges at positions (n, 2) in m."""
    force = internal_force(actuator.network, x) + actuator.network.force
    force[electric.loaded] += electric.forces()
    return force


def stiffness(actuator: Actuator, x: Array, electric: Electric) -> csr_array:
    """K_mech - K_elec (N/m) between free components, point by point; charges free to follow."""
    free = ~actuator.network.held.ravel()
    inside = np.flatnonzero(free)
    K = csr_array(tangent(actuator.network, x)[inside][:, inside])
    components = (2 * electric.loaded[:, None] + [0, 1]).ravel()
    moving = free[components]
    at = (np.cumsum(free) - 1)[components[moving]]
    rows, columns = np.repeat(at, len(at)), np.tile(at, len(at))
    values = electric.tangent()[np.ix_(moving, moving)].ravel()
    if not values.any():  # charges that are frozen, or none
        return K
    return csr_array(K - coo_array((values, (rows, columns)), shape=K.shape))


def factor_at(actuator: Actuator, x: Array, electric: Electric) -> Factor | None:
    """Factor of `stiffness` where it is positive; None where a motion meets no stiffness."""
    try:
        factor = factorised(stiffness(actuator, x, electric))
    except RuntimeError:  # a pivot of zero
        return None
    return None if factor.negative else factor


def is_small(actuator: Actuator, x: Array, electric: Electric, tolerance: float) -> bool:
    """Whether what is out of balance is small beside the forces that meet, or rounding."""
    network = actuator.network
    balance = np.abs(out_of_balance(actuator, x, electric))
    met = max(force_scale(network, x), float(np.abs(electric.forces()).max(initial=0.0)))
    allowed = tolerance * met + 4 * force_roundoff(network)
    return bool((balance <= allowed)[~network.held].all())


def balanced(
    actuator: Actuator, x: Array, charged: Callable[[Array], Electric], tolerance: float
) -> Found | None:
    """Stable balance near x by Newton's method; None if there is none.

    From a stable place towards another the stiffness stays positive: where it does not, the step
    went beyond pull-in.
    """
    free = ~actuator.network.held
    for solves in range(1, ITERATIONS + 1):
        electric = charged(x)
        factor = factor_at(actuator, x, electric)
        if factor is None:
            return None
        if is_small(actuator, x, electric, tolerance):
            return Found(x, electric, solves)
        move = np.zeros(x.shape)
        move[free] = factor.solve(out_of_balance(actuator, x, electric)[free])
        if largest_turn(actuator.network, x, move) > LARGEST_TURN:
            return None
        x = x + move
    return None
