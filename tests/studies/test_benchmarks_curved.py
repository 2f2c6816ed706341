"""Benchmarks with curved outlines: their meshes, and their accepted values by other ways."""

import numpy as np
import pytest
from msvalidate.studies.benchmarks import (
    curved,
    ellipse,
    hole,
    plate_springs,
    potentials,
    ring,
    shapes,
    thick_plate,
)
from scipy.integrate import quad
from scipy.special import ellipe

import reference_fem
from msvalidate.problem import Isotropic
from reference_fem.elasticity import stiffness

BODIES = {
    "ellipses": (shapes.elliptic_quarter, np.pi / 4 * (3.25 * 2.75 - 2)),
    "ring": (lambda n: shapes.ring_quarter(1.0, 2.0, n), np.pi / 4 * 3),
    "strip": (lambda n: shapes.holed_plate(0.3, 1.0, 3.0, n), 3 - np.pi / 4 * 0.09),
    "plate": (shapes.elliptic_plate, 0.6 * np.pi / 4 * (3.25 * 2.75 - 2)),
    "clamped": (shapes.clamped_plate, 0.6 * np.pi / 4 * (3.25 * 2.75 - 2)),
    "wider": (lambda n: shapes.clamped_plate(n, 0.1), 0.6 * np.pi / 4 * (3.35 * 2.85 - 2)),
}


# Meshes -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", BODIES)
def test_a_curved_mesh_covers_its_body_to_fourth_order(name):
    make, exact = BODIES[name]
    coarse, fine = (abs(make(n).mesh.volume / exact - 1) for n in (2, 4))
    assert fine < 1e-3
    assert np.log2(coarse / fine) > 3.7


def test_halving_lines_leaves_the_others():
    assert shapes.halve_cells(shapes.even_lines(2), 0.5, 1).tolist() == [0, 0.25, 0.5, 0.75, 1]
    assert shapes.halve_cells(shapes.even_lines(2), 1.0, 2).tolist() == [0, 0.5, 0.75, 0.875, 1]


# Accepted values by other ways --------------------------------------------------------------------


def test_potentials_of_a_narrow_hole_go_to_kirschs_stress():
    """What a square's sides add to 3 falls as the square of the hole's size."""
    narrow, wide = (potentials.holed_strip(a, 1.0).sum(complex(a)) - 3 for a in (0.05, 0.1))
    assert narrow < 0.03
    assert wide / narrow == pytest.approx(4, rel=0.1)


def test_potentials_give_a_pressed_ring_the_stress_of_lame():
    """With nothing but two circles: σθθ of outward tension p on the rim is 2 p b²/(b² - a²)."""
    turn = np.exp(1j * np.pi / 2 * (np.arange(40) + 0.5) / 40)
    angle = np.angle(turn)
    sides = (
        potentials.Side(turn, angle, np.zeros(40)),
        potentials.Side(2 * turn, angle, np.ones(40)),
    )
    found = potentials.solve_potentials(potentials.plain, sides, 4, np.array([1.0, 2.0]))
    assert found.missed < 1e-12
    assert found.sum(1.0) == pytest.approx(8 / 3, rel=1e-12)


def test_the_elliptic_membrane_is_in_balance():
    """Across y = 0 the stress bears the pull: ∫σyy dx is the pressure times the half-axis."""
    found = potentials.elliptic_membrane(10.0)
    assert found.missed < 1e-9
    ends = (np.sqrt((a + b) / (a - b)) for a, b in (shapes.INNER, shapes.OUTER))

    def carried(zeta):
        at = np.array([zeta + 0j])
        return found.stress(at)[0, 1] * potentials.ellipses(at)[1].real[0]

    assert quad(carried, *ends)[0] == pytest.approx(10.0 * shapes.OUTER[0], rel=1e-9)


def test_michell_stresses_of_the_membrane_do_not_depend_on_nu():
    """Elements of two ratios come together as they converge, and not by being alike."""
    apart = [abs(ellipse.elastic_tip(0.0, n) - ellipse.elastic_tip(0.45, n)) for n in (4, 8, 16)]
    assert apart[0] > apart[1] > apart[2]
    assert apart[2] < 2e-3 * ellipse.PUBLISHED


