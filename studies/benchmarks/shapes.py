"""Bodies with curved outlines as mapped meshes of quadratic cells, any refinement of them.

A smooth map takes a grid of the unit square or cube to the body, its mid-side nodes too, so every
edge of a cell is a parabola through three points of the true outline: the outline is off by the
fourth power of the cells' size at its worst. Meshes that halve their cells hold the same map, which
is what an observed order needs.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np
from scipy.spatial import KDTree

from msvalidate import kit

INNER, OUTER = (2.0, 1.0), (3.25, 2.75)
"""Half-axes (m) of the ellipses of NAFEMS LE1 and LE10."""
FOCUS = np.sqrt(INNER[0] ** 2 - INNER[1] ** 2)
"""Half the distance of the foci (m), of either ellipse."""
THICKNESS = 0.6
"""Of the plate of LE10 (m)."""
JOINT = 1e-9
"""Distance, relative to the body, below which nodes of neighbouring patches are one."""
SQUARE = ((0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1), (1, 1))
"""Places of the 9 nodes of a cell in VTK's order, in half cells."""
BASE = ((0, 0), (2, 0), (2, 2), (0, 2))
ROUND = ((1, 0), (2, 1), (1, 2), (0, 1))
CUBE = (
    *((i, j, k) for k in (0, 2) for i, j in BASE),
    *((i, j, k) for k in (0, 2) for i, j in ROUND),
    *((i, j, 1) for i, j in BASE),
    *((0, 1, 1), (2, 1, 1), (1, 0, 1), (1, 2, 1), (1, 1, 0), (1, 1, 2), (1, 1, 1)),
)
"""The same of the 27 nodes of a hexahedron: corners, edges, faces, centre."""
LINE = ((0,), (2,), (1,))
PLACES = {1: LINE, 2: SQUARE, 3: CUBE}


class PatchMesh(NamedTuple):
    """Nodes (n, d) in m, cells (c, 9 or 27) and named facets (f, 3 or 9), all in VTK's order."""

    points: kit.Array
    cells: kit.Index
    boundaries: dict[str, kit.Index]

    @property
    def mesh(self) -> kit.Mesh:
        """The body as a domain."""
        shape = "quad9" if self.points.shape[1] == 2 else "hexahedron27"
        return kit.Mesh(self.points, self.cells, shape, self.boundaries)


Map = Callable[[kit.Array], kit.Array]
"""Places (n, d) in the unit square or cube to places (n, d) of the body (m)."""


def patch(
    place: Map, lines: Sequence[kit.Array], names: Mapping[tuple[int, int], str]
) -> PatchMesh:
    """Mesh of a mapped unit square or cube.

    Parameters
    ----------
    place
        The map; it must not turn the square over.
    lines
        Along each axis of the square or cube where its cells end, from 0 to 1.
    names
        (axis, 0 or 1) -> name of the side at that end of the axis; the others have none.
    """
    ends = [np.interp(np.arange(0, len(at) - 0.75, 0.5), np.arange(len(at)), at) for at in lines]
    unit = np.stack(np.meshgrid(*ends, indexing="ij"), axis=-1)
    number = np.arange(unit[..., 0].size).reshape(unit.shape[:-1])
    boundaries = {
        name: gather_cells(np.take(number, -end, axis=axis)) for (axis, end), name in names.items()
    }
    return PatchMesh(place(unit.reshape(-1, len(lines))), gather_cells(number), boundaries)


def even_lines(cells: int) -> kit.Array:
    """Ends (cells + 1,) of equal cells of the unit interval."""
    return np.linspace(0, 1, cells + 1)


def halve_cells(lines: kit.Array, end: float, times: int) -> kit.Array:
    """The lines with the cell or cells that end there halved, those that then end there again."""
    for _ in range(times):
        at = int(np.abs(lines - end).argmin())
        beside = [i for i in (at - 1, at) if 0 <= i < len(lines) - 1]
        lines = np.sort(np.concatenate([lines, [lines[i : i + 2].mean() for i in beside]]))
    return lines


