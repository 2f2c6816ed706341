"""Tests of the one-page sheets of benchmarks: they show their tables, in words."""

from __future__ import annotations

import pytest
from matplotlib.text import Text
from msvalidate.studies.benchmarks import cases, sheets
from msvalidate.studies.benchmarks.sheet_list import SHEETS


@pytest.fixture(scope="module")
def tables(small_tables):
    return small_tables("benchmarks")


def words_of(figure):
    return [text.get_text() for text in figure.findobj(Text) if text.get_text()]


@pytest.mark.parametrize("name", SHEETS)
def test_a_sheet_names_every_method_of_its_tables_and_no_code(name, tables):
    sheet = SHEETS[name]
    said = words_of(sheets.draw(sheet, tables))
    drawn = [quantity for quantity, *_ in sheet.panels]
    for table in sheet.tables:
        rows = tables[table][tables[table]["quantity"].isin(drawn)]
        for method in set(rows["method"]):
            words, _ = cases.method_look(method)
            assert any(text.startswith(f"{words}: ") for text in said), method
    assert sheet.title in said
    assert not [text for text in said if "_" in text]


def test_a_sheet_tells_the_accepted_value_and_what_was_found_from_its_table(tables):
    row = cases.finest(tables["cook"]).iloc[0]
    moved = tables["cook"].assign(accepted=12.5, value=13.5, against_accepted=0.08)
    said = "\n".join(words_of(sheets.draw(SHEETS["cook"], {"cook": moved})))
    assert "accepted 12.5 m; errors against the limit, 23.968 m" in said.replace("\n", " ")
    assert "elements, linear (Q1): 13.5 m (+8 %)" in said
    assert f"{row['value']:.5g} m" not in said
