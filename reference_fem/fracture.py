"""Cracks that lie on a line of symmetry: the energy that would be released were they longer.

Such a crack is a side of half of the body, held across where it is not. Energy release rates by two
routes: from the energies of cracks of other lengths, and by the domain form of the J integral
([LiShihNeedleman1985]). Of the whole body both are twice that of its half.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np

from msvalidate.problem import Array, Box, Problem, ProblemError, Traction
from msvalidate.problem.records import dataclass
from reference_fem.body import Solution, nodal_forces, solve_problem
from reference_fem.elasticity import elastic_tensor, full_tensor
from reference_fem.first_mesh import kept_places
from reference_fem.mesh.boxes import lines_discretisation
from reference_fem.mesh.discretisation import Discretisation

SMALLEST, GROWTH, LARGEST = 2e-5, 0.8, 0.2
"""Cells of a first mesh: at the tip, over the body's least side; over their distance from the tip;
over the least side."""
REACH = (0.25, 0.75)
"""Distances from the tip where J is integrated, relative to the free distance.

The free distance is that from the tip to the nearest side or load.
"""


@dataclass(frozen=True, eq=False)
class ReleaseRate:
    """Energy release rate of half a body.

    Parameters
    ----------
    value, uncertainty
        In J/m of crack front length times thickness: N. The uncertainty is the sum of its
        changes from the coarser mesh, from twice the step in length, and from the J integral.
    integral
        The same by the J integral.
    """

    value: float
    uncertainty: float
    integral: float


def release_rate(
    problem_at: Callable[[float], Problem],
    tip_at: Callable[[float], tuple[float, ...]],
    length: float,
    step: float,
) -> ReleaseRate:
    """Energy release rate of a crack under loads that stay.

    Parameters
    ----------
    problem_at, tip_at
        Half of the body by the crack's length (m), and the place (m) of the tip, on a side of it.
    length, step
        The crack's length (m), and the step (m) to others: half of it, one and two either side.

    Raises
    ------
    ProblemError
        If the body is no plane box of one material under tractions, or the step is none.
    """
    _refuse_other_loads(problem_at(length))
    if not 0 < step < length / 2:
        raise ProblemError(f"step: {step:g} m; give a small part of the crack's length")

    def rates(finer: int, times: tuple[float, ...]) -> list[float]:
        """Rates by central differences of fourth order over so many steps and twice as many."""
        stored = {n: energy(n * step, finer) for k in times for n in (-2 * k, -k, k, 2 * k)}
        return [
            (8 * (stored[k] - stored[-k]) - stored[2 * k] + stored[-2 * k]) / (12 * k * step)
            for k in times
        ]

    def energy(longer: float, finer: int) -> float:
        problem = problem_at(length + longer)
        solution = solve_problem(problem, crack_mesh(problem, tip_at(length + longer), finer))
        return float((nodal_forces(problem, solution.body) * solution.displacement).sum()) / 2

    (coarse,), (rate, wide) = rates(1, (0.5,)), rates(2, (0.5, 1.0))
    problem, tip = problem_at(length), np.array(tip_at(length))
    along = np.array(tip_at(length + step)) - tip
    solution = solve_problem(problem, crack_mesh(problem, tuple(tip), 2))
    J = j_integral(solution, problem, tip, along / np.linalg.norm(along))
    # The meshes of two lengths differ in more than the tip, which each change may miss by itself.
    return ReleaseRate(rate, abs(rate - coarse) + abs(rate - wide) + abs(rate - J), J)


def _refuse_other_loads(problem: Problem) -> None:
    """Raise `ProblemError` for what neither route has: moved supports, forces inside, zones."""
    moved = any(value not in (None, 0) for each in problem.supports for value in each.displacement)
    inside = not all(isinstance(load, Traction) for load in problem.loads)
    if moved or inside or problem.zones or problem.contacts:
        raise ProblemError(
            "crack: supports that move, forces inside the body, zones or a contact; take tractions "
            "on a body of one material"
        )


def crack_mesh(problem: Problem, tip: tuple[float, ...], finer: int = 1) -> Discretisation:
    """Quadratic cells of a plane box that grow with their distance from a crack's tip (m)."""
    box = problem.domain
    if not isinstance(box, Box) or box.dim != 2:
        raise ProblemError("crack: elements take a plane box, half of a body; give a Box")
    size = min(box.size)
    lines = []
    for at, kept, (low, high) in zip(tip, kept_places(problem).T, box.span, strict=True):
        stops = np.unique(np.clip([low, high, at, *kept], low, high))
        stops = stops[np.append(True, np.diff(stops) > box.tolerance)]
        stops[-1] = high
        parts = [np.array([low])]
        for a, b in pairwise(stops):
            near = min(abs(a - at), abs(b - at))
            marks = [0.0]
            while marks[-1] < b - a:
                h = max(SMALLEST * size, GROWTH * (near + marks[-1])) / finer
                marks.append(marks[-1] + min(h, LARGEST * size / finer))
            part = np.array(marks) * ((b - a) / marks[-1])
            parts.append((b - part[::-1] if abs(b - at) < abs(a - at) else a + part)[1:])
        lines.append(np.concatenate(parts))
    return lines_discretisation(lines, "Q2")


def j_integral(solution: Solution, problem: Problem, tip: Array, along: Array) -> float:
    """J (N) of a crack's tip (2,) in m that grows along a direction (2,), of one material.

    ∫ (σ_ij ∂_k u_j d_k - W d_i) ∂_i q, where q falls from 1 around the tip to 0: the sides of the
    crack bear no load, and where the body is held its mirror image goes on.
    """
    body, basis, t = solution.body, solution.body.quadrature(6), problem.material.thickness
    stops = np.concatenate([np.array(problem.domain.span).T, kept_places(problem)])
    far = np.abs(stops - tip)
    room = far[far > 1e-9 * far.max()].min()
    near = np.clip((np.abs(body.points - tip).max(axis=1) / room - REACH[0]) / np.ptp(REACH), 0, 1)

    def slope(values: Array) -> Array:
        return np.asarray(basis.interpolate(values[body.node]).grad)

    grad = np.stack([slope(u) for u in solution.displacement.T])
    stress = np.einsum("abcd,cd...->ab...", full_tensor(elastic_tensor(problem.material)), grad)
    energy = 0.5 * np.einsum("ab...,ab...->...", stress, grad)
    moved = np.einsum("ij...,jk...,k->i...", stress, grad, along)
    moved -= energy * along[:, None, None]
    return t * float((np.einsum("i...,i...->...", moved, slope(1 - near)) * basis.dx).sum())
