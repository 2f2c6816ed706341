"""Random networks: drawn by a seed, and what solids they are."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from msvalidate import kit
from msvalidate.springs.constants.stiffness import AXES_OF, CAUCHY, isotropic_moduli, isotropic_part
from msvalidate.springs.lattice import STIFFNESS_RULES, Pattern
from msvalidate.springs.lattice.point_sets import periodic_points
from msvalidate.springs.lattice.tessellation import Tessellation, periodic_tessellation
from msvalidate.springs.lattice.voronoi import pattern_of_tessellation

from ..cases import Solid

Case = tuple[int, str, int, int]
"""Axes, kind of point set, number of points, seed."""
SEEDS, QUICK_SEEDS = 20, 6


def seeds(setting: kit.Setting, count: int | None = None) -> list[int]:
    """Seeds of the networks, by default as many as the study's form has."""
    count = count or (QUICK_SEEDS if setting.quick else SEEDS)
    return [int(seed) for seed in np.random.default_rng(setting.seed).integers(10**9, size=count)]


def draw_network(case: Case) -> Tessellation:
    """Voronoi cells of a periodic point set, one point in a unit of volume."""
    dim, points, count, seed = case
    size = (count ** (1 / dim),) * dim
    return periodic_tessellation(periodic_points(points, count, size, seed), size)


def measure(
    solid: Solid, case: Case, rules: tuple[str, ...] = STIFFNESS_RULES
) -> list[dict[str, Any]]:
    """What each rule makes of one point set: moduli, losses, and departures from identities."""
    cells = draw_network(case)
    dim, points, count, seed = case
    head = {"axes": dim, "point_set": points, "count": count, "seed": seed}
    content = (cells.area @ np.linalg.norm(cells.vectors, axis=1)) / (dim * cells.volume.sum()) - 1
    head |= {"neighbours": 2 * len(cells.springs) / count}
    head |= {"content": content, "closure": closure(cells)}
    return [
        head | {"stiffness": rule} | moduli(solid, pattern_of_tessellation(cells, rule), rule)
        for rule in rules
    ]


def closure(cells: Tessellation) -> float:
    """Largest |Σ A n| of a cell over its surface Σ A."""
    vectors = cells.vectors
    outward = cells.area[:, None] * vectors / np.linalg.norm(vectors, axis=1)[:, None]
    left, surface = np.zeros_like(cells.points), np.zeros(len(cells.points))
    for end, sign in ((0, 1), (1, -1)):
        np.add.at(left, cells.springs[:, end], sign * outward)
        np.add.at(surface, cells.springs[:, end], cells.area)
    return float((np.linalg.norm(left, axis=1) / surface).max())


def moduli(solid: Solid, pattern: Pattern, rule: str) -> dict[str, Any]:
    """Of one network: its moduli, held and at rest, and how far identities are missed."""
    found = solid(pattern, (1.0,))
    d = pattern.dim
    held, rest = isotropic_moduli(found.affine), isotropic_moduli(found.tensor)
    bulk, bulk_held = (tensor[:d, :d].sum() / d**2 for tensor in (found.tensor, found.affine))
    shear, shear_held = (m.E / (2 * (1 + m.nu)) for m in (rest, held))
    by_area = rule == "A/L"
    above = np.linalg.eigvalsh(found.tensor - found.affine)[-1] / np.abs(found.affine).max()
    return {
        "E": rest.E,
        "nu": rest.nu,
        "E_affine": held.E,
        "nu_affine": held.nu,
        "bulk_lost": 1 - bulk / bulk_held,
        "shear_lost": 1 - shear / shear_held,
        "E_lost": 1 - rest.E / held.E,
        "anisotropy": anisotropy(found.tensor),
        "tensor": found.tensor,
        "affine_sum": found.affine[:d, :d].sum() / d - 1 if by_area else 0.0,
        "bulk": d * bulk - 1 if by_area else 0.0,
        "cauchy": held.nu - CAUCHY[d],
        "above_affine": max(above, 0.0),
    }


def anisotropy(tensor: kit.Array) -> float:
    """Distance of a Voigt tensor from its mean over all rotations, relative, in all components."""
    d = AXES_OF[len(tensor)]
    times = np.array([1.0] * d + [math.sqrt(2)] * (len(tensor) - d))  # each shear stands for two
    weight = np.outer(times, times)
    away = np.linalg.norm(weight * (tensor - isotropic_part(tensor)))
    return float(away / np.linalg.norm(weight * tensor))
