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
import shapely
from numpy.typing import ArrayLike

from msvalidate.dielectric.charges.checks import (
    ROUNDED,
    check_error,
    check_voltages,
    refuse_dense,
)
from msvalidate.dielectric.charges.moments import factorise
from msvalidate.dielectric.kernels import polygons
from msvalidate.problem import PLACEMENT, Array, Index, ProblemError
from msvalidate.problem.checks import (
    finite_coordinates,
    finite_number,
    format_value,
    integers,
    length_in_metres,
    refuse_too_many,
    require_type,
    whole_number,
)
from msvalidate.problem.records import ReadOnly, dataclass

GRADING, SECTORS = 4.0, 4
"""The n-th line from an edge is n to this power away; patches in each ring of a disc, few, as the
charge of a disc alone is the same all around."""
OVERLAP = 1e-6
"""Largest overlap of two patches, relative to the smaller one.

Corners are rounded where patches meet along edges.
"""


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

    Raises
    ------
    ProblemError
        If a patch is not parallel to z = 0, has no area, crosses itself or is without its middle,
        or if patches overlap, or conductors touch.
    """

    corners: Array
    conductor: Index
    middle: Array

    def __post_init__(self) -> None:
        need = "give (n, c, 3), c above 2"
        corners = finite_coordinates("corners of patches", self.corners, "n>0", "c>2", 3, need=need)
        middle = finite_coordinates("middles of patches", self.middle, len(corners), 3)
        number = integers("conductor", self.conductor, len(corners))
        if not np.array_equal(known := np.unique(number), np.arange(len(known))):
            said = f"conductor: {format_value(known)}; count them 0, 1 and so on, leaving none out"
            raise ProblemError(said)
        near = PLACEMENT * float(np.ptp(corners.reshape(-1, 3), axis=0).max())
        _refuse_bodies(corners, number, middle, near)
        for name, value in {"corners": corners, "conductor": number, "middle": middle}.items():
            object.__setattr__(self, name, value)
        super().__post_init__()

    @property
    def area(self) -> Array:
        """(n,) in m², positive where corners are in counter-clockwise order."""
        first = self.corners[..., :2] - self.corners[:, :1, :2]
        second = np.roll(first, -1, axis=1)
        cross = first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]
        return np.asarray(0.5 * cross.sum(axis=1))


def _refuse_bodies(corners: Array, conductor: Index, middle: Array, near: float) -> None:
    """Raise `ProblemError` unless patches are level polygons with their middles, none on another.

    Lengths below `near` (m) are none.
    """
    flat = shapely.polygons(corners[..., :2])
    tilt = np.ptp(np.column_stack([corners[..., 2], middle[:, 2]]), axis=1)
    for bad, said in (
        (tilt > near, "its corners and middle differ in z; give a polygon parallel to z = 0"),
        ((shapely.area(flat) <= near**2) | ~shapely.is_valid(flat),
            "it has no area or crosses itself; give its corners in order"),
        (~shapely.intersects_xy(flat, *middle[:, :2].T),
            "its middle is beside it; give a point inside"),
    ):  # fmt: skip
        if bad.any():
            raise ProblemError(f"patch {bad.argmax()}: {said}")
    i, j = shapely.STRtree(flat).query(flat, predicate="dwithin", distance=near)
    level = (i < j) & (np.abs(corners[i, 0, 2] - corners[j, 0, 2]) <= near)
    i, j = i[level], j[level]
    shared = shapely.area(shapely.intersection(flat[i], flat[j]))
    over = shared > OVERLAP * np.minimum(shapely.area(flat[i]), shapely.area(flat[j]))
    for bad, said in (
        (conductor[i] != conductor[j], "they touch, and are of two conductors; leave a gap"),
        (over, "they overlap; let them share edges only"),
    ):
        if bad.any():
            raise ProblemError(f"patches {i[bad][0]} and {j[bad][0]}: {said}")


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
    """Capacitance over the permittivity (m) of one conductor to far away, or between two.

    Raises `ProblemError` for more than two, or as `patch_charges`.
    """
    require_type("patches", patches, Patches)
    if (count := int(patches.conductor.max()) + 1) > 2:
        raise ProblemError(f"patches: {count} conductors; a capacitance is of one or two")
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
