"""Any ratio and rubber in the study `lattices`: known values, and who locks."""

from __future__ import annotations

from functools import cache
from math import sqrt

import numpy as np
import pytest
from msvalidate.studies.lattices.ratio import (
    bent,
    bodies,
    faults,
    locking,
    pressure,
    routes,
    rubber,
    stretch,
    waves,
)
from msvalidate.studies.lattices.ratio.bent import Bent
from msvalidate.studies.lattices.ratio.routes import Way
from msvalidate.studies.lattices.ratio.stretch import Block

from msvalidate.bodies.calibrate import calibrate
from msvalidate.bodies.lattice_network import lattice_network
from msvalidate.constants.waves import highest_frequency
from msvalidate.judging.candidate import solve_springs
from msvalidate.judging.compare import observed_order
from msvalidate.judging.evidence import all_passed, judge
from msvalidate.judging.sweep import Setting
from msvalidate.lattice import patterns
from msvalidate.network.faults import stiffen_all
from msvalidate.problem import Isotropic
from msvalidate.studies import lattices

QUICK = Setting(quick=True)


@cache
def found(question):
    return lattices.run(setting=QUICK, questions=(question,))


@pytest.mark.parametrize("question", ["any_ratio", "rubber"])
def test_both_questions_hold(question):
    verdict = judge(found(question))
    assert all_passed(verdict), verdict[verdict["verdict"] == "fail"].to_string()


def test_every_ratio_of_the_plane_and_of_space_is_stretched():
    table = found("any_ratio").tables["any_ratio"]
    for state, ends in (("plane_stress", (-0.5, 0.499)), ("solid", (0.0, 0.49))):
        mine = table[table["state"] == state]
        assert (mine["nu_asked"].min(), mine["nu_asked"].max()) == ends
    assert table["nu_axes"].max() > 0.99


@pytest.mark.parametrize("name", ["square", "triangular", "cubic18", "bcc"])
def test_a_points_own_row_has_the_waves_of_the_pattern(name):
    pattern = getattr(patterns, name)()
    found_ = routes.calibrate_way(Way(name, "springs"), 1 / (pattern.dim + 1))
    mine = waves.highest(routes.wave_stiffness(pattern, found_))
    assert mine == pytest.approx(highest_frequency(pattern, found_.constants), rel=1e-9)


def test_long_waves_feel_the_moduli():
    # Along x they cost λ + 2μ (compression) and μ (shear), times the square of the phase.
    pattern = patterns.square()
    found_ = routes.calibrate_way(Way("square", "volume energy"), 0.45)
    K = routes.wave_stiffness(pattern, found_).stiffness(np.array([[1e-3, 0.0]]))[0].real / 1e-6
    mu, lam = 1 / 2.9, 0.45 / (1 - 0.45**2)
    np.testing.assert_allclose(K, np.diag([lam + 2 * mu, mu]), atol=1e-6)


def test_a_point_of_squares_is_coupled_with_eight():
    way = Way("square", "volume energy")
    stencil = routes.wave_stiffness(way.pattern, routes.calibrate_way(way, 0.45))
    assert stencil.coupled == 8


def test_ratios_that_a_part_leaves_open():
    square = Way("square", "volume energy")
    assert routes.reachable_ratios(square, -1.0) == (0.0, 1.0)
    assert routes.reachable_ratios(square, -2.5) == (-1.0, 1.0)


def test_a_rigid_motion_stretches_no_block():
    lattice = stretch.body("cubic18")
    turn = np.cross([0.1, -0.2, 0.3], lattice.points) + 0.7
    assert bodies.uneven(lattice, turn) < 1e-14
    assert bodies.uneven(lattice, lattice.points**2) > 0.01


def test_a_small_volume_fault_shows_in_proportion():
    block = Block("square", "plane_stress", 0.45)
    one, ten = (
        abs(stretch.measure(faults.with_fault(faults.every_volume, s), block)["nu_found"] - 0.45)
        for s in (1e-6, 1e-5)
    )
    assert ten == pytest.approx(10 * one, rel=1e-3)


def test_one_volume_of_one_cell_is_less_than_all():
    lattice = stretch.body("square")
    material = Isotropic(1.0, 0.45)
    network = lattice_network(
        stretch.pull_loads(lattice, material), lattice, calibrate(1.0, 0.45, lattice)
    )
    kappa = network.volumes.stiffness
    lacking = faults.one_volume(network, 1.0).volumes.stiffness
    assert (lacking != kappa).sum() == 1
    assert lacking.min() == 0


