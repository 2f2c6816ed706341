"""A table of rows in one test."""

import inspect

import pytest

from tests.table import table


def test_every_row_that_fails_is_told_and_the_others_are_not():
    @table(("x", "y"), [(1, 1), (2, 3), (4, 4), (5, 6)])
    def same(x, y, unit):
        assert unit * x == unit * y

    assert list(inspect.signature(same).parameters) == ["unit"]
    with pytest.raises(pytest.fail.Exception) as told:
        same(unit=1)
    lines = str(told.value).splitlines()
    assert lines[0] == "2 of 4 rows"
    assert [line for line in lines if line.startswith("row ")] == [
        line for line in lines if line.startswith(("row 1 (2, 3): ", "row 3 (5, 6): "))
    ]


def test_a_row_that_is_not_refused_is_a_row_that_fails():
    @table("text", ["1", "word"])
    def refused(text):
        with pytest.raises(ValueError, match="invalid literal"):
            int(text)

    with pytest.raises(pytest.fail.Exception, match=r"1 of 2 rows\nrow 0 .* DID NOT RAISE"):
        refused()
