"""The study `overview`: labels are of what ran, and say a number where they claim one."""

import math
from dataclasses import replace
from functools import partial

import pandas as pd
import pytest
from msvalidate.studies.benchmarks import cases, cook
from msvalidate.studies.overview import good_for, models, ordinary, part

from msvalidate.judging.candidate import solve_springs
from msvalidate.output import front
from msvalidate.output.results import Results
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
    told = good_for.of_part(made)(pd.DataFrame([found]))
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
    assert row["condition"].endswith(f"rule {rule}: 50 %")
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
