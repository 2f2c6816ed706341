"""From a `Problem` to finite elements: mesh of the box, supports, consistent loads, solution."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import skfem
from numpy.typing import ArrayLike

from msvalidate.problem import (
    Array,
    BodyForce,
    Box,
    Field,
    Index,
    PointForce,
    Problem,
    ProblemError,
    Traction,
    place_name,
    positive,
    prescribed,
    vectors_at,
    whole,
)
from reference_fem.discretisation import ELEMENTS, Discretisation, discretise
from reference_fem.elasticity import solve_on


@dataclass(frozen=True, eq=False)
class Solution:
    """Displacement (n, d) in m at the nodes of a discretisation."""

    body: Discretisation
    displacement: Array

    def __post_init__(self) -> None:
        self.displacement.setflags(write=False)

    def at(self, points: ArrayLike) -> Array:
        """Displacement (p, d) in m at points (p, d) of the body."""
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
    force = nodal_forces(problem, body)
    return Solution(body, solve_on(body, problem.material, held, displacement, force))


def _refuse_other_body(problem: Problem, body: Discretisation) -> None:
    box = problem.domain
    if box.dim != body.dim:
        raise ProblemError(f"{problem.name}: a {box.dim}D box, meshed in {body.dim}D")
    low, high = body.points.min(axis=0), body.points.max(axis=0)
    off = max(np.abs(low).max(), np.abs(high - box.size).max())
    if off > box.tolerance or abs(body.basis.dx.sum() - box.volume) > 1e-9 * box.volume:
        raise ProblemError(
            f"{problem.name}: the mesh spans {place_name(low)} to {place_name(high)} m, the box "
            f"(0, 0) to {place_name(np.array(box.size))} m; mesh the problem's own domain"
        )


def box_discretisation(
    box: Box,
    cells: int | tuple[int, int],
    element: str = "Q2",
    grading: float = 1.0,
    towards: Literal["both", "high"] = "both",
) -> Discretisation:
    """Mesh of a plane box.

    Parameters
    ----------
    box
        The domain.
    cells
        Number of quadrilaterals along x and y (one number serves both); P1 and P2 cut each in two.
    element
        "Q1", "Q2", "P1" or "P2".
    grading
        1 spaces the lines evenly; g > 1 draws them to both ends of each axis as s^g, towards the
        corners, where clamped bodies have singular stress.
    towards
        "both" ends of each axis, or the "high" end alone: the quarter of a symmetric body.

    Raises
    ------
    ProblemError
        If an argument is out of range.
    """
    pair = cells if isinstance(cells, tuple) else (cells, cells)
    if box.dim != 2 or element not in tuple(ELEMENTS) or len(pair) != box.dim:
        raise ProblemError(
            f"mesh: {element} with {cells} cells in a {box.dim}D box; give two counts, a plane box "
            f"and one of {', '.join(ELEMENTS)}"
        )
    counts = [whole("mesh cells", n, 1) for n in pair]
    if towards not in ("both", "high"):
        raise ProblemError(f"mesh grading towards {towards!r}; choose both or high")
    if positive("mesh grading", grading) < 1:
        raise ProblemError(f"mesh grading: {grading}; it must be 1 or more")
    kind = ELEMENTS[element]
    lines = [
        length * _subdivided(_graded(n, grading, towards), kind.degree)
        for length, n in zip(box.size, counts, strict=True)
    ]
    closest = min(float(np.diff(line).min()) for line in lines)
    if closest <= 4 * box.tolerance:
        raise ProblemError(
            f"mesh grading: {grading} with {cells} cells puts lines {closest:.2g} m apart, nearer "
            f"than two places are told apart ({box.tolerance:.2g} m); take less grading or cells"
        )
    y, x = np.meshgrid(lines[1], lines[0], indexing="ij")
    number = np.arange(x.size).reshape(x.shape)
    cut = _triangles if kind.corners == 3 else _quadrilaterals
    return discretise(np.column_stack([x.ravel(), y.ravel()]), cut(number, kind.degree), element)


def nodal_forces(problem: Problem, body: Discretisation) -> Array:
    """Consistent nodal forces (n, d) in N of a problem's loads, thickness included.

    Raises
    ------
    ProblemError
        If a point force meets no node, or a loaded part does not end at cell edges.
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
            order = 2 * body.element.degree + 2
            basis = skfem.FacetBasis(
                body.basis.mesh, body.basis.elem, facets=facets, intorder=order
            )
            force += thickness * _integrated(name, load.traction, basis, body)
        elif isinstance(load, BodyForce):
            order = 2 * body.element.degree + 2
            basis = skfem.Basis(body.basis.mesh, body.basis.elem, intorder=order)
            force += thickness * _integrated("body force", load.force, basis, body)
    return force


