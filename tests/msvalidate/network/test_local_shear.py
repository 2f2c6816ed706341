"""Springs that resist shear by local strain: energy, force, tangent, range, and their errors."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from scipy.spatial import Delaunay

from msvalidate import kernels
from msvalidate.bodies.calibrate import calibrate
from msvalidate.bodies.lattice_network import lattice_network
from msvalidate.lattice import fill, patterns
from msvalidate.network import energy, internal_force, mode_energy, spring_network, tangent
from msvalidate.network.laws import local_shear
from msvalidate.network.laws.local_shear import LocalShear, shear_tensor
from msvalidate.problem import VOIGT, Box, Isotropic, Problem, ProblemError, Support, Traction
from msvalidate.statics.equilibrium import equilibrium
from tests.table import table

dims = pytest.mark.parametrize("dim", [2, 3])
ISOTROPIC = {
    "square": (1.0, 0.5),
    "triangular": (1.0,),
    "cubic18": (1.0, 1.0),
    "cubic26": (11 / 3, 1.0, 1.0),
    "bcc": (1.0, 2 / 3),
    "fcc": (1.0, 0.25),
}


def random_shear(dim, seed=0):
    """Delaunay edges of a jittered grid with stiffness of either sign, and a position far off."""
    rng = np.random.default_rng(seed)
    side = np.arange(4 if dim == 2 else 3)
    grid = np.stack(np.meshgrid(*[side] * dim), axis=-1).reshape(-1, dim)
    points = grid + rng.uniform(-0.3, 0.3, grid.shape)
    corners = [list(pair) for pair in combinations(range(dim + 1), 2)]
    springs = np.unique(np.sort(Delaunay(points).simplices[:, corners].reshape(-1, 2)), axis=0)
    m = len(springs)
    shear = LocalShear(points, springs, rng.normal(size=m), rng.uniform(0.5, 1, m))
    return shear, points + rng.uniform(-0.2, 0.2, points.shape)


def turned(position, seed=3):
    dim = position.shape[1]
    Q, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(dim, dim)))
    Q[0] *= np.sign(np.linalg.det(Q))
    return position @ Q.T + 5.0


def differences(value, position, step=1e-5):
    """Central differences of value (any shape) by each component of a position, last axis."""
    columns = []
    for at in range(position.size):
        move = np.zeros(position.size)
        move[at] = step
        move = move.reshape(position.shape)
        columns.append((value(position + move) - value(position - move)) / (2 * step))
    return np.stack(columns, axis=-1)


# Energy, force, tangent -------------------------------------------------------------------------


@dims
def test_a_turn_and_a_shift_cost_nothing(dim):
    shear, position = random_shear(dim)
    quarter = np.eye(dim)
    quarter[:2, :2] = [[0, -1], [1, 0]]
    for moved in (shear.points @ quarter.T + 4.0, turned(shear.points)):
        assert abs(local_shear.energy(shear, moved)) < 1e-26  # squares of an eps of up to 10 m
        np.testing.assert_allclose(local_shear.force(shear, moved), 0, atol=1e-13)
    # 1e-12 of a sum of terms of either sign, none of which is above a few joules.
    stored = local_shear.energy(shear, position)
    assert local_shear.energy(shear, position @ quarter.T + 4.0) == pytest.approx(stored, abs=1e-12)
    assert local_shear.energy(shear, turned(position)) == pytest.approx(stored, abs=1e-12)
    assert abs(stored) > 1e-3


@dims
def test_force_is_minus_the_slope_of_energy(dim):
    shear, position = random_shear(dim)
    force = local_shear.force(shear, position)
    slope = differences(lambda x: local_shear.energy(shear, x), position)
    np.testing.assert_allclose(force.ravel(), -slope, atol=1e-6 * np.abs(force).max())


@dims
def test_tangent_is_minus_the_slope_of_force_and_symmetric(dim):
    shear, position = random_shear(dim)
    K = local_shear.tangent(shear, position).toarray()
    slope = differences(lambda x: local_shear.force(shear, x).ravel(), position)
    np.testing.assert_allclose(K, -slope, atol=1e-6 * np.abs(K).max())
    np.testing.assert_allclose(K, K.T, atol=1e-14 * np.abs(K).max())


@dims
def test_forces_and_moments_sum_to_nothing(dim):
    shear, position = random_shear(dim)
    force = local_shear.force(shear, position)
    moment = position.T @ force
    np.testing.assert_allclose(force.sum(axis=0), 0, atol=1e-13)
    np.testing.assert_allclose(moment, moment.T, atol=1e-13)
    assert np.abs(moment).max() > 1e-2


@dims
def test_a_uniform_strain_has_the_tensors_energy(dim):
    shear, _ = random_shear(dim)
    strain = np.random.default_rng(1).normal(size=(dim, dim))
    strain = (strain + strain.T) / 2
    # Green's strain of F is exactly this where FᵀF = I + 2 strain: its root is a uniform F.
    values, axes = np.linalg.eigh(np.eye(dim) + 0.2 * strain)
    F = axes @ np.diag(np.sqrt(values)) @ axes.T
    voigt = 0.1 * np.array([strain[a, b] * (1 if a == b else 2) for a, b in VOIGT[dim]])
    C = shear_tensor(shear.vector, shear.stiffness, 2.0)
    stored = local_shear.energy(shear, turned(shear.points @ F.T))
    assert stored == pytest.approx(2.0 * voigt @ C @ voigt / 2, rel=1e-12)


@dims
def test_a_mode_has_the_tangents_energy(dim):
    shear, position = random_shear(dim)
    mode = np.random.default_rng(2).normal(size=position.shape)
    expected = mode.ravel() @ (local_shear.tangent(shear, position) @ mode.ravel())
    assert local_shear.mode_energy(shear, position, mode) == pytest.approx(expected, rel=1e-11)


@dims
def test_no_force_is_above_the_sum_of_their_magnitudes(dim):
    shear, position = random_shear(dim)
    met = local_shear.force_magnitudes(shear, position)
    size = np.linalg.norm(local_shear.force(shear, position), axis=1)
    stretch = np.linalg.norm((shear.gradient @ position).reshape(-1, dim, dim), 2, axis=(1, 2))
    assert (size <= stretch.max() * met).all()
    assert met.max() < 100 * size.max()


@pytest.mark.parametrize("name", ISOTROPIC)
@pytest.mark.parametrize("alpha", [-0.6, 0.0, 1.0, 3.0])
def test_poissons_ratio_by_the_ratio_of_stiffness(name, alpha):
    pattern = getattr(patterns, name)()
    d, k = pattern.dim, pattern.stiffness(ISOTROPIC[name])
    volume = np.prod(pattern.size)
    C = pattern.tensor(ISOTROPIC[name]) + shear_tensor(pattern.vectors, alpha * k, volume)
    nu = (1 - alpha) / (d + 1 + alpha)
    assert C[0, 1] / (C[0, 0] + (d - 2) * C[0, 1]) == pytest.approx(nu, abs=1e-14)
    assert 2 * C[-1, -1] == pytest.approx(C[0, 0] - C[0, 1], rel=1e-13)


# Bodies -----------------------------------------------------------------------------------------


def pulled(nu, cells):
    """Error of the displacements of a unit square under tension, over its elongation, (n, 2)."""
    box = Box((1.0, 1.0))
    supports = (Support(box.side("left"), (0.0, None)), Support(box.side("bottom"), (None, 0.0)))
    pull = (Traction(box.side("right"), (1e-3, 0.0)),)
    problem = Problem(box, Isotropic(1.0, nu), supports, pull)
    grid = fill(patterns.square(), box, cells)
    network = lattice_network(problem, grid, calibrate(1.0, nu, grid, route="shear springs"))
    assert network.shear is not None
    assert network.volumes is None
    return equilibrium(network).displacement / 1e-3 - network.points * [1.0, -nu]


@pytest.mark.parametrize("nu", [-0.5, 0.0, 0.2, 0.45, 0.499])
def test_a_stretched_square_is_wrong_at_its_corners_alone(nu):
    worst, mean = np.array(
        [(np.abs(e).max(), np.abs(e).mean()) for e in (pulled(nu, 8), pulled(nu, 16))]
    ).T
    assert 0.8 < np.log2(worst[0] / worst[1]) < 1.1  # first order
    assert 1.7 < np.log2(mean[0] / mean[1]) < 2.3  # second
    assert 1e-3 < worst[1] < 0.035


def test_a_uniform_strain_leaves_forces_at_the_corners_alone():
    grid = fill(patterns.square(), Box((1.0, 1.0)), 6)
    k = np.array(ISOTROPIC["square"])[grid.kind] * grid.share
    shear = LocalShear(grid.points, grid.springs, k, grid.share)
    force = local_shear.tangent(shear, grid.points) @ (grid.points * [1.0, -0.3]).ravel()
    force = force.reshape(7, 7, 2)
    inside = force[2:-2, 2:-2]
    np.testing.assert_allclose(inside, 0, atol=1e-14)
    along_sides = force[2:-2]
    # What is left is normal to the sides, a uniform traction: λ εxx + (λ + 2μ) εyy of its tensor.
    C = shear_tensor(grid.vectors, k, 1.0)
    stress = C @ [1.0, -0.3, 0.0]
    np.testing.assert_allclose(along_sides[:, -1], [[stress[0] / 6, 0]] * 3, atol=1e-14)
    np.testing.assert_allclose(along_sides[:, 1:-1], 0, atol=1e-14)
    assert np.abs(force[:2, :2]).max() > 1e-2


def test_a_network_adds_its_shear_springs():
    shear, position = random_shear(2)
    plain = spring_network(shear.points, shear.springs, 2.0)
    both = replace(plain, shear=shear)
    mode = np.random.default_rng(0).normal(size=position.shape)
    for whole, part in (
        (lambda n: energy(n, position), local_shear.energy(shear, position)),
        (lambda n: internal_force(n, position), local_shear.force(shear, position)),
        (lambda n: tangent(n, position).toarray(), local_shear.tangent(shear, position).toarray()),
        (lambda n: mode_energy(n, position, mode), local_shear.mode_energy(shear, position, mode)),
    ):
        np.testing.assert_allclose(whole(both) - whole(plain), part, atol=1e-12)


def test_newton_finds_a_body_with_shear_springs_at_rest():
    box = Box((2.0, 1.0))
    held = (Support(box.side("left"), (0.0, 0.0)), Support(box.side("right"), (0.2, 0.1)))
    problem = Problem(box, Isotropic(1.0, 0.45), held)
    grid = fill(patterns.square(), box, (8, 4))
    network = lattice_network(problem, grid, calibrate(1.0, 0.45, grid, route="shear springs"))
    assert equilibrium(network, "nonlinear").residual < 1e-12


# Bad input --------------------------------------------------------------------------------------


def test_there_is_no_compiled_form():
    shear, position = random_shear(2)
    network = spring_network(shear.points, shear.springs, 2.0, shear=shear)
    with pytest.raises(ProblemError, match="its shear springs have no compiled form"):
        kernels.force_and_energy(network, position - shear.points, np.empty_like(position))


@table(
    ("given", "said"),
    [
        ({"points": [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]}, "those at point 0 do not span all 2"),
        ({"points": [[0.0, 0.0], [1.0, 0.0], [1.0, 0.0]]}, r"\[1, 2\] at index 1 are in one place"),
        ({"weights": [1.0, 1.0, 0.0]}, "those at point 0 do not span all 2 axes"),
        ({"springs": [[0, 1], [1, 2], [2, 9]]}, r"\[2 9\] at index 2; there are 3 points"),
        ({"springs": [[0, 1], [1, 2], [2, 2]]}, r"\[2 2\] at index 2 joins a point to itself"),
        ({"springs": [[0, 1, 2]]}, r"give whole numbers \(m, 2\)"),
        ({"stiffness": [1.0]}, r"stiffness: shape \(1,\); give \(3,\)"),
        ({"stiffness": [1.0, np.inf, 1.0]}, "stiffness"),
        ({"weights": [1.0, -1.0, 1.0]}, "a weight of -1; give 0 or more"),
        ({"points": [[0.0], [1.0], [2.0]]}, "give"),
    ],
)
def test_what_is_no_shear_spring_is_refused(given, said):
    usual = {
        "points": [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
        "springs": [[0, 1], [1, 2], [0, 2]],
        "stiffness": [1.0, 1.0, -1.0],
        "weights": [1.0, 1.0, 1.0],
    }
    LocalShear(**usual)
    with pytest.raises(ProblemError, match=said):
        LocalShear(**(usual | given))


def test_shear_springs_of_other_points_are_refused():
    shear, _ = random_shear(2)
    with pytest.raises(ProblemError, match="shear: of other points than the network's"):
        spring_network(shear.points + 1.0, shear.springs, 1.0, shear=shear)


def test_positions_of_another_shape_are_refused():
    shear, position = random_shear(2)
    with pytest.raises(ProblemError, match="position"):
        local_shear.energy(shear, position[1:])


@table(
    ("vectors", "volume", "said"),
    [
        ([[0.0, 0.0]], 1.0, "a vector of no length"),
        ([[1.0, 1.0]], 0.0, r"volume: 0\.0 m\^2; it must be above zero"),
        ([[1e90, 1.0]], 1e-300, "shear tensor: .* every value must be finite"),
        ([1.0, 1.0], 1.0, r"vectors: shape \(2,\)"),
    ],
)
def test_what_has_no_tensor_is_refused(vectors, volume, said):
    with pytest.raises(ProblemError, match=said):
        local_shear.shear_tensor(np.array(vectors), np.ones(1), volume)
