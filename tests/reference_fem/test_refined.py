"""Answers of slender, far and stiff bodies: right within the error that they state, or refused."""

from __future__ import annotations

import numpy as np
import pytest

import reference_fem
from msvalidate.problem import Box, Isotropic, Problem, ProblemError, SolverError, Support, Traction
from reference_fem.elasticity import solver_of, stiffness
from reference_fem.mixed import solve_mixed_on
from reference_fem.systems import Solver
from tests.reference_fem import exact_elements

ELEMENTS = {2: ("Q1", "Q2", "P1", "P2"), 3: ("H1", "H2", "T1", "T2")}
REFUSED = None


def drawn(seed, ordinary):
    """A body, its material, what is held, and forces on its nodes, by chance."""
    rng = np.random.default_rng(seed)
    d = 2 if rng.random() < 0.7 else 3
    element = str(rng.choice(ELEMENTS[d]))
    small = element in ("H2", "T2")
    along = int(rng.integers(2, 4 if small else 7 if d == 3 else 13))
    across = int(rng.integers(1, 2 if d == 3 else 3))
    height = 0.37
    ratio = 10 ** rng.uniform(0, 3 if ordinary else 4)
    box = Box((height * ratio, *([height] * (d - 1))))
    cells = (along, *([across] * (d - 1)))
    made = reference_fem.box_discretisation(box, cells, element)
    points = made.points
    if rng.random() < 0.5:
        points = points + rng.normal(size=d) * box.size[0] * 10 ** rng.uniform(
            0, 3 if ordinary else 7
        )
    nu = rng.uniform(-0.5, 0.49)
    if d == 2:
        state = str(rng.choice(["plane_stress", "plane_strain"]))
        material = Isotropic(10 ** rng.uniform(0, 9), nu, state, thickness=0.2)
    else:
        material = Isotropic(10 ** rng.uniform(0, 9), nu, "solid")
    body = reference_fem.discretise(points, made.cells, element)
    x = body.points[:, 0]
    held = np.zeros(points.shape, dtype=bool)
    held[x == x.min()] = True
    force = np.zeros(points.shape)
    loaded = x == x.max() if rng.random() < 0.5 else ~held[:, 0]
    force[loaded] = rng.normal(size=(loaded.sum(), d)) * material.E * 1e-6
    moved = np.zeros(points.shape)
    if rng.random() < 0.3:
        moved[held] = rng.normal(size=held.sum()) * 1e-6
    return body, material, held, moved, force


def stated_and_true(seed, ordinary):
    """Stated and true error of one body, relative to its largest displacement."""
    try:
        body, material, held, moved, force = drawn(seed, ordinary)
        solver = solver_of(body, material, held, allow_locked=True)
        found, how = solver.solve(moved, force)
    except (SolverError, ProblemError):
        return REFUSED
    right = exact_elements.displacement(body, material, held, moved, force)
    return how.error, np.abs(found - right).max() / np.abs(right).max()


def judged(seeds, ordinary):
    """No answer is off by more than it says; ordinary bodies are answered, and not vaguely."""
    pairs = [stated_and_true(seed, ordinary) for seed in seeds]
    known = np.array([pair for pair in pairs if pair is not REFUSED])
    stated, true = known.T
    missed = np.array(seeds)[[p is not REFUSED for p in pairs]][true > stated]
    assert not len(missed), f"seeds {missed}"
    if ordinary:
        assert len(known) >= 0.95 * len(pairs)
    worth = true > 1e-14
    if worth.sum() >= 5:
        assert np.median(stated[worth] / true[worth]) <= 100
    return len(known), len(pairs), stated, true
