"""Springs that resist shear, read from the strain around them: the second way to any nu.

A central spring alone has one ratio. Beside it a spring of stiffness k_t resists the shear of its
own direction n. If that shear were the motion of one end across the other, a rigid turn would cost
energy; read from the strain near by it costs none (distinct lattice spring model
[ZhaoFangZhao2011]). Here also for finite turns: with F the
deformation gradient at a point, by weighted least squares over its springs,

    E = (FᵀF - I)/2,   Ē = (E_i + E_j)/2,   s = L (Ēn - (n·Ēn) n),   U = ½ k_t |s|²,

n and L of the reference. FᵀF knows no turn, and a uniform F comes out exactly wherever a point's
springs span the space, so a uniform strain has the energy of `shear_tensor`. With k_t = α k_n on an
isotropic lattice of central springs

    plane: nu = (1 - α)/(3 + α),   solid: nu = (1 - α)/(4 + α),

so ratios above Cauchy's need α < 0 (see `msvalidate.constants.stable_range` for how far).

What a body pays: least squares are one-sided at its boundary, where a uniform stress no longer
leaves all points without force. In a square lattice this happens at the four points of each corner
alone, with forces that sum to zero. The displacement of a uniform stretch is then wrong there to
first order in the spacing and on average to second; in solids it happens along edges, and where
springs are cut by the boundary (triangular, BCC, FCC in a box) everywhere on it. The energy per
cell of `msvalidate.constants.routes` has no such error.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy.sparse import csr_array, eye_array, kron

from msvalidate.network.checks import check_springs
from msvalidate.problem import LONGEST, VOIGT, Array, Index, ProblemError
from msvalidate.problem.checks import finite, finite_coordinates, positive_number, require_type
from msvalidate.problem.records import dataclass

SPAN = 1e-9
"""Least eigenvalue of a point's Σ w DDᵀ, relative to the largest, above which its springs span."""


@dataclass(frozen=True, eq=False)
class LocalShear:
    """Springs that resist the shear of their direction. Arrays are made read-only.

    Source: [ZhaoFangZhao2011] for small turns; at finite turns derived above.

    Parameters
    ----------
    points
        (n, d) reference positions (m).
    springs
        (m, 2) pairs of different points.
    stiffness
        (m,) k_t in N/m, of either sign.
    weights
        (m,) of the springs in the least squares at both of their ends, 0 or more: in a body the
        part of each spring that belongs to it.

    Raises
    ------
    ProblemError
        Naming the array, the spring without length, or the point whose springs do not span the
        plane or space.
    """

    points: Array
    springs: Index
    stiffness: Array
    weights: Array

    def __post_init__(self) -> None:
        points = finite_coordinates("shear springs: points", self.points, "n", (2, 3))
        pairs = check_springs(self.springs, len(points), "shear springs")
        arrays = {"points": points, "springs": pairs}
        for name in ("stiffness", "weights"):
            arrays[name] = finite(f"shear springs: {name}", getattr(self, name), len(pairs))
        if arrays["weights"].min() < 0:
            raise ProblemError(
                f"shear springs: a weight of {arrays['weights'].min():g}; give 0 or more"
            )
        for name, array in arrays.items():
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        length = np.linalg.norm(self.vector, axis=1)
        none = np.flatnonzero(length <= max(1e-14 * float(np.abs(points).max()), 1 / LONGEST))
        if len(none):
            raise ProblemError(
                f"shear springs: {pairs[none[0]].tolist()} at index {none[0]} are in one place, "
                f"{length[none[0]]:g} m apart; join points that are not"
            )
        _refuse_flat(self._spanned, pairs)

    @property
    def dim(self) -> int:
        """Number of axes, 2 or 3."""
        return int(self.points.shape[1])

    @cached_property
    def vector(self) -> Array:
        """Vectors (m, d) in m along the springs in the reference."""
        i, j = self.springs.T
        vector = np.asarray(self.points[j] - self.points[i])
        vector.setflags(write=False)
        return vector

    @cached_property
    def _spanned(self) -> Array:
        """Σ w DDᵀ (n, d, d) in m² over the springs of each point."""
        n, d = self.points.shape
        outer = self.weights[:, None, None] * self.vector[:, :, None] * self.vector[:, None, :]
        A = np.zeros((n, d, d))
        for end in self.springs.T:
            np.add.at(A, end, outer)
        return A

    @cached_property
    def gradient(self) -> csr_array:
        """Operator (n·d, n) in 1/m: row n·d + b times a component's values is its ∂/∂X_b.

        Least squares: Σ w (x_j - x_i) DᵀA⁻¹ over a point's springs, A = Σ w DDᵀ.
        """
        A, (n, d) = self._spanned, self.points.shape
        joined = np.unique(self.springs)
        inverse = np.zeros(A.shape)
        inverse[joined] = np.linalg.inv(A[joined])
        i, j = self.springs.T
        rows, columns, values = [], [], []
        # Seen from the second end both D and the difference change sign: their product stays.
        for end in (i, j):
            weight = self.weights[:, None] * np.einsum("mbc,mc->mb", inverse[end], self.vector)
            row = (end[:, None] * d + np.arange(d)).ravel()
            for column, sign in ((j, 1.0), (i, -1.0)):
                rows.append(row)
                columns.append(np.repeat(column, d))
                values.append(sign * weight.ravel())
        entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
        return csr_array(entries, shape=(n * d, n))


