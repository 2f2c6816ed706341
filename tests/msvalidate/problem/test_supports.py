"""Supports: free rigid motions named, what is held, contradictions, and fields of displacement."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from msvalidate.problem import (
    Box,
    Isotropic,
    Problem,
    Region,
    Support,
    prescribed_displacements,
    rigid_motions,
    vectors_at,
)
from msvalidate.problem.motions import free_motions
from tests.table import refused, stored_rows, table

NAN = float("nan")
PLATE = Box((2.0, 1.0))
SHEET = Isotropic(E=1e6, nu=0.3)
CLAMP = Support(PLATE.side("left"), (0.0, 0.0))
X, Y = "translation along x", "translation along y"
GRID = np.stack(np.meshgrid([0.0, 1.0, 2.0], [0.0, 0.5, 1.0]), axis=-1).reshape(-1, 2)


def plate(*, supports=(CLAMP,), loads=()):
    return Problem(PLATE, SHEET, supports, loads)


@table(
    ("points", "held", "names"),
    [
        *stored_rows("free_motions"),
        ([[0, 0, 0], [2, 0, 0], [0, 2, 0]], [[0, 0, 1]] * 3, [X, Y, None]),
    ],
)
def test_free_motions_are_named(points, held, names):
    d = 2 if not points else len(points[0])
    places = np.array(points, dtype=float).reshape(-1, d)
    found = free_motions(places, np.array(held, dtype=bool).reshape(-1, d))
    assert len(found) == len(names)
    for name, expected in zip(found, names, strict=True):
        # None: a turn about the z axis through any point at all is free; the place is a choice.
        assert name == expected or (expected is None and "along z through" in name)


@pytest.mark.parametrize("d", [2, 3])
@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), size=st.sampled_from([1e-6, 1.0, 1e4]))
def test_as_many_motions_are_named_as_constraints_leave(d, seed, size):
    rng = np.random.default_rng(seed)
    points = rng.integers(0, 3, (rng.integers(1, 5), d)).astype(float)
    held = rng.random(points.shape) < 0.5
    # Constraint rows by hand: component a of t + W x, W skew with one entry per pair of axes.
    planes = [(a, b) for a in range(d) for b in range(a)]
    rows = []
    for point, axis in zip(*np.nonzero(held), strict=True):
        turn = [(a == axis) * points[point, b] - (b == axis) * points[point, a] for a, b in planes]
        rows.append([*np.eye(d)[axis], *turn])
    rank = np.linalg.matrix_rank(np.array(rows)) if rows else 0
    assert len(free_motions(size * points, held)) == d + len(planes) - rank


@pytest.mark.parametrize("d", [2, 3])
def test_rigid_motions_change_no_distance(d):
    points = np.random.default_rng(0).normal(size=(6, d))
    motions = rigid_motions(points)
    assert motions.shape == (6, d, d * (d + 1) // 2)
    assert np.linalg.matrix_rank(motions.reshape(6 * d, -1)) == d * (d + 1) // 2
    for motion in np.moveaxis(motions, 2, 0):
        apart, moved = points[:, None] - points, motion[:, None] - motion
        # To first order a distance changes by d·(u_j - u_i): sums of two products, so roundoff.
        np.testing.assert_allclose((apart * moved).sum(axis=2), 0.0, atol=1e-14)


@table(
    ("supports", "names"),
    [
        ((), [X, Y, "rotation about"]),
        ((Support(PLATE.side("left"), (0.0, None)),), [Y]),
        ((Support(Region((0.0, 0.0)), (0.0, 0.0)),), ["rotation about (0, 0)"]),
        # Only the displacement's direction counts, not its value or whether it is a field.
        ((Support(PLATE.side("bottom"), (None, lambda p: 0.1 * p[:, 0])),), [X]),
    ],
)
def test_a_body_left_free_is_refused_with_each_motion(supports, names):
    with refused("problem: the supports leave the body free: ") as caught:
        plate(supports=supports).refuse_free_body()
    assert str(caught.value).endswith("Hold one more component against each")
    for name in names:
        assert name in str(caught.value)
    assert str(caught.value).count(";") == len(names) - 1


# Supports and fields at points ----------------------------------------------------------------


@table("order", [1, -1])
def test_supports_that_contradict_each_other_are_refused_at_the_place(order):
    supports = (CLAMP, Support(PLATE.side("top"), (None, 0.5)))[::order]
    values = "0 and 0.5" if order == 1 else "0.5 and 0"
    with refused(f"y displacement {values} m at (0, 1); prescribe it once"):
        prescribed_displacements(plate(supports=supports), GRID)


def test_small_displacements_contradict_each_other_too():
    # Linear equilibrium has no scale: at a strain of 1e-10 this support matters as much as at 1.
    supports = (CLAMP, Support(PLATE.side("bottom"), (None, 1e-9)))
    with refused("supports contradict each other"):
        prescribed_displacements(plate(supports=supports), GRID)


@table("region", [Region((2.0, (0.0, 0.7))), Region(((0.5, 2.0), 0.0))])
def test_a_support_that_ends_between_the_points_is_refused(region):
    with refused("not at its ends; choose cells that put one at each"):
        prescribed_displacements(plate(supports=(CLAMP, Support(region, (0.0, None)))), GRID)


def test_a_support_between_the_points_is_refused():
    supports = (CLAMP, Support(Region((0.3, None)), (0.0, None)))
    with refused("support on (x = 0.3): no point of the discretised body lies there"):
        prescribed_displacements(plate(supports=supports), GRID)


@pytest.mark.parametrize(
    ("field", "message"),
    [
        (lambda p: p, "support on (x = 0): the field returned shape (3, 2), not (3,)"),
        (lambda p: 1e-3 * p[0], "support on (x = 0): the field returned shape (2,), not (3,)"),
        (lambda p: 0.0 * p[0, 0], "support on (x = 0): the field returned shape (), not (3,)"),
        (lambda p: np.where(p[:, 1] > 0.7, NAN, 0.0), "support on (x = 0): nan at index 2"),
    ],
)
def test_a_displacement_field_returns_a_finite_number_a_point(field, message):
    problem = plate(supports=(Support(PLATE.side("left"), (field, 0.0)),))
    with refused(message):
        prescribed_displacements(problem, GRID)


@pytest.mark.parametrize(
    ("field", "message"),
    [
        (lambda p: p[:, 0], "body force: the field returned shape (9,), not (9, 2)"),
        (lambda p: p.T, "body force: the field returned shape (2, 9), not (9, 2)"),
        (lambda p: p / np.where(p > 1.5, 0.0, 1.0), "body force: inf at index (2, 0)"),
    ],
)
def test_a_vector_field_returns_a_finite_vector_a_point(field, message):
    with np.errstate(divide="ignore"), refused(message):
        vectors_at("body force", field, GRID)
