"""Nearly or wholly incompressible elasticity: displacement and pressure sought together.

    2μ ∫ ε(u):ε(v) + ∫ p div v = ∫ b·v   for all v,
    ∫ q div u - 1/λ ∫ p q = 0            for all q,

with continuous displacement of the second degree and continuous pressure of the first, which stay
accurate as 1/λ goes to 0 ([TaylorHood1973]; [BoffiBrezziFortin2013], section 8.8). Displacement
elements lock there.

The pressure is p = λ div u, positive in tension: σ = 2με + p I.
"""

from __future__ import annotations

from time import perf_counter

import numpy as np
import skfem
from scipy.sparse import block_array, block_diag, csr_array, diags_array, hstack, vstack
from scipy.sparse.linalg import splu

from msvalidate.problem import (
    Array,
    Isotropic,
    Mask,
    Material,
    ProblemError,
    SolverError,
    refuse_free_motions,
)
from msvalidate.problem.checks import require_type
from msvalidate.problem.records import dataclass
from reference_fem.effort import fits_in_memory
from reference_fem.elasticity import full_tensor, weighted_stiffness
from reference_fem.materials import Materials, by_material, lame_constants, numbers_of
from reference_fem.mesh.discretisation import Discretisation
from reference_fem.mesh.elements import ELEMENTS
from reference_fem.mesh.gradients import gradients_at_points
from reference_fem.systems.cells import ElasticForces, MixedForces
from reference_fem.systems.refined import Vectors, refine_solution, share_left
from reference_fem.systems.solver import (
    ACCEPTED,
    RESIDUAL,
    SystemSolution,
    describe_lost_digits,
    refuse_shapes,
)

TAYLOR_HOOD = [name for name, kind in ELEMENTS.items() if kind.degree == 2]
"""Elements of displacement, beside those of the first degree of pressure ([TaylorHood1973])."""
SINGULAR = 1e-14
"""Relative residual of a mode without stiffness that is rounding."""
PIVOT = 0.1
"""Least pivot relative to the largest of its column: some on the diagonal are zero at nu = 1/2."""


def solve_mixed_on(
    body: Discretisation, material: Materials, held: Mask, displacement: Array, force: Array
) -> tuple[Array, Array]:
    """Displacement (n, d) in m and pressure (v,) in Pa under held components, values, forces (N).

    The pressures are in the order of `Discretisation.vertices`: by rising number of the corners.

    Source: elements of [TaylorHood1973]; [BoffiBrezziFortin2013], section 8.8.

    Raises
    ------
    ProblemError
        If a rigid motion is free, or the body or its material is not for mixed elements.
    SolverError
        If the system is singular, the solution fails its residual check, or rounding takes too
        many of its digits.
    """
    return mixed_solution(body, material, held, displacement, force)[:2]


def mixed_solution(
    body: Discretisation, material: Materials, held: Mask, displacement: Array, force: Array
) -> tuple[Array, Array, SystemSolution]:
    """As `solve_mixed_on`, and how it was solved: the larger residual of forces and of volumes."""
    refuse_shapes(body, held=held, displacement=displacement, force=force)
    began = perf_counter()
    with fits_in_memory(len(body.points), "nodes"):
        system = _mixed_system(body, material)
    refuse_free_motions("finite element body", body.points, held)
    free, n = ~held.T.ravel(), held.size
    start = np.zeros(n + system.M.shape[0])
    start[:n] = np.where(held, displacement, 0.0).T.ravel()
    load = np.concatenate([force.T.ravel(), np.zeros(len(start) - n)])
    with np.errstate(over="ignore", invalid="ignore"):  # the residual refuses what has no numbers
        inverse = system.inverse(free)
        start += inverse(load - np.concatenate([system.A @ start[:n], system.B @ start[:n]]))
        left = system.check(free, start[:n], start[n:], load[:n])
        forces = system.forces(body, material)
        moves = np.append(free, np.zeros(len(start) - n, dtype=bool))
        share = share_left(forces, inverse, body.points, moves, body.dim)
        better = refine_solution(forces, inverse, start, load, share, slice(n))
    if not better.error <= ACCEPTED:
        raise SolverError(describe_lost_digits(better.error))
    how = "superlu", "mixed elements: indefinite", left, 0, perf_counter() - began
    solved = SystemSolution(*how, better.error, better.corrections)
    moved = better.value[:n].reshape(body.dim, -1).T.copy()
    return moved, better.value[n:].copy(), solved


