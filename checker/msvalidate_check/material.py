"""The material that a field is elasticity of, as nearly as there is one."""

from __future__ import annotations

import math
from collections.abc import Callable
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


@dataclass(frozen=True, eq=False)
class Fit:
    """The ratio and scale at which fields known by ratio are nearest to a field.

    Parameters
    ----------
    nu, scale
        The ratio, and how many times the field at it is the given one.
    own, alone
        (n, d) in m: the field at the ratio, and its slope by the ratio without what a scale
        explains of it; 0 where no ratio shows.
    """

    nu: float
    scale: float
    own: Array
    alone: Array

    @property
    def shows(self) -> bool:
        """Whether another ratio is another field, and no scale."""
        return bool(self.alone.any())


def fit_material(
    found: Array,
    by_ratio: Callable[[float], Array],
    nu: float,
    between: tuple[float, float],
    *,
    beyond: bool = False,
    scaled: bool = True,
) -> Fit:
    """Fit found = s u(nu) by Gauss and Newton's steps from a ratio.

    Each step of nu is along what no scale explains, and the scale is fitted again at the ratio that
    is taken; not `scaled`, it stays 1. Slopes are differences, which may go `beyond` the ratios.
    """
    low, high = between
    step = RATIO_STEP * (high - low)

    def at(ratio: float) -> Fit:
        least, most = (-math.inf, math.inf) if beyond else between
        ahead, behind = min(ratio + step, most), max(ratio - step, least)
        own = by_ratio(ratio)
        slope = (by_ratio(ahead) - by_ratio(behind)) / (ahead - behind)
        if not scaled:
            return Fit(ratio, 1.0, own, slope)
        alone = slope - best_scale(slope, own) * own
        shows = np.linalg.norm(alone) > PARALLEL * np.linalg.norm(slope)
        return Fit(ratio, best_scale(found, own), own, alone if shows else np.zeros_like(alone))

    for _ in range(STEPS):
        fit = at(nu)
        square = fit.scale * float((fit.alone**2).sum())
        if fit.scale <= 0 or not square:
            return fit
        change = float((fit.alone * (found - fit.scale * fit.own)).sum()) / square
        before, nu = nu, float(np.clip(nu + change, low, high))
        if abs(nu - before) < SETTLED:
            break
    return at(nu)


def nearest_material(case: ElasticCase, order: Array, found: Array, uncertainty: float) -> Material:
    """Modulus and ratio of the elasticity that is nearest to a field, without what does not show.

    What a number may be off by is the sum of what every component may be, weighed as the fit weighs
    them; in a uniform state no ratio shows, and a modulus does if it is the same whatever the
    ratio.

    Parameters
    ----------
    case, order
        And the numbers (m,) of the set's points.
    found
        (m, d) displacements there, in m.
    uncertainty
        How far each component may be off besides what the set leaves open, in m.
    """
    loaded = case.driven != "supports"
    fit = fit_material(
        found, lambda nu: case.at_ratio(nu)[order], case.nu, case.ratios, beyond=True, scaled=loaded
    )
    rest = found - fit.scale * fit.own
    left = longest(rest) / longest(case.wanted)
    if fit.scale <= 0:
        return Material(left=left)
    away = uncertainty + float(np.abs(rest).max())
    away += fit.scale * longest(fit.own) * (ROUNDING + case.uncertainty_at_ratio(fit.nu))
    by_nu = fit.alone / (fit.scale * (fit.alone**2).sum()) if fit.shows else None
    nu_uncertainty = math.inf if by_nu is None else float(np.abs(by_nu).sum()) * away
    shown = {"nu": (fit.nu, nu_uncertainty)} if nu_uncertainty < SHOWS else {}
    if loaded:
        shown |= _moduli(case, order, found, fit, by_nu if shown else None, away)
    more = {f"{name}_uncertainty": each for name, (_, each) in shown.items()}
    return Material(left=left, **{name: value for name, (value, _) in shown.items()}, **more)


def _moduli(
    case: ElasticCase, order: Array, found: Array, fit: Fit, by_nu: Array | None, away: float
) -> dict[str, tuple[float, float]]:
    """Name -> modulus and its uncertainty: E if it shows, else G and K if they do.

    `by_nu` (m, d) is how the ratio follows the field; None where it may be any that the set knows.
    """

    def size(name: str, at: float) -> float:
        times = best_scale(found, case.at_ratio(at)[order])
        return case.E * _over_E(name, case.state, at) / times if times > 0 else math.nan

    nu, by_scale = fit.nu, fit.own / (fit.scale * (fit.own**2).sum())
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
