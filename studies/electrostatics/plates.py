"""Plates: are the capacitances of a square and of a disc alone in space found?

Question   Capacitance of thin bodies in space whose value is known.
Candidate  Patches of even charge with exact potentials, collocation, patches finer towards edges.
Reference  A disc has 8εa. A square has no closed form; 0.36679 times 4πε times its side is what
           several authors agree on.
Expected   With the n-th line from an edge n⁴ away, edges and corners no longer set the order, and
           evenly charged patches err with order 3 in their number along a side.
"""

from __future__ import annotations

from functools import partial
from itertools import product

import pandas as pd
from matplotlib.figure import Figure

from msvalidate import kit
from msvalidate.dielectric.charges import disc_capacitance, square_capacitance
from msvalidate.dielectric.charges.patches import disc, plate

from .common import ChargeSolver

SIDE = RADIUS = 1.0
ARCS = 256
"""Straight sides of a quarter of a ring: the polygon in the disc's place errs by some 2e-6."""
BODIES = {
    "square plate": (partial(plate, (SIDE, SIDE)), square_capacitance(SIDE)),
    "disc": (partial(disc, RADIUS, arcs=ARCS), disc_capacitance(RADIUS)),
}
"""Body -> how it is made of some patches across, and its capacitance over the permittivity (m)."""
ACROSS, QUICK_ACROSS = (8, 12, 16, 24, 32), (8, 12, 16, 24)
ORDER = 3.0
limit_of = partial(kit.Rule, unit="1", table="plate_limits", value="extrapolated", reference=1.0)
RULES = (
    limit_of(
        "capacitance of a square plate", 4e-5, rows={"body": "square plate"},
        because="errors fall with order 3 to 2e-4 at 24 patches across, of which extrapolation by "
        "that order leaves a tenth; the accepted value is known to 1.5e-5",
    ),
    limit_of(
        "capacitance of a disc", 5e-6, rows={"body": "disc"},
        because="errors fall with order 3 to 3e-5 at 24 rings, of which extrapolation by that "
        "order leaves a tenth; the polygon in the disc's place errs by 2e-6",
    ),
    limit_of(
        "order of the capacitance of square and disc", 0.3, value="order", reference=ORDER,
        because="the next term is smaller by a patch in the middle over the half width, a sixth to "
        "an eighteenth, with a factor of order 1; rings bring half of it",
    ),
)  # fmt: skip


def run(candidate: ChargeSolver, setting: kit.Setting) -> kit.Evidence:
    """Capacitances of both bodies on several meshes."""
    cases = list(product(BODIES, QUICK_ACROSS if setting.quick else ACROSS))
    table = pd.DataFrame(setting.sweep(partial(plate_rows, candidate), cases, "plates"))
    limits = pd.DataFrame([limit(str(body), rows) for body, rows in table.groupby("body")])
    return kit.Evidence(
        tables={"plates": table, "plate_limits": limits},
        tolerances=RULES,
        figures={"plates": draw},
        columns=kit.columns(__file__),
        findings=(finding(limits),),
    )


def plate_rows(candidate: ChargeSolver, case: tuple[str, int]) -> dict[str, object]:
    """Row of one mesh."""
    body, across = case
    made, accepted = BODIES[body]
    patches = made(across)
    return {
        "body": body,
        "patches_across": across,
        "patches": len(patches.corners),
        "capacitance_over_accepted": candidate.plates(patches) / accepted,
    }


def limit(body: str, rows: pd.DataFrame) -> dict[str, object]:
    """Row of the order, and of what the two finest meshes foretell."""
    n, value = rows["patches_across"].to_numpy(float), rows["capacitance_over_accepted"].to_numpy()
    growth = (n[-1] / n[-2]) ** ORDER
    return {
        "body": body,
        "order": kit.observed_order(1 / n, value - 1),
        "extrapolated": float(value[-1] + (value[-1] - value[-2]) / (growth - 1)),
    }


def finding(limits: pd.DataFrame) -> str:
    """Extrapolated values, in a sentence."""
    said = ", ".join(
        f"{row.body} {row.error:+.1e} (order {row.order:.2f})"
        for row in limits.assign(error=limits["extrapolated"] - 1).itertuples()
    )
    return f"Capacitance in space over the accepted one, less 1: {said}."


def draw(tables: kit.Tables) -> Figure:
    """Errors against the number of patches along a side."""
    table = tables["plates"]
    table = table.assign(error=(table["capacitance_over_accepted"] - 1).abs())
    figure, (axis,) = kit.figures.new_figure(size=(4.2, 3.3))
    for place, (body, rows) in enumerate(table.groupby("body", sort=False)):
        style = kit.figures.series_style(place)
        axis.loglog(rows["patches_across"], rows["error"], label=str(body), **style)
    kit.figures.draw_order(axis, table["patches_across"], 2 * table["error"].max(), ORDER)
    kit.figures.tick_at(axis, table["patches_across"])
    axis.set_xlabel("patches along a side,\nor rings of the disc (1)")
    axis.set_ylabel("relative error\nof the capacitance (1)")
    axis.set_title("Capacitance of plates alone in space")
    axis.legend()
    return figure