def mixed_forces(
    body: Discretisation, material: Materials, displacement: Array, pressure: Array
) -> Array:
    """Forces (n, d) in N that hold a mixed solution, of displacement (n, d) and pressure, in place.

    A u + Bᵀ p: loads where nodes are free, with the supports' where they are held.
    """
    system = _mixed_system(body, material)
    n, d = displacement.shape
    force = system.A @ displacement.T.ravel() + system.B.T @ pressure
    return np.asarray(force.reshape(d, n).T)


@dataclass(frozen=True, eq=False)
class _System:
    """A u + Bᵀ p = f and B u - M p = 0, component-major, thickness included.

    The tensors of 2με (Pa), thickness included, and 1/λ (1/Pa) are of each material.
    """

    A: csr_array
    B: csr_array
    M: csr_array
    tensors: list[Array]
    inverses: Array

    def forces(self, body: Discretisation, material: Materials) -> MixedForces:
        """Forces, then volumes, as cells bring them."""
        number = numbers_of(material)
        tensor = self.tensors[0] if number is None else np.array(self.tensors)
        shear = ElasticForces(gradients_at_points(body), tensor, number)
        return MixedForces(body, shear, self.inverses, material.thickness)

    def inverse(self, free: Mask) -> Vectors:
        """Displacements (m), then pressures (Pa), of forces (N) and then volumes (m³).

        Scaled so that each equation is near 1. The scale of a pressure is the diagonal of
        B A⁻¹ Bᵀ + M, with the diagonal of A for A.
        """
        A, B = self.A[free][:, free], self.B[:, free]
        stiff = A.diagonal()
        soft = (B * B) @ (1 / stiff) + self.M.diagonal()
        if not (soft > 0).all() or not (stiff > 0).all():
            raise SolverError(_NO_VOLUME)
        scale = 1 / np.sqrt(np.concatenate([stiff, soft]))
        S = diags_array(scale)
        K = S @ block_array([[A, B.T], [B, -self.M]], format="csr") @ S
        factor, sought = _factorise(K), np.append(free, np.ones(len(soft), dtype=bool))

        def inverse(right: Array) -> Array:
            found = np.zeros(len(sought))
            found[sought] = scale * factor(scale * right[sought])
            return found

        return inverse

    def check(self, free: Mask, u: Array, p: Array, load: Array) -> float:
        """Larger residual of the two equations, relative; refused if it is more than rounding."""
        worst = 0.0
        both, total = hstack([self.A, self.B.T], "csr"), np.concatenate([u, p])
        below = hstack([self.B, -self.M], "csr")
        for name, rows, right in (
            ("force", both[free], load[free]),
            ("volume", below, np.zeros(len(p))),
        ):
            left = np.abs(rows @ total - right).max(initial=0.0)  # all may be held
            scale = (abs(rows) @ np.abs(total) + np.abs(right)).max(initial=0.0)
            if not left <= RESIDUAL * scale:
                raise SolverError(
                    f"mixed finite elements: residual of {name} {left:.3g} against terms of "
                    f"{scale:.3g}; the system is singular or badly scaled"
                )
            worst = max(worst, float(left / scale) if scale else 0.0)
        return worst


_NO_VOLUME = (
    "mixed finite elements: the system is singular: at nu = 1/2 the pressure of a body held all "
    "round has no value, a part that hangs by a corner can move, and a body too slender for its "
    "cells is lost in rounding; leave part of the surface free, join the parts, take nu < 1/2, or "
    "longer cells"
)


