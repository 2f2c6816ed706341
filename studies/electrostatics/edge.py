"""Edge: does charge gather at the edge of an electrode as theory says?

Question   How much charge lies within some distance of the edge of a strip that is alone?
Candidate  Charges by the method of moments of a strip in the middle of a circle a hundred times as
           wide. In the plane a strip quite alone holds no charge, and the circle, by symmetry,
           changes how it is shared by (half width/radius)⁴, 1e-8.
Reference  Density Q/(π√(a² - x²)): within s of the edge lies the part arccos(1 - s/a)/π of all.
Expected   Charge within s of the edge grows like √s: a density with the exponent -1/2. What one
           segment at the edge holds is wrong by a part that does not fall with more segments, so
           the peak says nothing: the total near the edge does. Where an electrode ends at the
           corner of a slab in air, fields in the slab's right angle and in the air's three must
           fit: the potential goes as r^λ, tan²(λπ/2) = (1+3ε_r)/(3+ε_r), free charge as r^(λ-1).
"""

from __future__ import annotations

from functools import partial
from itertools import product
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from scipy.optimize import minimize_scalar

from msvalidate import kit
from msvalidate.dielectric.charges import Electrodes, facing_strips, strip_points
from msvalidate.dielectric.charges.faces import slab_faces
from msvalidate.dielectric.charges.moments import WEIGHTINGS

from .common import VOLTAGES, ChargeSolver

RADIUS = 100.0
"""Of the circle over half the strip's width."""
CORNERS = 64
"""Of the polygon in the circle's place; its harmonics die out like (1/RADIUS)**CORNERS inside."""
SEGMENTS = (40, 80, 160, 320)
QUICK_SEGMENTS = (40, 80, 160)
NEAR = 0.1
"""Over half the width: how far from the edge the exponent is fitted."""
SKIPPED = 2
"""Segments at the edge that are left out of the fit, the peak among them."""
RATIOS = (1.0, 6.0, 10.0)
PERMITTIVITY_RATIOS = (1.0, 3.0, 10.0)
SLAB, BOTTOM = 2.0, 200
"""Length over height of a slab in air, and segments of its bottom."""
CORNER, LEFT_OUT = 0.4, 4
"""How far from its corner the exponent is fitted, over the height, and segments left out there."""
DRAWN = 80
"""Segments of the strips whose densities are drawn."""
RULES = (
    kit.Rule(
        "exponent of the free charge at the corner of a slab in air", 0.02, "1",
        "segments there err by a part in a hundred, and the three powers 0.63, 1 and 1.37 that are "
        "told apart at a ratio of 10 are close; the error falls with more segments",
        table="corner", value="exponent", reference="exponent_expected",
    ),
)  # fmt: skip


def run(candidate: ChargeSolver, setting: kit.Setting) -> kit.Evidence:
    """Charge near the edge for several numbers of segments."""
    numbers = QUICK_SEGMENTS if setting.quick else SEGMENTS
    cases = list(product(WEIGHTINGS, numbers))
    lines = setting.sweep(partial(alone, candidate), cases, "strip alone")
    table = pd.DataFrame([summary(line) for line in lines])
    along = pd.concat([density(candidate, ratio) for ratio in RATIOS], ignore_index=True)
    finest = table[(table["segments"] == max(numbers)) & (table["weighting"] == "galerkin")]
    corners = pd.DataFrame([at_corner(candidate, ratio) for ratio in PERMITTIVITY_RATIOS])
    own = (
        kit.Tolerance(
            "exponent of the density at the edge, from the charge near it", 5e-3, "1",
            "the root's next term bends the slope by s/(12a), 0.008 at the far end of the fit and "
            "some 0.002 in its middle; the charge of single segments weighs no more",
            observed=kit.farthest_value(finest["exponent"], -0.5),
        ),
        kit.Tolerance(
            "charge within a tenth of half the width from the edge, over that of theory", 5e-4, "1",
            "what the last segment errs by, 0.04 of its own charge, its neighbours make good: the "
            "charge of k of them errs by 0.04/k² or so, and with 160 segments k is 20 or more",
            observed=kit.farthest_value(finest["charge_near_edge"], 1.0),
        ),
    )  # fmt: skip
    return kit.Evidence(
        tables={"edge": table, "corner": corners},
        tolerances=(*RULES, *own),
        drawn={"edge_charge": lines[-1], "density": along},
        figures={"density": draw},
        columns=kit.columns(__file__),
        findings=(finding(table, corners),),
    )


