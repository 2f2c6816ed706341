"""Films that strain as a whole: closed forms of their voltages and of where they pull in."""

from __future__ import annotations

import numpy as np
import pytest

from msvalidate.problem import ProblemError, SolverError
from reference_fem.actuator import Film
from reference_fem.large_strain import Fibres, NeoHookean, square_fibres


def rubber(dim, lam=1.0):
    """Neo-Hookean with μ = 1."""
    return NeoHookean(1.0, lam, dim)


def test_square_lattice_held_at_its_sides():
    # V² = 2 h² l² P(l)/ε with P = k1 (1 - l) + 2 k2 l (√(2/(1 + l²)) - 1).
    film = Film(square_fibres(1.0, 0.5), height=10.0, permittivity=1.0, sides="held")
    for ratio in (0.95, 0.8, 0.692):
        P = (1 - ratio) + ratio * (np.sqrt(2 / (1 + ratio**2)) - 1)
        assert film.voltage(ratio) == pytest.approx(np.sqrt(200 * ratio**2 * P), rel=1e-12)
    top = film.pull_in()
    assert (top.voltage, top.ratio) == pytest.approx((6.348, 0.692), abs=5e-4)
    assert top.stretch == 1


def test_linear_stress_pulls_in_at_two_thirds():
    # One fibre up the film: P = C (l - 1). V² = 2 C h² l² (1 - l)/ε is largest at l = 2/3.
    film = Film(Fibres(np.array([[0.0, 1.0]]), np.array([3.0]), 1.0), 2.0, 0.5, "held")
    top = film.pull_in()
    assert top.ratio == pytest.approx(2 / 3, abs=1e-6)
    assert top.voltage == pytest.approx(np.sqrt(8 * 3 * 2.0**2 / (27 * 0.5)), rel=1e-12)


def test_rubber_free_along_both_sides():
    # Incompressible: l = λ⁻², (ε/μ) E_nominal² = λ⁻² - λ⁻⁸, largest at λ⁶ = 4.
    film = Film(rubber(3), sides="volume kept")
    for ratio in (0.9, 0.7):
        assert film.voltage(ratio) == pytest.approx(np.sqrt(ratio - ratio**4), rel=1e-12)
    top = film.pull_in()
    # A maximum is flat: rounding of 1e-16 in a voltage hides 1e-8 of the ratio.
    assert top.ratio == pytest.approx(2 ** (-2 / 3), rel=1e-7)
    assert top.stretch == pytest.approx(2 ** (1 / 3), rel=1e-7)
    assert top.nominal_field == pytest.approx(np.sqrt(3 / 4 * 4 ** (-1 / 3)), rel=1e-12)
    assert top.true_field == pytest.approx(np.sqrt(3 / 4 * 4 ** (1 / 3)), rel=1e-7)
    expected = (0.630, 0.687, 1.091)
    assert (top.ratio, top.nominal_field, top.true_field) == pytest.approx(expected, abs=5e-4)


@pytest.mark.parametrize("dim", [2, 3])
def test_the_limit_of_no_change_of_volume_is_approached_to_first_order(dim):
    limit = Film(rubber(dim), sides="volume kept").voltage(0.8)
    gaps = [Film(rubber(dim, lam)).voltage(0.8) - limit for lam in (1e3, 1e4)]
    assert gaps[0] / gaps[1] == pytest.approx(10, rel=0.01)


def test_rubber_in_plane_strain_does_not_pull_in():
    # (ε/μ) E_nominal² = 1 - λ⁻⁴ rises towards 1 for ever.
    film = Film(rubber(2), sides="volume kept")
    assert film.pull_in() is None
    ratios = np.geomspace(0.99, 0.06, 50)
    assert [film.voltage(ratio) for ratio in ratios] == pytest.approx(
        np.sqrt(1 - ratios**4), rel=1e-9
    )


def test_rubber_that_gives_a_little_pulls_in_far_down_in_plane_strain():
    # The field's pull on the sides widens a film that gives, by v² = (V/h)²: λ ln J ≈ v²/(2 l²)
    # for small l, and 1 - v² = l⁴ + O(μ/λ l²): largest where both are alike, l ~ (μ/λ)^(1/6).
    tops = [Film(rubber(2, lam)).pull_in() for lam in (1e4, 1e6)]
    assert tops[1].ratio / tops[0].ratio == pytest.approx(100 ** (-1 / 6), rel=0.02)
    assert tops[0].voltage < tops[1].voltage < 1


@pytest.mark.parametrize("sides", ["held", "free", "volume kept"])
def test_voltages_are_stationary_points_of_the_free_energy(sides):
    # Its derivatives in l and λ, by differences, of W - ½ ε (V/h)² λ²/l.
    law, ratio = rubber(3, 2.0), 0.8
    film = Film(law, sides=sides)
    V, stretch, step = film.voltage(ratio), film.stretch(ratio), 1e-5

    def energy(ratio, side):
        W = law.energy(np.diag([side, side, ratio])[None])[0]
        return W - 0.5 * V**2 * side**2 / ratio

    def slope(way):
        ahead = energy(ratio + step * way[0], stretch + step * way[1])
        return (ahead - energy(ratio - step * way[0], stretch - step * way[1])) / (2 * step)

    ways = {"held": [(1, 0)], "free": [(1, 0), (0, 1)], "volume kept": [(ratio, -stretch / 2)]}[
        sides
    ]
    assert [slope(way) for way in ways] == pytest.approx([0.0] * len(ways), abs=1e-9)


@pytest.mark.parametrize("sides", ["held", "free", "volume kept"])
def test_units(sides):
    small = Film(rubber(3, 2.0), sides=sides)
    large = Film(NeoHookean(4.0, 8.0, 3), height=3.0, permittivity=0.01, sides=sides)
    expected = 3.0 * np.sqrt(4.0 / 0.01) * small.voltage(0.8)
    assert large.voltage(0.8) == pytest.approx(expected, rel=1e-12)


def test_bad_films_are_refused():
    law = square_fibres(1.0, 0.5)
    with pytest.raises(ProblemError, match="height of a film: 0"):
        Film(law, height=0.0)
    with pytest.raises(
        ProblemError, match="sides of a film: 'loose'; choose held, free, volume kept"
    ):
        Film(law, sides="loose")
    with pytest.raises(ProblemError, match="permittivity of a film"):
        Film(law, permittivity=-1.0)
    with pytest.raises(ProblemError, match="law: 'rubber'"):
        Film("rubber")
    with pytest.raises(ProblemError, match=r"ratio of thickness: 1\.2; a voltage"):
        Film(law).voltage(1.2)
    with pytest.raises(ProblemError, match="ratio of thickness"):
        Film(law).voltage(0.0)
    with pytest.raises(ProblemError, match="ratio of thickness: 1e-300; no film is that thin"):
        Film(law).voltage(1e-300)


def test_a_film_whose_sides_find_no_rest_is_refused():
    # P_11 λ + P_33 l = λ² + l² - 2 - 1.2 ln(λ² l) of this law is above zero at all λ for l = 1/2.
    film = Film(NeoHookean(1.0, -0.6, 3))
    assert film.voltage(1.0) == 0
    stretch = np.geomspace(0.01, 100, 1000)
    assert (stretch**2 + 0.25 - 2 - 1.2 * np.log(stretch**2 * 0.5)).min() > 0
    with pytest.raises(SolverError, match="its sides find no rest at a ratio of thickness "):
        film.voltage(0.5)
