"""Meshes and elements: what a body is divided into, and the integrals that only that decides."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import skfem
from numpy.typing import ArrayLike
from scipy.sparse import csr_matrix
from scipy.spatial import KDTree

from msvalidate.problem import Array, Index, ProblemError, finite


@dataclass(frozen=True)
class Element:
    """A finite element: its cells in VTK order start with `corners` corner points.

    `integration_order` is the polynomial degree integrated exactly. The library's default is far
    higher: it costs several times as much and differs from the usual Gauss rules.
    """

    name: str
    corners: int
    nodes: int
    degree: int
    integration_order: int
    mesh: Any
    function: Any


ELEMENTS = {
    element.name: element
    for element in (
        Element("Q1", 4, 4, 1, 2, skfem.MeshQuad, skfem.ElementQuad1),
        Element("Q2", 4, 9, 2, 4, skfem.MeshQuad, skfem.ElementQuad2),
        Element("P1", 3, 3, 1, 1, skfem.MeshTri, skfem.ElementTriP1),
        Element("P2", 3, 6, 2, 2, skfem.MeshTri, skfem.ElementTriP2),
    )
}


@dataclass(frozen=True, eq=False)
class Discretisation:
    """Points and cells of one element, with the scalar basis that belongs to them.

    Parameters
    ----------
    points
        (n, d) positions (m) of all nodes, in the caller's numbering.
    element
        The element.
    basis
        scikit-fem basis for one component.
    node
        (n,) node of each degree of freedom of the basis.
    """

    points: Array
    element: Element
    basis: Any
    node: Index

    @property
    def dim(self) -> int:
        """Number of axes."""
        return int(self.points.shape[1])

    @cached_property
    def gradients(self) -> list[list[csr_matrix]]:
        """∫ ∂φi/∂xc ∂φj/∂xd as matrices [c][d] of shape (n, n), rows and columns by node.

        Every constant tensor's stiffness is a combination of these: assembled once, on a scalar
        basis, they cost a fraction of a vector form.
        """
        d = self.dim
        upper = {(a, b): self._integral(a, b) for a in range(d) for b in range(a, d)}
        return [[upper[a, b] if a <= b else upper[b, a].T for b in range(d)] for a in range(d)]

    def _integral(self, a: int, b: int) -> csr_matrix:
        form = skfem.BilinearForm(lambda u, v, _: v.grad[a] * u.grad[b])
        matrix = form.assemble(self.basis).tocoo()
        pair = (self.node[matrix.row], self.node[matrix.col])
        return csr_matrix((matrix.data, pair), shape=matrix.shape)

    def interpolation(self, points: Array) -> csr_matrix:
        """Matrix (p, n) that takes nodal values to values at points (p, d) of the body.

        Raises
        ------
        ProblemError
            If a point lies outside the body.
        """
        try:
            probe = self.basis.probes(np.ascontiguousarray(points.T)).tocoo()
        except ValueError as error:
            raise ProblemError(f"points to sample: {error}; they must lie in the body") from error
        return csr_matrix((probe.data, (probe.row, self.node[probe.col])), shape=probe.shape)


def discretise(points: ArrayLike, cells: ArrayLike, element: str) -> Discretisation:
    """Discretisation from points (n, d) in m and cells (c, nodes) in VTK order.

    Raises
    ------
    ProblemError
        If the element is unknown, a cell is inverted or names a point that is not there, a point
        belongs to no cell or to two, or an edge is curved.
    """
    if element not in ELEMENTS:
        raise ProblemError(f"element: {element!r}; choose {', '.join(ELEMENTS)}")
    kind = ELEMENTS[element]
    x, t = finite("points", points), np.asarray(cells)
    if x.ndim != 2 or x.shape[1] != 2:
        raise ProblemError(f"points: shape {x.shape}; {element} needs (n, 2)")
    if t.ndim != 2 or t.shape[1] != kind.nodes or t.dtype.kind not in "iu" or not len(t):
        raise ProblemError(f"cells: {t.dtype} {t.shape}; {element} needs numbers (c, {kind.nodes})")
    if t.min() < 0 or t.max() >= len(x):
        raise ProblemError(f"cells: points {t.min()} to {t.max()}; there are 0 to {len(x) - 1}")
    corners = t[:, : kind.corners]
    _refuse_inverted(x[corners])
    vertices, local = np.unique(corners, return_inverse=True)
    mesh = kind.mesh(x[vertices].T.copy(), local.reshape(corners.shape).T.copy())
    basis = skfem.Basis(mesh, kind.function(), intorder=kind.integration_order)
    return Discretisation(x, kind, basis, _match(x, basis.doflocs.T))


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


def _match(points: Array, places: Array) -> Index:
    """Index of the point at each place, a one-to-one match or a `ProblemError`."""
    reach = 1e-8 * float(np.ptp(points, axis=0).max())
    distance, node = KDTree(points).query(places)
    if distance.max() > reach:
        place = places[distance.argmax()]
        raise ProblemError(
            f"points: none at ({place[0]:g}, {place[1]:g}), where the element has a node; "
            "mid-side nodes belong halfway along straight edges"
        )
    counts = np.bincount(node, minlength=len(points))
    bad = np.flatnonzero(counts != 1)
    if len(bad):
        why = "belongs to no cell" if not counts[bad[0]] else "coincides with another"
        raise ProblemError(f"points: point {bad[0]} {why}; remove or merge it")
    return np.asarray(node)
