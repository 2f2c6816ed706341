"""Solutions of the method of moments' equations under neutrality, by a factor or by GMRES.

Charges at potentials V are P⁻¹(V - c), and c is such that they add up to nothing.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.linalg import LinAlgError, cho_factor, cho_solve, lu_factor, lu_solve
from scipy.sparse.linalg import LinearOperator, gmres

from msvalidate.dielectric.charges.checks import condition_number, one_norm
from msvalidate.problem import Array, SolverError
from msvalidate.problem.records import dataclass

RESTARTS = 3
"""Of GMRES, which stops by the preconditioned residual and then looks at that of the potentials."""

Solve = Callable[[Array], Array]
FOLLOWED = 10.0
"""How far an error may exceed what one more step of an iteration would change."""


class Neutral:
    """Charges at potentials, and the constant with which they add up to nothing.

    Parameters
    ----------
    solve
        The inverse of P (m, m), for one column or several.
    count
        m.
    condition
        Of P.
    """

    def __init__(self, solve: Solve, count: int, condition: float) -> None:
        self.condition = condition
        self._solve, self._even = solve, solve(np.ones(count))
        self._capacity = self._even.sum()

    def __call__(self, potential: Array, total: float = 0.0) -> Array:
        """Charges (m, ...) and the constant (1, ...), below them, at potentials (m, ...)."""
        charge = self._solve(potential)
        constant = (charge.sum(axis=0) - total) / self._capacity
        return np.concatenate([charge - np.multiply.outer(self._even, constant), [constant]])


def factorise(matrix: Array, *, symmetric: bool) -> tuple[Solve, float]:
    """The inverse of P (m, m), whose memory its factor takes, and the condition number of P.

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
        return lambda potential: cho_solve(factor, potential, check_finite=False), condition
    return lambda potential: lu_solve(factor, potential, trans=1, check_finite=False), condition


@dataclass(frozen=True, eq=False)
class Iterated:
    """Charges and constant (m + 1,) by GMRES, its steps, and the error of the charges.

    The error is a sum over segments, over the sum of the charges: what one more correction by the
    preconditioner would change, times `FOLLOWED`.
    """

    solved: Array
    steps: int
    error: float


def neutral_gmres(
    bordered: Solve, nearly: Solve, potential: Array, *, most: int, residual: float
) -> Iterated | None:
    """Charges and constant by GMRES, preconditioned by `nearly`.

    None if `most` steps leave more than `residual` of the potentials.

    Source: [SaadSchultz1986].
    """
    count = 0
    right = np.append(potential, 0.0)

    def counted(_: float) -> None:
        nonlocal count
        count += 1

    shape = (len(potential) + 1,) * 2
    solved, failed = gmres(
        LinearOperator(shape, bordered),
        right,
        M=LinearOperator(shape, nearly),
        rtol=residual,
        restart=most,
        maxiter=RESTARTS,
        callback=counted,
        callback_type="pr_norm",
    )
    if failed:
        return None
    left = nearly(right - bordered(solved))
    return Iterated(solved, count, FOLLOWED * relative_change(left[:-1], solved[:-1]))


def relative_change(change: Array, charge: Array) -> float:
    """Sum of the sizes of a change of charges, over that of the charges; 0 where there is none."""
    off, size = float(np.abs(change).sum()), float(np.abs(charge).sum())
    return off / size if size else (0.0 if off == 0 else np.inf)


def subtract_middle(voltages: Array) -> tuple[Array, float]:
    """Voltages less the middle of them, which makes no charge but would cost digits, and that."""
    middle = 0.5 * float(voltages.max()) + 0.5 * float(voltages.min())
    return voltages - middle, middle
