"""Forces of a network by displacements from its reference points, in the plain form.

A position of 1 m has no digits for a displacement of 1e-17 m, nor one of 1e6 m for 1e-10 m, and a
length none for so small an elongation. What a spring is longer by than at the reference points,

    L - D = (L² - D²)/(L + D),    L² - D² = (2v + w)·w,

v its vector there, D its distance, w the difference of two displacements, has all digits of these.
"""

from __future__ import annotations

import numpy as np

from msvalidate.network import Network, refuse_zero_length
from msvalidate.network.accurate import AT_REST
from msvalidate.network.laws import volumes as cells
from msvalidate.problem import Array


class Displaced:
    """A network made ready for forces at many displacements.

    Parameters
    ----------
    network
        Springs, and what stands beside them.
    near
        The same network, its points counted from one of them: cells go by its positions.
    """

    def __init__(self, network: Network, near: Network) -> None:
        self.network, self.near = network, near
        self.distance = np.linalg.norm(network.vector, axis=1)
        beyond = self.distance - network.rest_length
        self.beyond_rest = np.where(np.abs(beyond) > AT_REST * self.distance, beyond, 0.0)

    def spring_vectors(self, displacement: Array) -> tuple[Array, Array, Array]:
        """Vectors (m, d), lengths (m,), and lengths less those at the reference points, in m."""
        i, j = self.network.springs.T
        w = displacement[j] - displacement[i]
        vector = self.network.vector + w
        length = np.linalg.norm(vector, axis=1)
        refuse_zero_length(self.network, length)
        grown = ((self.network.vector + vector) * w).sum(axis=1)
        return vector, length, grown / (length + self.distance)

    def internal_force(self, displacement: Array) -> Array:
        """Force (n, d) in N of all springs and cells on the points, displaced by (n, d) in m.

        As `network.internal_force` at the reference points plus the displacement.

        Raises
        ------
        SolverError
            If a spring has no length.
        """
        network, near = self.network, self.near
        vector, length, longer = self.spring_vectors(displacement)
        tension = network.stiffness * (longer + self.beyond_rest)
        force = network.assemble_forces((tension / length)[:, None] * vector)
        if near.volumes:
            force = force + cells.force(near.volumes, near.points + displacement)
        return force

    @property
    def rounded(self) -> float:
        """The largest length (m) that is rounded in a force, but for displacements."""
        spring = float(np.abs(self.beyond_rest).max())
        if not self.near.volumes:
            return spring
        return max(spring, float(np.abs(self.near.points).max()))
