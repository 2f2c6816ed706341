"""Limit points passed, prestress raised, and nonlinear answers against closed forms."""

from __future__ import annotations

from dataclasses import replace
from decimal import Decimal, getcontext

import numpy as np
import pytest
from scipy.optimize import minimize, minimize_scalar
from scipy.spatial import Delaunay

from msvalidate.problem import Box, PointForce, Region, SolverError, Support
from msvalidate.springs.network import spring_network
from msvalidate.springs.statics.equilibrium import equilibrium
from tests.msvalidate.energies import spring_energy

HALF, RISE, STIFFNESS = 0.37, 0.037, 3.0
"""Half span (m), rise (m) and spring (N/m) of a von Mises truss."""


def carried(height):
    """Force (N) that the truss carries at a height (m) of its middle: closed form."""
    length = np.hypot(HALF, height)
    return 2 * STIFFNESS * (np.hypot(HALF, RISE) - length) * height / length


LIMIT = -minimize_scalar(
    lambda y: -carried(y), bounds=(0, RISE), method="bounded", options={"xatol": 1e-12}
).fun


def truss(force):
    return spring_network(
        [[-HALF, 0], [0, RISE], [HALF, 0]],
        [[0, 1], [1, 2]],
        STIFFNESS,
        fixed=[[True, True], [True, False], [True, True]],
        force=[[0, 0], [0, -force], [0, 0]],
    )


# Limit points -------------------------------------------------------------------------------------


@pytest.mark.parametrize("over", [0.3, 0.9, 0.995])
def test_below_its_limit_an_arch_has_passed_none(over):
    found = equilibrium(truss(over * LIMIT), "nonlinear")
    assert found.passed_limit is None
    assert found.position[1, 1] > 0
    assert carried(found.position[1, 1]) == pytest.approx(over * LIMIT, rel=1e-9)


# At 16 the snapped arch is where the linear answer is; at 32 the means of both ends' rates fit.
@pytest.mark.parametrize("over", [1.01, 1.5, 4, 15.6, 16, 31.8, 100, 500])
def test_a_snapped_arch_says_at_which_part_of_the_load(over):
    found = equilibrium(truss(over * LIMIT), "nonlinear")
    assert found.position[1, 1] < -RISE
    assert carried(found.position[1, 1]) == pytest.approx(over * LIMIT, rel=1e-9)
    assert found.passed_limit == pytest.approx(1 / over, abs=2**-10)


def test_a_small_arch_within_a_large_body_is_noticed(lattice_body):
    """The truss hangs on a block that hardly moves, and carries a hundredth of its load."""
    block = lattice_body((3.7, 3.7), 6, loads=(PointForce((3.7, 3.7), (0.0, 0.1)),))
    arch, n = truss(1.2 * LIMIT), len(block.points)
    both = spring_network(
        np.concatenate([block.points, arch.points + np.array([9.0, 0.0])]),
        np.concatenate([block.springs, arch.springs + n]),
        np.concatenate([block.stiffness, arch.stiffness]),
        fixed=np.concatenate([block.fixed, arch.fixed]),
        force=np.concatenate([block.force, arch.force]),
    )
    found = equilibrium(both, "nonlinear")
    assert found.passed_limit == pytest.approx(1 / 1.2, abs=2**-10)
    assert equilibrium(block, "nonlinear").passed_limit is None


# Prestress ----------------------------------------------------------------------------------------


def tight(seed, kind):
    """A net of random points in tension between held edges; stiffness over 4 decades, or equal."""
    rng = np.random.default_rng(seed)
    line = np.linspace(0, 1, 9)
    frame = np.array([[x, y] for x in line for y in line if {x, y} & {0.0, 1.0}])
    points = 0.37 * np.concatenate([frame, rng.uniform(0.05, 0.95, (40, 2))])
    triangles = Delaunay(points).simplices
    pairs = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    springs = np.unique(pairs, axis=0)
    springs = springs[(springs >= len(frame)).any(axis=1)]
    length = np.linalg.norm(points[springs[:, 1]] - points[springs[:, 0]], axis=1)
    part = rng.uniform(0.9, 0.97, len(springs)) if kind == "stiffness" else None
    return spring_network(
        points,
        springs,
        10 ** rng.uniform(-2, 2, len(springs)) if kind == "stiffness" else 1.0,
        rest_length=length * (rng.uniform(0.7, 0.9, len(springs)) if part is None else part),
        fixed=np.repeat(np.arange(len(points))[:, None] < len(frame), 2, axis=1),
    )


