"""Large periodic cells: conjugate gradients say what a factor says, or that they can't."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from msvalidate.problem import ProblemError, SolverError
from msvalidate.springs.constants import cell_at_rest
from msvalidate.springs.constants.homogenise import homogenise, homogenise_network
from msvalidate.springs.lattice import patterns, repeat_cell, voronoi

dims = pytest.mark.parametrize(("dim", "count"), [(2, 900), (3, 700)])


def alike(pattern, stiffness=None):
    """The tensors of both ways, which must be one, and the errors that they state."""
    k = pattern.stiffness((1.0,) * pattern.kinds) if stiffness is None else stiffness
    cell = len(pattern.points), pattern.springs, pattern.vectors, k, float(np.prod(pattern.size))
    direct, other = (homogenise_network(*cell, solver=solver) for solver in ("direct", "multigrid"))
    assert (direct.solver, other.solver) == ("direct", "multigrid")
    root = np.sqrt(np.diag(direct.tensor))
    away = np.abs(other.tensor - direct.tensor) / np.outer(root, root)
    assert away.max() <= direct.error + other.error
    return other


@dims
@pytest.mark.parametrize("decades", [-4, 3])
def test_stiff_blocks_in_a_soft_cell_are_no_obstacle(dim, count, decades):
    pattern = voronoi(count, dim=dim)
    inside = (pattern.points[pattern.springs[:, 0]] % 5 < 2.5).all(axis=1)
    k = np.where(inside, 10.0**decades, 1.0) * pattern.stiffness((1.0,))
    alike(pattern, k)


def test_springs_a_million_times_apart_are_asked_again():
    pattern = voronoi(700, dim=3)
    k = 10 ** np.random.default_rng(0).uniform(-3, 3, len(pattern.springs))
    alike(pattern, k)


def test_the_way_goes_by_the_size(monkeypatch):
    pattern = voronoi(60, dim=3)
    assert homogenise(pattern, (1.0,)).solver == "direct"
    monkeypatch.setattr(cell_at_rest, "MULTIGRID", {2: 100, 3: 100})
    assert homogenise(pattern, (1.0,)).solver == "multigrid"
    with pytest.raises(ProblemError, match=re.escape("solver: 'cg'; choose auto, direct")):
        homogenise(pattern, (1.0,), solver="cg")


# Motions without stiffness ------------------------------------------------------------------------


def cut(pattern, dim, kind):
    """Springs (mask) of a cell that are left, so that something is loose."""
    springs = pattern.springs
    at = np.flatnonzero((springs == 5).any(axis=1))
    left = np.ones(len(springs), dtype=bool)
    if kind == "a point alone":
        left[at] = False
    elif kind == "a point on too few springs":
        left[at[dim - 1 :]] = False
    elif kind == "a point on just enough":
        left[at[dim:]] = False
    else:
        ball = np.linalg.norm(pattern.points - np.array(pattern.size) / 2, axis=1) < 2
        across = np.flatnonzero(ball[springs[:, 0]] != ball[springs[:, 1]])
        left[across[1 if kind == "an island on one spring" else 0 :]] = False
    return left


@dims
@pytest.mark.parametrize(
    "kind", ["a point alone", "a point on too few springs", "an island", "an island on one spring"]
)
def test_motions_without_stiffness_are_noticed(dim, count, kind):
    pattern = voronoi(count, dim=dim)
    factor = np.where(cut(pattern, dim, kind), pattern.factor, 0.0)
    with pytest.raises(SolverError, match="without stretching a spring"):
        homogenise(replace(pattern, factor=factor), (1.0,), solver="multigrid")


@dims
def test_a_point_that_is_just_held_is_not_refused(dim, count):
    pattern = voronoi(count, dim=dim)
    k = np.where(cut(pattern, dim, "a point on just enough"), pattern.factor, 0.0)
    alike(pattern, k)


@pytest.mark.parametrize("name", ["square4", "cubic6"])
def test_rows_that_shift_freely_are_noticed(name):
    # No point is loose by itself, and no force of a uniform strain moves one.
    pattern = repeat_cell(patterns.all_patterns()[name](), 9)
    with pytest.raises(SolverError, match="can move without stretching a spring"):
        homogenise(pattern, (1.0,), solver="multigrid")


def test_what_conjugate_gradients_do_not_answer_goes_to_the_factor(monkeypatch):
    few = partial(cell_at_rest.conjugate_gradients, most=3)
    monkeypatch.setattr(cell_at_rest, "conjugate_gradients", few)
    monkeypatch.setattr(cell_at_rest, "MULTIGRID", {2: 100, 3: 100})
    pattern = voronoi(200, dim=3)
    assert homogenise(pattern, (1.0,)).solver == "direct"
    with pytest.raises(SolverError, match=r"did not answer in 3 steps; .* solver='direct' tells"):
        homogenise(pattern, (1.0,), solver="multigrid")
    monkeypatch.setattr(cell_at_rest, "AFFORDED", {2: 100, 3: 100})
    with pytest.raises(SolverError, match="solver='direct' tells"):
        homogenise(pattern, (1.0,))
