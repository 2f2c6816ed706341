"""Natural frequencies of a network, from its assembled tangent and its masses."""

from __future__ import annotations

import math
import warnings
from typing import NamedTuple

import numpy as np
from scipy.linalg import eigvalsh
from scipy.sparse import csr_array, diags_array, eye_array
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import ArpackError, LinearOperator, eigsh, lobpcg

from msvalidate.linear_algebra.factor import NO_NUMBER, factorise
from msvalidate.linear_algebra.multigrid import Cycle
from msvalidate.problem import Array, ProblemError, SolverError, rigid_motions
from msvalidate.problem.checks import (
    finite_number,
    format_value,
    require_one_of,
    require_type,
)
from msvalidate.springs.network import Configuration, Network
from msvalidate.springs.network.inverse import SOLVERS, Solver, connected_pairs, elimination_order
from msvalidate.springs.network.multigrid import (
    NotConvergedError,
    free_force,
    make_cycle,
    restrained_tangent,
)

DENSE = 600
"""Degrees of freedom up to which a dense solver is the faster one."""
LARGEST_DENSE = 10_000
"""Degrees of freedom of the largest dense matrix made, close to a gigabyte."""
FEW = 40
"""Lowest frequencies that large networks are asked for without a factor."""
SAME = 1e-9
"""Smallest relative singular value of independent rigid-body motions."""
RIGID = 1e-9
"""Square of a rigid motion's frequency over the highest, that is rounding."""
UNSURE = 1e-11
"""Ratio of the lowest to the highest squared frequency that leaves five digits.

Below it the energy of the mode is computed.
"""
SWEEPS = 8
"""Inverse iterations on a few modes more than are asked for."""
FIRST_STEPS, MOST_STEPS = 5, 200
"""Number of first and of all iterations for large networks.

The first ones separate a squared frequency from its neighbours.
"""


class NaturalFrequencies(NamedTuple):
    """Lowest natural frequencies of a network and the highest one.

    Parameters
    ----------
    lowest
        Angular frequencies (rad/s), shape (count,), in ascending order.
    highest
        Angular frequency (rad/s) that limits the time step.
    """

    lowest: Array
    highest: float


