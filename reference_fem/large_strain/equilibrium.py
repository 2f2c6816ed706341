"""Solids at large strain at rest under dead loads: Newton's method in parts of the load.

    ∫ P(F):∂φ/∂X dX = f,    F = I + ∂u/∂X,

with nodal forces f that keep their size and direction. The last part of the load has the loads and
supports asked for; the first starts from an equilibrium, so that a part small enough stays near
one.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from msvalidate.linear_algebra.factor import factorise
from msvalidate.problem import Array, ProblemError, SolverError, UnstableError
from msvalidate.problem.checks import positive_number, require_type, whole_number
from msvalidate.problem.records import ReadOnly, dataclass
from reference_fem.effort import fits_in_memory
from reference_fem.large_strain.solid import Solid
from reference_fem.locking import refuse_locked
from reference_fem.systems.refined import LEAST, Vectors
from reference_fem.systems.solver import ACCEPTED, refuse_shapes

TOLERANCE = 1e-11
"""Residual at which Newton's method stops, relative to the largest sum of the forces that cancel at
a node: quadratic convergence usually leaves rounding, 1e-15."""
SETTLED = 1e-7
"""Correction that the tangent makes of the residual left, relative to the displacement, up to which
Newton's method may stop. In slender bodies the residual alone hardly knows of bending."""
NEAR = 1e-3
"""Strain of a last step up to which the tangent where it began tells of the end: a tangent changes
by a few times the strain. A longer step may land on an equilibrium, such as a uniform strain, at
once."""
ITERATIONS = 20
"""Newton steps that a part of the load may take: far more than quadratic convergence needs."""
FEW = 5
"""Newton steps up to which the next part of the load is made twice as large."""
LEAST_PART = 2.0**-10
SHORTENINGS = 8
"""Maximum number of bisections of a Newton step before the load step is reduced."""
DESCENT = 0.8
"""Largest relative slope of the energy at the end of a step.

Above it the step is too long or changes direction ([Crisfield1991], section 9.2).
"""


@dataclass(frozen=True, eq=False)
class LargeStrainSolution(ReadOnly):
    """A body at rest at large strain, in a stable equilibrium under its loads.

    Stable: the tangent was positive here, or where a last step of `NEAR` or less began.

    Parameters
    ----------
    solid
        The body.
    displacement
        (n, d) in m.
    reaction
        (n, d) force (N) of the supports on the held components, 0 elsewhere.
    residual
        Largest force left on a free component, relative to the forces that cancel there.
    iterations, parts
        Linear solves, and parts of the load, that it took.
    error
        Largest error of a displacement as the solution of the discrete equations, relative to the
        largest displacement: twice what the last tangent makes of the forces left, and the
        rounding of constants.
    """

    solid: Solid
    displacement: Array
    reaction: Array
    residual: float
    iterations: int
    parts: int
    error: float

    def at(self, points: ArrayLike) -> Array:
        """Displacement (p, d) in m at points (p, d) of the undeformed body.

        Raises
        ------
        ProblemError
            If a point lies outside the body.
        """
        return np.asarray(self.solid.body.interpolation(points) @ self.displacement)


