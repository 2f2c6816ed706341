"""A problem's solution with its own error: on meshes each twice as fine as the last.

Every quantity is read off each mesh, and `richardson` tells how far the last is from the limit.
Some questions have none, and corners where materials cross hide how slow they are: `limits`.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import csr_matrix

from msvalidate.problem import (
    VOIGT,
    Array,
    Isotropic,
    Mask,
    Problem,
    SolverError,
    prescribed_displacements,
)
from msvalidate.problem.checks import (
    finite_coordinates,
    positive_number,
    require_type,
    whole_number,
)
from msvalidate.problem.progress import report_step
from msvalidate.problem.records import dataclass, replace
from reference_fem.body import Make, Ready, Solution, nodal_forces, solve_by, solve_problem
from reference_fem.effort import MEMORY, More, fits_within, one_more_mesh
from reference_fem.elasticity import make_solver, stiffness, thickness_tensors
from reference_fem.first_mesh import MOST_MIXED, MOST_NODES, first_mesh
from reference_fem.limits import acts_on_points, crossing_order, has_no_limit
from reference_fem.materials import Materials, materials_of, numbers_of
from reference_fem.mesh.discretisation import Discretisation
from reference_fem.mesh.gradients import gradients_at_points
from reference_fem.mesh.subdivide import children_of, nodes_of_children
from reference_fem.mixed import mixed_forces
from reference_fem.richardson import (
    ROUNDING,
    TRUSTED_ORDER,
    TWO_MESHES,
    Estimate,
    close_in,
    unlimited,
)
from reference_fem.systems.cells import ElasticForces
from reference_fem.systems.direct import favours_factor
from reference_fem.systems.nested import NESTED, Nested

MOST_DIRECT = 20_000
"""Nodes of a mesh in space, cut from another, up to which a factor is thought of: of slender bodies
one takes some 5 s there, but a minute and 4 GB at 58,000."""
LEVELS = 3
"""Meshes that are always solved, if their nodes are few enough."""
NEARLY_INCOMPRESSIBLE = 0.45
"""Ratio from which displacement and pressure are sought together, but in plane stress."""


class LargeChange(NamedTuple):
    """Change of displacements by large displacements: equilibrium in full less first order.

    Parameters
    ----------
    displacement, uncertainty
        (p, d) in m at the points of a reference, and how far (m) it may be off.
    no_finer
        Error of a finer mesh that has no equilibrium; None if no such mesh was tried.
    """

    displacement: Array
    uncertainty: float
    no_finer: SolverError | None = None


@dataclass(frozen=True, eq=False)
class Reference:
    """Reference solution of a problem by elasticity, with an error for each value.

    Parameters
    ----------
    problem, points
        What was asked, and where (p, d) in m.
    solutions
        On each mesh, the finest last.
    accuracy
        Asked of the displacement, over the largest at the points.
    seconds
        That each mesh took.
    large
        Change by large displacements, if it was requested.
    contact
        `contact.ElementContact` of an obstacle on the finest mesh, and its relative error, or None.
    following
        What one more mesh takes, where memory limits them.
    """

    problem: Problem
    points: Array
    solutions: tuple[Solution, ...]
    accuracy: float
    seconds: tuple[float, ...]
    large: LargeChange | None = None
    contact: Any = None
    following: More | None = None

    @cached_property
    def displacement(self) -> Estimate:
        """Displacement (p, d) in m at the points."""
        found = self._close_in(self.by_mesh)
        if self.large is not None:
            found = replace(found, uncertainty=found.uncertainty + self.large[1])
        return unlimited(found.value) if self.no_limit else found

    @cached_property
    def by_mesh(self) -> list[Array]:
        """Displacement (p, d) in m at the points on each mesh."""
        more = 0.0 if self.large is None else self.large[0]
        return [solution.at(self.points) + more for solution in self.solutions]

    @cached_property
    def error(self) -> float:
        """Largest error of a displacement at the points, over the largest of them."""
        size = float(np.linalg.norm(self.displacement.value, axis=1).max())
        return float(self.displacement.uncertainty) / size if size else 0.0

    @property
    def resolved(self) -> bool:
        """True if the requested accuracy is reached."""
        return self.error <= self.accuracy

    @property
    def more(self) -> More | None:
        """Effort of a finer mesh; None if the accuracy is reached or memory suffices."""
        return None if self.resolved or self.no_limit else self.following

    @property
    def finest(self) -> Solution:
        """The solution on the finest mesh."""
        return self.solutions[-1]

    def solutions_up_to(self, nodes: int) -> tuple[Solution, ...]:
        """Solutions on meshes with at most so many nodes; the coarsest one if all have more."""
        few = tuple(one for one in self.solutions if len(one.body.points) <= nodes)
        return few or self.solutions[:1]

    @cached_property
    def reactions(self) -> tuple[Estimate, ...]:
        """Force (d,) in N of each support of the problem on the body."""
        forces = [self._support_forces(solution, force) for solution, force in self._internal]
        return tuple(self._close_in(list(each)) for each in zip(*forces, strict=True))

    @cached_property
    def energy(self) -> Estimate:
        """Strain energy (J)."""
        works = [
            np.array([(solution.displacement * force).sum() / 2])
            for solution, force in self._internal
        ]
        found = self._close_in(works)
        return unlimited(found.value) if self.no_limit else found

    @cached_property
    def mean_stress(self) -> Estimate:
        """Mean stress (3,) or (6,) in Pa: the outer forces' virial over the volume.

        Few values may change little by chance: a third of the change before the last counts too.
        """
        values = [self._mean_stress(solution, force) for solution, force in self._internal]
        found = self._close_in(values)
        before = np.abs(np.diff(values[-3:-1], axis=0)).max(initial=0.0) / 3
        return replace(found, uncertainty=np.maximum(found.uncertainty, before))

    def stress(self, points: Array) -> tuple[Array, Array]:
        """Stress (q, 3) or (q, 6) in Pa at points (q, d), and how far each of them may be off (q,).

        Twice the last change, as orders of stresses differ from place to place and changes vanish
        where they cross. Next to corners stresses have no limit.
        """
        found = [solution.stress(points) for solution in self.solutions[-2:]]
        if len(found) < 2:
            return found[-1], np.full(len(points), np.inf)
        return found[-1], np.asarray(TWO_MESHES * np.abs(found[-1] - found[-2]).max(axis=1))

    @cached_property
    def no_limit(self) -> tuple[str, ...]:
        """Why displacement and energy have no limit, a sentence each; empty where they have one."""
        if not acts_on_points(self.problem):
            return ()
        coarse = self.solutions[0]
        reactions = self._support_forces(coarse, self._forces(coarse))
        loads = float(np.abs(nodal_forces(self._without_contacts, coarse.body)).sum())
        return has_no_limit(self.problem, reactions, loads)

    @property
    def _without_contacts(self) -> Problem:
        """Problem without obstacles: their forces are no loads."""
        return replace(self.problem, contacts=()) if self.problem.contacts else self.problem

    def _close_in(self, values: list[Array]) -> Estimate:
        return close_in(values, self._most)

    @cached_property
    def _most(self) -> float:
        """Largest order that is believed."""
        return min(TRUSTED_ORDER, crossing_order(self.problem, self.solutions[0].body))

    @cached_property
    def _internal(self) -> list[tuple[Solution, Array]]:
        """Solutions, and forces (n, d) in N from outside on their nodes."""
        return [(solution, self._forces(solution)) for solution in self.solutions]

    def _forces(self, solution: Solution) -> Array:
        """Forces (n, d) in N from outside on the nodes of a solution.

        Loads where nodes are free: in slender bodies the sum over cells keeps few of their digits.
        """
        law, u = materials_of(self.problem, solution.body), solution.displacement
        if solution.pressure is not None:
            inner = mixed_forces(solution.body, law, u, solution.pressure)
        else:
            apply: Callable[[Array], Array] = (
                ElasticForces(
                    gradients_at_points(solution.body), thickness_tensors(law), numbers_of(law)
                )
                if solution.solved is not None and solution.solved.choice == NESTED
                else stiffness(solution.body, law).dot
            )
            inner = apply(u.T.ravel()).reshape(u.shape[::-1]).T
        if self.problem.contacts:  # whose forces are no loads
            return inner
        held, _ = prescribed_displacements(self.problem, solution.body.points)
        return np.where(held, inner, nodal_forces(self.problem, solution.body))

    def _support_forces(self, solution: Solution, force: Array) -> list[Array]:
        """Force (d,) in N of each support; what several hold is the first's."""
        points, tolerance = solution.body.points, self.problem.domain.tolerance
        outer = nodal_forces(self._without_contacts, solution.body)
        held, _ = prescribed_displacements(self.problem, points)
        left = np.where(held, force - outer, 0.0)
        found = []
        for support in self.problem.supports:
            on = support.region.select(points, tolerance)
            own: Mask = on[:, None] & np.array(
                [value is not None for value in support.displacement]
            )
            found.append(np.where(own, left, 0.0).sum(axis=0))
            left[own] = 0.0
        return found

    def _mean_stress(self, solution: Solution, force: Array) -> Array:
        domain, x = self.problem.domain, solution.body.points
        middle = x.mean(axis=0)
        virial = np.einsum("na,nb->ab", force, x - middle)
        volume = domain.volume * self.problem.material.thickness
        pairs = np.array(VOIGT[domain.dim])
        return np.asarray((virial + virial.T)[pairs[:, 0], pairs[:, 1]] / (2 * volume))