def natural_frequencies(
    network: Network,
    count: int = 10,
    *,
    tolerance: float = 0.0,
    cycle: Cycle | None = None,
    rigid: bool = False,
    solver: str = "auto",
) -> NaturalFrequencies:
    """Compute the lowest natural frequencies and the highest one of a network.

    The undamped eigenvalue problem K φ = ω² M φ is solved on the free degrees of freedom, with a
    lumped mass matrix and the tangent stiffness at the reference positions, geometric stiffness
    included. If rounding of the highest eigenvalue hides a low one, the elastic energy of its mode
    shape determines it. Source: [Rayleigh1877]; the generalised eigenvalue problem,
    [GolubVanLoan2013], section 8.7.

    Parameters
    ----------
    network
        Network with at least one free component.
    count
        Number of lowest frequencies, at most the number of free components.
    tolerance
        Relative error of ω² at which the iteration for large networks stops; 0 iterates to
        rounding.
    cycle
        Multigrid cycle of this or a similar network, if there is one.
    rigid
        True to allow free rigid-body motions: each counts as a frequency of exactly 0.
    solver
        "auto", "direct" or "multigrid", as for `equilibrium`; it matters for large networks only.

    Returns
    -------
    NaturalFrequencies
        The `count` lowest angular frequencies (rad/s) in ascending order, and the highest one.

    Raises
    ------
    ProblemError
        If an argument is out of its range, every component is fixed, or a rigid-body motion is free
        and `rigid` is False.
    SolverError
        If a mode has negative or zero stiffness, the iteration fails, or a rigid-body motion
        changes the energy because the network is not in equilibrium.

    Examples
    --------
    The first longitudinal mode of a clamped bar has the frequency π/2 √(E/ρ)/L:

    >>> import numpy as np
    >>> from msvalidate import Box, Isotropic, Problem, Region, Support
    >>> from msvalidate import lattice_network, natural_frequencies, square
    >>> bar = Box((0.4, 0.1))
    >>> clamp = Support(bar.side("left"), (0.0, 0.0))
    >>> guide = Support(Region((None, None)), (None, 0.0))  # longitudinal motion only
    >>> problem = Problem(bar, Isotropic(E=1e5, nu=1 / 3), supports=(clamp, guide))
    >>> network = lattice_network(problem, square(bar, (16, 4)))
    >>> frequencies = natural_frequencies(network, 1)
    >>> speed = np.sqrt(1e5 / (1 - 1 / 9) / 1000.0)  # m/s, without lateral contraction
    >>> print(f"{frequencies.lowest[0] / (np.pi / 2 * speed / 0.4):.3f}")
    1.000
    """
    require_type("network", network, Network)
    require_type("rigid", rigid, bool)
    matrix = _dynamical_matrix(network)
    size = matrix.shape[0]
    if not 0 <= finite_number("tolerance of the frequencies", tolerance) < 1:
        raise ProblemError(
            f"tolerance of the frequencies: {tolerance}; give a relative error, 0 <= tolerance < 1"
        )
    counted = isinstance(count, int | np.integer) and not isinstance(count, bool)
    if not (counted and 1 <= count <= size):
        raise ProblemError(
            f"count: {format_value(count)} frequencies; this network has {size} free components"
        )
    require_one_of("solver", solver, SOLVERS)
    zero = _rigid_motions(network, allowed=rigid)
    if size <= max(DENSE, 4 * count):
        squares = _dense_squares(matrix, count)
        lowest, highest = squares[:count], squares[-1]
    else:
        highest = _largest_square(matrix, tolerance)
        way = Solver(network, solver)
        asked = count, zero, highest, tolerance
        lowest = _lowest_of_large(way, network, cycle, matrix, asked)
    if lowest[0] < -1e-10 * highest:
        raise SolverError(
            f"natural frequencies: omega² = {lowest[0]:g} 1/s²; the network is unstable there"
        )
    lowest = _separate_rounding(network, lowest, highest, zero)
    return NaturalFrequencies(np.sqrt(np.maximum(lowest, 0.0)), float(np.sqrt(highest)))


def _lowest_of_large(
    solver: Solver,
    network: Network,
    cycle: Cycle | None,
    matrix: csr_array,
    task: tuple[int, int, float, float],
) -> Array:
    """Lowest squares (count,); `task` are their count, rigid motions, the highest, a tolerance."""
    count, zero, highest, tolerance = task
    if count > FEW or zero:
        solver.refuse_too_large(f"natural frequencies: {count} of a body with {zero} rigid motions")
    elif not solver.is_direct:
        try:
            return _smallest_by_multigrid(network, cycle, matrix, count, highest, tolerance)
        except NotConvergedError as error:
            solver.fall_back_to_factor(error)
    return _smallest_squares(network, matrix, count, highest, tolerance)


def _rigid_motions(network: Network, *, allowed: bool) -> int:
    """Number of rigid motions that supports leave to parts that hang together on their own."""
    n = len(network.points)
    i, j = connected_pairs(network).T
    graph = csr_array((np.ones(len(i)), (i, j)), shape=(n, n))
    parts, part = connected_components(graph, directed=False)
    count = 0
    for label in range(parts):
        own = np.flatnonzero(part == label)
        held = network.fixed[own]
        if parts > 1 and held.all():
            continue
        apart = network.points[own] - network.points[own].mean(axis=0)
        motions = rigid_motions(apart / (np.abs(apart).max(initial=0.0) or 1.0))
        left = _rank(motions.reshape(-1, motions.shape[2])) - _rank(motions[held])
        if left and not allowed:
            whole = "the network" if len(own) == n else f"the part of point {own[0]}"
            raise ProblemError(
                f"natural frequencies: {whole} is free to move as a rigid body in {left} ways; "
                "hold one more component against each, or allow rigid motions"
            )
        count += left
    return count


def _rank(motions: Array) -> int:
    sizes = np.linalg.svd(motions, compute_uv=False) if motions.size else np.zeros(1)
    return int((sizes > SAME * max(float(sizes[0]), 1.0)).sum())


