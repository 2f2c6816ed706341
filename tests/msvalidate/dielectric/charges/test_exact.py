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


def test_narrow_strips_are_wires_of_a_quarter_of_their_width():
    """π/ln(4d/w), with an error in proportion to (w/d)²."""
    for ratio in (0.1, 0.2, 0.4):
        wires = np.pi / np.log(4 / ratio)
        assert facing_strips_capacitance(ratio) == pytest.approx(wires, rel=0.1 * ratio**2)


def test_wide_strips_are_a_parallel_plate_capacitor_with_its_fringes():
    """w/d + [1 + ln(2πw/d)]/π + ..., with terms of the order of ln(w/d)/(w/d) left out."""
    ratios = np.array([10.0, 20.0, 50.0])
    plates = ratios + (1 + np.log(2 * np.pi * ratios)) / np.pi
    rest = [facing_strips_capacitance(ratio) for ratio in ratios] - plates
    left_out = rest * ratios / np.log(2 * np.pi * ratios)
    assert (left_out > 0.1).all()
    assert (left_out < 0.12).all()


def test_wider_strips_hold_more_without_a_step():
    ratios = np.geomspace(0.1, 50, 200)
    held = np.array([facing_strips_capacitance(ratio) for ratio in ratios])
    slope = np.gradient(held, ratios)
    assert (slope > 1).all()
    assert (np.diff(slope) < 0).all()


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
