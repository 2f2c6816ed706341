"""Constants of an isotropic material: every route against closed forms, bodies, and refusals."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from msvalidate.problem import Anisotropic, Box, Isotropic, Problem, ProblemError, Support
from msvalidate.springs.bodies.calibrate import calibrate, calibrate_material
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.constants.homogenise import deforms_affinely
from msvalidate.springs.constants.routes import default_constants
from msvalidate.springs.lattice import fill, patterns, square, triangular, voronoi, zigzag_block
from tests.registries import AFFINE, GRIDS, LATTICES
from tests.table import table

PLANE = {
    "square": patterns.square(),
    "square body": square(Box((1.0, 1.0)), 2),
    "triangles": triangular(zigzag_block(1.0, (2, 2)), 0.5),
}
SOLID = [name for name in AFFINE if LATTICES[name]().dim == 3]
PLANE_RATIOS = (-0.5, 0.0, 0.2, 1 / 3, 0.45, 0.499)
SOLID_RATIOS = (0.0, 0.25, 0.4, 0.49)
VOLUME, SPRINGS = "volume energy", "springs"
SHEET = square(Box((1.0, 1.0)), 2)
THICKNESS = 0.3
ROUNDING = 1e-12
"""Of constants, relative to the largest. Near 1/2 κ is a thousand times the rest, which an eps of
it enters: 2e-13."""


def pattern_of(name):
    return getattr(patterns, name)()


def lame(E, nu):
    return E * nu / ((1 + nu) * (1 - 2 * nu)), E / (2 * (1 + nu))


def plane_tensor(E, nu, state, thickness):
    """(3, 3) in N/m from Lamé's constants of the three-dimensional material."""
    lam, mu = lame(E, nu)
    if state == "plane_stress":  # no stress across: λ becomes 2λμ/(λ + 2μ)
        lam = 2 * lam * mu / (lam + 2 * mu)
    C = np.diag([2 * mu, 2 * mu, mu])
    C[:2, :2] += lam
    return thickness * C


def solid_tensor(E, nu):
    lam, mu = lame(E, nu)
    C = np.diag([2 * mu] * 3 + [mu] * 3)
    C[:3, :3] += lam
    return C


# Routes -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", PLANE)
@pytest.mark.parametrize("state", ["plane_stress", "plane_strain"])
@pytest.mark.parametrize("nu", PLANE_RATIOS)
def test_a_plane_lattice_is_any_material_by_a_volume_energy(name, state, nu):
    found = calibrate(2.0, nu, PLANE[name], state, thickness=THICKNESS, route=VOLUME)
    tensor = plane_tensor(2.0, nu, state, THICKNESS)
    np.testing.assert_allclose(found.tensor, tensor, atol=ROUNDING * tensor.max())
    assert (found.E, found.nu, found.zener) == pytest.approx((2.0, nu, 1.0), abs=ROUNDING)
    assert found.route == VOLUME
    assert min(found.constants) > 0


@pytest.mark.parametrize("name", SOLID)
@pytest.mark.parametrize("nu", SOLID_RATIOS)
def test_a_solid_lattice_is_any_material_by_a_volume_energy(name, nu):
    found = calibrate(2.0, nu, pattern_of(name), "solid", spacing=0.1, route=VOLUME)
    tensor = solid_tensor(2.0, nu)
    np.testing.assert_allclose(found.tensor, tensor, atol=ROUNDING * tensor.max())
    assert (found.E, found.nu, found.zener) == pytest.approx((2.0, nu, 1.0), abs=ROUNDING)


@pytest.mark.parametrize("nu", [0.34, 0.4, 0.45, 0.5, 0.7, 0.95])
def test_honeycomb_has_its_closed_form(nu):
    # In the plane E2 and nu2 of plane strain reach beyond 1/2: nu2 = nu/(1 - nu).
    found = calibrate(1.0, nu / (1 + nu), patterns.honeycomb(), "plane_strain")
    k1, k2 = found.constants
    assert (k1 + 3 * k2) / (k1 + 9 * k2) == pytest.approx(nu, abs=1e-9)
    assert math.sqrt(3) / 2 * k2 == pytest.approx(1 / (2 * (1 + nu / (1 + nu))), rel=1e-8)
    assert pytest.approx(1.0, rel=1e-8) == found.E


def test_constants_come_by_search_where_no_rule_has_them():
    mine = replace(patterns.cubic26(), name="mine", rules={"equal": (1.0, 1.0, 1.0)})
    found = calibrate(2.0, 0.25, mine, "solid")
    assert found.route == SPRINGS
    np.testing.assert_allclose(found.tensor, solid_tensor(2.0, 0.25), atol=1e-12)


