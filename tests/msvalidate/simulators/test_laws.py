"""Documented laws to first order: closed forms worked by hand, and the symmetry of ∂P/∂F."""

import numpy as np
import pytest

from msvalidate.problem import ProblemError
from msvalidate.simulators.bodies.laws import LAWS, first_order, predicted
from tests.table import table

E0, NU = 1e7, 0.3
MU = E0 / 2 / (1 + NU)
LAM = E0 * NU / (1 + NU) / (1 - 2 * NU)
SMITH, SIMPLE = "Smith's neo-Hookean", "neo-Hookean without logarithm"


def tensor(mu, lam):
    C = np.diag([2 * mu] * 3 + [mu] * 3)
    C[:3, :3] += lam
    return C


# dP = mu/dF-terms at F = I, with d cof(F) = tr(e) I - e and dI = 2 tr(e), by hand.
BY_HAND = {
    "linear": (MU, LAM),
    "corotated": (MU, LAM),
    "fixed corotated": (MU, LAM),
    "as rigid as possible": (MU, 0.0),
    "Saint Venant-Kirchhoff": (MU, LAM),
    "neo-Hookean, log J": (MU, LAM),
    "neo-Hookean of shape and volume apart": (MU, LAM),
    f"{SMITH}, Lamé's constants as they stand": (3 * MU / 4, LAM - 5 * MU / 8),
    f"{SMITH}, constants of small strain": (MU, LAM),
    f"{SIMPLE}, Lamé's constants as they stand": (MU, LAM - MU),
    f"{SIMPLE}, lam + mu": (MU, LAM),
    "two constraints, I - 3 and J - 1": (0.0, LAM + 4 * MU),
}


def test_every_law_is_worked_by_hand():
    assert set(BY_HAND) == set(LAWS)


@table("name", BY_HAND)
def test_first_order_is_that_worked_by_hand(name):
    C = predicted(name, E0, NU).C
    assert np.abs(C - tensor(*BY_HAND[name])).max() < 1e-12 * np.abs(C).max()  # rounding


@table("name", BY_HAND)
def test_laws_have_an_energy_and_do_not_see_turns(name):
    # dP symmetric in (iJ)(kL) at any F; P(R F) = R P(F). The linear law sees turns.
    stress, rng = LAWS[name].stress, np.random.default_rng(3)
    F = np.eye(3) + 0.2 * rng.normal(size=(3, 3))
    F = F if np.linalg.det(F) > 0 else F.T @ F
    h = 1e-6
    A = np.array([
        (stress(F + h * D, MU, LAM) - stress(F - h * D, MU, LAM)).ravel() / (2 * h)
        for D in np.eye(9).reshape(9, 3, 3)
    ])  # fmt: skip
    assert np.abs(A - A.T).max() < 1e-7 * np.abs(A).max()  # differences: h² and rounding over h
    R = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    R = R * np.linalg.det(R)
    gap = np.abs(stress(R @ F, MU, LAM) - R @ stress(F, MU, LAM)).max() / MU
    assert (gap > 0.1) if name == "linear" else (gap < 1e-10)


def test_raw_lame_constants_are_softer():
    raw = predicted(f"{SMITH}, Lamé's constants as they stand", E0, 0.25)
    # mu = lam: 3/4 mu and 3/8 mu, so E = mu (9/8 + 3/2)/(3/8 + 3/4) 3/4 = 7/4 mu, nu = 1/6.
    assert pytest.approx(1.75 * E0 / 2.5, rel=1e-12) == raw.E
    assert raw.nu == pytest.approx(1 / 6, rel=1e-12)


def test_what_is_refused():
    with pytest.raises(ProblemError, match="choose linear"):
        predicted("rubber", E0, NU)
    with pytest.raises(ProblemError, match="nu"):
        predicted("linear", E0, 0.5)
    with pytest.raises(ProblemError, match="no rest"):
        first_order(lambda F, mu, lam: mu * F + 0 * lam, MU, LAM)
