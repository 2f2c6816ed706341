"""Bodies: what does a finite block lose by each route, and how does that fall with its size?

Question   Strain along and across a pull of blocks with free sides, and how unevenly they stretch.
Candidate  Static equilibrium of springs alone at Cauchy's ratio, and with the volume energy at
           ratios on both sides of Cauchy's.
Reference  The uniform strain of the material asked for, on which the tractions do the work.
Expected   Exact where no spring crosses a side. Where springs do, points there have lost
           neighbours: order 1 by any route.
"""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from msvalidate.bodies.calibrate import calibrate
from msvalidate.bodies.lattice_network import lattice_network
from msvalidate.constants.routes import ROUTES
from msvalidate.constants.stiffness import CAUCHY
from msvalidate.judging.candidate import DisplacementSolver
from msvalidate.judging.compare import farthest_value, observed_order
from msvalidate.judging.evidence import Evidence, Tables, Tolerance
from msvalidate.judging.sweep import Setting
from msvalidate.lattice import Lattice
from msvalidate.output import figures
from msvalidate.problem import Anisotropic, Array
from msvalidate.problem.material import State

from .. import cases, loading
from ..cases import Case
from . import routes
from .routes import ADDED, ALIGNED, Way

LATTICES = {2: ("square", "triangular"), 3: ("cubic18", "bcc")}
PLANE = ("square", "triangular")
"""Names of those of the plane in the tables."""
RATIOS = {2: (0.2, 0.45), 3: (0.4,)}
SIZES = {2: (8, 16, 32), 3: (4, 8)}
QUICK = {2: (4, 8, 16)}
"""Cells along an edge, about, by the number of axes; none of space in the study's small form."""
EXACT = 1e-9
TOLERANCES = (
    Tolerance(
        "stretched blocks that should be exact: error of strains, relative", EXACT, "1",
        "uniform strain leaves no force on any point: rounding, 1e-16 times a condition number of "
        "up to 1e5",
    ),
    Tolerance(
        "stretched blocks of the plane that should not be exact: order of the finest pair, from "
        "the expected", 0.22, "1",
        "what a side loses, its ends lose otherwise: at most a cell at each end, a part 2/N of it. "
        "log2((1 - 2/16)/(1 - 2/8)) = 0.22 for 8 and 16 cells",
    ),
    Tolerance(
        "stretched blocks of space that should not be exact: order of the finest pair, from the "
        "expected", 0.45, "1",
        "half a cell at each end of an edge makes log2((1 - 1/8)/(1 - 1/4)) = 0.22 for 4 and 8 "
        "cells, a whole one 0.58: twice the half is allowed",
    ),
)  # fmt: skip
COLUMNS = {
    **{name: routes.COLUMNS[name] for name in ("lattice", "route")},
    **{name: cases.COLUMNS[name] for name in ("cells", "spacing")},
    "nu_block": "Poisson's ratio along the lattice's axes that was asked for (1)",
    "stretch_error": "strain along the pull over the exact one, less 1 (1)",
    "across_error_of_ratio": "strain across over that along the pull, from nu_block (1)",
    "uneven": "largest displacement from the exact one but for a rigid motion, over the pull's end "
    "displacement (1)",
    "block_order_expected": 'order on paper, or "exact" (1)',
    "block_order": "slope of log|stretch_error| against log(spacing) between the finest two sizes, "
    'or "exact" (1)',
    "uneven_order": 'the same of uneven, or "exact" (1)',
}


class Block(NamedTuple):
    """A block by one route, of a ratio and a size."""

    way: Way
    nu: float
    across: int


def blocks(setting: Setting) -> list[Block]:
    """Every block, the sizes of one kind one after another."""
    found = []
    every = QUICK if setting.quick else SIZES
    for way in (Way(name, route) for d in every for name in LATTICES[d] for route in ROUTES):
        d = way.pattern.dim
        ratios = RATIOS[d] if way.route == ADDED else (CAUCHY[d],)
        sizes = cases.sizes(_case(way), every[d])
        found += [Block(way, nu, across) for nu in ratios for across in sizes]
    return found


