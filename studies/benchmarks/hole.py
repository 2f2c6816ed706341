"""Hole in a plate: by how much does a circular hole raise the stress (Kirsch)?

Question   Stress on the hole's side, across the tension and along it, of a piece of an endless
           plate; of elements shear and von Mises stress between the two as well.
Candidate  Square cells cut to the outline, springs alone (nu = 1/3).
Reference  Kirsch's field ([Kirsch1898]; [TimoshenkoGoodier1970], art. 35): 3 and
           -1 times the tension.
Expected   A piece of the endless plate is given the exact tractions on its rim, so nothing is left
           but the mesh: order 2 of elements' stresses at nodes, and of springs' by a quadratic fit.
           Plates of a finite width are the question `strips`.
"""

from __future__ import annotations

from functools import partial

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from msvalidate import kit

from . import cases, curved, sketches
from .shapes import ring_quarter

MODULUS, TENSION = 1e6, 1.0
RADIUS, RIM = 1.0, 4.0
"""Of the hole and of the piece of the endless plate (m)."""
ACROSS, ALONG = np.array([[RADIUS, 0.0]]), np.array([[0.0, RADIUS]])
"""The sides of the hole; the tension is along y."""
ELEMENTS = (4, 8, 16, 32)
"""Cells from hole to rim."""
LATTICES, QUICK_LATTICES = (4, 8, 16, 32), (4, 8, 16)
"""Cells per radius of the hole."""
OUTLINE = 16
FIELD = (8, 16, 1 / 16)
"""As in `ellipse`."""
FEM = "FEM Q2"
SOURCE = "Kirsch 1898"
SIDES = {"σyy at (a, 0)": (ACROSS, 1, 3.0), "σxx at (0, a)": (ALONG, 0, -1.0)}
"""Quantity -> place, Voigt component and exact value over the tension."""
DIAGONAL = RADIUS * np.array([[np.sqrt(0.5), np.sqrt(0.5)]])
SLANTED = ("τxy on the hole, at 45°", "von Mises stress on the hole, at 45°")
ACROSS_BY = {
    fit: {"quantity": "σyy at (a, 0)", "method": curved.method(curved.SPRINGS_ALONE, fit)}
    for fit in curved.FITS
}
judged = partial(cases.judged, table="hole")
RULES = (
    judged(
        "Kirsch: order of the stress on the hole by Q2", 0.3,
        rows={"method": FEM, "quantity": tuple(SIDES)}, value=cases.orders, reference=2.0,
        because="2 for gradients of quadratic elements at a node; cells at the hole are 0.09 of "
        "its radius high where the pair starts, and the next term as large a part of the first, or "
        "twice that",
    ),
    judged(
        "Kirsch: stress across and along by Q2 over what it states to be off", 1.0,
        rows={"method": FEM, "quantity": tuple(SIDES)}, value=cases.STATED,
        because="as of shear below",
    ),
    judged(
        "Kirsch: shear and von Mises stress on the hole by Q2 over what it states to be off", 1.0,
        rows={"method": FEM, "quantity": SLANTED}, value=cases.STATED,
        because="three meshes that halve their cells state by Richardson's rule how far the last "
        "is off, with a factor of safety: no value may be farther from Kirsch's",
    ),
    judged(
        "Kirsch: stress across the hole by springs, quartic fit, finest lattice, relative", 0.01,
        layer="agreement", rows=ACROSS_BY["quartic"], value="against_limit",
        because="cut cells leave a part of a per cent at 16 cells per radius, as in the pressed "
        "ring",
    ),
    cases.fitted(
        "Kirsch: order of the stress across the hole by springs, quadratic fit, all lattices", 0.7,
        layer="agreement", table="hole", rows=ACROSS_BY["quadratic"],
        because="2, that of a quadratic fit, which reaches 6 cells deep: beyond the radius at 4 "
        "cells, where a pair has order 1, and what cut cells leave raises the finest, as of LE1",
    ),
)  # fmt: skip


def run(
    candidate: kit.DisplacementSolver = kit.solve_springs, setting: kit.Setting = kit.FULL
) -> kit.Evidence:
    """Compare springs and elements with Kirsch's field."""
    table = pd.DataFrame(rows(candidate, setting))
    meshed = partial(ring_quarter, RADIUS, RIM)
    drawn = curved.mesh_field(candidate, meshed, piece, FIELD)
    return kit.Evidence(
        tables={"hole": table},
        tolerances=RULES,
        columns=kit.columns(__file__),
        drawn={"hole_field": drawn},
        figures={
            "hole": cases.drawing(
                "hole", "Plate with a hole", "cells from hole to rim, or per radius (1)"
            ),
            **curved.pictures("hole_field", "Plate with a hole"),
        },
        findings=(f"Plate with a hole: {cases.describe(table)}.",),
    )


