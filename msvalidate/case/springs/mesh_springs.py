"""Springs on a part's own mesh, which are finite elements node for node, beside the lattice's.

Springs of no rest length under tension, on all edges of its cells, with cells under pressure (route
"neo-Hookean" of `springs.constants.routes`): what curves and supports cost a cut lattice they do
not.
"""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np
import pandas as pd

from msvalidate.case.file.case import EDGE_ROUTES, MESH_EDGES, Case, spacing_of
from msvalidate.case.file.part_mesh import count_one_cell_thick, spacing_of_points
from msvalidate.case.springs.lattice_springs import (
    SpringAnswer,
    displacements_at,
    extrapolate,
    solve_finer,
    solve_springs,
)
from msvalidate.linear_algebra.norms import max_length
from msvalidate.problem import Isotropic, Mesh, Problem, ProblemError, SolverError
from msvalidate.problem.records import dataclass, replace
from msvalidate.springs.constants.stiffness import NEAR_RATIO, springs_ratio
from reference_fem.converged import Reference, is_nearly_incompressible


@dataclass(frozen=True, eq=False)
class MeshSprings:
    """Springs on meshes from coarse to fine beside elasticity, at the points of the first.

    Parameters
    ----------
    answers
        At rest on the mesh whose points are nearest in number to the lattice's, then on meshes
        twice and four times as fine, all cut on the file's own curves.
    reference
        Elasticity at the first one's points.
    """

    answers: tuple[SpringAnswer, ...]
    reference: Reference

    @cached_property
    def table(self) -> pd.DataFrame:
        """A row a mesh."""
        points, wanted = self.reference.points, self.reference.displacement.value
        size = max_length(wanted) or 1.0
        rows = [
            {
                "spacing": one.spacing,
                "points": len(one.lattice.points),
                "springs": len(one.lattice.springs),
                "pushing": int((one.network.stiffness < 0).sum()),
                "cells": len(one.lattice.cells),
                "difference": max_length(one.at(points) - wanted) / size,
                "uncertainty": self.reference.error,
                "seconds": one.seconds,
            }
            for one in self.answers
        ]
        return pd.DataFrame(rows)

    @cached_property
    def order(self) -> float:
        """Order of convergence of the difference; NaN unless three meshes show one."""
        values, _ = displacements_at(self.answers, self.reference.points)
        return extrapolate(self.answers, values).order


def one_cell_deflection(law: Isotropic) -> float:
    """Deflection of a beam of square or cubic cells, one thick, relative to elasticity's.

    One such cell is bent by its hourglass mode, u = -xz, whose mean J is constant: the mode has
    the energy of shear alone, 2μ in place of the modulus. So a beam in 2D bends E'/(2μ) times as
    far, E' = E in plane stress and E/(1 - nu²) in plane strain. A second hourglass mode, v = yz/2,
    makes a 3D beam as wide as thick softer, E/(1.5 μ). A wide plate has 1/(1 - nu), which is less.
    """
    if law.state == "solid":
        return 4 / 3 * (1 + law.nu)
    return 1 + law.nu if law.state == "plane_stress" else 1 / (1 - law.nu)


def mesh_warning(problem: Problem) -> tuple[str, str]:
    """Fault of the linear elements of a problem's mesh, and its remedy; "" if none is known."""
    mesh = problem.domain
    if not isinstance(mesh, Mesh):
        return "", ""
    remedy = 'take cells with four or eight corners, or [springs] on = "lattice"'
    if mesh.kind.simplex and is_nearly_incompressible(problem):
        return "Linear triangles and tetrahedra lock near ratio 1/2", remedy
    if mesh.kind.simplex and mesh.dim == 3:
        return "Linear tetrahedra are too stiff in bending", remedy
    thin = count_one_cell_thick(mesh)
    times = [one_cell_deflection(law) for law in problem.materials if isinstance(law, Isotropic)]
    if not times or not thin:
        return "", ""
    cause = (
        f"{thin:,} of {len(mesh.cells):,} cells are the only one through their wall: its bending "
        f"is their hourglass mode, up to {max(times):.2f} times too soft if "
        "they are squares or cubes, too stiff if they are several times as long as thick"
    )
    return cause, "take a mesh with two cells or more through each wall"


def springs_alone(case: Case, reference: Reference) -> float:
    """Difference of springs alone on the edges of a part's own mesh from elasticity.

    For engines without cells. The springs have their own ratio, which is within `NEAR_RATIO` of
    that of the material.

    Returns
    -------
    float
        Largest difference relative to the largest displacement at the points of the mesh. NaN
        without a mesh, with several materials, at another ratio, or if these springs have no
        equilibrium.
    """
    problem, law = case.problem, case.problem.material
    if not isinstance(problem.domain, Mesh) or not isinstance(law, Isotropic) or problem.zones:
        return math.nan
    nu = springs_ratio(law)
    if abs(law.nu - nu) > NEAR_RATIO or problem.contacts or case.geometry == "nonlinear":
        return math.nan
    other = replace(
        _on_edges(case, EDGE_ROUTES[0], problem.domain.mean_edge),
        problem=replace(problem, material=replace(law, nu=nu)),
    )
    try:
        answer = solve_springs(other, spacing_of(other))
        points = np.asarray(answer.lattice.points)
        exact = replace(reference, points=points).displacement.value
    except (ProblemError, SolverError):
        return math.nan
    return max_length(answer.at(points) - exact) / (max_length(exact) or 1.0)


def _on_edges(case: Case, route: str, spacing: float) -> Case:
    """The case with springs on the edges of its mesh, at a spacing (m)."""
    return replace(
        case, lattice=MESH_EDGES, route=route, constants=None, volume=0.0, spacing=spacing,
        cells=None, fracture=None,
    )  # fmt: skip


def compare_on_mesh(case: Case, reference: Reference, count: int) -> tuple[MeshSprings | None, str]:
    """Springs on a case's own mesh of about so many points, and why there are none.

    None, with no reason, of a body without a mesh or of a case whose springs are these.
    """
    mesh = case.problem.domain
    if not isinstance(mesh, Mesh) or case.are_elements:
        return None, ""
    if case.problem.contacts or case.geometry == "nonlinear":
        return None, "springs on the mesh: of loads to first order; for others take on = 'mesh'"
    other = _on_edges(case, EDGE_ROUTES[1], spacing_of_points(mesh, count))
    try:
        answers = solve_finer(other)
        at = replace(reference, points=np.asarray(answers[0].lattice.points))
        at.displacement  # noqa: B018  refuses points outside here
    except (ProblemError, SolverError) as error:
        return None, f"springs on the mesh: not solved: {error}"
    return MeshSprings(answers, at), ""
