"""Floor 3: the judge's arithmetic: pure functions of numbers, ignorant of who produced them."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from msvalidate.evidence import Observed


def worst(values: ArrayLike, references: ArrayLike) -> Observed:
    """The value that is farthest from its reference; NaN counts as farthest.

    Raises
    ------
    ValueError
        If there is nothing to compare.
    """
    value, reference = np.broadcast_arrays(
        np.asarray(values, dtype=float), np.asarray(references, dtype=float)
    )
    if not value.size:
        raise ValueError("comparison of no values")
    value, reference = value.ravel(), reference.ravel()
    at = int(np.argmax(np.abs(value - reference)))  # argmax stops at the first NaN
    return Observed(float(value[at]), float(reference[at]))


def observed_order(spacings: ArrayLike, errors: ArrayLike) -> float:
    """Slope of log(error) against log(spacing), by least squares.

    NaN where an error is zero or not finite: an order fitted to rounding says nothing.
    """
    h, e = np.asarray(spacings, dtype=float), np.abs(np.asarray(errors, dtype=float))
    if len(h) < 2 or not np.isfinite(e).all() or (e <= 1e-14).any():
        return float("nan")
    return float(np.polyfit(np.log(h), np.log(e), 1)[0])
