"""Very many segments: the charges of the dense matrix, in steps that hardly grow with them."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from msvalidate.dielectric.charges import Moments, Multipole, facing_strips, forces
from msvalidate.dielectric.charges.moments import coefficients, segment_lines
from msvalidate.dielectric.charges.two_levels import TwoLevels
from msvalidate.problem import ProblemError

VOLTAGES = (0.7, -0.4)


def test_without_the_library_it_says_what_to_install(monkeypatch, wavy):
    monkeypatch.setitem(sys.modules, "pyfmmlib", None)
    with pytest.raises(ProblemError, match=r"pip install 'msvalidate\[multipole\]'") as told:
        Multipole(wavy(5))
    assert "\n" not in str(told.value)


@pytest.mark.parametrize("n", [20, 300])
def test_two_levels_are_nearly_the_inverse(wavy, n):
    """Symmetric, positive on neutral charges, and of a spectrum that is narrow."""
    electrodes = wavy(n)
    nearly = TwoLevels(*segment_lines(electrodes), electrodes.electrode, np.log(electrodes.extent))
    m = len(electrodes.segments)
    inverse = np.column_stack([nearly(column) for column in np.eye(m + 1)])
    np.testing.assert_allclose(inverse, inverse.T, atol=1e-10 * np.abs(inverse).max())
    P = np.ones((m + 1, m + 1))
    P[:m, :m], P[m, m] = coefficients(electrodes, 1.0, "galerkin") * 2 * np.pi, 0
    values = np.linalg.eigvals(inverse @ P)
    assert np.abs(values.imag).max() < 1e-6
    assert values.real.max() / values.real.min() < 15
    assert values.real.min() > 0


class TestWithTheLibrary:
    """What needs pyfmmlib itself."""

    @pytest.fixture(autouse=True)
    def _library(self):
        pytest.importorskip("pyfmmlib")

    @pytest.mark.parametrize("pair", ["wavy", "strips"])
    def test_charges_are_those_of_the_dense_matrix(self, wavy, pair):
        electrodes = wavy(250) if pair == "wavy" else facing_strips(6.0, 0.2, 250)
        expected = Moments(electrodes, permittivity=2.0).charges(VOLTAGES)
        found = Multipole(electrodes, permittivity=2.0).charges(VOLTAGES)
        scale = np.abs(expected.charge).max()
        np.testing.assert_allclose(found.charge, expected.charge, rtol=0, atol=1e-7 * scale)
        assert found.energy == pytest.approx(expected.energy, rel=1e-9)
        assert found.floating == pytest.approx(expected.floating, abs=1e-8)
        assert abs(found.charge.sum()) < 1e-10 * np.abs(found.charge).sum()
        pull = forces(expected)
        np.testing.assert_allclose(forces(found), pull, atol=1e-7 * np.abs(pull).max())

    def test_steps_hardly_grow_with_segments(self):
        pairs = [facing_strips(6.0, 1.0, n) for n in (400, 1200)]
        steps = [Multipole(pair).charges(VOLTAGES).iterations for pair in pairs]
        assert steps[1] < 1.4 * steps[0]  # without a preconditioner they grow like √3 or more
        assert steps[1] < 40

    def test_several_potentials_at_once(self, wavy):
        many = Multipole(wavy(40))
        potential = many.electrodes.middle  # of electrodes in a uniform field
        dense = Moments(wavy(40)).solve(potential)
        np.testing.assert_allclose(many.solve(potential), dense, atol=1e-6 * np.abs(dense).max())
