"""What repeats: the points and springs of one cell of an endless lattice, as data."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, fields
from itertools import product

import numpy as np

from msvalidate.problem import (
    Array,
    Index,
    ProblemError,
    coordinates,
    finite,
    instance,
    metres,
    shown,
    whole,
)

Constants = tuple[float, ...]
"""Spring constants (N/m), one for each kind of spring."""
SAME_DISTANCE = 1e-9
"""Distances closer than this fraction are one."""


@dataclass(frozen=True, eq=False)
class Pattern:
    """One rectangular cell of an endless lattice, its edges along the axes; lengths in spacings.

    A lattice is a function without arguments that returns one; `patterns.known` finds it.

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
        (n,) part of the cell that belongs to each point, by default an equal one.

    Raises
    ------
    ProblemError
        If an array does not fit the others, or a spring has no length.
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

    def __post_init__(self) -> None:
        for edge in self.size:
            metres(f"pattern {self.name}: cell edge", edge)
        d = len(self.size)
        points = coordinates(f"pattern {self.name}: points", self.points).reshape(-1, d)
        n, m = len(points), len(self.springs)
        object.__setattr__(self, "points", points)
        if not len(self.factor):
            object.__setattr__(self, "factor", np.ones(m))
        if not len(self.volume):
            object.__setattr__(self, "volume", np.full(n, math.prod(self.size) / n))
        self._refuse_misfits(n, m, d)
        for rule, constants in self.rules.items():
            self.stiffness(constants, rule)
        for item in fields(self):
            value = getattr(self, item.name)
            if isinstance(value, np.ndarray):
                value.setflags(write=False)

    def _refuse_misfits(self, n: int, m: int, d: int) -> None:
        shapes = {"springs": (m, 2), "image": (m, d), "kind": (m,), "factor": (m,), "volume": (n,)}
        for name, shape in shapes.items():
            found = np.shape(getattr(self, name))
            if found != shape or not m:
                raise ProblemError(f"pattern {self.name}: {name} {found}; give {shape}, m above 0")
        if self.springs.min() < 0 or self.springs.max() >= n:
            raise ProblemError(
                f"pattern {self.name}: springs between points {self.springs.min()} and "
                f"{self.springs.max()}; there are 0 to {n - 1}"
            )
        if set(self.kind.tolist()) != set(range(int(self.kind.max()) + 1)):
            kinds = sorted(set(self.kind.tolist()))
            raise ProblemError(f"pattern {self.name}: kinds {kinds}; count from 0 without a gap")
        if not np.linalg.norm(self.vectors, axis=1).all():
            raise ProblemError(f"pattern {self.name}: a spring has no length; leave it out")

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

        Raises
        ------
        ProblemError
            If they are not one a kind, or one is negative or not finite.
        """
        k = finite(f"{self.name}: spring constants", constants)
        if k.shape != (self.kinds,):
            raise ProblemError(
                f"{self.name}: spring {rule} {shown(constants)}; give {self.kinds}, one a kind"
            )
        if (k < 0).any():
            raise ProblemError(
                f"{self.name}: spring {rule} {shown(constants)}; none may be negative"
            )
        return np.asarray(k[self.kind] * self.factor)


def by_shells(
    name: str,
    size: tuple[float, ...],
    points: Iterable[Iterable[float]],
    distances: tuple[float, ...],
    rules: Mapping[str, Constants],
    tensor: Callable[[Constants], Array] | None = None,
) -> Pattern:
    """Pattern whose springs join all points at some distances, one kind of spring a distance.

    Parameters
    ----------
    name, size, points, rules, tensor
        As in `Pattern`.
    distances
        Lengths of the springs in spacings.

    Raises
    ------
    ProblemError
        If no two points are at a distance, or as for `Pattern`.
    """
    d = len(size)
    x = np.array([tuple(point) for point in points], dtype=float).reshape(-1, d)
    reach = [math.ceil(max(distances) / edge) for edge in size]
    images = np.array(list(product(*(range(-r, r + 1) for r in reach))))
    i, j, t = np.indices((len(x), len(x), len(images))).reshape(3, -1)
    image = images[t]
    vectors = x[j] + image * np.array(size) - x[i]
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
        keys = [i[at], -vectors[at, 0], *vectors[at, 1:].T]
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
    )


def repeated(pattern: Pattern, times: int) -> Pattern:
    """The same lattice with a cell of `times` the edges: its points may move apart from each other.

    Raises
    ------
    ProblemError
        If `times` is not a positive integer.
    """
    instance("pattern", pattern, Pattern)
    d, n = pattern.dim, len(pattern.points)
    cells = np.indices((whole("times", times, 1),) * d).reshape(d, -1).T
    place = times ** np.arange(d)[::-1]
    i, j = pattern.springs.T
    beyond = cells[:, None] + pattern.image
    image, home = np.divmod(beyond, times)
    here = np.repeat(cells @ place, len(i)).reshape(len(cells), -1)
    return Pattern(
        name=pattern.name,
        size=tuple(times * edge for edge in pattern.size),
        points=(cells[:, None] * np.array(pattern.size) + pattern.points).reshape(-1, d),
        springs=np.stack([here * n + i, home @ place * n + j], axis=2).reshape(-1, 2),
        image=image.reshape(-1, d),
        kind=np.tile(pattern.kind, len(cells)),
        rules=pattern.rules,
        tensor=pattern.tensor,
        factor=np.tile(pattern.factor, len(cells)),
        volume=np.tile(pattern.volume, len(cells)),
    )
