"""The study `actuator`: closed forms by other routes, measures of known shapes, identity."""

from functools import partial

import numpy as np
import pytest
from msvalidate.studies.actuator import (
    actuator_controls,
    bodies,
    edges,
    figure8_statements,
    models,
    prestretched,
    profile,
)

import reference_fem
from msvalidate.bench.judging.evidence import judge
from msvalidate.bench.judging.sweep import Setting
from msvalidate.problem import Box, Isotropic, SolverError
from msvalidate.studies import actuator

QUICK = Setting(quick=True)


@pytest.fixture(scope="module")
def solids():
    """Upper faces that finite elements put in the springs' place, on another mesh."""
    return profile.solve_faces(partial(bodies.elastic, 16), QUICK, ("partial",))


def test_reference_in_the_candidates_place(solids):
    """It differs from itself by no more than its meshes do."""
    table = profile.evidence(solids).tables["profile"]
    assert (table["difference_away"] <= 2 * table["uncertainty"]).all()


def test_two_ways_to_the_springs_agree():
    """Newton on all at once, and one linear solve under the forces at the first places."""
    slab = bodies.body("partial", 5)
    whole = bodies.springs(slab, profile.VOLTAGE)
    linear = bodies.linear_response(None, slab, profile.VOLTAGE)
    assert whole == pytest.approx(linear, abs=1e-4 * np.abs(linear).max())


def test_edge_force_of_a_wide_capacitor():
    """½ε/h for every length that two long faces gain; an edge over another has half of it."""
    wide = 0.5 / bodies.HEIGHT
    assert edges.edge_force("partial") == pytest.approx(wide, rel=0.15)
    assert edges.edge_force("full") == pytest.approx(wide / 2, rel=0.1)


def test_growth_under_a_force_on_a_straight_face():
    """Flamant: a force F along the face moves points by 2F/(πE)·ln 2 a halving."""
    found = edges.under_a_force(np.pi, 3.0)
    assert found == pytest.approx([2 / (3 * np.pi) * np.log(2), 0.0], abs=1e-12)


def test_growth_under_a_force_on_a_corner_by_elements():
    """A square corner under a point force: halving the cells adds what the closed form says."""
    box, material = Box((1.0, 1.0)), Isotropic(2.0, 1 / 3, "plane_stress")
    seen = []
    for cells in (16, 32, 64):
        mesh = reference_fem.box_discretisation(box, cells, "Q2")
        solver = reference_fem.Solver
        force = np.zeros(mesh.points.shape)
        tip = np.flatnonzero((mesh.points == (1.0, 1.0)).all(axis=1))[0]
        force[tip, 0] = 1.0
        held_at = np.repeat((mesh.points[:, 1] == 0)[:, None], 2, axis=1)
        stiffness = reference_fem.elasticity.stiffness(mesh, material)
        moved, _ = solver(mesh, stiffness, held_at).solve(np.zeros(force.shape), force)
        seen.append(moved[tip])
    grown = np.diff(seen, axis=0)[-1]
    assert grown == pytest.approx(edges.under_a_force(np.pi / 2, 2.0), rel=0.02)


@pytest.mark.parametrize(
    ("grown", "limit"),
    [([1.0, 1.0, 1.0], 1.0), ([3 + 2**-0.5, 3 + 0.5, 3 + 2**-1.5], 3.0)],
)
def test_limits_of_growth(grown, limit):
    assert profile.limit_of(grown) == pytest.approx(limit, abs=1e-12)
    assert np.isnan(profile.limit_of(grown[:2]))


@pytest.mark.parametrize(("name", "size"), actuator_controls.ASKED.items())
def test_faults_are_mixed_as_they_are(name, size):
    """The resolution's shortcut is the faulty candidate itself."""
    kind, slab = actuator_controls.KINDS[name], bodies.body("partial", 3)
    right = bodies.linear_response(None, slab, 1.0)
    wrong = kind.spoilt(1.0)(slab, 1.0)
    there = kind.spoilt(size)(slab, 1.0)
    assert kind.mixed(size, right, wrong) == pytest.approx(there, abs=1e-12)


def seen(shape, voltage=1.0, inner=0.4):
    x = np.linspace(0, 60, 61)
    move = np.column_stack([np.zeros(61), -shape(x)])
    return models.Observation(voltage, x, move, np.ones(61, dtype=bool), inner)


def test_measures_of_known_faces():
    """A parabola that is deepest at its ends, and a wave."""
    bowl = seen(lambda x: 1 + ((x - 30) / 30) ** 2)
    assert figure8_statements.middle(bowl) == -1.0
    assert figure8_statements.margin(bowl) == -2.0
    assert figure8_statements.deflection(bowl) == pytest.approx(-(1 + (28 / 30) ** 2))
    assert figure8_statements.count_dips(bowl) == 2
    assert figure8_statements.count_dips(seen(lambda x: 2 - np.cos(2 * np.pi * x / 20))) == 3
    assert figure8_statements.count_dips(seen(lambda x: 1 + 0.001 * np.cos(x))) == 1, (
        "ripples are no dips"
    )
    flat = seen(lambda x: 0 * x)
    assert figure8_statements.fastest_growth(flat, bowl, "full") == 0.0
    bump = seen(lambda x: np.exp(-((x - 25) ** 2)))
    assert figure8_statements.fastest_growth(flat, bump, "partial") == 5.0


