"""A dielectric body in air against the plane model, limits and its own energy."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from msvalidate.dielectric.charges import (
    SlabInAir,
    electrodes_of_chains,
    forces,
    forces_in_air,
    tangent_in_air,
)
from msvalidate.dielectric.charges.faces import Faces, slab_faces
from msvalidate.dielectric.charges.moments import Moments
from msvalidate.problem import ProblemError

EXACT = 1e-9  # rounding of 1e-16, times condition numbers of up to 1e6
VOLTS = (0.5, -0.5)
LENGTH, HEIGHT = 60.0, 10.0
examples = settings(max_examples=15, deadline=None)
every_cover = pytest.mark.parametrize("covered", [1.0, 1 / 3])


def crooked(seed, sides=9):
    """A star-shaped outline with segments of unlike length and two electrodes of two segments."""
    rng = np.random.default_rng(seed)
    angle = 2 * np.pi * (np.arange(sides) + rng.uniform(-0.3, 0.3, sides)) / sides
    radius = rng.uniform(0.7, 1.3, sides)
    points = radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    electrode = np.full(sides, -1)
    electrode[[1, 2]], electrode[[5, 6]] = 0, 1
    return Faces(points, electrode)


def moved_slab(slab, points):
    """The same body with the points of its surface elsewhere."""
    return SlabInAir(
        slab.electrodes.moved(points), ratio=slab.ratio, permittivity=slab.permittivity
    )


def capacitance_in_air(faces, ratio):
    """Capacitance per depth between two electrodes."""
    return float(SlabInAir(faces, ratio=ratio).charges(VOLTS).totals[0])


# --- limits and closed forms ----------------------------------------------------------------------


@every_cover
def test_without_contrast_it_is_the_plane_model(covered):
    faces = slab_faces(6.0, 1.0, 16, covered=covered)
    ours = SlabInAir(faces, ratio=1.0, permittivity=2.0).charges((3.0, 1.0))
    assert np.abs(ours.charge[faces.bare]).max() < 1e-13 * np.abs(ours.charge).max()
    order = [np.flatnonzero(faces.electrode == k) for k in (0, 1)]
    nodes = [np.append(segments, (segments[-1] + 1) % len(faces.points)) for segments in order]
    plane = Moments(
        electrodes_of_chains(*(faces.points[chain] for chain in nodes)), permittivity=2.0
    )
    theirs = plane.charges((3.0, 1.0))
    assert ours.charge[np.concatenate(order)] == pytest.approx(theirs.charge, rel=EXACT)
    assert ours.free == pytest.approx(ours.charge, rel=EXACT)
    assert ours.energy == pytest.approx(theirs.energy, rel=EXACT)
    expected = np.zeros_like(faces.points)
    expected[np.concatenate(nodes)] = forces(theirs)
    assert forces_in_air(ours) == pytest.approx(expected, abs=EXACT * np.abs(expected).max())
    points = np.array([[0.1, 0.4], [1.0, 5.0]])
    assert ours.potential(points) == pytest.approx(theirs.potential(points), rel=EXACT)
    assert ours.field(points) == pytest.approx(theirs.field(points), rel=EXACT)


def test_of_great_permittivity_all_field_is_inside():
    """C → εL/h like 1/ratio: what is left is the air's capacitance."""
    faces = slab_faces(LENGTH, HEIGHT, 96)
    excess = [capacitance_in_air(faces, ratio=ratio) - 6.0 for ratio in (1e2, 1e3, 1e6)]
    mesh = excess[2]
    assert mesh < 1e-3
    assert (excess[0] - mesh) / (excess[1] - mesh) == pytest.approx(10, rel=0.05)


@pytest.mark.parametrize("ratio", [1.0, 3.0, 10.0])
def test_pull_at_a_covered_edge_falls_with_the_mesh_as_its_exponent_says(ratio):
    pull = []
    for n in (96, 192):
        faces = slab_faces(LENGTH, HEIGHT, n)
        force = forces_in_air(SlabInAir(faces, ratio=ratio).charges(VOLTS))
        pull.append(force[np.hypot(*(faces.points - [30.0, 10.0]).T) < 1e-6, 0].item())
    # Twice as many segments are a quarter as long at the edge; the next term falls faster still.
    power = 4 / np.pi * np.arctan(np.sqrt((3 * ratio + 1) / (ratio + 3))) - 1
    assert np.log(pull[0] / pull[1]) / np.log(4) == pytest.approx(power, abs=0.03)


# --- what holds on any body -----------------------------------------------------------------------


@given(st.integers(0, 2**32 - 1), st.floats(0.1, 100))
@examples
def test_no_charge_is_lost(seed, ratio):
    faces = crooked(seed)
    slab = SlabInAir(faces, ratio=ratio)
    # Half of what a segment sends out enters the body, and leaves it through all others.
    assert slab.flux.sum(axis=0) == pytest.approx(np.full(len(faces.points), 0.5), rel=1e-10)
    charges = slab.charges((1.0, -2.0))
    size = np.abs(charges.totals).max()
    assert charges.charge.sum() == pytest.approx(0, abs=1e-10 * np.abs(charges.charge).max())
    assert charges.totals.sum() == pytest.approx(0, abs=1e-9 * size)


