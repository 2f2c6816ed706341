"""Refinement: answers against exact arithmetic, and the errors that they state.

`exact` solves in decimals of 60 digits, from the doubles as they are given, by elimination: it
shares nothing with the package but the formulas of a spring and of a plane cell, and that a spring
whose rest length is the rounded distance of its points is at rest.
"""

from __future__ import annotations

from dataclasses import replace
from decimal import Decimal, localcontext

import numpy as np
import pytest

from msvalidate.dynamics.spectrum import natural_frequencies
from msvalidate.linear_algebra.double_double import Pair, add, as_pair
from msvalidate.linear_algebra.refine import LARGEST_ERROR
from msvalidate.network import internal_force, spring_network
from msvalidate.network.accurate import State
from msvalidate.network.laws.volumes import Volumes
from msvalidate.problem import Region, SolverError, Traction
from msvalidate.statics.equilibrium import equilibrium
from msvalidate.statics.polish import error_of_displacement, refine_equilibrium
from msvalidate.statics.tangents import is_stable
from msvalidate.tangent.inverse import Solver
from tests.table import table

GEOMETRIES = ["linear", "nonlinear"]
DIGITS = 60


def decimals(values):
    """Doubles as decimals, exactly."""
    return [Decimal(float(value)) for value in np.ravel(values)]


def spring_terms(network, u):
    """Force on every component, and the tangent's entries, at a displacement in decimals."""
    d = network.dim
    X, F, K = decimals(network.points), decimals(network.force), {}
    k, rest = decimals(network.stiffness), decimals(network.rest_length)
    for s, (i, j) in enumerate(network.springs.tolist()):
        apart = [X[j * d + a] - X[i * d + a] for a in range(d)]
        v = [apart[a] + u[j * d + a] - u[i * d + a] for a in range(d)]
        length, distance = (sum(x * x for x in w).sqrt() for w in (v, apart))
        at_rest = abs(rest[s] - distance) <= distance * Decimal(2) ** -50
        across = k[s] * (1 - (distance if at_rest else rest[s]) / length)
        for a in range(d):
            F[i * d + a] += across * v[a]
            F[j * d + a] -= across * v[a]
            for b in range(d):
                entry = (k[s] - across) * v[a] * v[b] / length**2 + (across if a == b else 0)
                for p, q, sign in ((i, i, 1), (j, j, 1), (i, j, -1), (j, i, -1)):
                    at = p * d + a, q * d + b
                    K[at] = K.get(at, Decimal(0)) + sign * entry
    return F, K


def cell_terms(network, u, F, K):
    """Add plane cells that resist a change of area, by the shoelace formula."""
    X = decimals(network.points)
    constants = decimals(network.volumes.stiffness)
    for cell, kappa in zip(network.volumes.cells.tolist(), constants, strict=True):
        corners = len(cell)
        dofs = [2 * p + a for p in cell for a in range(2)]
        x = [X[dof] + u[dof] for dof in dofs]
        area = [
            sum(z[2 * i] * z[2 * j + 1] - z[2 * j] * z[2 * i + 1] for i, j in around(corners)) / 2
            for z in (x, [X[dof] for dof in dofs])
        ]
        slope = [Decimal(0)] * len(dofs)
        second = {}
        for i, j in around(corners):
            for p, q, sign in ((2 * i, 2 * j + 1, 1), (2 * j, 2 * i + 1, -1)):
                slope[p] += sign * x[q] / 2
                slope[q] += sign * x[p] / 2
                for at in ((p, q), (q, p)):
                    second[at] = second.get(at, Decimal(0)) + Decimal(sign) / 2
        pressure = kappa * (area[0] / area[1] - 1)
        for p, dof in enumerate(dofs):
            F[dof] -= pressure * slope[p]
            for q, other in enumerate(dofs):
                entry = kappa / area[1] * slope[p] * slope[q] + pressure * second.get((p, q), 0)
                K[dof, other] = K.get((dof, other), Decimal(0)) + entry


def around(corners):
    return [(i, (i + 1) % corners) for i in range(corners)]


def newton_step(network, u):
    """One exact linear solve from u: the displacement that balances to first order."""
    F, K = spring_terms(network, u)
    if network.volumes is not None:
        cell_terms(network, u, F, K)
    held, moved = network.held.ravel(), decimals(network.displacement)
    step = [moved[c] - u[c] if held[c] else Decimal(0) for c in range(len(u))]
    free = np.flatnonzero(~held).tolist()
    rows = [{q: K[p, q] for q in free if (p, q) in K} for p in free]
    right = [
        F[p] - sum(K[p, q] * step[q] for q in np.flatnonzero(held) if (p, q) in K) for p in free
    ]
    for p, value in zip(free, eliminated(rows, right, free), strict=True):
        step[p] = value
    return [a + b for a, b in zip(u, step, strict=True)]


