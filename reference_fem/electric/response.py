"""What Maxwell's forces do to a slab that is bonded to a rigid base, for small displacements."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from msvalidate.problem import Array, Isotropic, ProblemError
from msvalidate.problem.checks import finite, finite_coordinates, require_type
from reference_fem.body import Solution
from reference_fem.elasticity import make_solver
from reference_fem.electric.charges import Far, solve_charges
from reference_fem.electric.mesh import GRADING, SlabMesh, slab_mesh
from reference_fem.electric.slab import Slab
from reference_fem.refinement import HIGHEST_ORDER, Estimate, on_three_meshes, richardson


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


def surface_profile(
    slab: Slab,
    material: Isotropic,
    x: ArrayLike,
    layers: int,
    *,
    element: str = "Q2",
    grading: float = GRADING,
    reach: float | None = None,
) -> Estimate:
    """Linear displacement of the top at the slab's voltages, and the reference's own error.

    At an electrode's edge a tip force acts on a point, under which the displacement is infinite:
    values there are the mesh's own, and their uncertainty says so. The uncertainty is what three
    meshes show, and what the natural and the floating far boundary differ by.

    Parameters
    ----------
    slab, material
        The question.
    x
        (p,) places along the top (m).
    layers
        Of the finest of three meshes, a multiple of 8: the others have half and a quarter.
    element, grading, reach
        As for `slab_mesh`.

    Returns
    -------
    Estimate
        Of 2p values (m): x components of all places, then y components.

    Raises
    ------
    ProblemError
        If an argument is out of range.
    """
    require_type("slab", slab, Slab)
    along = finite_coordinates("places along the top", x)
    if along.ndim != 1 or not len(along) or (along < 0).any() or (along > slab.length).any():
        raise ProblemError(
            f"places along the top: shape {along.shape}; give (p,) from 0 to {slab.length:g} m"
        )
    top = np.column_stack([along, np.full(len(along), slab.height)])

    def profile(n: int, far: Far = "natural") -> Array:
        mesh = slab_mesh(slab, n, element=element, grading=grading, reach=reach)
        return respond(mesh, solve_charges(mesh, far=far).forces, material).at(top).T.ravel()

    estimate = richardson(*on_three_meshes(profile, layers), layers, HIGHEST_ORDER)
    coarsest = layers // 4
    beyond = np.abs(profile(coarsest, "floating") - profile(coarsest, "natural"))
    return replace(estimate, uncertainty=estimate.uncertainty + beyond)
