"""A field of displacements beside elasticity's: the records, the parts of their difference."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

Array = np.ndarray
Driven = Literal["loads", "weight", "supports", "both"]
"""What moves a body: loads, its own weight alone, its supports, or supports and something else."""
Factor = Callable[[float], float]
"""Factor of a stiffness by a parameter, such as a spacing (m)."""
AXES = "xyz"
ROUNDING = 1e-12
"""Of the sizes of a sum's parts: no more than this is left of parts that cancel."""
MOST_RATIO = 0.495
"""Ratio up to which elements without a pressure of their own are asked."""


@dataclass(frozen=True, eq=False)
class Mistake:
    """A known mistake and the displacements that it gives, computed when first needed.

    Parameters
    ----------
    kind
        Of the cause; key of its sentence in `causes.PHRASES`, if there is no other `key`.
    path
        Returns pairs of a parameter, such as a spacing (m), and the field (n, d) in m that the
        mistake gives there, in the order of the parameter; none if there is no answer. A candidate
        between two neighbours fits too, by linear interpolation.
    scaled
        Whether the mistake fixes the fields only up to a factor, such as a ratio of constants.
    named
        Kinds of phrases, and the factors of the stiffness, by the parameter, at which they replace
        the general one.
    beside
        Kind of a second mistake that is made with it; "" if there is none.
    simpler
        Kind of a mistake that it contains: it must fit better than that one to be reported.
    """

    kind: str
    path: Callable[[], Sequence[tuple[float, Array]]]
    scaled: bool = False
    named: Mapping[str, Factor] = field(default_factory=dict)
    beside: str = ""
    simpler: str = ""
    key: str = ""


@dataclass(frozen=True, eq=False)
class Field:
    """Displacements (n, d) of a candidate and of elasticity at places (n, d), all in m.

    `uncertainty` is how far elasticity and the numbers themselves may be off, over the largest;
    `driven` what moves the body; `span` its ends (m) along each axis; `ratio` its Poisson's
    ratio, NaN if it has none; `by_ratio` gives elasticity (n, d) of another of `ratios`, None
    if of no other; `elsewhere` gives it at other places (n, d) in m, None where one lies
    outside the body; `known` are fields (n, d), by ratio, of solvers that are known not to be
    converged, by what they are of; `other_state` gives it in the other plane state, with that
    state's name; `mistakes` are known mistakes, solved on this body; `unit` is the name and size
    (m) of the unit of length in sentences, `read_unit` the size (m) of that of the file.
    """

    places: Array
    found: Array
    wanted: Array
    uncertainty: float
    driven: Driven
    span: tuple[tuple[float, float], ...]
    ratio: float = math.nan
    ratios: tuple[float, float] = (0.0, MOST_RATIO)
    by_ratio: Callable[[float], Array] | None = None
    elsewhere: Callable[[Array], Array | None] | None = None
    known: Mapping[str, Callable[[float], Array]] = field(default_factory=dict)
    other_state: Callable[[], tuple[str, Array] | None] = lambda: None
    mistakes: Sequence[Mistake] = ()
    unit: tuple[str, float] = ("m", 1.0)
    read_unit: float = 1.0

    def length(self, value: float, digits: int = 3) -> str:
        """A length or coordinate (m) as text in the unit of the sentences."""
        return f"{value / self.unit[1]:.{digits}g}"

    @property
    def size(self) -> float:
        """Largest displacement (m) of elasticity."""
        return longest(self.wanted) or 1.0

    @property
    def difference(self) -> float:
        """Largest difference from elasticity, over the larger one's largest displacement.

        Never much above 1: what a cause leaves is small beside it, or is large beside elasticity.
        """
        return longest(self.found - self.wanted) / max(self.size, longest(self.found))

    def left(self, found: Array, wanted: Array | None = None) -> float:
        """Largest difference of two fields, over elasticity's largest displacement."""
        return longest(found - (self.wanted if wanted is None else wanted)) / self.size


def longest(vectors: Array) -> float:
    """Length of the longest of vectors (n, d)."""
    return float(np.linalg.norm(vectors, axis=1).max())


def best_scale(found: Array, wanted: Array) -> float:
    """The number of times that a field (n, d) is another, 0 if within rounding; NaN if it is 0."""
    square, parts = float((wanted**2).sum()), found * wanted
    product = float(parts.sum())
    if abs(product) <= ROUNDING * float(np.abs(parts).sum()):
        product = 0.0
    return product / square if square else math.nan


def fit(columns: Array, target: Array) -> Array:
    """Coefficients (k,) of the best sum of fields (k, n, d) for a field (n, d)."""
    A = columns.reshape(len(columns), -1).T
    size = np.linalg.norm(A, axis=0)
    size[size == 0] = 1.0
    return np.asarray(np.linalg.lstsq(A / size, target.ravel(), rcond=None)[0] / size)


def rigid_motions(places: Array) -> Array:
    """Rigid motions (k, n, d) about the middle."""
    middle = places - places.mean(axis=0)
    size = float(np.abs(middle).max()) or 1.0
    x = middle / size
    n, d = x.shape
    shifts = [np.broadcast_to(along, (n, d)) for along in np.eye(d)]
    if d == 2:
        return np.stack([*shifts, np.column_stack([-x[:, 1], x[:, 0]])])
    return np.stack([*shifts, *(np.cross(axis, x) for axis in np.eye(3))])


def split(field: Field) -> dict[str, Array]:
    """Parts (n, d) in m of found - wanted: scale, rigid motion, shape. Their sum is the whole."""
    modes = rigid_motions(field.places)
    columns = np.concatenate([field.wanted[None], modes])
    fitted = fit(columns, field.found - field.wanted)
    scale = fitted[0] * field.wanted
    rigid = np.einsum("k,knd->nd", fitted[1:], modes)
    return {
        "scale": scale,
        "rigid motion": rigid,
        "shape": field.found - field.wanted - scale - rigid,
    }
