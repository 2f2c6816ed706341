"""How finely numbers were rounded, as the numbers themselves show it."""

from __future__ import annotations

import math

import numpy as np

Array = np.ndarray
LEAST, LEVELS = 8, 64
"""Numbers that differ, and steps between the ends of them, that it takes to show a rounding: an
exact answer, such as uniform strain of a few cells, lies on a few even steps of its own."""
EVEN = 256
"""Steps of a grid of which numbers that are all multiples show no rounding to it."""
DIGITS, BINARY_DIGITS = 17, 40
"""Decimal digits that no number has more of; binary ones up to which numbers count as rounded."""
VANISHING = 1e-290
"""Size of a number whose own rounding is not a normal number."""
DOUBLE, SINGLE = float(np.finfo(np.float64).eps), float(np.finfo(np.float32).eps)


def spacing_of_displacements(move: Array, points: Array | None) -> float:
    """Distance between neighbouring displacements, which may be differences of positions.

    Parameters
    ----------
    move
        (n, d), in any unit.
    points
        (n, d) at rest, or None.
    """
    own = spacing_of_numbers(move)
    if points is None:
        return own
    at = (points + move)[move != 0]
    size = float(np.abs(at).max(initial=0.0))
    if not size or np.abs(at - _in_single(at)).max() > 8 * DOUBLE * size:
        return own
    # Round fractions lie on float32's grid without having been rounded to it.
    step = EVEN * SINGLE * 2.0 ** math.floor(math.log2(size))
    is_even = np.abs(move / step - np.rint(move / step)).max() < 1e-6
    return own if is_even or size <= np.abs(move).max() else max(own, SINGLE * size)


def spacing_of_numbers(values: Array) -> float:
    """Distance between neighbouring numbers of the kind that values seem to be rounded to.

    The largest that fits: float32; multiples of one power of two, as of differences of positions in
    float32; decimals of so many digits after the point, or so many digits in all; double precision.
    """
    size = float(np.abs(values).max(initial=0.0))
    if not size:
        return 0.0
    found = [DOUBLE * size]
    if np.array_equal(_in_single(values), values):
        found.append(SINGLE * size)
    sample = values.ravel()[:: max(1, values.size // 10_000)]
    sample = np.where(np.abs(sample) > VANISHING, sample, 0.0)
    if len(np.unique(np.abs(sample[sample != 0]))) < LEAST:
        return max(found)
    exponent = math.floor(math.log2(size))
    first = math.floor(math.log10(size)) + 1
    even = (math.ldexp(1.0, exponent - lower) for lower in range(BINARY_DIGITS))
    decimal = (10.0 ** (first - digits) for digits in range(1, DIGITS - 2))
    steps = [
        next((s for s in even if s and (np.rint(sample / s) == sample / s).all()), 0.0),
        next((s for s in decimal if s and _is_rounded(sample, s)), 0.0),
    ]
    found += [step for step in steps if LEVELS * step <= float(np.ptp(sample))]
    digits = next((k for k in range(2, DIGITS - 2) if _has_digits(sample, k)), None)
    if digits is not None:
        found.append(10.0 ** (first - digits))
    return max(found)


def _in_single(values: Array) -> Array:
    """Values rounded to float32; those beyond its range are infinite."""
    with np.errstate(over="ignore", under="ignore"):
        return values.astype(np.float32).astype(float)


def _is_rounded(values: Array, step: float) -> bool:
    return bool(np.abs(values - step * np.rint(values / step)).max() <= 1e-6 * step)


def _has_digits(values: Array, digits: int) -> bool:
    """Whether no number has more significant decimal digits than that."""
    size = np.abs(values[values != 0])
    step = 10.0 ** (np.floor(np.log10(size)) + 1 - digits)
    return bool((np.abs(size - step * np.rint(size / step)) <= 1e-6 * step).all())
