"""`springs.lattice_springs.extrapolate`: what finer lattices show is within the uncertainty that it
states."""

from __future__ import annotations

import re
from contextlib import suppress

import numpy as np
import pytest

from msvalidate.case.file.case import Case, spacing_of
from msvalidate.case.springs.lattice_springs import compared_points, extrapolate, solve_springs
from msvalidate.problem import (
    Box,
    Contact,
    Isotropic,
    Mesh,
    Obstacle,
    Problem,
    ProblemError,
    Region,
    Support,
    Traction,
)
from reference_fem.contact import press_closely
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
    limit = extrapolate(answers[:3], values[:3])
    return np.abs(limit.displacement - values[3]).max() <= limit.uncertainty


def holed(rng):
    """A plate in m or mm with a round hole, clamped on the left and pulled on the right."""
    size, wide, turns = rng.choice([0.37, 370.0]), rng.uniform(1, 2.5), 8 * int(rng.integers(1, 4))
    angle = 2 * np.pi * np.arange(turns) / turns
    ring = np.column_stack([np.cos(angle), np.sin(angle)])
    rim = ring / np.abs(ring).max(axis=1)[:, None] * (wide, 1.0)
    i = np.arange(turns)
    j = np.roll(i, -1)
    cells = np.column_stack([i, turns + i, turns + j, j])
    mesh = Mesh(size * np.vstack([rng.uniform(0.15, 0.35) * ring, rim]), cells, "quad")
    clamp = Support(Region((-wide * size, None)), (0.0, 0.0))
    pull = Traction(Region((wide * size, None)), tuple(rng.normal(size=2).tolist()))
    return Problem(mesh, Isotropic(1e5, rng.uniform(0, 0.45), thickness=0.2), (clamp,), (pull,))


def test_the_uncertainty_of_limits_covers():
    """Obstacles on boxes, and loads on boxes, outlines, bent meshes and plates with a hole.

    A change of two squares across an outline that is small by chance was no bound before.
    """
    covered = {"pressed": [], "cut": []}
    for seed in range(4):
        rng = np.random.default_rng(seed)
        bodies = [("pressed", pressed(rng), int(rng.integers(2, 5))) for _ in range(6)]
        cut = [problem for _, problem, _ in problems(seed, 1, ("box", "outline", "bent"))]
        bodies += [("cut", body, cells) for body in (*cut, holed(rng)) for cells in (2, 3)]
        for kind, problem, cells in bodies:
            with suppress(ProblemError):  # nothing is reached, or the lattice does not fit
                covered[kind].append(covers(problem, cells))
    for each in covered.values():
        assert len(each) >= 15
        assert np.mean(each) >= 0.95


def springs(problem):
    return solve_springs(Case(problem), 0.25).contact.contacts[0]


def elements(problem):
    return press_closely(problem, (2, 4))[0][-1]


@pytest.mark.parametrize("solve", [springs, elements])
def test_a_force_that_indents_less_than_rounding_is_refused_with_one_that_does_not(solve):
    """A disc beside the body touches its corner after 0.2 m."""
    box = Box((2.0, 0.5))
    clamp, disc = (
        Support(box.side("bottom"), (0.0, 0.0)),
        Obstacle("disc", (2.5, 0.5), (0, -1), 0.7),
    )

    def pressed_by(force):
        contact = Contact(box.side("top"), disc, force=force)
        material = Isotropic(1e6, 0.3, "plane_strain")
        return Problem(box, material, (clamp,), contacts=(contact,))

    for force in (1e-12, 1e-6):
        with pytest.raises(ProblemError, match="rounding of the gaps hides; take") as refusal:
            solve(pressed_by(force))
        least = float(re.search(r"take (\S+) N or more", str(refusal.value))[1])
        assert solve(pressed_by(least)).total == pytest.approx(least, rel=1e-9)
