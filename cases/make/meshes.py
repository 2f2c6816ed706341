"""Meshes of a grid: triangles, quadrilaterals, tetrahedra and hexahedra on the same nodes."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise, permutations

import numpy as np

from cases.make.statements import Grid
from msvalidate.problem import SHAPES, Mesh

Array = np.ndarray
GRADING = {2: (0.0, *(2.0**k for k in range(-9, 1))), 3: (0.0, 1 / 6, 1.0)}
FINER = {2: GRADING[2], 3: (0.0, 1 / 12, 1 / 3, 1.0)}
"""The same for meshes that are halved once only."""
"""Where the reference's lines are between an end at which stress is singular and the next."""
KINDS = {2: ("tri3", "quad4"), 3: ("tet4", "hex8")}
Sides = dict[str, Callable[[Array], Array]]
"""Name -> which places (n, d) in m lie on a side."""
MESHIO = {"tri3": "triangle", "quad4": "quad", "tet4": "tetra", "hex8": "hexahedron"}
"""Names of the cells in mesh files."""
QUADRATIC = {2: "quad9", 3: "hexahedron27"}


def lines(grid: Grid, halvings: int) -> list[Array]:
    """Parameters of a grid's lines along each axis, its cells halved so many times."""
    found = []
    for marks, cells in zip(grid.marks, grid.cells, strict=True):
        parts = [
            np.linspace(a, b, n * 2**halvings + 1)[:-1]
            for (a, b), n in zip(pairwise(marks), cells, strict=True)
        ]
        found.append(np.append(np.concatenate(parts), marks[-1]))
    return found


def graded_lines(grid: Grid, *, finer: bool = False) -> list[Array]:
    """Lines that crowd where stress is singular, to start the reference from."""
    found = []
    steps = np.array((FINER if finer else GRADING)[len(grid.marks)])
    for marks, cells, sharp in zip(grid.marks, grid.cells, grid.sharp, strict=True):
        parts = []
        for i, ((a, b), n) in enumerate(zip(pairwise(marks), cells, strict=True)):
            low, high = i in sharp, i + 1 in sharp
            if low and high:
                half = np.concatenate([steps / 2, 1 - steps[-2::-1] / 2])
            elif low or high:
                half = steps if low else 1 - steps[::-1]
            else:
                half = np.linspace(0.0, 1.0, max(n, 2) + 1)
            parts.append((a + (b - a) * half)[:-1])
        found.append(np.append(np.concatenate(parts), marks[-1]))
    return [no_longer(column, _longest_cell(grid)) for column in found]


def _longest_cell(grid: Grid) -> float:
    """Longest cell (m) along any axis of a body in space: its narrowest side."""
    if len(grid.marks) == 2:
        return np.inf
    return min(marks[-1] - marks[0] for marks in grid.marks)


def no_longer(column: Array, most: float) -> Array:
    """Lines with others amid where they are farther apart than that."""
    parts = []
    for a, b in pairwise(column):
        many = max(1, int(np.ceil((b - a) / most - 1e-9)))
        parts.append(a + (b - a) * np.arange(many) / many)
    return np.append(np.concatenate(parts), column[-1])


def grid_cells(columns: list[Array], grid: Grid) -> tuple[Array, Array, Array]:
    """Parameters (n, d) of nodes, cells (c, 2^d) in VTK order and each cell's place in the grid."""
    d = len(columns)
    shape = tuple(len(column) for column in columns)
    nodes = np.stack(np.meshgrid(*columns, indexing="ij"), axis=-1).reshape(-1, d)
    place = np.stack(np.meshgrid(*[np.arange(n - 1) for n in shape], indexing="ij"), axis=-1)
    place = place.reshape(-1, d)
    corners = [(0, 0), (1, 0), (1, 1), (0, 1)]
    around = np.array(corners if d == 2 else [(*c, k) for k in (0, 1) for c in corners])
    number = place[:, None, :] + around
    cells = np.ravel_multi_index(tuple(np.moveaxis(number, -1, 0)), shape)
    if grid.kept is not None:
        keep = grid.kept(nodes[cells].mean(axis=1))
        cells, place = cells[keep], place[keep]
    used, cells = np.unique(cells, return_inverse=True)
    return nodes[used], cells.reshape(-1, len(around)), place


def placed(grid: Grid, parameters: Array) -> Array:
    """Places (n, d) in m of parameters (n, d)."""
    return parameters if grid.place is None else grid.place(parameters)


