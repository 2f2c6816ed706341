"""Energies, scales and bounds where no length is 1: a wrong power of one shows."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from msvalidate.constants.homogenise import homogenise
from msvalidate.constants.stiffness import isotropic_moduli, moduli
from msvalidate.lattice import patterns
from msvalidate.network import (
    configuration_at,
    frequency_bound,
    mode_energy,
    spring_network,
    tangent,
)
from msvalidate.network.laws.volumes import Volumes
from msvalidate.network.residual import force_scale

SIDE = 0.37
SQUARE = SIDE * np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]]) + 2.0
EDGES = [[0, 1], [1, 2], [2, 3], [3, 0], [0, 2]]
examples = settings(max_examples=25, deadline=None)


@examples
@given(data=st.data(), seed=st.integers(0, 2**32 - 1))
def test_energy_of_small_motions_is_that_of_the_tangent(networks, data, seed):
    network, position = data.draw(networks(stressed=True))
    motion = np.random.default_rng(seed).normal(size=position.shape)
    K = tangent(network, position)
    expected = motion.ravel() @ (K @ motion.ravel())
    size = np.abs(motion.ravel()) @ (abs(K) @ np.abs(motion.ravel()))
    # Sums of terms of either sign, each rounded.
    assert mode_energy(network, position, motion) == pytest.approx(expected, abs=1e-12 * size)


def test_force_scale_counts_a_swollen_cell():
    cell = Volumes(SQUARE, [[0, 1, 2, 3]], [2.0])
    network = spring_network(SQUARE, EDGES, 0.0, volumes=cell)
    # The pressure κ (λ² - 1) on half of each of two sides of length λ 0.37 m.
    expected = 2.0 * (1.1**2 - 1) * 1.1 * SIDE / math.sqrt(2)
    assert force_scale(configuration_at(network, 1.1 * SQUARE)) == pytest.approx(
        expected, rel=1e-12
    )


def test_zeners_ratio_is_that_of_two_shears():
    """Along the axes, and at 45° to them: energies of strains γ/2 (1, -1, 0) and (0, 0, γ)."""
    C = homogenise(patterns.square(), (1.3, 0.2), SIDE).tensor
    along, across = np.array([0.0, 0, 1]), np.array([0.5, -0.5, 0])
    expected = (along @ C @ along) / (across @ C @ across)
    assert abs(expected - 1) > 0.1
    assert moduli(C).zener == pytest.approx(expected, rel=1e-12)
    assert isotropic_moduli(C).zener == pytest.approx(expected, rel=1e-12)


def test_frequency_bound_of_a_mass_on_a_spring():
    held = [[True, True], [False, True]]
    network = spring_network(SQUARE[:2], [[0, 1]], 5.0, mass=0.2, held=held)
    assert frequency_bound(network) == pytest.approx(math.sqrt(5.0 / 0.2), rel=1e-14)
