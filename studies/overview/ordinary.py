"""Ordinary parts: what does `case run` say of a plate with two holes and of a bracket in space?

Question   A plate of 120 mm by 40 mm with two holes, held at a straight side or at a hole, and a
           bracket in space: how far are springs from elasticity at the spacing that `case run`
           takes by itself, and at half of it?
Candidate  The springs of `case run`: lattices cut to the outline.
Reference  Its elements, and the error that they state of themselves.
Expected   Springs are the material: each halving brings them nearer. But cells are counted across
           the whole body: where a wall, or the rim that holds the body, has few, they are far off.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
import pandas as pd
from scipy.spatial import Delaunay

from msvalidate import kit
from msvalidate.case.case import Case
from msvalidate.case.comparison import compare_case
from msvalidate.lattice import fill, patterns
from msvalidate.linear_algebra.norms import max_length

BAND = 0.05
LENGTH, HEIGHT = 120.0, 40.0
"""Of the plate (mm)."""
HOLES = ((30.0, 20.0, 10.0), (85.0, 20.0, 12.0))
"""Centre and radius (mm); the first is the bolt's."""
SIZE, ROUND = 5.0, 48
"""Of the plate's triangles (mm), and the number of points on a hole."""
LEANING = np.array([[1.0, 0.02], [0.01, 1.0]])
"""Turns squares, which two diagonals cut equally well, into cells that one of them cuts."""
LEG, WIDE, WALL = 50.0, 40.0, 5.0
"""Of the bracket: two walls at a right angle (mm)."""
MM = 1e-3
PLASTIC = kit.Isotropic(E=2e9, nu=0.4, thickness=4 * MM)
METAL = kit.Isotropic(E=70e9, nu=0.33, state="solid")
PLATE = f"plate {LENGTH:g} x {HEIGHT:g} mm with two holes, ratio {PLASTIC.nu:g}"


@dataclass(frozen=True)
class Part:
    """A body that is made, held and loaded."""

    body: str
    problem: Callable[[], kit.Problem]


@cache
def plate() -> kit.Mesh:
    """Delaunay's triangles of the plate (m), its bolt's hole named."""
    lines = [np.linspace(0, size, round(size / SIZE) + 1) for size in (LENGTH, HEIGHT)]
    points = np.stack(np.meshgrid(*lines), axis=-1).reshape(-1, 2)
    turn = 2 * np.pi * np.arange(ROUND) / ROUND
    circle = np.column_stack([np.cos(turn), np.sin(turn)])
    for *centre, radius in HOLES:
        clear = np.linalg.norm(points - centre, axis=1) > radius + SIZE / 2
        points = np.concatenate([points[clear], centre + radius * circle])
    cells = Delaunay(points @ LEANING).simplices
    middle = points[cells].mean(axis=1)
    for *centre, radius in HOLES:
        outside = np.linalg.norm(middle - centre, axis=1) > radius * np.cos(np.pi / ROUND)
        cells, middle = cells[outside], middle[outside]
    bolt = len(points) - len(HOLES) * ROUND + np.arange(ROUND)  # the first of the circles
    rim = np.column_stack([bolt, np.roll(bolt, -1)])
    return kit.Mesh(MM * points, cells, "triangle", {"bolt": rim})


def bracket() -> kit.Mesh:
    """Cubes of a wall's thickness, an L along x and z."""
    counts = tuple(round(size / WALL) for size in (LEG, WIDE, LEG))
    whole = fill(patterns.cubic18(), kit.Box(tuple(MM * WALL * n for n in counts)), counts)
    middle = whole.points[whole.cells].mean(axis=1)
    cells = whole.cells[(middle[:, [0, 2]] < MM * WALL).any(axis=1)]
    used, numbered = np.unique(cells, return_inverse=True)
    return kit.Mesh(whole.points[used], numbered.reshape(cells.shape), "hexahedron")


