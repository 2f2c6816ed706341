"""Bodies of the patch tests: MacNeal and Harder's patches in elements, and in springs."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

import reference_fem
from msvalidate import kit
from msvalidate.springs.network import tangent
from reference_fem.elasticity import stiffness

MODULUS, THICKNESS = 1e6, 1e-3
"""Pa, and m of the plane patch."""
GRADIENT = {
    2: 1e-3 * np.array([[1.0, 0.5], [0.5, 1.0]]),
    3: 1e-3 * (np.eye(3) + 1) / 2,
}
"""∂u_i/∂x_j of the prescribed field, by the number of axes."""
PATCH, CUBE = kit.Box((0.24, 0.12)), kit.Box((1.0, 1.0, 1.0))
CORNERS = {
    2: ((0, 0), (0.24, 0), (0.24, 0.12), (0, 0.12)),
    3: ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)),
}
INNER = {
    2: ((0.04, 0.02), (0.18, 0.03), (0.16, 0.08), (0.08, 0.08)),
    3: (
        (0.249, 0.342, 0.192),
        (0.826, 0.288, 0.288),
        (0.850, 0.649, 0.263),
        (0.273, 0.750, 0.230),
        (0.320, 0.186, 0.643),
        (0.677, 0.305, 0.683),
        (0.788, 0.693, 0.644),
        (0.165, 0.745, 0.702),
    ),
}
"""The published places (m), in the order of the outline's own corners."""
FOLDED, UNFOLDED = 4, (0.320, 0.220, 0.643)
"""Of the published hexahedra one is folded: its Jacobian is -0.013 m³ at this inner point, which no
Gauss point of a trilinear cell sees. Hexahedra take the point 34 mm farther in."""
QUADRILATERALS = ((0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7), (4, 5, 6, 7))
FACES = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (0, 4, 7, 3))
"""Of a hexahedron, counter-clockwise as seen from outside."""
HEXAHEDRA = (tuple(range(8, 16)), *(tuple(8 + c for c in face) + face for face in FACES))


@dataclass(frozen=True, eq=False)
class Patch:
    """A patch's points (n, d) in m, their displacements (m), its cells, and mean stress (Pa).

    The stress is that of the forces on the outline, Σ x f/volume: the mean over the patch, whatever
    is inside. `at_points`: (n, 3 or 6) in Pa as elements give it at the points; springs have none.
    """

    points: kit.Array
    move: kit.Array
    cells: int
    stress: kit.Array
    at_points: kit.Array | None = None

    @property
    def off(self) -> kit.Array:
        """Displacement less the exact one, (n, d), over the largest exact one."""
        exact = self.points @ GRADIENT[self.points.shape[1]]
        return np.asarray((self.move - exact) / np.abs(exact).max())

    @property
    def worst(self) -> float:
        """Displacement of the point farthest off along an axis, as 1 + its part off."""
        return float(1 + self.off.flat[np.abs(self.off).argmax()])


def problem(domain: kit.Domain, nu: float) -> kit.Problem:
    """Body whose outline is moved by the linear field."""
    d = domain.dim
    field = tuple(lambda points, a=a: points @ GRADIENT[d][a] for a in range(d))
    parts: list[kit.Part]
    if isinstance(domain, kit.Mesh):
        parts = [domain.whole_surface]
    elif isinstance(domain, kit.Polygon):
        parts = [kit.Segment(a, b) for a, b in pairwise((*domain.vertices, domain.vertices[0]))]
    else:
        parts = [domain.side(name) for name, (axis, _) in kit.SIDES.items() if axis < d]
    material = (
        kit.Isotropic(E=MODULUS, nu=nu, thickness=THICKNESS)
        if d == 2
        else kit.Isotropic(E=MODULUS, nu=nu, state="solid")
    )
    return kit.Problem(
        domain, material, tuple(kit.Support(part, field) for part in parts), name="patch"
    )


def elastic_patch(element: str, nu: float) -> Patch:
    """The published patch in finite elements."""
    mesh = published(element[0])
    asked = problem(mesh, nu)
    body = reference_fem.mesh_discretisation(mesh, element)
    solution = reference_fem.solve_problem(asked, body)
    move = solution.displacement
    force = (stiffness(body, asked.material) @ move.T.ravel()).reshape(body.dim, -1).T
    volume = mesh.volume * asked.material.thickness
    mean = body.points.T @ force / volume
    return Patch(body.points, move, len(body.cells), mean, solution.stress(body.points))


def spring_patch(
    candidate: kit.DisplacementSolver, asked: kit.Problem, network: kit.Network, cells: int
) -> Patch:
    """A patch of the candidate's springs."""
    move = candidate(asked, network, "linear")
    force = (tangent(network, network.points) @ move.ravel()).reshape(move.shape)
    volume = asked.domain.volume * asked.material.thickness
    return Patch(network.points, move, cells, network.points.T @ force / volume)


def published(shape: str) -> kit.Mesh:
    """The published patch in quadrilaterals (Q) or hexahedra (H), or these cut up (P, T)."""
    if shape in "QP":
        points, cells = places(2), np.array(QUADRILATERALS)
        if shape == "Q":
            return kit.Mesh(points, cells, "quad")
        return kit.Mesh(
            points, np.concatenate([cells[:, [0, 1, 2]], cells[:, [0, 2, 3]]]), "triangle"
        )
    points, cells = places(3), np.array(HEXAHEDRA)
    if shape == "H":
        points[len(CORNERS[3]) + FOLDED] = UNFOLDED
        return kit.Mesh(points, cells, "hexahedron")
    return kit.Mesh(*cut_hexahedra(points, cells), "tetra")


def places(dim: int) -> kit.Array:
    """Corners of the outline, then the inner points (n, dim)."""
    return np.array(CORNERS[dim] + INNER[dim], dtype=float)


def cut_hexahedra(points: kit.Array, cells: kit.Index) -> tuple[kit.Array, kit.Index]:
    """Twelve tetrahedra of each hexahedron about a point in its middle.

    Every face is cut from its lowest number, so that neighbours agree.
    """
    middle = points[cells].mean(axis=1)
    pieces = []
    for cell, centre in zip(cells, len(points) + np.arange(len(cells)), strict=True):
        for face in cell[np.array(FACES)]:
            first, second, third, fourth = np.roll(face, -int(face.argmin()))
            # Clockwise from outside is counter-clockwise from the centre.
            pieces += [(first, third, second, centre), (first, fourth, third, centre)]
    return np.concatenate([points, middle]), np.array(pieces)
