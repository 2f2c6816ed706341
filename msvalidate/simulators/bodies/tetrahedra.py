"""Linear tetrahedra of any law, at rest and in motion, by the elements of `reference_fem`.

A simulator in memory. Beside a program that says it solves the same elements, what differs is the
program's own; beside elasticity, what differs is law, masses and mesh.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
from scipy.sparse import diags_array
from scipy.sparse.linalg import splu

from msvalidate.linear_algebra.norms import max_abs
from msvalidate.problem import Array, Isotropic, Mesh
from msvalidate.problem.records import dataclass, replace
from msvalidate.simulators.bodies import laws
from msvalidate.simulators.exchange.protocol import Answer, CannotRepresent, Request
from reference_fem.elasticity import solve_on
from reference_fem.large_strain import Solid, deform
from reference_fem.mesh.discretisation import Discretisation
from reference_fem.mesh.from_mesh import mesh_discretisation

Stress = Callable[[Array], Array]
"""From deformation gradients (c, 3, 3), real or complex, to first Piola-Kirchhoff stresses, Pa."""
LawOf = Callable[[Request], Stress]
"""The law that a request's material and settings mean to a simulator."""
STEPS, SETTLED = 20, 1e-12
"""Maximum number of Newton iterations of an implicit step, and its tolerance.

The tolerance is the residual relative to the largest force on a node.
"""


@dataclass(frozen=True, eq=False)
class StressLaw:
    """A law of `reference_fem.large_strain` that is known by its stress alone.

    Parameters
    ----------
    of
        P of F, analytic in F: its tangent is a complex derivative, its energy the work to there.
    """

    of: Stress
    dim = 3

    def energy(self, F: Array) -> Array:
        """W (q,) in J/m³: the work along the straight way from F = I."""
        H = F - np.eye(3)
        ways, weights = np.polynomial.legendre.leggauss(8)
        each = [(self.of(np.eye(3) + (1 + t) / 2 * H) * H).sum(axis=(1, 2)) for t in ways]
        return np.asarray(weights @ np.array(each) / 2)

    def stress(self, F: Array) -> Array:
        """P (q, 3, 3) in Pa."""
        return self.of(F)

    def tangent(self, F: Array) -> Array:
        """A (q, 3, 3, 3, 3) in Pa."""
        return laws.tangent(self.of, F)


@lru_cache(maxsize=8)
def tetrahedra_of(mesh: Mesh) -> Discretisation:
    """A mesh's tetrahedra; raise `CannotRepresent` if it has cells of another shape."""
    if mesh.shape != "tetra":
        raise CannotRepresent(f"cells {mesh.shape}; these are linear tetrahedra: give tetra")
    return mesh_discretisation(mesh)


def linear_elements(request: Request, E: float, nu: float, mass: Array | None = None) -> Array:
    """(n, 3) m of linear tetrahedra of a material on a request's own mesh, with other masses."""
    own = request if mass is None else replace(request, mass=mass)
    value = np.where(own.held, own.value, 0.0)
    material, body = Isotropic(E, nu, "solid"), tetrahedra_of(request.mesh)
    return solve_on(body, material, own.held, value, own.load, allow_locked=True)


def at_rest(request: Request, stress: Stress, start: Array | None = None) -> tuple[Array, Solid]:
    """Displacement (n, 3) m at rest under a request's loads, from `start`, and the body.

    Raises
    ------
    SolverError
        If there is no stable equilibrium to be found.
    """
    solid = Solid(tetrahedra_of(request.mesh), StressLaw(stress), request.held)
    value, force = np.where(request.held, request.value, 0.0), request.load
    found = deform(solid, value, force, start=start, allow_locked=True)
    return found.displacement, solid


def tetrahedra(law_of: LawOf, name: str = "linear tetrahedra") -> Callable[[Request], Answer]:
    """The simulator of a law.

    Its setting `integrator` is "explicit" (first velocities, then positions) or "implicit" (Euler's
    backward step).
    """

    def simulate(request: Request) -> Answer:
        stress = law_of(request)
        implicit = request.settings.get("integrator", "explicit") == "implicit"
        about: dict[str, Any] = {
            "simulator": name,
            "version": "1",
            "precision": "float64",
            "mass": "lumped",
            "forces_at": "end" if implicit else "start",
        }
        if request.task == "rest":
            move, solid = at_rest(request, stress)
            left = np.where(request.held, 0.0, request.load - solid.internal_force(move)[0])
            about["at_rest"] = {"residual": max_abs(left)}
            return Answer(displacement=move, about=about)
        position, velocity = _in_motion(request, stress, implicit=implicit)
        return Answer(position=position, velocity=velocity, about=about)

    return simulate


def of_law(law: str, name: str = "linear tetrahedra") -> Callable[[Request], Answer]:
    """The simulator of a law of `LAWS`; at rest the linear one is of small strains, always."""
    whole = tetrahedra(lambda asked: laws.stress_of(law, asked.material.E, asked.material.nu), name)

    def simulate(request: Request) -> Answer:
        if law != "linear" or request.task != "rest":
            return whole(request)
        move = linear_elements(request, request.material.E, request.material.nu)
        about = {"simulator": name, "version": "1", "precision": "float64", "mass": "lumped"}
        return Answer(displacement=move, about={**about, "at_rest": {"residual": 0.0}})

    return simulate


def _in_motion(request: Request, stress: Stress, *, implicit: bool) -> tuple[Array, Array]:
    """Position and velocity (n, 3) after a request's steps from `start` at zero velocity."""
    assert request.start is not None  # noqa: S101  as the request checks
    assert request.dt is not None  # noqa: S101
    points, dt, mass = request.mesh.points, request.dt, request.mass[:, None]
    # Held or not, forces are the same; a body that nothing holds is refused.
    solid = Solid(tetrahedra_of(request.mesh), StressLaw(stress), np.ones(points.shape, dtype=bool))
    u, v = request.start - points, np.zeros(points.shape)
    for _ in range(request.steps):
        if implicit:
            new = _backward(solid, request, u, v)
            u, v = new, (new - u) / dt
        else:
            v = v + dt * (request.gravity - solid.internal_force(u)[0] / mass)
            u = u + dt * v
    return points + u, v


def _backward(solid: Solid, request: Request, u0: Array, v0: Array) -> Array:
    """Displacement after a step at whose end M (v - v0) / dt is the force, by Newton's method."""
    dt, mass = float(request.dt or 0), request.mass[:, None]
    inertia = diags_array(np.tile(request.mass / dt**2, 3))
    u = u0 + dt * v0 + dt**2 * request.gravity
    size = max_abs(solid.internal_force(u)[0]) or 1.0
    for _ in range(STEPS):
        pull = mass * request.gravity - solid.internal_force(u)[0]
        left = pull - mass * ((u - u0) / dt - v0) / dt
        if max_abs(left) <= SETTLED * size:
            break
        K = (solid.tangent(u) + inertia).tocsc()
        u = u + solid.by_node(splu(K).solve(left.T.ravel()))
    return u
