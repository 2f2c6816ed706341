"""Floor 5: the command line, ``python -m msvalidate.study NAME``.

It defines no types and is imported by nobody: run as a module it is ``__main__``, and whatever it
defined would exist twice. Heavy imports wait until a study is really run.
"""

from __future__ import annotations

import argparse
import contextlib
import difflib
import gc
import os
import sys
import time
import traceback
from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from functools import partial
from typing import TYPE_CHECKING, Any, TextIO

from msvalidate import catalogue
from msvalidate.arguments import (
    FAILED,
    HELD,
    INTERRUPTED,
    MISSED,
    NOTHING,
    PROGRAM,
    USAGE,
    as_shown,
    parse,
)

if TYPE_CHECKING:
    import pandas as pd

    from msvalidate.stored import Result, Stored

Spent = tuple[datetime, float]
"""When a study began, and how many seconds it took."""
ROWS_SHOWN = 40
"""Longer tables are shown by their first rows; the CSV has them all."""


def main(arguments: Sequence[str]) -> int:
    """Run what the command line asks for; return the exit code."""
    args = parse(arguments)
    if args.verb == "list":
        return _guarded(_list, args)
    if args.verb == "report":
        return _guarded(lambda: _report(args), args)
    return _guarded(lambda: _run(args, arguments), args)


def _list() -> int:
    width = max(map(len, catalogue.names()))
    return _printed([f"{name:<{width}}  {catalogue.question(name)}" for name in catalogue.names()])


def _guarded(act: Callable[[], int], args: argparse.Namespace) -> int:
    """Act; what goes wrong outside the studies is said in one line."""
    # One thread for dense algebra: the sparse solves here gain nothing from more, and sums come out
    # the same on any number of cores.
    for library in ("OPENBLAS", "MKL", "OMP"):
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")
    # Figures are made without a window; the library refuses to start with one that is not there.
    os.environ["MPLBACKEND"] = "agg"
    try:
        return act()
    except ImportError as error:
        return _error(str(error), USAGE)
    except OSError as error:
        what = f"{error.strerror}: {error.filename}" if error.filename else str(error)
        return _error(f"writing results: {what}", USAGE)
    except Exception as error:  # noqa: BLE001  a fault of ours: one line, and a code of its own
        from msvalidate.problem import ProblemError

        if isinstance(error, ProblemError):
            return _error(str(error), USAGE)
        if args.verbose:
            _tell(traceback.format_exc())
        said = " ".join(f"{type(error).__name__}: {error}".split())
        return _error(f"a fault of the program itself: {said}; -v shows where", FAILED)


def _tell(message: str) -> None:
    """A line to stderr; one that cannot be read any more is not missed."""
    with contextlib.suppress(OSError):
        print(message, file=sys.stderr)
        return
    sys.stderr = _nowhere()


def _printed(lines: Sequence[str]) -> int:
    """Lines to stdout; the exit code of a place where they do not fit."""
    try:
        for line in lines:
            print(line)
        print(end="", flush=True)
    except BrokenPipeError:  # the reader left; the verdict stands
        sys.stdout = _nowhere()
    except OSError as error:  # a full disk; results are in files
        sys.stdout = _nowhere()
        return _error(f"stdout: {error.strerror}", USAGE)
    return HELD


def _nowhere() -> TextIO:
    return open(os.devnull, "w", encoding="utf-8")  # noqa: PTH123  as long as the process


def _report(args: argparse.Namespace) -> int:
    """Make the pages again from stored results."""
    from msvalidate import report

    studies = report.rebuild(args.out)
    for study in studies:
        _say(study, args)
    if not args.quiet:
        _tell(f"report in {args.out / 'report.html'}")
    if any(study.error for study in studies):
        return FAILED
    return HELD if all(study.held for study in studies) else MISSED


def _run(args: argparse.Namespace, arguments: Sequence[str]) -> int:
    """Run and judge studies, write what they found, and say what failed."""
    from msvalidate import report

    report.refuse_unwritable(args.out, args.studies)
    if args.junit:
        report.refuse_place("--junit", args.junit, args.out)
    if args.update:
        _changelog(args)  # refuses, if there is none, before the work
    _refuse_unknown_tables(args)
    for name in args.studies:
        catalogue.load(name)
    gc.freeze()  # the libraries' objects stay: no use in looking through them again and again
    results, unfinished, spent, codes = _studied(args)
    if args.verb == "check" and not args.update:
        results, uncompared = _compared(results, args)
        codes += [_error(message, NOTHING) for message in uncompared]
    studies = _written(results, unfinished, spent, args, arguments)
    codes.append(_printed([line for result in results for line in _shown(result, args)]))
    for study in studies:
        _say(study, args)
    codes += _tables_there(results, args)
    failed = [study.name for study in studies if not study.held]
    if args.update:
        codes.append(_update(results, args, failed))
    if not args.quiet:
        _tell(f"results in {args.out}, to read in {args.out / 'report.html'}")
    return max([*codes, MISSED if set(failed) - set(unfinished) else HELD])


