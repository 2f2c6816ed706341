"""Random lattices: springs between points whose Voronoi cells share a facet.

In the plane that joins each point with about six others, in space with about fifteen: the edges of
the Delaunay triangles and tetrahedra. The report tried it in the plane.
"""

from __future__ import annotations

import numpy as np

from msvalidate.lattice.filled import Lattice, missing_springs, side_share, weakly_supported
from msvalidate.lattice.pattern import Pattern
from msvalidate.lattice.point_sets import box_points, periodic_points
from msvalidate.lattice.tessellation import (
    Tessellation,
    bounded_tessellation,
    delaunay_simplices,
    periodic_tessellation,
)
from msvalidate.problem import Array, Box
from msvalidate.problem.checks import length_in_metres, require_one_of, require_type, whole_number
from msvalidate.problem.records import dataclass

STIFFNESS_RULES = ("1", "1/L", "A/L")
"""What the stiffness of a spring is proportional to: nothing, or its length L and facet area A."""
LOOSE = 1e-3
"""Σ n nᵀ along some direction, over the directions n of its springs, below which a point swings."""


@dataclass(frozen=True, eq=False, kw_only=True)
class VoronoiLattice(Lattice):
    """A random lattice in a box, whose sides are shared out among Voronoi cells.

    `side_area` (n, 2d) is the part (m or m²) of each side that is a point's own, in the order of
    `SIDES`: its springs need just that of a traction, whatever the facets.
    """

    side_area: Array


def voronoi(
    count: int = 100,
    *,
    dim: int = 2,
    points: str = "jittered",
    stiffness: str = "A/L",
    seed: int = 0,
) -> Pattern:
    """Random periodic lattice: a cell of `count` points, one in a unit of volume on average.

    Points are of a kind of `point_sets.POINT_SETS`, by random numbers of some seed, in 2 or 3
    dimensions. By the stiffness, one of `lattice.voronoi.STIFFNESS_RULES`, each spring of the
    constant k has k, k/L or k·A/L, in spacings.

    Raises `ProblemError` if a value is out of its range.
    """
    whole_number("dim", dim, 2, 3)
    size = (float(whole_number("number of points", count, 1)) ** (1 / dim),) * dim
    return pattern_of_tessellation(
        periodic_tessellation(periodic_points(points, count, size, seed), size), stiffness
    )


def pattern_of_tessellation(tessellation: Tessellation, stiffness: str) -> Pattern:
    """The periodic lattice of a tessellation whose mean spacing is the unit of length.

    Raises `ProblemError` if there is no such stiffness.
    """
    require_type("tessellation", tessellation, Tessellation)
    m = len(tessellation.springs)
    return Pattern(
        name="Voronoi",
        size=tessellation.size,
        points=tessellation.points,
        springs=tessellation.springs,
        image=tessellation.image,
        kind=np.zeros(m, dtype=np.intp),
        rules={"unit": (1.0,)},
        factor=relative_stiffness(tessellation.vectors, tessellation.area, stiffness),
        volume=tessellation.volume,
    )


def relative_stiffness(vectors: Array, area: Array, rule: str) -> Array:
    """Stiffness (m,) of springs relative to their constant, from vectors and areas in spacings.

    Raises `ProblemError` if there is no such rule.
    """
    require_one_of("stiffness", rule, STIFFNESS_RULES)
    length = np.linalg.norm(vectors, axis=1)
    top = {"1": length, "1/L": np.ones(len(length)), "A/L": area}[rule]
    return np.asarray(top / length)


def voronoi_box(
    box: Box, spacing: float, *, points: str = "jittered", stiffness: str = "A/L", seed: int = 0
) -> VoronoiLattice:
    """Random lattice that fills a box: points in its corners, on its edges and sides, and inside.

    A spring in a side has half of its facet inside the box, one in two sides a quarter: its share.
    A side is shared out among the points whose Voronoi cells reach it, most of them on it. That
    closes the cells, Σ A n = 0, so springs as A/L carry a hydrostatic strain exactly, but for the
    braces below. Cells are the Delaunay triangles or tetrahedra, facets those of their sides on the
    boundary. A corner whose cell meets but one other inside the box would swing about it: it gets
    the other edges of its triangles or tetrahedra too.

    The spacing is the mean distance (m) of neighbours: a point has the volume spacing^d. All else
    is as in `voronoi`.

    Raises `ProblemError` if a value is out of its range; `SolverError` if points lie so close that
    their cells can't be told apart.
    """
    require_type("box", box, Box)
    h = length_in_metres("spacing", spacing)
    cells = bounded_tessellation(box_points(points, box, h, seed), box)
    x = cells.points
    corners, facets = delaunay_simplices(x, box)
    braces = missing_springs(cells.springs, corners, weakly_supported(x, cells.springs, LOOSE))
    springs = np.concatenate([cells.springs, braces])
    share = side_share(x, springs, box)
    # A brace has no facet in the box; it gets a mean one.
    area = np.concatenate([cells.area, np.full(len(braces), cells.area.mean())]) / share
    vectors = x[springs[:, 1]] - x[springs[:, 0]]
    return VoronoiLattice(
        name="Voronoi",
        domain=box,
        points=x,
        springs=springs,
        cells=corners,
        facets=facets,
        share=share,
        point_volume=cells.volume,
        factor=relative_stiffness(vectors / h, area / h ** (box.dim - 1), stiffness),
        regular=False,
        side_area=cells.side_area,
    )
