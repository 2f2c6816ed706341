"""Constants fitted to displacements that another method found, where no closed form is.

Given load cases with wanted displacements, least squares over the constants p of K = Σ p_j K_j,
one K_j for each kind of spring and one for the cells' volumes, with exact slopes

    K u = f,   ∂u/∂p_j = -K⁻¹ K_j u.

Loads must be forces somewhere: prescribed displacements alone leave all constants open to a common
factor. What the load cases leave open is refused, by the singular values of the slopes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import OptimizeResult, least_squares
from scipy.sparse import bsr_array

from msvalidate.lattice import Constants
from msvalidate.linear_algebra.factor import Factor, NoMemoryError
from msvalidate.linear_algebra.norms import EPS
from msvalidate.network import Configuration, Network
from msvalidate.network.inverse import Solver
from msvalidate.network.multigrid import Cycles, NotConvergedError
from msvalidate.network.refine import LARGEST_ERROR
from msvalidate.problem import LONGEST, Array, Index, ProblemError, SolverError, refuse_free_motions
from msvalidate.problem.checks import finite_coordinates, integers, require_type
from msvalidate.problem.records import dataclass, replace
from msvalidate.statics.equilibrium import Equilibrium, equilibrium

OPEN = 1e-7
"""Least singular value of the slopes, relative to the largest, above which all is determined: some
1e-12 of rounding in displacements then leave five digits."""
NOTHING = 0.99
"""Residual from which a fit is no better than no displacement at all, which has 1."""
WORTH_HAVING = 1e-3
"""Part of the largest constant from which one is there."""
UNMOVED = 1e-10
"""What solutions of usual accuracy may move constants by, over the largest of these."""
CORRECTIONS = 6
PART = 1e-12
"""Of a displacement's error, left by multigrid."""
WORTH_NAMING = 0.1
"""Part of a constant in what is open, relative to the largest, from which it is named."""


@dataclass(frozen=True, eq=False)
class Fit:
    """Constants fitted to displacements.

    Parameters
    ----------
    constants
        Of the springs (N/m), one a kind, 0 or more.
    volume
        κ of the cells (N/m in the plane, Pa in space), 0 where they were not asked for.
    residual
        Root mean square over the load cases of |u - wanted| over |wanted|.
    condition
        Largest over least singular value of the slopes by constants in units of the largest: how
        many times an error of the displacements may come back in some combination of constants.
    solves
        Times that all load cases were solved.
    error
        Largest error of a constant over the largest constant, were what is wanted exact but for its
        rounding: what the errors of the solutions make of it. NaN where a constant has come to
        nothing and the network is loose without it.
    """

    constants: Constants
    volume: float
    residual: float
    condition: float
    solves: int
    error: float


@dataclass(frozen=True, eq=False)
class _Case:
    """A load case: its network, the parts of its stiffness, and what is wanted where it is free."""

    network: Network
    solver: Solver
    parts: tuple[bsr_array, ...]
    free: Index
    prescribed: Array
    force: Array
    wanted: Array
    scale: float


def fitted_constants(
    networks: Sequence[Network], wanted: Sequence[ArrayLike], kind: ArrayLike
) -> Fit:
    """Constants that fit given displacements of networks in least squares.

    Parameters
    ----------
    networks
        One a load case, with the same springs, unstressed, built with all constants 1 (springs'
        stiffness is then factor times weight), and with κ = 1 if that is to be fitted too: what is
        found multiplies what they were built with.
    wanted
        Displacements (n, d) in m, one array a network: held components do not count.
    kind
        (m,) class of each spring, 0 to the number of constants less one.

    Raises
    ------
    ProblemError
        If arrays do not fit, a network is loose, or load cases leave constants open: which ones.
    SolverError
        If no stable network is found, or none that comes nearer than no displacement at all.
    """
    number = _count_kinds(networks, kind)
    cases = _load_cases(networks, wanted, np.asarray(kind), number)
    with_volumes = len(cases[0].parts) > number
    p = _starting_constants(cases, number, with_volumes)
    unit = float(p.max())
    found = _least_squares(cases, p / unit, unit, number)
    if not found.success:
        raise SolverError(
            f"fitted constants: not found in {found.nfev} steps, a residual of "
            f"{np.sqrt(2 * found.cost / len(cases)):.3g} is left; take load cases that tell more"
        )
    residual = float(np.sqrt(2 * found.cost / len(cases)))
    if residual > NOTHING:
        raise SolverError(
            f"fitted constants: a residual of {residual:.3g}, as of no displacement at all; look "
            "at the signs of what is wanted"
        )
    condition = _check_determined(found.jac * found.x[:number].max(), number)
    constants, error = _correct_constants(
        networks, cases, np.asarray(kind), unit * found.x, found.jac
    )
    if error > LARGEST_ERROR:
        raise SolverError(
            f"fitted constants: known to {error:.1g} of the largest only, more than "
            f"{LARGEST_ERROR:g}: rounding of displacements comes back {condition:.1g} times in "
            "them; take a shorter body, or load cases that tell more"
        )
    return Fit(
        constants=tuple(constants[:number].tolist()),
        volume=float(constants[number]) if with_volumes else 0.0,
        residual=residual,
        condition=condition,
        solves=int(found.nfev),
        error=error,
    )


