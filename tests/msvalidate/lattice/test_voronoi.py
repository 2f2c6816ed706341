"""Random lattices: stiffness by length and facet, periodic and in a box."""

from __future__ import annotations

import numpy as np
import pytest

from msvalidate.bodies.lattice_network import lattice_network
from msvalidate.constants.homogenise import homogenise
from msvalidate.constants.routes import default_constants
from msvalidate.constants.stiffness import isotropic_moduli
from msvalidate.dynamics.spectrum import natural_frequencies
from msvalidate.lattice import STIFFNESS_RULES, boundary_weights, voronoi, voronoi_box
from msvalidate.lattice.point_sets import POINT_SETS
from msvalidate.lattice.tessellation import bounded_tessellation
from msvalidate.problem import (
    SIDES,
    Anisotropic,
    Box,
    Isotropic,
    Problem,
    Region,
    Support,
    Traction,
)
from msvalidate.statics.equilibrium import equilibrium
from tests.table import refused, table

BOXES = {2: Box((2.0, 1.5)), 3: Box((1.0, 0.8, 1.2))}
SPACING = {2: 0.1, 3: 0.2}
dims = pytest.mark.parametrize("dim", [2, 3])
kinds = pytest.mark.parametrize("points", POINT_SETS)


def bulk(tensor, dim):
    return tensor[:dim, :dim].sum() / dim**2


# Periodic -------------------------------------------------------------------------------------


@dims
@kinds
@pytest.mark.parametrize("seed", [0, 1])
def test_springs_as_facet_over_length_keep_their_bulk_modulus(dim, points, seed):
    # The facets of a closed cell sum to nothing, Σ A n = 0, so under a hydrostatic strain no point
    # wants to move: relaxing takes nothing from the affine value, (1/V) Σ A L/d² = 1/d.
    found = homogenise(voronoi(80, dim=dim, points=points, stiffness="A/L", seed=seed), (1.0,))
    assert bulk(found.affine, dim) == pytest.approx(1 / dim, rel=1e-12)
    assert bulk(found.tensor, dim) == pytest.approx(1 / dim, rel=1e-11)
    moduli = isotropic_moduli(found.tensor)
    # E = d² K (1 - (d - 1) nu)/d, with K = 1/d.
    assert pytest.approx(1 - (dim - 1) * moduli.nu, rel=1e-11) == moduli.E


@dims
@pytest.mark.parametrize("rule", ["1", "1/L"])
def test_springs_of_other_stiffness_do_not(dim, rule):
    found = homogenise(voronoi(80, dim=dim, stiffness=rule), (1.0,))
    assert bulk(found.tensor, dim) < 0.99 * bulk(found.affine, dim)


@dims
@pytest.mark.parametrize("rule", STIFFNESS_RULES)
def test_stiffness_is_by_length_and_facet(dim, rule):
    pattern = voronoi(60, dim=dim, stiffness=rule, seed=3)
    lengths = np.linalg.norm(pattern.vectors, axis=1)
    factor = pattern.factor * {"1": 1.0, "1/L": lengths, "A/L": lengths}[rule]
    if rule == "A/L":  # the area of every facet
        assert factor @ lengths == pytest.approx(dim * 60, rel=1e-12)
    else:
        np.testing.assert_allclose(factor, 1.0)
    assert np.prod(pattern.size) == pytest.approx(60)
    assert pattern.volume.sum() == pytest.approx(60, rel=1e-12)


def test_a_seed_is_a_network():
    first, again, other = (voronoi(50, seed=seed) for seed in (7, 7, 8))
    np.testing.assert_array_equal(first.points, again.points)
    np.testing.assert_array_equal(first.factor, again.factor)
    assert np.abs(first.points - other.points).max() > 0.1


# In a box -------------------------------------------------------------------------------------


@dims
@kinds
def test_a_box_is_filled_to_its_sides(dim, points):
    box, h = BOXES[dim], SPACING[dim]
    lattice = voronoi_box(box, h, points=points, seed=4)
    assert lattice.point_volume.sum() == pytest.approx(box.volume, rel=1e-12)
    # One point on average in h^d, those on sides by their part.
    size = np.array(box.size)
    sides = ((lattice.points == 0) | (lattice.points == size)).sum(axis=1)
    assert (0.5**sides).sum() * h**dim == pytest.approx(box.volume, rel=0.05)
    assert set(np.unique(lattice.share)) <= {1.0, 0.5, 0.25}
    assert (lattice.share < 1).sum() > 0


