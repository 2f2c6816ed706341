# SPDX-License-Identifier: MIT
"""Newton's soft bodies on Warp, on the processor, in single precision.

    python newton.py CASE_DIR OUT_DIR

Versions tried: 1.8.0 on warp-lang 1.19.0, which compiles for a minute or two at first.

Settings: solver semi (explicit) | vbd (implicit, block descent) | xpbd (constraints); iterations
(of vbd and xpbd; theirs are 10 and 2); relaxation (of xpbd; its own is .9); dt (s), limit of
steps, of "rest" alone (0: a stable step for semi, 20 of them for the others). k_mu and k_lambda are
Lamé's mu and lambda of the asked E, nu, as the documentation of `add_soft_mesh` asks.

Laws, as the source has them (newton/_src/solvers), and what they come to to first order:
  semi  P = mu (1 - 1/(Ic+1)) F + lambda (J - alpha) cof F, alpha = 1 + mu/lambda - mu/(4 lambda)
        (semi_implicit/kernels_particle.py:296, 317, 412): Smith et al. 2018 with raw constants,
        mu' = 3/4 mu, lambda' = lambda - 5/8 mu.
  vbd   P = mu F + (lambda + mu)(J - alpha) cof F, alpha = 1 + mu/(lambda + mu)
        (vbd/particle_vbd_kernels.py:228-250): mu' = mu, lambda' = lambda, as asked.
  xpbd  two constraints a tetrahedron, tr(F'F) - 3 with stiffness mu and J - 1 with lambda
        (xpbd/kernels.py:593-602): energy mu/2 (tr(F'F) - 3)^2 + lambda/2 (J - 1)^2, so
        mu' = 0, lambda' = lambda + 4 mu: no resistance to shear at F = I.
Step: semi v = v0 + dt f(x0)/m, x = x0 + dt v (solvers/solver.py:58-64); the others end near a
minimum of inertia and energy at x, v = (x - x0)/dt.
Mass: density volume / 4 of each tetrahedron to each of its nodes (sim/builder.py:12665-12669).

Traps: particles repel each other unless their radius is 0 (default .1 m) and the model has no grid;
with a radius and without a grid XPBD raises. Held nodes are those of mass 0: whole ones alone.
vbd and xpbd begin a step at x + dt v + dt^2 g and relax from there: what few iterations leave of
that way is a displacement at rest that shrinks with dt^2 and with more iterations. Much shorter
steps move points by less than positions resolve, so that they seem to be at rest before they are.
Positions resolve 6e-8 of the largest coordinate, which bounds how small displacements may be.
"""

import sys

import numpy as np
from exchange import cannot, run, setting
from moving import move, stable_step

del sys.path[0]  # this file has the name of a module that is not in it
# ruff: noqa: E402
import newton
import warp as wp

wp.config.quiet = True


class _Body:
    """One soft mesh in a model of its own, as `moving` wants it."""

    def __init__(self, request, solver, iterations, relaxation, dt):
        m = request.material
        mu = m.E / (2 * (1 + m.nu))
        lame = 2 * mu * m.nu / (1 - 2 * m.nu)
        builder = newton.ModelBuilder()
        zero = wp.vec3(0.0, 0.0, 0.0)
        builder.add_soft_mesh(
            pos=zero,
            rot=wp.quat_identity(),
            vel=zero,
            scale=1.0,
            density=m.density,
            k_mu=mu,
            k_lambda=lame,
            k_damp=0.0,
            vertices=[wp.vec3(*x) for x in request.points],
            indices=request.cells.ravel().tolist(),
            add_surface_mesh_edges=False,
            particle_radius=0.0,
        )
        self.place_at = request.points
        if request.task == "rest":
            for node in np.flatnonzero(request.held.any(axis=1)):
                builder.particle_mass[node] = 0.0
            self.place_at = request.points + np.where(request.held, request.value, 0.0)
        builder.color()
        self.model = builder.finalize(device="cpu")
        self.model.particle_grid = None
        self.model.set_gravity(tuple(request.gravity))
        self.states = self.model.state(), self.model.state()
        self.force = request.force if request.task == "rest" else np.zeros_like(request.points)
        self.solver, self.dt = _solver(self.model, solver, iterations, relaxation), dt
        self.place(self.place_at)

    def place(self, x):
        for state in self.states:
            state.particle_q.assign(x.astype(np.float32))

    def halt(self):
        for state in self.states:
            state.particle_qd.zero_()

    def step(self):
        now, after = self.states
        now.clear_forces()
        if self.force.any():
            now.particle_f.assign(self.force.astype(np.float32))
        self.solver.step(now, after, None, None, self.dt)
        self.states = after, now

    def positions(self):
        return self.states[0].particle_q.numpy().astype(float)

    def velocities(self):
        return self.states[0].particle_qd.numpy().astype(float)


def _solver(model, name, iterations, relaxation):
    if name == "semi":
        return newton.solvers.SolverSemiImplicit(model, enable_tri_contact=False)
    if name == "vbd":
        return newton.solvers.SolverVBD(model, iterations=iterations)
    return newton.solvers.SolverXPBD(model, iterations=iterations, soft_body_relaxation=relaxation)


def answer(request):
    """The answer: what it is about, and its arrays."""
    solver = setting(request, "solver", ("semi", "vbd", "xpbd"))
    iterations = setting(request, "iterations", 2 if solver == "xpbd" else 10)
    relaxation = setting(request, "relaxation", 0.9)
    dt, limit = setting(request, "dt", 0.0), setting(request, "limit", 20_000)
    if request.kind != "tetra":
        cannot(f"soft meshes are of tetrahedra, not of {request.kind}")
    if request.task == "rest" and (request.held.any(axis=1) != request.held.all(axis=1)).any():
        cannot("holds nodes in all components or in none: no rollers")
    if solver != "vbd" and request.material.nu == 0:
        cannot(f"{solver} takes no lambda of 0, which nu 0 has")
    explicit = solver == "semi"
    if request.task == "motion":
        dt = request.dt
    else:
        dt = dt or stable_step(request) * (1 if explicit else 20)
    wp.init()
    body = _Body(request, solver, iterations, relaxation, dt)
    floor = 4 * np.finfo(np.float32).eps * float(abs(request.points).max())
    how = {"still": 1e-6, "floor": floor, "limit": limit}
    about, arrays = move(request, body, **how)
    settings = {"solver": solver, "iterations": iterations, "relaxation": relaxation}
    units = {name: [value, ""] for name, value in settings.items()} | {"dt": [dt, "s"]}
    about |= {"simulator": "newton", "version": newton.__version__, "dt": dt}
    about |= {"law": "constraints" if solver == "xpbd" else "neo-Hookean", "mass": "lumped"}
    about |= {"precision": "float32", "forces_at": "start" if explicit else "end"}
    return {**about, "settings": units}, arrays


run(answer)
