"""How finely numbers were rounded, as the numbers themselves show it."""

from __future__ import annotations

import math

import numpy as np

Array = np.ndarray
LEAST, LEVELS = 8, 64
"""Numbers that differ, and steps between the ends of them, that it takes to show a rounding: an
exact answer, such as uniform strain of a few cells, lies on a few even steps of its own."""
DIGITS, BINARY_DIGITS = 17, 40
"""Decimal digits that no number has more of; binary ones up to which numbers count as rounded."""


def spacing_of_displacements(move: Array, points: Array | None) -> float:
    """Distance between neighbouring displacements, which may be differences of positions."""
    own = spacing_of_numbers(move)
    if points is None:
        return own
    at = (points + move).ravel()
    nearest = at.astype(np.float32).astype(float)
    size = float(np.abs(at).max())
    single = float(np.finfo(np.float32).eps) * size
    is_single = np.array_equal(points.astype(np.float32).astype(float), points)
    off = np.abs(at - nearest).max() <= 8 * np.finfo(float).eps * size
    return max(own, single) if is_single and off and size > np.abs(move).max() else own


def spacing_of_numbers(values: Array) -> float:
    """Distance between neighbouring numbers of the kind that values seem to be rounded to.

    The largest that fits: float32; multiples of one power of two, as of differences of positions in
    float32; decimals of so many digits after the point; double precision.
    """
    size = float(np.abs(values).max(initial=0.0))
    if not size:
        return 0.0
    found = [float(np.finfo(float).eps) * size]
    with np.errstate(over="ignore", under="ignore"):
        if np.array_equal(values.astype(np.float32).astype(float), values):
            found.append(float(np.finfo(np.float32).eps) * size)
    sample = values.ravel()[:: max(1, values.size // 10_000)]
    if len(np.unique(np.abs(sample[sample != 0]))) < LEAST:
        return max(found)
    span = float(np.ptp(sample))
    exponent = math.floor(math.log2(size))
    binary = (math.ldexp(1.0, exponent - lower) for lower in range(BINARY_DIGITS))
    steps = (s for s in binary if s and (np.rint(sample / s) == sample / s).all())
    found.append(next(steps, 0.0))
    first = math.floor(math.log10(size)) + 1
    decimal = (10.0 ** (first - digits) for digits in range(1, DIGITS - 2))
    found.append(next((s for s in decimal if s and _is_rounded(sample, s)), 0.0))
    return max(step for step in found if LEVELS * step <= span or step == found[0])


def _is_rounded(values: Array, step: float) -> bool:
    return bool(np.abs(values - step * np.rint(values / step)).max() <= 1e-6 * step)
