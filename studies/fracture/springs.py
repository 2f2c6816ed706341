"""Strips of a lattice between clamps, with a crack from one side."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from msvalidate.problem import Array, Box
from msvalidate.springs.lattice import Pattern, boundary_weights, fill
from msvalidate.springs.lattice.filled import Lattice
from msvalidate.springs.lattice.patterns import square, triangular
from msvalidate.springs.network import Network, spring_network
from msvalidate.springs.statics.breaking import FractureResult

Grow = Callable[..., FractureResult]
"""As `msvalidate.springs.statics.breaking.propagate_crack`."""
E, NU = 8 / 3, 1 / 3
LATTICES: dict[str, tuple[Pattern, tuple[float, ...]]] = {
    "square-8": (square(), (2.0, 1.0)),
    "triangular": (triangular(), (4 / np.sqrt(3),)),
}
"""Lattices of plane stress with this modulus (Pa) and ratio, and their constants (N/m)."""


def filled(name: str, width: int, height: float) -> Lattice:
    """A lattice of spacing 1 in a box so many spacings wide and about as high."""
    pattern, _ = LATTICES[name]
    rows = max(1, round(height / pattern.size[1]))
    return fill(pattern, Box((float(width), rows * pattern.size[1])), (width, rows))


def pulled(lattice: Lattice, k: tuple[float, ...]) -> Network:
    """A body whose lower and upper side are clamped and moved apart, by its height at factor 1."""
    x, height = lattice.points, lattice.domain.span[1][1]
    end = np.abs(x[:, 1] - height / 2) >= height / 2 * (1 - 1e-9)
    held = np.column_stack([end, end])
    moved = np.where(held, (x - [0, height / 2]) * [0, 1], 0.0)
    stiffness = np.array(k)[lattice.kind] * lattice.factor * boundary_weights(lattice, "shared")
    mass = lattice.point_volume
    return spring_network(
        x, lattice.springs, stiffness, fixed=held, displacement=moved, mass=mass,
        cells=lattice.cells,
    )  # fmt: skip


def middles(network: Network) -> Array:
    """Middle (m, 2) of each spring."""
    return np.asarray(network.points[network.springs].mean(axis=1))
