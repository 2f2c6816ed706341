"""Buckling: at which load does a column of springs give way, and where does it go then?

Question   A column L x H on rollers, its top free to move aside under a dead load: the load at
           which the straight state is no longer stable, and how far the top moves beyond it.
Candidate  Square-8 cells of linear springs; equilibrium along a path of loads.
Reference  Euler's load with the cells' own bending stiffness and the column's shortening, and the
           elastica in elliptic integrals.
Expected   P_cr/P_E = (1 + 1.25/N²)(1 - 0.42 (H/L)²): cells N through the height are too stiff in
           bending, and the shortening gives back a part of what shear takes. A side push that
           vanishes along the path leads onto the bent branch.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import pandas as pd
from scipy.linalg import eigvalsh
from scipy.optimize import brentq
from scipy.special import ellipk

from msvalidate import kit
from msvalidate.problem import Array
from msvalidate.problem.records import replace
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.lattice import square
from msvalidate.springs.network import Configuration, Network
from msvalidate.springs.statics.equilibrium import equilibrium

from . import fibres

COLUMNS = ((5, 2), (5, 4), (10, 2), (10, 4))
"""L/H and cells through the height."""
KNOWN = {
    (5, 1): 2.258627, (5, 2): 1.300768, (5, 4): 1.062496, (5, 8): 1.002940,
    (10, 1): 2.252277, (10, 2): 1.309560, (10, 4): 1.074185,
}  # fmt: skip
"""P_cr/P_E by an independent program."""
Build = Callable[[int, int], tuple[Network, Array]]
"""L/H and cells through the height -> a column, and the share of a top load of its points."""
LOADS = (1.05, 1.1, 1.2)
"""Over the critical one."""
PUSH = 0.1
"""Largest side push, halfway along the path, over the load: it bends the column to its branch."""
RULES = (
    kit.Rule(
        "critical load: an independent program, relative", 2e-6, "1",
        "half a unit of the last of its seven digits", table="buckling",
        value=kit.Quotient("critical", "known"), reference=1.0,
    ),
    kit.Rule(
        "critical load of 4 cells and more: Euler's with cells and shortening, relative", 5e-3, "1",
        "terms of (1/N)⁴ = 0.4 % at N = 4 are left out", table="buckling", rows={"cells": (4, 8)},
        value=kit.Quotient("critical", "formula"), reference=1.0,
    ),
    kit.Rule(
        "beyond the critical load: load against the elastica's at the same displacement, relative",
        0.01, "1", "the elastica neither shortens nor shears, and its moment is linear: parts of "
        "(H/L)² = 1 %", table="path", value=kit.Quotient("load", "load_elastica"), reference=1.0,
    ),
    kit.Rule(
        "below the critical load one place of rest, whatever the push", 1e-9, "1",
        "the straight column is the only equilibrium: rounding times a condition number of 1e6",
        table="positions", rows={"load": 0.9}, value="places_apart",
    ),
)  # fmt: skip
FIGURE = kit.series(
    "path", title="A column L/H = 10 of 4 cells beyond its critical load", x="load",
    y={"aside": "springs", "aside_elastica": "elastica"},
    size=(6.4, 4.0), labels=("load over critical load (1)", "top aside over length (1)"),
)  # fmt: skip


def run(setting: kit.Setting, build: Build | None = None) -> kit.Evidence:
    """Critical loads, a path beyond one, and where columns pushed to either side come to rest."""
    build = build or column
    columns = COLUMNS if setting.quick else tuple(KNOWN)
    table = pd.DataFrame(setting.sweep(partial(critical_load, build), columns, "columns"))
    critical = float(table.set_index(["slender", "cells"])["critical"][10, 4])
    path = pd.DataFrame(follow(build, 10, 4, critical))
    places = [two_places(build, 10, 4, load, critical) for load in (0.9, LOADS[1])]
    positions = pd.DataFrame(places)
    off = (path["load"] / path["load_elastica"] - 1).abs().max()
    finding = (
        "A column of 4 cells through its height, ten times as long, gives way at "
        f"{critical:.4f} of Euler's load, and follows "
        f"the elastica to {100 * off:.1f} % of load up to {LOADS[-1]:g} times that: a path of "
        "loads with a side push that vanishes is enough."
    )
    return kit.Evidence(
        {"buckling": table, "path": path, "positions": positions}, tolerances=RULES,
        columns=kit.columns(__file__),
        findings=(finding,), figures={"buckling": FIGURE},
    )  # fmt: skip


def column(slender: int, cells: int) -> tuple[Network, Array]:
    """A column of height 1 m on rollers, and the share (n,) of a top load that each point has."""
    box = kit.Box((1.0, float(slender)))
    material = kit.Isotropic(fibres.E2, fibres.NU2)
    corner = kit.Region((0.0, 0.0))
    held = (kit.Support(box.side("bottom"), (None, 0.0)), kit.Support(corner, (0.0, None)))
    network = lattice_network(
        kit.Problem(box, material, held), square(box, (cells, slender * cells))
    )
    x, top = network.points[:, 0], network.points[:, 1] > slender * (1 - 1e-9)
    share = np.where(top, 1.0 / cells, 0.0)
    share[top & ((x < 1e-9) | (x > 1 - 1e-9))] /= 2
    return network, share


def euler(slender: int) -> float:
    """Euler's load (N) of a column clamped at its foot and free above."""
    return float(np.pi**2 * fibres.E2 / 12 / (4 * slender**2))


