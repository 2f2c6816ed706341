"""Motions that relieve a large periodic cell: conjugate gradients with multigrid cycles.

All strains are solved for at once, so that the stiffness is read once a step. Smoothed aggregation
(PyAMG) brings the coarse spaces, from translations alone: these are all that a periodic cell has
without stiffness. Rotations, which are not periodic, make coarse spaces twice as large for an
eighth fewer steps. Smoothing is by Chebyshev's polynomial of second degree in the stiffness over
its diagonal blocks: products alone, and nothing is estimated. A spring between two points costs at
most twice what it would with either of them held, so 2 bounds the finest level's eigenvalues, and
sums over rows those of the others: the cycle is positive definite wherever the stiffness is.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.sparse import bsr_array, csr_array

from msvalidate.problem import Array, Index
from msvalidate.tangent.multigrid import UNSEEN

PART = 1e-4
"""Root of an energy's part that is left of what is relieved. Asked three times, that is rounding;
of a motion that is known it is a tenth of what may be missed."""
MOST_CYCLES = 300
"""Even random cells take 10 to 20; stiffnesses 1e6 times apart, spring by spring, 100 to 200."""
SPAN = 8.0
"""Highest eigenvalue over the least that smoothing is for: aggregates are some 30 points."""
HIGHEST = 2.0
"""Of the stiffness of springs over its diagonal blocks."""
LEAST_OWN = 1e-13
"""Stiffness of a point in its softest direction over that in its stiffest, all others held, below
which it is rounding."""
MEETS_NONE = "some motion meets no stiffness but rounding"
_OPTIONS = {
    # As in `multigrid`: weights from row sums, that do not go by random vectors.
    "smooth": ("jacobi", {"omega": 1.7, "weighting": "local"}),
    "improve_candidates": None,
    "strength": ("symmetric", {"theta": 0.05}),
    "presmoother": None,
    "postsmoother": None,
    "max_coarse": 60,
}


class NotConverged(Exception):  # noqa: N818  an outcome, for the caller to act on
    """Conjugate gradients did not answer; the motion (f, v) that they came to, if any."""

    def __init__(self, why: str, motion: Array | None = None) -> None:
        super().__init__(why)
        self.motion = motion


class MechanismFound(Exception):  # noqa: N818
    """A motion was found that stretches no spring."""


class _Level(NamedTuple):
    """A stiffness (f, f), the inverses (p, b, b) of its diagonal blocks, and ways down and up."""

    A: bsr_array
    inverse: Array
    highest: float
    up: csr_array
    down: csr_array

    def over_own(self, force: Array) -> Array:
        """A force (f, v) over the diagonal blocks."""
        parts = force.reshape(len(self.inverse), self.inverse.shape[1], -1)
        return np.asarray(np.matmul(self.inverse, parts).reshape(force.shape))

    def smoothed(self, force: Array) -> Array:
        """Motion (f, v) that takes the stiff part of a force (f, v), by Chebyshev's two steps."""
        middle, half = (0.5 * self.highest * (1 + way / SPAN) for way in (1, -1))
        first = self.over_own(force) / middle
        ahead = self.over_own(force - self.A @ first)
        turn = 1 / (2 * middle**2 / half**2 - 1)
        return (1 + turn) * first + (2 * middle * turn / half**2) * ahead


