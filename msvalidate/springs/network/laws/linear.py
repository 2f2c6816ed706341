"""Linear spring (Hooke), f = k (L - L0), the default law of a network."""

from __future__ import annotations

import numpy as np

from msvalidate.problem import Array
from msvalidate.springs.network.laws.law import Coefficients, SpringLaw


def _pull(c: Coefficients, s: Array) -> Array:
    k, L0 = c
    L = np.sqrt(s)
    return np.asarray(k * (L - L0) / L)


def _change(c: Coefficients, s0: Array, s: Array, grown: Array) -> Array:
    k, L0 = c
    D, L = np.sqrt(s0), np.sqrt(s)
    return np.asarray(k * (grown / (L + D) / L) * (L0 / D))


def _work(c: Coefficients, s0: Array, s: Array, grown: Array) -> Array:
    k, L0 = c
    D = np.sqrt(s0)
    return np.asarray(0.5 * k * (grown / (np.sqrt(s) + D)) ** 2 * (L0 / D))


LINEAR = SpringLaw(
    "linear",
    coefficients=lambda k, L0: (k, L0),
    pull=_pull,
    axial=lambda c, s: c[0],
    change=_change,
    work=_work,
    stored=lambda c, s: 0.5 * c[0] * (np.sqrt(s) - c[1]) ** 2,
    loops=lambda c: (c[0], c[0] * c[1]),
)
