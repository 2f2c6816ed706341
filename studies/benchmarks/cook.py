"""Cook's membrane: a tapered panel, clamped on the left and sheared on the right.

Question   Deflection of the middle of the right edge, (48, 52), in the problem's own units.
Candidate  Linear equilibrium of springs: a square lattice cut to the outline, and a spring on every
           edge of a mesh, equal or by area [vanGelder1998]: of quadrilaterals with diagonals, of
           these cut into triangles along diagonals that all rise or alternate, and of Delaunay's
           triangles, which are nearly equilateral inside.
Reference  23.967 for E = 1, nu = 1/3, F = 1 ([Cook1974] posed it; the
           value is that of fine meshes, 23.96 in most of the literature), and our own limit by
           quadratic elements graded to the corners.
Expected   The clamped upper corner measures 108 degrees: its exponent λ makes order 2λ on even
           meshes, for each element. The cut lattice has no better corner, but an error of its
           own of order 2 in bending that is larger on the meshes here, and of the other sign in
           part. Springs on edges of a mesh that is not regular are another material: they converge
           elsewhere. On equilateral triangles, equal springs and those by area are the material.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial
from itertools import product

import numpy as np
import pandas as pd

import reference_fem
from msvalidate import kit
from msvalidate.bench.judging.singularity import clamped_free_exponent
from msvalidate.springs.bodies.cut_network import cut_network
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.lattice import cut_lattice, mesh_lattice, patterns
from msvalidate.springs.lattice.edges import EdgeLattice
from msvalidate.springs.statics.stress import fitted_stress
from reference_fem.elasticity import elastic_tensor
from reference_fem.mesh.outlines import outline_discretisation

from . import cases, curved, models

PANEL = kit.Polygon(((0.0, 0.0), (48.0, 44.0), (48.0, 60.0), (0.0, 44.0)))
WIDTH, EDGE = 48.0, 16.0
"""Of the panel, and of its right edge (m)."""
PROBE = np.array([[48.0, 52.0]])
MATERIAL = kit.Isotropic(E=1.0, nu=1 / 3)
ACCEPTED = 23.967
CORNER = np.pi / 2 + np.arctan2(16.0, 48.0)
"""Angle (rad) of the panel's clamped upper corner; the lower one, of 47 degrees, is no worse."""
MESHES, QUICK_MESHES = (4, 8, 16, 32, 64), (4, 8, 16, 32)
LATTICES, QUICK_LATTICES = (12, 24, 48, 96, 192), (12, 24, 48)
"""Cells along the width, of elements and meshes of springs, and of cut lattices."""
COARSEST, GRADING, ACCURACY = 8, 2.0, 5e-5
"""Of the mesh for the limit."""
DRAWN = 24
"""Cells along the width of what is drawn."""
BAND = 0.01
CUT = models.method(curved.CUT, MATERIAL.nu)
EDGES = "springs, edges of"
RISING, EVEN = "rising diagonals", "Delaunay"
EQUAL = 2 * np.sqrt(3) / 4
"""Stiffness of equal springs over E t: what an edge inside an equilateral mesh gets, √3/4 of each
of its two triangles; so the triangular lattice of such springs has E and a ratio of 1/3."""
ON_EDGES = (
    ("quad", "", "area"),
    *product(("triangle",), (RISING, "alternating diagonals", EVEN), ("equal", "area")),
)
"""Cells, their diagonals and the rule of springs."""


def edge_method(shape: str, diagonals: str, rule: str) -> str:
    """Name of a method: what the mesh is of, its diagonals, and the rule of its springs."""
    return ", ".join(filter(None, (f"{EDGES} {shape}s", diagonals, f"rule {rule}")))


@cache
def corner_order() -> float:
    """Twice the displacement's exponent at the clamped upper corner."""
    return float(2 * clamped_free_exponent(elastic_tensor(MATERIAL), CORNER))


