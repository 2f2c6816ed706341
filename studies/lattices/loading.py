"""How bodies of lattice are loaded: uniform stress between tractions, or clamped and pulled."""

from __future__ import annotations

import numpy as np

from msvalidate import kit
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.lattice import Constants, Lattice

from .cases import box_of

STRAIN = 1e-5
"""Traction over the modulus. What is linear stays so, and a relaxation's rotations stay small."""
SIDES = (("left", "right"), ("bottom", "top"), ("back", "front"))
"""Low and high side across each axis."""
TESTS = ("pull", "shear")
"""Of a side across x: traction along x, or along y."""
Stress = tuple[int, int]
"""The axes of a stress component, as in `VOIGT`."""


def uniform(box: kit.Box, material: kit.Material, stress: Stress, size: float) -> kit.Problem:
    """Tractions of a uniform stress (Pa) on all sides; supports that take no force."""
    d = box.dim
    corner = np.zeros(d)
    along, up = corner.copy(), corner.copy()
    along[0], up[1] = box.size[:2]
    held = [(corner, (0.0,) * d), (along, (None, 0.0, 0.0)[:d])]
    if d == 3:
        held.append((up, (None, None, 0.0)))
    loads = []
    for normal, way in sorted({stress, stress[::-1]}):
        for side, sign in zip(SIDES[normal], (-1.0, 1.0), strict=True):
            traction = tuple(sign * size * (axis == way) for axis in range(d))
            loads.append(kit.Traction(box.side(side), traction))
    supports = tuple(kit.Support(kit.Region(tuple(at.tolist())), free) for at, free in held)
    return kit.Problem(box, material, supports, tuple(loads), name="uniform stress")


def clamped(box: kit.Box, material: kit.Material, test: str, size: float) -> kit.Problem:
    """Left side held, a uniform traction (Pa) on the right one, along x or along y."""
    d = box.dim
    way = TESTS.index(test)
    traction = tuple(size * (axis == way) for axis in range(d))
    return kit.Problem(
        box,
        material,
        (kit.Support(box.side("left"), (0.0,) * d),),
        (kit.Traction(box.side("right"), traction),),
        name=f"clamped, {test}",
    )


def modulus(tensor: kit.Array) -> float:
    """Young's modulus along x (unit of the tensor)."""
    return float(1 / compliances(tensor)[0, 0])


def compliances(tensor: kit.Array) -> kit.Array:
    """The inverse of a tensor (one over its unit)."""
    return np.asarray(np.linalg.inv(tensor), dtype=float)


def work(network: kit.Network, move: kit.Array) -> float:
    """Work (J) of a network's loads on a displacement (n, d) in m."""
    return float((network.force * move).sum())


def components(dim: int) -> dict[str, Stress]:
    """The stresses whose strains give E, nu and A: along the pull, across it, and of shear."""
    return {"pull": kit.VOIGT[dim][0], "across": kit.VOIGT[dim][1], "shear": kit.VOIGT[dim][-1]}


def compliance(
    candidate: kit.DisplacementSolver, lattice: Lattice, constants: Constants, body: kit.Anisotropic
) -> tuple[float, float, float]:
    """Strain per stress (1 over the unit of a tensor): along a pull, across it, and of shear.

    Of the strains the one on which a stress does work, through its tractions and per volume.
    """
    size, box = STRAIN * modulus(body.C), box_of(lattice)
    problems = {
        name: uniform(box, body, stress, size) for name, stress in components(body.dim).items()
    }
    networks = {
        name: lattice_network(problem, lattice, constants) for name, problem in problems.items()
    }
    pulled, sheared = (
        candidate(problems[test], networks[test], "linear") for test in ("pull", "shear")
    )
    unit = size**2 * box.volume
    return (
        work(networks["pull"], pulled) / unit,
        work(networks["across"], pulled) / unit,
        work(networks["shear"], sheared) / unit,
    )


def gradient(strain: kit.Array, dim: int) -> kit.Array:
    """Symmetric matrix (d, d) of a Voigt strain."""
    matrix = np.diag(strain[:dim])
    for (a, b), value in zip(kit.VOIGT[dim][dim:], strain[dim:], strict=True):
        matrix[a, b] = matrix[b, a] = value / 2
    return matrix
