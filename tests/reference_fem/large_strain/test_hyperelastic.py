"""Energy densities: stress and tangent by differences, objectivity, small strain, the lattice."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import bisect

from msvalidate.problem import Anisotropic, Isotropic, ProblemError
from reference_fem.elasticity import elastic_tensor, full_tensor
from reference_fem.large_strain import (
    Fibres,
    NeoHookean,
    Ogden,
    PlaneStress,
    StVenantKirchhoff,
    neo_hookean,
    square_fibres,
    st_venant_kirchhoff,
)
from tests.reference_fem.by_hand import SKEW
from tests.table import table

CUBIC = [(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1), (1, -1, 1), (1, 1, -1), (-1, 1, 1)]
TRELOAR = Ogden((0.618, 0.00118, -0.00981), (1.3, 5.0, -2.0), 1.2)
LAWS = {
    "neo-Hookean 2D": NeoHookean(0.8, 1.7),
    "neo-Hookean 3D": NeoHookean(0.8, 1.7, 3),
    "St Venant-Kirchhoff 2D": st_venant_kirchhoff(Anisotropic(SKEW)),
    "St Venant-Kirchhoff 3D": st_venant_kirchhoff(Isotropic(2.0, 0.3, "solid")),
    "fibres 2D": square_fibres(1.0, 0.5),
    "fibres 3D": Fibres(np.array(CUBIC, dtype=float), np.arange(1.0, 8.0), 2.0),
    "fibres and cells": Fibres(np.array(CUBIC, dtype=float), np.arange(1.0, 8.0), 2.0, 1.5),
    "Ogden": TRELOAR,
    "Mooney-Rivlin 2D": Ogden((0.8, -0.4), (2.0, -2.0), 1.1, 2),
    "plane stress neo-Hookean": PlaneStress(NeoHookean(0.8, 1.7, 3)),
    "plane stress Ogden": PlaneStress(TRELOAR),
}
each_law = pytest.mark.parametrize("law", LAWS.values(), ids=LAWS.keys())


def strained(law, seed=0, count=5):
    """Deformation gradients (q, d, d) far from I, with det F > 0.3."""
    change = np.random.default_rng(seed).uniform(-0.3, 0.3, (count, law.dim, law.dim))
    F = np.eye(law.dim) + change
    return F[np.linalg.det(F) > 0.3]


def turn(dim, angle, tilt):
    c, s = np.cos(angle), np.sin(angle)
    R = np.eye(dim)
    R[:2, :2] = [[c, -s], [s, c]]
    if dim == 3:
        c, s = np.cos(tilt), np.sin(tilt)
        R = R @ np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    return R


def differences(function, F, step=1e-6):
    """Central differences of a function of F in each of its entries, the entries last."""
    d = F.shape[1]
    columns = []
    for k in range(d):
        for L in range(d):
            change = np.zeros((d, d))
            change[k, L] = step
            columns.append((function(F + change) - function(F - change)) / (2 * step))
    found = np.stack(columns, axis=-1)
    return found.reshape(*found.shape[:-1], d, d)


@each_law
def test_stress_is_the_derivative_of_the_energy(law):
    F = strained(law)
    assert len(F) > 2
    expected = differences(law.energy, F)
    # Differences of second order with a step of 1e-6 leave 1e-12 and rounding of 1e-10.
    assert np.abs(law.stress(F) - expected).max() <= 1e-8 * np.abs(expected).max()


@each_law
def test_tangent_is_the_derivative_of_the_stress(law):
    F = strained(law)
    expected = differences(law.stress, F)
    assert np.abs(law.tangent(F) - expected).max() <= 1e-8 * np.abs(expected).max()


@each_law
def test_tangent_has_major_symmetry(law):
    A = law.tangent(strained(law))
    assert np.abs(A - A.transpose(0, 3, 4, 1, 2)).max() <= 1e-14 * np.abs(A).max()


@each_law
@settings(max_examples=20, deadline=None)
@given(angle=st.floats(-3.1, 3.1), tilt=st.floats(-3.1, 3.1))
def test_laws_do_not_see_rotations(law, angle, tilt):
    F, R = strained(law), turn(law.dim, angle, tilt)
    scale = np.abs(law.stress(F)).max()
    assert np.abs(law.energy(R @ F) - law.energy(F)).max() <= 1e-13 * np.abs(law.energy(F)).max()
    assert np.abs(law.stress(R @ F) - R @ law.stress(F)).max() <= 1e-13 * scale
    # Cauchy's stress P Fᵀ/J is symmetric: no couple acts inside.
    couple = law.stress(F) @ F.transpose(0, 2, 1)
    assert np.abs(couple - couple.transpose(0, 2, 1)).max() <= 1e-13 * scale


@each_law
def test_no_stress_at_rest(law):
    rest = np.eye(law.dim)[None]
    assert np.abs(law.energy(rest)).max() == 0
    assert np.abs(law.stress(rest)).max() == 0


@pytest.mark.parametrize("state", ["plane_strain", "plane_stress", "solid"])
@pytest.mark.parametrize("make", [neo_hookean, st_venant_kirchhoff])
def test_small_strain_is_linear_elasticity(make, state):
    material = Isotropic(2.0, 0.3, state)
    found = make(material).tangent(np.eye(material.dim)[None])[0]
    C = full_tensor(elastic_tensor(material))
    assert np.abs(found - C).max() <= 4e-16 * np.abs(C).max()


def test_plane_stress_pulled_along_an_axis():
    # Both stretches across are free, found here by bisection of the closed form in ln J:
    # mu (m² - 1) + lam ln J = 0 for the two alike, mu = 1, nu = 1/3.
    law, stretch = PlaneStress(NeoHookean(1.0, 2.0, 3)), 1.1
    m = bisect(lambda m: m**2 - 1 + 2 * np.log(stretch * m**2), 0.9, 1.0, xtol=1e-15)
    P = law.stress(np.diag([stretch, m])[None])[0]
    expected = stretch - 1 / stretch + 2 * np.log(stretch * m**2) / stretch
    assert expected == pytest.approx(0.24744967, abs=5e-9)
    assert pytest.approx(np.diag([expected, 0.0]), abs=1e-14) == P


def test_plane_stress_of_st_venant_kirchhoff_is_its_condensed_tensor():
    F = strained(LAWS["plane stress Ogden"], 3)
    own = st_venant_kirchhoff(Isotropic(2.0, 0.3, "plane_stress"))
    thinned = PlaneStress(st_venant_kirchhoff(Isotropic(2.0, 0.3, "solid")))
    assert np.abs(thinned.stress(F) - own.stress(F)).max() <= 1e-14


def test_laws_of_powers_in_closed_form():
    F = strained(TRELOAR)
    plain, powers = NeoHookean(0.8, 1.7, 3), Ogden((0.8,), (2.0,), 1.7)
    assert np.abs(plain.tangent(F) - powers.tangent(F)).max() <= 1e-13
    F = F / np.linalg.det(F)[:, None, None] ** (1 / 3)
    C = F.transpose(0, 2, 1) @ F
    first, squares = np.trace(C, axis1=1, axis2=2), np.trace(C @ C, axis1=1, axis2=2)
    expected = 0.4 * (first - 3) + 0.2 * ((first**2 - squares) / 2 - 3)
    assert np.abs(Ogden((0.8, -0.4), (2.0, -2.0), 1.1).energy(F) - expected).max() <= 1e-13


@pytest.mark.parametrize("apart", [0.0, 1e-9, 0.9e-5, 1.1e-5])
def test_stretches_that_are_nearly_alike(apart):
    F = np.diag([1.3, 1.3 + apart, 0.8])[None]
    expected = differences(TRELOAR.stress, F)
    assert np.abs(TRELOAR.tangent(F) - expected).max() <= 1e-8 * np.abs(expected).max()


def test_neo_hookean_energy_at_one_stretch():
    # By hand: F = diag(2, 1/2, 3), J = 3, F:F = 4 + 1/4 + 9.
    W = NeoHookean(2.0, 5.0, 3).energy(np.diag([2.0, 0.5, 3.0])[None])[0]
    assert pytest.approx(10.25 - 2 * np.log(3) + 2.5 * np.log(3) ** 2, rel=1e-14) == W


# --- fibres ---------------------------------------------------------------------------------------


def test_fibres_are_the_energy_of_springs():
    # One cell of the lattice, added up spring by spring.
    law, F = LAWS["fibres 3D"], strained(LAWS["fibres 3D"])[0]
    total = sum(
        0.5 * k * (np.linalg.norm(F @ r) - np.linalg.norm(r)) ** 2
        for r, k in zip(law.vectors, law.stiffness, strict=True)
    )
    assert law.energy(F[None])[0] == pytest.approx(total / law.cell, rel=1e-14)


# --- bad input ------------------------------------------------------------------------------------


@table(
    ("make", "message"),
    [
        (lambda: NeoHookean(0.0, 1.0), "neo-Hookean mu: 0.0 Pa"),
        (lambda: NeoHookean(1.0, -1.0), "2 mu \\+ 2 lam > 0"),
        (lambda: NeoHookean(1.0, float("nan")), "neo-Hookean lam"),
        (lambda: NeoHookean(1.0, 1.0, 4), "4 axes; give 2 or 3"),
        (lambda: NeoHookean(1.0, 1.0).stress(np.diag([1.0, -1.0])[None]), "det F = -1"),
        (lambda: neo_hookean(Isotropic(1.0, 0.5, "solid")), "nu = 1/2"),
        (lambda: neo_hookean(Anisotropic(SKEW)), "give an Isotropic"),
        (lambda: st_venant_kirchhoff(Isotropic(1.0, 0.5, "solid")), "nu = 1/2"),
        (lambda: Ogden((1.0,), (2.0,), -0.7), "2 mu \\+ 3 lam > 0"),
        (lambda: Ogden((1.0,), (2.0, 1.0), 1.0), "1 mu, 2 alpha"),
        (lambda: Ogden((1.0, 1.0), (2.0, 0.0), 1.0), "exponent 0"),
        (lambda: Ogden((1.0,), (-2.0,), 1.0), "mu: -1.0 Pa"),
        (lambda: Ogden((2.0, float("nan")), (2.0, -2.0), 1.0), "constants of rubber"),
        (lambda: TRELOAR.stress(np.diag([1.0, 1.0, -1.0])[None]), "det F = -1"),
        (lambda: PlaneStress(NeoHookean(1.0, 1.0)), "2 axes; give one of 3"),
        (lambda: PlaneStress(LAWS["fibres 3D"]), "shears the law across"),
        (lambda: StVenantKirchhoff(np.eye(3)), "shape \\(3, 3\\)"),
        (lambda: StVenantKirchhoff(np.arange(16.0).reshape((2,) * 4)), "minor symmetry"),
        (lambda: Fibres(np.ones((2, 4)), np.ones(2), 1.0), "shape \\(2, 4\\)"),
        (lambda: Fibres(np.ones((2, 2)), np.ones(3), 1.0), "give \\(2,\\)"),
        (lambda: Fibres(np.ones((2, 2)), -np.ones(2), 1.0), "-1.0 N/m"),
        (lambda: Fibres(np.zeros((1, 2)), np.ones(1), 1.0), "no length"),
        (lambda: Fibres(np.ones((1, 2)), np.ones(1), 0.0), "cell of fibres"),
        (lambda: square_fibres(1.0, float("inf")), "diagonal stiffness"),
    ],
)
def test_bad_laws_are_refused(make, message):
    with pytest.raises(ProblemError, match=message) as caught:
        make()
    assert "\n" not in str(caught.value)
