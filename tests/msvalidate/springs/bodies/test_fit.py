"""Constants fitted to displacements: recovered, near finite elements, and what is left open."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import reference_fem
from msvalidate.linear_algebra import choice
from msvalidate.problem import Box, Isotropic, Problem, ProblemError, SolverError, Support, Traction
from msvalidate.springs.bodies import fit
from msvalidate.springs.bodies.calibrate import calibrate
from msvalidate.springs.bodies.fit import fitted_constants
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.lattice import square
from msvalidate.springs.network import multigrid
from msvalidate.springs.statics.equilibrium import equilibrium
from tests.table import table

BOX = Box((2.0, 1.0))
GRID = square(BOX, (8, 4))
LOADS = {
    "pull": ("right", (1e-3, 0.0)),
    "bend": ("right", (0.0, 1e-3)),
    "lift": ("top", (0.0, 1e-3)),
}


def problems(*loads, nu=0.3):
    clamp = (Support(BOX.side("left"), (0.0, 0.0)),)
    for load in loads or LOADS:
        side, traction = LOADS[load]
        yield Problem(BOX, Isotropic(1.0, nu), clamp, (Traction(BOX.side(side), traction),))


def networks(constants, volume=0.0, *, lattice=GRID, loads=()):
    return [lattice_network(p, lattice, constants, volume=volume) for p in problems(*loads)]


def moves(*built):
    return [equilibrium(network).displacement for network in built]


def test_large_networks_are_fitted_by_multigrid(monkeypatch):
    wanted = moves(*networks((2.3, 0.7), 0.2))
    expected = fitted_constants(networks((1.0, 1.0), 1.0), wanted, GRID.kind)
    monkeypatch.setattr(choice, "MOST_PRODUCTS", 0)
    monkeypatch.setattr("msvalidate.linear_algebra.factor.splu", None)
    found = fitted_constants(networks((1.0, 1.0), 1.0), wanted, GRID.kind)
    assert found.constants == pytest.approx(expected.constants, rel=1e-9)
    assert found.volume == pytest.approx(0.2, rel=1e-9)
    assert found.error < 1e-9


def test_a_network_that_multigrid_finds_no_end_of_is_not_called_loose(monkeypatch):
    wanted = moves(*networks((2.3, 0.7)))
    expected = fitted_constants(networks((1.0, 1.0)), wanted, GRID.kind)
    monkeypatch.setattr(choice, "MOST_PRODUCTS", 0)
    real = multigrid.conjugate_gradients
    monkeypatch.setattr(
        multigrid, "conjugate_gradients", lambda *args, **rest: real(*args, **{**rest, "most": 0})
    )
    found = fitted_constants(networks((1.0, 1.0)), wanted, GRID.kind)
    assert found.constants == expected.constants


def test_slopes_are_the_differences_of_the_misfit():
    built = networks((1.0, 1.0), 1.0)
    (case,) = fit._load_cases(built[:1], moves(built[0]), GRID.kind, 2)
    p = np.array([2.3, 0.7, -0.2])
    slope = fit._respond(case, p).slope
    for j, step in enumerate(1e-6 * np.eye(3)):
        ahead, behind = (fit._respond(case, p + s).move for s in (step, -step))
        np.testing.assert_allclose(
            slope[:, j], (ahead - behind) / 2e-6, atol=1e-7 * np.abs(slope).max()
        )


def test_a_constant_that_is_not_there_comes_out_as_nothing():
    # Displacements that would take a negative k2 end at its bound.
    wanted = [
        move * np.array([1.0, -1.0]) for move in moves(*networks((1.0, 1.0), loads=("pull",)))
    ]
    found = fitted_constants(networks((1.0, 1.0), loads=("pull",)), wanted, GRID.kind)
    assert 0 <= found.constants[1] < 1e-3 * found.constants[0]
    assert found.residual > 0.01


def cantilever(length, load, constants):
    """A row of cells of 0.37 m, clamped on the left and pushed up at its end."""
    box = Box((0.37 * length, 0.37))
    clamp = (Support(box.side("left"), (0.0, 0.0)),)
    problem = Problem(box, Isotropic(1.0, 0.3), clamp, (Traction(box.side("right"), (0.0, load)),))
    return lattice_network(problem, square(box, (length, 1)), constants)


@pytest.mark.parametrize("length", [50, 100, 200, 400, 1000])
def test_constants_of_long_bodies_come_back_within_their_error_or_not_at_all(length):
    # Solutions that were not refined gave 1.3 times the second at 400 cells, 2.0 times at 1000.
    true = np.random.default_rng(length).uniform(0.3, 1, 2)
    load = 1e-3 / length**2
    wanted = moves(cantilever(length, load, tuple(true)))
    kind = square(Box((0.37 * length, 0.37)), (length, 1)).kind
    try:
        found = fitted_constants([cantilever(length, load, (1.0, 1.0))], wanted, kind)
    except SolverError as error:
        assert length >= 400
        assert "known to" in str(error)  # noqa: PT017
        return
    assert np.abs(found.constants - true).max() <= found.error * true.max() <= 1e-6


@pytest.mark.parametrize("nu", [0.3, 0.45])
def test_fitted_to_finite_elements_they_come_near_the_calibrated(nu):
    wrong, left = [], []
    for n in (4, 8):
        lattice = square(BOX, (2 * n, n))
        asked = list(problems(nu=nu))
        mesh = reference_fem.box_discretisation(BOX, (32, 16), "Q2")
        wanted = [reference_fem.solve_problem(p, mesh).at(lattice.points) for p in asked]
        built = [lattice_network(p, lattice, (1.0, 1.0), volume=1.0) for p in asked]
        found = fitted_constants(built, wanted, lattice.kind)
        exact = calibrate(1.0, nu, lattice)
        wrong.append(
            np.abs(np.subtract((*found.constants, found.volume), (*exact.constants, exact.volume)))
        )
        left.append(found.residual)
    # The constants make up for part of the discretisation's error, which is of second order.
    assert (np.array(wrong[1]) < 0.6 * np.array(wrong[0])).all()
    assert wrong[1].max() < 0.05
    assert 1.7 < np.log2(left[0] / left[1]) < 2.1


# Refusals ---------------------------------------------------------------------------------------


def stretched(lattice, constants, volume):
    """A block in tension, which knows C11 and C12 alone."""
    supports = (Support(BOX.side("left"), (0.0, None)), Support(BOX.side("bottom"), (None, 0.0)))
    pull = (Traction(BOX.side("right"), (1e-3, 0.0)),)
    problem = Problem(BOX, Isotropic(1.0, 0.3), supports, pull)
    return lattice_network(problem, lattice, constants, volume=volume)


def test_what_a_stretch_leaves_open_is_named():
    wanted = moves(stretched(GRID, (2.0, 1.0), 0.1))
    with pytest.raises(ProblemError, match="leave k2 and κ open"):
        fitted_constants([stretched(GRID, (1.0, 1.0), 1.0)], wanted, GRID.kind)
    found = fitted_constants(
        [stretched(GRID, (1.0, 1.0), 0.0)], moves(stretched(GRID, (2.0, 1.0), 0.0)), GRID.kind
    )
    assert found.constants == pytest.approx((2.0, 1.0), rel=1e-9)


def test_what_no_constants_come_near_is_refused():
    # A pull that shortens: the stiffest network is the nearest, and it does not move.
    with pytest.raises(SolverError, match="a residual of 1, as of no displacement at all"):
        fitted_constants(UNIT, [-u for u in WANTED], GRID.kind)


def test_prescribed_displacements_leave_a_common_factor_open():
    supports = (Support(BOX.side("left"), (0.0, 0.0)), Support(BOX.side("right"), (0.1, 0.0)))
    network = lattice_network(Problem(BOX, Isotropic(1.0, 0.3), supports), GRID, (1.0, 1.0))
    wanted = moves(network.scaled(np.where(GRID.kind == 0, 2.0, 1.0)))
    with pytest.raises(ProblemError, match="leave k1 and k2 open; add one that tells, with forces"):
        fitted_constants([network], wanted, GRID.kind)


UNIT = networks((1.0, 1.0))
WANTED = moves(*UNIT)


@table(("call", "said"), [
    (lambda: fitted_constants([], [], GRID.kind), "no network; give a list"),
    (lambda: fitted_constants(UNIT[0], WANTED[0], GRID.kind), "no network; give a list"),
    (lambda: fitted_constants(UNIT, None, GRID.kind), "3 networks, no list of displacements"),
    (lambda: fitted_constants(UNIT, WANTED[:2], GRID.kind), "3 networks, 2 displacements"),
    (lambda: fitted_constants(UNIT, WANTED, GRID.kind[1:]), "from 0 up without a gap"),
    (lambda: fitted_constants(UNIT, WANTED, 2 * GRID.kind), "from 0 up without a gap"),
    (lambda: fitted_constants(UNIT, [w[1:] for w in WANTED], GRID.kind), "wanted displacement"),
    (lambda: fitted_constants(UNIT, [0 * w for w in WANTED], GRID.kind),
        "no free point moves; give a load case"),
    (lambda: fitted_constants([replace(UNIT[0], force=0 * UNIT[0].force)], WANTED[:1], GRID.kind),
        "nothing moves the networks; load them by forces"),
    (lambda: fitted_constants(UNIT, [np.nan * w for w in WANTED], GRID.kind), "wanted disp"),
    (lambda: fitted_constants([UNIT[0], *networks((1.0, 1.0), 1.0)[1:]], WANTED, GRID.kind),
        "volumes in some networks only"),
    (lambda: fitted_constants([replace(UNIT[0], rest_length=1.1 * UNIT[0].rest_length)], WANTED[:1],
        GRID.kind), "a spring pulls at rest"),
    (lambda: fitted_constants([None], WANTED[:1], GRID.kind), "network: None; give a Network"),
])  # fmt: skip
def test_bad_questions_are_refused(call, said):
    with pytest.raises(ProblemError, match=said):
        call()
