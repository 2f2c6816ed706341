"""Linear tetrahedra of any law, at rest and in motion: what a law, masses and a mesh alone do.

A simulator in memory. Beside a program that says it solves the same elements, what differs is the
program's own; beside elasticity, what differs is law, masses and mesh.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.sparse import coo_array, csc_array
from scipy.sparse.linalg import splu

from msvalidate.problem import Array, Index, Mesh, SolverError
from msvalidate.problem.records import dataclass
from msvalidate.simulators.exchange.protocol import Answer, CannotRepresent, Request

Stress = Callable[[Array], Array]
"""From deformation gradients (c, 3, 3) to first Piola-Kirchhoff stresses (c, 3, 3), in Pa."""
LawOf = Callable[[Request], Stress]
"""The law that a request's material and settings mean to a simulator."""
STEP = 1e-6
"""Half the step of differences of stress: rounding 1e-10 and the law's third order 1e-12."""
STEPS, SETTLED = 40, 1e-12
"""Of Newton's method; residual over the largest force that meets at a node."""
ROUNDING = 64 * np.finfo(float).eps
"""Of forces, over stiffness times the size of the body: positions are sums of place and move."""
HALVINGS = 10


@dataclass(frozen=True, eq=False)
class Tetrahedra:
    """Linear tetrahedra at rest.

    Parameters
    ----------
    cells
        (c, 4) nodes.
    gradients
        (c, 4, 3) of the shape functions, in 1/m.
    volumes
        (c,) m³.
    """

    cells: Index
    gradients: Array
    volumes: Array


def tetrahedra_of(mesh: Mesh) -> Tetrahedra:
    """A mesh's tetrahedra; raise `CannotRepresent` if it has cells of another shape."""
    if mesh.shape != "tetra":
        raise CannotRepresent(f"cells {mesh.shape}; these are linear tetrahedra: give tetra")
    corners = mesh.points[mesh.cells]
    edges = corners[:, 1:] - corners[:, :1]
    inverse = np.linalg.inv(edges)  # its columns are the gradients of nodes 1 to 3
    rest = np.swapaxes(inverse, 1, 2)
    gradients = np.concatenate([-rest.sum(axis=1, keepdims=True), rest], axis=1)
    return Tetrahedra(mesh.cells, gradients, np.linalg.det(edges) / 6)


def forces_on_nodes(body: Tetrahedra, points: Array, stress: Stress) -> Array:
    """(n, 3) N that the body puts on its nodes: minus the derivative of its energy."""
    each = -np.einsum(
        "c,cij,caj->cai", body.volumes, stress(deformation_gradients(body, points)), body.gradients
    )
    force = np.zeros_like(points)
    np.add.at(force, body.cells, each)
    return force


def tangent(body: Tetrahedra, points: Array, stress: Stress) -> csc_array:
    """(3n, 3n) stiffness: minus the derivative of the forces, by differences of the law."""
    F = deformation_gradients(body, points)
    law = np.empty((len(F), 3, 3, 3, 3))
    for k in range(3):
        for m in range(3):
            change = np.zeros((3, 3))
            change[k, m] = STEP
            law[..., k, m] = (stress(F + change) - stress(F - change)) / (2 * STEP)
    g = body.gradients
    each = np.einsum("c,cijkm,caj,cbm->caibk", body.volumes, law, g, g, optimize=True)
    at = 3 * body.cells[:, :, None] + np.arange(3)
    rows = np.broadcast_to(at[:, :, :, None, None], each.shape)
    columns = np.broadcast_to(at[:, None, None, :, :], each.shape)
    size = 3 * len(points)
    found = coo_array((each.ravel(), (rows.ravel(), columns.ravel())), shape=(size, size))
    return csc_array(found)


def deformation_gradients(body: Tetrahedra, points: Array) -> Array:
    """(c, 3, 3) of nodes' places (n, 3) m; of displacements, their gradients."""
    return np.asarray(np.einsum("cai,caj->cij", points[body.cells], body.gradients))


def tetrahedra(law_of: LawOf, name: str = "linear tetrahedra") -> Callable[[Request], Answer]:
    """The simulator of a law.

    Its setting `integrator` is "explicit" (first velocities, then positions) or "implicit" (Euler's
    backward step).
    """

    def simulate(request: Request) -> Answer:
        body, stress = tetrahedra_of(request.mesh), law_of(request)
        implicit = request.settings.get("integrator", "explicit") == "implicit"
        about = {
            "simulator": name,
            "version": "1",
            "precision": "float64",
            "mass": "lumped",
            "forces_at": "end" if implicit else "start",
        }
        if request.task == "rest":
            move, left = at_rest(body, request, stress)
            return Answer(displacement=move, about=about | {"at_rest": {"residual": left}})
        position, velocity = in_motion(body, request, stress, implicit=implicit)
        return Answer(position=position, velocity=velocity, about=about)

    return simulate


