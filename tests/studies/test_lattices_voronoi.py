"""The study `lattices`: random solids and bodies, their surfaces, and ratios of zero."""

import pickle
from functools import partial

import numpy as np
import pandas as pd
import pytest
from msvalidate.studies.lattices.voronoi import (
    best,
    bodies,
    early,
    energy,
    faults,
    networks,
    solids,
    strewn,
    surfaces,
    trials,
)
from scipy.optimize import minimize
from scipy.spatial import KDTree, Voronoi
from scipy.stats import t as student
from scipy.stats import ttest_rel

import reference_fem
from msvalidate.constants.directions import rotate_tensor
from msvalidate.constants.homogenise import homogenise
from msvalidate.constants.stiffness import cubic_part, isotropic_moduli, isotropic_part
from msvalidate.judging.candidate import solve_springs
from msvalidate.judging.evidence import judge
from msvalidate.judging.sweep import Setting
from msvalidate.lattice import STIFFNESS_RULES
from msvalidate.lattice.voronoi import pattern_of_tessellation
from msvalidate.problem import Box

QUICK = Setting(quick=True)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("rule", STIFFNESS_RULES)
def test_moduli_of_a_network_by_least_squares(dim, rule):
    cells = networks.draw_network((dim, "uniform", 30, 7))
    pattern = pattern_of_tessellation(cells, rule)
    C = energy.energy_tensor(cells, pattern.stiffness((1.0,)))
    found = networks.moduli(homogenise, pattern, rule)
    assert found["tensor"] == pytest.approx(C, abs=1e-9 * np.abs(C).max())
    if rule == "A/L":
        assert C[:dim, :dim].sum() / dim**2 == pytest.approx(1 / dim, rel=1e-10)
        assert found["E"] == pytest.approx(1 - (dim - 1) * found["nu"], rel=1e-10)


@pytest.mark.parametrize("dim", [2, 3])
def test_the_ratio_follows_from_what_bulk_and_shear_lose(dim):
    """Cauchy's bulk modulus is 2 G in the plane and 5/3 G in space; relaxation takes parts."""
    for row in networks.measure(homogenise, (dim, "blue_noise", 40, 3)):
        over = (1 - row["bulk_lost"]) / (1 - row["shear_lost"]) * {2: 2, 3: 5 / 3}[dim]
        # nu = (dK - 2G)/(d(d - 1)K + 2G)
        nu = (dim * over - 2) / (dim * (dim - 1) * over + 2)
        assert row["nu"] == pytest.approx(nu, rel=1e-10)


def test_isotropic_part_is_the_mean_over_rotations():
    tensor = networks.measure(homogenise, (2, "uniform", 20, 1))[0]["tensor"]
    turned = [rotate_tensor(tensor, angle) for angle in np.arange(8) * np.pi / 8]
    mean = np.mean(turned, axis=0)
    assert isotropic_part(tensor) == pytest.approx(mean, abs=1e-12)
    sizes = [networks.anisotropy(C) for C in turned]
    assert np.ptp(sizes) < 1e-12
    assert sizes[0] > 0.01
    assert networks.anisotropy(mean) < 1e-12


def test_isotropic_part_in_space():
    tensor = networks.measure(homogenise, (3, "uniform", 20, 1))[0]["tensor"]
    part = isotropic_part(tensor)
    assert networks.anisotropy(part) < 1e-12
    before, after = isotropic_moduli(tensor), isotropic_moduli(part)
    assert (after.E, after.nu) == pytest.approx((before.E, before.nu), rel=1e-12)
    assert after.zener == pytest.approx(1, abs=1e-12)


def test_along_axes_is_the_mean_over_quarter_turns_and_mirrors():
    tensor = networks.measure(homogenise, (2, "jittered", 20, 1))[0]["tensor"]
    mirror = np.diag([1.0, 1.0, -1.0])
    alike = [tensor, rotate_tensor(tensor, np.pi / 2)]
    alike += [mirror @ C @ mirror for C in alike]
    assert cubic_part(tensor) == pytest.approx(np.mean(alike, axis=0), abs=1e-12)


