"""Models: the report's model, the plane model and the dielectric in air, side by side.

Question   Which charge, squeeze and margin does each model give a slab of w/d = 6?
Candidate  The report's kernel 1/(4πεr) on springs as rectangles 1, 6, 24 and more gaps deep, with
           Coulomb's law between middles and halves to ends; the plane model; the slab in air with
           permittivity ratios 1, 3 and 10. Springs as long as a tenth of the gap in all.
Reference  The plane model with the slab's permittivity all around, Galerkin, which every table is
           relative to. Plates in space by patches, which are other formulas: the report's own
           rectangles, and plates whose charge is free to gather along the depth as well.
Expected   The report's kernel describes plates of some depth in open space, with two margins more.
           The deeper, the nearer to the plane, like 1/depth; charge that is even along the depth
           and asked for in its middle leaves most of those margins out. Point sums put a rectangle
           into one point, and pull too hard as soon as it is deeper than the gap. Air takes away
           what the margin has outside the slab: charge falls to that of plates without margin, the
           force along the edge to a part, what stretches half the slab by little. In the middle all
           squeeze with ½ε(V/d)², the nearer the less the air lets through.
"""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numpy as np
import pandas as pd

from msvalidate import kit
from msvalidate.dielectric.charges import Electrodes, facing_strips, facing_strips_capacitance
from msvalidate.dielectric.charges.faces import slab_faces
from msvalidate.dielectric.charges.patches import Patches, conductors, plate
from msvalidate.dielectric.charges.report_model import report_forces

from .common import ChargeSolver
from .model_cases import DEPTHS, MODELS, PLANE, RATIOS, Model
from .models_drawing import draw

RATIO = 6.0
"""Width over gap."""
SPRINGS = 60
VOLTAGES = (0.5, -0.5)
DEEP = (96.0, 192.0)
"""Depths from which the endless one is foretold."""
ACROSS = 16
"""Patches along each side of plates whose charge is free along the depth."""
MIDDLE, MARGIN = 1.0, 0.5
"""Width over the gap of what counts as the middle, and as the margin."""


class Upper(NamedTuple):
    """Charge of the upper electrode, places (n, 2) from its middle, forces (n, 2) on its points.

    And the force along on all that is to the right of the middle (N/m).
    """

    charge: float
    points: kit.Array
    forces: kit.Array
    stretch: float = 0.0


def run(candidate: ChargeSolver, setting: kit.Setting) -> kit.Evidence:
    """Charge, squeeze and margin of every model."""
    found = setting.sweep(partial(upper, candidate), MODELS, "models")
    plane = found[0]
    table = pd.DataFrame([row(*pair, plane) for pair in zip(MODELS, found, strict=True)])
    lines = pd.concat([line(*pair) for pair in zip(MODELS, found, strict=True)], ignore_index=True)
    depths = pd.DataFrame([at_depth(candidate, depth) for depth in (*DEPTHS, *DEEP)])
    first, second = depths["as_report_over_plane"].iloc[-2:]
    air, ten = found[MODELS.index(Model("in air", "endless", "derivatives", 1.0))], table.iloc[-1]
    own = (
        kit.Tolerance(
            "charge of the report's model at endless depth over the plane model's", 1e-3, "1",
            "both by collocation on the same springs, asked for at half the depth: charge falls to "
            "the plane's like 1/depth or faster, and two depths leave terms of (w/depth)², 1e-3",
            observed=kit.Observed(second + (second - first) * DEEP[0] / (DEEP[1] - DEEP[0]), 1.0),
        ),
        kit.Tolerance(
            "charge of the report's model against the same plates by patches", 1e-9, "1",
            "the same equations by other formulas; rounding times their condition",
            observed=by_patches(candidate),
        ),
        kit.Tolerance(
            "charge and forces of the slab in air at ratio 1, against the plane model",
            1e-9, "of the largest",
            "no bound charge is left, and the equations are Galerkin's; rounding times their "
            "condition",
            observed=kit.farthest_value( [air.charge / plane.charge,
            *(air.forces / np.abs(plane.forces).max()).ravel()], [1.0,
            *(plane.forces / np.abs(plane.forces).max()).ravel()], ),
        ),
        kit.Tolerance(
            "squeeze in the middle in air, ratio 10, over ½ε(V/d)²", 5e-3, "1",
            "the field above the middle, d/w of that in the gap or so, pulls back with its square "
            "over the ratio, 0.003; the margin's field decays inwards like exp(-2πx/d)",
            observed=kit.Observed(float(ten["squeeze_in_middle"]), 1.0),
        ),
    )  # fmt: skip
    return kit.Evidence(
        tables={"models": table, "depths": depths},
        tolerances=own,
        drawn={"along_electrode": lines},
        figures={"models": draw},
        columns=kit.columns(__file__),
        findings=(finding(table, depths),),
    )


def electrodes() -> Electrodes:
    """The strips, of springs as long as a tenth of the gap."""
    return facing_strips(RATIO, 1.0, SPRINGS, grading="uniform")


def upper(candidate: ChargeSolver, model: Model) -> Upper:
    """Charge of the upper electrode and the forces on its points, from left to right."""
    if model.name == "in air":
        faces = slab_faces(RATIO, 1.0, SPRINGS, grading="uniform")
        found = candidate.in_air(faces, ratio=model.ratio).charges(VOLTAGES)
        top = np.flatnonzero(np.abs(faces.points[:, 1] - 1.0) < 1e-9)
        top = top[np.argsort(faces.points[top, 0], kind="stable")]
        force = candidate.forces_in_air(found)
        stretch = right_half(faces.points, force)
        return Upper(float(found.totals[0]), faces.points[top] - (0, 1), force[top], stretch)
    given = electrodes()
    top = np.arange(SPRINGS + 1)
    if model == PLANE:
        charges = candidate.charges(given, VOLTAGES)
        total, force = charges.totals[0], candidate.forces(charges)
    else:
        kernel = {"kernel": "plane"} if model.name == "plane" else {"depth": model.depth}
        as_report = candidate.report(given, **kernel).charges(VOLTAGES)
        total, force = as_report.totals[0], report_forces(as_report)
    stretch = right_half(given.points, force)
    return Upper(float(total), given.points[top] - (0, 1), force[top], stretch)


