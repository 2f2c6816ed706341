"""Plane bodies with a hole by Kolosov's potentials: stresses to many digits, without a mesh.

Of a plane body without body forces the stresses are ([Muskhelishvili1963], §§ 32, 39)

    σ_xx + σ_yy = 4 Re Φ,      σ_yy - σ_xx + 2i σ_xy = 2 (z̄ Φ' + Ψ),

with Φ = φ'(z) and Ψ = ψ'(z) analytic in the body. On a side whose outward normal has the angle α,

    σ_nn - i σ_nt = Φ + Φ̄ - e^(2iα) (z̄ Φ' + Ψ).

Where no hole has a resultant, displacements are single-valued without logarithms, and no material
constant is left in φ, ψ and the sides' tractions: stresses are the same for every nu, in plane
stress as in plane strain [Michell1899]. Here φ and ψ are odd Laurent polynomials with real
coefficients, for bodies and loads symmetric about both axes, in z or in a variable ζ that is mapped
onto it; tractions are met at many places by least squares. What is missed on the sides bounds what
is wrong inside.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from msvalidate import kit

from .shapes import FOCUS, INNER, OUTER

Complex = npt.NDArray[np.complex128]


class Conformal(Protocol):
    """A map z(ζ): z and its first two derivatives (n,) at places ζ (n,), complex."""

    def __call__(self, zeta: Complex) -> tuple[Complex, Complex, Complex]:
        """The map and its derivatives."""


@dataclass(frozen=True, eq=False)
class Side:
    """Places ζ (n,), the angle α (n,) of the normal there, and the normal traction (n,) wanted.

    Tangential tractions are zero.
    """

    places: Complex
    normal: kit.Array
    pull: kit.Array


@dataclass(frozen=True, eq=False)
class Stresses:
    """φ and ψ by their powers of ζ (k,) and coefficients (2k,); `missed`: worst on the sides."""

    map: Conformal
    powers: kit.Array
    scale: kit.Array
    coefficients: kit.Array
    missed: float

    def sum(self, zeta: complex) -> float:
        """σ_xx + σ_yy at a place: at a free side the stress along it."""
        value, _, _ = _functions(self.map, self.powers, self.scale, np.array([zeta]))
        return float(4 * (value @ self.coefficients[: len(self.powers)]).real[0])

    def stress(self, zeta: Complex) -> kit.Array:
        """Stress (n, 3), xx, yy, xy, at places (n,)."""
        value, slope, z = _functions(self.map, self.powers, self.scale, zeta)
        phi, psi = self.coefficients[: len(self.powers)], self.coefficients[len(self.powers) :]
        both = 4 * (value @ phi).real
        apart = 2 * (z.conj() * (slope @ phi) + value @ psi)
        return np.column_stack([both - apart.real, both + apart.real, apart.imag]) / 2


def plain(zeta: Complex) -> tuple[Complex, Complex, Complex]:
    """The map z = ζ."""
    return zeta, np.ones_like(zeta), np.zeros_like(zeta)


def ellipses(zeta: Complex) -> tuple[Complex, Complex, Complex]:
    """Joukowski's map z = (c/2)(ζ + 1/ζ): circles about 0 become ellipses with the foci ±c."""
    return FOCUS / 2 * (zeta + 1 / zeta), FOCUS / 2 * (1 - zeta**-2), FOCUS * zeta**-3


def solve_potentials(
    conformal: Conformal, sides: Sequence[Side], terms: int, scales: kit.Array
) -> Stresses:
    """Potentials of `terms` odd powers up and as many down.

    `scales`: size of ζ (2,) by which powers below and above zero are divided, for no more than
    rounding's sake.
    """
    powers = np.arange(1.0 - 2 * terms, 2 * terms, 2)
    scale = np.where(powers < 0, scales[0], scales[1])
    rows, wanted = [], []
    for side in sides:
        value, slope, z = _functions(conformal, powers, scale, side.places)
        turn = np.exp(2j * side.normal)[:, None]
        rows.append(np.hstack([2 * value.real - turn * z.conj()[:, None] * slope, -turn * value]))
        wanted.append(side.pull)
    system, right = np.concatenate(rows), np.concatenate(wanted)
    A, b = np.concatenate([system.real, system.imag]), np.concatenate([right, 0 * right])
    size = np.linalg.norm(A, axis=0)
    found = np.linalg.lstsq(A / size, b, rcond=None)[0] / size
    return Stresses(conformal, powers, scale, found, float(np.abs(A @ found - b).max()))


def _functions(
    conformal: Conformal, powers: kit.Array, scale: kit.Array, zeta: Complex
) -> tuple[Complex, Complex, Complex]:
    """Φ (n, k) of each power of φ, which is Ψ of ψ; dΦ/dz; and z (n,)."""
    z, dz, ddz = (each[:, None] for each in conformal(zeta))
    ratio = (zeta[:, None] / scale) ** (powers - 2) / scale**2
    first, second = powers * ratio * zeta[:, None], powers * (powers - 1) * ratio
    return first / dz, (second * dz - first * ddz) / dz**3, z[:, 0]


def elliptic_membrane(pull: float, terms: int = 24) -> Stresses:
    """LE1: the inner ellipse free, a normal traction (Pa) on the outer one.

    In ζ they are circles of radius √((a + b)/(a - b)).
    """
    inner, outer = (np.sqrt((a + b) / (a - b)) for a, b in (INNER, OUTER))
    turn = np.exp(1j * np.pi / 2 * (np.arange(8 * terms) + 0.5) / (8 * terms))
    sides = []
    for radius, traction in ((inner, 0.0), (outer, pull)):
        zeta = radius * turn
        _, slope, _ = ellipses(zeta)
        sides.append(Side(zeta, np.angle(zeta * slope), np.full(len(zeta), traction)))
    return solve_potentials(ellipses, sides, terms, np.array([inner, outer]))


def holed_strip(radius: float, half_length: float, terms: int = 30) -> Stresses:
    """Strip of half width 1 along y with a hole, unit tension along it at its ends."""
    count = 12 * terms
    middle = (np.arange(count) + 0.5) / count
    crowded = (1 - np.cos(np.pi * middle)) / 2  # towards corners
    angle = np.pi / 2 * middle
    none, one = np.zeros(count), np.ones(count)
    side: Complex = (1 + 1j * half_length * crowded).astype(complex)
    end: Complex = (crowded + 1j * half_length).astype(complex)
    sides = (
        Side(radius * np.exp(1j * angle), angle, none),
        Side(side, none, none),
        Side(end, np.pi / 2 * one, one),
    )
    return solve_potentials(plain, sides, terms, np.array([radius, np.hypot(1.0, half_length)]))
