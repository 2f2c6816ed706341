"""Which models `models` sets side by side."""

from __future__ import annotations

from typing import NamedTuple

DEPTHS = (1.0, 6.0, 24.0)
"""Of the report's rectangles, over the gap."""
RATIOS = (1.0, 3.0, 10.0)
"""Permittivity ratios of the slab in air."""


class Model(NamedTuple):
    """A model, as tables name it."""

    name: str
    depth: float | str
    forces_by: str
    ratio: float


PLANE = Model("plane", "endless", "derivatives", 1.0)
MODELS = (
    PLANE,
    Model("plane", "endless", "point sums", 1.0),
    *(Model("report's", depth, "point sums", 1.0) for depth in DEPTHS),
    *(Model("in air", "endless", "derivatives", ratio) for ratio in RATIOS),
)
"""The plane model, which others are held beside, comes first."""
