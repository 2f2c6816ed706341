"""A body filled with a lattice: points, springs, cells, facets, and what a boundary shares."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from itertools import combinations, product
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import Delaunay

from msvalidate.problem import Array, Box, Domain, Index, Mask, ProblemError
from msvalidate.problem.checks import (
    cell_counts,
    format_value,
    refuse_too_many,
    require_one_of,
    require_type,
)
from msvalidate.problem.records import ReadOnly, dataclass, field
from msvalidate.springs.lattice.pattern import Pattern
from msvalidate.springs.lattice.ties import break_ties

Kind = TypeVar("Kind", bound=np.generic)
VTK_ORDER = {2: (0, 1, 3, 2), 3: (0, 1, 3, 2, 4, 5, 7, 6)}
"""Number of axes -> corners of a box in VTK order, from x-fastest order."""


@dataclass(frozen=True, eq=False)
class Lattice(ReadOnly):
    """Points, springs and cells of a lattice that fills a body.

    Parameters
    ----------
    name
        Name of the lattice in tables.
    domain
        Body that the lattice fills.
    points
        Positions (m), shape (n, d).
    springs
        Pairs of points, shape (m, 2), the lower index first.
    cells
        Points of each cell, shape (c, corners), all of one shape, in VTK order.
    facets
        Points of each boundary facet, shape (f, corners): 2 corners in 2D; in 3D 3, or 4 with the
        first axis fastest.
    point_volume
        Area (m²) or volume (m³) of each point, shape (n,).
    kind
        Class of each spring, an index into the spring constants: (m,) or one for all.
    share
        Fraction of each spring that belongs to the body, (m,) or one for all: 1 inside, 1/2 on a
        side, 1/4 on an edge of a solid, and so on.
    sharing
        Number of cells that an identical spring inside the body borders: (m,) or one for all.
    factor
        Stiffness of springs inside, relative to the constant of their kind: (m,) or one for all.
    regular
        True if the facets belong to equal cells, so that a load on part of a side can end with
        them.
    boundary
        Rule for the boundary: "shared" (the default of `WEIGHTS`), "cut" (by the part of the cells
        inside the body) or "edges" (of a mesh).
    unit_cell
        Pattern that determines the spring constants, if there is one.
    """

    name: str
    domain: Domain
    points: Array
    springs: Index
    cells: Index
    facets: Index
    point_volume: Array
    kind: Index = field(default_factory=lambda: np.zeros((), dtype=np.intp))
    share: Array = field(default_factory=lambda: np.ones(()))
    sharing: Index = field(default_factory=lambda: np.ones((), dtype=np.intp))
    factor: Array = field(default_factory=lambda: np.ones(()))
    regular: bool = True
    boundary: str = "shared"
    unit_cell: Pattern | None = None

    def __post_init__(self) -> None:
        for name in ("kind", "share", "sharing", "factor"):
            each = np.asarray(getattr(self, name))
            if not each.ndim:
                object.__setattr__(self, name, np.full(len(self.springs), each))
        super().__post_init__()

    @property
    def vectors(self) -> Array:
        """Vector (m, d) in m along each spring."""
        return np.asarray(self.points[self.springs[:, 1]] - self.points[self.springs[:, 0]])

    @property
    def borders(self) -> Array:
        """Number (m,) of the body's cells that each spring borders."""
        return np.asarray(self.share * self.sharing)

    @property
    def kinds(self) -> int:
        """Number of kinds of spring."""
        return int(self.kind.max()) + 1


@dataclass(frozen=True, eq=False, kw_only=True)
class PatternLattice(Lattice):
    """Lattice of repeated unit cells: a `pattern` whose unit of length is `spacing` (m)."""

    pattern: Pattern
    spacing: float


WEIGHTS: Mapping[str, Callable[[Lattice], Array]] = {
    "shared": lambda lattice: lattice.share,
    "equal": lambda lattice: np.ones(len(lattice.springs)),
    "per_cell": lambda lattice: lattice.borders,
}
"""Rules for the weight (m,) of springs by the cells that they border: see `boundary_weights`."""