def alone(candidate: ChargeSolver, case: tuple[str, int]) -> pd.DataFrame:
    """Charge of a strip alone from its edge to its middle."""
    weighting, segments = case
    line = strip_points(2.0, 0.0, segments)
    found = candidate.charges(in_a_circle(line), weighting=weighting)
    half = segments // 2
    charge = found.charge[:half]
    distance = 1 + line[1 : half + 1, 0]
    total = found.totals[0]
    return pd.DataFrame(
        {
            "weighting": weighting,
            "segments": segments,
            "distance": distance,
            "share": np.cumsum(charge) / total,
            "share_exact": np.arccos(1 - distance) / np.pi,
            "density_over_mean": charge / np.diff(line[: half + 1, 0]) / (total / 2),
        }
    )


def in_a_circle(line: kit.Array) -> Electrodes:
    """A chain of points as electrode 0, in the middle of a polygon that is nearly a circle."""
    angle = 2 * np.pi * np.arange(CORNERS) / CORNERS
    circle = RADIUS * np.column_stack([np.cos(angle), np.sin(angle)])
    along, around = np.arange(len(line) - 1), len(line) + np.arange(CORNERS)
    return Electrodes(
        np.concatenate([line, circle]),
        np.concatenate(
            [np.column_stack([along, along + 1]), np.column_stack([around, np.roll(around, -1)])]
        ),
        np.repeat([0, 1], [len(along), CORNERS]),
    )


def summary(line: pd.DataFrame) -> dict[str, object]:
    """Row of one number of segments."""
    distance, share = line["distance"].to_numpy(), line["share"].to_numpy()
    near = np.flatnonzero(distance <= NEAR)
    power = kit.fitted_power(distance[near[SKIPPED:]], share[near[SKIPPED:]])
    within = np.interp(np.sqrt(NEAR), np.sqrt(distance), share)
    return {
        "weighting": line["weighting"].iloc[0],
        "segments": line["segments"].iloc[0],
        "exponent": power.exponent - 1,
        "charge_near_edge": float(within) * np.pi / np.arccos(1 - NEAR),
        "tip_over_exact": float(share[0] / line["share_exact"].iloc[0]),
    }


def at_corner(candidate: ChargeSolver, ratio: float) -> dict[str, object]:
    """Row of a slab in air whose top is covered in full."""
    faces = slab_faces(SLAB, 1.0, BOTTOM)
    free = candidate.in_air(faces, ratio=ratio).charges(VOLTAGES).free
    top = np.flatnonzero(faces.electrode == 0)
    top = top[np.argsort(-faces.middle[top, 0], kind="stable")]  # from the right corner inwards
    ends = np.concatenate([[0.0], np.cumsum(faces.length[top])])
    near = np.arange(LEFT_OUT, int(np.searchsorted(ends, CORNER)) - 1)
    wedge = 2 / np.pi * np.arctan(np.sqrt((1 + 3 * ratio) / (3 + ratio)))
    return {
        "permittivity_ratio": ratio,
        "exponent": fitted_exponent(ends[near], ends[near + 1], free[top][near]) - 1,
        "exponent_expected": float(wedge) - 1,
    }


