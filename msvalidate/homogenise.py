"""Floor 1: the elastic solid that a lattice is: its tensor, relaxed, and its highest frequency.

A uniform strain moves the cells as wholes; inside a cell the points move on until no force is left.
What that releases lies between the affine tensor, which holds them back, and the relaxed one:

    C = C_affine - (1/V) Fᵀ K⁺ F,

K the stiffness of the periodic motions and F the forces that unit strains leave on the points.
Where every point is a centre of symmetry F is zero and the affine tensor is exact.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import eigh, eigvalsh, qr, solve_triangular
from scipy.optimize import minimize
from scipy.sparse import csr_array

from msvalidate.lattice import WEIGHTS, Constants, Lattice, Pattern, boundary_weights
from msvalidate.lattice.filled import cells_bordered
from msvalidate.linear import factorised, softest_mode
from msvalidate.problem import (
    Array,
    Index,
    ProblemError,
    SolverError,
    chosen,
    finite,
    instance,
    integers,
    metres,
    refuse_too_many,
    shown,
    whole,
)
from msvalidate.stiffness import (
    ALIKE,
    spring_tensor,
    voigt_directions,
)

DENSE = 300
"""Motions of a cell up to which all eigenvectors are found, and those without stiffness told."""
PHASES = 8
"""Of waves along each axis, even, so that pi is one."""
SAME_HEIGHT = 1e-9
"""Part of a squared frequency by which two waves' are told apart; rounding leaves 1e-14 of it."""
LARGEST_CELL = 1000
"""Points of a cell up to which all frequencies of all waves are found: dense matrices."""
NO_STIFFNESS = 1e-10
"""Stiffness of a motion, relative to the stiffest, below which it has none."""


NO_ENERGY = 1e-24
"""The same by the springs' own elongations, which rounding of entries does not hide; and of a
spring, below which it is none."""
NEAR = 1e4
"""Times that stiffnesses may be apart for the cheapest way: rounding is 1e-12 of the softest."""
SOFTEST = 1e-6
"""Root of a motion's stiffness over the softest spring's, below which it has none."""
CORRECTIONS = 8
ENOUGH = 1e-15
"""Part of an energy that a correction takes, at which it was the last."""
LEAST_PART = 1e-24
"""Energy over the largest strain's, below which a strain has none."""
ROUNDING = 1e-13
"""Of sums over springs."""
LARGEST_ERROR = 1e-6
"""Of an entry, above which no tensor is handed out."""
BLIND = 1e-3
"""Part of a known motion's elongations that may be missed."""


@dataclass(frozen=True, eq=False)
class Homogenised:
    """The solid that an endless lattice is.

    Parameters
    ----------
    affine, tensor
        Voigt tensors, (3, 3) in N/m or (6, 6) in Pa: with the points held to the uniform strain, an
        upper bound, and with them at rest.
    floppy
        Number of periodic motions, translations apart, without stiffness; None where it was not
        counted (none of them is there: the lattice was solved).
    error
        Largest error of an entry of the tensor over the root of the two diagonal entries beside it,
        from the energy of the last correction.
    """

    affine: Array
    tensor: Array
    floppy: int | None
    error: float = 0.0

    def __post_init__(self) -> None:
        for array in (self.affine, self.tensor):
            array.setflags(write=False)


def homogenised(pattern: Pattern, constants: Constants, spacing: float = 1.0) -> Homogenised:
    """The solid that an endless lattice is, its points at rest.

    Parameters
    ----------
    pattern, constants
        What repeats, and its spring constants (N/m), one a kind.
    spacing
        Length (m) of the pattern's unit; a plane tensor does not depend on it.

    Raises
    ------
    ProblemError
        If the constants are not one a kind, or the spacing is no length.
    SolverError
        If a large cell has a motion without stiffness.
    """
    instance("pattern", pattern, Pattern)
    a = metres("spacing", spacing)
    size = a * np.array(pattern.size)
    return periodic(
        len(pattern.points),
        pattern.springs,
        a * pattern.vectors,
        pattern.stiffness(constants),
        float(np.prod(size)),
    )


