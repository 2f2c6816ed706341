"""The material that a field is elasticity of, as nearly as there is one."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from msvalidate_check.case_set import ElasticCase

Array = np.ndarray
STEPS, SETTLED = 12, 1e-9
"""Of the fit of modulus and ratio."""
SHOWS = 0.1
"""Uncertainty of a ratio from which it does not show in the field."""
RATIO_STEP = 1e-4
"""Half the step of differences by the ratio, over the range that the set knows."""


@dataclass(frozen=True)
class Material:
    """The material that a field is elasticity of, as nearly as there is one.

    Parameters
    ----------
    E, nu
        In Pa, and 1; NaN where it does not show.
    E_doubt, nu_doubt
        How far they may be off for what the field and the set leave open.
    left
        Largest difference that is left, over the largest displacement.
    """

    E: float
    nu: float
    E_doubt: float
    nu_doubt: float
    left: float


def nearest_material(case: ElasticCase, order: Array, found: Array, doubt: float) -> Material:
    """Modulus and ratio of the elasticity that is nearest to a field, by Gauss and Newton's steps.

    u = s·u(nu): columns are u(nu) and ∂u/∂nu, the modulus is E/s. What each may be off by is the
    sum of what every component may be, weighed as the fit weighs them.

    Parameters
    ----------
    case, order
        And the numbers (m,) of the set's points.
    found
        (m, d) displacements there, in m.
    doubt
        How far each component may be off, in m.
    """
    low, high = case.ratios
    scale, nu = 1.0, case.nu
    for _ in range(STEPS):
        own, columns = _columns(case, order, scale, nu)
        if not columns[:, -1].any():
            break
        target = found if case.driven != "supports" else found - own
        change = np.linalg.pinv(columns) @ target.ravel()
        if case.driven != "supports":
            scale = float(change[0])
        new = float(np.clip(nu + change[-1], low, high))
        settled, nu = abs(new - nu) < SETTLED, new
        if settled or scale <= 0:
            break
    return _described(case, order, found, doubt, (scale, nu))


def _columns(case: ElasticCase, order: Array, scale: float, nu: float) -> tuple[Array, Array]:
    """Elasticity (m, d) at a ratio, and what is fitted: it, if loads move it, and its slope."""
    low, high = case.ratios
    step = RATIO_STEP * (high - low)
    own = case.at_ratio(nu)[order]
    slope = (case.at_ratio(nu + step)[order] - case.at_ratio(nu - step)[order]) / (2 * step)
    every = [own, scale * slope] if case.driven != "supports" else [slope]
    return own, np.column_stack([each.ravel() for each in every])


def _described(
    case: ElasticCase, order: Array, found: Array, doubt: float, fitted: tuple[float, float]
) -> Material:
    """What a fit found, without what does not show."""
    scale, nu = fitted
    size = float(np.linalg.norm(case.wanted, axis=1).max())
    own, columns = _columns(case, order, scale, nu)
    away = np.abs(np.linalg.pinv(columns)).sum(axis=1) * doubt
    left = float(np.linalg.norm(found - scale * own, axis=1).max()) / size
    shows = bool(columns[:, -1].any()) and float(away[-1]) < SHOWS
    loads = case.driven != "supports" and scale > 0
    E = case.E / scale if loads else math.nan
    return Material(
        E,
        nu if shows else math.nan,
        E * float(away[0]) / scale if loads else math.nan,
        float(away[-1]) if shows else math.nan,
        left,
    )
