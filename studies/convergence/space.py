"""Space: how do steps, work and the solution of elements grow in a cube?

Question   The report says that a spring network costs O(n) for n nodes, its time to rest being
           constant, and that elements cost O(n^9) for n nodes along the edge of a cube. Both are
           said of space: how do steps and work of every relaxation grow there, and the elimination
           of elements?
Candidate  The table of relaxations, as `steps` counts them on the clamped cube.
Reference  Exponents by theory. Of elements: the factor of the order that `reference_fem` eliminates
           in, counted entry by entry, and the steps of its multigrid.
Expected   The lowest frequency falls as 1/L, the highest is fixed by the spacing: steps grow as the
           cells along an edge, nodes^(1/3), and work as nodes^(4/3). A factor by nested dissection
           has unknowns^(4/3) entries and takes unknowns^2 products ([George1973]; in space
           [LiptonRoseTarjan1979]): n^6 along an edge. A full matrix takes n^9. Multigrid takes as
           many steps at each size: n^3.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

import reference_fem
from msvalidate import kit
from msvalidate.bench.judging.counting import TIGHT
from msvalidate.bench.output.figures import COLOURS
from reference_fem.mesh.discretisation import Discretisation
from reference_fem.systems.direct import node_order

from . import bodies, elimination, steps

CUBE = "cube"
EDGES, QUICK_EDGES = (8, 12, 16, 24, 32, 48), (8, 12, 16, 24)
"""Cells along an edge of cubes whose factor is counted."""
SOLVED, QUICK_SOLVED = (6, 8, 10, 16, 24), (6, 8, 10, 12)
"""Of cubes that multigrid solves."""
FULL, DISSECTED, MULTIGRID = "full matrix", "nested dissection", "multigrid"
EXPECTED = {
    (FULL, "products"): 3.0,
    (DISSECTED, "entries"): 4 / 3,
    (DISSECTED, "products"): 2.0,
    (MULTIGRID, "cycles"): 0.0,
    (MULTIGRID, "products"): 1.0,
}
"""Exponents in the unknowns."""
CHECKED, QUICK_CHECKED = (6, 8, 10), (6, 8)
"""Cells along an edge of cubes that multigrid and a factor both bring to rest."""
exponent = partial(
    kit.Rule, limit=1 / 6, unit="1", table="growth_of_factors", value="exponent",
    reference="expected",
)  # fmt: skip
RULES = (
    exponent(
        "cube of elements: exponent of the factor's entries in unknowns",
        rows={"way": DISSECTED, "quantity": "entries"},
        because="nearer to 4/3 than to 5/3, the band's; terms below the first fall as "
        "unknowns^(-1/3)",
    ),
    exponent(
        "cube of elements: exponent of the factor's products in unknowns",
        rows={"way": DISSECTED, "quantity": "products"},
        because="nearer to 2 than to 7/3, the band's",
    ),
    exponent(
        "cube of elements: exponent of multigrid's cycles in unknowns",
        table="growth_of_multigrid", rows={"quantity": "cycles"}, value=steps.HERE["exponent"],
        because="nearer to constant than to 1/3, conjugate gradients without it",
    ),
)  # fmt: skip


def run(counted: pd.DataFrame, grown: pd.DataFrame, setting: kit.Setting) -> kit.Evidence:
    """Judge what `steps` counted on the cube, and count what elements take there."""
    edges, solved, checked = (
        (QUICK_EDGES, QUICK_SOLVED, QUICK_CHECKED) if setting.quick else (EDGES, SOLVED, CHECKED)
    )
    factors = pd.DataFrame(
        [row for rows in setting.sweep(count_elimination, edges, "factors") for row in rows]
    )
    cycles = pd.DataFrame(setting.sweep(count_cycles, solved, "multigrid"))
    growing = growth(factors)
    counts = cycles.rename(columns={"cycles_here": "cycles", "products_here": "products"})
    growing_here = growth(counts).rename(columns=steps.HERE)
    away = max(
        bodies.relative_error(
            bodies.rest_by_multigrid(CUBE, edge), bodies.rest_displacement(CUBE, edge)
        )
        for edge in checked
    )
    at_rest = kit.Tolerance(
        "cube at rest by multigrid from that by a factor, over the largest displacement, worst",
        1e-8, "1",
        "a hundredth of the smallest error that steps are counted to; forces are left at 1e-13, "
        "times a lever of the order of kappa, 1e4 at most", observed=kit.Observed(away),
    )  # fmt: skip
    return kit.Evidence(
        tables={
            "factors": factors,
            "multigrid": cycles,
            "growth_of_factors": growing,
            "growth_of_multigrid": growing_here,
        },
        tolerances=(*RULES, at_rest),
        figures={"elements_in_space": draw},
        columns=kit.columns(__file__),
        findings=findings(counted, grown, factors, growing, growing_here),
    )


def cube_of_elements(edge: int) -> Discretisation:
    """The cube as trilinear hexahedra."""
    return reference_fem.box_discretisation(bodies.box(CUBE), bodies.cells(CUBE, edge), "H1")


def count_elimination(edge: int) -> list[dict[str, object]]:
    """Rows of one cube: counts of a full matrix, and in nested dissection."""
    mesh = cube_of_elements(edge)
    unknowns = mesh.dim * int(free_nodes(mesh).sum())
    counts = {FULL: elimination.count_full(unknowns), DISSECTED: in_order(mesh, node_order(mesh))}
    return [
        {"way": way, "cells": edge, "unknowns": unknowns, **count._asdict()}
        for way, count in counts.items()
    ]


def free_nodes(mesh: Discretisation) -> kit.Mask:
    """Nodes (n,) off the clamped side."""
    held, _ = kit.prescribed_displacements(bodies.problem(CUBE), mesh.points)
    return np.asarray(~held.any(axis=1))


def in_order(mesh: Discretisation, order: kit.Index) -> elimination.Counts:
    """Counts of the clamped cube's factor, its nodes (n,) eliminated in such an order."""
    free = free_nodes(mesh)
    number = np.cumsum(free) - 1
    links = mesh.links[free][:, free]
    return elimination.count_factor(links, number[order[free[order]]], mesh.dim)


