"""Large symmetric systems of a network: conjugate gradients, one multigrid cycle a step.

Work and memory are in proportion to the unknowns, where a sparse factor's are not. The price is
certainty: a factor's pivots count the negative modes, while here a random load looks for one.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.linalg import eigh_tridiagonal
from scipy.sparse import bsr_array, csr_array

from msvalidate.network import Configuration, Network
from msvalidate.problem import Array, Index, Mask, rigid_motions
from msvalidate.problem.records import dataclass

MOST_CYCLES = 300
"""Bodies of good shape take 10 to 30; slender ones, or masses of soft springs, a few hundred."""
UNSEEN = 1e-4
"""Part of a mode's usual share of a random load below which `Cycles` overlook the mode. A
normal variable is smaller than that once in 12,500 times."""
ROUNDING = 1e-12
"""Of the largest eigenvalue of the coarsest level: below it a motion has no stiffness, or rounding.
A mechanism's is 0, of either sign."""
LOOSE = 1e-8
"""Of what each point meets, added to it where a motion without stiffness is looked for: a hundred
times what the library's inverses of blocks take for rounding."""
SWEEPS, MOST_SWEEPS = 2, 12
"""Inverse iterations: each shrinks modes of 1e-4 of what their points meet by 1e-4; those of stiff
points among soft ones meet less. The first need no more digits than an assembled stiffness has."""
STANDING = 1e-13
"""Change of a motion in a sweep, at which it was the last: its energy is known to the square."""
MOST_UNSETTLED = 3
"""Sweeps that conjugate gradients may leave unsettled: more bring a motion no nearer."""
CLEAN = 1e-10
"""What a sweep's solve leaves: 1e-14 of other modes in one without stiffness, by `LOOSE`."""
FAR_APART = 3.0
"""Mean difference of the numbers of two points that a spring joins, in points of a layer, beyond
which points are sorted first: lattices have less than 1, random numbers n^(1/d)/3."""
ORDINARY = 1e50
"""Largest stiffness (N/m) taken as it is, and one over the smallest. Others are scaled, in a copy
that the largest systems are spared."""
_SMOOTHER = "block_gauss_seidel"
_OPTIONS = {
    # Weights from row sums: the default draws random vectors, so that answers differ by run. Row
    # sums bound the highest mode of a lattice 1.5 times too high or more, which 4/3 · 1.3 makes up.
    "smooth": ("jacobi", {"omega": 1.7, "weighting": "local"}),
    "improve_candidates": None,
    "strength": ("symmetric", {"theta": 0.05}),
    # There and back: symmetric as conjugate gradients need it, at half the price of both ways twice
    "presmoother": (_SMOOTHER, {"sweep": "forward"}),
    "postsmoother": (_SMOOTHER, {"sweep": "backward"}),
}


@dataclass(frozen=True, eq=False)
class Cycle:
    """One multigrid cycle: nearly the inverse of a stiffness, positive definite if that is.

    Parameters
    ----------
    levels
        PyAMG's, of the stiffness over `unit`.
    unit
        N/m.
    indefinite_motion
        A motion (n·d,) of negative energy, if the coarsest level has one: so does the network then.
    order
        (n·d,) components as the levels have them; None where they are in the network's order.
    """

    levels: Any
    unit: float
    indefinite_motion: Array | None
    order: Index | None = None

    def __call__(self, force: Array) -> Array:
        """Displacement (n·d,) in m that nearly balances a force (n·d,) in N."""
        if self.order is None:
            return self._down(0, force / self.unit)
        found = np.empty_like(force)
        found[self.order] = self._down(0, force[self.order] / self.unit)
        return found

    def _down(self, level: int, load: Array) -> Array:
        """One W, each coarse level visited twice; the library's own also measures residuals.

        That takes a tenth more than a V, and spares steps that grow with levels and slenderness.
        """
        here = self.levels.levels[level]
        if level == len(self.levels.levels) - 1:
            return np.asarray(self.levels.coarse_solver(here.A, load))
        x = np.zeros_like(load)
        for _ in range(2 if level else 1):  # whole cycles, which keep it symmetric
            here.presmoother(here.A, x, load)
            x += here.P @ self._down(level + 1, here.R @ (load - here.A @ x))
            here.postsmoother(here.A, x, load)
        return x


@dataclass(frozen=True, eq=False)
class MultigridSolution:
    """What conjugate gradients found.

    Parameters
    ----------
    solution
        (n·d,) in m.
    cycles
        Steps taken, each with one cycle and one product.
    left
        Residual and error of the displacement, the larger, relative to those of no displacement.
    negative
        Whether a motion of no or negative energy was met: then the system is not positive definite.
    lowest
        Lowest eigenvalue of the stiffness times a cycle, as far as the load has it; infinite where
        it was not asked for.
    """

    solution: Array
    cycles: int
    left: float
    negative: bool
    lowest: float = math.inf


