"""Zero-length springs, f = k L: neo-Hookean together with cells under pressure.

Σ ½ k |F r|² over directions of second-order isotropy is (a/2) F:F, the part of the neo-Hookean
energy that changes of shape store; a `logarithmic` cell has the other. A rest length counts as a
size only. Source: derived, and measured node for node against P1 elements in study `large_strain`.
"""

from __future__ import annotations

import numpy as np

from msvalidate.springs.network.laws.law import SpringLaw

ZERO_LENGTH = SpringLaw(
    "zero-length",
    coefficients=lambda k, L0: (k,),
    pull=lambda c, s: c[0],
    axial=lambda c, s: c[0],
    change=lambda c, s0, s, grown: np.zeros_like(s),
    work=lambda c, s0, s, grown: np.zeros_like(s),
    stored=lambda c, s: np.zeros_like(s),
    rests=False,
)