def test_kirschs_field_is_in_balance_and_free_on_the_hole():
    place, step = np.array([[1.3, 0.9]]), 1e-5
    slope = [
        (hole.kirsch(place + e) - hole.kirsch(place - e))[0] / (2 * step) for e in step * np.eye(2)
    ]
    assert slope[0][0] + slope[1][2] == pytest.approx(0, abs=1e-9)
    assert slope[0][2] + slope[1][1] == pytest.approx(0, abs=1e-9)
    angle = np.linspace(0, np.pi / 2, 7)
    c, s = np.cos(angle), np.sin(angle)
    xx, yy, xy = hole.kirsch(np.column_stack([c, s])).T
    assert np.abs([xx * c + xy * s, xy * c + yy * s]).max() < 1e-14
    assert hole.kirsch(np.array([[1e4, 1e4]]))[0] == pytest.approx([0, 1, 0], abs=1e-7)
    assert hole.kirsch(hole.ACROSS)[0, 1] == pytest.approx(3)
    assert hole.kirsch(hole.ALONG)[0, 0] == pytest.approx(-1)


@pytest.mark.parametrize(("state", "nu"), [("plane_stress", 0.3), ("plane_strain", 0.45)])
def test_lames_field_meets_the_pressure(state, nu):
    """σrr from the displacement's strains, by differences, at both sides."""
    C = reference_fem.elasticity.elastic_tensor(Isotropic(E=ring.MODULUS, nu=nu, state=state))
    r, step = np.array([ring.INSIDE, ring.OUTSIDE]), 1e-6
    moved, hoop = ring.lame(state, nu, r)
    slope = (ring.lame(state, nu, r + step)[0] - ring.lame(state, nu, r - step)[0]) / (2 * step)
    radial = C[0, 0] * slope + C[0, 1] * moved / r
    assert radial == pytest.approx([-ring.PRESSURE, 0], abs=1e-4 * ring.PRESSURE)
    assert C[1, 0] * slope + C[1, 1] * moved / r == pytest.approx(hoop, rel=1e-4)


# Thick plate --------------------------------------------------------------------------------------


def test_the_line_sinks_by_kelvins_force():
    """The rim's length, an elliptic integral, against its arc by quadrature."""
    A, B = shapes.OUTER
    arc = quad(lambda t: np.hypot(A * np.sin(t), B * np.cos(t)), 0, np.pi / 2)[0]
    assert A * ellipe(1 - (B / A) ** 2) == pytest.approx(arc, rel=1e-12)
    # In plane strain a force P per length in an endless body moves by P (3 - 4 nu) /
    # (8 π G (1 - nu)) ln(1/r); a half space that is held across bears half of twice the force.
    load = thick_plate.PRESSURE * np.pi / 4 * (A * B - 2.0) / arc
    shear = thick_plate.MODULUS / 2.6
    endless = 2 * load * (3 - 1.2) / (8 * np.pi * shear * 0.7)
    assert thick_plate.sunk_by_theory() == pytest.approx(endless * np.log(2), rel=1e-12)


def test_a_pushed_rim_bears_the_plate():
    """The one node that is held bears nothing: with another held the stress is the same."""
    meshed = shapes.elliptic_plate(2)
    body = reference_fem.make_discretisation(meshed.points, meshed.cells, "H2")
    plate = thick_plate.read_solution(thick_plate.solve_plate(thick_plate.SPREAD, meshed, body))
    turned = meshed._replace(boundaries=meshed.boundaries | {"rim": meshed.boundaries["rim"][::-1]})
    again = thick_plate.read_solution(thick_plate.solve_plate(thick_plate.SPREAD, turned, body))
    assert again.stress == pytest.approx(plate.stress, rel=1e-9)


