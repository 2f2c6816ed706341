"""The networks that are timed: plates, cubes and bars of lattice, random triangles, tetrahedra."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import cache
from itertools import combinations

import numpy as np
from scipy.spatial import Delaunay

from msvalidate import kit
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.dynamics.step_limits import SAFETY
from msvalidate.springs.lattice import fill, patterns, square
from msvalidate.springs.network import spring_network

SIDE = 0.1
"""Of the plate (m)."""
THICKNESS = 0.01
DENSITY = 1000.0
STRAIN = 1e-3
"""Size of the shear that the load would cause, and of the random displacements in spacings."""
MATERIALS = {"soft tissue": 1e4, "rubber": 1e6, "steel": 2e11}
"""Young's moduli (Pa) whose real time is told; steel's density is its own."""
DENSITIES = {"soft tissue": 1000.0, "rubber": 1000.0, "steel": 7800.0}
E = MATERIALS["rubber"]
SOLID = kit.Isotropic(E=1.0, nu=0.25, state="solid")
"""Of cubes and bars: a ratio that springs alone can be."""
SLENDER = 100
"""Length over thickness of a bar."""
CORE = 0.3
"""Radius (m) of the stiff or soft ball in a cube of one metre."""
VOLUME_PART = 0.5
"""κ of cells over E t: a ratio of 0.5 or so in plane stress; only its presence matters to time."""


def plate(
    cells: int, *, volume: float = 0.0, strain: tuple[float, float] = (0.0, -STRAIN)
) -> kit.Network:
    """Square plate of `cells` x `cells` squares with eight neighbours, clamped on the left.

    On the right it is loaded by the modulus times `strain`, along it and across.
    """
    box = kit.Box((SIDE, SIDE))
    problem = kit.Problem(
        box,
        kit.Isotropic(E=E, nu=1 / 3, density=DENSITY, thickness=THICKNESS),
        (kit.Support(box.side("left"), (0.0, 0.0)),),
        (kit.Traction(box.side("right"), (strain[0] * E, strain[1] * E)),),
    )
    return lattice_network(problem, square(box, (cells, cells)), volume=volume)


def lattice(nodes: int) -> kit.Network:
    """The plate with about so many nodes, eight neighbours each."""
    return plate(along(nodes, 2))


def with_volume(nodes: int) -> kit.Network:
    """The same with an energy of the volume of each cell."""
    return plate(along(nodes, 2), volume=VOLUME_PART * E * THICKNESS)


def triangles(nodes: int) -> kit.Network:
    """A spring along each edge of the Delaunay triangles of random points in a square."""
    return strewn(nodes, 2)


def tetrahedra(nodes: int) -> kit.Network:
    """A spring along each edge of the Delaunay tetrahedra of random points in a cube."""
    return strewn(nodes, 3)


def strewn(nodes: int, dim: int, seed: int = 0) -> kit.Network:
    """Random points, in random order, joined as Delaunay [Delaunay1934] does; one tenth is held."""
    rng = np.random.default_rng(seed)
    spacing = SIDE * nodes ** (-1 / dim)
    points = SIDE * rng.random((nodes, dim))
    cells = Delaunay(points).simplices
    edges = [cells[:, pair] for pair in combinations(range(dim + 1), 2)]
    springs = np.unique(np.sort(np.concatenate(edges), axis=1), axis=0)
    force = np.zeros((nodes, dim))
    force[points[:, 0] > 0.9 * SIDE, 1] = -STRAIN * E * THICKNESS * spacing
    return spring_network(
        points,
        springs,
        E * THICKNESS,
        mass=DENSITY * SIDE**2 * THICKNESS / nodes,
        fixed=np.repeat(points[:, :1] < 0.1 * SIDE, dim, axis=1),
        force=np.where(points[:, :1] < 0.1 * SIDE, 0.0, force),
    )


NETWORKS: Mapping[str, Callable[[int], kit.Network]] = {
    "lattice": lattice,
    "lattice with volume energy": with_volume,
    "random triangles": triangles,
    "random tetrahedra": tetrahedra,
}


def cube(nodes: int) -> kit.Network:
    """Cube of a cubic lattice with 18 neighbours, clamped at one end and sheared at the other."""
    return solid(cube_cells(along(nodes, 3)))


def bar(nodes: int) -> kit.Network:
    """The same, a hundred times as long as it is thick."""
    across = max(2, round(float((nodes / SLENDER) ** (1 / 3)) - 2 / 3))
    return solid(bar_cells(across))


def cube_cells(across: int) -> tuple[int, int, int]:
    """Cells along each side of the cube."""
    return (across,) * 3


def bar_cells(across: int) -> tuple[int, int, int]:
    """Cells along the bar and across: about 100 (a + 2/3)³ points, if a are across."""
    return (SLENDER * across, across, across)


def solid(cells: tuple[int, ...]) -> kit.Network:
    """Cubic lattice of so many cells, E = 1 Pa, one metre across."""
    box = kit.Box(tuple(one / min(cells) for one in cells))
    problem = kit.Problem(
        box,
        SOLID,
        (kit.Support(box.side("left"), (0.0,) * 3),),
        (kit.Traction(box.side("right"), (0.0, 0.0, -STRAIN)),),
    )
    return lattice_network(problem, fill(patterns.cubic18(), box, cells))


def with_core(nodes: int, times: float) -> kit.Network:
    """The cube, with springs stiffer by `times` whose middles lie in a ball inside."""
    net = cube(nodes)
    middle = net.points[net.springs].mean(axis=1)
    inside = np.linalg.norm(middle - 0.5, axis=1) < CORE
    return net.scaled(np.where(inside, times, 1.0))


@cache
def network(name: str, nodes: int) -> kit.Network:
    """A network by name, with about so many nodes."""
    return NETWORKS[name](nodes)


def along(nodes: int, dim: int) -> int:
    """Cells along a side of a square or cube with about so many nodes."""
    return max(2, round(float(nodes ** (1 / dim))) - 1)


def time_step(net: kit.Network) -> float:
    """Step (s) below the limit of any network, for timing: 2/ω with ω² <= 2d·max Σk/m.

    By Gershgorin's circles without the tangent, which would take longer than the steps; an energy
    of volumes is of the same order.
    """
    met = np.bincount(net.springs.ravel(), np.repeat(net.stiffness, 2), len(net.points))
    fastest = 2 * net.dim * float((met / net.mass).max())
    return 0.5 * SAFETY * 2 / math.sqrt(fastest)


def start(net: kit.Network, seed: int = 0) -> tuple[kit.Array, kit.Array]:
    """Displacement (m) and velocity (m/s) to start from, (n, d) each.

    Small and random, so that no product is of zeros.
    """
    rng = np.random.default_rng(seed)
    size = STRAIN * float(net.rest_length.min()) * ~net.fixed
    return size * rng.standard_normal(net.points.shape), np.zeros(net.points.shape)
