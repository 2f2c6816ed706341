"""How far below zero what stands beside springs may go before some wave costs no energy.

**Shear springs** k_t = α k_n. The energy of a wave is its central springs' plus α times that of
shear springs of their stiffness: positive while α > -1/R, with R the largest ratio of the two over
all waves. For long ones the moduli alone say it: μ > 0 asks for α > -1 in the plane (nu < 1) and
α > -2/3 in a solid (nu < 1/2). Short waves ask for no more: least squares over both sides of a
point see little of what alternates from point to point.

**Cells' volumes** of κ. Long waves ask for λ + 2μ > 0, less than the bulk modulus does. Where the
corners of the cells are all the points there are, short ones ask for no more. Where they are not,
the corners may swell their cells while the other points stay: triangles in rectangular cells bear
κ > -5/3 μ (in-plane nu > -1/2), FCC κ > -5/4 μ (nu > -1/6).

A body asks for more, at its boundary. Of shear springs, for least squares are one-sided there: a
square of 8 x 8 cells for α > -0.993, a cube of 3 x 3 x 3 cells of eighteen neighbours for
α > -0.652 (nu < 0.493), one of BCC for α > -0.535 (nu < 0.443). Of volumes where the boundary cuts
springs but no cells: FCC of 2 x 2 x 2 cells is not stable at nu = 0, BCC not at -1/2.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import product

import numpy as np
from scipy.linalg import LinAlgError, eigvalsh

from msvalidate.lattice import Constants, Pattern
from msvalidate.lattice.pattern import SAME_DISTANCE
from msvalidate.problem import Array, ProblemError
from msvalidate.problem.checks import refuse_too_many, require_type

PHASES = 8
"""Of waves along each axis, even, so that pi is one."""
LONG = 1e-3
"""Phase of long waves, in rad a cell: what is left of the short ones is its square."""
LARGEST_CELL = 100
"""Points of a cell up to which all waves are solved for: dense matrices."""


def least_stable_ratio(pattern: Pattern, constants: Constants) -> float:
    """Ratio α = k_t/k_n above which every wave of an endless lattice costs energy.

    Over a grid of phases from cell to cell, and long waves along the same directions.

    Source: stability by the energies of all waves, [BornHuang1954].

    Parameters
    ----------
    pattern, constants
        What repeats, and its central springs' constants (N/m), one a kind.

    Raises
    ------
    ProblemError
        If the constants are not one a kind, the cell has too many points, or some wave already
        costs nothing without shear springs.
    """
    return -1 / _largest_ratio(_shear_ratio, pattern, constants)


def least_stable_volume(pattern: Pattern, constants: Constants) -> float:
    """κ above which every wave of an endless lattice costs energy, at a spacing of 1 m.

    Of cells as `msvalidate.lattice.fill` makes them: the pattern's own, from corner to corner. In
    the plane in N/m, at any spacing; in space in Pa, over the spacing.

    Source: stability by the energies of all waves, [BornHuang1954].

    Parameters
    ----------
    pattern, constants
        What repeats, with a point in the corner of its cell, and its springs' constants (N/m).

    Raises
    ------
    ProblemError
        As for `least_stable_ratio`, or if no point is in the corner.
    """
    require_type("pattern", pattern, Pattern)
    if not (np.abs(pattern.points) <= SAME_DISTANCE).all(axis=1).any():
        raise ProblemError(
            f"{pattern.name} lattice: no point in the corner of its cell, so it has no cells of a "
            "volume; shift the pattern"
        )
    return -1 / _largest_ratio(_volume_ratio, pattern, constants)


def _largest_ratio(
    ratio: Callable[[Pattern, Array, Array], float], pattern: Pattern, constants: Constants
) -> float:
    """Largest ratio of a wave's energies beside springs and in springs (N/m)."""
    require_type("pattern", pattern, Pattern)
    refuse_too_many("waves of a periodic cell", len(pattern.points), LARGEST_CELL)
    k = pattern.stiffness(constants)
    steps = 2 * math.pi / PHASES * (np.arange(PHASES) - PHASES // 2 + 1)
    # A wave and its opposite are one: half of the phases of the last axis will do.
    grid = np.array(list(product(*[steps] * (pattern.dim - 1), steps[steps >= 0])))
    grid = grid[np.abs(grid).max(axis=1) > 0]
    try:
        return max(ratio(pattern, k, phase) for phase in np.concatenate([grid, LONG * grid]))
    except LinAlgError as error:
        raise ProblemError(
            f"{pattern.name} lattice: some wave costs its central springs nothing; give constants "
            "that hold every point"
        ) from error


def _volume_ratio(pattern: Pattern, k: Array, phase: Array) -> float:
    """Largest ratio of the energies of cells' volumes with κ = 1 and of central springs."""
    n, d = pattern.points.shape
    (corner,) = np.flatnonzero((np.abs(pattern.points) <= SAME_DISTANCE).all(axis=1))
    size = np.array(pattern.size)
    slope = np.zeros((n, d), dtype=complex)  # of V by the motions: a side's area over its corners
    for place in product((0, 1), repeat=d):
        way = (2 * np.array(place) - 1) * np.prod(size) / size / 2 ** (d - 1)
        slope[corner] += np.exp(1j * (place @ phase)) * way
    stretch = _elongations(pattern, np.exp(1j * (pattern.image @ phase)))
    central = (stretch.conj().T * k) @ stretch
    volume = np.outer(slope.ravel().conj(), slope.ravel()) / np.prod(size)
    return float(eigvalsh(volume, central)[-1])


def _shear_ratio(pattern: Pattern, k: Array, phase: Array) -> float:
    """Largest ratio of the energies of shear and central springs over the motions of one wave."""
    n, d = pattern.points.shape
    turn = np.exp(1j * (pattern.image @ phase))
    m = len(turn)
    i, j = pattern.springs.T
    length = np.linalg.norm(pattern.vectors, axis=1)
    unit = pattern.vectors / length[:, None]
    stretch = _elongations(pattern, turn)
    gradient = _gradients(pattern, turn)
    mean = (gradient[i] + turn[:, None, None] * gradient[j]) / 2
    # s = L P (H + Hᵀ) n/2, with H_ab the gradient along b of the component a.
    along = np.einsum("mb,mbj->mj", unit, mean)
    seen = np.einsum("mj,ca->mcja", along, np.eye(d)) + np.einsum("mcj,ma->mcja", mean, unit)
    across = np.eye(d) - unit[:, :, None] * unit[:, None, :]
    shift = np.einsum("m,msc,mcja->msja", length / 2, across, seen).reshape(m * d, n * d)
    central = (stretch.conj().T * k) @ stretch
    shear = (shift.conj().T * np.repeat(k, d)) @ shift
    return float(eigvalsh(shear, central)[-1])


def _end_differences(pattern: Pattern, turn: Array) -> Array:
    """What springs see (m, n) of motions: their second end, at its image, less their first."""
    difference = np.zeros((len(turn), len(pattern.points)), dtype=complex)
    each = np.arange(len(turn))
    np.add.at(difference, (each, pattern.springs[:, 1]), turn)
    np.add.at(difference, (each, pattern.springs[:, 0]), -1.0)
    return difference


def _elongations(pattern: Pattern, turn: Array) -> Array:
    """Elongation of springs by motions (m, n·d)."""
    unit = pattern.vectors / np.linalg.norm(pattern.vectors, axis=1)[:, None]
    stretch = _end_differences(pattern, turn)[:, :, None] * unit[:, None, :]
    return np.asarray(stretch.reshape(len(turn), -1))


def _gradients(pattern: Pattern, turn: Array) -> Array:
    """Gradients (point, axis, point moved) by least squares over a point's springs, weights 1."""
    n, d = pattern.points.shape
    vector, difference = pattern.vectors, _end_differences(pattern, turn)
    A, right = np.zeros((n, d, d)), np.zeros((n, d, n), dtype=complex)
    # The second end sees all from its own cell.
    for end, seen in zip(pattern.springs.T, (np.ones(len(turn)), turn.conj()), strict=True):
        np.add.at(A, end, vector[:, :, None] * vector[:, None, :])
        np.add.at(right, end, vector[:, :, None] * (seen[:, None] * difference)[:, None, :])
    return np.asarray(np.linalg.solve(A, right))
