"""The highest frequency of an endless lattice."""

from __future__ import annotations

import re

import pytest

from msvalidate.constants.waves import highest_frequency
from msvalidate.lattice import patterns, repeat_cell
from msvalidate.lattice.pattern import pattern_by_shells
from msvalidate.problem import ProblemError

LATTICES = patterns.all_patterns()


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


def test_bad_input_is_refused():
    with pytest.raises(ProblemError, match="pattern: 'square'; give a Pattern"):
        highest_frequency("square", (1.0, 1.0))
    with pytest.raises(ProblemError, match=re.escape("the most is 1e+03")):
        highest_frequency(repeat_cell(patterns.fcc(), 7), (1.0, 1.0))