def test_summary_has_students_interval():
    rows = [networks.measure(homogenise, (2, "uniform", 20, seed))[0] for seed in range(5)]
    row = solids.summary(pd.DataFrame(rows))
    nu = [r["nu"] for r in rows]
    low, high = student.interval(
        0.95, len(nu) - 1, loc=np.mean(nu), scale=np.std(nu, ddof=1) / np.sqrt(len(nu))
    )
    assert (row["nu_low"], row["nu_high"]) == pytest.approx((low, high), rel=1e-9)


def test_spreads_are_told_apart_as_often_as_is_meant():
    """Pairs of equal spread at 5 %, correlated or not; of unequal spread nearly always."""
    rng = np.random.default_rng(2)
    x, y = rng.normal(size=(2, 2000, 12))
    for other in (y, 0.6 * x + 0.8 * y):
        told = np.mean([best.differ_by_spread(a, b) for a, b in zip(x, other, strict=True)])
        assert told == pytest.approx(0.05, abs=0.02)
    assert np.mean([best.differ_by_spread(a, 5 * b) for a, b in zip(x, y, strict=True)]) > 0.95


def test_means_are_told_apart_as_scipy_tells_them():
    rng = np.random.default_rng(4)
    pairs = [(rng.normal(size=8), rng.normal(shift, 1, 8)) for shift in np.linspace(0, 2, 20)]
    told = [best.differ_by_mean(a, b) for a, b in pairs]
    assert told == [ttest_rel(a, b).pvalue < 0.05 for a, b in pairs]
    assert {True, False} == set(told)


def test_standard_error_of_an_exponent_is_its_scatter():
    """Normal draws whose spread falls with the root of the count, many times over."""
    rng = np.random.default_rng(5)
    count = np.array([100, 400, 1600])
    found = []
    for _ in range(400):
        spread = [rng.normal(0, n**-0.5, 20).std(ddof=1) for n in count]
        table = pd.DataFrame({"count": count, "nu_std": spread, "anisotropy": spread})
        table[["axes", "point_set", "stiffness", "seeds"]] = [2, "uniform", "1", 20]
        found.append(solids.exponents(table))
    power = np.array([row["nu_exponent"] for row in found])
    assert power.mean() == pytest.approx(-0.5, abs=0.02)
    assert power.std() == pytest.approx(found[0]["nu_exponent_error"], rel=0.15)


@pytest.mark.parametrize("name", faults.FAULTS)
def test_faults_break_what_holds_for_every_seed(name):
    """Each by an identity of one network, but for points not at rest, which no identity tells."""
    pattern = pattern_of_tessellation(networks.draw_network((2, "uniform", 100, 2)), "A/L")
    right = networks.moduli(homogenise, pattern, "A/L")
    wrong = networks.moduli(faults.FAULTS[name]["solid"], pattern, "A/L")
    if name == "random solids 5 % unrelaxed":
        assert abs(wrong["affine_sum"]) < 1e-12
        assert abs(wrong["bulk"]) < 1e-9
        assert wrong["above_affine"] < 1e-12
        return
    if name == "random solids with their points held":
        assert abs(wrong["nu"] - 1 / 3) < 1e-12 < abs(right["nu"] - 1 / 3)
    else:
        assert abs(right["affine_sum"]) < 1e-12
        assert abs(wrong["affine_sum"]) > 1e-6


def test_a_little_unrelaxed_is_told_by_least_squares_alone():
    solid = faults.FAULTS["random solids 5 % unrelaxed"]["solid"]
    limit = energy.TOLERANCE.limit
    for case in energy.CASES:
        assert energy.compare_tensors(homogenise, case)["squares_error"] < limit
        row = energy.compare_tensors(solid, case)
        left = 0.05 / 0.95 * row["random_released"]
        assert row["squares_error"] == pytest.approx(left, rel=1e-6)
        assert row["squares_error"] > 1e6 * limit
    verdict = judge(solids.run(solid, QUICK))
    missed = verdict.loc[verdict["verdict"] == "fail", "quantity"]
    assert missed.tolist() == [energy.TOLERANCE.quantity]


