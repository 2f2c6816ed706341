"""What ``run``, ``check``, ``list`` and ``report`` do: studies run, judged, told and written."""

from __future__ import annotations

import argparse
import contextlib
import difflib
import gc
import os
import time
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from msvalidate.cli.arguments import FAILED, HELD, MISSED, NOTHING, USAGE, as_shown
from msvalidate.cli.terminal import (
    announce_compilation,
    ending,
    ending_of_all,
    failure_lines,
    print_lines,
    summary_lines,
    table_lines,
    tell,
    tell_error,
)
from msvalidate.judging import catalogue

if TYPE_CHECKING:
    from msvalidate.cli.outcome import Outcome
    from msvalidate.output.stored import Result, Stored


def list_studies(_args: argparse.Namespace) -> int:
    """Each study with what it asks, or why it cannot be read: which costs no other its line."""
    names = catalogue.names()
    asked = dict.fromkeys(names, "")
    for name in names:
        try:
            asked[name] = catalogue.question(name)
        except ImportError as error:
            asked[name] = f"(cannot be read: {error})"
    width = max(map(len, names))
    return print_lines([f"{name:<{width}}  {said}" for name, said in asked.items()])


def make_report(args: argparse.Namespace) -> int:
    """Make the pages again from stored results."""
    from msvalidate.output import report

    studies = report.rebuild(args.out)
    codes = [_tell_ending(study, args) for study in studies]
    if not args.quiet:
        tell(f"report in {args.out / 'report.html'}")
    return FAILED if any(study.error for study in studies) else max(codes)


def run_studies(args: argparse.Namespace) -> int:
    """Run and judge studies, saying how each ended, and write what they found."""
    from msvalidate.output import baseline, junit, report
    from msvalidate_check import exchange

    _refuse(args)
    if not args.quiet:
        announce_compilation()
    gc.freeze()  # the libraries' objects stay: no use in looking through them again and again
    codes, clock = [HELD], time.perf_counter()
    if args.verb == "check" and not args.update and not args.named:
        against = baseline.baseline_folder(args.form, args.baseline)
        for name in baseline.unknown_folders(against, catalogue.names()):
            said = f"{args.form} baseline: {name} is no study; check --update leaves it out"
            codes.append(tell_error(said, NOTHING))
    outcomes = _run(args, codes)
    finished = {each.name: each.files for each in outcomes if each.result}
    late = {each.name: each.files_beside for each in outcomes if not each.result}
    stored = report.publish(finished, args.out, late)
    if args.junit:
        exchange.replace_file(args.junit, lambda: junit.junit_xml(stored))
    results = [outcome.result for outcome in outcomes if outcome.result]
    codes.append(print_lines([line for result in results for line in _lines(result, args)]))
    made = {"verdict"}.union(*(result.evidence.tables for result in results))
    unmade = [name for name in args.tables if results and name not in made]
    if unmade:
        said = f"--table {unmade[0]}: no such table; choose from {', '.join(sorted(made))}"
        codes.append(tell_error(said, USAGE))
    if args.update:
        codes.append(_update(results, args, [each.name for each in outcomes if not each.held]))
    if not args.quiet:
        if len(outcomes) > 1:
            tell(ending_of_all(outcomes, time.perf_counter() - clock))
        tell(f"results in {args.out}, to read in {args.out / 'report.html'}")
    return max(codes)


def _refuse(args: argparse.Namespace) -> None:
    """Raise `ProblemError` or ImportError, before the work, for what cannot be."""
    from msvalidate.cli.candidates import check_candidate
    from msvalidate.output import baseline, report

    report.refuse_unwritable(args.out, args.studies)
    if args.junit:
        report.refuse_place("--junit", args.junit, args.out)
    if args.baseline:
        report.refuse_folder("--baseline", args.baseline, args.out, written=args.update)
        baseline.check_home(args.baseline)
    if args.update:
        baseline.reasons(args.baseline, args.form, args.reason)
    if args.tables:
        _refuse_unknown_tables(args)
    for name in args.studies:
        module = catalogue.load(name)
        if args.candidate:
            check_candidate(args.candidate, name, module)


