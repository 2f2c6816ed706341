"""Springs of a body of several materials: exact where zones end with cells, else of first order."""

from __future__ import annotations

import re

import numpy as np
import pytest

from msvalidate.problem import (
    Anisotropic,
    Ball,
    Box,
    Isotropic,
    Mesh,
    Problem,
    ProblemError,
    Region,
    Support,
    Traction,
    Weight,
    Zone,
    materials_at,
)
from msvalidate.springs.bodies.cut_network import cut_network
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.constants import zones
from msvalidate.springs.constants.stiffness import isotropic_tensor
from msvalidate.springs.constants.zones import calibrate_zones, material_fractions, spring_shares
from msvalidate.springs.lattice import (
    CutLattice,
    cut_lattice,
    fill,
    fill_rotated,
    mesh_lattice,
    patterns,
    square,
    voronoi_box,
)
from msvalidate.springs.statics.equilibrium import equilibrium
from msvalidate.springs.statics.stress import cell_stress
from reference_fem import box_discretisation, solve_problem
from tests.inclusion import RADIUS, ball, disc, disc_mesh
from tests.table import table

ROUNDING = 1e-14
LENGTH, PULL = 0.01, 3.0
MATERIALS = {
    "springs": ("plane_stress", (1e5, 1 / 3), (3e5, 1 / 3)),
    "plane stress": ("plane_stress", (1e5, 0.2), (3e5, 0.4)),
    "plane strain": ("plane_strain", (1e5, 0.2), (3e5, 0.4)),
    "solid": ("solid", (1e5, 0.2), (3e5, 0.4)),
}


def lattices(box, way):
    """A lattice of a box that has cells of a quarter."""
    if box.dim == 3:
        return {
            "filled": lambda: fill(patterns.cubic18(), box, (8, 4, 4)),
            "cut": lambda: cut_lattice(patterns.cubic18(), box, 0.25),
        }[way]()
    return {
        "filled": lambda: square(box, (8, 4)),
        "cut": lambda: cut_lattice(patterns.square(), box, 0.25),
    }[way]()


def pulled(name, series):
    """A bar whose sides cannot contract, loaded by a traction; or one whose end is moved."""
    state, *given = MATERIALS[name]
    first, second = (
        Isotropic(E, nu, state, density=rho)
        for (E, nu), rho in zip(given, (1000.0, 4000.0), strict=True)
    )
    box = Box((2.0, 1.0, 1.0)[: first.dim])
    free = (None,) * (box.dim - 2)
    rollers = [Support(box.side("left"), (0.0, None, *free))]
    rollers.append(Support(box.side("bottom"), (None, 0.0, *free)))
    if box.dim == 3:
        rollers += [Support(box.side(side), (None, None, 0.0)) for side in ("back", "front")]
    if series:
        rollers.append(Support(box.side("top"), (None, 0.0, *free)))
        loads = (Traction(box.side("right"), (PULL, *(0.0,) * (box.dim - 1))),)
        zone = Region(((1.0, 2.0), None, *free))
    else:
        rollers.append(Support(box.side("right"), (LENGTH, None, *free)))
        loads, zone = (), Region((None, (0.5, 1.0), *free))
    return Problem(box, first, tuple(rollers), loads, zones=(Zone(zone, second),))


def exact(problem, x, series):
    """Displacement (n, d) and the stress along the bar of the first and second material."""
    C = [tensor(material) for material in problem.materials]
    u, (a, b) = np.zeros(x.shape), np.clip(x.T[:2], 0.0, [[1.0], [0.5]])
    if series:
        u[:, 0] = PULL * (a / C[0][0, 0] + (x[:, 0] - a) / C[1][0, 0])
        return u, (PULL, PULL)
    ratio = [each[0, 1] / each[1, 1] for each in C]
    strain = LENGTH / 2
    u[:, 0] = strain * x[:, 0]
    u[:, 1] = -strain * (ratio[0] * b + ratio[1] * (x[:, 1] - b))
    return u, tuple(strain * (c[0, 0] - r * c[0, 1]) for c, r in zip(C, ratio, strict=True))


def tensor(material):
    """By E and nu of the axes: plane strain as plane stress of E/(1 - nu²) and nu/(1 - nu)."""
    E, nu = material.E, material.nu
    if material.state == "plane_strain":
        E, nu = E / (1 - nu**2), nu / (1 - nu)
    return isotropic_tensor(material.dim, E, nu)


