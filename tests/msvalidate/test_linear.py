"""Symmetric systems: inertia by the signs of pivots, and the mode that resists least."""

import numpy as np
import pytest
from scipy.sparse import csr_array

from msvalidate.linear import LARGEST_FACTORED, factorised, is_factored, softest_mode


@pytest.mark.parametrize("negative", [0, 1, 3])
def test_negative_pivots_are_negative_eigenvalues(negative):
    rng = np.random.default_rng(negative)
    basis = np.linalg.qr(rng.normal(size=(8, 8)))[0]
    values = np.where(np.arange(8) < negative, -1.0, 1.0) * rng.uniform(0.5, 2, 8)
    matrix = csr_array(basis * values @ basis.T)
    assert factorised(matrix).negative == negative


def test_a_zero_on_the_diagonal_is_not_positive():
    assert factorised(csr_array([[0.0, 1.0], [1.0, 0.0]])).negative == 1


def test_softest_mode_of_a_singular_matrix_is_its_null_vector():
    chain = csr_array(np.diag([1.0, 2, 2, 1]) - np.eye(4, k=1) - np.eye(4, k=-1))
    mode = softest_mode(chain)
    assert np.abs(np.abs(mode) - 0.5).max() < 1e-10, "a rigid shift, equal everywhere"


def test_what_nothing_resists_has_a_softest_mode_all_the_same():
    mode = softest_mode(csr_array((4, 4)))
    assert np.linalg.norm(mode) == pytest.approx(1.0, rel=1e-14)


@pytest.mark.parametrize("dim", [2, 3])
def test_a_factor_is_for_few_components_that_are_free(dim):
    most = LARGEST_FACTORED[dim]
    free = np.zeros((most, dim), dtype=bool)
    free.ravel()[:most] = True
    assert is_factored(free)
    free.ravel()[most] = True
    assert not is_factored(free)
