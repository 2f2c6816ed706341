"""Rubber spring that stiffens if c > 0, without square roots.

Its law is f/k = a L0²/L + b L + c L³/L0².

Its force need not vanish at the rest length: under incompressibility a constant tension is
pressure. Source: fitted to rubber's tests in study `large_strain`.
"""

from __future__ import annotations

import numpy as np

from msvalidate.problem import ProblemError
from msvalidate.problem.checks import finite
from msvalidate.springs.network.laws.law import SpringLaw
from msvalidate.springs.network.laws.logarithmic import excess_of_log


def cubic(a: float, b: float, c: float) -> SpringLaw:
    """The law of these three parts of a spring's stiffness.

    Raises
    ------
    ProblemError
        If one is no finite number, or a spring would have no stiffness at its rest length.
    """
    a, b, c = (
        float(finite(f"{name} of a cubic law", x)) for name, x in zip("abc", (a, b, c), strict=True)
    )
    if not b - a + 3 * c > 0:
        raise ProblemError(
            f"cubic law: stiffness b - a + 3c = {b - a + 3 * c:g} at rest; it must be above 0"
        )
    rests = a + b + c == 0
    return SpringLaw(
        f"cubic ({a:g}, {b:g}, {c:g})",
        coefficients=lambda k, L0: (k, L0**2),
        pull=lambda p, s: p[0] * (a * p[1] / s + b + c * s / p[1]),
        axial=lambda p, s: p[0] * (b - a * p[1] / s + 3 * c * s / p[1]),
        change=lambda p, s0, s, grown: p[0] * grown * (c / p[1] - a * p[1] / (s0 * s)),
        # With x = grown/s0: φ - φ0 - ½ pull0·grown = ½ k a L0² (log(1 + x) - x) + ¼ k c grown²/L0².
        work=lambda p, s0, s, grown: (
            0.25 * p[0] * c / p[1] * grown**2 - 0.5 * p[0] * a * p[1] * excess_of_log(grown / s0)
        ),
        stored=lambda p, s: np.zeros_like(s),
        rests=rests,
    )