def squeeze(found: Upper, width: float, *, margin: bool = False) -> float:
    """Force downwards within some width of the middle, or at the right margin (N/m)."""
    x = found.points[:, 0]
    near = x > RATIO / 2 - width if margin else np.abs(x) <= width / 2 + 1e-9
    # Points on the border of the middle stand for half of their part of the width.
    share = np.where(np.isclose(np.abs(x), width / 2) & (not margin), 0.5, 1.0)
    return float(-(share * found.forces[:, 1])[near].sum())


def right_half(points: kit.Array, forces: kit.Array) -> float:
    """Force along on points to the right of the middle, outward (N/m)."""
    return float(forces[points[:, 0] > 1e-9, 0].sum())


def row(model: Model, found: Upper, plane: Upper) -> dict[str, object]:
    """Row of one model."""
    return {
        "model": model.name,
        "depth_over_gap": model.depth,
        "forces_by": model.forces_by,
        "permittivity_ratio": model.ratio,
        "charge_over_plane": found.charge / plane.charge,
        "squeeze_in_middle": squeeze(found, MIDDLE) / (0.5 * MIDDLE),
        "squeeze_over_plane": found.forces[:, 1].sum() / plane.forces[:, 1].sum(),
        "margin_squeeze_over_plane": squeeze(found, MARGIN, margin=True)
        / squeeze(plane, MARGIN, margin=True),
        "margin_along_over_plane": right_half(found.points, found.forces)
        / right_half(plane.points, plane.forces),
        "stretch_over_plane": found.stretch / plane.stretch,
    }


def line(model: Model, found: Upper) -> pd.DataFrame:
    """Forces along the upper electrode."""
    x = found.points[:, 0]
    part = np.gradient(x)
    part[[0, -1]] /= 2
    return pd.DataFrame(
        {
            "model": model.name,
            "depth_over_gap": model.depth,
            "forces_by": model.forces_by,
            "permittivity_ratio": model.ratio,
            "place": 2 * x / RATIO,
            "squeeze": -found.forces[:, 1] / (0.5 * part),
            "along_here": found.forces[:, 0] / 0.25,
        }
    )


def at_depth(candidate: ChargeSolver, depth: float) -> dict[str, object]:
    """Row of one depth."""
    report, flat = (
        candidate.report(electrodes(), **how).charges(VOLTAGES)
        for how in ({"depth": depth}, {"kernel": "plane"})
    )
    sides = (RATIO, depth)
    free = conductors(plate(sides, ACROSS, height=1.0), plate(sides, ACROSS))
    plane = facing_strips_capacitance(RATIO)
    return {
        "depth_over_gap": depth,
        "as_report_over_plane": float(report.totals[0] / flat.totals[0]),
        "plates_over_plane": candidate.plates(free) / depth / plane,
    }


def by_patches(candidate: ChargeSolver) -> kit.Observed:
    """Charge of the report's model, over the same plates' by patches, at the depth farthest off."""
    given = electrodes()
    found = []
    for depth in DEPTHS:
        report = candidate.report(given, depth=depth).charges(VOLTAGES)
        found.append(float(report.totals[0]) * depth / candidate.plates(rectangles(given, depth)))
    return kit.farthest_value(found, 1.0)


def rectangles(given: Electrodes, depth: float) -> Patches:
    """Segments as rectangles of some depth in space, x along the strips and z up the gap."""
    ends = given.points[given.segments]
    near, far = (
        np.dstack([ends[..., 0], np.full(ends.shape[:2], y), ends[..., 1]])
        for y in (-depth / 2, depth / 2)
    )
    middle = np.insert(given.middle, 1, 0.0, axis=1)
    return Patches(np.concatenate([near, far[:, ::-1]], axis=1), given.electrode, middle)


def finding(table: pd.DataFrame, depths: pd.DataFrame) -> str:
    """Charge, squeeze and margin in sentences."""
    report = table[table["model"] == "report's"]
    air = table[table["model"] == "in air"]
    charges, free = (
        ", ".join(f"{ratio:.2f}" for ratio in depths[column][: len(DEPTHS)])
        for column in ("as_report_over_plane", "plates_over_plane")
    )
    squeezes, pulls = (
        ", ".join(f"{ratio:.3g}" for ratio in report[column])
        for column in ("squeeze_over_plane", "margin_along_over_plane")
    )
    margins = ", ".join(f"{row.margin_along_over_plane:.2f}" for row in air.itertuples())
    stretches = ", ".join(f"{row.stretch_over_plane:.2f}" for row in air.itertuples())
    told = ", ".join(f"{depth:g}" for depth in DEPTHS)
    ratios = ", ".join(f"{ratio:g}" for ratio in RATIOS)
    return (
        f"The report's model of rectangles {told} gaps deep holds {charges} times the plane charge "
        f"per depth; plates so deep with charge free along it hold {free} times. Its point sums "
        f"squeeze {squeezes} times as hard and pull along half the electrode {pulls} times. With "
        f"air around, the force along half the upper electrode is {margins} of that without, and "
        f"all that stretches half the slab {stretches}, at permittivity ratios {ratios}."
    )
