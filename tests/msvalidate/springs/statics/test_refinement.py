"""Refinement: answers against many digits, and the errors that they state."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from msvalidate.linear_algebra import choice
from msvalidate.problem import Region, SolverError, Traction
from msvalidate.springs.dynamics.spectrum import natural_frequencies
from msvalidate.springs.network import Configuration, spring_network
from msvalidate.springs.network.inverse import Solver
from msvalidate.springs.network.refine import LARGEST_ERROR
from msvalidate.springs.statics.equilibrium import equilibrium
from msvalidate.springs.statics.refinement import error_of_displacement, refine_equilibrium
from msvalidate.springs.statics.tangents import is_stable
from tests.table import table
from tests.truth import exact

GEOMETRIES = ["linear", "nonlinear"]


def true_error(network, geometry, displacement):
    """Largest error of a component over the largest component."""
    linear = geometry == "linear"
    truth = exact.linear(network) if linear else exact.nonlinear(network, displacement)
    return truth.error_of(displacement)


def braced(cells, size, rng, *, decades=0.0, far=0.0, prestress=0.0, load=1e-3, shaken=0.15):
    """A cantilever of braced cells, its points out of place, its spring constants scattered."""
    steps = [np.arange(n + 1) * extent / n for n, extent in zip(cells, size, strict=True)]
    points = np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1).reshape(-1, 2)
    points += shaken * rng.uniform(-1, 1, points.shape) * np.divide(size, cells)
    points += far * max(size) * np.array([0.3, -1.0])
    number = np.arange(len(points)).reshape(cells[0] + 1, cells[1] + 1)
    springs = np.concatenate(
        [
            np.stack([a.ravel(), b.ravel()], axis=1)
            for a, b in (
                (number[:-1], number[1:]),
                (number[:, :-1], number[:, 1:]),
                (number[:-1, :-1], number[1:, 1:]),
                (number[1:, :-1], number[:-1, 1:]),
            )
        ]
    )
    k = 10 ** (decades * rng.uniform(-0.5, 0.5, len(springs)))
    distance = np.linalg.norm(points[springs[:, 1]] - points[springs[:, 0]], axis=1)
    held = np.zeros(points.shape, dtype=bool)
    held[number[0]] = True
    force = np.zeros(points.shape)
    force[number[-1]] = load * rng.uniform(-1, 1, 2)
    return spring_network(
        points,
        springs,
        k,
        rest_length=distance * (1 - prestress * rng.uniform(0, 1, len(k))),
        fixed=held,
        force=force,
    )


# Against exact arithmetic -----------------------------------------------------------------------

BODIES = {
    "plain": {},
    "slender": {"size": (370.0, 0.37), "load": 1e-9},
    "6 decades": {"decades": 6.0, "load": 1e-7},
    "far": {"far": 1e3, "load": 1e-9},
    "prestressed": {"prestress": 0.02},
    "slender, prestressed, far": {"size": (37.0, 0.37), "prestress": 1e-4, "far": 1e3,
        "load": 1e-9},
}  # fmt: skip


@pytest.mark.parametrize("geometry", GEOMETRIES)
@pytest.mark.parametrize("name", BODIES)
def test_answers_are_the_exact_ones_within_the_error_stated(name, geometry):
    options = {"size": (1.48, 0.37), **BODIES[name]}
    network = braced((6, 2), rng=np.random.default_rng(3), **options)
    found = equilibrium(network, geometry)
    error = true_error(network, geometry, found.displacement)
    assert error <= found.error < 1e-9


def test_reactions_balance_the_load_to_rounding_of_its_moment(lattice_body):
    # The tip of a cantilever 4,000 cells long: force P and moment P L at its root.
    length, load = 4000.0, 1e-11
    network = lattice_body((length, 1.0), (4000, 1), loads=(tip(length, -load),))
    reaction = equilibrium(network).reaction
    # Two points' six springs, each component a product and a sum: some 16 roundings of the moment.
    assert reaction.sum(axis=0) == pytest.approx([0.0, load], abs=16 * 2**-52 * load * length)
    assert reaction[0, 0] - reaction[1, 0] == pytest.approx(load * length, rel=1e-12)


def test_a_load_far_below_balanced_prestress_keeps_its_digits():
    # Two springs in line, pulled tight: their pulls cancel but for 1e-16, which is no force.
    network = spring_network(
        [[0.0, 0.0], [0.37, 0.0], [0.74, 0.0]],
        [[0, 1], [1, 2]],
        3.0,
        rest_length=0.3,
        fixed=[[True, True], [False, False], [True, True]],
        force=[[0, 0], [0, 1e-6], [0, 0]],
    )
    found = equilibrium(network)
    pull = 3.0 * 0.07
    assert found.displacement[1, 1] == pytest.approx(1e-6 / (2 * pull / 0.37), rel=1e-14)
    assert found.error < 1e-13


# Long bodies ------------------------------------------------------------------------------------


def tip(length, load):
    return Traction(Region((length, None)), (0.0, load))


def tip_of(truth):
    return float(truth.displacement[-1].mid())


def long_body(lattice_body, length, load=1e-9):
    return lattice_body((float(length), 1.0), (length, 1), loads=(tip(float(length), -load),))


@pytest.mark.parametrize("length", [1000, 4000, 10_000])
def test_a_long_body_bends_as_its_cells_do(lattice_body, length):
    # A chain of equal cells under an end force bends by a L³ + b L: both from two short ones,
    # which are solved exactly, and confirmed by a third.
    short = {n: tip_of(exact.linear(long_body(lattice_body, n))) for n in (2, 4, 7)}
    a, b = np.linalg.solve([[8.0, 2.0], [64.0, 4.0]], [short[2], short[4]])
    assert short[7] == pytest.approx(a * 343 + b * 7, rel=1e-13)
    network = long_body(lattice_body, length)
    found = equilibrium(network)
    expected = a * length**3 + b * length
    assert abs(found.displacement[-1, 1] / expected - 1) <= found.error + 1e-13
    assert found.error < 1e-9
    stretch = network.vector / np.linalg.norm(network.vector, axis=1)[:, None]
    i, j = network.springs.T
    along = ((found.displacement[j] - found.displacement[i]) * stretch).sum(axis=1)
    work = np.vdot(network.force, found.displacement)
    assert network.stiffness @ along**2 / work == pytest.approx(1.0, abs=1e-12 + 2 * found.error)


def test_a_slender_cantilever_has_the_frequencies_of_a_beam(lattice_body):
    # Euler and Bernoulli: 1.8751² √(EI/m)/L², EI 3/16 of one cell. Shear and rotary inertia count
    # by a few (h/L)². Its square is 1e-13 of the highest, where eigenvalues have no digits left.
    network = lattice_body((1000.0, 1.0), (1000, 1), constants=(0.75, 0.375))
    lowest, highest = natural_frequencies(network, 1)
    mass = network.mass.sum() / 1000.0
    assert lowest[0] ** 2 < 1e-11 * highest**2
    assert lowest[0] == pytest.approx(1.87510407**2 * np.sqrt(3 / 16 / mass) / 1e6, rel=2e-5)


# Stiff beside soft ------------------------------------------------------------------------------


def half_stiff(times):
    rng = np.random.default_rng(1)
    network = braced((6, 2), (1.11, 0.37), rng, load=1e-3, shaken=0.0)
    middle = network.points[network.springs].mean(axis=1)[:, 0]
    return replace(network, stiffness=network.stiffness * np.where(middle > 0.56, times, 1.0))


@table("times", [1e6, 1e8, 1e10, 1e12, 1e14, 1e16])
@table("geometry", GEOMETRIES)
def test_a_stiff_half_is_answered_rightly_or_refused(times, geometry):
    network = half_stiff(times)
    found, said = None, ""
    try:
        found = equilibrium(network, geometry)
    except SolverError as refusal:
        said = str(refusal)
    if found is None:
        assert times > 1e9
        assert "stiffnesses" in said or "stiffen" in said
        return
    error = true_error(network, geometry, found.displacement)
    assert error <= found.error
    assert error < LARGEST_ERROR


def test_rounding_of_pivots_makes_no_body_unstable():
    # Of unstressed springs alone, so stable; at 1e12 some of its pivots are negative by rounding.
    network = half_stiff(1e12)
    assert is_stable(Configuration(network))


# Small loads ------------------------------------------------------------------------------------


@pytest.mark.parametrize("geometry", GEOMETRIES)
def test_a_form_in_balance_under_its_own_tension_stays_where_it_is(geometry):
    corners = 0.37 * np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    pairs = [[0, 1], [1, 2], [2, 3], [3, 0], [0, 2], [1, 3]]
    held = [[True, True], [False, True], [False, False], [False, False]]
    rest = np.array([1.0, 1.0, 1.0, 1.0, np.sqrt(2), np.sqrt(2)]) * 0.37
    rest += np.array([-1.0, -1.0, -1.0, -1.0, 1.0, 1.0]) * [*[1e-3] * 4, *[1e-3 * np.sqrt(2)] * 2]
    # Sides pull by k times 1 mm, diagonals push by √2 of it.
    found = equilibrium(spring_network(corners, pairs, 1.0, rest_length=rest, fixed=held), geometry)
    assert not found.displacement.any()
    assert found.error == 0.0


# The end of other solutions -----------------------------------------------------------------------


@pytest.mark.parametrize("products", [choice.MOST_PRODUCTS, 0])
@pytest.mark.parametrize("size", [1e-12, 1e-8, 1e-4])
def test_the_error_of_a_displacement_is_what_it_is_off_by(size, products, monkeypatch):
    """By a factor, and by multigrid."""
    network = braced((6, 2), (1.48, 0.37), np.random.default_rng(7), load=1e-3)
    rest = equilibrium(network, "nonlinear").displacement
    shift = np.where(network.fixed, 0.0, np.random.default_rng(8).normal(size=rest.shape))
    off = rest + size * np.abs(rest).max() * shift / np.abs(shift).max()
    error = np.abs(off - rest).max() / np.abs(rest).max()
    monkeypatch.setattr(choice, "MOST_PRODUCTS", products)
    assert error <= error_of_displacement(network, off) < 3 * error
    again = refine_equilibrium(network, off, None, Solver(network))
    np.testing.assert_allclose(again.solution, rest, rtol=0, atol=4e-16 * np.abs(rest).max())
