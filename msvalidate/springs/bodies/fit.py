"""Constants fitted to displacements that another method found, where no closed form is.

Given load cases with wanted displacements, least squares over the constants p of K = Σ p_j K_j,
one K_j for each kind of spring and one for the cells' volumes, with exact slopes

    K u = f,   ∂u/∂p_j = -K⁻¹ K_j u.

Loads must be forces somewhere: prescribed displacements alone leave all constants open to a common
factor. What the load cases leave open is refused, by the singular values of the slopes.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import OptimizeResult, least_squares
from scipy.sparse import bsr_array

from msvalidate.linear_algebra.factor import Factor, NoMemoryError
from msvalidate.linear_algebra.norms import EPS
from msvalidate.problem import LONGEST, Array, Index, ProblemError, SolverError, refuse_free_motions
from msvalidate.problem.checks import finite_coordinates, integers, require_type
from msvalidate.problem.records import dataclass, replace
from msvalidate.springs.lattice import Constants
from msvalidate.springs.network import Configuration, Network
from msvalidate.springs.network.inverse import Once
from msvalidate.springs.network.refine import LARGEST_ERROR
from msvalidate.springs.statics.equilibrium import equilibrium

OPEN = 1e-7
"""Smallest relative singular value of the derivatives for a determined fit.

