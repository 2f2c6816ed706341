"""A plate framed by bars, by finite elements: what whole springs along its edges make of a body.

A lattice whose springs along an edge keep their whole constant has there, beside its own half, a
bar of axial stiffness EA = k·spacing/2. The bars are added to the finite elements' matrix edge by
edge, quadratic as the plate's elements are; this is the only part that `reference_fem` lacks.
"""

from __future__ import annotations

from functools import partial

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.linalg import splu

import reference_fem
from msvalidate import kit
from reference_fem import Discretisation, Estimate
from reference_fem.body import nodal_forces
from reference_fem.elasticity import stiffness

COARSEST = 8
"""Cells along an edge of the first of three or more meshes, each twice as fine."""
GRADING = 3.0
"""Draws cells to the corners, where bars end and hand their force to the plate."""
BAR = np.array([[7.0, -8.0, 1.0], [-8.0, 16.0, -8.0], [1.0, -8.0, 7.0]]) / 3
"""Stiffness of a quadratic bar with nodes at its ends and middle, over EA/length."""


def work(box: kit.Box, problem: kit.Problem, bar: float, tolerance: float) -> Estimate:
    """Work (J) of the load on a framed plate, refined to a tolerance (J).

    Parameters
    ----------
    box, problem
        A plane body and the box that it fills; its supports must hold it.
    bar
        Axial stiffness EA (N) of the bar along each edge.
    tolerance
        Largest accepted uncertainty.

    Raises
    ------
    SolverError
        If meshes do not reach the tolerance.
    """
    return reference_fem.refine(partial(work_on, box, problem, bar), COARSEST, tolerance)


def work_on(box: kit.Box, problem: kit.Problem, bar: float, cells: int) -> float:
    """Work (J) of the load on a framed plate on one mesh."""
    mesh = reference_fem.box_discretisation(box, cells, "Q2", GRADING)
    matrix = (stiffness(mesh, problem.material) + bar * frame(mesh)).tocsc()
    held, moved = kit.prescribed_displacements(problem, mesh.points)
    if moved.any():
        raise ValueError(f"{problem.name}: supports that move are not for this reference")
    free = np.flatnonzero(~held.T.ravel())
    load = nodal_forces(problem, mesh).T.ravel()[free]
    # Symmetric ordering with diagonal pivots: several times faster than the general default.
    factor = splu(
        matrix[free][:, free],
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    return float(load @ factor.solve(load))


def frame(mesh: Discretisation) -> csr_array:
    """Stiffness (2n, 2n) over EA, component-major, of bars along the four edges of a Q2 box."""
    x = mesh.points
    rows, columns, values = [], [], []
    for axis in (0, 1):
        for end in (x[:, 1 - axis].min(), x[:, 1 - axis].max()):
            elements = _along(x, axis, np.flatnonzero(x[:, 1 - axis] == end))
            length = x[elements[:, 2], axis] - x[elements[:, 0], axis]
            component = elements + axis * len(x)
            rows.append(np.repeat(component, 3, axis=1).ravel())
            columns.append(np.tile(component, 3).ravel())
            values.append((BAR.ravel() / length[:, None]).ravel())
    entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    return coo_array(entries, shape=(2 * len(x),) * 2).tocsr()


def _along(x: kit.Array, axis: int, nodes: kit.Index) -> kit.Index:
    """End, middle and end (e, 3) of each element's side among the nodes of an edge."""
    line = nodes[np.argsort(x[nodes, axis], kind="stable")]
    return np.column_stack([line[:-2:2], line[1:-1:2], line[2::2]])
