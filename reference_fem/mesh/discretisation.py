"""Meshes and elements: what a body is divided into, and the integrals that only that decides."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
import skfem
from numpy.typing import ArrayLike
from scipy.sparse import coo_array, csr_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from msvalidate.problem import Array, Index, Mask, ProblemError
from msvalidate.problem.checks import finite_coordinates, require_one_of
from msvalidate.problem.records import ReadOnly, dataclass
from reference_fem.effort import fits_in_memory
from reference_fem.mesh.assembly import SparsityPattern, gradient_products, sparsity_pattern
from reference_fem.mesh.checks import checked_cells, refuse_overlap, refuse_repeated
from reference_fem.mesh.curved import is_bent, refuse_folded
from reference_fem.mesh.elements import CURVED_ORDER, ELEMENTS, Element
from reference_fem.mesh.interpolation import incident, locate
from reference_fem.mesh.maps import Cells, curved_cells, straight_cells

AT_NODE = 1e-13
"""A point this close to a node, relative to the body's size, is the node."""
COINCIDENT = 1e-8
"""Two points this close, relative to the body's size, lie in one place."""


@dataclass(frozen=True, eq=False)
class Discretisation(ReadOnly):
    """Points and cells of one element, with the scalar basis that belongs to them.

    Parameters
    ----------
    points
        (n, d) positions (m) of all nodes, in the caller's numbering.
    cells
        (c, nodes) nodes of each cell in VTK order.
    element
        The element.
    basis
        scikit-fem basis for one component.
    node
        (n,) node of each degree of freedom of the basis.
    curved
        Whether a cell has curved sides.
    """

    points: Array
    cells: Index
    element: Element
    basis: Any
    node: Index
    curved: bool = False

    @property
    def dim(self) -> int:
        """Number of axes."""
        return int(self.points.shape[1])

    @property
    def faces(self) -> Index:
        """Corners (c, faces, 2, 3 or 4) of the sides of each cell, seen from outside."""
        return np.asarray(self.cells[:, self.element.faces])

    @cached_property
    def surface(self) -> Index:
        """Nodes (f, k) of the sides that belong to one cell alone, seen from outside.

        Corners first, then mid-sides in the same turn, then the centre.
        """
        each = self.faces.reshape(-1, self.faces.shape[2])
        _, first, uses = np.unique(
            np.sort(each, axis=1), axis=0, return_index=True, return_counts=True
        )
        facets = self.cells[:, self.element.facets]
        return np.asarray(facets.reshape(-1, facets.shape[2])[np.sort(first[uses == 1])])

    @cached_property
    def vertices(self) -> Index:
        """Nodes (v,) that are corners of cells, in rising order."""
        return np.flatnonzero(np.bincount(self.cells[:, : self.element.corners].ravel()))

    @cached_property
    def in_one_piece(self) -> bool:
        """Return True if all cells are connected through whole sides.

        Its cells bend for no motion but rigid ones, and two with a common side move as one: such a
        body has no mechanism, and supports that stop its rigid motions hold it.
        """
        faces = self.faces
        # In space three corners of a face tell it from all others.
        each = np.sort(faces.reshape(-1, faces.shape[2]), axis=1)[:, : self.dim]
        number = each @ len(self.points) ** np.arange(self.dim)
        order = np.argsort(number, kind="stable")
        (shared,) = (np.diff(number[order]) == 0).nonzero()
        cell = order // faces.shape[1]
        size = len(self.cells)
        pairs = (np.ones(len(shared)), (cell[shared], cell[shared + 1]))
        graph = coo_array(pairs, shape=(size, size))
        return bool(connected_components(graph, directed=False)[0] == 1)

    @cached_property
    def pattern(self) -> SparsityPattern:
        """Pairs of nodes that share a cell."""
        return sparsity_pattern(self.cell_nodes, len(self.points))

    @property
    def links(self) -> csr_matrix:
        """Matrix (n, n), an entry for two nodes that share a cell."""
        return self.pattern.matrix(np.ones(len(self.pattern.columns)))

    def quadrature(self, order: int) -> Any:
        """The basis with points that integrate polynomials of such a degree exactly."""
        mapping = self.basis.mapping
        return skfem.Basis(self.basis.mesh, self.basis.elem, mapping=mapping, intorder=order)

    @cached_property
    def gradients(self) -> Array:
        """∫ ∂φi/∂xc ∂φj/∂xd (d, d, e), an entry for each pair of nodes of `Discretisation.pattern`.

        Every constant tensor's stiffness is a combination of these: made once, on a scalar basis,
        they cost a fraction of a vector form.

        Raises
        ------
        SolverError
            If memory does not suffice.
        """
        with fits_in_memory(len(self.points), "nodes"):
            return gradient_products(self.basis, self.pattern)

    def gradients_over(self, cells: Mask) -> Array:
        """As `gradients`, over the cells of a mask (c,) alone; raises `SolverError` as they do."""
        with fits_in_memory(len(self.points), "nodes"):
            return gradient_products(self.basis, self.pattern, cells)

    def interpolation(self, points: ArrayLike) -> csr_matrix:
        """Matrix (p, n) that takes nodal values to values at points (p, d) of the body.

        Raises
        ------
        ProblemError
            If a point lies outside the body.
        """
        x = self._sampled(points)
        # Most points asked for are nodes, which take no search among the cells.
        apart, nearest = KDTree(self.points).query(x)
        at_node = apart <= AT_NODE * float(np.ptp(self.points, axis=0).max())
        (known,), (rest,) = np.nonzero(at_node), np.nonzero(~at_node)
        cell, local = locate(self._shapes, x[rest])
        nodes = self.nodes_of(cell)
        entries, _ = self.element.functions(local)
        rows = np.concatenate([known, np.broadcast_to(rest, nodes.shape).ravel()])
        columns = np.concatenate([nearest[known], nodes.ravel()])
        weights = np.concatenate([np.ones(len(known)), entries.ravel()])
        return csr_matrix((weights, (rows, columns)), shape=(len(x), len(self.points)))

    def incident(self, points: ArrayLike) -> tuple[Index, Index, Array]:
        """Pairs of a point and a cell that holds it, with local coordinates: (q,), (q,), (q, d).

        By rising point; a point that cells share is in several pairs. Local coordinates are the
        library's, and `nodes_of` the nodes in its order.

        Raises
        ------
        ProblemError
            If a point lies outside the body.
        """
        if points is self.points:  # nodes, which need no search
            nodes, local = self.cell_nodes, np.asarray(self.element.function.doflocs)
            pair = np.argsort(nodes, axis=None, kind="stable")
            cell, place = np.divmod(pair, nodes.shape[1])
            return nodes.ravel()[pair], cell, local[place]
        return incident(self._shapes, self._sampled(points))

    def nodes_of(self, cell: Index) -> Index:
        """Nodes (nodes, q) of cells (q,), in the library's order."""
        return np.asarray(self.node[self.basis.element_dofs[:, cell]])

    @property
    def cell_nodes(self) -> Index:
        """Nodes (c, k) of all cells, in the library's order."""
        return self.nodes_of(np.arange(len(self.cells))).T

    def swelling(self, points: Array) -> Array:
        """Least growth (c,) of each cell's measure at its nodes, when these move to points (n, d).

        Below zero a cell is turned inside out.
        """
        kind, nodes = self.element, self.cell_nodes
        _, slope = kind.functions(np.asarray(kind.function.doflocs))
        before, after = (
            np.linalg.det(np.einsum("kjq,ckd->cqjd", slope, x[nodes]))
            for x in (self.points, points)
        )
        return np.asarray((after / before).min(axis=1))

    def _sampled(self, points: ArrayLike) -> Array:
        return finite_coordinates("points to sample", points, "p", self.dim)

    @cached_property
    def _shapes(self) -> Cells:
        """The cells as the library maps them: it may have turned their corners."""
        nodes = self.points[self.cell_nodes]
        if self.curved:
            return curved_cells(nodes, self.element)
        return straight_cells(nodes[:, : self.element.corners], self.element)


