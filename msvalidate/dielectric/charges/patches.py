"""Plates and discs in space, of flat patches: bodies whose capacitance is known verify the method.

A patch is a polygon parallel to the plane z = 0 that carries an even charge, whose potential is
exact (`kernels.polygons`); it is asked for at one point of each patch. In space the potential is
zero far away, so charges need not add up to nothing.

Charge grows without bound towards edges, and more so towards corners, so patches must be finer
there: where the n-th line lies n⁴ from an edge, 36 x 36 patches have the capacitance of a square to
1e-4 and 24 rings that of a disc to 5e-5. Means over patches in place of values at points (Galerkin)
halve these errors, for twice the time and a closed form that loses its digits on such meshes.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from msvalidate.dielectric.charges.checks import (
    ROUNDED,
    check_error,
    check_voltages,
    refuse_dense,
)
from msvalidate.dielectric.charges.moments import factorise
from msvalidate.dielectric.kernels import polygons
from msvalidate.problem import Array, Index, ProblemError
from msvalidate.problem.checks import (
    finite_number,
    format_value,
    length_in_metres,
    refuse_too_many,
    require_type,
    whole_number,
)
from msvalidate.problem.records import ReadOnly, dataclass

GRADING, SECTORS = 4.0, 4
"""The n-th line from an edge is n to this power away; patches in each ring of a disc, few, as the
charge of a disc alone is the same all around."""


@dataclass(frozen=True, eq=False)
class Patches(ReadOnly):
    """Conductors without thickness, each of patches at one potential, none on another.

    Parameters
    ----------
    corners
        (n, c, 3) of polygons parallel to z = 0 (m), in order, either way round. A corner that is
        given several times in a row counts once.
    conductor
        (n,) which conductor each patch belongs to: 0, 1, ..., none left out.
    middle
        (n, 3) a point of each patch, where its potential is asked for (m).
    """

    corners: Array
    conductor: Index
    middle: Array

    @property
    def area(self) -> Array:
        """(n,) in m², positive where corners are in counter-clockwise order."""
        first = self.corners[..., :2] - self.corners[:, :1, :2]
        second = np.roll(first, -1, axis=1)
        cross = first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]
        return np.asarray(0.5 * cross.sum(axis=1))


def patch_charges(patches: Patches, voltages: ArrayLike) -> Array:
    """Charges (n,) over the permittivity (V·m) of conductors at potentials (k,) in V.

    Potentials are over that far away.

    Raises
    ------
    ProblemError
        If patches are too many, or there is not one voltage a conductor.
    SolverError
        If rounding leaves the charges no digits.
    """
    require_type("patches", patches, Patches)
    refuse_dense("patches", len(patches.corners))
    given = check_voltages("a conductor", int(patches.conductor.max()) + 1, voltages)
    # Signed as the way round that corners are given in, as what is seen is.
    seen = polygons.seen(patches.middle, patches.corners) / patches.area
    inverse, condition = factorise(seen / (4 * np.pi), symmetric=False)
    check_error(ROUNDED * condition)
    return np.asarray(inverse(given[patches.conductor]))


def patch_capacitance(patches: Patches) -> float:
    """Capacitance over the permittivity (m) of one conductor to far away, or between two."""
    voltages = (0.5, -0.5) if patches.conductor.any() else (1.0,)
    return float(patch_charges(patches, voltages)[patches.conductor == 0].sum())


def conductors(first: Patches, second: Patches) -> Patches:
    """Two bodies of patches with as many corners, together."""
    return Patches(
        np.concatenate([first.corners, second.corners]),
        np.concatenate([first.conductor, second.conductor + 1]),
        np.concatenate([first.middle, second.middle]),
    )


def plate(sides: tuple[float, float], segments: int, *, height: float = 0.0) -> Patches:
    """A rectangular plate about the z axis, of segments² graded rectangles; lengths in m."""
    if not isinstance(sides, tuple | list) or len(sides) != 2:
        raise ProblemError(f"sides: {format_value(sides)}; give two lengths in m")
    refuse_too_many("segments", float(whole_number("segments", segments, 1)) ** 2, what="patches")
    half = np.linspace(-1.0, 1.0, segments + 1)
    part = np.sign(half) * (1 - (1 - np.abs(half)) ** GRADING)
    x, y = (0.5 * length_in_metres("side", side) * part for side in sides)
    left, low = (line.ravel() for line in np.meshgrid(x[:-1], y[:-1], indexing="ij"))
    right, high = (line.ravel() for line in np.meshgrid(x[1:], y[1:], indexing="ij"))
    across = np.column_stack([left, right, right, left])
    along = np.column_stack([low, low, high, high])
    corners = np.stack(
        [across, along, np.full_like(across, finite_number("height", height))], axis=-1
    )
    return Patches(corners, np.zeros(len(corners), dtype=np.intp), corners.mean(axis=1))


def disc(radius: float, rings: int, *, arcs: int = 64) -> Patches:
    """A disc about the z axis on z = 0, of rings of graded polar patches.

    The rim is a regular polygon of the disc's area, so that what it bulges and what it lacks make
    no difference to first order.

    Parameters
    ----------
    radius
        In m.
    rings
        Their number.
    arcs
        Straight sides that the arc of each patch is made of.
    """
    inwards = np.linspace(1.0, 0.0, whole_number("rings", rings, 1) + 1)
    turns = SECTORS * whole_number("arcs", arcs, 1)
    bulge = np.sqrt((2 * np.pi / turns) / np.sin(2 * np.pi / turns))
    refuse_too_many("rings", float(rings) * turns, what="corners of patches")
    r = length_in_metres("radius", radius) * bulge * (1 - inwards**GRADING)
    angle = 2 * np.pi / turns * (arcs * np.arange(SECTORS)[:, None] + np.arange(arcs + 1))
    arc = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    outer, inner = r[1:, None, None, None] * arc, r[:-1, None, None, None] * arc[:, ::-1]
    flat = np.concatenate([outer, inner], axis=2).reshape(rings * SECTORS, -1, 2)
    half = 0.5 * (arc[:, arcs // 2] + arc[:, (arcs + 1) // 2])
    middle = (0.5 * (r[1:] + r[:-1])[:, None, None] * half).reshape(-1, 2)
    return Patches(
        np.pad(flat, ((0, 0), (0, 0), (0, 1))),
        np.zeros(len(flat), dtype=np.intp),
        np.pad(middle, ((0, 0), (0, 1))),
    )
