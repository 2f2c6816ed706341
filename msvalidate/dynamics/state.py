"""The state of a network on its way to rest: where it is, how fast, and what is out of balance."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from msvalidate import kernels
from msvalidate.network import Network
from msvalidate.problem import Array
from msvalidate.statics.imposing import impose_supports


class State:
    """Displacement and velocity of a network, its forces there, and the work done so far.

    Parameters
    ----------
    network
        n points in d dimensions.
    begun
        (n, d) displacement (m) before what is held was moved.

    Attributes
    ----------
    displacement, velocity
        (n, d) in m and m/s. Who changes the displacement in place tells `moved` of it.
    inertia
        (n, d) mass (kg) of each component, the network's own unless a method sets others.
    steps, evaluations
        Steps taken, and times that the forces of all springs were computed for them.
    stored
        Energy (J) of springs and cells, as of the last `balance`.
    """

    def __init__(self, network: Network, begun: Array) -> None:
        self.network, self.begun = network, begun
        self.displacement = impose_supports(network, begun)
        self.velocity = np.zeros_like(self.displacement)
        self.inertia = np.repeat(network.mass[:, None], network.dim, axis=1)
        self.steps, self.evaluations = 0, 0
        self.stored = 0.0
        self._force = np.empty_like(self.displacement)
        self._known = False
        self._held = np.flatnonzero(network.held)

    @cached_property
    def motion(self) -> kernels.Motion:
        """What advances displacement and velocity, and knows the forces."""
        return kernels.Motion(self.network)

    @property
    def position(self) -> Array:
        """(n, d) in m."""
        return self.network.points + self.displacement

    @property
    def kinetic(self) -> float:
        """Kinetic energy (J)."""
        return 0.5 * float(np.vdot(self.inertia * self.velocity, self.velocity))

    def moved(self, steps: int = 0, evaluations: int = 0) -> None:
        """Say that the displacement has changed; count its steps and the evaluations they need."""
        self.steps += steps
        self.evaluations += evaluations
        self._known = False

    def balance(self) -> Array:
        """Out-of-balance force (n, d) in N at the present displacement, 0 where it is held."""
        if not self._known:
            self.stored = self.motion.force_and_energy(self.displacement, self._force)
            self._force += self.network.force
            self._force.ravel()[self._held] = 0.0
            self._known = True
        return self._force
