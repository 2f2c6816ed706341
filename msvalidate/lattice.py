"""Floor 1: where the points sit, which of them are joined, and which cells the springs border."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from msvalidate.problem import Array, Box, Index, ProblemError, whole

WEIGHTS = ("shared", "equal", "per_cell")
"""Rules for the weight of a spring on the boundary: see `boundary_weights`."""


@dataclass(frozen=True, eq=False)
class Lattice:
    """Points, springs and cells of a regular lattice that fills a box.

    Parameters
    ----------
    name
        The lattice's name in tables.
    box
        The box that it fills.
    points
        (n, d) positions (m).
    springs
        (m, 2) pairs of points, the lower index first.
    kind
        (m,) class of each spring: an index into the spring constants (0 axial, 1 diagonal).
    cells
        (c, 2^d) points of each cell, x fastest.
    facets
        (f, 2^(d-1)) points of each boundary facet.
    borders
        (m,) number of cells that each spring borders.
    sharing
        (kinds,) number of cells that an interior spring of each kind borders.
    """

    name: str
    box: Box
    points: Array
    springs: Index
    kind: Index
    cells: Index
    facets: Index
    borders: Index
    sharing: Index

    def __post_init__(self) -> None:
        for item in fields(self):
            value = getattr(self, item.name)
            if isinstance(value, np.ndarray):
                value.setflags(write=False)

    @property
    def vectors(self) -> Array:
        """Vector (m, d) in m along each spring."""
        return np.asarray(self.points[self.springs[:, 1]] - self.points[self.springs[:, 0]])

    @property
    def cell_volume(self) -> float:
        """Area (m²) or volume (m³) of one cell."""
        return self.box.volume / len(self.cells)

    @property
    def point_volume(self) -> Array:
        """Area or volume (n,) of each point: an equal part of every cell that it borders."""
        borders = np.bincount(self.cells.ravel(), minlength=len(self.points))
        return np.asarray(borders * (self.cell_volume / self.cells.shape[1]))


def square(box: Box, cells: int | tuple[int, int]) -> Lattice:
    """Square lattice with eight neighbours: axial springs (kind 0) and diagonals (kind 1).

    Parameters
    ----------
    box
        Box in the plane; its cells must come out square.
    cells
        Number of cells along x and y; one number serves both.

    Raises
    ------
    ProblemError
        If the box is not plane, a count is not a positive integer, or the cells are not square.
    """
    if box.dim != 2:
        raise ProblemError(f"square lattice: a {box.dim}D box; give a plane one")
    nx, ny = _counts(cells)
    (width, height), (dx, dy) = box.size, (box.size[0] / nx, box.size[1] / ny)
    if abs(dx - dy) > 1e-9 * dx:
        raise ProblemError(
            f"square lattice: {nx} x {ny} cells of {dx:g} m x {dy:g} m; "
            f"choose counts in the ratio {width:g} : {height:g}"
        )
    y, x = np.meshgrid(np.linspace(0, height, ny + 1), np.linspace(0, width, nx + 1), indexing="ij")
    number = np.arange(x.size).reshape(ny + 1, nx + 1)
    corners = [number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:]]
    low_left, low_right, high_left, high_right = (corner.ravel() for corner in corners)

    along_x = _pairs(number[:, :-1], number[:, 1:])
    along_y = _pairs(number[:-1, :], number[1:, :])
    rising, falling = _pairs(low_left, high_right), _pairs(low_right, high_left)
    inner_row = np.pad(np.full(ny - 1, 2), 1, constant_values=1)
    inner_column = np.pad(np.full(nx - 1, 2), 1, constant_values=1)
    borders = [np.repeat(inner_row, nx), np.tile(inner_column, ny), np.ones(2 * nx * ny, int)]
    axial = len(along_x) + len(along_y)
    sides = (number[0], number[-1], number[:, 0], number[:, -1])
    return Lattice(
        name="square",
        box=box,
        points=np.column_stack([x.ravel(), y.ravel()]),
        springs=np.concatenate([along_x, along_y, rising, falling]),
        kind=np.repeat([0, 1], [axial, 2 * nx * ny]),
        cells=np.column_stack([low_left, low_right, high_left, high_right]),
        facets=np.concatenate([_pairs(side[:-1], side[1:]) for side in sides]),
        borders=np.concatenate(borders),
        sharing=np.array([2, 1]),
    )


def boundary_weights(lattice: Lattice, rule: str) -> Array:
    """Weight (m,) that each spring's constant takes from the cells that it borders.

    ``shared``: a cell gives each of its edges half, so a spring on the boundary counts 1/2. Every
    cell then carries the energy of the interior cell, and uniform strain costs the same everywhere:
    the consistent rule. ``equal``: every spring counts 1, the report's code. ``per_cell``: every
    cell brings springs of its own, so an inner axial spring counts 2, which is what the report's
    formula k2/(2k1 + k2) assumes.

    Raises
    ------
    ProblemError
        If the rule is none of `WEIGHTS`.
    """
    if rule == "shared":
        return lattice.borders / lattice.sharing[lattice.kind]
    if rule == "equal":
        return np.ones(len(lattice.springs))
    if rule == "per_cell":
        return lattice.borders.astype(float)
    raise ProblemError(f"boundary weights: {rule!r}; choose {', '.join(WEIGHTS)}")


def _counts(cells: int | tuple[int, int]) -> tuple[int, int]:
    pair = cells if isinstance(cells, tuple) else (cells, cells)
    if len(pair) != 2:
        raise ProblemError(f"cells: {cells!r}; give one or two whole numbers, 1 or more")
    return whole("cells", pair[0], 1), whole("cells", pair[1], 1)


def _pairs(start: Index, end: Index) -> Index:
    return np.column_stack([start.ravel(), end.ravel()])
