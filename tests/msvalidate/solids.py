"""Solids as meshes: bars, turned and in any shape of cells, and balls of curved tetrahedra."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from msvalidate.problem import SHAPES, Mesh

SIDES = (("left", "right"), ("bottom", "top"), ("back", "front"))
EDGES = np.array([(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)])
EIGHTHS = (
    *((0, 4, 6, 7), (4, 1, 5, 8), (6, 5, 2, 9), (7, 8, 9, 3)),
    *((4, 6, 7, 8), (4, 6, 5, 8), (6, 7, 8, 9), (6, 5, 8, 9)),
)


def rotation(x, y, z):
    """Rotation (3, 3) about the axes in turn, by angles in rad."""
    return Rotation.from_euler("xyz", [x, y, z]).as_matrix()


def bar(size, parts, shape="tetra", turn=None, shift=(0.0, 0.0, 0.0)):
    """A box of so many parts a side, turned, then shifted; its sides have the names of a box's."""
    turn = np.eye(3) if turn is None else turn
    axes = [np.linspace(0, length, n + 1) for length, n in zip(size, parts, strict=True)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    number = np.arange(len(points)).reshape(np.add(parts, 1))
    nx, ny, nz = parts
    ring = [(0, 0), (1, 0), (1, 1), (0, 1)]
    cells = np.stack(
        [number[i : nx + i, j : ny + j, k : nz + k].ravel() for k in (0, 1) for i, j in ring],
        axis=1,
    )
    if shape.startswith("tetra"):
        six = [(0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6)]
        cells = cells[:, six].reshape(-1, 4)
    points, cells = with_middles(points, cells, shape)
    mesh = Mesh(points @ turn.T + shift, cells, shape)
    at = points[mesh.surface]
    named = {
        name: mesh.surface[(np.abs(at[..., axis] - end * size[axis]) < 1e-9).all(axis=1)]
        for axis, names in enumerate(SIDES)
        for end, name in enumerate(names)
    }
    return mesh.named(named)


def with_middles(points, cells, shape):
    """Points and cells with the nodes between corners that a shape has."""
    kind = SHAPES[shape]
    places = np.einsum("qk,ckd->cqd", kind.straight.values(kind.nodes), points[cells])
    flat = places.reshape(-1, 3)
    size = np.ptp(points, axis=0).max()
    _, first, which = np.unique(
        np.rint(flat / size * 1e9), axis=0, return_index=True, return_inverse=True
    )
    return flat[first], which.reshape(len(cells), -1)


def ball(halvings, radius=1.0):
    """A ball of 8·8^halvings tetra10 cells: an octahedron's, |x|₁ = r moved to |x|₂ = r."""
    points = np.array([(0, 0, 0), *np.eye(3), *-np.eye(3)], dtype=float)
    cells = np.array([(0, a, b, c) for a in (1, 4) for b in (2, 5) for c in (3, 6)])
    for _ in range(halvings):
        points, ten = with_middles(points, cells, "tetra10")
        cells = ten[:, EIGHTHS].reshape(-1, 4)
    points, ten = with_middles(points, cells, "tetra10")
    corners = points[ten[:, :4]]
    back = np.linalg.det(corners[:, 1:] - corners[:, :1]) < 0
    ten[back] = ten[back][:, [0, 2, 1, 3, 6, 5, 4, 7, 9, 8]]
    length = np.linalg.norm(points, axis=1)
    scale = np.abs(points).sum(axis=1) / np.where(length, length, 1.0)
    mesh = Mesh(radius * points * scale[:, None], ten, "tetra10")
    return mesh.named({"skin": mesh.surface})
