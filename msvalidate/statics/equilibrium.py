"""Static equilibrium of a network, by one linear solve or by Newton's method."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Literal

import numpy as np

from msvalidate.linear_algebra.choice import MOST_ENTRIES, MOST_IN_NEED, Choice
from msvalidate.linear_algebra.norms import max_abs
from msvalidate.network import Configuration, Network
from msvalidate.network.folds import count_folded, describe_folded, folded_cells
from msvalidate.network.inverse import Solver
from msvalidate.network.mechanism import is_certain
from msvalidate.network.multigrid import NotConvergedError
from msvalidate.network.refine import InaccurateError
from msvalidate.network.residual import out_of_balance_force
from msvalidate.problem import Array, ProblemError, SolverError, refuse_free_motions
from msvalidate.problem.checks import finite_coordinates, require_one_of, require_type
from msvalidate.problem.records import dataclass
from msvalidate.statics.following import PathResult, follow_path
from msvalidate.statics.path import Path, load_path
from msvalidate.statics.refinement import explain_rounding, refine_equilibrium, refine_linear


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """A network at rest under its supports and loads.

    Parameters
    ----------
    displacement
        (n, d) from the reference points (m).
    position
        (n, d) in m.
    reaction
        (n, d) force (N) of the supports on the held components, 0 elsewhere.
    residual
        Largest out-of-balance force (N) on a free component.
    iterations
        Linear solves that it took, or time steps.
    error
        Largest error of a component of the displacement over the largest component: an estimate
        from what refinement says, above the rounding that is known. 0 where nothing moves, NaN
        where it was not estimated.
    folded
        Number of cells that are flat or inside out; None where there was nothing to look at: see
        `msvalidate.network.folds`.
    passed_limit
        Part of the load at which the first limit point was passed, where the stable branch that
        begins at the start ends and the network snaps through to another. None where none was,
        and where no path of loads was followed: of linear answers and relaxations.
    solver
        Which was taken, "direct" or "multigrid", and why; None of relaxations, and where nothing
        had to be solved.
    """

    displacement: Array
    position: Array
    reaction: Array
    residual: float
    iterations: int
    error: float = math.nan
    folded: int | None = None
    passed_limit: float | None = None
    solver: Choice | None = None


def equilibrium(
    network: Network,
    geometry: Literal["linear", "nonlinear"] = "linear",
    *,
    path: Path | None = None,
    start: Equilibrium | Array | None = None,
    allow_folded: bool = False,
    solver: str | Solver = "auto",
) -> Equilibrium:
    """Static equilibrium of a network.

    Parameters
    ----------
    network
        Supports must hold every rigid motion.
    geometry
        "linear": one solve with the tangent at the reference points, valid to first order in the
        displacement. "nonlinear": Newton's method, in load increments where one step is too many.
        Either way the tangent must be positive: the network is stable where it is linearised.
    path
        Of nonlinear equilibria: how loads and prescribed displacements come to their full size.
        Fractions that rise to 1, at each of which an equilibrium is found; or a function of t that
        returns force and displacement (n, d) at t from 0 to 1, such as ends that turn, which in
        proportion would move along chords. By default the whole at once, in proportion where that
        is too much; networks that prestress leaves out of balance may come from springs without
        tension, their rest lengths raised together with the loads.
    start
        Of nonlinear equilibria: where to begin, an equilibrium or a displacement (n, d) in m.
        What is out of balance there is taken away along the path.
    allow_folded
        Whether cells may be flat or inside out. A linear answer is so under any load that is large
        enough, for it goes on in proportion: its cells are counted, and it is never refused for
        them.
    solver
        Of linear systems: "direct", a factor in nested dissection, whose pivots tell for certain
        whether a network is stable; "multigrid", conjugate gradients, which take work and memory
        in proportion to the points, and tell it but for a chance of one in 12,500; "auto", a factor
        of plane, slender and small bodies, where multigrid would take longer, and where it fails;
        or a solver of this network that is there already.

    Raises
    ------
    ProblemError
        If supports leave a rigid motion free, the message names it, or path or start do not fit, or
        there is no such solver.
    SolverError
        If the network is a mechanism or unstable, or no equilibrium is found at full load, or
        cells are folded in a nonlinear one.
    """
    require_type("network", network, Network)
    refuse_free_motions("network", network.points, network.held)
    require_one_of("geometry", geometry, ("linear", "nonlinear"))
    require_type("allow_folded", allow_folded, bool)
    if geometry == "linear" and not (path is None and start is None):
        raise ProblemError(
            "path, start: a linear equilibrium has neither; take geometry 'nonlinear'"
        )
    with np.errstate(over="ignore", invalid="ignore"):  # the residual refuses what has no numbers
        way = solver if isinstance(solver, Solver) else Solver(network, solver)
        if geometry == "linear":
            found = _solve_by(way, partial(_solve_linear, network, way))
        else:
            begun = start_displacement(network, start)
            found = _solve_by(way, partial(_solve_nonlinear, network, way, path, begun))
    if geometry == "nonlinear" and not allow_folded:
        refuse_folded(network, found, "nonlinear equilibrium")
    return found


def start_displacement(network: Network, start: Equilibrium | Array | None) -> Array | None:
    """Displacement (n, d) in m of a start, checked.

    Raises `ProblemError` if it is of another network, or no displacement.
    """
    if start is None:
        return None
    given = start.displacement if isinstance(start, Equilibrium) else start
    need = f"give an equilibrium of this network, or its displacement {network.points.shape}"
    return finite_coordinates("start", given, *network.points.shape, need=need)


def refuse_folded(network: Network, found: Equilibrium, title: str) -> None:
    """Raise `SolverError` if cells are folded, with their number and place."""
    simplices = network.simplices
    if found.folded and simplices is not None:
        folded = folded_cells(simplices, found.position)
        raise SolverError(
            f"{title}: {describe_folded(simplices, folded, network.points)}; raise what is "
            "applied along a path, or reduce it"
        )


def equilibrium_at(
    network: Network,
    displacement: Array,
    iterations: int,
    *,
    error: float = math.nan,
    passed_limit: float | None = None,
    solver: Choice | None = None,
    linear: bool = False,
) -> Equilibrium:
    """The equilibrium at a displacement (n, d) in m, with the residual and reactions found there.

    Forces come from the displacement: positions have lost digits where coordinates are large.
    `linear`: they are those at the reference points and their change to first order.
    """
    if linear:
        at = Configuration(network)
        left = at.force() + at.force_change(displacement) + network.force
    else:
        left = out_of_balance_force(network, displacement)
    displacement.setflags(write=False)
    position = network.points + displacement
    return Equilibrium(
        displacement=displacement,
        position=position,
        reaction=np.where(network.held, -left, 0.0),
        residual=max_abs(left[~network.held]),
        iterations=iterations,
        error=error,
        folded=count_folded(network.simplices, position),
        passed_limit=passed_limit,
        solver=solver,
    )


def _solve_by(solver: Solver, solve: Callable[[], Equilibrium]) -> Equilibrium:
    """What is found by a solver, by its factor where multigrid gives up."""
    while True:
        try:
            return solve()
        except SolverError as error:
            # A factor goes on past tangents that are not positive, at which multigrid stops.
            stopped = solver.met_negative and not isinstance(error, NotConvergedError)
            if solver.is_direct or not (
                stopped or isinstance(error, NotConvergedError | InaccurateError)
            ):
                raise
            solver.give_way(error, MOST_ENTRIES if stopped else MOST_IN_NEED)


def _solve_linear(network: Network, solver: Solver) -> Equilibrium:
    found = refine_linear(network, solver)
    choice = None if network.held.all() else solver.choice
    u, steps = found.solution, 1 + found.steps
    return equilibrium_at(network, u, steps, error=found.error, solver=choice, linear=True)


def _solve_nonlinear(
    network: Network, solver: Solver, path: Path | None, begun: Array | None
) -> Equilibrium:
    """Loads and prescribed displacements raised together; rest lengths too where prestress asks."""
    found = _follow_path(network, solver, path, begun)
    end = refine_equilibrium(network, found.displacement, found.factor, solver)
    return equilibrium_at(
        network,
        end.solution,
        found.solves + end.steps,
        error=end.error,
        passed_limit=found.passed_limit,
        solver=None if network.held.all() else solver.choice,
    )


def _follow_path(
    network: Network, solver: Solver, path: Path | None, begun: Array | None
) -> PathResult:
    """The end of the way to the network's own loads."""
    stressed = path is None and begun is None and network.law.rests and network.prestressed
    try:
        found = follow_path(load_path(network, path, begun), solver)
    except SolverError:
        tightened = _follow_prestress(network, solver, 0) if stressed else None
        if tightened is None or tightened.reached < 1:
            raise
        found = tightened
    if found.reached < 1 and stressed:
        tightened = _follow_prestress(network, solver, found.solves)
        found = tightened if tightened and tightened.reached == 1 else found
    if found.reached < 1:
        raise SolverError(_explain_failure(network, solver, found))
    return found


