"""The study `lattices`: known values, which bodies are exact, a lattice added as one function."""

from __future__ import annotations

from dataclasses import replace
from math import sqrt

import numpy as np
import pandas as pd
import pytest
from msvalidate.studies.lattices import (
    cases,
    clamped,
    edges,
    elastic,
    lattices_controls,
    loading,
    solids,
    uniform,
)
from msvalidate.studies.lattices.cases import Case

from msvalidate.bench.judging.evidence import all_passed, judge
from msvalidate.bench.judging.sweep import Setting
from msvalidate.problem import Anisotropic, Box, ProblemError, SolverError
from msvalidate.springs import lattice
from msvalidate.springs.constants.directions import directional_modulus
from msvalidate.springs.constants.homogenise import homogenise
from msvalidate.springs.lattice import Pattern, fill, patterns
from msvalidate.springs.lattice.pattern import pattern_by_shells
from msvalidate.studies import lattices

QUICK = Setting(quick=True)


def braced() -> Pattern:
    """Squares with a point in the middle: springs along the sides k1, to the middle k2."""
    points = [(0, 0), (0.5, 0.5)]
    at_sides = pattern_by_shells("braced", (1.0, 1.0), [(0, 0)], (1.0,), {"even": (1.0,)})
    found = pattern_by_shells("braced", (1.0, 1.0), points, (sqrt(0.5), 1.0), {"even": (1.0, 1.0)})
    keep = (found.kind == 0) | (found.springs == 0).all(axis=1)
    assert keep.sum() == 4 + len(at_sides.springs)
    return replace(
        found,
        springs=found.springs[keep],
        image=found.image[keep],
        kind=found.kind[keep],
        factor=found.factor[keep],
    )


def tetragonal() -> Pattern:
    """Cells half as high again as wide."""
    lengths = (1.0, sqrt(2), 1.5, sqrt(3.25))
    return pattern_by_shells(
        "tetragonal", (1.0, 1.0, 1.5), [(0, 0, 0)], lengths, {"even": (1.0,) * 4}
    )


def kagome() -> Pattern:
    """Triangles that share corners: stiff without an end, floppy with one."""
    h = sqrt(3) / 2
    points = [(0, 0), (1, 0), (0.5, h), (1, 2 * h), (0, 2 * h), (1.5, 3 * h)]
    return pattern_by_shells("kagome", (2.0, 4 * h), points, (1.0,), {"even": (1.0,)})


def centred() -> Pattern:
    """Squares, the point in the middle of the cell."""
    return pattern_by_shells(
        "centred", (1.0, 1.0), [(0.5, 0.5)], (1.0, sqrt(2)), {"even": (1.0, 0.5)}
    )


def slender() -> Pattern:
    """A cell so low that springs run over twenty of them."""
    lengths = (0.05, 1.0, sqrt(1 + 0.05**2))
    return pattern_by_shells("slender", (1.0, 0.05), [(0, 0)], lengths, {"even": (1.0,) * 3})


@pytest.fixture
def with_awkward(monkeypatch):
    for make in (tetragonal, kagome, centred, slender):
        monkeypatch.setattr(patterns, make.__name__, make, raising=False)


@pytest.fixture
def with_braced(monkeypatch):
    monkeypatch.setattr(patterns, "braced", braced, raising=False)


# The cases ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("case", "message"),
    [
        (Case("diamond", "equal"), "lattice: 'diamond'; choose from square, "),
        (Case("square", "soft"), "square: rule 'soft'; choose from isotropic, equal, report's 2"),
    ],
)
def test_unknown_cases_are_refused(case, message):
    with pytest.raises(ProblemError, match=message):
        _ = case.constants


def test_the_four_neighbours_shear_freely_and_no_body_is_made_of_them():
    free = [case for case in cases.all_cases() if case not in cases.stiff()]
    assert {case.lattice for case in free} == {"square4", "cubic6"}
    for case in free:
        assert cases.resists_shear(cases.tensor_of(homogenise, case)) == "shears freely"
        with pytest.raises(SolverError, match="shears freely; no body to compare"):
            cases.material(homogenise, case, cases.fill_box(case, 2))


def test_a_solid_without_bulk_gives_way():
    assert cases.resists_shear(np.diag([1.0, 0.0, 1.0])) == "gives way"
    assert cases.resists_shear(np.eye(6)) == "every strain"


@pytest.mark.usefixtures("with_awkward")
def test_bodies_of_high_cells_differ():
    case = Case("tetragonal", "even")
    bodies = [cases.fill_box(case, across) for across in cases.sizes(case, (2, 3, 4))]
    assert [cases.cells_along(body) for body in bodies] == [3, 6, 9]


@pytest.mark.usefixtures("with_awkward")
@pytest.mark.parametrize(
    ("case", "word"),
    [
        (Case("kagome", "even"), "mechanism"),
        (Case("centred", "even"), "no corner point"),
        (Case("slender", "even"), "stands"),
        (Case("tetragonal", "even"), "stands"),
        (Case("square4", "equal"), "no body"),
    ],
)
def test_which_bodies_stand(case, word):
    assert cases.body(homogenise, case) == word


