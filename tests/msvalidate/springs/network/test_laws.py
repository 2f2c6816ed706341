"""Laws of springs and cells: what each record's functions must be to one another, and twins."""

import numpy as np
import pytest
from scipy.spatial import Delaunay

from msvalidate.problem import ProblemError, SolverError
from msvalidate.problem.records import replace
from msvalidate.springs import kernels
from msvalidate.springs.dynamics.relax import relax
from msvalidate.springs.dynamics.relaxations import RELAXATIONS
from msvalidate.springs.network import Configuration, spring_network
from msvalidate.springs.network.laws.cubic import cubic
from msvalidate.springs.network.laws.green import GREEN
from msvalidate.springs.network.laws.linear import LINEAR
from msvalidate.springs.network.laws.logarithmic import LOGARITHMIC
from msvalidate.springs.network.laws.quadratic import QUADRATIC
from msvalidate.springs.network.laws.volumes import Volumes
from msvalidate.springs.network.laws.zero_length import ZERO_LENGTH
from msvalidate.springs.statics.equilibrium import equilibrium

LAWS = (LINEAR, ZERO_LENGTH, GREEN, cubic(0.3, 0.5, 0.2), cubic(-0.4, 0.3, 0.1))
K, L0 = np.array([3.0, 0.7]), np.array([0.37, 1.9])


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.name)
def test_a_springs_functions_are_derivatives_of_each_other(law):
    c, L, h = law.coefficients(K, L0), np.array([0.5, 1.2]), 1e-5
    s0 = L0**2 * 1.1

    def stored(length):
        s = length**2
        return law.work(c, s0, s, s - s0) + 0.5 * law.pull(c, s0) * (s - s0)

    def force(length):
        return law.pull(c, length**2) * length

    np.testing.assert_allclose((stored(L + h) - stored(L - h)) / (2 * h), force(L), rtol=1e-8)
    np.testing.assert_allclose(
        (force(L + h) - force(L - h)) / (2 * h), law.axial(c, L**2), rtol=1e-8
    )
    change = law.change(c, s0, L**2, L**2 - s0)
    np.testing.assert_allclose(change, law.pull(c, L**2) - law.pull(c, s0), rtol=1e-12, atol=1e-15)
    # A relative growth of 1e-12 keeps its digits: pull and work are what is of first order in it.
    tiny = 1e-12 * s0
    slope = (law.axial(c, s0) - law.pull(c, s0)) / s0
    small = law.change(c, s0, s0 + tiny, tiny)
    np.testing.assert_allclose(small, slope / 2 * tiny, rtol=1e-9)
    np.testing.assert_allclose(law.work(c, s0, s0 + tiny, tiny), slope / 8 * tiny**2, rtol=1e-9)


@pytest.mark.parametrize("law", [QUADRATIC, LOGARITHMIC], ids=lambda law: law.name)
def test_a_cells_functions_are_derivatives_of_each_other(law):
    c, j, h = (np.array([1.3]), np.array([0.8])), np.array([0.3]), 1e-5
    slope = (law.work(*c, j + h) - law.work(*c, j - h)) / (2 * h)
    np.testing.assert_allclose(slope, law.change(*c, j), rtol=1e-8)
    slope = (law.change(*c, j + h) - law.change(*c, j - h)) / (2 * h)
    np.testing.assert_allclose(slope, law.curvature(*c, j), rtol=1e-8)
    for tiny in (1e-10 + 0 * j, -1e-10 + 0 * j, 0.0099 + 0 * j):
        half = law.work(*c, tiny) / tiny**2
        assert half == pytest.approx(law.curvature(*c, 0 * j) / 2, rel=1e-9 + 3 * abs(tiny[0]))


def under_tension(dim, mu=0.8, lam=1.7, place=0.0):
    """Points in a box of .37 m, joined by springs of no rest length and cells under pressure.

    Stiffness is -μ V ∇φi·∇φj of each cell, summed over cells.
    """
    rng = np.random.default_rng(5)
    grid = np.stack(np.meshgrid(*[np.arange(5.0)] * dim, indexing="ij"), -1).reshape(-1, dim)
    inside = ((grid > 0) & (grid < 4)).all(axis=1)
    points = (grid + inside[:, None] * rng.uniform(-0.3, 0.3, grid.shape)) * 0.37 / 4 + place
    cells = Delaunay(points).simplices
    edges = points[cells[:, 1:]] - points[cells[:, :1]]
    volume = np.linalg.det(edges) / (2 if dim == 2 else 6)
    flat = np.abs(volume) < 1e-9 * 0.37**dim
    cells, edges, volume = cells[~flat], edges[~flat], volume[~flat]
    cells[volume < 0, :2] = cells[volume < 0, 1::-1]
    edges = points[cells[:, 1:]] - points[cells[:, :1]]
    inner = np.linalg.inv(edges).transpose(0, 2, 1)
    slopes = np.concatenate([-inner.sum(axis=1, keepdims=True), inner], axis=1)
    a, b = np.triu_indices(dim + 1, 1)
    k = -mu * np.abs(volume)[:, None] * (slopes[:, a] * slopes[:, b]).sum(axis=2)
    pairs = np.sort(np.stack([cells[:, a], cells[:, b]], -1), axis=2).reshape(-1, 2)
    springs, which = np.unique(pairs, axis=0, return_inverse=True)
    stiffness = np.bincount(which.ravel(), k.ravel())
    volumes = Volumes(points, cells, np.full(len(cells), lam), LOGARITHMIC, mu)
    held = np.zeros(points.shape, dtype=bool)
    held[grid[:, 0] == 0] = True
    return spring_network(points, springs, stiffness, volumes=volumes, fixed=held, law=ZERO_LENGTH)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("place", [0.0, 100.0])
