"""Many rows in one test: a table of refusals costs one test, and its failure names every row."""

from __future__ import annotations

import inspect
import re
import tomllib
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import pytest

from msvalidate.problem import ProblemError


def table(
    names: str | Sequence[str], rows: Iterable[Any], ids: Sequence[str] | None = None
) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """As `pytest.mark.parametrize`, but one test over all rows that ends with a list of what fails.

    For rows that take no time and leave nothing behind: all of them meet the same fixtures.
    """
    columns = [name.strip() for name in names.split(",")] if isinstance(names, str) else [*names]
    single = isinstance(names, str) and len(columns) == 1
    rows = list(rows)
    given = [(row,) if single else tuple(row) for row in rows]
    labels = ids or [str(number) for number in range(len(given))]
    assert given
    assert not any(hasattr(row, "marks") for row in rows), "a row has no marks"
    assert len(labels) == len(given)

    def over(test: Callable[..., None]) -> Callable[..., None]:
        def every(**fixtures: Any) -> None:
            missed = []
            for label, row in zip(labels, given, strict=True):
                try:
                    test(**fixtures, **dict(zip(columns, row, strict=True)))
                except (Exception, pytest.fail.Exception) as error:  # noqa: BLE001  told below
                    shown = ", ".join(map(repr, row))[:200]
                    missed.append(f"row {label} ({shown}): {type(error).__name__}: {error}")
            if missed:
                pytest.fail(f"{len(missed)} of {len(given)} rows\n" + "\n".join(missed))

        signature = inspect.signature(test)
        left = [value for name, value in signature.parameters.items() if name not in columns]
        every.__signature__ = signature.replace(parameters=left)  # type: ignore[attr-defined]
        every.__name__, every.__doc__, every.__module__ = (
            test.__name__,
            test.__doc__,
            test.__module__,
        )
        every.pytestmark = getattr(test, "pytestmark", [])  # type: ignore[attr-defined]
        return every

    return over


def stored_rows(name: str) -> Any:
    """Rows of a file of test data, tests/data/tables/NAME.toml."""
    path = Path(__file__).parent / "data" / "tables" / f"{name}.toml"
    return tomllib.loads(path.read_text("utf-8"))["rows"]


def refused(message: str) -> pytest.RaisesExc[ProblemError]:
    """As `pytest.raises` of bad input whose line has this message in it."""
    return pytest.raises(ProblemError, match=re.escape(message))


def undated(reasons):
    """Lines of a file of reasons without their dates and commits."""
    return re.sub(r"(?m)^- \d{4}-\d\d-\d\d(, commit \w+)?: ", "- ", reasons)
