"""JSON, JUnit and baseline output, with the same options in every command that judges."""

from __future__ import annotations

import argparse
import json
import math
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pandas as pd

from msvalidate.bench.judging.evidence import is_missed
from msvalidate.bench.output import baseline, junit, report
from msvalidate.cli.arguments import HELD, MISSED
from msvalidate.cli.terminal import print_lines, tell, tell_error
from msvalidate.problem import ProblemError, SolverError
from msvalidate.problem.records import dataclass, field, replace
from msvalidate_check import exchange

CASES, SIMULATORS = "case", "simulator"
"""Subfolders of a baseline, beside "quick" and "full" of studies."""


@dataclass(frozen=True, eq=False)
class Judged:
    """A judged case, field or simulator.

    Parameters
    ----------
    name
        Name of its test suite and of its folder in a baseline.
    verdict
        One row per judged quantity, with the columns of `junit.failure_line`.
    record
        Complete result, as JSON holds it.
    tables
        Name -> table that a baseline stores.
    rounding
        Column -> absolute tolerance of a baseline, in the unit of the column.
    seconds
        Duration, s.
    error
        Reason why there is no result, or "".
    """

    name: str
    verdict: pd.DataFrame
    record: Any
    tables: Mapping[str, pd.DataFrame] = field(default_factory=dict)
    rounding: Mapping[str, float] = field(default_factory=dict)
    seconds: float = 0.0
    error: str = ""


def unfinished(name: str, message: str) -> Judged:
    """Return the record of a case or simulator without a result."""
    return Judged(name, pd.DataFrame(), {"name": name, "error": message}, error=message)


def row(
    layer: str, quantity: str, verdict: str, because: str = "", **numbers: Any
) -> dict[str, Any]:
    """Return a row of a verdict, with NaN for missing numbers and unit 1."""
    columns = dict.fromkeys(("observed", "reference", "error", "limit"), math.nan)
    named = {"layer": layer, "quantity": quantity, "verdict": verdict, "because": because}
    return named | columns | {"unit": "1"} | numbers


def refuse_outputs(args: argparse.Namespace, form: str) -> None:
    """Check the places of JUnit file and baseline before any work.

    Raises
    ------
    ProblemError
        If a place is not writable, there is no baseline of this form to compare with, or the file
        of reasons cannot be read.
    """
    results = args.out or Path(os.devnull)
    if args.junit:
        report.refuse_place("--junit", args.junit, results)
    if args.baseline:
        report.refuse_folder("--baseline", args.baseline, results, written=args.update)
        baseline.check_home(args.baseline)
        if not (args.update or baseline.baseline_folder(form, args.baseline).is_dir()):
            raise ProblemError(
                f"--baseline {args.baseline}: no {form} baseline in it; make one by adding "
                '--update --reason "first"'
            )
    if args.update:
        baseline.reasons(args.baseline, form, args.reason)


@contextmanager
def failures(args: argparse.Namespace, name: str) -> Iterator[None]:
    """Write the JUnit file of a command that ends without a result."""
    try:
        yield
    except (ProblemError, SolverError) as error:
        failure = unfinished(name, str(error))
        if args.junit:
            exchange.replace_file(args.junit, lambda: junit.junit_xml([failure]))
        raise


def conclude(
    args: argparse.Namespace, form: str, results: Sequence[Judged], code: int, *, many: bool = False
) -> int:
    """Compare with the baseline, write the JUnit file, print JSON, and return the exit code.

    Parameters
    ----------
    args
        Options `junit`, `json`, `baseline`, `update` and `reason`.
    form
        Subfolder of the baseline.
    results
        Judged cases or simulators.
    code
        Exit code so far.
    many
        True if the command takes several: JSON is then a list.
    """
    if args.baseline and not args.update:
        compared = [_compared(each, args, form) for each in results]
        results = [each for each, _ in compared]
        code = max([code, *(other for _, other in compared)])
    if args.junit:
        exchange.replace_file(args.junit, lambda: junit.junit_xml(results))
    if args.json:
        records = [each.record for each in results]
        text = json.dumps(records if many else records[0], ensure_ascii=False, indent=1)
        code = max(code, print_lines([text]))
    if args.update:
        failed = ", ".join(each.name for each in results if each.error)
        failure = failed and f"baseline unchanged: {failed} has no result"
        tables = {each.name: each.tables for each in results}
        code = max(code, update(args, form, tables, failure))
    return code


def _compared(result: Judged, args: argparse.Namespace, form: str) -> tuple[Judged, int]:
    """Print what differs from the baseline; return the result with these rows, and a code."""
    if result.error:
        return result, HELD
    folder = baseline.baseline_folder(form, args.baseline) / result.name
    because = 'no baseline; make one by adding --update --reason "first"'
    rows = pd.DataFrame(
        baseline.compare(result.tables, folder, result.rounding)
        or [row("baseline", result.name, "fail", because)]
    )
    moved = rows[is_missed(rows)].to_dict("records")
    for line in moved:
        tell(f"{result.name}: baseline {line['quantity']}: {line['because']}")
    verdict = pd.concat([result.verdict, rows], ignore_index=True)
    return replace(result, verdict=verdict), MISSED if moved else HELD


def update(
    args: argparse.Namespace,
    form: str,
    tables: Mapping[str, Mapping[str, pd.DataFrame]],
    failure: str,
    *,
    named: bool = True,
) -> int:
    """Make tables the baseline, and return the exit code.

    A failure is reported in place of that. The tables of all others stay if these are `named`.
    """
    if failure:
        return tell_error(failure, MISSED)
    reasons: Path = baseline.renew(args.baseline, form, tables, args.reason, named=named)
    whose = f" of {', '.join(tables)}" if named else ""
    tell(f"{form} baseline{whose} renewed; {reasons.name} has the reason")
    return HELD
