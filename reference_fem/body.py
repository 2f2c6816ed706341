"""From a `Problem` to finite elements: mesh of the box, supports, consistent loads, solution."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import skfem
from numpy.typing import ArrayLike

from msvalidate.problem import (
    Array,
    BodyForce,
    Domain,
    Field,
    Index,
    PointForce,
    Problem,
    ProblemError,
    SolverError,
    Traction,
    instance,
    place_name,
    prescribed,
    vectors_at,
)
from reference_fem.discretisation import Discretisation
from reference_fem.elasticity import solve_on


@dataclass(frozen=True, eq=False)
class Solution:
    """Displacement (n, d) in m at the nodes of a discretisation.

    Raises
    ------
    ProblemError
        If there is not one displacement a node.
    """

    body: Discretisation
    displacement: Array

    def __post_init__(self) -> None:
        instance("body", self.body, Discretisation)
        shape = getattr(self.displacement, "shape", ())
        if shape != self.body.points.shape:
            raise ProblemError(f"solution: shape {shape}; give an array {self.body.points.shape}")
        self.displacement.setflags(write=False)

    def at(self, points: ArrayLike) -> Array:
        """Displacement (p, d) in m at points (p, d) of the body.

        Raises
        ------
        ProblemError
            If a point lies outside the body.
        """
        return np.asarray(self.body.interpolation(points) @ self.displacement)


def solve_problem(problem: Problem, body: Discretisation) -> Solution:
    """Solve a problem on a discretisation of its domain, such as `box_discretisation` gives.

    Raises
    ------
    ProblemError
        If a support or load does not meet the mesh.
    SolverError
        If the solution fails its residual check.
    """
    _refuse_other_body(problem, body)
    held, displacement = prescribed(problem, body.points)
    with np.errstate(over="ignore", invalid="ignore"):  # the residual refuses what is infinite
        force = nodal_forces(problem, body)
    return Solution(body, solve_on(body, problem.material, held, displacement, force))


def _refuse_other_body(problem: Problem, body: Discretisation) -> None:
    instance("problem", problem, Problem)
    instance("body", body, Discretisation)
    domain = problem.domain
    if domain.dim != body.dim:
        raise ProblemError(f"{problem.name}: a {domain.dim}D {domain}, meshed in {body.dim}D")
    reached = np.array([body.points.min(axis=0), body.points.max(axis=0)])
    low, high = np.array(domain.span).T
    off = np.abs(reached - (low, high)).max()
    if off > domain.tolerance or abs(body.basis.dx.sum() - domain.volume) > 1e-9 * domain.volume:
        raise ProblemError(
            f"{problem.name}: the mesh spans {place_name(reached[0])} to {place_name(reached[1])} "
            f"m, the domain {place_name(low)} to {place_name(high)} m, a {domain}; mesh the "
            "problem's own domain"
        )


def nodal_forces(problem: Problem, body: Discretisation) -> Array:
    """Consistent nodal forces (n, d) in N of a problem's loads, thickness included.

    Raises
    ------
    ProblemError
        If a point force meets no node, or a loaded part does not end at cell edges.
    SolverError
        If cells in the plane are too thin to be integrated over.
    """
    force = np.zeros(body.points.shape)
    tolerance, thickness = problem.domain.tolerance, problem.material.thickness
    for load in problem.loads:
        if isinstance(load, PointForce):
            at = load.region.select(body.points, tolerance)
            if not at.any():
                raise ProblemError(
                    f"point force at {load.region}: no mesh node there; "
                    "choose cells that put one there"
                )
            force[at] += load.force
        elif isinstance(load, Traction):
            name = f"traction on {load.region}"
            facets = _loaded_facets(problem.domain, load, body)
            if body.dim == 3:
                force += _on_faces(name, load.traction, facets, body)
                continue
            force += thickness * _integrated(name, load.traction, _edges(name, body, facets), body)
        elif isinstance(load, BodyForce):
            order = 2 * body.element.degree + 2
            basis = skfem.Basis(body.basis.mesh, body.basis.elem, intorder=order)
            force += thickness * _integrated("body force", load.force, basis, body)
    return force


def _edges(name: str, body: Discretisation, facets: Index) -> skfem.FacetBasis:
    """Basis on the loaded edges.

    The library finds their points inside quadrilaterals by iterating to an absolute 1e-12 of the
    cell, which coordinates do not resolve in cells that are tiny beside their distance from the
    origin. In triangles it need not iterate.
    """
    order = 2 * body.element.degree + 2
    try:
        return skfem.FacetBasis(body.basis.mesh, body.basis.elem, facets=facets, intorder=order)
    except Exception as error:  # the library raises no narrower class
        smallest = float(np.ptp(body.points[body.cells], axis=1).min())
        raise SolverError(
            f"{name}: the points of its edges cannot be found in slanted cells as small as "
            f"{smallest:.2g} m; take less grading, fewer cells, or triangles (P1 or P2)"
        ) from error


def _loaded_facets(domain: Domain, load: Traction, body: Discretisation) -> Index:
    mesh = body.basis.mesh
    inside = load.region.select(mesh.p.T, domain.tolerance)
    boundary = mesh.boundary_facets()
    facets = boundary[inside[mesh.facets[:, boundary]].all(axis=0)]
    if body.dim == 2:
        ends = mesh.p[:, mesh.facets[:, facets]]
        covered = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=0).sum()
    else:  # half the product of the diagonals, or of two sides of a triangle
        corners = mesh.p.T[mesh.facets[:, facets]]
        product = np.cross(corners[2] - corners[0], corners[-1] - corners[1])
        covered = np.linalg.norm(product, axis=1).sum() / 2
    wanted = load.region.measure(domain.span)
    if abs(covered - wanted) > 1e-9 * wanted:
        sides = "edges" if body.dim == 2 else "faces"
        raise ProblemError(
            f"traction on {load.region}: covers no whole number of mesh {sides}; "
            f"choose cells whose {sides} end where the loaded part ends"
        )
    return np.asarray(facets)


def _on_faces(
    name: str, vector: tuple[float, ...] | Field, facets: Index, body: Discretisation
) -> Array:
    """∫ φ_i f over faces, as (n, 3) by node: the shape functions there are those of the face.

    The library would look for the points of the faces in the cells, as on edges, and not find them
    in cells that are graded.
    """
    mesh = body.basis.mesh
    vertices = mesh.facets[:, facets].T
    face = skfem.ElementQuad1() if vertices.shape[1] == 4 else skfem.ElementTriP1()
    X, weights = skfem.quadrature.get_quadrature(face, 2 * body.element.degree + 2)
    shapes = [face.lbasis(X, i) for i in range(vertices.shape[1])]
    value, slope = (
        np.array([np.broadcast_to(f[k], (*n, len(weights))) for f in shapes])
        for k, n in ((0, ()), (1, (2,)))
    )
    corners = mesh.p.T[vertices]
    x = np.einsum("kq,fkd->fqd", value, corners)
    along, across = np.einsum("keq,fkd->efqd", slope, corners)
    area = np.linalg.norm(np.cross(along, across), axis=2) * weights
    traction = vectors_at(name, vector, x.reshape(-1, 3)).reshape(x.shape)
    force = np.zeros(body.points.shape)
    nodes = body.node[body.basis.nodal_dofs[0, vertices]]
    np.add.at(force, nodes, np.einsum("kq,fq,fqd->fkd", value, area, traction))
    return force


def _integrated(
    name: str, vector: tuple[float, ...] | Field, basis: skfem.AbstractBasis, body: Discretisation
) -> Array:
    """∫ φ_i f, as (n, d) by node, of a vector or a field of points."""
    if not callable(vector):  # one integral serves every component of a constant
        share = np.zeros(len(body.points))
        share[body.node] = skfem.LinearForm(lambda v, _: v).assemble(basis)
        return np.outer(share, vector)
    x = np.asarray(basis.global_coordinates())
    values = vectors_at(name, vector, x.reshape(body.dim, -1).T).T.reshape(x.shape)
    force = np.zeros(body.points.shape)
    for axis in range(body.dim):
        form = skfem.LinearForm(lambda v, w: w.f * v)
        force[body.node, axis] = form.assemble(basis, f=values[axis])
    return force