@pytest.mark.usefixtures("with_awkward")
def test_springs_longer_than_a_body_have_no_room():
    pattern = slender()
    few = fill(pattern, Box((2.0, 0.15)), (2, 3))
    assert np.abs(few.vectors[:, 1]).max() == pytest.approx(0.05)
    many = fill(pattern, Box((2.0, 1.5)), (2, 30))
    assert np.abs(many.vectors[:, 1]).max() == pytest.approx(1.0)


def test_only_boxes_of_a_pattern_are_measured_in_cells():
    with pytest.raises(ProblemError, match="no piece of a pattern"):
        cases.cells_along(lattice.diagonal_square(Box((1.0, 1.0)), 2))


# Solids ---------------------------------------------------------------------------------------


def test_isotropy_is_the_same_modulus_everywhere():
    normal = np.random.default_rng(5).normal(size=(50, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    for case in cases.stiff():
        directions = normal if case.pattern.dim == 3 else normal[:, :2]
        directions = directions / np.linalg.norm(directions, axis=1, keepdims=True)
        C = cases.tensor_of(homogenise, case)
        spread = np.ptp(directional_modulus(C, directions)) / C.max()
        assert (spread < 1e-12) == solids.is_isotropic(C), case


def test_energy_knows_what_moving_points_release():
    # A chain across the cell, softer on one side of its middle: 1/(1/1 + 1/3), not the mean.
    series = Pattern(
        name="series",
        size=(1.0, 1.0),
        points=np.array([[0.0, 0.0], [0.5, 0.0]]),
        springs=np.array([[0, 1], [1, 0], [0, 0], [1, 1]]),
        image=np.array([[0, 0], [1, 0], [0, 1], [0, 1]]),
        kind=np.array([0, 1, 2, 2]),
        rules={"uneven": (1.0, 3.0, 1.0)},
    )
    k = series.rules["uneven"]
    assert solids.by_energy(series, k)[0, 0] == pytest.approx(0.75, rel=1e-6)
    assert homogenise(series, k).tensor[0, 0] == pytest.approx(0.75, rel=1e-12)
    assert homogenise(series, k).affine[0, 0] == pytest.approx(1.0, rel=1e-12)


def test_honeycombs_give_way_in_words():
    points = [(0, 0), (0, 1.0), (sqrt(3) / 2, 1.5), (sqrt(3) / 2, 2.5)]
    honeycomb = pattern_by_shells("honeycomb", (sqrt(3), 3.0), points, (1.0,), {"equal": (1.0,)})
    found = homogenise(honeycomb, (1.0,)).tensor
    assert cases.resists_shear(found) == "gives way"
    assert solids.constants(found, "gives way") == (0.0, "none", "none")
    # Its points move until only a change of area costs energy: the bulk modulus k/(2√3).
    bulk = np.array([[1.0, 1, 0], [1, 1, 0], [0, 0, 0]]) / (2 * sqrt(3))
    np.testing.assert_allclose(found, bulk, atol=1e-12)
    # Pulled and sheared it costs that; pushed and sheared it folds, and costs nothing.
    pulled, pushed = (
        solids.least_energy(honeycomb, (1.0,), sign * solids.NUDGE * np.array([1.0, 0, 1]))
        for sign in (1, -1)
    )
    assert pulled == pytest.approx(solids.NUDGE**2 / (4 * sqrt(3)), rel=1e-3)
    assert pushed < 1e-3 * pulled


# Bodies ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("few", "dim", "word"),
    [
        (None, 2, "nowhere"),
        (0, 3, "inside"),
        (1, 2, "sides"),
        (2, 3, "edges"),
        (2, 2, "corners"),
        (3, 3, "corners"),
    ],
)
def test_places_in_words(few, dim, word):
    assert edges.locate_springs(few, dim) == word


def test_a_long_bar_takes_the_work_of_a_free_one():
    # Clamping matters at one end alone: of a bar ten times as long as wide, 1 % at most.
    tensor = Anisotropic(np.array([[1.125, 0.375, 0], [0.375, 1.125, 0], [0, 0, 0.375]])).C
    found = elastic.solve_reference((tensor, Box((10.0, 1.0)), (4, 8, 16)))
    assert found["pull"].work == pytest.approx(1, abs=0.01)
    assert found["shear"].work == pytest.approx(4 * 10**2, rel=0.02)  # L²/h² · 12/3 of a beam


def test_extrapolation_finds_the_limit_of_a_power_and_uncertainties_what_does_not_shrink():
    found = elastic.extrapolate(*(2 + h**1.6 for h in (1, 0.5, 0.25)))
    assert found.work == pytest.approx(2, rel=1e-12)
    assert found.uncertainty == pytest.approx(elastic.TRUST * 0.25**1.6 / 2, rel=1e-9)
    assert elastic.extrapolate(1.0, 1.1, 1.3).uncertainty == pytest.approx(0.6 / 1.3)
    assert elastic.extrapolate(1.0, 1.1, 1.0).work == 1.0


def test_clamped_bodies_of_one_tensor_are_solved_once(monkeypatch):
    solved = []
    monkeypatch.setattr(
        elastic, "solve_reference", lambda body: solved.append(body) or dict.fromkeys(loading.TESTS)
    )
    found = elastic.bodies(homogenise, QUICK)
    assert set(found) == set(cases.stiff())
    assert len(solved) < len(found)


@pytest.mark.parametrize(
    ("gaps", "uncertainty", "found"),
    [
        ((0.04, 0.01), 0.0, 2.0),
        ((0.04, 0.01), 0.004, "not resolved"),
        ((0.04, -0.01), 0.0, "not asymptotic"),
        ((0.01, 0.04), 0.0, "not asymptotic"),
    ],
)
def test_orders_of_two_sizes(gaps, uncertainty, found):
    pair = pd.DataFrame({"difference": gaps, "uncertainty": uncertainty, "spacing": (0.5, 0.25)})
    assert clamped.order(pair) == (found if isinstance(found, str) else pytest.approx(found))


def test_a_line_breaks_where_its_sign_changes():
    found = clamped.of_one_sign(pd.Series([0.3, 0.1, -0.1, -0.2, 0.1], index=range(5, 10)))
    assert [list(part) for part in found] == [[5, 6], [7, 8], [9]]


def test_nothing_to_judge_is_no_pass():
    words = pd.DataFrame({"cell_over": ["none"], "clamped_order": ["not resolved"]})
    assert np.isnan(cases.numbers("cell_over")(words))
    none = pd.DataFrame({"released": [1.0], "omega2_m": 1.0, "omega2_m_theory": ["none"]})
    assert np.isnan(solids._cauchy(none)["released"]).all()
    assert np.isnan(solids._frequency(none)).all()
    assert np.isnan(clamped._away(words.assign(clamped_expected=1.0)))
    orders = pd.DataFrame({"order_expected": ["none"], "order": ["exact"]})
    for rule in uniform.RULES:
        with pytest.raises(SolverError, match="no row of uniform_order"):
            rule.read({"uniform_order": orders})


# Controls and added lattices ------------------------------------------------------------------


def test_a_missing_direction_is_another_tensor():
    full, less = (
        make(patterns.square(), (1.0, 0.5)).tensor
        for make in (homogenise, lattices_controls.solid_with(1.0))
    )
    np.testing.assert_allclose(full - less, np.diag([1.0, 0, 0]), atol=1e-14)


@pytest.mark.usefixtures("with_braced")
def test_an_added_lattice_stands_in_every_table(monkeypatch):
    """One function in `patterns`: nothing else knows its name, and it has no closed form."""
    assert Case("braced", "even") in cases.stiff()
    mine = [Case("braced", "even"), Case("square", "isotropic"), Case("square4", "equal")]
    mine.append(Case("triangular", "equal"))
    monkeypatch.setattr(cases, "all_cases", lambda: mine)  # the others take their time elsewhere
    evidence = lattices.run(
        setting=QUICK, questions=("solids", "uniform", "clamped", "cost", "choice")
    )
    for name, table in evidence.tables.items():
        assert name == "crossing" or "braced" in set(table["lattice"]), name
    row = evidence.tables["lattices"].set_index("lattice").loc["braced"]
    assert (row["E_closed"], row["nu_closed"], row["A_closed"]) == ("none",) * 3
    assert row["E_body"] == pytest.approx(row["E"], rel=1e-9)
    assert all_passed(judge(evidence))
    for draw in evidence.figures.values():
        draw(evidence.tables)


@pytest.mark.usefixtures("with_awkward")
def test_awkward_lattices_are_rows_and_the_others_are_judged(monkeypatch):
    """No body of some, cells that are no cubes of another: the study ends, and holds."""
    names = ("tetragonal", "kagome", "centred")
    mine = [Case("square", "isotropic"), Case("triangular", "equal")]
    mine += [Case(name, "even") for name in names]
    monkeypatch.setattr(cases, "all_cases", lambda: mine)
    evidence = lattices.run(
        setting=QUICK, questions=("solids", "uniform", "clamped", "cost", "choice")
    )
    rows = evidence.tables["lattices"].set_index("lattice")
    assert rows["E_body"]["kagome"] == rows["pull_order"]["kagome"] == "mechanism"
    assert rows["E_body"]["centred"] == rows["rest_steps"]["centred"] == "no corner point"
    assert rows["A"]["tetragonal"] == rows["A_body"]["tetragonal"] == "none"
    assert all_passed(judge(evidence))
    for draw in evidence.figures.values():
        draw(evidence.tables)