def deform(
    solid: Solid,
    displacement: Array,
    force: Array,
    *,
    start: Array | None = None,
    parts: int = 1,
    least_part: float = LEAST_PART,
    tolerance: float = TOLERANCE,
    allow_locked: bool = False,
) -> LargeStrainSolution:
    """Equilibrium of a body at large strain.

    Newton's method raises loads and prescribed displacements together, from what holds `start` in
    place to what is asked for, and halves a part of the load in which it does not converge, a cell
    turns inside out, or the tangent has a negative mode: the branch it is on then has no stable
    equilibrium there, or one further off than a step reaches.

    Parameters
    ----------
    solid
        The body and its supports.
    displacement
        (n, d) in m, prescribed where components are held.
    force
        (n, d) in N, over the whole thickness; dead loads.
    start
        (n, d) in m to start from; None from rest.
    parts
        Equal parts of the load to begin with.
    least_part
        Part of the load that is not halved any more.
    tolerance
        Residual to stop at, relative to the forces that cancel at a node.
    allow_locked
        Answer also where elements of the first degree lock (`locking`).

    Raises
    ------
    ProblemError
        If an argument is of another shape, or `start` turns a cell inside out.
    UnstableError
        If there is no stable equilibrium to be found; the message says up to which part of the load
        there was, and what stopped it.
    SolverError
        If the elements lock, or rounding takes too many digits.
    """
    require_type("solid", solid, Solid)
    whole_number("parts of the load", parts, 1)
    positive_number("least part of the load", least_part)
    positive_number("tolerance", tolerance)
    begin = np.zeros(solid.body.points.shape) if start is None else start
    refuse_shapes(solid.body, displacement=displacement, force=force, start=begin)
    for name, given in (("displacement", displacement), ("force", force), ("start", begin)):
        if not np.isfinite(given).all():
            raise ProblemError(f"{name}: holds values that are not finite; give numbers")
    if not solid.is_upright(begin) or solid.turned(begin) is not None:
        raise ProblemError(
            "start: turns a cell inside out; start from an equilibrium, or from rest"
        )
    how = _Steps(1 / parts, least_part, tolerance)
    if not allow_locked:
        for tensor in solid.at_rest:
            refuse_locked(solid.body, tensor)
    # What has no numbers is not upright, and refused as such.
    with fits_in_memory(len(begin), "nodes"), np.errstate(over="ignore", invalid="ignore"):
        return _follow_load(solid, begin, displacement, force, how)


@dataclass(frozen=True)
class _Steps:
    """Load steps: first and smallest fraction, and the tolerance of the residual."""

    first: float
    least: float
    tolerance: float


def _out_of_balance(solid: Solid, balance: Array, sizes: Array) -> tuple[float, float]:
    """Largest force left on a free component, and largest sum of those that cancel there, in N."""
    largest = np.abs(balance[~solid.held]).max(initial=0.0)
    return float(largest), float(sizes.max(initial=0.0))


def _follow_load(
    solid: Solid, start: Array, displacement: Array, force: Array, how: _Steps
) -> LargeStrainSolution:
    """Equilibrium at the whole load.

    What holds the start in place is not asked for: it is the load to begin with.
    """
    first = solid.internal_force(start)[0]
    u, reached, iterations, parts, part, error = start, 0.0, 0, 0, how.first, 0.0
    while reached < 1:
        target = min(1.0, reached + part)
        wanted = np.where(solid.held, (1 - target) * start + target * displacement, 0.0)
        load = (1 - target) * first + target * force
        found, steps, why, error = _newton(solid, u, wanted, load, how.tolerance)
        iterations += steps
        if found is None:
            part = (target - reached) / 2
            if part < how.least:
                raise UnstableError(
                    f"finite strain: no stable equilibrium found beyond {reached:.4g} of the load: "
                    f"{why}; reduce the load, or take another mesh: a finer one reaches less far "
                    "at corners pressed against a clamp, where elements have no limit",
                    reached,
                )
            continue
        u, reached, parts = found, target, parts + 1
        if steps <= FEW:
            part *= 2
    inner, sizes = solid.internal_force(u)
    reaction = np.where(solid.held, inner - force, 0.0)
    left, scale = _out_of_balance(solid, force - inner, sizes + np.abs(force))
    return LargeStrainSolution(
        solid, u, reaction, left / scale if scale else 0.0, iterations, parts, error
    )


