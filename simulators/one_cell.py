# SPDX-License-Identifier: MIT
"""Programs that put a whole body into one cell by design: their bodies held against such a cell.

Linear elements on the nodes' mesh predict nothing of these. One trilinear cell of the same law, its
stiffness integrated exactly, with its corners where those of the body's box are, does: what it
adds to elasticity is resolution, and what the program differs from it by is not explained.
"""

from __future__ import annotations

import numpy as np

from msvalidate.problem import SHAPES, Array
from msvalidate.simulators.exchange.protocol import Request

HEXAHEDRON = SHAPES["hexahedron"]
GAUSS = 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3)
PLACES = np.array(np.meshgrid(*[GAUSS] * 3)).reshape(3, -1).T
"""Two of Gauss's points along each axis: exact for squares of slopes on a box."""


def one_cell(request: Request, E: float, nu: float, mass: Array | None = None) -> Array:  # noqa: ARG001
    """(n, 3) m at the points of a box in one trilinear cell of E (Pa) and nu, small strains.

    Forces do on the cell the work that they do on its points; of weight each corner has an eighth,
    whatever masses points are said to have.
    A corner's component is held where the point there is.
    """
    points = request.mesh.points
    low, sides = points.min(axis=0), np.ptp(points, axis=0)
    weights = HEXAHEDRON.values((points - low) / sides)  # (n, 8)
    corner = weights.argmax(axis=0)
    K = _stiffness(sides, E, nu)
    weight = request.material.density * sides.prod() / 8 * request.gravity
    load = (weights.T @ request.force + weight).ravel()
    held, value = request.held[corner].ravel(), request.value[corner].ravel()
    move = np.where(held, value, 0.0)
    move[~held] = np.linalg.solve(K[np.ix_(~held, ~held)], (load - K @ move)[~held])
    return np.asarray(weights @ move.reshape(8, 3))


def _stiffness(sides: Array, E: float, nu: float) -> Array:
    """(24, 24) N/m of a box in one cell of Hooke's law."""
    mu, lam = E / 2 / (1 + nu), E * nu / (1 + nu) / (1 - 2 * nu)
    slopes = HEXAHEDRON.slopes(PLACES) / sides  # (q, k, 3)
    products = np.einsum("qka,qlb->kalb", slopes, slopes) / len(PLACES) * sides.prod()
    same = np.einsum("kclc->kl", products)
    K = lam * products + mu * products.transpose(0, 3, 2, 1)
    K += mu * np.einsum("kl,ab->kalb", same, np.eye(3))
    return np.asarray(K.reshape(24, 24))
