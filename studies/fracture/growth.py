"""At which load does a crack begin to grow, and where does the energy go?

Question   Springs break at one critical stretch, set from a fracture energy: does a crack grow when
           elasticity says that so much is released?
Candidate  Two rules for the stretch: what the springs across a crack hold, and what a crack in the
           field of a stress intensity needs; `grow` in a long strip and in a plate.
Reference  Two small strips in an independent program; G = E ε² H/2(1 - nu²) of a long strip,
           whatever the crack's length; K of a plate by finite elements.
Expected   By the springs' own energy a crack grows at 2.4 (square-8) and 3.7 (triangular) times
           what was asked for. By growth in the field of K a plate and a strip are off by what
           T-stress and a finite size do.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from msvalidate import kit
from msvalidate.problem import Box, Isotropic, Problem, Region, Support, Traction
from msvalidate.problem.records import replace
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.bodies.toughness import (
    Toughness,
    crack_patch,
    critical_stretch,
    crossings,
    springs_energy,
    starts,
)
from msvalidate.springs.lattice import fill
from msvalidate.springs.statics.breaking import FractureResult

from . import intensity
from .springs import LATTICES, NU, E, Grow, filled, middles, pulled

SMALL = Path(__file__).with_name("small.csv")
STRIPS = {1: (12, 7, 5), 2: (16, 9, 6)}
"""Cells and crack of the small strips."""
KNOWN = {"square-8": (2.0576, 2.3655), "triangular": (3.748, 3.748)}
"""First break and growth over the springs' own energy, by discs of three sizes elsewhere."""
Y, Y_ERROR = intensity.KNOWN["edge", 0.3], 1e-4
"""K/(σ√πa) of an edge crack in three tenths of a plate, and how far it may be off."""
RULES = (
    kit.Rule(
        "small strips: springs that break, wrong ones", 0.5, "1", "the same in the same order",
        table="small", value="wrong",
    ),
    *(
        kit.Rule(
            f"small strips: {column}, relative", 1e-9, "1", "two programs: rounding",
            table="small", value=column,
        )
        for column in ("load", "released", "own")
    ),
    kit.Rule(
        "pushed patch: strain at the first break over the critical stretch", 1e-9, "1",
        "springs across are stretched by ν = 1/3 of the strain; none breaks that is shortened",
        table="pushed", value="strain", reference=3.0,
    ),
    kit.Rule(
        "ledger at rest: what is left of work, stored and released, over the released", 1e-10, "1",
        "each is computed on its own: rounding", table="steady", value="left",
    ),
    kit.Rule(
        "first break in the field of K, over the springs' own energy", 5e-3, "1",
        "extrapolated from discs of two radii, linear in the inverse", table="trapping",
        value="first", reference="known_first",
    ),
    kit.Rule(
        "growth in the field of K, over the springs' own energy", 5e-3, "1",
        "extrapolated from discs of two radii, linear in the inverse", table="trapping",
        value="growth", reference="known_growth",
    ),
    kit.Rule(
        "rule growth: G at growth over G_c in the field of K, at other radii", 5e-3, "1",
        "the same question", table="starts", rows={"rule": "growth", "body": "field of K"},
        value="start", reference=1.0,
    ),
    kit.Rule(
        "rule growth: G at growth over G_c, strips and plates of 12 spacings or more", 0.1, "1",
        "T-stress and a tip among few springs move it by several per cent", table="starts",
        rows={"rule": "growth", "size": (40, 41, 61, 80)}, value="start", reference=1.0,
    ),
    kit.Rule(
        "rule springs: G at growth over G_c, over the ratio of the rules", 0.1, "1",
        "a crack needs that ratio more than the springs hold", table="starts",
        rows={"rule": "springs"}, value=kit.Quotient("start", "ratio"), reference=1.0,
    ),
    kit.Rule(
        "long strip: released over crack length and G, in steady growth", 0.01, "1",
        "energy balance: what is ahead becomes what is behind", table="steady",
        value="released", reference=1.0,
    ),
    kit.Rule(
        "long strip: share that springs at the critical stretch hold, times start over their own",
        0.02, "1", "the same balance, of the springs", table="steady", value="share",
        reference=1.0,
    ),
)  # fmt: skip
FIGURES = {
    "teeth": kit.series(
        "teeth", title="One crack in a strip of square-8: load that breaks the next spring",
        x="crack", y="needed", size=(5.6, 3.4),
        labels=("spring breaks at (spacings)", "strain of the strip over that at growth (1)"),
    ),
}  # fmt: skip


