"""Electrostatic forces on the ends of segments, and how they change as these move.

At fixed voltages the force on a point is the derivative of W = ½ΣQV in its position. With
Galerkin's charges it needs none of the charges' own changes: W is stationary in them. So

    F = ∂W/∂x = -½ q' (∂P/∂x) q,

which holds the pull across the gap, its moment on each segment's ends, and the outward stretch
q²/(4πεl) of a segment by itself. Collocation's charges are not stationary: for them it is a force
with an error of the same order as theirs.
"""

from __future__ import annotations

import numpy as np

from msvalidate.dielectric.charges.moments import Charges, Complex, to_complex
from msvalidate.dielectric.kernels import charges as integrals
from msvalidate.problem import Array, ProblemError
from msvalidate.problem.checks import require_type


def forces(charges: Charges) -> Array:
    """Force (n, 2) per depth (N/m) on each point of the electrodes."""
    require_type("charges", charges, Charges)
    electrodes = charges.moments.electrodes
    total = integrals.pulled(
        to_complex(electrodes.start),
        to_complex(electrodes.along),
        electrodes.segments,
        charges.charge,
        len(electrodes.points),
    )
    return np.column_stack([total.real, -total.imag]) / (4 * np.pi * charges.moments.permittivity)


def tangent(charges: Charges) -> Array:
    """Derivative (2n, 2n) of `forces` at fixed voltages, per depth (N/m²), charges free to move.

    Symmetric, being of a second derivative: ∂²W/∂x² = -½q'(∂²P/∂x²)q + (∂P/∂x q)' S (∂P/∂x q),
    S the solution of `Moments`. Components of a point stand together.

    Raises
    ------
    ProblemError
        If charges are those of collocation, whose forces are no energy's derivative.
    """
    require_type("charges", charges, Charges)
    moments = charges.moments
    if moments.weighting != "galerkin":
        raise ProblemError(
            f'charges: their weighting is {moments.weighting}; a tangent takes weighting="galerkin"'
        )
    electrodes, scale = moments.electrodes, 1 / (2 * np.pi * moments.permittivity)
    first, second = integrals.turned(
        to_complex(electrodes.start),
        to_complex(electrodes.along),
        electrodes.segments,
        charges.charge,
        len(electrodes.points),
    )
    slope = -scale * slopes(first)
    return 0.5 * scale * bends(second) + slope.T @ moments.solve(slope)


def slopes(first: Complex) -> Array:
    """Complex derivatives (m, n) as real ones (m, 2n)."""
    return np.stack([first.real, -first.imag], axis=-1).reshape(len(first), -1)


def bends(second: Complex) -> Array:
    """Complex second derivatives (n, n) as real ones (2n, 2n)."""
    n = len(second)
    bend = np.empty((n, 2, n, 2))
    bend[:, 0, :, 0], bend[:, 1, :, 1] = second.real, -second.real
    bend[:, 0, :, 1] = bend[:, 1, :, 0] = -second.imag
    return bend.reshape(2 * n, 2 * n)