def test_a_voltage_that_was_not_held_is_named():
    run = [seen(lambda x: 0 * x, voltage) for voltage in (0.5, 1.0)]
    assert figure8_statements.at(run, 1.0) is run[1]
    with pytest.raises(SolverError, match=r"2 V was not held.*last held: 1 V"):
        figure8_statements.at(run, 2.0)
    with pytest.raises(SolverError, match=r"2 V was not held.*last held: 0.5 V"):
        figure8_statements.last_two(run[:1])


def walk(low, high, inner=0.4):
    return [seen(low, 0.5), seen(high, 1.5, inner), seen(lambda x: 2 * high(x), 2.0, inner)]


def even(x):
    return np.ones_like(x)


def shallow(x):
    return 0.1 * even(x)


def bowl(x):
    return 1 + 2 * ((x - 30) / 30) ** 2


def bump(place):
    return lambda x: 1 + np.exp(-((x - place) ** 2))


FACES = (
    (walk(bowl, bowl), walk(even, even)),
    (walk(even, bowl), walk(bowl, bowl)),
    (walk(shallow, shallow), walk(even, even)),
    (walk(even, even), walk(bowl, bowl)),
    (walk(even, lambda x: 2 - np.cos(2 * np.pi * x / 20)), walk(even, even)),
    (walk(even, bump(25)), walk(even, bump(20))),
    (walk(even, even, 0.5), walk(even, even, 0.3)),
)
"""Faces of which each statement holds, and of which it does not."""


@pytest.mark.parametrize(
    ("statement", "faces"), list(zip(figure8_statements.STATEMENTS, FACES, strict=True))
)
def test_every_statement_can_come_to_anything(statement, faces):
    """What it comes to hangs on the faces alone, and is not written into the table."""
    for ways, words in (
        ((True, True, True, True), "physics"),
        ((True, False, False, True), "physics, not shown by the report's way throughout"),
        ((False, True, True, False), "made by the report's model"),
        ((False, True, False, False), "made by the report's model on 10 layers"),
        ((False, False, True, False), "made by the report's model on 5 layers"),
        ((False, False, False, False), "holds in none of them"),
        ((True, True, True, False), "open: springs and FEM do not agree"),
    ):
        shown = (faces[0] if way else faces[1] for way in ways)
        row = figure8_statements.judge_statement(
            statement, dict(zip(models.SOURCES, shown, strict=True))
        )
        assert row["verdict_on_statement"] == words
        judgement = [source for source, way in zip(models.SOURCES, ways, strict=True) if way]
        assert row["judgement"] == (" and ".join(judgement) or "none")


@pytest.mark.parametrize(
    ("fault", "noticing", "disputed"),
    [("charges as at the start", [0, 1, 4], 1), ("edges pushed inwards", [0, 1, 2, 4], 3)],
)
def test_figure8_notices_its_faults(fault, noticing, disputed):
    """Charges that stay as they were make no effect that grows, and elements do: one statement."""
    verdict = judge(actuator.run(**actuator.FAULTS[fault], setting=QUICK))
    assert list(verdict.index[verdict["verdict"] == "fail"]) == noticing
    assert verdict["observed"].iloc[-1] == disputed


def test_part_that_is_alike():
    x = np.linspace(0, 10, 1001)
    assert prestretched.similar_fraction(x, np.ones_like(x)) == 1.0
    tent = 1 + 0.1 * np.abs(x - 5)  # 5 % at half a metre from the middle
    assert prestretched.similar_fraction(x, tent) == pytest.approx(0.1, abs=1e-9)


def test_stretched_law_is_the_law_of_the_stretched_body():
    """At rest it has the fibres' own stress; its stress is the slope of its energy."""
    F0 = np.diag([1.5, 0.8])
    law = prestretched.Stretched(prestretched.square_fibres(1.0, 0.5), F0)
    F, step = np.array([[[1.05, 0.1], [-0.05, 0.95]]]), 1e-6
    for i in range(2):
        for j in range(2):
            up, down = F.copy(), F.copy()
            up[0, i, j] += step
            down[0, i, j] -= step
            slope = (law.energy(up) - law.energy(down))[0] / (2 * step)
            assert law.stress(F)[0, i, j] == pytest.approx(slope, rel=1e-6)
            bend = (law.stress(up) - law.stress(down))[0] / (2 * step)
            assert law.tangent(F)[0, :, :, i, j] == pytest.approx(bend, abs=1e-6)


def test_every_film_is_at_rest_without_a_voltage():
    for film in prestretched.films((1.0, 2.0), 5):
        rest = bodies.springs(film.bonded(5), 0.0)
        assert np.abs(rest).max() < 1e-9 * film.height
