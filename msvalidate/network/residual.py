"""What a residual force is measured by: the forces that meet at a point, and rounding."""

from __future__ import annotations

import math

import numpy as np

from msvalidate.network import Network, spring_vectors
from msvalidate.network.laws import volumes as cells
from msvalidate.problem import Array, SolverError
from msvalidate.problem.checks import require_type


def force_scale(network: Network, position: Array) -> float:
    """Largest sum of force magnitudes (N) at a free point: the scale of a residual.

    Springs between points that are held take no part in any balance and do not count.

    Raises
    ------
    SolverError
        If the forces are beyond all numbers: any residual would be small beside them.
    """
    _, length = spring_vectors(network, position)
    with np.errstate(over="ignore", invalid="ignore"):  # refused below
        tension = np.abs(network.stiffness * (length - network.rest_length))
        met = np.linalg.norm(network.force, axis=1)
        for end in (0, 1):
            met = met + np.bincount(network.springs[:, end], tension, len(position))
        met = met + network.of_cells(cells.force_magnitudes, position)
    scale = float(met[~network.held.all(axis=1)].max(initial=0.0))
    if not math.isfinite(scale):
        raise SolverError(
            "network: forces beyond all numbers meet at a point; choose units that give ordinary "
            "forces, or reduce the load"
        )
    return scale


def force_roundoff(network: Network, reach: float | None = None) -> Array:
    """Force (n, 1) in N below which the residual at a point is rounding.

    An eps of lengths and of what is added to them, times the springs that meet there. `reach` (m)
    is the largest number added: by default a coordinate; where displacements are kept apart from
    reference positions, a displacement.

    Source: rounding of sums, [Higham2002], chapter 4.
    """
    require_type("network", network, Network)
    reach = float(np.abs(network.points).max()) if reach is None else reach
    pull = network.stiffness * (reach + network.rest_length)
    met = 1.0 * np.bincount(network.springs.ravel(), np.repeat(pull, 2), len(network.points))
    met = met + network.of_cells(cells.roundoff_magnitudes, reach)
    return np.asarray(np.finfo(float).eps * met)[:, None]