def _written(
    results: list[Result],
    unfinished: dict[str, str],
    spent: dict[str, Spent],
    args: argparse.Namespace,
    arguments: Sequence[str],
) -> list[Stored]:
    """Write what was found; return it as it was stored."""
    from msvalidate import report, stored
    from msvalidate.junit import junit
    from msvalidate.provenance import provenance

    command = as_shown(arguments)
    origins = {name: provenance(command, args.seed, *each) for name, each in spent.items()}
    files = {
        r.name: stored.files(r, origins[r.name], seconds=spent[r.name][1], plots=args.plots)
        for r in results
    }
    late = {
        name: partial(
            stored.unfinished,
            question=catalogue.load(name).__doc__ or catalogue.docstring(name),
            origin=origins[name],
            error=error,
            seconds=spent[name][1],
        )
        for name, error in unfinished.items()
    }
    studies = report.publish(files, args.out, late)
    if args.junit:
        report.replace_file(args.junit, lambda: junit(studies))
    return studies


def _studied(
    args: argparse.Namespace,
) -> tuple[list[Result], dict[str, str], dict[str, Spent], list[int]]:
    """Run the studies: those that finished, the errors of those that did not, times, exit codes.

    One that fails does not keep the others from running.
    """
    from msvalidate.evidence import judge
    from msvalidate.junit import printable
    from msvalidate.problem import ProblemError, SolverError
    from msvalidate.stored import Result
    from msvalidate.sweep import Setting

    setting = Setting(quick=args.form == "quick", seed=args.seed, progress=not args.quiet)
    results, unfinished, spent, codes = [], {}, {}, []
    for name in args.studies:
        if args.verbose:
            _tell(f"{name}: {catalogue.question(name)}")
        started, clock = datetime.now(UTC), time.perf_counter()
        try:
            module = catalogue.load(name)
            evidence = module.run(setting=setting)
            question = module.__doc__ or catalogue.docstring(name)
            results.append(Result(name, question, evidence, judge(evidence)))
        except (ProblemError, SolverError) as error:
            unfinished[name] = printable(str(error))
            code = USAGE if isinstance(error, ProblemError) else FAILED
            codes.append(_error(f"study {name}: {unfinished[name]}", code))
        # A crash is reported as one, and spoils nothing else; so is one that ends the program.
        except (Exception, SystemExit) as error:  # noqa: BLE001
            # What a crash says may hold paths of this machine: for the terminal, not the report.
            unfinished[name] = f"crashed: {type(error).__name__}"
            said = printable(str(error))
            codes.append(_error(f"study {name}: crashed: {type(error).__name__}: {said}", FAILED))
            if args.verbose:
                _tell(traceback.format_exc())
        spent[name] = (started, time.perf_counter() - clock)
    return results, unfinished, spent, codes


def _compared(results: list[Result], args: argparse.Namespace) -> tuple[list[Result], list[str]]:
    """Results with their tables held to the baseline, and what could not be compared."""
    from dataclasses import replace

    import pandas as pd

    from msvalidate import baseline

    found, form = [], args.form
    strangers = [] if args.named else baseline.strangers(form, catalogue.names())
    uncompared = [
        f"{form} baseline: {name} is no study; check --update leaves it out" for name in strangers
    ]
    for result in results:
        rows = baseline.compare(result.evidence, baseline.home(form) / result.name)
        if not rows:
            uncompared.append(
                f"study {result.name}: no {form} baseline, nothing compared; make one with "
                f"check {result.name} --update"
            )
        verdict = pd.concat([result.verdict, pd.DataFrame(rows)], ignore_index=True)
        found.append(replace(result, verdict=verdict))
    return found, uncompared


def _update(results: list[Result], args: argparse.Namespace, failed: list[str]) -> int:
    """Make these results the baseline, that of other studies staying, and say why."""
    from msvalidate import baseline, report

    if failed:
        return _error(
            f"baseline left as it was: {', '.join(failed)} did not hold; mend that first", MISSED
        )
    tables = {result.name: baseline.files(result.evidence) for result in results}
    # The reason first: a number never moves without one. It follows at once.
    reason = baseline.CHANGELOG, lambda: _changelog(args)
    report.replace_folder(baseline.home(args.form), tables, keep=args.named, beside=reason)
    whose = f" of {', '.join(args.studies)}" if args.named else ""
    _tell(f"{args.form} baseline{whose} renewed; CHANGELOG.md says why")
    return HELD