def boundary_weights(lattice: Lattice, rule: str) -> Array:
    """Weight (m,) of each spring, by the number of cells that it borders.

    ``shared``: a cell gives each of its edges its part, in the plane half, so a spring on the
    boundary counts 1/2. Every cell then carries the energy of the interior cell, and uniform strain
    costs the same everywhere: the consistent rule. ``equal``: every spring counts 1, the report's
    code. ``per_cell``: every cell brings springs of its own, so an inner axial spring of the plane
    counts 2, which is what the report's formula k2/(2k1 + k2) assumes.

    Raises `ProblemError` if the rule is none of `WEIGHTS`.
    """
    require_type("lattice", lattice, Lattice)
    require_one_of("boundary weights", rule, WEIGHTS)
    return WEIGHTS[rule](lattice)


def fill(pattern: Pattern, box: Box, cells: int | tuple[int, ...]) -> PatternLattice:
    """Fill a box with whole cells of a lattice pattern.

    Springs that would leave the box are removed. A spring in a side has boundary weight 1/2, one on
    an edge of a solid 1/4. Uniform tension is then exact at any size if every spring of the pattern
    lies inside a cell or on its sides. For other patterns (triangular, BCC, FCC with second
    neighbours) the boundary causes an error of first order in the spacing.

    Parameters
    ----------
    pattern
        Unit cell with a point in its corner.
    box
        Box of the same dimension d.
    cells
        Number of cells along each axis, d integers; one integer is the number across the narrowest
        side.

    Returns
    -------
    PatternLattice
        Points (n, d) in m, springs (m, 2), cells and facets.

    Raises
    ------
    ProblemError
        If the box has another dimension, a count is not a positive integer, the cells do not have
        the proportions of the pattern, or there are too many points.

    Examples
    --------
    >>> from msvalidate import Box, fill, patterns
    >>> lattice = fill(patterns.cubic18(), Box((0.2, 0.2, 0.1)), (4, 4, 2))
    >>> lattice.points.shape, lattice.spacing
    ((75, 3), 0.05)
    """
    require_type("pattern", pattern, Pattern)
    d = pattern.dim
    if not isinstance(box, Box) or box.dim != d:
        need = "a plane box, such as Box(4, 1)" if d == 2 else "a box of three lengths"
        raise ProblemError(f"{pattern.name} lattice: a {format_value(box)}; give {need}")
    n = cell_counts("cells", cells, d)
    if not isinstance(cells, tuple | list):
        cells_long = np.array(box.size) / pattern.size
        n = tuple(np.rint(n[0] * cells_long / cells_long.min()).astype(int).tolist())
    counted = " x ".join(map(str, n))
    refuse_too_many(
        f"{pattern.name} lattice of {counted} cells",
        len(pattern.points) * float(np.prod(np.add(n, 1, dtype=float))),
    )
    _refuse_other_proportions(pattern, box, n)
    number, points = _number_places(pattern, box, n)
    springs, which = number_springs(pattern, number)
    inside = np.nonzero(number >= 0)[-1]
    volume = box.volume / math.prod(n) * pattern.volume / math.prod(pattern.size)
    return PatternLattice(
        name=pattern.name,
        domain=box,
        points=points,
        springs=springs,
        kind=pattern.kind[which],
        cells=_box_corners(number[..., _at_corner(pattern)], d)[:, VTK_ORDER[d]],
        facets=_facets(pattern, number),
        share=side_share(points, springs, box),
        sharing=cells_bordered(pattern)[which],
        point_volume=volume[inside] * side_share(points, np.arange(len(points))[:, None], box),
        factor=pattern.factor[which],
        pattern=pattern,
        spacing=box.size[0] / n[0] / pattern.size[0],
    )


