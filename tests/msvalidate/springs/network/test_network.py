"""Energy, force and tangent of a spring network, and networks from lists."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from msvalidate.springs.network import (
    configuration_at,
    energy,
    internal_force,
    mode_energy,
    spring_network,
    tangent,
)
from msvalidate.springs.network.residual import force_scale
from tests.table import refused, stored_rows, table

STEP = 1e-5
"""Of a central difference (m): truncation STEP² and rounding 1e-16/STEP are both far below 1e-7."""
examples = settings(max_examples=25, deadline=None)


def differences(function, position):
    """Central differences of a function of positions by each component, one a row."""
    rows = []
    for place in np.ndindex(position.shape):
        step = np.zeros(position.shape)
        step[place] = STEP
        rows.append((function(position + step) - function(position - step)) / (2 * STEP))
    return np.array(rows)


def turn(dim, rng):
    """Random rotation matrix."""
    matrix, _ = np.linalg.qr(rng.normal(size=(dim, dim)))
    matrix[:, 0] *= np.linalg.det(matrix)
    return matrix


# Physics of any network -----------------------------------------------------------------------


@examples
@given(data=st.data())
def test_force_is_minus_the_gradient_of_energy(networks, data):
    network, position = data.draw(networks(stressed=True))
    gradient = differences(lambda x: energy(network, x), position).reshape(position.shape)
    scale = force_scale(configuration_at(network, position))
    np.testing.assert_allclose(internal_force(network, position), -gradient, atol=1e-6 * scale)


@examples
@given(data=st.data())
def test_tangent_is_minus_the_gradient_of_force_and_symmetric(networks, data):
    network, position = data.draw(networks(stressed=True))
    K = tangent(network, position).toarray()
    gradient = differences(lambda x: internal_force(network, x).ravel(), position)
    np.testing.assert_allclose(K, -gradient, atol=1e-6 * np.abs(K).max())
    np.testing.assert_allclose(K, K.T, atol=1e-14 * np.abs(K).max())  # order of summation


@examples
@given(data=st.data(), seed=st.integers(0, 2**32 - 1))
def test_energy_is_indifferent_to_the_frame_and_force_turns_with_it(networks, data, seed):
    network, position = data.draw(networks(stressed=True))
    rng = np.random.default_rng(seed)
    Q = turn(network.dim, rng)
    moved = position @ Q.T + rng.uniform(-5, 5, network.dim)
    scale = force_scale(configuration_at(network, position))
    assert energy(network, moved) == pytest.approx(energy(network, position), rel=1e-12, abs=1e-13)
    # Lengths are rounded to 1e-15 of coordinates up to 10 m.
    expected = internal_force(network, position) @ Q.T
    np.testing.assert_allclose(internal_force(network, moved), expected, atol=1e-12 * (1 + scale))


# One spring, by hand --------------------------------------------------------------------------


def test_one_stretched_spring():
    # A 3-4-5 triangle: 5 m long, at rest at 4 m, 2 N/m: tension 2 N, energy 1 J.
    network = spring_network([[1, 1], [4, 5]], [[0, 1]], 2.0, rest_length=[4.0])
    assert energy(network, network.points) == pytest.approx(1.0, rel=1e-15)
    force = internal_force(network, network.points)
    np.testing.assert_allclose(force, [[1.2, 1.6], [-1.2, -1.6]], rtol=1e-14)
    # Along (0.6, 0.8) the spring's 2 N/m; across, tension over length, 2/5 N/m.
    along, across = np.outer([0.6, 0.8], [0.6, 0.8]), np.outer([-0.8, 0.6], [-0.8, 0.6])
    block = 2.0 * along + 0.4 * across
    expected = np.block([[block, -block], [-block, block]])
    np.testing.assert_allclose(tangent(network, network.points).toarray(), expected, rtol=1e-13)


@examples
@given(data=st.data(), doubled=st.booleans())
def test_the_tangent_is_the_sum_of_its_springs(networks, data, doubled):
    """Entry by entry from the formula, springs side by side and turned round among them."""
    network, position = data.draw(networks(stressed=True))
    network = replace(network, volumes=None)
    if doubled:
        again = np.concatenate([network.springs, network.springs[::2, ::-1]])
        many = np.arange(len(again)) % len(network.springs)
        network = replace(
            network,
            springs=again,
            stiffness=network.stiffness[many],
            rest_length=network.rest_length[many],
        )
    d, n = network.dim, len(network.points)
    expected = np.zeros((n, d, n, d))
    for (i, j), k, rest in zip(
        network.springs, network.stiffness, network.rest_length, strict=True
    ):
        vector = position[j] - position[i]
        length = np.linalg.norm(vector)
        along = np.outer(vector, vector) / length**2
        block = k * along + k * (1 - rest / length) * (np.eye(d) - along)
        for a, b, sign in ((i, i, 1), (j, j, 1), (i, j, -1), (j, i, -1)):
            expected[a, :, b, :] += sign * block
    expected = expected.reshape(n * d, n * d)
    within = 1e-14 * np.abs(expected).max()  # order of summation
    np.testing.assert_allclose(tangent(network, position).toarray(), expected, atol=within)


@pytest.mark.parametrize("side", [-1e6, 1e6])
def test_points_that_only_rounding_keeps_apart_are_in_one_place(side):
    # 1e-14 of the coordinates is 1e-8 m.
    near, apart = (np.array([[side, side], [side + d, side]]) for d in (5e-9, 5e-8))
    with refused("its two points coincide"):
        spring_network(near, [[0, 1]], 1.0)
    assert spring_network(apart, [[0, 1]], 1.0).rest_length == pytest.approx(5e-8, rel=1e-2)


# Networks from lists --------------------------------------------------------------------------

TRIANGLE = {"points": [[0, 0], [1, 0], [0, 1]], "springs": [[0, 1], [1, 2], [2, 0]], "stiffness": 1}


def test_a_network_keeps_copies_that_cannot_be_changed():
    given_points = np.array(TRIANGLE["points"], dtype=float)
    network = spring_network(given_points, TRIANGLE["springs"], 1.0)
    given_points[0] = 9.0
    np.testing.assert_array_equal(network.points[0], [0, 0])
    for name in ("points", "springs", "stiffness", "rest_length", "mass", "fixed", "force"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(network, name)[0] = 0


def test_scaled_multiplies_every_stiffness():
    network = spring_network(**TRIANGLE)
    np.testing.assert_array_equal(network.scaled(1.01).stiffness, [1.01] * 3)
    np.testing.assert_array_equal(network.scaled(np.array([1, 0, 2.0])).stiffness, [1, 0, 2])
    np.testing.assert_array_equal(network.stiffness, [1, 1, 1])


@table(
    ("change", "message"),
    [
        *stored_rows("networks"),
        ({"points": np.zeros((0, 2))}, "springs: [0 1] at index 0; there are 0 points"),
    ],
)
def test_bad_lists_are_refused_by_array_and_index(change, message):
    with refused(message):
        spring_network(**(TRIANGLE | change))


@pytest.mark.parametrize("wrong", [[2, 99], [2, 2], [2, -1]])
def test_springs_are_checked_however_a_network_is_made(wrong):
    # The compiled loop has no bounds check: it would write to memory that is not its own.
    network = spring_network(**TRIANGLE)
    with refused("springs"):
        replace(network, springs=np.array([[0, 1], [1, 2], wrong]))


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