@given(st.integers(0, 2**32 - 1), st.sampled_from([0.3, 1.0, 3.0, 30.0]))
@examples
def test_forces_are_the_energys_derivative(seed, ratio):
    slab = SlabInAir(crooked(seed), ratio=ratio, permittivity=2.0)
    points, volts, step = slab.electrodes.points, (1.0, -0.6), 1e-5
    expected = np.empty_like(points)
    for at in np.ndindex(points.shape):
        moved = np.zeros_like(points)
        moved[at] = step
        higher, lower = (
            moved_slab(slab, points + s * moved).charges(volts).energy for s in (1, -1)
        )
        expected[at] = (higher - lower) / (2 * step)
    force = forces_in_air(slab.charges(volts))
    assert force == pytest.approx(expected, abs=1e-6 * np.abs(expected).max())


@given(st.integers(0, 2**32 - 1), st.sampled_from([0.3, 1.0, 3.0, 30.0]))
@examples
def test_tangent_is_the_forces_derivative(seed, ratio):
    slab = SlabInAir(crooked(seed), ratio=ratio, permittivity=2.0)
    points, volts, step = slab.electrodes.points, (1.0, -0.6), 1e-6
    measured = tangent_in_air(slab.charges(volts))
    size = np.abs(measured).max()
    assert measured == pytest.approx(measured.T, abs=1e-12 * size)
    for column in range(points.size):
        moved = (step * (np.arange(points.size) == column)).reshape(points.shape)
        there, back = (
            forces_in_air(moved_slab(slab, points + s * moved).charges(volts)) for s in (1, -1)
        )
        expected = ((there - back) / (2 * step)).ravel()
        assert measured[:, column] == pytest.approx(expected, abs=1e-6 * size)


@given(st.integers(0, 2**32 - 1), st.floats(0.1, 100))
@examples
def test_forces_are_balanced(seed, ratio):
    faces = crooked(seed)
    force = forces_in_air(SlabInAir(faces, ratio=ratio).charges((1.0, -0.6)))
    size = np.abs(force).sum()
    assert force.sum(axis=0) == pytest.approx([0, 0], abs=1e-10 * size)
    x, y = faces.points.T
    assert (x * force[:, 1] - y * force[:, 0]).sum() == pytest.approx(0, abs=1e-10 * size)


@given(st.floats(0.1, 10), st.floats(0, 2 * np.pi))
@examples
def test_place_direction_and_unit_of_length_change_nothing(scale, turn):
    slab = SlabInAir(crooked(7), ratio=3.0)
    c, s = np.cos(turn), np.sin(turn)
    rotation = np.array([[c, s], [-s, c]])
    there = moved_slab(slab, scale * slab.electrodes.points @ rotation + [5.0, -2.0]).charges(VOLTS)
    here = slab.charges(VOLTS)
    assert there.charge == pytest.approx(here.charge, abs=1e-9 * np.abs(here.charge).max())
    turned = forces_in_air(here) @ rotation / scale
    assert forces_in_air(there) == pytest.approx(turned, abs=1e-8 * np.abs(turned).max())


@pytest.mark.parametrize("permittivity", [8.85e-12, 1e6])
def test_unit_of_permittivity_changes_nothing(permittivity):
    faces = crooked(8)
    plain = SlabInAir(faces, ratio=3.0).charges(VOLTS)
    scaled = SlabInAir(faces, ratio=3.0, permittivity=permittivity).charges(VOLTS)
    assert scaled.totals / permittivity == pytest.approx(plain.totals, rel=EXACT)
    assert forces_in_air(scaled) / permittivity == pytest.approx(
        forces_in_air(plain), abs=EXACT * np.abs(forces_in_air(plain)).max()
    )


def test_bad_questions_are_refused():
    faces = crooked(1)
    with pytest.raises(ProblemError, match=r"ratio: 0\.0; it must be above zero"):
        SlabInAir(faces, ratio=0.0)
    with pytest.raises(ProblemError, match="permittivity: -1 F/m; it must be above zero"):
        SlabInAir(faces, permittivity=-1)
    with pytest.raises(ProblemError, match=r"voltages: shape \(3,\); give \(2,\)"):
        SlabInAir(faces).charges((1.0, 0.0, 0.0))
    with pytest.raises(ProblemError, match=r"faces: .*give a Faces"):
        SlabInAir(faces.points)
    with pytest.raises(ProblemError, match=r"points: shape \(2,\); give \(n, 2\)"):
        SlabInAir(faces).charges(VOLTS).field(np.zeros(2))
