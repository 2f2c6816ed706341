# SPDX-License-Identifier: MIT
"""Controls of the protocol itself: elements of high order beside elasticity, bonds beside springs.

A plane case is put to a program of bodies in space as a slab: one cell thick, between rollers on
both faces, which is plane strain and nothing else. So bodies with a clamped end are asked for whose
elasticity is known to some 1e-5, where bodies in space are known to some 1e-3.
"""

from __future__ import annotations

import itertools
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.spatial import KDTree

from msvalidate.case.file.building import read_case
from msvalidate.case.file.case import Case
from msvalidate.linear_algebra.norms import max_length
from msvalidate.problem import (
    Array,
    Box,
    Isotropic,
    Mesh,
    Problem,
    ProblemError,
    Support,
    Traction,
)
from msvalidate.simulators.exchange.export import CELLS, export_case
from msvalidate.simulators.exchange.protocol import Answer, Request, ask
from msvalidate_check import elastic_case
from reference_fem.mesh.boxes import lines_discretisation
from reference_fem.mesh.elements import of_shape
from simulators.environments import ROOT, adapter_of, pins, save

HALVINGS = {2: 6, 3: 3}
"""Of the cells of 1/8 m at all sides, by axes of the case: fields are singular at clamped corners,
and where a side that is sheared meets one that is not."""
ORDERS = (1, 3, 4)
"""Of elements; the first shows that the comparison sees what is not converged."""
SPACE_ORDERS = (1, 3)
SLABS = ("block_pull", "block_shear", "clamped_pull", "clamped_shear", "cantilever_load",
         "cantilever_gravity")  # fmt: skip
SPACE = ("block_pull_space", "block_shear_space", "cantilever_load_space")
RATIOS = (0.3, 0.45)
SPACE_RATIOS = (0.3,)
"""At 0.45 the bodies in space are known to 0.2 % alone."""
COARSEST = 0.125
"""Side (m) of the cells of the frozen set's coarsest meshes, whose nodes the answer is known at."""
COARSE = ("quad4", "hex8")
"""Those meshes in the plane and in space."""
STRAINS = (1e-3, 0.1)
E, DENSITY = 1e7, 1000.0
LATTICES = {
    "square": (Box((0.4, 0.2)), Isotropic(E, 1 / 3, "plane_stress", DENSITY), 8),
    "cubic18": (Box((0.4, 0.2, 0.2)), Isotropic(E, 0.25, "solid", DENSITY), 4),
}
"""Lattice -> a body of the one ratio that springs alone can be, and cells across it."""
DIGITS = 3


def record_elements() -> None:
    """NGSolve's displacements beside the frozen set's, by order: data/held/elements.json."""
    simulator = adapter_of("ngsolve.py", "ngsolve")
    rows: list[dict[str, Any]] = []
    about: dict[str, Any] = {}
    plane = itertools.product([f"{body}_plane_strain" for body in SLABS], RATIOS, ORDERS)
    space = itertools.product(SPACE, SPACE_RATIOS, SPACE_ORDERS)
    for name, nu, order in (*plane, *space):
        asked, places, wanted, known = body_of(name, nu, order)
        answer = ask(simulator, asked)
        about = dict(answer.about)
        error = max_length(moved(answer)[places, : wanted.shape[1]] - wanted)
        rows.append(
            {
                "case": name,
                "nu": nu,
                "order": order,
                "cells": len(asked.mesh.cells),
                "error": _short(error / max_length(wanted)),
                "known": _short(known),
            }
        )
        print(rows[-1], flush=True)
    program = {key: about[key] for key in ("simulator", "version", "law")}
    save("held/elements.json", program | pins("ngsolve.py", "ngsolve") | {"bodies": rows})


def body_of(name: str, nu: float, order: int) -> tuple[Request, Array, Array, float]:
    """A frozen case as a body in space for elements of an order.

    Returns
    -------
    tuple
        The request; nodes (p,) of it where the answer is known; displacements (p, d) there, m; what
        those are known to, over the largest.
    """
    case = elastic_case(name, nu, mesh=COARSE[name.endswith("_space")])
    source = read_case(ROOT / "cases" / "v1" / name / "case.toml")
    material = replace(source.problem.material, nu=nu)
    problem = replace(source.problem, material=material, domain=graded(source.problem.domain))
    asked = export_case(replace(source, problem=problem), settings={"order": order})
    places = case.points[case.named]
    far, near = KDTree(asked.mesh.points).query(places)
    if far.max() > 1e-12:
        raise ProblemError(f"{name}: no node at {places[far.argmax()]}; take more cells")
    return slab(asked) if asked.mesh.dim == 2 else asked, near, case.wanted, case.uncertainty