def eliminated(rows, right, columns):
    """Solve a symmetric system given as sparse rows, without pivoting: 60 digits forgive it."""
    place = {column: row for row, column in enumerate(columns)}
    for row, column in enumerate(columns):
        for other in [place[q] for q in rows[row] if place[q] > row]:
            times = rows[other][column] / rows[row][column]
            right[other] -= times * right[row]
            for q, value in rows[row].items():
                rows[other][q] = rows[other].get(q, Decimal(0)) - times * value
    out = [Decimal(0)] * len(columns)
    for row in range(len(columns) - 1, -1, -1):
        later = sum(rows[row][q] * out[place[q]] for q in rows[row] if place[q] > row)
        out[row] = (right[row] - later) / rows[row][columns[row]]
    return out


def exact(network, geometry, near):
    """Exact displacement: by one solve, or by Newton's method from a displacement close by."""
    if geometry == "linear":
        return newton_step(network, [Decimal(0)] * network.points.size)
    u = decimals(near)
    for _ in range(4):  # each squares the error: from 1e-4 to 1e-60 in four
        u = newton_step(network, u)
    return u


def true_error(network, geometry, displacement):
    """Largest error of a component over the largest component."""
    with localcontext() as context:
        context.prec = DIGITS
        u = exact(network, geometry, displacement)
        apart = (abs(a - b) for a, b in zip(decimals(displacement), u, strict=True))
        return float(max(apart) / max(abs(b) for b in u))


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
        held=held,
        force=force,
    )


# Against exact arithmetic -----------------------------------------------------------------------

BODIES = {
    "plain": {},
    "slender 1e4": {"size": (3.7e3, 0.37), "load": 1e-13},
    "12 decades": {"decades": 12.0, "load": 1e-7},
    "far": {"far": 1e7, "load": 1e-9},
    "far, 1e-9": {"far": 1e7, "load": 1e-9, "decades": 4.0},
    "prestressed": {"prestress": 0.02},
    "slender, prestressed, far": {
        "size": (37.0, 0.37),
        "prestress": 1e-4,
        "far": 1e3,
        "load": 1e-9,
    },
}


@pytest.mark.parametrize("geometry", GEOMETRIES)
@pytest.mark.parametrize("name", BODIES)
def test_answers_are_the_exact_ones_within_the_error_stated(name, geometry):
    options = {"size": (1.48, 0.37), **BODIES[name]}
    network = braced((6, 2), rng=np.random.default_rng(3), **options)
    found = equilibrium(network, geometry)
    error = true_error(network, geometry, found.displacement)
    assert error <= found.error
    # Refined, nothing but the rounding of the answer to doubles is left of it.
    assert error < 4e-16


def with_cells(network, cells, kappa):
    number = np.arange(len(network.points)).reshape(cells[0] + 1, cells[1] + 1)
    corners = (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:])
    quads = np.stack([corner.ravel() for corner in corners], axis=1)
    return replace(network, volumes=Volumes(network.points, quads, kappa(len(quads))))


@pytest.mark.parametrize("geometry", GEOMETRIES)
def test_cells_that_resist_a_change_of_area_count_as_exactly(geometry):
    rng = np.random.default_rng(5)
    network = braced((5, 2), (370.0, 0.37), rng, load=1e-9, far=10.0)
    network = with_cells(network, (5, 2), lambda count: rng.uniform(0.1, 100.0, count))
    found = equilibrium(network, geometry)
    error = true_error(network, geometry, found.displacement)
    assert error <= found.error
    assert error < 4e-16


def test_reactions_balance_the_load_to_the_last_digits(lattice_body):
    # The tip of a cantilever 4,000 cells long: force P and moment P L at its root.
    length, load = 4000.0, 1e-11
    network = lattice_body((length, 1.0), (4000, 1), loads=(tip(length, -load),))
    reaction = equilibrium(network).reaction
    assert reaction.sum(axis=0) == pytest.approx([0.0, load], rel=1e-12, abs=1e-12 * load)
    assert reaction[0, 0] - reaction[1, 0] == pytest.approx(load * length, rel=1e-12)


