"""Bent blocks: held at one side and sheared at the other, by springs and by elements."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

import reference_fem
from msvalidate import kit
from msvalidate.problem.material import State
from msvalidate.springs.bodies.calibrate import calibrate_material
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.lattice import fill, patterns
from msvalidate.springs.network import Network
from msvalidate.springs.network.laws.volumes import Volumes
from reference_fem.body import nodal_forces
from reference_fem.mixed import solve_mixed_on

from .. import elastic, loading

BOX = {2: (2.0, 1.0), 3: (1.0, 1.0, 1.0)}
"""Edges (m): of the plane body twice as long as high, so that it bends."""
MIXED = {2: "Q2", 3: "H2"}
ELEMENTS = {2: ("Q1", "P1"), 3: ("H1", "T1")}
"""Of linear displacement."""
LATTICES = {2: ("square",), 3: ("cubic18", "cubic26")}
HALVES = "square, halves"
SPRINGS = [*LATTICES[2], *LATTICES[3]]
RATIOS: dict[State, tuple[float, ...]] = {
    "plane_strain": (0.3, 0.45, 0.49, 0.499, 0.4999),
    "plane_stress": (0.45, 0.49, 0.499),
    "solid": (0.45, 0.49, 0.499),
}


class Bent(NamedTuple):
    """A bent block: of one material, by one model, of one size."""

    state: State
    nu: float
    model: str
    cells: int


def bend_block(state: State, nu: float) -> kit.Problem:
    """A block held at its left side and loaded along y at its right one: 1 Pa each."""
    box = kit.Box(BOX[3 if state == "solid" else 2])
    return loading.clamped(box, kit.Isotropic(1.0, nu, state), "shear", 1.0)


def box_of(problem: kit.Problem) -> kit.Box:
    """The box of a problem that is one of a box."""
    if not isinstance(problem.domain, kit.Box):
        raise kit.ProblemError(f"{problem.name}: a {problem.domain}; give a box")
    return problem.domain


def counts(box: kit.Box, cells: int) -> tuple[int, ...]:
    """Cells along each axis, so many through the height."""
    return tuple(round(cells * edge / box.size[1]) for edge in box.size)


def reference(
    meshes: Mapping[int, tuple[int, ...]], kind: tuple[State, float]
) -> elastic.Reference:
    """Deflection of the elastic body on three meshes, and extrapolated."""
    problem = bend_block(*kind)
    d = problem.domain.dim
    found = []
    for cells in meshes[d]:
        mesh = reference_fem.box_discretisation(
            box_of(problem), counts(box_of(problem), cells), MIXED[d], elastic.GRADING[d]
        )
        force = nodal_forces(problem, mesh)
        if kind[0] == "plane_stress":
            move = reference_fem.solve_problem(problem, mesh).displacement
        else:
            held, moved = kit.prescribed_displacements(problem, mesh.points)
            move, _ = solve_mixed_on(mesh, problem.material, held, moved, force)
        found.append(float((force * move).sum() / force.sum()))
    return elastic.extrapolate(*found)


def deflection(candidate: kit.DisplacementSolver, block: Bent) -> float:
    """Mean displacement (m) of the loaded side along the load."""
    problem = bend_block(block.state, block.nu)
    box = box_of(problem)
    cells = counts(box, block.cells)
    if block.model in ELEMENTS[box.dim]:
        mesh = reference_fem.box_discretisation(box, cells, block.model)
        force = nodal_forces(problem, mesh)
        # Elements that lock are what is looked at.
        move = reference_fem.solve_problem(problem, mesh, allow_locked=True).displacement
    else:
        network = springs_of(problem, block.model, cells)
        force, move = network.force, candidate(problem, network, "linear")
    return float((force * move).sum() / force.sum())


def springs_of(problem: kit.Problem, model: str, cells: tuple[int, ...]) -> Network:
    """Network of a model: its cells have a volume each, or their halves have."""
    box, material = box_of(problem), problem.material
    if not isinstance(material, kit.Isotropic):
        raise kit.ProblemError(f"{problem.name}: an anisotropic material; give an isotropic one")
    lattice = fill(getattr(patterns, model.split(",", maxsplit=1)[0])(), box, cells)
    network = lattice_network(problem, lattice, calibrate_material(material, lattice))
    return split(network) if model == HALVES else network


def split(network: Network) -> Network:
    """The network with two triangles, of a volume each, for every quadrilateral."""
    own = network.volumes
    if own is None:
        return network
    triangles = own.cells[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3)
    return replace(network, volumes=Volumes(own.points, triangles, np.repeat(own.stiffness, 2)))
