"""Nodes: should charge sit on springs, as in the report, or on the points between them?

Question   Which of the two finds the charge of an electrode better, and what becomes of the forces?
Candidate  Plane charges by collocation, even on springs or even on the halves of springs that meet
           at a point. Forces as derivatives of the energy, or Coulomb's law between middles of
           springs, halves to each end, or between the points.
Reference  The closed form of facing strips, central differences of each one's own energy, and what
           forces times their places add up to by the plane's law.
Expected   Both err with order 1 on even springs. Springs spread the charge of the edge too far
           inwards and take too little; a node at the edge has its potential asked for at the very
           edge, where its own charge makes the least, and takes too much. Sums over points are no
           derivative of an energy.
"""

from __future__ import annotations

from functools import partial
from itertools import product

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from msvalidate import kit
from msvalidate.dielectric.charges import facing_strips_capacitance
from msvalidate.dielectric.charges.pieces import PLACES
from msvalidate.dielectric.charges.report_model import (
    ReportCharges,
    consistent_forces,
    report_forces,
)

from .common import VOLTAGES, ChargeSolver, pair
from .derivatives import differences, growth, steps_of
from .shortcuts import HALF, RATIO

SEGMENTS = (30, 60, 120, 240, 480)
QUICK_SEGMENTS = (30, 60, 120)
WAVY, WAVY_WIDTH = 6, 4.0
"""Springs and width over gap of wavy electrodes, whose forces are held to the energy."""
FORCES = {"derivatives": consistent_forces, "point sums": report_forces}
WAYS = tuple(product(PLACES, FORCES))
RULES = (
    kit.Rule(
        "forces by charges on springs and on nodes, farthest from their energy's derivatives",
        1e-6, "of the largest force",
        "differences of fourth order with steps of a hundredth of a segment",
        table="nodes_own_energy", rows={"forces_by": 'derivatives'}, value="own_error",
    ),
    kit.Rule(
        "order of the charge by charges on springs and on nodes", 0.1, "1",
        "the last piece's length makes the error; the next term is smaller by it over the gap",
        table="nodes_orders", value="order", reference=1.0,
    ),
)  # fmt: skip


def run(candidate: ChargeSolver, setting: kit.Setting) -> kit.Evidence:
    """Compare four ways."""
    numbers = QUICK_SEGMENTS if setting.quick else SEGMENTS
    cases = list(product(WAYS, numbers))
    table = pd.DataFrame(setting.sweep(partial(flat_strips, candidate), cases, "springs and nodes"))
    own = pd.DataFrame([compare_with_own_energy(candidate, *way) for way in WAYS])
    once = table[table["forces_by"] == "derivatives"]
    orders = pd.DataFrame(
        [
            {
                "charges_on": where,
                "order": kit.observed_order(1 / rows["segments"], rows["charge_error"]),
            }
            for where, rows in once.groupby("charges_on", sort=False)
        ]
    )
    by_law = (
        kit.Tolerance(
            "sum of forces times places on wavy electrodes, from what the plane's law makes of it",
            2e-14, "of the sum of forces times the width",
            "the plane's energy has no unit of length, so its derivatives add up to nothing; in "
            "sums over pairs of points each adds its qq'/(2πε), -Σq²/(4πε) in all of charges that "
            "are neutral; rounding of 2e-16 times a condition of ten, and ten times that for "
            "differences",
            observed=kit.farthest_value([unit_of_length(candidate, *way) for way in WAYS], 0.0),
        ),
    )  # fmt: skip
    return kit.Evidence(
        tables={"nodes": table, "nodes_own_energy": own, "nodes_orders": orders},
        tolerances=(*RULES, *by_law),
        figures={"nodes": draw},
        columns=kit.columns(__file__),
        findings=(finding(table, own),),
    )


def charge_nodes(candidate: ChargeSolver, where: str, electrodes: object) -> ReportCharges:
    """Charges of a pair of electrodes."""
    return candidate.report(electrodes, kernel="plane", charges_on=where).charges(VOLTAGES)


