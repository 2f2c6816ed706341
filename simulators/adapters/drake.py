# SPDX-License-Identifier: MIT
"""Drake's deformable bodies: linear tetrahedra, implicit steps, double precision.

    python drake.py CASE_DIR OUT_DIR

Versions tried: 1.51.1 (drake-1.51.1, Python 3.11). Shipped defaults: E 1e8 Pa, nu .49, density
1500 kg/m³, law linear_corotated, no damping (multibody/fem/deformable_body_config.h:145-150);
here E, nu and density are the asked ones and the default law stays.

Settings: law linear_corotated | corotated | linear | neo_hookean; dt (s), of "rest" alone;
limit, of its steps. "rest" takes long steps and sets the velocities to zero after each, which makes
a step one of Newton's towards rest.

Laws, as the source has them (files of multibody/fem at tag v1.51.1). mu, lambda are those of the
asked E, nu (calc_lame_parameters.cc:19-21); mu', lambda' what the law comes to at F = I:
  linear            P = 2 mu e + lambda tr(e) I             linear_constitutive_model.cc:52
  linear_corotated  the same turned by the last step's R    linear_corotated_model.cc:51
  corotated         P = 2 mu (F-R) + lambda (J-1) cof F     corotated_model.cc:42
      all three: mu, lambda as asked
  neo_hookean       P = mu F + lambda (J-1-mu/lambda) cof F neohookean_model.cc:42-45
      mu' = mu, lambda' = lambda - mu: nu' = (4 nu - 1) / (4 nu), below 0 for nu < 1/4; the bulk
      modulus lambda - mu/3 is below 0 for nu < 1/8; nu = 0 divides by lambda = 0 (refused here).

Step: v = dt M^-1 f(x at its end), x = x0 + dt (v0 + v) / 2 (plant/deformable_model.cc:28-35).
Mass: "one point". The element's matrix is summed over the one point of its quadrature
(fem/volumetric_element.h:683-712, tree/deformable_body.cc:433), so that every entry of its 4 x 4 is
density volume / 16, neither lumped nor the consistent density volume (1 + delta) / 20.
Newton's iteration of the laws that are not linear stops at a residual of 1 % of the first or
1e-6 N (fem/fem_solver.h:233-237): no setting of Python's reaches that, so constants read from a
step have an error of 1e-4. Laws that are linear in a step are solved directly, but not where the
residual is below 1e-6 N, so loads of less do nothing.

Traps: supports are half-spaces of nodes that stay where they were (SetWallBoundaryCondition, the
last call alone counts): one side of the body, no rollers, no prescribed displacement. No forces on
nodes. Reads meshes from a VTK file alone, single numbers printed in full here.
"""

import sys
import tempfile
from importlib.metadata import version

import numpy as np
from exchange import cannot, run, setting
from moving import move, write_vtk

del sys.path[0]  # this file has the name of a module that is not in it
# ruff: noqa: E402
from pydrake.geometry import GeometryInstance, Mesh, ProximityProperties
from pydrake.math import RigidTransform
from pydrake.multibody.fem import DeformableBodyConfig, MaterialModel
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

LAWS = {
    "linear_corotated": MaterialModel.kLinearCorotated,
    "corotated": MaterialModel.kCorotated,
    "linear": MaterialModel.kLinear,
    "neo_hookean": MaterialModel.kNeoHookean,
}


class _Body:
    """One body in a plant of its own, as `moving` wants it."""

    def __init__(self, request, law, dt):
        builder = DiagramBuilder()
        plant, _ = AddMultibodyPlantSceneGraph(builder, dt)
        self.model = plant.mutable_deformable_model()
        with tempfile.TemporaryDirectory() as folder:
            mesh = Mesh(write_vtk(request, folder))
            shape = GeometryInstance(RigidTransform(), mesh, "body")
            shape.set_proximity_properties(ProximityProperties())
            self.id = self.model.RegisterDeformableBody(shape, config(request.material, law), 1.0)
        rest = self.model.GetReferencePositions(self.id).reshape(-1, 3)
        if not np.array_equal(rest, request.points):
            cannot("nodes after loading are not those of the request; they cannot be matched")
        if request.task == "rest":
            self.model.SetWallBoundaryCondition(self.id, *wall(request))
        plant.mutable_gravity_field().set_gravity_vector(request.gravity)
        plant.Finalize()
        self.simulator = Simulator(builder.Build())
        self.simulator.Initialize()
        self.context = plant.GetMyMutableContextFromRoot(self.simulator.get_mutable_context())
        self.dt, self.taken = dt, 0

    def place(self, x):
        self.model.SetPositions(self.context, self.id, np.asfortranarray(x.T))

    def halt(self):
        zero = np.zeros_like(self.model.GetVelocities(self.context, self.id), order="F")
        self.model.SetVelocities(self.context, self.id, zero)

    def step(self):
        self.taken += 1
        self.simulator.AdvanceTo(self.taken * self.dt)

    def positions(self):
        return self.model.GetPositions(self.context, self.id).T.copy()

    def velocities(self):
        return self.model.GetVelocities(self.context, self.id).T.copy()


def config(material, law):
    """Of the asked material."""
    chosen = DeformableBodyConfig()
    chosen.set_youngs_modulus(material.E)
    chosen.set_poissons_ratio(material.nu)
    chosen.set_mass_density(material.density)
    chosen.set_material_model(LAWS[law])
    return chosen


def wall(request):
    """A point and the normal of a plane with just the held nodes behind it."""
    held, x = request.held.all(axis=1), request.points
    if (request.held.any(axis=1) != held).any() or request.value.any() or not held.any():
        cannot("holds nodes of one side, in all components, at rest: no rollers, no displacement")
    for normal in np.concatenate([np.eye(3), -np.eye(3)]):
        depth = x @ normal
        if depth[held].max() < depth[~held].min():
            return normal * (depth[held].max() + depth[~held].min()) / 2, normal
    return cannot("holds the nodes behind a plane along an axis; the held ones are no such set")


def answer(request):
    """The answer: what it is about, and its arrays."""
    law = setting(request, "law", tuple(LAWS))
    dt, limit = setting(request, "dt", 0.01), setting(request, "limit", 2000)
    if request.kind != "tetra":
        cannot(f"bodies are of tetrahedra, not of {request.kind}")
    if request.task == "rest" and request.force.any():
        cannot("no forces on nodes can be given")
    if law == "neo_hookean" and request.material.nu == 0:
        cannot("neo_hookean divides by lambda, which is 0 where nu is 0")
    dt = dt if request.task == "rest" else request.dt
    about, arrays = move(request, _Body(request, law, dt), each_step=True, limit=limit)
    if about["at_rest"]:
        about["at_rest"]["residual"] = 1e-6  # where its solver stops: with less it takes no step
    about |= {"simulator": "drake", "version": version("drake"), "law": law, "dt": dt}
    if law in ("corotated", "neo_hookean"):
        about["solves_to"] = 0.01  # of its first residual, where Newton's iteration stops
    about |= {"precision": "float64", "mass": "one point", "forces_at": "end"}
    return {**about, "settings": {"law": [law, ""]}}, arrays


run(answer)