def network_tensor(lattice: Lattice, constants: Constants, weights: str) -> Array:
    """Tensor, (3, 3) in N/m or (6, 6) in Pa, of the *interior* of the lattice, as built by a rule.

    Of a piece of a pattern it is the solid of what repeats, its points at rest. A `diagonal_square`
    has lost the springs that its boundary cut, and comes near its interior's tensor only as it
    grows.

    Raises
    ------
    ProblemError
        If the constants are not one a kind, there is no such rule, or the lattice is irregular.
    """
    instance("lattice", lattice, Lattice)
    k = finite("spring constants", constants)
    if k.shape != (lattice.kinds,):
        raise ProblemError(
            f"spring constants: {shown(constants)}; give {lattice.kinds}, one a kind"
        )
    chosen("boundary weights", weights, WEIGHTS)
    pattern = lattice.pattern
    if pattern is not None:
        if weights == "per_cell":  # every cell that a spring borders brings one of its own
            pattern = replace(pattern, factor=pattern.factor * cells_bordered(pattern))
        return homogenised(pattern, constants, lattice.spacing).tensor
    if not lattice.regular:
        raise ProblemError(
            f"{lattice.name} lattice: its interior is not what its springs add up to; ask "
            "homogenised of the pattern that it was made from, or of a periodic sample of its kind"
        )
    # With shared boundary springs the whole lattice is made of interior cells, none of them cut.
    inside = lattice.sharing if weights == "per_cell" else 1
    per_spring = k[lattice.kind] * lattice.factor * inside * boundary_weights(lattice, "shared")
    return spring_tensor(lattice.vectors, per_spring, lattice.domain.volume)


def follows_strain(pattern: Pattern) -> bool:
    """Whether the points stay where a uniform strain takes them, whatever the constants.

    They do where each kind of spring by itself leaves no force on them: where every point is a
    centre of symmetry. The affine tensor is then exact, and linear in the constants.

    Raises
    ------
    ProblemError
        If it is no pattern.
    """
    instance("pattern", pattern, Pattern)
    for kind in range(pattern.kinds):
        k = np.where(pattern.kind == kind, pattern.factor, 0.0)
        force = strain_forces(len(pattern.points), pattern.springs, pattern.vectors, k)
        most = float((k * np.linalg.norm(pattern.vectors, axis=1)).max())
        if np.abs(force).max() > ALIKE * most:
            return False
    return True


def strain_forces(count: int, springs: Index, vectors: Array, stiffness: Array) -> Array:
    """Forces (n, d, v) in N on the points of a periodic cell under the unit Voigt strains."""
    length = np.linalg.norm(vectors, axis=1)
    normal = vectors / length[:, None]
    # A unit strain stretches a spring by L v, and it pulls at both ends.
    tension = (stiffness * length)[:, None, None] * normal[:, :, None]
    pull = tension * voigt_directions(normal)[:, None, :]
    force = np.zeros((count, *pull.shape[1:]))
    np.add.at(force, springs[:, 0], pull)
    np.add.at(force, springs[:, 1], -pull)
    return force


def periodic(
    count: int, springs: ArrayLike, vectors: ArrayLike, stiffness: ArrayLike, volume: float
) -> Homogenised:
    """The solid that a periodic network is, from its springs alone.

    Parameters
    ----------
    count
        Number of points in the periodic cell.
    springs, vectors, stiffness
        (m, 2) pairs of points, (m, d) in m from the first to the image of the second that it is
        joined to, and (m,) in N/m; unstressed.
    volume
        Of the periodic cell, m² or m³.

    Raises
    ------
    ProblemError
        If an array does not fit, or a value is not finite.
    SolverError
        If a large network has a motion without stiffness.
    """
    n, pairs = whole("points of the cell", count, 1), integers("springs", springs)
    refuse_too_many("periodic network", n)
    vector, k = finite("vectors", vectors), finite("stiffness", stiffness)
    if not k.size or k.min() < 0:
        raise ProblemError(
            f"stiffness: {shown(stiffness)}; give numbers of 0 or more, one a spring"
        )
    affine = spring_tensor(vector, k, volume)
    k = np.where(k >= NO_ENERGY * k.max(), k, 0.0)
    if pairs.shape != (len(k), 2):
        raise ProblemError(
            f"springs: {pairs.dtype} {pairs.shape}; give whole numbers {(len(k), 2)}"
        )
    if pairs.min() < 0 or pairs.max() >= n:
        raise ProblemError(f"springs: {pairs.min()} to {pairs.max()}; there are {n} points")
    normal = vector / np.linalg.norm(vector, axis=1)[:, None]
    K = _stiffness(n, pairs, k[:, None, None] * normal[:, :, None] * normal[:, None, :])
    stretch = np.linalg.norm(vector, axis=1)[:, None] * voigt_directions(normal)
    d = vector.shape[1]
    K, B = K[d:, d:], _elongations(n, pairs, normal)[:, d:]  # the first point held
    if _apart(k) > NEAR and K.shape[0] <= DENSE:
        relieve, floppy = _by_least_squares(B.toarray(), k)
    else:
        relieve, floppy = _by_forces(K, B, k)
    total, error = _relaxed(relieve, B, k, stretch)
    tensor = total.T @ (k[:, None] * total) / volume
    return Homogenised(affine, (tensor + tensor.T) / 2, floppy, error)


