# SPDX-License-Identifier: MIT
"""MuJoCo's flexes in space: a body of points with three slides each, double precision.

    python mujoco.py CASE_DIR OUT_DIR

Versions tried: 4.0.0. Shipped defaults: integrator Euler, nu 0, no damping of elasticity; edges and
contacts, which this adapter turns off, have nothing to do with elasticity.

Settings: dof full | trilinear (see below); integrator Euler (explicit) | discrete (implicit in
position, new in 4.0); law stvk | snh (experimental, "discrete" alone, by mjSpec alone); masses
flexcomp (its own: equal ones) | asked (those of the request); tolerance, iterations of the solver
of "discrete"; dt (s), limit of steps, of "rest" alone (0: a stable step, or for "discrete" a long
one).

Laws, by the manual that comes with 4.0.0 (mujoco/doc):
  stvk  mu tr(e^2) + lambda/2 tr(e)^2 of Green's strain e, mu and lambda as asked
        (XMLreference.rst:4543-4556). To first order mu' = mu, lambda' = lambda.
        Releases before 4.0 had 2 lambda in the place of lambda (changelog.rst:170-175, 11).
  snh   simplified stable neo-Hookean (APIreference/APItypes.rst:2122-2131); no formula there.
Step: Euler takes v = v0 + dt M^-1 f(x0), x = x0 + dt v (computation/index.rst). "discrete" solves
(M + dt^2 K(x0)) v = M v0 + dt f(x0): one step of Newton's, so forces are those at its end to first
order in the step alone.
Mass: flexcomp gives each point the mass of the body over the number of points, wherever it is and
however its elements are (XMLreference.rst:3841-3843).

dof trilinear: by design one cell for the whole body. Three slides at each of the 8 corners of its
bounding box, points between are interpolated (XMLreference.rst:3702). Each corner has an eighth of
a box's mass. So positions that no such cell has, supports that are not whole sides of the box, and
boxes whose corners are no points are refused. A motion of one Euler step is answered by the
forces on the corners, which are all that such a body puts anywhere. Bent bodies show what one cell
is. Law: a constant stiffness of the cell, "standard isotropic linear-elastic" of E and nu since 4.0
(changelog.rst:702), turned with it.

Traps: a run that diverges is reset to its start in silence but for a warning, which is asked here.
Masses set after loading count from mj_setConst on. Pins hold points whole, so held components get
an armature (added inertia) of 1e9 body masses and are put back after each step.
"""

import sys

import numpy as np
from exchange import cannot, run, setting
from moving import move, stable_step

del sys.path[0]  # this file has the name of a module that is not in it
# ruff: noqa: E402
import mujoco

XML = """<mujoco><option timestep="{dt!r}" gravity="{gravity}" integrator="{integrator}" solver="CG"
tolerance="{tolerance}" iterations="{iterations}"><flag contact="disable"/></option>
<size memory="1G"/><worldbody><flexcomp name="b" type="direct" dim="3" dof="{dof}" radius="1e-6"
mass="{mass!r}" point="{points}" element="{cells}">
<contact selfcollide="none" contype="0" conaffinity="0"/>
<edge equality="false"/><elasticity young="{E!r}" poisson="{nu!r}" damping="0"/>
</flexcomp></worldbody></mujoco>"""


class _Body:
    """One flex in a world of its own, as `moving` wants it."""

    rounded = 0.0  # of the size, what points may be off after loading

    def __init__(self, request, chosen, dt):
        dof, law, masses, integrator, tolerance, iterations = chosen
        words = {"tolerance": tolerance, "iterations": iterations, "integrator": integrator}
        m, rest = request.material, request.points
        words |= {"dof": dof, "E": m.E, "nu": m.nu, "dt": dt, "mass": float(request.mass.sum())}
        arrays = {"gravity": request.gravity, "points": rest, "cells": request.cells}
        words |= {name: " ".join(map(repr, a.ravel().tolist())) for name, a in arrays.items()}
        spec = mujoco.MjSpec.from_string(XML.format(**words))
        spec.flexes[0].elastic3d = law == "snh"
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        mujoco.mj_forward(self.model, self.data)
        if np.abs(self.data.flexvert_xpos - rest).max() > self.rounded * np.ptp(rest):
            cannot("nodes after loading are not those of the request; they cannot be matched")
        self.rest = rest
        self._connect(request, masses)

    def _connect(self, request, masses):
        """Each point is a body."""
        bodies = self.model.flex_vertbodyid
        self.dofs = self.model.body_dofadr[bodies][:, None] + np.arange(3)
        if masses == "asked":
            self.model.body_mass[bodies] = request.mass
            mujoco.mj_setConst(self.model, self.data)
        self.held = self.dofs[request.held]
        self.value = request.value[request.held]
        if request.task == "rest":
            self._support(request.force)

    def _support(self, force):
        """Held components hardly move by their inertia, and not at all by what `step` does."""
        self.model.dof_armature[self.held] = 1e9 * self.model.body_mass.max()
        mujoco.mj_setConst(self.model, self.data)
        self.data.qfrc_applied[self.dofs] = force
        self._hold()

    def _hold(self):
        self.data.qpos[self.held] = self.value
        self.data.qvel[self.held] = 0

    def place(self, x):
        self.data.qpos[self.dofs] = x - self.rest

    def halt(self):
        self.data.qvel[:] = 0
        self.data.qacc_warmstart[:] = 0

    def step(self):
        mujoco.mj_step(self.model, self.data)
        self._hold()
        for name in ("BADQPOS", "BADQVEL", "BADQACC"):
            if self.data.warning[getattr(mujoco.mjtWarning, "mjWARN_" + name)].number:
                raise SystemExit(f"mujoco: {name}, diverged; take shorter steps")

    def positions(self):
        return self.rest + self.data.qpos[self.dofs]

    def velocities(self):
        return self.data.qvel[self.dofs]


