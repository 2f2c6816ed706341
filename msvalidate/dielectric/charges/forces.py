"""Electrostatic forces on the ends of segments, and how they change as these move.

At fixed voltages the force on a point is the derivative of W = ½ΣQV in its position. With
Galerkin's charges it needs none of the charges' own changes: W is stationary in them. So

    F = ∂W/∂x = -½ q' (∂P/∂x) q,

which holds the pull across the gap, its moment on each segment's ends, and the outward stretch
q²/(4πεl) of a segment by itself. Collocation's charges are not stationary: for them it is a force
with an error of the same order as theirs.

The equations M(x) q = r of a body in air are not symmetric. With r constant at fixed voltages,
W = ½g(x)'q and M'y = g,

    dW = ½(dg)'q - ½y'(dM)q,
    d²W = ½(d²g)'q - ½y'(d²M)q - ½[s'M⁻¹u + u'M⁻ᵀs],    u = (dM)q,    s = dg - (dM)'y,

so one solve with as many columns as there are components gives all of it.
"""

from __future__ import annotations

import numpy as np

from msvalidate.dielectric.charges.dielectric import ChargesInAir
from msvalidate.dielectric.charges.moments import Charges
from msvalidate.dielectric.kernels import charges as integrals
from msvalidate.dielectric.kernels import fluxes
from msvalidate.problem import Array, ProblemError
from msvalidate.problem.checks import require_type
from msvalidate.springs.kernels.values import Complex


def forces(charges: Charges) -> Array:
    """Force (n, 2) per depth (N/m) on each point of the electrodes."""
    require_type("charges", charges, Charges)
    electrodes, q = charges.moments.electrodes, charges.charge
    total = integrals.pulled(*electrodes.lines, electrodes.segments, q, len(electrodes.points))
    return _slopes(total[None]).reshape(-1, 2) / (4 * np.pi * charges.moments.permittivity)


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
    electrodes, q, scale = (
        moments.electrodes,
        charges.charge,
        1 / (2 * np.pi * moments.permittivity),
    )
    lines, n = electrodes.lines, len(electrodes.points)
    first, _, second = integrals.turned(*lines, electrodes.segments, q, q, n)
    slope = -scale * _slopes(first)
    return slope.T @ moments.solve(slope) + 0.5 * scale * _bends(second)


def forces_in_air(charges: ChargesInAir) -> Array:
    """Force (n, 2) per depth (N/m) on each point of the surface, bare or covered.

    The energy's derivative in the points at fixed voltages, by the adjoint y of the charges:

        dW = -½ y'(dP)q over electrodes + ½ [2·contrast·y - (ε_r-1)·V]'(dΦ)q,

    y on bare faces, V on electrodes. It holds the traction on faces, the pull at the edges of
    electrodes, and the moments of both on the ends of segments.

    At the edge of an electrode on a smooth face, r away, tractions go like ±1/r for ε_r other than
    1: inwards on the electrode, outwards beside it. Together they have a limit, each alone has
    none: sums over a finer and finer electrode without its neighbourhood do not converge.
    """
    require_type("charges", charges, ChargesInAir)
    on_covered, weight = _adjoint_weights(charges)
    faces, q, n = charges.moments.electrodes, charges.charge, len(weight)
    lines = *faces.lines, faces.segments
    # A form of two vectors, from that of one.
    more, less = (integrals.pulled(*lines, on_covered + s * q, n) for s in (1, -1))
    total = (more - less) / (8 * charges.moments.around) + fluxes.dragged(*lines, weight, q, n)
    return _slopes(total[None]).reshape(-1, 2) / (2 * np.pi)


def tangent_in_air(charges: ChargesInAir) -> Array:
    """Derivative (2n, 2n) of `forces_in_air` at fixed voltages, per depth (N/m²).

    Symmetric, being of a second derivative. Components of a point stand together.
    """
    require_type("charges", charges, ChargesInAir)
    moments, q = charges.moments, charges.charge
    faces, (on_covered, weight) = moments.electrodes, _adjoint_weights(charges)
    lines, n = (*faces.lines, faces.segments), len(weight)
    potential = [each / (2 * np.pi) for each in integrals.turned(*lines, on_covered, q, n)]
    flux = [each / (2 * np.pi) for each in fluxes.twisted(*lines, weight, q, n)]
    bare = faces.bare[:, None]
    right = -np.where(bare, 2 * moments.contrast * _slopes(flux[0]), _slopes(potential[0]))
    moved = moments.solve(right)[:-1]
    turned = _slopes(potential[1] / moments.around + 2 * flux[1])
    cross = turned.T @ moved
    return _bends(potential[2] / (2 * moments.around) + flux[2]) - 0.5 * (cross + cross.T)


def _adjoint_weights(charges: ChargesInAir) -> tuple[Array, Array]:
    """The weights (n,) of (dP)q, times the air's permittivity, and of (dΦ)q in `forces_in_air`."""
    moments = charges.moments
    faces, ratio = moments.electrodes, moments.ratio
    volt = np.where(faces.bare, 0.0, charges.voltages[faces.electrode])
    answer = moments.solve(
        0.5 * (1 + ratio) * volt - (ratio - 1) * (volt @ moments.flux), adjoint=True
    )[:-1]
    on_bare = np.where(faces.bare, answer, 0.0)
    on_covered = moments.around * (answer - on_bare)
    return on_covered, moments.contrast * on_bare - 0.5 * (ratio - 1) * volt


def _slopes(first: Complex) -> Array:
    """Complex derivatives (m, n) as real ones (m, 2n)."""
    return np.stack([first.real, -first.imag], axis=-1).reshape(len(first), -1)


def _bends(second: Complex) -> Array:
    """Complex second derivatives (n, n) as real ones (2n, 2n)."""
    n = len(second)
    bend = np.empty((n, 2, n, 2))
    bend[:, 0, :, 0], bend[:, 1, :, 1] = second.real, -second.real
    bend[:, 0, :, 1] = bend[:, 1, :, 0] = -second.imag
    return bend.reshape(2 * n, 2 * n)
