"""Uniform deformations of soft solids under a voltage, by minimising their energy.

A unit cube of an ideal dielectric (permittivity as it is, whatever the stretch) between electrodes
that stretch with it has at a nominal field Ẽ (voltage over the height at no load) the energy

    W(x) - ½·ε·Ẽ²·g(x),

g the capacitance over that at no load. Where x is a single number W' = ½εẼ²g' is equilibrium: the
nominal field rises to a largest value, the pull-in, or has none. No closed form of it is used here:
energies are differentiated and maximised by number.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

STEP = 1e-5
"""Of the central differences: errors of 1e-10 from it, and 1e-11 from rounding."""


class Found(NamedTuple):
    """Thickness over that at no load (1), nominal and true field over √(μ/ε) (1)."""

    thickness: float
    nominal: float
    true: float


Law = Callable[[float, float], float]
"""Energy over μ of a sheet stretched by two factors, its volume kept."""


def neo_hookean(first: float, second: float) -> float:
    """Energy over μ of a sheet stretched by two factors, its volume kept."""
    return 0.5 * (first**2 + second**2 + 1 / (first * second) ** 2 - 3)


def free_sheet(thinning: float, law: Law = neo_hookean) -> float:
    """Energy over μ of a sheet free to widen, its area so many times as large: least over shapes.

    That both stretches are alike is found, not taken.
    """
    found = minimize_scalar(
        lambda ratio: law(np.sqrt(thinning * ratio), np.sqrt(thinning / ratio)),
        bounds=(0.2, 5.0),
        method="bounded",
        options={"xatol": 1e-10},
    )
    return float(found.fun)


def field(
    energy: Callable[[float], float], capacitance: Callable[[float], float], x: float
) -> float:
    """Nominal field over √(μ/ε) that holds x, from W' = ½Ẽ²g'; 0 where none does.

    Source: the energy of [ZhaoSuo2007], differentiated.
    """
    slopes = [(f(x + STEP) - f(x - STEP)) / (2 * STEP) for f in (energy, capacitance)]
    return float(np.sqrt(max(2 * slopes[0] / slopes[1], 0.0)))


def pull_in(
    energy: Callable[[float], float],
    capacitance: Callable[[float], float],
    bounds: tuple[float, float],
) -> tuple[float, float]:
    """The x of the largest nominal field between bounds, and that field over √(μ/ε)."""
    found = minimize_scalar(
        lambda x: -field(energy, capacitance, x),
        bounds=bounds,
        method="bounded",
        options={"xatol": 1e-8},
    )
    return float(found.x), -float(found.fun)


def free_pull_in(law: Law = neo_hookean) -> Found:
    """Of a sheet free to widen along both axes: g = thinning squared.

    Source: [ZhaoSuo2007].
    """
    thinning, nominal = pull_in(partial(free_sheet, law=law), lambda a: a**2, (1.01, 4.0))
    return Found(1 / thinning, nominal, nominal * thinning)


def plane_field(thinning: float, law: Law = neo_hookean) -> float:
    """Nominal field over √(μ/ε) that thins a sheet so much which may widen along one axis alone.

    Source: closed form derived here.
    """
    return field(lambda a: law(a, 1.0), lambda a: a**2, thinning)
