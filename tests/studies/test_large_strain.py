"""The study `large_strain`: laws by another route, digits of closed forms, and what tables say."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from msvalidate.studies.large_strain import bending, buckling, fibres, rubber
from scipy.integrate import quad
from scipy.optimize import brentq

from reference_fem.large_strain import Fibres
from tests.table import table

LATTICES = {springs.name: springs for springs in fibres.lattices()}
F = np.array([[1.23, 0.31], [-0.12, 0.84]])


@table(
    ("name", "stretch", "stress", "across"),
    [
        ("square", 0.9, -0.25781050, 1.03318267),
        ("square", 1.5, 1.53778968, 0.84798710),
        ("triangular, row", 1.5, 4 / 3, np.sqrt(7 / 12)),  # m² = 1 - (λ² - 1)/3
        ("triangular, across", 0.9, -0.24724991, 1.03556145),
        ("triangular, across", 1.1, 0.28293453, 0.96884988),
        ("triangular, across", 1.5, 1.62568291, 0.88068980),
    ],
)
def test_lattices_pulled_with_free_sides(name, stretch, stress, across):
    """Digits of another program."""
    found = fibres.pulled(LATTICES[name].stress, "uniaxial", stretch - 1)
    assert found == pytest.approx((stress, across), abs=6e-9)


@pytest.mark.parametrize("springs", fibres.lattices()[:3], ids=lambda springs: springs.name)
def test_stress_and_waves_are_those_of_elements_fibres(springs):
    law = Fibres(springs.r, springs.k, springs.V0)
    assert springs.stress(F) == pytest.approx(law.stress(F[None])[0], rel=1e-12)
    pressed = np.diag([0.7, 0.9])
    A = law.tangent(pressed[None])[0]
    turn = np.linspace(0, np.pi, 721)
    n = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    least = np.linalg.eigvalsh(np.einsum("iJkL,tJ,tL->tik", A, n, n)).min()
    assert springs.softest(pressed) == pytest.approx(least, rel=1e-9)


def test_a_confined_square_lattice_gives_way_along_its_rows():
    """Waves along the load that move across it: what is left of springs along it is their push."""

    def stiffness(stretch: float) -> float:
        d = np.hypot(stretch, 1)
        return 2 * (1 - 1 / stretch) + 2 * (1 - np.sqrt(2) / d + np.sqrt(2) / d**3)

    lost = 1 - brentq(stiffness, 0.5, 0.9)
    assert fibres.ellipticity_lost(LATTICES["square"], "confined") == pytest.approx(lost, abs=1e-9)


def test_stress_of_a_pulled_random_network_by_an_integral():
    """Uniaxial: springs at angle arccos z have r² = λ² z² + (1 - z²)/λ."""
    stretch = 2.3
    point = pd.DataFrame({"test": ["uniaxial"], "stretch": [stretch], "stress_MPa": [1.0]})
    for law, force in (("linear spring", lambda r: r - 1), ("Green's spring", lambda r: r**3 - r)):

        def along(z: float, force=force) -> float:
            r = np.sqrt(stretch**2 * z**2 + (1 - z**2) / stretch)
            return force(r) / r * (stretch**2 * z**2 - (1 - z**2) / (2 * stretch)) / stretch

        (found,) = rubber.stress_of_springs(point, rubber.LAWS[law])
        assert found == pytest.approx(quad(along, 0, 1)[0], rel=1e-7)


def test_published_constants_of_rubber():
    """6.3, .012 and -.1 kg/cm² have the shear modulus ½ Σ μ α = 4.225 kg/cm²."""
    small = pd.DataFrame({"test": ["pure shear"], "stretch": [1 + 1e-6], "stress_MPa": [1.0]})
    (stress,) = rubber.stress_of_ogden(small)
    assert stress == pytest.approx(4 * 4.225 * 0.0980665 * 1e-6, rel=1e-5)


def test_elastica_bends_as_its_series_says():
    """P/P_cr = 1 + α²/8 + …, top aside over length (2/π) α (1 + …) by its angle α."""
    angle = 1e-2
    load, aside = buckling.elastica(np.sin(angle / 2))
    assert load - 1 == pytest.approx(angle**2 / 8, rel=1e-4)
    assert aside == pytest.approx(2 / np.pi * angle, rel=1e-4)


def test_the_arc_keeps_its_middle_and_turns_its_ends_as_plates():
    strain = 0.3
    ends = np.array([[4.0, 0.0], [4.0, 0.5], [4.0, 1.0]])
    low, middle, high = ends + bending.arc(ends, strain)
    assert np.linalg.norm(high - low) == pytest.approx(1.0, rel=1e-12)
    assert (low + high) / 2 == pytest.approx(middle, abs=1e-12)
    normal = np.arctan2(*(high - low)[::-1]) - np.pi / 2
    assert abs(normal) == pytest.approx(strain * 4.0, rel=1e-12)


def test_springs_reach_as_far_as_neo_hookean_elements(small_tables):
    reached = small_tables("large_strain")["reached"].set_index("law")["reached"]
    assert reached["springs"] == reached["neo-Hookean"] > reached["St. Venant-Kirchhoff"]