def _stiffness(n: int, pairs: Index, block: Array) -> csr_array:
    """Stiffness (n·d, n·d) of the periodic motions: a spring from a point to itself has none."""
    m, d = block.shape[:2]
    dof = pairs[:, :, None] * d + np.arange(d)
    row = np.broadcast_to(dof[:, :, None, :, None], (m, 2, 2, d, d))
    column = np.broadcast_to(dof[:, None, :, None, :], (m, 2, 2, d, d))
    sign = np.array([[1.0, -1.0], [-1.0, 1.0]])
    value = sign[None, :, :, None, None] * block[:, None, None]
    entries = (value.ravel(), (row.ravel(), column.ravel()))
    return csr_array(entries, shape=(n * d, n * d))


def _elongations(n: int, pairs: Index, normal: Array) -> csr_array:
    """Elongations (m, n·d) of springs by motions of the points."""
    m, d = normal.shape
    column = pairs[:, :, None] * d + np.arange(d)
    value = np.stack([-normal, normal], axis=1)
    row = np.broadcast_to(np.arange(m)[:, None, None], column.shape)
    return csr_array((value.ravel(), (row.ravel(), column.ravel())), shape=(m, n * d))


def _apart(k: Array) -> float:
    """Largest stiffness over the least that is one."""
    there = k[k > 0]
    return float(there.max() / there.min()) if len(there) else 1.0


Relieve = Callable[[Array], Array]
"""Motions (f, v) that relieve elongations (m, v): the least energy that is left, or nearly."""


def _relaxed(relieve: Relieve, B: csr_array, k: Array, stretch: Array) -> tuple[Array, float]:
    """Elongations (m, v) with the least energy, from those of the points held, and an error.

    The energy of an elongation that is off is off by the square: what a correction takes from it
    bounds what the next one would.
    """
    total = stretch + B @ relieve(stretch)
    left = np.inf
    for _ in range(CORRECTIONS):
        move = B @ relieve(total)
        total, before = total + move, left
        energy = np.einsum("m,mv,mv->v", k, total, total)
        taken = np.einsum("m,mv,mv->v", k, move, move)
        floor = LEAST_PART * energy.max(initial=0.0)
        left = float((taken / np.maximum(energy, max(floor, np.finfo(float).tiny))).max())
        if left <= ENOUGH or left > before / 2:
            break
    known = B @ np.random.default_rng(0).normal(size=(B.shape[1], 1))
    known[k == 0] = 0.0
    missed = np.linalg.norm(np.where(k[:, None] > 0, known + B @ relieve(known), 0.0))
    error = left + ROUNDING
    if not (error <= LARGEST_ERROR and missed <= BLIND * np.linalg.norm(known)):
        raise SolverError(
            f"periodic network: its tensor is known to {error:.1g} only, more than "
            f"{LARGEST_ERROR:g}: stiffnesses are {_apart(k):.1g} times apart; bring them closer "
            "together, or take fewer points a cell"
        )
    return total, error


def _by_forces(K: csr_array, B: csr_array, k: Array) -> tuple[Relieve, int | None]:
    """By the stiffness (f, f) of what is free; and the number of motions without any."""
    if not K.shape[0]:
        return lambda stretch: np.zeros((0, stretch.shape[1])), 0
    if K.shape[0] > DENSE:
        return _by_factor(K, B, k)
    values, modes = eigh(K.toarray())
    stiff = values > NO_STIFFNESS * max(values[-1], np.finfo(float).tiny)
    values, modes = values[stiff], modes[:, stiff]

    def relieve(stretch: Array) -> Array:
        return np.asarray(-(modes / values) @ (modes.T @ (B.T @ (k[:, None] * stretch))))

    return relieve, int((~stiff).sum())


