"""Static equilibrium of a network, by one linear solve or by Newton's method."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Literal

import numpy as np

from msvalidate.linear_algebra.choice import MOST_ENTRIES, MOST_IN_NEED, Choice
from msvalidate.linear_algebra.norms import max_abs
from msvalidate.problem import Array, ProblemError, SolverError, refuse_free_motions
from msvalidate.problem.checks import finite_coordinates, require_one_of, require_type
from msvalidate.problem.records import dataclass
from msvalidate.springs.network import Configuration, Network
from msvalidate.springs.network.folds import count_folded, describe_folded, folded_cells
from msvalidate.springs.network.inverse import Solver
from msvalidate.springs.network.mechanism import is_certain
from msvalidate.springs.network.multigrid import NotConvergedError
from msvalidate.springs.network.refine import InaccurateError
from msvalidate.springs.network.residual import out_of_balance_force
from msvalidate.springs.statics.newton_path import PathResult, follow_path
from msvalidate.springs.statics.path import Path, load_path
from msvalidate.springs.statics.refinement import (
    explain_rounding,
    refine_equilibrium,
    refine_linear,
)


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """Equilibrium of a network under its supports and loads.

    Parameters
    ----------
    displacement
        Displacement (m) from the reference positions, shape (n, d).
    position
        Positions (m), shape (n, d).
    reaction
        Force (N) of the supports on the fixed components, shape (n, d), 0 elsewhere.
    residual
        Largest out-of-balance force (N) on a free component.
    iterations
        Number of linear solves, or of time steps.
    error
        Estimated largest error of a displacement component, relative to the largest component. It
        covers rounding and the solver, not the difference from elasticity. 0 for zero
        displacement, NaN without an estimate.
    folded
        Number of flat or inverted cells; None if there are no cells to check.
    passed_limit
        Load factor of the first limit point on the path, where the stable branch ends and the
        network snaps through. None if there was none, and for linear results and relaxations.
    solver
        "direct" or "multigrid", with the reason; None for relaxations, or if nothing was solved.
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
    """Compute the static equilibrium of a network.

    Source: Newton's method with load steps, [Crisfield1991].

    Parameters
    ----------
    network
        Network with n points in d dimensions, whose supports prevent every rigid-body motion.
    geometry
        "linear": one solve with the tangent stiffness at the reference positions, valid for small
        displacements. "nonlinear": Newton's method, with load steps if needed. The tangent
        stiffness must be positive definite in both.
    path
        Load path of a nonlinear equilibrium: increasing fractions that end at 1, or a function of t
        in [0, 1] that returns forces (N) and prescribed displacements (m), each of shape (n, d).
        Default: the whole load at once, and proportional steps if that fails.
    start
        Start of a nonlinear solve: an ``Equilibrium`` or a displacement (m) of shape (n, d). The
        out-of-balance force at the start is removed along the path.
    allow_folded
        True to accept flat or inverted cells in a nonlinear equilibrium. A linear result is never
        rejected for them; its field ``folded`` counts them.
    solver
        "direct": sparse factorisation, which detects instability with certainty. "multigrid":
        conjugate gradients with multigrid, with time and memory proportional to n. "auto": the
        factorisation for 2D, slender and small bodies and where multigrid fails, otherwise
        multigrid. Or a solver of this network from an earlier call.

    Returns
    -------
    Equilibrium
        Displacement (m), position (m) and reaction (N), each of shape (n, d), with the residual (N)
        and the estimated relative error.

    Raises
    ------
    ProblemError
        If a rigid-body motion is free (the message names it), or an argument is out of its range.
    SolverError
        If the network is a mechanism or unstable, no equilibrium is found at the full load, or
        cells are folded in a nonlinear equilibrium.

    Examples
    --------
    A bar in uniaxial tension has the elongation σ L / E, here 100 Pa · 0.4 m / 1e5 Pa:

    >>> from msvalidate import Box, Isotropic, Problem, Support, Traction
    >>> from msvalidate import equilibrium, lattice_network, square
    >>> bar = Box((0.4, 0.1))
    >>> roller = Support(bar.side("left"), (0.0, None))
    >>> guide = Support(bar.side("bottom"), (None, 0.0))
    >>> pull = Traction(bar.side("right"), (100.0, 0.0))
    >>> problem = Problem(bar, Isotropic(E=1e5, nu=1 / 3), supports=(roller, guide), loads=(pull,))
    >>> result = equilibrium(lattice_network(problem, square(bar, (8, 2))))
    >>> print(f"{result.displacement[:, 0].max():.6e} m")
    4.000000e-04 m
    """
    require_type("network", network, Network)
    refuse_free_motions("network", network.points, network.fixed)
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