class _Cell(_Body):
    """One trilinear cell: its bodies are the corners of the box, points are between them."""

    rounded = 1e-14  # by interpolation

    def _connect(self, request, masses):
        if masses != "flexcomp":
            cannot("masses asked: a trilinear flex has masses at the corners of its box alone")
        bodies = self.model.flex_nodebodyid
        self.dofs = self.model.body_dofadr[bodies][:, None] + np.arange(3)
        corners, low = self.data.xpos[bodies], self.rest.min(axis=0)
        part = (self.rest - low) / np.ptp(self.rest, axis=0)
        high = corners > corners.mean(axis=0)
        self.weights = np.where(high, part[:, None], 1 - part[:, None]).prod(axis=2)  # (n, 8)
        self.points = self.weights.argmax(axis=0)  # of ours, at the corners
        if not np.array_equal(self.rest[self.points], corners):
            cannot("a corner of the body's box is none of its nodes: one trilinear cell has others")
        self._hold_corners(request)
        if request.task == "rest":
            self._support(self.weights.T @ request.force)

    def _hold_corners(self, request):
        """Supports of corners, where they hold what is held and nothing else."""
        held, value = request.held[self.points], request.value[self.points]
        # A point is held where all corners that it has a part of are, and its value follows.
        follows = np.isclose(self.weights @ held, 1.0)
        there = np.abs(self.weights @ np.where(held, value, 0.0) - request.value)[request.held]
        if not np.array_equal(follows, request.held) or there.max(initial=0.0) > self._small():
            cannot(
                "supports that are not whole sides of the body's box: its corners are one cell's"
            )
        self.held, self.value = self.dofs[held], value[held]

    def _small(self):
        return 1e-9 * np.ptp(self.rest, axis=0).max()

    def place(self, x):
        move = (x - self.rest)[self.points]
        if np.abs(self.weights @ move + self.rest - x).max() > self._small():
            cannot("positions that no trilinear cell has: points follow the corners of the box")
        self.data.qpos[self.dofs] = move

    def positions(self):
        return self.rest + self.weights @ self.data.qpos[self.dofs]

    def velocities(self):
        return self.weights @ self.data.qvel[self.dofs]

    def forces(self, x):
        """What it puts on its points at positions (n, 3), N."""
        self.place(x)
        self.halt()
        mujoco.mj_forward(self.model, self.data)
        found = np.zeros_like(self.rest)
        found[self.points] = self.data.qfrc_passive[self.dofs]
        return found


def answer(request):
    """The answer: what it is about, and its arrays."""
    dof = setting(request, "dof", ("full", "trilinear"))
    integrator = setting(request, "integrator", ("Euler", "discrete"))
    law = setting(request, "law", ("stvk", "snh"))
    masses = setting(request, "masses", ("flexcomp", "asked"))
    tolerance = setting(request, "tolerance", 1e-12)
    iterations = setting(request, "iterations", 500)
    dt, limit = setting(request, "dt", 0.0), setting(request, "limit", 100_000)
    if request.kind != "tetra":
        cannot(f"flexes in space are of tetrahedra, not of {request.kind}")
    if law == "snh" and integrator != "discrete":
        cannot("law snh needs integrator discrete")
    if dof == "trilinear":
        if "law" in request.settings:
            cannot(f"law {law}: a trilinear flex has a stiffness of its own; leave it out")
        law = "linear, corotated"
    explicit, n = integrator == "Euler", len(request.points)
    mass = np.full(n, request.mass.sum() / n) if masses == "flexcomp" else request.mass
    if request.task == "motion":
        dt = request.dt
    elif dt == 0.0:
        dt = stable_step(request, mass) if explicit else 0.01
    kind = _Body if dof == "full" else _Cell
    body = kind(request, (dof, law, masses, integrator, tolerance, iterations), dt)
    if kind is _Cell and explicit and request.task == "motion" and request.steps == 1:
        about = {"steps": 1, "at_rest": {}, "notes": ""}
        arrays = {"force": body.forces(request.start)}
    else:
        about, arrays = move(request, body, each_step=not explicit, limit=limit)
    about |= {"simulator": "mujoco", "version": mujoco.__version__, "law": law, "dt": dt}
    about |= {"precision": "float64", "mass": "lumped"}
    taken = {"dof": dof, "integrator": integrator, "law": law, "masses": masses}
    taken |= {"tolerance": tolerance, "iterations": iterations}
    units = {name: [value, ""] for name, value in taken.items()}
    return {**about, "forces_at": "start" if explicit else "end", "settings": units}, arrays


run(answer)
