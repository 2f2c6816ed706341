"""Bodies: what does a finite block lose by each route, and how does that fall with its size?

Question   Strain along and across a pull of blocks with free sides, and how unevenly they stretch.
Candidate  Static equilibrium of springs alone at Cauchy's ratio, and with the volume energy at
           ratios on both sides of Cauchy's.
Reference  The uniform strain of the material asked for, on which the tractions do the work.
Expected   Exact where no spring crosses a side. Where springs do, points there have lost
           neighbours: order 1 by each route.
"""

from __future__ import annotations

from functools import partial
from itertools import combinations
from typing import NamedTuple

import numpy as np
import pandas as pd

from msvalidate import kit
from msvalidate.springs.bodies.calibrate import calibrate
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.constants.stiffness import CAUCHY
from msvalidate.springs.lattice import Lattice

from .. import cases, loading
from ..cases import Case
from .routes import ADDED, ALIGNED, ROUTES, Way

LATTICES = {2: ("square", "triangular"), 3: ("cubic18", "bcc")}
RATIOS = {2: (0.2, 0.45), 3: (0.4,)}
SIZES = {2: (8, 16, 32), 3: (4, 8)}
QUICK = {2: (4, 8, 16)}
"""Cells along an edge, about, by the number of axes; none of space in the study's small form."""
KIND = ["lattice", "route", "nu_block"]
order = partial(
    kit.Rule, unit="1", table="route_blocks", by=tuple(KIND), last=2, value="stretch_error",
    power_of="spacing", reference=1.0,
)  # fmt: skip
RULES = (
    kit.Rule(
        "stretched blocks that should be exact: error of strains, relative", 1e-9, "1",
        "uniform strain leaves no force on any point: rounding, 1e-16 times a condition number of "
        "up to 1e5",
        table="route_blocks", rows={"lattice": ALIGNED},
        value=lambda rows: rows.iloc[:, -3:].abs().max(axis=1),  # of three errors the largest
    ),
    order(
        "stretched blocks of the plane that should not be exact: order of the finest pair, from "
        "the expected", 0.22, rows={"lattice": "triangular"},
        because="what a side loses, its ends lose otherwise: at most a cell at each end, a part "
        "2/N of it. log2((1 - 2/16)/(1 - 2/8)) = 0.22 for 8 and 16 cells",
    ),
    order(
        "stretched blocks of space that should not be exact: order of the finest pair, from the "
        "expected", 0.45, rows={"lattice": "BCC"},
        because="half a cell at each end of an edge makes log2((1 - 1/8)/(1 - 1/4)) = 0.22 for 4 "
        "and 8 cells, a whole one 0.58: twice the half is allowed",
    ),
)  # fmt: skip
FIGURE = kit.series(
    "route_blocks", title="Stretched blocks at any Poisson's ratio", x="cells", y="stretch_error",
    labels=("cells along the block (1)", "error of strain (1)"), words={1 / 3: "1/3"},
    rows={"lattice": ("triangular", "BCC")}, by=("route", "nu_block"), panel="lattice", log="xy",
    orders=(-1,),
)  # fmt: skip


class Block(NamedTuple):
    """A block by one route, of a ratio and a size."""

    way: Way
    nu: float
    across: int


def run(candidate: kit.DisplacementSolver, setting: kit.Setting) -> kit.Evidence:
    """Stretch blocks by every route, and judge their errors."""
    blocks = []
    for d, wanted in (QUICK if setting.quick else SIZES).items():
        for way in (Way(name, route) for name in LATTICES[d] for route in ROUTES):
            ratios = RATIOS[d] if way.route == ADDED else (CAUCHY[d],)
            sizes = cases.sizes(_case(way), wanted)
            blocks += [Block(way, nu, across) for nu in ratios for across in sizes]
    table = pd.DataFrame(setting.sweep(partial(measure, candidate), blocks, "blocks by route"))
    exact = table["lattice"].isin(ALIGNED)
    losses = "; ".join(
        f"{lattice} by {route} at {nu:.3g}: {rows['stretch_error'].iloc[-1]:+.2g} at "
        f"{rows['cells'].iloc[-1]} cells, order "
        f"{kit.observed_order(rows['spacing'].iloc[-2:], rows['stretch_error'].iloc[-2:]):.2f}"
        for (lattice, route, nu), rows in table[~exact].groupby(KIND, sort=False)
    )
    whole = ", ".join(table["lattice"][exact].unique())
    finding = (
        f"Stretched blocks are exact by springs and volume energy in {whole}. Others are off: "
        f"{losses}."
    )
    return kit.Evidence(
        {"route_blocks": table},
        tolerances=RULES[:-1] if setting.quick else RULES,
        figures={"route_blocks": FIGURE},
        columns=kit.columns(__file__),
        findings=(finding,),
    )


def measure(candidate: kit.DisplacementSolver, block: Block) -> dict[str, object]:
    """One row of the table `route_blocks`."""
    pattern = block.way.pattern
    d = pattern.dim
    lattice = cases.fill_box(_case(block.way), block.across)
    found = calibrate(
        1.0, block.nu, lattice, "plane_stress" if d == 2 else "solid", route=block.way.route
    )
    box = cases.box_of(lattice)
    problem, sideways = (
        loading.uniform(box, kit.Anisotropic(found.tensor), (axis, axis), loading.STRAIN)
        for axis in (0, 1)
    )
    network = lattice_network(problem, lattice, found)
    move = candidate(problem, network, "linear")
    unit = loading.STRAIN**2 * box.volume
    along = loading.work(network, move) / unit
    across = loading.work(lattice_network(sideways, lattice, found), move) / unit
    exact = loading.STRAIN * lattice.points * np.array([1.0] + [-block.nu] * (d - 1))
    return {
        "lattice": pattern.name,
        "route": block.way.route,
        "nu_block": block.nu,
        "cells": cases.cells_along(lattice),
        "spacing": lattice.spacing,
        "stretch_error": along - 1,
        "across_error_of_ratio": -across / along - block.nu,
        "uneven": uneven(lattice, move - exact) / (loading.STRAIN * box.size[0]),
    }


def uneven(lattice: Lattice, move: kit.Array) -> float:
    """Largest displacement (m) that no small rigid motion makes, in least squares."""
    n, d = lattice.points.shape
    x = lattice.points - lattice.points.mean(axis=0)
    ways = [np.broadcast_to(axis, (n, d)) for axis in np.eye(d)]
    for a, b in combinations(range(d), 2):
        turn = np.zeros((n, d))
        turn[:, a], turn[:, b] = -x[:, b], x[:, a]
        ways.append(turn)
    rigid = np.column_stack([way.ravel() for way in ways])
    part, *_ = np.linalg.lstsq(rigid, move.ravel(), rcond=None)
    return float(np.abs(move.ravel() - rigid @ part).max())


def _case(way: Way) -> Case:
    """The case whose bodies these are; its rule is not used."""
    return Case(way.lattice, next(iter(way.pattern.rules)))
