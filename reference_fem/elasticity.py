"""Linear elasticity: div σ + b = 0 with σ = C:ε, for any constant tensor, plane or solid."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_matrix

from msvalidate.problem import VOIGT, Array, Isotropic, Mask, Material, ProblemError
from msvalidate.problem.checks import finite, format_value, require_type
from reference_fem.effort import fits_in_memory
from reference_fem.locking import refuse_locked
from reference_fem.materials import (
    CellMaterials,
    Materials,
    by_material,
    each_material,
    lame_constants,
    numbers_of,
)
from reference_fem.mesh.discretisation import Discretisation, make_discretisation
from reference_fem.systems.solver import Solver, refuse_shapes


def solve(
    points: ArrayLike,
    cells: ArrayLike,
    element: str,
    material: Material,
    fixed: Iterable[tuple[int, int, float]],
    nodal_forces: Iterable[tuple[int, int, float]],
    *,
    allow_locked: bool = False,
) -> Array:
    """Displacement (n, d) in m of the nodes of a mesh.

    Parameters
    ----------
    points, cells
        (n, d) in m, and (c, nodes) in VTK order: corners counter-clockwise, then mid-sides, then
        the centre; in space the first face's corners counter-clockwise as seen from the others,
        then edges, faces and the centre. Mid-sides off straight edges curve them.
    element
        A name in `mesh.ELEMENTS`: "Q2", "P1" and so on in the plane, "H1", "T2" in space.
    material
        Plane state and thickness are the material's.
    fixed
        Rows (node, component, displacement in m).
    nodal_forces
        Rows (node, component, force in N), over the whole thickness; rows for one component add up.
    allow_locked
        Answer also where the elements lock (`locking`).

    Raises
    ------
    ProblemError
        If the mesh or a row is wrong, or the body can move rigidly.
    SolverError
        If the elements lock, or the solution fails its residual check or its error may be above
        `systems.solver.ACCEPTED`.
    """
    body = make_discretisation(points, cells, element)
    rows = check_arrays(body, fixed, nodal_forces)
    return solve_on(body, material, *rows, allow_locked=allow_locked)


def check_arrays(
    body: Discretisation,
    fixed: Iterable[tuple[int, int, float]],
    nodal_forces: Iterable[tuple[int, int, float]],
) -> tuple[Mask, Array, Array]:
    """Held components (n, d), their values (m) and the forces (N) of rows as `solve` takes them.

    Raises
    ------
    ProblemError
        If a row is wrong, or two contradict each other.
    """
    shape = body.points.shape
    held = np.zeros(shape, dtype=bool)
    displacement, force = np.zeros(shape), np.zeros(shape)
    for node, component, value in _rows("fixed", fixed, shape):
        if held[node, component] and displacement[node, component] != value:
            raise ProblemError(f"fixed: node {node} component {component} has two different values")
        held[node, component], displacement[node, component] = True, value
    for node, component, value in _rows("nodal_forces", nodal_forces, shape):
        force[node, component] += value
    return held, displacement, force


def solve_on(
    body: Discretisation,
    material: Materials,
    held: Mask,
    displacement: Array,
    force: Array,
    *,
    solver: str = "auto",
    allow_locked: bool = False,
) -> Array:
    """Displacement (n, d) in m under held components (n, d), their values (m) and forces (N).

    For many loads, or to know how it was solved, make a `Solver` of the `stiffness`.

    Raises
    ------
    ProblemError
        If a rigid motion is free, the material is not for this body or not compressible, or the
        solver is unknown, not there or not for this body.
    SolverError
        If part of the body can move without strain, the elements lock, or the solution fails its
        residual check or its error may be above `systems.solver.ACCEPTED`.
    """
    refuse_shapes(body, held=held, displacement=displacement, force=force)
    with np.errstate(over="ignore", invalid="ignore"):  # the residual refuses what has no numbers
        ready = make_solver(body, material, held, solver, allow_locked=allow_locked)
    return ready.solve(displacement, force)[0]


def stiffness(body: Discretisation, material: Materials) -> csr_matrix:
    """Stiffness (d·n, d·n) in N/m, thickness included, component-major.

    K_(ai)(bj) = t Σ_cd ∫ C_acbd ∂c φi ∂d φj, C constant in a cell.

    Source: [ZienkiewiczTaylorZhu2013].

    Raises
    ------
    ProblemError
        If the material is of another dimension, or not one a cell.
    SolverError
        If memory does not suffice.
    """
    each = [(thickness_tensor(one), cells) for one, cells in by_material(material, body)]
    return weighted_stiffness(body, *each)


def thickness_tensor(material: Material) -> Array:
    """C (d, d, d, d) in Pa, times the thickness."""
    return np.asarray(material.thickness * full_tensor(elastic_tensor(material)))


def thickness_tensors(material: Materials) -> Array:
    """As `thickness_tensor`, or (m, d, d, d, d) of several materials."""
    tensors = [thickness_tensor(one) for one in each_material(material)]
    return np.array(tensors) if isinstance(material, CellMaterials) else tensors[0]


def make_solver(
    body: Discretisation,
    material: Materials,
    held: Mask,
    choice: str = "auto",
    *,
    allow_locked: bool = False,
) -> Solver:
    """A `Solver` of a body and its material, which sums residuals cell by cell.

    Raises
    ------
    ProblemError
        As `stiffness` and `Solver`.
    SolverError
        If memory does not suffice, or the elements lock and that is not allowed.
    """
    K = stiffness(body, material)
    if not allow_locked:
        for one in each_material(material):
            refuse_locked(body, elastic_tensor(one))
    return Solver(body, K, held, choice, thickness_tensors(material), numbers_of(material))


def weighted_stiffness(body: Discretisation, *each: tuple[Array, Mask | None]) -> csr_matrix:
    """Σ_cd C_acbd ∫ ∂c φi ∂d φj (d·n, d·n), component-major, summed over tensors and their cells.

    Each tensor (d, d, d, d) holds in the cells of a mask (c,), or in all where there is none.
    """
    with fits_in_memory(len(body.points), "nodes"):
        blocks = [
            np.tensordot(
                C,
                body.gradients if cells is None else body.gradients_over(cells),
                axes=((1, 3), (0, 1)),
            )
            for C, cells in each
        ]
        whole = blocks[0]
        for block in blocks[1:]:
            whole += block
        return body.pattern.component_major(whole)


def elastic_tensor(material: Material) -> Array:
    """Voigt tensor (3, 3) or (6, 6) in Pa, from `lame_constants`.

    Order xx, yy, xy or xx, yy, zz, yz, xz, xy, with engineering shear.

    Raises
    ------
    ProblemError
        If λ is infinite (nu = 1/2 but in plane stress).
    """
    require_type("material", material, Material)
    if not isinstance(material, Isotropic):
        return material.C
    mu, lam = lame_constants(material)
    if math.isinf(lam):
        raise ProblemError(
            "nu = 1/2: displacement elements need a compressible body; take nu = 0.4999, or mixed "
            "elements"
        )
    d = material.dim
    C = np.diag([2 * mu] * d + [mu] * (d * (d - 1) // 2))
    C[:d, :d] += lam
    return C


def full_tensor(C: Array) -> Array:
    """Fourth-order tensor (d, d, d, d) of a Voigt tensor."""
    d = 2 if len(C) == 3 else 3
    T = np.zeros((d, d, d, d))
    for i, (a, b) in enumerate(VOIGT[d]):
        for j, (c, e) in enumerate(VOIGT[d]):
            T[a, b, c, e] = T[b, a, c, e] = T[a, b, e, c] = T[b, a, e, c] = C[i, j]
    return T


def _rows(
    name: str, rows: Iterable[tuple[int, int, float]], shape: tuple[int, ...]
) -> list[tuple[int, int, float]]:
    """Check rows (node, component, value) against a body of shape (n, d)."""
    checked = []
    if not isinstance(rows, Iterable):
        raise ProblemError(f"{name}: {format_value(rows)}; give rows (node, component, value)")
    for row in rows:
        values = finite(f"{name} row {format_value(row)}", row)
        if values.shape != (3,) or (values[:2] != np.floor(values[:2])).any():
            raise ProblemError(f"{name}: row {format_value(row)}; give (node, component, value)")
        node, component = int(values[0]), int(values[1])
        if not (0 <= node < shape[0] and 0 <= component < shape[1]):
            raise ProblemError(
                f"{name}: row {format_value(row)}; nodes run to {shape[0] - 1}, components to "
                f"{shape[1] - 1}"
            )
        checked.append((node, component, float(values[2])))
    return checked
