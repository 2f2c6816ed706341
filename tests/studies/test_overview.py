"""The study `overview`: labels are of what ran, and say a number where they claim one."""

import math
from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd
import pytest
from msvalidate.studies.benchmarks import cases, cook
from msvalidate.studies.overview import good_for, models, ordinary, part

from msvalidate.bench.judging.candidate import solve_springs
from msvalidate.bench.output import front
from msvalidate.bench.output.results import Results
from tests.table import table

LIMIT = cases.Quantity("Cook's membrane", "u_y", "m", 24.0, "by hand", 1 / 3)
ROWS = {question.table: question for question in good_for.QUESTIONS}


@table(
    "made, said",
    [
        (models.REPORT, "square, k2/k1 = 2, whole boundary springs"),
        (replace(models.REPORT, weights="shared"),
         "square, k2/k1 = 2, half boundary springs"),
        (replace(models.REPORT, constants=(2.0, 3.0), weights="per_cell"),
         "square, k2/k1 = 1.5, weights 'per_cell'"),
        (models.VOLUME, "square, k2/k1 = 0.5, volume energy, half boundary springs"),
        (models.Random("jittered", "1/L"), "jittered, springs as 1/L"),
    ],
)  # fmt: skip
def test_springs_are_labelled_by_what_they_are_made_with(made, said):
    assert str(made) == said
    found = part.measure(
        str(made), partial(part.solve_springs, solve_springs, made.network), 4,
        part.reference(quick=True), 1,
    )  # fmt: skip
    told = good_for.of_part(pd.DataFrame([found]))
    assert told["springs"].to_list() == [said]


@pytest.mark.parametrize("rule", ["area", "equilateral"])
def test_another_rule_another_label(rule):
    """What ran by another rule is told so on the first screen."""
    asked = "triangle", cook.RISING, rule
    method = cook.edge_method(*asked)
    ran = pd.DataFrame(cases.rows(LIMIT, method, (4, 8), (30.0, 36.0)))
    results = Results("quick", {"benchmarks": {"cook_edges": ran}})
    row = good_for.row(ROWS["cook_edges"], results, {})
    assert row["springs"] == f"springs on edges of triangles, rising diagonals, rule {rule}"
    assert front._line({name: str(value) for name, value in row.items()}).springs == row["springs"]


@table("form", ["quick", "full"])
def test_the_committed_rows_are_made_of_the_committed_tables(form):
    committed = Results(form)
    own = {name: committed.table("overview", name) for name in ("part", "part_orders", "ordinary")}
    made = Results(form, {"overview": good_for.run(committed, own).tables})
    made, kept = (each.table("overview", "good_for") for each in (made, committed))
    pd.testing.assert_frame_equal(made[list(kept)], kept, rtol=1e-6, atol=1e-7)


@pytest.mark.parametrize("lattice", ["square, cut", "triangular, cut"])
def test_another_lattice_another_label(lattice):
    row = {"lattice": lattice, "cells_across": 8, "difference": 0.4, "uncertainty": 0.1}
    told = ROWS["ordinary"].told(pd.DataFrame([{"body": ordinary.BRACKET.body, **row}]))
    assert told["springs"].to_list() == [f"{lattice} to the outline"]


def test_the_plate_has_its_area_and_its_bolts_hole():
    body = ordinary.plate()
    holes = sum(math.pi * radius**2 for *_, radius in ordinary.HOLES)  # of arcs, nearly
    assert body.volume == pytest.approx((ordinary.LENGTH * ordinary.HEIGHT - holes) * 1e-6, 1e-5)
    *centre, radius = ordinary.HOLES[0]
    rim = body.points[body.boundaries["bolt"][:, 0]] / ordinary.MM - centre
    assert [math.hypot(*place) for place in rim] == pytest.approx([radius] * ordinary.ROUND)


SPRING_COLUMN = {
    "part": "model", "bending": "model", "griffith": "lattice", "rubber": "model",
    "solid": "lattice", "cook": "method", "ordinary": "lattice", "cook_edges": "method",
}  # fmt: skip
"""Column of the springs in each table of several; what names an element or a law is none."""
NO_SPRINGS = r"elements|FEM|^[PQTH]1$|Venant|energy$|linear elasticity"


@pytest.mark.parametrize("question", good_for.QUESTIONS, ids=lambda each: each.body)
@pytest.mark.parametrize("seed", range(3))
def test_a_row_is_of_the_best_springs_of_its_body_or_names_them(question, seed):
    """Errors of all springs of the body's table are multiplied at random."""
    committed, rng = Results("full"), np.random.default_rng(seed)
    table = committed.table(question.study, question.table)
    told = question.told(table)
    if column := SPRING_COLUMN.get(question.table):
        mine = table[table["body"] == question.body] if "body" in table else table
        if question.table == "rubber":
            mine = mine[(mine["state"] == "plane_strain") & (mine["nu_rubber"] == 0.4999)]
        words = mine[column].drop_duplicates()
        names = words[~words.str.contains(NO_SPRINGS)]
        assert told["springs"].nunique() == len(names), "a kind of springs is left out"
    factor = {name: rng.uniform(0.01, 100) for name in told["springs"].unique()}
    told = told.assign(error=told["error"] * told["springs"].map(factor))
    own = {name: committed.table("overview", name) for name in ("part", "ordinary")}
    row = good_for.row(replace(question, told=lambda _: told, condition="so"), committed, own)
    last = {name: good_for.finest(line) for name, line in good_for.lines_of(told).items()}
    best = min(last, key=last.get)
    assert row["springs"] == best or f"{best}: {good_for.percent(last[best])}" in row["condition"]
    assert row["error_fine"] == (max if question.worst else min)(last.values())
