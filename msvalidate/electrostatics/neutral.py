"""Solutions of the method of moments' equations under neutrality, by a factor or by GMRES.

Charges at potentials V are P⁻¹(V - c), and c is such that they add up to nothing.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.linalg import LinAlgError, cho_factor, cho_solve, lu_factor, lu_solve
from scipy.sparse.linalg import LinearOperator, gmres

from msvalidate.problem import Array, SolverError

RESTARTS = 3
"""Of GMRES, which stops by the preconditioned residual and then looks at that of the potentials."""

Solve = Callable[[Array], Array]


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

    def __call__(self, potential: Array, total: float = 0.0) -> Array:
        """Charges (m, ...) and the constant (1, ...), below them, at potentials (m, ...)."""
        charge = self._solve(potential)
        constant = (charge.sum(axis=0) - total) / self._capacity
        return np.concatenate([charge - np.multiply.outer(self._even, constant), [constant]])


def factorised(matrix: Array, *, symmetric: bool) -> Solve:
    """The inverse of P (m, m), whose memory its factor takes.

    Raises
    ------
    SolverError
        If it has none, or is to be positive definite and is not.
    """
    try:
        # Transposed it is in the order of columns that LAPACK works in without a copy.
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
    if symmetric:
        return lambda potential: cho_solve(factor, potential, check_finite=False)
    return lambda potential: lu_solve(factor, potential, trans=1, check_finite=False)


def neutral_gmres(
    bordered: Solve, nearly: Solve, potential: Array, *, most: int, residual: float
) -> tuple[Array | None, int]:
    """Charges and constant (m + 1,) by GMRES, preconditioned by `nearly`, and its steps.

    None in their place if `most` steps leave more than `residual` of the potentials.
    """
    count = 0

    def counted(_: float) -> None:
        nonlocal count
        count += 1

    shape = (len(potential) + 1,) * 2
    solved, failed = gmres(
        LinearOperator(shape, bordered),
        np.append(potential, 0.0),
        M=LinearOperator(shape, nearly),
        rtol=residual,
        restart=most,
        maxiter=RESTARTS,
        callback=counted,
        callback_type="pr_norm",
    )
    return (None if failed else solved), count
