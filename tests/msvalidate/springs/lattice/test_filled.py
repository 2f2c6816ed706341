"""Boxes filled with whole cells of any pattern: shares, facets, and exactness under uniform strain.

Every lattice whose springs run inside a cell or along its sides must carry any uniform strain at
any size, as the homogenised solid does: that decides whether shares and facets are right.
"""

from __future__ import annotations

import json
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from msvalidate.problem import (
    Anisotropic,
    Box,
    Isotropic,
    Problem,
    Region,
    Support,
    Traction,
)
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.constants.homogenise import deforms_affinely, homogenise, interior_tensor
from msvalidate.springs.constants.routes import default_constants
from msvalidate.springs.constants.stiffness import spring_tensor
from msvalidate.springs.lattice import Pattern, boundary_weights, fill, patterns, repeat_cell
from msvalidate.springs.lattice.cut import joins_corners
from msvalidate.springs.lattice.pattern import pattern_by_shells
from msvalidate.springs.statics.equilibrium import equilibrium
from tests.table import refused, table

LATTICES = patterns.all_patterns()
every = pytest.mark.parametrize("name", LATTICES)
SOLID = [name for name, make in LATTICES.items() if make().dim == 3]
CUBES = [name for name in SOLID if joins_corners(LATTICES[name]())]
SIZES = [(1, 1, 1), (1, 2, 3), (3, 1, 2)]
SPACING = 0.25


def box_of(pattern, cells, spacing=SPACING):
    return Box(tuple(spacing * edge * n for edge, n in zip(pattern.size, cells, strict=False)))


def filled(name, cells):
    pattern = LATTICES[name]()
    cells = cells[: pattern.dim]
    return fill(pattern, box_of(pattern, cells), cells)


# Geometry -------------------------------------------------------------------------------------


@pytest.mark.parametrize("cells", SIZES)
@every
def test_points_are_all_places_of_the_lattice_in_the_closed_box(name, cells):
    lattice = filled(name, cells)
    pattern = lattice.pattern
    steps = np.array(list(product(range(-1, 5), repeat=pattern.dim)))
    places = SPACING * (steps[:, None] * np.array(pattern.size) + pattern.points)
    places = places.reshape(-1, pattern.dim)
    size = np.array(lattice.domain.size)
    inside = ((places > -1e-9) & (places < size + 1e-9)).all(axis=1)

    def ordered(points):
        return np.unique(points.round(9), axis=0)

    np.testing.assert_allclose(ordered(lattice.points), ordered(places[inside]), atol=1e-9)


def test_part_of_a_face_of_fcc_is_loaded_on_whole_cells_alone():
    box, load = Box((1.0, 1.0, 1.0)), (1.0, 2.0, -3.0)
    material = Isotropic(1.0, 0.25, "solid")
    held = (Support(box.side("left"), (0.0,) * 3),)

    def loaded(low, high):
        part = Region((1.0, (low, high), (low, high)))
        problem = Problem(box, material, held, (Traction(part, load),))
        return lattice_network(problem, fill(patterns.fcc(), box, 4))

    network = loaded(0.25, 0.75)
    # Half of an inner point's square in the middle of cells, and of a corner a quarter of that.
    taken = network.points[:, 1:][network.force.any(axis=1)]
    assert ((taken >= 0.25) & (taken <= 0.75)).all()
    on_rim = ((taken == 0.25) | (taken == 0.75)).sum(axis=1)
    expected = 0.5 / 16 * 0.5 ** on_rim[:, None] * load
    np.testing.assert_allclose(network.force[network.force.any(axis=1)], expected, rtol=1e-13)
    with refused("covers no whole number of cell edges; choose cells"):
        loaded(0.25, 0.7)


@pytest.mark.parametrize("name", CUBES)
def test_cells_are_cubes_in_vtk_order(name):
    lattice = filled(name, (2, 1, 3))
    corners = lattice.points[lattice.cells]
    around = ((0, 0), (1, 0), (1, 1), (0, 1))
    steps = SPACING * np.array([[x, y, z] for z in (0, 1) for x, y in around])
    np.testing.assert_allclose(corners - corners[:, :1], np.tile(steps, (6, 1, 1)), atol=1e-14)
    held = np.zeros((len(lattice.points), 6), dtype=bool)
    held[lattice.cells.T, np.arange(6)] = True
    i, j = lattice.springs.T
    np.testing.assert_array_equal(lattice.borders, (held[i] & held[j]).sum(axis=1))