def rows(candidate: kit.DisplacementSolver, setting: kit.Setting) -> list[dict[str, object]]:
    """Rows of the table `hole`."""
    lattices = QUICK_LATTICES if setting.quick else LATTICES
    of_elements = setting.sweep(elastic_sides, ELEMENTS, "hole by elements")
    of_springs = setting.sweep(partial(spring_sides, candidate), lattices, "hole by springs")
    found: list[dict[str, object]] = []
    for name, (_, _, exact) in SIDES.items():
        value = cases.Quantity(
            "plate with a hole", name, "Pa", exact * TENSION, SOURCE, curved.SPRINGS_ALONE
        )
        found += cases.rows(value, FEM, ELEMENTS, [each[name] for each in of_elements])
        for fit in curved.FITS:
            springs_by = curved.method(curved.SPRINGS_ALONE, fit)
            found += cases.rows(
                value, springs_by, lattices, [each[name, fit] for each in of_springs]
            )
    slanted = kirsch(DIAGONAL)
    known = float(slanted[0, 2]), float(curved.mises(slanted)[0])
    for name, accepted in zip(SLANTED, known, strict=True):
        asked = cases.Quantity(
            "plate with a hole", name, "Pa", accepted, SOURCE, curved.SPRINGS_ALONE
        )
        found += cases.rows(asked, FEM, ELEMENTS, [each[name] for each in of_elements])
    return found


def kirsch(points: kit.Array) -> kit.Array:
    """Stress (n, 3) in Pa of the endless plate at points (n, 2) in m, tension along y.

    In polar coordinates with q = (a/r)² and the angle from the tension
    σ_rr = (1 - q)/2 + (1 - 4q + 3q²)/2 cos 2θ, σ_θθ = (1 + q)/2 - (1 + 3q²)/2 cos 2θ,
    σ_rθ = -(1 + 2q - 3q²)/2 sin 2θ.

    Source: [Kirsch1898]; [TimoshenkoGoodier1970], article 35.
    """
    radius, turned = np.linalg.norm(points, axis=1), np.arctan2(points[:, 1], points[:, 0])
    q, twice = (RADIUS / radius) ** 2, 2 * (turned - np.pi / 2)
    rr = (1 - q) / 2 + (1 - 4 * q + 3 * q**2) / 2 * np.cos(twice)
    hoop = (1 + q) / 2 - (1 + 3 * q**2) / 2 * np.cos(twice)
    shear = -(1 + 2 * q - 3 * q**2) / 2 * np.sin(twice)
    c, s = np.cos(turned), np.sin(turned)
    xx = c**2 * rr + s**2 * hoop - 2 * s * c * shear
    yy = s**2 * rr + c**2 * hoop + 2 * s * c * shear
    xy = s * c * (rr - hoop) + (c**2 - s**2) * shear
    return TENSION * np.column_stack([xx, yy, xy])


def piece(mesh: kit.Mesh) -> kit.Problem:
    """Quarter ring cut out of the endless plate, with the plate's tractions on its rim."""
    return kit.Problem(
        mesh,
        kit.Isotropic(E=MODULUS, nu=curved.SPRINGS_ALONE),
        curved.quarter_supports(mesh),
        (kit.Traction(mesh.side("rim"), pull),),
        name="plate with a hole",
    )


def pull(points: kit.Array) -> kit.Array:
    """Traction (n, 2) in Pa of the endless plate on circles about the hole."""
    xx, yy, xy = kirsch(points).T
    x, y = (points / np.linalg.norm(points, axis=1, keepdims=True)).T
    return np.column_stack([xx * x + xy * y, xy * x + yy * y])


def mark_loads(axis: Axes) -> None:
    """Arrows of the tractions on the rim in a picture of the body."""
    at = sketches.arc((RIM, RIM), (2.0, 88.0), 12)
    sketches.forces(axis, at, 0.7 * pull(at) / TENSION, pull=True)


def elastic_sides(cells: int) -> dict[str, float]:
    """Stresses (Pa) on the hole by finite elements."""
    solution = curved.elastic(piece(ring_quarter(RADIUS, RIM, cells).mesh))
    found = {name: float(solution.stress(at)[0, part]) for name, (at, part, _) in SIDES.items()}
    slanted = solution.stress(DIAGONAL)
    seen = float(slanted[0, 2]), float(curved.mises(slanted)[0])
    return found | dict(zip(SLANTED, seen, strict=True))


def spring_sides(candidate: kit.DisplacementSolver, cells: int) -> dict[tuple[str, str], float]:
    """The same of springs, `cells` per radius, by quantity and fit."""
    asked = piece(ring_quarter(RADIUS, RIM, OUTLINE).mesh)
    body = curved.spring_body(candidate, asked, RADIUS / cells)
    return {
        (name, fit): float(body.stress(at, fit)[0, part])
        for name, (at, part, _) in SIDES.items()
        for fit in curved.FITS
    }
