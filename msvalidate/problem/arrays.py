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
"""Pairs of axes of the Voigt components, by number of axes.

The order is xx, yy, xy in 2D and xx, yy, zz, yz, xz, xy in 3D.
"""
PLACEMENT = 1e-9
"""Relative distance below which two positions coincide, as a fraction of the body's size.

It is far above rounding of coordinates (1e-16) and far below any spacing that fits in memory.
"""
LONGEST = 1e100
"""Upper limit of lengths and coordinates (m); its inverse is the lower limit of lengths.

Areas, volumes and squared distances are then finite numbers.
"""
MOST_POINTS = 20_000_000
"""Maximum number of lattice points or mesh nodes.

Beyond it, springs or cells and the arrays that generate them would take tens of gigabytes.
"""
