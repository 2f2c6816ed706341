"""Closed forms: independent values, limits on both ends, the method of moments between them."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

from msvalidate.dielectric.charges import (
    capacitance,
    disc_capacitance,
    facing_strips,
    facing_strips_capacitance,
    square_capacitance,
)


@pytest.mark.parametrize(("ratio", "value"), [(1, 2.1157790), (6, 7.5394932), (10, 11.6813301)])
def test_facing_strips_have_the_values_of_the_theory(ratio, value):
    assert facing_strips_capacitance(ratio) == pytest.approx(value, abs=6e-8)


@pytest.mark.parametrize("ratio", [0.1, 0.7, 3.0, 20.0, 50.0])
def test_the_method_of_moments_meets_the_closed_form(ratio):
    """Cosine grading errs in proportion to 1/n²: two meshes leave 1/n⁴ or so."""
    coarse, fine = (capacitance(facing_strips(ratio, 1.0, n)) for n in (150, 300))
    assert fine + (fine - coarse) / 3 == pytest.approx(facing_strips_capacitance(ratio), rel=3e-6)


def test_disc_holds_the_charge_of_its_density():
    """Of a disc at 1 V the density is 4ε/(π·√(a²-r²)), both faces together (Weber)."""
    charge = quad(lambda u: 4 / np.pi * 2 * np.pi * np.sin(u) * 1.5, 0, np.pi / 2)[0]
    assert disc_capacitance(1.5) == pytest.approx(charge)


def test_square_lies_between_discs_inside_and_of_equal_area():
    """Of plates of one area the disc holds least (Pólya and Szegő); a part holds less."""
    assert disc_capacitance(1 / np.sqrt(np.pi)) < square_capacitance(1.0)
    assert square_capacitance(1.0) < disc_capacitance(np.sqrt(0.5))
    assert square_capacitance(3.0) == pytest.approx(3 * square_capacitance(1.0))
