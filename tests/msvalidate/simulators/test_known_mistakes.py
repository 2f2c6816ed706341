"""Springs of an adapter with one known mistake each: bodies at rest show which one it is."""

from __future__ import annotations

import numpy as np
import pytest

from msvalidate.constants.stiffness import CAUCHY, central_modulus
from msvalidate.lattice import mesh_lattice
from msvalidate.problem import Isotropic
from msvalidate.problem.records import replace
from msvalidate.simulators.bodies.tetrahedra import of_law
from msvalidate.simulators.exchange.asked import Asked
from msvalidate.simulators.exchange.protocol import Answer, CannotRepresent
from msvalidate.simulators.verdict.judgement import judge_simulator
from msvalidate.simulators.verdict.sheet import sheet_of

PARTS = ("bodies",)
CAUCHY_SOLID = Isotropic(1e7, CAUCHY[3], "solid", 1000.0)
ELASTIC = Isotropic(3e4, 0.4, "solid", 50.0)


def springs(times=None, mass=lambda m: m, rest=1.0):
    """Springs on the edges of the mesh, all of `times` E h, or with the right constants."""

    def simulate(request):
        if request.task == "motion":
            raise CannotRepresent("no motion")
        points, law = request.mesh.points, request.material
        edges = mesh_lattice(request.mesh, "area", positive=True)
        a, b = edges.springs.T
        way = points[b] - points[a]
        length = np.linalg.norm(way, axis=1)
        k = central_modulus(replace(law, nu=CAUCHY[3]), 3, "springs") * edges.factor
        if times is not None:
            k = np.full(len(k), times * law.E * length.mean())
        K, load = np.zeros((points.size, points.size)), request.force.astype(float)
        load = load + np.outer(mass(request.mass), request.gravity)
        for i, j, stiffness, d, size in zip(a, b, k, way, length, strict=True):
            block, push = stiffness * np.outer(d, d) / size**2, stiffness * (rest - 1) * d
            for one, other, sign in ((i, i, 1), (j, j, 1), (i, j, -1), (j, i, -1)):
                K[3 * one : 3 * one + 3, 3 * other : 3 * other + 3] += sign * block
            load[i] -= push
            load[j] += push
        u, free = np.where(request.held, request.value, 0.0).ravel(), ~request.held.ravel()
        force = (load.ravel() - K @ u)[free]
        u[free] = np.linalg.solve(K[np.ix_(free, free)], force)
        about = {"simulator": "springs", "precision": "float64", "at_rest": {"residual": 0.0}}
        return Answer(displacement=u.reshape(points.shape), about=about)

    return simulate


def elements(change):
    def simulate(request):
        if request.task == "motion":
            raise CannotRepresent("no motion")
        return of_law("linear")(change(request))

    return simulate


def equal(mass):
    return np.full(len(mass), mass.mean())


MISTAKES = {
    "one k, E h": (springs(1.0), CAUCHY_SOLID, {"k alike"}),
    "one k, 3 E h": (springs(3.0), CAUCHY_SOLID, {"k alike"}),
    "one k, other ratio": (springs(0.5), ELASTIC, {"k alike"}),
    "springs, equal masses": (springs(mass=equal), CAUCHY_SOLID, {"equal masses"}),
    "springs, doubled masses": (springs(mass=lambda m: 2 * m), CAUCHY_SOLID, {"doubled mass"}),
    "elements, equal masses": (
        elements(lambda r: replace(r, mass=equal(r.mass))), ELASTIC, {"equal masses"},
    ),
    "elements, doubled masses": (
        elements(lambda r: replace(r, mass=2 * r.mass)), ELASTIC, {"modulus", "load"},
    ),
    "elements, half the load": (
        elements(lambda r: replace(r, force=r.force / 2, gravity=r.gravity / 2)), ELASTIC,
        {"law"},
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", MISTAKES)
def test_a_known_mistake_is_among_the_causes_and_a_factor_has_rivals(name):
    simulate, material, true = MISTAKES[name]
    asked = Asked(simulate)
    found = judge_simulator(asked, material, meshes=("tet4",), parts=PARTS)
    kinds = {cause.kind for cause in found.causes}
    lines = sheet_of(found, asked, PARTS).lines(name)
    assert true <= kinds, lines
    if "modulus" in kinds:
        assert kinds & {"load", "thickness", "doubled mass", "coarse springs"}, lines
    if "law" in kinds:
        assert "loads" in " ".join(lines)
