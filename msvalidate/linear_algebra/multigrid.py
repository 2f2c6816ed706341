"""Multigrid cycles for symmetric systems of blocks, a step of conjugate gradients each.

Work and memory are in proportion to the unknowns, where a sparse factor's are not. Coarse spaces
come from smoothed aggregation of near-null vectors that are given, by PyAMG, or from meshes that
hold each other. Nothing is drawn at random, so that answers are the same at every run.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np
from scipy.sparse import bsr_array, csr_array

from msvalidate.problem import Array, Index, Mask
from msvalidate.problem.records import dataclass

SPAN = 8.0
"""Highest eigenvalue over the least that Chebyshev's polynomial is for: aggregates are some 30
points, and fields of a mesh of half the size differ by as much."""
NO_STIFFNESS = 1e-13
"""Relative stiffness of a block or of the coarsest level that is rounding."""
ORDINARY = 1e50
"""Largest stiffness without scaling, and inverse of the smallest.

Others are scaled in a copy, which the largest systems avoid.
"""
MOST_COARSE = 10, 60
"""Maximum number of points on the coarsest level.

It is higher if translations are free, since one point has no other motion.
"""
_AGGREGATION = {
    # Weights from row sums: the default draws random vectors, so that answers differ by run. Row
    # sums bound the highest mode of a lattice 1.5 times too high or more, which 4/3 · 1.3 makes up.
    "smooth": ("jacobi", {"omega": 1.7, "weighting": "local"}),
    "improve_candidates": None,
    "strength": ("symmetric", {"theta": 0.05}),  # cells ten times as long as wide
    "presmoother": None,
    "postsmoother": None,
}

Smoother = Callable[[Array | None, Array], Array]
"""Function that improves a solution for a load; None stands for zero."""


@dataclass(frozen=True, eq=False)
class Level:
    """Block matrix (N, N) with its smoother and its transfer to a coarser level.

    Parameters
    ----------
    A
        The matrix.
    up, down
        (N, M) from the unknowns of the next coarser one, and its transpose.
    before, after
        Smoothers: one is the other's transpose, as conjugate gradients need it.
    """

    A: bsr_array
    up: Any
    down: Any
    before: Smoother
    after: Smoother

    def once(self, x: Array | None, load: Array, coarser: Callable[[Array], Array]) -> Array:
        """A motion nearer to the one under a load: smoothed, corrected, smoothed again."""
        x = self.before(x, load)
        x += self.up @ coarser(self.down @ (load - self.A @ x))
        return self.after(x, load)


@dataclass(frozen=True, eq=False)
class Cycle:
    """Multigrid cycle: approximate inverse of a matrix, positive definite if that is.

    Parameters
    ----------
    levels
        The finest first.
    coarsest
        Solves on the coarsest level.
    unit
        The levels are those of the matrix over this.
    softest
        Motion (N,) of the coarsest level's lowest eigenvalue, and this over its highest.
    order
        (N,) unknowns as the levels have them; None where they are in the given order.
    floating
        Components of translations that meet nothing, and are taken out; 0 where there are none.
    """

    levels: Sequence[Level]
    coarsest: Callable[[Array], Array]
    unit: float = 1.0
    softest: tuple[Array, float] | None = None
    order: Index | None = None
    floating: int = 0

    def __call__(self, force: Array) -> Array:
        """Motion that nearly balances a force, both (N,) or (N, v) of v at once."""
        ordered = force if self.order is None else force[self.order]
        found = self._down(0, ordered / self.unit)
        if self.floating:
            parts = found.reshape(-1, self.floating, *force.shape[1:])
            found = (parts - parts.mean(axis=0)).reshape(force.shape)
        return found if self.order is None else self._restored(found)

    @property
    def indefinite_motion(self) -> Array | None:
        """Direction (N,) of negative curvature on the coarsest level, if any.

        The matrix then has one as well.
        """
        if self.softest is None or self.softest[1] >= -10 * NO_STIFFNESS:
            return None
        return self.softest[0] if self.order is None else self._restored(self.softest[0])

    def _restored(self, ordered: Array) -> Array:
        back = np.empty_like(ordered)
        back[self.order] = ordered
        return back

    def _down(self, depth: int, load: Array) -> Array:
        """Run one W-cycle, in which each coarse level is visited twice.

        That takes a tenth more than a V, and spares steps that grow with levels and slenderness.
        """
        if depth == len(self.levels):
            return self.coarsest(load)
        here = self.levels[depth]
        x = here.once(None, load, partial(self._down, depth + 1))
        return here.once(x, load, partial(self._down, depth + 1)) if depth else x


def aggregate(
    A: bsr_array,
    near_null: Array,
    order: Index | None = None,
    *,
    floating: int = 0,
    highest: float | None = None,
) -> Cycle:
    """A cycle whose coarse spaces hold vectors that meet little: by smoothed aggregation.

    The same system has the same cycle, to the last digit.

    Source: [Vanek1996].

    Parameters
    ----------
    A
        (N, N) in square blocks, every point with one on the diagonal.
    near_null
        (N, r), such as rigid motions.
    order
        (n,) points as they are to be aggregated, neighbours near each other.
    floating
        Components of a point, where translations meet nothing; then smoothing is by products alone,
        for many right-hand sides at once, and 0 otherwise.
    highest
        Bound on the eigenvalues of A over its diagonal blocks, where one is known.

    Raises
    ------
    MeetsNothingError
        If translations are free, and another motion meets nothing but rounding.
    """
    from pyamg import smoothed_aggregation_solver  # noqa: PLC0415  half a second for one method

    size = A.blocksize[0]
    largest = float(A.data.max())
    unit = 1.0 if 1 / ORDINARY < largest < ORDINARY else largest  # squares are to have numbers
    scaled = A if unit == 1 else bsr_array((A.data / unit, A.indices, A.indptr), shape=A.shape)
    unknowns = None
    if order is not None:
        scaled = _permute_blocks(scaled, order)
        unknowns = (order[:, None] * size + np.arange(size)).ravel()
        near_null = near_null[unknowns]
    scaled.has_canonical_format = True  # or it is looked through at every use
    most = MOST_COARSE[bool(floating)]
    found = smoothed_aggregation_solver(scaled, B=near_null, max_coarse=most, **_AGGREGATION).levels
    above: list[Any] = []
    levels = []
    for here in found[:-1]:
        bound = None if above else highest
        smoothers = _by_products(here.A, bound, above) if floating else _by_sweeps(here.A)
        levels.append(Level(here.A, here.P, here.R, *smoothers))
        above.append(here.P)
    coarsest, motion, stiffness = _coarsest(found[-1], floating=bool(floating))
    softest = _prolong(motion, above), stiffness
    if floating and not stiffness > NO_STIFFNESS:
        raise MeetsNothingError(softest[0][:, None])
    return Cycle(levels, coarsest, unit, softest, unknowns, floating)


def _coarsest(level: Any, *, floating: bool) -> tuple[Callable[[Array], Array], Array, float]:
    """Pseudoinverse of the coarsest level, its softest mode and relative stiffness.

    Translations are removed.

    By all eigenvectors: a matrix that is not positive definite keeps its signs.
    """
    matrix = level.A.toarray()
    shift = np.linalg.qr(level.B)[0] if floating else np.zeros((len(matrix), 0))
    values, motions = np.linalg.eigh(matrix + np.abs(matrix).max() * shift @ shift.T)
    top = float(np.abs(values).max(initial=0.0)) or 1.0
    there = np.abs(values) > NO_STIFFNESS * top
    stiff, kept = values[there], motions[:, there]

    def solve(load: Array) -> Array:
        held = load - shift @ (shift.T @ load)
        return np.asarray(kept @ ((kept.T @ held).T / stiff).T)

    return solve, motions[:, 0], float(values[0]) / top


class MeetsNothingError(Exception):
    """A motion (N, 1) meets no stiffness but rounding."""

    def __init__(self, motion: Array | None = None) -> None:
        super().__init__("some motion meets no stiffness but rounding")
        self.motion = motion


def _prolong(motion: Array, up: list[Any]) -> Array:
    """A motion of a coarse level on the finest."""
    for each in up[::-1]:
        motion = np.asarray(each @ motion)
    return motion


def _by_sweeps(A: bsr_array) -> tuple[Smoother, Smoother]:
    """Gauss and Seidel's method by blocks, forward and back.

    There and back is symmetric, at half the price of both ways twice.
    """
    from pyamg.relaxation.relaxation import block_gauss_seidel  # noqa: PLC0415
    from pyamg.util.utils import get_block_diag  # noqa: PLC0415

    size = A.blocksize[0]
    inverse = get_block_diag(A, blocksize=size, inv_flag=True)

    def smooth(x: Array | None, load: Array, *, sweep: str) -> Array:
        x = np.zeros_like(load) if x is None else x
        block_gauss_seidel(A, x, load, sweep=sweep, blocksize=size, Dinv=inverse)
        return x

    return partial(smooth, sweep="forward"), partial(smooth, sweep="backward")


def _by_products(A: bsr_array, highest: float | None, up: list[Any]) -> tuple[Smoother, Smoother]:
    """Chebyshev's polynomial of second degree in the matrix over its diagonal blocks.

    Sums of blocks bound its eigenvalues if the highest is not known: over the roots of diagonal
    blocks, their norms over rows.
    """
    own, row = diagonal_blocks(A)
    values, motions = np.linalg.eigh(own)
    worst = int((values[:, 0] - NO_STIFFNESS * values[:, -1]).argmin())
    if not values[worst, 0] > NO_STIFFNESS * values[worst, -1]:
        motion = np.zeros(own.shape[:2])
        motion[worst] = motions[worst, :, 0]
        raise MeetsNothingError(_prolong(motion.reshape(-1, 1), up))
    if highest is None:
        root = (motions / np.sqrt(values)[:, None]).transpose(0, 2, 1)
        blocks = root[row] @ A.data @ root[A.indices].transpose(0, 2, 1)
        highest = float(np.bincount(row, np.linalg.norm(blocks, axis=(1, 2), ord=2)).max())
    smooth = chebyshev(A, (motions / values[:, None]) @ motions.transpose(0, 2, 1), highest)
    return smooth, smooth


def chebyshev(A: bsr_array, inverse: Array, highest: float) -> Smoother:
    """A smoother by products alone, from inverses (n, d, d) of diagonal blocks.

    Source: [Adams2003].
    """
    middle, half = (0.5 * highest * (1 + way / SPAN) for way in (1, -1))
    turn = 1 / (2 * middle**2 / half**2 - 1)

    def over_own(force: Array) -> Array:
        parts = force.reshape(len(inverse), inverse.shape[1], -1)
        return np.asarray(np.matmul(inverse, parts).reshape(force.shape))

    def smooth(x: Array | None, load: Array) -> Array:
        force = load if x is None else load - A @ x
        first = over_own(force) / middle
        change = (1 + turn) * first
        change += (2 * middle * turn / half**2) * over_own(force - A @ first)
        return change if x is None else x + change

    return smooth


def diagonal_blocks(A: bsr_array) -> tuple[Array, Index]:
    """Diagonal blocks (n, d, d), 0 if missing, and the rows of all blocks."""
    rows = len(A.indptr) - 1
    row = np.repeat(np.arange(rows), np.diff(A.indptr))
    own = np.zeros((rows, *A.blocksize))
    at = A.indices == row
    own[row[at]] = A.data[at]
    return own, row


def restrain_in_place(K: bsr_array, free: Mask) -> None:
    """Remove the couplings of fixed components from K (n·d, n·d) in place.

    Diagonal entries of components that are not `free` (n, d) become the largest entry of K, so that
    every point keeps its block.
    """
    held = ~np.asarray(free.all(axis=1))
    at = np.flatnonzero(np.repeat(held, np.diff(K.indptr)) | held[K.indices])
    row, column = np.searchsorted(K.indptr, at, side="right") - 1, K.indices[at]
    K.data[at] *= free[row][:, :, None] * free[column][:, None, :]
    own = row == column
    unit = float(K.data.max(initial=0.0)) or 1.0
    K.data[at[own]] += unit * (np.eye(free.shape[1]) * ~free[row[own]][:, :, None])


def _permute_blocks(A: bsr_array, points: Index) -> bsr_array:
    """A with the blocks of its points (n,) in another order."""
    n = len(points)
    where = csr_array((np.arange(len(A.indices)), A.indices, A.indptr), shape=(n, n))
    where = where[points][:, points]
    where.sort_indices()
    return bsr_array((A.data[where.data], where.indices, where.indptr), shape=A.shape)
