"""Closed forms of uniform films, against energies, differences and a boundary value problem."""

from __future__ import annotations

import numpy as np
import pytest

from msvalidate.dielectric.actuator import uniform
from msvalidate.lattice import square
from msvalidate.network import energy, spring_network
from msvalidate.problem import Box, ProblemError, SolverError
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


def test_a_filled_slab_has_the_energy_of_its_cells():
    lattice = square(Box((3.0, 2.0)), (6, 4))
    k = np.array([1.3, 0.4])[lattice.kind] * lattice.share
    network = spring_network(lattice.points, lattice.springs, k)
    moved = lattice.points * [1.2, 0.8]
    cells = 24 * cell_energy(1.2, 0.8, 1.3, 0.4) * 0.5**2  # of squares of 0.5 m
    assert energy(network, moved) == pytest.approx(cells, rel=1e-13)


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


def surface_stiffness(wave):
    """Normal pressure over μk·u of an incompressible layer on a rigid base, of thickness 1.

    u = -∂ψ/∂y, v = ∂ψ/∂x with ψ = f(y)·sin(kx), f'''' - 2k²f'' + k⁴f = 0, by collocation.
    """
    n = 40
    y = 0.5 * (1 - np.cos(np.pi * np.arange(n + 1) / n))
    T = np.polynomial.chebyshev
    basis = np.eye(n + 1)
    at = [
        T.chebval(2 * y - 1, T.chebder(basis, d)) * 2.0**d if d else T.chebval(2 * y - 1, basis)
        for d in range(5)
    ]
    f, f1, f2, f3, f4 = (a.T for a in at)
    k = wave
    rows = [f4[i] - 2 * k**2 * f2[i] + k**4 * f[i] for i in range(2, n - 1)]
    # Base: u = v = 0. Surface: v = 1 (k f = 1), no shear (f'' + k² f = 0).
    rows += [f[0], f1[0], k * f[-1], f2[-1] + k**2 * f[-1]]
    right = np.zeros(n + 1)
    right[-2] = 1.0
    c = np.linalg.solve(np.array(rows), right)
    # x-momentum at the surface: ∂p/∂x = μ∇²u, u = -f' sin; p = (f''' - k² f')/k · cos.
    # σ_yy = -p + 2μ ∂v/∂y, of a v of k·f·cos.
    pressure = (f3[-1] - k**2 * f1[-1]) @ c / k
    return (-pressure + 2 * k * (f1[-1] @ c)) / k


@pytest.mark.parametrize("wave", [0.3, 1.0, 3.0, 8.0])
def test_bonded_film_field_against_a_boundary_value_problem(wave):
    square = surface_stiffness(wave) * np.tanh(wave)
    assert uniform.bonded_film_field(wave) ** 2 == pytest.approx(square, rel=1e-6)


def test_bonded_film_goes_first_at_short_waves():
    waves = np.geomspace(1e-3, 1e3, 400)
    fields = np.array([uniform.bonded_film_field(wave) for wave in waves])
    assert (np.diff(fields) <= 1e-9 * fields[1:]).all()  # the series meets the closed form at 0.02
    assert fields[-1] == pytest.approx(uniform.bonded_film_limit(), rel=1e-12)
