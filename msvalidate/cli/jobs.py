"""Studies run one after another or side by side, each in a process of its own.

Each worker has an executor to itself: if its process dies, that costs the study that it was at, and
no other. What a study finds does not depend on which worker it ran on, or beside what.
"""

from __future__ import annotations

import contextlib
import gc
import multiprocessing
import signal
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from datetime import UTC, datetime

from msvalidate.bench.judging import catalogue
from msvalidate.bench.judging.sweep import end_with_parent
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
    todo = deque(tasks)
    names = tuple(task.name for task in tasks)
    idle = [_worker(names) for _ in range(min(jobs, len(todo)))]
    busy: dict[Future[Outcome], tuple[Task, datetime, ProcessPoolExecutor]] = {}
    try:
        while todo or busy:
            while todo and idle:
                task, worker = todo.popleft(), idle.pop()
                began(task.name)
                with _defer_interrupt():
                    busy[worker.submit(run_task, task)] = task, datetime.now(UTC), worker
            for future in wait(busy, return_when=FIRST_COMPLETED).done:
                task, started, worker = busy.pop(future)
                error = future.exception()
                if isinstance(error, BrokenProcessPool):
                    worker.shutdown()
                    worker = _worker(names)
                idle.append(worker)
                yield future.result() if error is None else unfinished(task, started, error)
    except BaseException:  # an interrupt, or nobody asks for the rest
        for process in multiprocessing.active_children():
            process.terminate()
        raise
    finally:
        for worker in [*idle, *(worker for _, _, worker in busy.values())]:
            worker.shutdown()


def _worker(names: Sequence[str]) -> ProcessPoolExecutor:
    """An executor of one process, which starts with its first study."""
    # Spawned: a fork would copy locks of libraries that other threads hold.
    context = multiprocessing.get_context("spawn")
    return ProcessPoolExecutor(1, context, initializer=_prepare, initargs=(tuple(names),))


def _prepare(names: Sequence[str]) -> None:
    """Make a process a worker: it loads the studies, and ends with the process that started it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # which is told, and ends the workers
    end_with_parent()
    for name in names:
        catalogue.load(name)
    gc.freeze()  # the libraries' objects stay: no use in looking through them again and again


@contextlib.contextmanager
def _defer_interrupt() -> Iterator[None]:
    """Hold an interrupt back; processes that are started meanwhile never hear of any."""
    if not hasattr(signal, "pthread_sigmask"):  # not a Unix
        yield
        return
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
