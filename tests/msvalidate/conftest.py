"""What several test files share: random networks, independent results, bodies on a lattice."""

from __future__ import annotations

import json
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from hypothesis import strategies as st
from scipy.spatial import Delaunay

from msvalidate.body import lattice_network
from msvalidate.lattice import square
from msvalidate.network import spring_network
from msvalidate.problem import Box, Isotropic, Problem, Support
from msvalidate.volumes import Volumes

SPRINGS = Path(__file__).parents[1] / "data" / "springs"


@st.composite
def _network_and_position(draw, *, stressed):
    """Draw a jittered grid joined by Delaunay edges or random pairs, and a position nearby.

    Cells may resist a change of volume: the grid's boxes, or simplices between its points.

    Points start 1 m apart and move by less than 0.4 m in all, so no spring comes near length zero.
    """
    dim = draw(st.sampled_from([2, 3]))
    sides = draw(st.tuples(*[st.integers(2, 4 if dim == 2 else 3)] * dim))
    joined = draw(st.sampled_from(["Delaunay", "pairs"]))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))

    grid = np.stack(np.meshgrid(*map(np.arange, sides), indexing="ij"), axis=-1).reshape(-1, dim)
    points = grid + rng.uniform(-0.3, 0.3, grid.shape)
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
    return network, points + rng.uniform(-0.1, 0.1, points.shape)


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
        cells = cells[np.abs(np.linalg.det(edges)) > 0.05]  # slivers have no stiffness to speak of
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
            held=held,
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
            held=np.concatenate([block.held, np.zeros((last, 2), dtype=bool)]),
            force=force,
        )

    return build