def linear_meshes(grid: Grid, count: int) -> dict[str, tuple[Array, Array]]:
    """Name -> nodes (n, d) in m and cells, coarse to fine; coarser ones' nodes stand first."""
    d = len(grid.marks)
    found: dict[str, tuple[Array, Array]] = {}
    before = np.empty((0, d))
    for level in range(count):
        s, cells, place = grid_cells(lines(grid, level), grid)
        order = _coarse_first(s, before)
        s, cells = s[order], np.argsort(order)[cells]
        before = s
        suffix = f"_{level + 1}" if level else ""
        split = _triangles if d == 2 else _tetrahedra
        for kind, own in zip(KINDS[d], (split(cells, place), cells), strict=True):
            found[kind + suffix] = placed(grid, s), own
    return found


def coarsest_nodes(grid: Grid) -> Array:
    """Nodes (p, d) in m of the coarsest mesh, at which the set knows the answer."""
    points, _ = next(iter(linear_meshes(grid, 1).values()))
    return points


def _coarse_first(s: Array, before: Array) -> Array:
    """Order of nodes in which those of a coarser mesh stand first, as they stand there."""
    if not len(before):
        return np.arange(len(s))
    away = np.abs(s[None] - before[:, None]).max(axis=2)
    first = away.argmin(axis=1)
    assert away.min(axis=1).max() < 1e-12  # noqa: S101
    rest = np.setdiff1d(np.arange(len(s)), first)
    return np.concatenate([first, rest])


def _triangles(cells: Array, place: Array) -> Array:
    """Two triangles a quadrilateral, the diagonal one way and the other by turns."""
    even = place.sum(axis=1) % 2 == 0
    one = np.where(even[:, None], cells[:, [0, 1, 2]], cells[:, [0, 1, 3]])
    other = np.where(even[:, None], cells[:, [0, 2, 3]], cells[:, [1, 2, 3]])
    return np.stack([one, other], axis=1).reshape(-1, 3)


def _tetrahedra(cells: Array, _: Array) -> Array:
    """Six tetrahedra a hexahedron around its diagonal, one for each order of the axes."""
    base = ((0, 0), (1, 0), (1, 1), (0, 1))
    number: dict[tuple[int, ...], int] = {
        (*corner, k): 4 * k + i for i, corner in enumerate(base) for k in (0, 1)
    }
    found = []
    for order in permutations(range(3)):
        at = [0, 0, 0]
        corners = [number[tuple(at)]]
        for axis in order:
            at[axis] = 1
            corners.append(number[tuple(at)])
        sign = np.linalg.det(np.eye(3)[list(order)])
        found.append(cells[:, corners if sign > 0 else [corners[i] for i in (0, 2, 1, 3)]])
    return np.stack(found, axis=1).reshape(-1, 4)


def quadratic_mesh(grid: Grid, columns: list[Array]) -> tuple[Array, Array]:
    """Nodes (n, d) in m and cells of nine or 27 nodes in VTK order, on the body's own curves."""
    d = len(columns)
    fine = [_with_middles(column) for column in columns]
    shape = tuple(len(column) for column in fine)
    s = np.stack(np.meshgrid(*fine, indexing="ij"), axis=-1).reshape(-1, d)
    place = np.stack(np.meshgrid(*[np.arange(len(c) - 1) for c in columns], indexing="ij"), axis=-1)
    local = np.rint(2 * SHAPES[QUADRATIC[d]].nodes).astype(int)
    number = 2 * place.reshape(-1, 1, d) + local
    cells = np.ravel_multi_index(tuple(np.moveaxis(number, -1, 0)), shape)
    if grid.kept is not None:
        cells = cells[grid.kept(s[cells].mean(axis=1))]
    used, cells = np.unique(cells, return_inverse=True)
    return placed(grid, s[used]), cells.reshape(-1, len(local))


def _with_middles(column: Array) -> Array:
    found = np.empty(2 * len(column) - 1)
    found[::2] = column
    found[1::2] = (column[:-1] + column[1:]) / 2
    return found


def facets_of(points: Array, cells: Array, shape: str, sides: Sides | None) -> dict[str, Array]:
    """Facets on each named side: those all of whose nodes lie there."""
    if not sides:
        return {}
    surface = Mesh(points, cells, shape).surface
    return {
        name: surface[np.asarray(test(points))[surface].all(axis=1)] for name, test in sides.items()
    }
