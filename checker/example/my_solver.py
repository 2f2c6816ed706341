"""A solver to be judged, put yours in its place: linear triangles or tetrahedra, a dense matrix."""

import numpy as np


def solve(points, cells, E, nu, state, thickness, force, held, value):
    """Displacement (n, d) in m of an elastic body at rest, small strains.

    Parameters
    ----------
    points
        (n, d), m.
    cells
        (m, d + 1) points of each triangle or tetrahedron.
    E, nu
        Pa; 1.
    state
        "plane_stress", "plane_strain" or "space".
    thickness
        m; 1 in space.
    force
        (n, d), N.
    held, value
        (n, d) which components are prescribed, and to what (m).
    """
    lam, mu = E * nu / ((1 + nu) * (1 - 2 * nu)), E / (2 * (1 + nu))
    if state == "plane_stress":
        lam = 2 * lam * mu / (lam + 2 * mu)
    n, d = points.shape
    stiffness = np.zeros((n, d, n, d))
    for cell in cells:
        edges = points[cell[1:]] - points[cell[0]]
        slopes = np.linalg.inv(edges).T  # of the shape functions of the corners but the first
        G = np.vstack([-slopes.sum(axis=0), slopes])
        volume = thickness * abs(np.linalg.det(edges)) / (2 if d == 2 else 6)
        K = lam * np.einsum("ai,bj->aibj", G, G) + mu * np.einsum("aj,bi->aibj", G, G)
        K += mu * np.einsum("ak,bk,ij->aibj", G, G, np.eye(d))
        stiffness[np.ix_(cell, range(d), cell, range(d))] += volume * K
    K, free = stiffness.reshape(n * d, n * d), ~held.ravel()
    u = np.where(held, value, 0.0).ravel()
    load = force.ravel() - K @ u
    u[free] = np.linalg.solve(K[np.ix_(free, free)], load[free])
    return u.reshape(n, d)
