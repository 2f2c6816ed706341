"""Stress intensity of cracks that do not grow: where is a lattice's tip?

Question   K = √(E G) of an edge crack, a centre crack and a notched beam, by cells in the crack.
Candidate  Half of the body as a lattice, held on its line of symmetry from one point on; G from
           stored energies of cracks that end at other points.
Reference  Elements on the same plate or beam, by energies and by the J integral; values of an
           independent program.
Expected   A lattice has K of a crack that ends somewhere before its first held point: at one and
           the same part of a spacing in each body. At the point itself K is low, to first order.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

from msvalidate import kit
from msvalidate.problem import Box, Isotropic, Problem, Region, Support, Traction
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.lattice import fill
from msvalidate.springs.statics.equilibrium import equilibrium
from reference_fem.body import solve_problem
from reference_fem.fracture import crack_mesh, j_integral, release_rate

from .springs import LATTICES, NU, E

MATERIAL = Isotropic(E=E, nu=NU, state="plane_stress")
KNOWN = {
    ("edge", 0.3): 1.659872697580806, ("edge", 0.4): 2.111418451116136,
    ("centre", 0.3): 1.0659692949370656, ("centre", 0.4): 1.1219703962330294,
    ("notch", 0.3): 1.5126236600893834, ("notch", 0.5): 2.641000654501948,
}  # fmt: skip
"""K/(σ√πa) of plates 1.5 times as high as wide either side of the crack, K W^1.5/(P S) of a beam
with spread forces: spectral elements elsewhere, to 1e-4."""
INFINITE = KNOWN | {("centre", a): np.cos(np.pi * a / 2) ** -0.5 for a in (0.3, 0.4)}
"""The handbook's plates of infinite height in their place."""
PLATES = (("edge", 0.3), ("centre", 0.3), ("notch", 0.5), ("edge", 0.4), ("centre", 0.4),
          ("notch", 0.3))  # fmt: skip
STEP = 0.02
"""Of the plate's width, between cracks whose energies are compared."""
DIFFERENCES = ((2 / 3, -1 / 12), (3 / 4, -3 / 20, 1 / 60))
"""Weights of central differences of fourth and sixth order."""
FEW = 20
"""Cells in a crack below which the latter are taken: one over these to the fourth would be seen."""
RULES = (
    kit.Rule(
        "elements: K by energies beside an independent program, relative", 1e-3, "1",
        "two meshes graded to the tip", table="plates", value=kit.Quotient("energies", "known"),
        reference=1.0,
    ),
    kit.Rule(
        "elements: K by the J integral beside that by energies", 1e-3, "1",
        "two routes from the same elements", table="plates",
        value=kit.Quotient("integral", "energies"), reference=1.0,
    ),
    kit.Rule(
        "order of K in the spacing with the tip at the first held point", 0.15, "1",
        "a tip that is a part of a spacing elsewhere", table="tips", value="at_point",
        power_of=kit.Quotient(1, "cells"), reference=1.0, by=("lattice", "body", "length"), last=2,
    ),
    kit.Rule(
        "plates: K with the tip where the longest edge crack has it, from 6 cells on", 5e-4, "1",
        "what remains is of second order", table="tips", rows={"body": ("edge", "centre")},
        value="placed",
    ),
    kit.Rule(
        "plates: the tip's place from the longest edge crack's, in spacings", 5e-3, "1",
        "a lattice's own, whatever the body", table="tips", rows={"body": ("edge", "centre")},
        value=kit.Difference("tip", "place"),
    ),
)  # fmt: skip
NOTCH = kit.Rule(
    "notched beam: K with the tip where the edge crack has it, times (cells/20)²", 2e-3, "1",
    "forces on a cell or two: of second order in the spacing", table="tips",
    rows={"body": "notch"}, value=lambda t: t["placed"] * (t["cells"] / 20) ** 2,
)  # fmt: skip
FIGURES = {
    "tips": kit.series(
        "tips", title="K of cracks: tip at the first held point, or where the edge crack has it",
        x="cells", y={"at_point": "held point", "placed": "edge crack's"}, panel="lattice",
        by="body", rows={"length": 0.3}, log="xy", size=(3.6, 3.2), ylim=(1e-6, 0.2),
        labels=("cells in the crack", "error of K, relative (1)"),
    ),
}  # fmt: skip


def half(body: str, height: float, a: float) -> Problem:
    """Half of a plate or beam with a crack of length a (m), of width 1 m."""
    if body == "notch":
        return Problem(
            Box((2.25, 1.0)), MATERIAL,
            (Support(Region((0.0, (a, 1.0))), (0.0, None)),
             Support(Region((0.0, 1.0)), (None, 0.0))),
            (Traction(Region(((0.0, 0.05), 1.0)), (0.0, -10.0)),
             Traction(Region(((1.95, 2.05), 0.0)), (0.0, 5.0))),
        )  # fmt: skip
    across = Region((0.0, None)) if body == "centre" else Region((1.0, 0.0))
    return Problem(
        Box((1.0, height)), MATERIAL,
        (Support(Region(((a, 1.0), 0.0)), (None, 0.0)), Support(across, (0.0, None))),
        (Traction(Region((None, height)), (0.0, 1.0)),),
    )  # fmt: skip


def tip(body: str, a: float) -> tuple[float, float]:
    """Where (m) the crack ends."""
    return (0.0, a) if body == "notch" else (a, 0.0)


