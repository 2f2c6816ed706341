"""Derivatives by differences, that forces are held to."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np

from msvalidate import kit
from msvalidate.dielectric.charges import facing_strips_capacitance

STEP = 0.01
"""Of the differences, over the shortest segment beside a point."""
Function = Callable[[kit.Array], kit.Array]


def differences(function: Function, x: kit.Array, steps: kit.Array) -> kit.Array:
    """Derivative (..., k) of a function of (k,) numbers, by differences of fourth order."""
    columns = []
    for i, step in enumerate(steps):
        moved = np.zeros_like(x)
        moved[i] = step
        near = function(x + moved) - function(x - moved)
        far = function(x + 2 * moved) - function(x - 2 * moved)
        columns.append((8 * near - far) / (12 * step))
    return np.stack(columns, axis=-1)


def steps_of(points: kit.Array) -> kit.Array:
    """Steps (2n,) of differences: parts of the shortest segment, far below any gap."""
    apart = np.hypot(*np.diff(points, axis=0).T)
    before, after = np.concatenate([[np.inf], apart]), np.concatenate([apart, [np.inf]])
    return np.repeat(STEP * np.minimum(before, after), 2)


@cache
def growth(ratio: float) -> float:
    """Derivative of the closed form's C/ε in the width over the gap."""
    step = np.array([1e-2 * ratio])

    def form(x: kit.Array) -> kit.Array:
        return np.array(facing_strips_capacitance(float(x[0])))

    return float(differences(form, np.array([ratio]), step)[0])
