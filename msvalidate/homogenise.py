"""Floor 1: the elastic solid that a lattice is: its tensor, relaxed, and its highest frequency.

A uniform strain moves the cells as wholes; inside a cell the points move on until no force is left.
What that releases lies between the affine tensor, which holds them back, and the relaxed one:

    C = C_affine - (1/V) Fᵀ K⁺ F,

K the stiffness of the periodic motions and F the forces that unit strains leave on the points.
Where every point is a centre of symmetry F is zero and the affine tensor is exact.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import eigh, eigvalsh
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
    """

    affine: Array
    tensor: Array
    floppy: int | None

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
    if pairs.shape != (len(k), 2):
        raise ProblemError(
            f"springs: {pairs.dtype} {pairs.shape}; give whole numbers {(len(k), 2)}"
        )
    if pairs.min() < 0 or pairs.max() >= n:
        raise ProblemError(f"springs: {pairs.min()} to {pairs.max()}; there are {n} points")
    right = strain_forces(n, pairs, vector, k).reshape(-1, len(affine))
    normal = vector / np.linalg.norm(vector, axis=1)[:, None]
    K = _stiffness(n, pairs, k[:, None, None] * normal[:, :, None] * normal[:, None, :])
    u, floppy = _at_rest(K, right, vector.shape[1])
    tensor = affine - right.T @ u / volume
    return Homogenised(affine, (tensor + tensor.T) / 2, floppy)


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


def _at_rest(K: csr_array, right: Array, d: int) -> tuple[Array, int | None]:
    """Motions (n·d, v) that leave no force, the first point held, and the number of floppy ones."""
    u = np.zeros(right.shape)
    free = K[d:, d:]
    if free.shape[0] <= DENSE:
        if not free.shape[0]:
            return u, 0
        values, modes = eigh(free.toarray())
        stiff = values > NO_STIFFNESS * max(values[-1], np.finfo(float).tiny)
        u[d:] = (modes[:, stiff] / values[stiff]) @ (modes[:, stiff].T @ right[d:])
        return u, int((~stiff).sum())
    try:
        factor = factorised(free)
    except RuntimeError as error:
        raise SolverError(FLOPPY) from error
    mode = softest_mode(free, factor)
    if mode @ (free @ mode) <= NO_STIFFNESS * (mode**2 @ free.diagonal()):
        raise SolverError(FLOPPY)
    for column in range(right.shape[1]):
        u[d:, column] = factor.solve(right[d:, column])
        # One step of refinement: pairs of near points make the matrix badly scaled.
        u[d:, column] += factor.solve(right[d:, column] - free @ u[d:, column])
    return u, None


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
