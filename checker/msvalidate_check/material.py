"""The material that a field is elasticity of, as nearly as there is one."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from msvalidate_check.beside import best_scale, longest
from msvalidate_check.case_set import ElasticCase

Array = np.ndarray
STEPS, SETTLED = 30, 1e-12
"""Of the fit of modulus and ratio."""
SHOWS = 0.1
"""Uncertainty of a ratio, and of a modulus over it, from which they do not show in the field."""
RATIO_STEP = 1e-4
"""Half the step of differences by the ratio, over the range that the set knows."""
PARALLEL = 1e-5
"""Part of a change by the ratio that no scale explains, below which no ratio shows: slopes are kept
in single precision."""
ROUNDING = 1e-12
"""Of the largest displacement: what the fit itself leaves."""
TRIED = 9
"""Ratios at which moduli are asked where any may be the field's."""


@dataclass(frozen=True)
class Material:
    """The material that a field is elasticity of, as nearly as there is one.

    Parameters
    ----------
    E, nu
        In Pa, and 1; NaN where it does not show.
    E_uncertainty, nu_uncertainty
        How far they may be off for what the field, the fit and the set leave open.
    left
        Largest difference that is left, over the largest displacement.
    G, K, G_uncertainty, K_uncertainty
        In Pa, where they show and E does not: shear modulus, and pressure over change of volume,
        in the plane of area: E/(3(1 - 2nu)), in plane stress E/(2(1 - nu)), in plane strain
        E/(2(1 + nu)(1 - 2nu)).
    """

    E: float = math.nan
    nu: float = math.nan
    E_uncertainty: float = math.nan
    nu_uncertainty: float = math.nan
    left: float = math.nan
    G: float = math.nan
    K: float = math.nan
    G_uncertainty: float = math.nan
    K_uncertainty: float = math.nan


def nearest_material(case: ElasticCase, order: Array, found: Array, uncertainty: float) -> Material:
    """Modulus and ratio of the elasticity that is nearest to a field, by Gauss and Newton's steps.

    u = s·u(nu), and the modulus is E/s. Each step of nu is along what no scale explains, and the
    scale is fitted again at the ratio that is taken. What a number may be off by is the sum of what
    every component may be, weighed as the fit weighs them; in a uniform state no ratio shows, and a
    modulus does if it is the same whatever the ratio.

    Parameters
    ----------
    case, order
        And the numbers (m,) of the set's points.
    found
        (m, d) displacements there, in m.
    uncertainty
        How far each component may be off besides what the set leaves open, in m.
    """
    low, high = case.ratios
    nu = case.nu
    for _ in range(STEPS):
        own, scale, alone = _parts(case, order, found, nu)
        square = scale * float((alone**2).sum())
        if scale <= 0 or not square:
            break
        change = float((alone * (found - scale * own)).sum()) / square
        before, nu = nu, float(np.clip(nu + change, low, high))
        if abs(nu - before) < SETTLED:
            break
    return _described(case, order, found, uncertainty, nu)


def _parts(case: ElasticCase, order: Array, found: Array, nu: float) -> tuple[Array, float, Array]:
    """Elasticity (m, d) at a ratio, how many times the field is it, its slope beside a scale."""
    low, high = case.ratios
    step = RATIO_STEP * (high - low)
    own = case.at_ratio(nu)[order]
    slope = (case.at_ratio(nu + step)[order] - case.at_ratio(nu - step)[order]) / (2 * step)
    if case.driven == "supports":
        return own, 1.0, slope
    alone = slope - best_scale(slope, own) * own
    shows = np.linalg.norm(alone) > PARALLEL * np.linalg.norm(slope)
    return own, best_scale(found, own), alone if shows else np.zeros_like(alone)


def _described(
    case: ElasticCase, order: Array, found: Array, uncertainty: float, nu: float
) -> Material:
    """What a fit found, without what does not show."""
    own, scale, alone = _parts(case, order, found, nu)
    rest = found - scale * own
    left = longest(rest) / longest(case.wanted)
    if scale <= 0:
        return Material(left=left)
    away = uncertainty + float(np.abs(rest).max())
    away += scale * longest(own) * (ROUNDING + case.uncertainty_at_ratio(nu))
    by_nu = alone / (scale * (alone**2).sum()) if alone.any() else None
    nu_uncertainty = math.inf if by_nu is None else float(np.abs(by_nu).sum()) * away
    shown = {"nu": (nu, nu_uncertainty)} if nu_uncertainty < SHOWS else {}
    if case.driven != "supports":
        shown |= _moduli(case, order, found, nu, by_nu if shown else None, away)
    more = {f"{name}_uncertainty": each for name, (_, each) in shown.items()}
    return Material(left=left, **{name: value for name, (value, _) in shown.items()}, **more)


def _moduli(
    case: ElasticCase, order: Array, found: Array, nu: float, by_nu: Array | None, away: float
) -> dict[str, tuple[float, float]]:
    """Name -> modulus and its uncertainty: E if it shows, else G and K if they do.

    `by_nu` (m, d) is how the ratio follows the field; None where it may be any that the set knows.
    """

    def size(name: str, at: float) -> float:
        times = best_scale(found, case.at_ratio(at)[order])
        return case.E * _over_E(name, case.state, at) / times if times > 0 else math.nan

    own, scale, _ = _parts(case, order, found, nu)
    by_scale = own / (scale * (own**2).sum())
    low, high = case.ratios
    step = RATIO_STEP * (high - low)
    shown = {}
    for name in ("E", "G", "K"):
        value = size(name, nu)
        slope = math.log(size(name, nu + step) / size(name, nu - step)) / (2 * step)
        weights = by_scale if by_nu is None else by_scale - slope * by_nu
        part = float(np.abs(weights).sum()) * away
        if by_nu is None:
            part += max(abs(size(name, at) / value - 1) for at in np.linspace(low, high, TRIED))
        if part < SHOWS:
            shown[name] = (value, part * value)
    return {"E": shown["E"]} if "E" in shown else shown


def _over_E(name: str, state: str, nu: float) -> float:
    """A modulus over Young's."""
    if name == "E":
        return 1.0
    if name == "G":
        return 1 / (2 * (1 + nu))
    of = {"space": 3 * (1 - 2 * nu), "plane_stress": 2 * (1 - nu)}
    return 1 / of.get(state, 2 * (1 + nu) * (1 - 2 * nu))
