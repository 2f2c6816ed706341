"""No wrong answer leaves a solver of springs: random bodies, hard ones among them, in many digits.

`make slow` judges 3,000 of them, `make test` a few.
"""

from __future__ import annotations

import numpy as np
import pytest

from msvalidate.springs.network import spring_network
from tests.truth import exact
from tests.truth.judge import tally

A_SLICE = 100
LONG_SEED = 14
"""Seed of a body of 314 points that takes 45 s; `make slow` judges it."""


def _agrees(seeds):
    result = tally(seeds)
    assert not result.missed, "\n".join(map(str, result.missed))
    return result


def test_what_is_answered_is_right_within_its_stated_error():
    _agrees({*range(24)} - {LONG_SEED})


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, 2400, A_SLICE))
def test_each_of_many_answers_is_right_within_its_stated_error(first):
    result = _agrees(range(first, first + A_SLICE))
    assert result.share_answered >= 0.9  # of some 30 bodies; of all of them below


@pytest.mark.slow
def test_ordinary_bodies_are_answered_and_errors_not_overstated():
    result = tally(range(2400, 3000))
    assert result.share_answered >= 0.95, "\n".join(
        str(v) for v in result.refused if v.body.ordinary
    )
    assert result.overstatement <= 100


def test_truth_is_right_on_a_bar_of_two_springs():
    # u = F (1/k1 + 1/k2), at rest lengths that are no floats
    points = np.array([[0.1, 0.2], [0.4, 0.6], [0.7, 1.0]])
    held = np.ones((3, 2), dtype=bool)
    held[2, 0] = held[1, 0] = False
    network = spring_network(
        points, [[0, 1], [1, 2]], [3.0, 7.0], fixed=held, force=[[0, 0], [0, 0], [1.0, 0]]
    )
    truth = exact.linear(network)
    along = (0.3**2) / (0.3**2 + 0.4**2)  # a spring at an angle resists by cos² of it
    assert float(truth.displacement[4].mid()) == pytest.approx((1 / 3 + 1 / 7) / along, rel=1e-12)
    assert truth.negative == 0


def test_truth_is_right_on_a_shallow_truss():
    # Two bars of length 1, rest length 1, apex at height h: F = 2k (1 - 1/l) y at apex height y
    h, y, k = 0.3, 0.26, 5.0
    span = np.sqrt(1 - h * h)
    points = np.array([[-span, 0], [0, h], [span, 0]])
    held = np.array([[1, 1], [1, 0], [1, 1]], dtype=bool)
    force = 2 * k * (1 - 1 / np.hypot(span, y)) * y
    network = spring_network(
        points, [[0, 1], [1, 2]], k, fixed=held, force=[[0, 0], [0, force], [0, 0]], rest_length=1.0
    )
    truth = exact.nonlinear(network, np.array([[0, 0], [0, -0.03], [0, 0]]))
    assert float(truth.displacement[3].mid()) == pytest.approx(y - h, rel=1e-12)
