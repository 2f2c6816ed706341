"""Bodies as the report built them: points strewn inside a box, joined by Voronoi adjacency.

No point lies on a side. What is held or measured at a side are the points whose cells touch it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from msvalidate import kit
from msvalidate.springs.constants.stiffness import square_tensor
from msvalidate.springs.lattice.point_sets import periodic_points
from msvalidate.springs.lattice.tessellation import BoundedTessellation, bounded_tessellation
from msvalidate.springs.lattice.voronoi import relative_stiffness
from msvalidate.springs.network import spring_network

STRAIN = 1e-3
"""Of a stretched body; a linear answer is in proportion to it."""


@dataclass(frozen=True, eq=False)
class Strewn:
    """Cells of points inside a box of one point a unit of area, and springs between them."""

    cells: BoundedTessellation
    stiffness: kit.Array

    @property
    def box(self) -> kit.Box:
        """The body."""
        return kit.Box(self.cells.size)

    def at(self, side: str) -> kit.Mask:
        """Which points (n,) have cells that touch a side."""
        axis, end = kit.SIDES[side]
        return np.asarray(self.cells.side_area[:, 2 * axis + end] > 0)

    def ends(self, low: str, high: str) -> tuple[kit.Mask, kit.Mask]:
        """Points (n,) at two opposite sides, none at both.

        In a body of few points one cell may touch both sides. It counts with the low one, unless
        it is the last of all that touch the high one.
        """
        first, last = self.at(low), self.at(high)
        apart = last & ~first
        if not apart.any():
            axis, _ = kit.SIDES[high]
            apart[np.where(last, self.cells.points[:, axis], -np.inf).argmax()] = True
        return first & ~apart, apart

    def surface(self, side: str) -> kit.Index:
        """Numbers of the points whose cells touch a side, in order along it.

        On a line the cells of points come in the order of the points' places along it.
        """
        along = 1 - kit.SIDES[side][0]
        touching = np.flatnonzero(self.at(side))
        return touching[np.argsort(self.cells.points[touching, along], kind="stable")]


def strewn(points: str, count: int, stiffness: str, seed: int, aspect: float = 1.0) -> Strewn:
    """Random points in a box `aspect` times as long as high, one point a unit of area."""
    high = (count / aspect) ** 0.5
    size = (aspect * high, high)
    return from_points(periodic_points(points, count, size, seed), kit.Box(size), stiffness)


def from_points(points: kit.Array, box: kit.Box, stiffness: str) -> Strewn:
    """Any points in a box, their mean distance about 1 m."""
    cells = bounded_tessellation(points, box)
    return Strewn(cells, relative_stiffness(cells.vectors, cells.area, stiffness))


def stretch_body(body: Strewn, ends: str = "slide") -> tuple[kit.Problem, kit.Network]:
    """The body with the points at both ends moved apart by `STRAIN`, as the report would.

    The ends "slide" along themselves, are "clamped", or slide with the bottom on its line, as in
    "half" of a body. The problem is that of the whole box, its material a sheet of ratio 1/3, which
    no spring knows.
    """
    x, box = body.cells.points, body.box
    left, right = body.ends("left", "right")
    both = left | right
    first = np.arange(len(x)) == left.argmax()
    held = np.zeros(x.shape, dtype=bool)
    held[both, 0] = True
    held[{"slide": first, "clamped": both, "half": body.at("bottom")}[ends], 1] = True
    pull = STRAIN * gauge(body)
    move = np.zeros(x.shape)
    move[right, 0] = pull
    network = spring_network(x, body.cells.springs, body.stiffness, fixed=held, displacement=move)
    across = 0.0 if ends == "clamped" else None
    supports = [kit.Support(box.side("left"), (0.0, across))]
    supports.append(kit.Support(box.side("right"), (pull, across)))
    if ends != "clamped":
        bottom = box.side("bottom") if ends == "half" else kit.Region((0.0, 0.0))
        supports.append(kit.Support(bottom, (None, 0.0)))
    material = kit.Anisotropic(square_tensor(2 / 3, 1 / 3))
    return kit.Problem(box, material, tuple(supports), name=f"strewn, {ends}"), network


def gauge(body: Strewn) -> float:
    """Mean distance (m) of the held ends."""
    x = body.cells.points[:, 0]
    left, right = body.ends("left", "right")
    return float(x[right].mean() - x[left].mean())


def ratio(body: Strewn, displacement: kit.Array, place: str = "whole") -> float:
    """Poisson's ratio by means: change of the distance of top and bottom points, over `STRAIN`.

    Of all of the top and bottom, or of the eighth of their length next to each of the "ends". A
    place that has no points at the top or the bottom is widened to the whole.
    """
    x, y = body.cells.points.T
    here = np.abs(x / body.box.size[0] - 0.5) >= (3 / 8 if place == "ends" else 0.0)
    bottom, top = (points & here for points in body.ends("bottom", "top"))
    if not (top.any() and bottom.any()):
        return ratio(body, displacement)
    width = y[top].mean() - y[bottom].mean()
    change = displacement[top, 1].mean() - displacement[bottom, 1].mean()
    return float(-change / width / STRAIN)