def test_a_cubic_bar_is_the_one_that_another_program_moved():
    data = Path(__file__).parents[3] / "data" / "springs" / "s2_trajectory_cubic18_damped.json"
    independent = json.loads(data.read_text())
    points = np.array(independent["points"])
    lattice = fill(patterns.cubic18(), Box(tuple(points.max(axis=0).tolist())), (5, 3, 3))
    np.testing.assert_allclose(lattice.points, points, atol=1e-15)
    expected = np.unique(np.sort(independent["springs"], axis=1), axis=0)
    np.testing.assert_array_equal(np.unique(lattice.springs, axis=0), expected)


# Uniform strain -------------------------------------------------------------------------------


def stays(pattern):
    """Which springs (m,) run inside a cell or along its sides."""
    away = pattern.points[pattern.springs[:, 0]] + pattern.vectors
    low, high = -1e-9, np.array(pattern.size) + 1e-9
    start = pattern.points[pattern.springs[:, 0]]
    # Any cell will do that holds both ends: shift the spring by whole cells.
    inside = np.zeros(len(away), dtype=bool)
    for step in product((-1, 0, 1), repeat=pattern.dim):
        shift = np.array(step) * pattern.size
        ends = np.stack([start + shift, away + shift])
        inside |= ((ends >= low) & (ends <= high)).all(axis=(0, 2))
    return inside


def constants_within(pattern):
    """Constants that leave no spring that runs from a cell to the next with stiffness."""
    inside = stays(pattern)
    kinds = [bool(inside[pattern.kind == kind].all()) for kind in range(pattern.kinds)]
    return tuple(0.7 + 0.4 * kind if whole else 0.0 for kind, whole in enumerate(kinds))


def resists_within(name):
    """Whether the springs inside its cells alone resist every strain."""
    pattern = LATTICES[name]()
    tensor = homogenise(pattern, constants_within(pattern)).tensor
    return np.linalg.eigvalsh(tensor)[0] > 1e-3


@pytest.mark.parametrize("name", [*filter(resists_within, LATTICES)])
def test_uniform_strain_is_as_exact_where_a_cell_is_a_block_of_cells(name):
    # Sides of such a cell are crowded, and squares of points on them are cut in two at will.
    pattern = repeat_cell(LATTICES[name](), 2)
    cells = (2, 1, 1)[: pattern.dim]
    refuse_more_than_uniform_strain(fill(pattern, box_of(pattern, cells), cells), name)


def refuse_more_than_uniform_strain(lattice, name):
    d = lattice.domain.dim
    constants = constants_within(lattice.pattern)
    tensor = interior_tensor(lattice, constants, "shared")
    rng = np.random.default_rng(5)
    strain = rng.normal(size=(d, d))
    strain += strain.T
    if name == "cubic26":  # shear leaves forces at the corners of the box: see below
        strain = np.diag(np.diag(strain))
    voigt = [(a, a) for a in range(d)] + ([(0, 1)] if d == 2 else [(1, 2), (0, 2), (0, 1)])
    engineering = np.array([strain[a, b] * (1 if a == b else 2) for a, b in voigt])
    stress = np.zeros((d, d))
    for (a, b), value in zip(voigt, tensor @ engineering, strict=True):
        stress[a, b] = stress[b, a] = value
    loads = tuple(
        Traction(lattice.domain.side(side), tuple((sign * stress[axis]).tolist()))
        for axis, pair in enumerate((("left", "right"), ("bottom", "top"), ("back", "front"))[:d])
        for side, sign in zip(pair, (-1, 1), strict=True)
    )
    corner = Support(Region((0.0,) * d), (0.0,) * d)
    spin = [
        Support(Region((lattice.domain.size[0], *(0.0,) * (d - 1))), (None,) + (0.0,) * (d - 1))
    ]
    if d == 3:
        spin.append(Support(Region((0.0, lattice.domain.size[1], 0.0)), (None, None, 0.0)))
    problem = Problem(lattice.domain, Anisotropic(tensor), (corner, *spin), loads)
    network = lattice_network(problem, lattice, constants)
    move = equilibrium(network, "linear").displacement
    # What is left of the affine motion after the best rigid one: nothing.
    x = np.column_stack([lattice.points, np.ones(len(lattice.points))])
    fit, *_ = np.linalg.lstsq(x, move, rcond=None)
    gradient = fit[:d].T
    size = np.abs(strain).max() * max(lattice.domain.size)
    np.testing.assert_allclose(x @ fit, move, atol=1e-11 * size)
    np.testing.assert_allclose((gradient + gradient.T) / 2, strain, atol=1e-11 * size / SPACING)


