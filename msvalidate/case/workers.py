"""Rows of a sweep by workers: processes of this machine, or a Dask cluster.

The time limit of a row starts with its work. Rows that come too late, or whose process dies, are
rows too; a lost cluster is an error.
"""

from __future__ import annotations

import importlib
import math
import multiprocessing
import secrets
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    ProcessPoolExecutor,
    ThreadPoolExecutor,
    wait,
)
from queue import SimpleQueue
from typing import Any, Literal

import msgspec

from msvalidate.judging.sweep import end_with_parent
from msvalidate.problem import ProblemError, SolverError

LATE, DIED = "too long", "died"
POLL, GRACE = 1.0, 60.0
"""Seconds between looks at a cluster, and without any worker until it counts as lost."""
TOPIC = "msvalidate rows"
"""Topic of the events of a cluster by which tasks announce their start."""


class Row(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Result of a combination as its file stores it; difference and uncertainty if solved."""

    outcome: Literal["solved", "refused", "failed", "too long", "died"]
    verdict: str = ""
    difference: float | None = None
    uncertainty: float | None = None
    message: str = ""
    seconds: float = 0.0


def make_row(began: float, outcome: Any, message: str, verdict: str = "", *numbers: float) -> Row:
    """The row of a combination that began at a time (s) of the monotonic clock."""
    difference, uncertainty = numbers or (None, None)
    seconds = round(time.monotonic() - began, 3)
    return Row(outcome, verdict, difference, uncertainty, " ".join(message.split()), seconds)


class Workers:
    """Processes of this machine, one combination at a time each: one that is late is killed."""

    def __init__(self, jobs: int) -> None:
        self.slots = jobs
        self._idle: SimpleQueue[ProcessPoolExecutor | None] = SimpleQueue()
        self._all: list[ProcessPoolExecutor] = []
        for _ in range(jobs):
            self._idle.put(None)

    def run(self, limit: float, function: Callable[..., Row], *arguments: Any) -> Row:
        """Result of a function, or why there is none in `limit` seconds; start-up not counted."""
        slot, began = self._idle.get(), time.monotonic()
        try:
            if slot is None:
                slot, began = self._start(function.__module__), time.monotonic()
            return slot.submit(function, *arguments).result(limit)
        except (TimeoutError, BrokenExecutor) as error:
            if slot is not None:
                _kill(slot)
            slot = None
            if isinstance(error, TimeoutError):
                return make_row(began, LATE, f"longer than {limit:g} s")
            return make_row(began, DIED, str(error))
        finally:
            self._idle.put(slot)

    def _start(self, module: str) -> ProcessPoolExecutor:
        context = multiprocessing.get_context("spawn")
        slot = ProcessPoolExecutor(1, context, initializer=_prepare, initargs=(module,))
        self._all.append(slot)
        slot.submit(int).result()
        return slot

    def refuse_lost(self) -> None:
        """Do nothing: processes that die are replaced."""

    def close(self) -> None:
        """End all processes."""
        for slot in self._all:
            _kill(slot)


def _prepare(module: str) -> None:
    """Import a module in a new process, which ends with its parent."""
    end_with_parent()
    importlib.import_module(module)


def _kill(slot: ProcessPoolExecutor) -> None:
    for process in dict(getattr(slot, "_processes", None) or {}).values():
        process.kill()
    slot.shutdown(wait=False, cancel_futures=True)


class Cluster:
    """Workers of a Dask cluster: a combination that is late is abandoned; one that kills, fails."""

    def __init__(self, address: str) -> None:
        try:
            self._dask = importlib.import_module("distributed")  # an extra
        except ImportError as error:
            raise ProblemError("--scheduler: needs dask; pip install msvalidate[dask]") from error
        self._whose = f"--scheduler {address}"
        try:
            self._client = self._dask.Client(address, timeout="10s", set_as_default=False)
        except (OSError, ValueError, TimeoutError) as error:
            raise ProblemError(f"{self._whose}: {error}; start one there") from error
        self.slots = max(1, sum(self._client.nthreads().values()))
        self._began: dict[str, float] = {}
        self._alive = time.monotonic()
        self._client.subscribe_topic(TOPIC, self._note)

    def _note(self, event: tuple[Any, str]) -> None:
        """Start the clock of a task when its worker has begun."""
        self._began[event[1]] = time.monotonic()

    def run(self, limit: float, function: Callable[..., Row], *arguments: Any) -> Row:
        """Result of a function, or why there is none in `limit` seconds after its start."""
        name = f"msvalidate-{secrets.token_hex(8)}"
        options = {"key": name, "retries": 0, "pure": False}
        future = self._client.submit(_announce, name, function, *arguments, **options)
        while True:
            began = self._began.get(name, math.inf)
            try:
                return future.result(POLL)  # type: ignore[no-any-return]
            except TimeoutError:
                if time.monotonic() - began > limit:
                    future.cancel()
                    return make_row(began, LATE, f"longer than {limit:g} s")
            except self._dask.KilledWorker as error:
                return make_row(min(began, time.monotonic()), DIED, str(error))
            except CancelledError as error:
                raise self._lost("the scheduler") from error

    def refuse_lost(self) -> None:
        """Raise `SolverError` if the scheduler does not answer, or no worker is there for long."""
        try:
            workers = self._client.nthreads()
        except (OSError, ValueError, RuntimeError, TimeoutError) as error:
            raise self._lost("the scheduler") from error
        if workers:
            self._alive = time.monotonic()
        elif time.monotonic() - self._alive > GRACE:
            raise self._lost("the last worker")

    def _lost(self, whose: str) -> SolverError:
        return SolverError(f"{self._whose}: {whose} is lost; start one, and run the command again")

    def close(self) -> None:
        """Leave the cluster."""
        self._client.close(timeout=POLL)


def _announce(name: str, function: Callable[..., Row], *arguments: Any) -> Row:
    """Tell the client that a task begins, on its worker; then run it."""
    importlib.import_module("distributed").get_worker().log_event(TOPIC, name)
    return function(*arguments)


def run_all(
    function: Callable[..., Row],
    requests: Iterable[tuple[Any, ...]],
    workers: Workers | Cluster,
    limit: float,
) -> Iterator[tuple[tuple[Any, ...], Row]]:
    """Arguments of a function and its rows, in any order; each call gets `limit` (s)."""
    threads = ThreadPoolExecutor(workers.slots)
    try:
        running = {threads.submit(workers.run, limit, function, *each): each for each in requests}
        while running:
            for future in wait(running, POLL, FIRST_COMPLETED).done:
                yield running.pop(future), future.result()
            workers.refuse_lost()
    finally:
        threads.shutdown(wait=False, cancel_futures=True)
        workers.close()
