"""Execution of a study: verdict, comparison with the baseline, figures and files.

What comes of it can be sent from one process to another, so that studies may run side by side.
"""

from __future__ import annotations

import argparse
import inspect
import traceback
from collections.abc import Mapping
from concurrent.futures.process import BrokenProcessPool
from datetime import UTC, datetime
from pathlib import Path

import pandas as pd

from msvalidate.bench.judging import catalogue
from msvalidate.bench.judging.evidence import Evidence, all_passed, judge
from msvalidate.bench.judging.foreign import judge_candidate
from msvalidate.bench.judging.sweep import Setting
from msvalidate.bench.output import baseline, stored
from msvalidate.bench.output.junit import printable
from msvalidate.bench.output.provenance import collect_provenance
from msvalidate.bench.output.results import Results
from msvalidate.bench.output.stored import Result
from msvalidate.cli.arguments import FAILED, HELD, USAGE, as_shown
from msvalidate.cli.candidates import load_candidate, shown_name
from msvalidate.problem import ProblemError, SolverError
from msvalidate.problem.checks import require_type
from msvalidate.problem.records import dataclass, field, replace

DIED = "crashed: its process died"


@dataclass(frozen=True)
class Task:
    """A study to be run as the options of a command, `args`, say.

    Its tables are held `against` a folder, of the form that is run. One that puts together what
    others found is given their `results`.
    """

    name: str
    args: argparse.Namespace
    against: Path | None = None
    results: Results | None = None


@dataclass(frozen=True, eq=False)
class Outcome:
    """Outcome of a study: name, docstring, seconds without figures, and provenance.

    One that finished has a result, without its figures, and files (name -> content); it may lack
    a baseline that its tables could be held to. One that did not has an exit `code`, and why, for
    the report (`error`) and the terminal (`said`), and where it crashed (`trace`).
    """

    name: str
    question: str
    seconds: float
    origin: Mapping[str, str]
    result: Result | None = None
    files: Mapping[str, bytes] = field(default_factory=dict)
    lacks_baseline: bool = False
    code: int = HELD
    error: str = ""
    said: str = ""
    trace: str = ""

    @property
    def verdict(self) -> pd.DataFrame:
        """Verdict of the study, without rows if it did not finish."""
        return stored.nothing_judged() if self.result is None else self.result.verdict

    @property
    def held(self) -> bool:
        """True if the study finished, judged something, and all of it passed."""
        return not self.error and all_passed(self.verdict)

    def files_beside(self, folder: Path) -> dict[str, bytes]:
        """Files of a study that did not finish, by those in its folder."""
        return stored.unfinished_files(folder, self.question, self.origin, self.error, self.seconds)


def run_task(task: Task) -> Outcome:
    """Run a study, judge it, compare its tables and draw its figures; report any error.

    A study that ends the program, as libraries may, has crashed; an interrupt comes through.
    """
    started, rows = datetime.now(UTC), []
    try:
        evidence, verdict = _judged(task)
        seconds = _since(started)
        if task.against:
            rows = baseline.compare(evidence.tables, task.against / task.name, evidence.rounding)
            verdict = pd.concat([verdict, pd.DataFrame(rows)], ignore_index=True)
        result = Result(task.name, catalogue.docstring(task.name), evidence, verdict)
        origin = _origin(task, started, seconds)
        files = stored.result_files(result, origin, seconds=seconds, plots=task.args.plots)
    except (Exception, SystemExit) as error:  # noqa: BLE001
        return unfinished(task, started, error)
    lacks = bool(task.against and evidence.tables and not rows)
    # Functions that draw may be of any kind, and not all can be sent to another process.
    found = replace(result, evidence=replace(evidence, figures={}))
    return Outcome(task.name, found.question, seconds, origin, found, files, lacks)


def unfinished(task: Task, started: datetime, error: BaseException) -> Outcome:
    """The outcome of a study that ended with an exception, or whose process died."""
    seconds, trace = _since(started), ""
    said = why = printable(str(error))
    if isinstance(error, BrokenProcessPool):
        why, said = DIED, f"{DIED}, killed or out of memory; run it with --jobs 1"
    elif not isinstance(error, ProblemError | SolverError):
        # What a crash says may hold paths of this machine: for the terminal, not the report.
        why = f"crashed: {type(error).__name__}"
        said, trace = f"{why}: {said}", "".join(traceback.format_exception(error))
    code = USAGE if isinstance(error, ProblemError) else FAILED
    origin, question = _origin(task, started, seconds), catalogue.docstring(task.name)
    return Outcome(
        task.name, question, seconds, origin, code=code, error=why, said=said, trace=trace
    )


def _since(started: datetime) -> float:
    return (datetime.now(UTC) - started).total_seconds()


def _judged(task: Task) -> tuple[Evidence, pd.DataFrame]:
    """Evidence of a study and its verdict, by its own limits or a candidate's."""
    run, args = catalogue.load(task.name).run, task.args
    setting = Setting(quick=args.form == "quick", seed=args.seed)
    if args.questions is not None and "questions" not in inspect.signature(run).parameters:
        raise ProblemError(f"--questions: {task.name} has one question only; leave it out")
    if args.candidate:
        candidate = load_candidate(args.candidate)
        found = judge_candidate(run, candidate, setting, args.questions, args.accuracy)
        return found.evidence, found.verdict
    given: dict[str, object] = {"candidate": task.results, "questions": args.questions}
    given = {name: value for name, value in given.items() if value is not None}
    evidence = run(setting=setting, **given)
    require_type("what its run returns", evidence, Evidence)
    return evidence, judge(evidence)


def _origin(task: Task, started: datetime, seconds: float) -> dict[str, str]:
    """Provenance of a study's results; of a candidate or of some questions it says so."""
    args = task.args
    command = as_shown(args.words)
    found = collect_provenance(command, args.seed, started, seconds, form=args.form)
    if args.candidate:
        found["candidate"] = printable(shown_name(args.candidate))
    if args.questions is not None:
        found["questions"] = f"{', '.join(args.questions)}; the others were not asked"
    return found
