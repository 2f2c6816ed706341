"""From a `Problem` to finite elements: supports, consistent loads, the solution."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np
import skfem
from numpy.typing import ArrayLike

from msvalidate.problem import (
    VOIGT,
    Array,
    BodyForce,
    Domain,
    Field,
    Index,
    Mask,
    Material,
    Mesh,
    PointForce,
    Problem,
    ProblemError,
    Traction,
    Weight,
    enclosed_volume,
    facet_areas,
    facet_middles,
    format_point,
    measure_of,
    prescribed_displacements,
    vectors_at,
)
from msvalidate.problem.checks import format_value, require_type, shaped
from msvalidate.problem.records import dataclass
from reference_fem.elasticity import elastic_tensor, make_solver
from reference_fem.first_mesh import first_mesh
from reference_fem.materials import CellMaterials, Materials, by_material, materials_of, numbers_of
from reference_fem.mesh.discretisation import Discretisation
from reference_fem.mesh.facets import Facets
from reference_fem.mixed import mixed_solution, shear_and_compliance
from reference_fem.stress import (
    displacement_gradient,
    engineering_strain,
    gradient_in_cells,
    mean_by_point,
    pressure_at,
    pressure_numbers,
)
from reference_fem.systems.nested import Nested
from reference_fem.systems.solver import Solver, SystemSolution

Ready = Solver | Nested
"""Solver of the equations of one mesh."""
Make = Callable[[Discretisation, Materials, Mask], Ready]
"""Function that makes the solver of a body with its materials.

The fixed components are a mask (n, d).
"""


@dataclass(frozen=True, eq=False)
class Solution:
    """Displacement (n, d) in m at the nodes of a discretisation.

    Parameters
    ----------
    body, displacement
        The discretisation and the displacements of its nodes.
    material
        What stress follows from, by cell where there are several; None if only displacements are
        asked for.
    pressure
        (v,) in Pa at the corners of cells, in the order of `body.vertices`, of mixed elements:
        p = λ div u, positive in tension. Of several materials each has its own corners, one after
        the other. None of displacement elements.
    solved
        How the displacements were found; None where they were given.

    Raises
    ------
    ProblemError
        If there is not one displacement a node, or one pressure a corner.
    """

    body: Discretisation
    displacement: Array
    material: Materials | None = None
    pressure: Array | None = None
    solved: SystemSolution | None = None

    def __post_init__(self) -> None:
        require_type("body", self.body, Discretisation)
        shape = getattr(self.displacement, "shape", ())
        if shape != self.body.points.shape:
            raise ProblemError(f"solution: shape {shape}; give an array {self.body.points.shape}")
        self.displacement.setflags(write=False)
        if self.material is not None:
            require_type("material", self.material, Materials)
        if self.pressure is not None:
            _, wanted = pressure_numbers(self.body, self._number)
            shaped("pressure", np.asarray(self.pressure), wanted)
            self.pressure.setflags(write=False)

    @property
    def error(self) -> float:
        """Largest error of a nodal displacement as the elements' own, relative to the largest.

        What rounding and the solver leave of the linear equations; how far the elements are from
        the body is another matter, for which refine the mesh. NaN where displacements were given.
        """
        return self.solved.error if self.solved else math.nan

    def at(self, points: ArrayLike) -> Array:
        """Displacement (p, d) in m at points (p, d) of the body.

        Raises
        ------
        ProblemError
            If a point lies outside the body.
        """
        return np.asarray(self.body.interpolation(points) @ self.displacement)

    def strain(self, points: ArrayLike) -> Array:
        """Strain (p, 3 or 6) at points (p, d): xx, yy, xy or xx, yy, zz, yz, xz, xy.

        Shears are engineering ones, twice the tensor's. Where cells meet, the mean over them. Plane
        strain has no other; in plane stress εzz = -nu/(1 - nu)·(εxx + εyy).

        Raises
        ------
        ProblemError
            If a point lies outside the body.
        """
        return engineering_strain(displacement_gradient(self.body, self.displacement, points))

    def stress(self, points: ArrayLike) -> Array:
        """Stress (p, 3 or 6) in Pa at points (p, d), tension positive, in the order of `strain`.

        σ = C:ε of `strain`, so it jumps between cells and is their mean where they meet, each with
        its own material. Of mixed elements σ = 2με + p I with the pressure that was solved for,
        which jumps between materials alone. Plane stress has no σzz; in plane strain
        σzz = nu·(σxx + σyy).

        Raises
        ------
        ProblemError
            If a point lies outside the body, or the solution was made without its material.
        """
        law = self.material
        if law is None:
            raise ProblemError("stress: the solution was made without a material; give it one")
        if isinstance(law, CellMaterials):
            point, cell, each = gradient_in_cells(self.body, self.displacement, points)
            strain, number = engineering_strain(each), law.number[cell]
            found = np.empty_like(strain)
            for i, one in enumerate(law.materials):
                found[number == i] = self._of_strain(strain[number == i], one)
            stress = mean_by_point(point, found)
        else:
            stress = self._of_strain(self.strain(points), law)
        if self.pressure is not None:
            stress[:, : self.body.dim] += self.pressure_at(points)[:, None]
        return stress

    def _of_strain(self, strain: Array, material: Material) -> Array:
        """Stress (p, 3 or 6) in Pa of a material's strain, without the pressure of mixed ones."""
        if self.pressure is None:
            return np.asarray(strain @ elastic_tensor(material).T)
        d, pairs = self.body.dim, len(VOIGT[self.body.dim]) - self.body.dim
        mu, _ = shear_and_compliance(material)
        return np.asarray(strain * ([2 * mu] * d + [mu] * pairs))

    @property
    def _number(self) -> Index | None:
        """Number (c,) of each cell's material, where there are several."""
        return None if self.material is None else numbers_of(self.material)

    def pressure_at(self, points: ArrayLike) -> Array:
        """Pressure λ div u (p,) in Pa at points (p, d), positive in tension, of mixed elements.

        Where materials meet, the mean over the cells.

        Raises
        ------
        ProblemError
            If a point lies outside the body, or the elements were not mixed.
        """
        if self.pressure is None:
            raise ProblemError("pressure: displacement elements have none; solve mixed elements")
        return pressure_at(self.body, self.pressure, points, self._number)