def _refuse_unknown_tables(args: argparse.Namespace) -> None:
    """What studies may make is in their baseline, or named in their sources."""
    from msvalidate.output import baseline
    from msvalidate.problem import ProblemError
    from msvalidate.problem.checks import format_value

    known = {"verdict"}.union(*map(baseline.tables, args.studies))
    words = known.union(*map(catalogue.words, args.studies))
    for name in args.tables if len(known) > 1 else ():  # else there is nothing to go by
        if name not in words:
            near = difflib.get_close_matches(name, known, n=1)
            hint = f"did you mean {near[0]}?" if near else f"choose from {', '.join(sorted(known))}"
            raise ProblemError(f"--table {format_value(name)}: no such table; {hint}")


def _run(args: argparse.Namespace, codes: list[int]) -> list[Outcome]:
    """How each study ended, in the order asked, said as it ends; `codes` get those of exit.

    One that fails does not keep the others from running; those that read results come last.
    """
    from msvalidate.cli.jobs import run_tasks
    from msvalidate.cli.outcome import Task
    from msvalidate.judging.sweep import Setting
    from msvalidate.output import baseline
    from msvalidate.output.results import Results

    checks = args.verb == "check"
    setting = Setting(quick=args.form == "quick", seed=args.seed, progress=not args.quiet)
    against = None
    if checks and not args.update:
        against = baseline.baseline_folder(args.form, args.baseline)

    def task(name: str) -> Task:
        # A study of a user's own has no baseline among ours: its tolerances alone judge it.
        own = against if args.baseline or catalogue.is_ours(name) else None
        asked = args.candidate or "", args.accuracy, args.questions
        return Task(name, setting, tuple(as_shown(args.words)), args.plots, own, None, *asked)

    def began(name: str) -> None:
        if args.verbose:
            tell(f"{name}: {catalogue.question(name)}")

    found: dict[str, Outcome] = {}
    late = [name for name in args.studies if catalogue.reads_results(name)]
    for batch in ([name for name in args.studies if name not in late], late):
        tasks = [task(name) for name in batch]
        if batch is late:  # what others left is not looked at where this run is judged by itself
            tables = {n: each.result.evidence.tables for n, each in found.items() if each.result}
            results = Results(args.form, tables, None if checks else args.out)
            tasks = [replace(task, results=results) for task in tasks]
        with contextlib.closing(run_tasks(tasks, args.jobs, began)) as outcomes:
            for outcome in outcomes:
                found[outcome.name] = outcome
                codes += _told(outcome, args)
    return [found[name] for name in args.studies]


def _told(outcome: Outcome, args: argparse.Namespace) -> list[int]:
    """Say how a study ended; its exit codes."""
    codes = []
    if outcome.code:
        codes.append(tell_error(f"study {outcome.name}: {outcome.said}", outcome.code))
        if args.verbose and outcome.trace:
            tell(outcome.trace)
    codes.append(_tell_ending(outcome, args))
    if outcome.lacks_baseline:
        home = f" --baseline {args.baseline}" if args.baseline else ""
        said = f"study {outcome.name}: no {args.form} baseline, nothing compared; make one with "
        said += f"check {outcome.name} --update{home}"
        codes.append(tell_error(said, NOTHING))
    return codes


def _tell_ending(study: Stored | Outcome, args: argparse.Namespace) -> int:
    """What a study missed, and how it ended, to stderr; its exit code if it finished."""
    from msvalidate.judging.evidence import is_missed

    for line in failure_lines(study, f"{args.out / study.name}{os.sep}verdict.csv"):
        tell(line)
    if not args.quiet:
        tell(ending(study))
    if study.error or study.held:
        return HELD
    # Nothing is known if none of its rows is resolved.
    return NOTHING if len(study.verdict) and not is_missed(study.verdict).any() else MISSED


def _lines(result: Result, args: argparse.Namespace) -> list[str]:
    """What stdout says of a study, line by line: its findings, or the tables asked for."""
    if args.quiet or args.verb == "check":
        return []
    if args.tables:
        return table_lines(result, args.tables)
    tables = [*table_lines(result, ()), ""] if args.verbose else []
    return [*tables, *summary_lines(result)]


def _update(results: Sequence[Result], args: argparse.Namespace, failed: Sequence[str]) -> int:
    """Make these results the baseline, that of other studies staying, and say why."""
    from msvalidate.output import baseline

    if failed:
        return tell_error(
            f"baseline left as it was: {', '.join(failed)} did not hold; mend that first", MISSED
        )
    found = {result.name: result.evidence for result in results}
    reason = baseline.renew(args.baseline, args.form, found, args.reason, named=args.named)
    whose = f" of {', '.join(args.studies)}" if args.named else ""
    tell(f"{args.form} baseline{whose} renewed; {reason.name} says why")
    return HELD
