"""Claims: the report's words about its Figures 4 to 7 as numbers, and curves for the bent bar."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from msvalidate import kit

SOURCES = ("springs", "homogenised body", "target")
LIKE = 0.05
"""A line is like a curve if it misses it by less than this part of its height, which a reader of a
printed figure just about sees."""


class Claim(NamedTuple):
    """A statement as a number, of points (m) and displacements (m): above a bound or below it."""

    statement: str
    measured: str
    number: Callable[[kit.Array, kit.Array], float]
    above: bool
    bound: float = 0.0
    unit: str = "m"

    def judge(self, values: list[float]) -> str:
        """Of which of the sources it holds, in words."""
        sign = 1 if self.above else -1
        true = [s for s, v in zip(SOURCES, values, strict=True) if sign * (v - self.bound) > 0]
        if len(true) == len(SOURCES):
            return "holds"
        return f"holds of {' and '.join(true)} only" if true else "does not hold"


def gap(points: kit.Array, move: kit.Array, axis: int) -> kit.Array:
    """Change (m) of the distance along an axis of two opposite sides, particle by particle."""
    along = points[:, axis]
    low, high = np.isclose(along, along.min()), np.isclose(along, along.max())
    return np.asarray(move[high, axis] - move[low, axis])


def lower_row(points: kit.Array, move: kit.Array) -> tuple[kit.Array, kit.Array]:
    """Places along x (m) and deflection (m) of the lowest row of particles."""
    low = points[:, 1] == 0
    return points[low, 0], move[low, 1]


def clamped_beam(xi: kit.Array) -> kit.Array:
    """Deflection of a clamped beam under a force in its middle, 1 there; xi = x/L."""
    near = np.minimum(xi, 1 - xi)
    return np.asarray(4 * near**2 * (3 - 4 * near))


CURVES: dict[str, Callable[[kit.Array], list[kit.Array]]] = {
    "fit_half_wave": lambda xi: [np.sin(np.pi * xi)],
    "fit_whole_wave": lambda xi: [(1 - np.cos(2 * np.pi * xi)) / 2],
    "fit_clamped_beam": lambda xi: [clamped_beam(xi)],
    "fit_shear_beam": lambda xi: [clamped_beam(xi), np.minimum(xi, 1 - xi)],
}


def fitted(x: kit.Array, line: kit.Array, curve: str) -> kit.Array:
    """Least-squares fit of a curve to a deflection line (m) at places x (m)."""
    shapes = np.column_stack(CURVES[curve](x / x.max()))
    return np.asarray(shapes @ np.linalg.lstsq(shapes, line, rcond=None)[0])


def rms(values: kit.Array) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(values**2)))


def misfit(x: kit.Array, line: kit.Array, curve: str) -> float:
    """Root mean square by which a line misses a curve, over the line's height."""
    return float(rms(line - fitted(x, line, curve)) / np.abs(line).max())


NAMED = ("mean change of height", "mean change of width", "change of length along x")
MISFIT = "rms misfit over height"
SLIGHTLY = "mean swelling over mean shrinking"
LOADED, FREE = "change of height at x = 0, loaded", "change of width at y = 1 m, free"
SWELLS, SHRINKS = "swells along y", "shrinks along x"
UPPER, BOTTOM = "upper edge is compressed", "bottom edge elongates"


def like(statement: str, curve: str) -> Claim:
    """The claim that the lowest row is like a curve."""

    def number(points: kit.Array, move: kit.Array) -> float:
        return misfit(*lower_row(points, move), curve)

    return Claim(statement, MISFIT, number, above=False, bound=LIKE, unit="1")


PRESSED = (
    Claim(SWELLS, NAMED[0], lambda x, u: gap(x, u, 1).mean(), above=True),
    Claim(SWELLS, "change of height at x = 0.4 m", lambda x, u: gap(x, u, 1)[2], above=True),
    Claim(SWELLS, LOADED, lambda x, u: gap(x, u, 1)[0], above=True),
    Claim(SHRINKS, NAMED[1], lambda x, u: gap(x, u, 0).mean(), above=False),
    Claim(SHRINKS, "change of width at y = 0.4 m", lambda x, u: gap(x, u, 0)[2], above=False),
    Claim(SHRINKS, FREE, lambda x, u: gap(x, u, 0)[-1], above=False),
    Claim(
        "swells slightly: less than half of what it shrinks",
        SLIGHTLY,
        lambda x, u: -gap(x, u, 1).mean() / gap(x, u, 0).mean(),
        above=False,
        bound=0.5,
        unit="1",
    ),
)
CLAIMS = {
    "pressure": PRESSED,
    "two-sided pressure": PRESSED,
    "shear": (
        Claim(UPPER, NAMED[2], lambda x, u: gap(x, u, 0)[-1], above=False),
        Claim(BOTTOM, NAMED[2], lambda x, u: gap(x, u, 0)[0], above=True),
    ),
    "bending": (
        like("sine-like: half a wave", "fit_half_wave"),
        like("sine-like: a whole wave, 1 - cos", "fit_whole_wave"),
        like("for comparison: a clamped beam", "fit_clamped_beam"),
        like("for comparison: a clamped beam that shears", "fit_shear_beam"),
    ),
}