def test_an_ordinary_body_takes_one_correction():
    # A residual of the wrong sign would be made good by what combines corrections, at their cost.
    network = braced((6, 2), (1.48, 0.37), np.random.default_rng(3))
    assert equilibrium(network).iterations == 2


def test_a_load_far_below_prestress_is_known_no_better_than_that_lets_it():
    # Two springs in line, pulled tight: their pulls cancel, rounded by 1e-32 of themselves.
    network = spring_network(
        [[0.0, 0.0], [0.37, 0.0], [0.74, 0.0]],
        [[0, 1], [1, 2]],
        3.0,
        rest_length=0.3,
        held=[[True, True], [False, False], [True, True]],
        force=[[0, 0], [0, 1e-20], [0, 0]],
    )
    found = equilibrium(network)
    pull = 3.0 * 0.07
    assert found.displacement[1, 1] == pytest.approx(1e-20 / (2 * pull / 0.37), rel=1e-9)
    assert 1e-13 < found.error < LARGEST_ERROR


# Long bodies ------------------------------------------------------------------------------------


def tip(length, load):
    return Traction(Region((length, None)), (0.0, load))


def long_body(lattice_body, length, load=1e-9):
    return lattice_body((float(length), 1.0), (length, 1), loads=(tip(float(length), -load),))


@pytest.mark.parametrize("length", [1000, 4000, 10_000])
def test_a_long_body_bends_as_its_cells_do(lattice_body, length):
    # A chain of equal cells under an end force bends by a L³ + b L: both from two short ones,
    # which are solved exactly, and confirmed by a third.
    with localcontext() as context:
        context.prec = DIGITS
        short = {n: float(exact(long_body(lattice_body, n), "linear", None)[-1]) for n in (2, 4, 7)}
    a, b = np.linalg.solve([[8.0, 2.0], [64.0, 4.0]], [short[2], short[4]])
    assert short[7] == pytest.approx(a * 343 + b * 7, rel=1e-13)
    network = long_body(lattice_body, length)
    found = equilibrium(network)
    expected = a * length**3 + b * length
    assert abs(found.displacement[-1, 1] / expected - 1) <= found.error + 1e-13
    assert found.error < 1e-13
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
    assert is_stable(network, network.points)
    assert equilibrium(network, "nonlinear").error < LARGEST_ERROR


# Small loads ------------------------------------------------------------------------------------


@pytest.mark.parametrize("geometry", GEOMETRIES)
def test_a_small_load_on_a_long_body_moves_it(lattice_body, geometry):
    # E = 1e6 Pa: 1e-6 N bends it by 16/9 · 1e-12 · 1e9 m; it was 0 by "nonlinear".
    network = long_body(lattice_body, 1000, 1e-6)
    network = replace(network, stiffness=1e6 * network.stiffness)
    found = equilibrium(network, geometry)
    assert found.displacement[-1, 1] == pytest.approx(-1.78e-3, rel=2e-3)
    assert found.error < LARGEST_ERROR


@pytest.mark.parametrize("geometry", GEOMETRIES)
def test_a_small_load_far_from_the_origin_moves_a_body(geometry):
    # Cells of 1 m at UTM coordinates; 0.01 N moved it by 0 where 1e-7 m is right.
    near = braced((8, 2), (8.0, 2.0), np.random.default_rng(2), shaken=0.0, load=0.01)
    near = replace(near, stiffness=1e6 * near.stiffness)
    far = replace(near, points=near.points + np.array([4.3e5, 5.2e6]))
    found, expected = (equilibrium(network, geometry) for network in (far, near))
    np.testing.assert_array_equal(found.displacement, expected.displacement)
    assert np.abs(found.displacement).max() > 1e-8
    assert true_error(far, geometry, found.displacement) <= found.error


@pytest.mark.parametrize("times", [2.0**-60, 2.0**40])
def test_a_linear_answer_grows_with_its_load_to_the_last_bit(times):
    # Rest lengths are distances rounded to doubles: as prestress that would outweigh a small load.
    network = braced((4, 2), (1.48, 0.37), np.random.default_rng(4), load=1e-3)
    other = equilibrium(replace(network, force=times * network.force))
    np.testing.assert_array_equal(other.displacement, times * equilibrium(network).displacement)


@pytest.mark.parametrize("geometry", GEOMETRIES)
def test_without_a_load_nothing_moves_and_nothing_is_wrong(lattice_body, geometry):
    found = equilibrium(lattice_body((1.11, 0.37), (6, 2)), geometry)
    assert not found.displacement.any()
    assert found.error == 0.0