def _correct_constants(
    networks: Sequence[Network], cases: list[_Case], kind: Index, p: Array, slope: Array
) -> tuple[Array, float]:
    """Constants by refined solutions, and their error over the largest of them.

    `slope` is that of the misfit by constants in the unit that makes the largest of them about 1.
    A solution's error comes back as it would if it were wanted. Constants that are 0 stay so.
    """
    unit = float(p.max())
    inverse = np.where(p[:, None] > 0, np.linalg.pinv(slope), 0.0)
    for _ in range(CORRECTIONS):
        try:
            refined = [_refined_equilibrium(network, p, kind) for network in networks]
        except SolverError:  # without a constant that has come to nothing the network is loose
            if p.min() > WORTH_HAVING * unit:
                raise
            return p, math.nan
        u = [one.displacement.ravel()[case.free] for one, case in zip(refined, cases, strict=True)]
        plain = np.concatenate([_scaled_response(case, p)[0] for case in cases])
        exact = np.concatenate([case.scale * each for case, each in zip(cases, u, strict=True)])
        off = np.concatenate(
            [
                np.full(len(each), case.scale * max(one.error, EPS) * np.abs(each).max())
                for case, one, each in zip(cases, refined, u, strict=True)
            ]
        )
        rounding = float((np.abs(inverse) @ off).max())
        moved = inverse @ (exact - plain)
        if np.abs(moved).max() <= max(rounding, UNMOVED):
            return p, rounding + float(np.abs(moved).max())
        step = inverse @ (exact - np.concatenate([c.scale * c.wanted for c in cases]))
        if (unit * step >= p)[p > 0].any():  # nothing is known of a constant that rounding takes
            break
        p = p - unit * step
        if np.abs(step).max() <= max(rounding, UNMOVED):
            return p, rounding + float(np.abs(step).max())
    return p, max(float(np.abs(step).max()), rounding)


def _refined_equilibrium(network: Network, p: Array, kind: Index) -> Equilibrium:
    """The equilibrium with constants p, refined to the last digit."""
    cells = network.volumes
    volumes = cells and replace(cells, stiffness=float(p[-1]) * cells.stiffness)
    return equilibrium(replace(network, stiffness=p[kind] * network.stiffness, volumes=volumes))


def _count_kinds(networks: Sequence[Network], kind: ArrayLike) -> int:
    """Number of kinds of spring, of networks that go together."""
    if not isinstance(networks, Sequence) or not networks:
        raise ProblemError("fitted constants: no network; give a list, one a load case")
    for network in networks:
        require_type("network", network, Network)
        refuse_free_motions("network", network.points, network.held)
        if network.prestressed:
            raise ProblemError("fitted constants: a spring pulls at rest; give none that does")
        if not np.array_equal(network.springs, networks[0].springs):
            raise ProblemError("fitted constants: the networks' springs differ; give the same")
        if not np.array_equal(network.resisting, networks[0].resisting):
            raise ProblemError("fitted constants: volumes in some networks only; give all or none")
    found = integers("kind", kind)
    kinds = np.unique(found)
    m = len(networks[0].springs)
    if found.shape != (m,) or not np.array_equal(kinds, np.arange(len(kinds))):
        raise ProblemError(f"kind: {found.shape}; give ({m},), from 0 up without a gap")
    return len(kinds)


def _load_cases(
    networks: Sequence[Network], wanted: Sequence[ArrayLike], kind: Index, number: int
) -> list[_Case]:
    count = len(wanted) if isinstance(wanted, Sequence | np.ndarray) else "no list of"
    if count != len(networks):
        raise ProblemError(
            f"fitted constants: {len(networks)} networks, {count} displacements; give as many of "
            "each"
        )
    cases = []
    for network, target in zip(networks, wanted, strict=True):
        u = finite_coordinates("wanted displacement", target, *network.points.shape)
        free = np.flatnonzero(~network.held.ravel())
        largest = float(np.abs(u).max(initial=0.0)) or 1.0  # squares of small numbers are none
        size = largest * float(np.linalg.norm(u.ravel()[free] / largest))
        if not size:
            raise ProblemError(
                "wanted displacement: no free point moves; give a load case that moves some"
            )
        plain = replace(network, volumes=None)
        single = [plain.scaled(1.0 * (kind == j)) for j in range(number)]
        if network.volumes is not None:
            single.append(network.scaled(0.0))
        parts = [Configuration(each).tangent() for each in single]
        prescribed, force = network.displacement.ravel(), network.force.ravel()
        given = prescribed, force, u.ravel()[free], 1 / size
        cases.append(_Case(network, Solver(network), tuple(parts), free, *given))
    return cases


