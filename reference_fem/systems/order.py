"""Order of a mesh's unknowns for a factor, and what a factor takes: by its corners."""

from __future__ import annotations

import numpy as np

from msvalidate.linear_algebra.choice import Choice, choose
from msvalidate.linear_algebra.order import (
    Dissection,
    free_unknowns,
    nested_dissection,
    pairs_in,
)
from msvalidate.problem import Array, Index, Mask
from reference_fem.mesh.discretisation import Discretisation


def elimination_order(body: Discretisation, held: Mask, found: Dissection | None = None) -> Index:
    """Free components (f,) in the order to eliminate them, as positions among the free ones.

    Parameters
    ----------
    body
        The mesh.
    held
        Components (n, d) that are held; the free ones are counted component-major.
    found
        Of its corners, where it is at hand.
    """
    return free_unknowns(node_order(body, found), held, by_component=True)


def node_order(body: Discretisation, found: Dissection | None = None) -> Index:
    """Nodes (n,) in the order of nested dissection.

    No cell holds corners of both halves, so a node between some corners, as on an edge, belongs to
    the piece of the first of these to be eliminated, and goes with it.
    """
    corners, cells = _corner_graph(body)
    order = (found or nested_dissection(corners, pairs_in(cells))).order
    rank = np.empty(len(corners), dtype=np.intp)
    rank[order] = np.arange(len(corners))
    of_cells, of_nodes = rank[cells], np.empty(len(body.points), dtype=np.intp)
    for node, between in enumerate(body.element.means != 0):
        of_nodes[body.cells[:, node]] = of_cells[:, between].min(axis=1)
    return np.argsort(of_nodes, kind="stable")


def choose_solver(body: Discretisation) -> tuple[Choice, Dissection]:
    """A factor or multigrid, and what a factor takes as far as it was counted."""
    corners, cells = _corner_graph(body)
    entries = body.dim**2 * len(body.pattern.columns)
    return choose(corners, pairs_in(cells), body.dim, entries, _wide(body))


def factor_entries(body: Discretisation) -> float:
    """Entries that one triangle of a factor takes."""
    corners, cells = _corner_graph(body)
    found = nested_dissection(corners, pairs_in(cells))
    return (body.dim * _wide(body)) ** 2 * found.entries


def _wide(body: Discretisation) -> float:
    """Nodes of a layer over its corners."""
    return float((len(body.points) / len(body.vertices)) ** (1 - 1 / body.dim))


def _corner_graph(body: Discretisation) -> tuple[Array, Index]:
    """Places (v, d) of corners, and the numbers (c, k) of those of each cell."""
    cells = np.searchsorted(body.vertices, body.cells[:, : body.element.corners])
    return body.points[body.vertices], cells
