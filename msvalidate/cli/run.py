"""Commands ``run``, ``check``, ``list`` and ``report``."""

from __future__ import annotations

import argparse
import contextlib
import gc
import math
import os
import re
import textwrap
import time
from collections import Counter
from collections.abc import Sequence
from typing import Any

from msvalidate.bench.judging import catalogue
from msvalidate.bench.judging.evidence import is_missed
from msvalidate.bench.judging.summary import NAME as SUMMARY
from msvalidate.bench.output import baseline, junit, report, summary
from msvalidate.bench.output.results import Results
from msvalidate.bench.output.stored import Result, Stored, verdict_json
from msvalidate.cli import gating
from msvalidate.cli.arguments import FAILED, HELD, MISSED, NOTHING, USAGE
from msvalidate.cli.candidates import check_candidate
from msvalidate.cli.jobs import run_tasks
from msvalidate.cli.outcome import Outcome, Task
from msvalidate.cli.progress import Progress, log_path
from msvalidate.cli.terminal import print_lines, tell, tell_error
from msvalidate.problem import ProblemError
from msvalidate.problem.checks import format_value
from msvalidate.problem.progress import report_stage
from msvalidate.problem.records import replace
from msvalidate_check import exchange
from msvalidate_check.text import WIDTH

FINDINGS = 8
"""Lines of findings a study: with its question and what was left out, ten."""
FIRST_SENTENCE = re.compile(r"(?<=[.!?]) (?=[A-Z])")
FAILURES = 5
"""Failures a study that are told one by one."""


def make_report(args: argparse.Namespace) -> int:
    """Make the pages again from stored results."""
    studies = report.rebuild(args.out)
    codes = [_tell_ending(study, args) for study in studies]
    if not args.quiet:
        tell(f"report in {args.out / 'report.html'}")
    return FAILED if any(study.error for study in studies) else max(codes)


def run_studies(args: argparse.Namespace) -> int:
    """Run and judge studies, saying how each ended, and write what they found."""
    _refuse(args)
    gc.freeze()  # the libraries' objects stay: no use in looking through them again and again
    codes, clock = [HELD], time.perf_counter()
    if args.verb == "check" and not args.update and not args.named:
        against = baseline.baseline_folder(args.form, args.baseline)
        for name in baseline.unknown_folders(against, catalogue.names()):
            said = f"{args.form} baseline: {name} is no study; check --update leaves it out"
            codes.append(tell_error(said, NOTHING))
    with Progress("studies", shown=not args.quiet, log=log_path(args.out)):
        outcomes = _run(args, codes)
    if args.questions and all(each.code == USAGE for each in outcomes):  # misspelt
        return max(codes)
    finished = {each.name: each.files for each in outcomes if each.result}
    late = {each.name: each.files_beside for each in outcomes if not each.result}
    stored = report.publish(finished, args.out, late)
    if args.junit:
        exchange.replace_file(args.junit, lambda: junit.junit_xml(stored))
    if args.json:
        print_lines([verdict_json(stored).decode()])
    results = [outcome.result for outcome in outcomes if outcome.result]
    codes.append(print_lines([line for result in results for line in _lines(result, args)]))
    made = {"verdict"}.union(*(result.evidence.tables for result in results))
    unmade = [name for name in args.tables if results and name not in made]
    if unmade:
        said = f"--table {unmade[0]}: no such table; choose from {', '.join(sorted(made))}"
        codes.append(tell_error(said, USAGE))
    if args.update:
        failed = ", ".join(each.name for each in outcomes if not each.held)
        failure = failed and f"baseline left as it was: {failed} did not hold; mend that first"
        tables = {result.name: result.evidence.tables for result in results}
        codes.append(gating.update(args, args.form, tables, failure, named=args.named))
    if not args.quiet:
        if len(outcomes) > 1:
            tell(ending_of_all(outcomes, time.perf_counter() - clock))
        tell(f"results in {args.out}, to read in {args.out / 'report.html'}")
    return max(codes)


def _refuse(args: argparse.Namespace) -> None:
    """Raise `ProblemError` or ImportError, before the work, for what cannot be."""
    report.refuse_unwritable(args.out, args.studies)
    gating.refuse_outputs(args, args.form)
    if args.tables:
        _refuse_unknown_tables(args)
    for name in args.studies:
        module = catalogue.load(name)
        if args.candidate:
            check_candidate(args.candidate, name, module)


def _refuse_unknown_tables(args: argparse.Namespace) -> None:
    """Refuse names of tables that no study makes.

    The possible tables are in the baseline, or named in the sources of a study.
    """
    known = {"verdict"}.union(*map(baseline.tables, args.studies))
    words = known.union(*map(catalogue.words, args.studies))
    for name in args.tables if len(known) > 1 else ():  # else there is nothing to go by
        if name not in words:
            hint = catalogue.suggestion(name, sorted(known))
            raise ProblemError(f"--table {format_value(name)}: no such table; {hint}")


