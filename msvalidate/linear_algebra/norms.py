"""The norms by which residuals and moves are measured."""

from __future__ import annotations

import numpy as np

from msvalidate.problem import Array

EPS = float(np.finfo(float).eps)
"""Rounding of doubles."""


def dots(a: Array, b: Array) -> Array:
    """a·b, () of vectors or (v,) of columns.

    Not by BLAS: its threads change the last digits, and wait for each other.
    """
    return np.asarray(np.einsum("i...,i...->...", a, b))


def max_abs(values: Array) -> float:
    """Largest absolute value, without a temporary array.

    It is 0 for no values, and NaN if any value is NaN.
    """
    return abs(float(max(values.max(), -values.min()))) if values.size else 0.0


def max_length(vectors: Array) -> float:
    """Length of the longest of some vectors (n, d)."""
    return float(np.linalg.norm(vectors, axis=1).max())