def _loaded_facets(box: Box, load: Traction, body: Discretisation) -> Index:
    mesh = body.basis.mesh
    inside = load.region.select(mesh.p.T, box.tolerance)
    boundary = mesh.boundary_facets()
    facets = boundary[inside[mesh.facets[:, boundary]].all(axis=0)]
    ends = mesh.p[:, mesh.facets[:, facets]]
    covered = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=0).sum()
    bounds = np.array(box.bounds(load.region))
    wanted = np.delete(bounds[:, 1] - bounds[:, 0], load.region.normal_axes).prod()
    if abs(covered - wanted) > 1e-9 * wanted:
        raise ProblemError(
            f"traction on {load.region}: covers no whole number of mesh edges; "
            "choose cells whose edges end where the loaded part ends"
        )
    return np.asarray(facets)


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


def _graded(n: int, grading: float, towards: str) -> Array:
    """Coordinates of n + 1 lines on [0, 1], drawn to both ends alike or to 1."""
    if towards == "high":
        return np.asarray(1 - (1 - np.linspace(0, 1, n + 1)) ** grading)
    s = np.linspace(-1, 1, n + 1)
    return np.asarray(0.5 * (1 + np.sign(s) * (1 - (1 - np.abs(s)) ** grading)))


def _subdivided(line: Array, degree: int) -> Array:
    """The coordinates with the midpoints between them, for quadratic elements."""
    if degree == 1:
        return line
    fine = np.empty(2 * len(line) - 1)
    fine[::2], fine[1::2] = line, 0.5 * (line[1:] + line[:-1])
    return fine


def _quadrilaterals(number: Index, degree: int) -> Index:
    """Cells in VTK order from the node numbers (rows along y) of a grid."""
    if degree == 1:
        return _cells(number, 1, [(0, 0), (0, 1), (1, 1), (1, 0)])
    ring = [(0, 0), (0, 2), (2, 2), (2, 0), (0, 1), (1, 2), (2, 1), (1, 0), (1, 1)]
    return _cells(number, 2, ring)


def _triangles(number: Index, degree: int) -> Index:
    """Each quadrilateral cut along the diagonal that rises to the right."""
    if degree == 1:
        lower, upper = [(0, 0), (0, 1), (1, 1)], [(0, 0), (1, 1), (1, 0)]
    else:
        lower = [(0, 0), (0, 2), (2, 2), (0, 1), (1, 2), (1, 1)]
        upper = [(0, 0), (2, 2), (2, 0), (1, 1), (2, 1), (1, 0)]
    return np.concatenate([_cells(number, degree, lower), _cells(number, degree, upper)])


def _cells(number: Index, degree: int, places: list[tuple[int, int]]) -> Index:
    """Node numbers at the given (row, column) places of every block of `degree` intervals."""
    rows, columns = number.shape
    nodes = [
        number[r : rows - degree + r : degree, c : columns - degree + c : degree].ravel()
        for r, c in places
    ]
    return np.column_stack(nodes)
