"""The tables of all studies as one whole, for studies that put together what others found.

A table is taken from this run, else from a folder of results, else from the committed baseline; it
is the same table of text and numbers wherever it comes from.
"""

from __future__ import annotations

import contextlib
import io
import math
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path

import pandas as pd

from msvalidate.bench.judging.evidence import Tables
from msvalidate.bench.output.baseline import baseline_folder
from msvalidate.bench.output.stored import csv_bytes, read_csv, read_result
from msvalidate.problem import ProblemError
from msvalidate.problem.checks import require_type
from msvalidate.problem.records import dataclass, field

THIS_RUN, STORED, BASELINE = "this run", "stored results", "committed baseline"
FULL = "full"


@dataclass(frozen=True)
class Results:
    """Results of the studies: from this run, from files, or from the baseline.

    The studies in `run` have just run.

    `run` is study -> its tables; a `folder` of stored results may be None, and those of the other
    form than "quick" or "full", that of the baseline, count as none.
    """

    form: str
    run: Mapping[str, Tables] = field(default_factory=dict)
    folder: Path | None = None

    def table(self, study: str, name: str) -> pd.DataFrame:
        """A table; values that are numbers are floats, others text.

        Columns of times are not in the committed baseline; see `evidence.UNGATED`.

        Raises `ProblemError` if no study left such a table.
        """
        source = self.source(study)
        if source == THIS_RUN:
            found = self.run[study].get(name)
            text = None if found is None else read_csv(io.BytesIO(csv_bytes(found)))
        elif source == STORED:
            text = self._stored[study].get(name)
        else:
            path = baseline_folder(self.form) / study / f"{name}.csv"
            text = read_csv(path) if path.is_file() else None
        if text is None:
            raise ProblemError(f"{source}: no table {study}/{name}; run {study} again")
        return read_numbers(text)

    def in_full_mode(self) -> Results:
        """Results that a headline quotes: these if of full mode, else the committed baseline."""
        return self if self.form == FULL else Results(FULL)

    def source(self, study: str) -> str:
        """Origin of a study's tables: `THIS_RUN`, `STORED` or `BASELINE`."""
        if study in self.run:
            return THIS_RUN
        return STORED if study in self._stored else BASELINE

    @cached_property
    def _stored(self) -> dict[str, Tables]:
        """Study -> its tables, of those that left whole results of this form in the folder."""
        if self.folder is None or not self.folder.is_dir():
            return {}
        found = {}
        for place in self.folder.iterdir():
            with contextlib.suppress(ProblemError):
                result = read_result(place)
                # Results of old do not say their form. What a candidate gave, or a part of the
                # questions, is not what the study found.
                partial = {"candidate", "questions"} & set(result.origin)
                if (
                    not (result.error or partial)
                    and result.origin.get("form", self.form) == self.form
                ):
                    found[place.name] = result.tables
        return found


def check_results(candidate: Results | None, *, quick: bool) -> Results:
    """The candidate of a study that reads results; None is the committed baseline of its form.

    Raises `ProblemError` if it is neither.
    """
    if candidate is None:
        return Results("quick" if quick else "full")
    require_type("candidate", candidate, Results)
    return candidate


def read_numbers(table: pd.DataFrame) -> pd.DataFrame:
    """A table of text whose columns of numbers are floats; in others each number is one."""
    return pd.DataFrame({column: _numbers(list(table[column])) for column in table})


def _numbers(values: list[str]) -> pd.Series:
    found = [_number(value) for value in values]
    mixed = any(isinstance(value, str) for value in found)
    return pd.Series(found, dtype=object if mixed else float)


def _number(text: str) -> float | str:
    with contextlib.suppress(ValueError):
        if math.isfinite(value := float(text)):
            return value
    return text
