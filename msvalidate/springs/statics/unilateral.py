"""Unilateral contact forces as a convex problem in the candidate points.

The minimum of ½ f·C f + f·g0 over f >= 0, where forces f open gaps g = g0 + C f: there g >= 0 and
f·g = 0. Obstacles of a given force have Σ f w = P beside, w the part of each force along their way,
and go deeper by δ, which takes δ w from the gaps. By conjugate gradients in the points that touch,
restarted when others come in. Source: [PolonskyKeer1999].
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from msvalidate.problem import Array, Index, Mask, SolverError
from msvalidate.problem.records import dataclass

CLOSED = 1e-10
"""Gap or penetration that counts as zero, relative to the depth."""
EXACT, MORE = 1e-14, 6
"""Relative tolerance with an exact C, and extra steps after a tenth of `CLOSED`.

The iteration stops at either; the tolerance is relative to the depth.
"""
ROUNDING = float(np.finfo(float).eps)
"""Relative rounding of the largest gap, which hides a small depth."""
APPLICATIONS = 2000
"""Maximum number of iterations, each with one or two products with C.

Usually 30 to 60 products suffice.
"""


@dataclass(eq=False)
class Unilateral:
    """Contact problem, with the largest penetration `depth` (m) without contact forces.

    Parameters
    ----------
    follow
        Forces (c,) in N -> what the gaps (c,) in m grow by; it may be inexact.
    gap, start
        Gaps (c,) in m under forces (c,) in N to start from: what is inexact counts by how far
        forces change.
    along, which
        Part (c,) of each force along its obstacle's way, and which obstacle that is.
    prescribed_force
        Force (N) of each obstacle, NaN where its depth is given.
    """

    follow: Callable[[Array], Array]
    gap: Array
    start: Array
    along: Array
    which: Index
    prescribed_force: Array
    depth: float = 0.0

    def solve(self, within: float) -> tuple[Array, Array]:
        """Forces (c,) in N, and how much deeper (m) each obstacle goes that is pressed.

        It stops at the part `within` of the first violation, or else where there is none.

        Raises `SolverError` if it does not get there, or an obstacle is pressed so hard that
        nothing bears it.
        """
        free = self._gap_at(np.zeros_like(self.start))
        force = self._begin(free)
        full, t, square, keep = self._gap_at(force), np.zeros_like(force), 1.0, False
        enough, closed, left = None, 0, np.inf
        for _ in range(APPLICATIONS):
            on = force > 0
            raised = self._mean(full, on)
            gap = full - self._deeper(raised)
            self.depth = float((self._deeper(raised) - free).max())
            left = max(float(-gap.min()), float(gap[on].max(initial=0.0)))
            if enough is None:
                enough = max(within * left, ROUNDING * float(np.abs(self.gap).max()))
            closed += left <= CLOSED / 10 * self.depth
            if left <= max(EXACT * self.depth, enough) or closed > MORE:
                return force, raised
            new = float(gap[on] @ gap[on])
            t = gap + new / square * t if keep else gap
            t = np.where(on, t - self._deeper(self._mean(t, on)), 0.0)  # what is pressed stays so
            square = new
            # Points that bear an obstacle's force alone have no gap: those inside set the step.
            way = t if np.abs(t).max() > EXACT * left else np.minimum(gap, 0.0)
            follows = self.follow(way)
            step = float(gap @ way) / float(way @ follows)
            moved = np.where(on, force - step * way, 0.0)
            out, entering = moved < 0, (moved <= 0) & (gap < 0)
            moved[out] = 0.0
            moved[entering] = -step * gap[entering]
            keep = not entering.any()
            if out.any() or entering.any():
                force = self._scaled(moved)
                full = self._gap_at(force)
            else:
                force, full = moved, full - step * follows
        raise SolverError(f"gaps of {left:.1g} m left after {APPLICATIONS} steps")

    def _gap_at(self, force: Array) -> Array:
        """Gaps (c,) in m under forces (c,) in N."""
        change = force - self.start
        return self.gap + (self.follow(change) if change.any() else 0.0)

    def _begin(self, free: Array) -> Array:
        """Forces (c,) in N to begin with.

        Forces of an earlier solution are scaled to the prescribed ones. Otherwise they are in
        proportion to the depth, or alike for an obstacle of prescribed force, with the best factor.
        """
        if self.start.any():
            return self._scaled(self.start)
        deep = np.maximum(-free, 0.0)
        guess = np.where(np.isnan(self.prescribed_force)[self.which], deep, 1.0)
        return self._scaled(guess * (guess @ deep / (guess @ self.follow(guess)) or 1.0))

    def _scaled(self, force: Array) -> Array:
        """Forces (c,) that have the force of each obstacle that is pressed."""
        for k in np.flatnonzero(~np.isnan(self.prescribed_force)):
            own = self.which == k
            if not (total := float(force[own] @ self.along[own])) > 0:
                force, total = np.where(own, 1.0, force), float(self.along[own].sum())
            force = np.where(own, force * (self.prescribed_force[k] / total), force)
        return force

    def _deeper(self, raised: Array) -> Array:
        """Reduction (c,) of the gaps when obstacles move deeper by a distance (m)."""
        return np.asarray(raised[self.which] * self.along)

    def _mean(self, values: Array, on: Mask) -> Array:
        """Mean of values (c,) where each obstacle touches, weighted by its way; 0 by depth."""
        mean = np.zeros(len(self.prescribed_force))
        for k in np.flatnonzero(~np.isnan(self.prescribed_force)):
            own = on & (self.which == k)
            if not own.any():
                raise SolverError("pressed so hard that nothing bears it; reduce the force")
            mean[k] = float(self.along[own] @ values[own]) / float((self.along[own] ** 2).sum())
        return mean
