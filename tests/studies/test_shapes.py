"""Shapes of the displacement study: numbers of known fields, words that follow them, pictures."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from msvalidate.studies.displacement import claims, load_cases, shapes
from msvalidate.studies.displacement.load_cases import CASES
from msvalidate.studies.displacement.measuring import Block, Measurement

from msvalidate.bench.judging.evidence import all_passed, judge
from msvalidate.problem import SolverError

FINER = 10
BULGE = 0.004
SINK = 0.02


def field(case, points):
    """A displacement (m) of which every statement of the report holds, and by how much."""
    x, y = points.T
    if case == "shear":
        return np.column_stack([0.01 * (0.5 - y) * x, 0.02 * (1 - x)])
    if case == "bending":
        return np.column_stack([0 * x, -SINK * (1 - np.cos(2 * np.pi * x / 5)) / 2])
    return np.column_stack([-0.01 * x, BULGE * y])


def points_of(case, fineness=shapes.FINENESS):
    return load_cases.body("square", case, fineness).grid().points


def asked(springs=1.0, homogenised=1.0, target=1.0):
    """Springs and bodies that move by multiples of the known fields."""
    measured, bodies = {}, {}
    for case in CASES:
        grids = {n: points_of(case, n) for n in (shapes.FINENESS, FINER)}
        solids = [
            SimpleNamespace(at_points={n: factor * field(case, at) for n, at in grids.items()})
            for factor in (homogenised, target)
        ]
        points = grids[shapes.FINENESS]
        for model in shapes.SQUARE:
            moves = {shapes.SETTING: springs * field(case, points)}
            measured[Block(case, model, shapes.FINENESS)] = Measurement(points, moves)
            bodies |= {(case, model, n): tuple(solids) for n in grids}
    return measured, bodies


@pytest.fixture(scope="module")
def evidence():
    return shapes.run(*asked())


def judgements(found, figure):
    table = found.tables["statements"]
    return set(table[table["figure"] == figure]["judgement"])


def test_same_shapes_pass(evidence):
    assert all_passed(judge(evidence))
    assert all(judgements(evidence, figure) == {"holds"} for figure in (4, 5, 6))


def test_numbers_of_known_fields(evidence):
    table = evidence.tables["statements"]
    rows = table[table["k2"] == shapes.DRAWN.k[1]]
    height, middle, loaded, *widths, slightly = rows[rows["figure"] == 4]["in_springs"]
    assert [height, middle, loaded] == pytest.approx([BULGE] * 3, abs=1e-15)
    assert widths == pytest.approx([-0.01] * 3, abs=1e-15)
    assert slightly == pytest.approx(0.4)
    assert list(rows[rows["figure"] == 6]["in_springs"]) == pytest.approx([-0.005, 0.005])
    bent = rows[rows["figure"] == 7].set_index("statement")
    assert bent.loc["sine-like: a whole wave, 1 - cos", "in_springs"] < 1e-14
    assert bent.loc["sine-like: half a wave", "judgement"] == "does not hold"


@pytest.mark.parametrize(
    ("factors", "words"),
    [
        ((-1, 1, 1), "holds of homogenised body and target only"),
        ((1, -1, -1), "holds of springs only"),
        ((1, 1, -1), "holds of springs and homogenised body only"),
        ((-1, -1, -1), "does not hold"),
    ],
)
def test_signs_flip_the_words(factors, words):
    assert judgements(shapes.run(*asked(*factors)), 6) == {words}


def test_a_swelling_of_another_size_is_judged():
    measured, bodies = asked()
    for block, seen in measured.items():
        if block.case == "pressure":
            seen.moves[shapes.SETTING][:, 1] *= 1.25  # Poisson's ratio 0.5, not 0.4
    failed = judge(shapes.run(measured, bodies)).query("verdict == 'fail'")["quantity"]
    assert list(failed) == ["Figures 4 and 5: swelling over shrinking, springs against FEM"]


def test_another_deflection_line_is_judged():
    """A bar free to turn at its ends sinks by half a wave."""
    measured, bodies = asked()
    for block, seen in measured.items():
        if block.case == "bending":
            move = seen.moves[shapes.SETTING]
            move[:, 1] = -SINK * np.sin(np.pi * seen.points[:, 0] / 5)
    found = shapes.run(measured, bodies)
    failed = judge(found).query("verdict == 'fail'")["quantity"]
    assert list(failed) == ["Figure 7: deflection line over its height, springs - FEM, rms"]
    half, wave, *_ = found.tables["statements"].query("figure == 7")["judgement"]
    assert (half, wave) == ("holds of springs only", "holds of homogenised body and target only")


def test_a_body_that_does_not_move_is_no_result():
    with pytest.raises(SolverError), np.errstate(invalid="ignore", divide="ignore"):
        shapes.run(*asked(springs=0.0))


@pytest.mark.parametrize("curve", claims.CURVES)
def test_a_curve_fits_itself_and_no_other(curve):
    x = np.linspace(0, 5, 26)
    line = -0.3 * sum(claims.CURVES[curve](x / 5))
    missed = {name: claims.misfit(x, line, name) for name in claims.CURVES}
    assert missed.pop(curve) < 1e-14
    missed.pop("fit_shear_beam", None)  # holds the clamped beam as a part
    assert min(missed.values()) > 1e-3


def test_misfit_by_hand():
    """A whole wave against the constant part and sum of squares of half a wave, on even places."""
    x = np.arange(1, 8) / 8  # the ends add nothing to either sum, but count in the mean
    x = np.concatenate([[0.0], x, [1.0]])
    half, wave = np.sin(np.pi * x), np.sin(np.pi * x) ** 2
    factor = (half @ wave) / (half @ half)
    by_hand = np.sqrt(((wave - factor * half) ** 2).mean())
    assert claims.misfit(x, wave, "fit_half_wave") == pytest.approx(by_hand, rel=1e-12)


def test_clamped_beam_is_a_clamped_beam():
    """No slope at the ends and in the middle, constant shear force up to the middle."""
    xi = np.linspace(0, 1, 2001)
    w = claims.clamped_beam(xi)
    slope = np.gradient(w, xi, edge_order=2)
    assert slope[[0, 1000, 2000]] == pytest.approx(0, abs=1e-4)
    assert w[1000] == 1.0
    assert w == pytest.approx(w[::-1], abs=1e-14)
    assert np.diff(w[:1001], 4) == pytest.approx(0, abs=1e-13)


@pytest.mark.parametrize("case", CASES)
def test_outline_goes_round_once(evidence, case):
    table = evidence.tables["outline"]
    rings = table[table["case"] == case].groupby("source")
    assert len(rings) == 2
    width = 5.0 if case == "bending" else 1.0
    for _, ring in rings:
        at = ring[["x", "y"]].to_numpy()
        steps = np.roll(at, -1, axis=0) - at
        assert np.abs(steps).sum(axis=1) == pytest.approx(1 / FINER), "the finest grid, no jumps"
        assert len(np.unique(np.round(at, 9), axis=0)) == len(at) == 2 * (width + 1) * FINER
        x, y = at.T
        area = (x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2
        assert area == pytest.approx(width), "counter-clockwise, once"
        assert ring[["ux", "uy"]].to_numpy() == pytest.approx(field(case, at), abs=1e-15)


def test_findings_follow_the_table(evidence):
    pressed, _, sheared, bent = evidence.findings
    slightly = '"swells slightly: less than half of what it shrinks" holds'
    assert f"{slightly} (mean swelling over mean shrinking: 0.400 in the springs" in pressed
    assert "-5.00 mm in the springs" in sheared
    assert '"sine-like: half a wave" does not hold' in bent
    reversed_shear = shapes.run(*asked(springs=-1.0)).findings[2]
    assert '"upper edge is compressed" holds of homogenised body and target only' in reversed_shear


def test_figure_numbers_are_fields_of_the_load_cases(monkeypatch):
    others = {**CASES, "bending": replace(CASES["bending"], figure=9)}
    monkeypatch.setattr(shapes, "CASES", dict(reversed(others.items())))
    table = shapes.run(*asked()).tables["statements"]
    assert (table["figure"] == 9).sum() == 2 * len(claims.CLAIMS["bending"])
