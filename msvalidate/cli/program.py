"""The command line, ``python -m msvalidate.study NAME``.

It defines no types and is imported by nobody: run as a module it is ``__main__``, and whatever it
defined would exist twice. Heavy imports wait until a study is really run.
"""

from __future__ import annotations

import argparse
import contextlib
import gc
import os
import sys
import time
import traceback
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from importlib import import_module
from typing import TYPE_CHECKING, Any, NoReturn

from msvalidate.cli.advise_arguments import parse_advise
from msvalidate.cli.arguments import (
    FAILED,
    HELD,
    INTERRUPTED,
    MISSED,
    NOTHING,
    USAGE,
    as_shown,
    parse,
)
from msvalidate.cli.case_arguments import parse_case
from msvalidate.cli.new_study import parse_new_study
from msvalidate.cli.simulator_arguments import parse_simulators
from msvalidate.cli.tables import refuse_unknown_tables, refuse_unmade_tables, said_of
from msvalidate.cli.terminal import (
    announce_compilation,
    ending,
    ending_of_all,
    failure_lines,
    nowhere,
    print_lines,
    tell,
    tell_error,
)
from msvalidate.judging import catalogue

if TYPE_CHECKING:
    from msvalidate.cli.outcome import Outcome
    from msvalidate.output.results import Results
    from msvalidate.output.stored import Result, Stored


PARSERS = {
    "case": ("cases", parse_case),
    "advise": ("advise", parse_advise),
    "study": ("new_study", parse_new_study),
}
"""Commands with a line of their own: the module that acts, and what parses their words."""


def main(arguments: Sequence[str]) -> int:
    """Run what the command line asks for; return the exit code."""
    word = arguments[0] if arguments else ""
    if word in PARSERS:
        module, parse_words = PARSERS[word]
        return _act(module, parse_words(arguments[1:]))
    if word in {"simulate", "adapter"}:
        return _act("simulators", parse_simulators(arguments))
    args = parse(arguments)
    if args.verb == "list":
        return _guard(_list, args)
    if args.verb == "report":
        return _guard(lambda: _report(args), args)
    return _guard(lambda: _run(args, arguments), args)


def _act(module: str, args: argparse.Namespace) -> int:
    """Do what a module of this folder does."""
    return _guard(lambda: int(import_module(f"msvalidate.cli.{module}").act(args)), args)


def _list() -> int:
    width = max(map(len, catalogue.names()))
    return print_lines([f"{name:<{width}}  {_question(name)}" for name in catalogue.names()])


def _question(name: str) -> str:
    """What a study asks, or why it cannot be read: that must not cost the others their line."""
    try:
        return catalogue.question(name)
    except ImportError as error:
        return f"(cannot be read: {error})"


def _guard(act: Callable[[], int], args: argparse.Namespace) -> int:
    """Act; what goes wrong outside the studies is said in one line."""
    # One thread for dense algebra: the sparse solves here gain nothing from more, and sums come out
    # the same on any number of cores. Who asks for more has them, but not in each of several jobs.
    for library in ("OPENBLAS", "MKL", "OMP"):
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")
        if args.jobs > 1:
            os.environ[f"{library}_NUM_THREADS"] = "1"
    # Figures are made without a window; the library refuses to start with one that is not there.
    os.environ["MPLBACKEND"] = "agg"
    try:
        return act()
    except ImportError as error:
        return tell_error(str(error), USAGE)
    except OSError as error:
        from msvalidate.problem.checks import format_value

        name = format_value(str(error.filename)).strip("'")
        return tell_error(f"{error.strerror}: {name}" if error.filename else str(error), USAGE)
    except Exception as error:  # noqa: BLE001  a fault of ours: one line, and a code of its own
        from msvalidate.problem import ProblemError

        if isinstance(error, ProblemError):
            return tell_error(str(error), USAGE)
        if args.verbose:
            tell(traceback.format_exc())
        said = " ".join(f"{type(error).__name__}: {error}".split())
        return tell_error(f"a fault of the program itself: {said}; -v shows where", FAILED)


