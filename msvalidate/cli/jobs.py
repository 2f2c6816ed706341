"""Studies run one after another or side by side, each in a process of its own.

Each worker has an executor to itself: if its process dies, that costs the study that it was at, and
no other. What a study finds does not depend on which worker it ran on, or beside what.
"""

from __future__ import annotations

import contextlib
import gc
from collections.abc import Callable, Generator, Sequence
from datetime import UTC, datetime

from msvalidate.bench.judging import catalogue
from msvalidate.bench.judging.workers import Workers, run_all
from msvalidate.cli.outcome import Outcome, Task, run_task, unfinished


def run_tasks(tasks: Sequence[Task], jobs: int, began: Callable[[str], None]) -> Generator[Outcome]:
    """Outcomes of studies as they end, in any order; with one job in the order given.

    Close it to leave the rest: what is running is then stopped. So many `jobs` run at once, each a
    process; 1 is this process itself. Those that stand alone (see `catalogue.alone`) run after the
    others, with none beside them. `began` is told the name of each study as it begins.
    """
    if jobs == 1 or len(tasks) < 2:
        for task in tasks:
            began(task.name)
            yield run_task(task)
        return
    alone = [task for task in tasks if catalogue.alone(task.name)]
    yield from _run_in_parallel([task for task in tasks if task not in alone], jobs, began)
    yield from _run_in_parallel(alone, 1, began)


def _run_in_parallel(
    tasks: Sequence[Task], jobs: int, began: Callable[[str], None]
) -> Generator[Outcome]:
    started: dict[str, datetime] = {}

    def begin(task: Task) -> None:
        started[task.name] = datetime.now(UTC)
        began(task.name)

    calls, names = [(task,) for task in tasks], [task.name for task in tasks]
    workers = Workers(min(jobs, len(tasks)) or 1, _load, names)
    with contextlib.closing(run_all(run_task, calls, workers, on_start=begin)) as ended:
        for (task,), future in ended:
            error = future.exception()
            yield unfinished(task, started[task.name], error) if error else future.result()


def _load(names: Sequence[str]) -> None:
    """Load studies in a worker, before they are timed."""
    for name in names:
        catalogue.load(name)
    gc.freeze()  # the libraries' objects stay: no use in looking through them again and again
