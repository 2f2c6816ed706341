"""Virtual work: are forces on points the derivatives of the energy in their positions?

Question   Forces, net force, net moment and tangent of flat and of wavy electrodes.
Candidate  `forces` and `tangent` of Galerkin's charges; forces of collocation's charges.
Reference  Central differences of the energy W = ½ΣQV at fixed voltages, F = +∂W/∂x, point by point,
           edges included, in a medium of permittivity 3. For two flat strips the derivatives of the
           closed form as well: dW/dd is the pull between them, dW/dw what stretches them. And
           forces on the surface of a slab in air.
Expected   Galerkin's charges make W stationary, so forces are its derivatives, and as W does not
           change when all moves together, forces and moments add up to nothing, and as it does not
           when all grows together, pull times gap is stretch. Collocation's charges leave W
           sloping: its forces are no derivative. At an edge, which looks the same at each
           fineness, they stay wrong by a part; their sums err with order 2 as its charges do.
"""

from __future__ import annotations

from functools import partial
from itertools import product

import numpy as np
import pandas as pd

from msvalidate import kit
from msvalidate.dielectric.charges import Charges, facing_strips
from msvalidate.dielectric.charges.dielectric import ChargesInAir
from msvalidate.dielectric.charges.faces import slab_faces
from msvalidate.dielectric.charges.moments import WEIGHTINGS

from .common import VOLTAGES, ChargeSolver, pair
from .derivatives import differences, growth, steps_of
from .virtual_work_drawing import draw

SHAPES = ("flat", "wavy")
WIDTH = 4.0
"""Of the electrodes, over the gap."""
PERMITTIVITY = 3.0
PERMITTIVITY_RATIOS, QUICK_PERMITTIVITY_RATIOS = (1.0, 3.0, 10.0), (3.0,)
SLAB, BOTTOM = 2.0, 6
"""Length over height of a slab in air, and segments of its bottom."""
SEGMENTS = (12, 24, 48)
QUICK_SEGMENTS = (6, 12)
RATIO = 6.0
FINE = (20, 40, 80, 160, 320)
QUICK_FINE = (20, 40, 80, 160)
galerkin = partial(kit.Rule, table="virtual_work", rows={"weighting": "galerkin"})
flat = partial(galerkin, unit="1", table="flat_strips", last=1)
tangent = partial(kit.Rule, unit="of its largest component", table="tangents")
RULES = (
    galerkin(
        "Galerkin's forces, farthest from differences of the energy", 1e-7, "of the largest force",
        "differences of fourth order with steps of a hundredth of a segment: 1e-8 times the bend "
        "of the energy of neighbours, of order 1 to 10", value="force_error",
    ),
    galerkin(
        "Galerkin's forces on the edges, farthest from differences of the energy",
        1e-7, "of that force", "as of all forces: those on edges are the largest",
        value="edge_force_error",
    ),
    galerkin(
        "net force of Galerkin's forces", 1e-12, "of the sum of their sizes",
        "pairs cancel as numbers; some hundred roundings of 1e-16", value="net_force",
    ),
    galerkin(
        "net moment of Galerkin's forces", 1e-12, "of the sum of their sizes times the width",
        "exact integrals; some thousand roundings of 1e-16", value="net_moment",
    ),
    tangent(
        "asymmetry of the tangent", 1e-10, value="asymmetry",
        because="a second derivative; rounding times the condition of the equations",
    ),
    tangent(
        "tangent, farthest from differences of the forces", 1e-6, value="tangent_error",
        because="differences of fourth order, as of the energy",
    ),
    flat(
        "pull between flat strips, finest, over dW/dd of the closed form", 1e-4, value="pull_error",
        because="falls with order 2 like the capacitance, from 1e-3 or so at 40 segments",
    ),
    flat(
        "stretch of flat strips, finest, over dW/dw of the closed form", 1e-4,
        value="stretch_error", because="as of the pull, which it equals",
    ),
    galerkin(
        "order of pull and stretch", 0.1, "1",
        "as of the capacitance: derivatives of an error that goes like 1/n² do so too",
        table="flat_orders", reference=2.0,
        value=lambda rows: rows[["pull_order", "stretch_order"]].to_numpy().ravel(),
    ),
    kit.Rule(
        "forces on a wavy slab in air, farthest from differences of the energy",
        1e-6, "of the largest force",
        "differences of fourth order with steps of a hundredth of a segment, whose next term grows "
        "with the cube of the field at edges and corners",
        table="slab_in_air", value="outline_error",
    ),
)  # fmt: skip


