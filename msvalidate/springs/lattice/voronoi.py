"""Random lattices: springs between points whose Voronoi cells share a facet.

In the plane that joins each point with about six others, in space with about fifteen: the edges of
the Delaunay triangles and tetrahedra. The report tried it in the plane.
"""

from __future__ import annotations

import numpy as np

from msvalidate.problem import Array, Box
from msvalidate.problem.checks import length_in_metres, require_one_of, require_type, whole_number
from msvalidate.problem.records import dataclass
from msvalidate.springs.lattice.filled import Lattice, missing_springs, side_share, weakly_supported
from msvalidate.springs.lattice.pattern import Pattern
from msvalidate.springs.lattice.point_sets import box_points, periodic_points
from msvalidate.springs.lattice.tessellation import (
    Tessellation,
    bounded_tessellation,
    delaunay_simplices,
    periodic_tessellation,
)

STIFFNESS_RULES = ("1", "1/L", "A/L")
"""Rules for the stiffness of a spring of length L across a facet A."""
LOOSE = 1e-3
"""Smallest eigenvalue of Σ n nᵀ for which a point does not swing.

The sum is over the directions n of the point's springs.
"""


@dataclass(frozen=True, eq=False, kw_only=True)
class VoronoiLattice(Lattice):
    """Random lattice of Voronoi neighbours that fills a box.

    Parameters
    ----------
    side_area
        Length (m) or area (m²) of each side that belongs to each point, shape (n, 2d), in the order
        of `SIDES`. A traction on a whole side is distributed in proportion to it.
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
    """Generate a random periodic lattice of the neighbours in a Voronoi tessellation.

    The unit cell is a square or cube of volume `count`, so that the mean volume per point is 1.
    Sources: jittered points [Cook1986], blue noise [Yuksel2015].

    Parameters
    ----------
    count
        Number of points in the unit cell.
    dim
        Number of dimensions, 2 or 3.
    points
        Kind of random points: "uniform", "jittered" or "blue_noise".
    stiffness
        Stiffness of a spring of length L across a facet of area A, relative to the spring constant:
        "1", "1/L" or "A/L", with lengths in units of the mean spacing.
    seed
        Seed of the random numbers, an integer >= 0.

    Returns
    -------
    Pattern
        Unit cell with points (count, dim) and one kind of spring.

    Raises
    ------
    ProblemError
        If a value is out of its range.

    Examples
    --------
    >>> from msvalidate import voronoi
    >>> pattern = voronoi(100, seed=1)
    >>> pattern.points.shape, pattern.size
    ((100, 2), (10.0, 10.0))
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
    """Fill a box with a random lattice of Voronoi neighbours.

    Points lie in the corners, on the edges and sides, and inside. A spring in a side has boundary
    weight 1/2, one in two sides 1/4. Springs with stiffness A/L reproduce a hydrostatic strain
    exactly, except for braces that stabilise corner points. Cells are Delaunay triangles or
    tetrahedra.

    Parameters
    ----------
    box
        Box of dimension d.
    spacing
        Mean distance (m) of neighbours; the mean volume per point is spacing^d.
    points, stiffness, seed
        As for `voronoi`.

    Returns
    -------
    VoronoiLattice
        Points (n, d) in m and springs (m, 2), all of kind 0.

    Raises
    ------
    ProblemError
        If a value is out of its range, or there are too many points.
    SolverError
        If points are too close for their Voronoi cells to be determined.

    Examples
    --------
    >>> from msvalidate import Box, voronoi_box
    >>> lattice = voronoi_box(Box((0.37, 0.2)), spacing=0.05, seed=1)
    >>> print(f"{lattice.point_volume.sum():.6f} m²")
    0.074000 m²
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
