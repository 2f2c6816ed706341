"""Symmetric systems: inertia by the signs of pivots, and the mode that resists least."""

import resource
from pathlib import Path

import numpy as np
import pytest
from scipy.sparse import csr_array, diags_array, eye_array, kron

from msvalidate.linear_algebra.factor import factorise, softest_mode
from msvalidate.problem import SolverError


def test_softest_mode_of_a_singular_matrix_is_its_null_vector():
    chain = csr_array(np.diag([1.0, 2, 2, 1]) - np.eye(4, k=1) - np.eye(4, k=-1))
    mode = softest_mode(chain)
    assert np.abs(np.abs(mode) - 0.5).max() < 1e-10, "a rigid shift, equal everywhere"


def test_what_nothing_resists_has_a_softest_mode_all_the_same():
    mode = softest_mode(csr_array((4, 4)))
    assert np.linalg.norm(mode) == pytest.approx(1.0, rel=1e-14)


def test_a_given_order_changes_nothing_but_the_way():
    rng = np.random.default_rng(0)
    basis = rng.normal(size=(9, 9))
    matrix, load = csr_array(basis @ basis.T), rng.normal(size=9)
    factor = factorise(matrix, rng.permutation(9))
    np.testing.assert_allclose(matrix @ factor.solve(load), load, rtol=0, atol=1e-10)
    assert factor.negative == 0


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
