"""Energy of springs and its slope by the plain formula, for minimisers in tests."""

from __future__ import annotations

import numpy as np


def spring_energy(network, position):
    """Energy (J) of the springs alone at positions (n, d), and its slope (n, d) in N."""
    i, j = network.springs.T
    vector = position[j] - position[i]
    length = np.sqrt((vector**2).sum(axis=1))
    tension = network.stiffness * (length - network.rest_length)
    slope, pull = np.zeros(position.shape), (tension / length)[:, None] * vector
    np.add.at(slope, j, pull)
    np.add.at(slope, i, -pull)
    return 0.5 * tension @ (length - network.rest_length), slope
