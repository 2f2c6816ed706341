"""The judge's arithmetic where two slips agree on the easy cases: signs, pairs, the least data."""

import numpy as np
import pytest

from msvalidate.bench.judging.compare import (
    farthest_value,
    fitted_power,
    observed_order,
)
from msvalidate.bench.judging.evidence import Observed
from msvalidate.problem import ProblemError
from msvalidate_check.verdict import agreement
from tests.table import stored_rows


def test_far_apart_means_a_difference_and_not_a_sum():
    assert farthest_value([10.0, 1.0], [10.0, 3.0]) == Observed(1.0, 3.0, 2)
    assert farthest_value([-2.0, 2.0], [2.0, 1.0]) == Observed(-2.0, 2.0, 2)


def test_an_order_is_of_the_size_of_errors_of_either_sign():
    h = np.array([1.0, 0.5, 0.25])
    signs = np.array([1.0, -1.0, -1.0])
    assert observed_order(h, signs * 3 * h**1.7) == pytest.approx(1.7, abs=1e-12)


@pytest.mark.parametrize("spacings", [[0.5, 0.5], [1.0, -0.5], [1.0, 0.0]])
def test_each_spacing_once_and_above_zero(spacings):
    with pytest.raises(ProblemError, match="above zero"):
        observed_order(spacings, [0.1, 0.2])


def test_three_values_make_a_power():
    # On a line without scatter the interval is the slope itself.
    np.testing.assert_allclose(fitted_power([0.37, 1.0, 2.0], [0.37**2, 1.0, 4.0]), 2, rtol=1e-12)


@pytest.mark.parametrize(
    ("difference", "uncertainty", "residual_motion", "word"),
    stored_rows("agreements"),
)
def test_agreement_is_said_where_nothing_left_open_can_change_it(
    difference, uncertainty, residual_motion, word
):
    assert agreement(difference, uncertainty, 0.05, residual_motion) == word