def gather_cells(number: kit.Index) -> kit.Index:
    """Cells of a grid of node numbers, two half cells along each axis of every cell."""
    starts = product(*(range(0, n - 1, 2) for n in number.shape))
    corner = np.array(list(starts))[:, None, :] + np.array(PLACES[number.ndim])[None]
    return np.asarray(number[tuple(np.moveaxis(corner, -1, 0))])


def join_patches(patches: Sequence[PatchMesh]) -> PatchMesh:
    """One mesh of patches that share sides node by node; sides of one name become one."""
    points = np.concatenate([part.points for part in patches])
    reach = JOINT * float(np.ptp(points, axis=0).max())
    # Of nodes in one place the first stands for all.
    first = np.array([min(near) for near in KDTree(points).query_ball_point(points, reach)])
    kept, number = np.unique(first, return_inverse=True)
    starts = np.cumsum([0, *(len(part.points) for part in patches[:-1])])
    boundaries: dict[str, list[kit.Index]] = {}
    for part, start in zip(patches, starts, strict=True):
        for name, facets in part.boundaries.items():
            boundaries.setdefault(name, []).append(number[facets + start])
    cells = [number[part.cells + start] for part, start in zip(patches, starts, strict=True)]
    sides = {name: np.concatenate(facets) for name, facets in boundaries.items()}
    return PatchMesh(points[kept], np.concatenate(cells), sides)


def elliptic_quarter(n: int) -> PatchMesh:
    """Quarter between the ellipses of LE1: n cells from hole to rim, 2n round the quarter.

    Sides: "hole", "rim", "bottom" (y = 0) and "left" (x = 0).
    """
    names = {(0, 0): "hole", (0, 1): "rim", (1, 0): "bottom", (1, 1): "left"}
    return patch(_between_ellipses, (even_lines(n), even_lines(2 * n)), names)


def elliptic_plate(n: int, halvings: int = 0) -> PatchMesh:
    """Plate of LE10: the quarter of LE1 in four layers, two halves and the upper halved twice.

    The stress that is asked for is on the upper face. `halvings`: how often the cells along the
    middle of the rim are halved towards it. Sides as in `elliptic_quarter`, and "lower" (z = 0) and
    "upper".
    """
    through = halve_cells(halve_cells(even_lines(2), 1.0, 2), 0.5, halvings)
    lines = (halve_cells(even_lines(n), 1.0, halvings), even_lines(2 * n), through)
    names = {(0, 0): "hole", (0, 1): "rim", (1, 0): "bottom", (1, 1): "left"}
    return patch(_extruded, lines, names | {(2, 0): "lower", (2, 1): "upper"})


def clamped_plate(n: int, wider: float = 0.0) -> PatchMesh:
    """Plate of LE10 for a rim that is held all over: cells halved twice towards its edges.

    Six layers; n + 2 cells from hole to rim, along straight lines between the ellipses, and 2n
    round. `wider`: how far (m) the rim's half-axes lie beyond those of the plate. Sides as in
    `elliptic_plate`.
    """

    def place(unit: kit.Array) -> kit.Array:
        angle = np.pi / 2 * unit[:, 1]
        turn = on_axes(np.column_stack([np.cos(angle), np.sin(angle)]))
        s = unit[:, :1]
        flat = turn * ((1 - s) * np.array(INNER) + s * (np.array(OUTER) + wider))
        return np.column_stack([flat, THICKNESS * unit[:, 2]])

    through = halve_cells(halve_cells(even_lines(2), 1.0, 2), 0.0, 2)
    names = {(0, 0): "hole", (0, 1): "rim", (1, 0): "bottom", (1, 1): "left"}
    lines = (halve_cells(even_lines(n), 1.0, 2), even_lines(2 * n), through)
    return patch(place, lines, names | {(2, 0): "lower", (2, 1): "upper"})


