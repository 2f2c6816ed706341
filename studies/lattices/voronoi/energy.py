"""Third route: the tensor of a random network by least squares, without any stiffness matrix.

Under a uniform strain e and periodic moves u the elongations are B u + S e. At rest u makes
|√k (B u + S e)|² least, and what is left is the energy e·C e V.
"""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np

from msvalidate import kit
from msvalidate.springs.lattice import STIFFNESS_RULES
from msvalidate.springs.lattice.tessellation import Tessellation
from msvalidate.springs.lattice.voronoi import pattern_of_tessellation

from ..cases import Solid
from .networks import draw_network

COUNTS = {2: 64, 3: 30}
"""Few points, as the least squares are dense."""
SEED = 7
CASES = list(product(COUNTS, STIFFNESS_RULES))
RULE = kit.Rule(
    "small random solids: tensor from that by least squares, relative", 1e-9, "1",
    "the same minimum of the energy by two routes; left is the rounding of a linear solve, 1e-16 "
    "times a condition number of up to 1e6, and least squares have its root",
    table="random_energy", value="squares_error",
)  # fmt: skip


def compare_tensors(solid: Solid, case: tuple[int, str]) -> dict[str, Any]:
    """One row of the table `random_energy`: a solid's tensor against least squares."""
    dim, rule = case
    cells = draw_network((dim, "uniform", COUNTS[dim], SEED))
    pattern = pattern_of_tessellation(cells, rule)
    found = solid(pattern, (1.0,))
    exact = energy_tensor(cells, pattern.stiffness((1.0,)))
    size = np.abs(exact).max()
    return {
        "axes": dim,
        "point_set": "uniform",
        "stiffness": rule,
        "count": COUNTS[dim],
        "random_released": float(np.abs(found.affine - found.tensor).max() / size),
        "squares_error": float(np.abs(found.tensor - exact).max() / size),
    }


def energy_tensor(cells: Tessellation, stiffness: kit.Array) -> kit.Array:
    """Relaxed Voigt tensor of springs (m,): each spring one residual, points move as they like."""
    n, d = cells.points.shape
    length = np.linalg.norm(cells.vectors, axis=1)
    unit = cells.vectors / length[:, None]
    moves = np.zeros((len(length), n, d))
    rows = np.arange(len(length))
    np.add.at(moves, (rows, cells.springs[:, 1]), unit)
    np.add.at(moves, (rows, cells.springs[:, 0]), -unit)
    root = np.sqrt(stiffness)[:, None]
    strains = np.stack([length * unit[:, a] * unit[:, b] for a, b in kit.VOIGT[d]], axis=1)
    left, right = root * moves.reshape(len(length), -1), root * strains
    # The shortest of the best moves: a shift of all points stretches nothing.
    move, *_ = np.linalg.lstsq(left, -right, rcond=None)
    rest = right + left @ move
    return np.asarray(rest.T @ rest / cells.volume.sum())
