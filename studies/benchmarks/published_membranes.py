"""Moduli of random membranes beside those that an abstract gives: what of them can be confirmed.

Question   Shear and area modulus of random Delaunay networks whose springs all have one constant.
Candidate  The endless lattice, its points at rest: homogenisation of periodic cells.
Reference  J. C. Hansen and others, Biophysical Journal 70, from page 146 (1996), abstract: 0.45 and
           0.90 of the spring constant for moderate randomness. The measure of randomness and the
           size of the patch, whose outer points were moved as prescribed, could not be had.
Expected   √3/4 and √3/2 of the regular lattice. With all points held to the uniform strain,
           C_iijj = C_ijij (Cauchy), so that the area modulus is twice the shear modulus whatever
           the network. Points that come to rest only soften it.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial

import numpy as np
import pandas as pd

from msvalidate.constants.homogenise import homogenise
from msvalidate.constants.stiffness import isotropic_moduli
from msvalidate.judging.compare import farthest_value
from msvalidate.judging.evidence import Observed, Tolerance
from msvalidate.judging.sweep import Setting
from msvalidate.lattice import Pattern, patterns, voronoi
from msvalidate.problem import Array

PRINTED = (0.45, 0.90)
"""Shear and area modulus over the spring constant, moderate randomness, as printed."""
RANDOM = ("blue_noise", "jittered", "uniform")
"""Point sets, ever more random."""
COUNT, CELLS = 1600, 4
QUICK_COUNT, QUICK_CELLS = 400, 2
"""Points of a cell, and how many cells a mean is of."""
TOLERANCE = Tolerance(
    "published membranes, points held: area modulus over shear modulus", 1e-12, "1",
    "Cauchy's relation holds spring by spring: rounding of sums over 4800 springs",
)  # fmt: skip
COLUMNS = {
    "points": "how the points of a membrane lie; of the row as printed how is not known",
    "shear_modulus": "over the spring constant, points at rest, mean over cells (1)",
    "area_modulus": "the same of the area (1)",
    "area_over_shear": "area_modulus over shear_modulus (1)",
    "membrane_scatter": "of area_modulus over the cells, standard deviation, relative, "
    'or "not printed" (1)',
    "shear_held": "shear modulus over the spring constant with every point held to the uniform "
    'strain, or "not printed" (1)',
    "area_held": 'the same of the area, or "not printed" (1)',
}


@dataclass(frozen=True)
class Membrane:
    """Shear and area modulus over the spring constant: points at rest, and held."""

    rest: tuple[float, float]
    held: tuple[float, float]


def measure(setting: Setting) -> pd.DataFrame:
    """The table `published_membrane`."""
    count, cells = (QUICK_COUNT, QUICK_CELLS) if setting.quick else (COUNT, CELLS)
    seeds = range(setting.seed, setting.seed + cells)
    rows: list[dict[str, object]] = [
        head("as printed", PRINTED)
        | dict.fromkeys(("membrane_scatter", "shear_held", "area_held"), "not printed"),
        row("regular", [moduli_of(patterns.triangular())]),
    ]
    for points in RANDOM:
        found = setting.sweep(partial(random_membrane, count, points), seeds, points)
        rows.append(row(points, found))
    return pd.DataFrame(rows)


def random_membrane(count: int, points: str, seed: int) -> Membrane:
    """One periodic cell of Delaunay triangles, all springs of one constant."""
    return moduli_of(voronoi(count, points=points, stiffness="1", seed=seed))


def moduli_of(pattern: Pattern) -> Membrane:
    """Moduli of a pattern whose springs have the constant 1."""
    solid = homogenise(pattern, (1.0,))
    return Membrane(shear_and_area(solid.tensor), shear_and_area(solid.affine))


def shear_and_area(tensor: Array) -> tuple[float, float]:
    """E/(2(1 + nu)) and E/(2(1 - nu)), in the unit of a plane tensor."""
    found = isotropic_moduli(tensor)
    return found.E / (2 * (1 + found.nu)), found.E / (2 * (1 - found.nu))


def head(points: str, moduli: Iterable[float]) -> dict[str, object]:
    """The columns that print has as well."""
    shear, area = moduli
    return {
        "points": points,
        "shear_modulus": shear,
        "area_modulus": area,
        "area_over_shear": area / shear,
    }


def row(points: str, cells: list[Membrane]) -> dict[str, object]:
    """One row of the table: means over cells."""
    rest, held = (np.array([getattr(cell, which) for cell in cells]) for which in ("rest", "held"))
    return head(points, rest.mean(axis=0).tolist()) | {
        "membrane_scatter": float(rest[:, 1].std() / rest[:, 1].mean()),
        "shear_held": float(held[:, 0].mean()),
        "area_held": float(held[:, 1].mean()),
    }


def observe(table: pd.DataFrame) -> Observed:
    """The ratio that Cauchy's relation gives."""
    ours = table.iloc[1:]
    return farthest_value((ours["area_held"] / ours["shear_held"]).astype(float), 2.0)


def finding(table: pd.DataFrame) -> str:
    """What can be said of the printed moduli."""
    rows = table.set_index("points")
    printed, regular = rows.loc["as printed"], rows.loc["regular"]
    random = rows.loc[list(RANDOM)]
    above = max((random[name] / regular[name]).max() for name in ("shear_modulus", "area_modulus"))
    verdict = "Not confirmed" if above < 1 else "Not refuted"
    return (
        f"{verdict}: that moderately random membranes have {printed['shear_modulus']:.2f} and "
        f"{printed['area_modulus']:.2f} of the spring constant (Hansen and others 1996, abstract), "
        f"{100 * (printed['area_modulus'] / regular['area_modulus'] - 1):.0f} % above the regular "
        f"{regular['shear_modulus']:.3f} and {regular['area_modulus']:.3f}. With points at rest "
        "endless networks soften as they grow random, to "
        f"{random['shear_modulus'].iloc[-1]:.3f} and {random['area_modulus'].iloc[-1]:.3f}, and "
        f"their ratio falls from 2 to {random['area_over_shear'].iloc[-1]:.2f}. Points held to the "
        "strain keep the ratio of 2 and stiffen; in a patch the outer points are so held, which "
        "may be why, but its size is not in the abstract."
    )
