# SPDX-License-Identifier: MIT
"""PyBullet's deformable bodies: neo-Hookean tetrahedra, explicit steps, double precision.

    python pybullet.py CASE_DIR OUT_DIR

Versions tried: 3.2.7. Shipped default: no elasticity but what is asked for by name.

Settings: dt (s; 0: a quarter of a stable step), damping (s, of the strains' rate; 0: near critical
for the longest side) and limit of steps, all of "rest" alone.

Law, as the source has it (Bullet's src/BulletSoftBody/btDeformableNeoHookeanForce.h):
  P = mu (1 - 1/(Ic+1)) F + (lambda (J - 1) - 3/4 mu) cof F   (lines 358-363)
Smith et al. 2018 with raw constants. Its comment calls m_mu and m_lambda Lamé's (line 27), which
are given it as such here; to first order mu' = 3/4 mu, lambda' = lambda - 5/8 mu.
Step: v = v0 + dt M^-1 f(x0), x = x0 + dt v (PhysicsServerCommandProcessor.cpp:10020 asks for
explicit ones); damping alone is solved for within a step.
Mass: the same for each node, the body's over their number (btSoftBody.cpp:947-978).

Traps: positions can be set, velocities cannot, so "rest" needs damping of the program, which is 0
where nothing moves; at rest is what moves no more within the damping's time, three times. Its
damping leaves a tremble of some 1e-4 to 6e-4 of the displacement, which at_rest states. After 2 s
of slow motion a body is put to sleep and moves no more at all, wherever it is; no setting of
Python's kept it awake, so all that is done here ends before. Forces of an
earlier body survive resetSimulation: one body a process. Fixed nodes are anchors, whose mass
becomes 0: whole ones alone. NumPy has to be there before PyBullet is installed.
"""

import sys
import tempfile

import numpy as np
from exchange import cannot, run, setting
from moving import move, stable_step, write_vtk

del sys.path[0]  # this file has the name of a module that is not in it
# ruff: noqa: E402
from importlib.metadata import version

import pybullet

AWAKE = 0.9
"""Of the 2 s before a body may be put to sleep, for coming to rest (s); as long again tells how far
it is from there."""
LOOKS = 8
"""Times that a body is looked at when it is at rest: it trembles, and one look may see none."""


class _Body:
    """One body in a world of its own, as `moving` wants it; it can be halted at its start alone."""

    def __init__(self, request, dt, damping, together):
        m, self.dt, self.together = request.material, dt, together
        mu = m.E / (2 * (1 + m.nu))
        pybullet.connect(pybullet.DIRECT)
        pybullet.resetSimulation(pybullet.RESET_USE_DEFORMABLE_WORLD)
        pybullet.setGravity(*request.gravity)
        pybullet.setTimeStep(dt)
        with tempfile.TemporaryDirectory() as folder:
            name = write_vtk(request, folder)
            self.id = pybullet.loadSoftBody(
                name,
                simFileName=name,
                mass=float(request.mass.sum()),
                scale=1.0,
                collisionMargin=1e-6,
                useSelfCollision=0,
                useFaceContact=0,
                useNeoHookean=1,
                NeoHookeanMu=mu,
                NeoHookeanLambda=2 * mu * m.nu / (1 - 2 * m.nu),
                NeoHookeanDamping=damping,
            )
        if not np.array_equal(self.positions(), request.points):
            cannot("nodes after loading are not those of the request; they cannot be matched")
        if request.task == "rest":
            for node in np.flatnonzero(request.held.any(axis=1)):
                pybullet.createSoftBodyAnchor(self.id, int(node), -1, -1)

    def place(self, x):
        pybullet.resetMeshData(self.id, x.tolist())

    def halt(self):
        """Nothing: velocities cannot be set, and are 0 where a motion begins."""

    def step(self):
        for _ in range(self.together - 1):
            pybullet.stepSimulation()
        self.before = self.positions()
        pybullet.stepSimulation()

    def positions(self):
        flag = pybullet.MESH_DATA_SIMULATION_MESH
        return np.array(pybullet.getMeshData(self.id, -1, flags=flag)[1])

    def velocities(self):
        """Of the last step, by what it does: x = x0 + dt v."""
        return (self.positions() - self.before) / self.dt


def tremble(body, x):
    """Largest change (m) from positions x in some looks at the body as it goes on."""
    largest = 0.0
    for _ in range(LOOKS):
        body.step()
        largest = max(largest, float(abs(body.positions() - x).max()))
    return largest


def answer(request):
    """The answer: what it is about, and its arrays."""
    dt, damping = setting(request, "dt", 0.0), setting(request, "damping", 0.0)
    limit, rest = setting(request, "limit", 50_000), request.task == "rest"
    if request.kind != "tetra":
        cannot(f"deformable bodies are of tetrahedra, not of {request.kind}")
    if rest and (request.held.any(axis=1) != request.held.all(axis=1)).any():
        cannot("holds nodes in all components or in none: no rollers")
    if rest and (request.force.any() or request.value.any()):
        cannot("no forces on nodes and no displacements can be given")
    m, n = request.material, len(request.points)
    if rest:
        equal = np.full(n, request.mass.sum() / n)
        dt = dt or stable_step(request, equal) / 4
        damping = damping or np.ptp(request.points, axis=0).max() * np.sqrt(m.density / m.E)
    else:
        dt, damping = request.dt, 0.0
    together = int(np.ceil(damping / dt)) if rest else 1
    body = _Body(request, dt, damping, together)
    limit = max(1, min(limit, int(AWAKE / dt)) // together)
    about, arrays = move(request, body, each_step=True, still=1e-6, limit=limit)
    about["steps"] *= together
    if rest:
        name, known = "change_when_twice_as_long", about["at_rest"]
        known[name] = max(known[name], tremble(body, request.points + arrays["displacement"]))
        about["notes"] = "damped by its own damping; no velocity was set to zero"
    about |= {"simulator": "pybullet", "version": version("pybullet"), "law": "neo-Hookean"}
    about |= {"precision": "float64", "mass": "lumped", "forces_at": "start", "dt": dt}
    return {**about, "settings": {"damping": [damping, "s"], "dt": [dt, "s"]}}, arrays


run(answer)
