"""Meshes and elements: what a body is divided into, and the integrals that only that decides."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np
import skfem
from numpy.typing import ArrayLike
from scipy.sparse import csr_matrix
from scipy.spatial import KDTree

from msvalidate.problem import Array, Index, ProblemError, chosen, coordinates, place_name
from reference_fem.effort import within_memory
from reference_fem.interpolation import determinant, locate, mapped

AT_NODE = 1e-13
"""A point this close to a node, relative to the body's size, is the node."""


@dataclass(frozen=True)
class Element:
    """A finite element: its cells in VTK order start with `corners` corner points.

    `integration_order` is the polynomial degree integrated exactly. The library's default is far
    higher: it costs several times as much and differs from the usual Gauss rules. `faces` are the
    corners of its sides, each counter-clockwise as seen from outside. `order` are the corners as
    the library lists them.
    """

    name: str
    dim: int
    corners: int
    nodes: int
    degree: int
    integration_order: int
    mesh: Any
    function: Any
    faces: tuple[tuple[int, ...], ...]
    order: tuple[int, ...]


TRIANGLE = ((0, 1), (1, 2), (2, 0))
SQUARE = ((0, 1), (1, 2), (2, 3), (3, 0))
TETRAHEDRON = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))
CUBE = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (0, 4, 7, 3))
# Listed so, the corners have in the library's unit cube the coordinates that VTK gives them.
CUBE_ORDER = (6, 2, 5, 7, 1, 3, 4, 0)

ELEMENTS = {
    element.name: element
    for element in (
        Element("Q1", 2, 4, 4, 1, 2, skfem.MeshQuad, skfem.ElementQuad1, SQUARE, (0, 1, 2, 3)),
        Element("Q2", 2, 4, 9, 2, 4, skfem.MeshQuad, skfem.ElementQuad2, SQUARE, (0, 1, 2, 3)),
        Element("P1", 2, 3, 3, 1, 1, skfem.MeshTri, skfem.ElementTriP1, TRIANGLE, (0, 1, 2)),
        Element("P2", 2, 3, 6, 2, 2, skfem.MeshTri, skfem.ElementTriP2, TRIANGLE, (0, 1, 2)),
        Element("H1", 3, 8, 8, 1, 2, skfem.MeshHex, skfem.ElementHex1, CUBE, CUBE_ORDER),
        Element("T1", 3, 4, 4, 1, 1, skfem.MeshTet, skfem.ElementTetP1, TETRAHEDRON, (0, 1, 2, 3)),
    )
}


