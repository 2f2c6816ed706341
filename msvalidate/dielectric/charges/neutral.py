"""Solutions of the method of moments' equations under neutrality, by a factor.

Charges at potentials V are P⁻¹(V - c), and c is such that they add up to nothing.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.linalg import LinAlgError, cho_factor, cho_solve, lu_factor, lu_solve

from msvalidate.dielectric.charges.checks import condition_number, one_norm
from msvalidate.problem import Array, SolverError

Solve = Callable[..., Array]


class Neutral:
    """Charges at potentials, and the constant with which they add up to nothing.

    Parameters
    ----------
    solve
        The inverse of P (m, m), for one column or several.
    count
        m.
    """

    def __init__(self, solve: Solve, count: int) -> None:
        self._solve, self._even = solve, solve(np.ones(count))
        self._capacity = self._even.sum()

    def __call__(self, potential: Array) -> Array:
        """Charges (m, ...) and the constant (1, ...), below them, at potentials (m, ...)."""
        charge = self._solve(potential)
        constant = charge.sum(axis=0) / self._capacity
        return np.concatenate([charge - np.multiply.outer(self._even, constant), [constant]])


def factorise(matrix: Array, *, symmetric: bool) -> tuple[Solve, float]:
    """The inverse of P (m, m), whose memory its factor takes, and the condition number of P.

    The inverse of one that is not symmetric has an option `adjoint`, of its transpose.

    Raises
    ------
    SolverError
        If it has none, or is to be positive definite and is not.
    """
    # Transposed it is in the order of columns that LAPACK works in without a copy.
    norm = one_norm(matrix.T)
    try:
        factor = (
            cho_factor(matrix.T, lower=True, overwrite_a=True, check_finite=False)
            if symmetric
            else lu_factor(matrix.T, overwrite_a=True, check_finite=False)
        )
    except LinAlgError as error:
        raise SolverError(
            "electrodes: to rounding, some of their segments lie on each other; move them apart, "
            "or take longer ones"
        ) from error
    condition = condition_number(factor[0], norm, symmetric=symmetric)
    if symmetric:
        return lambda right: cho_solve(factor, right, check_finite=False), condition

    def solve(right: Array, *, adjoint: bool = False) -> Array:
        return np.asarray(lu_solve(factor, right, trans=int(not adjoint), check_finite=False))

    return solve, condition


def subtract_middle(voltages: Array) -> tuple[Array, float]:
    """Voltages less the middle of them, which makes no charge but would cost digits, and that."""
    middle = 0.5 * float(voltages.max()) + 0.5 * float(voltages.min())
    return voltages - middle, middle
