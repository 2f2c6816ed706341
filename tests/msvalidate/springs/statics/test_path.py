"""Paths of loads and prescribed displacements: followed as given, or refused in one line."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from msvalidate.problem import Box, ProblemError, SolverError, Support, Traction
from msvalidate.springs.dynamics.relax import relax
from msvalidate.springs.dynamics.relaxations import RELAXATIONS
from msvalidate.springs.network import spring_network
from msvalidate.springs.statics.equilibrium import equilibrium
from tests.msvalidate.energies import spring_energy
from tests.table import table

LENGTH, HEIGHT, CELLS = 2.22, 0.37, (24, 4)
ANGLE = 3.5
"""rad, by which the ends are turned against each other."""
BENDING = 1 / 12 * (1 + 1.25 / 16)
"""Of the lattice with four cells through the height, over E·t·height³ (`test_unstable`)."""


def bar(lattice_body):
    box = Box((LENGTH, HEIGHT))
    ends = (Support(box.side("left"), (0, 0)), Support(box.side("right"), (0, 0)))
    return lattice_body((LENGTH, HEIGHT), CELLS, supports=ends)


def bent(network, t):
    """Force and displacement at t: the right end goes along the arc that pure bending asks for."""
    angle, right = ANGLE * t, network.points[:, 0] > LENGTH - 1e-9
    moved = np.zeros(network.points.shape)
    if angle:
        radius, y = LENGTH / angle, network.points[right, 1] - HEIGHT / 2
        x = (radius - y) * np.sin(angle)
        moved[right, 0] = x - LENGTH
        moved[right, 1] = radius - (radius - y) * np.cos(angle) - y
    return np.zeros(moved.shape), moved


def test_ends_turned_by_more_than_half_a_turn_bend_the_bar_into_a_circle(lattice_body):
    """In proportion the end would move along a chord, through the bar."""
    network = bar(lattice_body)
    turned = replace(network, displacement=bent(network, 1.0)[1])
    with pytest.raises(SolverError, match="no stable equilibrium found beyond"):
        equilibrium(turned, "nonlinear")
    found = equilibrium(turned, "nonlinear", path=partial(bent, network))
    assert found.folded == 0
    assert found.passed_limit is None
    # Bending stiffness · angle² / (2 length); 3.5 rad over six heights are strains of 0.3.
    expected = BENDING * HEIGHT**3 * ANGLE**2 / (2 * LENGTH)
    assert spring_energy(network, found.position)[0] == pytest.approx(expected, rel=0.05)
    # A circle: the middle of the bar is where the arc has gone half of its way.
    radius, middle = (
        LENGTH / ANGLE,
        np.flatnonzero((network.points == [LENGTH / 2, HEIGHT / 2]).all(axis=1)),
    )
    place = radius * np.array([np.sin(ANGLE / 2), 1 - np.cos(ANGLE / 2)])
    apart = found.position[middle[0]] - [0, HEIGHT / 2] - place
    assert np.abs(apart).max() < 0.02 * radius
    run = relax(turned, RELAXATIONS["conjugate_gradients"], path=partial(bent, network))
    rest = run.equilibrium.displacement
    np.testing.assert_allclose(rest, found.displacement, atol=1e-7 * LENGTH)
    assert run.history[-1, 0] == run.steps
    assert (np.diff(run.history[:, 0]) >= 0).all()


def sheet(lattice_body):
    box = Box((0.37, 0.37))
    return lattice_body((0.37, 0.37), 4, loads=(Traction(box.side("right"), (0.05, 0.02)),))


def test_fractions_lead_to_where_the_whole_load_does(lattice_body):
    network = sheet(lattice_body)
    whole = equilibrium(network, "nonlinear")
    parts = equilibrium(network, "nonlinear", path=[0.1, 0.5, 1])
    np.testing.assert_allclose(parts.displacement, whole.displacement, rtol=0, atol=1e-14)
    assert parts.iterations > whole.iterations
    again = equilibrium(network, "nonlinear", start=whole)
    assert again.iterations < whole.iterations
    np.testing.assert_allclose(again.displacement, whole.displacement, rtol=0, atol=1e-14)
    for start in (whole, whole.displacement):
        run = relax(network, RELAXATIONS["newton"], start=start)
        assert run.steps <= 1


def test_a_function_is_met_at_its_own_loads_on_the_way(lattice_body):
    """Pulled far to the side and back, the sheet ends where it would have gone at once."""
    network, seen = sheet(lattice_body), []

    def applied(t):
        seen.append(t)
        aside = np.zeros(network.force.shape)
        aside[network.force[:, 0] > 0, 1] = -0.01 * np.sin(np.pi * t)
        return t * network.force + aside, network.displacement

    found = equilibrium(network, "nonlinear", path=applied)
    whole = equilibrium(network, "nonlinear")
    np.testing.assert_allclose(found.displacement, whole.displacement, rtol=0, atol=1e-13)
    assert set(np.arange(32) / 32) <= set(seen)


def truss(force):
    """Two springs that meet at a height of 0.037 m over supports 0.74 m apart, and their load."""
    return spring_network(
        [[-0.37, 0], [0, 0.037], [0.37, 0]],
        [[0, 1], [1, 2]],
        3.0,
        fixed=[[True, True], [True, False], [True, True]],
        force=[[0, 0], [0, -force], [0, 0]],
    )


def test_a_start_stays_on_its_own_branch():
    """Unloaded from where it has snapped through, the truss is its own mirror image."""
    through = equilibrium(truss(0.01), "nonlinear")
    assert through.position[1, 1] < -0.037
    left = equilibrium(truss(0.0), "nonlinear", start=through)
    assert left.position[1, 1] == pytest.approx(-0.037, rel=1e-12)
    assert equilibrium(truss(0.0), "nonlinear").position[1, 1] == 0.037
    run = relax(truss(0.0), RELAXATIONS["conjugate_gradients"], start=through)
    assert run.equilibrium.position[1, 1] == pytest.approx(-0.037, rel=1e-8)


def held_at(value):
    def path(t):
        moved = np.zeros((3, 2))
        moved[1, 1] = value
        return t * truss(1e-3).force, moved

    return path


BAD = {
    "falls": ([0.5, 0.4, 1.0], r"path: 0.4 at index 1; fractions must rise"),
    "from nothing": ([0.0, 1.0], r"path: 0 at index 0; fractions must rise"),
    "ends early": ([0.5, 0.9], r"path: ends at 0.9; its last fraction must be 1"),
    "ends late": ([0.5, 1.5], r"path: ends at 1.5; its last fraction must be 1"),
    "no row": (1.0, r"path: 1.0; give a row of fractions"),
    "empty": ([], r"path: \[\]; give a row of fractions"),
    "two rows": ([[0.5, 1.0]], r"give a row of fractions"),
    "NaN": ([0.5, np.nan, 1.0], r"path: nan"),
    "words": ("half", r"path: expected numbers"),
    "no pair": (lambda t: t, r"path: at t = 1 no pair of force and displacement .*return two"),
    "wrong shape": (lambda _: (np.zeros(3), np.zeros((3, 2))), r"path: force at t = 1: shape"),
    "NaN inside": (lambda t: (np.full((3, 2), np.nan if t < 1 else 0) + truss(1e-3).force,
        np.zeros((3, 2))), r"path: force at t = [0-9.]+: nan"),
    "free point moved": (held_at(0.1), r"displacement at t = 1 of point 1, which is not held"),
    "another end": (lambda t: (2 * t * truss(1e-3).force, np.zeros((3, 2))),
        r"path: at t = 1 the force of point 1 is \[.*\], the network's own \[.*\]; end the path"),
}  # fmt: skip


@table("case", BAD)
def test_bad_paths_are_refused_in_one_line(case):
    path, message = BAD[case]
    for solve in (
        partial(equilibrium, truss(1e-3), "nonlinear"),
        partial(relax, truss(1e-3), RELAXATIONS["newton"]),
    ):
        with pytest.raises(ProblemError, match=message) as caught:
            solve(path=path)
        assert "\n" not in str(caught.value)


@table(
    ("start", "message"),
    [
        (np.zeros((2, 2)), r"start: shape \(2, 2\); give an equilibrium of this network"),
        (np.full((3, 2), np.inf), "start: inf"),
        ("rest", "start: expected numbers"),
    ],
)
def test_bad_starts_are_refused(start, message):
    with pytest.raises(ProblemError, match=message):
        equilibrium(truss(1e-3), "nonlinear", start=start)
    with pytest.raises(ProblemError, match=message):
        relax(truss(1e-3), RELAXATIONS["newton"], start=start)


def test_a_linear_equilibrium_has_no_path():
    for given in ({"path": [1.0]}, {"start": np.zeros((3, 2))}):
        with pytest.raises(ProblemError, match="a linear equilibrium has neither"):
            equilibrium(truss(1e-3), **given)
    with pytest.raises(ProblemError, match="allow_folded: 1"):
        equilibrium(truss(1e-3), "nonlinear", allow_folded=1)
