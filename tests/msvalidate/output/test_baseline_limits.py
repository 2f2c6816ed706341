"""Which value of a column is judged, and what a baseline that cannot be read says."""

import io

import pandas as pd
import pytest

from msvalidate.judging.evidence import Evidence
from msvalidate.output import baseline, stored

LARGE_AND_SMALL = pd.DataFrame({"x": [1e6, 0.5, 1.0]})


def row_of(table, quantity):
    reference = stored.read_csv(io.BytesIO(stored.csv_bytes(LARGE_AND_SMALL)))
    rows = baseline.compare_tables("t", table, reference, {})
    return {row["quantity"]: row for row in rows}[quantity]


def test_the_value_farthest_off_for_its_own_limit_is_judged():
    # 1e6 may move by 1, 1 by a thousandth (1e-9 of the range): the small one is wrong.
    moved = LARGE_AND_SMALL + pd.DataFrame({"x": [0.1, 0.0, 0.01]})
    row = row_of(moved, "t.csv: x")
    assert row["verdict"] == "fail"
    assert row["reference"] == 1.0
    assert row["error"] == pytest.approx(0.01)
    assert row["limit"] == pytest.approx(1e-9 * (1e6 - 0.5) + 1e-6)
    within = row_of(LARGE_AND_SMALL + pd.DataFrame({"x": [0.1, 0.0, 9e-4]}), "t.csv: x")
    assert within["verdict"] == "pass"


def test_a_baseline_that_cannot_be_read_fails_by_its_name(tmp_path):
    (tmp_path / "t.csv").write_text("x\n1\n1,2,3\n")
    (tmp_path / "u.csv").write_bytes(stored.csv_bytes(LARGE_AND_SMALL))
    tables = {"t": LARGE_AND_SMALL, "u": LARGE_AND_SMALL}
    rows = baseline.compare(Evidence(tables, {}, (), columns={"x": "a number"}), tmp_path)
    verdicts = {row["quantity"]: row["verdict"] for row in rows}
    assert verdicts["t.csv"] == "fail", "it cannot be read"
    assert verdicts["u.csv: x"] == "pass", "the others are still compared"
