"""Named sides of a mesh in words: kind, size and centre."""

from __future__ import annotations

import numpy as np

from msvalidate.case.file.units import LENGTH
from msvalidate.problem import AXES, Array, Mesh
from msvalidate.problem.shapes import area_vectors
from msvalidate_check.text import number_text

KINDS = {2: ("line", "arc", "curve", "length"), 3: ("plane", "cylinder", "curved", "area")}
"""Number of axes -> flat, round and other kind, and name of the size."""
FLAT, ROUND = 1e-5, 2e-2
"""Limits of a plane and of a cylinder.

They are the variance of unit normals and the root mean square distance of nodes from a fitted
circle, relative to that from a line. Facets of curved sides are
approximations: their normals determine an axis to some 1e-3."""
ALONG = 1e-2
"""Largest other component of a unit vector that is named by an axis."""


def face_lines(mesh: Mesh, length: str) -> list[str]:
    """Describe each named side of a mesh in one line.

    Lengths are in a unit of `LENGTH`.

    Examples
    --------
    >>> from msvalidate import Mesh
    >>> square = [[0, 0], [0.02, 0], [0.02, 0.02], [0, 0.02]]  # m
    >>> mesh = Mesh(square, [[0, 1, 2, 3]], "quad", {"foot": [[0, 1]]})
    >>> face_lines(mesh, "mm")
    ['foot: line, facing -y, length 20 mm, centre (10, 0) mm']
    """
    lines, room = [], 1e3 * mesh.tolerance / LENGTH[length]
    for name in mesh.boundaries:
        places = mesh.side(name).places / LENGTH[length]
        x, area = area_vectors(places)
        size = np.linalg.norm(area, axis=2)
        centre = np.einsum("fq,fqd->d", size, x) / size.sum()
        unit = length if mesh.dim == 2 else f"{length}²"
        lines.append(
            f"{name}: {_kind(places, area.reshape(-1, mesh.dim), length)}, {KINDS[mesh.dim][3]} "
            f"{number_text(size.sum())} {unit}, centre {_components(centre, room)} {length}"
        )
    return lines


def _kind(places: Array, area: Array, length: str) -> str:
    """Kind of the surface or line through facets (f, k, d), its radius and its direction.

    The area vectors (q, d) are those of the facets. Normals of a plane are equal. Those of a
    cylinder lie in a plane, whose normal is the axis, and nodes lie on a circle in that plane. In
    |x|² = 2 c·x + (r² - |c|²), the centre c and the last term are the unknowns of a linear fit.
    """
    dim, size = area.shape[1], np.linalg.norm(area, axis=1, keepdims=True)
    flat, bent, other, _ = KINDS[dim]
    mean = area.sum(axis=0) / size.sum()
    off = area / size - mean
    spread, directions = np.linalg.eigh(off.T @ (size * off) / size.sum())
    if spread[-1] < FLAT:
        return f"{flat}, facing {_direction(mean)}"
    x = places.reshape(-1, dim) @ directions[:, -2:]
    x -= x.mean(axis=0)
    system = np.column_stack([2 * x, np.ones(len(x))])
    centre = np.linalg.lstsq(system, (x**2).sum(axis=1))[0][:2]
    radii = np.linalg.norm(x - centre, axis=1)
    curved = radii.std() > ROUND * np.sqrt(np.linalg.eigvalsh(np.cov(x.T))[0])
    if curved or (dim == 3 and spread[0] > FLAT):
        return other
    along = f", along {_direction(directions[:, 0]).strip('-')}" if dim == 3 else ""
    return f"{bent}, r {number_text(radii.mean())} {length}{along}"


def _direction(vector: Array) -> str:
    """Axis that a unit vector runs along, with its sign, or its components."""
    axis = int(np.abs(vector).argmax())
    if np.abs(np.delete(vector, axis)).max() < ALONG:
        return f"{'-' if vector[axis] < 0 else ''}{AXES[axis]}"
    return _components(vector)


def _components(vector: Array, room: float = 1e-6) -> str:
    """Components with four digits; those smaller than `room` are 0."""
    shown = np.where(np.abs(vector) < room, 0.0, vector)
    return f"({', '.join(f'{each:.4g}' for each in shown)})"
