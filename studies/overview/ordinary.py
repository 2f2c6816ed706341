"""Ordinary parts: what does `case run` say of a plate with two holes and of a bracket in space?

Question   A plate of 120 mm by 40 mm with two holes, held at a straight side or at a hole, and a
           bracket in space: how far are springs from elasticity at the spacing that `case run`
           takes by itself, and at half of it?
Candidate  The springs of `case run`: lattices cut to the outline, and beside them those on the
           part's own mesh, which are linear elements.
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
from msvalidate.case.file.case import Case, spacing_of
from msvalidate.case.springs.large import converge_case
from msvalidate.case.springs.lattice_springs import compared_points, solve_springs
from msvalidate.case.springs.mesh_springs import compare_on_mesh
from msvalidate.linear_algebra.norms import max_length
from msvalidate.springs.lattice import fill, patterns
from reference_fem.mesh.from_mesh import mesh_discretisation

BAND = 0.05
LENGTH, HEIGHT = 120.0, 40.0
"""Of the plate (mm)."""
HOLES = ((30.0, 20.0, 10.0), (85.0, 20.0, 12.0))
"""Centre and radius (mm); the first is the bolt's."""
SIZE, ROUND, RINGS = 4.0, 32, (1.0, 1.2, 1.45)
"""Of the plate's triangles (mm), the points round a hole, and rings of them over its radius."""
LEANING = np.array([[1.0, 0.02], [0.01, 1.0]])
"""Turns squares, which two diagonals cut equally well, into cells that one of them cuts."""
LEG, WIDE, WALL = 50.0, 40.0, 5.0
"""Of the bracket: two walls at a right angle (mm)."""
ON_MESH = "edges of its own mesh, no rest length"
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
    """Delaunay's quadratic triangles of the plate (m), on the holes' own curves, the bolt's named.

    Rings of points round the holes grow with their distance, up to a grid's.
    """
    x, rows = np.linspace(0, LENGTH, round(LENGTH / SIZE) + 1), round(HEIGHT / SIZE * 2 / 3**0.5)
    staggered = [x, np.concatenate([x[:1], (x[1:] + x[:-1]) / 2, x[-1:]])]
    every = [(staggered[row % 2], HEIGHT * row / rows) for row in range(rows + 1)]
    points = np.concatenate([np.column_stack([x, np.full(len(x), y)]) for x, y in every])
    rim, holes = [], [(np.array(centre), radius) for *centre, radius in HOLES]
    for centre, radius in holes:
        points = points[np.linalg.norm(points - centre, axis=1) > radius * RINGS[-1] + SIZE / 2]
        for number, ring in enumerate(RINGS):
            turn = 2 * np.pi * (np.arange(ROUND) + number / 2) / ROUND
            rim.append(centre + radius * ring * np.column_stack([np.cos(turn), np.sin(turn)]))
    points = np.concatenate([points, *rim])
    cells = Delaunay(points @ LEANING).simplices
    for centre, radius in holes:
        off = np.linalg.norm(points[cells].mean(axis=1) - centre, axis=1)
        cells = cells[off > radius * np.cos(np.pi / ROUND)]
    body = mesh_discretisation(kit.Mesh(points, cells, "triangle"), "P2")
    x, surface, bolt = body.points.copy(), body.surface, np.zeros(0, dtype=int)
    for centre, radius in reversed(holes):
        off = np.linalg.norm(x - centre, axis=1)
        bolt = np.flatnonzero((np.abs(off[surface[:, :2]] - radius) < MM).all(axis=1))
        middle = surface[bolt, 2]
        x[middle] = centre + radius * (x[middle] - centre) / off[middle, None]
    return kit.Mesh(MM * x, body.cells, "triangle6", {"bolt": surface[bolt]})


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
"""All, and those for which cut lattices are not advised."""


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
    case = Case(part.problem(), quantities=("displacement",))
    lattices = [solve_springs(case, spacing_of(case) / times) for times in (1, 2)]
    points = compared_points(case, lattices[0].lattice)
    reference = converge_case(case, points)
    wanted, uncertainty = reference.displacement.value, reference.error
    narrowest = min(high - low for low, high in case.problem.domain.span)
    told = []
    for springs in lattices:
        away = max_length(springs.at(points) - wanted) / max_length(wanted)
        told.append({
            "body": part.body,
            "lattice": springs.lattice.name,
            "cells_across": round(narrowest / springs.spacing),
            "spacing": springs.spacing,
            "difference": away,
            "uncertainty": uncertainty,
        })  # fmt: skip
    on_mesh, _ = compare_on_mesh(case, reference, len(lattices[0].lattice.points))
    for one in [] if on_mesh is None else on_mesh.table[:2].to_dict("records"):
        told.append({
            "body": part.body,
            "lattice": ON_MESH,
            "cells_across": round(narrowest / one["spacing"]),
            **{name: one[name] for name in ("spacing", "difference", "uncertainty")},
        })  # fmt: skip
    return told


def judge(table: pd.DataFrame) -> tuple[kit.Tolerance, ...]:
    """What the tolerances judge, in their order."""
    lattices, meshes = (table[(table["lattice"] == ON_MESH) == own] for own in (False, True))
    coarse, fine = (lattices.groupby("body", sort=False).nth(k).set_index("body") for k in (0, 1))
    bolted = meshes.set_index("body").loc[[BOLTED.body]]
    order = -np.diff(np.log(bolted["difference"])) / -np.diff(np.log(bolted["spacing"]))
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
            "parts for which cut lattices are not advised: those that agree at half of the spacing",
            0, "1", "what a cut lattice does well is no case for the part's own mesh",
            observed=kit.Observed(float((advised["difference"] <= BAND).sum())),
        ),
        kit.Tolerance(
            "plate held at a bolt hole: springs on its own mesh, difference at 20 cells across",
            0.015, "1", "linear elements of a mesh that is finer at its holes; no cell is cut",
            layer="agreement",
            observed=kit.Observed(float(bolted["difference"].iloc[0])),
        ),
        kit.Tolerance(
            "plate held at a bolt hole: springs on its own mesh, order below 2", 0.3, "1",
            "linear elements: 2 where nothing is singular, and the hole is smooth",
            observed=kit.Observed(float(max(0.0, 2 - abs(order[0])))),
        ),
    )  # fmt: skip


def finding(table: pd.DataFrame) -> str:
    """How far off each part is."""
    said = "; ".join(
        f"{row['body']}: {100 * row['difference']:.2g} % ± {100 * row['uncertainty']:.2g} %"
        for row in table.groupby("body", sort=False).head(1).to_dict("records")
    )
    return f"Springs of `case run` beside elements, at the spacing that it takes by itself: {said}."
