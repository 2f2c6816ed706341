"""Small displacements of a bonded slab under Maxwell forces."""

from __future__ import annotations

import numpy as np

from msvalidate.problem import Array, Isotropic
from msvalidate.problem.checks import finite, require_type
from reference_fem.body import Solution
from reference_fem.elasticity import make_solver
from reference_fem.electric.mesh import SlabMesh


def respond(mesh: SlabMesh, forces: Array, material: Isotropic) -> Solution:
    """Linear elastic response of the slab, bonded to a rigid base, to forces per depth.

    Parameters
    ----------
    mesh
        Its slab is the body; all of the bottom is held.
    forces
        (m, 2) as `Charged.forces` gives them (N/m).
    material
        Of the slab; its thickness is the depth.

    Raises
    ------
    ProblemError
        If the forces are of another shape, or nu = 1/2 in plane strain.
    SolverError
        If the solution fails its residual check.
    """
    require_type("mesh", mesh, SlabMesh)
    require_type("material", material, Isotropic)
    solid = mesh.solid
    held = np.repeat(mesh.base[:, None], 2, axis=1)
    ready = make_solver(solid, material, held)
    force = material.thickness * finite("forces", forces)
    moved, solved = ready.solve(np.zeros(solid.points.shape), force)
    return Solution(solid, moved, material, solved=solved)