def count_cycles(edge: int) -> dict[str, object]:
    """Row of one cube: cycles of multigrid."""
    mesh = cube_of_elements(edge)
    free = free_nodes(mesh)
    found = reference_fem.solve_problem(bodies.problem(CUBE), mesh, solver="multigrid")
    cycles = found.solved.steps if found.solved else 0
    entries = mesh.dim**2 * mesh.links[free][:, free].nnz
    return {
        "way": MULTIGRID,
        "cells": edge,
        "unknowns": mesh.dim * int(free.sum()),
        "entries": entries,
        "cycles_here": cycles,
        "products_here": entries * cycles,
    }


def growth(factors: pd.DataFrame) -> pd.DataFrame:
    """Exponents of entries and products in the unknowns."""
    return pd.DataFrame(
        [
            {
                "way": way,
                "quantity": quantity,
                "expected": exponent,
                **kit.fitted_power(part["unknowns"], part[quantity])._asdict(),
            }
            for (way, quantity), exponent in EXPECTED.items()
            if len(part := factors[factors["way"] == way])
        ]
    )


def findings(
    counted: pd.DataFrame,
    grown: pd.DataFrame,
    factors: pd.DataFrame,
    growing: pd.DataFrame,
    growing_here: pd.DataFrame,
) -> tuple[str, ...]:
    """What the report's two sentences come to where it said them."""
    tight = grown[(grown["body"] == CUBE) & (grown["threshold"] == TIGHT)]
    explicit = tight[tight["method"].isin(steps.EXPLICIT)]
    rises = explicit[explicit["quantity"] == "steps in nodes"]
    works = explicit[explicit["quantity"] == "cost in nodes"]
    own_rise, own_work = (
        fits[fits["method"].isin(steps.VISCOUS)]["low"] for fits in (rises, works)
    )
    known = len(own_rise) == len(own_work) == len(steps.VISCOUS)
    refuted = known and (own_rise > 0).all() and (own_work > 1).all()
    said = (
        f"The report's O(n), its time to rest constant, in space and by its own viscous motion: "
        f"{'refuted' if refuted else 'not decided by these sizes'}. Theory has steps as "
        f"nodes^(1/3) and work as nodes^(4/3). Steps to an error of {TIGHT:g} grow as the "
        f"nodes to the power of: {powers(rises)}; work: {powers(works)}. {ends(counted)}"
    )
    fits = pd.concat([growing, growing_here.rename(columns={v: k for k, v in steps.HERE.items()})])
    products = fits[fits["quantity"] == "products"].set_index("way")
    told = ", ".join(
        f"{way} n^{edge['exponent']:.1f} [{edge['low']:.1f}, {edge['high']:.1f}] (theory "
        f"{edge['expected']:.0f})"
        for way, edge in (3 * products.drop(columns="quantity")).iterrows()
    )
    sparse = products.drop(index=FULL)
    verdict = (
        "only of a full matrix"
        if (sparse["high"] < products["expected"][FULL]).all()
        else "or not, these sizes do not decide"
    )
    last = factors[factors["cells"] == factors["cells"].max()].set_index("way")
    times = last["products"][FULL] / last["products"][DISSECTED]
    cubed = (
        f"The report's O(n^9) for elements, n nodes along the edge of a cube: it holds {verdict}. "
        f"Products grow as: {told}. With {factors['cells'].max()} cells along the edge, "
        f"{last['unknowns'].iloc[0]:,} unknowns, the full matrix takes {times:,.0f} times as many "
        "as nested dissection."
    )
    return said, cubed


