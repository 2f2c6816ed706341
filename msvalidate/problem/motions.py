"""Rigid-body motions that the supports of a body leave free."""

from __future__ import annotations

import numpy as np

from msvalidate.problem.arrays import AXES, Array, Mask
from msvalidate.problem.errors import ProblemError


def refuse_free_motions(name: str, points: Array, fixed: Mask) -> None:
    """Raise `ProblemError`, naming them, if the held components leave the body rigid motions."""
    motions = free_motions(points, fixed)
    if motions:
        raise ProblemError(
            f"{name}: the supports leave the body free: {'; '.join(motions)}. "
            "Hold one more component against each"
        )


def free_motions(points: Array, fixed: Mask) -> list[str]:
    """Name the rigid-body motions u(x) = t + w×x that the supports leave free.

    Held are components (n, d) at places (n, d) in m.
    """
    d = points.shape[1]
    middle = points.mean(axis=0) if len(points) else np.zeros(d)
    somewhere = fixed.any(axis=1)
    points, fixed = points[somewhere], fixed[somewhere]
    # Measured by what is held: two supports side by side hold a large body, if only just.
    centre = points.mean(axis=0) if len(points) else middle
    scale = float(np.abs(points - centre).max()) if len(points) else 1.0
    modes = rigid_motions((points - centre) / (scale or 1.0))
    stiffness = modes[fixed].T @ modes[fixed]
    eigenvalues, vectors = np.linalg.eigh(stiffness)
    free = vectors[:, eigenvalues <= 1e-12 * max(float(eigenvalues[-1]), 1.0)]
    return _describe_motions(free, centre, scale or 1.0, middle)


def rigid_motions(points: Array) -> Array:
    """Translations and infinitesimal rotations of points (n, d): (n, d, 3) or (n, d, 6)."""
    n, d = points.shape
    translations = np.broadcast_to(np.eye(d), (n, d, d))
    if d == 2:
        rotations = np.stack([-points[:, 1], points[:, 0]], axis=1)[:, :, None]
    else:
        rotations = np.stack([np.cross(axis, points) for axis in np.eye(3)], axis=2)
    return np.concatenate([translations, rotations], axis=2)


def _describe_motions(free: Array, centre: Array, scale: float, middle: Array) -> list[str]:
    """Describe a space of rigid motions, columns (t, w) about `centre` in units of `scale`."""
    d = len(centre)
    names = []
    _, sizes, rows = np.linalg.svd(free[d:])
    rank = int((sizes > 1e-6).sum())
    for direction in _along_axes(free[:d] @ rows[rank:].T):
        names.append(f"translation along {_direction(direction)}")
    for spin in _along_axes(free[d:] @ rows[:rank].T):
        shift = free[:d] @ np.linalg.lstsq(free[d:], spin, rcond=None)[0]
        if d == 2:
            pivot = centre + scale * np.array([-shift[1], shift[0]]) / spin[0]
            names.append(f"rotation about {format_point(pivot)}")
        else:
            pivot = centre + scale * np.cross(spin, shift) / (spin @ spin)
            pivot = pivot + spin * (spin @ (middle - pivot)) / (spin @ spin)  # nearest the middle
            names.append(
                f"rotation about the axis along {_direction(spin)} through {format_point(pivot)}"
            )
    return names


def _along_axes(span: Array) -> list[Array]:
    """Basis of the column space of `span`, coordinate axes first where they lie in it."""
    if not span.shape[1]:
        return []
    vectors, sizes, _ = np.linalg.svd(span, full_matrices=False)
    space = vectors[:, sizes > 1e-6]
    basis = [e for e in np.eye(len(span)) if np.linalg.norm(space.T @ e) > 1 - 1e-6]
    if len(basis) < space.shape[1]:
        taken = np.array(basis).reshape(-1, len(span))
        rest = np.linalg.svd(space - taken.T @ (taken @ space), full_matrices=False)[0]
        basis += list(rest.T[: space.shape[1] - len(basis)])
    return basis


def _direction(vector: Array) -> str:
    axis = int(np.abs(vector).argmax())
    if abs(abs(vector[axis]) - np.linalg.norm(vector)) < 1e-6:
        return AXES[axis]
    return format_point(vector / vector[axis])


def format_point(point: Array) -> str:
    """Coordinates (m) of a point as a message shows them."""
    return f"({', '.join(f'{value + 0.0:.6g}' for value in np.round(point, 12))})"