def flat_strips(candidate: ChargeSolver, case: tuple[tuple[str, str], int]) -> dict[str, object]:
    """Row of two flat strips of even springs."""
    (where, how), segments = case
    electrodes = pair("flat", RATIO, segments, grading="uniform")
    found = charge_nodes(candidate, where, electrodes)
    force = FORCES[how](found)
    work = HALF * growth(RATIO) * RATIO
    return {
        "charges_on": where,
        "forces_by": how,
        "segments": segments,
        "charge_error": float(found.totals[0]) / facing_strips_capacitance(RATIO) - 1,
        "pull_error": float(-force[: segments + 1, 1].sum()) / work - 1,
        "stretch_error": float(electrodes.points[:, 0] @ force[:, 0]) / work - 1,
        "edge_along": float(force[segments, 0]) * 2 * RATIO / work,
    }


def compare_with_own_energy(candidate: ChargeSolver, where: str, how: str) -> dict[str, object]:
    """Row of wavy electrodes."""
    electrodes = pair("wavy", WAVY_WIDTH, WAVY)
    points = electrodes.points

    def energy(x: kit.Array) -> kit.Array:
        return np.array(charge_nodes(candidate, where, electrodes.moved(x.reshape(-1, 2))).energy)

    force = FORCES[how](charge_nodes(candidate, where, electrodes))
    exact = differences(energy, points.ravel(), steps_of(points)).reshape(-1, 2)
    moment = points[:, 0] @ force[:, 1] - points[:, 1] @ force[:, 0]
    sizes = np.hypot(*exact.T)
    return {
        "charges_on": where,
        "forces_by": how,
        "own_error": float(np.hypot(*(force - exact).T).max() / sizes.max()),
        "own_moment": float(abs(moment) / (sizes.sum() * WAVY_WIDTH)),
    }


def unit_of_length(candidate: ChargeSolver, where: str, how: str) -> float:
    """Σx·F of wavy electrodes less that of the plane's law, over the sum of |F| times the width."""
    electrodes = pair("wavy", WAVY_WIDTH, WAVY)
    found = charge_nodes(candidate, where, electrodes)
    force = FORCES[how](found)
    alone = float((found.charge**2).sum()) / (4 * np.pi * found.moments.permittivity)
    expected = 0.0 if how == "derivatives" else -alone
    sizes = np.hypot(*force.T)
    return float(((electrodes.points * force).sum() - expected) / (sizes.sum() * WAVY_WIDTH))


def finding(table: pd.DataFrame, own: pd.DataFrame) -> str:
    """Springs against nodes, in sentences."""
    keys = ["charges_on", "forces_by"]
    last = table[table["segments"] == table["segments"].min()].set_index(keys)
    wrong = own.set_index(keys)["own_error"]
    charge, stretch = last["charge_error"], last["stretch_error"]
    said = []
    for where in PLACES:
        said.append(
            f"on {where} the charge errs by {charge[where, 'derivatives']:+.2%}; point sums miss "
            f"derivatives of the energy by {wrong[where, 'point sums']:.0%} of the largest force "
            f"on wavy electrodes, and stretch by {stretch[where, 'point sums']:+.1%}"
        )
    return f"With {last['segments'].iloc[0]} even springs a strip, " + "; ".join(said) + "."


def draw(tables: kit.Tables) -> Figure:
    """Errors of charge and stretch against the number of springs."""
    table = tables["nodes"]
    figure, (charge, stretch) = kit.figures.new_figure(2, size=(3.5, 3.4))
    groups = table.groupby(["charges_on", "forces_by"], sort=False)
    for place, ((where, how), rows) in enumerate(groups):
        style, name = kit.figures.series_style(place), f"on {where}, {how}"
        if how == "derivatives":
            charge.loglog(rows["segments"], rows["charge_error"].abs(), label=name, **style)
        stretch.loglog(rows["segments"], rows["stretch_error"].abs(), label=name, **style)
    for axis, column in ((charge, "charge_error"), (stretch, "stretch_error")):
        kit.figures.draw_order(axis, table["segments"], 1.6 * table[column].abs().max(), 1)
        kit.figures.tick_at(axis, table["segments"])
        axis.set_xlabel("springs of each\nelectrode (1)")
    charge.set_ylabel("relative error\nof the charge (1)")
    stretch.set_ylabel("relative error of\nthe stretch, w·dW/dw (1)")
    figure.suptitle("Charges on springs or on nodes: facing strips")
    kit.figures.add_shared_legend(figure, [charge, stretch], columns=2)
    return figure
