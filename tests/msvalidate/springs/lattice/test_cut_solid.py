"""Lattices cut to solids of any shape: volumes, moments, what is inside, prisms both ways."""

from __future__ import annotations

import numpy as np
import pytest

from msvalidate.problem import SHAPES, Box
from msvalidate.springs.lattice import cut_lattice, grid_cut, patterns
from msvalidate.springs.lattice.drawn import draw_surface, solid_facets
from msvalidate.springs.lattice.grid_cut import DRAWING, cell_parts
from tests.msvalidate.solids import ball, bar, rotation
from tests.table import refused

HALF = np.array([0.1, 0.2, 0.3])


@pytest.fixture
def all_slivers_count(monkeypatch):
    monkeypatch.setattr(grid_cut, "SLIVER", 0.0)


@pytest.mark.usefixtures("all_slivers_count")
@pytest.mark.parametrize("shape", [n for n, s in SHAPES.items() if s.dim == 3])
def test_points_have_the_volume_and_first_moment_of_a_turned_bar(shape):
    mesh = bar((1.0, 0.6, 0.5), (2, 1, 1), shape, rotation(0.3, 0.5, 0.7), HALF)
    lattice = cut_lattice(patterns.cubic18(), mesh, 0.13)
    assert lattice.by_surface
    assert lattice.drawing_error == 0
    assert lattice.point_volume.sum() == pytest.approx(0.3, rel=1e-9)
    middle = rotation(0.3, 0.5, 0.7) @ [0.5, 0.3, 0.25] + HALF
    np.testing.assert_allclose(lattice.point_volume @ lattice.points / 0.3, middle, rtol=1e-8)
    own = (lattice.points - HALF) @ rotation(0.3, 0.5, 0.7)
    within = ((own > 1e-9) & (own < np.array([1.0, 0.6, 0.5]) - 1e-9)).all(axis=1)
    np.testing.assert_array_equal(lattice.inside, within)


@pytest.mark.usefixtures("all_slivers_count")
def test_a_box_of_broken_cells_is_cut_on_every_side():
    box = Box((1.03, 0.71, 0.57))
    lattice = cut_lattice(patterns.cubic18(), box, 0.1, origin=(0.02, 0.0, 0.03))
    assert lattice.point_volume.sum() == pytest.approx(box.volume, rel=1e-12)
    middle = lattice.point_volume @ lattice.points / box.volume
    np.testing.assert_allclose(middle, np.array(box.size) / 2, rtol=1e-12)
    assert lattice.fraction.min() == pytest.approx(0.1 * 0.1 * 0.3, rel=1e-9)


@pytest.mark.usefixtures("all_slivers_count")
def test_a_curved_ball_is_cut_to_the_error_that_it_states():
    mesh = ball(1)
    lattice = cut_lattice(patterns.cubic18(), mesh, 0.25)
    missing = 1 - lattice.point_volume.sum() / mesh.volume
    assert 0.9 * DRAWING < lattice.drawing_error <= DRAWING
    # All of its facets bulge outwards, so that what lies between is what is missing.
    assert missing == pytest.approx(lattice.drawing_error, rel=1e-3)
    away = np.linalg.norm(lattice.points, axis=1)
    assert lattice.inside[away < 0.97].all()
    assert not lattice.inside[away > 1.001].any()


def test_what_does_not_fit_is_refused_in_one_line():
    mesh = ball(0)
    with refused("cut lattice of spacing 1e-05 m: "):
        cut_lattice(patterns.cubic18(), mesh, 1e-5)
    with refused("no cell of 9 m has more than 0.01 of it inside the body"):
        cut_lattice(patterns.cubic18(), mesh, 9.0)
    with refused("flat triangles, and the most is 2e+06; take fewer"):
        draw_surface(solid_facets(mesh), mesh.tolerance, gap=1e-12)
    # One body in another counts twice: `cut_lattice` refuses it, as its surface crosses itself.
    at = np.concatenate([solid_facets(mesh), solid_facets(mesh) / 2])
    drawn = draw_surface(at, mesh.tolerance, gap=1e-2).corners + 1.5
    assert cell_parts(drawn, np.array([3, 3, 3]), 0.0)[2][1] > 1 + 1e-3
