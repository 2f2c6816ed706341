"""Electrodes that several test files look at."""

from __future__ import annotations

import numpy as np
import pytest

from msvalidate.dielectric.charges import electrodes_of_chains


def waves(n, *, tall=0.12):
    """A wavy electrode over another of a different length and grading, the gap about 1."""
    x = 2.5 * np.sin(0.5 * np.pi * np.linspace(-1, 1, n + 1))
    u = np.linspace(-2.0, 3.0, n + 4)
    return electrodes_of_chains(
        np.column_stack([x, 1 + tall * np.sin(3 * x) + 0.1 * x]),
        np.column_stack([u, tall * np.cos(2 * u)]),
    )


@pytest.fixture(scope="session")
def wavy():
    """Build two wavy electrodes of n and n + 3 segments."""
    return waves
