"""The highest frequency of an endless lattice; how far below zero volumes may go."""

from __future__ import annotations

import re
from itertools import product

import numpy as np
import pytest

from msvalidate.problem import ProblemError
from msvalidate.springs.constants.waves import highest_frequency, least_stable_volume
from msvalidate.springs.lattice import patterns, repeat_cell
from msvalidate.springs.lattice.pattern import pattern_by_shells

LATTICES = patterns.all_patterns()
ISOTROPIC = {
    "square": (1.0, 0.5),
    "triangular": (1.0,),
    "cubic18": (1.0, 1.0),
    "bcc": (1.0, 2 / 3),
    "fcc": (1.0, 0.25),
}
WHERE_UNSTABLE = {"square": -3, "triangular": -5 / 3, "cubic18": -3, "bcc": -2, "fcc": -5 / 4}
"""Least κ over μ. -3 is λ + 2μ = 0 of a long wave, κ being added to λ = μ."""


@pytest.mark.parametrize(
    ("name", "constants", "expected"),
    [
        ("square", (1.0, 0.5), 6.0),
        ("square", (0.8, 0.3), 4.4),
        ("triangular", (0.7,), 4.2),
        ("cubic18", (0.6, 0.6), 7.2),
        ("cubic6", (1.5,), 6.0),
        ("bcc", (0.6, 0.3), 4.4),
        ("fcc", (0.5, 0.2), 4.8),
    ],
)
def test_highest_frequency_of_an_endless_lattice(name, constants, expected):
    assert highest_frequency(LATTICES[name](), constants) == pytest.approx(expected, rel=1e-12)


def test_highest_frequency_between_the_phases_of_the_grid():
    # Springs to the next and the one after: 4 k1 s² + 16 k2 s² (1 - s²), s = sin(q/2), greatest at
    # s² = 5/8 for equal constants, a phase of 104 degrees.
    pattern = pattern_by_shells("chains", (1.0, 1.0), [(0, 0)], (1.0, 2.0), {"equal": (1.0, 1.0)})
    assert highest_frequency(pattern, (1.0, 1.0)) == pytest.approx(25 / 4, rel=1e-12)


def test_highest_frequency_does_not_depend_on_the_cell():
    for name in ("square", "triangular", "bcc", "honeycomb"):
        pattern = LATTICES[name]()
        constants = tuple(1.0 + 0.3 * kind for kind in range(pattern.kinds))
        twice = highest_frequency(repeat_cell(pattern, 2), constants)
        assert highest_frequency(pattern, constants) == pytest.approx(twice, rel=1e-12), name


@pytest.mark.parametrize("name", WHERE_UNSTABLE)
def test_cells_make_the_highest_frequency_higher(name):
    # On a torus of two cells an axis, which has the highest waves: their phases are 0 and pi.
    pattern, kappa = getattr(patterns, name)(), 3.0
    springs, volumes = torus(pattern, ISOTROPIC[name])
    expected = np.linalg.eigvalsh(springs + kappa * volumes)[-1]
    assert highest_frequency(pattern, ISOTROPIC[name], kappa) == pytest.approx(expected, rel=1e-12)
    assert expected > 1.2 * highest_frequency(pattern, ISOTROPIC[name])


def test_bad_input_is_refused():
    with pytest.raises(ProblemError, match="pattern: 'square'; give a Pattern"):
        highest_frequency("square", (1.0, 1.0))
    with pytest.raises(ProblemError, match=re.escape("the most is 1e+03")):
        highest_frequency(repeat_cell(patterns.fcc(), 7), (1.0, 1.0))


# Volumes below zero ------------------------------------------------------------------------------


def test_waves_that_cost_nothing_are_refused():
    with pytest.raises(ProblemError, match="cubic 6 lattice: some wave costs its central springs"):
        least_stable_volume(patterns.cubic6(), (1.0,))


@pytest.mark.parametrize("name", WHERE_UNSTABLE)
def test_volumes_bear_so_much(name):
    pattern = getattr(patterns, name)()
    mu = pattern.tensor(ISOTROPIC[name])[-1, -1]
    assert least_stable_volume(pattern, ISOTROPIC[name]) == pytest.approx(WHERE_UNSTABLE[name] * mu)


def torus(pattern, constants):
    """Stiffness of the springs and of the volumes with κ = 1 of a ring of two cells an axis."""
    twice = repeat_cell(pattern, 2)
    n, d = twice.points.shape
    normal = twice.vectors / np.linalg.norm(twice.vectors, axis=1)[:, None]
    stretch = np.zeros((len(normal), n, d))
    each = np.arange(len(normal))
    np.add.at(stretch, (each, twice.springs[:, 1]), normal)
    np.add.at(stretch, (each, twice.springs[:, 0]), -normal)
    stretch = stretch.reshape(len(normal), -1)
    size, corners = np.array(pattern.size), list(product((0, 1), repeat=d))
    slopes = []
    for cell in corners:
        slope = np.zeros((n, d))
        for place in corners:
            at = (np.add(cell, place) % 2) * size
            (point,) = np.flatnonzero(np.abs(twice.points - at).max(axis=1) < 1e-9)
            slope[point] += (2 * np.array(place) - 1) * np.prod(size) / size / 2 ** (d - 1)
        slopes.append(slope.ravel())
    slopes = np.array(slopes)
    k = twice.stiffness(constants)
    return (stretch.T * k) @ stretch, slopes.T @ slopes / np.prod(size)


def test_cells_without_a_corner_are_refused():
    shifted = pattern_by_shells(
        "shifted", (1.0, 1.0), [(0.5, 0.5)], (1.0, 2**0.5), {"one": (1.0, 1.0)}
    )
    with pytest.raises(ProblemError, match="no point in the corner of its cell"):
        least_stable_volume(shifted, (1.0, 0.5))
