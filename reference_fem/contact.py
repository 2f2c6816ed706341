"""Elements against rigid obstacles, without friction, to first order in the displacement.

A pressure Σ p_j φ_j on the facets that may touch, φ_j the elements' own functions, acts along the
obstacle's normals n_j. With B_j the nodal forces of p_j = 1, the gaps in the mean are

    G = q + D p >= 0,    p >= 0,    p·G = 0,    D = Bᵀ K⁻¹ B,    q = Bᵀ u0 + ∫ φ g0,

u0 what other loads move. That is the least squares problem |Lᵀp + L⁻¹q| over p >= 0 with D = L Lᵀ,
which `scipy.optimize.nnls` ends at the exact set of nodes ([LawsonHanson1995]).
"""

from __future__ import annotations

import time

import numpy as np
from scipy.linalg import cholesky, solve_triangular
from scipy.optimize import nnls
from scipy.spatial.distance import cdist

from msvalidate.problem import (
    Array,
    Box,
    Contact,
    Index,
    Problem,
    ProblemError,
    SolverError,
    Traction,
    prescribed_displacements,
)
from msvalidate.problem.checks import finite_coordinates
from msvalidate.problem.progress import report_step
from msvalidate.problem.records import ReadOnly, dataclass, replace
from reference_fem.body import Solution, loaded_sides, nodal_forces
from reference_fem.converged import Reference
from reference_fem.elasticity import make_solver
from reference_fem.first_mesh import first_mesh
from reference_fem.materials import materials_of
from reference_fem.mesh.boxes import lines_discretisation
from reference_fem.mesh.discretisation import Discretisation
from reference_fem.mesh.facets import Facets
from reference_fem.mesh.subdivide import subdivide
from reference_fem.systems.solver import Solver

GROWTH = 1.25
"""Growth of cell sizes with distance from the contact patch."""
ROOM = 1.5
"""Half-widths to which cells are of one size."""
TURNS = 60
"""Maximum number of iterations of the active set, or of the mesh for a half-width."""
CELLS = {2: (4, 8, 16), 3: (1, 2, 3)}
"""In a half-width, by the number of axes: in space 4 would be 30,000 nodes."""
NEAR = 1e-4
"""Relative depth that a round obstacle may move from the position of its normals."""
EXACT, ACCEPTED = 1e-10, 1e-6
"""Relative error of the force at a depth, and the limit if rounding is larger.

Pressures are then scaled to the force.
"""
BEARING = 1e-3
"""Smallest weight of a node that can carry an obstacle, relative to the largest.

The corners of P2 elements cannot.
"""
CLOSE = 0.1
"""Change of the half-width at which its mesh is good for it."""


@dataclass(frozen=True, eq=False)
class ElementContact(ReadOnly):
    """A body of elements at rest against one obstacle.

    Parameters
    ----------
    solution
        Displacements.
    points, pressure
        Nodes (c, d) in m that may touch, and the pressure (c,) in Pa there.
    depth, total
        How far (m) the obstacle was lowered, and its force (N) along its way.
    half_width
        Half-width (m) or radius of the patch, from the pressure's second moment as of Hertz's.
    complementarity
        Largest penetration in the mean, or gap under pressure, over the largest in the body as it
        was.
    """

    solution: Solution
    points: Array
    pressure: Array
    depth: float
    total: float
    half_width: float
    complementarity: float


def press(
    problem: Problem,
    body: Discretisation,
    *,
    within: float | None = None,
) -> ElementContact:
    """Solve a problem with one contact on a discretisation of its domain.

    Parameters
    ----------
    problem, body
        As for `solve_problem`.
    within
        Distance (m) from the way of the obstacle's foremost point up to which nodes may touch,
        where that is known; all of the region otherwise, and where it turns out too small.

    Raises
    ------
    ProblemError
        If there is not one contact, or it reaches nothing; or as `solve_problem`.
    SolverError
        If the patch of a round obstacle is smaller than an element; or as `solve_problem`.
    """
    result = _press(problem, body, within)
    touched = int((result.pressure > 0).sum())
    if touched <= body.dim and problem.contacts[0].obstacle.radius is not None:
        raise SolverError(
            f"contact: the patch has {touched} nodes, and smaller elements are needed; take "
            "`contact_mesh` with its half-width, or `press_closely`"
        )
    return result


