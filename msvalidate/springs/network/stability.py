"""Number of modes of negative energy of a tangent, robust to rounding of pivots.

A factor's pivots count the negative modes of the matrix that was factorised, which differs from the
exact one by some eps of what each point meets. A mode of less stiffness than that may have any sign
there. These few are found by inverse iteration, and their energies taken from the springs' own
vectors (`Configuration.force_change`): by Weyl's inequality no other mode can have changed its
sign.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import eigh

from msvalidate.linear_algebra.factor import Factor
from msvalidate.problem import Array, SolverError
from msvalidate.springs.network.inverse import Regular
from msvalidate.springs.network.mechanism import NO_STIFFNESS, is_certain
from msvalidate.springs.network.multigrid import NotConvergedError, free_force
from msvalidate.springs.network.refine import FACTOR_ROUNDING

MODES = 8
"""Modes whose energies are taken: as many motions as may meet less than rounding."""
SWEEPS = 3
"""Inverse iterations on them all at once."""
CLEAR = 10.0
"""Relative stiffness, in units of rounding, that makes all other signs certain.

It refers to the stiffest of these modes.
"""


def negative_modes(factorised: Regular) -> int:
    """Number of negative eigenvalues of a tangent, at most 1 from multigrid.

    `factorised` holds the inverse of the tangent. Multigrid does not count: 1 then means that at
    least one eigenvalue is negative.

    Raises `SolverError` if some motion has no stiffness, or if too many motions have none beyond
    rounding. Raises `NotConvergedError` if the softest motion has none beyond rounding and there is
    no factor, or if conjugate gradients do not decide.
    """
    if is_certain(factorised.softness):
        return factorised.negative
    if not isinstance(factorised.inverse, Factor):
        raise NotConvergedError(
            "multigrid: whether the network is stable cannot be told: a motion meets "
            f"{abs(factorised.softness):.1g} of what its points meet alone"
        )
    weight = np.abs(factorised.diagonal)
    modes, pushes = _softest_motions(factorised.inverse, weight)
    own = modes.T @ pushes
    metric = modes.T @ (weight[:, None] * modes)
    factored = eigh((own + own.T) / 2, metric, eigvals_only=True)
    changes = np.column_stack([free_force(factorised.at, mode) for mode in modes.T])
    exact = modes.T @ changes
    energies = eigh((exact + exact.T) / 2, metric, eigvals_only=True)
    all_seen = len(weight) <= MODES
    if not all_seen and np.abs(factored).max() < CLEAR * FACTOR_ROUNDING:
        raise SolverError(
            "equilibrium: whether the network is stable cannot be told: many of its motions meet "
            f"less than {FACTOR_ROUNDING:.0g} of what their points meet alone; bring stiffnesses "
            "closer together"
        )
    if np.abs(energies).min() <= NO_STIFFNESS:
        raise SolverError(
            "equilibrium: whether the network is stable cannot be told: a motion meets "
            f"{np.abs(energies).min():.1g} of what its points meet alone; "
            "bring stiffnesses closer together, or add springs or supports"
        )
    outside = factorised.negative - int((factored < 0).sum())
    return max(outside, 0) + int((energies < 0).sum())


def _softest_motions(factor: Factor, weight: Array) -> tuple[Array, Array]:
    """Motions (f, modes) that the factor resists least, and the forces that it meets them with."""
    rng = np.random.default_rng(0)
    modes = rng.normal(size=(len(weight), min(MODES, len(weight))))
    modes /= np.sqrt(weight)[:, None]
    for _ in range(SWEEPS):
        pushes = weight[:, None] * modes
        modes = np.column_stack([factor.solve(push) for push in pushes.T])
        # Orthonormal in the metric of the weights; forces go along.
        root = np.sqrt(weight)[:, None]
        _, R = np.linalg.qr(root * modes / np.abs(root * modes).max(axis=0))
        scale = np.abs(root * modes).max(axis=0)
        modes, pushes = (np.linalg.solve(R.T, (x / scale).T).T for x in (modes, pushes))
    return modes, pushes
