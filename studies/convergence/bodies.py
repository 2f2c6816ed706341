"""The bodies of the study `convergence`: a sheared plate and cube, a bent beam, of any fineness."""

from __future__ import annotations

from functools import cache

import numpy as np

from msvalidate import kit
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.constants.routes import default_constants
from msvalidate.springs.constants.stiffness import square_tensor
from msvalidate.springs.dynamics.relax import relax
from msvalidate.springs.dynamics.relaxations import RELAXATIONS
from msvalidate.springs.dynamics.spectrum import extreme_frequencies
from msvalidate.springs.lattice import Lattice, fill, patterns, square
from msvalidate.springs.statics.equilibrium import equilibrium

SIZES: dict[str, tuple[float, ...]] = {
    "plate": (1.0, 1.0),
    "beam": (5.0, 1.0),
    "cube": (1.0, 1.0, 1.0),
}
"""m."""
PLANE = ("plate", "beam")
SHEAR = {"plate": 2e-5, "beam": 2e-6, "cube": 2e-5}
"""Traction (Pa) across the free end of a body with E = 1 Pa. Its rotations, of the order of 1e-4,
are small enough for predictions from frequencies at rest, and far above the rounding of lengths."""
NU = 1 / 3
"""Of the isotropic square lattice: the network stands for the elastic body, with no other error
than that of its spacing."""
NU_IN_SPACE = 1 / 4
"""Likewise of the cubic lattice with eighteen neighbours."""
FACTORISED = 10
"""Cells along an edge of a cube up to which its tangent is factorised. The factor of springs grows
as their points squared: with 20 cells one takes ten seconds, multigrid half of one."""
BY_MULTIGRID = 1e-13
"""Residual, over the largest force, at which multigrid has brought a larger cube to rest."""


def dim(body: str) -> int:
    """Axes of the body."""
    return len(SIZES[body])


def box(body: str) -> kit.Box:
    """The body's outline."""
    return kit.Box(SIZES[body])


def problem(body: str) -> kit.Problem:
    """Clamped on the left, sheared along y on the right; density 1 kg/m³, plates 1 m thick."""
    outline = box(body)
    plane = dim(body) == 2
    still, shear = np.zeros(dim(body)), np.zeros(dim(body))
    shear[1] = -SHEAR[body]
    return kit.Problem(
        outline,
        kit.Isotropic(E=1.0, nu=NU)
        if plane
        else kit.Isotropic(E=1.0, nu=NU_IN_SPACE, state="solid"),
        (kit.Support(outline.side("left"), tuple(still)),),
        (kit.Traction(outline.side("right"), tuple(shear)),),
    )


def tensor() -> kit.Array:
    """Plane stiffness (3, 3) in N/m of the plate and the beam, and of their networks."""
    return square_tensor(*default_constants(problem("plate").material, lattice("plate", 1)))


def lattice(body: str, fineness: int) -> Lattice:
    """Square lattice with eight neighbours, or cubic lattice with eighteen."""
    if dim(body) == 2:
        along, across = cells(body, fineness)
        return square(box(body), (along, across))
    return fill(patterns.cubic18(), box(body), cells(body, fineness))


def cells(body: str, fineness: int) -> tuple[int, ...]:
    """Square or cubic cells along each axis, of which `fineness` across the body."""
    across = SIZES[body][1]
    return tuple(round(side / across) * fineness for side in SIZES[body])


def network(body: str, fineness: int) -> kit.Network:
    """The lattice's network, with shared weights."""
    return lattice_network(problem(body), lattice(body, fineness))


def is_factor_worthwhile(body: str, fineness: int) -> bool:
    """Whether a factor of the body's tangent is worth its time."""
    return dim(body) == 2 or fineness <= FACTORISED


@cache
def rest_displacement(body: str, fineness: int) -> kit.Array:
    """The network's own equilibrium (n, d) in m, by Newton's method.

    By a direct solver; of cubes beyond `FACTORISED` by multigrid, which `space` judges.
    """
    if is_factor_worthwhile(body, fineness):
        return equilibrium(network(body, fineness), "nonlinear").displacement
    return rest_by_multigrid(body, fineness)


def rest_by_multigrid(body: str, fineness: int) -> kit.Array:
    """The same (n, d) in m, with no factor."""
    method = RELAXATIONS["newton_multigrid"]
    return relax(network(body, fineness), method, tolerance=BY_MULTIGRID).equilibrium.displacement


@cache
def frequencies(body: str, fineness: int) -> tuple[float, float]:
    """Lowest and highest natural frequency (rad/s) of the network."""
    return extreme_frequencies(network(body, fineness))


def root_kappa(body: str, fineness: int) -> float:
    """Highest over lowest natural frequency of the network."""
    low, high = frequencies(body, fineness)
    return high / low


def relative_error(displacement: kit.Array, reference: kit.Array) -> float:
    """Largest distance from the reference over the largest displacement there."""
    apart = np.linalg.norm(displacement - reference, axis=1).max()
    return float(apart / np.linalg.norm(reference, axis=1).max())


def relative_distance(displacement: kit.Array, reference: kit.Array) -> float:
    """Euclidean distance from the reference over its Euclidean norm."""
    return float(np.linalg.norm(displacement - reference) / np.linalg.norm(reference))
