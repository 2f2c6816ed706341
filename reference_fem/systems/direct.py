"""Factor of a mesh's stiffness: the order of its unknowns, and what it takes, by its corners."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_matrix

from msvalidate.linear_algebra.choice import Choice, choose
from msvalidate.linear_algebra.factor import (
    Factor,
    NoMemoryError,
    factorise,
    inverse_iteration,
)
from msvalidate.linear_algebra.order import (
    Dissection,
    free_unknowns,
    nested_dissection,
    pairs_in,
)
from msvalidate.problem import Array, Index, Mask, SolverError, format_point
from reference_fem.mesh.discretisation import Discretisation

NO_STIFFNESS = 1e-14
"""Strain energy of a mode that is rounding, relative to what its components cost one by one."""


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


def favours_factor(body: Discretisation) -> bool:
    """Return True if "auto" starts with a factor."""
    return not body.in_one_piece or choose_solver(body)[0].name == "direct"


def factor_of(
    body: Discretisation, A: csr_matrix, order: Index, free: Index, name: str = "superlu"
) -> Factor:
    """Factor of the free part (f, f) of a body's stiffness, its unknowns taken in an order (f,).

    `free` (f,) are the numbers of its components. Cells that hang together by whole sides have no
    motion without strain, so rounding alone makes such a matrix singular: then it is mended.

    Raises
    ------
    SolverError
        If part of the body can move without strain, or memory does not suffice.
    """
    if not np.isfinite(A.data).all():
        return Factor(name, lambda load: np.full(load.shape, np.nan))  # which no residual allows
    mend = body.in_one_piece and bool((A.diagonal() > 0).all())
    try:
        factor = factorise(A, order, name, mend=mend)
    except NoMemoryError as error:
        raise MemoryError from error
    except RuntimeError as error:
        raise SolverError(
            "finite elements: the stiffness is singular: a part of the body can move without "
            "strain; join the parts or hold each"
        ) from error
    if not body.in_one_piece:
        # A zero-energy mode hides from the residual, but not from two inverse iterations.
        mode = inverse_iteration(factor.solve, A.shape[0])
        if abs(mode @ (A @ mode)) <= NO_STIFFNESS * (mode**2 @ A.diagonal()):
            place = body.points[free[np.abs(mode).argmax()] % len(body.points)]
            raise SolverError(
                f"finite elements: the part of the body around {format_point(place)} can move "
                "without strain; join it to the rest by an edge, or hold it"
            )
    return factor