def restrain_in_place(K: bsr_array, free: Mask) -> None:
    """Cut off in K (n·d, n·d) itself what is not `free` (n, d), but for positive diagonal entries.

    Rows that are held stay, so that every point has its block.
    """
    held = ~np.asarray(free.all(axis=1))
    at = np.flatnonzero(np.repeat(held, np.diff(K.indptr)) | held[K.indices])
    row, column = np.searchsorted(K.indptr, at, side="right") - 1, K.indices[at]
    K.data[at] *= free[row][:, :, None] * free[column][:, None, :]
    own = row == column
    unit = float(K.data.max(initial=0.0)) or 1.0
    K.data[at[own]] += unit * (np.eye(free.shape[1]) * ~free[row[own]][:, :, None])


def restrained_tangent(at: Configuration) -> bsr_array:
    """The tangent there, its free part left: see `restrain_in_place`."""
    K = at.tangent()
    restrain_in_place(K, ~at.network.held)
    return K


def make_cycle(A: bsr_array, at: Configuration) -> Cycle:
    """Smoothed aggregation whose coarse spaces hold the rigid motions of the points there.

    `A` is `restrained_tangent` there. The same system has the same cycle, to the last digit.

    Source: [Vanek1996].
    """
    from pyamg import smoothed_aggregation_solver  # noqa: PLC0415  half a second for one method

    network, free = at.network, ~at.network.held
    centred = network.points - network.points.mean(axis=0)
    centred += at.displacement - at.displacement.mean(axis=0)
    rigid = rigid_motions(centred / np.abs(centred).max()).reshape(free.size, -1)
    largest = float(A.data.max())
    unit = 1.0 if 1 / ORDINARY < largest < ORDINARY else largest  # squares are to have numbers
    scaled = A if unit == 1 else bsr_array((A.data / unit, A.indices, A.indptr), shape=A.shape)
    scaled.has_canonical_format = True  # or it is looked through at every use
    motions, order = rigid * free.reshape(-1, 1), None
    if _is_scattered(network):
        points = _order_by_place(network)
        scaled = _permute_blocks(scaled, points)
        order = (points[:, None] * network.dim + np.arange(network.dim)).ravel()
        motions = motions[order]
    levels = smoothed_aggregation_solver(scaled, B=motions, **_OPTIONS)
    falling = _indefinite_motion(levels.levels)
    if falling is not None and order is not None:
        back = np.empty_like(falling)
        back[order] = falling
        falling = back
    return Cycle(levels, unit, falling, order)


def _is_scattered(network: Network) -> bool:
    """Whether points are numbered without regard to their places: cycles take more steps then."""
    n, d = network.points.shape
    i, j = network.springs.T
    return bool(np.abs(i - j).mean() > FAR_APART * n ** (1 - 1 / d))


def _order_by_place(network: Network) -> Index:
    """Points (n,) in layers, rows and along them, as lattices have them; alike ones by number."""
    spacing = float(np.linalg.norm(network.vector, axis=1).mean())
    layers = np.floor((network.points - network.points.min(axis=0)) / spacing + 0.25)
    return np.lexsort(layers.T)


def _permute_blocks(A: bsr_array, points: Index) -> bsr_array:
    """A with the blocks of its points (n,) in another order."""
    n = len(points)
    where = csr_array((np.arange(len(A.indices)), A.indices, A.indptr), shape=(n, n))
    where = where[points][:, points]
    where.sort_indices()
    found = bsr_array((A.data[where.data], where.indices, where.indptr), shape=A.shape)
    found.has_canonical_format = True
    return found


def _indefinite_motion(levels: list[Any]) -> Array | None:
    """The coarsest motion of the least energy on the finest level, if that is below rounding."""
    stiffness, motions = np.linalg.eigh(levels[-1].A.toarray())
    if stiffness[0] >= -ROUNDING * stiffness[-1]:
        return None
    motion = motions[:, 0]
    for level in levels[-2::-1]:
        motion = level.P @ motion
    return np.asarray(motion)


