"""Floor 2: constants fitted to displacements that another method found, where no closed form is.

Given load cases with wanted displacements, least squares over the constants p of K = Σ p_j K_j,
one K_j for each kind of spring and one for the cells' volumes, with exact slopes

    K u = f,   ∂u/∂p_j = -K⁻¹ K_j u.

A search by plain factors comes near. Then displacements and slopes are refined to their last digit
(`linear_solution`), the constants corrected by them, and the error that rounding leaves is stated:
a body long or soft multiplies the rounding of what is wanted by the slopes' condition.

Loads must be forces somewhere: prescribed displacements alone leave all constants open to a common
factor. What the load cases leave open is refused, by the singular values of the slopes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import OptimizeResult, least_squares, lsq_linear
from scipy.sparse import csr_array

from msvalidate.accurate import State
from msvalidate.lattice import Constants
from msvalidate.linear import factorised
from msvalidate.linear_solution import sensitive
from msvalidate.network import Network, tangent
from msvalidate.problem import (
    LONGEST,
    Array,
    Index,
    ProblemError,
    SolverError,
    coordinates,
    finite,
    instance,
    integers,
    refuse_free_motions,
)
from msvalidate.refine import HALF_A_UNIT

Evaluate = Callable[[list["_Case"], Array], tuple[Array, Array]]
"""Misfit (f,) and slopes (f, p) of load cases at constants (p,)."""

OPEN = 1e-10
"""Least singular value of the slopes, relative to the largest, above which all is determined:
displacements that are refined to half a unit then leave six digits."""
SINGULAR = 1e-13
"""The same at a place that is not the answer: slopes have no more digits."""
NOTHING = 0.99
"""Residual from which a fit is no better than no displacement at all, which has 1."""
LARGEST_ERROR = 1e-6
"""Error of a constant, over its own size, above which it is refused ..."""
BESIDE = 1e-9
"""... unless it is below this part of the largest constant: one that is nothing beside the others
has no size of its own."""
NEAR = 1e-9
"""Correction, over a constant or `BESIDE` the largest, from which none is made any more."""
FAR = 1e-3
"""Correction, over a constant, up to which slopes at one place serve for it."""
CORRECTIONS = 12
"""Corrections, after which they are taken not to end."""
FALLING = 0.7
"""Ratio of a correction to the one before it above which they do not fall."""
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
        Root mean square over the load cases of |u - wanted| over |wanted|, each a weighted norm.
    condition
        Largest over least singular value of the slopes by constants in units of the largest: how
        many times an error of the displacements may come back in some combination of constants.
    solves
        Times that all load cases were solved.
    errors
        Largest error (N/m) of each of `constants`: of what is wanted being doubles, right to half a
        unit of the largest displacement, of displacements and slopes here, and of corrections not
        made. What else is wrong of the wanted displacements comes back up to `condition` times.
    volume_error
        Of `volume`, likewise.
    """

    constants: Constants
    volume: float
    residual: float
    condition: float
    solves: int
    errors: Constants
    volume_error: float


@dataclass(frozen=True, eq=False)
class _Here:
    """Refined misfit (f,) and slopes (f, p) of all load cases, and the largest errors of both."""

    misfit: Array
    slope: Array
    noise: Array
    slope_noise: Array


@dataclass(frozen=True, eq=False)
class _Case:
    """A load case: the parts of its stiffness, its free components, and what is wanted there."""

    network: Network
    kind: Index
    states: tuple[State, ...]
    parts: tuple[csr_array, ...]
    free: Index
    prescribed: Array
    force: Array
    wanted: Array
    scale: Array


def fitted_constants(
    networks: Sequence[Network],
    wanted: Sequence[ArrayLike],
    kind: ArrayLike,
    *,
    weights: Sequence[ArrayLike] | None = None,
    start: Constants | None = None,
) -> Fit:
    """Constants with which networks come nearest to wanted displacements, in least squares.

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
    weights
        (n,) of the points, 0 or more, one array a network; by default all are 1.
    start
        Constants (N/m) to start from, above 0; by default equal ones that come nearest.

    Raises
    ------
    ProblemError
        If arrays do not fit, a network is loose, or load cases leave constants open: which ones.
    SolverError
        If no stable network is found, or none that comes nearer than no displacement at all; if
        rounding alone leaves a constant wrong by more than 1e-6 of it (and 1e-9 of the largest).
    """
    number = _kinds(networks, kind)
    cases = _cases(networks, wanted, np.asarray(kind), number, weights)
    with_volumes = networks[0].volumes is not None
    p = _start(cases, number, with_volumes, start)
    unit = float(p.max())
    rough = _nearest(cases, p / unit, unit, _plain)
    q, here, error, solves = _corrected(cases, rough.x, p / unit, unit, number)
    residual = float(np.linalg.norm(here.misfit) / np.sqrt(len(cases)))
    if residual > NOTHING:
        raise SolverError(
            f"fitted constants: a residual of {residual:.3g}, as of no displacement at all; look "
            "at the signs of what is wanted, or start from better constants"
        )
    condition = _determined(here.slope * q[:number].max(), number)
    _refuse_unknown(q, error, condition, number)
    k, wrong = (unit * q).tolist(), (unit * error).tolist()
    return Fit(
        constants=tuple(k[:number]),
        volume=k[number] if with_volumes else 0.0,
        residual=residual,
        condition=condition,
        solves=rough.nfev + solves,
        errors=tuple(wrong[:number]),
        volume_error=wrong[number] if with_volumes else 0.0,
    )


