"""Grid lines of a slab's mesh, graded to electrode edges and slab corners.

At an edge of an electrode the potential goes as √r. Elements of degree p keep their order there if
lines stand at distances s^g from it, s evenly spaced, with g > 2p in theory
[BabuskaKelloggPitkaranta1979]; energies already have order 3 with g = 3. Farther out the
lines grow geometrically, so that a far boundary at many lengths of the slab costs little. Twice as
many lines are the same lines and one between each two.
"""

from __future__ import annotations

import itertools

import numpy as np

from msvalidate.problem import Array
from msvalidate.problem.checks import refuse_too_many
from reference_fem.electric.slab import Slab

STEEPEST = 2.0
"""Growth of distances in the far air, for each unit of s, is exp of this or of the grading."""
MOST_LINES = 100_000
"""Across the even part of a slab: with 40 layers one 7,500 times as long as high has so many."""


def mesh_lines(slab: Slab, half: int, grading: float, reach: float) -> tuple[Array, Array]:
    """Coordinates (m) of the mesh's lines along the slab and up it.

    Parameters
    ----------
    slab
        The question.
    half
        Lines within half a height of a face, or of an edge or corner.
    grading, reach
        As for `slab_mesh`.

    Raises
    ------
    ProblemError
        If the lines are too many.
    """
    near = 0.5 * slab.height
    out = _outwards(reach, near, half, grading)
    ends = sorted(e for electrode in slab.electrodes for e in (electrode.start, electrode.end))
    breaks = [0.0]
    for end in [*ends, slab.length]:
        if end - breaks[-1] > slab.tolerance:
            breaks.append(end)
    breaks[-1] = slab.length
    parts = [
        _between(start, end, near, half, grading)[:-1] for start, end in itertools.pairwise(breaks)
    ]
    up = _between(0.0, slab.height, near, half, grading)[:-1]
    return (
        np.concatenate([-out[::-1], *parts, [slab.length], slab.length + out]),
        np.concatenate([-out[::-1], up, [slab.height], slab.height + out]),
    )


def _between(start: float, end: float, near: float, half: int, grading: float) -> Array:
    """Lines from one edge or corner to the next: graded within `near` (m) of each, even between."""
    inner = end - start - 2 * near
    units = round(inner / (near * grading))
    refuse_too_many("mesh lines along the slab", units * half, MOST_LINES, "lines")
    reach = near if units > 0 else 0.5 * (end - start)
    close = reach * (np.arange(half + 1) / half) ** grading
    even = np.linspace(start + reach, end - reach, max(units, 0) * half + 1)
    return np.concatenate([start + close, even[1:-1], (end - close)[::-1][int(units <= 0) :]])


def _outwards(reach: float, near: float, half: int, grading: float) -> Array:
    """Distances (m) of lines from a face: graded up to `near`, then growing by one factor."""
    close = near * (np.arange(1, half + 1) / half) ** grading
    growth = np.log(reach / near)
    units = max(1, round(growth / max(grading, STEEPEST)))
    steps = np.arange(1, units * half + 1) / (units * half)
    return np.concatenate([close, near * np.exp(growth * steps)])