def _press(problem: Problem, body: Discretisation, within: float | None) -> ElementContact:
    """Contact as `press` has it, of a patch of any size."""
    report_step("mesh against the obstacle, %s nodes", f"{len(body.points):,}")
    contact, bare = _only_contact(problem)
    obstacle, depth = contact.obstacle, contact.depth
    held, given = prescribed_displacements(bare, body.points)
    law = materials_of(bare, body)
    ready = make_solver(body, law, held)
    force = nodal_forces(bare, body)
    begun, _ = ready.solve(given, force)
    nodes, mass = _mass(contact, problem, body)
    x = body.points[nodes]
    far = np.linalg.norm(obstacle.across(x), axis=1)
    may = far <= (np.inf if within is None else within)
    for _ in range(TURNS):
        normal = obstacle.normal(x, depth)
        gap = obstacle.gap(x, depth) + (normal * begun[nodes]).sum(axis=1)
        along = normal @ obstacle.axis
        if not (along > 0).any() or (contact.force is None and (gap >= 0).all()):
            raise ProblemError(
                f"contact: no point of the region can be reached, the nearest is {gap.min():.4g} m "
                "away; place the obstacle above the region, or lower it by more than that"
            )
        # Gaps, forces and their total have the same weights and each node's own normal.
        loads = mass[may][:, :, None] * normal
        follows = _followed(ready, body, nodes, loads)
        D = np.einsum("cnd,knd->ck", loads, follows)
        q = np.einsum("cnd,nd->c", loads, begun[nodes]) + mass[may] @ obstacle.gap(x, depth)
        # A force along the way is a weight w on pressures; lowering by δ takes δ w from the gaps.
        w = mass[may] @ along
        try:
            p, deeper = _unilateral((D + D.T) / 2, q, w, contact.force)
        except SolverError:
            problem.refuse_slight_force()
            raise
        depth += deeper
        if obstacle.is_round and abs(deeper) > NEAR * abs(depth):  # its normals have turned
            continue
        nodal = np.einsum("c,cnd->nd", p, loads)
        total = force.copy()
        total[nodes] += nodal
        found, solved = ready.solve(given, total)
        gap = obstacle.gap(x, depth) + (normal * found[nodes]).sum(axis=1)
        if (gap[~may] >= 0).all():
            break
        may[:] = True
    else:
        problem.refuse_slight_force()
        raise _no_depth(contact.force)
    left = q + D @ p - deeper * w
    wrong = np.abs(np.where(p > 0, left, np.minimum(left, 0.0))).max()
    along = nodal @ obstacle.axis
    pressure = np.zeros(len(x))
    pressure[may] = p
    return ElementContact(
        solution=Solution(body, found, law, solved=solved),
        points=x,
        pressure=pressure,
        depth=depth,
        total=float(along.sum()),
        half_width=obstacle.half_width(x, along),
        complementarity=float(wrong / np.abs(q - deeper * w).max()),
    )


def _only_contact(problem: Problem) -> tuple[Contact, Problem]:
    """A problem's one contact, without friction, and the problem without it."""
    if len(problem.contacts) != 1:
        raise ProblemError(f"{problem.name}: {len(problem.contacts)} contacts; elements take one")
    problem.refuse_free_body()
    (contact,) = problem.contacts
    if contact.friction:
        raise ProblemError(f"contact: friction {contact.friction:g} of elements; take 0")
    return contact, replace(problem, contacts=())


def _followed(ready: Solver, body: Discretisation, nodes: Index, loads: Array) -> Array:
    """Displacements (c, n, d) in m of n nodes under each of the loads (c, n, d) in N on them."""
    follows = np.empty(loads.shape)
    for each, moved in zip(loads, follows, strict=True):
        pushed = np.zeros(body.points.shape)
        pushed[nodes] = each
        moved[:] = ready.inverse(pushed.T.ravel()).reshape(body.dim, -1).T[nodes]
    return follows


def _mass(contact: Contact, problem: Problem, body: Discretisation) -> tuple[Index, Array]:
    """Nodes (c,) of the facets that may touch, and ∫ φ_i φ_j over them (c, c), times thickness."""
    traction = Traction(contact.region, (1.0,) * body.dim)
    facets: Facets = loaded_sides(problem.domain, traction, body)
    nodes, at = np.unique(facets.nodes, return_inverse=True)
    at = at.reshape(facets.nodes.shape)
    each = np.einsum("kq,fq,lq->fkl", facets.values, facets.measure, facets.values)
    mass = np.zeros((len(nodes), len(nodes)))
    np.add.at(mass, (at[:, :, None], at[:, None, :]), each)
    return np.asarray(nodes), problem.material.thickness * mass


def _unilateral(D: Array, q: Array, w: Array, total: float | None) -> tuple[Array, float]:
    """Pressures (c,) in Pa, and by how much (m) an obstacle pressed by a force goes deeper."""
    if total is None:
        return _pressures(D, q), 0.0
    bearing = np.flatnonzero(w > BEARING * w.max())
    on = bearing[[np.argmin(q[bearing] / w[bearing])]]
    before = np.inf
    for _ in range(TURNS):  # of the nodes that touch, as if they were all: Newton's method
        alone = np.linalg.solve(D[np.ix_(on, on)], np.column_stack([-q[on], w[on]]))
        deeper = float((total - w[on] @ alone[:, 0]) / (w[on] @ alone[:, 1]))
        p = _pressures(D, q - deeper * w)
        if not p.any():  # no depth is that small
            break
        off = float(abs(w @ p / total - 1))
        if off <= EXACT or before <= off <= ACCEPTED:  # rounding of gaps allows no less
            return p * (total / (w @ p)), deeper
        before = off
        on = np.flatnonzero(p)
    raise _no_depth(total)