def test_cases_travel_to_other_processes():
    for work in (
        partial(networks.measure, homogenise),
        partial(bodies.measure, solve_springs),
        partial(trials.few, solve_springs),
        early.stops,
    ):
        assert pickle.dumps(work)


def test_same_seed_same_networks():
    assert networks.seeds(QUICK) == networks.seeds(Setting(quick=True))
    assert networks.seeds(QUICK) != networks.seeds(Setting(quick=True, seed=1))
    assert networks.seeds(Setting())[:6] == networks.seeds(QUICK)


def test_a_strewn_body_has_the_springs_of_its_voronoi_diagram():
    body = strewn.strewn("uniform", 25, "1", 3)
    x, (width, height) = body.cells.points, body.box.size
    mirrored = [x, x * (-1, 1), (2 * width, 0) + x * (-1, 1), x * (1, -1)]
    mirrored.append((0, 2 * height) + x * (1, -1))
    pairs = Voronoi(np.concatenate(mirrored)).ridge_points
    inside = np.sort(pairs[(pairs < len(x)).all(axis=1)], axis=1)
    assert {tuple(p) for p in inside} == {tuple(p) for p in np.sort(body.cells.springs, axis=1)}


def test_surface_points_are_those_nearest_to_places_on_the_side():
    body = strewn.strewn("jittered", 49, "1", 1)
    along = np.linspace(0, body.box.size[0], 20001)
    _, nearest = KDTree(body.cells.points).query(np.column_stack([along, 0 * along]))
    in_order = nearest[np.flatnonzero(np.diff(nearest, prepend=-1))]
    assert body.surface("bottom").tolist() == in_order.tolist()


def test_ends_of_bodies_of_few_points_are_apart():
    for seed in range(300):
        body = strewn.strewn("uniform", 3, "1", seed)
        for low, high in (("left", "right"), ("bottom", "top")):
            first, last = body.ends(low, high)
            assert first.any()
            assert last.any()
            assert not (first & last).any()


@pytest.mark.parametrize("dim", [2, 3])
def test_depth_of_a_surface_by_nearest_points(dim):
    """No cells at all: the nearest of uniform points to places far from the other sides."""
    rng = np.random.default_rng(11)
    squares = []
    for _ in range(40):
        x = rng.random((int(10**dim), dim)) * 10
        places = np.column_stack([4 + 2 * rng.random((400, dim - 1)), np.zeros(400)])
        _, nearest = KDTree(x).query(places)
        squares.append((x[nearest, -1] ** 2).mean())
    error = np.std(squares) / np.sqrt(len(squares))
    assert np.mean(squares) == pytest.approx(surfaces.DEPTH[dim] ** 2, abs=4 * error)


def test_the_drawn_body_narrows_as_it_is_stretched():
    table = surfaces.lines(solve_springs, 1, "blue_noise")
    top = table[(table["part"] == "surface") & (table["y"] > 6.5) & (table["y_end"] > 6.5)]
    assert (table["ux"].max(), table["ux"].min()) == pytest.approx((7, 0), abs=1.5)
    assert top["uy"].mean() < 0


def test_stretch_is_the_closed_form_of_any_tensor():
    tensor = cubic_part(networks.measure(homogenise, (2, "jittered", 64, 1))[2]["tensor"])
    exact, _ = bodies.expected_response(tensor)
    box = Box((1.0, 1.0))
    problem = bodies.stretch(box)
    problem = type(problem)(box, bodies.Anisotropic(tensor), problem.supports, problem.loads)
    mesh = reference_fem.box_discretisation(box, 3, "Q2")
    move = reference_fem.solve_problem(problem, mesh).at([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)])
    assert 1 / (move[1, 0] - move[0, 0]) == pytest.approx(exact["stretch: modulus"], rel=1e-9)
    ratio = -(move[2, 1] - move[1, 1]) / (move[1, 0] - move[0, 0])
    assert ratio == pytest.approx(exact["stretch: ratio"], rel=1e-9)


