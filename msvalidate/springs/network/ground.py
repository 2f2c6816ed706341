"""Ground springs: one-sided springs between points and an obstacle that does not move.

A point at the depth p in the obstacle is pushed out by k·p along its normal. With friction a spring
as stiff holds it across, to where it touched first; where that would pull by more than μ k p, its
anchor slides along ([CundallStrack1979]). So what sticks stays where it is under any load below
that, at any rate of loading: friction that is made from a speed of slip instead creeps.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from msvalidate.problem import Array, Index, Mask, Obstacle, ProblemError
from msvalidate.problem.checks import finite, finite_number, indices, require_type
from msvalidate.springs.network.network import Network


class Ground:
    """The ground springs of a network's points, and where their anchors are.

    A motion changes it: begin each with one of its own.

    Parameters
    ----------
    network
        Whose points.
    points
        (c,) numbers.
    obstacle, depth, friction
        As in `problem.Contact`.
    stiffness
        (c,) or one number (N/m); by default the mean stiffness of the network's springs, so that
        steps that are stable without ground springs nearly are with them: see `frequency`.

    Attributes
    ----------
    force
        (c, d) in N on the points, as of the last call of `push`.
    stored, dissipated
        Energy (J) in the springs then, and lost to friction up to then.

    Raises
    ------
    ProblemError
        If a number is no point's, or a value is out of range.
    """

    def __init__(
        self,
        network: Network,
        points: Index,
        obstacle: Obstacle,
        *,
        depth: float = 0.0,
        friction: float = 0.0,
        stiffness: ArrayLike | None = None,
    ) -> None:
        require_type("network", network, Network)
        require_type("ground: obstacle", obstacle, Obstacle)
        if obstacle.dim != network.dim:
            raise ProblemError(f"ground: an obstacle in {obstacle.dim}D; give {network.dim} axes")
        self.points = indices("ground: points", points, len(network.points))
        self.obstacle = obstacle
        self.depth = finite_number("ground: depth", depth)
        self.friction = finite_number("ground: friction", friction, least=0)
        k = network.axial_stiffness
        given = k[k > 0].mean() if stiffness is None else stiffness
        self.stiffness = np.broadcast_to(finite("ground: stiffness", given), self.points.shape)
        if (self.stiffness <= 0).any():
            raise ProblemError(f"ground: stiffness {self.stiffness.min():g} N/m; raise it above 0")
        self._rest, self._mass = network.points[self.points], network.mass[self.points]
        self._gap = obstacle.gap(self._rest, self.depth)
        self._normal = obstacle.normal(self._rest, self.depth)
        self.anchor = np.zeros_like(self._rest)
        self.touches = np.zeros(len(self.points), dtype=bool)
        self.force = np.zeros_like(self._rest)
        self.stored = self.dissipated = 0.0

    @property
    def frequency(self) -> float:
        """Highest frequency (rad/s) of a point on its ground spring alone.

        With ground springs a network's highest is at most √(ω² + this²), ω its own.
        """
        return float(np.sqrt((self.stiffness / self._mass).max()))

    def push(self, displacement: Array) -> Array:
        """Forces (c, d) in N on the points at displacements (c, d) in m.

        The anchors move.
        """
        if self.obstacle.radius is None:  # a plane's gap has all digits of the displacement
            gap, normal = self._gap + displacement @ self._normal[0], self._normal
        else:
            x = self._rest + displacement
            gap, normal = self.obstacle.gap(x, self.depth), self.obstacle.normal(x, self.depth)
        deep = np.maximum(-gap, 0.0)
        touches = deep > 0
        self.force = (self.stiffness * deep)[:, None] * normal
        self.stored = 0.5 * float(self.stiffness @ deep**2)
        if self.friction:
            self._stick(displacement, normal, deep, touches)
        self.touches = touches
        return self.force

    def _stick(self, u: Array, normal: Array, deep: Array, touches: Mask) -> None:
        """Add what springs across pull, and let anchors slide."""
        first = touches & ~self.touches
        if first.any():
            self.anchor[first] = u[first]
        across = u - self.anchor
        across -= np.einsum("ca,ca->c", across, normal)[:, None] * normal
        far = np.sqrt(np.einsum("ca,ca->c", across, across))
        kept = np.minimum(far, self.friction * deep)  # μ k p over k: as stiff as the normal one
        slid = touches & (far > kept)
        if slid.any():
            self.dissipated += float((self.stiffness * kept * (far - kept))[slid].sum())
        part = np.where(touches, kept / np.where(far > 0, far, 1.0), 0.0)
        pull = part[:, None] * across
        self.anchor[slid] = (u - pull)[slid]
        self.force = self.force - self.stiffness[:, None] * pull
        self.stored += 0.5 * float(
            self.stiffness @ np.where(touches, np.minimum(far, kept), 0.0) ** 2
        )
