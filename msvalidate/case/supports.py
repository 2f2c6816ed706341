"""What supports cost that no line of a cut lattice runs along, as at a bolt's hole.

Such a support holds all points of the cells that it runs through at its own value: an error of
first order in the spacing (`bodies.cut_network`). Springs held there as elasticity moves are
without it. Beyond the outline that motion is taken to go on evenly: at x = 2p - y, with p the
support's place nearest to x and y in the body, it is 2 g(p) - u(y), g being what is prescribed.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress

import numpy as np
import shapely

from msvalidate.bodies.cut_network import support_selector
from msvalidate.lattice import CutLattice
from msvalidate.lattice.outline import straight_pieces
from msvalidate.network import Network
from msvalidate.problem import Array, Box, Problem, ProblemError, Support
from msvalidate.problem.records import replace


def held_as(
    problem: Problem,
    lattice: CutLattice,
    network: Network,
    motion: Callable[[Array], Array],
    room: float,
) -> Network | None:
    """The network with supports off the lattice's lines held as a motion (n, d) -> (n, d) in m.

    None where that is nowhere other than it is by more than `room` (m). In space, of walls alone.
    """
    moved = network.displacement.copy()
    for support in problem.supports:
        on = support_selector(lattice)(support)
        off = np.flatnonzero(on & ~support.region.select(lattice.points, problem.domain.tolerance))
        if not len(off):
            continue
        with suppress(ProblemError):  # facets across z have no lines
            moved[off] = _moved(problem, support, lattice.points[off], moved[off], motion)
    other = np.abs(moved - network.displacement).max() > room
    return replace(network, displacement=moved) if other else None


def _moved(
    problem: Problem, support: Support, x: Array, held: Array, motion: Callable[[Array], Array]
) -> Array:
    """Displacement (n, d) in m of points x (n, d): `held`, but where a motion is known."""
    domain, place, value = problem.domain, x.copy(), held.copy()
    if isinstance(domain, Box):  # its sides lie on lines
        return value
    lines = shapely.multilinestrings(straight_pieces(support.region, domain))
    nearest = shapely.shortest_line(shapely.points(x[:, :2]), lines)
    place[:, :2] = shapely.get_coordinates(nearest)[1::2]
    inside = domain.contains(x)
    at = np.where(inside[:, None], x, 2 * place - x)
    known = inside | domain.contains(at)
    u = motion(at[known])
    for axis, entry in enumerate(support.displacement):
        if entry is not None:
            g = entry(place[known]) if callable(entry) else entry
            value[known, axis] = np.where(inside[known], u[:, axis], 2 * g - u[:, axis])
    return value