def _by_least_squares(B: Array, k: Array) -> tuple[Relieve, int | None]:
    """By rows of springs (m, f), the stiff ones first: rounded by themselves, not by each other.

    Householder's method with columns exchanged (Cox and Higham 1998, in Numerical Analysis 1997).
    """
    order = np.argsort(-k, kind="stable")
    root = np.sqrt(k[order])[:, None]
    Q, R, exchanged = qr(root * B[order], mode="economic", pivoting=True)
    least = SOFTEST * float(np.sqrt(k[k > 0].min()))
    rank = int((np.abs(np.diag(R)) > least).sum())

    def relieve(stretch: Array) -> Array:
        u = np.zeros((B.shape[1], stretch.shape[1]))
        right = Q[:, :rank].T @ (root * stretch[order])
        u[exchanged[:rank]] = -solve_triangular(R[:rank, :rank], right)
        return u

    return relieve, B.shape[1] - rank


def _by_factor(K: csr_array, B: csr_array, k: Array) -> tuple[Relieve, int | None]:
    """By a factor of the stiffness (f, f) of what is free."""
    try:
        factor = factorised(K)
    except RuntimeError as error:
        raise SolverError(FLOPPY) from error
    mode = softest_mode(K, factor, K.diagonal())
    energy, least = float(k @ (B @ mode) ** 2), NO_ENERGY if _apart(k) > NEAR else NO_STIFFNESS
    if energy <= least * (mode**2 @ K.diagonal()):
        raise SolverError(FLOPPY)

    def relieve(stretch: Array) -> Array:
        right = -(B.T @ (k[:, None] * stretch))
        return np.column_stack([factor.solve(column) for column in right.T])

    return relieve, None


FLOPPY = (
    "periodic network: some of its points can move without stretching a spring; take more springs "
    "a point, or fewer points a cell"
)


def highest_frequency(pattern: Pattern, constants: Constants) -> float:
    """Highest frequency squared times the mean mass of a point (N/m) of an endless lattice.

    Over all waves: the best of a grid of phases from cell to cell, 0 and pi among them, where
    lattices of near neighbours have theirs, and then uphill from there. Masses are in proportion to
    the points' volumes.

    Raises
    ------
    ProblemError
        If the constants are not one a kind, or the cell has too many points.
    """
    instance("pattern", pattern, Pattern)
    n, d = pattern.points.shape
    refuse_too_many("frequency of a periodic cell", n, LARGEST_CELL)
    normal = pattern.vectors / np.linalg.norm(pattern.vectors, axis=1)[:, None]
    k = pattern.stiffness(constants)
    unit = float(k.max(initial=0.0)) or 1.0
    block = (k / unit)[:, None, None] * normal[:, :, None] * normal[:, None, :]
    i, j = pattern.springs.T
    mass = np.repeat(pattern.volume / pattern.volume.mean(), d)

    def square(phases: Array) -> float:
        turn = np.exp(1j * (pattern.image @ phases))[:, None, None]
        D = np.zeros((n, n, d, d), dtype=complex)
        np.add.at(D, (i, i), block)
        np.add.at(D, (j, j), block)
        np.add.at(D, (i, j), -turn * block)
        np.add.at(D, (j, i), -turn.conj() * block)
        matrix = D.transpose(0, 2, 1, 3).reshape(n * d, n * d) / np.sqrt(np.outer(mass, mass))
        return float(eigvalsh(matrix)[-1])

    steps = 2 * math.pi / PHASES * np.arange(PHASES)
    # A wave and its opposite are one: half of the phases of the last axis will do.
    waves = product(*[steps] * (d - 1), steps[: PHASES // 2 + 1])
    each = [(square(np.array(wave)), wave) for wave in waves]
    best = max(value for value, _ in each)
    # Of waves as high but for rounding, the first.
    start = next(wave for value, wave in each if value >= best * (1 - SAME_HEIGHT))
    options = {"xatol": 1e-8, "fatol": 1e-14}
    uphill = minimize(lambda q: -square(q), start, method="Nelder-Mead", options=options)
    return unit * max(best, -float(uphill.fun))
