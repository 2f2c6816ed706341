"""What several test files share: random networks, independent results, bodies, meshes."""

from __future__ import annotations

import json
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from hypothesis import strategies as st
from scipy.spatial import ConvexHull, Delaunay, QhullError

from msvalidate.problem import SHAPES, Box, Isotropic, Mesh, Problem, Support, Traction
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.lattice import square
from msvalidate.springs.network import spring_network
from msvalidate.springs.network.laws.volumes import Volumes

UNIT = 0.37
"""Size (m) of the squares and cubes of random networks."""
SPRINGS = Path(__file__).parents[1] / "data" / "springs"


@st.composite
def _network_and_position(draw, *, stressed):
    """Draw a jittered grid joined by Delaunay edges or random pairs, and a position nearby.

    Cells may resist a change of volume: the grid's boxes, or simplices between its points.

    Points start a unit apart and move by less than 0.4 of it in all, so no spring comes near length
    zero. The unit is no metre: where it is one, wrong powers of a length do not show.
    """
    dim = draw(st.sampled_from([2, 3]))
    sides = draw(st.tuples(*[st.integers(2, 4 if dim == 2 else 3)] * dim))
    joined = draw(st.sampled_from(["Delaunay", "pairs"]))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))

    grid = np.stack(np.meshgrid(*map(np.arange, sides), indexing="ij"), axis=-1).reshape(-1, dim)
    points = UNIT * (grid + rng.uniform(-0.3, 0.3, grid.shape))
    if joined == "Delaunay":
        corners = [list(pair) for pair in combinations(range(dim + 1), 2)]
        springs = np.unique(np.sort(Delaunay(points).simplices[:, corners].reshape(-1, 2)), axis=0)
    else:
        pairs = np.array(list(combinations(range(len(points)), 2)))
        springs = rng.permutation(pairs)[: rng.integers(1, len(pairs) + 1)]
    distance = np.linalg.norm(points[springs[:, 1]] - points[springs[:, 0]], axis=1)
    cells = draw(st.sampled_from(["none", "simplices", "boxes"]))
    network = spring_network(
        points,
        springs,
        rng.uniform(0.1, 10, len(springs)),
        volumes=None if cells == "none" else _volumes(points, sides, cells, rng),
        rest_length=distance * (rng.uniform(0.7, 1.3, len(springs)) if stressed else 1.0),
        mass=rng.uniform(0.5, 2, len(points)),
        force=rng.uniform(-1, 1, points.shape),
    )
    return network, points + UNIT * rng.uniform(-0.1, 0.1, points.shape)


def _volumes(points, sides, kind, rng):
    """Cells of a jittered grid."""
    if kind == "boxes":
        number = np.arange(len(points)).reshape(sides)
        around = [(0, 0), (1, 0), (1, 1), (0, 1)]
        corners = around if len(sides) == 2 else [(*c, z) for z in (0, 1) for c in around]
        shift = [
            [slice(step, n - 1 + step) for step, n in zip(c, sides, strict=True)] for c in corners
        ]
        cells = np.column_stack([number[tuple(part)].ravel() for part in shift])
    else:
        cells = Delaunay(points).simplices.astype(int)
        edges = points[cells[:, 1:]] - points[cells[:, :1]]
        turned = np.linalg.det(edges) < 0
        cells[turned, :2] = cells[turned, 1::-1]
        # Slivers have no stiffness to speak of.
        cells = cells[np.abs(np.linalg.det(edges)) > 0.05 * UNIT ** points.shape[1]]
    return Volumes(points, cells, rng.uniform(0, 5, len(cells)))


@pytest.fixture(scope="session")
def networks():
    """Strategy function for (network, position): no supports, random stiffness, masses, loads."""
    return _network_and_position


@pytest.fixture(scope="session")
def independent():
    """Read a file of tests/data/springs, by the start of its name: network and its record."""

    def read(name):
        (path,) = SPRINGS.glob(f"{name}_*.json")
        record = json.loads(path.read_text(encoding="utf-8"))
        points = np.array(record["points"])
        held = np.zeros(points.shape, dtype=bool)
        held[record["held"]] = True
        force = np.zeros(points.shape)
        for point, axis, value in record["forces"]:
            force[point, axis] += value
        network = spring_network(
            points,
            record["springs"],
            record["stiffness"],
            rest_length=record["rest_length"],
            mass=record["mass"],
            fixed=held,
            force=force,
        )
        return network, record

    return read


@pytest.fixture(scope="session")
def lattice_body():
    """Build the network of a plane stress body, nu = 1/3, on a square lattice, clamped on the left.

    E = 1 Pa and thickness 1 m, so k1 = 3/4 N/m and k2 = 3/8 N/m unless constants are given.
    """

    def build(size, cells, *, supports=None, loads=(), constants=None, **rules):
        box = Box(size)
        supports = supports or (Support(box.side("left"), (0.0, 0.0)),)
        problem = Problem(box, Isotropic(E=1.0, nu=1 / 3), supports, loads)
        return lattice_network(problem, square(box, cells), constants, **rules)

    return build


