"""`case.springs.limit_of`: what finer lattices show is within the uncertainty that it states."""

from __future__ import annotations

import numpy as np
import pytest

from msvalidate.case.case import Case, spacing_of
from msvalidate.case.springs import compared_points, limit_of, solve_springs
from msvalidate.problem import Box, Contact, Isotropic, Obstacle, Problem, ProblemError, Support
from tests.reference_fem.bodies_at_random import problems


def pressed(rng):
    """A block in m or mm under a round obstacle, by depth or force."""
    size, wide, E = rng.choice([0.37, 370.0]), int(rng.integers(1, 4)), 10 ** rng.uniform(3, 9)
    box = Box((wide * size, size))
    shape, part = str(rng.choice(["disc", "parabola"])), 10 ** rng.uniform(-4, -1.3)
    place = (rng.uniform(0.2, 0.8) * wide * size, size)
    obstacle = Obstacle(shape, place, (0.0, -1.0), 10 ** rng.uniform(-0.3, 1.2) * size)
    given = {"depth": part * size} if rng.random() < 0.5 else {"force": part * E * 0.2 * size}
    clamp = Support(box.side(str(rng.choice(["bottom", "left"]))), (0.0, 0.0))
    contact = Contact(box.side("top"), obstacle, **given)
    material = Isotropic(E, rng.uniform(0, 0.45), thickness=0.2)
    return Problem(box, material, (clamp,), contacts=(contact,))


def covers(problem, cells):
    """Whether a lattice twice as fine as the finest is nearer to the limit than stated."""
    case = Case(problem, cells=cells)
    answers = tuple(solve_springs(case, spacing_of(case) / times) for times in (1, 2, 4, 8))
    places = compared_points(case, answers[0].lattice)
    values = [answer.at(places) for answer in answers]
    limit = limit_of(answers[:3], values[:3])
    return np.abs(limit.displacement - values[3]).max() <= limit.uncertainty


@pytest.mark.parametrize("seed", [0, 1, 2, 3])
def test_the_uncertainty_of_limits_covers(seed):
    """Obstacles and other loads, on boxes and bent meshes: at least 95 of 100."""
    rng = np.random.default_rng(seed)
    bodies = [pressed(rng) for _ in range(10)]
    bodies += [problem for _, problem, _ in problems(seed, 1, ("box", "bent"))]
    covered = []
    for problem in bodies:
        try:
            covered.append(covers(problem, int(rng.integers(2, 5))))
        except ProblemError:  # nothing is reached, or the lattice does not fit
            continue
    assert len(covered) >= 8
    assert np.mean(covered) >= 0.95
