"""What a network on a lattice has exactly: uniform stress; matrix and loads of linear triangles."""

from __future__ import annotations

import numpy as np
import pytest

import reference_fem
from msvalidate.problem import (
    BodyForce,
    Box,
    Isotropic,
    Polygon,
    Problem,
    Region,
    Segment,
    Support,
    Traction,
)
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.lattice import diagonal_square, square, trapezium, triangular, zigzag_block
from msvalidate.springs.statics.equilibrium import equilibrium
from reference_fem.body import nodal_forces
from tests.table import refused, table

THIRD = Isotropic(E=3.0, nu=1 / 3, state="plane_stress", density=500.0, thickness=0.3)


def outlines():
    """A zigzag block, a trapezium, and the trapezium turned, each with triangles of 0.2 m."""
    bar = trapezium(0.2, (5, 3))
    c, s = np.cos(0.7), np.sin(0.7)
    turned = bar.corners @ np.array([[c, s], [-s, c]]) + [0.3, -0.1]
    return {
        "zigzag block": zigzag_block(1.0, (4, 5)),
        "trapezium": bar,
        "turned trapezium": Polygon(tuple(map(tuple, turned.tolist()))),
    }


OUTLINES = outlines()


def sides(corners):
    ends = zip(corners.tolist(), np.roll(corners, -1, axis=0).tolist(), strict=True)
    return [Segment(tuple(a), tuple(b)) for a, b in ends]


def edges(outline):
    return sides(outline.corners)


def outward(edge):
    along = np.subtract(edge.end, edge.start)
    return np.array([along[1], -along[0]]) / np.linalg.norm(along)


@pytest.mark.parametrize("name", OUTLINES)
def test_masses_and_constants_of_a_triangular_body(name):
    outline = OUTLINES[name]
    held = (Support(edges(outline)[0], (0.0, 0.0)),)
    network = lattice_network(Problem(outline, THIRD, held), triangular(outline, 0.2))
    assert network.mass.sum() == pytest.approx(500.0 * 0.3 * outline.volume, rel=1e-13)
    # k = √3/2·E·t, half of it on the boundary.
    values = np.sqrt(3) / 2 * 3.0 * 0.3 * np.array([0.5, 1.0])
    np.testing.assert_allclose(np.unique(network.stiffness.round(12)), values, rtol=1e-11)


@table("name", OUTLINES)
def test_the_lattice_of_another_polygon_is_refused(name):
    outline = OUTLINES[name]
    problem = Problem(outline, THIRD, (Support(edges(outline)[0], (0.0, 0.0)),))
    with refused("the problem's is a polygon of"):
        lattice_network(problem, triangular(trapezium(0.2, (5, 2)), 0.2))


def under_stress(lattice, corners):
    """Linear displacement under `STRESS` by tractions on all sides, from corner to corner."""
    xx, yy, xy = STRESS
    loads = tuple(
        Traction(side, tuple(np.array([[xx, xy], [xy, yy]]) @ outward(side)))
        for side in sides(corners)
    )
    first, second = (tuple(corner) for corner in corners[:2].tolist())
    held = (Support(Region(first), (0.0, 0.0)), Support(Region(second), (None, 0.0)))
    problem = Problem(lattice.domain, THIRD, held, loads)
    return equilibrium(lattice_network(problem, lattice)).displacement


STRESS = (0.7, -0.4, 0.3)
STRAIN = np.linalg.solve([[9 / 8, 3 / 8, 0], [3 / 8, 9 / 8, 0], [0, 0, 3 / 8]], STRESS) / 3.0
"""Plane stress, E = 3 Pa, nu = 1/3: C11 = 9E/8, C12 = C66 = 3E/8."""


def strained(points, level):
    """Displacement under `STRAIN`, 0 at the first place and along y at the second, in `level`."""
    (x, y), (along, up) = (points - level[0]).T, level[1] - level[0]
    exx, eyy, exy = STRAIN
    turn = -(exy / 2 * along + eyy * up) / along
    return np.stack([exx * x + (exy / 2 - turn) * y, (exy / 2 + turn) * x + eyy * y], axis=1)


@pytest.mark.parametrize("spacing", [0.2, 0.1])
@pytest.mark.parametrize("name", ["trapezium", "turned trapezium"])
def test_uniform_stress_is_exact_on_triangles_to_their_very_edge(name, spacing):
    outline = OUTLINES[name]
    lattice = triangular(outline, spacing)
    expected = strained(lattice.points, outline.corners[:2])
    found = under_stress(lattice, outline.corners)
    # A direct solve of a few hundred unknowns.
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("build", [square, diagonal_square])
def test_uniform_stress_is_exact_on_squares_but_not_where_they_are_cut(build):
    corners = np.array([(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)])
    worst = []
    for n in (4, 8, 16):
        lattice = build(Box((2.0, 1.0)), (2 * n, n))
        expected = strained(lattice.points, corners[:2])
        error = under_stress(lattice, corners) - expected
        worst.append(np.abs(error).max() / np.abs(expected).max())
    if build is square:
        assert max(worst) < 1e-12
    else:
        # Half the diagonals of the outermost cells are missing: first order in their size.
        assert worst[-1] > 1e-3
        assert 1.6 < worst[0] / worst[1] < 2.4
        assert 1.6 < worst[1] / worst[2] < 2.4


# The same matrix by another code --------------------------------------------------------------


def other_code(lattice):
    """Linear triangles of the reference on the cells of a lattice, node by node."""
    return reference_fem.make_discretisation(lattice.points, lattice.cells, "P1")


def linear(p):
    return np.stack([1 + 2 * p[:, 0] - p[:, 1], 3 * p[:, 1] - 1], axis=1)


@pytest.mark.parametrize("cells", [5, 10])
def test_a_patch_of_load_on_a_zigzag_block_is_that_of_linear_triangles(cells):
    lattice = triangular(zigzag_block(1.0, (4, cells)), 1.0 / cells)
    right = lattice.domain.span[0][1]
    problem = Problem(
        lattice.domain,
        THIRD,
        (Support(Region((right, None)), (0.0, 0.0)),),
        (Traction(Region((0.0, (0.4, 0.6))), linear), BodyForce((0.0, -1.0))),
    )
    wanted = nodal_forces(problem, other_code(lattice))
    network = lattice_network(problem, lattice)
    np.testing.assert_allclose(network.force, wanted, rtol=0, atol=1e-13 * np.abs(wanted).max())
    # So the answers are one as well; a direct solve of a few hundred unknowns on either side.
    found = equilibrium(network).displacement
    answer = reference_fem.solve_problem(problem, other_code(lattice)).displacement
    np.testing.assert_allclose(found, answer, rtol=0, atol=1e-11 * np.abs(answer).max())