# The end of other solutions -----------------------------------------------------------------------


@pytest.mark.parametrize("size", [1e-12, 1e-8, 1e-4])
def test_the_error_of_a_displacement_is_what_it_is_off_by(size):
    network = braced((6, 2), (1.48, 0.37), np.random.default_rng(7), load=1e-3)
    rest = equilibrium(network, "nonlinear").displacement
    shift = np.where(network.held, 0.0, np.random.default_rng(8).normal(size=rest.shape))
    off = rest + size * np.abs(rest).max() * shift / np.abs(shift).max()
    error = np.abs(off - rest).max() / np.abs(rest).max()
    assert error <= error_of_displacement(network, off) < 2 * error
    again = refine_equilibrium(network, off, None, Solver(network))
    np.testing.assert_allclose(again.displacement, rest, rtol=0, atol=2e-16 * np.abs(rest).max())


# Forces in twice the digits -----------------------------------------------------------------------


def in_space(kind, rng):
    """A jittered block of 3 x 3 x 3 points with springs to neighbours, and what stands beside."""
    grid = np.stack(np.meshgrid(*[np.arange(3.0)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    points = 0.37 * (grid + rng.uniform(-0.1, 0.1, grid.shape))
    i, j = np.triu_indices(27, 1)
    close = np.linalg.norm(grid[i] - grid[j], axis=1) < 1.5
    springs = np.stack([i, j], axis=1)[close]
    number = np.arange(27).reshape(3, 3, 3)
    bits = [(*c, z) for z in (0, 1) for c in ((0, 0), (1, 0), (1, 1), (0, 1))]
    boxes = [number[tuple(slice(b, b + 2) for b in bit)].ravel() for bit in bits]
    parts = {
        "springs": {},
        "cells": {"volumes": Volumes(points, np.stack(boxes, axis=1), rng.uniform(-1, 5, 8))},
    }
    rest = np.linalg.norm(points[springs[:, 1]] - points[springs[:, 0]], axis=1)
    rest *= rng.uniform(0.9, 1.1, len(springs))
    return spring_network(
        points, springs, rng.uniform(0.1, 9, len(springs)), rest_length=rest, **parts[kind]
    )


@pytest.mark.parametrize("kind", ["springs", "cells"])
def test_forces_have_twice_the_digits_of_doubles(kind):
    rng = np.random.default_rng(9)
    network = in_space(kind, rng)
    u, way = 0.02 * rng.uniform(-1, 1, (2, 27, 3))
    here = State(network, as_pair(u))
    unit = here.length * here.stiffness
    plain = internal_force(network, network.points + u)
    np.testing.assert_allclose(here.force().hi * unit, plain, atol=2e-14 * np.abs(plain).max())
    # A step of 1e-13 changes forces by 13 digits less than they have; of doubles 3 would be left.
    h = 2.0**-43
    there = State(network, add(as_pair(u), as_pair(h * way)))
    change = add(there.force(), Pair(*(-x for x in here.force()))).hi * unit / h
    zero = as_pair(np.zeros_like(u))
    slope = here.residual(zero, as_pair(way)).hi * here.stiffness
    np.testing.assert_allclose(change, slope, atol=1e-11 * np.abs(slope).max())


@pytest.mark.parametrize("load", [1e-20, 1e-60, 1e-250])
@pytest.mark.parametrize("kind", ["springs", "cells"])
def test_a_strain_of_nothing_to_speak_of_is_the_linear_one(kind, load):
    # Lengths have 32 digits, and elongations at these strains none of them: diagonals did not pull.
    network = in_space(kind, np.random.default_rng(9))
    held = np.zeros(network.points.shape, dtype=bool)
    held[:9] = True
    force = np.where(held, 0.0, load * np.random.default_rng(1).uniform(-1, 1, held.shape))
    parts = {"volumes": replace(network.volumes, stiffness=np.ones(8))} if kind == "cells" else {}
    distance = np.linalg.norm(network.vector, axis=1)
    network = replace(network, rest_length=distance, held=held, force=force, **parts)
    found, linear = equilibrium(network, "nonlinear"), equilibrium(network)
    scale = np.abs(linear.displacement).max()
    # To second order they differ by strains, some 10 times the load here.
    apart = np.abs(found.displacement - linear.displacement).max() / scale
    assert apart <= found.error + linear.error + 100 * load
    assert found.error < 1e-14