def _refuse_other_proportions(pattern: Pattern, box: Box, n: tuple[int, ...]) -> None:
    spacing = np.array(box.size) / n / pattern.size
    if np.abs(spacing - spacing[0]).max() <= 1e-9 * spacing[0]:
        if not _at_corner(pattern).any():
            raise ProblemError(
                f"{pattern.name} lattice: no point in the corner of its cell, so none would lie in "
                "the corners of a box; shift the pattern"
            )
        return
    cell = " x ".join(f"{edge:g} m" for edge in np.array(box.size) / n)
    if np.ptp(pattern.size):
        proportions = " : ".join(f"{edge:g}" for edge in pattern.size)
        remedy = f"its cells are as {proportions}: choose a box and counts that make them so"
    else:
        remedy = f"choose counts in the ratio {' : '.join(f'{edge:g}' for edge in box.size)}"
    raise ProblemError(
        f"{pattern.name} lattice: {' x '.join(map(str, n))} cells of {cell}; {remedy}"
    )


def _number_places(pattern: Pattern, box: Box, n: tuple[int, ...]) -> tuple[Index, Array]:
    """Numbers (.., n_y + 1, n_x + 1, points a cell) of all places, -1 outside, and positions."""
    d = pattern.dim
    grids = [np.linspace(0, length, count + 1) for length, count in zip(box.size, n, strict=True)]
    corner = np.stack(np.meshgrid(*reversed(grids), indexing="ij")[::-1], axis=-1)
    spacing = box.size[0] / n[0] / pattern.size[0]
    place = corner[..., None, :] + spacing * pattern.points
    inside = np.ones(place.shape[:-1], dtype=bool)
    for axis in range(d):
        # Of the last corners, beyond which there is no cell, only what lies in the side itself.
        last = _layer_view(inside, d, axis, n[axis])
        last &= _on_low_side(pattern, axis)
    number = np.full(inside.shape, -1)
    number[inside] = np.arange(inside.sum())
    return number, place[inside]


def number_springs(pattern: Pattern, number: Index) -> tuple[Index, Index]:
    """Springs (m, 2) between numbered places, the lower first, and their numbers in the pattern.

    Places are numbered (.., cells along y, cells along x, points a cell), -1 where none is. Springs
    that reach over more cells than there are have no room.
    """
    n = number.shape[-2::-1]
    pairs = []
    for (i, j), image in zip(pattern.springs, pattern.image, strict=True):
        steps = list(zip(image, n, strict=True))
        # A stop below 0 would count from the end, not leave nothing.
        start = [slice(max(0, -t), max(0, count - max(0, t))) for t, count in steps]
        end = [slice(max(0, t), max(0, count + min(0, t))) for t, count in steps]
        a, b = number[(*reversed(start), i)], number[(*reversed(end), j)]
        there = (a >= 0) & (b >= 0)
        pairs.append(np.sort(np.column_stack([a[there], b[there]]), axis=1))
    which = np.repeat(np.arange(len(pairs)), [len(pair) for pair in pairs])
    return np.concatenate(pairs), which


def side_share(points: Array, together: Index, box: Box) -> Array:
    """Fraction (k,) inside the box of each group of points (k, p).

    It is 1/2 for each side that all points of the group share.

    Of single points, p = 1, the part of their volume.
    """
    low, high = (points == 0)[together], (points == np.array(box.size))[together]
    return np.asarray(0.5 ** (low.all(axis=1) | high.all(axis=1)).sum(axis=1))


def weakly_supported(points: Array, springs: Index, least: float) -> Mask:
    """Mask (n,) of points with a smallest eigenvalue of Σ n nᵀ below `least`.

    The sum is over the directions n of the springs of a point.
    """
    vector = points[springs[:, 1]] - points[springs[:, 0]]
    normal = vector / np.linalg.norm(vector, axis=1)[:, None]
    held = np.zeros((len(points), points.shape[1], points.shape[1]))
    for end in springs.T:
        np.add.at(held, end, normal[:, :, None] * normal[:, None, :])
    return np.asarray(np.linalg.eigvalsh(held)[:, 0] < least)


