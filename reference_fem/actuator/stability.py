"""How near a soft slab is to pulling in, and by which motion: eigenvalues of field against body.

At a fixed voltage the slab is stable where K_mech - K_elec is positive, so where the gains, the
eigenvalues of K_elec v = g K_mech v, are below 1. The largest gives the motion that is lost first.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import ArpackError, LinearOperator, eigsh

from msvalidate.problem import Array, ProblemError, SolverError
from msvalidate.problem.checks import positive_number, require_type, whole_number
from msvalidate.problem.records import dataclass
from reference_fem.actuator.actuated import ActuatedSlab, solve_actuated
from reference_fem.actuator.soft_slab import SoftSlab
from reference_fem.systems.factor import Apply, signed_factor

NUDGE = 1e-5
"""Movement, relative to the slab's height, of a difference of two fields."""
GAIN_TOLERANCE = 1e-4
"""What an eigenvector leaves, relative to its gain: the gain is as good, often to the square."""
STRIDE = 0.05
"""Relative change of a voltage, at most, from one of its gains to the next."""
NEAR_ONE = 1e-3
"""Difference of a gain from 1 at which the voltage of a loss is known: to a fifth of it, as gains
go with the fifth power of the voltage there."""
MOST_VOLTAGES = 30


def stiffness_gains(held: ActuatedSlab, count: int = 1) -> tuple[Array, Array]:
    """How near a slab is to pulling in: the largest eigenvalues of K_elec against K_mech.

    Over all motions that the supports leave, at a fixed voltage: below 1 the slab is stable, at 1
    it pulls in, by the mode that goes with it. K_elec is the derivative of Maxwell's forces, here
    by central differences of them.

    Parameters
    ----------
    held
        An equilibrium.
    count
        How many.

    Returns
    -------
    gains
        (count,), the largest first.
    modes
        (count, m, 2) in m, the largest movement of each 1.

    Raises
    ------
    ProblemError
        If the count is out of range, or the equilibrium is at 0 V.
    SolverError
        If they are not found.
    """
    require_type("held", held, ActuatedSlab)
    if not held.voltage:
        raise ProblemError("gains: held is at 0 V, where no field pulls; give one at a voltage")
    unknowns = len(held.actuator.solid.free)
    whole_number("count of gains", count, 1, unknowns - 1)
    K, inverse = _body_tangent(held)
    shape = (unknowns, unknowns)
    try:
        values, modes = eigsh(
            LinearOperator(shape, lambda way: _field_tangent(held, way), dtype=float),
            count,
            K,
            which="LA",
            Minv=LinearOperator(shape, inverse, dtype=float),
            v0=inverse(np.random.default_rng(0).normal(size=unknowns)),
            tol=GAIN_TOLERANCE,
        )
    except ArpackError as error:
        raise SolverError(f"actuator: its gains are not found at {held.voltage:g} V") from error
    order = np.argsort(-values, kind="stable")
    fields = np.array([_moved(held, modes[:, i] / np.abs(modes[:, i]).max()) for i in order])
    return values[order], fields


def _body_tangent(held: ActuatedSlab) -> tuple[csr_matrix, Apply]:
    """K_mech (f, f) in N/m of the free components, and its inverse."""
    solid = held.actuator.solid
    K = solid.tangent(held.displacement)[solid.free][:, solid.free]
    K.sort_indices()
    try:
        return K, signed_factor(K)[0]
    except RuntimeError as error:
        raise SolverError(
            f"actuator: the body alone has a motion without stiffness at {held.voltage:g} V"
        ) from error


def _field_tangent(held: ActuatedSlab, way: Array) -> Array:
    """K_elec (f, f) in N/m times a movement (f,) in m, by a difference of two fields."""
    actuator, u = held.actuator, held.displacement
    nudge = NUDGE * actuator.slab.height
    far = nudge / max(np.abs(way).max(), np.finfo(float).tiny) * _moved(held, way.ravel())
    change = actuator.electric(u + far).forces - actuator.electric(u - far).forces
    size = np.abs(way).max() / (2 * nudge)
    return np.asarray(held.voltage**2 * size * change.T.ravel()[actuator.solid.free])


def _moved(held: ActuatedSlab, way: Array) -> Array:
    """Displacement (m, 2) of a movement (f,) of the free components, both in m."""
    solid = held.actuator.solid
    each = np.zeros(solid.held.size)
    each[solid.free] = way
    return solid.by_node(each)


@dataclass(frozen=True, eq=False)
class StabilityLoss:
    """Where the first motion loses its stiffness.

    Parameters
    ----------
    voltage
        In V.
    mode
        (m, 2) in m, its largest movement 1.
    held
        The equilibrium there.
    """

    voltage: float
    mode: Array
    held: ActuatedSlab


def first_instability(actuator: SoftSlab, start: ActuatedSlab) -> StabilityLoss:
    """The voltage at which the largest gain reaches 1, above a stable equilibrium `start`.

    By secants of its logarithm over that of the voltage.

    Raises
    ------
    SolverError
        If it is not found: no equilibrium there, or gains that do not rise.
    """
    require_type("start", start, ActuatedSlab)
    found, steps = (
        start,
        [(math.log(positive_number("start's voltage", start.voltage)), _log_gain(start))],
    )
    slope = 2.0  # of charges that stay where they are
    for _ in range(MOST_VOLTAGES):
        if abs(steps[-1][1]) <= NEAR_ONE:
            return StabilityLoss(found.voltage, stiffness_gains(found)[1][0], found)
        ahead = min(max(-steps[-1][1] / slope, -STRIDE), STRIDE)
        found = solve_actuated(actuator, "voltage", math.exp(steps[-1][0] + ahead), found)
        steps.append((math.log(found.voltage), _log_gain(found)))
        slope = (steps[-1][1] - steps[-2][1]) / (steps[-1][0] - steps[-2][0])
        if not slope > 0:
            break
    raise SolverError(
        f"actuator: its gain does not rise to 1; it is {math.exp(steps[-1][1]):.4g} at "
        f"{found.voltage:.6g} V"
    )


def _log_gain(held: ActuatedSlab) -> float:
    return math.log(max(float(stiffness_gains(held)[0][0]), np.finfo(float).tiny))