ROUNDING = {
    **dict.fromkeys(("force_error", "edge_force_error", "outline_error", "tangent_error"), 1e-8),
    **dict.fromkeys(("net_force", "net_moment"), 1e-13),
    **dict.fromkeys(("pull_error", "stretch_error"), 1e-9),
    **dict.fromkeys(("pull_order", "stretch_order"), 1e-4),
    "asymmetry": 1e-12,
}


def run(candidate: ChargeSolver, setting: kit.Setting) -> kit.Evidence:
    """Hold forces to the energy, and to closed forms."""
    numbers = QUICK_SEGMENTS if setting.quick else SEGMENTS
    cases = list(product(SHAPES, WEIGHTINGS, numbers))
    table = pd.DataFrame(
        setting.sweep(partial(compare_with_energy, candidate), cases, "virtual work")
    )
    bends = pd.DataFrame([compare_with_forces(candidate, shape, numbers[-1]) for shape in SHAPES])
    fine = list(product(WEIGHTINGS, QUICK_FINE if setting.quick else FINE))
    flat = pd.DataFrame(setting.sweep(partial(compare_with_form, candidate), fine, "flat strips"))
    orders = pd.DataFrame([fit_orders(str(w), rows) for w, rows in flat.groupby("weighting")])
    ratios = QUICK_PERMITTIVITY_RATIOS if setting.quick else PERMITTIVITY_RATIOS
    slabs = pd.DataFrame([wavy_electrodes(candidate, ratio) for ratio in ratios])
    return kit.Evidence(
        tables={
            "virtual_work": table,
            "tangents": bends,
            "flat_strips": flat,
            "flat_orders": orders,
            "slab_in_air": slabs,
        },
        tolerances=RULES,
        figures={"virtual_work": draw},
        columns=kit.columns(__file__),
        findings=(finding(table, flat),),
    )


def compare_with_energy(candidate: ChargeSolver, case: tuple[str, str, int]) -> dict[str, object]:
    """Row of one pair of electrodes."""
    shape, weighting, segments = case
    electrodes = pair(shape, WIDTH, segments)

    def solved(x: kit.Array) -> Charges:
        moved = electrodes.moved(x.reshape(-1, 2))
        return candidate.charges(moved, permittivity=PERMITTIVITY, weighting=weighting)

    x = electrodes.points.ravel()
    force = candidate.forces(solved(x))
    energy = differences(lambda at: np.array(solved(at).energy), x, steps_of(electrodes.points))
    wrong = np.hypot(*(force - energy.reshape(-1, 2)).T)
    size = np.hypot(*energy.reshape(-1, 2).T)
    edges = [0, segments, segments + 1, 2 * segments + 1]
    moment = electrodes.points[:, 0] @ force[:, 1] - electrodes.points[:, 1] @ force[:, 0]
    return {
        "shape": shape,
        "weighting": weighting,
        "segments": segments,
        "points": len(size),
        "force_error": float(wrong.max() / size.max()),
        "edge_force_error": float((wrong[edges] / size[edges]).max()),
        "net_force": float(np.hypot(*force.sum(axis=0)) / np.hypot(*force.T).sum()),
        "net_moment": float(abs(moment) / (np.hypot(*force.T).sum() * WIDTH)),
    }


