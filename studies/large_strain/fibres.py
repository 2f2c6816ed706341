"""Lattices of springs under a homogeneous strain, and the laws that they are held against.

All have λ = μ = 1 in the plane at small strain. Under F a lattice carries the nominal stress
P = (1/V0) Σ p(s) (F r)⊗r of its springs r, p the pull at s = |F r|² [BornHuang1954]; points that
are centres of symmetry follow F.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq

from msvalidate.problem import Array
from msvalidate.problem.records import dataclass
from msvalidate.springs.network.laws.law import SpringLaw
from msvalidate.springs.network.laws.linear import LINEAR

MU = LAM = 1.0
"""N/m."""
E2, NU2 = 8 / 3, 1 / 3
"""Young's modulus (N/m) and Poisson's ratio of the plane."""
DIRECTIONS = 720
"""Of a random network: the mean is exact to 1e-15, for what is averaged is smooth and periodic."""


@dataclass(frozen=True, eq=False)
class Springs:
    """Springs r (m, 2) in m for each V0 (m²), of stiffness k (m,) in N/m, at rest unstrained."""

    name: str
    r: Array
    k: Array
    V0: float
    law: SpringLaw = LINEAR

    def stress(self, F: Array) -> Array:
        """Nominal stress P (2, 2) in N/m."""
        y, c = self.r @ F.T, self._coefficients
        pull = self.law.pull(c, (y**2).sum(axis=1))
        return np.asarray(np.einsum("b,bi,bJ->iJ", pull, y, self.r) / self.V0)

    def softest(self, F: Array) -> float:
        """Least eigenvalue of the acoustic tensor over all directions (N/m): below 0 where lost."""
        y, c = self.r @ F.T, self._coefficients
        s = (y**2).sum(axis=1)
        pull, axial, n = self.law.pull(c, s), self.law.axial(c, s), y / np.sqrt(s)[:, None]
        block = pull[:, None, None] * np.eye(2) + (axial - pull)[:, None, None] * (
            n[:, :, None] * n[:, None]
        )
        turn = np.linspace(0, np.pi, 2 * 360 + 1)
        across = (np.stack([np.cos(turn), np.sin(turn)], 1) @ self.r.T) ** 2
        return float(np.linalg.eigvalsh(np.einsum("tb,bij->tij", across, block) / self.V0).min())

    @property
    def _coefficients(self) -> tuple[Array, ...]:
        return self.law.coefficients(self.k, np.linalg.norm(self.r, axis=1))


def _turned(degrees: Array | float) -> Array:
    angle = np.radians(degrees)
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def lattices(law: SpringLaw = LINEAR) -> tuple[Springs, ...]:
    """Square cells with both diagonals, triangles along and across their rows, and at random."""
    three = np.array([0.0, 60.0, 120.0])
    k = np.full(3, 4 / np.sqrt(3))
    square = np.array([[1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, -1.0]])
    every = _turned(np.arange(DIRECTIONS) * 180.0 / DIRECTIONS)
    return (
        Springs("square", square, np.array([2.0, 2.0, 1.0, 1.0]), 1.0, law),
        Springs("triangular, row", _turned(three), k, np.sqrt(3) / 2, law),
        Springs("triangular, across", _turned(three + 90.0), k, np.sqrt(3) / 2, law),
        Springs("random", every, np.full(DIRECTIONS, 8.0 / DIRECTIONS), 1.0, law),
    )


Stress = Callable[[Array], Array]


def neo_hookean(F: Array) -> Array:
    """P (2, 2) of W = μ/2 (F:F - 2 - 2 ln J) + λ/2 ln²J."""
    G = np.linalg.inv(F).T
    return np.asarray(MU * (F - G) + LAM * np.log(np.linalg.det(F)) * G)


def st_venant(F: Array) -> Array:
    """P (2, 2) of W = μ E:E + λ/2 tr²E."""
    E = (F.T @ F - np.eye(2)) / 2
    return np.asarray(F @ (2 * MU * E + LAM * np.trace(E) * np.eye(2)))


def linear(F: Array) -> Array:
    """Stress (2, 2) of linear elasticity, of the strain sym(F) - I."""
    e = (F + F.T) / 2 - np.eye(2)
    return np.asarray(2 * MU * e + LAM * np.trace(e) * np.eye(2))


def pulled(stress: Stress, loading: str, strain: float) -> tuple[float, float]:
    """Nominal stress (N/m) along the load, and the stretch across, of a loading at a strain.

    "uniaxial" with free sides, "confined" without, "equibiaxial", or "shear" by an angle.
    """
    across = 1.0
    if loading == "uniaxial":

        def side(m: float) -> float:
            return float(stress(np.diag([1 + strain, m]))[1, 1])

        across = brentq(
            side, 1 - 0.9 * max(strain, 0) - 0.05, 1.6 if strain < 0 else 1.05, xtol=1e-15
        )
    if loading == "equibiaxial":
        across = 1 + strain
    F = (
        np.array([[1.0, strain], [0.0, 1.0]])
        if loading == "shear"
        else np.diag([1 + strain, across])
    )
    return float(stress(F)[0, 1 if loading == "shear" else 0]), across


def first_outside(stress: Stress, target: Stress, loading: str, band: float, most: float) -> float:
    """Least strain (1) at which the stress is off the target's by a band; NaN: never up to `most`.

    `most` has the sign of the loading.
    """

    def beyond(strain: float) -> float:
        ours, theirs = (pulled(law, loading, strain)[0] for law in (stress, target))
        return abs(ours / theirs - 1) - band

    steps = most * np.linspace(0.001, 1, 120)
    for low, high in pairwise(steps):
        if beyond(high) > 0:
            return float(abs(brentq(beyond, low, high, xtol=1e-12)))
    return float("nan")


def ellipticity_lost(springs: Springs, loading: str) -> float:
    """Compression (1) at which some wave has no speed any more."""

    def softest(strain: float) -> float:
        across = pulled(springs.stress, loading, -strain)[1]
        return springs.softest(np.diag([1 - strain, across]))

    steps = np.linspace(0.01, 0.6, 60)
    for low, high in pairwise(steps):
        if softest(high) < 0:
            return float(brentq(softest, low, high, xtol=1e-12))
    return float("nan")
