"""Calls run side by side: in processes of this machine, or on a Dask cluster.

The time limit of a call starts with its work. A call that is late, or whose process dies, costs no
other; a lost cluster costs all that are left.
"""

from __future__ import annotations

import importlib
import math
import multiprocessing
import secrets
import signal
import time
from collections.abc import Callable, Generator, Iterable
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Future,
    ProcessPoolExecutor,
    ThreadPoolExecutor,
    wait,
)
from queue import SimpleQueue
from typing import Any

from msvalidate.bench.judging.sweep import end_with_parent
from msvalidate.problem import ProblemError, SolverError

POLL, GRACE = 1.0, 60.0
"""Seconds between looks at a cluster, and without any worker until it counts as lost."""
TOPIC = "msvalidate calls"
"""Topic of the events of a cluster by which calls announce their start."""


class Workers:
    """Processes of this machine, each with one call at a time.

    Parameters
    ----------
    jobs
        Number of processes.
    prepare, arguments
        A function that each process calls first, outside the time limit, and its arguments.
    """

    def __init__(self, jobs: int, prepare: Callable[..., Any], *arguments: Any) -> None:
        self.slots, self._prepare = jobs, (prepare, *arguments)
        self._idle: SimpleQueue[ProcessPoolExecutor | None] = SimpleQueue()
        self._all: list[ProcessPoolExecutor] = []
        for _ in range(jobs):
            self._idle.put(None)

    def run(self, limit: float | None, function: Callable[..., Any], *arguments: Any) -> Any:
        """Result of a function; its process is killed if it takes longer than `limit` seconds.

        Raises TimeoutError if it is late, BrokenExecutor if its process died.
        """
        slot = self._idle.get()
        try:
            if slot is None:
                slot = self._start()
            return slot.submit(function, *arguments).result(limit)
        except (TimeoutError, BrokenExecutor):
            if slot is not None:
                _kill(slot)
            slot = None
            raise
        finally:
            self._idle.put(slot)

    def _start(self) -> ProcessPoolExecutor:
        # Spawned: a fork would copy locks of libraries that other threads hold.
        context = multiprocessing.get_context("spawn")
        slot = ProcessPoolExecutor(1, context, initializer=_begin, initargs=self._prepare)
        self._all.append(slot)
        if hasattr(signal, "pthread_sigmask"):  # of this thread, and of the process that it starts
            signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        slot.submit(int).result()
        return slot

    def refuse_lost(self) -> None:
        """Do nothing: processes that die are replaced."""

    def close(self) -> None:
        """End all processes."""
        for slot in self._all:
            _kill(slot)


def _begin(prepare: Callable[..., Any], *arguments: Any) -> None:
    """Make a process a worker, which ends with its parent and leaves interrupts to it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    end_with_parent()
    prepare(*arguments)


def _kill(slot: ProcessPoolExecutor) -> None:
    for process in dict(getattr(slot, "_processes", None) or {}).values():
        process.kill()
    slot.shutdown(wait=False, cancel_futures=True)


class Cluster:
    """Workers of a Dask cluster; a call that is late is abandoned there."""

    def __init__(self, address: str) -> None:
        self._whose = f"--scheduler {address}"
        try:
            self._dask = importlib.import_module("distributed")  # an extra
            self._client = self._dask.Client(address, timeout="10s", set_as_default=False)
        except ImportError as error:
            raise ProblemError("--scheduler: needs dask; pip install msvalidate[dask]") from error
        except (OSError, ValueError, TimeoutError) as error:
            raise ProblemError(f"{self._whose}: {error}; start one there") from error
        self.slots = max(1, sum(self._client.nthreads().values()))
        self._began: dict[str, float] = {}
        self._alive = time.monotonic()
        self._client.subscribe_topic(TOPIC, self._note)

    def _note(self, event: tuple[Any, str]) -> None:
        """Start the clock of a call when its worker has begun."""
        self._began[event[1]] = time.monotonic()

    def run(self, limit: float | None, function: Callable[..., Any], *arguments: Any) -> Any:
        """Result of a function; errors as of `Workers.run`, or what killed its workers."""
        name = secrets.token_hex(16)
        options = {"key": name, "retries": 0, "pure": False}
        future = self._client.submit(_announce, name, function, *arguments, **options)
        while True:
            try:
                return future.result(POLL)
            except TimeoutError:
                if time.monotonic() - self._began.get(name, math.inf) > (limit or math.inf):
                    future.cancel()
                    raise
            except CancelledError as error:
                raise self._lost("scheduler") from error

    def refuse_lost(self) -> None:
        """Raise `SolverError` if the scheduler does not answer, or no worker is there for long."""
        try:
            workers = self._client.nthreads()
        except (OSError, ValueError, RuntimeError) as error:
            raise self._lost("scheduler") from error
        if workers:
            self._alive = time.monotonic()
        elif time.monotonic() - self._alive > GRACE:
            raise self._lost("last worker")

    def _lost(self, what: str) -> SolverError:
        return SolverError(f"{self._whose}: the {what} is lost; start one, and run this again")

    def close(self) -> None:
        """Leave the cluster."""
        self._client.close(timeout=POLL)


def _announce(name: str, function: Callable[..., Any], *arguments: Any) -> Any:
    """Tell the client that a call begins, on its worker; then call."""
    importlib.import_module("distributed").get_worker().log_event(TOPIC, name)
    return function(*arguments)


def run_all(
    function: Callable[..., Any],
    calls: Iterable[tuple[Any, ...]],
    workers: Workers | Cluster,
    limit: float | None = None,
    on_start: Callable[..., None] = lambda *_: None,
) -> Generator[tuple[tuple[Any, ...], Future[Any]]]:
    """Arguments of calls with their finished futures, in any order.

    Parameters
    ----------
    function, calls
        A function, and the arguments of each call.
    workers
        Who calls; they are closed at the end, and if the iterator is.
    limit
        Seconds for each call; None sets no limit.
    on_start
        Receives the arguments of each call that begins.
    """

    def call(*arguments: Any) -> Any:
        on_start(*arguments)
        return workers.run(limit, function, *arguments)

    threads = ThreadPoolExecutor(workers.slots)
    try:
        running = {threads.submit(call, *each): each for each in calls}
        while running:
            ended = wait(running, POLL, FIRST_COMPLETED).done
            for future in sorted(ended, key=lambda item: item.exception() is not None):
                yield running.pop(future), future  # results first: an error may end the iteration
            workers.refuse_lost()
    finally:
        threads.shutdown(wait=False, cancel_futures=True)
        workers.close()