def fitted_exponent(start: kit.Array, end: kit.Array, charge: kit.Array) -> float:
    """The power λ with which charges between two distances fit sums of s^λ, s and s^(2-λ) best.

    These are the powers of a corner's potentials below 2: an even field has the power 1.
    """

    def misfit(power: float) -> float:
        terms = np.stack([end**p - start**p for p in (power, 1.0, 2 - power)], axis=1)
        terms /= charge[:, None]
        best = np.linalg.lstsq(terms, np.ones(len(charge)), rcond=None)[0]
        return float(((terms @ best - 1) ** 2).sum())

    return float(minimize_scalar(misfit, bounds=(0.3, 0.9), method="bounded").x)


def density(candidate: ChargeSolver, ratio: float) -> pd.DataFrame:
    """Density along the upper of two facing strips."""
    electrodes = facing_strips(ratio, 1.0, DRAWN)
    found = candidate.charges(electrodes)
    upper = electrodes.electrode == 0
    return pd.DataFrame(
        {
            "width_over_gap": ratio,
            "place": 2 * electrodes.middle[upper, 0] / ratio,
            "density": found.density[upper],
        }
    )


def finding(table: pd.DataFrame, corners: pd.DataFrame) -> str:
    """Exponents and peak, in sentences."""
    said = ", ".join(
        f"{row.exponent:.3f} (theory {row.exponent_expected:.3f})" for row in corners.itertuples()
    )
    ratios = ", ".join(f"{ratio:g}" for ratio in PERMITTIVITY_RATIOS)
    last = table[table["weighting"] == "galerkin"].iloc[-1]
    tips = table[table["weighting"] == "galerkin"]["tip_over_exact"]
    return (
        f"Near the edge of a strip alone the charge gives the density an exponent of "
        f"{last['exponent']:.4f}, and the outer tenth of a half holds "
        f"{last['charge_near_edge']:.5f} times what it should; the last segment alone holds "
        f"{tips.min():.4f} ... {tips.max():.4f} times its part however many there are. At the "
        f"corner of a slab in air the exponent is {said} at permittivity ratios {ratios}."
    )


def draw(tables: kit.Tables) -> Figure:
    """Density along facing strips, and near an edge."""
    along, near = tables["density"], tables["edge_charge"]
    figure, (across, edge) = kit.figures.new_figure(2, size=(3.5, 3.8))
    for place, (ratio, line) in enumerate(along.groupby("width_over_gap", sort=False)):
        colour, label = kit.figures.COLOURS[place], f"facing strips, w/d = {ratio:g}"
        across.plot(line["place"], line["density"], color=colour, label=label)
        half = line[line["place"] < 0]
        gaps = (1 + half["place"]) * float(str(ratio)) / 2
        edge.loglog(gaps, half["density"], color=colour, label=label)
    across.axhline(1.0, color="grey", ls=":", lw=1)
    across.text(0, 0.93, "plates without end", ha="center", va="top", fontsize=8, color="grey")
    across.set(xlabel="place over half the width (1)", ylim=(0, 6))
    across.set_ylabel("charge per area over εV/d (1)")
    middle = near["distance"] - np.diff(near["distance"], prepend=0.0) / 2
    alone: dict[str, Any] = {"mfc": "none", "ms": 3.5, "label": "strip alone, over its mean"}
    edge.loglog(middle, near["density_over_mean"], "o", color="black", **alone)
    s = np.geomspace(middle.min(), 1.0, 60)
    exact = 2 / np.pi / np.sqrt(1 - (1 - s) ** 2)
    edge.loglog(s, exact, color="black", lw=0.8, label="1/(π√(a² - x²))")
    ends = np.array([middle.min(), 0.05])
    edge.loglog(ends, 0.8 * np.sqrt(0.1 / ends), ":", color="grey", label="exponent -1/2")
    edge.set(xlabel="distance from the edge\nover gap, or half width a (1)", ylabel="density (1)")
    figure.suptitle("Charge on facing strips and on a strip alone")
    kit.figures.add_shared_legend(figure, [across, edge], columns=2)
    return figure