def run(candidate: DisplacementSolver, setting: Setting) -> Evidence:
    """Stretch blocks by every route, and judge their errors."""
    wanted = blocks(setting)
    table = pd.DataFrame(setting.sweep(partial(measure, candidate), wanted, "blocks by route"))
    orders = approach(table, list(dict.fromkeys((b.way, b.nu) for b in wanted)))
    exact = orders[orders["block_order_expected"] == "exact"]
    rest = orders[orders["block_order_expected"] != "exact"]
    kept = table.merge(exact[KEY])
    errors = kept[["stretch_error", "across_error_of_ratio", "uneven"]].to_numpy()
    observed = {TOLERANCES[0].quantity: farthest_value(errors, 0.0)}
    flat = rest["lattice"].isin(PLANE)
    for tolerance, part in zip(TOLERANCES[1:], (rest[flat], rest[~flat]), strict=True):
        if len(part):
            orders_found, expected = part["block_order"], part["block_order_expected"]
            observed[tolerance.quantity] = farthest_value(
                orders_found.astype(float), expected.astype(float)
            )
    return Evidence(
        tables={"route_blocks": table, "route_orders": orders},
        observed=observed,
        tolerances=tuple(t for t in TOLERANCES if t.quantity in observed),
        figures={"route_blocks": draw},
        columns=COLUMNS,
        rounding=dict.fromkeys(("stretch_error", "across_error_of_ratio", "uneven"), 1e-11),
        findings=findings(table, orders),
    )


KEY = ["lattice", "route", "nu_block"]
"""Columns that name a kind of block."""


def approach(table: pd.DataFrame, kinds: list[tuple[Way, float]]) -> pd.DataFrame:
    """The table `route_orders`."""
    rows = []
    for way, nu in kinds:
        name = way.pattern.name
        mine = table[(table["lattice"] == name) & (table["route"] == way.route)]
        pair = mine[mine["nu_block"] == nu].iloc[-2:]
        expected = order_expected(way)
        seen: list[float | str] = ["exact", "exact"]
        if expected != "exact":
            seen = [
                observed_order(pair["spacing"], pair[name]) for name in ("stretch_error", "uneven")
            ]
        rows.append(
            {"lattice": name, "route": way.route, "nu_block": nu, "block_order_expected": expected}
            | dict(zip(("block_order", "uneven_order"), seen, strict=True))
        )
    return pd.DataFrame(rows)


def order_expected(way: Way) -> float | str:
    """Order of the error of a stretched block on paper."""
    return "exact" if way.lattice in ALIGNED else 1.0


def findings(table: pd.DataFrame, orders: pd.DataFrame) -> tuple[str, ...]:
    """What a block loses at the finest size."""
    finest = table.groupby(KEY, sort=False).last().reset_index().merge(orders)
    rest = finest[finest["block_order_expected"] != "exact"]
    told = "; ".join(
        f"{row['lattice']} by {row['route']} at {row['nu_block']:.3g}: {row['stretch_error']:+.2g} "
        f"at {row['cells']} cells, order {row['block_order']:.2f}"
        for _, row in rest.iterrows()
    )
    whole = ", ".join(dict.fromkeys(finest["lattice"][finest["block_order_expected"] == "exact"]))
    return (
        (
            f"Stretched blocks are exact by springs and volume energy in {whole}. Others are off: "
            f"{told}."
        ),
    )


