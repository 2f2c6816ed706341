"""Springs of Green's strain, φ = (k/8L0²)(L² - L0²)².

Of isotropic lattices they are St. Venant-Kirchhoff's solid with λ = μ, at any strain (fourth
moments of the directions). f/L = (k/2)(s/L0² - 1). Source: derived, as above.
"""

from __future__ import annotations

from msvalidate.springs.network.laws.law import SpringLaw

GREEN = SpringLaw(
    "green",
    coefficients=lambda k, L0: (0.5 * k, L0**2),
    pull=lambda c, s: c[0] * ((s - c[1]) / c[1]),
    axial=lambda c, s: c[0] * (3 * s - c[1]) / c[1],
    change=lambda c, s0, s, grown: c[0] * (grown / c[1]),
    work=lambda c, s0, s, grown: 0.25 * c[0] / c[1] * grown**2,
    stored=lambda c, s: 0.25 * c[0] / c[1] * (s - c[1]) ** 2,
    loops=lambda c: (c[0] / c[1], c[0]),
    straight=True,
)