def ring_quarter(inner: float, outer: float, n: int) -> PatchMesh:
    """Quarter ring (m): n cells from hole to rim, graded in proportion to the radius, n round it.

    Sides as in `elliptic_quarter`.
    """

    def place(unit: kit.Array) -> kit.Array:
        radius = inner * (outer / inner) ** unit[:, 0]
        angle = np.pi / 2 * unit[:, 1]
        return radius[:, None] * on_axes(np.column_stack([np.cos(angle), np.sin(angle)]))

    return patch(
        place,
        (even_lines(n), even_lines(n)),
        {(0, 0): "hole", (0, 1): "rim", (1, 0): "bottom", (1, 1): "left"},
    )


def holed_plate(radius: float, half_width: float, half_length: float, n: int) -> PatchMesh:
    """Quarter of a plate with a circular hole at its centre; x runs across it, y along it (m).

    Each eighth of the square about the hole has n cells round it and 2n towards the side, graded in
    proportion to the radius; the rest of the plate has cells as wide as high, or nearly.
    Sides: "hole", "side" (x = half_width), "end" (y = half_length), "bottom" and "left".
    """
    # Less than 1 cell as long as wide at the far end would be graded for nothing.
    rest = max(1, round(n * (half_length - half_width) / half_width))
    eighths = [
        patch(
            lambda unit: _from_hole(radius, half_width, unit),
            (even_lines(2 * n), even_lines(n)),
            {(0, 0): "hole", (0, 1): "side", (1, 0): "bottom"},
        ),
        patch(
            lambda unit: _from_hole(radius, half_width, unit + np.array([0, 1])),
            (even_lines(2 * n), even_lines(n)),
            {(0, 0): "hole", (1, 1): "left"},
        ),
    ]

    def beyond(unit: kit.Array) -> kit.Array:
        across = half_width * np.tan(np.pi / 4 * unit[:, 0])  # as the eighths end on it
        along = half_width + (half_length - half_width) * unit[:, 1]
        return np.column_stack([across, along])

    sides = {(0, 0): "left", (0, 1): "side", (1, 1): "end"}
    return join_patches([*eighths, patch(beyond, (even_lines(n), even_lines(rest)), sides)])


def on_axes(points: kit.Array) -> kit.Array:
    """Points with coordinates that are zero but for rounding set to zero."""
    return np.where(np.abs(points) < 1e-15 * np.abs(points).max(), 0.0, points)


def _between_ellipses(unit: kit.Array) -> kit.Array:
    """Elliptic coordinates: x + iy = c cosh(m + ia); the ellipses of LE1 share their foci, ±c.

    The map is conformal, and its cells are smallest where the hole bends most, at (2, 0).
    """
    low, high = (np.arctanh(b / a) for a, b in (INNER, OUTER))
    m = low + (high - low) * unit[:, 0]
    angle = np.pi / 2 * unit[:, 1]
    wide, high_ = np.cosh(m) * np.cos(angle), np.sinh(m) * np.sin(angle)
    return on_axes(FOCUS * np.column_stack([wide, high_]))


def _extruded(unit: kit.Array) -> kit.Array:
    return np.column_stack([_between_ellipses(unit[:, :2]), THICKNESS * unit[:, 2]])


def _from_hole(radius: float, half_width: float, unit: kit.Array) -> kit.Array:
    """Two eighths, second coordinate 0 to 1 and 1 to 2, from the hole to the square about it.

    Along a ray the distance from the centre grows by equal factors near the hole; the rays' ends on
    the square belong to equal angles.
    """
    angle = np.pi / 4 * unit[:, 1]
    turn = on_axes(np.column_stack([np.cos(angle), np.sin(angle)]))
    reach = half_width / np.abs(turn).max(axis=1)
    distance = radius * (reach / radius) ** unit[:, 0]
    return np.asarray(distance[:, None] * turn)