def at_least_energy(network):
    """Positions (n, d) in m by L-BFGS on the springs' energy alone, over its stiffest spring."""
    i, j = network.springs.T
    free, x0 = ~network.fixed, np.array(network.points)
    # In units of √(stiffness met) components are alike.
    met = np.zeros(len(x0))
    np.add.at(met, i, network.stiffness)
    np.add.at(met, j, network.stiffness)
    unit = np.sqrt(np.repeat(met[:, None], 2, axis=1))[free]

    def value(y):
        position = x0.copy()
        position[free] = y / unit
        stored, slope = spring_energy(network, position)
        return stored, slope[free] / unit

    options = {"maxiter": 20000, "maxfun": 40000, "ftol": 0, "gtol": 1e-12, "maxcor": 40}
    end = minimize(value, x0[free] * unit, jac=True, method="L-BFGS-B", options=options)
    x0[free] = end.x / unit
    return x0


@pytest.mark.parametrize("kind", ["stiffness", "rest lengths"])
@pytest.mark.parametrize("seed", range(6))
def test_nets_in_tension_are_answered(kind, seed):
    """No load acts, and the springs are far from balance at the points that are given."""
    network = tight(seed, kind)
    found = equilibrium(network, "nonlinear", allow_folded=True)
    np.testing.assert_allclose(found.position, at_least_energy(network), rtol=0, atol=1e-6 * 0.37)
    assert found.passed_limit is None


def test_prestress_that_no_rest_bears_names_prestress():
    """Two springs in line, too long for their span: straight is no stable rest."""
    long = spring_network(
        [[0, 0], [0.37, 0], [0.74, 0]],
        [[0, 1], [1, 2]],
        1.0,
        rest_length=0.5,
        fixed=[[True, True], [False, True], [True, True]],
    )
    free = np.array([[True, True], [False, False], [True, True]])
    assert equilibrium(long, "nonlinear").position[1, 0] == pytest.approx(0.37)
    with pytest.raises(SolverError) as caught:
        equilibrium(replace(long, fixed=free), "nonlinear")
    assert "reduce the load" not in str(caught.value)
    assert "rest lengths" in str(caught.value)


# Closed forms at other sizes ----------------------------------------------------------------------


def narrowing(stretch, k1, k2):
    """Lateral stretch - 1 of square-8 pulled along x with free sides, to 40 digits.

    k1 (m - 1) + 2 k2 m (1 - √2/√(λ² + m²)) = 0.
    """
    getcontext().prec = 40
    lam, m = 1 + Decimal(stretch), Decimal(1)
    k1, k2, two = Decimal(k1), Decimal(k2), Decimal(2)
    for _ in range(60):
        d = (lam * lam + m * m).sqrt()
        f = k1 * (m - 1) + 2 * k2 * m * (1 - two.sqrt() / d)
        slope = k1 + 2 * k2 * (1 - two.sqrt() / d + two.sqrt() * m * m / d**3)
        m -= f / slope
    return float(m - 1)


@pytest.mark.parametrize("strain", [1e-9, 1e-4, 0.05, 0.3])
@pytest.mark.parametrize("far", [0.0, 2.0**20])
@pytest.mark.parametrize("constants", [(0.4, 0.2), (2e9, 2e3)])
def test_uniform_tension_is_its_closed_form(lattice_body, strain, far, constants):
    """6 x 4 cells of 1/16 m between rollers, near the origin and 3 million sizes away."""
    size = (0.375, 0.25)
    box = Box(size)
    rollers = (
        Support(box.side("left"), (0.0, None)),
        Support(box.side("right"), (strain * size[0], None)),
        Support(Region((0.0, 0.0)), (None, 0.0)),
    )
    here = lattice_body(size, (6, 4), supports=rollers, constants=constants)
    found = equilibrium(replace(here, points=here.points + far), "nonlinear")
    expected = here.points * [strain, narrowing(strain, *constants)]
    within = found.error + 4 * np.finfo(float).eps
    assert np.abs(found.displacement - expected).max() <= within * np.abs(expected).max()
    # Rest lengths are known to an eps of themselves, and the answer to tens of these of a strain.
    assert found.error <= 40 * np.finfo(float).eps / strain + 1e-14
    assert found.folded == 0