def test_slack_springs_settle_where_the_energy_is_least(monkeypatch):
    """The energy of springs that push with a tenth of their stiffness is convex: one minimum."""
    monkeypatch.setattr(trials, "SLACK_COUNT", 16)
    _, _, nu, _ = trials.with_slack(solve_springs, ("compressed", 0.1, 4))
    body = strewn.strewn("uniform", 16, "1", 4)
    _, network = strewn.stretch_body(body)
    i, j = network.springs.T
    unit = network.vector / np.linalg.norm(network.vector, axis=1)[:, None]
    free = ~network.held

    def energy(move):
        u = np.array(network.displacement)
        u[free] = move
        longer = ((u[j] - u[i]) * unit).sum(axis=1)
        pull = network.stiffness * np.where(longer < 0, 0.1, 1.0) * longer
        slope = np.zeros_like(u)
        np.add.at(slope, j, pull[:, None] * unit)
        np.add.at(slope, i, -pull[:, None] * unit)
        return 1e6 * 0.5 * pull @ longer, 1e6 * slope[free]

    found = minimize(
        energy,
        np.zeros(free.sum()),
        jac=True,
        method="BFGS",
        options={"gtol": 1e-9, "maxiter": 5000},
    )
    u = np.array(network.displacement)
    u[free] = found.x
    assert strewn.ratio(body, u) == pytest.approx(nu, abs=1e-4)


def test_square_grids_have_no_ratio_and_jittered_ones_have():
    rows = {
        (r["jitter"], r["stiffness"]): r
        for jitter in (0.0, 1e-6, 1e-3)
        for r in trials.nearly_square(solve_springs, homogenise, (jitter, 3))
    }
    for rule in STIFFNESS_RULES:
        assert abs(rows[0.0, rule]["nu_endless"]) < 1e-12
        assert abs(rows[0.0, rule]["nu_means"]) < 1e-12
        assert rows[0.0, rule]["neighbours"] == 4
        assert rows[1e-6, rule]["neighbours"] == 6
    assert rows[1e-6, "1"]["nu_means"] > 0.1
    assert 0 < rows[1e-6, "A/L"]["nu_means"] < 2e-6
    assert 0 < rows[1e-3, "A/L"]["nu_means"] < 2e-3


def test_one_random_diagonal_a_square_by_hand():
    """With k = 1 a vanishing jitter leaves squares with one diagonal each: affine C12 is a half."""
    rng = np.random.default_rng(3)
    grid = 0.5 + np.indices((trials.GRID, trials.GRID)).reshape(2, -1).T
    points = grid + 1e-9 * (2 * rng.random(grid.shape) - 1)
    cells = networks.periodic_tessellation(points, (float(trials.GRID),) * 2)
    affine = homogenise(pattern_of_tessellation(cells, "1"), (1.0,)).affine
    assert affine[0, 0] == pytest.approx(1.5, abs=1e-6)
    assert affine[0, 1] == pytest.approx(0.5, abs=1e-6)


def test_overdamped_runs_show_a_narrower_change_when_stopped():
    rows = {
        (r["damping_factor"], r["stop"]): r
        for damping in (1, 100)
        for r in early.stops(("moved", damping, 5))
    }
    assert rows[1, early.REST]["nu"] == pytest.approx(rows[1, early.REST]["nu_rest"], abs=5e-3)
    assert rows[100, 0.1]["nu"] < 0.3 * rows[1, 0.1]["nu"]
    assert rows[100, 0.01]["lateral_part"] < rows[100, 0.01]["inner_part"]
