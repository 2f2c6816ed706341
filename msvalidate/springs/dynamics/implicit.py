"""Solvers of an implicit time step: accelerations, and increments by Newton's method.

A scheme whose new acceleration depends on the new position x + δ asks for the δ of

    p·δ - q·a(x + δ) = b,    p = 1 + O(h·c), q = O(h²),

with the Jacobian p - q·∂a/∂x: of a network the matrix p·m + q·K, K its tangent stiffness.

Source: [Newmark1959]; Newton's iterations as in [Bathe2014], chapter 9.5.
"""

from __future__ import annotations

from typing import Protocol, TypeGuard

import numpy as np
from scipy.sparse import csr_array, diags_array

from msvalidate.linear_algebra.factor import Factor, factorise
from msvalidate.linear_algebra.norms import EPS, max_abs
from msvalidate.problem import LONGEST, Array, ProblemError, SolverError
from msvalidate.springs.dynamics.scheme import Acceleration
from msvalidate.springs.network import Configuration, Network
from msvalidate.springs.network.ground import Ground
from msvalidate.springs.network.inverse import elimination_order
from msvalidate.springs.network.residual import out_of_balance_force

MOST = 30
"""Maximum number of Newton iterations in one step.

A fresh tangent is made only after a correction above `SLOW` times the one before.
"""
SLOW = 0.1
"""Ratio of two corrections that indicates an outdated tangent or rounding."""
ROUNDED = 1e-9
"""Correction with a fresh tangent over the largest coordinate that rounding may leave: where stiff
parts stand beside soft ones the rounding of forces moves these by more than that of positions."""


class ConvergenceError(SolverError):
    """Newton's method did not converge."""


class SolvableAcceleration(Protocol):
    """Acceleration that can also be solved for its displacement.

    `linear` says whether one solution with the Jacobian is exact.
    """

    linear: bool

    def __call__(self, x: Array) -> Array:
        """Acceleration (n, d) in m/s² at displacements (n, d) in m."""

    def solve(
        self, x: Array, residual: Array, p: Array | float, q: float, /, *, fresh: bool
    ) -> Array:
        """Solve (p - q·∂a/∂x)·δ = residual for δ in m.

        Unless `fresh`, ∂a/∂x may be that of an earlier x.
        """


class ModeAcceleration:
    """Accelerations -ω²x of uncoupled modes with one frequency.

    `omega` is their angular frequency in rad/s.
    """

    linear = True

    def __init__(self, omega: float) -> None:
        self.omega = omega

    def __call__(self, x: Array) -> Array:
        """Acceleration (n, d) in m/s² at displacements (n, d) in m."""
        return np.asarray(-(self.omega**2) * x)

    def solve(self, _: Array, residual: Array, p: Array | float, q: float, **__: bool) -> Array:
        """The δ in m of (p + q·ω²)·δ = residual."""
        return np.asarray(residual / (p + q * self.omega**2))


class NetworkAcceleration:
    """Accelerations (n, d) in m/s² of the free components of a network.

    They are a function of displacements (n, d) in m.
    """

    linear = False

    def __init__(self, network: Network, ground: Ground | None = None) -> None:
        self.network, self.ground = network, ground
        self.free = ~network.fixed
        self._factor: tuple[Factor, float] | None = None

    def __call__(self, x: Array) -> Array:
        """Acceleration (n, d) in m/s² at a displacement; zero where the network is held."""
        if not (np.abs(x) <= LONGEST).all():  # nor where it is NaN
            raise SolverError(f"motion: positions beyond {LONGEST:g} m; take smaller steps")
        force = out_of_balance_force(self.network, x)
        if self.ground is not None:
            force[self.ground.points] += self.ground.push(x[self.ground.points])
        pull = force / self.network.mass[:, None]
        return np.where(self.free, pull, 0)

    def solve(self, x: Array, residual: Array, p: Array | float, q: float, *, fresh: bool) -> Array:
        """Solve (p·m + q·K)·δ = m·residual for δ (n, d) in m.

        δ is zero on fixed components.
        """
        if not np.isfinite(residual).all():
            raise SolverError("implicit step: it is beyond all numbers; take smaller steps")
        mass = np.broadcast_to(self.network.mass[:, None], x.shape)
        if fresh or self._factor is None or self._factor[1] != q:
            K = csr_array(Configuration(self.network, x).tangent())
            A = csr_array(diags_array((p * mass).ravel()) + q * K)
            free = np.flatnonzero(self.free.ravel())
            order = elimination_order(self.network)
            try:
                self._factor = factorise(csr_array(A[free][:, free]), order), q
            except RuntimeError as error:  # singular, as K is where the body is free
                raise SolverError(
                    f"implicit step: masses are lost in rounding beside {q:.3g} s² times the "
                    "stiffness; take smaller steps"
                ) from error
        found = np.zeros_like(x)
        found[self.free] = self._factor[0].solve((mass * residual)[self.free])
        return found


def increment(
    acceleration: Acceleration, x: Array, a: Array, b: Array, p: Array | float, q: float
) -> tuple[Array, Array]:
    """The δ of p·δ - q·a(x + δ) = b, and a(x + δ).

    `x` and `a` are the position (m) and the acceleration (m/s²) there, `b`, `p` and `q` in m, 1 and
    s²; p is one number, or one a component.

    Raises `ProblemError` if the acceleration is a plain function; `ConvergenceError` if Newton's
    method does not converge; `SolverError` if the step is beyond what numbers hold.
    """
    if not _is_solvable(acceleration):
        raise ProblemError(
            "acceleration: a plain function; an implicit scheme needs one that it can solve, as "
            "`springs.dynamics.implicit.NetworkAcceleration`"
        )
    if acceleration.linear:
        move = acceleration.solve(x, b + q * a, p, q, fresh=False)
        return move, acceleration(x + move)
    move, before, fresh = np.zeros_like(b), np.inf, False
    for _ in range(MOST):
        correction = acceleration.solve(x + move, b + q * a - p * move, p, q, fresh=fresh)
        move = move + correction
        a = acceleration(x + move)
        size, left = max(max_abs(move), max_abs(x)), max_abs(correction)
        if left <= 4 * EPS * size or (fresh and left <= ROUNDED * size):
            return move, a
        before, fresh = left, left > SLOW * before
    raise ConvergenceError(
        f"implicit step: a move of {max_abs(move):.1g} m is still corrected by {left:.1g} m after "
        f"{MOST} Newton iterations; take smaller steps"
    )


def _is_solvable(acceleration: object) -> TypeGuard[SolvableAcceleration]:
    return hasattr(acceleration, "solve")
