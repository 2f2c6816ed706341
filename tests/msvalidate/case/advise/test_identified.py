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
    ("arguments", "expected"),
    [
        ((3, None, None), (1000.0, "1000 kg/m³ (default)")),
        ((2, 7.5, 0.2), (1.5, "7.5 kg/m³")),
        ((2, None, 0.2), (200.0, "1000 kg/m³ (default)")),
        ((2, None, None), (None, "")),
        ((1, None, None), (None, "")),
        ((3, 7.5, 0.2), "--thickness: a solid has none"),
        ((1, 7.5, 0.2), "--density: a chain has no volume"),
        ((2, 7.5, None), "--density: a plane lattice's mass takes its --thickness"),
    ],
)
def test_mass_of_a_volume_in_each_dimension(arguments, expected):
    if isinstance(expected, tuple):
        assert mass_density(*arguments) == expected
    else:
        with refused(expected):
            mass_density(*arguments)


@pytest.mark.parametrize("name", ["triangular", "fcc"])
def test_volume_energy_is_bounded_by_short_waves(name):
    pattern = LATTICES[name]()
    k = (3.0,) * pattern.kinds
    least = least_stable_volume(pattern, k) / 0.5 ** (pattern.dim - 2)
    text = f"unstable: short waves ask for κ above {least:.6g}"
    for part, stable in ((1 + 1e-6, text), (1 - ALIKE / 2, text), (1 - 1e-6, STABLE)):
        assert identify_lattice(name, k, 0.5, part * least).stable == stable


@pytest.mark.parametrize("name", ["triangular", "cubic18"])
def test_frequencies_follow_stiffness_mass_and_spacing(name):
    pattern, h = LATTICES[name](), 0.25
    k = np.array([2.0, 1.0][: pattern.kinds])
    one = identify_lattice(name, k, 1.0, 0.3, 1.0)
    # A mass is density·h**dim, a cell has kappa·h**(dim - 2) N/m.
    other = identify_lattice(name, 4 * k, h, 1.2 / h ** (pattern.dim - 2), 9.0)
    assert other.omega == pytest.approx(one.omega * 2 / (3 * h ** (pattern.dim / 2)), rel=1e-9)
    none = identify_lattice(name, k, 1.0, 0.3)
    assert np.isnan(none.omega)
    assert "κ = 0.3" in none.what


def cells_beside(tensor, kappa, change=0.0, floppy=0):
    affine = np.array(tensor, dtype=float)
    affine[0, 1] += change
    solid = SimpleNamespace(tensor=np.array(tensor), affine=affine, floppy=floppy, error=0.1)
    return with_cells("it", solid, kappa)


def test_cells_add_to_normal_stresses():
    tensor = np.array([[5.0, 1.0, 0.5], [1.0, 4.0, 0.0], [0.5, 0.0, 2.0]])
    added = cells_beside(tensor, 0.25).tensor - tensor
    np.testing.assert_array_equal(added, [[0.25, 0.25, 0], [0.25, 0.25, 0], [0, 0, 0]])
    diagonal = np.diag([100.0, 50.0, 20.0])
    for change in (1.5e-7, -1.5e-7, 300.0):
        with refused("points move on in a uniform strain"):
            cells_beside(diagonal, 0.5, change)
        assert cells_beside(diagonal, 0.0, change).solid
    assert cells_beside(diagonal, 0.5, 0.5e-7).solid


@pytest.mark.parametrize(("least", "solid"), [(0.5e-7, False), (1.5e-7, True), (0.5, True)])
def test_a_solid_resists_every_strain(least, solid):
    tensor = np.diag([100.0, 50.0, least])
    found = cells_beside(tensor, 0.0)
    assert found.solid == solid
    assert found.stable == (STABLE if solid else "no solid: some strain costs no energy")
    floppy = cells_beside(tensor, 0.0, floppy=3).stable
    assert ("3 motions of points stretch no spring" in floppy) == solid
    bounds = TensorBounds(tensor, np.diag([100.0, 50.0, 2.0]), 1, 2.0, 0)
    assert (with_bounds("it", (bounds,)).stable == STABLE) == solid