def test_tension_and_pressure_at_rest_are_no_force(dim, place):
    network = under_tension(dim, place=place)
    assert network.prestressed
    if not place:
        assert not network.rest_force.any()
    X = network.points - network.points.mean(axis=0)
    motion = np.random.default_rng(0).normal(size=X.shape)
    exact = -Configuration(network).force_change(motion)
    # At a strain of 1e-9 forces are their first order, to its own part.
    force = Configuration(network, 1e-9 * 0.1 * motion).force() - network.rest_force
    np.testing.assert_allclose(force, -1e-10 * exact, atol=3e-7 * 1e-10 * np.abs(exact).max())
    # A turn of the whole stores nothing.
    turn = np.zeros(X.shape)
    turn[:, 0], turn[:, 1] = -X[:, 1], X[:, 0]
    stored = Configuration(network).mode_energy(turn)
    size = network.axial_stiffness @ (network.distance**2)
    assert abs(stored) <= 1e-11 * abs(size)


@pytest.mark.parametrize("dim", [2, 3])
def test_forces_and_tangent_are_derivatives_of_the_energy(dim):
    network = under_tension(dim)
    rng = np.random.default_rng(3)
    u, w = (1e-4 * rng.normal(size=network.points.shape) for _ in range(2))
    h = 1e-2
    ahead, behind = (Configuration(network, u + s * h * w) for s in (1, -1))
    slope = (ahead.energy() - behind.energy()) / (2 * h)
    at = Configuration(network, u)
    assert slope == pytest.approx(-float((at.force() * w).sum()), rel=1e-6)
    change = (ahead.force() - behind.force()) / (2 * h)
    np.testing.assert_allclose(change, at.force_change(w), atol=1e-5 * np.abs(change).max())
    bent = float(w.ravel() @ (at.tangent() @ w.ravel()))
    assert at.mode_energy(w) == pytest.approx(bent, rel=1e-10)


def test_compiled_loops_have_greens_springs():
    rng = np.random.default_rng(2)
    points = rng.random((200, 3))
    corners = Delaunay(points).simplices
    springs = np.unique(np.sort(corners[:, [[0, 1], [1, 2], [2, 3]]].reshape(-1, 2)), axis=0)
    network = spring_network(points, springs, rng.uniform(1, 2, len(springs)), law=GREEN)
    u, force = 0.05 * rng.normal(size=points.shape), np.empty(points.shape)
    at, motion = Configuration(network, u), kernels.Motion(network)
    assert motion.path == "general"
    assert motion.force_and_energy(u, force) == pytest.approx(at.energy(), rel=1e-13)
    np.testing.assert_allclose(force, at.force(), atol=1e-13 * np.abs(force).max())


@pytest.mark.parametrize(
    ("law", "method"),
    [("green", "fire"), ("green", "newton"), ("zero-length", "algorithm1")],
)
def test_relaxations_come_to_the_equilibrium_by_every_law(method, law):
    network = under_tension(2)
    if law == "green":
        network = replace(
            network, law=GREEN, stiffness=np.full(len(network.springs), 20.0), volumes=None
        )
    load = np.where(network.fixed, 0.0, [0.002, -0.004])
    network = replace(network, force=load)
    rest = relax(network, RELAXATIONS[method], tolerance=1e-9).equilibrium.displacement
    wanted = equilibrium(network, "nonlinear").displacement
    np.testing.assert_allclose(rest, wanted, atol=1e-6 * np.abs(wanted).max())


def test_compiled_paths_of_laws_that_they_lack_are_refused():
    network = under_tension(2)
    assert kernels.Motion(network).path == "plain"
    with pytest.raises(
        ProblemError, match="path: general, for laws zero-length, logarithmic; take"
    ):
        kernels.Motion(network, path="general")


def test_what_no_law_allows_is_refused():
    points, springs = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], [[0, 1], [1, 2], [2, 0]]
    with pytest.raises(ProblemError, match="0 or more by the green law"):
        spring_network(points, springs, -1.0, law=GREEN)
    with pytest.raises(ProblemError, match="b - a"):
        cubic(1.0, 0.5, 0.1)
    volumes = Volumes(np.array(points), np.array([[0, 1, 2]]), np.ones(1), LOGARITHMIC, 0.5)
    network = spring_network(points, springs, 1.0, law=ZERO_LENGTH, volumes=volumes)
    flat = np.array([[0.0, 0.0], [0.0, 0.0], [0.0, -1.1]])
    with pytest.raises(SolverError, match=r"cell 0 .* no volume left .*-0.1"):
        Configuration(network, flat).force()