def _run(args: argparse.Namespace, codes: list[int]) -> list[Outcome]:
    """Run studies and return their outcomes in order, with a message for each.

    `codes` receives the exit codes.

    One that fails does not keep the others from running; those that read results come last.
    """
    checks = args.verb == "check"
    against = None
    if checks and not args.update:
        against = baseline.baseline_folder(args.form, args.baseline)

    def task(name: str) -> Task:
        # A study of a user's own has no baseline among ours: its tolerances alone judge it.
        own = against if args.baseline or catalogue.is_ours(name) else None
        return Task(name, args, own)

    def began(name: str) -> None:
        running.append(name)
        report_stage(name, args.studies, running)
        if args.verbose:
            tell(f"{name}: {catalogue.question(name)}")

    found: dict[str, Outcome] = {}
    running: list[str] = []
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
                running.remove(outcome.name)
                for name in running[-1:]:
                    report_stage(name, args.studies, running)
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
    """Print failures and the ending of a study to stderr; return its exit code."""
    for line in failure_lines(study, f"{args.out / study.name}{os.sep}verdict.csv"):
        tell(line)
    if not args.quiet:
        tell(ending(study))
    if study.error or study.held:
        return HELD
    # Nothing is known if none of its rows is resolved.
    return NOTHING if len(study.verdict) and not is_missed(study.verdict).any() else MISSED


def _lines(result: Result, args: argparse.Namespace) -> list[str]:
    """Lines of a study for stdout: its findings, or the requested tables."""
    if args.quiet or args.verb == "check":
        return []
    if args.tables:
        return table_lines(result, args.tables)
    tables = [*table_lines(result, ()), ""] if args.verbose else []
    return [*tables, *summary_lines(result)]


# What is said of studies --------------------------------------------------------------------------


def summary_lines(result: Result) -> list[str]:
    """Question, summary table and first findings of a study, the latter in at most nine lines.

    A study that puts together what others found is the conclusion, of which none is left out.
    """
    lines = [f"{result.name}: {result.question.partition(chr(10))[0]}"]
    if SUMMARY in result.evidence.tables:
        table = result.evidence.tables[SUMMARY]
        lines += ["", *summary.summary_lines(table, result.evidence), ""]
    findings, begun = result.evidence.findings, len(lines)
    limit = math.inf if catalogue.reads_results(result.name) else FINDINGS
    wrap = textwrap.TextWrapper(WIDTH, "  - ", "    ", break_on_hyphens=False).wrap
    for place, finding in enumerate(findings):
        wrapped = wrap(FIRST_SENTENCE.split(finding, maxsplit=1)[0])
        if place and len(lines) - begun + len(wrapped) > limit:
            left = len(findings) - place
            return [*lines, f"  … {left} more finding{'s' * (left > 1)} in the report"]
        lines += wrapped[:FINDINGS]
    return lines


def table_lines(result: Result, names: Sequence[str]) -> list[str]:
    """The tables of these names, whole and aligned; all of them for none."""
    tables: dict[str, Any] = {**result.evidence.tables}
    tables["verdict"] = result.verdict.drop(columns="because")
    texts = {
        name: "\n".join(summary.summary_lines(tables[name], result.evidence))
        if name == SUMMARY
        else tables[name].to_string(index=False, float_format="{:.6g}".format)
        for name in names or tables
        if name in tables
    }
    return [f"\n{result.name}/{name}\n{text}" for name, text in texts.items()]


def failure_lines(study: Stored | Outcome, where: str) -> list[str]:
    """Lines with at most five failures of a study, the worst first.

    The last line states where the others are.
    """
    missed = missed_rows(study)
    lines = []
    for row in missed[:FAILURES]:
        lines.append(f"{study.name}: FAIL {junit.failure_line(row)}")
    if len(missed) > FAILURES:
        lines.append(f"{study.name}: … {len(missed) - FAILURES} more in {where}")
    return lines


def missed_rows(study: Stored | Outcome) -> list[dict[Any, Any]]:
    """Rows of a verdict that were missed, worst first; what is no number, and baseline, last."""
    rows = study.verdict[is_missed(study.verdict) & (not study.error)]
    worst = (rows["error"] / rows["limit"]).where(rows["error"] < math.inf)
    rows = rows.assign(last=rows["layer"] == "baseline", worst=worst)
    return rows.sort_values(["last", "worst"], ascending=[True, False]).to_dict("records")


def ending(study: Stored | Outcome) -> str:
    """Ending of a study in one line."""
    rows = 0 if study.error else len(study.verdict)
    missed = len(missed_rows(study))
    said = f"{rows - missed} of {rows} held"
    if study.error:
        said = "not finished"
    elif "candidate" in study.origin:
        counts = Counter(study.verdict["verdict"])
        words = ", ".join(f"{word}: {many}" for word, many in sorted(counts.items()))
        said = f"{study.origin['candidate']}, {rows} rows, {words}"
    elif not study.held:
        said = f"FAILED, {rows} row{'s' * (rows != 1)}: {rows - missed} held, {missed} missed"
    return f"{study.name}: {said}" + (f", {study.seconds:.1f} s" if study.seconds else "")


def ending_of_all(outcomes: Sequence[Outcome], seconds: float) -> str:
    """Ending of several studies together, layer by layer."""
    judged, held = Counter[str](), Counter[str]()
    for outcome in outcomes:
        judged.update(outcome.verdict["layer"])
        held.update(outcome.verdict.loc[outcome.verdict["verdict"] == "pass", "layer"])
    layers = [f"{layer} {held[layer]} of {many}" for layer, many in judged.items()]
    whole = f"{sum(each.held for each in outcomes)} of {len(outcomes)} studies held"
    return f"{', '.join([whole, *layers])}, {seconds:.1f} s"