def energy(shear: LocalShear, position: Array) -> float:
    """Energy (J) stored in the shear springs at `position` (n, d) in m."""
    shift = _shear_of_springs(shear, _gradients(shear, position))
    return float(0.5 * shear.stiffness @ (shift**2).sum(axis=1))


def force(shear: LocalShear, position: Array) -> Array:
    """Force (n, d) in N of the shear springs on the points at `position` (n, d) in m: -∂U/∂x.

    Σ_s k_t s·∂s/∂E is a moment M_i (N·m) at each point; of it Gᵀ(F M), G the gradient.
    """
    F = _gradients(shear, position)
    pull = np.einsum("nac,ncb->nba", F, _moments(shear, _shear_of_springs(shear, F)))
    return np.asarray(-(shear.gradient.T @ pull.reshape(-1, shear.dim)))


def tangent(shear: LocalShear, position: Array) -> csr_array:
    """Tangent stiffness (n·d, n·d) in N/m at `position`, row n·d of point-major components.

    Sᵀ k_t S with S = ∂s/∂x, and the moments' work on the second change of FᵀF.
    """
    F = _gradients(shear, position)
    n, d = position.shape
    moments = _moments(shear, _shear_of_springs(shear, F))
    G, one = shear.gradient, eye_array(d)
    row = np.arange(n)
    at = (np.repeat(d * row[:, None] + np.arange(d), d), np.repeat(d * row, d * d))
    at = (at[0], at[1] + np.tile(np.arange(d), n * d))
    stressed = G.T @ csr_array((moments.ravel(), at), shape=(n * d, n * d)) @ G
    S = _shift_by_gradients(shear, F) @ kron(G, one)
    k = np.repeat(shear.stiffness, d)
    return csr_array(S.T @ (S * k[:, None]) + kron(stressed, one))


def mode_energy(shear: LocalShear, position: Array, motion: Array) -> float:
    """Twice the energy (J) of a small motion (n, d) in m from `position`: motionᵀ K motion.

    Springs with a shear of less than 1e-12 of their length count as unstressed.
    """
    F = _gradients(shear, position)
    shift = _shear_of_springs(shear, F)
    length = np.linalg.norm(shear.vector, axis=1)
    shift[np.linalg.norm(shift, axis=1) < 1e-12 * length] = 0.0
    way = (shear.gradient @ motion).reshape(F.shape)
    change = (_shift_by_gradients(shear, F) @ way.ravel()).reshape(shift.shape)
    bent = np.einsum("nba,nbc,nca->", way, _moments(shear, shift), way)
    return float(shear.stiffness @ (change**2).sum(axis=1) + bent)


def force_magnitudes(shear: LocalShear, position: Array) -> Array:
    """Sum (n,) of the magnitudes of the forces (N) that shear springs bring about at each point."""
    shift = np.linalg.norm(_shear_of_springs(shear, _gradients(shear, position)), axis=1)
    return _point_forces(shear, shift)


def roundoff_magnitudes(shear: LocalShear, reach: float) -> Array:
    """Sum (n,) of the forces (N) of springs sheared by `reach` (m) and their own length.

    An eps of it is the rounding of a force: see `residual.force_roundoff`.
    """
    return _point_forces(shear, reach + np.linalg.norm(shear.vector, axis=1))