def test_a_lattice_of_a_body_brings_its_pattern_and_spacing():
    box = Box((2.0, 1.0))
    for lattice in (square(box, (4, 2)), fill(patterns.square(), box, (4, 2))):
        found = calibrate(1.0, 0.3, lattice)
        assert found.constants == calibrate(1.0, 0.3, patterns.square()).constants
    block = PLANE["triangles"]
    assert calibrate(1.0, 0.3, block).volume == calibrate(1.0, 0.3, patterns.triangular()).volume
    solid = fill(patterns.fcc(), Box((1.0, 1.0, 1.0)), 5)
    assert calibrate(1.0, 0.3, solid, "solid").constants == pytest.approx(
        calibrate(1.0, 0.3, patterns.fcc(), "solid", spacing=0.2).constants, rel=1e-13
    )
    assert default_constants(Isotropic(1.0, 1 / 3), square(box, (4, 2))) == pytest.approx(
        (0.75, 0.375), rel=1e-14
    )


def test_points_follow_a_strain_where_all_are_centres_of_symmetry():
    for name, make in patterns.all_patterns().items():
        assert deforms_affinely(make()) == (name != "honeycomb"), name
    assert not deforms_affinely(voronoi(12, seed=1))


# Refusals ---------------------------------------------------------------------------------------


@table(
    ("nu", "name", "plane", "route", "said"),
    [
        (0.45, "square", "plane_stress", SPRINGS, "isotropic at 0.333333 only"),
        (0.3, "triangular", "plane_stress", SPRINGS, "isotropic at 0.333333 only"),
        (0.3, "cubic18", "solid", SPRINGS, "isotropic at 0.25 only"),
        (0.5, "square", "plane_strain", None, "nothing is compressible, and κ would be infinite"),
        (0.5, "cubic18", "solid", VOLUME, "take nu below 1/2, such as 0.499"),
        (0.5, "honeycomb", "plane_strain", None, "nothing is compressible, which takes an infin"),
        (0.2, "honeycomb", "plane_stress", None, "leave nu = 0.333333 and a Zener ratio of 1"),
        (1 / 3, "honeycomb", "plane_stress", None, "leave nu = 0.333333"),
        (0.4, "honeycomb", "plane_stress", VOLUME, "take one whose points are centres of symmetr"),
        (1 / 3, "square4", "plane_stress", None, "no spring constants make it isotropic"),
        (0.3, "cubic6", "solid", None, "no spring constants make it isotropic"),
        (0.3, "cubic6", "solid", VOLUME, "no spring constants make it isotropic"),
        (0.3, "square", "solid", None, "the material is a solid; take plane stress or strain"),
        (0.3, "bcc", "plane_stress", None, "material in plane_stress; give a solid"),
        (-0.2, "fcc", "solid", None, "its points are not all corners of cells: take a ratio along"),
        (-0.2, "fcc", "solid", None, "above -0.166667"),
        (-0.6, "triangular", "plane_stress", None, "above -0.5"),
        (0.6, "square", "plane_stress", None, "a stable material has -1 < nu <= 1/2"),
        (0.3, "square", "plane", None, "plane"),
        (0.3, "square", "plane_stress", "angles", "route: 'angles'; choose springs, volume energy"),
        (0.3, "square", "plane_stress", "shear springs", "is gone; take 'volume energy'"),
    ],
)
def test_what_a_lattice_cannot_be_is_refused_with_the_nearest(nu, name, plane, route, said):
    with pytest.raises(ProblemError, match=said) as caught:
        calibrate(1.0, nu, pattern_of(name), plane, route=route)
    assert "\n" not in str(caught.value)


def test_a_random_lattice_is_not_isotropic_and_says_what_it_is():
    with pytest.raises(ProblemError, match=r"the nearest found, .* leave nu = 0\..* Zener ratio"):
        calibrate(1.0, 0.4, voronoi(12, seed=1))


@table(("call", "said"), [
    (lambda: calibrate(1.0, 0.3, None), "give a Pattern or a Lattice"),
    (lambda: calibrate(1.0, 0.3, SHEET, spacing=1.0), "leave it out"),
    (lambda: calibrate(1.0, 0.3, patterns.square(), spacing=0.0), "spacing"),
    (lambda: calibrate(-1.0, 0.3, patterns.square()), "Young's modulus E"),
    (lambda: calibrate_material(Anisotropic(np.eye(3)), patterns.square()), "must be isotropic"),
    (lambda: calibrate_material(Isotropic(1.0, 0.3), replace(PLANE["triangles"], unit_cell=None)),
        "none known for triangular; give the constants, or calibrate the pattern"),
])  # fmt: skip
def test_bad_questions_are_refused(call, said):
    with pytest.raises(ProblemError, match=said):
        call()


def test_a_calibration_brings_its_own_volume_energy():
    box = Box((1.0, 1.0))
    grid = square(box, 2)
    problem = Problem(box, Isotropic(1.0, 0.3), (Support(box.side("left"), (0.0, 0.0)),))
    with pytest.raises(ProblemError, match="a calibration brings its own, leave it out"):
        lattice_network(problem, grid, calibrate(1.0, 0.3, grid), volume=1.0)
    with pytest.raises(ProblemError, match=r"volume stiffness: .*; give one number"):
        lattice_network(problem, grid, (1.0, 1.0), volume=np.ones(2))