def _kinds(networks: Sequence[Network], kind: ArrayLike) -> int:
    """Number of kinds of spring, of networks that go together."""
    if not isinstance(networks, Sequence) or not networks:
        raise ProblemError("fitted constants: no network; give a list, one a load case")
    for network in networks:
        instance("network", network, Network)
        refuse_free_motions("network", network.points, network.held)
        if network.shear is not None:
            raise ProblemError("fitted constants: shear springs are not fitted; leave them out")
        length = np.linalg.norm(network.vector, axis=1)
        if np.abs(network.rest_length / length - 1).max() > 1e-9:
            raise ProblemError("fitted constants: a spring is stressed at rest; give none that is")
        if not np.array_equal(network.springs, networks[0].springs):
            raise ProblemError("fitted constants: the networks' springs differ; give the same")
        if (network.volumes is None) != (networks[0].volumes is None):
            raise ProblemError("fitted constants: volumes in some networks only; give all or none")
    found = integers("kind", kind)
    kinds = np.unique(found)
    m = len(networks[0].springs)
    if found.shape != (m,) or not np.array_equal(kinds, np.arange(len(kinds))):
        raise ProblemError(f"kind: {found.shape}; give ({m},), from 0 up without a gap")
    return len(kinds)


def _cases(
    networks: Sequence[Network],
    wanted: Sequence[ArrayLike],
    kind: Index,
    number: int,
    weights: Sequence[ArrayLike] | None,
) -> list[_Case]:
    weights = [np.ones(len(n.points)) for n in networks] if weights is None else weights
    for name, given in (("displacements", wanted), ("weights", weights)):
        count = len(given) if isinstance(given, Sequence | np.ndarray) else "no list of"
        if count != len(networks):
            raise ProblemError(
                f"fitted constants: {len(networks)} networks, {count} {name}; give as many of each"
            )
    cases = []
    for network, target, weight in zip(networks, wanted, weights, strict=True):
        u, w = coordinates("wanted displacement", target), finite("weights", weight)
        if u.shape != network.points.shape or w.shape != u.shape[:1] or w.min() < 0:
            raise ProblemError(
                f"wanted displacement {u.shape}, weights {w.shape}: give {network.points.shape} "
                "and one of 0 or more a point"
            )
        free = np.flatnonzero(~network.held.ravel())
        root = np.sqrt(np.repeat(w, network.dim))[free]
        root /= root.max(initial=0.0) or 1.0
        size = _norm(root * u.ravel()[free])
        if size < np.finfo(float).tiny:
            raise ProblemError(
                "wanted displacement: nothing that counts moves; give a load case that moves free "
                "points of weight above 0"
            )
        plain = replace(network, volumes=None)
        parts = [plain.scaled(1.0 * (kind == j)) for j in range(number)]
        if network.volumes is not None:
            parts.append(network.scaled(0.0))
        cases.append(
            _Case(
                network,
                kind,
                tuple(State(part) for part in parts),
                tuple(tangent(part, network.points) for part in parts),
                free,
                network.displacement.ravel(),
                network.force.ravel(),
                u.ravel()[free],
                root / size,
            )
        )
    return cases


def _norm(values: Array) -> float:
    """Euclidean norm, by the largest first: squares may leave the range of doubles."""
    largest = float(np.abs(values).max(initial=0.0))
    return largest * float(np.linalg.norm(values / largest)) if largest else 0.0


