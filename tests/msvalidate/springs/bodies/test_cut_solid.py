"""Solids of any shape on cut lattices: supports and loads anywhere on the surface.

Closed forms: any body under a pressure p all round is u = -p x (1 - 2 nu)/E; a bar in tension is
linear. Both are exact on the lattice but for what is cut.
"""

from __future__ import annotations

import re

import numpy as np
import pytest

from msvalidate.problem import (
    BodyForce,
    Box,
    Isotropic,
    Mesh,
    PointForce,
    Problem,
    ProblemError,
    Region,
    Support,
    Traction,
)
from msvalidate.springs.bodies.cut_network import cut_network
from msvalidate.springs.lattice import cut_lattice, patterns
from msvalidate.springs.statics.equilibrium import equilibrium
from tests.msvalidate.solids import ball, bar, rotation

SOLID = Isotropic(E=1.0, nu=1 / 4, state="solid", density=500.0)
TURN = rotation(0.3, 0.5, 0.7)


def fields(slope):
    """Components of the displacement x ↦ x @ slope."""
    return tuple(lambda p, i=i: p @ slope[:, i] for i in range(3))


def deviation(problem, lattice, wanted):
    """RMS error of the displacement inside, relative to its mean."""
    u = equilibrium(cut_network(problem, lattice)).displacement[lattice.inside]
    right = wanted(lattice.points[lattice.inside])
    return float(np.sqrt(((u - right) ** 2).sum() / (right**2).sum()))


def test_a_bar_in_tension_converges_at_any_slope():
    along = TURN[:, 0]
    strain = 5 / 4 * np.outer(along, along) - np.eye(3) / 4
    mesh = bar((1.0, 0.5, 0.5), (1, 1, 1), "tetra", TURN)
    end = Support(mesh.side("left"), fields(strain))
    problem = Problem(mesh, SOLID, (end,), (Traction(mesh.side("right"), tuple(along)),))
    error = [
        deviation(problem, cut_lattice(patterns.cubic18(), mesh, 0.5 / n), lambda x: x @ strain)
        for n in (5, 10)
    ]
    # The end that is held begins up to half a cell early or late: of first order.
    assert error[1] < 0.02
    assert 0.8 < np.log(error[0] / error[1]) / np.log(2) < 1.4


def test_a_ball_under_pressure_converges():
    mesh = ball(2)

    def press(x):
        return -x / np.linalg.norm(x, axis=1)[:, None]

    supports = (
        Support(Region((0.0, 0.0, 0.0)), (0.0, 0.0, 0.0)),
        Support(Region((1.0, 0.0, 0.0)), (None, 0.0, 0.0)),
        Support(Region((0.0, 1.0, 0.0)), (None, None, 0.0)),
    )
    problem = Problem(mesh, SOLID, supports, (Traction(mesh.side("skin"), press),))
    error = [
        deviation(problem, cut_lattice(patterns.cubic18(), mesh, 2 / n), lambda x: -x / 2)
        for n in (6, 14)
    ]
    # The ball's own parabolas miss the sphere by 1e-3 of its volume.
    assert error[1] < 7e-3
    assert 1.2 < np.log(error[0] / error[1]) / np.log(14 / 6) < 1.9


def test_tractions_have_their_resultants_on_any_facets():
    mesh = bar((1.0, 0.6, 0.5), (2, 1, 1), "hexahedron", TURN)
    lattice = cut_lattice(patterns.cubic18(), mesh, 0.07)
    held = (Support(mesh.side("left"), (0.0, 0.0, 0.0)),)

    def pull(x):
        own = x @ TURN  # from 0 to 0.6 and 0.5 m across the bar
        return np.stack([own[:, 1], 2 - own[:, 2], own[:, 1] * 0 + 1], axis=1)

    load = Traction(mesh.side("right"), pull)
    force = cut_network(Problem(mesh, SOLID, held, (load,)), lattice).force
    np.testing.assert_allclose(force.sum(axis=0), [0.09, 0.525, 0.3], rtol=1e-12)
    moment = np.cross(lattice.points, force).sum(axis=0)
    s, w = np.polynomial.legendre.leggauss(4)
    y, z = (each.ravel() for each in np.meshgrid(0.3 * (s + 1), 0.25 * (s + 1), indexing="ij"))
    places = np.stack([np.ones(16), y, z], axis=1) @ TURN.T
    area = 0.3 * np.outer(w / 2, w / 2).ravel()[:, None]
    wanted = np.cross(places, area * pull(places)).sum(axis=0)
    np.testing.assert_allclose(moment, wanted, rtol=1e-12)


