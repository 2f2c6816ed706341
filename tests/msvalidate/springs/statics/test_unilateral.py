"""`statics.unilateral`: contact forces of given compliance matrices, against their conditions."""

from __future__ import annotations

import numpy as np
import pytest

from msvalidate.problem import SolverError
from msvalidate.springs.statics import unilateral


class Compliance:
    """A compliance matrix (m/N) that keeps the forces (N) it was multiplied with."""

    def __init__(self, matrix):
        self.matrix, self.forces = np.asarray(matrix, dtype=float), []

    def __call__(self, force):
        self.forces.append(force)
        return self.matrix @ force

    def contact(self, gap, press=(np.nan,), which=None, along=None, start=None):
        c = len(gap)
        start = np.zeros(c) if start is None else np.array(start, dtype=float)
        gap = np.array(gap, dtype=float) + (self.matrix @ start)
        along = np.ones(c) if along is None else np.array(along, dtype=float)
        which = np.zeros(c, dtype=int) if which is None else np.array(which)
        return unilateral.Unilateral(self, gap, start, along, which, np.array(press, dtype=float))


@pytest.mark.parametrize("warm", [False, True])
@pytest.mark.parametrize("pressed", [(), (0,), (1,), (0, 1)])
@pytest.mark.parametrize(("softness", "deep"), [(1.0, 1.0), (1e-6, 1e-3), (30.0, 1e4)])
def test_forces_meet_the_conditions_of_contact(softness, deep, pressed, warm):
    """Two obstacles, each by its depth or pressed by a force of its own."""
    rng = np.random.default_rng(len(pressed))
    root = rng.normal(size=(14, 14))
    compliance = Compliance(softness * (root @ root.T / 14 + 0.1 * np.eye(14)))
    which, along = np.repeat([0, 1], 7), rng.uniform(0.5, 1.0, 14)
    gap, press = deep * rng.normal(size=14), np.full(2, np.nan)
    press[list(pressed)] = np.array([2.0, 5.0])[list(pressed)] * deep / softness
    start = rng.uniform(-1, 1, 14).clip(0) * deep / softness if warm else None
    contact = compliance.contact(gap, press, which, along, start)
    force, deeper = contact.solve(0.0)
    left = gap + compliance.matrix @ force - deeper[which] * along
    total = np.bincount(which, force * along)
    assert (force >= 0).all()
    assert contact.depth == pytest.approx((deeper[which] * along - gap).max(), rel=1e-9)
    assert left.min() >= -1e-9 * contact.depth
    assert np.abs(left[force > 0]).max() <= 1e-9 * contact.depth
    assert 0 < (force > 0).sum() < 14
    for obstacle in (0, 1):
        if obstacle in pressed:
            assert total[obstacle] == pytest.approx(press[obstacle], rel=1e-9)
        else:
            assert deeper[obstacle] == 0


@pytest.mark.parametrize(("press", "steps"), [(np.nan, 4), (40.0, 7)])
@pytest.mark.parametrize("scale", [1.0, 1e-5])
def test_conjugate_gradients_take_as_many_steps_as_there_are_compliances(scale, press, steps):
    """Of points that all touch; a ninth, out of reach of a prescribed depth, costs no step."""
    axes = np.linalg.qr(np.random.default_rng(4).normal(size=(8, 8)))[0]
    matrix = axes * np.repeat([1.0, 1.1, 1.25, 1.4], 2) @ axes.T
    wanted = np.linspace(3, 7, 8)
    gap, compliance = -matrix @ wanted, Compliance(scale * matrix)
    if np.isnan(press):
        gap, wanted = np.append(gap, 50.0), np.append(wanted, 0.0)
        compliance = Compliance(scale * np.block([[matrix, np.zeros((8, 1))], [np.ones(9)]]))
    else:  # a constant more depth, which turns eight directions into seven between them
        inverse = np.linalg.inv(matrix)
        wanted = wanted + (press - wanted.sum()) * inverse.sum(axis=0) / inverse.sum()
    force, _ = compliance.contact(scale * gap, (press,)).solve(0.0)
    np.testing.assert_allclose(force, wanted, rtol=1e-12)
    assert len(compliance.forces) == 2 + steps


def test_steps_by_hand():
    """The force on the first point draws the second onto the obstacle."""
    compliance = Compliance([[1.0, -0.5], [-0.5, 2.0]])
    force, _ = compliance.contact([-1.0, 0.1]).solve(0.0)
    np.testing.assert_allclose(force, [1.95 / 1.75, 0.4 / 1.75])
    np.testing.assert_allclose(compliance.forces[:4], [[1, 0], [1, 0], [0, -0.4], [1, 0.2]])


def ill_conditioned(points, seed):
    """Contact of a compliance whose iteration gains little in a step, and its violation."""
    rng = np.random.default_rng(seed)
    axes = np.linalg.qr(rng.normal(size=(points, points)))[0]
    compliance = Compliance(axes * np.geomspace(1e-3, 1, points) @ axes.T)
    contact = compliance.contact(-100 * rng.uniform(1, 2, points))

    def violation(force):
        gap = contact.gap + compliance.matrix @ force
        return max(-gap.min(), np.abs(gap[force > 0]).max())

    return compliance, contact, violation


@pytest.mark.parametrize("within", [0.3, 0.01, 1e-5])
def test_it_stops_at_a_part_of_the_first_violation(within):
    compliance, contact, violation = ill_conditioned(30, 7)
    force, _ = contact.solve(within)
    assert within / 100 < violation(force) / violation(compliance.forces[1]) <= within


def test_it_takes_more_steps_than_a_tenth_of_what_counts_as_closed(monkeypatch):
    compliance, contact, violation = ill_conditioned(60, 0)
    contact.solve(0.0)
    steps = len(compliance.forces)
    monkeypatch.setattr(unilateral, "MORE", 0)
    compliance, contact, violation = ill_conditioned(60, 0)
    force, _ = contact.solve(0.0)
    assert 2e-12 < violation(force) / contact.depth <= 1e-11
    assert steps == len(compliance.forces) + 6
    monkeypatch.setattr(unilateral, "MORE", -1)
    compliance, contact, _ = ill_conditioned(60, 0)
    contact.solve(0.0)
    assert len(compliance.forces) == 2


@pytest.mark.parametrize("far", [1e3, -1e3])
def test_a_light_force_far_away_is_known_to_the_rounding_of_the_gaps(far):
    contact = Compliance(np.eye(3) + 1).contact([far, far, far + 1e-9], (1e-6,))
    force, deeper = contact.solve(0.0)
    assert force.sum() == pytest.approx(1e-6, rel=1e-9)
    assert deeper[0] == pytest.approx(far, abs=1e-5)


def test_what_has_no_answer_is_refused():
    with pytest.raises(SolverError, match="nothing bears it; reduce the force"):
        Compliance(np.eye(3)).contact([0.0, 0.0, 0.0], (0.0,)).solve(0.0)
    compliance, contact, _ = ill_conditioned(20, 1)
    rng = np.random.default_rng(0)
    contact.follow = lambda force: compliance(force) + rng.normal(size=20)
    with pytest.raises(SolverError, match="left after 2000 steps"):
        contact.solve(0.0)