def _start(cases: list[_Case], number: int, volumes: bool, given: Constants | None) -> Array:
    """Constants to start from: those given, or the equal ones that come nearest under forces."""
    p = np.append(np.ones(number), np.zeros(int(volumes)))
    if given is not None:
        k = finite("start", given)
        if k.shape != (number,) or k.min() <= 1 / LONGEST or k.max() > LONGEST:
            raise ProblemError(
                f"start: {k.tolist()}; give {number} constants above 0, of ordinary size"
            )
        p[:number] = k
    answers = [_answer(case, p)[0] for case in cases]
    if not all(np.isfinite(answer).all() for answer in answers):
        raise ProblemError("fitted constants: the networks are loose; add springs, or hold more")
    wanted = np.concatenate([c.scale * c.wanted for c in cases])
    u = np.concatenate(answers)
    size = _norm(u)
    if size > LONGEST:
        raise ProblemError(
            f"wanted displacement: below what the networks move by at the start {size:.1g} times; "
            "choose units that give constants of ordinary size"
        )
    if given is not None:
        return p
    if not size:
        raise ProblemError("fitted constants: nothing moves the networks; load them by forces")
    factor = size / max(float(u / size @ wanted), np.finfo(float).tiny)
    return p * (factor if 1 / LONGEST <= factor <= LONGEST else 1.0)


def _nearest(cases: list[_Case], start: Array, unit: float, evaluate: Evaluate) -> OptimizeResult:
    """Least squares over constants in a unit of theirs; springs', the first, stay 0 or more."""
    last: list[tuple[Array, tuple[Array, Array]]] = []

    def at(q: Array) -> tuple[Array, Array]:
        if not last or not np.array_equal(last[0][0], q):
            last[:] = [(q.copy(), evaluate(cases, unit * q))]
        return last[0][1]

    # What is told badly has small slopes: refined, they are gone down to the end.
    limits = {"xtol": 1e-14, "ftol": 1e-15, "gtol": 1e-14 if evaluate is _plain else None}
    found = least_squares(
        lambda q: at(q)[0],
        start,
        lambda q: unit * at(q)[1],
        (_lowest(cases, len(start)), np.inf),
        **limits,
    )
    if not found.success:
        raise SolverError(
            f"fitted constants: not found in {found.nfev} steps, a residual of "
            f"{np.sqrt(2 * found.cost / len(cases)):.3g} is left; start from better ones"
        )
    return found


def _lowest(cases: list[_Case], count: int) -> Array:
    """The least that constants may be: 0 for springs, anything for cells."""
    springs = int(cases[0].kind.max()) + 1
    return np.where(np.arange(count) < springs, 0.0, -np.inf)


def _plain(cases: list[_Case], p: Array) -> tuple[Array, Array]:
    """Misfit and slopes by plain factors."""
    misfits, slopes = zip(*(_misfit(case, p) for case in cases), strict=True)
    return np.concatenate(misfits), np.concatenate(slopes)


def _exact(cases: list[_Case], p: Array) -> tuple[Array, Array]:
    """Misfit and slopes, refined; infinite where the network is not stable."""
    try:
        here = _refined(cases, p)
    except SolverError:
        f = sum(len(case.free) for case in cases)
        return np.full(f, np.inf), np.full((f, len(p)), np.inf)
    return here.misfit, here.slope


def _refined(cases: list[_Case], p: Array) -> _Here:
    """Misfit and slopes, refined, with their errors."""
    parts = [_refined_case(case, p) for case in cases]
    return _Here(
        *(
            np.concatenate([getattr(part, name) for part in parts])
            for name in ("misfit", "slope", "noise", "slope_noise")
        )
    )


def _refined_case(case: _Case, p: Array) -> _Here:
    network, springs = case.network, int(case.kind.max()) + 1
    cells = network.volumes
    if cells is not None:
        cells = replace(cells, stiffness=cells.stiffness * p[springs])
    stiffness = network.stiffness * p[:springs][case.kind]
    found = sensitive(replace(network, stiffness=stiffness, volumes=cells), case.states)
    u = found.solved.displacement.ravel()[case.free]
    moved, wished = (float(np.abs(x).max(initial=0.0)) for x in (u, case.wanted))
    # Constants times what springs were built with are rounded too, by half a unit.
    noise = (found.solved.error + HALF_A_UNIT) * moved + HALF_A_UNIT * wished
    slopes = [s.ravel()[case.free] for s in found.slopes]
    sizes = [e * float(np.abs(s).max()) for s, e in zip(slopes, found.errors, strict=True)]
    return _Here(
        case.scale * (u - case.wanted),
        case.scale[:, None] * np.column_stack(slopes),
        case.scale * noise,
        case.scale[:, None] * np.array(sizes),
    )


