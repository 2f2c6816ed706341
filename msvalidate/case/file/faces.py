"""Named sides of a mesh in words: kind, size and centre, by which a reader finds them."""

from __future__ import annotations

import numpy as np

from msvalidate.case.file.units import LENGTH
from msvalidate.problem import AXES, Array, Mesh
from msvalidate.problem.shapes import area_vectors
from msvalidate_check.text import number_text

FLAT, ROUND = 1e-5, 2e-2
"""Maximum variance of unit normals on a plane, and distance of nodes from a fitted circle.

The distance is a root mean square relative to the size of the side. Facets of curved sides are
approximations: their normals determine an axis to some 1e-3."""
ALONG = 1e-2
"""Largest other component of a unit vector that is named by an axis."""


def face_lines(mesh: Mesh, length: str) -> list[str]:
    """Describe each named side of a mesh in one line, with lengths in a unit of `LENGTH`.

    Examples
    --------
    >>> from msvalidate import Mesh
    >>> square = [[0, 0], [0.02, 0], [0.02, 0.02], [0, 0.02]]  # m
    >>> mesh = Mesh(square, [[0, 1, 2, 3]], "quad", {"foot": [[0, 1]]})
    >>> face_lines(mesh, "mm")
    ['foot: line, facing -y, length 20 mm, centre (10, 0) mm']
    """
    lines = []
    for name in mesh.boundaries:
        places = mesh.side(name).places / LENGTH[length]
        x, area = area_vectors(places)
        size = np.linalg.norm(area, axis=2)
        centre = np.einsum("fq,fqd->d", size, x) / size.sum()
        measure = f"length {number_text(size.sum())} {length}"
        if mesh.dim == 3:
            measure = f"area {number_text(size.sum())} {length}²"
        kind = _kind(places, area.reshape(-1, mesh.dim), length)
        lines.append(f"{name}: {kind}, {measure}, centre {_components(centre)} {length}")
    return lines


def _kind(places: Array, area: Array, length: str) -> str:
    """Kind of the surface or line through facets (f, k, d), its radius and its direction.

    The area vectors (q, d) are those of the facets. Normals of a plane are equal. Those of
    cylinders and cones lie in a plane, whose normal is the axis, and those of a cylinder are
    perpendicular to the axis.
    """
    dim, size = area.shape[1], np.linalg.norm(area, axis=1, keepdims=True)
    mean = area.sum(axis=0) / size.sum()
    off = area / size - mean
    spread, directions = np.linalg.eigh(off.T @ (size * off) / size.sum())
    if spread[-1] < FLAT:
        return f"{'plane' if dim == 3 else 'line'}, facing {_direction(mean)}"
    nodes = np.unique(places.reshape(-1, dim), axis=0)
    if dim == 2:
        radius = _radius(nodes)
        return f"arc, r {number_text(radius)} {length}" if radius else "curve"
    axis, across = directions[:, 0], directions[:, 1:]
    radius = _radius(nodes @ across)
    along = f"along {_direction(axis).strip('-')}"
    if spread[0] < FLAT and abs(mean @ axis) >= ALONG:
        return f"cone, {along}"
    if spread[0] < FLAT and radius:
        return f"cylinder, r {number_text(radius)} {length}, {along}"
    radius = _radius(nodes)
    return f"sphere, r {number_text(radius)} {length}" if radius else "curved"


def _radius(points: Array) -> float:
    """Radius of the circle or sphere through points (n, d); 0 if they lie on none.

    |x|² = 2 c·x + (r² - |c|²) is linear in the centre c and the constant.
    """
    x = points - points.mean(axis=0)
    squared = (x**2).sum(axis=1)
    *centre, _ = np.linalg.lstsq(np.column_stack([2 * x, np.ones(len(x))]), squared)[0]
    distance = np.linalg.norm(x - centre, axis=1)
    room = ROUND * np.sqrt(np.linalg.eigvalsh(x.T @ x / len(x))[0])
    return float(distance.mean()) if distance.std() < room else 0.0


def _direction(vector: Array) -> str:
    """Axis that a unit vector runs along, with its sign, or its components."""
    axis = int(np.abs(vector).argmax())
    if np.abs(np.delete(vector, axis)).max() < ALONG:
        return f"{'-' if vector[axis] < 0 else ''}{AXES[axis]}"
    return _components(vector)


def _components(vector: Array) -> str:
    """Components with four digits; those below a millionth of the largest are 0."""
    shown = np.where(np.abs(vector) < 1e-6 * np.abs(vector).max(), 0.0, vector)
    return f"({', '.join(f'{each:.4g}' for each in shown)})"
