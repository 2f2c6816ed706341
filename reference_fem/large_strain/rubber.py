"""Laws of rubber in powers of the principal stretches s: Ogden's, and Mooney's and Rivlin's.

    W = Σ_p μ_p/α_p (Σ_a s_a^α_p - d) - (Σ_p μ_p) ln J + λ/2 (ln J)²,    μ = ½ Σ_p μ_p α_p

with μ and λ those of small strain. Source: [Ogden1972]; the terms in J, which rubber hardly tells,
are those of `NeoHookean`, which is α = 2. With s² - 1 = 2e, e Green's principal strains along N,
and ln s = ½ ln(1 + 2e), no digit is lost at small strain.
"""

from __future__ import annotations

from functools import cached_property
from typing import cast

import numpy as np

from msvalidate.problem import Array, ProblemError
from msvalidate.problem.checks import finite
from msvalidate.problem.records import dataclass
from reference_fem.large_strain.hyperelastic import (
    ByGradient,
    green,
    refuse_unstable,
    volume_change,
)

ALIKE = 1e-5
"""Stretches nearer than this have the mean of their slopes as quotient, off by its square."""


@dataclass(frozen=True, eq=False)
class Ogden(ByGradient):
    """Ogden's law; of two terms, α = 2 and -2, it is Mooney's and Rivlin's.

    That has C1 (I1 - 3) + C2 (I2 - 3) of incompressible rubber, with μ_p = 2 C1 and -2 C2.

    Parameters
    ----------
    mu, alpha
        (p,) in Pa, and the exponents, none of them 0.
    lam
        Lamé's λ (Pa) of small strain.
    dim
        Number of axes, 3, or 2 of plane strain.

    Raises
    ------
    ProblemError
        If they are not those of a stable solid; of its functions, where det F is not above zero.
    """

    mu: tuple[float, ...]
    alpha: tuple[float, ...]
    lam: float
    dim: int = 3

    def __post_init__(self) -> None:
        if not 0 < len(self.mu) == len(self.alpha):
            raise ProblemError(f"Ogden: {len(self.mu)} mu, {len(self.alpha)} alpha; give as many")
        if not self.terms[1].all():
            raise ProblemError("rubber: a term has exponent 0; give pairs of mu (Pa) and alpha")
        refuse_unstable("rubber", float(self.terms.prod(axis=0).sum()) / 2, self.lam, self.dim)

    @cached_property
    def terms(self) -> Array:
        """μ_p (Pa) and α_p (2, p)."""
        return finite("constants of rubber", [self.mu, self.alpha])

    def energy(self, F: Array) -> Array:
        """W (q,) in J/m³."""
        log, _ = _log_stretches(F - np.eye(self.dim))
        (mu, alpha), log_J = self.terms, log.sum(axis=1)
        powers = np.expm1(alpha * log[..., None]).sum(axis=1)
        return np.asarray(powers @ (mu / alpha) - mu.sum() * log_J + self.lam / 2 * log_J**2)

    def stress_by_gradient(self, H: Array) -> Array:
        """P = F Σ_a (∂W/∂s_a / s_a) N_a ⊗ N_a (q, d, d) in Pa of H = F - I."""
        log, N = _log_stretches(H)
        along = self._pull(log) * np.exp(-2 * log)
        return np.asarray((np.eye(self.dim) + H) @ (N * along[:, None]) @ N.transpose(0, 2, 1))

    def tangent(self, F: Array) -> Array:
        """A (q, d, d, d, d) in Pa: in the principal axes, then turned ([Ogden1984], § 6.1.4)."""
        log, N = _log_stretches(F - np.eye(self.dim))
        s, own = np.exp(log), np.arange(self.dim)
        n, w = (F @ N) / s[:, None], self._pull(log) / s
        mu, alpha = self.terms
        slope = np.exp(alpha * log[..., None]) @ (mu * alpha)
        twice = self.lam / (s[:, :, None] * s[:, None])
        twice[:, own, own] += slope / s**2 - w / s
        # Quotients of w_a - w_b by s_a - s_b and of w_a + w_b by s_a + s_b.
        apart, ends = s[:, :, None] - s[:, None], twice[:, own, own]
        near = np.abs(apart) <= ALIKE * s[:, None]
        limit = (ends[:, :, None] + ends[:, None]) / 2 - twice
        less = np.where(near, limit, (w[:, :, None] - w[:, None]) / np.where(near, 1.0, apart))
        more = (w[:, :, None] + w[:, None]) / (s[:, :, None] + s[:, None])
        same, crossed = (less + more) / 2, (less - more) / 2
        same[:, own, own] = crossed[:, own, own] = 0.0
        n_N = np.einsum("qia,qJb->qabiJ", n, N)
        by = ("qab,qaaiJ,qbbkL->qiJkL", "qab,qabiJ,qabkL->qiJkL", "qab,qabiJ,qbakL->qiJkL")
        parts = zip(by, (twice, same, crossed), strict=True)
        return np.asarray(sum(np.einsum(how, x, n_N, n_N, optimize=True) for how, x in parts))

    def _pull(self, log: Array) -> Array:
        """Slope of W by ln s, s ∂W/∂s (q, d) in Pa."""
        mu, alpha = self.terms
        swelling = self.lam * log.sum(axis=1, keepdims=True)
        return np.asarray(np.expm1(alpha * log[..., None]) @ mu + swelling)


def _log_stretches(H: Array) -> tuple[Array, Array]:
    """Ln s (q, d) of H = F - I, and the principal directions N (q, d, d) at rest, in columns."""
    volume_change(H)  # refuses what is inside out, which stretches do not tell
    e, N = np.linalg.eigh(green(H))
    return cast("Array", np.log1p(2 * e) / 2), N