def _changelog(args: argparse.Namespace) -> bytes:
    from msvalidate import baseline

    return baseline.changelog(args.form, args.reason, args.studies if args.named else ())


def _shown(result: Result, args: argparse.Namespace) -> list[str]:
    """A study's tables and findings as stdout has them."""
    if args.quiet or args.verb == "check":
        return []
    tables: dict[str, Any] = {**result.evidence.tables}
    tables["verdict"] = result.verdict.drop(columns="because")
    asked = [name for name in args.tables if name in tables] if args.tables else list(tables)
    whole = args.tables or args.verbose
    lines = [
        f"\n{result.name}/{name}\n{_aligned(tables[name], None if whole else ROWS_SHOWN)}"
        for name in asked
    ]
    findings = [] if args.tables else [f"- {finding}" for finding in result.evidence.findings]
    return [*lines, *([] if args.tables else [""]), *findings]


def _refuse_unknown_tables(args: argparse.Namespace) -> None:
    """Raise `ProblemError`, before the work, for a table that none of the studies makes.

    What they may make is in their baseline, or named in their sources.
    """
    if not args.tables:
        return
    from msvalidate import baseline
    from msvalidate.problem import ProblemError, shown

    known = {"verdict"}.union(*map(baseline.tables, args.studies))
    if len(known) == 1:
        return  # nothing to go by
    words = known.union(*map(catalogue.words, args.studies))
    for name in args.tables:
        if name not in words:
            near = difflib.get_close_matches(name, known, n=1)
            hint = f"did you mean {near[0]}?" if near else f"choose from {', '.join(sorted(known))}"
            raise ProblemError(f"--table {shown(name)}: no such table; {hint}")


def _tables_there(results: list[Result], args: argparse.Namespace) -> list[int]:
    """An exit code if a table was asked for that no study made; which, is said."""
    made = {"verdict"}.union(*(result.evidence.tables for result in results))
    unknown = [name for name in args.tables if name not in made]
    if not (results and unknown):
        return []
    known = ", ".join(sorted(made))
    return [_error(f"--table {unknown[0]}: no such table; choose from {known}", USAGE)]


def _aligned(table: pd.DataFrame, most: int | None) -> str:
    """Aligned text of a table's first rows, and how many more there are; None is all."""
    rows = len(table) if most is None else most
    text = table.head(rows).to_string(index=False, float_format=lambda value: f"{value:.6g}")
    return text + (f"\n… {len(table) - rows} more rows" if len(table) > rows else "")


def _say(study: Stored, args: argparse.Namespace) -> None:
    """What a study missed, a line each, and how much of each layer it held, to stderr."""
    from msvalidate.junit import line

    rows = [] if study.error else study.verdict.to_dict("records")
    for row in rows:
        if row["verdict"] != "pass":
            why = f" ({row['because']})" if row["layer"] == "baseline" else ""
            _tell(f"{study.name}: FAIL {line(row)}{why}")
    if args.quiet:
        return
    layers = [
        f"{layer} {int((held['verdict'] == 'pass').sum())} of {len(held)}"
        for layer, held in study.verdict.groupby("layer", sort=False)
    ]
    word = "held" if study.held else "FAILED"
    said = f"not finished: {study.error}" if study.error else f"{word}, {', '.join(layers)}"
    _tell(f"{study.name}: {said}")


def _error(message: str, code: int) -> int:
    _tell(f"{PROGRAM}: error: {message}")
    return code


def _prepare_streams() -> None:
    """Streams that take any letter; what was closed (``>&-``, cron) leads nowhere.

    The numbers of closed ones are taken, else the first file that is opened would be stdout.
    """
    while (number := os.open(os.devnull, os.O_RDWR)) <= 2:
        pass
    os.close(number)
    for name in ("stdout", "stderr"):
        stream: Any = getattr(sys, name) or _nowhere()
        stream.reconfigure(errors="replace")
        setattr(sys, name, stream)


if __name__ == "__main__":
    _prepare_streams()
    try:
        code = main(sys.argv[1:])
    except SystemExit as end:  # --help, or wrong usage
        code = end.code if isinstance(end.code, int) else HELD
    except KeyboardInterrupt:
        code = _error("interrupted; results are as they were", INTERRUPTED)
    sys.exit(max(code, _printed([])))  # what --help left unwritten
