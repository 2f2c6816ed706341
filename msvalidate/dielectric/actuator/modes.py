"""Instability as an eigenvalue: the lowest modes of K_mech - K_elec."""

from __future__ import annotations

import numpy as np
from scipy.linalg import eigh
from scipy.sparse import csr_array, eye_array
from scipy.sparse.linalg import ArpackError, LinearOperator, eigsh

from msvalidate.dielectric.actuator.balance import positive_factor, stiffness
from msvalidate.dielectric.actuator.equilibria import ActuatorEquilibrium
from msvalidate.dielectric.actuator.models import charge_actuator
from msvalidate.linear_algebra.factor import Factor
from msvalidate.problem import Array, ProblemError, SolverError
from msvalidate.problem.checks import require_type, whole_number
from msvalidate.springs.lattice.ties import TIE

DENSE = 400
"""Free components up to which a dense solver is the faster one."""
FIRST_SHIFT, LONGEST_SHIFT = 1e-6, 10.0
"""Shifts below zero, over the largest stiffness, tried tenfold until no mode lies below."""


def lowest_modes(held: ActuatorEquilibrium, count: int = 1) -> tuple[Array, Array]:
    """Smallest eigenvalues (N/m) of K_mech - K_elec, charges free to follow, and their modes.

    The first is above zero where the actuator is stable, and falls to zero at pull-in. Modes have
    unit length over all free components, masses play no part, so values go with the size of the
    cells; their signs do not.

    Parameters
    ----------
    held
        Where.
    count
        Number of modes.

    Returns
    -------
    (count,) values in N/m, rising, and (count, n, 2) modes, each with the first of its largest
    components above zero.

    Raises
    ------
    ProblemError
        If an argument is out of range.
    SolverError
        If the iteration fails.
    """
    require_type("held", held, ActuatorEquilibrium)
    actuator, n = held.actuator, len(held.displacement)
    electric = charge_actuator(actuator, held.position, held.voltage)
    K = stiffness(actuator, held.position, electric)
    free = np.flatnonzero(~actuator.network.fixed.ravel())
    if whole_number("count", count, 1) > len(free):
        raise ProblemError(f"count: {count} modes; the actuator has {len(free)} free components")
    values, vectors = _smallest(csr_array(0.5 * (K + K.T)), count)
    modes = np.zeros((count, 2 * n))
    modes[:, free] = vectors.T
    # Of a symmetric body two components are as large, and may be of opposite signs.
    size = np.abs(modes)
    first = (size >= size.max(axis=1, keepdims=True) * (1 - TIE)).argmax(axis=1)
    largest = np.take_along_axis(modes, first[:, None], axis=1)
    return values, (modes * np.sign(largest)).reshape(count, n, 2)


def _smallest(K: csr_array, count: int) -> tuple[Array, Array]:
    size = K.shape[0]
    if size <= max(DENSE, 4 * count):
        values, vectors = eigh(K.toarray(), subset_by_index=(0, count - 1))
        return values, vectors
    shift, factor = _shifted_factor(K)
    start = np.random.default_rng(0).normal(size=size)  # fixed: the last digits stay the same
    inverse = LinearOperator(K.shape, factor.solve)
    try:
        values, vectors = eigsh(K, count, sigma=shift, OPinv=inverse, v0=start)
    except ArpackError as error:
        raise SolverError(f"lowest modes: the iteration failed ({error})") from error
    order = np.argsort(values, kind="stable")
    return values[order], vectors[:, order]


def _shifted_factor(K: csr_array) -> tuple[float, Factor]:
    """A shift that no eigenvalue lies below, and the factor of K shifted by it."""
    scale = float(K.diagonal().max())
    part = FIRST_SHIFT
    while part <= LONGEST_SHIFT:
        shift = -part * scale
        factor = positive_factor(csr_array(K - shift * eye_array(K.shape[0])))
        if factor is not None:
            return shift, factor
        part *= 10
    raise SolverError(
        f"lowest modes: one lies below {-LONGEST_SHIFT * scale:.3g} N/m; the electrodes are about "
        "to touch, take an equilibrium at a lower voltage"
    )
