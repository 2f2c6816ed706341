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
           many steps at any size: n^3.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

import reference_fem
from msvalidate.judging.compare import fitted_power
from msvalidate.judging.counting import TIGHT
from msvalidate.judging.evidence import Evidence, Observed, Tables, Tolerance, by_quantity
from msvalidate.judging.sweep import Setting
from msvalidate.output import figures
from msvalidate.output.figures import COLOURS
from msvalidate.problem import Index, Mask, prescribed_displacements
from reference_fem.mesh.discretisation import Discretisation
from reference_fem.systems.dissection import node_order

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
RESTARTING = ("kinetic_damping", "adaptive", "conjugate_gradients")
CHECKED, QUICK_CHECKED = (6, 8, 10), (6, 8)
"""Cells along an edge of cubes that multigrid and a factor both bring to rest."""
TOLERANCES = (
    Tolerance(
        "exponent of steps in kappa, viscous methods on the cube, worst", 0.08, "1",
        "1/2 less what Algorithm 1 loses: of first order, damped critically for the exact motion, "
        "its two rates lie sqrt(e) apart, e = 1.8/sqrt(kappa) = 0.09 on the coarsest cube, which "
        "costs sqrt(e)/4 of the exponent there",
    ),
    Tolerance(
        "exponent of steps in nodes, viscous leapfrog on the cube", 0.08, "1",
        "1/3: n cells have n + 1 nodes along an edge, so that it is (1 + 1/n)/3 at first, 0.06 "
        "more with 6 cells; the clamped side adds two hundredths",
    ),
    Tolerance(
        "exponent of cost in nodes, viscous methods on the cube, worst", 0.15, "1",
        "4/3, and as above; nodes of the surface have fewer springs, which adds 0.07",
    ),
    Tolerance(
        "exponent of steps in nodes, kinetic and adaptive damping and conjugate gradients on the "
        "cube, worst", 1 / 6, "1",
        "nearer to 1/3 than to 0, the report's constant time, and to 2/3, as steepest descent "
        "steps",
    ),
    Tolerance(
        "exponent of steps in nodes, FIRE on the cube", 0.27, "1",
        "as above, and 0.1 more: its counts hang on the last digits, by a fifth on six times the "
        "nodes; still no constant",
    ),
    Tolerance(
        "exponent of cycles in nodes, Newton's method by multigrid on the cube", 1 / 6, "1",
        "nearer to constant than to 1/3, as explicit methods step",
    ),
    Tolerance(
        "cube at rest by multigrid from that by a factor, over the largest displacement, worst",
        1e-8, "1",
        "a hundredth of the smallest error that steps are counted to; forces are left at 1e-13, "
        "times a lever of the order of kappa, 1e4 at most",
    ),
    Tolerance(
        "cube of elements: exponent of the factor's entries in unknowns", 1 / 6, "1",
        "nearer to 4/3 than to 5/3, the band's; terms below the first fall as unknowns^(-1/3)",
    ),
    Tolerance(
        "cube of elements: exponent of the factor's products in unknowns", 1 / 6, "1",
        "nearer to 2 than to 7/3, the band's",
    ),
    Tolerance(
        "cube of elements: exponent of multigrid's cycles in unknowns", 1 / 6, "1",
        "nearer to constant than to 1/3, conjugate gradients without it",
    ),
)  # fmt: skip
COLUMNS = {
    **steps.COLUMNS,
    "way": "of solving the elements of a cube: factor of the full matrix, factor in nested "
    "dissection, or multigrid",
    "cells": "along an edge",
    "unknowns": "components that are not held",
    "entries": "of the factor; of multigrid, of the stiffness",
    "products": "multiplications to make the factor, one of a symmetric pair counted twice",
    "cycles_here": "of multigrid, one a step of conjugate gradients",
    "products_here": "entries of the stiffness times cycles; coarser levels add a part that is the "
    "same at any size",
    "expected": "exponent by theory (1)",
}


def run(counted: pd.DataFrame, grown: pd.DataFrame, setting: Setting) -> Evidence:
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
    at_rest = (
        bodies.relative_error(
            bodies.rest_by_multigrid(CUBE, edge), bodies.rest_displacement(CUBE, edge)
        )
        for edge in checked
    )
    seen = [*relaxations(grown), Observed(max(at_rest)), *elements(growing, growing_here)]
    return Evidence(
        tables={
            "factors": factors,
            "multigrid": cycles,
            "growth_of_factors": growing,
            "growth_of_multigrid": growing_here,
        },
        observed=by_quantity(TOLERANCES, seen),
        tolerances=TOLERANCES,
        figures={"elements_in_space": draw},
        columns=COLUMNS,
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


def free_nodes(mesh: Discretisation) -> Mask:
    """Nodes (n,) off the clamped side."""
    held, _ = prescribed_displacements(bodies.problem(CUBE), mesh.points)
    return np.asarray(~held.any(axis=1))


def in_order(mesh: Discretisation, order: Index) -> elimination.Counts:
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
                **fitted_power(part["unknowns"], part[quantity])._asdict(),
            }
            for (way, quantity), exponent in EXPECTED.items()
            if len(part := factors[factors["way"] == way])
        ]
    )


def relaxations(grown: pd.DataFrame) -> list[Observed]:
    """What the tolerances of springs judge, in their order."""
    asked = (
        ("steps in kappa", steps.VISCOUS),
        ("steps in nodes", ("viscous_leapfrog",)),
        ("cost in nodes", steps.VISCOUS),
        ("steps in nodes", RESTARTING),
        ("steps in nodes", ("fire",)),
        ("cycles in nodes", ("newton_multigrid",)),
    )
    return [steps.exponent(grown, quantity, (CUBE,), methods) for quantity, methods in asked]


def elements(growing: pd.DataFrame, growing_here: pd.DataFrame) -> list[Observed]:
    """What the tolerances of elements judge, in their order."""
    fits = growing.set_index(["way", "quantity"])["exponent"]
    here = growing_here.set_index(["way", "quantity"])["exponent_here"]
    judged = (
        (fits, (DISSECTED, "entries")),
        (fits, (DISSECTED, "products")),
        (here, (MULTIGRID, "cycles")),
    )
    return [Observed(float(found[what]), EXPECTED[what]) for found, what in judged]


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


def draw(tables: Tables) -> Figure:
    """What the elements of a cube take to solve, against the nodes along its edge."""
    multigrid = tables["multigrid"].rename(columns={"products_here": "products"})
    table = pd.concat([tables["factors"], multigrid], ignore_index=True)
    figure, axes = figures.new_figure(len(LABELS), size=(3.5, 3.2))
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
    figures.add_shared_legend(figure, axes, columns=3)
    return figure
