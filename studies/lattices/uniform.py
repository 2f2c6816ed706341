"""Uniform: does a body of lattice show the solid's own constants?

Question   Modulus, ratio and anisotropy of boxes of whole cells under a uniform stress, tractions
           on every side and supports that take no force.
Candidate  Static equilibrium of the spring network, boundary springs shared.
Reference  The solid's tensor. Strains are those on which the tractions' stress does work, so they
           need no gauge; which sizes are exact, and at what order the others converge, is read off
           the pattern: `edges`.
Expected   Where every spring runs inside a cell or along its sides, cells are alike and a pull is
           exact at each size. Springs across a side are cut there: the points just inside have lost
           a neighbour and nothing on the side can replace it, an error of first order. Springs
           along the cube's diagonals leave a force normal to a shear at the body's eight corners,
           which no traction balances: third order, since its reach is a cell along each axis.
"""

from __future__ import annotations

from functools import partial
from itertools import product

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from msvalidate import kit
from msvalidate.springs.lattice import patterns

from . import cases, edges, loading
from .cases import Case, Solid
from .solids import from_compliance, is_cubic

SIZES = {2: (8, 16, 32), 3: (2, 3, 4, 6, 8)}
QUICK = {2: (8, 16, 32), 3: (2, 3, 4)}
"""Cells along an edge, about, by the number of axes."""
EXACT = 1e-9


def run(candidate: kit.DisplacementSolver, solid: Solid, setting: kit.Setting) -> kit.Evidence:
    """Stretch and shear bodies, and judge them."""
    table = measure_bodies(candidate, solid, setting)
    orders = approach(table, solid)
    crossing = [case for case in cases.stiff(solid) if edges.crosses(case)]
    mended = pd.DataFrame(setting.sweep(edges.rebuild_lattice, crossing, "weights"))
    return kit.Evidence(
        tables={"uniform": table, "uniform_order": orders}
        | ({"crossing": mended} if len(mended) else {}),
        tolerances=RULES,
        figures={"uniform": draw},
        columns=kit.columns(__file__),
        findings=findings(table, orders, mended),
    )


def measure_bodies(
    candidate: kit.DisplacementSolver, solid: Solid, setting: kit.Setting
) -> pd.DataFrame:
    """The table `uniform`."""
    wanted = QUICK if setting.quick else SIZES
    todo = [
        (case, across)
        for case in cases.stiff(solid)
        for across in cases.sizes(case, wanted[case.pattern.dim])
    ]
    return pd.DataFrame(setting.sweep(partial(measure, candidate, solid), todo, "uniform stress"))


def measure(
    candidate: kit.DisplacementSolver, solid: Solid, todo: tuple[Case, int]
) -> dict[str, object]:
    """One row of the table `uniform`."""
    case, across = todo
    lattice = cases.fill_box(case, across)
    body = cases.material(solid, case, lattice)
    own = loading.compliances(body.C)
    S = loading.compliance(candidate, lattice, case.constants, body)
    E, nu, A = from_compliance(*S)
    E_solid, nu_solid, _ = from_compliance(own[0, 0], own[1, 0], own[-1, -1])
    return case.head | {
        "cells": cases.cells_along(lattice),
        "points": len(lattice.points),
        "spacing": lattice.spacing,
        "E_over": E / E_solid,
        "nu_measured": nu,
        "A_measured": A if is_cubic(body.C) else "none",
        "pull_error": S[0] / own[0, 0] - 1,
        "across_error": nu - nu_solid,
        "shear_error": S[2] / own[-1, -1] - 1,
    }


def approach(table: pd.DataFrame, solid: Solid) -> pd.DataFrame:
    """The table `uniform_order`."""
    rows = []
    for case in cases.stiff(solid):
        pattern = case.pattern
        mine = table[(table["lattice"] == pattern.name) & (table["rule"] == case.rule)]
        pair = mine.iloc[-2:]
        for test in loading.TESTS:
            few = edges.unbalanced_force(case, solid, test)
            expected = "exact" if few is None else few or "none"
            crosses = "yes" if edges.crosses(case) else "no"
            row: dict[str, object] = {"test": test, "springs_cross": crosses}
            row |= {
                "unbalanced": edges.locate_springs(few, pattern.dim),
                "order_expected": expected,
            }
            error = pair[f"{test}_error"].to_numpy()
            row |= {"order": order(pair["spacing"], error)}
            both = ["pull_error", "across_error"] if test == "pull" else ["shear_error"]
            rows.append(case.head | row | {"largest_error": mine[both].abs().to_numpy().max()})
    return pd.DataFrame(rows)


def order(spacing: pd.Series, error: kit.Array) -> float | str:
    """Power with which an error fell, or that there is none."""
    return "exact" if np.abs(error).max() <= EXACT else kit.observed_order(spacing, error)