def _starting_constants(cases: list[_Case], number: int, volumes: bool) -> Array:
    """Constants to start from: the equal ones that come nearest under forces."""
    p = np.append(np.ones(number), np.zeros(int(volumes)))
    answers = [_scaled_response(case, p)[0] for case in cases]
    if not all(np.isfinite(answer).all() for answer in answers):
        raise ProblemError("fitted constants: the networks are loose; add springs, or hold more")
    wanted = np.concatenate([c.scale * c.wanted for c in cases])
    u = np.concatenate(answers)
    size = float(np.linalg.norm(u))
    if not size:
        raise ProblemError("fitted constants: nothing moves the networks; load them by forces")
    factor = size / max(float(u / size @ wanted), np.finfo(float).tiny)
    return p * (factor if 1 / LONGEST <= factor <= LONGEST else 1.0)


def _least_squares(cases: list[_Case], start: Array, unit: float, number: int) -> OptimizeResult:
    """Least squares over constants in a unit of theirs; springs', the first, stay 0 or more."""
    lowest = np.where(np.arange(len(start)) < number, 0.0, -np.inf)

    def misfit(q: Array) -> Array:
        return np.concatenate([_misfit(case, unit * q)[0] for case in cases])

    def slope(q: Array) -> Array:
        return unit * np.concatenate([_misfit(case, unit * q)[1] for case in cases])

    limits = {"xtol": 1e-14, "ftol": 1e-15, "gtol": 1e-14}
    return least_squares(misfit, start, slope, (lowest, np.inf), **limits)


def _misfit(case: _Case, p: Array) -> tuple[Array, Array]:
    """Scaled misfit (f,) and its slopes (f, p); infinite where the network is not stable."""
    answer, slope = _scaled_response(case, p)
    return answer - case.scale * case.wanted, slope


def _scaled_response(case: _Case, p: Array) -> tuple[Array, Array]:
    """Scaled displacement (f,) and its slopes (f, p); infinite as in `_misfit`."""
    free = case.free
    K = bsr_array(sum(part * value for part, value in zip(case.parts, p, strict=True)))
    nowhere = np.full(len(free), np.inf), np.full((len(free), len(p)), np.inf)
    try:
        inverse = case.solver.inverse(Configuration(case.network), K)
        if isinstance(inverse, Factor) and inverse.negative:
            return nowhere
        return _response_by_inverse(case, K, inverse)
    except NoMemoryError:
        raise
    except NotConvergedError as error:  # not stable, or no more than too much for multigrid
        try:
            case.solver.give_way(error)
        except SolverError:
            return nowhere
        return _scaled_response(case, p)
    except RuntimeError:  # a pivot of zero
        return nowhere


def _response_by_inverse(
    case: _Case, K: bsr_array, inverse: Factor | Cycles
) -> tuple[Array, Array]:
    """As `_scaled_response`, by the inverse of K."""
    free = case.free

    def solve(right: Array) -> Array:
        return inverse.solve(right) if isinstance(inverse, Factor) else inverse.solve(right, PART)

    u = case.prescribed.copy()
    u[free] = solve(case.force[free] - (K @ case.prescribed)[free])
    slopes = [-solve((part @ u)[free]) for part in case.parts]
    slope = case.scale * np.column_stack(slopes)
    return case.scale * u[free], slope


def _check_determined(slope: Array, number: int) -> float:
    """Condition of the slopes; refused with the names of the constants that they leave open."""
    _, values, ways = np.linalg.svd(slope, full_matrices=False)
    if values[-1] > OPEN * values[0]:
        return float(values[0] / values[-1])
    part = np.abs(ways[values <= OPEN * values[0]]).max(axis=0)
    names = [f"k{j + 1}" for j in range(number)] + ["κ"]
    said = [
        name for name, size in zip(names, part, strict=False) if size > WORTH_NAMING * part.max()
    ]
    raise ProblemError(
        f"fitted constants: the load cases leave {' and '.join(said)} open; add one that tells, "
        "with forces rather than prescribed displacements, or fit fewer"
    )
