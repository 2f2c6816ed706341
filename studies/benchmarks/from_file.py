"""Mesh file: is a body from a file that is written in millimetres the body that was meant?

Question   Area of MacNeal and Harder's patch, read from a Gmsh file in mm, and how much longer it
           gets under a uniform tension.
Candidate  Linear equilibrium of a square lattice cut to the outline of what was read.
Reference  On paper: 0.24 m x 0.12 m, and σ·L/E. Elements on the mesh of the file.
Expected   Exact: the stress is uniform, which elements hold on the file's mesh and the lattice at
           its sizes. Coordinates taken for metres would make the elongation 1000 times as large,
           which no ratio of lengths shows.
"""

from __future__ import annotations

from pathlib import Path

import pandas as pd

import reference_fem
from msvalidate import kit
from msvalidate.springs.bodies.mesh_file import read_mesh

from . import cases, curved, models
from .patch_bodies import MODULUS, PATCH, THICKNESS

FILE = Path(__file__).parent / "data" / "patch_mm.msh"
UNIT = 1e-3
"""Length (m) that coordinates in the file are multiples of."""
TENSION = 1e3
CELLS = 8
"""Of the lattice, along the patch: 8 x 4 whole ones, however long the patch was read to be."""
NU = curved.SPRINGS_ALONE
SOURCE = "on paper"
RULES = (
    kit.Rule(
        "body from a file in mm: area and elongation of elements and springs, relative", 1e-10, "1",
        "uniform stress is exact in both: left is rounding, 1e-16 times a condition number of up "
        "to 1e5",
        table="from_file", value="against_accepted",
    ),
)  # fmt: skip


def run(candidate: kit.DisplacementSolver, setting: kit.Setting) -> kit.Evidence:
    """Read the file and pull at what is in it."""
    mesh = read_mesh(FILE, unit=UNIT)
    asked = problem(mesh)
    length, height = mesh.points.max(axis=0)
    right = [[length, 0.5 * height]]
    elastic = reference_fem.solve_problem(asked, reference_fem.mesh_discretisation(mesh))
    springs = curved.spring_body(candidate, asked, float(length) / CELLS)
    far = springs.lattice.points[:, 0].argmax()
    longer = cases.Quantity(
        "patch from a file", "elongation", "m", TENSION / MODULUS * PATCH.size[0], SOURCE, NU
    )
    area = cases.Quantity("patch from a file", "area", "m²", PATCH.volume, SOURCE, NU)
    rows = [
        *cases.rows(area, "FEM Q1", (len(mesh.cells),), (mesh.volume,)),
        *cases.rows(longer, "FEM Q1", (len(mesh.cells),), (float(elastic.at(right)[0, 0]),)),
        *cases.rows(
            longer,
            models.method(curved.CUT, NU),
            (len(springs.lattice.cells),),
            (float(springs.displacement[far, 0]),),
        ),
    ]
    table = pd.DataFrame(rows)
    return kit.Evidence(
        tables={"from_file": table},
        tolerances=RULES,
        columns=kit.columns(__file__),
    )


def problem(mesh: kit.Mesh) -> kit.Problem:
    """The patch pulled along x, free to contract."""
    return kit.Problem(
        mesh,
        kit.Isotropic(E=MODULUS, nu=NU, thickness=THICKNESS),
        (
            kit.Support(mesh.side("left"), (0.0, None)),
            kit.Support(kit.Region((0.0, 0.0)), (None, 0.0)),
        ),
        (kit.Traction(mesh.side("right"), (TENSION, 0.0)),),
        name="patch from a file",
    )
