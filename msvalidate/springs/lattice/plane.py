"""2D lattices: square, square at 45 degrees, and triangular."""

from __future__ import annotations

import math

import numpy as np

from msvalidate.problem import MOST_VERTICES, Array, Box, Polygon, ProblemError, format_point
from msvalidate.problem.checks import cell_counts, format_value, length_in_metres, refuse_too_many
from msvalidate.springs.lattice import patterns
from msvalidate.springs.lattice.filled import Lattice, fill
from msvalidate.springs.lattice.pattern import pattern_by_shells

SIN60 = math.sin(math.pi / 3)


def square(box: Box, cells: int | tuple[int, int]) -> Lattice:
    """Fill a 2D box with a square lattice with eight neighbours per point.

    Parameters
    ----------
    box
        2D box.
    cells
        Number of cells along x and y; one integer is the number across the narrowest side. The
        cells must be square.

    Returns
    -------
    PatternLattice
        Points (n, 2) in m and springs (m, 2), of kind 0 along the axes and of kind 1 along
        diagonals.

    Raises
    ------
    ProblemError
        As for `fill`.

    Examples
    --------
    >>> from msvalidate import Box, square
    >>> lattice = square(Box((0.4, 0.1)), (4, 1))
    >>> lattice.points.shape, lattice.springs.shape
    ((10, 2), (21, 2))
    """
    return fill(patterns.square(), box, cells)


def diagonal_square(box: Box, cells: int | tuple[int, int]) -> Lattice:
    """Square lattice with eight neighbours, cut at 45 degrees.

    The box is divided into squares whose sides are *diagonal* springs, with a point in the middle
    of each: axial springs run along the squares' half diagonals. The cut halves the lattice's own
    cells, and a half cell has lost one of its diagonals: it is no longer the material. Squares and
    errors are as the cells of `square`.
    """
    side, rules = math.sqrt(2), patterns.square().rules
    middles = [(0, 0), (side / 2, side / 2)]
    whole = fill(pattern_by_shells("square", (side, side), middles, (1.0, side), rules), box, cells)
    ring, middle = whole.cells.T, np.setdiff1d(np.arange(len(whole.points)), whole.cells)
    quarters = [np.column_stack([ring[k - 1], ring[k], middle]) for k in range(4)]
    return Lattice(
        name="square at 45°",
        domain=box,
        points=whole.points,
        springs=whole.springs,
        kind=whole.kind,
        cells=np.concatenate(quarters),
        facets=whole.facets,
        share=whole.share,
        sharing=np.array(2),
        point_volume=whole.point_volume,
        unit_cell=patterns.square(),  # a turn changes no isotropic solid
    )