def ends(counted: pd.DataFrame) -> str:
    """Steps of the report's algorithm on the smallest cube and on the largest."""
    done = counted[
        (counted["body"] == CUBE)
        & (counted["threshold"] == TIGHT)
        & (counted["method"] == "algorithm1")
        & (counted["outcome"] == "reached")
    ]
    told = (f"{row.steps:,} with {row.nodes:,} nodes" for row in done.itertuples(index=False))
    first, *_, last = [*told] or ["none", "none"]
    return f"Algorithm 1 takes {first}, {last}."


def powers(fits: pd.DataFrame) -> str:
    """Exponents and their intervals, by method."""
    return ", ".join(
        f"{row.method} {row.exponent:.2f} [{row.low:.2f}, {row.high:.2f}]"
        for row in fits.itertuples(index=False)
    )


DRAWN: dict[str, dict[str, Any]] = {
    FULL: {"color": COLOURS[1], "marker": "s"},
    DISSECTED: {"color": COLOURS[0], "marker": "o"},
    MULTIGRID: {"color": COLOURS[2], "marker": "^"},
}
SLOPES = {FULL: "-.", DISSECTED: "--", MULTIGRID: ":"}
LABELS = {"products": "products to solve for one load", "entries": "entries that are stored"}


def draw(tables: kit.Tables) -> Figure:
    """What the elements of a cube take to solve, against the nodes along its edge."""
    multigrid = tables["multigrid"].rename(columns={"products_here": "products"})
    table = pd.concat([tables["factors"], multigrid], ignore_index=True)
    figure, axes = kit.figures.new_figure(len(LABELS), size=(3.5, 3.2))
    for axis, (quantity, label) in zip(axes, LABELS.items(), strict=True):
        for way, part in table.dropna(subset=[quantity]).groupby("way", sort=False):
            edge = part["cells"].to_numpy() + 1.0
            values = part[quantity].to_numpy(dtype=float)
            axis.loglog(edge, values, label=str(way), **DRAWN[str(way)])
            if quantity == "products":
                slope = 3 * EXPECTED[str(way), quantity]
                line = 0.4 * values[-1] * (edge / edge[-1]) ** slope
                axis.loglog(edge, line, SLOPES[str(way)], color="black", label=f"n^{slope:.0f}")
        axis.set(xlabel="nodes along the edge, n (1)", ylabel=label)
    figure.suptitle("A cube of linear elements: work and memory to solve it")
    kit.figures.add_shared_legend(figure, axes, columns=3)
    return figure
