"""Types of arrays, names of axes and the sizes beyond which nothing is made."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
"""Real numbers; (n, d) for points and vectors, d = 2 or 3."""
Mask = NDArray[np.bool_]
Index = NDArray[np.intp]
Field = Callable[[Array], Array]
"""A function of points (n, d) in m that returns values (n,) or (n, d)."""
Span = tuple[tuple[float, float], ...]
"""Low and high coordinate (m) of a body along each axis."""

AXES = "xyz"
VOIGT = {2: ((0, 0), (1, 1), (0, 1)), 3: ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))}
"""Pairs of axes of Voigt's components: xx, yy, xy, or xx, yy, zz, yz, xz, xy."""
PLACEMENT = 1e-9
"""Two places closer than this fraction of the body are the same place: far above rounding of
coordinates (1e-16), far below any spacing that fits in memory."""
LONGEST = 1e100
"""Lengths and coordinates (m) stay below it, and lengths above its inverse: areas and volumes, and
the squares that a distance takes, are then ordinary numbers too."""
MOST_POINTS = 20_000_000
"""Points of a lattice, or nodes of a mesh, beyond which none is made: its springs or cells, and the
lists that make them, would take tens of gigabytes."""
