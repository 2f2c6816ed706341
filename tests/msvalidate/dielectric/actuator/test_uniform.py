"""Closed forms of uniform films, against energies and differences."""

from __future__ import annotations

import numpy as np
import pytest

from msvalidate.dielectric.actuator import uniform
from msvalidate.problem import ProblemError, SolverError
from tests.table import table

SPRINGS = {"axial": 1.3, "diagonal": 0.4}


def cell_energy(across, along, axial, diagonal):
    """Energy of one unit cell of the endless lattice: two edges and two diagonals."""
    diagonals = 2 * diagonal * (np.hypot(across, along) - np.sqrt(2)) ** 2
    return 0.5 * (axial * (across - 1) ** 2 + axial * (along - 1) ** 2 + diagonals)


def derivative(f, x, step=1e-5):
    return (f(x + step) - f(x - step)) / (2 * step)


@pytest.mark.parametrize("stretch", [0.8, 1.0, 1.4])
@pytest.mark.parametrize("ratio", [0.4, 0.7, 0.95])
def test_pressure_is_the_slope_of_a_cell_s_energy(ratio, stretch):
    slope = derivative(lambda l: cell_energy(stretch, l, 1.3, 0.4), ratio)  # noqa: E741
    found = uniform.pressure(ratio, stretch=stretch, **SPRINGS)
    # Differences of step 1e-5: 1e-10 by the third derivative, 1e-11 by rounding.
    assert found == pytest.approx(-slope / stretch, abs=1e-9)


def test_pull_in_of_the_report_s_lattice_is_the_known_one():
    ratio, volts = uniform.pull_in()
    assert round(volts, 3) == 6.348  # THEORY of the slab: k1 = 1, k2 = 1/2, h0 = 10, ε = 1
    assert round(ratio, 3) == 0.692


@pytest.mark.parametrize("stretch", [0.8, 1.0, 1.3])
def test_pull_in_is_the_largest_voltage(stretch):
    given = {"height": 2.0, "permittivity": 3.0, "stretch": stretch, **SPRINGS}
    ratio, volts = uniform.pull_in(**given)
    whole = uniform.relaxed_thickness(stretch, **SPRINGS)
    tried = [uniform.voltage(l, **given) for l in np.linspace(0.05, whole - 1e-9, 4001)]  # noqa: E741
    assert max(tried) <= volts * (1 + 1e-15)
    assert max(tried) == pytest.approx(volts, rel=1e-6)  # the grid's 2.4e-4, squared
    slope = derivative(lambda l: uniform.voltage(l, **given), ratio)  # noqa: E741
    assert slope == pytest.approx(0, abs=1e-8)


def test_a_voltage_is_balanced_by_its_own_energy():
    """d/dl of the cells' energy and of ½εV²/(l·h0) cancel at the voltage that is said to hold l."""
    ratio, height, permittivity = 0.8, 2.5, 1.7
    volts = uniform.voltage(ratio, height=height, permittivity=permittivity, **SPRINGS)

    def total(l):  # noqa: E741
        stored = height * cell_energy(1.0, l, 1.3, 0.4)
        return stored - 0.5 * permittivity * volts**2 / (l * height)

    assert derivative(total, ratio) == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("part", [0.0, 0.3, 0.9, 1.0])
def test_thickness_inverts_the_voltage(part):
    end = uniform.pull_in(stretch=1.2, **SPRINGS)
    ratio = uniform.thickness(part * end.voltage, stretch=1.2, **SPRINGS)
    assert ratio >= end.thickness
    back = uniform.voltage(ratio * (1 - 1e-15), stretch=1.2, **SPRINGS) if part else 0.0
    assert back == pytest.approx(part * end.voltage, rel=1e-12)


def test_no_thickness_beyond_pull_in():
    with pytest.raises(SolverError, match=r"no thickness at 6.4 V; it is pulled in at 6.34789 V"):
        uniform.thickness(6.4)


def test_a_voltage_does_not_thicken():
    with pytest.raises(ProblemError, match="only squeezes"):
        uniform.voltage(1.2)


@table(
    ("ask", "said"),
    [
        (lambda: uniform.pull_in(axial=np.nan), "axial: nan"),
        (lambda: uniform.pull_in(axial="a"), "axial: expected numbers"),
        (lambda: uniform.pull_in(diagonal=-5.0), "diagonal: -5.0 Pa; it must be above zero"),
        (lambda: uniform.pull_in(stretch=1e200), r"stretch: 1e\+200; give 1e-06 to 1e\+06"),
        (lambda: uniform.relaxed_thickness(1.0, axial=-1.0), "axial: -1.0 Pa"),
    ],
)
def test_values_out_of_range_are_named(ask, said):
    with pytest.raises(ProblemError, match=said):
        ask()


def largest(f, low, high):
    """Where and how large a smooth function is at its largest, by a fine grid."""
    x = np.linspace(low, high, 200_001)
    values = f(x)
    at = values.argmax()
    assert 0 < at < len(x) - 1
    return x[at], values[at]


def test_linear_stress_pull_in_is_the_largest_voltage():
    ratio, volts = uniform.linear_stress_pull_in(2.0, 3.0, 0.5)
    at, value = largest(lambda l: np.sqrt(2 * 9 * l**2 * 2 * (1 - l) / 0.5), 0.01, 0.99)  # noqa: E741
    assert ratio == pytest.approx(at, abs=1e-5)
    assert volts == pytest.approx(value, rel=1e-9)


def neo_hookean(stretch, sides):
    """Energy over μ of an incompressible film stretched along one or two sides, and its area."""
    if sides == 2:
        return 0.5 * (2 * stretch**2 + stretch**-4 - 3), stretch**2
    return 0.5 * (stretch**2 + stretch**-2 - 2), stretch


@pytest.mark.parametrize(
    ("sides", "field"),
    [(2, uniform.biaxial_nominal_field), (1, uniform.plane_strain_nominal_field)],
)
@pytest.mark.parametrize("stretch", [1.1, 1.26, 2.0])
def test_neo_hookean_films_rest_at_their_field(sides, field, stretch):
    """Energy less ½ε(V/h)² of the volume; the capacitance grows with the area squared."""
    square = field(stretch) ** 2

    def total(wide):
        stored, area = neo_hookean(wide, sides)
        return stored - 0.5 * square * area**2

    assert derivative(total, stretch) == pytest.approx(0, abs=1e-8)


def test_biaxial_pull_in_is_the_largest_field():
    ratio, volts = uniform.biaxial_pull_in(1.0, 1.0)
    at, value = largest(lambda x: np.sqrt(x**-2.0 - x**-8.0), 1.01, 3.0)
    assert ratio == pytest.approx(at**-2, abs=1e-5)
    assert volts == pytest.approx(value, rel=1e-9)
    assert (round(ratio, 3), round(volts, 3)) == (0.63, 0.687)
    assert round(volts / ratio, 3) == 1.091  # the true field


def test_plane_strain_has_no_pull_in():
    fields = [uniform.plane_strain_nominal_field(x) for x in np.linspace(1, 30, 500)]
    assert (np.diff(fields) > 0).all()
    assert 0.999 < fields[-1] < 1


def test_bonded_film_goes_first_at_short_waves():
    waves = np.geomspace(1e-3, 1e3, 400)
    fields = np.array([uniform.bonded_film_field(wave) for wave in waves])
    assert (np.diff(fields) <= 1e-9 * fields[1:]).all()  # the series meets the closed form at 0.02
    assert fields[-1] == pytest.approx(uniform.bonded_film_limit(), rel=1e-12)
