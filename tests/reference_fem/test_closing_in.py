"""The stated error of sequences whose limit and order are known: its rule, to the digit."""

from __future__ import annotations

import numpy as np
import pytest

from reference_fem.closing_in import close_in

LIMIT = np.array([-7.0, 0.5, 3.0])


def sequence(*parts, meshes=3):
    """`LIMIT` + C h^p on meshes each twice as fine, (C, p) of each component; last errors."""
    errors = [[C * 2.0 ** (-p * n) for C, p in parts] for n in range(meshes)]
    return [LIMIT[: len(parts)] + each for each in errors], np.array(errors[-1])


@pytest.mark.parametrize("order", [0.501, 0.6, 1.0, 1.4, 2.0])
@pytest.mark.parametrize("meshes", [3, 5])
@pytest.mark.parametrize("size", [0.3, -0.3])
def test_twice_the_true_error_is_stated_where_an_order_is_seen(order, meshes, size):
    values, errors = sequence((size, order), (0.02, order), meshes=meshes)
    found = close_in(values)
    assert found.order == pytest.approx(order)
    assert found.uncertainty == pytest.approx(2 * np.abs(errors).max())
    assert found.extrapolated_uncertainty == pytest.approx(np.abs(errors).max())
    np.testing.assert_array_equal(found.value, values[-1])
    np.testing.assert_allclose(found.extrapolated, LIMIT[:2], rtol=1e-12)


def test_higher_orders_count_as_the_highest_that_is_believed():
    values, errors = sequence((0.3, 3.0))
    found = close_in(values)  # of 7 parts that changed, an order of 2 leaves 7/3
    assert found.order == pytest.approx(3)
    assert found.uncertainty == pytest.approx(2 * 7 / 3 * errors[0])
    values, errors = sequence((0.3, 1.0))
    assert close_in(values, 0.25).uncertainty == pytest.approx(2 * errors[0] / (2**0.25 - 1))


@pytest.mark.parametrize("order", [0.499, 0.2, -0.5])
@pytest.mark.parametrize(("most", "factor"), [(2.0, 3.0), (0.25, 2 / (2**0.25 - 1))])
def test_the_larger_of_two_changes_counts_where_no_order_is_seen(order, most, factor):
    changes = [0.0, 1.0, 2.0**-order]
    values = list(np.array([5.0, 1.0]) - np.outer(np.cumsum(changes), [-0.2, 1.0]))
    found = close_in(values, most)
    assert np.isnan(found.order)
    assert (
        found.uncertainty == found.extrapolated_uncertainty == pytest.approx(factor * max(changes))
    )
    np.testing.assert_array_equal(found.extrapolated, values[-1])


def test_few_meshes():
    values, _ = sequence((-0.3, 1.0), (0.4, 1.0), meshes=2)
    assert close_in(values).uncertainty == pytest.approx(2 * 0.2)
    assert close_in(values, 0.25).uncertainty == pytest.approx(2 * 0.2 / (2**0.25 - 1))
    assert np.isinf(close_in(values[:1]).uncertainty)
    for meshes in (2, 3):
        none = close_in([np.zeros(2)] * meshes)
        assert none.uncertainty == none.extrapolated_uncertainty == 0
    for array in (none.value, none.added):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0


@pytest.mark.parametrize("meshes", [2, 3])
@pytest.mark.parametrize(("change", "stated"), [(0.0, 1.0), (-0.9, 1.0), (-1.1, None)])
def test_rounding(meshes, change, stated):
    rounding = 1e-10 * 8.0
    values = [np.array([-8.0, 1.0])] * (meshes - 1) + [np.array([-8.0, 1.0 + change * rounding])]
    found = close_in(values)
    wanted = stated or {2: 2 * 1.1, 3: 3 * 1.1}[meshes]
    assert found.uncertainty == pytest.approx(wanted * rounding, rel=1e-5)
    assert np.isnan(found.order)


def test_components_that_close_in_more_slowly_have_their_own_order():
    # The first rules the order; the second is slower, the third faster and counts as the first.
    values, errors = sequence((100.0, 2.0), (-1.0, 0.7), (0.5, 4.0), meshes=4)
    found = close_in(values)
    assert found.order == pytest.approx(2, abs=1e-3)
    np.testing.assert_allclose(found.extrapolated[:2], LIMIT[:2], rtol=0, atol=2e-3)
    assert found.added[2] == pytest.approx(15 / 3 * -errors[2], rel=1e-2)
    # Nor has one that goes to and fro, or hardly falls, an order of its own.
    for last in (-0.5, 0.9):
        rows = [np.array([100 * 4.0**-n, part]) for n, part in enumerate((0, 1, 1 + last))]
        assert close_in(rows).added[1] == pytest.approx(last / 3, rel=3e-3)


@pytest.mark.parametrize("many", [1, 400])
def test_the_order_is_the_lower_of_all_and_of_the_largest(many):
    # Changes 8 and 2 of one, 3 and 1.5 of many: alone the largest rules, many rule the norm.
    rows = np.cumsum([np.zeros(many + 1), [8] + [3] * many, [2] + [1.5] * many], axis=0)
    norms = np.sqrt([64 + 9 * many, 4 + 2.25 * many])
    found = close_in(list(rows))
    assert found.order == pytest.approx(np.log2(min(norms[0] / norms[1], 8 / 2)))
    # The other way round: the largest falls more slowly than all together.
    rows = np.cumsum([np.zeros(many + 1), [8] + [3] * many, [5] + [0.1] * many], axis=0)
    assert close_in(list(rows)).order == pytest.approx(np.log2(8 / 5))