def network_of(problem, lattice, constants=None):
    make = cut_network if isinstance(lattice, CutLattice) else lattice_network
    return make(problem, lattice, constants or calibrate_zones(problem, lattice))


@pytest.mark.parametrize("series", [True, False], ids=["series", "parallel"])
@table("name, way", [(name, way) for name in MATERIALS for way in ("filled", "cut")])
def test_bars_of_two_materials_are_exact(name, way, series):
    problem = pulled(name, series)
    if problem.domain.dim == 3 and way == "cut" and series:
        return  # tractions on walls are not for cut lattices
    lattice = lattices(problem.domain, way)
    network = network_of(problem, lattice)
    found = equilibrium(network)
    wanted, stress = exact(problem, network.points, series)
    assert np.abs(found.displacement - wanted).max() <= ROUNDING * np.abs(wanted).max()
    assert network.mass.sum() == pytest.approx(2500.0 * problem.domain.volume, rel=1e-12)
    shares = spring_shares(problem, lattice, calibrate_zones(problem, lattice))
    stresses = cell_stress(network, lattice, found, parts=shares)
    number = materials_at(problem, network.points[lattice.cells].mean(axis=1))
    np.testing.assert_allclose(stresses[:, 0], np.array(stress)[number], rtol=1e-12)
    if not series:
        np.testing.assert_allclose(stresses[:, 1], 0, atol=1e-12 * max(stress))
    if way == "filled":
        end = network.points[:, 0] == 0
        force = -found.reaction[end, 0].sum()
        assert force == pytest.approx(np.mean(stress), rel=1e-12)


@table("way", ["filled", "cut", "elements"])
def test_a_column_of_two_materials_under_its_weight(way):
    # σ(y) is the weight above over the area; springs on a grid have a chain's exact nodal values.
    tall, g = Box((1.0, 2.0)), 10.0
    low, high = (
        Isotropic(E, nu, "plane_strain", density=rho, thickness=0.5)
        for E, nu, rho in ((1e5, 0.2, 1000.0), (3e5, 0.4, 4000.0))
    )
    held = [Support(tall.side("bottom"), (None, 0.0))]
    held += [Support(tall.side(side), (0.0, None)) for side in ("left", "right")]
    zone = Zone(Region((None, (1.0, 2.0))), high)
    problem = Problem(tall, low, tuple(held), (Weight((0.0, -g)),), zones=(zone,))
    if way == "elements":
        body = box_discretisation(tall, (2, 4), "Q2")
        x, found = body.points, solve_problem(problem, body).displacement
    else:
        lattice = (
            square(tall, (4, 8)) if way == "filled" else cut_lattice(patterns.square(), tall, 0.25)
        )
        network = network_of(problem, lattice)
        x, found = network.points, equilibrium(network).displacement
        assert network.force[:, 1].sum() == pytest.approx(-g * 0.5 * 5000.0, rel=1e-12)
    M = [tensor(material)[0, 0] for material in problem.materials]
    a, b = np.minimum(x[:, 1], 1.0), np.maximum(x[:, 1] - 1.0, 0.0)
    wanted = (5000.0 * a - 1000.0 * a**2 / 2) / M[0] + 4000.0 * (b - b**2 / 2) / M[1]
    np.testing.assert_allclose(found[:, 1], -g * wanted, atol=1e-13 * g * wanted.max())
    assert np.abs(found[:, 0]).max() <= 1e-13 * g * wanted.max()


def tension(material, inner, p, q, n, centre=(1.013, 1.007)):
    """A square of side 2 cut out of an endless plate about a disc, and what it does."""
    box, middle = Box((2.0, 2.0)), np.array(centre)

    def moved(x):
        return disc(x - middle, material, inner, p, q)

    around = tuple(
        Support(box.side(side), (lambda x: moved(x)[:, 0], lambda x: moved(x)[:, 1]))
        for side in ("left", "right", "bottom", "top")
    )
    zone = Zone(Ball(centre, RADIUS), inner)
    return Problem(box, material, around, zones=(zone,)), square(box, n), moved


BOTH = ((1.0, 0.0), (0.0, 1.0))
"""Tension in the plane, and shear: sums of the two are any tension."""


