"""Equilibria refined by the factor at hand, and the error that is stated of them.

What is out of balance comes from changes of length (`springs.network.configuration`). The tangent
needs no more than its usual digits, so one factor serves several corrections. To what the last of
them says of the error comes what rounding does to all of them alike, and, where the softest motion
meets so little that the factor may be wrong along it, how a motion that is known comes back.
"""

from __future__ import annotations

import math

import numpy as np

from msvalidate.linear_algebra.multigrid import Cycle
from msvalidate.linear_algebra.norms import EPS, max_abs
from msvalidate.problem import Array, SolverError
from msvalidate.problem.records import replace
from msvalidate.springs.network import Configuration, Network
from msvalidate.springs.network.inverse import Regular, Solver
from msvalidate.springs.network.multigrid import PART, ROUGHLY, Cycles, NotConvergedError
from msvalidate.springs.network.refine import (
    DOUBTFUL,
    STANDING,
    Refined,
    error_amplification,
    refine_solution,
    refuse_inaccurate,
)
from msvalidate.springs.network.residual import is_unloaded, out_of_balance_force, rounded_otherwise
from msvalidate.springs.network.stability import negative_modes
from msvalidate.springs.statics.tangents import LARGEST_TURN

SAME_TANGENT = 1e-3
"""Relative change of spring vectors up to which pivots keep their signs."""
FACTORS = 6
"""Tangents made at the most."""
CONVERGED = 1e-13
"""Error up to which no other tangent is made.

It is relative to the largest displacement.
"""
CYCLES_PART = 1e-4
"""Relative residual of a correction by conjugate gradients."""
ROUNDINGS = 16.0
"""Safety factor of the error from one sample of rounding in the forces."""
SMALLEST = float(np.finfo(float).smallest_subnormal)
SOFTEST_REFINED = 1e-14
"""Softness from which a factor's corrections are known to fall."""
ALIKE = 100.0
"""Ratio of stiffnesses up to which messages do not mention it."""


class _System:
    """Residual of a network at displacements, and the inverse of a tangent.

    `linear`: forces are those of the inverse's configuration, and change by its tangent.
    """

    def __init__(self, network: Network, factorised: Regular, *, linear: bool) -> None:
        self.network, self.factorised, self.linear = network, factorised, linear
        self.free = ~network.fixed

    def residual(self, u: Array, network: Network | None = None) -> Array:
        """Residual force (n, d) in N on the free components.

        The displacement is (n, d) in m. A second `network` has other springs and cells, while the
        loads remain those of the first.
        """
        network = network or self.network
        if not self.linear:
            force = Configuration(network, u).force()
        else:
            own = network is self.network
            at = (
                self.factorised.at
                if own
                else Configuration(network, self.factorised.at.displacement)
            )
            force = at.force() + at.force_change(u - at.displacement)
        return np.where(self.free, force + self.network.force, 0.0)

    def change(self, motion: Array) -> Array:
        """Change of this force by a small motion (n, d) in m."""
        return np.where(self.free, self.factorised.at.force_change(motion), 0.0)

    def solve(self, force: Array, part: float = PART) -> Array:
        """Motion (n, d) in m under a force (n, d) in N, by the inverse.

        `part` is the relative residual of conjugate gradients.
        """
        motion, inverse = np.zeros(force.shape), self.factorised.inverse
        if not np.isfinite(force).all():
            raise SolverError(
                "equilibrium: forces beyond all numbers; choose units that give ordinary forces"
            )
        load = force[self.free]
        motion[self.free] = (
            inverse.solve(load, part) if isinstance(inverse, Cycles) else inverse.solve(load)
        )
        return motion

    def refined(self, start: Array, solved: float = 0.0) -> Refined:
        """Corrections from a start (n, d) in m, and the whole error."""
        rate = self.factorised.rate
        found = refine_solution(self.residual, self.solve, start, rate, solved)
        scale = max_abs(found.solution)
        if not scale:
            return replace(found, error=math.inf if self.residual(found.solution).any() else 0.0)
        if not math.isfinite(found.error):
            return found
        times = 1.0
        if rate > DOUBTFUL:
            # Of all kinds at once, the softest among them.
            motion = np.random.default_rng(0).normal(size=self.free.shape) * self.free
            own = self.factorised.mode.reshape(motion.shape)
            known = motion / np.abs(motion).max() + own / np.abs(own).max()
            times = error_amplification(self.change, self.solve, rate, known)
        left = self.residual(found.solution, rounded_otherwise(self.network))
        rounded = max_abs(self.solve(left, ROUGHLY)) / scale
        lost = 8 * EPS + SMALLEST / scale
        return replace(found, error=times * found.error + ROUNDINGS * rounded + lost)


