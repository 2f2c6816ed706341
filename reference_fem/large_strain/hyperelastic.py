"""Energy densities of solids at large strain, their stress and their tangent.

A law is a record with three functions of deformation gradients F = I + ∂u/∂X, shape (q, d, d):

    energy   W(F)            (q,) in J/m³, of the undeformed volume
    stress   P = ∂W/∂F       (q, d, d) in Pa, the first Piola-Kirchhoff stress
    tangent  A = ∂P/∂F       (q, d, d, d, d) in Pa, A_iJkL = ∂P_iJ/∂F_kL

A law may also have `stress_by_gradient(H)`, P by the displacement gradient H = F - I: at small
strain F - I has lost what H still tells, and E = (H + Hᵀ + HᵀH)/2 loses nothing. All laws here do.

In the plane F has d = 2 and the body does not strain across it (plane strain); `PlaneStress` makes
plane stress of a law in space. All of them have no stress at F = I and do not see a rotation:
W(RF) = W(F).
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from msvalidate.problem import Array, ProblemError
from msvalidate.problem.checks import (
    finite,
    finite_coordinates,
    finite_number,
    format_value,
    positive_number,
)
from msvalidate.problem.records import dataclass


class Law(Protocol):
    """Interface of a hyperelastic law."""

    @property
    def dim(self) -> int:
        """Number of axes, 2 or 3."""

    def energy(self, F: Array) -> Array:
        """W (q,) in J/m³."""

    def stress(self, F: Array) -> Array:
        """P (q, d, d) in Pa."""

    def tangent(self, F: Array) -> Array:
        """A (q, d, d, d, d) in Pa."""


def refuse_other_laws(law: object) -> None:
    """Raise a `ProblemError` for what is no law."""
    if not all(hasattr(law, name) for name in ("dim", "energy", "stress", "tangent")):
        raise ProblemError(f"law: {format_value(law)}; give a NeoHookean or another law")


def refuse_unstable(law: str, mu: float, lam: float, dim: int) -> None:
    """Raise a `ProblemError` unless μ > 0 and 2μ + d·λ > 0, both in Pa, with 2 or 3 axes."""
    positive_number(f"{law} mu", mu, "Pa")
    finite_number(f"{law} lam", lam)
    if dim not in (2, 3):
        raise ProblemError(f"{law} law: {dim} axes; give 2 or 3")
    if 2 * mu + dim * lam <= 0:
        raise ProblemError(
            f"{law} lam: {lam} Pa with mu = {mu} Pa; a stable solid has 2 mu + {dim} lam > 0"
        )


def stress_by_gradient(law: Law, H: Array) -> Array:
    """P (q, d, d) in Pa of displacement gradients (q, d, d), as exactly as the law can."""
    exact = getattr(law, "stress_by_gradient", None)
    if exact is not None:
        return np.asarray(exact(H))
    return np.asarray(law.stress(np.eye(law.dim) + H))


class ByGradient:
    """A law whose stress follows from H = F - I without loss of digits."""

    def stress(self, F: Array) -> Array:
        """P (q, d, d) in Pa."""
        return np.asarray(self.stress_by_gradient(F - np.eye(F.shape[1])))  # type: ignore[attr-defined]


@dataclass(frozen=True)
class NeoHookean(ByGradient):
    """W = μ/2 (F:F - d - 2 ln J) + λ/2 (ln J)², with J = det F.

    The volumetric form is that of [SimoPister1984], in ln J: other neo-Hookean laws with the same μ
    and λ differ at large strain. In the plane d = 2 is plane strain of the solid: the stretch
    across is 1 and adds nothing.

    Parameters
    ----------
    mu, lam
        Lamé's constants (Pa) of small strain; μ > 0, and 2μ + d·λ > 0.
    dim
        Number of axes, 2 or 3.

    Raises
    ------
    ProblemError
        If the constants are not those of a stable solid; of its functions, where det F is not above
        zero.
    """

    mu: float
    lam: float
    dim: int = 2

    def __post_init__(self) -> None:
        refuse_unstable("neo-Hookean", self.mu, self.lam, self.dim)

    def energy(self, F: Array) -> Array:
        """W (q,) in J/m³."""
        log = _log_volume(F)
        squares = np.einsum("qiJ,qiJ->q", F, F)
        return np.asarray(self.mu / 2 * (squares - self.dim - 2 * log) + self.lam / 2 * log**2)

    def stress_by_gradient(self, H: Array) -> Array:
        """P = μ (F - F⁻ᵀ) + λ ln J F⁻ᵀ (q, d, d) in Pa, with F - F⁻ᵀ = (H + Hᵀ + H Hᵀ) F⁻ᵀ."""
        inverse = _inverse_transposed(np.eye(self.dim) + H)
        log = np.log1p(volume_change(H))[:, None, None]
        along = H + _transposed(H) + H @ _transposed(H)
        return np.asarray(self.mu * along @ inverse + self.lam * log * inverse)

    def tangent(self, F: Array) -> Array:
        """A (q, d, d, d, d) in Pa, by ∂F⁻ᵀ_iJ/∂F_kL = -F⁻ᵀ_iL F⁻ᵀ_kJ."""
        log, G = _log_volume(F), _inverse_transposed(F)
        across = np.einsum("qiL,qkJ->qiJkL", G, G)
        along = np.einsum("qiJ,qkL->qiJkL", G, G)
        crossed = (self.mu - self.lam * log)[:, None, None, None, None] * across
        return np.asarray(self.mu * _identity(self.dim) + crossed + self.lam * along)


@dataclass(frozen=True, eq=False)
class StVenantKirchhoff(ByGradient):
    """W = ½ E:C:E with Green's strain E = (FᵀF - I)/2; S = C:E is the second Piola stress.

    It softens under compression and has no energy to stop J from going through 0: a model for large
    rotations and moderate strains. S33 is linear in E33: with the tensor of plane stress it is the
    law's plane stress, at any strain and ratio.

    Parameters
    ----------
    C
        Stiffness (d, d, d, d) in Pa, with the symmetries of elasticity.
    """

    C: Array

    def __post_init__(self) -> None:
        C = finite("St Venant-Kirchhoff tensor", self.C)
        if C.shape not in {(2,) * 4, (3,) * 4}:
            raise ProblemError(
                f"St Venant-Kirchhoff tensor: shape {C.shape}; give (2, 2, 2, 2) or (3, 3, 3, 3)"
            )
        for swap, name in (((1, 0, 2, 3), "minor"), ((2, 3, 0, 1), "major")):
            if not np.abs(C - C.transpose(swap)).max() <= 1e-12 * np.abs(C).max():
                raise ProblemError(
                    f"St Venant-Kirchhoff tensor: without {name} symmetry; give C_ijkl = "
                    "C_jikl = C_klij"
                )
        object.__setattr__(self, "C", C)

    @property
    def dim(self) -> int:
        """Number of axes, 2 or 3."""
        return len(self.C)

    def energy(self, F: Array) -> Array:
        """W (q,) in J/m³."""
        E = green(F - np.eye(self.dim))
        return np.asarray(0.5 * np.einsum("qIJ,IJKL,qKL->q", E, self.C, E))

    def stress_by_gradient(self, H: Array) -> Array:
        """P = F S (q, d, d) in Pa of H = F - I."""
        return np.asarray((np.eye(self.dim) + H) @ self._second(H))

    def tangent(self, F: Array) -> Array:
        """A_iJkL = δ_ik S_JL + F_iI C_IJKL F_kK (q, d, d, d, d) in Pa."""
        material = np.einsum("qiI,IJKL,qkK->qiJkL", F, self.C, F, optimize=True)
        return np.asarray(
            material
            + np.einsum("ik,qJL->qiJkL", np.eye(self.dim), self._second(F - np.eye(self.dim)))
        )

    def _second(self, H: Array) -> Array:
        return np.asarray(np.einsum("IJKL,qKL->qIJ", self.C, green(H)))


@dataclass(frozen=True, eq=False)
class Fibres(ByGradient):
    """W = Σ ½ k (|F r| - |r|)² / cell: a lattice of springs that follows F as a whole.

    The rule of Cauchy and Born: exact where the deformation is uniform, as each point is then a
    centre of symmetry ([BornHuang1954], §11). It differs from the lattice by the gradients of F
    over a spacing and by what its surface cuts. The spacing enters by r²/cell alone.

    Parameters
    ----------
    vectors
        (s, d) springs of one cell in m, from end to end, each once.
    stiffness
        (s,) in N/m.
    cell
        Volume of a cell (m³); in the plane its area times the thickness.
    volume
        κ (Pa) of ½ κ (J - 1)², where cells resist a change of volume too; 0 where they do not.

    Raises
    ------
    ProblemError
        If a spring has no length, the shapes differ, or a value is out of range.
    """

    vectors: Array
    stiffness: Array
    cell: float
    volume: float = 0.0

    def __post_init__(self) -> None:
        r = finite_coordinates("fibres", self.vectors, "s>0", (2, 3))
        k = finite("stiffness of fibres", self.stiffness, len(r))
        if (k < 0).any():
            raise ProblemError(f"stiffness of fibres: {k.min()} N/m; give none below zero")
        if not np.linalg.norm(r, axis=1).all():
            raise ProblemError("fibres: one has no length; give each its vector")
        positive_number("cell of fibres", self.cell, "m³")
        finite_number("volume of fibres", self.volume)
        object.__setattr__(self, "vectors", r)
        object.__setattr__(self, "stiffness", k)

    @property
    def dim(self) -> int:
        """Number of axes, 2 or 3."""
        return int(self.vectors.shape[1])

    def energy(self, F: Array) -> Array:
        """W (q,) in J/m³."""
        _, length, rest = self._stretched(F)
        found = (length - rest) ** 2 @ self.stiffness / (2 * self.cell)
        if self.volume:
            found = found + self.volume / 2 * volume_change(F - np.eye(self.dim)) ** 2
        return np.asarray(found)

    def stress_by_gradient(self, H: Array) -> Array:
        """P = Σ k (1 - |r|/|y|) y ⊗ r / cell (q, d, d) in Pa of H = F - I, with y = F r.

        And |y| - |r| = Hr·(2r + Hr)/(|y| + |r|).
        """
        y, length, rest = self._stretched(np.eye(self.dim) + H)
        move = np.einsum("qiJ,sJ->qsi", H, self.vectors)
        longer = (move * (2 * self.vectors + move)).sum(axis=2) / (length + rest)
        pull = self.stiffness / self.cell * longer / length
        found = np.einsum("qs,qsi,sJ->qiJ", pull, y, self.vectors, optimize=True)
        if self.volume:
            change = volume_change(H)[:, None, None]
            inverse = _inverse_transposed(np.eye(self.dim) + H)
            found = found + self.volume * change * (1 + change) * inverse
        return np.asarray(found)

    def tangent(self, F: Array) -> Array:
        """A = Σ k/cell [(1 - |r|/|y|) δ_ik + |r| y_i y_k/|y|³] r_J r_L (q, d, d, d, d) in Pa."""
        y, length, rest = self._stretched(F)
        weight = self.stiffness / self.cell
        along = np.einsum("qs,qsi,qsk->qsik", weight * rest / length**3, y, y, optimize=True)
        across = (weight * (1 - rest / length))[..., None, None] * np.eye(self.dim)
        r = self.vectors
        found = np.einsum("qsik,sJ,sL->qiJkL", along + across, r, r, optimize=True)
        if self.volume:
            G, J = _inverse_transposed(F), np.linalg.det(F)[:, None, None]
            found = found + self.volume * (
                np.einsum("qiJ,qkL->qiJkL", J * (2 * J - 1) * G, G)
                - np.einsum("qiL,qkJ->qiJkL", J * (J - 1) * G, G)
            )
        return np.asarray(found)

    def _stretched(self, F: Array) -> tuple[Array, Array, Array]:
        """Fibres as deformed (q, s, d), their lengths (q, s) and those at rest (s,), in m."""
        y = np.einsum("qiJ,sJ->qsi", F, self.vectors)
        return y, np.linalg.norm(y, axis=2), np.linalg.norm(self.vectors, axis=1)


def square_fibres(axial: float, diagonal: float, thickness: float = 1.0) -> Fibres:
    """Fibres of the square lattice with both diagonals, of any spacing.

    Springs along the sides have the stiffness `axial`, those along diagonals `diagonal` (N/m). At
    small strain C11 = C22 = (axial + diagonal)/t and C12 = C66 = diagonal/t: Σ k r_i r_j r_k r_l /
    (|r|² cell) with r = (1, 0), (0, 1), (1, 1) and (1, -1).
    """
    k = (
        positive_number("axial stiffness", axial, "N/m"),
        positive_number("diagonal stiffness", diagonal, "N/m"),
    )
    directions = np.array([[1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, -1.0]])
    return Fibres(directions, np.repeat(k, 2), positive_number("thickness", thickness, "m"))


def green(H: Array) -> Array:
    """E = (FᵀF - I)/2 of H = F - I."""
    return np.asarray((H + _transposed(H) + _transposed(H) @ H) / 2)


def _identity(d: int) -> Array:
    """δ_ik δ_JL."""
    return np.asarray(np.einsum("ik,JL->iJkL", np.eye(d), np.eye(d)))


def _log_volume(F: Array) -> Array:
    """Ln J (q,), of deformations that turn nothing inside out."""
    return np.asarray(np.log1p(volume_change(F - np.eye(F.shape[1]))))


def volume_change(H: Array) -> Array:
    """J - 1 (q,) of H = F - I, the sum of H's principal minors: of deformations with J > 0."""
    det, trace = np.linalg.det(H), np.trace(H, axis1=1, axis2=2)
    change = trace + det
    if H.shape[1] == 3:
        for a, b in ((0, 1), (0, 2), (1, 2)):
            change = change + (H[:, a, a] * H[:, b, b] - H[:, a, b] * H[:, b, a])
    if not (change > -1).all():
        raise ProblemError(
            f"deformation gradient: det F = {1 + change.min():.3g}; this law keeps it above zero"
        )
    return np.asarray(change)


def _inverse_transposed(F: Array) -> Array:
    return np.asarray(np.linalg.inv(F).transpose(0, 2, 1), dtype=float)


def _transposed(F: Array) -> Array:
    return F.transpose(0, 2, 1)
