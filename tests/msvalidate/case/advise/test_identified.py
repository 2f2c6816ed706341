"""Solids of given tensors: conditions of stability, and tables in closed form."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from msvalidate.case.advise.advice import step_limits, step_words
from msvalidate.case.advise.identify import (
    STABLE,
    Identified,
    identified_lines,
    identify_cubic,
    identify_lattice,
    mass_density,
    moduli_rows,
    with_bounds,
    with_cells,
)
from msvalidate.springs.constants.bounds import TensorBounds
from msvalidate.springs.constants.stiffness import ALIKE
from msvalidate.springs.constants.waves import least_stable_volume
from tests.registries import LATTICES
from tests.table import refused


@pytest.mark.parametrize(
    ("dim", "density", "thickness", "expected"),
    [
        (3, None, None, (1000.0, "1000 kg/m³ (default)")),
        (3, 7.5, None, (7.5, "7.5 kg/m³")),
        (2, 7.5, 0.2, (1.5, "7.5 kg/m³")),
        (2, None, 0.2, (200.0, "1000 kg/m³ (default)")),
        (2, None, None, (None, "")),
        (1, None, None, (None, "")),
        (3, 7.5, 0.2, "--thickness: a solid has none"),
        (3, None, 0.2, "--thickness: a solid has none"),
        (1, 7.5, None, "--density: a chain has no volume"),
        (1, 7.5, 0.2, "--density: a chain has no volume"),
        (2, 7.5, None, "--density: a plane lattice's mass takes its --thickness"),
    ],
)
def test_mass_of_a_volume_in_each_dimension(dim, density, thickness, expected):
    if isinstance(expected, str):
        with refused(expected):
            mass_density(dim, density, thickness)
    else:
        assert mass_density(dim, density, thickness) == expected


@pytest.mark.parametrize("name", ["triangular", "fcc"])
@pytest.mark.parametrize("spacing", [1.0, 0.5])
def test_volume_energy_is_bounded_by_short_waves(name, spacing):
    pattern, k = LATTICES[name](), (3.0,)
    k = k * pattern.kinds
    least = least_stable_volume(pattern, k) / spacing ** (pattern.dim - 2)
    assert least < 0
    text = f"unstable: short waves ask for κ above {least:.6g}"
    for part, stable in ((1 + 1e-6, text), (1 - ALIKE / 2, text), (1 - 1e-6, STABLE)):
        assert identify_lattice(name, k, spacing, part * least).stable == stable


@pytest.mark.parametrize("name", ["triangular", "cubic18"])
def test_frequencies_follow_stiffness_mass_and_spacing(name):
    pattern = LATTICES[name]()
    k = np.array([2.0, 1.0][: pattern.kinds])
    one = identify_lattice(name, k, 1.0, 0.3, 1.0)
    assert one.whose
    h, rho = 0.25, 9.0  # a mass of rho·h**dim, cells of kappa·h**(dim - 2) N/m
    other = identify_lattice(name, 4 * k, h, 4 * 0.3 / h ** (pattern.dim - 2), rho)
    assert other.omega == pytest.approx(one.omega * 2 / (3 * h ** (pattern.dim / 2)), rel=1e-9)
    none = identify_lattice(name, k, 1.0, 0.3)
    assert np.isnan(none.omega)
    assert "κ = 0.3" in none.what


def test_frequency_of_the_endless_lattice_is_nearly_that_of_a_block():
    """Triangular: 6 k/m at the middle of an edge of the Brillouin zone; a free side adds little."""
    omega = identify_lattice("triangular", (2.0,), 0.5, density=3.0).omega
    endless = np.sqrt(6 * 2.0 / (3.0 * 0.5**2 * np.sqrt(3) / 2))
    assert 1 - 1e-9 <= omega / endless < 4 / 3


@pytest.mark.parametrize(
    "values", [(0.5, 0.1, 0.2), (1.0, -0.45, 0.2), (1.0, 0.99, 0.2), (1.0, -0.2, 3.0)]
)
def test_cubic_solids(values):
    found = identify_cubic(*values)
    C11, C12, C44 = values
    corner = C12 + (C11 - C12) * np.eye(3)
    expected = np.block([[corner, np.zeros((3, 3))], [np.zeros((3, 3)), C44 * np.eye(3)]])
    np.testing.assert_array_equal(found.tensor, expected)
    assert (found.error, found.stable, found.solid) == (0.0, STABLE, True)


@pytest.mark.parametrize(
    "values",
    [(1, 0.5, 0), (1, 0.5, -0.5), (1, 1, 0.5), (1, 1.5, 0.5), (1, -0.5, 0.5), (1, -0.6, 0.5)],
)
def test_cubic_constants_that_are_no_solid(values):
    with refused("--cubic: cubic solid, C11, C12, C44"):
        identify_cubic(*values)


def homogenised(tensor, change=0.0, floppy=0):
    affine = np.array(tensor, dtype=float)
    affine[0, 1] += change
    return SimpleNamespace(tensor=np.array(tensor, float), affine=affine, floppy=floppy, error=0.1)


def test_cells_add_to_normal_stresses():
    solid = homogenised([[5.0, 1.0, 0.5], [1.0, 4.0, 0.0], [0.5, 0.0, 2.0]])
    found = with_cells("it", solid, 0.25)
    added = found.tensor - solid.tensor
    np.testing.assert_array_equal(added, [[0.25, 0.25, 0], [0.25, 0.25, 0], [0, 0, 0]])
    assert (found.what, found.error, found.stable, found.solid) == ("it", 0.1, STABLE, True)


@pytest.mark.parametrize(("least", "solid"), [(0.5e-7, False), (1.5e-7, True), (0.5, True)])
def test_a_solid_resists_every_strain(least, solid):
    found = with_cells("it", homogenised(np.diag([100.0, 50.0, least])), 0.0)
    assert found.solid == solid
    assert found.stable == (STABLE if solid else "no solid: some strain costs no energy")
    floppy = with_cells("it", homogenised(np.diag([100.0, 50.0, least]), floppy=3), 0.0)
    assert ("3 motions of points stretch no spring" in floppy.stable) == solid
    upper = np.diag([100.0, 50.0, 2.0])
    lower = np.diag([100.0 - 2 * ALIKE, 50.0, least])
    bounds = with_bounds("it", (TensorBounds(lower, upper, 1, 2.0, 0),))
    assert (bounds.stable == STABLE) == solid


@pytest.mark.parametrize("change", [1.5e-7, -1.5e-7, 3.0])
def test_cells_of_points_that_move_on_are_refused(change):
    tensor = np.diag([100.0, 50.0, 20.0])
    with refused("points move on in a uniform strain"):
        with_cells("it", homogenised(tensor, change), 0.5)
    assert with_cells("it", homogenised(tensor, change), 0.0).solid
    assert with_cells("it", homogenised(tensor, change / abs(change) * 0.5e-7), 0.5).solid


def test_bounds_are_a_mean_and_half_their_distance():
    lower = np.array([[4.0, 1.0, 0.0], [1.0, 2.0, 0.0], [0.0, 0.0, 0.5]])
    upper = lower + np.diag([2.0, 2.0, 0.5])
    rows = tuple(TensorBounds(lower * n, upper * n, 9 // n, 7.0 * n, 0) for n in (1, 2, 3))
    found = with_bounds("it", rows)
    np.testing.assert_allclose(found.tensor, [[5, 1, 0], [1, 3, 0], [0, 0, 0.75]])
    assert found.error == pytest.approx(1 / 3)
    assert found.bounds == rows
    text = dict(moduli_rows(found))
    names = ["bounds, 9 × 7 points", "bounds, 4 × 14 points", "bounds, 3 × 21 points"]
    assert list(text)[:3] == names
    low, high = rows[1].moduli
    assert text[names[1]] == (
        f"E = {low[0]:.4g} to {high[0]:.4g} N/m, nu = {low[1]:.4g} to {high[1]:.4g}, "
        f"Zener ratio {low[2]:.4g} to {high[2]:.4g}"
    )
    # K = (5 + 3 + 2)/4, mu = ((5 + 3 - 2)/4 + 0.75)/2: E = 4·K·mu/(K + mu) = 3.1034483.
    assert text["nearest isotropic"].startswith("E = 3.103 N/m, nu = 0.3793")
    assert any("0.75" in line for line in identified_lines(found))
    assert any(line.split() == ["1.667", "0.3333", "0"] for line in identified_lines(thirds(found)))


def thirds(found):
    return Identified("it", found.tensor / 3, 0.1, STABLE, bounds=found.bounds)


def plane(E, nu):
    return E / (1 - nu**2) * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])


def test_table_of_an_isotropic_plane():
    found = Identified("it", plane(2.5, 0.25), 3e-13, STABLE, omega=7.0, whose="all")
    steps = [("highest frequency", "7 rad/s of all"), ("step", step_words(step_limits(7.0)))]
    isotropic = ("isotropic", "E = 2.5 N/m, nu = 0.25")
    assert moduli_rows(found) == [isotropic, *steps]
    in_pascals = [
        ("in plane stress", "E = 5 Pa, nu = 0.25"),
        ("in plane strain", "E = 4.8 Pa, nu = 0.2"),
    ]
    assert moduli_rows(found, 0.5) == [isotropic, *in_pascals, *steps]
    lines = identified_lines(found, 0.5)
    assert lines[:2] == ["it: stable", "C in N/m (to 3e-13):"]
    table = [line.split() for line in lines[2:6]]
    assert table[0] == ["xx", "yy", "xy"]
    assert table[-1] == ["0", "0", "1"]
    no_solid = identified_lines(Identified("it", plane(2.5, 0.25), 3e-13, "no", solid=False))
    assert no_solid[1:] == lines[1 : len(no_solid)]
    assert "isotropic" not in " ".join(no_solid)
    auxetic = moduli_rows(Identified("it", plane(1.0, -0.5), 0.0, STABLE))
    assert auxetic[1] == ("auxetic", "widens when it is pulled")


@pytest.mark.parametrize(
    ("nu", "text"), [(0.0, "0"), (5e-13, "0"), (-5e-13, "0"), (1.5e-12, "1."), (-1.5e-12, "-1.")]
)
def test_entries_and_ratios_of_rounding_are_zero(nu, text):
    found = Identified("it", plane(1 / 3, nu), 0.0, STABLE)
    assert moduli_rows(found)[0][1].startswith(f"E = 0.333333333 N/m, nu = {text}")
    table = Identified("it", np.array([[3.0, nu, 0], [nu, 3, 0], [0, 0, 1]]), 0.0, STABLE)
    assert identified_lines(table)[3].split()[1] == "0"
    table = Identified("it", np.array([[0.5, nu, 0], [nu, 0.5, 0], [0, 0, 1]]), 0.0, STABLE)
    assert (identified_lines(table)[3].split()[1] == "0") == (text == "0")


def test_table_of_a_cubic_solid():
    """[Nye1957]: 1/E = S11 - 2 (S11 - S12 - S44/2) (l²m² + m²n² + n²l²)."""
    found = identify_cubic(5.0, 1.0, 3.0)  # S11, S12, S44 = 6/28, -1/28, 1/3
    assert moduli_rows(found) == [
        ("lowest E", "4.66667 Pa along (1, 0, 0)"),
        ("highest E", "6.3 Pa along (1, 1, 1)"),
        ("along (1, 0, 0)", "E = 4.66667 Pa, nu = 0.166667 along (0, 1, 0)"),
        (
            "along (1, 1, 0)",
            "E = 5.7931 Pa, nu = -0.0344828 along (1, -1, 0) to 0.206897 along (0, 0, 1)",
        ),
        ("along (1, 1, 1)", "E = 6.3 Pa, nu = 0.05 along (1, 0, -1)"),
        ("Zener ratio along the axes", "1.5"),
        ("nearest isotropic", "E = 5.6875 Pa, nu = 0.09375"),
    ]
    third = identified_lines(identify_cubic(5 / 3, 1 / 3, 1.0))
    assert third[2].split() == ["xx", "yy", "zz", "yz", "xz", "xy"]
    assert ["1.666667", "0.3333333", "0.3333333", "0", "0", "0"] in [x.split() for x in third]


def test_directions_have_indices_up_to_8():
    """Fibres along (9, 1) in an isotropic plane: the highest modulus is theirs."""
    n = np.array([9.0, 1.0]) / np.sqrt(82)
    fibre = np.array([n[0] ** 2, n[1] ** 2, n[0] * n[1]])
    C = plane(1.0, 0.2) + 5 * np.outer(fibre, fibre)
    at = np.array([64.0, 1.0, 8.0]) / 65
    text = f"{1 / (at @ np.linalg.solve(C, at)):.6g} N/m along (8, 1)"
    assert dict(moduli_rows(Identified("it", C, 0.0, STABLE)))["highest E"] == text


def test_table_of_a_chain():
    found = Identified("it", np.array([[2.0]]), 0.0, STABLE, omega=7.0, whose="all")
    lines = identified_lines(found)
    assert lines[0] == "it"
    assert [line.split()[:3] for line in lines if "EA" in line] == [["EA", "2", "N"]]
    assert "7 rad/s of all" in " ".join(lines)