def small_strips(grow: Grow) -> list[dict[str, object]]:
    """Events of two small strips beside those of an independent program."""
    rows: list[dict[str, object]] = []
    for number, known in pd.read_csv(SMALL).groupby("strip"):
        n, m, a = STRIPS[int(str(number))]
        network = pulled(filled("square-8", n, m), LATTICES["square-8"][1])
        ends = network.points[network.springs]
        at = crossings(network.points, network.springs, m / 2)
        cut = np.flatnonzero(~np.isnan(at) & (ends[:, :, 0].max(axis=1) <= a))
        found = grow(network, 0.01, crack=cut, most_breaks=len(known))
        middle = middles(network)
        for one, (_, row) in zip(found.breaks, known.iterrows(), strict=False):
            names = {f"{x:g} {y:g}" for x, y in middle[one.springs]}
            rows.append({
                "strip": number, "event": len(rows),
                "wrong": len(names ^ set(row["springs"].split("; "))),
                "load": one.load / row["load"] - 1, "released": one.released / row["released"] - 1,
                "own": one.stored_energy / row["own"] - 1,
            })  # fmt: skip
    return rows


def pushed_patch(grow: Grow) -> dict[str, float]:
    """A body that is pushed together between smooth plates."""
    network = pulled(filled("square-8", 6, 6), LATTICES["square-8"][1])
    held = network.fixed.copy()
    held[:, 0] &= network.points[:, 0] == 0
    network = replace(network, fixed=held, displacement=-network.displacement)
    found = grow(network, 0.01, most_breaks=1)
    return {"strain": found.load / 0.01, "together": len(found.broken)}


def set_stretch(name: str, rule: str) -> Toughness:
    """Critical stretch of a lattice of spacing 1 m that is to have 1 J/m²."""
    pattern, k = LATTICES[name]
    return critical_stretch(pattern, k, 1.0, rule=rule)


def in_field(name: str, stretch: float, radii: tuple[int, int] = (30, 50)) -> float:
    """Energy release rate at growth in the field of K."""
    pattern, k = LATTICES[name]
    stiffness = pattern.stiffness(k)
    needed = starts(lambda r: crack_patch(pattern, stiffness, (1.0, 0.0), E, NU, r), radii)
    return float(needed.max()) ** 2 / E * stretch**2


def in_strip(grow: Grow, name: str, stretch: float, height: int, breaks: int) -> FractureResult:
    """Growth in a long strip between clamps that do not break."""
    network = pulled(filled(name, 3 * height, height), LATTICES[name][1])
    high = np.ptp(network.points[:, 1])
    line = high / 2 if name == "square-8" else high / 2 + np.sqrt(3) / 4
    crack = np.flatnonzero(crossings(network.points, network.springs, line) < height)
    middle = middles(network)
    whole = (np.abs(middle[:, 1] - high / 2) > high / 2 - 2) | (middle[:, 0] > 2.5 * height)
    return grow(network, np.where(whole, np.inf, stretch), 1e3, crack=crack, most_breaks=breaks)


def in_plate(grow: Grow, name: str, stretch: float, width: int) -> float:
    """Energy release rate at growth of an edge crack in a plate under tension."""
    pattern, k = LATTICES[name]
    rows = round(3 * width / pattern.size[1])
    rows |= name == "square-8"  # a crack between two rows is in the middle then
    box = Box((float(width), rows * pattern.size[1]))
    problem = Problem(
        box, Isotropic(E=E, nu=NU, state="plane_stress"),
        (Support(Region((0.0, 0.0)), (0.0, 0.0)), Support(Region((1.0 * width, 0.0)), (None, 0.0))),
        (Traction(box.side("bottom"), (0.0, -1.0)), Traction(box.side("top"), (0.0, 1.0))),
    )  # fmt: skip
    network = lattice_network(problem, fill(pattern, box, (width, rows)), k)
    line = box.size[1] / 2 + (0 if name == "square-8" else np.sqrt(3) / 4)
    a = 0.3 * width
    crack = np.flatnonzero(crossings(network.points, network.springs, line) < a - 1e-9)
    found = grow(network, stretch, 1e9, crack=crack, most_breaks=12)
    return float((max(one.load for one in found.breaks) * Y) ** 2 * np.pi * a / E)


def run_small(grow: Grow) -> kit.Evidence:
    """Two small strips."""
    tables = {
        "small": pd.DataFrame(small_strips(grow)), "pushed": pd.DataFrame([pushed_patch(grow)])
    }  # fmt: skip
    return kit.Evidence(tables, tolerances=RULES[:5], columns=kit.columns(__file__))


