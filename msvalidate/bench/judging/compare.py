"""The judge's arithmetic: pure functions of numbers, ignorant of who produced them."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import stdtrit

from msvalidate.problem import Array, ProblemError
from msvalidate.problem.checks import finite, numbers
from msvalidate.problem.records import dataclass

Layer = Literal["theory", "agreement", "regression", "baseline"]
"""Basis of a tolerance: theory, agreement, regression or baseline.

*Theory* is a formula, an order, an identity or the accuracy of the reference; *agreement* a band
between springs and elasticity whose width has its own reason; *regression* a limit from a
measurement, which detects a change and proves nothing; *baseline* the previous value.
"""
CONFIDENCE = 0.95
"""Probability that the interval of a fitted power contains the true exponent.

The scatter is assumed to be random.
"""


@dataclass(frozen=True)
class Observed:
    """Observed value with its reference.

    It is the farthest of a number of `rows`, the one described by `at`.
    """

    value: float
    reference: float = 0.0
    rows: int = 1
    at: str = ""

    @property
    def error(self) -> float:
        """Distance from the reference."""
        return abs(self.value - self.reference)


@dataclass(frozen=True)
class Tolerance:
    """Largest allowed error of a quantity, with unit, layer and reason, and what was observed."""

    quantity: str
    limit: float
    unit: str
    because: str
    layer: Layer = "theory"
    observed: Observed | None = None

    def __post_init__(self) -> None:
        if not (np.isfinite(self.limit) and self.limit >= 0 and self.unit and self.because):
            raise ValueError(
                f"tolerance {self.quantity}: needs a finite limit, a unit and a reason"
            )


class Power(NamedTuple):
    """Fitted power law: its exponent, and the ends of the exponent's confidence interval."""

    exponent: float
    low: float
    high: float


def farthest_value(values: ArrayLike, references: ArrayLike) -> Observed:
    """The value that is farthest from its reference; NaN counts as farthest.

    Raises
    ------
    ProblemError
        If there is nothing to compare, or values and references do not fit together.
    """
    value, reference = _check_fit(numbers("values", values), numbers("references", references))
    if not value.size:
        raise ProblemError("comparison of no values; give at least one")
    value, reference = value.ravel(), reference.ravel()
    with np.errstate(over="ignore", invalid="ignore"):  # what has no distance counts as farthest
        at = int(np.argmax(np.abs(value - reference)))  # argmax stops at the first NaN
    return Observed(float(value[at]), float(reference[at]), value.size)


def observed_order(spacings: ArrayLike, errors: ArrayLike) -> float:
    """Slope of log(error) against log(spacing), by least squares.

    NaN where an error is zero or not finite: an order fitted to rounding says nothing.

    Raises
    ------
    ProblemError
        If there is not one error a spacing, or a spacing is not above zero or given twice.
    """
    h, e = finite("spacings", spacings), np.abs(numbers("errors", errors))
    if h.ndim != 1 or e.shape != h.shape:
        raise ProblemError(f"spacings {h.shape}, errors {e.shape}: give a row of each, as long")
    if (h <= 0).any() or len(set(h)) < len(h):
        raise ProblemError("spacings: give each once, above zero")
    if len(h) < 2 or not np.isfinite(e).all() or (e <= 1e-14).any():
        return float("nan")
    return float(np.polyfit(np.log(h), np.log(e), 1)[0])


def fitted_power(sizes: ArrayLike, values: ArrayLike) -> Power:
    """Exponent p of values ∝ sizes^p, by least squares in logarithms, with its interval.

    The interval is Student's, of `CONFIDENCE`: what the scatter about the line says of its slope.

    Source: the interval of [Student1908].

    Raises
    ------
    ProblemError
        If there is not one value a size, fewer than three, or one is not above zero.
    """
    x, y = finite("sizes", sizes), finite("values", values)
    if x.ndim != 1 or y.shape != x.shape or len(x) < 3:
        raise ProblemError(f"sizes {x.shape}, values {y.shape}: give three or more, one a size")
    if (x <= 0).any() or (y <= 0).any() or len(set(x)) < len(x):
        raise ProblemError("sizes and values: give each size once, and all above zero")
    u, w = np.log(x) - np.log(x).mean(), np.log(y) - np.log(y).mean()
    if np.ptp(u) < 1e-9:
        raise ProblemError(f"sizes: from {x.min():g} to {x.max():g}; too close to fit a power")
    slope = float(u @ w / (u @ u))
    error = float(np.sqrt(((w - slope * u) ** 2).sum() / (len(x) - 2) / (u @ u)))
    reach = float(stdtrit(len(x) - 2, 0.5 + CONFIDENCE / 2)) * error
    return Power(slope, slope - reach, slope + reach)


def _check_fit(value: Array, reference: Array) -> tuple[Array, Array]:
    try:
        both = np.broadcast_arrays(value, reference)
    except ValueError as error:
        raise ProblemError(
            f"comparison of values {value.shape} with references {reference.shape}; give one "
            "reference, or one a value"
        ) from error
    return both[0], both[1]
