"""The coupling of field and body: uniform slabs against closed forms, energies, what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from msvalidate.problem import Isotropic, ProblemError, SolverError
from reference_fem.actuator import (
    SoftSlab,
    equilibrium_at,
    sweep,
    turning_point,
)
from reference_fem.actuator.staggered import fixed_point
from reference_fem.electric import Electrode, Slab, facing_slab, respond, solve_charges
from reference_fem.large_strain import Fibres, NeoHookean, neo_hookean, square_fibres

pytestmark = pytest.mark.filterwarnings("error")

LATTICE = square_fibres(1.0, 0.5)


def between_plates(element="Q1"):
    """One cell: its only motions are those of the uniform slab and a tilt."""
    return SoftSlab(facing_slab(10.0, 10.0), LATTICE, 1, "plates", element=element)


def in_air(covered=1.0, law=LATTICE, layers=4, frame=0.0):
    slab = facing_slab(30.0, 10.0, covered=covered)
    return SoftSlab(slab, law, layers, reach=100.0, frame=frame)


# --- between plates -------------------------------------------------------------------------------


def uniform_voltage(ratio, k1=1.0, k2=0.5, h=10.0):
    """V(l) of the square lattice squeezed flat (ε = 1)."""
    return np.sqrt(
        2
        * h**2
        * ratio**2
        * (k1 * (1 - ratio) + 2 * k2 * ratio * (np.sqrt(2 / (1 + ratio**2)) - 1))
    )


@pytest.mark.parametrize("element", ["Q1", "Q2"])
def test_uniform_slab_follows_its_curve(element):
    found = sweep(between_plates(element=element), (1.0, 5.0, 6.3))
    assert (found.pull_in, len(found.held)) == (None, 3)
    for held in found.held:
        assert uniform_voltage(held.ratio) == pytest.approx(held.voltage, rel=1e-6)
        assert held.residual <= 1e-8
        # Of two plates C = ε length / thickness.
        assert held.charge[0] == pytest.approx(10 / (10 * held.ratio) * held.voltage, rel=1e-6)
        assert held.charge.sum() == pytest.approx(0, abs=1e-12)


def test_uniform_slab_pulls_in_where_it_should():
    actuator = between_plates()
    found = sweep(actuator, (6.0, 6.6), resolution=0.02)
    low, high = found.pull_in
    assert low < 6.348 < high
    assert high - low <= 0.02 * high
    assert [held.voltage for held in found.held] == [6.0, low]
    top = turning_point(actuator, found.held[0])
    assert (top.voltage, top.ratio) == pytest.approx((6.348, 0.692), abs=5e-4)
    closed = max(uniform_voltage(ratio) for ratio in np.linspace(0.65, 0.75, 10_001))
    assert top.voltage == pytest.approx(closed, rel=1e-7)


def test_linear_stress_pulls_in_at_two_thirds():
    # One fibre up the slab: P = C (l - 1), so V² = 8 C h²/(27 ε). It resists no shear, and the
    # sides hold that.
    law = Fibres(np.array([[0.0, 1.0]]), np.array([1.0]), 1.0)
    actuator = SoftSlab(facing_slab(10.0, 10.0), law, 1, "plates", "Q1")
    top = turning_point(actuator, equilibrium_at(actuator, 5.0))
    assert top.ratio == pytest.approx(2 / 3, abs=5e-4)
    assert top.voltage == pytest.approx(np.sqrt(800 / 27), rel=1e-7)


def test_a_voltage_beyond_pull_in_is_refused_and_names_the_last():
    with pytest.raises(SolverError, match="no equilibrium at 7 V; the last held is at 6\\.") as no:
        equilibrium_at(between_plates(), 7.0, resolution=0.1)
    assert str(no.value).endswith("; stay below, or take `sweep`, which keeps it")
    assert "\n" not in str(no.value)


# --- in air ---------------------------------------------------------------------------------------


def test_forces_are_the_derivative_of_the_energy_that_the_moved_mesh_has():
    actuator = in_air(covered=0.5)
    x, y = actuator.body.points.T
    u = 0.3 * np.column_stack([np.sin(x / 5) * y / 10, -np.cos(x / 7) * y / 10])
    way = np.column_stack([np.cos(x / 3), np.sin(x / 4)]) * (y / 10)[:, None]
    step = 1e-4
    energies = [actuator.electric(u + s * step * way).capacitance / 2 for s in (1, -1)]
    slope = (energies[0] - energies[1]) / (2 * step)
    assert (actuator.electric(u).forces * way).sum() == pytest.approx(slope, rel=1e-6)


@pytest.fixture(scope="module")
def framed():
    return in_air(frame=2.5)


def test_a_slab_in_air_is_at_rest_and_symmetric(framed):
    found = equilibrium_at(framed, 4.0)
    u, solid = found.displacement, framed.solid
    left = 16 * framed.electric(u).forces - solid.internal_force(u)[0]
    assert np.abs(left[~solid.held]).max() <= 1e-6 * np.abs(16 * found.electric.forces).max()
    x = framed.body.points
    mirror = found.at(np.column_stack([30 - x[:, 0], x[:, 1]]))
    assert np.abs(mirror * (-1, 1) - u).max() <= 1e-7
    # The middle is squeezed as a uniform slab is.
    assert uniform_voltage(found.ratio) == pytest.approx(4, rel=0.05)


def test_a_free_end_of_an_electrode_is_lost_early_and_the_last_equilibrium_kept():
    found = sweep(in_air(), (1.0, 3.0), resolution=0.1)
    assert found.held[0].voltage == 1.0
    assert found.pull_in[0] == found.held[-1].voltage
    assert found.pull_in[1] < 3.0
    assert "inside out" in found.why or "do not settle" in found.why


def test_low_voltages_move_by_their_square():
    ratios = [1 - equilibrium_at(in_air(), voltage).ratio for voltage in (0.1, 0.2)]
    assert ratios[1] / ratios[0] == pytest.approx(4, rel=1e-3)


def test_low_voltages_meet_the_linear_response():
    material = Isotropic(1.2, 0.25, "plane_strain")
    actuator = in_air(covered=0.5, law=neo_hookean(material))
    at_rest = solve_charges(actuator.mesh)
    linear = respond(actuator.mesh, at_rest.forces, material).displacement
    errors = []
    for voltage in (0.4, 0.2):
        found = equilibrium_at(actuator, voltage)
        gap = found.displacement / voltage**2 - linear
        errors.append(np.abs(gap).max() / np.abs(linear).max())
    # What linear theory leaves out is of the order of the strain, V².
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.1)
    assert errors[1] < 0.01


# --- fixed points ---------------------------------------------------------------------------------


def test_a_map_without_a_fixed_point_is_refused():
    with pytest.raises(SolverError, match="do not settle: a movement of 1 m is left after 9 turns"):
        fixed_point(lambda x: (x + 1, None), np.zeros((2, 1)), 1e-8, 9)


def test_a_map_to_what_is_no_number_is_refused():
    with pytest.raises(SolverError, match="not a finite number"):
        fixed_point(lambda x: (x * np.nan, None), np.zeros((2, 1)), 1e-8)
    with pytest.raises(ProblemError, match="images: 0"):
        fixed_point(lambda x: (x, None), np.zeros((2, 1)), 1e-8, 0)
    with pytest.raises(ProblemError, match="movement that is none: nan"):
        fixed_point(lambda x: (x, None), np.zeros((2, 1)), np.nan)


# --- bad input ------------------------------------------------------------------------------------


def test_bad_slabs_are_refused():
    slab = facing_slab(20.0, 10.0)
    with pytest.raises(ProblemError, match="slab: 3; give a Slab"):
        SoftSlab(3, LATTICE)
    with pytest.raises(ProblemError, match="around: 'water'; choose air or plates"):
        SoftSlab(slab, LATTICE, around="water")
    with pytest.raises(ProblemError, match="law: not one of two axes"):
        SoftSlab(slab, NeoHookean(1.0, 1.0, 3))
    with pytest.raises(ProblemError, match="depth"):
        SoftSlab(slab, LATTICE, depth=0.0)
    with pytest.raises(ProblemError, match=r"frame: -1\.0 m; give a distance"):
        SoftSlab(slab, LATTICE, frame=-1.0)
    with pytest.raises(ProblemError, match="layers"):
        SoftSlab(slab, LATTICE, 0)
    with pytest.raises(ProblemError, match="plates: an electrode from 5 to 15 m"):
        SoftSlab(facing_slab(20.0, 10.0, covered=0.5), LATTICE, around="plates")
    three = (
        Electrode("top", 0.0, 9.0, 1.0),
        Electrode("top", 11.0, 20.0, 1.0),
        Electrode("bottom", 0.0, 20.0, 0.0),
    )
    with pytest.raises(ProblemError, match="two cover both faces"):
        SoftSlab(Slab(20.0, 10.0, three), LATTICE, around="plates")


def test_bad_sweeps_are_refused():
    actuator = between_plates()
    with pytest.raises(ProblemError, match="give them rising"):
        sweep(actuator, (2.0, 1.0))
    with pytest.raises(ProblemError, match="give them rising"):
        sweep(actuator, (-1.0, 1.0))
    with pytest.raises(ProblemError, match="voltages"):
        sweep(actuator, (float("nan"),))
    with pytest.raises(ProblemError, match="resolution: 0"):
        sweep(actuator, (1.0,), resolution=0)
    with pytest.raises(ProblemError, match="actuator: None"):
        sweep(None, (1.0,))
    held = equilibrium_at(actuator, 2.0)
    with pytest.raises(ProblemError, match="start: at 2 V, above the first voltage, 1 V"):
        sweep(actuator, (1.0,), start=held)
    with pytest.raises(ProblemError, match="start: of another slab"):
        sweep(between_plates(), (3.0,), start=held)
    with pytest.raises(ProblemError, match="start: None"):
        turning_point(actuator, None)
    rest = equilibrium_at(actuator, 0.0)
    with pytest.raises(ProblemError, match="start is at 0 V"):
        turning_point(actuator, rest)
    with pytest.raises(ProblemError, match="actuator: None"):
        turning_point(None, held)
    with pytest.raises(ProblemError, match="start: 5; give an Actuated"):
        sweep(actuator, (1.0,), start=5)
    with pytest.raises(ProblemError, match=r"displacement of the slab: shape \(2, 2\)"):
        actuator.electric(np.zeros((2, 2)))
    with pytest.raises(ProblemError, match="displacement of the slab: nan"):
        actuator.electric(np.full(actuator.body.points.shape, np.nan))
