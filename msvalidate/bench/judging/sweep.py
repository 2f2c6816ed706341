"""Execution of a study: quick or full mode, seed and workers."""

from __future__ import annotations

import multiprocessing
import os
import threading
from collections.abc import Callable, Iterable
from concurrent.futures import Executor
from typing import TYPE_CHECKING, TypeVar

from msvalidate.bench.judging import catalogue
from msvalidate.problem import ProblemError
from msvalidate.problem.checks import format_value, require_type, whole_number
from msvalidate.problem.progress import report_step
from msvalidate.problem.records import dataclass, replace

if TYPE_CHECKING:
    from msvalidate.bench.judging.evidence import Evidence

Case = TypeVar("Case")
Result = TypeVar("Result")
MOST_SEED = 2**63 - 1
"""Largest seed: one that a table of any kind can hold."""
ORPHANED = 1
"""Exit code of a worker that nobody waits for any more."""


@dataclass(frozen=True)
class Setting:
    """Settings of a study. The numbers depend on `quick` and `seed` alone.

    Parameters
    ----------
    quick
        The small form: fewer sizes, the same tolerances.
    seed
        Where random numbers start, if the study draws any.
    executor
        Runs the cases of a sweep: any `concurrent.futures` executor, or the one that a Dask
        client's ``get_executor()`` returns. None runs them here, one after another.
    """

    quick: bool = False
    seed: int = 0
    executor: Executor | None = None

    def __post_init__(self) -> None:
        require_type("quick", self.quick, bool)
        whole_number("seed", self.seed, 0, MOST_SEED)
        if not (self.executor is None or callable(getattr(self.executor, "map", None))):
            raise ProblemError(
                f"executor: {format_value(self.executor)}; give a concurrent.futures executor or "
                f"None"
            )

    def sweep(
        self, function: Callable[[Case], Result], cases: Iterable[Case], label: str
    ) -> list[Result]:
        """Results of the function, in the order of the cases whatever the workers.

        Raises
        ------
        ProblemError
            If it is no function or these are no cases. What the function raises comes through.
        """
        if not callable(function) or not isinstance(cases, Iterable):
            raise ProblemError(
                f"sweep: {format_value(function)} over {format_value(cases)}; give a function and "
                f"its cases"
            )
        todo = list(cases)
        run = map if self.executor is None else self.executor.map
        found = list[Result]()
        for result in run(function, todo):
            found.append(result)
            report_step("%s: %d of %d cases", label, len(found), len(todo))
        return found

    def one_by_one(
        self, function: Callable[[Case], Result], cases: Iterable[Case], label: str
    ) -> list[Result]:
        """As `sweep`, but here and in turn whatever the workers: what is timed runs alone."""
        return replace(self, executor=None).sweep(function, cases, label)


FULL = Setting()
"""The whole study, its cases one after another."""


def run(study: str, *, quick: bool = False) -> Evidence:
    """Run a study in this process and return its evidence with its tables.

    Parameters
    ----------
    study
        Name of a study, such as "poisson".
    quick
        True for quick mode: fewer sizes, the same tolerances.

    Raises
    ------
    ProblemError
        If there is no such study, or it combines the results of others.

    Examples
    --------
    >>> import msvalidate as ms
    >>> table = ms.run("poisson", quick=True).tables["summary"]  # doctest: +SKIP
    """
    if study not in catalogue.names():
        raise ProblemError(f"study {study!r}: {catalogue.suggestion(study, catalogue.names())}")
    if catalogue.reads_results(study):
        command = f"python -m msvalidate.study {study}"
        raise ProblemError(f"study {study!r}: combines results of others; run `{command}`")
    evidence: Evidence = catalogue.load(study).run(setting=Setting(quick=quick))
    return evidence


def end_with_parent() -> None:
    """End this worker process together with its parent, even if that is killed."""
    parent = multiprocessing.parent_process()

    def end() -> None:
        if parent is not None:
            parent.join()
            os._exit(ORPHANED)

    threading.Thread(target=end, daemon=True).start()
