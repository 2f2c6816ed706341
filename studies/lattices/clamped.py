"""Clamped: how far is a body of lattice from the elastic body, where stress is not uniform?

Question   The work of the load on boxes held on one side and pulled, or sheared, at the other: its
           difference from the elastic body, and the order at which that falls.
Candidate  Static equilibrium of the spring network, boundary springs shared.
Reference  Finite elements of the body with the lattice's own, anisotropic tensor: Q2 in the
           plane and H1 in space, on three meshes, and extrapolated.
Expected   Stress is singular where the held side ends: twice the exponent of the displacement there
           is the order of a lattice, 1.26 to 1.49 here, as it is of elements. Lattices that lose
           springs at a side have an error of first order instead, and of the other sign: too soft,
           not too stiff. Sheared, the two cancel at a few cells.
"""

from __future__ import annotations

from functools import partial

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from msvalidate import kit
from msvalidate.springs.bodies.lattice_network import lattice_network

from . import cases, edges, elastic, loading
from .cases import Case, Solid

SIZES = {2: (8, 16, 32, 64), 3: (2, 4, 6, 8)}
QUICK = {2: (8, 16, 32), 3: (2, 3, 4)}
"""Cells along an edge, about, by the number of axes."""
DOUBT = 0.25
"""Part of an error that the reference's own may be: the order is then known to 0.4 at most."""
ALIKE = 0.2
"""Largest distance of an order seen from that of the limit."""


def _away(rows: pd.DataFrame) -> pd.Series | float:
    """Orders that are resolved, from those expected; NaN, which fails, where there is none."""
    known = rows[rows["clamped_order"] != "not resolved"]
    away = pd.to_numeric(known["clamped_order"], errors="coerce") - known["clamped_expected"]
    return away if len(away) else np.nan


RULES = (
    kit.Rule(
        "work of elastic bodies: uncertainty, relative", 0.02, "1",
        "half of what an extrapolation adds, 2.4 % on 12 cells at most: a tenth of the coarsest "
        "lattices' difference; whether it serves for an order, clamped_order says",
        table="clamped", value="uncertainty",
    ),
    kit.Rule(
        "lattices of like cells: order, from twice the exponent of the clamped side's end",
        ALIKE, "1",
        "a sheared body bends as well, with an error of order 2 beside that of its corners, "
        "and a pulled one has weak corners: two sizes are off by 0.17 and -0.12 at 16 and 32 "
        "cells of the plane, and by -0.18 at 3 and 4 of space",
        table="clamped_order", rows={"springs_cross": "no"}, value=_away,
    ),
    kit.Rule(
        "lattices with springs across sides, pulled: order, from 1", ALIKE, "1",
        "the next term is of order 1.4 to 1.6 and smaller by far: 0.08 for 3 and 4 cells",
        table="clamped_order", rows={"springs_cross": "yes", "test": "pull"}, value=_away,
    ),
    kit.Rule(
        "lattices whose difference does not fall with the spacing", 0, "1",
        "every lattice converges to its solid; where springs cross sides and the body is "
        "sheared, two errors of opposite sign cancel at few cells, so those are left out",
        table="clamped_order", value=lambda rows: (
            (rows["falls"] == "no") & ((rows["springs_cross"] == "no") | (rows["test"] == "pull"))
        ).sum(),
    ),
)  # fmt: skip


def run(candidate: kit.DisplacementSolver, solid: Solid, setting: kit.Setting) -> kit.Evidence:
    """Load clamped bodies, and judge them."""
    table = measure(candidate, solid, setting)
    orders = approach(table, solid)
    return kit.Evidence(
        tables={"clamped": table, "clamped_order": orders},
        tolerances=RULES,
        figures={"clamped": draw},
        columns=kit.columns(__file__),
        findings=findings(table, orders),
    )


def measure(candidate: kit.DisplacementSolver, solid: Solid, setting: kit.Setting) -> pd.DataFrame:
    """The table `clamped`."""
    wanted = QUICK if setting.quick else SIZES
    todo = [
        (case, test, across)
        for case in cases.stiff(solid)
        for test in loading.TESTS
        for across in cases.sizes(case, wanted[case.pattern.dim])
    ]
    works = setting.sweep(partial(lattice_work, candidate, solid), todo, "clamped lattices")
    references = elastic.bodies(solid, setting)
    rows = []
    for (case, test, across), work in zip(todo, works, strict=True):
        lattice = cases.fill_box(case, across)
        reference = references[case][test]
        rows.append(
            case.head
            | {
                "test": test,
                "cells": cases.cells_along(lattice),
                "spacing": lattice.spacing,
                "work": work,
                "work_fem": reference.work,
                "uncertainty": reference.uncertainty,
                "difference": work / reference.work - 1,
            }
        )
    return pd.DataFrame(rows)


def lattice_work(
    candidate: kit.DisplacementSolver, solid: Solid, todo: tuple[Case, str, int]
) -> float:
    """Work of the load on a clamped lattice, over that on a free bar of the solid's modulus."""
    case, test, across = todo
    lattice = cases.fill_box(case, across)
    body = cases.material(solid, case, lattice)
    size = loading.STRAIN * loading.modulus(body.C)
    problem = loading.clamped(cases.box_of(lattice), body, test, size)
    network = lattice_network(problem, lattice, case.constants)
    free = size * loading.STRAIN * lattice.domain.volume
    return loading.work(network, candidate(problem, network, "linear")) / free