@table(("other", "said"), [
    (calibrate(1.0, 0.3, patterns.cubic18(), "solid"), "a spacing of 1 m, not 0.25 m"),
    (calibrate(1.0, 0.3, patterns.cubic18(), "solid", spacing=0.1),
        "a spacing of 0.1 m, not 0.25 m"),
    (calibrate(1.0, 0.3, patterns.bcc(), "solid", spacing=0.25), "a BCC lattice, not cubic 18"),
    (calibrate(1.0, 0.3, patterns.square()), "a square lattice, not cubic 18"),
    (calibrate(1.0, 0.2, patterns.cubic18(), "solid", spacing=0.25),
        "E = 1 Pa and nu = 0.2 of another state or size than the problem's 1 and 0.3 in solid"),
])  # fmt: skip
def test_a_calibration_of_something_else_is_refused(other, said):
    # Each has as many constants as the body has kinds: it would be another material, silently.
    cube = Box((1.0, 1.0, 1.0))
    held = (Support(cube.side("left"), (0.0, 0.0, 0.0)),)
    problem, grid = (
        Problem(cube, Isotropic(1.0, 0.3, "solid"), held),
        fill(patterns.cubic18(), cube, 4),
    )
    assert len(other.constants) == grid.kinds
    with pytest.raises(ProblemError, match=f"calibration: for {said}; calibrate the problem's own"):
        lattice_network(problem, grid, other)


def test_a_calibration_is_for_the_tensor_of_an_anisotropic_material_alone():
    box = Box((1.0, 1.0))
    made, held = calibrate(1.0, 1 / 3, SHEET), (Support(box.side("left"), (0.0, 0.0)),)
    lattice_network(Problem(box, Anisotropic(made.tensor), held), SHEET, made)
    other = Problem(box, Anisotropic(np.diag([1.0, 4.0, 1.0])), held)
    with pytest.raises(ProblemError, match="not the problem's tensor; give spring constants"):
        lattice_network(other, SHEET, made)


def test_a_calibration_is_not_for_a_material_that_keeps_its_volume():
    # Plane strain of nu = 1/2 is a plane ratio of 1: no finite tensor to compare with.
    box = Box((1.0, 1.0))
    material = Isotropic(1.0, 0.5, "plane_strain")
    problem = Problem(box, material, (Support(box.side("left"), (0.0, 0.0)),))
    with pytest.raises(ProblemError, match=r"calibration: for E = 1 Pa and nu = 0\.3 of another"):
        lattice_network(problem, SHEET, calibrate(1.0, 0.3, SHEET, "plane_strain"))


def test_a_calibration_of_another_thickness_is_refused_and_of_another_spacing_in_the_plane_not():
    box = Box((1.0, 1.0))
    held = (Support(box.side("left"), (0.0, 0.0)),)
    problem = Problem(box, Isotropic(1.0, 0.3, thickness=THICKNESS), held)
    for thickness in (0.2, 1.0):
        with pytest.raises(ProblemError, match=f"for a thickness of {thickness:g} m, not 0.3 m"):
            lattice_network(problem, SHEET, calibrate(1.0, 0.3, SHEET, thickness=thickness))
    other = calibrate(1.0, 0.3, patterns.square(), thickness=THICKNESS, spacing=7.0)
    own = calibrate(1.0, 0.3, SHEET, thickness=THICKNESS)
    theirs, ours = (lattice_network(problem, SHEET, found) for found in (other, own))
    np.testing.assert_allclose(theirs.stiffness, ours.stiffness, rtol=1e-14)


def test_cells_that_are_triangles_bear_what_rectangles_do_not():
    found = calibrate(1.0, -0.9, PLANE["triangles"])
    assert (found.E, found.nu) == pytest.approx((1.0, -0.9), abs=1e-12)
    with pytest.raises(ProblemError, match=r"above -0\.5"):
        calibrate(1.0, -0.9, patterns.triangular())


@pytest.mark.parametrize("name", GRIDS)
@pytest.mark.parametrize("nu", [-0.3, 0.2, 0.49])
def test_springs_against_pressure_are_any_material(name, nu):
    pattern = getattr(patterns, name)()
    plane = "plane_strain" if pattern.dim == 2 else "solid"
    body = fill(pattern, Box((0.37,) * pattern.dim), 3)
    found = calibrate(2.0, nu, body, plane, route="neo-Hookean")
    assert found.body.verdict == "exact"
    assert (found.E, found.nu) == pytest.approx((2.0, nu), abs=1e-12)


def test_springs_that_sides_cut_are_no_match_for_pressure():
    box = Box((1.0, 1.0, 1.0))
    held = (Support(box.side("left"), (0.0, 0.0, 0.0)),)
    body, material = fill(patterns.bcc(), box, 3), Isotropic(2.0, 0.2, "solid")
    found = calibrate_material(material, body, route="neo-Hookean")
    with pytest.raises(ProblemError, match="out of balance at point 0"):
        lattice_network(Problem(box, material, held), body, found)