def test_parts_of_faces_of_a_box_and_broken_layers_take_loads_and_supports():
    box = Box((1.0, 1.0, 0.55))
    lattice = cut_lattice(patterns.cubic18(), box, 0.1)
    held = (Support(box.side("front"), (0.0, 0.0, 0.0)),)
    part = Region((1.0, (0.0, 0.47), (0.2, 0.5)))
    loads = (
        Traction(part, lambda p: np.stack([p[:, 1], p[:, 2], 1 + 0 * p[:, 0]], axis=1)),
        BodyForce((0.0, -1.0, 0.0)),
        PointForce((0.33, 0.5, 0.21), (0.0, 0.0, 3.0)),
    )
    network = cut_network(Problem(box, SOLID, held, loads), lattice)
    area = 0.47 * 0.3
    wanted = [area * 0.235, area * 0.35 - 0.55, area + 3.0]
    np.testing.assert_allclose(network.force.sum(axis=0), wanted, rtol=1e-12)
    # The face lies amid a layer: its points above, and those half a cell below.
    heights = np.unique(lattice.points[network.fixed[:, 0], 2])
    np.testing.assert_allclose(heights, [0.5, 0.6], rtol=1e-12)


def angle(order):
    """An L of three blocks of 0.5 m, its width of 0.5 m along an axis; sides by what they bear."""
    number = np.arange(16).reshape(2, 8)
    flat = np.array([(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (2, 1), (0, 2), (1, 2)]) / 2
    points = np.concatenate([np.column_stack([flat, np.full(8, z)]) for z in (0.0, 0.5)])
    quads = np.array([(0, 1, 4, 3), (1, 2, 5, 4), (3, 4, 7, 6)])
    cells = np.concatenate([number[0][quads], number[1][quads]], axis=1)
    surface = Mesh(points, cells, "hexahedron").surface
    at = points[surface]
    sides = {
        "foot": surface[(at[..., 0] == 1.0).all(axis=1)],
        "seat": surface[(at[..., 1] == 0.5).all(axis=1)],
    }
    return Mesh(points[:, order], cells, "hexahedron", sides)


def test_a_prism_along_another_axis_is_the_same_body():
    found = {}
    for order in ((0, 1, 2), (1, 2, 0)):
        mesh = angle(list(order))
        held = (Support(mesh.side("foot"), (0.0, 0.0, 0.0)),)
        pull = tuple(np.array([0.1, 0.2, 0.3])[list(order)])
        lattice = cut_lattice(patterns.cubic18(), mesh, 0.125)
        assert lattice.by_surface == (order != (0, 1, 2))
        problem = Problem(mesh, SOLID, held, (Traction(mesh.side("seat"), pull),))
        u = equilibrium(cut_network(problem, lattice)).displacement
        back = np.argsort(order)
        own = lattice.points[:, back]
        sorted_ = np.lexsort(np.rint(own / 0.125).T)
        found[order] = own[sorted_], u[:, back][sorted_]
    one, two = found.values()
    np.testing.assert_array_equal(one[0], two[0])
    np.testing.assert_allclose(one[1], two[1], rtol=0, atol=1e-11 * np.abs(one[1]).max())


def test_what_a_solid_cannot_take_is_refused_in_one_line():
    mesh = ball(0)
    lattice = cut_lattice(patterns.cubic18(), mesh, 0.3)
    held = (Support(mesh.side("skin"), (0.0, 0.0, 0.0)),)
    far = PointForce((0.9, 0.9, 0.9), (1.0, 0.0, 0.0))
    with pytest.raises(ProblemError, match=re.escape("outside the body, as in a hole; choose")):
        cut_network(Problem(mesh, SOLID, held, (far,)), lattice)
    point = (Support(Region((1.0, 0.0, 0.0)), (0.0, 0.0, 0.0)), *held)
    with pytest.raises(ProblemError, match="no point of the discretised body lies there"):
        cut_network(Problem(mesh, SOLID, point), lattice)