def solve_problem(
    problem: Problem,
    body: Discretisation | None = None,
    *,
    mixed: bool = False,
    solver: str = "auto",
    allow_locked: bool = False,
) -> Solution:
    """Solve a problem on a discretisation of its domain, such as `box_discretisation` gives.

    Parameters
    ----------
    problem, body
        Problem, and the mesh. Default: the coarsest mesh of `converged.converge`, which refines it
        until the error is known.
    mixed
        Seek displacement and pressure together (Taylor-Hood): for nu near 1/2 and 1/2 itself, in
        plane strain and space, on quadratic elements. Displacement elements lock there.
    solver
        One of `solver.SOLVERS`, as for a `Solver`; of mixed elements "auto" or "superlu".
    allow_locked
        Answer also where elements of the first degree lock (`locking`): to look at locking itself.

    Raises
    ------
    ProblemError
        If a support or load does not meet the mesh, a zone ends inside a cell, mixed elements are
        not for a material, or the solver is unknown, not there or not for this body.
    SolverError
        If the elements lock, or the solution fails its residual check or its error may be above
        `solver.ACCEPTED`.
    """
    require_type("problem", problem, Problem)
    body = first_mesh(problem) if body is None else body
    if mixed:
        if solver not in ("auto", "superlu"):
            raise ProblemError(
                f"solver: {format_value(solver)}; mixed elements are indefinite, take auto or "
                f"superlu"
            )
        law, held, displacement, force = _asked(problem, body)
        found, pressure, solved = mixed_solution(body, law, held, displacement, force)
        return Solution(body, found, law, pressure, solved)
    return solve_by(problem, body, partial(make_solver, choice=solver, allow_locked=allow_locked))[
        0
    ]


def solve_by(problem: Problem, body: Discretisation, make: Make) -> tuple[Solution, Ready]:
    """The solution by what is made of a body, its materials and held components (n, d), and that.

    Raises
    ------
    ProblemError, SolverError
        As `solve_problem`.
    """
    law, held, displacement, force = _asked(problem, body)
    with np.errstate(over="ignore", invalid="ignore"):
        ready = make(body, law, held)
    found, solved = ready.solve(displacement, force)
    return Solution(body, found, law, solved=solved), ready


