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
    controls,
    cost,
    edges,
    elastic,
    loading,
    solids,
    uniform,
)
from msvalidate.studies.lattices.cases import Case

from msvalidate import lattice
from msvalidate.constants.directions import directional_modulus
from msvalidate.constants.homogenise import homogenise
from msvalidate.judging.candidate import solve_springs
from msvalidate.judging.evidence import all_passed, judge
from msvalidate.judging.singularity import clamped_free_exponent
from msvalidate.judging.sweep import Setting
from msvalidate.lattice import Pattern, fill, patterns
from msvalidate.lattice.pattern import pattern_by_shells
from msvalidate.problem import Anisotropic, Box, ProblemError, SolverError
from msvalidate.studies import lattices

QUICK = Setting(quick=True)
EXACT = [
    ("square", "isotropic"),
    ("square", "equal"),
    ("cubic18", "isotropic"),
    ("cubic18", "report's 2 k1"),
    ("fcc", "nearest only"),
]
CROSSING = [("triangular", "equal"), ("bcc", "isotropic"), ("bcc", "equal"), ("fcc", "isotropic")]


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


@pytest.fixture(scope="module")
def solid_tables():
    return solids.solid_tables(homogenise, QUICK)


# The cases ------------------------------------------------------------------------------------


def test_every_lattice_and_rule_is_a_case():
    assert {(c.lattice, c.rule) for c in cases.all_cases()} == {
        (name, rule) for name, make in patterns.all_patterns().items() for rule in make().rules
    }


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


@pytest.mark.parametrize(
    ("size", "cells"),
    [((1.0, 1.0), (1, 1)), ((1.0, sqrt(3)), (2, 1)), ((1.0, 2.0, 1.0), (2, 1, 2))],
)
def test_boxes_are_nearly_cubes(size, cells):
    assert cases.proportions(size) == cells


def test_sizes_of_a_base_are_all_different_and_others_are_those_wanted():
    # 3 x 3 x 2 cells are the least that make a cube of cells 1 x 1 x 1.5.
    assert cases.proportions((1.0, 1.0, 1.5)) == (3, 3, 2)
    assert cases.sizes(Case("cubic18", "isotropic"), (2, 3, 4, 6)) == [2, 3, 4, 6]
    assert cases.sizes(Case("triangular", "equal"), (8, 16, 32)) == [8, 16, 32]


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


def test_24_cases_are_drawn_in_24_ways():
    ways = {tuple(map(str, cases.style(number).values())) for number in range(24)}
    lines = {(s["color"], str(s["linestyle"])) for s in map(cases.style, range(24))}
    markers = {(s["color"], s["marker"]) for s in map(cases.style, range(24))}
    assert len(ways) == len(lines) == len(markers) == 24


@pytest.mark.usefixtures("with_awkward")
def test_only_square_and_cubic_tensors_have_a_ratio_of_zener():
    for case, ratio in ((Case("tetragonal", "even"), False), (Case("fcc", "nearest only"), True)):
        C = cases.tensor_of(homogenise, case)
        assert solids.is_cubic(C) == ratio
        assert (solids.constants(C, "every strain")[2] != "none") == ratio


def test_boxes_are_filled_to_a_length_of_1_m():
    box = cases.box_of(cases.fill_box(Case("triangular", "equal"), 8))
    assert box.size == pytest.approx((1.0, 4 * sqrt(3) / 8))
    assert cases.cells_along(cases.fill_box(Case("triangular", "equal"), 8)) == 8


def test_only_boxes_of_a_pattern_are_measured_in_cells():
    with pytest.raises(ProblemError, match="no piece of a pattern"):
        cases.cells_along(lattice.diagonal_square(Box((1.0, 1.0)), 2))


# Solids ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("case", "E", "nu", "zener"),
    [
        (Case("square", "isotropic"), 4 / 3, 1 / 3, 1),
        (Case("triangular", "equal"), 2 / sqrt(3), 1 / 3, 1),
        (Case("cubic18", "isotropic"), 2.5, 1 / 4, 1),
        (Case("cubic26", "equal"), 2.7, 0.35, 7 / 3),
        (Case("fcc", "nearest only"), 4 / 3, 1 / 3, 2),
        (Case("bcc", "isotropic"), 5 / 3, 1 / 4, 1),
    ],
)
def test_known_constants(solid_tables, case, E, nu, zener):
    rows = solid_tables["solids"]
    row = rows[(rows["lattice"] == case.pattern.name) & (rows["rule"] == case.rule)].iloc[0]
    assert (row["E"], row["nu"], row["A"]) == pytest.approx((E, nu, zener), rel=1e-12)
    assert row["isotropic"] == ("yes" if zener == 1 else "no")


def test_free_shears_are_rows_with_words_not_failures(solid_tables):
    rows = solid_tables["solids"].set_index("lattice").loc[["square 4", "cubic 6"]]
    assert (rows["strains"] == "shears freely").all()
    assert (rows["A"] == 0).all()
    assert (rows["floppy"] > 0).all()


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