def conjugate_gradients(
    A: bsr_array,
    force: Array,
    cycle: Callable[[Array], Array],
    part: float,
    *,
    most: int = MOST_CYCLES,
    spectral: bool = False,
) -> MultigridSolution:
    """Solve A x = force (n·d,) in N until the residual and the error are `part` of the first.

    The error is what a cycle makes of the residual: that hardly knows of a slender body's bending.
    If `spectral`, both are to be smaller by the lowest eigenvalue, of which the error may be one
    over as large: conjugate gradients know it (Lanczos; [GolubVanLoan2013], section 11.3).

    Source: [HestenesStiefel1952].
    """
    x, residual = np.zeros(len(force)), force.copy()
    ahead = cycle(residual)
    first = _norm(force), _norm(ahead)
    direction, power, left = ahead.copy(), _dot(residual, ahead), 1.0
    if not all(first):  # no load, or one whose squares are too small for numbers
        return MultigridSolution(x, 0, float(force.any()), negative=False)
    lengths: list[float] = []
    turns: list[float] = []
    lowest = math.inf
    while left > part * min(lowest, 1.0) and len(lengths) < most:
        push = A @ direction
        stiff = _dot(direction, push)
        if not (stiff > 0 and power > 0):
            negative = bool(stiff <= 0 or power <= 0)
            return MultigridSolution(x, len(lengths), left, negative, lowest)
        lengths.append(power / stiff)
        x += lengths[-1] * direction
        residual -= lengths[-1] * push
        ahead = cycle(residual)
        now = _norm(residual), _norm(ahead)
        left = max(now[0] / first[0], now[1] / first[1])
        power, before = _dot(residual, ahead), power
        turns.append(power / before)
        direction *= turns[-1]
        direction += ahead
        if spectral and left <= part:
            lowest = _lowest_eigenvalue(np.array(lengths), np.array(turns))
    return MultigridSolution(x, len(lengths), left, negative=False, lowest=lowest)


def _lowest_eigenvalue(lengths: Array, turns: Array) -> float:
    """Lowest eigenvalue that steps of conjugate gradients have met, by their Lanczos matrix.

    Source: [Lanczos1950].
    """
    diagonal = 1 / lengths
    diagonal[1:] += turns[:-1] / lengths[:-1]
    beside = np.sqrt(np.abs(turns[:-1])) / lengths[:-1]
    values = eigh_tridiagonal(diagonal, beside, eigvals_only=True, select="i", select_range=(0, 0))
    return float(values[0])


def _dot(a: Array, b: Array) -> float:
    """a·b, not by BLAS: its threads change the last digits, and wait for each other."""
    return float(np.einsum("i,i", a, b))


def _norm(a: Array) -> float:
    return math.sqrt(_dot(a, a))


def softest_motion(A: bsr_array, at: Configuration) -> Array:
    """Motion (n·d,) that meets the least stiffness, its largest component 1, by inverse iteration.

    `A` is `restrained_tangent` there. It is stiffened by a part ε of what each point meets, D, so
    that a mechanism has an inverse too. A sweep (A + εD)⁻¹ εD x is made as x - (A + εD)⁻¹ A x at
    last, A x from the springs' own elongations: rounding in stiff springs
    would else deform the soft ones beside them. Without an answer, of a network that is unstable,
    all are 0.

    Source: inverse iteration, [GolubVanLoan2013], section 8.2.
    """
    d = at.network.dim
    own = A.indices == np.repeat(np.arange(len(A.indptr) - 1), np.diff(A.indptr))
    data = A.data.copy()
    met = np.repeat(data[own].trace(axis1=1, axis2=2), d)
    met /= np.abs(met).max()
    data[own] += LOOSE * A.data.max() * (met.reshape(-1, d, 1) * np.eye(d))
    stiffened = bsr_array((data, A.indices, A.indptr), shape=A.shape)
    cycle, mode = make_cycle(stiffened, at), _random_load(at.network)
    unsettled = 0
    for sweep in range(MOST_SWEEPS):
        exact, before = sweep >= SWEEPS, mode
        load = force_against(at, mode) if exact else met * mode * cycle.unit
        outcome = conjugate_gradients(stiffened, load, cycle, CLEAN)
        mode = mode - outcome.solution if exact else outcome.solution
        size = np.abs(mode).max()
        if outcome.negative or not size:
            return np.zeros_like(mode)
        mode = mode / size
        unsettled += not outcome.left <= CLEAN
        if exact and (np.abs(mode - before).max() <= STANDING or unsettled > MOST_UNSETTLED):
            break
    return mode


def force_against(at: Configuration, motion: Array) -> Array:
    """Force (n·d,) in N that a motion (n·d,) in m meets, where it is free.

    By the springs' own vectors: sums of large entries would lose what meets little.
    """
    held = at.network.held
    return np.where(held, 0.0, -at.force_change(motion.reshape(held.shape))).ravel()


def _random_load(network: Network) -> Array:
    """A load (n·d,) on what is free, the same every time."""
    free = ~network.held
    return np.where(free, np.random.default_rng(0).normal(size=free.shape), 0.0).ravel()