def _follow_prestress(network: Network, solver: Solver, solves: int) -> PathResult | None:
    """The end of a way from springs without tension; None where those would be a mechanism."""
    try:
        found = follow_path(load_path(network, tightened=True), solver)
    except SolverError:
        return None
    found.solves += solves
    return found


def _explain_failure(network: Network, solver: Solver, found: PathResult) -> str:
    """What to say of a way that leads no further."""
    what, hidden = "load", _explain_pivots(network, solver)
    if hidden:
        remedy = f"what lies beyond may be hidden by rounding: {hidden}"
    elif not (network.law.rests and network.prestressed):
        remedy = "reduce the load or stiffen the network"
    elif network.force.any() or network.displacement.any():
        remedy = "reduce load or prestress, or take the start from a relaxation"
    else:
        what = "prestress"
        remedy = "bring rest lengths closer to the springs' lengths, or take the start from a "
        remedy += "relaxation"
    return (
        f"nonlinear equilibrium: no stable equilibrium found beyond {found.reached:.4g} of the "
        f"{what} (after {found.solves} linear solves); {remedy}"
    )


def _explain_pivots(network: Network, solver: Solver) -> str:
    """Why the signs of pivots may be rounding at the reference points; empty where they are not."""
    if network.held.all():
        return ""
    try:
        found = solver.regular(Configuration(network))
    except SolverError:  # such as a rope, which stands by its tension alone
        return ""
    return "" if is_certain(found.softness) else explain_rounding(network, found.softness)