def _separate_rounding(network: Network, squares: Array, highest: float, zero: int) -> Array:
    """Lowest squared frequencies (count,) in 1/s², without values that are rounding.

    The first `zero` of them, of rigid motions, become exact zeros. Raises `SolverError` if one of
    these is too large for that, or if rounding hides a soft mode of a body with rigid motions.

    Eigenvalues are rounded by an eps of the highest. The energies of modes are not: they are summed
    spring by spring, and a mode's error counts by its square.
    """
    squares = squares.copy()
    if (np.abs(squares[:zero]) > RIGID * highest).any():
        raise SolverError(
            f"natural frequencies: omega² = {np.abs(squares[:zero]).max():g} 1/s² of a rigid "
            "motion; the network is not at rest there"
        )
    squares[:zero] = 0.0
    soft = int((squares[zero:] < UNSURE * highest).sum())
    if not soft:
        return squares
    if zero:
        raise SolverError(
            f"natural frequencies: omega² = {squares[zero]:.3g} 1/s² beside {highest:.3g} 1/s² is "
            "rounding: a slender body, stiffnesses or masses far apart, or a mechanism; hold the "
            "body, and energies of its modes will tell"
        )
    squares[:soft] = _squares_by_energy(network, soft)
    return squares


def _squares_by_energy(network: Network, count: int) -> Array:
    """The lowest squares from the energies of their modes, by inverse iteration on a few more."""
    inside = np.flatnonzero(~network.fixed.ravel())
    at = Configuration(network)
    factor = Solver(network).regular(at).inverse
    mass = np.repeat(network.mass, network.dim)[inside]
    few = min(count + 4, len(inside))
    modes = np.random.default_rng(0).normal(size=(len(inside), few))
    for _ in range(SWEEPS):
        modes = np.column_stack([factor.solve(mass * mode) for mode in modes.T])
        modes = np.linalg.qr(np.sqrt(mass)[:, None] * modes)[0] / np.sqrt(mass)[:, None]
    energies = modes.T @ np.column_stack([free_force(at, mode) for mode in modes.T])
    return np.asarray(eigvalsh((energies + energies.T) / 2)[:count])


def extreme_frequencies(
    network: Network, *, tolerance: float = 0.0, cycle: Cycle | None = None
) -> tuple[float, float]:
    """Lowest and highest natural frequency (rad/s); see `natural_frequencies`."""
    lowest, highest = natural_frequencies(network, 1, tolerance=tolerance, cycle=cycle)
    return float(lowest[0]), highest


def highest_frequency(network: Network, *, tolerance: float = 0.0) -> float:
    """Highest natural frequency (rad/s) at the reference points; see `natural_frequencies`.

    It needs no factor and no stability, and sets the limit of most time steps by itself.
    """
    matrix = _dynamical_matrix(network)
    if matrix.shape[0] <= DENSE:
        return float(np.sqrt(max(eigvalsh(matrix.toarray())[-1], 0.0)))
    return float(np.sqrt(_largest_square(matrix, tolerance)))


def _dynamical_matrix(network: Network) -> csr_array:
    """M^(-1/2) K M^(-1/2) on the free components."""
    free = np.flatnonzero(~network.fixed.ravel())
    if not len(free):
        raise ProblemError("natural frequencies: every component is held; nothing can move")
    scale = diags_array(1 / np.sqrt(np.repeat(network.mass, network.dim)[free]))
    stiffness = csr_array(Configuration(network).tangent())[free][:, free]
    with np.errstate(over="ignore", invalid="ignore"):
        matrix = csr_array(scale @ stiffness @ scale)
    largest, stiffest = float(abs(matrix).max()), float(abs(stiffness).max())
    if not math.isfinite(largest) or (stiffest and largest < NO_NUMBER):
        raise SolverError(
            f"natural frequencies: stiffnesses of {stiffest:.3g} N/m with masses from "
            f"{network.mass.min():.3g} to {network.mass.max():.3g} kg; choose units that give "
            "ordinary frequencies"
        )
    return matrix


def _dense_squares(matrix: csr_array, count: int) -> Array:
    """Every square, by a dense solver, unless the matrix is too large to be dense."""
    size = matrix.shape[0]
    if size > LARGEST_DENSE:
        raise ProblemError(
            f"count: {count} frequencies of {size}; ask for fewer than a quarter of them, or "
            f"of a network with at most {LARGEST_DENSE} free components"
        )
    return np.asarray(eigvalsh(matrix.toarray()))


