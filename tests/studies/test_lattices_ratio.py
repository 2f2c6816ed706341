"""Any ratio and rubber in the study `lattices`: known values, and who locks."""

from functools import cache

import numpy as np
import pytest
from msvalidate.studies.lattices.ratio import (
    bent,
    bodies,
    faults,
    pressure,
    routes,
    rubber,
    stretch,
    waves,
)
from msvalidate.studies.lattices.ratio.bent import Bent
from msvalidate.studies.lattices.ratio.routes import Way

from msvalidate import kit
from msvalidate.bench.judging.evidence import judge
from msvalidate.springs.bodies.calibrate import calibrate
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.constants.waves import highest_frequency
from msvalidate.springs.lattice import patterns
from msvalidate.springs.network.faults import stiffen_all
from msvalidate.studies import lattices
from tests.registries import AFFINE


@cache
def found(question):
    return lattices.run(setting=kit.Setting(quick=True), questions=(question,))


@pytest.mark.parametrize("name", AFFINE)
def test_a_points_own_row_has_the_waves_of_the_pattern(name):
    pattern = getattr(patterns, name)()
    springs = routes.calibrate_way(Way(name, "springs"))
    mine = waves.highest(routes.wave_stiffness(pattern, springs))
    assert mine == pytest.approx(highest_frequency(pattern, springs.constants), rel=1e-9)


def test_long_waves_of_squares_feel_the_moduli_and_eight_neighbours():
    # Along x they cost λ + 2μ (compression) and μ (shear), times the square of the phase.
    way = Way("square", "volume energy")
    stencil = routes.wave_stiffness(way.pattern, routes.calibrate_way(way, 0.45))
    K = stencil.stiffness(np.array([[1e-3, 0.0]]))[0].real / 1e-6
    mu, lam = 1 / 2.9, 0.45 / (1 - 0.45**2)
    np.testing.assert_allclose(K, np.diag([lam + 2 * mu, mu]), atol=1e-6)
    assert stencil.coupled == 8
    assert routes.reachable_ratios(way, -1.0) == (0.0, 1.0)
    assert routes.reachable_ratios(way, -2.5) == (-1.0, 1.0)


def test_a_rigid_motion_stretches_no_block():
    lattice = stretch.body("cubic18")
    turn = np.cross([0.1, -0.2, 0.3], lattice.points) + 0.7
    assert bodies.uneven(lattice, turn) < 1e-14
    assert bodies.uneven(lattice, lattice.points**2) > 0.01


def test_one_volume_of_one_cell_is_less_than_all():
    lattice = stretch.body("square")
    problem = stretch.pull_loads(lattice, kit.Isotropic(1.0, 0.45))
    network = lattice_network(problem, lattice, calibrate(1.0, 0.45, lattice))
    lacking = faults.one_volume(network, 1.0).volumes.stiffness
    assert (lacking != network.volumes.stiffness).sum() == 1
    assert lacking.min() == 0


def test_halves_of_cells_keep_the_area_and_lock():
    problem = bent.bend_block("plane_strain", 0.4999)
    network = bent.springs_of(problem, "square", (4, 2))
    halves = bent.springs_of(problem, bent.HALVES, (4, 2))
    assert len(halves.volumes.cells) == 2 * len(network.volumes.cells)
    assert halves.volumes.rest_volume.sum() == pytest.approx(2.0)
    np.testing.assert_allclose(pressure.dilatation(network, 0.3 * network.points), 0.6, rtol=1e-10)
    whole, split, q1 = (
        bent.deflection(kit.solve_springs, Bent("plane_strain", 0.4999, model, 8))
        for model in ("square", bent.HALVES, "Q1")
    )
    assert max(split, q1) < 0.3 * whole


def rows_of_squares(difference):
    """Rows of the table `rubber` of the finest two sizes, with other differences."""
    table = found("rubber").tables["rubber"]
    mine = table[(table["state"] == "plane_strain") & (table["nu_rubber"] == 0.499)]
    mine = mine[(mine["model"] == "square") & (mine["cells_through"] > 4)].copy()
    mine["deflection_difference"] = difference(mine)
    return mine


def test_springs_wrong_by_1_percent_have_orders_out_of_bounds():
    candidate = faults.with_fault(stiffen_all, 0.01)
    pair = [bent.deflection(candidate, Bent("plane_strain", 0.499, "square", n)) for n in (8, 16)]
    wrong = rows_of_squares(lambda mine: pair / mine["deflection_mixed"] - 1)
    assert rubber.orders_outside(wrong)[0] > 0.2


@pytest.mark.parametrize(("order", "out"), [(1.5, 0), (1.0, 0.190), (2.3, 0.3)])
def test_how_far_orders_are_out_of_bounds(order, out):
    # Of small differences both orders are that of the deflection; the least allowed is 1.190.
    rows = rows_of_squares(lambda mine: 1e-6 * (1 / mine["cells_through"]) ** order)
    assert rubber.orders_outside(rows)[0] == pytest.approx(out, abs=1e-3)


def test_squares_that_lose_as_much_as_halves_are_reported_to_lock():
    table = found("rubber").tables["rubber"].copy()
    wrong = table[table["model"] == bent.HALVES]["deflection_difference"].to_numpy()
    place = (table["model"] == "square") & (table["state"] == "plane_strain")
    table.loc[place, "deflection_difference"] = wrong
    evidence = rubber.judge_blocks(table)
    verdict = judge(evidence).set_index("quantity")["verdict"]
    lost, expected = (rule.quantity for rule in rubber.RULES[2:])
    assert verdict[[lost, expected]].tolist() == ["fail", "fail"]
    assert "not lock: cubic18" in evidence.findings[-1]


def test_the_clamped_ends_order_near_half():
    # Williams' clamped-free corner of 90°: (3 - 4 nu) sin²(λπ/2) = 4 (1 - nu)² - λ².
    for nu in (0.3, 0.499):
        half = rubber.end_order("plane_strain", nu) / 2
        left = (3 - 4 * nu) * np.sin(half * np.pi / 2) ** 2
        assert left == pytest.approx(4 * (1 - nu) ** 2 - half**2, abs=1e-8)
