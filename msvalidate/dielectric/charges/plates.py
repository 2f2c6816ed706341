"""Plates of graded patches: rectangles and discs."""

from __future__ import annotations

import numpy as np

from msvalidate.dielectric.charges.patches import Patches
from msvalidate.problem import ProblemError
from msvalidate.problem.checks import (
    finite_number,
    format_value,
    length_in_metres,
    refuse_too_many,
    whole_number,
)

STEEPEST = 8.0
"""Largest exponent of grading: beyond it patches at edges are lost in rounding."""


def plate(
    sides: tuple[float, float], segments: int, *, height: float = 0.0, grading: float = 4.0
) -> Patches:
    """A rectangular plate about the z axis at z = height, of segments² rectangles.

    Parameters
    ----------
    sides
        In m.
    segments
        Along each side.
    height
        In m.
    grading
        The n-th line from a side is n to this power away: 1 for uniform patches.
    """
    if not isinstance(sides, tuple | list) or len(sides) != 2:
        raise ProblemError(f"sides: {format_value(sides)}; give two lengths in m")
    refuse_too_many("segments", float(whole_number("segments", segments, 1)) ** 2, what="patches")
    half = np.linspace(-1.0, 1.0, segments + 1)
    exponent = finite_number("grading", grading, least=1, most=STEEPEST)
    part = np.sign(half) * (1 - (1 - np.abs(half)) ** exponent)
    x, y = (0.5 * length_in_metres("side", side) * part for side in sides)
    left, low = (line.ravel() for line in np.meshgrid(x[:-1], y[:-1], indexing="ij"))
    right, high = (line.ravel() for line in np.meshgrid(x[1:], y[1:], indexing="ij"))
    across = np.column_stack([left, right, right, left])
    along = np.column_stack([low, low, high, high])
    corners = np.stack(
        [across, along, np.full_like(across, finite_number("height", height))], axis=-1
    )
    return Patches(corners, np.zeros(len(corners), dtype=np.intp), corners.mean(axis=1))


def disc(
    radius: float, rings: int, *, height: float = 0.0, sectors: int = 4, arcs: int = 64
) -> Patches:
    """A disc about the z axis at z = height, of rings·sectors polar patches.

    The rim is a regular polygon of the disc's area, so that what it bulges and what it lacks make
    no difference to first order.

    Parameters
    ----------
    radius, height
        In m.
    rings
        The n-th from the rim is n to the power of 4 away.
    sectors, arcs
        Patches in each ring, and straight sides that the arc of each is made of. The charge of a
        disc alone is the same all around, and few sectors serve.
    """
    inwards = np.linspace(1.0, 0.0, whole_number("rings", rings, 1) + 1)
    turns = whole_number("sectors", sectors, 2) * whole_number("arcs", arcs, 1)
    bulge = np.sqrt((2 * np.pi / turns) / np.sin(2 * np.pi / turns))
    refuse_too_many("rings", float(rings) * turns, what="corners of patches")
    r = length_in_metres("radius", radius) * bulge * (1 - inwards**4.0)
    angle = 2 * np.pi / turns * (arcs * np.arange(sectors)[:, None] + np.arange(arcs + 1))
    arc = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    outer, inner = r[1:, None, None, None] * arc, r[:-1, None, None, None] * arc[:, ::-1]
    flat = np.concatenate([outer, inner], axis=2).reshape(rings * sectors, -1, 2)
    half = 0.5 * (arc[:, arcs // 2] + arc[:, (arcs + 1) // 2])
    middle = (0.5 * (r[1:] + r[:-1])[:, None, None] * half).reshape(-1, 2)
    level = finite_number("height", height)
    return Patches(
        np.concatenate([flat, np.full((*flat.shape[:2], 1), level)], axis=-1),
        np.zeros(len(flat), dtype=np.intp),
        np.column_stack([middle, np.full(len(middle), level)]),
    )
