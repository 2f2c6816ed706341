"""Multigrid over nested meshes: it agrees with a factor, its spaces are nested, no chance in it."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

from msvalidate.problem import (
    Box,
    Isotropic,
    Mesh,
    Problem,
    Region,
    SolverError,
    Support,
    Traction,
    Zone,
)
from reference_fem import box_discretisation, make_discretisation, mesh_discretisation
from reference_fem.body import solve_by
from reference_fem.elasticity import make_solver, stiffness, thickness_tensors
from reference_fem.materials import numbers_of
from reference_fem.mesh.subdivide import children_of
from reference_fem.systems.nested import Nested

BOX = Box((1.2, 0.8, 1.0))
SOFT, STIFF = Isotropic(1e5, 0.3, "solid"), Isotropic(2e6, 0.1, "solid")
ROLLERS = (
    Support(BOX.side("left"), (1e-2, None, None)),
    Support(BOX.side("bottom"), (None, -1e-2, None)),
    Support(BOX.side("back"), (None, None, lambda x: 1e-2 * x[:, 0])),
)
CLAMPS = (
    Support(BOX.side("left"), (0.0, 0.0, 0.0)),
    Support(BOX.side("right"), (0.02, None, 0.01)),
)
PULL = Traction(BOX.side("top"), lambda x: 1e3 * x[:, [1, 2, 0]])


def nested(problem, first, levels):
    """The solution by nested meshes, and the factor's on the last of them."""
    solution, ready = solve_by(problem, first, make_solver)
    for _ in range(levels):
        body, finer = children_of(solution.body)

        def make(body, law, held, coarser=ready, finer=finer, found=solution):
            start, tensor = finer @ found.displacement, thickness_tensors(law)
            return Nested(body, held, tensor, numbers_of(law), coarser, finer, start)

        solution, ready = solve_by(problem, body, make)
    return solution, solve_by(problem, body, partial(make_solver, choice="superlu"))[0]


@pytest.mark.parametrize(
    ("element", "supports", "cells", "levels"),
    [("H2", ROLLERS, 1, 2), ("H2", CLAMPS, (2, 1, 2), 1), ("T2", CLAMPS, 1, 2)],
)
def test_cycles_agree_with_a_factor(element, supports, cells, levels):
    half = Zone(Region(((0.0, 0.6), None, None)), STIFF) if cells != 1 else None
    problem = Problem(BOX, SOFT, supports, (PULL,), zones=(half,) if half else ())
    first = box_discretisation(BOX, cells, element)
    found, direct = nested(problem, first, levels)
    assert found.solved.choice == "nested"
    assert 0 < found.solved.steps < 30
    size = np.abs(direct.displacement).max()
    away = np.abs(found.displacement - direct.displacement).max() / size
    assert away <= min(1e-8, found.error + direct.error)
    again, _ = nested(problem, first, levels)
    np.testing.assert_array_equal(again.displacement, found.displacement)


def bent(element):
    """A quarter of a ring, its sides bent."""
    even = box_discretisation(Box((1.0, 1.0, 1.0)), (1, 2, 1), element)
    x, y, z = even.points.T
    turned = np.column_stack([(1 + x) * np.cos(y), (1 + x) * np.sin(y), z + 0.1 * x * y])
    return make_discretisation(turned, even.cells, element)


@pytest.mark.parametrize("element", ["H2", "T2"])
def test_spaces_are_nested(element):
    for body in (bent(element), box_discretisation(BOX, (2, 1, 1), element)):
        fine, finer = children_of(body)
        rng = np.random.default_rng(4)
        field = rng.normal(size=(len(body.points), 3))
        cell = body.points[body.cells]
        inside = (cell * rng.dirichlet(np.ones(cell.shape[1]), len(cell))[:, :, None]).sum(axis=1)
        if not body.curved:
            there = body.interpolation(inside) @ field
            np.testing.assert_allclose(fine.interpolation(inside) @ finer @ field, there, atol=1e-9)
            coarse = stiffness(body, SOFT).toarray()
            P = np.kron(np.eye(3), finer.toarray())
            np.testing.assert_allclose(P.T @ (stiffness(fine, SOFT) @ P), coarse, rtol=0, atol=1e-9)
        np.testing.assert_allclose(finer @ body.points, fine.points, rtol=0, atol=1e-12)
        volumes = [Mesh(one.points, one.cells, one.element.shape).volume for one in (body, fine)]
        assert volumes[1] == pytest.approx(volumes[0], rel=1e-12)


def test_what_does_not_come_down_is_refused(monkeypatch):
    monkeypatch.setattr("reference_fem.systems.nested.MOST_STEPS", 2)
    problem = Problem(BOX, SOFT, CLAMPS, (PULL,))
    with pytest.raises(SolverError, match="after 2 steps over nested meshes; take cells of better"):
        nested(problem, mesh_discretisation(box_mesh(), "H2"), 1)


def box_mesh():
    even = box_discretisation(BOX, (2, 1, 1), "H1")
    return Mesh(even.points, even.cells, "hexahedron")