def _corrected(
    cases: list[_Case], q: Array, start: Array, unit: float, number: int
) -> tuple[Array, _Here, Array, int]:
    """Constants in a unit, what is there, their errors, and times solved: by refined slopes."""
    lowest, solves, before, fell = _lowest(cases, len(q)), 0, np.inf, 0.5
    for _ in range(CORRECTIONS):
        here = _refined(cases, unit * q)
        here = replace(here, slope=unit * here.slope, slope_noise=unit * here.slope_noise)
        solves += 1
        _determined(here.slope * q[:number].max(), number, SINGULAR)
        step = _correction(here, q, lowest)
        size = float(np.abs(step).max())
        fell = max(0.5, size / before) if before < np.inf else fell
        if _small(step, q, NEAR) or fell > FALLING:
            break
        if _small(step, q, FAR) or before < np.inf:
            # At 0 a network may be loose: a constant that is to vanish is left all but nothing.
            least = np.minimum(q, BESIDE / 4 * q.max())
            q, before = np.where(q + step > lowest, q + step, least), size
        else:
            # From the start again: plain factors may have led far astray.
            found = _nearest(cases, start, unit, _exact)
            q, solves, before = found.x, solves + found.nfev, size
    error = _error(here)
    left = np.abs(step) / (1 - min(fell, FALLING))
    if fell > FALLING and not _small(step, q, NEAR):  # unless it is rounding, none knows how far
        left = np.where(np.abs(step) <= error, left, np.inf)
    return q, here, error + left, solves


def _correction(here: _Here, q: Array, lowest: Array) -> Array:
    """Change of constants that slopes ask for, within their limits."""
    return np.asarray(lsq_linear(here.slope, -here.misfit, (lowest - q, np.inf), method="bvls").x)


def _error(here: _Here) -> Array:
    """Largest errors (p,) of constants by those of misfit and slopes, to first order."""
    inverse = np.linalg.pinv(here.slope)
    turned = here.slope_noise.T @ np.abs(here.misfit)
    return np.asarray(np.abs(inverse) @ here.noise + np.abs(inverse @ inverse.T) @ turned)


def _small(change: Array, q: Array, part: float) -> bool:
    """Whether changes are small beside each constant, or nothing beside the largest."""
    size = np.abs(q)
    return bool((np.abs(change) <= np.maximum(part * size, BESIDE * size.max())).all())


def _refuse_unknown(q: Array, error: Array, condition: float, number: int) -> None:
    """Raise `SolverError` where an error is too large."""
    if _small(error, q, LARGEST_ERROR):
        return
    wrong = error / np.maximum(np.abs(q), np.finfo(float).tiny)
    j = int(np.where(error > BESIDE * np.abs(q).max(), wrong, 0.0).argmax())
    name = f"k{j + 1}" if j < number else "κ"
    known = f"known to {wrong[j]:.1g} of it" if wrong[j] < 1 else "not known"
    raise SolverError(
        f"fitted constants: {name} is {known}, worse than {LARGEST_ERROR:g}: the slopes' condition "
        f"is {condition:.2g}; add a load case that tells it, take fewer cells along a slender "
        "body, or start from better constants"
    )


def _misfit(case: _Case, p: Array) -> tuple[Array, Array]:
    """Weighted misfit (f,) and its slopes (f, p); infinite where the network is not stable."""
    answer, slope = _answer(case, p)
    return answer - case.scale * case.wanted, slope


def _answer(case: _Case, p: Array) -> tuple[Array, Array]:
    """Weighted displacement (f,) and its slopes (f, p); infinite as in `_misfit`."""
    free = case.free
    K = csr_array(sum(part * value for part, value in zip(case.parts, p, strict=True)))
    nowhere = np.full(len(free), np.inf), np.full((len(free), len(p)), np.inf)
    try:
        factor = factorised(csr_array(K[free][:, free]))
    except RuntimeError:
        return nowhere
    if factor.negative:
        return nowhere
    u = case.prescribed.copy()
    u[free] = factor.solve(case.force[free] - (K @ case.prescribed)[free])
    slopes = [-factor.solve((part @ u)[free]) for part in case.parts]
    slope = case.scale[:, None] * np.column_stack(slopes)
    return case.scale * u[free], slope


def _determined(slope: Array, number: int, least: float = OPEN) -> float:
    """Condition of the slopes; refused with the names of the constants that they leave open."""
    _, values, ways = np.linalg.svd(slope, full_matrices=False)
    if values[-1] > least * values[0]:
        return float(values[0] / values[-1])
    part = np.abs(ways[values <= least * values[0]]).max(axis=0)
    names = [f"k{j + 1}" for j in range(number)] + ["κ"]
    said = [
        name for name, size in zip(names, part, strict=False) if size > WORTH_NAMING * part.max()
    ]
    raise ProblemError(
        f"fitted constants: the load cases leave {' and '.join(said)} open; add one that tells, "
        "with forces rather than prescribed displacements, or fit fewer"
    )
