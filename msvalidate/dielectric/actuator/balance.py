"""Balance of springs, loads and charges: what is left over, how it changes, and Newton's method."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array, csr_array

from msvalidate.dielectric.actuator.device import Actuator
from msvalidate.dielectric.actuator.models import Electric
from msvalidate.linear_algebra.factor import Factor, NoMemoryError, factorise
from msvalidate.problem import Array
from msvalidate.springs.network import Configuration, tangent
from msvalidate.springs.network.residual import force_scale, out_of_balance_force
from msvalidate.springs.statics.tangents import LARGEST_TURN

ITERATIONS = 25
"""Newton steps to one voltage: several times what quadratic convergence needs."""
BESIDE_LOADS = 1e-8
"""Residual at rest, over the largest load or pull of charges on what is free: beside prestress a
tolerance alone would take a start under a small voltage for rest."""


class BalancedState(NamedTuple):
    """Result of an equilibrium search: displacement (n, 2) in m, charges, linear solves."""

    displacement: Array
    electric: Electric
    solves: int


def residual_force(actuator: Actuator, displacement: Array, electric: Electric) -> Array:
    """Force (n, 2) in N of springs, loads and charges at a displacement (n, 2) in m."""
    force = out_of_balance_force(actuator.network, displacement)
    force[electric.loaded] += electric.forces()
    return force


def stiffness(actuator: Actuator, x: Array, electric: Electric) -> csr_array:
    """K_mech - K_elec (N/m) between free components, point by point; charges free to follow."""
    free = ~actuator.network.fixed.ravel()
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


def positive_factor(K: csr_array) -> Factor | None:
    """Factor of a stiffness that is positive; None where a motion meets no stiffness, or less."""
    try:
        factor = factorise(K)
    except NoMemoryError:
        raise
    except RuntimeError:  # a pivot of zero
        return None
    return None if factor.negative else factor


def is_balanced(
    actuator: Actuator, displacement: Array, electric: Electric, tolerance: float
) -> bool:
    """Return True if the residual is small relative to forces and free loads.

    Or rounding: an eps of the displacement, whatever the coordinates are.
    """
    network, free = actuator.network, ~actuator.network.fixed
    pull = np.array(network.force)
    pull[electric.loaded] += electric.forces()
    met = max(
        force_scale(Configuration(network, displacement)),
        float(np.abs(electric.forces()).max(initial=0.0)),
    )
    allowed, load = tolerance * met, float(np.abs(pull[free]).max(initial=0.0))
    if load:
        allowed = min(allowed, max(tolerance, BESIDE_LOADS) * load)
    a_metre = 4 * (network.rounding(1.0) - network.rounding(0.0))
    rounding = a_metre * float(np.abs(displacement).max(initial=0.0))
    left = np.abs(residual_force(actuator, displacement, electric))
    return bool((left <= allowed + rounding)[free].all())


def find_equilibrium(
    actuator: Actuator, u: Array, charged: Callable[[Array], Electric], tolerance: float
) -> BalancedState | None:
    """Stable balance near a displacement u (n, 2) in m by Newton's method; None if there is none.

    `charged` is a function of positions. From a stable place towards another the stiffness stays
    positive: where it does not, the step went beyond pull-in.
    """
    network, free = actuator.network, ~actuator.network.fixed
    for solves in range(1, ITERATIONS + 1):
        x = network.points + u
        electric = charged(x)
        factor = positive_factor(stiffness(actuator, x, electric))
        if factor is None:
            return None
        if is_balanced(actuator, u, electric, tolerance):
            return BalancedState(u, electric, solves)
        move = np.zeros(u.shape)
        move[free] = factor.solve(residual_force(actuator, u, electric)[free])
        if Configuration(network, u).largest_rotation(move) > LARGEST_TURN:
            return None
        u = u + move
    return None