judged = partial(cases.judged, table="cook")
on_mesh = partial(cases.judged, table="cook_edges")
RULES = (
    judged(
        "Cook's membrane: limit by finite elements against 23.967, relative", 1e-4,
        value=kit.Quotient("limit", "accepted"), reference=1.0,
        because="a unit of the accepted value's last digit is 4e-5, and as much is our own "
        "uncertainty",
    ),
    judged(
        "Cook's membrane: order of Q2 on even meshes, against the corner's 2λ", 0.15,
        rows={"method": "FEM Q2"}, value=cases.orders, reference=lambda _: corner_order(),
        because="the next term, of the lower corner, is of order 2.4: a part 1/16^1.1 of the first "
        "at 16 cells, were they alike at one, moves a pair by 0.07",
    ),
    kit.Rule(
        "Cook's membrane: springs cut to the outline, 48 cells, relative", 0.005, "1",
        "springs are stiffer in bending by (5/4)/N²: 0.5 % at the right edge, 16 cells high at "
        "48 along the width, and less everywhere else",
        table="cook", rows={"method": CUT, "cells": 48}, value="against_limit",
    ),
    cases.fitted(
        "Cook's membrane: order of springs cut to the outline, all lattices", 0.2,
        table="cook", rows={"method": CUT},
        because="2, that of bending; the corner's part, if as large as that of Q2, is 7 % of the "
        "whole at 48 cells and 18 % at 192, and moves a pair by 2 - 2λ = 0.65 of that, 0.12 at "
        "most; the next term of bending, 1/16 of the first at 4 cells through the right edge, by "
        "0.07",
    ),
    on_mesh(
        "Cook's membrane: cut squares with a spring on every edge within 1 %, finest", 0,
        value=lambda rows: sum(
            EVEN not in row.method and abs(row.against_limit) <= BAND for row in rows.itertuples()
        ),
        because="such springs are another material on cells that are not regular, however small; "
        "the panel's mapped squares, whole or cut in two, are nowhere",
    ),
    on_mesh(
        "Cook's membrane: springs by area on Delaunay's triangles, finest, relative", 0.05,
        layer="agreement", value="against_limit",
        rows={"method": f"{EDGES} triangles, {EVEN}, rule area"},
        because="the band of displacements: triangles are equilateral but for a row or two at the "
        "outline, and on these springs by area are the material",
    ),
)  # fmt: skip
EDGES_FIGURE = kit.series(
    "cook_edges", title="Cook's membrane by springs on edges of triangles", by="method",
    rows={"method": tuple(edge_method(*each) for each in ON_EDGES[1:])},
    x="cells", y="against_limit", labels=("cells along the width (1)", "difference, relative (1)"),
    words={edge_method(s, d, rule): f"{d}, {rule}" for s, d, rule in ON_EDGES},
    level={0.0: "limit by elements"}, log="x", size=(6.4, 4.2),
)  # fmt: skip


def run(
    candidate: kit.DisplacementSolver = kit.solve_springs, setting: kit.Setting = kit.FULL
) -> kit.Evidence:
    """Compare the candidate's panels and finite elements with the accepted value."""
    meshes = QUICK_MESHES if setting.quick else MESHES
    lattices = QUICK_LATTICES if setting.quick else LATTICES
    estimate = reference_fem.refine(
        lambda cells: elastic_deflection("Q2", GRADING, cells) / ACCEPTED, COARSEST, ACCURACY
    )
    goal = cases.Quantity(
        "Cook's membrane", "u_y at (48, 52)", "m", ACCEPTED, "Cook 1974; fine meshes", MATERIAL.nu,
        limit=float(estimate.value[0]) * ACCEPTED,
        limit_uncertainty=float(estimate.uncertainty[0] / estimate.value[0]),
    )  # fmt: skip
    rows = []
    for element in ("Q1", "Q2"):
        found = setting.sweep(partial(elastic_deflection, element, 1.0), meshes, "Cook's membrane")
        rows += cases.rows(goal, f"FEM {element}", meshes, found)
    cut = setting.sweep(partial(cut_deflection, candidate), lattices, "cut lattices")
    rows += cases.rows(goal, CUT, lattices, cut)
    edges = []
    for shape, diagonals, rule in ON_EDGES:
        make = partial(on_edges, shape, diagonals, rule)
        method = edge_method(shape, diagonals, rule)
        found = setting.sweep(partial(edge_deflection, candidate, make), meshes, method)
        edges += cases.rows(goal, method, meshes, found)
    table, on_mesh = pd.DataFrame(rows), pd.DataFrame(edges)
    fields = field_to_draw(candidate)
    return kit.Evidence(
        tables={"cook": table, "cook_edges": on_mesh},
        tolerances=RULES,
        columns=kit.columns(__file__),
        drawn={"cook_field": fields},
        figures={
            "cook": cases.drawing("cook", "Cook's membrane", "cells along the width (1)"),
            "cook_edges": EDGES_FIGURE,
            **curved.pictures("cook_field", "Cook's membrane"),
        },
        findings=(finding(goal, table), finding(goal, on_mesh)),
    )


def problem(body: kit.Domain) -> kit.Problem:
    """The membrane: left edge clamped, a unit force along y on the right one."""
    left, right = kit.Segment((0.0, 44.0), (0.0, 0.0)), kit.Segment((48.0, 44.0), (48.0, 60.0))
    return kit.Problem(
        body,
        MATERIAL,
        (kit.Support(left, (0.0, 0.0)),),
        (kit.Traction(right, (0.0, 1 / EDGE)),),
        name="Cook's membrane",
    )


