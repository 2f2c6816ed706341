"""Bodies as the report built them: points strewn inside a box, joined by Voronoi adjacency.

No point lies on a side. What is held or measured at a side are the points whose cells touch it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from msvalidate.constants.stiffness import square_tensor
from msvalidate.lattice.point_sets import periodic_points
from msvalidate.lattice.tessellation import BoundedTessellation, bounded_tessellation
from msvalidate.lattice.voronoi import relative_stiffness
from msvalidate.network import Network, spring_network
from msvalidate.problem import SIDES, Anisotropic, Array, Box, Index, Mask, Problem, Region, Support

STRAIN = 1e-3
"""Of a stretched body; a linear answer is in proportion to it."""


@dataclass(frozen=True, eq=False)
class Strewn:
    """Cells of points inside a box of one point a unit of area, and springs between them."""

    cells: BoundedTessellation
    stiffness: Array

    @property
    def box(self) -> Box:
        """The body."""
        return Box(self.cells.size)

    def weighted(self, stiffness: str) -> Strewn:
        """The same points and springs under another rule of stiffness."""
        cells = self.cells
        return Strewn(cells, relative_stiffness(cells.vectors, cells.area, stiffness))

    def at(self, side: str) -> Mask:
        """Which points (n,) have cells that touch a side."""
        axis, end = SIDES[side]
        return np.asarray(self.cells.side_area[:, 2 * axis + end] > 0)

    def ends(self, low: str, high: str) -> tuple[Mask, Mask]:
        """Points (n,) at two opposite sides, none at both.

        In a body of few points one cell may touch both sides. It counts with the low one, unless
        it is the last of all that touch the high one.
        """
        first, last = self.at(low), self.at(high)
        apart = last & ~first
        if not apart.any():
            axis, _ = SIDES[high]
            apart[np.where(last, self.cells.points[:, axis], -np.inf).argmax()] = True
        return first & ~apart, apart

    def surface(self, side: str) -> Index:
        """Numbers of the points whose cells touch a side, in order along it.

        On a line the cells of points come in the order of the points' places along it.
        """
        along = 1 - SIDES[side][0]
        touching = np.flatnonzero(self.at(side))
        return touching[np.argsort(self.cells.points[touching, along], kind="stable")]


def strewn(points: str, count: int, stiffness: str, seed: int, aspect: float = 1.0) -> Strewn:
    """Random points in a box `aspect` times as long as high, one point a unit of area."""
    high = (count / aspect) ** 0.5
    size = (aspect * high, high)
    return from_points(periodic_points(points, count, size, seed), Box(size), stiffness)


def from_points(points: Array, box: Box, stiffness: str) -> Strewn:
    """Any points in a box, their mean distance about 1 m."""
    cells = bounded_tessellation(points, box)
    return Strewn(cells, relative_stiffness(cells.vectors, cells.area, stiffness))


ENDS = ("slide", "clamped", "half")
"""How the pulled ends are held: free to slide along themselves; not; or free, and the bottom side
stays on its line, as it does in half of a body."""


def stretch_body(body: Strewn, ends: str = "slide") -> tuple[Problem, Network]:
    """The body with the points at both ends moved apart by `STRAIN`, as the report would.

    The problem is that of the whole box, its material a sheet of ratio 1/3, which no spring knows.
    """
    x, box = body.cells.points, body.box
    left, right = body.ends("left", "right")
    held = np.zeros(x.shape, dtype=bool)
    held[left | right, 0] = True
    if ends == "clamped":
        held[left | right, 1] = True
    elif ends == "half":
        held[body.at("bottom"), 1] = True
    else:
        held[np.flatnonzero(left)[0], 1] = True
    move = np.zeros(x.shape)
    move[right, 0] = STRAIN * gauge(body)
    network = spring_network(x, body.cells.springs, body.stiffness, held=held, displacement=move)
    across = 0.0 if ends == "clamped" else None
    supports = [
        Support(box.side("left"), (0.0, across)),
        Support(box.side("right"), (STRAIN * gauge(body), across)),
    ]
    if ends == "slide":
        supports.append(Support(Region((0.0, 0.0)), (None, 0.0)))
    elif ends == "half":
        supports.append(Support(box.side("bottom"), (None, 0.0)))
    material = Anisotropic(square_tensor(2 / 3, 1 / 3))
    return Problem(box, material, tuple(supports), name=f"strewn, {ends}"), network


def gauge(body: Strewn) -> float:
    """Mean distance (m) of the held ends."""
    x = body.cells.points[:, 0]
    left, right = body.ends("left", "right")
    return float(x[right].mean() - x[left].mean())


PLACES = ("whole", "middle", "ends")
"""Where the width is measured: on all of the top and bottom, the middle quarter of their length, or
the eighth next to each end."""


def ratio(body: Strewn, displacement: Array, place: str = "whole") -> float:
    """Poisson's ratio by means: change of the distance of top and bottom points, over `STRAIN`.

    A place that has no points at the top or the bottom is widened to the whole.
    """
    x, y = body.cells.points.T
    here = is_within_part(x / body.box.size[0], place)
    bottom, top = (points & here for points in body.ends("bottom", "top"))
    if not (top.any() and bottom.any()):
        return ratio(body, displacement)
    width = y[top].mean() - y[bottom].mean()
    change = displacement[top, 1].mean() - displacement[bottom, 1].mean()
    return float(-change / width / STRAIN)


def is_within_part(along: Array, place: str) -> Mask:
    """Which parts (n,) of the length, from 0 to 1, are at one of `PLACES`."""
    away = np.abs(along - 0.5)
    if place == "middle":
        return np.asarray(away <= 1 / 8)
    return np.asarray(away >= 3 / 8) if place == "ends" else np.ones(len(along), dtype=bool)
