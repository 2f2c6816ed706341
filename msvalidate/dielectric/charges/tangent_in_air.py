"""How forces on a dielectric body in air change as its surface moves.

With the equations M(x) q = r, r constant at fixed voltages, and W = ½g(x)'q, let M'y = g. Then

    dW = ½(dg)'q - ½y'(dM)q,
    d²W = ½(d²g)'q - ½y'(d²M)q - ½[s'M⁻¹u + u'M⁻ᵀs],    u = (dM)q,    s = dg - (dM)'y,

so one solve with as many columns as there are components gives all of it.
"""

from __future__ import annotations

import numpy as np

from msvalidate.dielectric.charges.dielectric import ChargesInAir, adjoint_weights
from msvalidate.dielectric.charges.forces import bends, slopes
from msvalidate.dielectric.kernels import charges as integrals
from msvalidate.dielectric.kernels import fluxes
from msvalidate.problem import Array
from msvalidate.problem.checks import require_type


def tangent_in_air(charges: ChargesInAir) -> Array:
    """Derivative (2n, 2n) of `forces_in_air` at fixed voltages, per depth (N/m²).

    Symmetric, being of a second derivative. Components of a point stand together.
    """
    require_type("charges", charges, ChargesInAir)
    moments = charges.moments
    faces, charge = moments.faces, charges.charge
    on_covered, weight = adjoint_weights(charges)
    lines, n = (*moments.lines(), faces.segments), len(weight)
    # Sums and differences of two vectors tell of a form of both.
    more_first, more_second = integrals.turned(*lines, on_covered + charge, n)
    less_first, less_second = integrals.turned(*lines, on_covered - charge, n)
    through, sent, second = fluxes.twisted(*lines, weight, charge, n)
    whole = 2 * np.pi
    potential = -slopes(0.5 * (more_first - less_first)) / whole
    bound = -2 * moments.contrast * slopes(through) / whole
    moved = moments.solve(np.where(faces.bare[:, None], bound, potential))[:-1]
    turned = slopes(0.5 * (more_first + less_first) / moments.around + 2 * sent) / whole
    cross = turned.T @ moved
    bend = bends((more_second - less_second) / (8 * moments.around) + second) / whole
    return bend - 0.5 * (cross + cross.T)
