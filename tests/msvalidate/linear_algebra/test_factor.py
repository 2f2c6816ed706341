"""Symmetric systems: inertia by the signs of pivots, and the mode that resists least."""

import ctypes
import os
import resource
from pathlib import Path

import numpy as np
import pytest
from scipy.sparse import csr_array, diags_array, eye_array, kron

from msvalidate.linear_algebra.factor import (
    factorise,
    inverse_iteration,
    silence_library,
    softest_mode,
)
from msvalidate.problem import Box, Isotropic, SolverError
from msvalidate.springs.network import spring_network, tangent
from reference_fem import box_discretisation
from reference_fem.elasticity import stiffness


def test_softest_mode_of_a_singular_matrix_is_its_null_vector():
    chain = csr_array(np.diag([1.0, 2, 2, 1]) - np.eye(4, k=1) - np.eye(4, k=-1))
    mode = softest_mode(chain)
    assert np.abs(np.abs(mode) - 0.5).max() < 1e-10, "a rigid shift, equal everywhere"


def test_what_nothing_resists_has_a_softest_mode_all_the_same():
    mode = softest_mode(csr_array((4, 4)))
    assert np.linalg.norm(mode) == pytest.approx(1.0, rel=1e-14)


def test_a_mode_whose_squares_overflow_has_length_one():
    mode = inverse_iteration(lambda load: 1e200 * load, 4)
    assert np.linalg.norm(mode) == pytest.approx(1.0, rel=1e-14)


def test_a_given_order_changes_nothing_but_the_way():
    rng = np.random.default_rng(0)
    basis = rng.normal(size=(9, 9))
    matrix, load = csr_array(basis @ basis.T), rng.normal(size=9)
    factor = factorise(matrix, rng.permutation(9))
    np.testing.assert_allclose(matrix @ factor.solve(load), load, rtol=0, atol=1e-10)
    assert factor.negative == 0


def spring_tangent(seed, dim, push):
    """Tangent of a random network whose springs are pushed, so that some of its motions fall."""
    rng = np.random.default_rng(seed)
    points = rng.uniform(size=(9, dim))
    springs = np.array([(i, j) for j in range(9) for i in range(j) if rng.uniform() < 0.8])
    length = np.linalg.norm(points[springs[:, 1]] - points[springs[:, 0]], axis=1)
    held = np.zeros(points.shape, dtype=bool)
    held[:dim] = True
    stiffness = 10.0 ** rng.uniform(-1, 1, len(springs))
    network = spring_network(points, springs, stiffness, rest_length=push * length, fixed=held)
    free = ~held.ravel()
    return tangent(network, points)[free][:, free]


def element_stiffness(seed, dim, shift):
    """Stiffness of a box of elements less a part of its mass, as of a wave."""
    cells, element = ((4, 3), "Q2") if dim == 2 else ((3, 2, 2), "T1")
    body = box_discretisation(Box((1.0, 0.7, 0.8)[:dim]), cells, element)
    nu = np.random.default_rng(seed).uniform(-0.3, 0.4)
    K = stiffness(body, Isotropic(1.0, nu, "solid" if dim == 3 else "plane_strain"))
    free = np.flatnonzero((np.repeat(body.points[:, :1], dim, axis=1) > 0).T)
    return K[free][:, free] - shift * eye_array(len(free))


def with_eigenvalues(values, seed):
    """A full matrix of given eigenvalues."""
    Q, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(len(values),) * 2))
    return (Q * values) @ Q.T


MATRICES = {
    "networks": [spring_tangent(s, 2 + s % 2, p) for s in range(15) for p in (1.0, 1.3, 1.8)],
    "elements": [
        element_stiffness(s, 2 + s % 2, c) for s in range(12) for c in (0, 0.02, 0.1, 0.4)
    ],
    "one negative": [with_eigenvalues(np.r_[-1.0, 1:12], s) for s in range(30)],
    "repeated": [with_eigenvalues(np.repeat([-2.0, 1.0, 3.0], s % 4 + 1), s) for s in range(30)],
    "nearly singular": [
        with_eigenvalues(np.r_[sign * 10.0 ** -(6 + s % 6), 1:12], s)
        for s in range(24)
        for sign in (1, -1)
    ],
}


@pytest.mark.parametrize("kind", MATRICES)
def test_signs_of_pivots_are_those_of_eigenvalues(kind):
    """Of all 201; in any order, by the factor that both sides take, and its answers with it."""
    assert sum(map(len, MATRICES.values())) >= 200
    counts = []
    for number, matrix in enumerate(MATRICES[kind]):
        A = csr_array(matrix)
        order = np.random.default_rng(number).permutation(A.shape[0])
        factor, values = factorise(A, order), np.linalg.eigvalsh(A.toarray())
        counts.append((factor.negative, int((values < 0).sum())))
        load = np.ones((A.shape[0], 2))
        left = np.abs(A @ factor.solve(load) - load).max()
        assert left <= 1e-10 * np.abs(values).max() / np.abs(values).min()
    assert [found for found, _ in counts] == [wanted for _, wanted in counts]
    assert {min(wanted, 1) for _, wanted in counts} >= ({1} if kind != "elements" else {0, 1})


@pytest.mark.parametrize("rows", [[[0, 1], [1, 0]], [[1, 1, 0], [1, 1, 1], [0, 1, 1]]])
def test_a_pivot_of_zero_is_one_negative_motion_at_least(rows):
    """One eigenvalue is below zero: by rows exchanged, none of the pivots would be."""
    factor = factorise(csr_array(np.array(rows, dtype=float)), np.arange(len(rows)))
    assert factor.is_exchanged
    assert factor.negative == 1


def test_a_matrix_that_rounding_made_singular_has_a_factor_if_asked():
    singular = csr_array(np.array([[1.0, -1.0], [-1.0, 1.0]]))
    with pytest.raises(RuntimeError):
        factorise(singular)
    balanced = np.array([1.0, -1.0])
    found = factorise(singular, mend=True).solve(balanced)
    np.testing.assert_allclose(singular @ found, balanced, rtol=1e-12)


def test_a_lack_of_memory_is_one_line_and_the_library_is_quiet(capfd):
    """What SciPy raises when SuperLU gets no memory: here by a limit on the process's own."""
    limits = resource.getrlimit(resource.RLIMIT_AS)
    cells = 160
    one = diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(cells, cells))
    grid = csr_array(kron(kron(one, eye_array(cells)), eye_array(8)))
    matrix = csr_array(grid + kron(eye_array(cells), kron(one, np.ones((8, 8)))))
    now = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    resource.setrlimit(resource.RLIMIT_AS, (now * resource.getpagesize() + 2**26, limits[1]))
    try:
        with pytest.raises(SolverError, match=r"take more memory than there is; take solver"):
            factorise(matrix)
    finally:
        resource.setrlimit(resource.RLIMIT_AS, limits)
    assert capfd.readouterr() == ("", "")


def test_lines_of_a_library_that_fails_are_not_written(capfd):
    """What it writes at once, and what C keeps back; our own are, afterwards."""
    library = ctypes.CDLL(None)

    @silence_library()
    def fail():
        os.write(2, b"at once")
        library.puts(b"later")
        raise MemoryError

    with pytest.raises(MemoryError):
        fail()
    library.fflush(None)
    os.write(1, b"ours")
    assert capfd.readouterr() == ("ours", "")