def run_growth(grow: Grow, setting: kit.Setting, rule: str = "growth") -> kit.Evidence:
    """Growth by rule, lattice and body; `rule` is what is called "growth"."""
    trapping: list[dict[str, Any]] = []
    starting, steady, teeth, plates = [], [], [], []
    size = 41 if setting.quick else 61
    for name, (first, growth) in KNOWN.items():
        found = set_stretch(name, "growth")
        trapping.append({
            "lattice": name, "first": found.first, "growth": found.ratio, "known_first": first,
            "known_growth": growth, "own_share": 1 / found.ratio,
        })  # fmt: skip
        row = {"lattice": name, "rule": "growth", "ratio": found.ratio}
        stretch = set_stretch(name, rule).critical_stretch
        strip = in_strip(grow, name, stretch, size, 40)
        starting += [
            {**row, "body": "field of K", "size": 50, "start": in_field(name, stretch)},
            {**row, "body": "strip", "size": size, "start": strip_release(name, strip)},
        ]
        steady.append(balance(name, size, strip, stretch))
        teeth += saw_teeth(strip) if name == "square-8" else []
        for width in (20, 40) if setting.quick else (20, 40, 80):
            G = in_plate(grow, name, stretch, width)
            plates.append({**row, "cells": 0.3 * width, "strength": float(np.sqrt(G)),
                           "reference": Y_ERROR})  # fmt: skip
            starting.append({**row, "body": "plate", "size": width, "start": G})
        row["rule"] = "springs"
        stretch = set_stretch(name, "springs").critical_stretch
        other = in_strip(grow, name, stretch, size, 4)
        G = in_plate(grow, name, stretch, 40)
        starting += [
            {**row, "body": "strip", "size": size, "start": strip_release(name, other)},
            {**row, "body": "plate", "size": 40, "start": G},
        ]
    tables = {
        "trapping": pd.DataFrame(trapping), "starts": pd.DataFrame(starting),
        "steady": pd.DataFrame(steady), "griffith": pd.DataFrame(plates),
        "teeth": pd.DataFrame(teeth),
    }  # fmt: skip
    by = tables["starts"].query("rule == 'growth' and body != 'field of K'")
    finding = (
        "A critical stretch from the energy of the broken springs makes a crack grow at "
        f"{trapping[0]['growth']:.2f} (square-8, along an axis) and {trapping[1]['growth']:.2f} "
        "times (triangular, along a row) the fracture energy that was asked for: only "
        f"{100 * trapping[1]['own_share']:.0f} to {100 * trapping[0]['own_share']:.0f} % of what "
        "is released was in the springs that broke. Set from growth, strips and plates are at "
        f"{by['start'].min():.2f} to {by['start'].max():.2f} of it: T-stress and size."
    )
    return kit.Evidence(
        tables, tolerances=RULES[5:], columns=kit.columns(__file__), findings=(finding,),
        figures=FIGURES,
    )  # fmt: skip


def strip_release(name: str, strip: FractureResult) -> float:
    """G = E ε² H/2(1 - nu²) at the largest load of a strip."""
    high = np.ptp(strip.network.points[:, 1])
    return float(E / (1 - NU**2) * max(one.load for one in strip.breaks) ** 2 * high / 2)


def balance(name: str, height: int, strip: FractureResult, stretch: float) -> dict[str, object]:
    """What is released per crack length in steady growth, over G, and the springs' share.

    The share is of the springs that broke, each at the critical stretch.
    """
    pattern, k = LATTICES[name]
    across = springs_energy(pattern, pattern.stiffness(k), (1.0, 0.0)) * stretch**2
    whole = pulled(filled(name, 3 * height, height), k)
    holds = whole.stiffness * (whole.rest_length * stretch) ** 2 / 2
    G, breaks = strip_release(name, strip), strip.breaks[10:30]
    middle = middles(strip.network)
    length = middle[strip.breaks[30].springs, 0].max() - middle[breaks[0].springs, 0].max()
    released = sum(one.released for one in breaks)
    own = sum(holds[one.springs].sum() for one in breaks)
    return {
        "lattice": name, "released": released / length / G,
        "share": own / released * G / across,
        "held": sum(one.stored_energy for one in breaks) / released, "left": strip.closure,
    }  # fmt: skip


def saw_teeth(strip: FractureResult) -> list[dict[str, float]]:
    """Strain at which each spring would break, over that at growth."""
    middle, top = middles(strip.network), max(one.load for one in strip.breaks)
    return [
        {"crack": float(middle[one.springs, 0].mean()), "needed": one.needed / top}
        for one in strip.breaks
    ]