def disc_error(ratio, rule, n, nu=(1 / 3, 1 / 3), state="plane_stress", tensions=BOTH):
    """Largest error of what a disc changes, of the largest change."""
    outer, inner = Isotropic(1.0, nu[0], state), Isotropic(ratio, nu[1], state)
    off = 0.0
    for p, q in tensions:
        problem, lattice, moved = tension(outer, inner, p, q, n)
        with pytest.MonkeyPatch.context() as patch:
            if rule:
                fractions = rule(material_fractions(problem, lattice), ratio)
                patch.setattr(zones, "material_fractions", lambda *_, given=fractions: given)
            network = network_of(problem, lattice)
        x, centre = network.points, np.array(problem.zones[0].region.centre)
        change = moved(x) - disc(x - centre, outer, outer, p, q)
        miss = equilibrium(network).displacement - moved(x)
        off = max(off, np.abs(miss).max() / np.abs(change).max())
    return off


@pytest.mark.parametrize(
    ("ratio", "nu", "state"),
    [(10.0, (0.3, 0.2), "plane_stress"), (0.1, (0.3, 0.45), "plane_strain")],
)
def test_a_disc_is_met_to_first_order(ratio, nu, state):
    coarse, fine = (disc_error(ratio, None, n, nu, state, BOTH[1:]) for n in (60, 120))
    assert np.log2(coarse / fine) > 0.75
    assert fine < 0.035


def test_a_ball_is_met_to_first_order():
    outer, inner = Isotropic(1.0, 0.25, "solid"), Isotropic(10.0, 0.3, "solid")
    box, errors = Box((1.0, 1.0, 1.0)), []

    def component(axis):
        return lambda x: ball(x, outer, inner, 1.0)[:, axis]

    sides = tuple(
        Support(box.side(side), tuple(component(axis) for axis in range(3)))
        for side in ("left", "right", "bottom", "top", "back", "front")
    )
    problem = Problem(box, outer, sides, zones=(Zone(Ball((0.0,) * 3, RADIUS), inner),))
    for n in (6, 12):
        network = network_of(problem, fill(patterns.cubic18(), box, n))
        wanted = ball(network.points, outer, inner, 1.0)
        change = wanted - ball(network.points, outer, outer, 1.0)
        miss = equilibrium(network).displacement - wanted
        errors.append(np.linalg.norm(miss) / np.linalg.norm(change))
    assert np.log2(errors[0] / errors[1]) > 0.75
    assert errors[1] < 0.025


def test_named_cells_in_a_cut_lattice():
    mesh, outer, inner = disc_mesh(2), Isotropic(1.0, 1 / 3), Isotropic(10.0, 1 / 3)
    held = (Support(mesh.whole_surface, (0.0, 0.0)),)
    lattice = cut_lattice(patterns.square(), mesh, 0.12, origin=(0.01, 0.02))
    named, round_ = (
        material_fractions(Problem(mesh, outer, held, zones=(Zone(region, inner),)), lattice)
        for region in (mesh.zone("disc"), Ball((0.0, 0.0), RADIUS))
    )
    # The disc's outline is of quadratic sides, and a place or two of 256 lie between.
    np.testing.assert_allclose(named, round_, atol=3 / 256)
    volume = lattice.corner_volume.sum(axis=1)
    assert volume @ named[:, 1] == pytest.approx(np.pi * RADIUS**2, rel=2e-3)


def test_a_mesh_has_its_edges_by_cell():
    # Equilateral springs and P1 elements are one where cells are: their energies are the test.
    body = box_discretisation(Box((2.0, 1.0)), (4, 2), "P1")
    mesh = Mesh(body.points, body.cells, "triangle", zones={"a": np.arange(3), "b": [2, 9]})
    laws = [Isotropic(E, 1 / 3, density=rho) for E, rho in ((1e5, 1.0), (3e5, 2.0), (7e5, 5.0))]
    parts = (Zone(mesh.zone("a"), laws[1]), Zone(mesh.zone("b"), laws[2]))
    held = (Support(mesh.whole_surface, (0.0, 0.0)),)
    lattice = mesh_lattice(mesh)
    network = lattice_network(Problem(mesh, laws[0], held, zones=parts), lattice)
    number = np.zeros(len(mesh.cells), dtype=int)
    number[:3], number[[2, 9]] = 1, 2
    E = np.array([law.E for law in laws])[number]
    wanted = np.bincount(lattice.of.ravel(), (E[:, None] * lattice.gifts).ravel())
    np.testing.assert_allclose(network.stiffness, wanted, rtol=1e-14)
    area = np.repeat(np.array([law.density for law in laws])[number] / 8 / 3, 3)
    np.testing.assert_allclose(network.mass, np.bincount(mesh.cells.ravel(), area), rtol=1e-13)


