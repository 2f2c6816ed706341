"""The tables that a command line asks for by name: refused before the work, printed after it."""

from __future__ import annotations

import argparse
import difflib
from typing import TYPE_CHECKING

from msvalidate.cli.arguments import USAGE
from msvalidate.cli.terminal import summary_lines, table_lines, tell_error
from msvalidate.judging import catalogue

if TYPE_CHECKING:
    from msvalidate.output.stored import Result


def said_of(result: Result, args: argparse.Namespace) -> list[str]:
    """What stdout says of a study, line by line: its findings, or the tables asked for."""
    if args.quiet or args.verb == "check":
        return []
    if args.tables:
        return table_lines(result, args.tables)
    tables = [*table_lines(result, ()), ""] if args.verbose else []
    return [*tables, *summary_lines(result)]


def refuse_unknown_tables(args: argparse.Namespace) -> None:
    """Raise `ProblemError`, before the work, for a table that none of the studies makes.

    What they may make is in their baseline, or named in their sources.
    """
    if not args.tables:
        return
    from msvalidate.output import baseline
    from msvalidate.problem import ProblemError
    from msvalidate.problem.checks import format_value

    known = {"verdict"}.union(*map(baseline.tables, args.studies))
    if len(known) == 1:
        return  # nothing to go by
    words = known.union(*map(catalogue.words, args.studies))
    for name in args.tables:
        if name not in words:
            near = difflib.get_close_matches(name, known, n=1)
            hint = f"did you mean {near[0]}?" if near else f"choose from {', '.join(sorted(known))}"
            raise ProblemError(f"--table {format_value(name)}: no such table; {hint}")


def refuse_unmade_tables(results: list[Result], args: argparse.Namespace) -> list[int]:
    """An exit code if a table was asked for that no study made; which, is said."""
    made = {"verdict"}.union(*(result.evidence.tables for result in results))
    unknown = [name for name in args.tables if name not in made]
    if not (results and unknown):
        return []
    known = ", ".join(sorted(made))
    return [tell_error(f"--table {unknown[0]}: no such table; choose from {known}", USAGE)]