def pulled_down(body: kit.Mesh, law: kit.Isotropic, held: str = "") -> kit.Problem:
    """A body that is held at its first end, or a named side, and sheared down at its other one."""
    ends = [kit.Region((x, *[None] * (body.dim - 1))) for x in body.span[0]]
    support = kit.Support(body.side(held) if held else ends[0], (0.0,) * body.dim)
    return kit.Problem(
        body, law, (support,), (kit.Traction(ends[1], (*[0.0] * (body.dim - 1), -1e6)),)
    )


CLAMPED = Part(f"{PLATE}, held at a side", lambda: pulled_down(plate(), PLASTIC))
BOLTED = Part(f"{PLATE}, held at a bolt hole", lambda: pulled_down(plate(), PLASTIC, "bolt"))
BRACKET = Part(
    f"bracket in space, {LEG:g} x {WIDE:g} x {LEG:g} mm, {WALL:g} mm thick",
    lambda: pulled_down(bracket(), METAL),
)
PARTS, ADVISED = (CLAMPED, BOLTED, BRACKET), (BOLTED, BRACKET)
"""All, and those that elements are advised for."""


def run() -> kit.Evidence:
    """Differences of all parts, at two spacings each."""
    table = pd.DataFrame([row for part in PARTS for row in rows(part)])
    return kit.Evidence(
        tables={"ordinary": table},
        tolerances=judge(table),
        columns=kit.columns(__file__),
        findings=(finding(table),),
    )


@cache
def rows(part: Part) -> list[dict[str, object]]:
    """A part as `case run` compares it, displacements alone, and at half of that spacing."""
    found = compare_case(Case(part.problem(), quantities=("displacement",)))
    wanted, uncertainty = found.reference.displacement.value, found.rows[0].uncertainty
    narrowest = min(high - low for low, high in found.case.problem.domain.span)
    told = []
    for springs in found.springs[:2]:
        away = max_length(springs.at(found.points) - wanted) / max_length(wanted)
        told.append({
            "body": part.body,
            "lattice": springs.lattice.name,
            "cells_across": round(narrowest / springs.spacing),
            "spacing": springs.spacing,
            "difference": away,
            "uncertainty": uncertainty,
        })  # fmt: skip
    return told


def judge(table: pd.DataFrame) -> tuple[kit.Tolerance, ...]:
    """What the tolerances judge, in their order."""
    coarse, fine = (table.groupby("body", sort=False).nth(k).set_index("body") for k in (0, 1))
    advised = fine.loc[[part.body for part in ADVISED]]
    return (
        kit.Tolerance(
            "ordinary parts: reference's own error over the difference of springs, worst", 0.5, "1",
            "a difference is resolved where the reference moves it by less than half",
            observed=kit.Observed(float((table["uncertainty"] / table["difference"]).max())),
        ),
        kit.Tolerance(
            "ordinary parts: parts whose difference does not fall at half of the spacing", 0, "1",
            "the springs are the material, and finer ones are nearer",
            observed=kit.Observed(float((fine["difference"] >= coarse["difference"]).sum())),
        ),
        kit.Tolerance(
            "plate with two holes, held at its straight side: difference at the spacing of `case "
            "run`",
            BAND, "1", "the band of displacements; the least ligament, beside a hole, has 4 cells",
            layer="agreement",
            observed=kit.Observed(float(coarse["difference"][CLAMPED.body])),
        ),
        kit.Tolerance(
            "parts that elements are advised for: those that agree at half of the spacing", 0, "1",
            "what springs do well is no case for elements",
            observed=kit.Observed(float((advised["difference"] <= BAND).sum())),
        ),
    )  # fmt: skip


def finding(table: pd.DataFrame) -> str:
    """How far off each part is."""
    said = "; ".join(
        f"{row['body']}: {100 * row['difference']:.2g} % ± {100 * row['uncertainty']:.2g} %"
        for row in table.groupby("body", sort=False).head(1).to_dict("records")
    )
    return f"Springs of `case run` beside elements, at the spacing that it takes by itself: {said}."
