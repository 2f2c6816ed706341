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

from msvalidate.judging.candidate import DisplacementSolver, solve_springs
from msvalidate.judging.compare import farthest_value
from msvalidate.judging.evidence import Evidence, Observed, Tolerance, by_quantity
from msvalidate.judging.sweep import FULL, Setting
from msvalidate.problem import Array, Isotropic, Mesh, Problem, Traction

from . import cases, curved, curved_drawing, sketches
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
OWN = "Kirsch: shear and von Mises stress on the hole by Q2 over what it states to be off"
TOLERANCES = (
    Tolerance(
        "Kirsch: order of the stress on the hole by Q2", 0.3, "1",
        "2 for gradients of quadratic elements at a node; cells at the hole are 0.09 of its radius "
        "high where the pair starts, and the next term as large a part of the first, or twice that",
    ),
    Tolerance(
        "Kirsch: stress across and along by Q2 over what it states to be off", 1.0, "1",
        "as of shear below",
    ),
    Tolerance(
        OWN, 1.0, "1",
        "three meshes that halve their cells state by Richardson's rule how far the last is off, "
        "with a factor of safety: no value may be farther from Kirsch's",
    ),
    Tolerance(
        "Kirsch: stress across the hole by springs, quartic fit, finest lattice, relative",
        0.01, "1",
        "cut cells leave a part of a per cent at 16 cells per radius, as in the pressed ring",
        layer="agreement",
    ),
    Tolerance(
        "Kirsch: order of the stress across the hole by springs, quadratic fit, all lattices",
        0.7, "1",
        "2, that of a quadratic fit, which reaches 6 cells deep: beyond the radius at 4 cells, "
        "where a pair has order 1, and what cut cells leave raises the finest, as of LE1",
        layer="agreement",
    ),
)  # fmt: skip
COLUMNS = {
    **cases.COLUMNS,
    **curved_drawing.COLUMNS,
}


def run(candidate: DisplacementSolver = solve_springs, setting: Setting = FULL) -> Evidence:
    """Compare springs and elements with Kirsch's field."""
    table = pd.DataFrame(rows(candidate, setting))
    meshed = partial(ring_quarter, RADIUS, RIM)
    drawn = curved.field(candidate, meshed, piece, FIELD)
    return Evidence(
        tables={"hole": table, "hole_field": curved_drawing.table(*drawn)},
        observed=observe(table),
        tolerances=TOLERANCES,
        columns=COLUMNS,
        figures={
            "hole": cases.drawing(
                "hole", "Plate with a hole", "cells from hole to rim, or per radius (1)"
            ),
            "hole_field": curved_drawing.drawing(
                "hole_field", "Plate with a hole", meshed(FIELD[0]).cells, (RADIUS,) * 2, mark_loads
            ),
        },
        findings=(f"Plate with a hole, finest meshes: {cases.describe(table)}.",),
    )


def rows(candidate: DisplacementSolver, setting: Setting) -> list[dict[str, object]]:
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
    known = float(slanted[0, 2]), float(curved_drawing.mises(slanted)[0])
    for name, accepted in zip(SLANTED, known, strict=True):
        asked = cases.Quantity(
            "plate with a hole", name, "Pa", accepted, SOURCE, curved.SPRINGS_ALONE
        )
        found += cases.rows(asked, FEM, ELEMENTS, [each[name] for each in of_elements])
    return found


def kirsch(points: Array) -> Array:
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


def piece(mesh: Mesh) -> Problem:
    """Quarter ring cut out of the endless plate, with the plate's tractions on its rim."""
    return Problem(
        mesh,
        Isotropic(E=MODULUS, nu=curved.SPRINGS_ALONE),
        curved.quarter_supports(mesh),
        (Traction(mesh.side("rim"), pull),),
        name="plate with a hole",
    )


def pull(points: Array) -> Array:
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
    seen = float(slanted[0, 2]), float(curved_drawing.mises(slanted)[0])
    return found | dict(zip(SLANTED, seen, strict=True))


def spring_sides(candidate: DisplacementSolver, cells: int) -> dict[tuple[str, str], float]:
    """The same of springs, `cells` per radius, by quantity and fit."""
    asked = piece(ring_quarter(RADIUS, RIM, OUTLINE).mesh)
    body = curved.spring_body(candidate, asked, RADIUS / cells)
    return {
        (name, fit): float(body.stress(at, fit)[0, part])
        for name, (at, part, _) in SIDES.items()
        for fit in curved.FITS
    }


def observe(table: pd.DataFrame) -> dict[str, Observed]:
    """The judged quantities."""
    last = cases.finest(table)
    elements = last[(last["method"] == FEM) & last["quantity"].isin(SIDES)]
    slanted = last[last["quantity"].isin(SLANTED)]
    across = table[table["quantity"] == next(iter(SIDES))]
    quadratic = across[across["method"].str.endswith("quadratic fit")]
    quartic = cases.finest(across[across["method"].str.endswith("quartic fit")])
    values = (
        farthest_value(cases.orders(elements), 2.0),
        farthest_value(cases.excess_over_uncertainty(elements), 0.0),
        farthest_value(cases.excess_over_uncertainty(slanted), 0.0),
        farthest_value(quartic["against_limit"], 0.0),
        farthest_value(curved.fitted_orders(quadratic), 2.0),
    )
    return by_quantity(TOLERANCES, values)