def refine_linear(network: Network, solver: Solver) -> Refined:
    """The linear equilibrium from the reference points: one inverse, and corrections.

    Raises `SolverError` if the network is a mechanism or unstable, or no trustworthy digits are
    left.
    """
    prescribed = np.array(network.displacement)
    if network.fixed.all():
        return Refined(prescribed, 0.0, 0)
    found = solver.regular(Configuration(network))
    why = explain_rounding(network, found.softness)
    if negative_modes(found):
        if not (network.prestressed or network.volumes):
            # Springs at rest resist every motion or none: the sign is rounding.
            refuse_inaccurate(math.inf, "linear equilibrium", why)
        remedy = "relieve its prestress" if network.prestressed else "stiffen its cells"
        raise SolverError(
            "linear equilibrium: the network is unstable at its reference points (its tangent "
            f"stiffness has a negative mode); {remedy} or hold it better"
        )
    if is_unloaded(network):
        return Refined(prescribed, 0.0, 0)
    system = _System(network, found, linear=True)
    first = system.solve(system.residual(prescribed))
    refined = system.refined(prescribed + first, max_abs(first))
    refuse_inaccurate(refined.error, "linear equilibrium", why)
    return refined


def refine_equilibrium(
    network: Network, displacement: Array, factorised: Regular | None, solver: Solver
) -> Refined:
    """The equilibrium near a displacement (n, d) in m, refined, and its error.

    `factorised` is the inverse of the tangent there, where it is at hand; `solver` makes others.

    Raises `SolverError` if the network is a mechanism or unstable there, or no trustworthy digits
    are left.
    """
    title = "nonlinear equilibrium"
    u = np.where(network.fixed, network.displacement, displacement)
    if network.fixed.all() or (is_unloaded(network) and not u.any()):
        return Refined(u, 0.0, 0)
    before, best, steps = Configuration(network, u), math.inf, 0
    for _ in range(FACTORS):
        factorised = factorised or solver.regular(Configuration(network, u))
        refined = _System(network, factorised, linear=False).refined(u)
        turn = factorised.at.largest_rotation(refined.solution - factorised.at.displacement)
        steps += refined.steps
        _refuse_far(turn)
        u, last = refined.solution, factorised
        if turn <= SAME_TANGENT and not CONVERGED < refined.error < STANDING * best:
            break
        best, factorised = refined.error, None
    _refuse_far(before.largest_rotation(refined.solution - before.displacement))
    error = refined.error if turn <= SAME_TANGENT else math.inf
    refuse_inaccurate(error, title, explain_rounding(network, last.softness))
    if negative_modes(last):
        raise SolverError(
            f"{title}: the network is unstable under its full load; reduce the load or stiffen "
            "the network"
        )
    return replace(refined, steps=steps)


def error_of_displacement(
    network: Network, displacement: Array, cycle: Cycle | None = None
) -> float:
    """Estimate the relative error of a displacement close to an equilibrium.

    The displacement is (n, d) in m, its error relative to the largest displacement.

    By corrections that are not applied; infinite where none can be made. Of a large body multigrid
    makes one, by `cycle` if that is one of a tangent close by, and a factor where it does not.
    """
    size = max_abs(displacement)
    if network.fixed.all():
        return 0.0
    force = np.where(network.fixed, 0.0, out_of_balance_force(network, displacement))
    if not size:
        return math.inf if force.any() else 0.0
    at, solver = Configuration(network, displacement), Solver(network, cycle=cycle)
    try:
        if not solver.is_direct:
            try:
                return _error_by_multigrid(at, force, solver) / size + 8 * EPS
            except NotConvergedError as error:
                solver.fall_back_to_factor(error)
        system = _System(network, solver.regular(at), linear=False)
        moved = system.refined(displacement)
    except SolverError:
        return math.inf
    apart = 1.01 * max_abs(moved.solution - displacement)
    return (apart + moved.error * max_abs(moved.solution)) / size


def _error_by_multigrid(at: Configuration, force: Array, solver: Solver) -> float:
    """Error (m) of a displacement that leaves a force (n, d) in N, by one correction."""
    K = at.tangent()
    system = _System(at.network, Regular(at, solver.inverse(at, K), K.diagonal()), linear=False)
    other = out_of_balance_force(rounded_otherwise(at.network), at.displacement) - force
    step, rounded = (max_abs(system.solve(each, CYCLES_PART)) for each in (force, other))
    return 2 * step + ROUNDINGS * rounded


def explain_rounding(network: Network, softness: float) -> str:
    """Explain a rounding error: ratio of stiffnesses, softest mode and remedy."""
    k = np.abs(network.axial_stiffness[network.axial_stiffness != 0])
    apart = float(k.max() / k.min()) if len(k) else 1.0
    # What the softest motion of a slender body meets falls as the fourth power of its cells.
    share = min((abs(softness) / SOFTEST_REFINED) ** 0.25, 1.0)
    remedies = []
    if share < 1 and apart < ALIKE:
        remedies.append(f"take {share:.1g} of the cells along a slender body")
    if network.prestressed:
        remedies.append("take a load that prestress does not hide")
    if apart >= ALIKE or not remedies:
        remedies.append("bring stiffnesses closer together")
    start = f"stiffnesses are {apart:.1g} times apart, and " if apart >= ALIKE else ""
    return (
        f"{start}the softest motion meets {abs(softness):.1g} of what its points meet one by one; "
        f"{', or '.join(remedies)}"
    )


def _refuse_far(turn: float) -> None:
    if not turn <= LARGEST_TURN:
        raise SolverError(
            f"nonlinear equilibrium: corrections turn a spring by {turn:.2g} of its length: "
            "rounding hides the equilibrium; take a smaller load, or stiffnesses that are closer "
            "together"
        )
