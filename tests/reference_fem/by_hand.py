"""What several tests of elements share: cells with middle nodes, Hooke's law, moments."""

from __future__ import annotations

import numpy as np

from reference_fem.mesh.elements import ELEMENTS

# C16 and C26 couple stretch and shear: a swapped index cannot hide behind a zero.
SKEW = np.array([[3.0, 0.9, 0.5], [0.9, 2.0, -0.3], [0.5, -0.3, 1.1]])


def compliance(E, nu):
    """Hooke's law as engineers write it: strains (6,) from stresses (6,)."""
    S = np.diag([1.0, 1, 1, *[2 * (1 + nu)] * 3])
    S[:3, :3] -= nu * (1 - np.eye(3))
    return S / E


def with_middles(corners, cells, element):
    """Points and cells in VTK order: edge midpoints after the corners, the mean of them last."""
    corners, cells = np.array(corners, dtype=float), np.array(cells)
    kind = ELEMENTS[element]
    if kind.simplex:
        cells = np.vstack([cells[:, [0, 1, 2]], cells[:, [0, 2, 3]]])
    if kind.degree == 1:
        return corners, cells
    edges = np.sort(np.stack([cells, np.roll(cells, -1, axis=1)], axis=2), axis=2)
    ends, which = np.unique(edges.reshape(-1, 2), axis=0, return_inverse=True)
    middles = [corners, corners[ends].mean(axis=1)]
    columns = [cells, len(corners) + which.reshape(cells.shape)]
    if any(len(amid) == 4 for amid in kind.middles):
        middles.append(corners[cells].mean(axis=1))
        columns.append(len(corners) + len(ends) + np.arange(len(cells))[:, None])
    return np.vstack(middles), np.hstack(columns)


def moment(points, force):
    """Of forces (n, d) at points (n, d), about the origin: a number in the plane, (3,) in space."""
    if points.shape[1] == 2:
        return float((points[:, 0] * force[:, 1] - points[:, 1] * force[:, 0]).sum())
    return np.cross(points, force).sum(axis=0)