def triangular(outline: Polygon, spacing: float) -> Lattice:
    """Fill a polygon with a triangular lattice with six neighbours per point.

    Parameters
    ----------
    outline
        Union of whole equilateral triangles, such as the functions ``zigzag_block`` and
        ``trapezium`` of this module return. The first vertex is a lattice point and the first edge
        a lattice direction.
    spacing
        Side (m) of the triangles.

    Returns
    -------
    Lattice
        Points (n, 2) in m and springs (m, 2), all of kind 0.

    Raises
    ------
    ProblemError
        If whole triangles of this side do not fill the outline, or there are too many points.

    Examples
    --------
    >>> from msvalidate import Polygon, triangular
    >>> outline = Polygon(((0.0, 0.0), (0.4, 0.0), (0.2, 0.2 * 3**0.5)))
    >>> lattice = triangular(outline, spacing=0.1)
    >>> lattice.points.shape, lattice.springs.shape
    ((15, 2), (30, 2))
    """
    if not isinstance(outline, Polygon):
        raise ProblemError(
            f"triangular lattice: a {format_value(outline)}; give a Polygon, such as zigzag_block"
        )
    h = length_in_metres("triangular lattice: spacing", spacing)
    origin = outline.corners[0]
    along = outline.corners[1] - origin
    along *= h / np.linalg.norm(along)
    upward = np.array([along[0] - SIN60 * 2 * along[1], SIN60 * 2 * along[0] + along[1]]) / 2
    steps = np.linalg.solve(np.column_stack([along, upward]), (outline.corners - origin).T)
    _refuse_other_outline(outline, h, steps)
    low, high = np.round(steps.min(axis=1)), np.round(steps.max(axis=1))
    refuse_too_many(f"triangular lattice of spacing {h:g} m", math.prod((high - low + 1).tolist()))
    i, j = np.meshgrid(*map(np.arange, low, high + 1), indexing="ij")
    points = origin + i.reshape(-1, 1) * along + j.reshape(-1, 1) * upward
    number = np.arange(i.size).reshape(i.shape)
    here, ahead, above = number[:-1, :-1].ravel(), number[1:, :-1].ravel(), number[:-1, 1:].ravel()
    beyond = number[1:, 1:].ravel()
    triangles = np.concatenate(
        [np.column_stack([here, ahead, above]), np.column_stack([ahead, beyond, above])]
    )
    inside = triangles[outline.contains(points[triangles].mean(axis=1))]
    used, cells = np.unique(inside, return_inverse=True)
    cells = cells.reshape(-1, 3)
    edges = np.sort(cells[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    springs, borders = np.unique(edges, axis=0, return_counts=True)
    return Lattice(
        name="triangular",
        domain=outline,
        points=points[used],
        springs=springs,
        cells=cells,
        facets=springs[borders == 1],
        share=borders / 2,
        sharing=np.array(2),
        point_volume=np.bincount(cells.ravel()).astype(float) * outline.volume / (3 * len(cells)),
        unit_cell=patterns.triangular(),
    )


def zigzag_block(height: float, cells: tuple[int, int]) -> Polygon:
    """Outline of a block of equilateral triangles: left and right straight, the others zigzag.

    The left side is `height` (m) long, along y. Cells are the number of strips of triangles along
    x, even so that both ends are of this height, and of triangle sides along the height. Every
    second column of points is one point shorter, so the block is symmetric about its middle line;
    it is cells[0]·√3/2·height/cells[1] wide.

    Raises `ProblemError` if the number of strips is odd, or a value is out of range.
    """
    strips, sides = _pair("zigzag block", cells, "(strips, sides)")
    if strips % 2 or sides < 2:
        raise ProblemError(f"zigzag block: cells {cells}; give an even number of strips, 2 sides")
    refuse_too_many("zigzag block", 2 * strips + 2, MOST_VERTICES, "vertices")
    h = length_in_metres("zigzag block: height", height) / sides
    x = [column * SIN60 * h for column in range(strips + 1)]
    inset = [0.5 * h * (column % 2) for column in range(strips + 1)]
    top = [(a, height - b) for a, b in zip(x, inset, strict=True)]
    bottom = list(zip(x, inset, strict=True))
    # The first edge is the left side, which gives the direction of the rows.
    return Polygon((top[0], *bottom, *reversed(top[1:])))


def trapezium(spacing: float, cells: tuple[int, int]) -> Polygon:
    """Outline of a bar of equilateral triangles with straight sides and ends at 60°.

    Triangles have sides of `spacing` (m). Cells are the number of their sides along the top and of
    their rows; the bottom has the sum.

    Raises `ProblemError` if a value is out of range.
    """
    h = length_in_metres("trapezium: spacing", spacing)
    sides, rows = _pair("trapezium", cells, "(sides, rows)")
    refuse_too_many("trapezium", (rows + 1) * (sides + 1 + rows / 2))
    height, slant = rows * SIN60 * h, 0.5 * rows * h
    length = (sides + rows) * h
    return Polygon(((0.0, 0.0), (length, 0.0), (length - slant, height), (slant, height)))


def _refuse_other_outline(outline: Polygon, side: float, steps: Array) -> None:
    """Whole triangles make up an outline whose edges run along rows from point to point.

    `steps` (2, n) leads to its corners: along the first edge, and along that turned by 60 degrees.
    """
    nearest = np.round(steps)
    off = np.abs(steps - nearest).max(axis=0) * side > outline.tolerance
    i, j = np.roll(nearest, -1, axis=1) - nearest
    bad = np.flatnonzero(np.roll(off, -1) | ((i != 0) & (j != 0) & (i + j != 0)))
    if len(bad):
        edge = f"{bad[0]} of the outline, from {format_point(outline.corners[bad[0]])}"
        raise ProblemError(
            f"triangular lattice: no row of triangles of side {side:g} m runs along edge {edge}; "
            "choose a spacing that divides every edge, and edges at multiples of 60 degrees"
        )


def _pair(name: str, cells: tuple[int, int], both: str) -> tuple[int, int]:
    """Two counts of different things, for which one number cannot serve."""
    if not isinstance(cells, tuple | list):
        raise ProblemError(f"{name}: cells {format_value(cells)}; give two whole numbers, {both}")
    first, second = cell_counts("cells", cells)
    return first, second