@dims
@kinds
@pytest.mark.parametrize("rule", STIFFNESS_RULES)
def test_springs_in_a_box_have_the_facets_of_its_cells(dim, points, rule):
    box, h = BOXES[dim], SPACING[dim]
    lattice = voronoi_box(box, h, points=points, stiffness=rule, seed=4)
    cells = bounded_tessellation(lattice.points, box)
    m = len(cells.springs)
    np.testing.assert_array_equal(lattice.springs[:m], cells.springs)  # braces come after
    assert len(lattice.springs) - m <= 2 * dim * 2**dim
    length = np.linalg.norm(cells.vectors, axis=1)
    weight = (lattice.factor * boundary_weights(lattice, "shared"))[:m]
    # A side halves the facet of a spring in it: the clipped one has the share already.
    on = [(cells.points == end)[cells.springs].all(axis=1) for end in (0, box.size)]
    share = 0.5 ** (on[0] | on[1]).sum(axis=1)
    assert (share < 1).any()
    expected = {"1": share, "1/L": share / length * h, "A/L": cells.area / length / h ** (dim - 2)}
    np.testing.assert_allclose(weight, expected[rule], rtol=1e-12)
    if rule == "A/L":  # Σ A L = d V, with the pyramids that stand on the sides
        total = (weight * h ** (dim - 2)) @ length**2
        total += (cells.side_area * cells.side_distance).sum()
        assert total == pytest.approx(dim * box.volume, rel=1e-12)


@dims
def test_every_side_is_covered_by_facets(dim):
    box = BOXES[dim]
    lattice = voronoi_box(box, SPACING[dim])
    for side in ("left", "right", "bottom", "top", "back", "front")[: 2 * dim]:
        load = Traction(box.side(side), (0.0,) * (dim - 1) + (1.0,))
        low = Support(box.side("left" if side != "left" else "right"), (0.0,) * dim)
        problem = Problem(box, Anisotropic(np.eye(3 * (dim - 1))), (low,), (load,))
        force = lattice_network(problem, lattice, (1.0,)).force
        assert force.sum(axis=0)[-1] == pytest.approx(box.side(side).measure(box.span), rel=1e-12)


@dims
@kinds
@pytest.mark.parametrize("size", [0.06, 0.12, 0.3])
def test_springs_as_facet_over_length_carry_a_hydrostatic_strain_in_any_box(dim, points, size):
    # Closed cells again, by the parts of the sides: Σ A n + Σ S n = 0 at every point, where k L is
    # A h^(2-d) for a constant of 1 N/m, and S goes with the tractions.
    box, h = Box((0.8, 0.6, 0.7)[:dim]), size if dim == 2 else 1.5 * size
    for seed in unbraced(box, h, points):
        lattice = voronoi_box(box, h, points=points, seed=seed)
        pressure = h ** (2 - dim)
        loads = tuple(
            Traction(box.side(side), tuple(((2 * end - 1) * pressure * np.eye(dim)[axis]).tolist()))
            for side, (axis, end) in SIDES.items()
            if axis < dim
        )
        problem = Problem(box, Anisotropic(np.eye(3 * (dim - 1))), held_just(box), loads)
        network = lattice_network(problem, lattice, (1.0,))
        pull = network.stiffness[:, None] * lattice.vectors
        left = network.force.copy()
        np.add.at(left, lattice.springs[:, 0], pull)
        np.add.at(left, lattice.springs[:, 1], -pull)
        assert np.abs(left).max() < 1e-11 * pressure * h ** (dim - 1)


def held_just(box):
    """Supports of corners that stop a box's rigid motions and nothing else."""
    ends, dim = box.size, box.dim
    supports = (
        Support(Region((0.0,) * dim), (0.0,) * dim),
        Support(Region((ends[0], *(0.0,) * (dim - 1))), (None,) + (0.0,) * (dim - 1)),
    )
    if dim == 2:
        return supports
    return (*supports, Support(Region((0.0, ends[1], 0.0)), (None, None, 0.0)))