def test_halves_of_cells_keep_the_area_and_lock():
    problem = bent.bend_block("plane_strain", 0.4999)
    network = bent.springs_of(problem, "square", (4, 2))
    halves = bent.springs_of(problem, bent.HALVES, (4, 2))
    assert len(halves.volumes.cells) == 2 * len(network.volumes.cells)
    assert halves.volumes.rest_volume.sum() == pytest.approx(2.0)
    whole, split, q1 = (
        bent.deflection(solve_springs, Bent("plane_strain", 0.4999, model, 8))
        for model in ("square", bent.HALVES, "Q1")
    )
    assert max(split, q1) < 0.3 * whole


def test_volumes_lose_little_where_elements_lock():
    lost = found("rubber").tables["rubber_locking"].set_index(["state", "model"])["lost"]
    assert lost["plane_strain", "Q1"] < -0.3 < -0.01 < lost["plane_strain", "square"] < 0
    assert abs(lost["plane_stress", "Q1"]) < 0.01


@pytest.mark.parametrize(("size", "low"), [(0.01, True), (-0.01, False)])
def test_springs_wrong_by_1_percent_have_orders_out_of_bounds(size, low):
    candidate = faults.with_fault(stiffen_all, size)
    pair = [bent.deflection(candidate, Bent("plane_strain", 0.499, "square", n)) for n in (8, 16)]
    table = found("rubber").tables["rubber"]
    mine = table[(table["state"] == "plane_strain") & (table["nu_rubber"] == 0.499)]
    mine = mine[(mine["model"] == "square") & (mine["cells_through"] > 4)].copy()
    mine["deflection_difference"] = pair / mine["deflection_mixed"] - 1
    row = rubber.approach(mine).iloc[0]
    assert row["order_outside"] > 0.2
    assert (row["rubber_order"] < row["twice_exponent_rubber"]) == low


def test_how_far_orders_are_out_of_bounds():
    # Errors a h^p + b h² of one sign have a slope between p and 2.
    h = np.array([1 / 8, 1 / 16])
    slope = observed_order(h, 0.5 * h**1.2 + 2 * h**2)
    assert 1.2 < slope < 2
    assert rubber.outside(slope, slope, 1.2) == 0
    assert rubber.outside(1.1, 1.3, 1.2) == 0
    assert rubber.outside(0.9, 1.0, 1.2) == pytest.approx(0.2)
    assert rubber.outside(2.3, 2.1, 1.2) == pytest.approx(0.1)


def test_halves_are_said_to_lock():
    table = found("rubber").tables["rubber"].copy()
    wrong = table[table["model"] == bent.HALVES]["deflection_difference"].to_numpy()
    place = (table["model"] == "square") & (table["state"] == "plane_strain")
    table.loc[place, "deflection_difference"] = wrong
    verdict = judge(locking.run(table)).set_index("quantity")["verdict"]
    assert (verdict == "fail").sum() == 2
    assert "not lock: cubic18" in locking.run(table).findings[0]


def test_the_clamped_ends_order_near_half():
    # Williams' clamped-free corner of 90°: (3 - 4 nu) sin²(λπ/2) = 4 (1 - nu)² - λ².
    for nu in (0.3, 0.499):
        half = rubber.end_order("plane_strain", nu) / 2
        left = (3 - 4 * nu) * np.sin(half * np.pi / 2) ** 2
        assert left == pytest.approx(4 * (1 - nu) ** 2 - half**2, abs=1e-8)


def test_black_against_white_pushes_nothing():
    assert pressure.push_row(("all round", 5))["silent"] == 2
    assert pressure.push_row(("left", 5))["silent"] == 0


def test_pressures_of_a_uniform_swelling():
    problem = bent.bend_block("plane_strain", 0.4)
    network = bent.springs_of(problem, "square", (4, 2))
    swollen = pressure.dilatation(network, 0.3 * network.points)
    np.testing.assert_allclose(swollen, 0.6, rtol=1e-10)


def test_steps_grow_with_the_root_of_the_bulk_modulus():
    table = found("rubber").tables["rubber_rest"].set_index("nu_settled")
    grown = table["steps_leapfrog"][0.495] / table["steps_leapfrog"][0.485]
    assert grown == pytest.approx(sqrt(3), rel=0.02)