def _largest_square(matrix: csr_array, tolerance: float) -> float:
    # A fixed start makes the last digits the same from run to run.
    start = np.random.default_rng(0).normal(size=matrix.shape[0])
    try:
        value = eigsh(matrix, k=1, which="LA", v0=start, tol=tolerance, return_eigenvectors=False)
        return float(value[0])
    except ArpackError as error:
        raise SolverError(f"highest natural frequency: the iteration failed ({error})") from error


def _smallest_squares(
    network: Network, matrix: csr_array, count: int, highest: float, tolerance: float
) -> Array:
    # The shift keeps the factor regular when a mode has no stiffness, and costs no accuracy there.
    start = np.random.default_rng(0).normal(size=matrix.shape[0])
    shift = -1e-9 * highest
    try:
        shifted = csr_array(matrix - shift * eye_array(matrix.shape[0]))
        factor = factorise(shifted, elimination_order(network))
        if factor.negative:
            # Modes near zero are not the lowest then; the smallest one tells how unstable it is.
            softest = eigsh(matrix, k=1, which="SA", v0=start, return_eigenvectors=False)
            return np.asarray(softest)
        inverse = LinearOperator(matrix.shape, factor.solve)
        values = eigsh(
            matrix,
            count,
            sigma=shift,
            OPinv=inverse,
            v0=start,
            tol=tolerance,
            return_eigenvectors=False,
        )
    except (ArpackError, RuntimeError) as error:
        raise SolverError(f"lowest natural frequencies: the iteration failed ({error})") from error
    return np.sort(values)


def _smallest_by_multigrid(
    network: Network,
    cycle: Cycle | None,
    matrix: csr_array,
    count: int,
    highest: float,
    tolerance: float,
) -> Array:
    """By multigrid; where its making finds the network unstable, how much so."""
    at = Configuration(network)
    A = restrained_tangent(at)
    cycle = cycle or make_cycle(A, at)
    if cycle.indefinite_motion is None:
        inside = np.flatnonzero(~network.fixed.ravel())
        root, of_stiffness = np.sqrt(np.repeat(network.mass, network.dim)[inside]), cycle

        def applied(residual: Array) -> Array:
            force = np.zeros(network.fixed.size)
            force[inside] = root * residual.ravel()
            return np.asarray(root * of_stiffness(force)[inside])

        inverse = LinearOperator(matrix.shape, matvec=applied, dtype=float)
        return _smallest_of_many(matrix, inverse, count, highest, tolerance)
    weight = np.repeat(network.mass, network.dim) @ cycle.indefinite_motion**2
    return np.array([cycle.indefinite_motion @ (A @ cycle.indefinite_motion) / weight])


def _smallest_of_many(
    matrix: csr_array, inverse: LinearOperator, count: int, highest: float, tolerance: float
) -> Array:
    """Without a factor: locally optimal conjugate gradients, by multigrid.

    The error of a square is that of its residual squared over the gap to the next (Kato), so a
    tenth of the tolerance's root is asked of the residual; rounding is of the highest square.

    Source: [Knyazev2001].
    """
    modes = np.random.default_rng(0).normal(size=(matrix.shape[0], count))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # of residuals, which are judged below
        squares, modes = lobpcg(matrix, modes, M=inverse, largest=False, maxiter=FIRST_STEPS)
        least = float(np.abs(squares).min())
        allowed = max(0.1 * math.sqrt(tolerance) * least, 10 * np.finfo(float).eps * highest)
        squares, modes = lobpcg(
            matrix, modes, M=inverse, largest=False, maxiter=MOST_STEPS, tol=allowed
        )
    left = float(np.linalg.norm(matrix @ modes - modes * squares, axis=0).max())
    if not left <= 2 * allowed:  # its last digits are rounding
        raise NotConvergedError(
            f"lowest natural frequencies: residual {left:.3g} 1/s² of squares, where {allowed:.3g} "
            "is asked: the lowest are close to rounding of the highest; ask for fewer of them"
        )
    return np.sort(squares)
