"""Moduli of random membranes beside those that an abstract gives: what of them can be confirmed.

Question   Shear and area modulus of random Delaunay networks whose springs all have one constant.
Candidate  The endless lattice, its points at rest: homogenisation of periodic cells.
Reference  J. C. Hansen and others, Biophysical Journal 70, from page 146 (1996), abstract: 0.45 and
           0.90 of the spring constant for moderate randomness. The measure of randomness and the
           size of the patch, whose outer points were moved as prescribed, could not be had.
Expected   √3/4 and √3/2 of the regular lattice. With all points held to the uniform strain,
           C_iijj = C_ijij (Cauchy), so that the area modulus is twice the shear modulus in
           each network. Points that come to rest only soften it.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial

import numpy as np
import pandas as pd

from msvalidate import kit
from msvalidate.springs.constants.homogenise import homogenise
from msvalidate.springs.constants.stiffness import isotropic_moduli
from msvalidate.springs.lattice import Pattern, patterns, voronoi

PRINTED = (0.45, 0.90)
"""Shear and area modulus over the spring constant, moderate randomness, as printed."""
RANDOM = ("blue_noise", "jittered", "uniform")
"""Point sets, ever more random."""
COUNT, CELLS = 1600, 4
QUICK_COUNT, QUICK_CELLS = 400, 2
"""Points of a cell, and how many cells a mean is of."""


def measure(setting: kit.Setting) -> pd.DataFrame:
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


def random_membrane(count: int, points: str, seed: int) -> kit.Array:
    """One periodic cell of Delaunay triangles, all springs of one constant."""
    return moduli_of(voronoi(count, points=points, stiffness="1", seed=seed))


def moduli_of(pattern: Pattern) -> kit.Array:
    """Shear and area modulus (2, 2) of springs of constant 1: points at rest, and held."""
    solid = homogenise(pattern, (1.0,))
    return np.array([shear_and_area(solid.tensor), shear_and_area(solid.affine)])


def shear_and_area(tensor: kit.Array) -> tuple[float, float]:
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


def row(points: str, cells: list[kit.Array]) -> dict[str, object]:
    """One row of the table: means over cells."""
    rest, held = np.moveaxis(np.array(cells), 1, 0)
    shear, area = held.mean(axis=0)
    return head(points, rest.mean(axis=0).tolist()) | {
        "membrane_scatter": float(rest[:, 1].std() / rest[:, 1].mean()),
        "shear_held": float(shear),
        "area_held": float(area),
    }


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
