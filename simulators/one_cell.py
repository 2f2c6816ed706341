# SPDX-License-Identifier: MIT
"""Programs that put a whole body into one cell by design: their bodies held against such a cell.

Linear elements on the nodes' mesh predict nothing of these. One trilinear cell of the same law, its
stiffness integrated exactly, with its corners where those of the body's box are, does: what it
adds to elasticity is resolution, and what the program differs from it by is not explained.
"""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np

from msvalidate.problem import SHAPES, Array, Isotropic
from msvalidate.simulators.blocks import AtRest, at_rest_both_ways, elasticity_at
from msvalidate.simulators.causes import CAUSE
from msvalidate.simulators.factors import Factors
from msvalidate.simulators.judgement import Judgement
from msvalidate.simulators.moduli import SHOWN
from msvalidate.simulators.protocol import Request, Simulator

HEXAHEDRON = SHAPES["hexahedron"]
GAUSS = 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3)
PLACES = np.array(np.meshgrid(*[GAUSS] * 3)).reshape(3, -1).T
"""Two of Gauss's points along each axis: exact for squares of slopes on a box."""


def explain_by_one_cell(
    simulator: Simulator, settings: dict[str, Any], judged: Judgement, record: dict[str, Any]
) -> None:
    """Put into a record what one cell explains of its bodies, which are asked for once more.

    The state becomes "differs with cause" where the law was read to be the asked one and one cell
    explains all bodies.
    """
    reading = judged.reading
    if reading is None or reading.E is None or reading.nu is None or not reading.is_valid:
        return
    law = (reading.E, reading.nu)
    each = []
    for row in record["bodies"]:
        found = at_rest_both_ways(simulator, row["case"], row["mesh"], judged.asked, settings)
        each.append(one_cell_factors(found, law))
        row["factors"] = {name: float(f"{value:.8g}") for name, value in asdict(each[-1]).items()}
    off = abs(law[0] / judged.asked.E - 1), abs(law[1] - judged.asked.nu)
    if each and max(off) <= SHOWN and all(one.is_explained for one in each):
        worst = min(one.resolution for one in each)
        record["state"] = CAUSE
        record["causes"] = [f"resolution: one cell by design, down to {worst:.3g} of a body's move"]


def one_cell_factors(found: AtRest, law: tuple[float, float]) -> Factors:
    """Causes of an answer of one cell: law, resolution, and what is left. Its mass is a box's."""
    named, asked = found.case.named, found.request.material
    wanted = elasticity_at(found.case, 1.0, asked.nu)
    cell = one_cell(found.request, Isotropic(*law, "solid", asked.density))

    def size(move: Array) -> float:
        return float((move * wanted).sum() / (wanted * wanted).sum())

    own = size(elasticity_at(found.case, law[0] / asked.E, law[1]))
    away = np.linalg.norm(found.move - cell, axis=1).max() / np.linalg.norm(cell, axis=1).max()
    whole, at_cell = size(found.move[named]), size(cell[named])
    return Factors(whole, own, at_cell / own, 1.0, 1.0, whole / at_cell, float(away))


def one_cell(request: Request, material: Isotropic) -> Array:
    """(n, 3) m at the points of a box in one trilinear cell, small strains.

    Forces do on the cell the work that they do on its points; of weight each corner has an eighth.
    A corner's component is held where the point there is.
    """
    points = request.mesh.points
    low, sides = points.min(axis=0), np.ptp(points, axis=0)
    weights = HEXAHEDRON.values((points - low) / sides)  # (n, 8)
    corner = weights.argmax(axis=0)
    K = _stiffness(sides, material)
    weight = material.density * sides.prod() / 8 * request.gravity
    load = (weights.T @ request.force + weight).ravel()
    held, value = request.held[corner].ravel(), request.value[corner].ravel()
    move = np.where(held, value, 0.0)
    move[~held] = np.linalg.solve(K[np.ix_(~held, ~held)], (load - K @ move)[~held])
    return np.asarray(weights @ move.reshape(8, 3))


def _stiffness(sides: Array, material: Isotropic) -> Array:
    """(24, 24) N/m of a box in one cell of Hooke's law."""
    E, nu = material.E, material.nu
    mu, lam = E / 2 / (1 + nu), E * nu / (1 + nu) / (1 - 2 * nu)
    slopes = HEXAHEDRON.slopes(PLACES) / sides  # (q, k, 3)
    products = np.einsum("qka,qlb->kalb", slopes, slopes) / len(PLACES) * sides.prod()
    same = np.einsum("kclc->kl", products)
    K = lam * products + mu * products.transpose(0, 3, 2, 1)
    K += mu * np.einsum("kl,ab->kalb", same, np.eye(3))
    return np.asarray(K.reshape(24, 24))