def refuse_folded(network: Network, equilibrium: Equilibrium, title: str) -> None:
    """Raise `SolverError` if cells are folded, with their number and place."""
    simplices = network.simplices
    if equilibrium.folded and simplices is not None:
        folded = folded_cells(simplices, equilibrium.position)
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
    """Evaluate residual and reactions of an equilibrium at a displacement.

    It is (n, d) in m.

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
        reaction=np.where(network.fixed, -left, 0.0),
        residual=max_abs(left[~network.fixed]),
        iterations=iterations,
        error=error,
        folded=count_folded(network.simplices, position),
        passed_limit=passed_limit,
        solver=solver,
    )


def _solve_by(solver: Solver, solve: Callable[[], Equilibrium]) -> Equilibrium:
    """Solve with a solver, and with its factor if multigrid fails."""
    while True:
        try:
            return solve()
        except SolverError as error:
            # A factor goes on past tangents that are not positive, at which multigrid stops.
            stopped = solver.is_indefinite and not isinstance(error, NotConvergedError)
            if solver.is_direct or not (
                stopped or isinstance(error, NotConvergedError | InaccurateError)
            ):
                raise
            solver.fall_back_to_factor(error, MOST_ENTRIES if stopped else MOST_IN_NEED)


def _solve_linear(network: Network, solver: Solver) -> Equilibrium:
    found = refine_linear(network, solver)
    choice = None if network.fixed.all() else solver.choice
    u, steps = found.solution, 1 + found.steps
    return equilibrium_at(network, u, steps, error=found.error, solver=choice, linear=True)


def _solve_nonlinear(
    network: Network, solver: Solver, path: Path | None, begun: Array | None
) -> Equilibrium:
    """Nonlinear equilibrium at the end of a load path, refined.

    By default loads and prescribed displacements rise together from the reference points; a path
    function prescribes them otherwise. From a start (`begun`) without a path, the loads act in full
    and the initial imbalance is reduced to zero. If the default path of a prestressed network
    fails, rest lengths change from the present lengths to their own along another path.

    Raises `SolverError` if no stable equilibrium is found at the full load.
    """
    found = _follow_path(network, solver, path, begun)
    end = refine_equilibrium(network, found.displacement, found.factor, solver)
    return equilibrium_at(
        network,
        end.solution,
        found.solves + end.steps,
        error=end.error,
        passed_limit=found.passed_limit,
        solver=None if network.fixed.all() else solver.choice,
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


def _explain_failure(network: Network, solver: Solver, result: PathResult) -> str:
    """Explain why a load path cannot be continued."""
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
        f"nonlinear equilibrium: no stable equilibrium found beyond {result.reached:.4g} of the "
        f"{what} (after {result.solves} linear solves); {remedy}"
    )


def _explain_pivots(network: Network, solver: Solver) -> str:
    """Why the signs of pivots may be rounding at the reference points; empty where they are not."""
    if network.fixed.all():
        return ""
    try:
        found = solver.regular(Configuration(network))
    except SolverError:  # such as a rope, which stands by its tension alone
        return ""
    return "" if is_certain(found.softness) else explain_rounding(network, found.softness)
