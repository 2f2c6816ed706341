"""Plane waves in a periodic lattice: highest frequency and smallest stable κ.

κ of cells' volumes may be below zero as long as every wave costs energy. Long waves ask for
λ + 2μ > 0, less than the bulk modulus does. Where the corners of the cells are all the points there
are, short ones ask for no more. Where they are not, the corners may swell their cells while the
other points stay: triangles in rectangular cells bear κ > -5/3 μ (in-plane nu > -1/2), FCC
κ > -5/4 μ (nu > -1/6).

A body asks for more where its boundary cuts springs but no cells: FCC of 2 x 2 x 2 cells is not
stable at nu = 0, BCC not at -1/2.
"""

from __future__ import annotations

import math
from itertools import product

import numpy as np
from scipy.linalg import LinAlgError, eigvalsh
from scipy.optimize import minimize
from scipy.sparse import csr_array, diags_array

from msvalidate.problem import Array, ProblemError
from msvalidate.problem.checks import finite_number, refuse_too_many, require_type
from msvalidate.springs.constants.cell_at_rest import elongations
from msvalidate.springs.lattice import Constants, Pattern
from msvalidate.springs.lattice.pattern import SAME_DISTANCE

PHASES = 8
"""Number of wave phases along each axis, even so that π is one."""
LONG = 1e-3
"""Phase of long waves, in rad per cell.

The effect of short waves is its square.
"""
SAME_HEIGHT = 1e-9
"""Relative difference at which two squared frequencies count as different; rounding is 1e-14."""
LARGEST_CELL = 1000
"""Maximum number of points per cell for dense matrices of all waves."""
LARGEST_SOFT = 100
"""Points of a cell up to which `least_stable_volume` looks at all waves."""


def highest_frequency(pattern: Pattern, constants: Constants, volume: float = 0.0) -> float:
    """Highest frequency squared times the mean mass of a point (N/m) of an endless lattice.

    Over all waves: the best of a grid of phases from cell to cell, 0 and pi among them, where
    lattices of near neighbours have theirs, and then uphill from there. Masses are in proportion to
    the points' volumes.

    Source: the dynamical matrix of a lattice, [BornHuang1954].

    Parameters
    ----------
    pattern, constants
        What repeats, and its springs' constants (N/m).
    volume
        κ of cells from corner to corner, as `springs.lattice.fill` makes them: in N/m in the
        plane; in space in Pa times the spacing.

    Raises
    ------
    ProblemError
        If the constants are not one a kind, the cell has too many points, or has a κ and no point
        in its corner.
    """
    require_type("pattern", pattern, Pattern)
    refuse_too_many("frequency of a periodic cell", len(pattern.points), LARGEST_CELL)
    k = pattern.stiffness(constants)
    kappa = finite_number("volume stiffness", volume)
    unit = max(float(k.max(initial=0.0)), abs(kappa)) or 1.0
    root = np.sqrt(np.repeat(pattern.volume / pattern.volume.mean(), pattern.dim))

    def square(phase: Array) -> float:
        stretch = _wave_elongations(pattern, phase)
        matrix = (stretch.conj().T @ diags_array(k / unit) @ stretch).toarray()
        if kappa:
            slope = _volume_slope(pattern, phase)
            matrix += kappa / unit * np.outer(slope.conj(), slope)
        return float(eigvalsh(matrix / np.outer(root, root))[-1])

    steps = 2 * math.pi / PHASES * np.arange(PHASES)
    # A wave and its opposite are one: half of the phases of the last axis will do.
    waves = product(*[steps] * (pattern.dim - 1), steps[: PHASES // 2 + 1])
    each = [(square(np.array(wave)), wave) for wave in waves]
    best = max(value for value, _ in each)
    # Of waves as high but for rounding, the first.
    start = next(wave for value, wave in each if value >= best * (1 - SAME_HEIGHT))
    options = {"xatol": 1e-8, "fatol": 1e-14}
    uphill = minimize(lambda q: -square(q), start, method="Nelder-Mead", options=options)
    return unit * max(best, -float(uphill.fun))


def least_stable_volume(pattern: Pattern, constants: Constants) -> float:
    """Smallest κ for which every wave has positive energy, at a spacing of 1 m.

    Of cells as `springs.lattice.fill` makes them: the pattern's own, from corner to corner. In
    the plane in N/m, at any spacing; in space in Pa, over the spacing.

    Source: stability by the energies of all waves, [BornHuang1954].

    Parameters
    ----------
    pattern, constants
        What repeats, with a point in the corner of its cell, and its springs' constants (N/m).

    Raises
    ------
    ProblemError
        If no point is in the corner, the constants are not one a kind, the cell has too many
        points, or some wave already costs the springs nothing.
    """
    require_type("pattern", pattern, Pattern)
    _corner(pattern)
    refuse_too_many("waves of a periodic cell", len(pattern.points), LARGEST_SOFT)
    k = pattern.stiffness(constants)
    steps = 2 * math.pi / PHASES * (np.arange(PHASES) - PHASES // 2 + 1)
    # A wave and its opposite are one: half of the phases of the last axis will do.
    grid = np.array(list(product(*[steps] * (pattern.dim - 1), steps[steps >= 0])))
    grid = grid[np.abs(grid).max(axis=1) > 0]
    try:
        return -1 / max(_volume_ratio(pattern, k, q) for q in np.concatenate([grid, LONG * grid]))
    except LinAlgError as error:
        raise ProblemError(
            f"{pattern.name} lattice: some wave costs its central springs nothing; give constants "
            "that hold every point"
        ) from error


def _volume_ratio(pattern: Pattern, k: Array, phase: Array) -> float:
    """Largest ratio of the energies of cells' volumes with κ = 1 and of central springs."""
    slope = _volume_slope(pattern, phase)
    stretch = _wave_elongations(pattern, phase).toarray()
    central = (stretch.conj().T * k) @ stretch
    return float(eigvalsh(np.outer(slope.conj(), slope), central)[-1])


def _volume_slope(pattern: Pattern, phase: Array) -> Array:
    """Slope (n·d,) of a cell's volume by the motions of a wave, over the root of the volume.

    Of each corner, a side's area over the side's corners.
    """
    n, d = pattern.points.shape
    size, place = np.array(pattern.size), np.array(list(product((0, 1), repeat=d)))
    way = (2 * place - 1) * math.sqrt(np.prod(size)) / size / 2 ** (d - 1)
    slope = np.zeros((n, d), dtype=complex)
    slope[_corner(pattern)] = np.exp(1j * (place @ phase)) @ way
    return slope.ravel()


def _corner(pattern: Pattern) -> int:
    """The point in the corner of its cell; raise `ProblemError` if none is."""
    (found,) = np.nonzero((np.abs(pattern.points) <= SAME_DISTANCE).all(axis=1))
    if not len(found):
        raise ProblemError(
            f"{pattern.name} lattice: no point in the corner of its cell, so it has no cells of a "
            "volume; shift the pattern"
        )
    return int(found[0])


def _wave_elongations(pattern: Pattern, phase: Array) -> csr_array:
    """Elongation of springs by motions (m, n·d) of a cell in a wave of phases (d,) a cell."""
    unit = pattern.vectors / np.linalg.norm(pattern.vectors, axis=1)[:, None]
    turn = np.exp(1j * (pattern.image @ phase))
    return elongations(len(pattern.points), pattern.springs, unit, turn)