def measure(candidate: DisplacementSolver, block: Block) -> dict[str, object]:
    """One row of the table `route_blocks`."""
    pattern = block.way.pattern
    d = pattern.dim
    lattice = cases.fill_box(_case(block.way), block.across)
    state: State = "plane_stress" if d == 2 else "solid"
    found = calibrate(1.0, block.nu, lattice, state, route=block.way.route)
    box = cases.box_of(lattice)
    problem = loading.uniform(box, Anisotropic(found.tensor), (0, 0), loading.STRAIN)
    across = loading.uniform(box, Anisotropic(found.tensor), (1, 1), loading.STRAIN)
    network = lattice_network(problem, lattice, found)
    move = candidate(problem, network, "linear")
    unit = loading.STRAIN**2 * box.volume
    along = loading.work(network, move) / unit
    sideways = loading.work(lattice_network(across, lattice, found), move) / unit
    exact = loading.STRAIN * lattice.points * np.array([1.0] + [-block.nu] * (d - 1))
    return {
        "lattice": pattern.name,
        "route": block.way.route,
        "nu_block": block.nu,
        "cells": cases.cells_along(lattice),
        "spacing": lattice.spacing,
        "stretch_error": along - 1,
        "across_error_of_ratio": -sideways / along - block.nu,
        "uneven": uneven(lattice, move - exact) / (loading.STRAIN * box.size[0]),
    }


def uneven(lattice: Lattice, move: Array) -> float:
    """Largest displacement (m) that no small rigid motion makes, in least squares."""
    n, d = lattice.points.shape
    x = lattice.points - lattice.points.mean(axis=0)
    ways = [np.broadcast_to(axis, (n, d)) for axis in np.eye(d)]
    for a, b in ((0, 1), (0, 2), (1, 2))[: d * (d - 1) // 2]:
        turn = np.zeros((n, d))
        turn[:, a], turn[:, b] = -x[:, b], x[:, a]
        ways.append(turn)
    rigid = np.column_stack([way.ravel() for way in ways])
    part, *_ = np.linalg.lstsq(rigid, move.ravel(), rcond=None)
    return float(np.abs(move.ravel() - rigid @ part).max())


def _case(way: Way) -> Case:
    """The case whose bodies these are; its rule is not used."""
    return Case(way.lattice, next(iter(way.pattern.rules)))


def draw(tables: Tables) -> Figure:
    """Error of the strain along the pull against the number of cells, plane and space."""
    table, orders = tables["route_blocks"], tables["route_orders"]
    kinds = orders[orders["block_order_expected"] != "exact"]
    rest = table.merge(kinds[[*KEY, "block_order_expected"]])
    plane = rest["lattice"].isin(PLANE)
    parts = [("plane", rest[plane]), ("space", rest[~plane])]
    parts = [(title, part) for title, part in parts if len(part)]
    figure, axes = figures.new_figure(
        len(parts), size=(3.3 if len(parts) > 1 else 5.0, 4.4), sharey=True
    )
    names = list(dict.fromkeys(zip(rest["lattice"], rest["route"], strict=True)))
    for axis, (title, part) in zip(axes, parts, strict=True):
        for key, mine in part.groupby(KEY, sort=False):
            lattice, route = key[:2]
            style = cases.style(names.index((lattice, route)))
            above = mine["nu_block"].iloc[0] >= min(CAUCHY.values())
            axis.loglog(
                mine["cells"],
                mine["stretch_error"].abs(),
                mfc=style["color"] if above else "white",
                label=f"{lattice}, {route}" if above else None,
                **style,
            )
        cells = np.array(sorted(set(part["cells"])), dtype=float)
        # From 1.5 times the largest error, so that no curve hides it.
        line = 1.5 * part["stretch_error"].abs().max() * cells[0] / cells
        axis.loglog(cells, line, ":", color="grey", label="slope -1")
        axis.set_xticks(cells, [f"{n:g}" for n in cells])
        axis.set(title=title, xlabel="cells along the block (1)")
    axes[0].set_ylabel("error of strain along the pull (1)")
    figure.suptitle("Stretched blocks at any Poisson's ratio")
    axes[0].plot([], [], "o", color="black", mfc="white", label="open: nu = 0.2, below Cauchy's")
    figures.add_shared_legend(figure, axes, columns=2)
    return figure
