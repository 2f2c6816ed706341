"""Floor 1: symmetric sparse systems: factor, inertia, and the mode that resists least."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import csr_array, eye_array
from scipy.sparse.linalg import splu

from msvalidate.problem import Array, Mask, SolverError

SWEEPS = 2
"""Inverse iterations: each shrinks what is not the softest mode by a ratio of eigenvalues, which is
all but zero where that mode has no stiffness."""
LARGEST_FACTORED = {2: 15_000, 3: 5_000}
"""Free components, by axes, up to which questions of a spectrum are put to a factor: a quarter
of a second of SuperLU. In space its work grows with the square of the components."""
NO_NUMBER = 1e-280
"""Entries below which a matrix has no digits left for a fraction of them."""


@dataclass(frozen=True, eq=False)
class Factor:
    """Factor of a symmetric matrix.

    Parameters
    ----------
    lu
        SuperLU's factor.
    negative
        Number of negative eigenvalues, by Sylvester's law of inertia.
    """

    lu: Any
    negative: int

    def solve(self, right: Array) -> Array:
        """Solution of the system for a right-hand side (n,)."""
        return np.asarray(self.lu.solve(right))


def factorised(matrix: csr_array) -> Factor:
    """Factor with pivots on the diagonal, in a symmetric ordering: faster than the general default.

    Raises
    ------
    RuntimeError
        If a pivot is exactly zero with nothing beside it to take.
    SolverError
        If the factor does not fit in memory.
    """
    try:
        lu = splu(
            matrix.tocsc(),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
    except MemoryError as error:
        raise SolverError(
            f"sparse factor: {matrix.shape[0]} unknowns take more memory than there is; take "
            "fewer cells"
        ) from error
    negative = int((lu.U.diagonal() < 0).sum())
    if not np.array_equal(lu.perm_r, lu.perm_c):  # a zero on the diagonal: not positive definite
        negative = max(negative, 1)
    return Factor(lu, negative)


def is_factored(free: Mask) -> bool:
    """Whether a network with free components (n, d) is small enough for a factor of its tangent."""
    return bool(np.count_nonzero(free) <= LARGEST_FACTORED[free.shape[1]])


def softest_mode(
    matrix: csr_array, factor: Factor | None = None, weight: Array | None = None
) -> Array:
    """Unit vector (n,) along which the matrix resists least: inverse iteration from a fixed start.

    Without a factor (the matrix is exactly singular) that of a slightly stiffened matrix serves.
    `weight` (n,) measures motions, as the diagonal does where parts differ in stiffness.
    """
    mode = np.random.default_rng(0).normal(size=matrix.shape[0])
    if factor is None:
        norm = float(abs(matrix).sum(axis=1).max())
        if norm < NO_NUMBER:  # nothing resists any motion: one is as good as another
            return np.asarray(mode / np.linalg.norm(mode))
        factor = factorised(csr_array(matrix + 1e-12 * norm * eye_array(matrix.shape[0])))
    unit = 1.0 if weight is None else weight / np.abs(weight).max()
    for _ in range(SWEEPS):
        mode = factor.solve(unit * mode)
        mode /= np.abs(mode).max()  # first by the largest: squares may overflow
        mode /= np.linalg.norm(mode)
    return np.asarray(mode)
