"""Symmetric sparse systems: factor, inertia, and the mode that resists least.

By SciPy's SuperLU, or CHOLMOD where cvxopt is there. Source: [SuperLU]; [CHOLMOD], by [cvxopt].
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import csr_array, diags_array, eye_array
from scipy.sparse.linalg import splu

from msvalidate.problem import Array, Index, SolverError
from msvalidate.problem.records import dataclass

SWEEPS = 2
"""Number of inverse iterations.

Each reduces other modes than the softest by a ratio of eigenvalues, which is almost zero if the
softest mode has no stiffness.
"""
NO_NUMBER = 1e-280
"""Entries below which a matrix has no digits left for a fraction of them."""
NO_MEMORY = (
    "sparse factor: {} unknowns take more memory than there is; take solver 'multigrid' where "
    "there is a choice, or fewer points"
)
STIFFENED = 2.0**-48
"""Relative increase of the diagonal of a matrix that rounding made singular."""


class NoMemoryError(SolverError):
    """A factor does not fit in memory."""


@dataclass(frozen=True, eq=False)
class Factor:
    """Factor of a symmetric matrix.

    Parameters
    ----------
    name
        "superlu" or "cholmod".
    inverse
        Solutions for right-hand sides, both in the order of elimination.
    order
        (f,) unknowns in the order of elimination; None where the library chose it.
    lu
        SuperLU's factor; None of a Cholesky factor, which only a positive matrix has.
    """

    name: str
    inverse: Callable[[Array], Array]
    order: Index | None = None
    lu: Any = None

    @cached_property
    def negative(self) -> int:
        """Number of negative eigenvalues, by Sylvester's law of inertia.

        Raises
        ------
        SolverError
            If there is no memory for the library's copy of the factor.
        """
        if self.lu is None:
            return 0
        try:  # the library copies both triangles for that
            negative = int((self.lu.U.diagonal() < 0).sum())
        except MemoryError as error:
            raise NoMemoryError(NO_MEMORY.format(self.lu.shape[0])) from error
        # A zero on the diagonal, where another row was taken: not positive definite.
        return max(negative, 1) if self.is_exchanged else negative

    @property
    def is_exchanged(self) -> bool:
        """True if a row exchange replaced a zero pivot.

        The signs of the pivots are then meaningless.
        """
        return self.lu is not None and not np.array_equal(self.lu.perm_r, self.lu.perm_c)

    def solve(self, right: Array) -> Array:
        """Solve the system for right-hand sides (f,) or (f, r)."""
        if self.order is None:
            return np.asarray(self.inverse(right))
        found = np.empty_like(right)
        found[self.order] = self.inverse(right[self.order])
        return found


def has_cholmod() -> bool:
    """Return True if cvxopt, which provides CHOLMOD, is installed."""
    try:
        import cvxopt.cholmod  # noqa: F401, PLC0415  optional
    except ImportError:
        return False
    return True


def factorise(
    matrix: csr_array, order: Index | None = None, name: str = "superlu", *, mend: bool = False
) -> Factor:
    """Factor with pivots on the diagonal, in a symmetric ordering: faster than the general default.

    Parameters
    ----------
    matrix
        (f, f), symmetric.
    order
        (f,) in which its unknowns are eliminated, such as that of `order.free_unknowns`; by
        default of minimum degree, which is as good for a few thousand unknowns.
    name
        "superlu", or "cholmod" of a matrix that is known to be positive definite.
    mend
        Whether to add `STIFFENED` of the diagonal where rounding has made the matrix singular.

    Raises
    ------
    RuntimeError
        If a pivot is exactly zero with nothing beside it to take.
    NoMemoryError
        If the factor does not fit in memory.
    """
    try:
        with silence_library():
            ordered = matrix if order is None else matrix[order][:, order]
            if name == "cholmod":
                return Factor(name, _cholesky(ordered), order)
            lu = splu(
                ordered.tocsc(),
                permc_spec="MMD_AT_PLUS_A" if order is None else "NATURAL",
                diag_pivot_thresh=0.0,
                options={"SymmetricMode": True},
            )
    except (ArithmeticError, MemoryError, RuntimeError) as error:
        if isinstance(error, MemoryError) or "MALLOC" in str(error):
            raise NoMemoryError(NO_MEMORY.format(matrix.shape[0])) from error
        if not mend:
            raise RuntimeError(*error.args) from error  # a pivot of zero
        stiffened = matrix + diags_array(STIFFENED * np.abs(matrix.diagonal()))
        return factorise(csr_array(stiffened), order, name)
    return Factor(name, lu.solve, order, lu)


def _cholesky(matrix: csr_array) -> Callable[[Array], Array]:
    """L Lᵀ of a symmetric matrix as it is ordered."""
    from cvxopt import cholmod, spmatrix  # noqa: PLC0415  optional
    from cvxopt import matrix as dense  # noqa: PLC0415

    row = np.repeat(np.arange(matrix.shape[0]), np.diff(matrix.indptr))
    below = matrix.indices <= row
    entries = matrix.data[below], row[below], matrix.indices[below].astype(np.int64)
    lower = spmatrix(*(dense(each) for each in entries), matrix.shape)
    factor = cholmod.symbolic(lower, p=dense(np.arange(matrix.shape[0])))
    cholmod.numeric(lower, factor)

    def inverse(load: Array) -> Array:
        found = dense(load)
        cholmod.solve(factor, found)
        return np.array(found).reshape(load.shape)

    return inverse


@contextmanager
def silence_library() -> Iterator[None]:
    """Keep the library's own lines, of memory that it does not get, from the terminal.

    Those of the whole process: what other threads write in the meantime is lost.
    """
    streams = (1, 2)
    try:
        kept, nowhere = [os.dup(each) for each in streams], os.open(os.devnull, os.O_WRONLY)
    except OSError:  # one is closed
        yield
        return
    try:
        for each in streams:
            os.dup2(nowhere, each)
        yield
    except (MemoryError, RuntimeError):
        with suppress(OSError, TypeError, AttributeError):  # what C keeps back would come later
            ctypes.CDLL(None).fflush(None)
        raise
    finally:
        for each, own in zip(streams, kept, strict=True):
            os.dup2(own, each)
        for each in (*kept, nowhere):
            os.close(each)


def softest_mode(
    matrix: csr_array, factor: Factor | None = None, weight: Array | None = None
) -> Array:
    """Unit vector (n,) along which the matrix resists least.

    Without a factor (the matrix is exactly singular) that of a slightly stiffened matrix serves.
    `weight` is as in `inverse_iteration`.

    Source: inverse iteration, [GolubVanLoan2013], section 8.2.
    """
    size = matrix.shape[0]
    if factor is None:
        norm = float(abs(matrix).sum(axis=1).max())
        if norm < NO_NUMBER:  # nothing resists any motion: one is as good as another
            mode = np.random.default_rng(0).normal(size=size)
            return np.asarray(mode / np.linalg.norm(mode))
        factor = factorise(csr_array(matrix + 1e-12 * norm * eye_array(size)))
    return inverse_iteration(factor.solve, size, weight)


def inverse_iteration(
    solve: Callable[[Array], Array], size: int, weight: Array | None = None
) -> Array:
    """Unit vector (size,) that a matrix resists least, by its inverse, from a fixed start.

    `weight` (size,) measures motions, as the diagonal does where parts differ in stiffness. NaN
    where the inverse is beyond all numbers.

    Source: [GolubVanLoan2013], section 8.2.
    """
    mode = np.random.default_rng(0).normal(size=size)
    unit = 1.0 if weight is None else weight / np.abs(weight).max()
    with np.errstate(invalid="ignore", over="ignore"):  # NaN, where nothing resists a motion
        for _ in range(SWEEPS):
            mode = solve(unit * mode)
            mode /= np.abs(mode).max()  # first by the largest: squares may overflow
            mode /= np.linalg.norm(mode)
    return np.asarray(mode)
