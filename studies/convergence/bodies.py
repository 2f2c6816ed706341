"""The bodies of the study `convergence`: a sheared plate and a bent beam, of any fineness."""

from __future__ import annotations

from functools import cache

import numpy as np

from msvalidate.body import lattice_network
from msvalidate.calibrate import default_constants
from msvalidate.equilibrium import equilibrium
from msvalidate.lattice import Lattice, square
from msvalidate.network import Network
from msvalidate.problem import Array, Box, Isotropic, Problem, Support, Traction
from msvalidate.spectrum import extreme_frequencies
from msvalidate.stiffness import square_tensor

SIZES = {"plate": (1.0, 1.0), "beam": (5.0, 1.0)}
"""m."""
SHEAR = {"plate": 2e-5, "beam": 2e-6}
"""Traction (Pa) across the free end of a body with E = 1 Pa. Its rotations, of the order of 1e-4,
are small enough for predictions from frequencies at rest, and far above the rounding of lengths."""
NU = 1 / 3
"""Of the isotropic square lattice: the network stands for the elastic body, with no other error
than that of its spacing."""


def box(body: str) -> Box:
    """The body's outline."""
    return Box(SIZES[body])


def problem(body: str) -> Problem:
    """Clamped on the left, sheared on the right; density 1 kg/m³, thickness 1 m."""
    outline = box(body)
    return Problem(
        outline,
        Isotropic(E=1.0, nu=NU),
        (Support(outline.side("left"), (0.0, 0.0)),),
        (Traction(outline.side("right"), (0.0, -SHEAR[body])),),
    )


def tensor() -> Array:
    """Plane stiffness (3, 3) in N/m of the bodies and of their networks."""
    return square_tensor(*default_constants(problem("plate").material, lattice("plate", 1)))


def lattice(body: str, fineness: int) -> Lattice:
    """Square lattice with eight neighbours."""
    return square(box(body), cells(body, fineness))


def cells(body: str, fineness: int) -> tuple[int, int]:
    """Square cells along x and y, of which `fineness` across the body."""
    width, height = SIZES[body]
    return round(width / height) * fineness, fineness


def network(body: str, fineness: int) -> Network:
    """The lattice's network, with shared weights."""
    return lattice_network(problem(body), lattice(body, fineness))


@cache
def at_rest(body: str, fineness: int) -> Array:
    """The network's own equilibrium (n, d) in m, by Newton's method with a direct solver."""
    return equilibrium(network(body, fineness), "nonlinear").displacement


@cache
def frequencies(body: str, fineness: int) -> tuple[float, float]:
    """Lowest and highest natural frequency (rad/s) of the network."""
    return extreme_frequencies(network(body, fineness))


def relative_error(displacement: Array, reference: Array) -> float:
    """Largest distance from the reference over the largest displacement there."""
    apart = np.linalg.norm(displacement - reference, axis=1).max()
    return float(apart / np.linalg.norm(reference, axis=1).max())


def relative_distance(displacement: Array, reference: Array) -> float:
    """Euclidean distance from the reference over its Euclidean norm."""
    return float(np.linalg.norm(displacement - reference) / np.linalg.norm(reference))