def graded(box: Box) -> Mesh:
    """A box of cells of 1/8 m, those at its sides halved again and again towards these."""
    parts = 2.0 ** -np.arange(HALVINGS[box.dim] + 1) * COARSEST
    lines = []
    for side in box.size:
        whole = np.arange(round(side / COARSEST) + 1) * COARSEST
        lines.append(np.unique(np.concatenate([whole, parts, side - parts])))
    kind = CELLS[box.dim][1]
    body = lines_discretisation(tuple(lines), of_shape(kind).name)
    return Mesh(body.points, body.cells, kind)


def slab(plane: Request) -> Request:
    """A request of quads in plane strain as one layer of hexahedra between rollers.

    Nodes of the lower face come first, in their own order, then those of the upper.
    """
    if plane.material.state != "plane_strain" or plane.mesh.kind.name != "quad":
        raise ProblemError(
            f"slab: {plane.mesh.kind.name} in {plane.material.state}; give quad in plane_strain"
        )
    n, thickness = len(plane.mesh.points), plane.material.thickness
    low, high = np.zeros((n, 1)), np.full((n, 1), thickness)
    points = np.block([[plane.mesh.points, low], [plane.mesh.points, high]])
    cells = np.hstack([plane.mesh.cells, plane.mesh.cells + n])
    roller = np.ones((2 * n, 1), dtype=bool)
    return replace(
        plane,
        mesh=Mesh(points, cells, "hexahedron"),
        material=replace(plane.material, state="solid", thickness=1.0),
        mass=np.tile(plane.mass / 2, 2),
        gravity=np.append(plane.gravity, 0.0),
        force=_twice(plane.force / 2, low),
        held=np.hstack([np.tile(plane.held, (2, 1)), roller]),
        value=_twice(plane.value, low),
    )


def _twice(rows: Array, third: Array) -> Array:
    return np.tile(np.hstack([rows, third]), (2, 1))


def record_springs() -> None:
    """Bonds of LAMMPS beside our springs, both at rest: data/held/springs.json."""
    bonds, springs = adapter_of("lammps.py", "lammps"), adapter_of("springs.py", "")
    rows: list[dict[str, Any]] = []
    versions: dict[str, str] = {}
    for lattice in LATTICES:
        for strain in STRAINS:
            asked = pulled_lattice(lattice, strain)
            theirs = ask(bonds, asked)
            ours = ask(springs, replace(asked, settings={"geometry": "nonlinear"}))
            linear = ask(springs, replace(asked, settings={"geometry": "linear"}))
            size = max_length(moved(ours))
            load = float(np.abs(asked.force).max())
            versions = {a.about["simulator"]: a.about["version"] for a in (theirs, ours)}
            rows.append(
                {
                    "lattice": lattice,
                    "strain": strain,
                    "points": len(asked.mesh.points),
                    "springs": 0 if asked.springs is None else len(asked.springs.ends),
                    "moved": _short(size),
                    "difference": _short(max_length(moved(theirs) - moved(ours)) / size),
                    "linear": _short(max_length(moved(theirs) - moved(linear)) / size),
                    "residual": _short(theirs.about["at_rest"]["residual"] / load),
                }
            )
            print(rows[-1], flush=True)
    save("held/springs.json", {"versions": versions} | pins("lammps.py", "lammps")
         | {"bodies": rows})  # fmt: skip


def pulled_lattice(lattice: str, strain: float) -> Request:
    """A lattice clamped at its left, pulled at its right by E times a strain, half as much sheared.

    Points beside the end are stretched by about that strain.
    """
    box, material, cells = LATTICES[lattice]
    pull = (strain * E, strain * E / 2, *[0.0] * (material.dim - 2))
    problem = Problem(
        box,
        material,
        (Support(box.side("left"), (0.0,) * material.dim),),
        (Traction(box.side("right"), pull),),
        f"{lattice}, pulled and sheared",
    )
    return export_case(Case(problem, lattice=lattice), cells=cells, springs=True)


def moved(answer: Answer) -> Array:
    """Displacement (n, d) of an answer of rest, m."""
    assert answer.displacement is not None  # noqa: S101  as `ask` sees to
    return answer.displacement


def _short(value: float) -> float:
    return float(f"{value:.{DIGITS - 1}e}")
