"""Floor 2: the elastic solid that an endless lattice is: its tensor, relaxed, and its frequencies.

A uniform strain moves the cells as wholes; inside a cell the points move on until no force is left.
What that releases lies between the affine tensor, which holds them back, and the relaxed one:

    C = C_affine - (1/V) Fᵀ K⁺ F,

K the stiffness of the periodic motions and F the forces that unit strains leave on the points.
Where every point is a centre of symmetry F is zero and the affine tensor is exact.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import eigh, eigvalsh
from scipy.sparse import csr_array

from msvalidate.lattice import Constants, Pattern
from msvalidate.linear import factorised, softest_mode
from msvalidate.problem import Array, ProblemError, SolverError, finite, instance, metres, whole
from msvalidate.stiffness import spring_tensor, voigt_directions

DENSE = 300
"""Motions of a cell up to which all eigenvectors are found, and those without stiffness told."""
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
    n, pairs = whole("points of the cell", count, 1), np.asarray(springs)
    vector, k = finite("vectors", vectors), finite("stiffness", stiffness)
    affine = spring_tensor(vector, k, volume)
    if pairs.shape != (len(k), 2) or pairs.dtype.kind not in "iu":
        raise ProblemError(
            f"springs: {pairs.dtype} {pairs.shape}; give whole numbers {(len(k), 2)}"
        )
    if pairs.min() < 0 or pairs.max() >= n:
        raise ProblemError(f"springs: {pairs.min()} to {pairs.max()}; there are {n} points")
    length = np.linalg.norm(vector, axis=1)
    normal = vector / length[:, None]
    # A unit strain stretches a spring by L v; what it pulls at its two ends is F.
    pull = (k * length)[:, None, None] * normal[:, :, None] * voigt_directions(normal)[:, None, :]
    F = np.zeros((n, vector.shape[1], len(affine)))
    np.add.at(F, pairs[:, 0], pull)
    np.add.at(F, pairs[:, 1], -pull)
    right = F.reshape(-1, len(affine))
    K = _stiffness(n, pairs, k[:, None, None] * normal[:, :, None] * normal[:, None, :])
    u, floppy = _at_rest(K, right, vector.shape[1])
    tensor = affine - right.T @ u / volume
    return Homogenised(affine, (tensor + tensor.T) / 2, floppy)


def _stiffness(n: int, pairs: Array, block: Array) -> csr_array:
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


def highest_frequency(pattern: Pattern, constants: Constants, steps: int = 8) -> float:
    """Highest frequency squared times the mass of a point (N/m) of an endless lattice.

    Over waves with `steps` phases a cell along each axis, 0 and pi among them, where square, cubic
    and centred lattices have theirs; masses are in proportion to the points' volumes, 1 on average.

    Raises
    ------
    ProblemError
        If the constants are not one a kind, or the steps are not an even number.
    """
    instance("pattern", pattern, Pattern)
    if whole("steps", steps, 2) % 2:
        raise ProblemError(f"steps: {steps}; give an even number, so that a phase of pi is one")
    n, d = pattern.points.shape
    vector = pattern.vectors
    normal = vector / np.linalg.norm(vector, axis=1)[:, None]
    k = pattern.stiffness(constants)
    block = k[:, None, None] * normal[:, :, None] * normal[:, None, :]
    i, j = pattern.springs.T
    mass = np.repeat(pattern.volume / pattern.volume.mean(), d)
    highest = 0.0
    for wave in product(2 * math.pi / steps * np.arange(steps // 2 + 1), repeat=d):
        for signs in product((1, -1), repeat=d - 1):
            phase = np.exp(1j * (pattern.image @ (np.array(wave) * (*signs, 1))))
            D = np.zeros((n, n, d, d), dtype=complex)
            np.add.at(D, (i, i), block)
            np.add.at(D, (j, j), block)
            np.add.at(D, (i, j), -phase[:, None, None] * block)
            np.add.at(D, (j, i), -phase.conj()[:, None, None] * block)
            matrix = D.transpose(0, 2, 1, 3).reshape(n * d, n * d) / np.sqrt(np.outer(mass, mass))
            highest = max(highest, float(eigvalsh(matrix)[-1]))
    return highest