@pytest.mark.parametrize("name", SOLID)
def test_shared_springs_of_a_filled_box_sum_to_the_solids_energy_where_none_is_cut(name):
    lattice = filled(name, (2, 1, 3))
    constants = constants_within(lattice.pattern)
    k = np.array(constants)[lattice.kind] * boundary_weights(lattice, "shared")
    found = spring_tensor(lattice.vectors, k, lattice.domain.volume)
    exact = lattice.pattern.tensor(constants) / SPACING
    np.testing.assert_allclose(found, exact, atol=1e-13 * np.abs(exact).max())


@pytest.mark.parametrize("name", [n for n in LATTICES if deforms_affinely(LATTICES[n]())])
def test_per_cell_every_cell_is_one_cell_alone(name):
    lattice, alone = filled(name, (2, 1, 3)), filled(name, (1, 1, 1))
    constants = constants_within(lattice.pattern)

    def energy(body):
        k = np.array(constants)[body.kind] * boundary_weights(body, "per_cell")
        return spring_tensor(body.vectors, k, body.domain.volume)

    np.testing.assert_allclose(energy(lattice), energy(alone), atol=1e-12 * energy(alone).max())
    found = interior_tensor(lattice, constants, "per_cell")
    np.testing.assert_allclose(found, energy(alone), atol=1e-12 * found.max())


# Constants ------------------------------------------------------------------------------------


@table(("name", "material", "message"), [
    ("cubic18", Isotropic(1.0, 0.3, "solid"),
        "nu = 0.3); central springs make it isotropic at 0.25 only"),
    ("cubic18", Isotropic(1.0, 0.25), "material in plane_stress; give a solid"),
    ("cubic6", Isotropic(1.0, 0.25, "solid"), "no spring constants make it isotropic"),
    ("square4", Isotropic(1.0, 0.25), "no spring constants make it isotropic"),
])  # fmt: skip
def test_materials_that_a_lattice_cannot_be_are_refused(name, material, message):
    with refused(message):
        default_constants(material, filled(name, (2, 2, 2)))


# Bad input ------------------------------------------------------------------------------------


def off_corner() -> Pattern:
    pattern = pattern_by_shells("shifted", (1.0, 1.0), [(0.5, 0.5)], (1.0,), {"one": (1.0,)})
    assert len(pattern.springs) == 2
    return pattern


@table(("make", "message"), [
    (lambda: fill(None, Box((1.0, 1.0)), 2), "pattern: None; give a Pattern"),
    (lambda: fill(patterns.bcc(), Box((1.0, 1.0)), 2), "BCC lattice: a box 1 x 1 m; give"),
    (lambda: fill(patterns.square(), Box((1.0,) * 3), 2), "give a plane box"),
    (lambda: fill(patterns.fcc(), Box((1.0,) * 3), (2, 2)), "give one or three whole numbers"),
    (lambda: fill(patterns.fcc(), Box((1.0,) * 3), 0), "cells: 0; give a whole number"),
    (lambda: fill(patterns.fcc(), Box((1.0,) * 3), (1, 2, 2)), "counts in the ratio 1 : 1 : 1"),
    (lambda: fill(patterns.triangular(), Box((1.0, 1.0)), 2), "its cells are as 1 : 1.73205"),
    (lambda: fill(patterns.fcc(), Box((1.0,) * 3), 2000), "points, and the most is"),
    (lambda: fill(off_corner(), Box((1.0, 1.0)), 2), "no point in the corner of its cell"),
])  # fmt: skip
def test_bad_boxes_and_counts_are_refused(make, message):
    with refused(message):
        make()