def compare_with_forces(candidate: ChargeSolver, shape: str, segments: int) -> dict[str, object]:
    """Row of one tangent."""
    electrodes = pair(shape, WIDTH, segments)

    def forces(x: kit.Array) -> kit.Array:
        moved = electrodes.moved(x.reshape(-1, 2))
        found = candidate.charges(moved, permittivity=PERMITTIVITY)
        return candidate.forces(found).ravel()

    exact = differences(forces, electrodes.points.ravel(), steps_of(electrodes.points))
    tangent = candidate.tangent(candidate.charges(electrodes, permittivity=PERMITTIVITY))
    size = np.abs(exact).max()
    return {
        "shape": shape,
        "segments": segments,
        "tangent_error": float(np.abs(tangent - exact).max() / size),
        "asymmetry": float(np.abs(tangent - tangent.T).max() / size),
    }


def wavy_electrodes(candidate: ChargeSolver, ratio: float) -> dict[str, object]:
    """Row of a slab in air, partly covered, whose surface is not straight."""
    flat = slab_faces(SLAB, 1.0, BOTTOM, covered=0.5)
    x, y = flat.points.T
    wavy = flat.moved(flat.points + 0.05 * np.column_stack([np.sin(5 * y), np.cos(4 * x + 1)]))

    def solved(points: kit.Array) -> ChargesInAir:
        moved = wavy.moved(points.reshape(-1, 2))
        return candidate.in_air(moved, ratio=ratio, permittivity=PERMITTIVITY).charges(VOLTAGES)

    points = wavy.points
    ring = np.concatenate([points[-1:], points, points[:1]])
    steps = steps_of(ring)[2:-2]
    exact = differences(lambda at: np.array(solved(at).energy), points.ravel(), steps)
    force = candidate.forces_in_air(solved(points)).ravel()
    return {
        "permittivity_ratio": ratio,
        "points": len(points),
        "outline_error": float(np.abs(force - exact).max() / np.abs(exact).max()),
    }


def compare_with_form(candidate: ChargeSolver, case: tuple[str, int]) -> dict[str, object]:
    """Row of two flat strips."""
    weighting, segments = case
    electrodes = facing_strips(RATIO, 1.0, segments)
    found = candidate.charges(electrodes, permittivity=PERMITTIVITY, weighting=weighting)
    force = candidate.forces(found)
    slope = growth(RATIO)
    half = 0.5 * PERMITTIVITY * (VOLTAGES[0] - VOLTAGES[1]) ** 2
    # W = ½εV²C(w/d): dW/dd = -½εV²·C'·w/d², dW/dw = ½εV²·C'/d, with d = 1 here.
    pull = force[: segments + 1, 1].sum() / (-half * slope * RATIO)
    stretch = (electrodes.points[:, 0] @ force[:, 0]) / (half * slope * RATIO)
    return {
        "weighting": weighting,
        "segments": segments,
        "pull_error": float(pull) - 1,
        "stretch_error": float(stretch) - 1,
    }


def fit_orders(weighting: str, rows: pd.DataFrame) -> dict[str, object]:
    """Row of orders."""
    parts = 1 / rows["segments"]
    return {
        "weighting": weighting,
        "pull_order": kit.observed_order(parts, rows["pull_error"]),
        "stretch_order": kit.observed_order(parts, rows["stretch_error"]),
    }


def finding(table: pd.DataFrame, flat: pd.DataFrame) -> str:
    """Galerkin's and collocation's errors, in a sentence."""
    said = []
    for weighting in WEIGHTINGS:
        rows = table[table["weighting"] == weighting]
        last = rows[rows["segments"] == rows["segments"].max()]
        said.append(
            f"{weighting}'s {last['force_error'].max():.1e} of the largest "
            f"({last['edge_force_error'].max():.1e} at the edges), net force "
            f"{last['net_force'].max():.1e} of the sum"
        )
    last = flat[flat["weighting"] == "collocation"].iloc[-1]
    return (
        f"Forces against differences of the energy with {table['segments'].max()} segments: "
        + "; ".join(said)
        + f". Collocation's pull of flat strips with {last['segments']} segments is wrong by "
        f"{last['pull_error']:.1e}, its stretch by {last['stretch_error']:.1e}."
    )
