"""Elements and loads compared with scikit-fem's own elasticity, `condense` and `solve`."""

from dataclasses import replace

import numpy as np
import pytest
import skfem
from skfem.models.elasticity import lame_parameters, linear_elasticity, plane_stress

from msvalidate.problem import BodyForce, Box, Isotropic, Mesh, Problem, Support, Traction, Zone
from reference_fem import box_discretisation, mesh_discretisation, solve_problem
from reference_fem.body import nodal_forces
from reference_fem.elasticity import stiffness
from reference_fem.materials import materials_of
from reference_fem.mesh import ELEMENTS, facets

EQUAL = 1e-11  # rounding of 1e-16 times a condition number of at most 1e5
NOTICED = 1e-9  # relative change of one modulus, which the comparison must notice
STATES = {2: ("plane_stress", "plane_strain"), 3: ("solid",)}
CASES = [(name, state) for name, kind in ELEMENTS.items() for state in STATES[kind.dim]]
MOVE, PULL, PUSH = (3e-3, -1e-3, 2e-3), (300.0, 200.0, -100.0), (40.0, -50.0, 20.0)


def bent_body(element, state, change=0.0):
    """Problem with two zones on a bent mesh, its elements, and masks of the nodes at both ends."""
    kind, d = ELEMENTS[element], ELEMENTS[element].dim
    flat = box_discretisation(Box((2.0, 1.0, 0.5)[:d]), (4, 2, 1)[:d], element)
    x = flat.points + 0.2 * np.roll(np.sin(flat.points), 1, axis=1)
    mesh, ends = Mesh(x, flat.cells, kind.shape), flat.points[:, 0] == [[0.0], [2.0]]
    start, end = (mesh.surface[at[mesh.surface].all(axis=1)] for at in ends)
    half = np.flatnonzero(flat.points[flat.cells, 0].max(axis=1) < 1.1)
    mesh = mesh.named({"start": start, "end": end}, {"stiff": half})
    soft = Isotropic(2e6, 0.3, state, thickness=0.2 if d == 2 else 1.0)
    zone = Zone(mesh.zone("stiff"), replace(soft, E=9e6 * (1 + change), nu=0.4))
    loads = (Traction(mesh.side("end"), PULL[:d]), BodyForce(PUSH[:d]))
    problem = Problem(mesh, soft, (Support(mesh.side("start"), MOVE[:d]),), loads, zones=(zone,))
    return problem, mesh_discretisation(mesh), ends


def by_scikit_fem(problem, body, ends):
    """Stiffness, load vector and solution by scikit-fem, component-major in the order of nodes."""
    kind, mesh, law = body.element, body.basis.mesh, materials_of(problem, body)
    vector, curved = skfem.ElementVector(kind.function), body.basis.mapping.mesh
    mapping = skfem.MappingIsoparametric(curved, kind.function, kind.side) if body.curved else None
    basis = skfem.Basis(mesh, vector, mapping, quadrature=body.basis.quadrature)
    lame = plane_stress if problem.material.state == "plane_stress" else lame_parameters
    moduli = np.array([lame(each.E, each.nu) for each in law.materials])[law.number]
    K = law.thickness * linear_elasticity(*moduli.T[..., None]).assemble(basis)
    start, end = (np.flatnonzero(at[body.vertices][mesh.facets].all(axis=0)) for at in ends)
    cells = skfem.Basis(mesh, vector, mapping, 2 * kind.degree + 2)
    side = skfem.FacetBasis(mesh, vector, mapping, facets.CURVED_ORDER, facets=end)
    force = skfem.LinearForm(lambda v, w: sum(map(np.multiply, w.f, v)))
    load = law.thickness * (force.assemble(side, f=PULL) + force.assemble(cells, f=PUSH))
    order = np.empty((body.dim, len(body.points)), dtype=int)
    order[:, body.cell_nodes.T] = [basis.element_dofs[i :: body.dim] for i in range(body.dim)]
    u = np.tile(MOVE[: body.dim], len(body.points))  # each node's components follow each other
    u = skfem.solve(*skfem.condense(K, load, x=u, D=basis.get_dofs(start)))
    return K.toarray()[np.ix_(order.ravel(), order.ravel())], load[order.ravel()], u[order.ravel()]


@pytest.mark.parametrize(("element", "state"), CASES)
def test_stiffness_load_and_solution_are_those_of_scikit_fem(element, state):
    reference = by_scikit_fem(*bent_body(element, state))
    for change in (0.0, NOTICED):
        problem, body, _ = bent_body(element, state, change)
        K = stiffness(body, materials_of(problem, body)).toarray()
        fields = nodal_forces(problem, body), solve_problem(problem, body).displacement
        pairs = zip((K, *(field.T.ravel() for field in fields)), reference, strict=True)
        equal = [np.abs(a - b).max() <= EQUAL * np.abs(b).max() for a, b in pairs]
        assert (body.curved, *equal) == (body.element.degree > 1, not change, True, not change)
