"""Energies, scales and bounds where no length is 1: a wrong power of one shows."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from msvalidate.network import (
    mode_energy,
    tangent,
)

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