def converge(
    problem: Problem,
    points: Array,
    accuracy: float = 1e-3,
    *,
    memory: float = MEMORY,
    most_nodes: int | None = None,
    first: Discretisation | None = None,
    mixed: bool | None = None,
    solver: str = "auto",
) -> Reference:
    """Solve a problem on finer and finer meshes until displacements at points are known.

    Parameters
    ----------
    problem
        On a box, an outline or a mesh; of the last the cells are cut, raised to quadratic ones, and
        their sides stay on the file's own curves.
    points
        (p, d) in m, in the body.
    accuracy
        Of the displacement, over the largest at the points. Where it takes more nodes or memory
        than there may be, the answer is what there is, with the error that it has.
    memory
        GB (1e9 bytes) that a mesh in space may take, as predicted by its nodes: the same answer on
        every machine that has so much.
    most_nodes
        Of the finest mesh, in place of a limit of memory; by default `MOST_NODES` in the plane, and
        in space by a solver that is named; `MOST_MIXED` of mixed elements there.
    first
        A mesh to start from in place of the one made here.
    mixed
        Whether displacement and pressure are sought together; by default where a ratio is
        `NEARLY_INCOMPRESSIBLE` or more, but in plane stress.
    solver
        As for `solve_problem`.

    Raises
    ------
    ProblemError
        If a point lies outside the body, or a support or load cannot be met by a mesh's nodes.
    SolverError
        If there is no trustworthy answer on the first mesh, or a mesh that `memory` allows takes
        more than the machine has free.
    """
    require_type("problem", problem, Problem)
    problem.refuse_free_body()
    x = finite_coordinates("points", points, "p", problem.domain.dim)
    positive_number("accuracy", accuracy)
    mixed = is_nearly_incompressible(problem) if mixed is None else mixed
    positive_number("memory", memory)
    most: float = (
        MOST_MIXED if mixed and problem.domain.dim == 3 else MOST_NODES[problem.domain.dim]
    )
    if most_nodes is not None:
        most = whole_number("most nodes", most_nodes, 1)
    elif problem.domain.dim == 3 and solver == "auto" and not mixed:
        most = np.inf  # memory limits them
    body = first or first_mesh(problem)
    ready: Ready | None = None
    finer: csr_matrix | None = None
    found: list[Solution] = []
    seconds: list[float] = []
    reference: Reference | None = None
    following: More | None = None
    while True:
        began = time.perf_counter()
        if found:
            body, finer = children_of(body)
        expected = f", about {following.seconds:.0f} s" if following else ""
        text = "mesh %d of at least %d, %s nodes%s"
        report_step(text, len(found) + 1, LEVELS, f"{len(body.points):,}", expected)
        try:
            if mixed:
                found.append(solve_problem(problem, body, mixed=True, solver=solver))
            else:
                make = partial(_make_ready, solver, found, ready, finer)
                solution, ready = _solve(problem, body, make, solver)
                found.append(solution)
        except SolverError:
            if reference is None or len(body.points) <= MOST_NODES[3] or body.dim == 2:
                raise
            return replace(reference, following=None)  # cells too long, and children no less so
        seconds.append(time.perf_counter() - began)
        nodes = nodes_of_children(body)
        following = (
            one_more_mesh(body.element.name, body.dim, nodes, seconds[-1] / len(body.points))
            if np.isinf(most)
            else None
        )
        reference = Reference(
            problem, x, tuple(found), accuracy, tuple(seconds), following=following
        )
        many = len(found) >= LEVELS or nodes > MOST_NODES[body.dim]
        enough = reference.resolved and (many or reference.error <= ROUNDING)
        if enough or nodes > most or not fits_within(following, memory):
            return reference