def test_a_zone_of_the_same_material_changes_nothing():
    plain = pulled("plane strain", series=True)
    same = Zone(Ball((1.1, 0.4), 0.33), plain.material)
    problem = Problem(plain.domain, plain.material, plain.supports, plain.loads, zones=(same,))
    lattice = square(plain.domain, (8, 4))
    alone = Problem(plain.domain, plain.material, plain.supports, plain.loads)
    found = network_of(problem, lattice)
    wanted = network_of(alone, lattice, *calibrate_zones(alone, lattice))
    np.testing.assert_allclose(found.stiffness, wanted.stiffness, rtol=1e-14)
    np.testing.assert_allclose(found.volumes.stiffness, wanted.volumes.stiffness, rtol=1e-12)
    np.testing.assert_array_equal(found.mass, wanted.mass)


BOX = Box((2.0, 1.0))
SHEET = Isotropic(1e5, 1 / 3)
GRID = square(BOX, (8, 4))
LEFT = (Support(BOX.side("left"), (0.0, 0.0)),)
TWO = Problem(BOX, SHEET, LEFT, zones=(Zone(Region(((1.0, 2.0), None)), Isotropic(3e5, 0.2)),))
TENSOR = Problem(
    BOX, SHEET, LEFT, zones=(Zone(Region(((1.0, 2.0), None)), Anisotropic(np.eye(3))),)
)
CAUCHY = Problem(BOX, SHEET, LEFT, zones=(Zone(Region(((1.0, 2.0), None)), SHEET),))
EACH = calibrate_zones(TWO, GRID)


@table("make, message", [
    (lambda: lattice_network(TWO, GRID, (1.0, 0.5)), "(1.0, 0.5) for 2 materials; give a tup"),
    (lambda: lattice_network(TWO, GRID, EACH[0]), "for 2 materials; give a tuple"),
    (lambda: lattice_network(TWO, GRID, EACH[:1]), "for 2 materials; give a tuple"),
    (lambda: lattice_network(TWO, GRID, EACH[::-1]), "calibrate the problem's own body"),
    (lambda: lattice_network(CAUCHY, GRID, volume=1.0), "volume stiffness: 1.0 for 2 material"),
    (lambda: lattice_network(TENSOR, GRID), "the material is a tensor; give the constants"),
    (lambda: calibrate_zones(TENSOR, GRID), "the material must be isotropic"),
    (lambda: calibrate_zones(TWO, GRID, route="springs"), "nu = 0.2"),
    (lambda: lattice_network(CAUCHY, voronoi_box(BOX, 0.2), ((1.0,), (2.0,))),
        "belong to no cells; take one that repeats"),
    (lambda: lattice_network(Problem(BOX, SHEET, LEFT, zones=(Zone(Ball((0.5, 0.5), 1e-4), SHEET),
        CAUCHY.zones[0])), GRID), "no cell has a part of it; take smaller cells"),
])  # fmt: skip
def test_what_is_refused(make, message):
    with pytest.raises(ProblemError, match=re.escape(message)) as refused:
        make()
    assert "\n" not in str(refused.value)


def test_constants_of_ones_own_go_one_a_material():
    network = lattice_network(TENSOR, GRID, ((1.0, 0.5), (4.0, 2.0)))
    middle = network.points[network.springs].mean(axis=1)
    first, second = (np.abs(middle[:, 0] - x) < 1 - 1e-9 for x in (0.0, 2.0))
    kinds = np.array([[1.0, 0.5], [4.0, 2.0]])[:, GRID.kind] * GRID.factor * GRID.share
    np.testing.assert_allclose(network.stiffness[first], kinds[0][first], rtol=1e-14)
    np.testing.assert_allclose(network.stiffness[second], kinds[1][second], rtol=1e-14)
    rest = ~first & ~second
    np.testing.assert_allclose(network.stiffness[rest], kinds.mean(axis=0)[rest], rtol=1e-14)
    turned = fill_rotated(patterns.square(), BOX, 0.2, 0.3)
    number = materials_at(TENSOR, turned.points)
    found = lattice_network(TENSOR, turned, ((1.0, 0.5), (4.0, 2.0)))
    inside = (number[turned.springs] == 0).all(axis=1) & (
        turned.points[turned.springs][..., 0] < 0.7
    ).all(axis=1)
    plain = np.array([1.0, 0.5])[turned.kind] * turned.factor * turned.share
    np.testing.assert_allclose(found.stiffness[inside], plain[inside], rtol=1e-14)