def test_the_plates_reaction_is_near_a_uniform_one():
    """What bounds the factor between the plate's sinking and Kelvin's, uniform, line force."""
    meshed = shapes.elliptic_plate(2, 1)
    body = reference_fem.make_discretisation(meshed.points, meshed.cells, "H2")
    found = thick_plate.solve_plate(thick_plate.LINE, meshed, body)
    force = stiffness(body, found.material) @ found.displacement.T.ravel()
    rim = np.unique(meshed.boundaries["rim"])
    line = rim[np.abs(body.points[rim, 2] - shapes.THICKNESS / 2) < 1e-9]
    line = line[np.argsort(body.points[line, 1])]
    reaction = force.reshape(3, -1)[2][line]
    bears = thick_plate.PRESSURE * np.pi / 4 * (3.25 * 2.75 - 2)
    assert reaction.sum() == pytest.approx(bears, rel=1e-3)
    # Per length: the consistent forces of a quadratic line, its matrix taken back.
    length = np.linalg.norm(np.diff(body.points[line], axis=0), axis=1)
    mass = np.zeros((len(line), len(line)))
    for first in range(0, len(line) - 2, 2):
        part = length[first : first + 2].sum() / 30
        mass[first : first + 3, first : first + 3] += part * np.array(
            [[4, 2, -1], [2, 16, 2], [-1, 2, 4]]
        )
    ratio = np.linalg.solve(mass, reaction) * length.sum() / bears
    assert 0.85 < ratio.min() < 1 < ratio.max() < 1.15


def test_the_wall_of_held_cells_is_as_deep_as_directions_say():
    """Volume of the body in cells held at all corners, over the rim's area: 2/π spacings."""
    problem, lattice, network = plate_springs.spring_model(plate_springs.FACE, 8)
    held = network.fixed.all(axis=1)[lattice.cells].all(axis=1)
    wall = lattice.fraction[held].sum() * lattice.spacing**3
    A, B = problem.domain.points.max(axis=0)[:2]
    rim = A * ellipe(1 - (B / A) ** 2) * shapes.THICKNESS
    assert wall / rim / lattice.spacing == pytest.approx(plate_springs.DEEP, rel=0.1)
    # So what is left free is the plate.
    free = lattice.corner_volume.sum() - wall
    assert free == pytest.approx(0.6 * np.pi / 4 * (3.25 * 2.75 - 2), rel=5e-3)


def test_a_line_is_held_upwards_at_its_level_only():
    _, lattice, whole = plate_springs.spring_model(plate_springs.FACE, 4)
    _, _, line = plate_springs.spring_model(plate_springs.LINE, 4)
    assert (line.fixed[:, :2] == whole.fixed[:, :2]).all()
    assert line.fixed[:, 2].sum() * 5 == whole.fixed[:, 2].sum()
    assert set(lattice.points[line.fixed[:, 2], 2]) == {0.3}


def test_springs_of_the_plate_bear_its_pressure_and_read_uniform_strain():
    problem, lattice, network = plate_springs.spring_model(plate_springs.FACE, 4)
    area = problem.domain.volume / shapes.THICKNESS
    assert -network.force[:, 2].sum() == pytest.approx(area * thick_plate.PRESSURE, rel=1e-3)
    slope = 1e-6 * np.array([[1.0, 0.2, 0.3], [0.4, -0.5, 0.1], [0.0, 0.2, 2.0]])
    stress = plate_springs.read(lattice.points, lattice.points @ slope.T)
    C = reference_fem.elasticity.elastic_tensor(plate_springs.MATERIAL)
    assert stress == pytest.approx(1e-6 * (C[1, :3] @ np.diag(slope)), rel=1e-9)


def test_extrapolation_takes_an_error_of_its_order_off():
    assert plate_springs.extrapolated((4, 6), (1 + 1 / 16, 1 + 1 / 36), 2.0) == pytest.approx(1)
    values = tuple(1 - n**-1.5 for n in (4, 6, 8))
    assert plate_springs.extrapolated((4, 6, 8), values, 1.5) == pytest.approx(1)


def test_mises_stress_of_known_states():
    stress = np.array([[1.0, 0, 0], [1, 1, 0], [0, 0, 1]])
    assert curved.mises(stress) == pytest.approx([1, 1, np.sqrt(3)])