def _solve(
    problem: Problem, body: Discretisation, make: Make, solver: str
) -> tuple[Solution, Ready]:
    """The solution, on meshes that may have a factor by one where multigrid over all gives up."""
    try:
        return solve_by(problem, body, make)
    except SolverError:
        if body.dim == 2 or solver != "auto" or len(body.points) > MOST_NODES[3]:
            raise
    return solve_by(problem, body, partial(make_solver, choice=solver))


def _make_ready(
    solver: str,
    found: list[Solution],
    coarser: Ready | None,
    finer: csr_matrix | None,
    body: Discretisation,
    law: Materials,
    held: Mask,
) -> Ready:
    """Make the solver of a mesh: multigrid in 3D unless a factor is fast."""
    if coarser is None or finer is None or solver != "auto" or body.dim == 2:
        return make_solver(body, law, held, solver)
    if len(body.points) <= MOST_DIRECT and favours_factor(body):
        return make_solver(body, law, held, solver)
    start = finer @ found[-1].displacement
    return Nested(body, held, thickness_tensors(law), numbers_of(law), coarser, finer, start)


def is_nearly_incompressible(problem: Problem) -> bool:
    """Return True if a problem needs the mixed formulation of displacement and pressure."""
    laws = problem.materials
    if not all(isinstance(law, Isotropic) and law.nu > 0 for law in laws):
        return False  # such have no pressure that grows with volume
    return any(
        isinstance(law, Isotropic)
        and law.state != "plane_stress"
        and law.nu >= NEARLY_INCOMPRESSIBLE
        for law in laws
    )
