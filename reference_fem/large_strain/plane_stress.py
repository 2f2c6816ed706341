"""Plane stress at large strain: a law in space whose section thins until nothing pulls across.

At each F in the plane the stretch across s has P33(s) = 0, and W, P and ∂P/∂F follow with that s:

    A = A_iJkL - A_iJ33 A_33kL / A_3333,    i, J, k, L in the plane.

Stress is per undeformed area, and the thickness that of the undeformed body.
"""

from __future__ import annotations

import numpy as np

from msvalidate.problem import Array, ProblemError, SolverError
from msvalidate.problem.records import dataclass
from reference_fem.large_strain.hyperelastic import (
    ByGradient,
    Law,
    refuse_other_laws,
    stress_by_gradient,
)

STEPS, LONGEST = 50, 0.5
"""Newton steps for ln s, and the longest of them."""
FOUND, ROUNDED = 1e-8, 1e-12
"""Last step of ln s, over it or over the largest entry of F - I: its square is left, or less."""


@dataclass(frozen=True, eq=False)
class PlaneStress(ByGradient):
    """The plane stress of a law in space.

    Parameters
    ----------
    law
        Of three axes and symmetric about the plane: no shear across follows from strain in it.

    Raises
    ------
    ProblemError
        If the law is none of these.
    SolverError
        Of its functions, where no stretch across is free of stress.
    """

    law: Law
    dim = 2

    def __post_init__(self) -> None:
        refuse_other_laws(self.law)
        if self.law.dim != 3:
            raise ProblemError(f"plane stress: a law of {self.law.dim} axes; give one of 3")
        (A,) = self.law.tangent(np.eye(3)[None])
        if np.abs(A[:2, :2, :2, 2]).max() > 1e-12 * np.abs(A).max():
            raise ProblemError("plane stress: strain in the plane shears the law across; turn it")

    def energy(self, F: Array) -> Array:
        """W (q,) in J/m³."""
        return self.law.energy(np.eye(3) + self._thinned(F - np.eye(2)))

    def stress_by_gradient(self, H: Array) -> Array:
        """P (q, 2, 2) in Pa of H = F - I."""
        return stress_by_gradient(self.law, self._thinned(H))[:, :2, :2]

    def tangent(self, F: Array) -> Array:
        """A (q, 2, 2, 2, 2) in Pa."""
        A = self.law.tangent(np.eye(3) + self._thinned(F - np.eye(2)))
        across = A[:, :2, :2, 2, 2]
        less = np.einsum("qiJ,qkL->qiJkL", across, across / A[:, 2, 2, 2, 2, None, None])
        return np.asarray(A[:, :2, :2, :2, :2] - less)

    def _thinned(self, H: Array) -> Array:
        """H in space (q, 3, 3), with the stretch across that has no stress."""
        whole, log = np.zeros((len(H), 3, 3)), np.zeros(len(H))
        whole[:, :2, :2] = H
        rounded = ROUNDED * np.abs(H).max(axis=(1, 2))
        for _ in range(STEPS):
            pull = stress_by_gradient(self.law, whole)[:, 2, 2]
            slope = self.law.tangent(np.eye(3) + whole)[:, 2, 2, 2, 2] * (1 + whole[:, 2, 2]) + pull
            if not (slope > 0).all():
                break
            step = np.clip(-pull / slope, -LONGEST, LONGEST)
            log += step
            whole[:, 2, 2] = np.expm1(log)
            if (np.abs(step) <= FOUND * np.abs(log) + rounded).all():
                return whole
        raise SolverError("plane stress: no stretch across is free of stress; strain less")
