"""`statics.unilateral`: contact forces of given compliance matrices, against their conditions."""

from __future__ import annotations

import numpy as np
import pytest

from msvalidate.problem import SolverError
from msvalidate.springs.statics import unilateral


def contact(matrix, gap, press=(np.nan,), which=0, along=1.0, start=0.0):
    """A contact of a compliance (m/N), and the forces (N) that it is multiplied with."""
    forces, gap = [], np.array(gap, dtype=float)
    which, along, start = (np.zeros(len(gap)) + each for each in (which, along, start))

    def follow(force):
        forces.append(force)
        return matrix @ force

    given = gap + matrix @ start, start, along, which.astype(int), np.array(press)
    return unilateral.Unilateral(follow, *given), forces


@pytest.mark.parametrize("warm", [0.0, 1.0])
@pytest.mark.parametrize("pressed", [(), (0,), (1,), (0, 1)])
@pytest.mark.parametrize(("softness", "deep"), [(1e-6, 1e-3), (30.0, 1e4)])
def test_forces_meet_the_conditions_of_contact(softness, deep, pressed, warm):
    """Two obstacles, each by its depth or pressed by a force of its own."""
    rng, unit = np.random.default_rng(len(pressed)), deep / softness
    root = rng.normal(size=(14, 14))
    matrix = softness * (root @ root.T / 14 + 0.1 * np.eye(14))
    which, along = np.repeat([0, 1], 7), rng.uniform(0.5, 1.0, 14)
    gap, press = deep * rng.normal(size=14), np.full(2, np.nan)
    press[list(pressed)] = np.array([2.0, 5.0])[list(pressed)] * unit
    start = warm * rng.uniform(-1, 1, 14).clip(0) * unit
    body, _ = contact(matrix, gap, press, which, along, start)
    force, deeper = body.solve(0.0)
    left = gap + matrix @ force - deeper[which] * along
    assert (force >= 0).all()
    assert body.depth == pytest.approx((deeper[which] * along - gap).max(), rel=1e-9)
    assert max(-left.min(), np.abs(left[force > 0]).max()) <= 1e-9 * body.depth
    total = np.where(np.isnan(press), np.nan, np.bincount(which, force * along))
    np.testing.assert_allclose(total, press, rtol=1e-9)
    assert (deeper[np.isnan(press)] == 0).all()


@pytest.mark.parametrize(("press", "steps"), [(np.nan, 4), (50.0, 7)])
def test_conjugate_gradients_take_as_many_steps_as_there_are_compliances(press, steps):
    """All points touch; a prescribed force replaces the 8 directions by 7 between them."""
    axes = np.linalg.qr(np.random.default_rng(4).normal(size=(8, 8)))[0]
    matrix = axes * np.repeat([1.0, 1.1, 1.25, 1.4], 2) @ axes.T
    body, forces = contact(1e-5 * matrix, -1e-5 * matrix @ np.linspace(3, 7, 8), (press,))
    force, _ = body.solve(0.0)
    more = np.linalg.inv(matrix).sum(axis=0)
    more = more / more.sum() * np.nan_to_num(press - 40.0)
    np.testing.assert_allclose(force, np.linspace(3, 7, 8) + more, rtol=1e-9)
    assert len(forces) == 2 + steps


def ill_conditioned(points):
    """A contact whose iteration gains little in a step, its forces, and their violation."""
    rng = np.random.default_rng(0)
    axes = np.linalg.qr(rng.normal(size=(points, points)))[0]
    matrix = axes * np.geomspace(1e-3, 1, points) @ axes.T
    body, forces = contact(matrix, -100 * rng.uniform(1, 2, points))

    def violation(force):
        gap = body.gap + matrix @ force
        return max(-gap.min(), np.abs(gap[force > 0]).max())

    return body, forces, violation


def test_it_takes_more_steps_than_a_tenth_of_what_counts_as_closed(monkeypatch):
    counts = []
    for more in (-1, 0, unilateral.MORE):
        monkeypatch.setattr(unilateral, "MORE", more)
        body, forces, violation = ill_conditioned(60)
        force, _ = body.solve(0.0)
        assert more or 2e-12 < violation(force) / body.depth <= 1e-11
        counts.append(len(forces))
    assert counts == [2, counts[1], counts[1] + 6]


def test_what_has_no_answer_is_refused():
    with pytest.raises(SolverError, match="nothing bears it; reduce the force"):
        contact(np.eye(3), [0.0, 0.0, 0.0], (0.0,))[0].solve(0.0)
    body, _, _ = ill_conditioned(20)
    exact, rng = body.follow, np.random.default_rng(0)
    body.follow = lambda force: exact(force) + rng.normal(size=20)
    with pytest.raises(SolverError, match="left after 2000 steps"):
        body.solve(0.0)
