"""The tables that a command line asks for by name."""

from __future__ import annotations

import argparse
import difflib
from typing import TYPE_CHECKING

from msvalidate.cli.arguments import USAGE
from msvalidate.cli.terminal import summary_lines, table_lines, tell_error

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


def refuse_unmade_tables(results: list[Result], args: argparse.Namespace) -> list[int]:
    """An exit code if a table was asked for that no study made; which, is said."""
    made = {"verdict"}.union(*(result.evidence.tables for result in results))
    unknown = [name for name in args.tables if name not in made]
    if not (results and unknown):
        return []
    near = difflib.get_close_matches(unknown[0], made, n=1)
    hint = f"did you mean {near[0]}?" if near else f"choose from {', '.join(sorted(made))}"
    return [tell_error(f"--table {unknown[0]!r}: no such table; {hint}", USAGE)]
