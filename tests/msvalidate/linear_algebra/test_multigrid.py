"""Multigrid and conjugate gradients on matrices alone, against dense algebra."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import bsr_array, csr_array, diags_array

from msvalidate.linear_algebra.conjugate_gradients import (
    MOST_STEPS,
    answer_to_random_load,
    conjugate_gradients,
)
from msvalidate.linear_algebra.multigrid import (
    Cycle,
    MeetsNothingError,
    _by_products,
    aggregate,
    chebyshev,
    diagonal_blocks,
    restrain_in_place,
)

SIDE = 14
FREE = np.ones((SIDE * SIDE, 2), dtype=bool)
SHIFT = np.tile(np.eye(2), (SIDE * SIDE, 1))


def grid(periodic, core=1.0):
    """Stiffness of square-8 springs on a grid, in blocks; springs in the middle `core` times."""
    number = np.arange(SIDE * SIDE).reshape(SIDE, SIDE)
    K = np.zeros((SIDE * SIDE, 2, SIDE * SIDE, 2))
    for step in ((0, 1), (1, 0), (1, 1), (1, -1)):
        to = np.roll(number, (-step[0], -step[1]), axis=(0, 1))
        way = np.array(step) / np.linalg.norm(step)
        for i, j, row, col in zip(
            number.ravel(), to.ravel(), *np.divmod(number.ravel(), SIDE), strict=True
        ):
            inside = row + step[0] < SIDE and 0 <= col + step[1] < SIDE
            if periodic or inside:
                k = core if 4 <= row < 9 and 4 <= col < 9 else 1.0
                block = k * np.outer(way, way)
                K[i, :, i, :] += block
                K[j, :, j, :] += block
                K[i, :, j, :] -= block
                K[j, :, i, :] -= block
    return bsr_array(csr_array(K.reshape(2 * SIDE**2, -1)), blocksize=(2, 2))


def rigid():
    x = np.stack(np.divmod(np.arange(SIDE * SIDE), SIDE), axis=1) / SIDE - 0.5
    return np.column_stack([SHIFT, np.stack([-x[:, 1], x[:, 0]], axis=1).ravel()])


def clamped(core=1.0):
    """The grid held at one side, and which components are free."""
    A, free = grid(periodic=False, core=core), FREE.copy()
    free[:SIDE] = False
    restrain_in_place(A, free)
    A.sort_indices()
    return A, free


def as_matrix(cycle, size):
    return np.column_stack([cycle(column) for column in np.eye(size)])


@pytest.mark.parametrize("order", [None, np.random.default_rng(0).permutation(SIDE * SIDE)])
@pytest.mark.parametrize(("core", "unit"), [(1.0, 1.0), (1e4, 1.0), (1.0, 1e60)])
def test_a_cycle_is_symmetric_positive_and_nearly_the_inverse(core, unit, order):
    A, free = clamped(core)
    A = unit * A
    cycle = aggregate(A, rigid() * free.reshape(-1, 1), order)
    M = as_matrix(cycle, A.shape[0])
    assert np.abs(M - M.T).max() <= 1e-12 * core * np.abs(M).max()
    values = np.linalg.eigvals(M @ A.toarray()).real
    assert values.min() > 0.05
    assert values.max() <= 1 + 1e-9
    assert (cycle.unit == 1) is (unit == 1)
    assert cycle.indefinite_motion is None


def test_what_is_held_is_cut_off():
    A, free = clamped()
    whole, kept = grid(periodic=False).toarray(), free.ravel()
    np.testing.assert_array_equal(A.toarray()[kept][:, kept], whole[kept][:, kept])
    assert not A.toarray()[kept][:, ~kept].any()
    assert (A.diagonal()[~kept] > 0).all()


@pytest.mark.parametrize("spectral", [False, True])
def test_columns_are_solved_for_as_each_alone(spectral):
    """Answers to the part asked for; a column of nothing stays nothing."""
    A, free = clamped()
    load = np.random.default_rng(1).normal(size=(A.shape[0], 3)) * free.reshape(-1, 1)
    load[:, 1] = 0.0
    cycle = aggregate(A, rigid() * free.reshape(-1, 1))
    wanted = np.linalg.solve(A.toarray(), load)
    for column in (0, 2):
        found = conjugate_gradients(A, load[:, column], cycle, 1e-10, spectral=spectral)
        error = np.abs(found.solution - wanted[:, column]).max() / np.abs(wanted[:, column]).max()
        assert error <= 1e-9
        assert 3 < found.steps < 20
        assert found.reduction <= 1e-10
        if spectral:
            lowest = np.linalg.eigvals(as_matrix(cycle, len(load)) @ A.toarray()).real.min()
            assert found.lowest == pytest.approx(lowest, rel=0.2)
    inverse = np.linalg.inv(diagonal_blocks(A)[0])
    smooth = chebyshev(A, inverse, 2.0)
    both = conjugate_gradients(A, load, lambda r: smooth(None, r), 1e-10)
    assert not both.solution[:, 1].any()
    np.testing.assert_allclose(both.solution, wanted, atol=1e-7 * np.abs(wanted).max())
    assert conjugate_gradients(A, load[:, 1], cycle, 1e-10).steps == 0


def test_steps_end_where_they_must():
    A, free = clamped()
    cycle = aggregate(A, rigid() * free.reshape(-1, 1))
    load = np.where(free, 1.0, 0.0).ravel()
    found = conjugate_gradients(A, load, cycle, 1e-12, most=2)
    assert (found.steps, found.negative) == (2, False)
    assert found.reduction > 1e-12
    stopped = conjugate_gradients(A, load, cycle, 0.0, stop=lambda left: np.abs(left).max() < 1e-3)
    assert np.abs(load - A @ stopped.solution).max() < 1e-3
    assert stopped.negative is False


def test_steps_tell_the_lowest_eigenvalue():
    """All eigenvalues are met in as many steps as there are."""
    values = np.array([0.3, 1.0, 2.0, 5.0, 9.0])
    found = conjugate_gradients(np.diag(values), np.ones(5), np.copy, 1e-9, spectral=True)
    assert found.lowest == pytest.approx(0.3, rel=1e-9)


def test_a_cycle_of_negative_energy_is_told_and_so_is_what_does_not_settle():
    found = conjugate_gradients(np.eye(3), np.full(3, 0.1), np.negative, 1e-8)
    assert (found.steps, found.negative) == (0, True)
    stiff = diags_array(10.0 ** np.linspace(-8, 0, 2000))
    found, told = answer_to_random_load(stiff, np.copy, np.ones(2000, dtype=bool))
    assert (found.steps, told) == (MOST_STEPS, False)


@pytest.mark.parametrize("core", [1.0, 1e6])
def test_a_floating_grid_is_solved_but_for_translations(core):
    A = grid(periodic=True, core=core)
    cycle = aggregate(A, SHIFT, floating=2, highest=2.0)
    load = np.random.default_rng(2).normal(size=(SIDE * SIDE, 2, 6))
    load = (load - load.mean(axis=0)).reshape(-1, 6)
    found = conjugate_gradients(A, load, cycle, 1e-9)
    assert np.abs(A @ found.solution - load).max() <= 1e-7 * np.abs(load).max()
    assert np.abs(found.solution.reshape(-1, 2, 6).mean(axis=0)).max() <= 1e-9
    answer, told = answer_to_random_load(A, cycle, FREE.ravel(), 2)
    assert told
    assert not answer.negative


def test_a_motion_that_meets_nothing_is_found():
    """A point without springs, alone or by the coarsest level."""
    A = grid(periodic=True)
    own, row = diagonal_blocks(A)
    alone = A.data.copy()
    alone[(row == 30) | (A.indices == 30)] = 0.0
    loose = bsr_array((alone, A.indices, A.indptr), shape=A.shape)
    with pytest.raises(MeetsNothingError) as found:
        aggregate(loose, SHIFT, floating=2, highest=2.0)
    assert set(np.flatnonzero(found.value.motion) // 2) == {30}
    assert (own.trace(axis1=1, axis2=2) > 0).all()


@pytest.mark.parametrize(("part", "falls"), [(-1e-10, True), (-1e-14, False), (1e-14, False)])
def test_rounding_is_no_motion_of_negative_energy(part, falls):
    cycle = Cycle([], np.copy, softest=(np.ones(2), part))
    assert (cycle.indefinite_motion is not None) is falls


@pytest.mark.parametrize("part", [0.5, 0.05])
def test_a_motion_of_negative_energy_is_not_overlooked(part):
    """The lowest mode is turned over; where it meets little, by steps or by the coarsest level."""
    A, free = clamped()
    kept = free.ravel()
    full = A.toarray()
    values, modes = np.linalg.eigh(full[kept][:, kept])
    full[np.ix_(kept, kept)] -= (1 + part) * values[0] * np.outer(modes[:, 0], modes[:, 0])
    bent = bsr_array(csr_array(full), blocksize=(2, 2))
    cycle = aggregate(bent, rigid() * kept[:, None])
    found, told = answer_to_random_load(bent, cycle, kept)
    falls = cycle.indefinite_motion
    assert found.negative or not told or (falls is not None and falls @ bent @ falls < 0)


def test_chebyshev_takes_what_it_is_made_for():
    """Of a diagonal matrix: parts from highest/8 to highest shrink to a third at the most."""
    values = np.linspace(0.25, 2.0, 50)
    A = bsr_array(csr_array(np.diag(values)), blocksize=(1, 1))
    smooth = chebyshev(A, np.ones((50, 1, 1)), 2.0)
    left = 1 - values * smooth(None, np.ones(50))
    assert np.abs(left).max() == pytest.approx(1 / (2 * (9 / 7) ** 2 - 1), rel=1e-9)
    again = smooth(smooth(None, np.ones(50)), np.ones(50))
    np.testing.assert_allclose(1 - values * again, left**2, atol=1e-12)


def test_the_bound_of_a_smoother_is_that_of_blocks_over_roots_of_the_diagonal_ones(monkeypatch):
    """By Cholesky's roots, whose norms are those of symmetric ones."""
    basis = np.random.default_rng(4).normal(size=(8, 8))
    full = basis @ basis.T
    blocks = full.reshape(4, 2, 4, 2)
    root = np.linalg.inv(np.linalg.cholesky(np.einsum("iaib->iab", blocks)))
    over = np.einsum("iab,ibjc,jdc->ijad", root, blocks, root)
    monkeypatch.setattr("msvalidate.linear_algebra.multigrid.chebyshev", lambda *given: given[2])
    bound, _ = _by_products(bsr_array(csr_array(full), blocksize=(2, 2)), None, [])
    assert bound == pytest.approx(np.linalg.norm(over, 2, axis=(2, 3)).sum(axis=1).max())