def unbraced(box, h, points, count=3):
    """The first seeds of bodies without braces, springs that have no facet."""
    found = []
    for seed in range(40):
        lattice = voronoi_box(box, h, points=points, seed=seed)
        if len(lattice.springs) == len(bounded_tessellation(lattice.points, box).springs):
            found.append(seed)
        if len(found) == count:
            return found
    raise AssertionError("all have braces")


@dims
@pytest.mark.parametrize("rule", STIFFNESS_RULES)
def test_a_box_pulled_along_x_comes_near_the_periodic_solid(dim, rule):
    box, h = Box((1.0,) * dim), 1 / (24 if dim == 2 else 9)
    lattice = voronoi_box(box, h, stiffness=rule)
    along = np.eye(dim)[0]
    loads = tuple(
        Traction(box.side(side), tuple((sign * along).tolist()))
        for side, sign in (("left", -1), ("right", 1))
    )
    problem = Problem(box, Anisotropic(np.eye(3 * (dim - 1))), held_just(box), loads)
    move = equilibrium(lattice_network(problem, lattice, (1.0,)), "linear").displacement
    gradient = np.linalg.lstsq(
        np.column_stack([lattice.points, np.ones(len(move))]), move, rcond=None
    )[0][:dim]
    count = 576 if dim == 2 else 300
    solid = isotropic_moduli(homogenise(voronoi(count, dim=dim, stiffness=rule), (1.0,)).tensor)
    E = 1 / gradient[0, 0] * h ** (dim - 2)
    nu = -(np.trace(gradient) / gradient[0, 0] - 1) / (dim - 1)
    # A boundary layer of one spacing in 24 or 9, and the scatter of one sample.
    assert pytest.approx(1, abs=0.15 if dim == 2 else 0.2) == E / solid.E
    assert nu == pytest.approx(solid.nu, abs=0.06)


@pytest.mark.parametrize("rule", STIFFNESS_RULES)
def test_no_point_is_left_to_swing(rule):
    # A corner whose cell meets one other only, as one in sixteen of these bodies has.
    lonely = 0
    for seed in range(40):
        lattice = voronoi_box(Box((1.0, 1.0)), 1 / 8, points="uniform", stiffness=rule, seed=seed)
        ends = np.bincount(lattice.springs.ravel(), minlength=len(lattice.points))
        assert ends.min() >= 2
        before = bounded_tessellation(lattice.points, Box((1.0, 1.0))).springs
        lonely += len(lattice.springs) > len(before)
        assert (lattice.factor > 0).all()
    assert lonely > 0


def test_a_random_body_has_no_soft_mode():
    box = BOXES[3]
    lattice = voronoi_box(box, 0.25, stiffness="1")
    problem = Problem(box, Isotropic(1.0, 0.25, "solid"), (Support(box.side("left"), (0.0,) * 3),))
    network = lattice_network(problem, lattice, (1.0,))
    lowest, highest = natural_frequencies(network, 1)
    assert lowest[0] > 1e-3 * highest


@table(
    ("call", "message"),
    [
        (lambda: voronoi(0), "number of points: 0"),
        (lambda: voronoi(10, dim=4), "dim: 4; the most is 3"),
        (lambda: voronoi(10, dim=1), "dim: 1; give a whole number, 2 or more"),
        (lambda: voronoi(10, points="hexagonal"), "'hexagonal'; choose uniform"),
        (lambda: voronoi(10, stiffness="L"), "stiffness: 'L'; choose 1, 1/L, A/L"),
        (lambda: voronoi(10, seed=-1), "seed: -1"),
        (lambda: voronoi_box(None, 0.1), "box: None; give a Box"),
        (lambda: voronoi_box(BOXES[2], 0.0), "spacing: 0.0 m"),
        (lambda: voronoi_box(BOXES[2], float("nan")), "spacing: nan"),
        (lambda: voronoi_box(BOXES[2], 0.1, stiffness=None), "stiffness: None; choose"),
        (lambda: voronoi_box(BOXES[3], 1e-4), "points, and the most is"),
        (
            lambda: default_constants(Isotropic(1.0, 1 / 3), voronoi_box(BOXES[2], 0.5)),
            "none known for Voronoi; give the constants",
        ),
    ],
)
def test_bad_input_is_refused(call, message):
    with refused(message):
        call()