@pytest.fixture(scope="session")
def hinged_blocks(lattice_body):
    """Two blocks of n × n cells that meet at one corner: the second can turn about it."""

    def build(n):
        block = lattice_body((1.0, 1.0), n)
        last = len(block.points) - 1  # the upper right corner
        number = np.concatenate([[last], last + 1 + np.arange(last)])
        force = np.zeros((2 * last + 1, 2))
        force[-1] = [0.0, 0.1]
        return spring_network(
            np.concatenate([block.points, block.points[1:] + 1.0]),
            np.concatenate([block.springs, number[block.springs]]),
            np.tile(block.stiffness, 2),
            fixed=np.concatenate([block.fixed, np.zeros((last, 2), dtype=bool)]),
            force=force,
        )

    return build


def _flat_area(corners, normal):
    """Area of the convex hull of points in the plane across a normal."""
    _, _, axes = np.linalg.svd(normal[None])
    flat = (corners - corners.mean(axis=0)) @ axes[1:].T
    if flat.shape[1] == 1:
        return float(np.ptp(flat))
    try:
        return float(ConvexHull(flat).volume)
    except QhullError:  # the points lie on a line
        return 0.0


@pytest.fixture(scope="session")
def flat_area():
    """Area of the convex hull of points in the plane across a normal."""
    return _flat_area


def _split(shape):
    """Cells that fill a unit square or cube, as reference places (cells, corners, dim)."""
    kind = SHAPES[shape]
    corners = SHAPES["quad" if kind.dim == 2 else "hexahedron"].nodes
    if not kind.simplex:
        return corners[None]
    if kind.dim == 2:
        return corners[[[0, 1, 2], [0, 2, 3]]]
    paths = [(1, 2), (2, 3), (3, 7), (7, 4), (4, 5), (5, 1)]  # round the diagonal from 0 to 6
    return corners[[[0, a, b, 6] for a, b in paths]]


def _box_mesh(shape, counts=(2, 2, 2), size=(2.0, 1.0, 0.5), bend=lambda x: x, **names):
    """Mesh of a box in equal cells, bent by a function of points, with sides chosen by masks."""
    kind = SHAPES[shape]
    d = kind.dim
    counts, size = np.array(counts[:d]), np.array(size[:d])
    weights = kind.straight.values(kind.nodes)
    places = []
    for block in np.ndindex(*counts):
        for corners in _split(shape):
            places.append((weights @ corners + block) * 2)
    whole = np.rint(np.array(places)).astype(int)  # nodes are at corners and halfway
    keys, cells = np.unique(whole.reshape(-1, d), axis=0, return_inverse=True)
    x = keys / 2 / counts * size
    mesh = Mesh(bend(x), cells.reshape(len(places), -1), shape)
    sides = {name: mesh.surface[mask(x)[mesh.surface].all(axis=1)] for name, mask in names.items()}
    return mesh.named(sides)


def _left(x):
    return x[:, 0] == 0


def _right(x):
    return np.abs(x[:, 0] - 2) < 1e-9


def _ring_mesh(shape, counts=(2, 4), inner=1.0, outer=2.0):
    """A quarter of a ring: along x the radius, along y the angle."""

    def bend(x):
        r, angle = inner + (outer - inner) * x[:, 0] / 2, np.pi / 2 * x[:, 1]
        rest = x[:, 2:]
        return np.column_stack([r * np.cos(angle), r * np.sin(angle), rest])

    return _box_mesh(shape, (*counts, 1), bend=bend, inner=_left, outer=_right)


@pytest.fixture(scope="session")
def box_mesh():
    """Build a mesh of a box in equal cells; see `_box_mesh`."""
    return _box_mesh


@pytest.fixture(scope="session")
def ring_mesh():
    """Build a quarter of a ring; see `_ring_mesh`."""
    return _ring_mesh


def _quarter_ring(inner, outer, cells=12):
    """Quarter of an elliptic ring, half axes (x, y) in m, by cells with bent sides."""
    r, t = np.arange(5), np.arange(2 * cells + 1)
    angle = t * np.pi / (4 * cells)
    ray = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    ray[-1, 0] = 0.0
    half_axes = np.linspace(inner, outer, len(r))
    points = (ray[:, None] * half_axes).reshape(-1, 2)
    number = t[:, None] * len(r) + r
    a, b = np.meshgrid(np.arange(0, 2 * cells, 2), (0, 2), indexing="ij")
    at = [(0, 0), (0, 2), (2, 2), (2, 0), (0, 1), (1, 2), (2, 1), (1, 0), (1, 1)]
    nodes = np.stack([number[a + i, b + j].ravel() for i, j in at], axis=1)

    def side(line):
        return np.stack([line[:-2:2], line[2::2], line[1:-1:2]], axis=1)

    sides = {
        "inner": side(number[:, 0]),
        "outer": side(number[:, -1]),
        "bottom": side(number[0]),
        "left": side(number[-1]),
    }
    return Mesh(points, nodes, "quad9", sides)


def _on_rollers(mesh, material, *loads):
    supports = (Support(mesh.side("bottom"), (None, 0.0)), Support(mesh.side("left"), (0.0, None)))
    return Problem(mesh, material, supports, loads)


@pytest.fixture(scope="session")
def quarter_ring():
    """Build a quarter of an elliptic ring; see `_quarter_ring`."""
    return _quarter_ring


@pytest.fixture(scope="session")
def pressed_ring():
    """Ring of radii 1 and 2 m under 1 Pa from inside, E = 1 Pa."""
    mesh = _quarter_ring((1.0, 1.0), (2.0, 2.0))
    return _on_rollers(
        mesh,
        Isotropic(E=1.0, nu=1 / 3),
        Traction(mesh.side("inner"), lambda x: x / np.linalg.norm(x, axis=1)[:, None]),
    )