def _factorise(K: csr_array) -> Vectors:
    """Solutions of a symmetric indefinite system by a factor."""
    with fits_in_memory(K.shape[0], "unknowns"):
        try:
            factor = splu(
                K.tocsc(),
                permc_spec="MMD_AT_PLUS_A",
                diag_pivot_thresh=PIVOT,
                options={"SymmetricMode": True},
            )
        except RuntimeError as error:
            raise SolverError(_NO_VOLUME) from error
    # What the system does not feel hides from the residual, not from two inverse iterations.
    mode = np.random.default_rng(0).normal(size=K.shape[0])
    for _ in range(2):
        mode = factor.solve(mode)
        mode /= np.abs(mode).max()
    if not np.abs(K @ mode).max() > SINGULAR * (abs(K) @ np.abs(mode)).max():
        raise SolverError(_NO_VOLUME)
    return lambda right: np.asarray(factor.solve(right))


def _mixed_system(body: Discretisation, material: Materials) -> _System:
    """The matrices of a body and material that mixed elements are for.

    Each material has pressures of its own, for they jump where materials meet.
    """
    each = [(shear_and_compliance(one), cells) for one, cells in by_material(material, body)]
    if body.element.degree != 2:
        raise ProblemError(
            f"mixed elements: {body.element.name} has displacements of degree 1; take one of "
            f"{', '.join(TAYLOR_HOOD)}, with pressure of degree 1"
        )
    d, t = body.dim, material.thickness
    pairs = d * (d - 1) // 2
    shear = [
        (t * full_tensor(np.diag([2 * mu] * d + [mu] * pairs)), cells) for (mu, _), cells in each
    ]
    A = csr_array(weighted_stiffness(body, *shear))
    found = [(inverse, *_pressure_matrices(body, cells)) for (_, inverse), cells in each]
    mass = block_diag([inverse * mass for inverse, _, mass in found], "csr")
    B = vstack([B for _, B, _ in found], "csr")
    inverses = np.array([inverse for inverse, _, _ in found])
    return _System(A, t * B, t * mass, [tensor for tensor, _ in shear], inverses)


def _pressure_matrices(body: Discretisation, cells: Mask | None) -> tuple[csr_array, csr_array]:
    """∫ q div u (v, d·n) and ∫ p q (v, v) over all cells, or those of a mask and their corners."""
    basis, among = body.basis, None if cells is None else np.flatnonzero(cells)
    rule = {"mapping": basis.mapping, "quadrature": (basis.X, basis.W), "elements": among}
    pressure = skfem.Basis(basis.mesh, body.element.linear, **rule)
    if among is not None:
        basis = skfem.Basis(basis.mesh, basis.elem, dofs=basis.dofs, **rule)
    column = np.argsort(body.node, kind="stable")
    parts = []
    for axis in range(body.dim):
        form = skfem.BilinearForm(lambda u, v, _, axis=axis: v * u.grad[axis])
        parts.append(csr_array(form.assemble(basis, pressure))[:, column])
    mass = csr_array(skfem.BilinearForm(lambda p, q, _: p * q).assemble(pressure))
    B = hstack(parts, "csr")
    if among is None:
        return B, mass
    own = np.unique(pressure.element_dofs)
    return B[own], mass[own][:, own]


def shear_and_compliance(material: Material) -> tuple[float, float]:
    """Lamé's μ (Pa) and 1/λ (1/Pa), finite at nu = 1/2.

    Raises
    ------
    ProblemError
        If mixed elements are not for this material.
    """
    require_type("material", material, Material)
    if not isinstance(material, Isotropic):
        raise ProblemError(
            "mixed elements: the material is anisotropic; take displacement elements"
        )
    if material.state == "plane_stress":
        raise ProblemError(
            "mixed elements: plane stress leaves thickness free to change, so that nothing locks "
            "at nu = 1/2; take displacement elements"
        )
    if material.nu <= 0:
        raise ProblemError(
            f"mixed elements: nu = {material.nu:g} has no pressure that grows with volume (λ <= 0);"
            " take displacement elements, or nu above 0"
        )
    mu, lam = lame_constants(material)
    return mu, 1 / lam
