# SPDX-License-Identifier: MIT
"""NGSolve: elements of any order on the nodes' mesh, at rest or at given positions (6.2.2608).

Law: linear elasticity, sigma = 2 mu eps + lambda tr(eps) I, in `elasticity` below: the program has
no laws of materials of its own, a user writes the form, as here.

Settings: ``order`` of the elements (3), at rest. A motion of one step is answered by the forces of
elements of order 1, -K u: theirs are the nodes.

Elements of order 1 take forces and weight on the nodes. Those of higher order take the weight as
density times gravity, and each component of the forces as a traction: the one, linear on faces
whose corners all bear that component, that does the same work on linear fields. Where these faces
meet at an edge it is one value there for both, so that a component that differs between two sides
is not what was meant. A force on no such face stays at its node.

Traps: a component is held on faces whose corners all are; where a held node is on no such face, it
alone is held, which elements of high order feel less the finer they are: the notes count these.
"""

import sys
from importlib import metadata

import numpy as np
from exchange import cannot, refuse_unknown, run, setting

del sys.path[0]  # this file has the name of a module that is not in it
# ruff: noqa: E402
from netgen import meshing
from ngsolve import (
    H1,
    BilinearForm,
    CoefficientFunction,
    Grad,
    GridFunction,
    Id,
    InnerProduct,
    LinearForm,
    Mesh,
    SetNumThreads,
    Trace,
    VectorH1,
    ds,
    dx,
)

FACES = {
    "tetra": ((1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1)),
    "hexahedron": (
        (0, 3, 2, 1),
        (4, 5, 6, 7),
        (0, 1, 5, 4),
        (1, 2, 6, 5),
        (2, 3, 7, 6),
        (3, 0, 4, 7),
    ),
}


def answer(request):
    """Displacement of a body at rest, or its forces at `start`."""
    if request.kind not in FACES:
        cannot(f"cells {request.kind}: this adapter gives NGSolve tetra or hexahedron only")
    if request.task == "motion" and request.steps != 1:
        cannot(f"a motion of {request.steps} steps: this adapter asks NGSolve for statics alone")
    SetNumThreads(1)
    order = setting(request, "order", 3)
    refuse_unknown(request)
    moving = request.task == "motion"
    order = 1 if moving else order
    faces = outer_faces(request)
    held = [np.all(request.held[faces, a], axis=1) for a in range(3)]
    pulled = [np.all(request.force[faces, a], axis=1) for a in range(3)]
    marks = np.array(
        [*(np.where(h, "h", "-") for h in held), *(np.where(p, "p", "-") for p in pulled)]
    )
    names = ["".join(column) for column in marks.T]
    mesh = built(request, faces, names)
    space, stiffness = elasticity(request, mesh, order)
    shift = GridFunction(space)
    size = space.components[0].ndof
    dofs = np.arange(len(request.points))[:, None] + size * np.arange(3)
    vector = shift.vec.FV().NumPy()
    about = {
        "simulator": "NGSolve",
        "version": metadata.version("ngsolve"),
        "law": "linear",
        "settings": {"order": [order, ""]},
        "steps": 1,
        "dt": None,
        "precision": "float64",
        "mass": "consistent",
        "forces_at": "start",
        "at_rest": {},
        "notes": "",
    }
    product = shift.vec.CreateVector()
    if moving:
        vector[dofs] = request.start - request.points
        product.data = stiffness.mat * shift.vec
        return about, {"force": -product.FV().NumPy()[dofs]}
    vector[dofs[request.held]] = request.value[request.held]
    free, alone = space.FreeDofs(), 0
    for dof in dofs[request.held]:
        alone += bool(free[int(dof)])
        free[int(dof)] = False
    load = loaded(request, mesh, space, dofs, order)
    product.data = load - stiffness.mat * shift.vec
    for _ in range(2):  # the second takes what rounding of the first has left
        shift.vec.data += stiffness.mat.Inverse(free, "sparsecholesky") * product
        product.data = load - stiffness.mat * shift.vec
    left = abs(product.FV().NumPy()[np.array([bool(bit) for bit in free])]).max()
    about["notes"] = f"{alone} held components at single nodes" if alone else ""
    return {**about, "at_rest": {"residual": float(left)}}, {"displacement": vector[dofs]}


def outer_faces(request):
    """Nodes of the faces of one cell alone, in the order of that cell."""
    faces = np.concatenate([request.cells[:, list(face)] for face in FACES[request.kind]])
    _, first, count = np.unique(
        np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True
    )
    return faces[np.sort(first[count == 1])]


def built(request, faces, names):
    """NGSolve's mesh of the cells, its faces named."""
    mesh = meshing.Mesh(dim=3)
    points = [mesh.Add(meshing.MeshPoint(meshing.Pnt(*point))) for point in request.points]
    kinds = sorted(set(names))
    for number, name in enumerate(kinds, 1):
        mesh.Add(meshing.FaceDescriptor(surfnr=number, domin=1, bc=number))
        mesh.SetBCName(number - 1, name)
    for cell in request.cells:
        mesh.Add(meshing.Element3D(1, [points[node] for node in cell]))
    for face, name in zip(faces, names, strict=True):
        mesh.Add(meshing.Element2D(kinds.index(name) + 1, [points[node] for node in face]))
    return Mesh(mesh)


def elasticity(request, mesh, order):
    """The space with its supports, and the stiffness."""
    E, nu = request.material.E, request.material.nu
    mu, lam = E / 2 / (1 + nu), E * nu / (1 + nu) / (1 - 2 * nu)
    held = {f"dirichlet{a}": "." * i + "h.*" for i, a in enumerate("xyz")}
    space = VectorH1(mesh, order=order, **held)
    u, v = space.TnT()
    strain = (Grad(u) + Grad(u).trans) / 2
    stress = 2 * mu * strain + lam * Trace(strain) * Id(3)
    return space, BilinearForm(InnerProduct(stress, Grad(v)) * dx, symmetric=True).Assemble()


def spread(mesh, on, nodes, force):
    """The linear field on some faces that does the work of forces at their nodes."""
    space = H1(mesh, order=1, definedon=on)
    t, w = space.TnT()
    mass = BilinearForm(t * w * ds(definedon=on)).Assemble()
    field = GridFunction(space)
    at_nodes = field.vec.CreateVector()
    at_nodes[:] = 0.0
    at_nodes.FV().NumPy()[nodes] = force
    field.vec.data = mass.mat.Inverse(space.FreeDofs(), "sparsecholesky") * at_nodes
    return field


def loaded(request, mesh, space, dofs, order):
    """The load vector."""
    v = space.TestFunction()
    form = LinearForm(space)
    at_nodes = request.load
    if order > 1:
        density = request.material.density
        form += InnerProduct(CoefficientFunction(tuple(density * request.gravity)), v) * dx
        at_nodes = request.force.copy()
        for a in range(3):
            on = mesh.Boundaries("." * (3 + a) + "p.*")
            nodes = sorted({v.nr for element in on.Elements() for v in element.vertices})
            if nodes:
                form += spread(mesh, on, nodes, request.force[nodes, a]) * v[a] * ds(definedon=on)
                at_nodes[nodes, a] = 0.0
    form.Assemble()
    form.vec.FV().NumPy()[dofs] += at_nodes
    return form.vec


if __name__ == "__main__":
    run(answer)