def approach(table: pd.DataFrame, solid: Solid) -> pd.DataFrame:
    """The table `clamped_order`."""
    rows = []
    for case in cases.stiff(solid):
        pattern = case.pattern
        corner = elastic.corner_order(cases.tensor_of(solid, case), pattern.dim)
        crosses = edges.crosses(case)
        mine = table[(table["lattice"] == pattern.name) & (table["rule"] == case.rule)]
        for test in loading.TESTS:
            own = mine[mine["test"] == test]
            first, *_, last = own["difference"].abs()
            row = {"axes": pattern.dim, "test": test, "springs_cross": "yes" if crosses else "no"}
            row |= {"twice_exponent": corner, "clamped_expected": 1.0 if crosses else corner}
            row |= {"clamped_order": order(own.iloc[-2:]), "falls": "yes" if last < first else "no"}
            rows.append(case.head | row)
    return pd.DataFrame(rows)


def order(pair: pd.DataFrame) -> float | str:
    """Power with which the difference fell between two sizes, or why there is none."""
    gap = pair["difference"].to_numpy()
    if pair["uncertainty"].iloc[-1] > DOUBT * abs(gap[-1]):
        return "not resolved"
    if gap[0] * gap[1] <= 0 or abs(gap[1]) >= abs(gap[0]):
        return "not asymptotic"
    return kit.observed_order(pair["spacing"], gap)


def findings(table: pd.DataFrame, orders: pd.DataFrame) -> tuple[str, ...]:
    """How near lattices come at one size, and how fast they come nearer."""
    said = []
    for axes, place in ((2, "in the plane"), (3, "in space")):
        names = orders[orders["axes"] == axes][["lattice", "rule"]].drop_duplicates()
        if not len(names):
            continue
        mine = table.merge(names)
        finest = mine.groupby(["lattice", "rule", "test"], sort=False).last().reset_index()
        told = "; ".join(
            f"{lattice}, {rule} "
            + " and ".join(f"{row.difference:+.2%} in {row.test}" for row in rows.itertuples())
            for (lattice, rule), rows in finest.groupby(["lattice", "rule"], sort=False)
        )
        said.append(
            f"Clamped bodies {place}, work of the load against elasticity at "
            f"{finest['cells'].max()} cells: {told}."
        )
    return tuple(said)


def of_one_sign(difference: pd.Series) -> list[pd.Index]:
    """Labels of the stretches of a sequence whose values have one sign, in their order."""
    stiff = difference < 0
    return [part.index for _, part in difference.groupby((stiff != stiff.shift()).cumsum())]


def draw(tables: kit.Tables) -> Figure:
    """Difference against the number of cells: a row for plane and space, a column a test.

    Markers are open where the lattice is too stiff; a line breaks where the sign changes.
    """
    table, orders = tables["clamped"], tables["clamped_order"]
    names = list(dict.fromkeys(zip(orders["lattice"], orders["rule"], strict=True)))
    dims = sorted(set(orders["axes"]))
    figure, axes = kit.figures.new_figure(2, len(dims), size=(3.3, 2.9), sharey="row")
    places = [(dim, test) for dim in dims for test in loading.TESTS]
    for axis, (dim, test) in zip(axes, places, strict=True):
        part = orders[(orders["axes"] == dim) & (orders["test"] == test)]
        for row in part.itertuples():
            mine = table[
                (table["lattice"] == row.lattice)
                & (table["rule"] == row.rule)
                & (table["test"] == test)
            ]
            style = cases.style(names.index((row.lattice, row.rule)))
            label = f"{row.lattice}, {row.rule}"
            axis.plot([], [], label=label, **style)  # for the legend: markers filled
            for run in of_one_sign(mine["difference"]):
                part_of = mine.loc[run]
                stiff = part_of["difference"].iloc[0] < 0
                mfc = "white" if stiff else style["color"]
                axis.loglog(part_of["cells"], part_of["difference"].abs(), mfc=mfc, **style)
        cells = np.array(sorted(set(table.merge(part)["cells"])), dtype=float)
        for power, dashes in ((1, ":"), (1.5, "--")):
            line = 0.5 * table.merge(part)["difference"].abs().max() * (cells / cells[0]) ** -power
            axis.loglog(cells, line, dashes, color="grey", label=f"slope -{power}")
        axis.set_xticks(cells, [f"{n:g}" for n in cells])
        axis.set_title(f"{'plane' if dim == 2 else 'space'}, {test}")
        axis.set_xlabel("cells along the body (1)")
    for axis in axes[::2]:
        axis.set_ylabel("difference (1)")
    axes[0].plot([], [], "o", color="black", mfc="white", label="too stiff")
    axes[0].plot([], [], "o", color="black", label="too soft")
    figure.suptitle("Work of the load on clamped bodies, beside their solids'")
    kit.figures.add_shared_legend(figure, axes, columns=3)
    return figure