def map_to_panel(points: kit.Array) -> kit.Array:
    """Places (n, 2) of the unit square in the panel: each line of it is straight."""
    s, t = points.T
    return np.column_stack([WIDTH * s, 44 * s * (1 - t) + (44 + 16 * s) * t])


def elastic_mesh(element: str, grading: float, cells: int) -> reference_fem.Discretisation:
    """Cells of an element in the panel, drawn to its corners where grading is above 1."""
    unit = reference_fem.box_discretisation(kit.Box((1.0, 1.0)), cells, element, grading)
    return reference_fem.make_discretisation(map_to_panel(unit.points), unit.cells, element)


def elastic_deflection(element: str, grading: float, cells: int) -> float:
    """Deflection at (48, 52) by finite elements."""
    body = elastic_mesh(element, grading, cells)
    return float(reference_fem.solve_problem(problem(PANEL), body).at(PROBE)[0, 1])


def cut_deflection(candidate: kit.DisplacementSolver, cells: int) -> float:
    """The same of the candidate's square lattice cut to the outline."""
    lattice = cut_lattice(patterns.square(), PANEL, WIDTH / cells)
    asked = problem(PANEL)
    move = candidate(asked, cut_network(asked, lattice), "linear")
    points, weights = lattice.weights_at(PROBE)
    return float((weights * move[points, 1]).sum())


def edge_deflection(
    candidate: kit.DisplacementSolver, make: Callable[[int], EdgeLattice], cells: int
) -> float:
    """The same of the candidate's springs along the edges of a mesh."""
    lattice = make(cells)
    asked = problem(lattice.domain)
    network = lattice_network(asked, lattice, (MATERIAL.E * MATERIAL.thickness,))
    move = candidate(asked, network, "linear")
    at = np.linalg.norm(lattice.points - PROBE, axis=1).argmin()
    return float(move[at, 1])


def on_edges(shape: str, diagonals: str, rule: str, cells: int) -> EdgeLattice:
    """A spring on each edge of a mesh of the panel."""
    if diagonals == EVEN:
        body = outline_discretisation(PANEL, WIDTH / cells, PROBE)
        mesh = kit.Mesh(body.points, body.cells, shape)
    else:
        unit = reference_fem.box_discretisation(kit.Box((1.0, 1.0)), cells, "Q1")
        mesh = cut_mesh(map_to_panel(unit.points), unit.cells, shape, diagonals)
    if rule != "equal":
        return mesh_lattice(mesh, rule)
    lattice = mesh_lattice(mesh)
    return replace(lattice, factor=np.full(len(lattice.springs), EQUAL), rule=rule)


def cut_mesh(points: kit.Array, cells: kit.Index, shape: str, diagonals: str) -> kit.Mesh:
    """Quadrilaterals as they are, or each cut in two triangles: a row's diagonals rise, or all."""
    if shape == "quad":
        return kit.Mesh(points, cells, shape)
    row, column = np.divmod(np.arange(len(cells)), round(np.sqrt(len(cells))))
    falls = (row + column) % 2 == 1 if diagonals != RISING else np.zeros(len(cells), dtype=bool)
    turned = np.where(falls[:, None], np.roll(cells, 1, axis=1), cells)
    return kit.Mesh(points, np.concatenate([turned[:, [0, 1, 2]], turned[:, [0, 2, 3]]]), shape)


def finding(goal: cases.Quantity, table: pd.DataFrame) -> str:
    """Where everything arrives."""
    uncertainty = goal.limit_uncertainty * goal.goal
    return (
        f"Cook's membrane, our limit {goal.goal:.4f} ± {uncertainty:.4f}: {cases.describe(table)}."
    )


def field_to_draw(candidate: kit.DisplacementSolver) -> pd.DataFrame:
    """Stresses of the cut lattice and of finite elements, both by a fit to displacements near by.

    At corners the fit reaches beyond them, and what is drawn as a difference there is the fit's.
    """
    places = map_to_panel(reference_fem.box_discretisation(kit.Box((1.0, 1.0)), 16, "Q1").points)
    springs = curved.spring_body(candidate, problem(PANEL), WIDTH / DRAWN)
    body = elastic_mesh("Q2", 1.0, DRAWN)
    move = reference_fem.solve_problem(problem(PANEL), body).displacement
    elements = fitted_stress(body.points, move, places, springs.tensor, degree=2)
    return curved.field(places, elements, springs.stress(places, "quadratic"))
