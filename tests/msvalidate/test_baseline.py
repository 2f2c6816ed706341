"""The baseline: what has moved is told, with value, reference, error and limit."""

import io

import numpy as np
import pandas as pd
import pytest

from msvalidate import baseline, stored
from msvalidate.evidence import Evidence

TABLE = pd.DataFrame(
    {
        "name": ["a", "b", "c"],
        "x": [1.0, -2.0, 3e-7],
        "order": [1.5, "not asymptotic", 2.0],
        "n": [1, 2, 3],
        "steps_per_second": [1.0, 2.0, 3.0],
    }
)
MEANING = {c: c for c in TABLE} | {"order": 'power; "not asymptotic" where there is none'}


def text(table):
    return stored.read_csv(io.BytesIO(stored.csv(table.drop(columns="steps_per_second"))))


def failures(table=TABLE, reference=None, rounding=None):
    reference = text(TABLE) if reference is None else reference
    rows = baseline.compare_tables("t", table, reference, rounding or {})
    return {row["quantity"]: row for row in rows if row["verdict"] != "pass"}


def changed(column, row, value):
    table = TABLE.copy()
    table[column] = table[column].astype(object)
    table.loc[row, column] = value
    return table


def test_the_same_table_holds():
    assert failures() == {}
    rows = baseline.compare_tables("t", TABLE, text(TABLE), {})
    assert [row["quantity"] for row in rows] == [
        "t.csv: columns: missing or extra",
        "t.csv: rows",
        *("t.csv: name", "t.csv: x", "t.csv: order", "t.csv: n"),
    ]
    assert {row["layer"] for row in rows} == {"baseline"}


def test_a_moved_number_is_told():
    row = failures(changed("x", 1, -2.00001))["t.csv: x"]
    assert (row["observed"], row["reference"]) == (-2.00001, -2.0)
    assert row["error"] == pytest.approx(1e-5)
    assert row["limit"] == pytest.approx(2e-6, rel=1e-2)
    assert row["because"].startswith("row 1: ")


@pytest.mark.parametrize(
    ("value", "held"), [(-2 - 1.9e-6, True), (-2 - 2.1e-6, False), (-2 + 2.1e-6, False)]
)
def test_the_limit_is_where_it_is_said_to_be(value, held):
    assert (failures(changed("x", 1, value)) == {}) == held


def test_near_zero_the_columns_range_counts():
    assert failures(changed("x", 2, 3e-7 + 2.9e-9)) == {}
    assert "t.csv: x" in failures(changed("x", 2, 3e-7 + 3.5e-9))


def test_rounding_of_a_column():
    spoilt = changed("x", 2, 4e-7)
    assert "t.csv: x" in failures(spoilt)
    assert failures(spoilt, rounding={"x": 2e-7}) == {}


@pytest.mark.parametrize(
    ("column", "row", "value"),
    [
        ("name", 0, "A"),
        ("order", 1, "none"),
        ("order", 1, 1.5),
        ("order", 0, "not asymptotic"),
        ("n", 2, 4),
    ],
)
def test_words_are_exact(column, row, value):
    assert list(failures(changed(column, row, value))) == [f"t.csv: {column}"]


def test_a_word_before_numbers():
    table = TABLE.assign(order=["not asymptotic", 1.5, 2.0])
    assert failures(table, text(table)) == {}


def test_what_depends_on_the_machine_is_left_out():
    assert failures(changed("steps_per_second", 0, 99.0)) == {}


@pytest.mark.parametrize("value", ["nan", "", "inf", "-inf", "NaN"])
def test_no_number_is_never_held(value):
    """Not even where both sides have it."""
    reference = text(TABLE)
    reference.loc[1, "x"] = value
    assert "t.csv: x" in failures(reference=reference)
    both = changed("x", 1, np.nan)
    assert "t.csv: x" in failures(both, reference)


def test_a_missing_row_column_and_nothing_at_all():
    assert list(failures(TABLE.head(2))) == ["t.csv: rows"]
    assert list(failures(TABLE.assign(more=1))) == ["t.csv: columns: missing or extra"]
    found = failures(TABLE.drop(columns="x"))["t.csv: columns: missing or extra"]
    assert found["because"].endswith("missing: x")
    assert "t.csv: rows" in failures(TABLE.head(0), text(TABLE).head(0))


def evidence(tables):
    return Evidence(tables, {}, (), columns=MEANING)


def test_tables_of_a_study(tmp_path):
    for name, content in baseline.files(evidence({"t": TABLE})).items():
        (tmp_path / name).write_bytes(content)
    assert (tmp_path / "t.csv").read_text().startswith("name,x,order,n\n")
    rows = baseline.compare(evidence({"t": TABLE}), tmp_path)
    assert {row["verdict"] for row in rows} == {"pass"}
    first, *_ = baseline.compare(evidence({"t": TABLE, "u": TABLE}), tmp_path)
    assert (first["verdict"], first["because"][-8:]) == ("fail", "extra: u")
    assert baseline.compare(evidence({"t": TABLE}), tmp_path / "none") == []
    (tmp_path / "t.csv").rename(tmp_path / "u.csv")
    assert baseline.compare(evidence({"t": TABLE}), tmp_path)[0]["because"].endswith(
        "missing: u; extra: t"
    )
    (tmp_path / "u.csv").unlink()
    assert baseline.compare(evidence({"t": TABLE}), tmp_path) == [], "nothing to compare with"


@pytest.mark.parametrize(
    ("before", "after"),
    [
        (
            "# C\n\n## Unreleased\n\n### Added\n",
            "### Numbers\n\n- Baseline (quick): so\n\n### Added\n",
        ),
        (
            "## Unreleased\n\n### Numbers\n\n- old\n\n## 1\n",
            "### Numbers\n\n- Baseline (quick): so\n- old\n\n## 1\n",
        ),
        (
            "## Unreleased\n\n## 1\n\n### Numbers\n\n- old\n",
            "### Numbers\n\n- Baseline (quick): so\n\n## 1\n\n### Numbers\n\n- old\n",
        ),
    ],
)
def test_a_line_in_the_changelog(before, after, tmp_path, monkeypatch):
    place = tmp_path / "CHANGELOG.md"
    place.write_text(before, encoding="utf-8")
    monkeypatch.setattr(baseline, "CHANGELOG", place)
    assert baseline.changelog("quick", "so").decode().endswith(f"## Unreleased\n\n{after}")