def _newton(
    solid: Solid, u: Array, wanted: Array, load: Array, tolerance: float
) -> tuple[Array | None, int, str, float]:
    """Stable equilibrium under a load, None if there is none near; solves; why none; error."""
    near = SETTLED * max(1.0, tolerance / TOLERANCE)
    error = np.inf
    inner, sizes = solid.internal_force(u)
    for steps in range(1, ITERATIONS + 1):
        ahead = np.where(solid.held, wanted - u, 0.0)
        balance = load - inner
        step, negative, inverse = _step(solid, u, balance, ahead)
        if step is None or negative:
            _refuse_at_rest(u)
            count = "motions" if negative > 1 else "a motion"
            return None, steps, f"the tangent has {count} without stiffness", np.inf
        u_next = _line_search(solid, u, step, load, balance, bool(ahead.any()))
        if u_next is None:
            return None, steps, "a step would turn a cell inside out or not descend", np.inf
        before, u = u, np.where(solid.held, wanted, u_next)  # to the last bit
        inner, sizes = solid.internal_force(u)
        left, scale = _out_of_balance(solid, load - inner, sizes + np.abs(load))
        if left <= max(tolerance * scale, solid.rounding(u)):
            error = _error(solid, u, load - inner, inverse)
            if error > near and steps < ITERATIONS:
                continue
            if error > max(ACCEPTED, near):
                break
            cell = solid.turned(u)
            if cell is not None:
                return None, steps, f"cell {cell} is turned inside out at a node", np.inf
            if _largest_strain(solid, u - before) > NEAR and not _is_stable(solid, u):
                return None, steps, "the tangent has a motion without stiffness", np.inf
            return u, steps, "", error
    if np.isfinite(error):
        raise SolverError(
            f"finite strain: displacements are known to {error:.1g} of the largest only, wanted "
            f"{ACCEPTED:g}: rounding rules in a body so slender; take fewer and longer cells"
        )
    return None, ITERATIONS, f"Newton's method did not converge in {ITERATIONS} steps", np.inf


def _error(solid: Solid, u: Array, balance: Array, inverse: Vectors | None) -> float:
    """Twice what a tangent makes of the forces left, relative to the displacement, and `LEAST`."""
    largest = float(np.abs(u).max())
    if inverse is None or not largest:
        return 0.0
    return 2 * float(np.abs(inverse(balance.T.ravel()[solid.free])).max()) / largest + LEAST


def _largest_strain(solid: Solid, step: Array) -> float:
    """Largest change (1) of a cell's extent in a step (n, d) in m, each over the cell's least."""
    cells, points = solid.body.cells, solid.body.points
    extent = np.ptp(points[cells], axis=1).min(axis=1)
    return float((np.ptp(step[cells], axis=1).max(axis=1) / extent).max(initial=0.0))


def _is_stable(solid: Solid, u: Array) -> bool:
    """Return True if the tangent at u (n, d) in m is positive definite."""
    nothing = np.zeros(u.shape)
    step, negative, _ = _step(solid, u, nothing, nothing)
    return step is not None and not negative


def _refuse_at_rest(u: Array) -> None:
    """A tangent that is not positive before there is any load is no matter of the load."""
    if not u.any():
        raise SolverError(
            "finite strain: the tangent at rest has a motion without stiffness: the law has none "
            "there, or the body is too slender for so many cells and rounding rules; take a law "
            "with stiffness in every strain, or fewer and longer cells"
        )


def _step(
    solid: Solid, u: Array, balance: Array, ahead: Array
) -> tuple[Array | None, int, Vectors | None]:
    """Newton step (n, d) in m, held ones moving as `ahead` says; negative modes; inverse."""
    K, free = solid.tangent(u), solid.free
    step = ahead.T.ravel().copy()
    if len(free):
        A = K[free][:, free]
        A.sort_indices()
        try:
            factor = factorise(A, np.arange(len(free)))
            if factor.is_exchanged:  # a pivot was zero: signs tell nothing
                return None, 0, None
            inverse, negative = factor.solve, factor.negative
        except (ArithmeticError, RuntimeError):
            return None, 0, None
        step[free] = inverse((balance.T.ravel() - K @ step)[free])
        if not np.isfinite(step).all():
            return None, negative, inverse
        return solid.by_node(step), negative, inverse
    return solid.by_node(step), 0, None


def _line_search(
    solid: Solid, u: Array, step: Array, load: Array, balance: Array, moving: bool
) -> Array | None:
    """Displacement (n, d) after as much of a step as descends; None if none of it does.

    A step in which held components move must be taken as a whole.
    """
    free = ~solid.held
    slope = float(balance[free] @ step[free])
    share = 1.0
    for _ in range(1 if moving else SHORTENINGS):
        trial = u + share * step
        if solid.is_upright(trial):
            if moving:
                return np.asarray(trial)
            left = load - solid.internal_force(trial)[0]
            if abs(float(left[free] @ step[free])) <= DESCENT * abs(slope):
                return np.asarray(trial)
            if np.abs(left[free]).max() <= solid.rounding(trial):  # no slope tells any more
                return np.asarray(trial)
        share /= 2
    return None
