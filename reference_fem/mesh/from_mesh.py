"""Finite elements on the cells of a mesh that is itself the body."""

from __future__ import annotations

import numpy as np

from msvalidate.problem import Array, Index, Mesh, ProblemError
from msvalidate.problem.checks import format_value, refuse_too_many, require_type
from reference_fem.mesh.discretisation import Discretisation, make_discretisation
from reference_fem.mesh.elements import ELEMENTS, Element, of_shape


def mesh_discretisation(mesh: Mesh, element: str | None = None) -> Discretisation:
    """Finite elements on the cells of a mesh.

    Parameters
    ----------
    mesh
        The domain.
    element
        The one that has the nodes of the mesh's cells, taken by default; or a quadratic one on
        linear cells, whose sides stay straight: the new nodes lie amid the corners.

    Raises
    ------
    ProblemError
        If the element is neither, or the nodes are too many.
    SolverError
        If memory does not suffice.
    """
    require_type("mesh", mesh, Mesh)
    own = of_shape(mesh.shape)
    raised = own.raised if own.degree == 1 else ()
    if element not in (None, own.name, *raised):
        raise ProblemError(
            f"mesh: element {format_value(element)} on {mesh.shape} cells; give "
            f"{' or '.join((own.name, *raised))}"
        )
    kind = own if element is None else ELEMENTS[element]
    if kind is own:
        refuse_too_many(str(mesh), len(mesh.points), kind.most_nodes)
        return make_discretisation(mesh.points, mesh.cells, kind.name)
    points, cells = with_middles(mesh.points, mesh.cells, kind)
    refuse_too_many(f"{mesh} with {kind.name}", len(points), kind.most_nodes)
    return make_discretisation(points, cells, kind.name)


def with_middles(points: Array, cells: Index, kind: Element) -> tuple[Array, Index]:
    """Points (m, d) in m and cells (c, nodes) of an element on cells of corners alone.

    New nodes lie amid each group of corners that the element has one for.
    """
    found, columns, count = [points], [cells], len(points)
    for size in sorted({len(group) for group in kind.middles}):  # edges, faces, cells
        groups = np.array([group for group in kind.middles if len(group) == size])
        corners = np.sort(cells[:, groups].reshape(-1, size), axis=1)
        each, number = np.unique(corners, axis=0, return_inverse=True)
        found.append(points[each].mean(axis=1))
        columns.append(count + number.reshape(len(cells), -1))
        count += len(each)
    return np.concatenate(found), np.concatenate(columns, axis=1)
