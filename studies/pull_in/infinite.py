"""An infinite bonded slab of lattice in a uniform field: its waves, without solving a slab.

Points of a column move as u_j·exp(iqx), j up the height: springs give a Hermitian matrix of 2 by 2
blocks that link a layer to the next. The top electrode is a chain of straight segments whose
charges are even on each as `msvalidate.dielectric.charges` has them; a flat chain's field is
known, and so is what a wave does to it.

A wave of a chain of spacing a has all k_m = q + 2πm/a. With s_m = sin(k_m·a/2)/(k_m·a/2), the gap
H = l·h and the charge per area σ = εV/H, displacements of the chain are Σ s_m²·u·exp(ik_m·x), and
charges that are even on segments Σ (-1)^m·s_m·c·exp(ik_m·x). A wave of charge has the potential
1/(2ε|k|) on its own electrode and exp(-|k|H) of that on the other. So

- charges that are carried along give back σ²/(2ε)·Σ|k_m|·s_m⁴·diag(-1, 1);
- they upset the potentials of segments by r·Σ(-1)^m·s_m³·(-i·sgn k_m, 1) on top, r = σ/(2ε), and by
  -r·Σ(-1)^m·s_m³·exp(-|k_m|H)·(i·sgn k_m, 1) below;
- charges that restore them add upset†·P⁻¹·upset.

For a long wave the sum is εE²·k·coth(kH) up and down: the softening of a conducting surface.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from msvalidate import kit
from msvalidate.dielectric.actuator import uniform

from .slab import AXIAL, DIAGONAL, HEIGHT, PERMITTIVITY

Complex = NDArray[np.complex128]
WAVES = 100
"""Of each sign that a chain's motion is taken apart into; terms fall as 1/m³."""
HALVINGS = 32
"""Of a bracket of l: to 1e-10."""
UP: Any = np.diag([0.0, 1.0])
ALONG: Any = np.diag([1.0, 0.0])
TURNED: Any = np.array([[0.0, 1.0], [1.0, 0.0]])


class Columns(NamedTuple):
    """Infinite slabs, one a wave: thickness l (w,), spacing (m), wavenumber q (w,) in 1/m."""

    part: kit.Array
    spacing: float
    q: kit.Array

    @property
    def gap(self) -> kit.Array:
        """Between the electrodes (w,) in m."""
        return self.part * HEIGHT

    @property
    def charge(self) -> kit.Array:
        """Per area (w,) in C/m²: σ²/(2ε) is the pressure of the springs."""
        part = self.part
        diagonals = 2 * DIAGONAL * part * (np.sqrt(2 / (1 + part**2)) - 1)
        return np.asarray(np.sqrt(2 * PERMITTIVITY * (AXIAL * (1 - part) + diagonals)))


def blocks(columns: Columns) -> tuple[Complex, Complex, Complex]:
    """Stiffness (w, 2, 2) in N/m: of a point inside, of one on top, and of one with that below it.

    A spring of rest length L0, now L along n, has k·[(1 - L0/L)·1 + (L0/L)·n nᵀ].
    """
    part, turn = columns.part[:, None, None], (columns.q * columns.spacing)[:, None, None]
    square = 1 + part**2
    rest = np.sqrt(2 / square)
    upright = AXIAL * ((1 - 1 / part) * np.eye(2) + UP / part)
    even = (1 - rest) * np.eye(2) + rest / square * (ALONG + part**2 * UP)
    odd = rest / square * part * TURNED
    below = upright + 2 * DIAGONAL * even
    along = AXIAL * (2 - 2 * np.cos(turn)) * ALONG
    link = -upright - 2 * DIAGONAL * (np.cos(turn) * even - 1j * np.sin(turn) * odd)
    return 2 * below + along + 0j, below + along / 2 + 0j, link


def softening(columns: Columns) -> Complex:
    """Derivative (w, 2, 2) in N/m of the electric force on a top point, charges free to move."""
    m = np.arange(-WAVES, WAVES + 1)
    k = columns.q[:, None] + 2 * np.pi * m / columns.spacing
    s = np.sinc(k * columns.spacing / (2 * np.pi))
    far = np.exp(-np.abs(k) * columns.gap[:, None])
    one = s**2 / (2 * PERMITTIVITY * np.abs(k))
    own, other = one.sum(axis=1), (one * far).sum(axis=1)
    potential = np.stack([own, other, other, own], axis=-1).reshape(-1, 2, 2) + 0j
    r = columns.charge / (2 * PERMITTIVITY)
    cubed = np.where(m % 2, -1.0, 1.0) * s**3
    upset = np.empty((len(r), 2, 2), dtype=complex)
    for row, (part, sign) in enumerate(((cubed, 1), (cubed * far, -1))):
        upset[:, row, 0] = -1j * r * (part * np.sign(k)).sum(axis=1)
        upset[:, row, 1] = sign * r * part.sum(axis=1)
    carried = columns.charge * r * (np.abs(k) * s**4).sum(axis=1)
    restored = adjoint(upset) @ np.linalg.solve(potential, upset)
    return np.asarray(columns.spacing * (carried[:, None, None] * (UP - ALONG) + restored))


def adjoint(matrix: Complex) -> Complex:
    """Of matrices (w, 2, 2)."""
    return np.conj(np.swapaxes(matrix, 1, 2))


def softest_wave(part: float, layers: int, q: kit.Array) -> kit.Array:
    """Smallest eigenvalue (w,) in N/m of K_mech - K_elec for waves of wavenumbers q (1/m)."""
    columns = Columns(np.full(len(q), part), HEIGHT / layers, q)
    inside, top, link = blocks(columns)
    whole = np.zeros((len(q), layers, 2, layers, 2), dtype=complex)
    for j in range(layers):
        whole[:, j, :, j] = inside if j < layers - 1 else top - softening(columns)
        if j:
            whole[:, j, :, j - 1] = link
            whole[:, j - 1, :, j] = adjoint(link)
    return np.asarray(np.linalg.eigvalsh(whole.reshape(len(q), 2 * layers, 2 * layers))[:, 0])


def is_stable(part: kit.Array, layers: int, q: kit.Array) -> kit.Mask:
    """Whether K_mech - K_elec is positive for each wave (w,), by eliminating layer after layer."""
    columns = Columns(part, HEIGHT / layers, q)
    inside, top, link = blocks(columns)
    top = top - softening(columns)
    stable = np.ones(len(q), dtype=bool)
    carried = np.zeros_like(inside)
    for j in range(layers):
        left = (top if j == layers - 1 else inside) - carried
        stable &= np.linalg.eigvalsh(left)[:, 0] > 0
        left[~stable] = np.eye(2)
        carried = link @ np.linalg.solve(left, adjoint(link))
    return stable


def thresholds(layers: int, wavelengths: kit.Array) -> kit.Array:
    """Thickness l (w,) at which waves of these lengths (m) first cost nothing.

    Searched down to the pull-in of the slab as a whole, the limit of long waves.
    """
    q = 2 * np.pi / wavelengths
    least = uniform.pull_in(height=HEIGHT, axial=AXIAL, diagonal=DIAGONAL).thickness
    low, high = np.full(len(q), least), np.full(len(q), 1.0)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        stable = is_stable(middle, layers, q)
        low, high = np.where(stable, low, middle), np.where(stable, middle, high)
    return low
