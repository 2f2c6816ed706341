"""Stated errors cover the true ones of bodies at random, beside exact solutions."""

from __future__ import annotations

import numpy as np
import pytest

from msvalidate.problem import Box, Isotropic
from msvalidate.springs.constants.homogenise import homogenise_network
from reference_fem import box_discretisation
from reference_fem.electric.electrostatics import Dielectric
from reference_fem.large_strain import Solid, deform, neo_hookean
from tests.msvalidate.simulators.test_masses import OWN, measured

COVERED = 0.95
"""Part of the cases whose true error lies within the stated one."""
EXACT = 1e-15
"""Rounding of an exact solution, relative to its largest value."""


def potential(rng):
    """Layers between two electrodes; potentials are relative to half of their difference."""
    size, count = 10 ** rng.uniform(-3, 3), int(rng.integers(2, 9))
    body = box_discretisation(Box((size, size)), (3, count), "Q1")
    y, epsilon = body.points[:, 1], 10 ** rng.uniform(-4, 4, count)
    ends, height = rng.normal(size=2), np.linspace(0, size, count + 1)
    cell = np.searchsorted(height, body.points[body.cells].mean(axis=1)[:, 1]) - 1
    drop = np.r_[0, np.cumsum(1 / epsilon)] / (1 / epsilon).sum()
    exact = ends[0] + np.diff(ends) * np.interp(y, height, drop)
    held = (y <= height[0]) | (y >= height[-1])
    found = Dielectric(body, epsilon[cell], held).solve(np.where(held, exact, 0.0))
    return 2 * np.abs(found.values - exact).max() / np.ptp(ends), found.error


def large_strain(rng):
    """A uniform gradient on the surface of a neo-Hookean block."""
    law = Isotropic(10 ** rng.uniform(3, 9), rng.uniform(0, 0.45), "plane_strain")
    body = box_discretisation(Box((10 ** rng.uniform(-3, 3), 0.37)), 2, "Q2")
    exact = body.points @ (10 ** rng.uniform(-9, -0.7) * rng.uniform(-1, 1, (2, 2)))
    held = np.zeros(exact.shape, dtype=bool)
    held[np.unique(body.surface)] = True
    found = deform(Solid(body, neo_hookean(law), held), np.where(held, exact, 0), 0 * exact)
    return np.abs(found.displacement - exact).max() / np.abs(exact).max(), found.error


def homogenised(rng):
    """Rows of springs in series, each an upright and two diagonals of half its stiffness."""
    count = int(rng.integers(2, 60))
    k, j = 10 ** rng.uniform(-4, 4, count), np.arange(count)
    above = np.column_stack([j, (j + 1) % count])
    springs = np.concatenate([np.column_stack([j, j]), above, above, above])
    ways = np.repeat([[1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [-1.0, 1.0]], count, axis=0)
    each = np.concatenate([k, k, k / 2, k / 2])
    found = homogenise_network(count, springs, 0.37 * ways, each, count * 0.37**2)
    exact = count / (1 / (1.5 * k)).sum()
    return abs(found.tensor[1, 1] / exact - 1), found.error


def masses(rng):
    """Masses at random, whose total is that of the requested ones."""
    kind, implicit = str(rng.choice(["float64", "float32"])), bool(rng.integers(2))
    own = OWN * rng.uniform(0.5, 2.0, OWN.shape)
    found = measured(kind, implicit, masses=own)
    return np.abs(found.values / (own * OWN.sum() / own.sum()) - 1).max(), found.error


@pytest.mark.parametrize(
    ("attribute", "count"), [(potential, 40), (large_strain, 20), (homogenised, 40), (masses, 4)]
)
def test_stated_errors_cover_at_random(attribute, count):
    rng = np.random.default_rng(count)
    true, stated = np.transpose([attribute(rng) for _ in range(count)])
    assert (true <= stated + EXACT).mean() >= COVERED, np.c_[true, stated]
    assert (stated < 1).all()
