"""Linear elasticity: div σ + b = 0 with σ = C:ε, for any constant tensor, plane or solid."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import bmat, csr_matrix
from scipy.sparse.linalg import splu

from msvalidate.problem import (
    Array,
    Index,
    Isotropic,
    Mask,
    Material,
    ProblemError,
    SolverError,
    finite,
    instance,
    place_name,
    refuse_free_motions,
    shown,
)
from reference_fem.discretisation import Discretisation, discretise
from reference_fem.effort import envelope, within_memory
from reference_fem.multigrid import MOST_STEPS, in_one_piece, multigrid

RESIDUAL = 1e-9
"""Largest accepted residual relative to the terms that cancel in it; a direct solve of a regular
system leaves 1e-13."""
NO_STIFFNESS = 1e-14
"""Strain energy of a mode that is rounding, relative to what its components cost one by one."""
MOST_PRODUCTS = 4e9
"""Products of a factor's envelope, in space, beyond which multigrid may be faster: half a second to
three. A cube of 12 x 12 x 12 cells has 3.6e9, a bar of 200 x 4 x 4 has 1.3e8. In the plane a factor
is faster to a million unknowns and more."""
MOST_ENTRIES = 5e7
"""Entries of a factor's envelope up to which one is made where multigrid fails: it takes 10
bytes for each in hexahedra, 30 in tetrahedra, 2 GB at most. A cube of 18 x 18 x 18 has 3e7."""
PRODUCTS_A_STEP = 2e8
"""Products of a factor that take no less time than a step of multigrid: what it may waste."""
LEAST_STEPS = 60
"""Steps that multigrid is always given: well-shaped cells take 40."""
VOIGT = {
    2: ((0, 0), (1, 1), (0, 1)),
    3: ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)),
}


def solve(
    points: ArrayLike,
    cells: ArrayLike,
    element: str,
    material: Material,
    fixed: Iterable[tuple[int, int, float]],
    nodal_forces: Iterable[tuple[int, int, float]],
) -> Array:
    """Displacement (n, d) in m of the nodes of a mesh.

    Parameters
    ----------
    points, cells
        (n, d) in m, and (c, nodes) in VTK order: corners counter-clockwise, then mid-sides, then
        the centre; in space the first face's corners counter-clockwise as seen from the others,
        then edges, faces and the centre. Mid-sides off straight edges curve them.
    element
        "Q1", "Q2", "P1" or "P2" in the plane, "H1", "H2", "T1" or "T2" in space.
    material
        Plane state and thickness are the material's.
    fixed
        Rows (node, component, displacement in m).
    nodal_forces
        Rows (node, component, force in N), over the whole thickness; rows for one component add up.

    Raises
    ------
    ProblemError
        If the mesh or a row is wrong, or the body can move rigidly.
    SolverError
        If the solution fails its residual check.
    """
    body = discretise(points, cells, element)
    return solve_on(body, material, *arrays(body, fixed, nodal_forces))


def arrays(
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


def refuse_shapes(body: Discretisation, **named: Array | Mask) -> None:
    """Raise a `ProblemError` for an array that has not one value for each component of a node."""
    instance("body", body, Discretisation)
    for name, array in named.items():
        if np.shape(array) != body.points.shape:
            raise ProblemError(f"{name}: shape {np.shape(array)}; give {body.points.shape}")


def solve_on(
    body: Discretisation, material: Material, held: Mask, displacement: Array, force: Array
) -> Array:
    """Displacement (n, d) in m under held components (n, d), their values (m) and forces (N).

    Raises
    ------
    ProblemError
        If a rigid motion is free, or the material is not for this body or not compressible.
    SolverError
        If the solution fails its residual check.
    """
    refuse_shapes(body, held=held, displacement=displacement, force=force)
    refuse_free_motions("finite element body", body.points, held)
    with np.errstate(over="ignore", invalid="ignore"):  # the residual refuses what has no numbers
        return _solved(body, stiffness(body, material), held, displacement, force)


def _solved(
    body: Discretisation, K: csr_matrix, held: Mask, displacement: Array, force: Array
) -> Array:
    known = held.T.ravel()
    u = np.where(held, displacement, 0.0).T.ravel()
    load = force.T.ravel()
    free = np.flatnonzero(~known)
    if len(free):
        rows = K[free]
        acting = load[free] - rows @ u
        if body.dim == 3:
            u[free] = _in_space(body, held, K, acting)
        else:
            u[free] = _direct(body, free, rows[:, free], acting)
        residual = np.abs(rows @ u - load[free]).max()
        scale = (abs(rows) @ np.abs(u) + np.abs(load[free])).max()
        if not residual <= RESIDUAL * scale:
            raise SolverError(
                f"finite elements: residual {residual:.3g} N against forces of {scale:.3g} N; "
                "the system is singular or badly scaled"
            )
    return u.reshape(body.dim, -1).T.copy()


def _in_space(body: Discretisation, held: Mask, K: csr_matrix, load: Array) -> Array:
    """Solution of the free part of a body in space by the way that its shape makes the faster."""
    free = np.flatnonzero(~held.T.ravel())
    entries, products = envelope(body.links, held)
    if products > MOST_PRODUCTS and in_one_piece(body):
        fits = entries <= MOST_ENTRIES
        steps = max(LEAST_STEPS, int(products / PRODUCTS_A_STEP)) if fits else MOST_STEPS
        try:
            return multigrid(body, held, K, load, min(steps, MOST_STEPS))
        except SolverError:  # thin cells, or nu near 1/2, which a factor does not mind
            if not fits:
                raise
    return _direct(body, free, K[free][:, free], load)


def stiffness(body: Discretisation, material: Material) -> csr_matrix:
    """Stiffness (d·n, d·n) in N/m, thickness included, component-major.

    K_(ai)(bj) = t Σ_cd C_acbd ∫ ∂c φi ∂d φj.

    Raises
    ------
    ProblemError
        If the material is of another dimension.
    SolverError
        If memory does not suffice.
    """
    instance("body", body, Discretisation)
    instance("material", material, Material)
    if material.dim != body.dim:
        raise ProblemError(f"material: {material.dim}D, the body {body.dim}D")
    return weighted(body, material.thickness * full_tensor(elastic_tensor(material)))


def weighted(body: Discretisation, C: Array) -> csr_matrix:
    """Σ_cd C_acbd ∫ ∂c φi ∂d φj (d·n, d·n), component-major, of a constant tensor (d, d, d, d)."""
    d, G = body.dim, body.gradients
    with within_memory(len(body.points), "nodes"):
        blocks = [
            [sum(C[a, c, b, e] * G[c][e] for c in range(d) for e in range(d)) for b in range(d)]
            for a in range(d)
        ]
        return bmat(blocks, format="csr")


def elastic_tensor(material: Material) -> Array:
    """Voigt tensor (3, 3) or (6, 6) in Pa, from Lamé's constants.

    Order xx, yy, xy or xx, yy, zz, yz, xz, xy, with engineering shear. Plane stress replaces λ by
    2λμ/(λ + 2μ) = E·nu/(1 - nu²).

    Raises
    ------
    ProblemError
        If λ is infinite (nu = 1/2 but in plane stress).
    """
    instance("material", material, Material)
    if not isinstance(material, Isotropic):
        return material.C
    E, nu = material.E, material.nu
    mu = E / (2 * (1 + nu))
    if material.state == "plane_stress":
        lam = E * nu / (1 - nu**2)
    elif nu < 0.5:
        lam = E * nu / ((1 + nu) * (1 - 2 * nu))
    else:
        raise ProblemError(
            "nu = 1/2: displacement elements need a compressible body; take nu < 1/2, or mixed "
            "elements (solve_mixed, or solve_problem with mixed=True)"
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


def _direct(body: Discretisation, free: Index, K: csr_matrix, load: Array) -> Array:
    """Solution of the free part, refused if part of the body can move without strain."""
    # Symmetric ordering with diagonal pivots: several times faster than the general default.
    options = {"SymmetricMode": True}
    ordering = "MMD_AT_PLUS_A"
    with within_memory(len(free), "unknowns"):
        try:
            factor = splu(K.tocsc(), permc_spec=ordering, diag_pivot_thresh=0.0, options=options)
        except RuntimeError as error:
            raise SolverError(
                "finite elements: the stiffness is singular: a part of the body can move without "
                "strain; join the parts or hold each"
            ) from error
    # A zero-energy mode hides from the residual, not from two steps of inverse iteration.
    mode = np.random.default_rng(0).normal(size=len(free))
    for _ in range(2):
        mode = factor.solve(mode)
        mode /= np.abs(mode).max()
    if abs(mode @ (K @ mode)) <= NO_STIFFNESS * (mode**2 @ K.diagonal()):
        place = body.points[free[np.abs(mode).argmax()] % len(body.points)]
        raise SolverError(
            f"finite elements: the part of the body around {place_name(place)} can move without "
            "strain; join it to the rest by an edge, or hold it"
        )
    return np.asarray(factor.solve(load))


def _rows(
    name: str, rows: Iterable[tuple[int, int, float]], shape: tuple[int, ...]
) -> list[tuple[int, int, float]]:
    """Check rows (node, component, value) against a body of shape (n, d)."""
    checked = []
    if not isinstance(rows, Iterable):
        raise ProblemError(f"{name}: {shown(rows)}; give rows (node, component, value)")
    for row in rows:
        values = finite(f"{name} row {shown(row)}", row)
        if values.shape != (3,) or (values[:2] != np.floor(values[:2])).any():
            raise ProblemError(f"{name}: row {shown(row)}; give (node, component, value)")
        node, component = int(values[0]), int(values[1])
        if not (0 <= node < shape[0] and 0 <= component < shape[1]):
            raise ProblemError(
                f"{name}: row {shown(row)}; nodes run to {shape[0] - 1}, components to "
                f"{shape[1] - 1}"
            )
        checked.append((node, component, float(values[2])))
    return checked