def test_bounds_are_a_mean_and_half_their_distance():
    lower = np.array([[4.0, 1.0, 0.0], [1.0, 2.0, 0.0], [0.0, 0.0, 0.5]])
    upper = lower + np.diag([2.0, 2.0, 0.5])
    rows = tuple(TensorBounds(n * lower, n * upper, 9 // n, 7.0 * n, 0) for n in (1, 2, 3))
    found = with_bounds("it", rows)
    np.testing.assert_allclose(found.tensor, [[5, 1, 0], [1, 3, 0], [0, 0, 0.75]])
    assert found.error == pytest.approx(1 / 3)
    # K = (5 + 3 + 2)/4 and mu = ((5 + 3 - 2)/4 + 0.75)/2: E = 4·K·mu/(K + mu) = 3.1034483.
    text = dict(moduli_rows(found))
    assert text["nearest isotropic"] == "E = 3.103 N/m, nu = 0.3793"
    low, high = rows[1].moduli
    ends = [f"{a:.4g} to {b:.4g}" for a, b in zip(low, high, strict=True)]
    expected = f"E = {ends[0]} N/m, nu = {ends[1]}, Zener ratio {ends[2]}"
    assert text["bounds, 4 × 14 points"] == expected
    third = Identified("it", found.tensor / 3, 0.1, STABLE, bounds=rows)
    assert identified_lines(third)[3].split() == ["1.667", "0.3333", "0"]


def plane(E, nu, **more):
    tensor = E / (1 - nu**2) * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])
    return Identified("it", tensor, 3e-13, STABLE, **more)


def test_table_of_an_isotropic_plane():
    found = plane(2.5, 0.25, omega=7.0, whose="all")
    steps = [("highest frequency", "7 rad/s of all"), ("step", step_words(step_limits(7.0)))]
    isotropic = ("isotropic", "E = 2.5 N/m, nu = 0.25")
    stress = ("in plane stress", "E = 5 Pa, nu = 0.25")
    strain = ("in plane strain", "E = 4.8 Pa, nu = 0.2")
    assert moduli_rows(found) == [isotropic, *steps]
    assert moduli_rows(found, 0.5) == [isotropic, stress, strain, *steps]
    lines = identified_lines(found, 0.5)
    assert lines[:2] == ["it: stable", "C in N/m (to 3e-13):"]
    assert [line.split()[-1] for line in lines[2:6]] == ["xy", "0", "0", "1"]
    none = identified_lines(plane(2.5, 0.25, solid=False))
    assert none == lines[: len(none)]
    assert len(none) == 6
    assert moduli_rows(plane(1.0, -0.5))[1] == ("auxetic", "widens when it is pulled")


def test_table_of_a_cubic_solid():
    # [Nye1957]: 1/E = S11 - 2 (S11 - S12 - S44/2) (l²m² + m²n² + n²l²).
    found = identify_cubic(5.0, 1.0, 3.0)  # S11, S12, S44 = 6/28, -1/28, 1/3
    ratios = "nu = -0.0344828 along (1, -1, 0) to 0.206897 along (0, 0, 1)"
    assert moduli_rows(found) == [
        ("lowest E", "4.66667 Pa along (1, 0, 0)"),
        ("highest E", "6.3 Pa along (1, 1, 1)"),
        ("along (1, 0, 0)", "E = 4.66667 Pa, nu = 0.166667 along (0, 1, 0)"),
        ("along (1, 1, 0)", f"E = 5.7931 Pa, {ratios}"),
        ("along (1, 1, 1)", "E = 6.3 Pa, nu = 0.05 along (1, 0, -1)"),
        ("Zener ratio along the axes", "1.5"),
        ("nearest isotropic", "E = 5.6875 Pa, nu = 0.09375"),
    ]
    third = identified_lines(identify_cubic(5 / 3, 1 / 3, 1.0))
    assert third[2].split() == ["xx", "yy", "zz", "yz", "xz", "xy"]
    assert third[3].split() == ["1.666667", "0.3333333", "0.3333333", "0", "0", "0"]
