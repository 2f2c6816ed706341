"""Closed forms of electrostatics that the method of moments is held against."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq
from scipy.special import ellipe, ellipeinc, ellipkinc, ellipkm1

from msvalidate.problem import ProblemError
from msvalidate.problem.checks import positive_number

NARROWEST, WIDEST = 0.1, 50.0
"""Widths over the gap for which the closed form is held against its limits on both ends, and within
3e-6 against the method of moments all along."""
UNIT_SQUARE = 0.36679
"""Capacitance of a square plate over 4πε times its side. It has no closed form; patches graded
towards the edges, up to 128 x 128 of them, extrapolate to 0.366788, and the literature on it
([Read1997], and others by other methods) agrees in these five digits."""


def facing_strips_capacitance(ratio: float) -> float:
    """Capacitance per depth over the permittivity, of two facing strips without thickness.

    Love's conformal map [Love1923] opens the half plane above the plane of symmetry: C/ε =
    K(m)/K(1-m) where w/d = (2/π)·[K·E(φ|m) - E·F(φ|m)] and sin²φ = (K-E)/(mK). It is solved for
    ln(1-m), which is -2πw/d or so of wide strips.

    Parameters
    ----------
    ratio
        Width over gap, 0.1 to 50.

    Raises
    ------
    ProblemError
        If the ratio is out of this range.
    """
    if not NARROWEST <= positive_number("width over gap", ratio) <= WIDEST:
        raise ProblemError(
            f"width over gap: {ratio:g}; give {NARROWEST:g} to {WIDEST:g}, or take a wire pair "
            "below and a parallel-plate capacitor above"
        )

    def excess(log_rest: float) -> float:
        rest, m = np.exp(log_rest), -np.expm1(log_rest)
        whole, second = ellipkm1(rest), ellipe(m)
        angle = np.arcsin(np.sqrt((whole - second) / (m * whole)))
        given = whole * ellipeinc(angle, m) - second * ellipkinc(angle, m)
        return float(2 / np.pi * given - ratio)

    log_rest = float(brentq(excess, -700.0, -1e-3, xtol=1e-14, rtol=1e-14))
    rest, m = np.exp(log_rest), -np.expm1(log_rest)
    return float(ellipkm1(rest) / ellipkm1(m))


def disc_capacitance(radius: float) -> float:
    """Capacitance over the permittivity (m) of a thin disc alone in space: 8a.

    Source: [Maxwell1873].
    """
    return 8.0 * positive_number("radius", radius, "m")


def square_capacitance(side: float) -> float:
    """Capacitance over the permittivity (m) of a thin square plate alone in space."""
    return 4 * np.pi * UNIT_SQUARE * positive_number("side", side, "m")