def _report(args: argparse.Namespace) -> int:
    """Make the pages again from stored results."""
    from msvalidate.output import report

    studies = report.rebuild(args.out)
    for study in studies:
        _say(study, args)
    if not args.quiet:
        tell(f"report in {args.out / 'report.html'}")
    if any(study.error for study in studies):
        return FAILED
    return max([HELD, *(_missed_code(study) for study in studies if not study.held)])


def _missed_code(study: Stored | Outcome) -> int:
    """Exit code of a study that did not hold; nothing is known if none of its rows is resolved."""
    from msvalidate.judging.evidence import is_missed

    unknown = len(study.verdict) and not is_missed(study.verdict).any()
    return NOTHING if unknown else MISSED


def _run(args: argparse.Namespace, arguments: Sequence[str]) -> int:
    """Run and judge studies, saying how each ended, and write what they found."""
    from msvalidate.output import baseline, report

    report.refuse_unwritable(args.out, args.studies)
    if args.junit:
        report.refuse_place("--junit", args.junit, args.out)
    if args.baseline:
        report.refuse_folder("--baseline", args.baseline, args.out, written=args.update)
        baseline.check_home(args.baseline)
    if args.update:
        baseline.reasons(args.baseline, args.form, args.reason)  # refuses before the work
    refuse_unknown_tables(args)
    for name in args.studies:
        catalogue.load(name)
    if args.candidate:
        _check_candidate(args)
    if not args.quiet:
        announce_compilation()
    gc.freeze()  # the libraries' objects stay: no use in looking through them again and again
    codes = _strangers(args)
    clock = time.perf_counter()
    outcomes, told = _run_studies(args, arguments)
    codes += told
    _write(outcomes, args)
    results = [outcome.result for outcome in outcomes if outcome.result]
    codes.append(print_lines([line for result in results for line in said_of(result, args)]))
    codes += refuse_unmade_tables(results, args)
    failed = [outcome.name for outcome in outcomes if not outcome.held]
    if args.update:
        codes.append(_update(results, args, failed))
    if not args.quiet:
        if len(outcomes) > 1:
            tell(ending_of_all(outcomes, time.perf_counter() - clock))
        tell(f"results in {args.out}, to read in {args.out / 'report.html'}")
    return max([*codes, HELD])


def _check_candidate(args: argparse.Namespace) -> None:
    """Raise `ProblemError`, before the work, for what cannot be a candidate of the studies."""
    from msvalidate.cli.candidates import check_candidate

    for name in args.studies:
        check_candidate(args.candidate, name, catalogue.load(name))


def _strangers(args: argparse.Namespace) -> list[int]:
    """Exit codes of what is in the baseline and no study: nothing is compared with it."""
    if args.verb != "check" or args.update or args.named:
        return []
    from msvalidate.output import baseline

    return [
        tell_error(
            f"{args.form} baseline: {name} is no study; check --update leaves it out", NOTHING
        )
        for name in baseline.unknown_folders(
            baseline.baseline_folder(args.form, args.baseline), catalogue.names()
        )
    ]


