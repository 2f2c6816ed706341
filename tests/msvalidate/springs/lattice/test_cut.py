"""Lattices cut to an outline: what counts of a cell, loads, supports, and where they are exact."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from msvalidate.problem import (
    BodyForce,
    Box,
    Isotropic,
    Mesh,
    PointForce,
    Polygon,
    Problem,
    Region,
    Segment,
    Support,
    Traction,
)
from msvalidate.springs.bodies.cut_network import cut_network
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.lattice import cut_lattice, fill, patterns
from msvalidate.springs.lattice.cut import bridged_gaps, narrow_holes
from msvalidate.springs.network import tangent
from msvalidate.springs.statics.equilibrium import equilibrium
from tests.msvalidate.solids import bar
from tests.table import refused

THIRD = Isotropic(E=3.0, nu=1 / 3, density=500.0, thickness=0.3)
UNIT = Isotropic(E=1.0, nu=1 / 3)


# A lattice cut along its own lines is that lattice ------------------------------------------------


def test_a_lattice_cut_along_its_lines_is_the_one_that_fills_the_box():
    box = Box((2.0, 1.0))
    loads = (
        Traction(box.side("right"), lambda p: np.stack([1 + p[:, 1], p[:, 1]], axis=1)),
        BodyForce((0.0, -1.0)),
        PointForce((1.0, 1.0), (0.3, 0.4)),
    )
    problem = Problem(box, THIRD, (Support(box.side("left"), (0.0, 0.0)),), loads)
    ours = cut_network(problem, cut_lattice(patterns.square(), box, 0.25), volume=0.1)
    theirs = lattice_network(problem, fill(patterns.square(), box, (8, 4)), volume=0.1)
    one, two = (np.lexsort(network.points.T) for network in (ours, theirs))
    np.testing.assert_array_equal(ours.points[one], theirs.points[two])
    np.testing.assert_allclose(ours.mass[one], theirs.mass[two], rtol=1e-14)
    np.testing.assert_allclose(ours.force[one], theirs.force[two], rtol=0, atol=1e-15)
    found, wanted = equilibrium(ours).displacement[one], equilibrium(theirs).displacement[two]
    # A direct solve of 90 unknowns.
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-11 * np.abs(wanted).max())


def test_a_prism_of_whole_cubes_is_the_box_that_they_fill():
    box = Box((2.0, 1.0, 0.5))
    top = Traction(box.side("front"), lambda p: p * np.array([0.0, 1.0, 2.0]) + [1.0, 0.0, 0.0])
    solid = Isotropic(E=3.0, nu=1 / 4, state="solid", density=2.0)
    problem = Problem(box, solid, (Support(box.side("left"), (0.0,) * 3),), (top,))
    ours = cut_network(problem, cut_lattice(patterns.cubic18(), box, 0.25))
    theirs = lattice_network(problem, fill(patterns.cubic18(), box, (8, 4, 2)))
    one, two = (np.lexsort(network.points.T) for network in (ours, theirs))
    K, wanted = (np.sort(tangent(network, network.points).diagonal()) for network in (ours, theirs))
    np.testing.assert_allclose(K, wanted, rtol=1e-13)
    np.testing.assert_allclose(ours.mass[one], theirs.mass[two], rtol=1e-13)
    np.testing.assert_allclose(ours.force.sum(axis=0), theirs.force.sum(axis=0), rtol=1e-13)


def prism(bent=0.0):
    """Half of a tube of 16 sides, radii 0.5 and 1, height 0.4 m; its top at a slant if asked."""
    angle = np.linspace(0, np.pi, 17)
    rim = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    flat = np.concatenate([0.5 * rim, rim])
    i = np.arange(16)
    ring = np.stack([i, i + 17, i + 18, i + 1], axis=1)
    low, high = (np.column_stack([flat, np.full(34, z)]) for z in (0.0, 0.4))
    high[:, 2] += bent * high[:, 1]
    points, cells = np.concatenate([low, high]), np.concatenate([ring, ring + 34], axis=1)
    surface = Mesh(points, cells, "hexahedron").surface
    walls = surface[np.ptp(points[surface][..., 2], axis=1) > 0]
    return Mesh(points, cells, "hexahedron", {"walls": walls})


def test_a_prism_in_walls_that_follow_a_linear_displacement_follows_it():
    mesh = prism()
    slope = 0.01 * np.array([[1.0, 2.0, -1.0], [0.5, -1.0, 3.0], [0.0, 1.0, 2.0]])
    field = tuple(lambda p, i=i: p @ slope[:, i] for i in range(3))
    solid = Isotropic(E=1.0, nu=1 / 4, state="solid")
    sides = (mesh.side("walls"), Region((None, None, 0.0)), Region((None, None, 0.4)))
    whole = Problem(mesh, solid, tuple(Support(side, field) for side in sides))
    lattice = cut_lattice(patterns.cubic18(), mesh, 0.05)
    network = cut_network(whole, lattice)
    found = equilibrium(network).displacement
    assert (~network.fixed).sum() > 1000
    np.testing.assert_allclose(found, lattice.points @ slope, rtol=0, atol=1e-13)


def bent_tube(parts=4):
    """Quarter of a tube, radii 0.5 and 1, height 0.2 m, its cells with parabolas for edges."""
    base, ring = ((0, 0), (2, 0), (2, 2), (0, 2)), ((1, 0), (2, 1), (1, 2), (0, 1))
    cube = [(*at, k) for nodes in (base, ring) for k in (0, 2) for at in nodes]
    cube += [(*at, 1) for at in base]
    cube += [(0, 1, 1), (2, 1, 1), (1, 0, 1), (1, 2, 1), (1, 1, 0), (1, 1, 2), (1, 1, 1)]
    number = np.arange(27 + 18 * (parts - 1)).reshape(2 * parts + 1, 3, 3)  # round, out, up
    cells = [[number[2 * part + j, i, k] for i, j, k in cube] for part in range(parts)]
    turn, out, up = np.stack(np.meshgrid(*map(np.arange, number.shape), indexing="ij"), -1).T
    angle, r = (turn * np.pi / (4 * parts)).T.ravel(), (0.5 + out / 4).T.ravel()
    points = np.column_stack([r * np.cos(angle), r * np.sin(angle), up.T.ravel() / 10])
    surface = Mesh(points, np.array(cells), "hexahedron27").surface
    outer = surface[(np.linalg.norm(points[surface][..., :2], axis=2) > 1 - 1e-9).all(axis=1)]
    return Mesh(points, np.array(cells), "hexahedron27", {"outer": outer})


def test_bent_walls_of_a_solid_hold_the_points_of_the_cells_they_run_through():
    mesh = bent_tube()
    supports = tuple(
        Support(side, (0.0, 0.0, 0.0)) for side in (mesh.side("outer"), Region((None, None, 0.0)))
    )
    lattice = cut_lattice(patterns.cubic18(), mesh, 0.1)
    assert lattice.point_volume.sum() == pytest.approx(np.pi / 4 * 0.75 * 0.2, rel=2e-3)
    solid = Isotropic(E=1.0, nu=1 / 4, state="solid")
    held = cut_network(Problem(mesh, solid, supports), lattice).fixed.all(axis=1)
    radius = np.linalg.norm(lattice.points[:, :2], axis=1)
    above = lattice.points[:, 2] > 0.05
    # Corners of cells with body on both sides of the circle, and of no others.
    cells = radius[lattice.cells]
    runs = (cells.min(axis=1) < 1 - 1e-3) & (cells.max(axis=1) > 1 + 1e-3)
    expected = np.zeros(len(held), dtype=bool)
    expected[lattice.cells[runs]] = True
    assert expected[above].sum() > 40
    assert (held[above] | ~expected[above]).all()
    assert (np.abs(radius[held & above] - 1) < np.sqrt(2) * lattice.spacing).all()


# Loads and supports on an outline that the lattice does not follow --------------------------------


def test_loads_have_their_resultants_on_any_outline():
    domain = Polygon(((0.0, 0.1), (2.0, 0.0), (1.7, 1.5), (0.2, 1.1)))
    edge = Segment((2.0, 0.0), (1.7, 1.5))
    loads = (
        Traction(edge, lambda p: np.stack([p[:, 0] + 2 * p[:, 1], 1 - p[:, 1]], axis=1)),
        PointForce((0.71, 0.53), (1.0, -2.0)),
        BodyForce((0.5, -9.81)),
    )
    held = (Support(Segment((0.2, 1.1), (0.0, 0.1)), (0.0, 0.0)),)
    lattice = cut_lattice(patterns.square(), domain, 0.11)
    network = cut_network(Problem(domain, THIRD, held, loads), lattice)
    s, w = np.polynomial.legendre.leggauss(4)
    places = np.array([2.0, 0.0]) + (s[:, None] + 1) / 2 * np.array([-0.3, 1.5])
    pull = np.stack([places[:, 0] + 2 * places[:, 1], 1 - places[:, 1]], axis=1)
    pull *= 0.3 * (w / 2 * np.hypot(0.3, 1.5))[:, None]
    own = 0.3 * lattice.point_volume.sum() * np.array([0.5, -9.81])
    total = pull.sum(axis=0) + np.array([1.0, -2.0]) + own
    np.testing.assert_allclose(network.force.sum(axis=0), total, rtol=1e-12)
    moment = np.cross(np.pad(places, ((0, 0), (0, 1))), np.pad(pull, ((0, 0), (0, 1))))[:, 2].sum()
    found = (lattice.points[:, 0] * network.force[:, 1]).sum()
    found -= (lattice.points[:, 1] * network.force[:, 0]).sum()
    moment += 0.71 * -2.0 - 0.53 * 1.0
    x = lattice.points * (network.mass / 500)[:, None]
    moment += (x[:, 0] * -9.81 - x[:, 1] * 0.5).sum()
    assert found == pytest.approx(moment, rel=1e-12)


def test_a_linear_displacement_prescribed_all_round_is_exact():
    domain = Polygon(((0.0, 0.1), (2.0, 0.0), (1.7, 1.5), (0.2, 1.1)))
    slope = np.array([[0.01, 0.02], [-0.005, 0.03]])
    corners = [*domain.vertices, domain.vertices[0]]
    parts = tuple(
        Support(Segment(a, b), tuple(lambda p, i=i: p @ slope[:, i] for i in (0, 1)))
        for a, b in pairwise(corners)
    )
    lattice = cut_lattice(patterns.square(), domain, 0.1)
    found = equilibrium(cut_network(Problem(domain, UNIT, parts), lattice)).displacement
    # A direct solve of a few hundred unknowns.
    np.testing.assert_allclose(found, lattice.points @ slope, rtol=0, atol=1e-13)


def test_a_support_off_the_lattice_is_refused(pressed_ring):
    problem = pressed_ring
    lattice = cut_lattice(patterns.square(), problem.domain, 0.1, origin=(0.05, 0.0))
    with refused("no line of the cut lattice runs along x = 0 m; choose a spacing at which"):
        cut_network(problem, lattice)


# What is refused ----------------------------------------------------------------------------------


def test_bodies_and_lattices_that_do_not_fit_are_refused():
    box, solid = Box((1.0, 1.0)), Box((1.0, 1.0, 0.5))
    with refused("FCC lattice: not of one point in cubes or squares"):
        cut_lattice(patterns.fcc(), solid, 0.1)
    with refused("square lattice: a box 1 x 1 x 0.5 m; give one of 2D"):
        cut_lattice(patterns.square(), solid, 0.1)
    with refused("no cell of 40 m has more than 0.01 of it inside the body"):
        cut_lattice(patterns.square(), box, 40.0)
    with refused("cut lattice: origin (0.0,); give two coordinates"):
        cut_lattice(patterns.square(), box, 0.1, origin=(0.0,))
    with refused("cut lattice: origin (0.0,); give two or three coordinates"):
        cut_lattice(patterns.cubic18(), solid, 0.1, origin=(0.0,))
    with refused("body: None; give a Box or a Polygon or a Mesh"):
        cut_lattice(patterns.square(), None, 0.1)


@pytest.mark.parametrize(
    "body",
    [
        Polygon(((0.0, 0.0), (3.0, 0.0), (3.0, 2.0), (0.0, 2.0))),
        bar((3.0, 2.0, 1.0), (3, 2, 1)),
        Box((3.0, 2.0)),
        Box((3.0, 2.0, 1.0)),
    ],
    ids=str,
)
def test_points_on_the_surface_are_in_the_body(body):
    pattern = patterns.square() if body.dim == 2 else patterns.cubic18()
    assert cut_lattice(pattern, body, 0.25).inside.all()
    beyond = cut_lattice(pattern, body, 0.29)
    top = np.array(body.span).T[1]
    np.testing.assert_array_equal(beyond.inside, (beyond.points <= top).all(axis=1))
    assert 0.5 < beyond.inside.mean() < 1


def test_places_to_interpolate_at_must_fit():
    lattice = cut_lattice(patterns.square(), Box((1.0, 1.0)), 0.25)
    with refused("places: shape (2,); give (q, 2)"):
        lattice.weights_at(np.zeros(2))
    with refused("places: nan"):
        lattice.weights_at(np.full((1, 2), np.nan))


def test_supports_that_hold_every_point_are_refused(quarter_ring):
    ring = quarter_ring((1.0, 1.0), (2.0, 2.0))
    held = (Support(ring.side("outer"), (0.0, 0.0)), Support(ring.side("inner"), (0.0, 0.0)))
    with refused("its supports hold every point at a spacing of 1 m; choose a smaller one"):
        cut_network(Problem(ring, THIRD, held), cut_lattice(patterns.square(), ring, 1.0))


def test_a_point_force_outside_the_outline_is_refused_and_on_it_is_not(quarter_ring):
    ring = quarter_ring((1.0, 1.0), (2.0, 2.0))
    held = (Support(ring.side("outer"), (0.0, 0.0)),)
    lattice = cut_lattice(patterns.square(), ring, 0.25)
    for place in ((0.2, 0.2), (1.9, 1.9)):  # inside the hole, and in a corner of the ring's span
        with refused("outside the body, as in a hole; choose a place in it"):
            cut_network(Problem(ring, THIRD, held, (PointForce(place, (1.0, 0.0)),)), lattice)
    rim = cut_network(Problem(ring, THIRD, held, (PointForce((1.0, 0.0), (1.0, 0.0)),)), lattice)
    np.testing.assert_allclose(rim.force.sum(axis=0), [1.0, 0.0], atol=1e-14)


def test_a_lattice_cut_to_another_body_is_refused(pressed_ring):
    lattice = cut_lattice(patterns.square(), Box((1.0, 1.0)), 0.1)
    with refused("build it from the problem's own"):
        cut_network(pressed_ring, lattice)


def test_a_cut_lattice_needs_a_network_of_its_own(pressed_ring):
    lattice = cut_lattice(patterns.square(), pressed_ring.domain, 0.1)
    with refused("its points miss the outline; give cut_network"):
        lattice_network(pressed_ring, lattice)


def test_gaps_that_are_narrower_than_cells_are_seen():
    def gaps(corners, side=0.1):
        return bridged_gaps(cut_lattice(patterns.square(), Polygon(corners), side))

    around = ((0.0, 0.0), (2.0, 0.0), (2.0, 1.0))
    slit = (*around, (1.001, 1.0), (1.001, 0.32), (0.999, 0.32), (0.999, 1.0), (0.0, 1.0))
    assert len(gaps(slit)) >= 6
    wide = (*around, (1.26, 1.0), (1.26, 0.32), (0.94, 0.32), (0.94, 1.0), (0.0, 1.0))
    assert not len(gaps(wide))
    assert not len(gaps((*around, (0.0, 1.0))))
    turn = 2 * np.pi * np.arange(60) / 60
    ring = tuple(zip(0.53 + 0.5 * np.cos(turn), 0.51 + 0.5 * np.sin(turn), strict=True))
    assert not len(gaps(ring))


def test_holes_narrower_than_two_cells_are_told():
    grid = fill(patterns.square(), Box((1.0, 1.0)), (5, 5))
    frame = Mesh(grid.points, np.delete(grid.cells, 12, axis=0), "quad")  # its hole 0.2 m wide
    assert not len(narrow_holes(cut_lattice(patterns.square(), frame, 0.099)))
    (found,) = narrow_holes(cut_lattice(patterns.square(), frame, 0.101))
    assert found == pytest.approx([0.5, 0.5, 0.2], rel=1e-2)
