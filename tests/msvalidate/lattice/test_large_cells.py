"""Large periodic cells: conjugate gradients say what a factor says, or that they can't."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from msvalidate.constants import cell_at_rest, cell_multigrid
from msvalidate.constants.homogenise import homogenise, homogenise_network
from msvalidate.lattice import patterns, repeat_cell, voronoi
from msvalidate.problem import ProblemError, SolverError

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
@pytest.mark.parametrize("points", ["uniform", "jittered"])
def test_both_ways_say_the_same_of_random_cells(dim, count, points):
    assert alike(voronoi(count, dim=dim, points=points)).error <= 1e-12


@pytest.mark.parametrize("name", ["triangular", "honeycomb", "bcc", "fcc"])
def test_both_ways_say_the_same_of_lattices(name):
    pattern = patterns.all_patterns()[name]()
    alike(repeat_cell(pattern, 20 if pattern.dim == 2 else 6))


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


def test_the_work_does_not_grow_faster_than_the_cell(monkeypatch):
    steps = []
    cycle = cell_multigrid._Cycle.__call__
    monkeypatch.setattr(
        cell_multigrid._Cycle, "__call__", lambda self, f: steps.append(1) or cycle(self, f)
    )
    counts = []
    for count in (500, 4000):
        homogenise(voronoi(count, dim=3), (1.0,), solver="multigrid")
        counts.append(len(steps))
        steps.clear()
    # Twice as long a cell: without coarse levels twice the steps.
    assert counts[1] <= 1.25 * counts[0]


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
    monkeypatch.setattr(cell_multigrid, "MOST_CYCLES", 3)
    monkeypatch.setattr(cell_at_rest, "MULTIGRID", {2: 100, 3: 100})
    pattern = voronoi(200, dim=3)
    assert homogenise(pattern, (1.0,)).solver == "direct"
    with pytest.raises(SolverError, match=r"did not answer in 3 steps; .* solver='direct' tells"):
        homogenise(pattern, (1.0,), solver="multigrid")
    monkeypatch.setattr(cell_at_rest, "AFFORDED", {2: 100, 3: 100})
    with pytest.raises(SolverError, match="solver='direct' tells"):
        homogenise(pattern, (1.0,))


def test_a_strain_that_is_stiff_and_one_that_is_soft_state_what_rounding_leaves():
    # Their common entry was off by 3e-11 of the root of both, and 1e-13 stated.
    pattern = voronoi(60, seed=0)
    soft = pattern.points[pattern.springs[:, 0], 0] < pattern.size[0] / 2
    cell = 60, pattern.springs, pattern.vectors, np.where(soft, 1.0, 1e12), 60.0
    exact = homogenise_network(*cell)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(cell_at_rest, "DENSE", 10)
        found = homogenise_network(*cell)
    root = np.sqrt(np.diag(exact.tensor))
    away = np.abs(found.tensor - exact.tensor) / np.outer(root, root)
    assert 1e-12 < away.max() <= found.error < 1e-8


def test_a_cell_of_one_point_has_nothing_loose():
    vectors = np.array([[1.0, 0.0], [0.0, 1.0], [1.0, 1.0]])
    cell = 1, np.zeros((3, 2), dtype=int), vectors, np.ones(3), 1.0
    found = homogenise_network(*cell, solver="multigrid")
    np.testing.assert_array_equal(found.tensor, homogenise_network(*cell, solver="direct").tensor)
    np.testing.assert_allclose(found.tensor, found.affine, rtol=1e-15)
