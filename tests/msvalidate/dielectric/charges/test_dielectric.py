"""A dielectric body in air against the plane model, finite elements, limits and its own energy."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from skfem import (
    Basis,
    BilinearForm,
    ElementQuad0,
    ElementQuad2,
    Functional,
    MeshQuad,
    condense,
    solve,
)
from skfem.helpers import dot, grad

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


# --- finite elements, which share nothing with charges on a surface -------------------------------


def growing(start, end, first=1e-2, growth=1.5):
    """Places from start to end, the first step given, each of the next so much longer."""
    steps = np.log1p(abs(end - start) * (growth - 1) / first) / np.log(growth)
    reach = np.concatenate([[0], np.cumsum(growth ** np.arange(np.ceil(steps)))])
    return start + (end - start) * reach / reach[-1]


def both_ways(start, end):
    middle = 0.5 * (start + end)
    return [growing(start, middle), growing(end, middle)]


@BilinearForm
def stored(u, v, w):
    return w.permittivity * dot(grad(u), grad(v))


@Functional
def stress_upon(w):
    """-T:∇b, which is the virtual work of Maxwell's stress in a motion b·e_x, and in b·e_y."""
    field, slope = -grad(w.u), w.slope
    along = dot(field, slope)
    return -w.permittivity * (field * along - 0.5 * dot(field, field) * slope)


class FiniteElements:
    """Half a slab at ±0.5 V and the air around it, permittivity 1 in the slab."""

    def __init__(self, height, covered, ratio, far=400.0):
        half, edge = 0.5 * LENGTH, 0.5 * LENGTH * covered
        across = [growing(edge, 0.0), growing(half, far)]
        if edge < half:
            across += both_ways(edge, half)
        up = [growing(0.0, -far), *both_ways(0.0, height), growing(height, height + far)]
        x, y = (np.unique(np.round(np.concatenate(part), 10)) for part in (across, up))
        mesh = MeshQuad.init_tensor(x, y)
        middle = mesh.p[:, mesh.t].mean(axis=1)
        inside = (middle[0] < half) & (middle[1] > 0) & (middle[1] < height)
        self.basis = Basis(mesh, ElementQuad2(), intorder=5)
        cells = self.basis.with_element(ElementQuad0())
        of_cell = cells.zeros()
        of_cell[cells.element_dofs[0]] = np.where(inside, 1.0, 1 / ratio)
        self.permittivity = cells.interpolate(of_cell)
        self.stiffness = stored.assemble(self.basis, permittivity=self.permittivity)
        at = self.basis.doflocs
        top = (np.abs(at[1] - height) < 1e-9) & (at[0] <= edge + 1e-9)
        bottom = (np.abs(at[1]) < 1e-9) & (at[0] <= half + 1e-9)
        given_at = np.where(top, 0.5, np.where(bottom, -0.5, 0.0))
        self.potential = solve(
            *condense(self.stiffness, x=given_at, D=np.flatnonzero(top | bottom))
        )

    def capacitance(self):
        return 2 * self.potential @ (self.stiffness @ self.potential)

    def force(self, slope):
        """Work (2,) of the stress in a motion whose size has this slope, of points (2, ...)."""
        given_fields = {
            "u": self.basis.interpolate(self.potential),
            "permittivity": self.permittivity,
            "slope": slope(np.asarray(self.basis.global_coordinates())),
        }
        return stress_upon.elemental(self.basis, **given_fields).sum(axis=-1)


@every_cover
@pytest.mark.parametrize("ratio", [1.0, 3.0, 10.0])
def test_capacitance_against_finite_elements(covered, ratio):
    ours = capacitance_in_air(slab_faces(LENGTH, HEIGHT, 96, covered=covered), ratio=ratio)
    # The air ends 400 m away, which leaves out 6e-4 of the energy and less.
    assert ours == pytest.approx(FiniteElements(HEIGHT, covered, ratio).capacitance(), rel=1e-3)


@every_cover
def test_squeeze_is_the_slope_of_the_finite_elements_energy(covered):
    """Work on a slab stretched upwards: dW/dh = Σ F·y/h, with W = ½CV² of another method."""
    step = 0.2
    higher, lower = (FiniteElements(HEIGHT + s, covered, 3.0).capacitance() for s in (step, -step))
    expected = 0.5 * (higher - lower) / (2 * step)
    faces = slab_faces(LENGTH, HEIGHT, 96, covered=covered)
    force = forces_in_air(SlabInAir(faces, ratio=3.0).charges(VOLTS))
    squeeze = (force[:, 1] * faces.points[:, 1]).sum() / HEIGHT
    # (step/h)², 4e-4, from differences, and 6e-4 from the finite elements.
    assert squeeze == pytest.approx(expected, rel=2e-3)


INNER, OUTER = 2.0, 6.0


def bump(points, edge):
    """1 within 2 m of an electrode's edge, 0 beyond 6 m, and a half wave between."""
    part = np.clip((np.hypot(*(points - edge).T) - INNER) / (OUTER - INNER), 0, 1)
    return 0.5 * (1 + np.cos(np.pi * part))


def slope_of_bump(at, edge):
    away = at - edge.reshape(2, *[1] * (at.ndim - 1))
    r = np.hypot(*away)
    between = (r > INNER) & (r < OUTER)
    size = -0.5 * np.pi / (OUTER - INNER) * np.sin(np.pi * (r - INNER) / (OUTER - INNER))
    return np.where(between, size / r, 0.0) * away


@every_cover
@pytest.mark.parametrize("ratio", [1.0, 3.0, 10.0])
def test_force_near_the_edge_of_an_electrode_against_finite_elements(covered, ratio):
    """In the volume, where no singular stress is summed: it is even within 2 m of the edge."""
    edge = np.array([0.5 * LENGTH * covered, HEIGHT])
    faces = slab_faces(LENGTH, HEIGHT, 96, covered=covered)
    force = forces_in_air(SlabInAir(faces, ratio=ratio).charges(VOLTS))
    ours = bump(faces.points, edge) @ force
    theirs = FiniteElements(HEIGHT, covered, ratio).force(lambda at: slope_of_bump(at, edge))
    # Segments of 1 m take the bump's wave as straight lines: (π/4)²/12 of its rim, 5e-3 of all.
    assert ours == pytest.approx(theirs, rel=5e-3)


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


@every_cover
@pytest.mark.parametrize("ratio", [1.0, 3.0, 10.0])
def test_graded_segments_converge_with_order_two(covered, ratio):
    found = [
        capacitance_in_air(slab_faces(LENGTH, HEIGHT, n, covered=covered), ratio=ratio)
        for n in (18, 36, 72)
    ]
    order = np.log2((found[1] - found[0]) / (found[2] - found[1]))
    # Numbers of segments on short sides are rounded, which disturbs it.
    assert order == pytest.approx(2.0, abs=0.25)


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
