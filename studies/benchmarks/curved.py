"""Curved outlines: bodies solved by quadratic elements and by lattices cut to the outline.

Springs are cells of the square lattice, cut by the outline (`springs.lattice.cut`), with an
energy of the cells' volumes where nu is not 1/3. A network's stress at its outline is that of a
polynomial through the displacements near by (`springs.statics.stress.fitted_stress`): a quadratic
one, whose own error has order 2, and a quartic one, which leaves the network's error.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

import reference_fem
from msvalidate import kit
from msvalidate.springs.bodies.calibrate import calibrate_material
from msvalidate.springs.bodies.cut_network import cut_network
from msvalidate.springs.constants.stiffness import CAUCHY
from msvalidate.springs.lattice import Pattern, patterns
from msvalidate.springs.lattice.cut import CutLattice, cut_lattice
from msvalidate.springs.statics.stress import fitted_stress, interior_points

from . import models
from .shapes import PatchMesh

FITS = {"quadratic": (2, 24), "quartic": (4, 60)}
"""Degree of the polynomial that stresses of networks are read off, and points: four a coefficient.
From the side of a body they reach 6 and 10 cells deep."""
SPRINGS_ALONE = CAUCHY[2]
"""Poisson's ratio of springs alone, in plane stress."""
CUT = "square, cut"
"""What tables call the lattice."""


@dataclass(frozen=True, eq=False)
class SpringBody:
    """Displacements (n, d) in m at the points of a cut lattice, and the tensor (Pa) it stands for.

    `whole`: the points all of whose cells are inside the body.
    """

    lattice: CutLattice
    displacement: kit.Array
    tensor: kit.Array

    def stress(self, places: kit.Array, fit: str) -> kit.Array:
        """Stress (p, 3) or (p, 6) in Pa at places (p, d)."""
        whole = interior_points(self.lattice)
        points, move = self.lattice.points[whole], self.displacement[whole]
        degree, count = FITS[fit]
        return fitted_stress(points, move, places, self.tensor, degree=degree, count=count)


def method(nu: float, fit: str) -> str:
    """What tables call the network that stands for plane stress at this ratio, read by a fit."""
    return f"{models.method(CUT, nu)}, {fit} fit"


def elastic(problem: kit.Problem) -> reference_fem.Solution:
    """Finite elements on the problem's own mesh."""
    mesh = problem.domain
    if not isinstance(mesh, kit.Mesh):
        raise TypeError(f"{problem.name}: give a problem on a mesh")
    return reference_fem.solve_problem(problem, reference_fem.mesh_discretisation(mesh))


def spring_body(
    candidate: kit.DisplacementSolver,
    problem: kit.Problem,
    spacing: float,
    pattern: Pattern | None = None,
) -> SpringBody:
    """The candidate's answer on a lattice cut to the body, its lines along both axes."""
    kind = pattern or patterns.square()
    lattice = cut_lattice(kind, problem.domain, spacing)
    network, tensor = spring_model(problem, lattice, kind)
    return SpringBody(lattice, candidate(problem, network, "linear"), tensor)


def spring_model(
    problem: kit.Problem, lattice: CutLattice, kind: Pattern
) -> tuple[kit.Network, kit.Array]:
    """Network for the problem's isotropic material, and its tensor in Pa."""
    material = problem.material
    if not isinstance(material, kit.Isotropic):
        raise TypeError(f"{problem.name}: give an isotropic material")
    made = calibrate_material(material, kind, spacing=lattice.spacing)
    network = cut_network(problem, lattice, made.constants, volume=made.volume)
    return network, made.tensor / material.thickness


def quarter_supports(mesh: kit.Mesh) -> tuple[kit.Support, ...]:
    """Mirror symmetry about the sides "bottom" and "left", whatever the axes."""
    free: tuple[None, ...] = (None,) * (mesh.dim - 2)
    return (
        kit.Support(mesh.side("bottom"), (None, 0.0, *free)),
        kit.Support(mesh.side("left"), (0.0, None, *free)),
    )


def mises(stress: kit.Array) -> kit.Array:
    """Von Mises' stress (p,) of plane stresses (p, 3)."""
    x, y, shear = stress.T
    return np.asarray(np.sqrt(x**2 - x * y + y**2 + 3 * shear**2))


def field(places: kit.Array, of_elements: kit.Array, of_springs: kit.Array) -> pd.DataFrame:
    """Von Mises stress at places (p, 2) of stresses (p, 3) in Pa, and what springs are off (%)."""
    fem, springs = mises(of_elements), mises(of_springs)
    table = {"x": places[:, 0], "y": places[:, 1], "mises": fem}
    return pd.DataFrame(table | {"off": 100 * (springs - fem) / fem.max()})


def mesh_field(
    candidate: kit.DisplacementSolver,
    meshes: Callable[[int], PatchMesh],
    problem: Callable[[kit.Mesh], kit.Problem],
    sizes: tuple[int, int, float],
) -> pd.DataFrame:
    """`field` at the nodes of a mesh.

    `sizes`: n of the mesh drawn, of the mesh solved, a multiple of it so that every place is in the
    body, and the springs' spacing (m).
    """
    drawn, solved, spacing = sizes
    places = meshes(drawn).points
    fine = problem(meshes(solved).mesh)
    springs = spring_body(candidate, fine, spacing).stress(places, "quartic")
    return field(places, np.asarray(elastic(fine).stress(places)), springs)


def pictures(name: str, body: str) -> dict[str, Any]:
    """Figures of a `field`: the stress of elements, and by how much that of springs is off."""
    shown = partial(kit.field, name, at=("x", "y"), size=(4.4, 4.0))
    return {
        name: shown(
            title=f"{body}: von Mises stress by elements",
            value="mises", label="von Mises stress (Pa)",
        ),
        f"{name}_off": shown(
            title=f"{body}: springs less elements",
            value="off", label="von Mises stress over the largest (%)",
        ),
    }  # fmt: skip
