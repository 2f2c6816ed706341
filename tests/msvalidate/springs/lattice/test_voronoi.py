"""Random lattices: stiffness by length and facet, periodic and in a box."""

from __future__ import annotations

import numpy as np
import pytest

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
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.constants.routes import default_constants
from msvalidate.springs.lattice import voronoi, voronoi_box
from msvalidate.springs.lattice.point_sets import POINT_SETS
from msvalidate.springs.lattice.tessellation import bounded_tessellation
from tests.table import refused, table

BOXES = {2: Box((2.0, 1.5)), 3: Box((1.0, 0.8, 1.2))}
SPACING = {2: 0.1, 3: 0.2}
dims = pytest.mark.parametrize("dim", [2, 3])
kinds = pytest.mark.parametrize("points", POINT_SETS)


# Periodic -------------------------------------------------------------------------------------


def test_a_seed_is_a_network():
    first, again, other = (voronoi(50, seed=seed) for seed in (7, 7, 8))
    np.testing.assert_array_equal(first.points, again.points)
    np.testing.assert_array_equal(first.factor, again.factor)
    assert np.abs(first.points - other.points).max() > 0.1


# In a box -------------------------------------------------------------------------------------


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


@table(("call", "message"), [
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
    (lambda: default_constants(Isotropic(1.0, 1 / 3), voronoi_box(BOXES[2], 0.5)),
        "none known for Voronoi; give the constants"),
])  # fmt: skip
def test_bad_input_is_refused(call, message):
    with refused(message):
        call()