Rounding of 1e-12 in displacements then leaves five digits.
"""
NOTHING = 0.99
"""Relative residual from which a fit is no better than zero displacement."""
WORTH_HAVING = 1e-3
"""Smallest relative constant that is not at its bound of 0."""
PART = 1e-12
"""Relative error of derivatives computed by multigrid."""
WORTH_NAMING = 0.1
"""Smallest relative part of a constant in an undetermined combination to name it."""


@dataclass(frozen=True, eq=False)
class Fit:
    """Result of a fit of spring constants to displacements.

    Parameters
    ----------
    constants
        Spring constants (N/m), one per class, >= 0.
    volume
        Volume stiffness κ of the cells (N/m in 2D, Pa in 3D), 0 if it was not fitted.
    residual
        Root mean square, over the load cases, of the relative misfit of the displacements.
    condition
        Condition number of the derivatives, with the constants in units of the largest: the largest
        amplification of an error in the displacements.
    error
        Estimated largest error of a constant, relative to the largest constant, if the given
        displacements are exact up to rounding.
    """

    constants: Constants
    volume: float
    residual: float
    condition: float
    error: float


@dataclass(frozen=True, eq=False)
class _Case:
    """Load case: its network, the parts of its stiffness, and the target displacements."""

    network: Network
    kind: Index
    solver: Once
    parts: tuple[bsr_array, ...]
    displacement: Array
    scale: float


def fitted_constants(
    networks: Sequence[Network], displacements: Sequence[ArrayLike], kind: ArrayLike
) -> Fit:
    """Fit spring constants to given displacements by least squares.

    The squared differences of the displacements K⁻¹ f are minimised over the constants p of
    K = Σ p_j K_j, with the exact derivatives -K⁻¹ K_j u.

    Parameters
    ----------
    networks
        One network per load case, all with the same springs, n points and zero prestress, built
        with all spring constants equal to 1. To fit a volume energy as well, build them with κ = 1.
    displacements
        One array of displacements (m) of shape (n, d) per network; fixed components are ignored.
    kind
        Class of each spring, shape (m,), numbered from 0.

    Returns
    -------
    Fit
        Spring constants (N/m), one per class, the volume stiffness κ if it was fitted, the relative
        residual, the condition number and the estimated error.

    Raises
    ------
    ProblemError
        If the arrays do not fit, a network can move rigidly, or the load cases leave a constant
        undetermined.
    SolverError
        If the iteration fails, no stable network fits better than zero displacement, or the
        constants are too sensitive to rounding.

    Examples
    --------
    >>> from msvalidate import Box, Isotropic, Problem, Support, Traction
    >>> from msvalidate import equilibrium, fitted_constants, lattice_network, square
    >>> box = Box((0.4, 0.1))
    >>> clamp = Support(box.side("left"), (0.0, 0.0))
    >>> pull = Traction(box.side("right"), (100.0, 0.0))
    >>> problem = Problem(box, Isotropic(E=1e5, nu=1 / 3), supports=(clamp,), loads=(pull,))
    >>> lattice = square(box, (4, 1))
    >>> target = equilibrium(lattice_network(problem, lattice)).displacement
    >>> unit = lattice_network(problem, lattice, (1.0, 1.0))
    >>> fit = fitted_constants([unit], [target], lattice.kind)
    >>> print(", ".join(f"{k:.0f}" for k in fit.constants), "N/m")
    75000, 37500 N/m
    """
    number = _count_kinds(networks, kind)
    cases = _load_cases(networks, displacements, np.asarray(kind), number)
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
    condition = _check_determined(found.jac * float(found.x[:number].max()), number)
    constants = unit * found.x
    off = np.concatenate([_respond(case, constants).off for case in cases])
    largest = float(found.x[:number].max())
    free = (found.x > WORTH_HAVING * largest) | (np.arange(len(found.x)) >= number)
    inverse = np.linalg.pinv(found.jac[:, free])
    error = float((np.abs(inverse @ found.fun) + np.abs(inverse) @ off).max()) / largest
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
        error=error,
    )


def _count_kinds(networks: Sequence[Network], kind: ArrayLike) -> int:
    """Number of kinds of spring, of networks that go together."""
    if not isinstance(networks, Sequence) or not networks:
        raise ProblemError("fitted constants: no network; give a list, one a load case")
    for network in networks:
        require_type("network", network, Network)
        refuse_free_motions("network", network.points, network.fixed)
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
    networks: Sequence[Network], displacements: Sequence[ArrayLike], kind: Index, number: int
) -> list[_Case]:
    count = len(displacements) if isinstance(displacements, Sequence | np.ndarray) else "no list of"
    if count != len(networks):
        raise ProblemError(
            f"fitted constants: {len(networks)} networks, {count} displacements; give as many of "
            "each"
        )
    cases = []
    for network, target in zip(networks, displacements, strict=True):
        u = finite_coordinates("wanted displacement", target, *network.points.shape)
        free = np.flatnonzero(~network.fixed.ravel())
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
        solver = Once(network, "auto")
        cases.append(_Case(network, kind, solver, tuple(parts), u.ravel()[free], 1 / size))
    return cases


def _starting_constants(cases: list[_Case], number: int, volumes: bool) -> Array:
    """Equal spring constants, and κ = 0, from which a fit starts.

    Their shape is (number,), or (number + 1,) with a volume energy. Their common factor is the one
    whose displacements are nearest to the reference if only forces act. It is 1 if that factor is
    not between 1/`LONGEST` and `LONGEST`.

    Raises `ProblemError` if a network has no stable equilibrium, or if nothing moves any of them.
    """
    p = np.append(np.ones(number), np.zeros(int(volumes)))
    answers = [_respond(case, p).move for case in cases]
    if not all(np.isfinite(answer).all() for answer in answers):
        raise ProblemError("fitted constants: the networks are loose; add springs, or hold more")
    wanted = np.concatenate([c.scale * c.displacement for c in cases])
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
        return np.concatenate(
            [_respond(case, unit * q).move - case.scale * case.displacement for case in cases]
        )

    def slope(q: Array) -> Array:
        return unit * np.concatenate([_respond(case, unit * q).slope for case in cases])

    limits = {"xtol": 1e-14, "ftol": 1e-15, "gtol": 1e-14}
    return least_squares(misfit, start, slope, (lowest, np.inf), **limits)


class _Response(NamedTuple):
    """Scaled displacement (f,), its slopes (f, p), and its error (f,); infinite if not stable."""

    move: Array
    slope: Array
    off: Array


def _respond(case: _Case, p: Array) -> _Response:
    """Response of a load case to constants p."""
    cells, free = case.network.volumes, np.flatnonzero(~case.network.fixed.ravel())
    network = replace(
        case.network,
        stiffness=p[case.kind] * case.network.stiffness,
        volumes=cells and replace(cells, stiffness=float(p[-1]) * cells.stiffness),
    )
    case.solver.renew()
    try:
        found = equilibrium(network, solver=case.solver)
    except NoMemoryError:
        raise
    except SolverError:
        nowhere = np.full(len(free), np.inf)
        return _Response(nowhere, np.full((len(free), len(p)), np.inf), nowhere)
    inverse = case.solver.regular(Configuration(network)).inverse

    def solve(right: Array) -> Array:
        return inverse.solve(right) if isinstance(inverse, Factor) else inverse.solve(right, PART)

    u = found.displacement.ravel()
    slope = np.column_stack([-solve((part @ u)[free]) for part in case.parts])
    move = case.scale * u[free]
    off = np.full(len(free), max(found.error, EPS) * np.abs(move).max())
    return _Response(move, case.scale * slope, off)


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