def _run_studies(
    args: argparse.Namespace, arguments: Sequence[str]
) -> tuple[list[Outcome], list[int]]:
    """How each study ended, in the order asked, and exit codes; said of each as it ends.

    One that fails does not keep the others from running.
    """
    from msvalidate.cli import jobs
    from msvalidate.cli.outcome import Task
    from msvalidate.judging.sweep import Setting
    from msvalidate.output import baseline

    setting = Setting(quick=args.form == "quick", seed=args.seed, progress=not args.quiet)
    holds = args.verb == "check" and not args.update
    against = baseline.baseline_folder(args.form, args.baseline) if holds else None
    command = tuple(as_shown(arguments))
    # A study of a user's own has no baseline among ours: its tolerances alone judge it.
    compared = {
        name: against if args.baseline or catalogue.is_ours(name) else None for name in args.studies
    }
    asked = {
        "candidate": args.candidate or "",
        "accuracy": args.accuracy,
        "questions": args.questions,
    }
    tasks = [
        Task(name, setting, command, args.plots, compared[name], **asked) for name in args.studies
    ]

    def began(name: str) -> None:
        if args.verbose:
            tell(f"{name}: {catalogue.question(name)}")

    found: dict[str, Outcome] = {}
    codes = []
    late = [task for task in tasks if catalogue.reads_results(task.name)]
    for batch in ([task for task in tasks if task not in late], late):
        found_so_far = _results(found, args)
        ready = [replace(task, results=found_so_far) for task in batch] if batch is late else batch
        with contextlib.closing(jobs.run_tasks(ready, args.jobs, began)) as outcomes:
            for outcome in outcomes:
                found[outcome.name] = outcome
                codes += _told(outcome, args)
                tables = outcome.result.evidence.tables if outcome.result else {}
                if compared[outcome.name] and tables and not outcome.compared:
                    message = f"study {outcome.name}: no {args.form} baseline, nothing compared; "
                    message += f"make one with check {outcome.name} --update"
                    message += f" --baseline {args.baseline}" if args.baseline else ""
                    codes.append(tell_error(message, NOTHING))
    return [found[name] for name in args.studies], codes


def _results(found: Mapping[str, Outcome], args: argparse.Namespace) -> Results:
    """What studies found in this run; what others left, unless this run is judged by itself."""
    from msvalidate.output.results import Results

    tables = {name: each.result.evidence.tables for name, each in found.items() if each.result}
    return Results(args.form, tables, None if args.verb == "check" else args.out)


def _told(outcome: Outcome, args: argparse.Namespace) -> list[int]:
    """Say how a study ended; its exit code if that was not with all held."""
    codes = []
    if outcome.fault:
        code = USAGE if outcome.fault == "problem" else FAILED
        codes.append(tell_error(f"study {outcome.name}: {outcome.said}", code))
        if args.verbose and outcome.fault == "crash":
            tell(outcome.trace)
    elif not outcome.held:
        codes.append(_missed_code(outcome))
    _say(outcome, args)
    return codes


def _write(outcomes: list[Outcome], args: argparse.Namespace) -> None:
    """Write what was found."""
    from msvalidate.output import report, stored
    from msvalidate.output.junit import junit_xml
    from msvalidate_check import exchange

    files = {each.name: each.files for each in outcomes if each.result}
    late = {
        each.name: partial(
            stored.unfinished_files,
            question=each.question,
            origin=each.origin,
            error=each.error,
            seconds=each.seconds,
        )
        for each in outcomes
        if not each.result
    }
    studies = report.publish(files, args.out, late)
    if args.junit:
        exchange.replace_file(args.junit, lambda: junit_xml(studies))


def _update(results: list[Result], args: argparse.Namespace, failed: list[str]) -> int:
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


def _say(study: Stored | Outcome, args: argparse.Namespace) -> None:
    """What a study missed, and how it ended, to stderr."""
    for line in failure_lines(study, f"{args.out / study.name}{os.sep}verdict.csv"):
        tell(line)
    if not args.quiet:
        tell(ending(study))


def _prepare_streams() -> None:
    """Streams that take any letter; what was closed (``>&-``, cron) leads nowhere.

    The numbers of closed ones are taken, else the first file that is opened would be stdout.
    """
    while (number := os.open(os.devnull, os.O_RDWR)) <= 2:
        pass
    os.close(number)
    for name in ("stdout", "stderr"):
        stream: Any = getattr(sys, name) or nowhere()
        stream.reconfigure(errors="replace")
        setattr(sys, name, stream)


def run() -> NoReturn:
    """Run the command line as a program: streams that take any letter, and an exit code."""
    _prepare_streams()
    try:
        code = main(sys.argv[1:])
    except SystemExit as end:  # --help, or wrong usage
        code = end.code if isinstance(end.code, int) else HELD
    except KeyboardInterrupt:
        code = tell_error("interrupted; results are as they were", INTERRUPTED)
    sys.exit(max(code, print_lines([])))  # what --help left unwritten