def _no_depth(force: float | None) -> SolverError:
    return SolverError(
        f"contact: no depth for {force:g} N after {TURNS} turns; take smaller elements at the "
        "obstacle, or another force"
    )


def _pressures(D: Array, gap: Array) -> Array:
    """Pressures (c,) in Pa that close gaps (c,): of the nodes that the obstacle enters.

    Gaps far from the patch are many times the depth, and would hide it in the rounding of `nnls`.
    So nodes are taken only if they are entered by the body as it was, or as it bulges.
    """
    p, on = np.zeros_like(gap), gap < 0
    entered = on
    while entered.any():
        on = on | entered
        L = cholesky(D[np.ix_(on, on)], lower=True)
        right = solve_triangular(L, gap[on], lower=True)
        # nnls takes small numbers for none.
        size, times = float(L.max()), float(np.abs(right).max())
        p[on] = nnls(L.T / size, -right / times)[0] * (times / size)
        entered = ~on & (gap + D @ p < 0)
    return p


def contact_mesh(problem: Problem, half_width: float, cells: int) -> Discretisation:
    """Quadratic cells of a box, so many in a half-width (m) at the contact, larger elsewhere."""
    obstacle, domain = problem.contacts[0].obstacle, problem.domain
    lines = [
        _lines(low, high, at, half_width / cells, 0.0 if abs(way) > 0.5 else ROOM * half_width)
        for (low, high), at, way in zip(domain.span, obstacle.at, obstacle.axis, strict=True)
    ]
    return lines_discretisation(lines, "Q2" if domain.dim == 2 else "H2")


def _lines(low: float, high: float, at: float, h: float, even: float) -> Array:
    """Coordinates (m) from low to high, h apart within `even` of a place, then growing."""

    def side(length: float) -> Array:
        steps = np.full(max(1, round(min(even, length) / h)) if even else 1, h)
        while steps.sum() < length:
            steps = np.append(steps, steps[-1] * GROWTH)
        return np.asarray(np.cumsum(steps) * (length / steps.sum()))

    at = min(max(at, low), high)
    up, down = high - at, at - low
    parts = [at - side(down)[::-1]] if down > 0 else []
    parts += [np.array([at])] + ([at + side(up)] if up > 0 else [])
    return np.concatenate(parts)


def press_closely(
    problem: Problem, cells: tuple[int, ...] = (4, 8, 16)
) -> tuple[tuple[ElementContact, ...], float]:
    """Solve on finer and finer meshes; and the relative error of what the last says of the patch.

    Cells of boxes are so many in a half-width, where the obstacle is round; else the first mesh of
    the domain is cut. The error is the larger of what changed last and the square of the nodes'
    distance over the half-width: where between two nodes the patch ends, no mesh tells.
    """
    within = None
    if isinstance(problem.domain, Box) and problem.contacts[0].obstacle.radius is not None:
        a = min(problem.domain.size) / 4
        for _ in range(TURNS):
            before, a = a, _press(problem, contact_mesh(problem, a, cells[0]), None).half_width
            if abs(a / before - 1) < CLOSE:
                break
            a = min(max(a, before / 8), max(problem.domain.size))  # a node alone has no width
        bodies, within = [contact_mesh(problem, a, many) for many in cells], 2 * a
    else:
        body = first_mesh(problem)
        bodies = [subdivide(body, times) if times else body for times in range(len(cells))]
    found = tuple(_press(problem, body, within) for body in bodies)
    values = [
        np.array([one.half_width, one.pressure.max(), one.depth, one.total]) for one in found[-2:]
    ]
    with np.errstate(divide="ignore", invalid="ignore"):  # of one node that touches
        change = float(np.nan_to_num(np.abs(values[0] / values[1] - 1), nan=np.inf).max())
    touched = found[-1].points[found[-1].pressure > 0]
    apart = np.sort(cdist(touched, touched), axis=1)[:, 1].max() if len(touched) > 1 else np.inf
    width = found[-1].half_width
    return found, max(change, (float(apart) / width) ** 2 if width else np.inf)


def converge_contact(problem: Problem, points: Array, accuracy: float) -> Reference:
    """Converged solution of a contact problem, as `converge` for other problems."""
    began = time.perf_counter()
    x = finite_coordinates("points", points, "p", problem.domain.dim)
    found, error = press_closely(problem, CELLS[problem.domain.dim])
    each = (time.perf_counter() - began) / len(found)
    solutions = tuple(one.solution for one in found)
    seconds = (each,) * len(found)
    return Reference(problem, x, solutions, accuracy, seconds, contact=(found[-1], error))
