"""One study from its run to its files: judged, compared with the baseline, drawn.

What comes of it can be sent from one process to another, so that studies may run side by side.
"""

from __future__ import annotations

import inspect
import time
import traceback
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Literal

import pandas as pd

from msvalidate.cli.candidates import load_candidate, shown_name
from msvalidate.judging import catalogue
from msvalidate.judging.evidence import Evidence, all_passed, judge
from msvalidate.judging.foreign import judge_candidate
from msvalidate.judging.sweep import Setting
from msvalidate.output import baseline, stored
from msvalidate.output.junit import printable
from msvalidate.output.provenance import collect_provenance
from msvalidate.output.results import Results
from msvalidate.output.stored import Result
from msvalidate.problem import ProblemError, SolverError
from msvalidate.problem.checks import require_type
from msvalidate.problem.records import dataclass, field, replace

Fault = Literal["", "problem", "solver", "crash"]
"""Why a study did not finish: an ill-posed question, no trustworthy answer, anything else."""


@dataclass(frozen=True)
class Task:
    """A study to be run.

    Parameters
    ----------
    name
        Of the study.
    setting
        How it is run.
    command
        The command line in words, for the report.
    plots
        Whether its figures are drawn.
    against
        Folder of the baseline that its tables are held to, of the form that is run; None for none.
    results
        What other studies found, for one that puts that together; None for others.
    candidate
        Whom it judges, as ``module:function`` or ``file.py:function``; "" for our own.
    accuracy
        That the candidate is said to have; None for single precision.
    questions
        Of the study that are asked; None asks all.
    """

    name: str
    setting: Setting
    command: tuple[str, ...] = ()
    plots: bool = True
    against: Path | None = None
    results: Results | None = None
    candidate: str = ""
    accuracy: float | None = None
    questions: tuple[str, ...] | None = None

    @property
    def form(self) -> str:
        """Of the study, "quick" or "full"."""
        return "quick" if self.setting.quick else "full"


@dataclass(frozen=True, eq=False)
class Outcome:
    """How a study ended.

    Parameters
    ----------
    name, question
        Its name and its whole docstring.
    seconds
        That the study itself took, by the clock, its figures not among them.
    origin
        Provenance, label -> value.
    result
        What it found, with its judgement and without its figures; None if it did not finish.
    files
        Name -> content, of a study that finished.
    error, said, trace
        Why it did not finish, or "": for the report, for the terminal, and where that was.
    fault
        The kind of that.
    compared
        Whether its tables were held to a baseline.
    """

    name: str
    question: str
    seconds: float
    origin: Mapping[str, str]
    result: Result | None = None
    files: Mapping[str, bytes] = field(default_factory=dict)
    error: str = ""
    said: str = ""
    trace: str = ""
    fault: Fault = ""
    compared: bool = False

    @property
    def verdict(self) -> pd.DataFrame:
        """Its judgement; without rows if it did not finish."""
        return stored.nothing_judged() if self.result is None else self.result.verdict

    @property
    def held(self) -> bool:
        """Whether it finished, judged something, and all that it judged passed."""
        return not self.error and all_passed(self.verdict)


class Clock:
    """When a study began, and how many seconds it has taken since."""

    def __init__(self) -> None:
        self.started, self._began = datetime.now(UTC), time.perf_counter()

    @property
    def seconds(self) -> float:
        """Since the beginning (s)."""
        return time.perf_counter() - self._began


def run_task(task: Task) -> Outcome:
    """Run a study, judge it, compare its tables and draw its figures; report any error.

    A study that ends the program, as libraries may, has crashed; an interrupt comes through.
    """
    clock = Clock()
    try:
        evidence, verdict = _judged(task)
        seconds, rows = clock.seconds, []
        if task.against:
            rows = baseline.compare(evidence, task.against / task.name)
            verdict = pd.concat([verdict, pd.DataFrame(rows)], ignore_index=True)
        result = Result(task.name, catalogue.docstring(task.name), evidence, verdict)
        origin = _origin(task, clock, seconds)
        files = stored.result_files(result, origin, seconds=seconds, plots=task.plots)
    except (ProblemError, SolverError) as error:
        said = printable(str(error))
        kind: Fault = "problem" if isinstance(error, ProblemError) else "solver"
        return unfinished_outcome(task, clock, kind, said, said, traceback.format_exc())
    except (Exception, SystemExit) as error:  # noqa: BLE001
        return crashed_outcome(task, clock, error)
    # Functions that draw may be of any kind, and not all can be sent to another process.
    found = replace(result, evidence=replace(evidence, figures={}))
    return Outcome(task.name, found.question, seconds, origin, found, files, compared=bool(rows))


def _judged(task: Task) -> tuple[Evidence, pd.DataFrame]:
    """What a study found, and its verdict by its own limits, or by those for a candidate."""
    run = catalogue.load(task.name).run
    if task.questions is not None and "questions" not in inspect.signature(run).parameters:
        raise ProblemError(f"--questions: {task.name} has one question only; leave it out")
    if task.candidate:
        candidate = load_candidate(task.candidate)
        found = judge_candidate(run, candidate, task.setting, task.questions, task.accuracy)
        return found.evidence, found.verdict
    given: dict[str, object] = {} if task.results is None else {"candidate": task.results}
    if task.questions is not None:
        given["questions"] = task.questions
    evidence = run(setting=task.setting, **given)
    require_type("what its run returns", evidence, Evidence)
    return evidence, judge(evidence)


def _origin(task: Task, clock: Clock, seconds: float) -> dict[str, str]:
    """Provenance of a study's results; of a candidate or of some questions it says so."""
    found = collect_provenance(
        task.command, task.setting.seed, clock.started, seconds, form=task.form
    )
    if task.candidate:
        found["candidate"] = printable(shown_name(task.candidate))
    if task.questions is not None:
        found["questions"] = f"{', '.join(task.questions)}; the others were not asked"
    return found


def crashed_outcome(task: Task, clock: Clock, error: BaseException) -> Outcome:
    """The outcome of a study that ended with an unexpected exception."""
    kind = type(error).__name__
    # What a crash says may hold paths of this machine: for the terminal, not the report.
    said = f"crashed: {kind}: {printable(str(error))}"
    trace = "".join(traceback.format_exception(error))
    return unfinished_outcome(task, clock, "crash", f"crashed: {kind}", said, trace)


def unfinished_outcome(
    task: Task, clock: Clock, fault: Fault, error: str, said: str, trace: str = ""
) -> Outcome:
    """The outcome of a study that did not finish."""
    seconds = clock.seconds
    origin = _origin(task, clock, seconds)
    question = catalogue.docstring(task.name)
    return Outcome(
        task.name, question, seconds, origin, error=error, said=said, trace=trace, fault=fault
    )