@dataclass(frozen=True, eq=False)
class Discretisation:
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
    """

    points: Array
    cells: Index
    element: Element
    basis: Any
    node: Index

    def __post_init__(self) -> None:
        for array in (self.points, self.cells, self.node):
            array.setflags(write=False)

    @property
    def dim(self) -> int:
        """Number of axes."""
        return int(self.points.shape[1])

    @property
    def faces(self) -> Index:
        """Corners (c, faces, 2, 3 or 4) of the sides of each cell, seen from outside."""
        return np.asarray(self.cells[:, self.element.faces])

    @cached_property
    def gradients(self) -> list[list[csr_matrix]]:
        """∫ ∂φi/∂xc ∂φj/∂xd as matrices [c][d] of shape (n, n), rows and columns by node.

        Every constant tensor's stiffness is a combination of these: assembled once, on a scalar
        basis, they cost a fraction of a vector form.

        Raises
        ------
        SolverError
            If memory does not suffice.
        """
        d = self.dim
        with within_memory(len(self.points), "nodes"):
            upper = {(a, b): self._integral(a, b) for a in range(d) for b in range(a, d)}
            return [[upper[a, b] if a <= b else upper[b, a].T for b in range(d)] for a in range(d)]

    def _integral(self, a: int, b: int) -> csr_matrix:
        form = skfem.BilinearForm(lambda u, v, _: v.grad[a] * u.grad[b])
        matrix = form.assemble(self.basis).tocoo()
        pair = (self.node[matrix.row], self.node[matrix.col])
        return csr_matrix((matrix.data, pair), shape=matrix.shape)

    def interpolation(self, points: ArrayLike) -> csr_matrix:
        """Matrix (p, n) that takes nodal values to values at points (p, d) of the body.

        Raises
        ------
        ProblemError
            If a point lies outside the body.
        """
        x = coordinates("points to sample", points)
        if x.ndim != 2 or x.shape[1] != self.dim:
            raise ProblemError(f"points to sample: shape {x.shape}; give (p, {self.dim})")
        # Most points asked for are nodes, which take no search among the cells.
        apart, nearest = KDTree(self.points).query(x)
        at_node = apart <= AT_NODE * float(np.ptp(self.points, axis=0).max())
        (known,), (rest,) = np.nonzero(at_node), np.nonzero(~at_node)
        mesh = self.basis.mesh  # the library may have turned the corners of a cell
        corners = mesh.t.T[:, np.argsort(self.element.order)]
        cell, local = locate(mesh.p.T[corners], x[rest])
        nodes = self.node[self.basis.element_dofs[:, cell]]
        values = [self.basis.elem.lbasis(local.T, i)[0] for i in range(len(nodes))]
        entries = np.array([np.broadcast_to(value, len(rest)) for value in values])
        rows = np.concatenate([known, np.broadcast_to(rest, nodes.shape).ravel()])
        columns = np.concatenate([nearest[known], nodes.ravel()])
        weights = np.concatenate([np.ones(len(known)), entries.ravel()])
        return csr_matrix((weights, (rows, columns)), shape=(len(x), len(self.points)))


def discretise(points: ArrayLike, cells: ArrayLike, element: str) -> Discretisation:
    """Discretisation from points (n, d) in m and cells (c, nodes) in VTK order.

    Raises
    ------
    ProblemError
        If the element is unknown or of another dimension, a cell is inverted, overlaps another or
        names a point that is not there, a point belongs to no cell or lies where another does, or
        an edge is curved.
    SolverError
        If memory does not suffice.
    """
    chosen("element", element, ELEMENTS)
    kind = ELEMENTS[element]
    x = coordinates("points", points)
    if x.ndim != 2 or x.shape[1] != kind.dim:
        raise ProblemError(f"points: shape {x.shape}; {element} needs (n, {kind.dim})")
    t = _checked_cells(cells, kind, len(x))
    with within_memory(len(x), "nodes"):
        return _assembled(x, t, kind)


def _assembled(x: Array, t: Index, kind: Element) -> Discretisation:
    """Discretisation of points (n, d) and cells (c, nodes), which are looked into."""
    corners = t[:, : kind.corners]
    if kind.dim == 2:
        _refuse_inverted(x[corners])
    else:
        _refuse_folded(x[corners])
    _refuse_overlap(corners[:, kind.faces])
    vertices, local = np.unique(corners[:, kind.order], return_inverse=True)
    mesh = kind.mesh(x[vertices].T.copy(), local.reshape(corners.shape).T.copy())
    basis = skfem.Basis(mesh, kind.function(), intorder=kind.integration_order)
    node = _match(x, basis.doflocs.T)
    misnumbered = (np.sort(node[basis.element_dofs].T) != np.sort(t)).any(axis=1)
    if misnumbered.any():
        raise ProblemError(
            f"cells: cell {np.flatnonzero(misnumbered)[0]} names other nodes than those that lie "
            "on its sides and centre; list corners, mid-sides, centre"
        )
    return Discretisation(x, t, kind, basis, node)


def _checked_cells(cells: ArrayLike, kind: Element, points: int) -> Index:
    try:
        t = np.array(cells)
    except ValueError as error:
        raise ProblemError(
            f"cells: rows of different length; {kind.name} needs {kind.nodes}"
        ) from error
    if t.ndim != 2 or t.shape[1] != kind.nodes or t.dtype.kind not in "iu" or not len(t):
        raise ProblemError(
            f"cells: {t.dtype} {t.shape}; {kind.name} needs whole numbers (c, {kind.nodes})"
        )
    if t.min() < 0 or t.max() >= points:
        raise ProblemError(f"cells: points {t.min()} to {t.max()}; there are 0 to {points - 1}")
    return np.asarray(t, dtype=np.intp)


def _refuse_overlap(faces: Index) -> None:
    """Neighbours run round their common face (c, faces, corners), or along an edge, oppositely."""
    each = faces.reshape(-1, faces.shape[2])
    side = "edges"
    if faces.shape[2] > 2:  # a ring starts anywhere: with its lowest number
        start = each.argmin(axis=1)[:, None]
        each = np.take_along_axis(each, (start + np.arange(each.shape[1])) % each.shape[1], axis=1)
        side = "faces"
    _, first, count = np.unique(each, axis=0, return_index=True, return_counts=True)
    if count.max() > 1:
        cell = int(first[count.argmax()]) // faces.shape[1]
        raise ProblemError(
            f"cells: cell {cell} overlaps another on one of its {side}; list it once"
        )


def _refuse_inverted(corners: Array) -> None:
    """Corners (c, 3 or 4, 2) must turn left all the way round."""
    edge = np.roll(corners, -1, axis=1) - corners
    following = np.roll(edge, -1, axis=1)
    turn = edge[..., 0] * following[..., 1] - edge[..., 1] * following[..., 0]
    size = np.linalg.norm(edge, axis=2) * np.linalg.norm(following, axis=2)
    bad = np.flatnonzero((turn <= 1e-12 * size).any(axis=1))
    if len(bad):
        raise ProblemError(
            f"cells: cell {bad[0]} is inverted, flat or not convex; list its corners "
            "counter-clockwise"
        )


def _refuse_folded(corners: Array) -> None:
    """The map onto each cell (c, 4 or 8, 3) must nowhere turn inside out.

    A hexahedron's Jacobian is quadratic along each axis of the unit cube, so it is above zero
    wherever its 27 Bernstein coefficients are: at its corners alone would not be enough.
    """
    steps = (0.0, 0.5, 1.0) if corners.shape[1] == 8 else (0.0,)
    jacobian = np.empty((len(steps) ** 3, len(corners)))
    lengths = np.zeros((3, len(corners)))
    for i, place in enumerate(product(steps, repeat=3)):
        _, columns = mapped(corners, np.array([place]))
        jacobian[i] = determinant(columns)
        lengths = np.maximum(lengths, [np.linalg.norm(side, axis=1) for side in columns])
    if len(steps) == 3:
        bernstein = np.array([[1, 0, 0], [-0.5, 2, -0.5], [0, 0, 1]])
        values = jacobian.reshape(3, 3, 3, -1)
        jacobian = np.einsum("ai,bj,ck,ijkn->abcn", *[bernstein] * 3, values).reshape(27, -1)
    bad = np.flatnonzero((jacobian <= 1e-12 * lengths.prod(axis=0)).any(axis=0))
    if len(bad):
        first = corners.shape[1] // 2 if len(steps) == 3 else 3
        raise ProblemError(
            f"cells: cell {bad[0]} is inverted, flat or folded; list its corners in VTK order, the "
            f"first {first} counter-clockwise as seen from the rest"
        )


def _match(points: Array, places: Array) -> Index:
    """Index of the point at each place, a one-to-one match or a `ProblemError`."""
    reach = 1e-8 * float(np.ptp(points, axis=0).max())
    distance, node = KDTree(points).query(places)
    if distance.max() > reach:
        place = places[distance.argmax()]
        raise ProblemError(
            f"points: none at {place_name(place)}, where the element has a node; "
            "mid-side nodes belong halfway along straight edges"
        )
    counts = np.bincount(node, minlength=len(points))
    bad = np.flatnonzero(counts != 1)
    if len(bad):
        near, twin = KDTree(points).query(points[bad[0]], k=2)
        twins = len(points) > 1 and near[1] <= reach
        why = f"coincides with point {twin[twin != bad[0]][0]}" if twins else "belongs to no cell"
        raise ProblemError(f"points: point {bad[0]} {why}; remove or merge it")
    return np.asarray(node)
