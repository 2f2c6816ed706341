"""Slabs: a square lattice bonded at its bottom, with electrodes below and above."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from msvalidate.dielectric.actuator.device import Actuator
from msvalidate.dielectric.actuator.uniform import relaxed_thickness
from msvalidate.problem import Box, ProblemError
from msvalidate.problem.checks import (
    finite_number,
    format_value,
    length_in_metres,
    positive_number,
    require_one_of,
    require_type,
    whole_number,
)
from msvalidate.springs.lattice import boundary_weights, square
from msvalidate.springs.network import spring_network

SIDES = ("free", "sliding")
WHOLE = 1e-6
"""Deviation from a whole number of cells that is rounding."""


def slab(
    length: float,
    height: float,
    cells: int,
    *,
    covered: float = 1.0,
    axial: float = 1.0,
    diagonal: float = 0.5,
    permittivity: float = 1.0,
    prestretch: float = 1.0,
    sides: str = "free",
    depth: float = 1.0,
    model: str = "plane",
    permittivity_ratio: float = 1.0,
) -> Actuator:
    """A slab of squares with diagonals, bonded at its bottom; the bottom electrode covers it all.

    Springs on the surface count half, so that each cell carries the energy of one inside.

    A pre-stretch scales the film along x before it is bonded: springs keep the rest lengths of the
    unstretched lattice, points are λ times as far apart along x and as far along y as leaves the
    top without force (`uniform.relaxed_thickness`). With sliding sides that is a rest position;
    free ones draw back until the bonded bottom stops them.

    Parameters
    ----------
    length, height
        Of the film before it is stretched (m); it lies from 0 along x and y.
    cells
        Up the height; as many along the length as makes them squares.
    covered
        Part of the length under the top electrode, in the middle; it must end at points.
    axial, diagonal
        Spring constants per depth (Pa): k1 along the axes, k2 along the diagonals.
    permittivity, depth, model, permittivity_ratio
        As in `Actuator`.
    prestretch
        λ, length after over length before.
    sides
        "free", or "sliding": held along x, as between frictionless walls.

    Raises
    ------
    ProblemError
        If cells are no squares, the top electrode does not end at points, or a value is out of
        range.
    """
    width, tall = length_in_metres("length", length), length_in_metres("height", height)
    layers = whole_number("cells", cells, 1)
    require_one_of("sides", sides, SIDES)
    columns = round(width * layers / tall)
    if columns < 1 or abs(columns - width * layers / tall) > WHOLE:
        raise ProblemError(
            f"length: {width * layers / tall:.6g} cells along it; give a whole multiple of "
            "height/cells"
        )
    lattice = square(Box((width, tall)), (columns, layers))
    k = np.array(
        [positive_number("axial", axial, "Pa"), positive_number("diagonal", diagonal, "Pa")]
    )
    stretched = positive_number("prestretch", prestretch)
    deep = positive_number("depth", depth, "m")
    x, y = lattice.points.T
    bonded = y == 0
    gripped = ((x == 0) | (x == x.max())) if sides == "sliding" else bonded
    network = spring_network(
        lattice.points * [stretched, relaxed_thickness(stretched, axial=k[0], diagonal=k[1])],
        lattice.springs,
        deep * k[lattice.kind] * boundary_weights(lattice, "shared"),
        rest_length=np.linalg.norm(lattice.vectors, axis=1),
        mass=deep * lattice.point_volume,
        fixed=np.column_stack([bonded | gripped, bonded]),
    )
    upper, lower = np.flatnonzero(y == y.max()), np.flatnonzero(bonded)
    top, bottom = (at[np.argsort(x[at], kind="stable")] for at in (upper, lower))
    bare = _bare_columns(covered, columns)
    facing = top[bare : len(top) - bare], bottom
    return Actuator(network, facing, permittivity, model, deep, permittivity_ratio)


def fix_near_tips(actuator: Actuator, within: float) -> Actuator:
    """The same actuator with all points near an edge of its top electrode held where they start.

    The field is endless at an edge, so the last points are pulled in first, at a voltage that
    falls with the size of the cells; held, they let the rest show what it does.

    Parameters
    ----------
    actuator
        What to hold.
    within
        Distance (m) from an edge, at the start, up to which points are held; 0 holds the edges.

    Raises
    ------
    ProblemError
        If the distance is below zero, or nothing is left to move.
    """
    require_type("actuator", actuator, Actuator)
    distance = finite_number("distance from a tip", within, least=0, unit="m")
    network, top = actuator.network, actuator.electrodes[0]
    start = network.start
    away = np.linalg.norm(start[:, None] - start[top[[0, -1]]], axis=2).min(axis=1)
    near = away <= distance + WHOLE * float(np.ptp(start, axis=0).max()) / len(start)
    held = network.fixed | near[:, None]
    if held.all():
        raise ProblemError(f"distance from a tip: {distance:g} m; it holds every point, give less")
    return replace(actuator, network=replace(network, fixed=held))


def _bare_columns(covered: float, columns: int) -> int:
    """Cells on either side of the top electrode."""
    part = positive_number("covered", covered)
    if part > 1:
        raise ProblemError(
            f"covered: {format_value(covered)}; give a part of the length, at most 1"
        )
    bare = 0.5 * (1 - part) * columns
    if abs(bare - round(bare)) > WHOLE or 2 * round(bare) >= columns:
        ends = columns - 2 * np.clip(round(bare), 0, (columns - 1) // 2)
        raise ProblemError(
            f"covered: {part:g} ends between points of {columns} cells; take {ends}/{columns}"
        )
    return round(bare)