@pytest.mark.parametrize(("name", "rule"), [*EXACT, *CROSSING, ("cubic26", "equal")])
def test_which_springs_cross(name, rule):
    assert edges.crosses(Case(name, rule)) == ((name, rule) in CROSSING)


@pytest.mark.parametrize(("name", "rule"), EXACT)
def test_exact_bodies_are_told_from_the_pattern_and_are(name, rule):
    case = Case(name, rule)
    for test in loading.TESTS:
        assert edges.unbalanced_force(case, homogenise, test) is None
    row = uniform.measure(solve_springs, homogenise, (case, 2))
    for error in ("pull_error", "across_error", "shear_error"):
        assert abs(row[error]) < 1e-12


@pytest.mark.parametrize(("name", "rule"), CROSSING)
def test_bodies_that_lost_springs_are_too_soft_at_first_order(name, rule):
    case = Case(name, rule)
    assert edges.unbalanced_force(case, homogenise, "pull") == 1
    first, second = (
        uniform.measure(solve_springs, homogenise, (case, n))["pull_error"] for n in (4, 8)
    )
    assert 0 < second < first
    assert np.log2(first / second) == pytest.approx(1, abs=0.2)


def test_corners_of_cubes_with_space_diagonals_cost_third_order():
    case = Case("cubic26", "equal")
    assert edges.unbalanced_force(case, homogenise, "pull") is None
    assert edges.unbalanced_force(case, homogenise, "shear") == 3
    errors = [uniform.measure(solve_springs, homogenise, (case, n))["shear_error"] for n in (3, 6)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(3, abs=0.2)


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


def test_no_weights_balance_a_centre_whose_neighbour_is_cut_off():
    assert edges.unbalanced_rest(Case("bcc", "isotropic")) > 0.5
    assert edges.unbalanced_rest(Case("triangular", "equal")) > 0.5
    # Shared weights balance a lattice of like cells: nothing is left.
    assert edges.unbalanced_rest(Case("square", "equal")) < 1e-9


@pytest.mark.parametrize(("name", "rule"), CROSSING)
def test_rewired_lattices_are_the_same_solid(name, rule):
    case = Case(name, rule)
    pattern = edges.rewire_edges(case)
    assert not (edges.crossing(pattern) & (pattern.stiffness(case.constants) > 0)).any()
    np.testing.assert_allclose(
        homogenise(pattern, case.constants).affine,
        cases.tensor_of(homogenise, case),
        atol=1e-12,
    )
    assert edges.rewired_error(case) == (
        "mechanism" if name == "triangular" else pytest.approx(0, abs=1e-12)
    )


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


def test_clamped_lattices_come_nearer_to_the_elastic_body():
    case = Case("square", "isotropic")
    tensor = cases.tensor_of(homogenise, case)
    box = cases.box_of(cases.fill_box(case, 8))
    body = elastic.solve_reference((tensor / loading.modulus(tensor), box, (4, 8, 16)))["shear"]
    away = [
        abs(clamped.lattice_work(solve_springs, homogenise, (case, "shear", n)) / body.work - 1)
        for n in (8, 16)
    ]
    order = 2 * clamped_free_exponent(tensor, np.pi / 2)
    assert np.log2(away[0] / away[1]) == pytest.approx(order, abs=0.2)


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


def test_what_crossing_springs_are_to_blame_for_is_not_said_where_points_move():
    case = Case("honeycomb", "equal")
    assert edges.crosses(case)
    assert cases.support_releases(homogenise, case)
    assert edges.rebuild_lattice(case)["left_over"] == "none"
    assert not cases.support_releases(homogenise, Case("triangular", "equal"))


def test_steps_are_those_of_the_slowest_mode():
    row = cost.measure(homogenise, (Case("square", "isotropic"), 6.0))
    assert row["steps"] == pytest.approx(row["steps_predicted"], rel=0.05)
    assert 1 < row["highest_over"] < row["cell_over"]


# Controls and added lattices ------------------------------------------------------------------


def test_a_missing_direction_is_another_tensor():
    full, less = (
        make(patterns.square(), (1.0, 0.5)).tensor
        for make in (homogenise, controls.solid_with(1.0))
    )
    np.testing.assert_allclose(full - less, np.diag([1.0, 0, 0]), atol=1e-14)


@pytest.mark.parametrize("fault", lattices.FAULTS)
def test_faults_name_their_questions(fault):
    assert set(lattices.FAULTS[fault]) <= {"candidate", "solid", "questions"}
    assert lattices.FAULTS[fault]["questions"]


@pytest.mark.usefixtures("with_braced")
def test_an_added_lattice_stands_in_every_table(monkeypatch):
    """One function in `patterns`: nothing else knows its name, and it has no closed form."""
    mine = [Case("braced", "even"), Case("square", "isotropic"), Case("square4", "equal")]
    mine.append(Case("triangular", "equal"))
    monkeypatch.setattr(cases, "all_cases", lambda: mine)  # the others take their time elsewhere
    assert "braced" in patterns.all_patterns()
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


@pytest.mark.usefixtures("with_braced")
def test_an_added_lattice_is_found_without_being_named():
    assert Case("braced", "even") in cases.all_cases()
    assert Case("braced", "even") in cases.stiff()


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