def at_rest(
    body: Tetrahedra, request: Request, stress: Stress, start: Array | None = None
) -> tuple[Array, float]:
    """Displacement (n, 3) at rest under a request's loads, and the residual (N) that is left.

    Newton's method begins at `start` (n, 3) m, a displacement; by default at none.

    Raises
    ------
    SolverError
        If Newton's method does not settle.
    """
    points = request.mesh.points
    outer = request.force + request.mass[:, None] * request.gravity
    free = ~request.held.ravel()
    x = points + np.where(request.held, request.value, 0.0 if start is None else start)

    def residual(at: Array) -> Array:
        return np.asarray((forces_on_nodes(body, at, stress) + outer).ravel()[free])

    left, floor = residual(x), 0.0
    for _ in range(STEPS):
        inner = forces_on_nodes(body, x, stress)
        size = max(float(np.abs(outer).max()), float(np.abs(inner).max()))
        if np.abs(left).max(initial=0.0) <= SETTLED * size + floor:
            return x - points, float(np.abs(left).max(initial=0.0))
        stiffness = tangent(body, x, stress)
        floor = ROUNDING * float(np.abs(stiffness.data).max()) * float(np.abs(x).max())
        change = np.zeros(x.size)
        change[free] = _solve(csc_array(stiffness[free][:, free]), left)
        x, left = _step(x, change.reshape(x.shape), residual, float(np.abs(left).max()))
    raise SolverError(
        f"tetrahedra: {STEPS} steps of Newton's method left {np.abs(left).max():.3g} N"
    )


def _solve(stiffness: csc_array, force: Array) -> Array:
    try:
        return np.asarray(splu(stiffness).solve(force))
    except RuntimeError as error:
        raise SolverError("tetrahedra: the body can move without a force; hold it") from error


def _step(
    x: Array, change: Array, residual: Callable[[Array], Array], before: float
) -> tuple[Array, Array]:
    """A step of Newton's method, halved until it is one that helps; the last one in any case."""
    for halving in range(HALVINGS):
        new = x + change / 2**halving
        left = residual(new)
        if np.isfinite(left).all() and np.abs(left).max(initial=0.0) < before:
            return new, left
    return x + change, residual(x + change)


def in_motion(
    body: Tetrahedra, request: Request, stress: Stress, *, implicit: bool
) -> tuple[Array, Array]:
    """Position and velocity (n, 3) after a request's steps from `start` at zero velocity."""
    assert request.start is not None  # noqa: S101  as the request checks
    assert request.dt is not None  # noqa: S101
    x, v, dt = request.start.copy(), np.zeros_like(request.start), request.dt
    mass = request.mass[:, None]
    for _ in range(request.steps):
        if implicit:
            x, v = _backward(body, request, stress, (x, v))
        else:
            v = v + dt * (forces_on_nodes(body, x, stress) / mass + request.gravity)
            x = x + dt * v
    return x, v


def _backward(
    body: Tetrahedra, request: Request, stress: Stress, state: tuple[Array, Array]
) -> tuple[Array, Array]:
    """A step at whose end M (v - v0) / dt is the force."""
    assert request.dt is not None  # noqa: S101
    (x0, v0), dt = state, request.dt
    mass = request.mass[:, None]
    inertia = np.repeat(request.mass / dt**2, 3)
    x = x0 + dt * v0 + dt**2 * request.gravity

    def residual(at: Array) -> Array:
        pull = forces_on_nodes(body, at, stress) + mass * request.gravity
        return np.asarray((pull - mass * ((at - x0) / dt - v0) / dt).ravel())

    size = float(np.abs(forces_on_nodes(body, x, stress)).max()) or 1.0
    for _ in range(STEPS):
        left = residual(x)
        if np.abs(left).max() <= SETTLED * size:
            break
        stiffness = tangent(body, x, stress)
        stiffness = csc_array(stiffness + coo_array((inertia, (np.arange(x.size),) * 2)))
        x, _ = _step(
            x, _solve(stiffness, left).reshape(x.shape), residual, float(np.abs(left).max())
        )
    return x, (x - x0) / dt