def shear_tensor(vectors: Array, stiffness: Array, volume: float) -> Array:
    """Tensor, (3, 3) in N/m or (6, 6) in Pa, of shear springs in a uniform strain, each once.

    C = (1/V) Σ k_t L² NᵀPN: N takes a Voigt strain to εn, and P takes its part along n away.

    Source: the energy of `LocalShear` in a uniform strain, differentiated twice.

    Parameters
    ----------
    vectors, stiffness
        (m, d) in m and k_t (m,) in N/m.
    volume
        Area (m²) or volume (m³) that the springs stand for.

    Raises
    ------
    ProblemError
        If an array does not fit, a vector has no length, or a value is not finite.
    """
    D = finite_coordinates("vectors", vectors, "m", (2, 3))
    k = finite("stiffness", stiffness, len(D))
    if not D.any(axis=1).all():
        raise ProblemError("shear tensor: a vector of no length; leave it out")
    unit, across = _directions(D)
    d = D.shape[1]
    pairs = VOIGT[d]
    N = np.zeros((len(D), d, len(pairs)))
    for column, (a, b) in enumerate(pairs):
        N[:, a, column] += unit[:, b] / 2  # engineering shear: half of it each way
        N[:, b, column] += unit[:, a] / 2
    shift = np.linalg.norm(D, axis=1)[:, None, None] * (across @ N)
    V = positive_number("volume", volume, f"m^{d}")
    with np.errstate(over="ignore", invalid="ignore"):  # what is infinite is refused
        return finite("shear tensor", np.einsum("m,mav,maw->vw", k, shift, shift) / V)


def _directions(vector: Array) -> tuple[Array, Array]:
    """Unit vectors (m, d) along springs, and projections (m, d, d) across them."""
    unit = vector / np.linalg.norm(vector, axis=1)[:, None]
    return unit, np.eye(vector.shape[1]) - unit[:, :, None] * unit[:, None, :]


def _gradients(shear: LocalShear, position: Array) -> Array:
    """Deformation gradients (n, d, d), F_ab = ∂x_a/∂X_b."""
    require_type("shear", shear, LocalShear)
    x = finite_coordinates("position", position, *shear.points.shape)
    n, d = x.shape
    return np.asarray((shear.gradient @ x).reshape(n, d, d).transpose(0, 2, 1))


def _shear_of_springs(shear: LocalShear, F: Array) -> Array:
    """Shear s (m, d) in m of each spring, the mean of what its two ends see."""
    strain = (F.transpose(0, 2, 1) @ F - np.eye(shear.dim)) / 2
    i, j = shear.springs.T
    unit, across = _directions(shear.vector)
    shift = np.einsum("mab,mbc,mc->ma", across, (strain[i] + strain[j]) / 2, unit)
    return np.asarray(np.linalg.norm(shear.vector, axis=1)[:, None] * shift)


def _moments(shear: LocalShear, shift: Array) -> Array:
    """Symmetric ∂U/∂E (n, d, d) in N·m at each point: half of every spring's k_t L (s⊗n)."""
    pull = (shear.stiffness[:, None] * shift)[:, :, None] * shear.vector[:, None, :]
    moments = np.zeros((len(shear.points), shear.dim, shear.dim))
    for end in shear.springs.T:
        np.add.at(moments, end, (pull + pull.transpose(0, 2, 1)) / 4)
    return moments


def _point_forces(shear: LocalShear, shift: Array) -> Array:
    """Force (n,) in N at the points, all signs up, of springs sheared by `shift` (m,) in m."""
    size = np.abs(shear.stiffness) * shift * np.linalg.norm(shear.vector, axis=1) / 2
    n, d = shear.points.shape
    moment = np.bincount(shear.springs.ravel(), np.repeat(size, 2), n)
    return np.asarray(abs(shear.gradient).T @ np.repeat(moment, d))


def _shift_by_gradients(shear: LocalShear, F: Array) -> csr_array:
    """∂s/∂F (m·d, n·d·d): columns point by point, in each by the axis of X and then of x."""
    m, d = shear.vector.shape
    unit, across = _directions(shear.vector)
    across = across * (np.linalg.norm(shear.vector, axis=1) / 4)[:, None, None]
    rows, columns, values = [], [], []
    for end in shear.springs.T:
        here = F[end]
        # d(FᵀF) n = Fᵀ(dF n) + dFᵀ(F n), and a quarter: half of the strain, half of the mean.
        block = np.einsum("msc,mac,mb->msba", across, here, unit)
        block += across[:, :, :, None] * np.einsum("mac,mc->ma", here, unit)[:, None, None, :]
        row, column = np.arange(m)[:, None] * d + np.arange(d), end[:, None] * d * d
        column = column + np.arange(d * d)
        rows.append(np.repeat(row, d * d))
        columns.append(np.repeat(column[:, None, :], d, axis=1).ravel())
        values.append(block.ravel())
    entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    return csr_array(entries, shape=(m * d, len(shear.points) * d * d))


def _refuse_flat(A: Array, springs: Index) -> None:
    """Raise `ProblemError` for a point that is joined, but whose springs leave out a direction."""
    joined = np.unique(springs)
    values = np.linalg.eigvalsh(A[joined])
    flat = np.flatnonzero(values[:, 0] <= SPAN * values[:, -1])
    if len(flat):
        raise ProblemError(
            f"shear springs: those at point {joined[flat[0]]} do not span all {A.shape[1]} axes, "
            "so no strain is known there; join it to more points, or leave its springs out"
        )
