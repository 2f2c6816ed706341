"""Unit cell of a periodic lattice: its points and springs as data."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from msvalidate.problem import Array, Index, ProblemError
from msvalidate.problem.checks import (
    finite,
    finite_coordinates,
    format_value,
    indices,
    integers,
    length_in_metres,
    refuse_too_many,
    require_type,
    whole_number,
)
from msvalidate.problem.records import dataclass, field, replace
from msvalidate.springs.lattice.ties import level_numbers

Constants = tuple[float, ...]
"""Spring constants (N/m; Pa for 3D mesh edges), one per kind."""
SAME_DISTANCE = 1e-9
"""Distances closer than this fraction are one."""


class SpringFormulas(NamedTuple):
    """Formulas for the springs of a lattice, as text for users.

    They are in μ and λ (written ``{λ}``), the thickness t and the spacing h.

    Parameters
    ----------
    kinds
        Where the springs of each kind run, and their stiffness (N/m) by central springs; empty if
        no formula is known.
    zero_length
        Stiffness (N/m) of all springs by the route "neo-Hookean"; empty if it is not known.
    source
        Key of docs/references.bib.
    """

    kinds: tuple[tuple[str, str], ...] = ()
    zero_length: str = ""
    source: str = "BornHuang1954"


@dataclass(frozen=True, eq=False)
class Pattern:
    """Rectangular unit cell of a periodic lattice, with lengths in units of the spacing.

    The edges of the cell lie along the axes.

    A lattice is a function without arguments that returns one; `patterns.all_patterns` finds it.

    Parameters
    ----------
    name
        The lattice's name in tables.
    size
        (d,) edge lengths of the cell.
    points
        (n, d) places in the cell: 0 <= x < size.
    springs, image
        (m, 2) pairs of points, each spring once, and (m, d) how many cells away along each axis
        the second one lies.
    kind
        (m,) class of each spring: an index into the spring constants.
    rules
        Spring constants by the name of what they are for.
    tensor
        The homogenised stiffness in closed form: a function of the constants (N/m) that returns the
        Voigt tensor, (3, 3) in N/m or (6, 6) in Pa at a spacing of 1 m; None where there is none.
    factor
        (m,) stiffness of each spring relative to the constant of its kind, by default 1.
    volume
        (n,) area or volume of the cell that belongs to each point, in units of the spacing; by
        default equal. They sum to that of the cell.
    formulas
        Constants of its springs as text, a row a kind or none.

    Raises
    ------
    ProblemError
        If an array does not fit the others, a spring has no length or is listed twice, or volumes
        do not sum to that of the cell.
    """

    name: str
    size: tuple[float, ...]
    points: Array
    springs: Index
    image: Index
    kind: Index
    rules: Mapping[str, Constants]
    tensor: Callable[[Constants], Array] | None = None
    factor: Array = field(default_factory=lambda: np.ones(0))
    volume: Array = field(default_factory=lambda: np.ones(0))
    formulas: SpringFormulas = SpringFormulas()

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name.isprintable() or not self.name:
            raise ProblemError(f"pattern: name {format_value(self.name)}; give a word")
        said = f"pattern {self.name}"
        size = _cell_edges(said, self.size)
        d = len(size)
        points = finite_coordinates(f"{said}: points", self.points, "n>0", d)
        if (points < 0).any() or (points >= size).any():
            raise ProblemError(f"{said}: points reach outside the cell; give 0 <= x < size")
        n = len(points)
        springs = indices(f"{said}: springs", self.springs, n, "m>0", 2)
        m = len(springs)
        factor = self.factor if np.size(self.factor) else np.ones(m)
        volume = self.volume if np.size(self.volume) else np.full(n, math.prod(self.size) / n)
        arrays = {
            "points": points,
            "springs": springs,
            "image": integers(f"{said}: image", self.image, m, d),
            "kind": integers(f"{said}: kind", self.kind, m),
            "factor": finite(f"{said}: factor", factor, m),
            "volume": finite(f"{said}: volume", volume, n),
        }
        for name, array in arrays.items():
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        self._refuse_misfits(said)
        self._refuse_twins(said)
        if not isinstance(self.rules, Mapping) or not self.rules:
            raise ProblemError(
                f"{said}: rules {format_value(self.rules)}; give constants by their names"
            )
        for rule, constants in self.rules.items():
            self.stiffness(constants, rule)
        if not (self.tensor is None or callable(self.tensor)):
            raise ProblemError(
                f"{said}: tensor {format_value(self.tensor)}; give a function or None"
            )

    def _refuse_misfits(self, name: str) -> None:
        kinds = sorted(set(self.kind.tolist()))
        if kinds != list(range(len(kinds))):
            raise ProblemError(f"{name}: kinds {kinds}; count from 0 without a gap")
        if len(self.formulas.kinds) not in {0, len(kinds)}:
            raise ProblemError(
                f"{name}: formulas of {len(self.formulas.kinds)} kinds; give {len(kinds)}, or none"
            )
        if (self.factor < 0).any() or (self.volume <= 0).any():
            raise ProblemError(f"{name}: a factor below 0 or a volume not above; give neither")
        cell = math.prod(self.size)
        if abs(self.volume.sum() - cell) > 1e-9 * cell:
            raise ProblemError(
                f"{name}: volumes sum to {self.volume.sum():g}, the cell has {cell:g}; share it out"
            )

    def _refuse_twins(self, name: str) -> None:
        """Raise `ProblemError` for a spring without length, or one listed twice.

        A spring that is listed from its other end counts as the same.
        """
        if not np.linalg.norm(self.vectors, axis=1).all():
            raise ProblemError(f"{name}: a spring has no length; leave it out")
        there = np.column_stack([self.springs, self.image])
        back = np.column_stack([self.springs[:, ::-1], -self.image])
        both = np.concatenate([there, back])
        if len(np.unique(both, axis=0)) < len(both):
            raise ProblemError(f"{name}: a spring is listed twice; list each from one end")

    @property
    def dim(self) -> int:
        """Number of axes, 2 or 3."""
        return len(self.size)

    @property
    def kinds(self) -> int:
        """Number of kinds of spring."""
        return int(self.kind.max()) + 1

    @property
    def vectors(self) -> Array:
        """Vector (m, d) along each spring."""
        i, j = self.springs.T
        return np.asarray(self.points[j] + self.image * np.array(self.size) - self.points[i])

    def stiffness(self, constants: Constants, rule: str = "constants") -> Array:
        """Stiffness (m,) in N/m of the springs under constants, one a kind.

        Raises `ProblemError` if they are not one a kind, or one is negative or not finite.
        """
        k = finite(f"{self.name}: spring constants", constants)
        said = f"{self.name}: spring {rule} {format_value(constants)}"
        if k.shape != (self.kinds,):
            raise ProblemError(f"{said}; give {self.kinds}, one a kind")
        if (k < 0).any():
            raise ProblemError(f"{said}; none may be negative")
        return np.asarray(k[self.kind] * self.factor)


def _cell_edges(name: str, size: tuple[float, ...]) -> Array:
    """Edge lengths (d,) of a cell."""
    if not isinstance(size, tuple) or len(size) not in {2, 3}:
        raise ProblemError(f"{name}: size {format_value(size)}; give a tuple of 2 or 3 lengths")
    return np.array([length_in_metres(f"{name}: cell edge", edge) for edge in size])


def pattern_by_shells(
    name: str,
    size: tuple[float, ...],
    points: ArrayLike,
    distances: tuple[float, ...],
    rules: Mapping[str, Constants],
    tensor: Callable[[Constants], Array] | None = None,
    formulas: SpringFormulas = SpringFormulas(),  # noqa: B008  it is never changed
) -> Pattern:
    """Pattern whose springs join all points at some distances in spacings, one kind each.

    All else is as in `Pattern`.

    Raises `ProblemError` if no two points are at a distance, or as for `Pattern`.
    """
    edges = _cell_edges(f"pattern {name}", size)
    d, x = len(edges), finite_coordinates(f"pattern {name}: points", points)
    far = finite_coordinates(f"pattern {name}: distances", distances)
    if x.shape != (len(x), d) or far.ndim != 1 or not len(far) or (far <= 0).any():
        raise ProblemError(
            f"pattern {name}: points {x.shape}, distances {format_value(distances)}; give (n, {d}) "
            "and lengths above 0"
        )
    reach = np.ceil(far.max() / edges).astype(int).tolist()
    counted = len(x) ** 2 * math.prod(2.0 * r + 1 for r in reach)
    refuse_too_many(f"pattern {name}", counted, what="pairs of points")
    images = np.array(list(product(*(range(-r, r + 1) for r in reach))))
    i, j, t = np.indices((len(x), len(x), len(images))).reshape(3, -1)
    image = images[t]
    vectors = x[j] + image * edges - x[i]
    length = np.linalg.norm(vectors, axis=1)
    # Of a spring's two directions the one that goes up, or else backwards, or else to the right.
    sign = np.where(np.abs(vectors) > SAME_DISTANCE, np.sign(vectors), 0)
    once = (sign @ 3 ** np.arange(d)) > 0
    chosen, kind = [], []
    for number, distance in enumerate(distances):
        at = np.flatnonzero(once & (np.abs(length - distance) <= SAME_DISTANCE * distance))
        if not len(at):
            raise ProblemError(f"pattern {name}: no two points are {distance:g} spacings apart")
        # By direction, along the first axis first: (1, 0), (0, 1) and (1, 1), (-1, 1).
        along = level_numbers(vectors[at], SAME_DISTANCE * distance)
        keys = [i[at], -along[:, 0], *along[:, 1:].T]
        chosen.append(at[np.lexsort(keys)])
        kind.append(np.full(len(at), number))
    at = np.concatenate(chosen)
    return Pattern(
        name=name,
        size=size,
        points=x,
        springs=np.column_stack([i[at], j[at]]),
        image=image[at],
        kind=np.concatenate(kind),
        rules=rules,
        tensor=tensor,
        formulas=formulas,
    )


def repeat_cell(pattern: Pattern, times: int) -> Pattern:
    """Return the same lattice with a unit cell of `times` the edges.

    Its points have more freedom to move relative to each other.

    Raises `ProblemError` if `times` is not a positive integer.
    """
    require_type("pattern", pattern, Pattern)
    d, n = pattern.dim, len(pattern.points)
    whole_number("times", times, 1)
    refuse_too_many("repeated cell", n * float(times) ** d)
    cells = np.indices((times,) * d).reshape(d, -1).T
    place = times ** np.arange(d)[::-1]
    i, j = pattern.springs.T
    beyond = cells[:, None] + pattern.image
    image, home = np.divmod(beyond, times)
    here = np.repeat(cells @ place, len(i)).reshape(len(cells), -1)
    return replace(
        pattern,
        size=tuple(times * edge for edge in pattern.size),
        points=(cells[:, None] * np.array(pattern.size) + pattern.points).reshape(-1, d),
        springs=np.stack([here * n + i, home @ place * n + j], axis=2).reshape(-1, 2),
        image=image.reshape(-1, d),
        kind=np.tile(pattern.kind, len(cells)),
        factor=np.tile(pattern.factor, len(cells)),
        volume=np.tile(pattern.volume, len(cells)),
    )
