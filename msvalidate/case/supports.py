"""What supports cost that no line of a cut lattice runs along, as at a bolt's hole.

Such a support holds all points of the cells that it runs through at its own value: an error of
first order in the spacing (`bodies.cut_network`). Springs held there as elasticity moves are
without it. Beyond the outline that motion is taken to go on evenly: at x = 2q - y, with q the
outline's place nearest to x and y in the body, it is 2 u(q) - u(y).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import shapely

from msvalidate.bodies.cut_network import support_selector
from msvalidate.lattice import CutLattice
from msvalidate.lattice.outline import outline
from msvalidate.network import Network
from msvalidate.problem import Array, Box, Problem, ProblemError
from msvalidate.problem.records import replace

WITHIN = 1e-3
"""Part of a point's distance by which q lies in the body: curves are drawn by straight lines."""


def held_as(
    problem: Problem,
    lattice: CutLattice,
    network: Network,
    motion: Callable[[Array], Array],
    room: float,
) -> Network | None:
    """The network with supports off the lattice's lines held as a motion (n, d) -> (n, d) in m.

    None where that is nowhere other than it is by more than `room` (m): of boxes, whose sides lie
    on lines, and of solids but for walls of prisms.
    """
    domain, x, off = problem.domain, lattice.points, np.zeros(len(lattice.points), dtype=bool)
    if isinstance(domain, Box):
        return None
    for support in problem.supports:
        off |= support_selector(lattice)(support) & ~support.region.select(x, domain.tolerance)
    try:
        side = shapely.boundary(outline(domain))
    except ProblemError:  # of no prism
        return None
    step = np.zeros(x[off].shape)
    nearest = shapely.shortest_line(shapely.points(x[off, :2]), side)
    step[:, :2] = shapely.get_coordinates(nearest)[1::2] - x[off, :2]
    inside = lattice.inside[off]
    step[inside] = 0.0
    near, far = x[off] + (1 + WITHIN) * step, x[off] + 2 * step
    known = inside | (domain.contains(near) & domain.contains(far))
    u = network.displacement[off]
    at, beyond = motion(near[known]), motion(far[known])
    u[known] = at + (1 + WITHIN) / (1 - WITHIN) * (at - beyond)  # on the line through both
    moved = network.displacement.copy()
    moved[off] = np.where(network.held[off], u, moved[off])
    other = np.abs(moved - network.displacement).max() > room
    return replace(network, displacement=moved) if other else None