def missing_springs(springs: Index, cells: Index, at: Mask) -> Index:
    """Edges (b, 2) of simplices at marked points that are not springs yet."""
    edges = np.concatenate([cells[:, pair] for pair in combinations(range(cells.shape[1]), 2)])
    edges = np.sort(edges[at[edges].any(axis=1)], axis=1)
    known = set(map(tuple, springs.tolist()))
    new = [pair for pair in np.unique(edges, axis=0).tolist() if tuple(pair) not in known]
    return np.array(new, dtype=np.intp).reshape(-1, 2)


def cells_bordered(pattern: Pattern) -> Index:
    """Number (m,) of cells at each spring, doubled by each side that contains it."""
    inside_sides = np.zeros(len(pattern.springs), dtype=int)
    i, j = pattern.springs.T
    for axis in range(pattern.dim):
        side = _on_low_side(pattern, axis)
        inside_sides += side[i] & side[j] & (pattern.image[:, axis] == 0)
    return np.asarray(2**inside_sides)


def _facets(pattern: Pattern, number: Index) -> Index:
    """Points of all boundary facets: segments, quadrilaterals, or triangles on a crowded face."""
    d = pattern.dim
    facets = []
    for axis in reversed(range(d)):
        on_side = _on_low_side(pattern, axis)
        for layer in (0, -1):
            there = _layer_view(number, d, axis, layer)[..., on_side]
            facets.append(
                _box_corners(there, d - 1)
                if on_side.sum() == 1
                else _cover_side(pattern, axis, there)
            )
    return np.concatenate(facets)


def _cover_side(pattern: Pattern, axis: int, there: Index) -> Index:
    """Segments or triangles (f, d) between the places numbered in a side across an axis.

    One cell's face is covered and then repeated, so that facets end where cells do: those of a
    whole side at once would straddle them wherever its points lie in squares at an angle.
    """
    others = [other for other in range(pattern.dim) if other != axis]
    size = np.array(pattern.size)[others]
    points = pattern.points[_on_low_side(pattern, axis)][:, others]
    low = np.abs(points) <= 1e-9 * size
    points = np.where(low, 0.0, points)
    # The closed face: what lies in a low edge of it lies in the high one too.
    images = np.array(list(product((0, 1), repeat=len(others))))
    image, point = np.nonzero((low | (images[:, None] == 0)).all(axis=2))
    places = points[point] + images[image] * size
    if len(others) == 1:
        order = np.argsort(places[:, 0], kind="stable")
        facets = np.column_stack([order[:-1], order[1:]])
    else:
        facets = Delaunay(break_ties(places)).simplices
    ends = (slice(None, -1), slice(1, None))
    numbers = [
        there[(*(ends[step] for step in reversed(images[i])), j)].ravel()
        for i, j in zip(image, point, strict=True)
    ]
    return np.concatenate([np.column_stack([numbers[k] for k in facet]) for facet in facets])


def _box_corners(number: Index, axes: int) -> Index:
    """Corners, x fastest, of all boxes between the places numbered in a grid (.., y, x, 1)."""
    grid = number[..., 0]
    low, high = slice(None, -1), slice(1, None)
    return np.column_stack([grid[corner].ravel() for corner in product((low, high), repeat=axes)])


def _layer_view(grid: NDArray[Kind], dim: int, axis: int, layer: int) -> NDArray[Kind]:
    """View of the places of a grid (.., n_y + 1, n_x + 1, points) in one layer across an axis."""
    place: list[slice | int] = [slice(None)] * dim
    place[dim - 1 - axis] = layer
    view: NDArray[Kind] = grid[tuple(place)]
    return view


def _on_low_side(pattern: Pattern, axis: int) -> Mask:
    """Mask (n,) of the points in the low side of the cell along an axis."""
    return np.asarray(np.abs(pattern.points[:, axis]) <= 1e-9 * pattern.size[axis])


def _at_corner(pattern: Pattern) -> Mask:
    """Mask (n,) of the pattern's points in the corner of the cell."""
    return np.asarray((np.abs(pattern.points) <= 1e-9 * np.array(pattern.size)).all(axis=1))
