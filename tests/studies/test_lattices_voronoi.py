"""The study `lattices`: random solids and bodies, their surfaces, and ratios of zero."""

import numpy as np
import pandas as pd
import pytest
from msvalidate.studies.lattices.voronoi import (
    bodies,
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

import reference_fem
from msvalidate import kit
from msvalidate.bench.judging.evidence import judge
from msvalidate.springs.constants.directions import rotate_tensor
from msvalidate.springs.constants.homogenise import homogenise
from msvalidate.springs.constants.stiffness import cubic_part, isotropic_part
from msvalidate.springs.lattice.voronoi import pattern_of_tessellation

QUICK = kit.Setting(quick=True)


@pytest.mark.parametrize("dim", [2, 3])
def test_the_ratio_follows_from_what_bulk_and_shear_lose(dim):
    """Cauchy's bulk modulus is 2 G in the plane and 5/3 G in space; relaxation takes parts."""
    for row in networks.measure(homogenise, (dim, "blue_noise", 40, 3)):
        over = (1 - row["bulk_lost"]) / (1 - row["shear_lost"]) * {2: 2, 3: 5 / 3}[dim]
        # nu = (dK - 2G)/(d(d - 1)K + 2G)
        nu = (dim * over - 2) / (dim * (dim - 1) * over + 2)
        assert row["nu"] == pytest.approx(nu, rel=1e-10)


def test_summary_has_students_interval():
    rows = [networks.measure(homogenise, (2, "uniform", 20, seed))[0] for seed in range(5)]
    row = solids.summary(pd.DataFrame(rows))
    nu = [r["nu"] for r in rows]
    low, high = student.interval(
        0.95, len(nu) - 1, loc=np.mean(nu), scale=np.std(nu, ddof=1) / np.sqrt(len(nu))
    )
    assert (row["nu_low"], row["nu_high"]) == pytest.approx((low, high), rel=1e-9)


def test_standard_error_of_an_exponent_is_its_scatter():
    """Normal draws whose spread falls with the root of the count, many times over."""
    rng = np.random.default_rng(5)
    count = np.array([100, 400, 1600])
    found = []
    for _ in range(400):
        spread = [rng.normal(0, n**-0.5, 20).std(ddof=1) for n in count]
        found.append(solids.exponent(pd.DataFrame({"count": count, "nu_std": spread, "seeds": 20})))
    power, error = np.array(found).T
    assert power.mean() == pytest.approx(-0.5, abs=0.02)
    assert power.std() == pytest.approx(error[0], rel=0.15)


def test_a_little_unrelaxed_is_told_by_least_squares_alone():
    solid = faults.FAULTS["random solids 5 % unrelaxed"]["solid"]
    limit = energy.RULE.limit
    for case in energy.CASES:
        assert energy.compare_tensors(homogenise, case)["squares_error"] < limit
        row = energy.compare_tensors(solid, case)
        left = 0.05 / 0.95 * row["random_released"]
        assert row["squares_error"] == pytest.approx(left, rel=1e-6)
        assert row["squares_error"] > 1e6 * limit
    verdict = judge(solids.run(solid, QUICK))
    missed = verdict.loc[verdict["verdict"] == "fail", "quantity"]
    assert missed.tolist() == [energy.RULE.quantity]


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


def test_stretch_is_the_closed_form_of_any_tensor():
    tensor = cubic_part(networks.measure(homogenise, (2, "jittered", 64, 1))[2]["tensor"])
    exact, _ = bodies.expected_response(tensor)
    box = kit.Box((1.0, 1.0))
    problem = bodies.stretch(box)
    problem = kit.Problem(box, kit.Anisotropic(tensor), problem.supports, problem.loads)
    mesh = reference_fem.box_discretisation(box, 3, "Q2")
    move = reference_fem.solve_problem(problem, mesh).at([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)])
    assert 1 / (move[1, 0] - move[0, 0]) == pytest.approx(exact["stretch: modulus"], rel=1e-9)
    ratio = -(move[2, 1] - move[1, 1]) / (move[1, 0] - move[0, 0])
    assert ratio == pytest.approx(exact["stretch: ratio"], rel=1e-9)


def test_slack_springs_settle_where_the_energy_is_least(monkeypatch):
    """The energy of springs that push with a tenth of their stiffness is convex: one minimum."""
    monkeypatch.setattr(trials, "COUNT", 16)
    nu = trials.slack_ratio(kit.solve_springs, "compressed", 0.1, 4)
    body = strewn.strewn("uniform", 16, "1", 4)
    _, network = strewn.stretch_body(body)
    i, j = network.springs.T
    unit = network.vector / np.linalg.norm(network.vector, axis=1)[:, None]
    free = ~network.fixed

    def energy(move):
        u = np.array(network.displacement)
        u[free] = move
        longer = ((u[j] - u[i]) * unit).sum(axis=1)
        pull = network.stiffness * np.where(longer < 0, 0.1, 1.0) * longer
        slope = np.zeros_like(u)
        np.add.at(slope, j, pull[:, None] * unit)
        np.add.at(slope, i, -pull[:, None] * unit)
        return 1e6 * 0.5 * pull @ longer, 1e6 * slope[free]

    found = minimize(energy, np.zeros(free.sum()), jac=True, method="BFGS", options={"gtol": 1e-9})
    u = np.array(network.displacement)
    u[free] = found.x
    assert strewn.ratio(body, u) == pytest.approx(nu, abs=1e-4)


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
    critical, rest, static = trials.stop("moved", 1, 5)
    assert rest == pytest.approx(static, abs=5e-3)
    assert trials.stop("moved", 100, 5)[0] < 0.3 * critical


@pytest.mark.parametrize("dim", [2, 3])
def test_the_isotropic_part_has_no_anisotropy(dim):
    tensor = networks.measure(homogenise, (dim, "uniform", 20, 1))[0]["tensor"]
    assert networks.anisotropy(isotropic_part(tensor)) < 1e-12
    turned = [rotate_tensor(tensor, angle) for angle in (0.3, 1.0)] if dim == 2 else [tensor]
    for C in turned:
        assert networks.anisotropy(C) == pytest.approx(networks.anisotropy(tensor), rel=1e-12)