FALLING = {"order_expected": (1, 2, 3)}
RULES = (
    kit.Rule(
        "bodies that should be exact: error of E, nu or G, relative", EXACT, "1",
        "cells that share springs are all alike: uniform strain is exact; left is rounding, "
        "1e-16 times a condition number of up to 1e5",
        table="uniform_order", rows={"order_expected": "exact"}, value="largest_error",
    ),
    kit.Rule(
        "bodies that should not be exact and are", 0, "1",
        "a force that nothing balances moves points: the pattern says which tests have one",
        table="uniform_order", rows=FALLING, value=lambda rows: rows["order"] == "exact",
    ),
    kit.Rule(
        "order of the error of the finest pair, from that of the pattern's edges", 0.35, "1",
        "the next term is of one order more: as large as the first at one cell, it adds a part "
        "1/N, 0.29 for 3 and 4 cells",
        table="uniform_order", rows=FALLING, reference="order_expected",
        value=lambda rows: pd.to_numeric(rows["order"], errors="coerce"),
    ),
)  # fmt: skip


def findings(table: pd.DataFrame, orders: pd.DataFrame, mended: pd.DataFrame) -> tuple[str, ...]:
    """Which bodies are exact, which are not, and why."""
    by = orders.groupby(["lattice", "rule"], sort=False)
    exact = [", ".join(map(str, key)) for key, rows in by if (rows["order"] == "exact").all()]
    said = [f"Uniform stress is exact at the sizes tried in: {'; '.join(exact)}."]
    corners = orders[(orders["unbalanced"] == "corners") & (orders["springs_cross"] == "no")]
    if len(corners):
        said.append(
            f"{_names(corners)}: exact when pulled, but in shear the diagonals of the cube leave a "
            "force at each corner of the body, along the axis that the shear does not name. The "
            f"error is of third order: {_orders(corners)}."
        )
    if len(mended):
        said += _of_crossing(table, orders, mended)
    return tuple(said)


def _of_crossing(table: pd.DataFrame, orders: pd.DataFrame, mended: pd.DataFrame) -> list[str]:
    """What lattices with springs across sides lose, and what mends it."""
    # Where points move inside a cell, or weights would do, the reasons told here are not theirs.
    left = pd.to_numeric(mended["left_over"], errors="coerce")
    lost = mended[left > edges.BALANCED][["lattice", "rule"]]
    cut = orders[(orders["springs_cross"] == "yes") & (orders["test"] == "pull")].merge(lost)
    if not len(cut):
        return []
    bodies = table.merge(cut[["lattice", "rule"]])
    softest = bodies.nsmallest(1, "E_over").iloc[0]
    said = []
    said.append(
        f"{_names(cut)}: springs that run from cell to cell are cut off at a side, and bodies are "
        f"too soft by an error of first order ({_orders(cut)}): {softest['E_over']:.2f} of the "
        f"solid's modulus at {softest['cells']:g} cells. While springs inside keep their constants "
        "no weights of those at the boundary mend it: some strain loads a row of such springs and "
        "none beside it, and the last of the row pulls on a point that nothing else holds."
    )
    error = pd.to_numeric(mended["pull_error_rewired"], errors="coerce").abs()
    exact = mended[error <= EXACT]
    if len(exact):
        said.append(
            f"{_names(exact)}: another network is the same solid and exact when pulled: without "
            "the springs that cross, those of their kind and direction that stay in a cell taking "
            "over their stiffness."
        )
    return said


def _names(rows: pd.DataFrame) -> str:
    return ", ".join(dict.fromkeys(rows["lattice"]))


def _orders(rows: pd.DataFrame) -> str:
    found = pd.to_numeric(rows["order"], errors="coerce")
    return f"orders observed {found.min():.2f} to {found.max():.2f}"


def draw(tables: kit.Tables) -> Figure:
    """Error of the strain against cells: a row for plane and space, a column a test."""
    table, orders = tables["uniform"], tables["uniform_order"]
    known = {kind().name: kind().dim for kind in patterns.all_patterns().values()}
    inexact = orders[orders["order"] != "exact"].assign(axes=orders["lattice"].map(known))
    dims = sorted(set(inexact["axes"]))
    tests = loading.TESTS
    figure, axes = kit.figures.new_figure(len(tests), len(dims), size=(3.3, 2.9), sharey=True)
    names = list(dict.fromkeys(zip(table["lattice"], table["rule"], strict=True)))
    for axis, (dim, test) in zip(axes, product(dims, tests), strict=True):
        here = inexact[(inexact["axes"] == dim) & (inexact["test"] == test)]
        for row in here.itertuples():
            mine = table[(table["lattice"] == row.lattice) & (table["rule"] == row.rule)]
            axis.loglog(
                mine["cells"],
                mine[f"{test}_error"].abs(),
                label=f"{row.lattice}, {row.rule}",
                **cases.style(names.index((row.lattice, row.rule))),
            )
        sizes = table.merge(inexact[inexact["axes"] == dim][["lattice", "rule"]])["cells"]
        cells = np.array(sorted(set(sizes)), dtype=float)
        for power, line in ((1, ":"), (3, "--")):
            below = 0.6 * (cells / cells[0]) ** -power
            axis.loglog(cells, below, line, color="grey", label=f"slope -{power}")
        axis.set_xticks(cells, [f"{n:g}" for n in cells])
        axis.set_title(f"{'plane' if dim == 2 else 'space'}, {test}")
        axis.set_xlabel("cells along the body (1)")
    for axis in axes[:: len(tests)]:
        axis.set_ylabel("error of the strain (1)")
    figure.suptitle("Bodies under uniform stress whose strain is not exact")
    kit.figures.add_shared_legend(figure, axes, columns=3)
    return figure
