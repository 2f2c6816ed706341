"""One problem on a box and on its mesh file; elements of a mesh's own cells."""

from __future__ import annotations

from itertools import cycle

import numpy as np
import pytest

from msvalidate.problem import (
    BodyForce,
    Box,
    Isotropic,
    Mesh,
    PointForce,
    Problem,
    Support,
    Traction,
)
from msvalidate.springs.bodies.mesh_file import read_mesh
from reference_fem import box_discretisation, mesh_discretisation, solve_problem
from reference_fem.mesh import ELEMENTS
from tests.msvalidate.springs.bodies.test_mesh_file import written
from tests.table import refused

ROUNDING = 1e-11
"""Relative: a condition number of 1e4 times the rounding of 1e-16, and the order of the sums."""


def box_of(element):
    return Box((2.0, 1.0, 0.5)[: ELEMENTS[element].dim])


def asked(domain, left, right, dim):
    """A clamped body that is pulled, pushed at a corner, and heavy."""
    material = Isotropic(E=1e6, nu=0.3, state="plane_stress" if dim == 2 else "solid")
    loads = (
        Traction(right, (300.0, 200.0, 100.0)[:dim]),
        BodyForce((0.0, -50.0, 20.0)[:dim]),
        PointForce((2.0, 1.0, 0.5)[:dim], (1.0, 2.0, 3.0)[:dim]),
    )
    return Problem(domain, material, (Support(left, (0.0,) * dim),), loads)


def mesh_of(body):
    """The same cells as a mesh with both ends named."""
    mesh = Mesh(body.points, body.cells, body.element.shape)
    sides = {
        name: mesh.surface[(np.abs(body.points[:, 0] - x) < 1e-9)[mesh.surface].all(axis=1)]
        for name, x in (("left", 0.0), ("right", 2.0))
    }
    return mesh.named(sides)


# Tests of mesh files show that every format gives the same mesh.
@pytest.mark.parametrize(
    ("element", "form"), list(zip(ELEMENTS, cycle(["gmsh22", "vtu", "vtk"]), strict=False))
)
def test_box_and_its_mesh_file_move_alike(element, form, tmp_path):
    box = box_of(element)
    body = box_discretisation(box, (4, 3, 2)[: box.dim], element)
    expected = solve_problem(asked(box, box.side("left"), box.side("right"), box.dim), body)
    path, names = written(mesh_of(body), tmp_path, form, binary=form.startswith("vt"))
    mesh = read_mesh(path)
    x = np.vstack([body.points, np.random.default_rng(0).random((20, box.dim)) * box.size])
    # Nor does it matter whether the sides are said by names or by coordinates.
    for ends in (map(mesh.side, names), map(box.side, ("left", "right"))):
        found = solve_problem(asked(mesh, *ends, box.dim), mesh_discretisation(mesh))
        for one, other in (
            (found.displacement, expected.displacement),
            (found.stress(x), expected.stress(x)),
        ):
            assert np.abs(one - other).max() <= ROUNDING * np.abs(other).max()


@pytest.mark.parametrize("element", [name for name, kind in ELEMENTS.items() if kind.degree == 2])
def test_quadratic_elements_on_linear_cells(element):
    box = box_of(element)
    cells = (4, 3, 2)[: box.dim]
    problem = asked(box, box.side("left"), box.side("right"), box.dim)
    quadratic = box_discretisation(box, cells, element)
    mesh = mesh_of(box_discretisation(box, cells, ELEMENTS[element].first.name))
    body = mesh_discretisation(mesh, element)
    assert len(body.points) == len(quadratic.points)
    on_mesh = asked(mesh, mesh.side("left"), mesh.side("right"), box.dim)
    found = solve_problem(on_mesh, body).displacement
    expected = solve_problem(problem, quadratic).at(body.points)
    assert np.abs(found - expected).max() <= ROUNDING * np.abs(expected).max()
    own = mesh_of(quadratic)
    again = solve_problem(
        asked(own, own.side("left"), own.side("right"), box.dim), mesh_discretisation(own)
    )
    assert np.abs(again.at(body.points) - expected).max() <= ROUNDING * np.abs(expected).max()


def test_elements_that_do_not_fit_the_cells_are_refused():
    mesh = mesh_of(box_discretisation(Box((2.0, 1.0)), (2, 2), "P1"))
    with refused("mesh: element 'Q1' on triangle cells; give P1 or P2"):
        mesh_discretisation(mesh, "Q1")
    mesh = mesh_of(box_discretisation(Box((2.0, 1.0)), (2, 2), "Q2"))
    with refused("mesh: element 'Q1' on quad9 cells; give Q2"):
        mesh_discretisation(mesh, "Q1")
    with refused("give a Mesh"):
        mesh_discretisation(Box((1.0, 1.0)))


def test_the_mesh_of_a_body_elsewhere_is_refused():
    mesh = mesh_of(box_discretisation(Box((2.0, 1.0)), (4, 3), "Q1"))
    moved = Mesh(mesh.points + 1.0, mesh.cells, mesh.shape)
    with refused("mesh the problem's own domain"):
        solve_problem(asked(mesh, *map(mesh.side, mesh.boundaries), 2), mesh_discretisation(moved))
