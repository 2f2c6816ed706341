"""The highest frequency of an endless lattice, over all waves that it carries."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
from scipy.linalg import eigvalsh
from scipy.optimize import minimize

from msvalidate.lattice import Constants, Pattern
from msvalidate.problem import Array
from msvalidate.problem.checks import refuse_too_many, require_type

PHASES = 8
"""Of waves along each axis, even, so that pi is one."""
SAME_HEIGHT = 1e-9
"""Relative difference at which two squared frequencies count as different; rounding is 1e-14."""
LARGEST_CELL = 1000
"""Points of a cell up to which all frequencies of all waves are found: dense matrices."""


def highest_frequency(pattern: Pattern, constants: Constants) -> float:
    """Highest frequency squared times the mean mass of a point (N/m) of an endless lattice.

    Over all waves: the best of a grid of phases from cell to cell, 0 and pi among them, where
    lattices of near neighbours have theirs, and then uphill from there. Masses are in proportion to
    the points' volumes.

    Source: the dynamical matrix of a lattice, [BornHuang1954].

    Raises
    ------
    ProblemError
        If the constants are not one a kind, or the cell has too many points.
    """
    require_type("pattern", pattern, Pattern)
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
