"""Edges: what the end of a body does to a lattice, read off the pattern without solving a body.

A uniform strain is put on a few cells. Where it leaves forces, and along how many axes these places
are few, says at which order in the spacing a body's error falls: a layer at a side has a part of
order 1 of the body, what lies along an edge order 2, what lies at a corner order 3.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.linalg import lsmr

from msvalidate import kit
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.constants.homogenise import homogenise
from msvalidate.springs.constants.stiffness import voigt_directions
from msvalidate.springs.lattice import Lattice, Pattern, PatternLattice, fill
from msvalidate.springs.network import tangent

from . import cases, loading
from .cases import Case, Solid

CELLS = 3
"""Along each axis: one that meets no side, between two that do."""
LONG = 4
"""Cells along x where springs between inner cells are asked for."""
BALANCED = 1e-9
"""Force left on a point, over the largest load, that is rounding."""


def crossing(pattern: Pattern) -> kit.Mask:
    """Which springs (m,) run from a cell to the next across a side: no one cell holds both ends."""
    i, j = pattern.springs.T
    place = pattern.points / np.array(pattern.size)
    ends = np.stack([place[i], place[j] + pattern.image])
    low, high = ends.min(axis=0), ends.max(axis=0)
    cells = np.ceil(high - cases.STIFF) - np.floor(low + cases.STIFF)
    return np.asarray((cells > 1).any(axis=1))


def crosses(case: Case) -> bool:
    """Whether springs with stiffness run from a cell to the next across a side."""
    stiffness = case.pattern.stiffness(case.constants)
    return bool((crossing(case.pattern) & (stiffness > 0)).any())


def piece(pattern: Pattern, cells: tuple[int, ...]) -> PatternLattice:
    """A box of so many cells, spacing 1 m."""
    return fill(pattern, kit.Box(tuple((np.array(cells) * pattern.size).tolist())), cells)


def near_sides(lattice: Lattice, cell: kit.Array) -> kit.Index:
    """Number (n,) of axes along which each point lies less than a cell from a side."""
    room = cell * (1 - BALANCED)
    near = (lattice.points < room) | (lattice.points > np.array(cases.box_of(lattice).size) - room)
    return np.asarray(near.sum(axis=1))


def unbalanced_force(case: Case, solid: Solid, test: str) -> int | None:
    """Along how many axes the places where uniform stress leaves forces are few; None: nowhere.

    Forces inside, where points of a cell move apart, are along none: 0.
    """
    pattern = case.pattern
    lattice = piece(pattern, (CELLS,) * pattern.dim)
    body = cases.material(solid, case, lattice)
    a, b = loading.components(pattern.dim)[test]
    problem = loading.uniform(cases.box_of(lattice), body, (a, b), 1.0)
    network = lattice_network(problem, lattice, case.constants)
    strain = loading.compliances(body.C)[:, kit.VOIGT[pattern.dim].index((a, b))]
    move = lattice.points @ loading.gradient(strain, pattern.dim)
    left = network.force - (tangent(network, network.points) @ move.ravel()).reshape(move.shape)
    at = np.abs(left).max(axis=1) > BALANCED * np.abs(network.force).max()
    if not at.any():
        return None
    return int(near_sides(lattice, np.array(pattern.size))[at].min())


def locate_springs(axes_few: int | None, dim: int) -> str:
    """The same in words."""
    if axes_few is None:
        return "nowhere"
    return "corners" if axes_few == dim else ("inside", "sides", "edges")[axes_few]


def rebuild_lattice(case: Case) -> dict[str, object]:
    """One row of the table `crossing`: what other weights of springs could do."""
    # Where points move inside a cell forces of uniform strain are no measure of what is cut off.
    moves = cases.support_releases(homogenise, case)
    return case.head | {
        "left_over": "none" if moves else unbalanced_rest(case),
        "pull_error_rewired": rewired_error(case),
    }


def unbalanced_rest(case: Case) -> float:
    """Least force on points off the sides over all weights of springs near them, relative.

    Springs between points a cell or more from every side keep their weight; least in the sum of
    squares over these points and all unit strains, relative to the largest force of one spring.
    """
    pattern = case.pattern
    lattice = piece(pattern, (LONG, *(CELLS,) * (pattern.dim - 1)))
    edge = np.array(cases.box_of(lattice).size)
    on_side = ((lattice.points < BALANCED) | (lattice.points > edge - BALANCED)).any(axis=1)
    inner = (near_sides(lattice, np.array(pattern.size)) == 0)[lattice.springs].all(axis=1)
    vector = lattice.vectors
    normal = vector / np.linalg.norm(vector, axis=1)[:, None]
    k = np.array(case.constants)[lattice.kind] * lattice.factor
    # Force (m, d, strains) of each spring on its first point under unit strains.
    pull = (k[:, None] * vector)[:, :, None] * voigt_directions(normal)[:, None, :]
    matrix = _balance(lattice, pull)[np.flatnonzero(np.repeat(~on_side, pull[0].size))]
    found = lsmr(
        matrix[:, np.flatnonzero(~inner)],
        -matrix[:, np.flatnonzero(inner)].sum(axis=1),
        atol=1e-13,
        btol=1e-13,
        maxiter=20 * len(k),
    )
    return float(found[3] / np.abs(pull).max())


def _balance(lattice: Lattice, pull: kit.Array) -> coo_array:
    """Matrix (n·d·strains, m) from weights of springs to forces on points."""
    m, d, strains = pull.shape
    place = np.arange(d * strains).reshape(1, d, strains)
    row = lattice.springs.T[:, :, None, None] * d * strains + place
    column = np.broadcast_to(np.arange(m)[None, :, None, None], row.shape)
    value = np.stack([pull, -pull])
    shape = (len(lattice.points) * d * strains, m)
    return coo_array((value.ravel(), (row.ravel(), column.ravel())), shape=shape).tocsr()


def rewired_error(case: Case) -> float | str:
    """Error of the strain along a pull of two cells whose crossing springs are replaced.

    Springs of their kind and direction that stay in a cell take over their stiffness.
    """
    pattern = rewire_edges(case)
    if pattern is None:
        return "none"
    lattice = piece(pattern, (2,) * pattern.dim)
    body = cases.material(homogenise, case, lattice)
    try:
        S = loading.compliance(kit.solve_springs, lattice, case.constants, body)
    except kit.SolverError:  # the springs left do not hold its points
        return "mechanism"
    return float(S[0] * loading.modulus(body.C) - 1)


def rewire_edges(case: Case) -> Pattern | None:
    """The pattern without springs that cross, others like them stiffer; None: there are none."""
    pattern = case.pattern
    cross = crossing(pattern)
    factor = np.where(cross, 0.0, pattern.factor)
    alike = np.round(np.column_stack([pattern.kind, pattern.vectors]), 9)
    for like in np.unique(alike[cross], axis=0):
        same = (alike == like).all(axis=1)
        stay = same & ~cross
        if not stay.any():
            return None
        factor[stay] *= pattern.factor[same].sum() / pattern.factor[stay].sum()
    return replace(pattern, factor=factor)
