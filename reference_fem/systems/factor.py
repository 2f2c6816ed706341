"""Factors of a symmetric positive stiffness: SciPy's SuperLU, or CHOLMOD where cvxopt is there.

Source: [SuperLU]; [CHOLMOD], by [cvxopt].
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.sparse import csc_matrix, csr_matrix, diags_array
from scipy.sparse.linalg import splu

from msvalidate.problem import Array, Index, SolverError, format_point
from msvalidate.problem.records import dataclass
from reference_fem.effort import fits_in_memory
from reference_fem.mesh.discretisation import Discretisation

SHIFT = 1e-14
"""Part of the diagonal that is added to it where a factor fails by rounding."""
NO_STIFFNESS = 1e-14
"""Strain energy of a mode that is rounding, relative to what its components cost one by one."""

Apply = Callable[[Array], Array]


@dataclass(frozen=True, eq=False)
class Factor:
    """The inverse of a system, ready for any load.

    Parameters
    ----------
    name
        "superlu" or "cholmod".
    order
        (f,) where each unknown, as it was eliminated, stands among the free components.
    inverse
        Unknowns under loads, both (f,) in that order.
    """

    name: str
    order: Index
    inverse: Apply

    def __call__(self, load: Array) -> Array:
        """Free displacements (f,) in m under forces (f,) in N; or (f, r) of r loads at once."""
        found = np.empty(load.shape)
        found[self.order] = self.inverse(load[self.order])
        return found


def has_cholmod() -> bool:
    """Whether cvxopt, which brings CHOLMOD, is installed."""
    try:
        import cvxopt.cholmod  # noqa: F401, PLC0415  optional
    except ImportError:
        return False
    return True


def factorise(body: Discretisation, free: Index, order: Index, K: csr_matrix, name: str) -> Factor:
    """A factor of the free part of a stiffness.

    Parameters
    ----------
    body
        Whose stiffness it is.
    free, order
        Free components (f,), and the order (f,) to eliminate them in, as positions among them.
    K
        Stiffness (N/m) of all components.
    name
        "superlu" or "cholmod".

    Raises
    ------
    SolverError
        If part of the body can move without strain, or memory does not suffice.
    """
    with fits_in_memory(len(free), "unknowns"):
        kept = free[order]
        A = K[kept][:, kept]
        if not np.isfinite(A.data).all():
            return Factor(name, order, lambda load: np.full(load.shape, np.nan))  # none allowed
        A.sort_indices()
        make = {"superlu": _superlu, "cholmod": _cholmod}[name]
        try:
            inverse = _shift_singular(A, make, body)
        except (ArithmeticError, RuntimeError) as error:
            raise SolverError(
                "finite elements: the stiffness is singular: a part of the body can move without "
                "strain; join the parts or hold each"
            ) from error
        # A zero-energy mode hides from the residual, but cells in one piece have none.
        if not body.in_one_piece:
            _refuse_mechanism(body, kept, A, inverse)
    return Factor(name, order, inverse)


def _shift_singular(
    A: csr_matrix, make: Callable[[csr_matrix], Apply], body: Discretisation
) -> Apply:
    """The inverse, of a diagonal a little larger where rounding alone makes the matrix singular.

    It has no motion without strain where cells hang together by whole sides, and refinement mends
    the shift.
    """
    try:
        return make(A)
    except (ArithmeticError, RuntimeError):
        stiff = A.diagonal()
        if not (body.in_one_piece and (stiff > 0).all()):
            raise
        return make(csr_matrix(A + diags_array(SHIFT * stiff)))


def _refuse_mechanism(body: Discretisation, kept: Index, A: csr_matrix, inverse: Apply) -> None:
    """What the residual does not show, two steps of inverse iteration do."""
    mode = np.random.default_rng(0).normal(size=len(kept))
    for _ in range(2):
        mode = inverse(mode)
        mode /= np.abs(mode).max()
    if abs(mode @ (A @ mode)) <= NO_STIFFNESS * (mode**2 @ A.diagonal()):
        place = body.points[kept[np.abs(mode).argmax()] % len(body.points)]
        raise SolverError(
            f"finite elements: the part of the body around {format_point(place)} can move without "
            "strain; join it to the rest by an edge, or hold it"
        )


def signed_factor(A: csr_matrix) -> tuple[Apply, int]:
    """The inverse of a symmetric matrix (f, f) as it is ordered, and its negative eigenvalues.

    The pivots stand on the diagonal, so they have as many below zero as the eigenvalues have
    (Sylvester). Where one is zero the library would take another row's, and no sign could be told.

    Raises
    ------
    RuntimeError
        If a pivot is zero.
    """
    factor = _eliminate(A)
    if (factor.perm_r != factor.perm_c).any():
        raise RuntimeError("a pivot is zero")
    return lambda load: np.asarray(factor.solve(load)), int((factor.U.diagonal() < 0).sum())


def _superlu(A: csr_matrix) -> Apply:
    """L U of a symmetric matrix as it is ordered, its diagonal the pivots."""
    factor = _eliminate(A)
    return lambda load: np.asarray(factor.solve(load))


def _eliminate(A: csr_matrix) -> Any:
    columns = csc_matrix((A.data, A.indices, A.indptr), shape=A.shape)  # its own transpose
    return splu(
        columns, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
    )


def _cholmod(A: csr_matrix) -> Apply:
    """L Lᵀ of a symmetric matrix as it is ordered."""
    from cvxopt import cholmod, matrix, spmatrix  # noqa: PLC0415  optional

    row = np.repeat(np.arange(A.shape[0]), np.diff(A.indptr))
    below = A.indices <= row
    lower = spmatrix(
        matrix(A.data[below]),
        matrix(row[below]),
        matrix(A.indices[below].astype(np.int64)),
        A.shape,
    )
    factor = cholmod.symbolic(lower, p=matrix(np.arange(A.shape[0])))
    cholmod.numeric(lower, factor)

    def inverse(load: Array) -> Array:
        found = matrix(load)
        cholmod.solve(factor, found)
        return np.array(found).reshape(load.shape)

    return inverse