def scale(body: str, a: float) -> float:
    """K over its dimensionless factor."""
    return 4.0 if body == "notch" else float(np.sqrt(np.pi * a))


def elements(finer: int, case: tuple[str, float, float]) -> dict[str, Any]:
    """G by elements, and its logarithm as a polynomial (3,) of that of the length about there."""
    body, a, height = case
    at, place = partial(half, body, height), partial(tip, body)
    along = np.array(place(1.0)) - place(0.0)
    lengths, rates = a + np.array([-0.04, 0.0, 0.04]), []
    for length in lengths:
        problem = at(length)
        solution = solve_problem(problem, crack_mesh(problem, place(length), finer))
        rates.append(j_integral(solution, problem, np.array(place(length)), along))
    return {
        "body": body, "length": a, "height": height, "rate": rates[1],
        "law": np.polyfit(np.log(lengths / a), np.log(np.array(rates) / rates[1]), 2),
    }  # fmt: skip


def plate(known: Mapping[tuple[str, float], float], case: tuple[str, float]) -> dict[str, object]:
    """K of a plate or beam by elements, over its dimensional part, by two routes."""
    body, a = case
    found = release_rate(partial(half, body, 1.5), partial(tip, body), a, STEP)
    energies, integral = np.sqrt(2 * E * np.array([found.value, found.integral])) / scale(body, a)
    return {
        "body": body, "length": a, "energies": energies, "integral": integral,
        "known": known[case], "reference": found.uncertainty / found.value / 2,
    }  # fmt: skip


def lattice_rate(name: str, body: str, height: float, a: float, cells: int) -> float:
    """Energy release rate of half a lattice by differences over points."""
    pattern, k = LATTICES[name]
    n = round(cells / a)

    def stored(end: int) -> float:
        problem = half(body, height, end / n)
        box = Box(tuple(high for _, high in problem.domain.span))
        size = np.array(box.size) * n / pattern.size
        lattice = fill(pattern, box, tuple(np.round(size).astype(int).tolist()))
        network = lattice_network(problem, lattice, k)
        return float((network.force * equilibrium(network).displacement).sum()) / 2

    weights = DIFFERENCES[cells < FEW]
    return n * sum(
        weight * (stored(cells + step) - stored(cells - step))
        for step, weight in enumerate(weights, 1)
    )


def tip_place(rate: float, known: dict[str, Any], cells: int) -> float:
    """How far (spacings) before its first held point a crack of this rate ends."""
    law = known["law"]
    want, x = np.log(rate / known["rate"]), 0.0
    for _ in range(20):
        x -= (np.polyval(law, x) - want) / np.polyval(np.polyder(law), x)
    return float(cells * (1 - np.exp(x)))


def K_error(rate: float, known: dict[str, Any], cells: int, before: float) -> float:
    """Relative error of K with the tip so far (spacings) before the first held point."""
    expected = np.polyval(known["law"], np.log(1 - before / cells))
    return float(np.sqrt(rate / known["rate"] / np.exp(expected)) - 1)


def run_plates(
    setting: kit.Setting, known: Mapping[tuple[str, float], float] = KNOWN
) -> kit.Evidence:
    """K of plates and beams by elements."""
    plates = PLATES[:2] if setting.quick else PLATES
    tables = {"plates": pd.DataFrame(setting.sweep(partial(plate, known), plates, "plates"))}
    return kit.Evidence(tables, tolerances=RULES[:2], columns=kit.columns(__file__))


def run_tips(setting: kit.Setting, moved: float = 0.0) -> kit.Evidence:
    """K of lattices; `moved` (spacings) is a fault of the tip's place."""
    plates = PLATES[:2] if setting.quick else PLATES
    high = 0.85 * np.sqrt(3)
    bodies = [*((*each, 1.5) for each in plates), ("edge", 0.3, high)]
    ready = partial(elements, 2 if setting.quick else 3)
    found = setting.sweep(ready, bodies, "elements")
    times = (1, 2, 4) if setting.quick else (1, 2, 4, 8)
    rows: list[dict[str, object]] = []
    place: dict[str, float] = {}
    for (body, a, height), each in zip(bodies, found, strict=True):
        name = "triangular" if height == high else "square-8"
        cells = [n * round(20 * a) for n in times]
        rates = [lattice_rate(name, body, height, a, n) for n in cells]
        place.setdefault(name, tip_place(rates[-1], each, cells[-1]))
        at = place[name] + moved
        rows += [
            {
                "lattice": name, "body": body, "length": a, "cells": n,
                "at_point": K_error(rate, each, n, 0.0), "placed": K_error(rate, each, n, at),
                "tip": tip_place(rate, each, n), "place": at,
            }
            for n, rate in zip(cells, rates, strict=True)
        ]  # fmt: skip
    tips = pd.DataFrame(rows)
    square, other = place["square-8"], place["triangular"]
    worst = tips.query("cells == 6")["at_point"].min()
    finding = (
        f"A crack in a lattice ends {square:.3f} (square-8) and {other:.3f} (triangular) spacings "
        "before its first held point in each plate: with that K is right from 6 cells on; with "
        f"the tip at the point it is up to {-100 * worst:.1f} % low there."
    )
    rules = RULES[2:] if setting.quick else (*RULES[2:], NOTCH)
    return kit.Evidence(
        {"tips": tips}, tolerances=rules, columns=kit.columns(__file__), findings=(finding,),
        figures=FIGURES,
    )  # fmt: skip