def make_discretisation(points: ArrayLike, cells: ArrayLike, element: str) -> Discretisation:
    """Discretisation from points (n, d) in m and cells (c, nodes) in VTK order.

    Mid-side nodes off the middle of a straight edge make it a parabola through them. Where all
    edges are straight, cells are mapped by their corners alone.

    Raises
    ------
    ProblemError
        If the element is unknown or of another dimension, a cell is inverted, folded, overlaps
        another or names a point that is not there, a point belongs to no cell or lies where another
        does, or neighbours do not share the nodes of their common side.
    SolverError
        If memory does not suffice.
    """
    require_one_of("element", element, ELEMENTS)
    kind = ELEMENTS[element]
    x = finite_coordinates("points", points, "n", kind.dim, need=f"{element} needs (n, {kind.dim})")
    t = checked_cells(cells, kind, len(x))
    with fits_in_memory(len(x), "nodes"):
        return _build_discretisation(x, t, kind)


def _build_discretisation(x: Array, t: Index, kind: Element) -> Discretisation:
    """Discretisation of points (n, d) and cells (c, nodes), which are looked into."""
    refuse_repeated(t, kind)
    curving = is_bent(x, t, kind)
    plain, round_ = np.flatnonzero(~curving), np.flatnonzero(curving)
    refuse_folded(x, t[plain, : kind.corners], plain, kind.first)
    refuse_folded(x, t[round_], round_, kind)
    refuse_overlap(t[:, kind.faces])
    listed = kind.in_library_order(t)
    vertices, local = np.unique(listed[:, : kind.corners], return_inverse=True)
    local = local.reshape(len(t), kind.corners)
    mesh = kind.mesh(x[vertices].T.copy(), local.T.copy())
    mapping, order = None, kind.integration_order
    dofs = skfem.Dofs(mesh, kind.function)
    node = _nodes_of_dofs(x, listed, dofs)
    if len(round_):
        nodes = x[node].T.copy()
        whole = kind.mesh(nodes, mesh.t, elem=type(kind.function), sort_t=False)
        mapping, order = skfem.MappingIsoparametric(whole, kind.function), CURVED_ORDER
    basis = skfem.Basis(mesh, kind.function, mapping=mapping, intorder=order, dofs=dofs)
    return Discretisation(x, t, kind, basis, node, bool(len(round_)))


def _nodes_of_dofs(points: Array, listed: Index, dofs: Any) -> Index:
    """Node (n,) of each degree of freedom, by cells (c, nodes) in the library's order."""
    orphan = np.flatnonzero(np.bincount(listed.ravel(), minlength=len(points)) == 0)
    reach = COINCIDENT * float(np.ptp(points, axis=0).max())
    twins = KDTree(points).query_pairs(reach, output_type="ndarray")
    if len(orphan) or len(twins):
        first, second = twins[0] if len(twins) else (orphan[0], None)
        why = "belongs to no cell" if second is None else f"coincides with point {second}"
        raise ProblemError(f"points: point {first} {why}; remove or merge it")
    node = np.empty(dofs.N, dtype=np.intp)
    node[dofs.element_dofs.T] = listed
    other = (node[dofs.element_dofs.T] != listed).any(axis=1)
    uses = np.bincount(node, minlength=len(points))
    if other.any() or uses.max() > 1:
        lent = np.isin(listed, np.flatnonzero(uses > 1)).any(axis=1)
        raise ProblemError(
            f"cells: cell {np.flatnonzero(other | lent)[0]} names other nodes than its neighbours "
            "do on the sides they share; list corners, mid-sides, centre, and share whole sides"
        )
    return node