def _asked(problem: Problem, body: Discretisation) -> tuple[Materials, Mask, Array, Array]:
    """Materials, held components (n, d), their displacements (m) and forces (N), all checked."""
    _refuse_other_body(problem, body)
    problem.refuse_free_body()
    held, displacement = prescribed_displacements(problem, body.points)
    with np.errstate(over="ignore", invalid="ignore"):  # the residual refuses what is infinite
        force = nodal_forces(problem, body)
    return materials_of(problem, body), held, displacement, force


def _refuse_other_body(problem: Problem, body: Discretisation) -> None:
    require_type("problem", problem, Problem)
    require_type("body", body, Discretisation)
    domain = problem.domain
    if domain.dim != body.dim:
        raise ProblemError(f"{problem.name}: a {domain.dim}D {domain}, meshed in {body.dim}D")
    reached = np.array([body.points.min(axis=0), body.points.max(axis=0)])
    low, high = np.array(domain.span).T
    # Sides that bend reach beyond the nodes that a mesh's span is of.
    off = not isinstance(domain, Mesh) and np.abs(reached - (low, high)).max() > domain.tolerance
    volume = enclosed_volume(body.points[body.surface])
    # Only boxes are known by their span and volume; others by where their sides are, too.
    if isinstance(domain, Mesh) and not off:
        off = not domain.on_boundary(body.points[np.unique(body.surface)])
    if off or abs(volume - domain.volume) > 1e-9 * domain.volume:
        raise ProblemError(
            f"{problem.name}: the mesh spans {format_point(reached[0])} to "
            f"{format_point(reached[1])} "
            f"m, the domain {format_point(low)} to {format_point(high)} m, a {domain}; mesh the "
            "problem's own domain"
        )


def nodal_forces(problem: Problem, body: Discretisation) -> Array:
    """Consistent nodal forces (n, d) in N of a problem's loads, thickness included.

    Raises
    ------
    ProblemError
        If a point force meets no node, or a loaded part does not end at cell edges.
    """
    if problem.contacts:
        raise ProblemError(
            f"{problem.name}: has a contact, for `case run` and contact.press; leave it out"
        )
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
            facets = loaded_sides(problem.domain, load, body)
            x = facets.places
            field = vectors_at(f"traction on {load.region}", load.traction, x.reshape(-1, body.dim))
            force += thickness * facets.integrated(field.reshape(x.shape))
        elif isinstance(load, BodyForce):
            basis = body.quadrature(2 * body.element.degree + 2)
            force += thickness * _integrate("body force", load.force, basis, body)
        elif isinstance(load, Weight):
            force += thickness * np.outer(_mass_shares(problem, body), load.acceleration)
    return force


def _mass_shares(problem: Problem, body: Discretisation) -> Array:
    """∫ ρ φ_i by node (n,) in kg/m in the plane, kg in space."""
    basis = body.quadrature(2 * body.element.degree + 2)
    density = np.empty(len(body.cells))
    for material, cells in by_material(materials_of(problem, body), body):
        density[slice(None) if cells is None else cells] = material.density
    share = np.zeros(len(body.points))
    each = np.broadcast_to(density[:, None], np.shape(basis.dx))
    share[body.node] = skfem.LinearForm(lambda v, w: w.rho * v).assemble(basis, rho=each)
    return share


def loaded_sides(domain: Domain, load: Traction, body: Discretisation) -> Facets:
    """The sides of cells that a traction acts on: all of their nodes lie on the loaded part.

    So does their middle: all corners of a side may belong to others that meet there.
    """
    inside = load.region.select(body.points, domain.tolerance)
    nodes = body.surface[inside[body.surface].all(axis=1)]
    within = load.region.select(facet_middles(body.points[nodes]), domain.tolerance)
    facets = Facets(body, nodes[within])
    covered = float(facet_areas(body.points[facets.nodes]).sum())
    wanted = measure_of(load.region, domain)
    if abs(covered - wanted) > 1e-9 * wanted:
        sides = "edges" if body.dim == 2 else "faces"
        raise ProblemError(
            f"traction on {load.region}: covers no whole number of mesh {sides}; "
            f"choose cells whose {sides} end where the loaded part ends"
        )
    return facets


def _integrate(
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