def stiffen_diagonals(slender: int, cells: int) -> tuple[Network, Array]:
    """A column whose diagonals are 0.1 % too stiff."""
    network, share = column(slender, cells)
    stiffer = np.where(network.distance > 1.1 / cells, 1.001, 1.0)
    return replace(network, stiffness=network.stiffness * stiffer), share


FAULTS: dict[str, dict[str, object]] = {
    "columns with diagonals 0.1 % too stiff": {
        "build": stiffen_diagonals, "questions": ("buckling",)
    },
}  # fmt: skip


def critical_load(build: Build, case: tuple[int, int]) -> dict[str, float]:
    """One row of the table: where the least stiffness of the straight state is 0."""
    slender, cells = case
    network, _ = build(slender, cells)
    free = ~network.fixed.ravel()
    springs = fibres.lattices()[0]

    def softest(strain: float) -> float:
        across = fibres.pulled(springs.stress, "uniaxial", -strain)[1]
        u = network.points * np.array([across - 1, -strain])
        K = Configuration(network, u).tangent().toarray()[np.ix_(free, free)]
        return float(eigvalsh(K, subset_by_index=[0, 0])[0])

    guess = euler(slender) / fibres.E2
    strain = brentq(softest, 0.5 * guess, 3 * guess, xtol=1e-12)
    load = -fibres.pulled(springs.stress, "uniaxial", -strain)[0]
    formula = (1 + 1.25 / cells**2) * (1 - 0.42 / slender**2)
    row = {"slender": slender, "cells": cells, "critical": load / euler(slender)}
    return row | {"formula": formula, "known": KNOWN[case]}


def follow(build: Build, slender: int, cells: int, critical: float) -> list[dict[str, float]]:
    """Where the top goes at loads beyond the critical one, over Euler's."""
    network, share = build(slender, cells)
    rows = []
    for load in LOADS:
        aside = top_aside(network, share, load * critical * euler(slender), PUSH)
        k = brentq(lambda k, load=load: elastica(k)[0] - load, 1e-6, 0.95)
        same = brentq(lambda k, aside=aside: elastica(k)[1] - aside, 1e-6, 0.95)
        row = {"load": load, "aside": aside, "aside_elastica": elastica(k)[1]}
        rows.append(row | {"load_elastica": elastica(same)[0]})
    return rows


def top_aside(network: Network, share: Array, P: float, push: float) -> float:
    """Where the top comes to rest under a load (N), over the length, by way of a side push."""
    loaded = replace(network, force=_load(network, share, P, push, 1.0)[0])
    found = equilibrium(loaded, "nonlinear", path=partial(_load, network, share, P, push))
    x, foot = found.displacement[:, 0], network.points[:, 1] == 0  # which widens, held at a corner
    return float((x[share > 0].mean() - x[foot].mean()) / np.ptp(network.points[:, 1]))


def two_places(
    build: Build, slender: int, cells: int, load: float, critical: float
) -> dict[str, float]:
    """How far apart the top comes to rest, pushed to one side and to the other."""
    network, share = build(slender, cells)
    right, left = (
        top_aside(network, share, load * critical * euler(slender), push) for push in (PUSH, -PUSH)
    )
    return {"load": load, "places_apart": right - left}


def elastica(k: float) -> tuple[float, float]:
    """Load over the critical one, and displacement of the top across over the length.

    k is the sine of half the top's angle. Source: [TimoshenkoGere1961], section 2.7.
    """
    K = float(ellipk(k**2))
    return (2 / np.pi * K) ** 2, 2 * k / K


def _load(network: Network, share: Array, P: float, push: float, t: float) -> tuple[Array, Array]:
    """Force (n, 2) in N and prescribed displacement at t of the path."""
    aside = 4 * push * P * t * (1 - t)
    return share[:, None] * np.array([aside, -P * t]), network.displacement
