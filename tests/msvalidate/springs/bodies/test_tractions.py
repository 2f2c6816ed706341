"""Tractions on lattices: their force and moment, and what each point of a body takes of them."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from msvalidate.problem import (
    SIDES,
    Anisotropic,
    Box,
    Problem,
    Region,
    Support,
    Traction,
)
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.lattice import (
    Lattice,
    fill,
    fill_rotated,
    patterns,
    repeat_cell,
    voronoi_box,
)
from msvalidate.springs.lattice.point_sets import POINT_SETS
from tests.table import refused, table

PLANE, SPACE = Box((1.0, 0.75)), Box((1.0, 0.75, 0.5))
TILT = Rotation.from_rotvec([0.3, 0.5, 0.7]).as_matrix()


def by_facets(lattice):
    """A random body that takes tractions by its facets, as it does on part of a side."""
    return Lattice(**{each.name: getattr(lattice, each.name) for each in fields(Lattice)})


BODIES = {
    "FCC, one cell": lambda: fill(patterns.fcc(), Box((0.5, 0.5, 0.5)), 1),
    "FCC": lambda: fill(patterns.fcc(), SPACE, (4, 3, 2)),
    "BCC": lambda: fill(patterns.bcc(), SPACE, (4, 3, 2)),
    "square": lambda: fill(patterns.square(), PLANE, (4, 3)),
    "blocks of squares": lambda: fill(repeat_cell(patterns.square(), 2), PLANE, (4, 3)),
    "square, turned": lambda: fill_rotated(patterns.square(), PLANE, 1 / 16, 0.4),
    "cubic, turned": lambda: fill_rotated(patterns.cubic18(), SPACE, 1 / 8, TILT),
    "cubic, turned by nothing": lambda: fill_rotated(patterns.cubic18(), SPACE, 1 / 8, np.eye(3)),
    "BCC, turned": lambda: fill_rotated(patterns.bcc(), SPACE, 1 / 8, TILT),
    "FCC, turned": lambda: fill_rotated(patterns.fcc(), SPACE, 1 / 8, TILT),
} | {
    f"{points}, {box.dim}D": lambda points=points, box=box: by_facets(
        voronoi_box(box, 0.12, points=points, seed=2)
    )
    for points in POINT_SETS
    for box in (PLANE, SPACE)
}


def pushed(lattice, region, traction):
    """Forces (n, d) of one traction on a body of thickness 1 m."""
    box, d = lattice.domain, lattice.domain.dim
    held = Support(box.side("left"), (0.0,) * d)
    if region == box.side("left"):
        held = Support(box.side("right"), (0.0,) * d)
    problem = Problem(box, Anisotropic(np.eye(3 * (d - 1))), (held,), (Traction(region, traction),))
    return lattice_network(problem, lattice, (1.0,) * lattice.kinds).force


def linear(dim, part):
    """Traction t = start + gradient (x - middle) about the middle of a part of a box (2, d)."""
    rng = np.random.default_rng(3)
    start, gradient = rng.normal(size=dim), rng.normal(size=(dim, dim))
    return start, gradient, lambda x: start + (x - part.mean(axis=0)) @ gradient.T


def refuse_other_force_or_moment(lattice, region):
    box, d = lattice.domain, lattice.domain.dim
    corners = region.corners(box.span)
    part = np.stack([corners.min(axis=0), corners.max(axis=0)])
    area, length = region.measure(box.span), np.ptp(part, axis=0)
    start, gradient, traction = linear(d, part)
    arm = lattice.points - part.mean(axis=0)
    for load, slope in ((tuple(start.tolist()), 0 * gradient), (traction, gradient)):
        force = pushed(lattice, region, load)
        # ∫ t = area · start and ∫ (x_a - middle_a) t_b = area · length_a²/12 · gradient_ba.
        moments = area * length[:, None] ** 2 / 12 * slope.T
        size = np.abs(force).sum()
        np.testing.assert_allclose(force.sum(axis=0), area * start, atol=1e-13 * size)
        found = arm.T @ force
        expected = moments - moments.T
        np.testing.assert_allclose(found - found.T, expected, atol=1e-13 * size)


@pytest.mark.parametrize("name", BODIES)
def test_tractions_up_to_linear_keep_their_force_and_moment(name):
    lattice = BODIES[name]()
    for side, (axis, _) in SIDES.items():
        if axis < lattice.domain.dim:
            refuse_other_force_or_moment(lattice, lattice.domain.side(side))


@pytest.mark.parametrize("cells", [4, 8])
def test_they_do_on_part_of_a_face_of_fcc(cells):
    lattice = fill(patterns.fcc(), Box((1.0, 1.0, 1.0)), cells)
    refuse_other_force_or_moment(lattice, Region((1.0, (0.25, 0.75), (0.5, 0.75))))


# Points' parts of a side ----------------------------------------------------------------------


@pytest.mark.parametrize("points", POINT_SETS)
def test_a_pull_on_a_random_plane_body_has_no_moment(points):
    # Parts meet where power functions y² - 2 y y_i + |x_i|² do, so Σ S_i y_i telescopes.
    for seed in range(5):
        lattice = voronoi_box(PLANE, 0.08, points=points, seed=seed)
        force = pushed(lattice, PLANE.side("right"), (1.0, 0.0))[:, 0]
        assert force @ (lattice.points[:, 1] - 0.375) == pytest.approx(0, abs=1e-14)


def test_the_moment_of_a_linear_traction_on_a_random_body_is_of_second_order():
    def bending(x):
        return np.stack([x[:, 1] - 0.375, 0 * x[:, 0]], axis=1)

    errors = []
    for h in (0.1, 0.05, 0.025):
        found = []
        for seed in range(8):
            lattice = voronoi_box(PLANE, h, seed=seed)
            force = pushed(lattice, PLANE.side("right"), bending)[:, 0]
            found.append(force @ (lattice.points[:, 1] - 0.375))
        errors.append(np.abs(np.array(found) / (0.75**3 / 12) - 1).mean())
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert (orders > 1.5).all()


@table(
    "make",
    [
        lambda: voronoi_box(SPACE, 0.15),
        lambda: fill_rotated(patterns.fcc(), SPACE, 1 / 6, TILT),
    ],
)
def test_part_of_a_side_of_an_irregular_body_is_refused(make):
    with refused("end where it does; load a whole side"):
        pushed(make(), Region((1.0, (0.25, 0.5), (0.1, 0.3))), (1.0, 0.0, 0.0))