class _Cycle:
    """Nearly the inverse of a periodic stiffness, but for translations.

    Source: smoothed aggregation, [Vanek1996].

    Parameters
    ----------
    K
        (n·d, n·d), its largest entry of order 1.
    dim
        Axes d.

    Raises
    ------
    NotConverged
        If a level is not positive definite, but for translations; with a motion to blame.
    """

    def __init__(self, K: bsr_array, dim: int) -> None:
        from pyamg import smoothed_aggregation_solver  # noqa: PLC0415  half a second for one method

        self.dim = dim
        shift = np.tile(np.eye(dim), (K.shape[0] // dim, 1))
        levels = smoothed_aggregation_solver(K, B=shift, **_OPTIONS).levels
        for depth, here in enumerate(levels[:-1]):
            if (soft := _softest_block(here.A)) is not None:
                raise NotConverged(MEETS_NONE, _prolong(soft, levels[:depth]))
        self.levels = [
            _level(here.A, here.P, here.R, None if depth else HIGHEST)
            for depth, here in enumerate(levels[:-1])
        ]
        # Translations are stiffened, and taken out of what comes and goes.
        coarsest = levels[-1].A.toarray()
        self.shift = np.linalg.qr(levels[-1].B)[0]
        stiffened = coarsest + np.abs(coarsest).max() * self.shift @ self.shift.T
        values, motions = np.linalg.eigh(stiffened)
        if not values[0] > LEAST_OWN * values[-1]:
            raise NotConverged(MEETS_NONE, _prolong(motions[:, :1], levels[:-1]))
        self.factor = cho_factor(stiffened)

    def __call__(self, force: Array) -> Array:
        """Motion (n·d, v), of mean zero, for forces (n·d, v)."""
        motion = self._down(0, force).reshape(-1, self.dim, force.shape[1])
        return np.asarray((motion - motion.mean(axis=0)).reshape(force.shape))

    def _down(self, depth: int, force: Array) -> Array:
        if depth == len(self.levels):
            held = force - self.shift @ (self.shift.T @ force)
            return np.asarray(cho_solve(self.factor, held))
        here = self.levels[depth]
        x = here.smoothed(force)
        x += here.up @ self._down(depth + 1, here.down @ (force - here.A @ x))
        x += here.smoothed(force - here.A @ x)
        return x


def _prolong(motion: Array, levels: list[Any]) -> Array:
    """A motion (f, 1) of a coarse level on the finest."""
    for level in levels[::-1]:
        motion = np.asarray(level.P @ motion)
    return motion


def _own_blocks(A: bsr_array) -> tuple[Array, Index]:
    """The diagonal blocks (p, b, b), 0 where there is none, and the rows of all blocks."""
    rows = len(A.indptr) - 1
    row = np.repeat(np.arange(rows), np.diff(A.indptr))
    own = np.zeros((rows, *A.blocksize))
    at = A.indices == row
    own[row[at]] = A.data[at]
    return own, row


def _softest_block(A: bsr_array) -> Array | None:
    """A motion (f, 1) of one point that meets no stiffness but rounding; None without any."""
    own, _ = _own_blocks(A)
    values, motions = np.linalg.eigh(own)
    part = values[:, 0] - LEAST_OWN * values[:, -1]
    worst = int(part.argmin())
    if part[worst] > 0:
        return None
    motion = np.zeros((*own.shape[:2], 1))
    motion[worst, :, 0] = motions[worst, :, 0]
    return np.asarray(motion.reshape(-1, 1), dtype=float)


def _level(A: bsr_array, up: csr_array, down: csr_array, highest: float | None) -> _Level:
    """A level; sums of blocks bound its eigenvalues if the highest is not known."""
    own, row = _own_blocks(A)
    if highest is None:
        # Blocks over the roots of diagonal ones: sums of their norms over rows bound eigenvalues.
        root = np.linalg.inv(np.linalg.cholesky(own))
        blocks = root[row] @ A.data @ root[A.indices].transpose(0, 2, 1)
        sums = np.bincount(row, np.linalg.norm(blocks, axis=(1, 2), ord=2))
        highest = float(sums.max())
    return _Level(A, np.asarray(np.linalg.inv(own), dtype=float), highest, up, down)


Stop = Callable[[Array], bool]
"""Whether a residual (f, v) is small enough."""


def _solve(K: bsr_array, force: Array, cycle: _Cycle, stop: Stop | None = None) -> Array:
    """Motions (f, v) for forces (f, v), each by conjugate gradients of its own.

    Until `stop`, or until the energy left, as a cycle has it, is `PART`² of what it was.

    Source: conjugate gradients, [HestenesStiefel1952].

    Raises
    ------
    NotConverged
        If it takes more than `MOST_CYCLES`, or there is a motion without stiffness.
    """
    size = np.abs(force).max(axis=0, initial=0.0)
    residual = force / np.where(size > 0, size, 1.0)
    x, ahead = np.zeros_like(force), cycle(residual)
    direction = ahead.copy()
    power = first = _column_products(residual, ahead)
    for _ in range(MOST_CYCLES):
        going = power > (0.0 if stop else PART**2 * first)
        if stop(size * residual) if stop else not going.any():
            return np.asarray(x * size)
        push = K @ direction
        stiff = _column_products(direction, push)
        if not (np.isfinite(stiff).all() and (stiff[going] > 0).all()):
            raise NotConverged(MEETS_NONE, direction)
        step = np.where(going, power / np.where(going, stiff, 1.0), 0.0)
        x += step * direction
        residual -= step * push
        ahead = cycle(residual)
        power, before = _column_products(residual, ahead), power
        direction *= np.where(going, power / np.where(going, before, 1.0), 0.0)
        direction += ahead
    raise NotConverged(f"conjugate gradients did not answer in {MOST_CYCLES} steps", size * x)


def _column_products(a: Array, b: Array) -> Array:
    """Products (v,) of columns, not by BLAS: its threads change the last digits."""
    return np.asarray(np.einsum("fv,fv->v", a, b))


def _answer_to_random_load(K: bsr_array, cycle: _Cycle) -> Array:
    """The answer (f, 1) to a random load.

    The part along a motion without stiffness never falls (the residual is a polynomial in the
    stiffness, 1 at 0, times the load), unless rounding has given it one: then it takes the whole
    answer. Each component of the load is random as the root of what it meets by itself, so along
    each motion it has the same spread: once the residual is `UNSEEN` of that, no such motion is
    overlooked but once in 12,500 times.
    """
    own = K.diagonal()[:, None]
    load = np.sqrt(own) * np.random.default_rng(0).normal(size=own.shape)
    parts = load.reshape(-1, cycle.dim)
    load = (parts - parts.mean(axis=0)).reshape(own.shape)
    return _solve(K, load, cycle, lambda left: bool((left**2 / own).sum() <= UNSEEN**2))


def _is_mechanism(B: csr_array, k: Array, own: Array, motion: Array, least: float) -> bool:
    """Whether a motion (f, 1) stretches no spring: energy over that of its parts, `own` (f,)."""
    size = float(np.abs(motion).max(initial=0.0))
    if not (size and np.isfinite(size)):
        return False
    way = motion[:, 0] / size
    return bool(k @ (B @ way) ** 2 <= least * (own @ way**2))


def multigrid_relaxation(
    K: csr_array, B: csr_array, k: Array, dim: int, least: float
) -> Callable[[Array], Array]:
    """A way to relieve elongations (m, v) by motions (f, v).

    Parameters
    ----------
    K
        Stiffness (n·d, n·d) of all points in N/m, none held.
    B, k
        Elongations (m, n·d) of springs by motions, and stiffnesses (m,) in N/m.
    dim
        Axes d.
    least
        Energy of a motion, over what its components cost one by one, below which it has none.

    Raises
    ------
    MechanismFound
        If a motion without stiffness was found: certain.
    NotConverged
        If conjugate gradients do not answer.
    """
    unit = float(k.max(initial=0.0))
    if not unit:
        raise MechanismFound
    scaled, part = (K / unit).tobsr((dim, dim)), k / unit
    scaled.sort_indices()
    try:
        cycle = _Cycle(scaled, dim)
        motion = _answer_to_random_load(scaled, cycle)
    except NotConverged as why:
        if why.motion is not None and _is_mechanism(B, part, scaled.diagonal(), why.motion, least):
            raise MechanismFound from why
        raise
    if _is_mechanism(B, part, scaled.diagonal(), motion, least):
        raise MechanismFound

    def relieve(stretch: Array) -> Array:
        return -_solve(scaled, B.T @ (part[:, None] * stretch), cycle)

    return relieve
