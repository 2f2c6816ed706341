"""`bench.judging.workers`: late rows, rows whose process dies, and lost clusters."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from concurrent.futures import CancelledError, ThreadPoolExecutor
from pathlib import Path
from types import SimpleNamespace

import pytest

from msvalidate.bench.judging import workers
from msvalidate.bench.judging.workers import Cluster, Workers, run_all
from msvalidate.case.report.sweep import Row, finished_row
from msvalidate.cli.program import main
from msvalidate.problem import SolverError

ROOT = Path(__file__).resolve().parents[4]


def test_one_that_is_late_and_one_that_is_killed_are_rows():
    """The limit of calls that end is beyond any wait."""
    made = Workers(1, int)
    calls = [(0.1, time.sleep, 600.0), (600.0, os._exit, 1), (600.0, abs, -3)]
    with ThreadPoolExecutor(1) as thread:
        late, dead, last = [thread.submit(made.run, *each) for each in calls]
    made.close()
    assert [finished_row(each).outcome for each in (late, dead)] == ["too long", "died"]
    assert last.result() == 3  # by another process


class Future:
    """A task of the cluster below; without an answer it waits for ever."""

    def __init__(self, result, state):
        self.answer, self.state = result, state

    def result(self, timeout):
        if self.state.closed:
            raise CancelledError
        if isinstance(self.answer, Exception):
            raise self.answer
        if self.answer is None:
            time.sleep(timeout)
            raise TimeoutError
        return self.answer

    def cancel(self):
        self.answer = None


@pytest.fixture
def cluster(monkeypatch):
    """A cluster in the place of Dask's, with answers of tasks by their order."""
    state = SimpleNamespace(answers=[], threads={"worker": 1}, closed=False)

    class Client:
        def __init__(self, *_words, **_options):
            pass

        def nthreads(self):
            return state.threads if state.answers else {}

        def subscribe_topic(self, _topic, handler):
            self.begin = handler

        def submit(self, *_arguments, key, **_options):
            answer = state.answers.pop(0)
            if answer == "endless":
                self.begin((0, key))
                answer = None
            return Future(answer, state)

        def close(self, timeout):
            state.closed = timeout > 0

    class KilledWorker(Exception):  # noqa: N818  its name there
        pass

    module = SimpleNamespace(Client=Client, KilledWorker=KilledWorker)
    monkeypatch.setitem(sys.modules, "distributed", module)
    monkeypatch.setattr(workers, "POLL", 0.01)
    monkeypatch.setattr(workers, "GRACE", 0.3)
    state.killed = KilledWorker("killed")
    return state


SOLVED = Row("solved", "agrees", 0.01, 0.001)


def test_the_clock_starts_with_the_work(cluster):
    """A task that has not begun is never late."""
    cluster.answers = [None, "left"]
    made, cluster.answers = Cluster("tcp://here"), [None]
    with pytest.raises(SolverError, match="the last worker is lost; start one"):
        list(run_all(abs, [(1,)], made, 0.05))
    cluster.closed = False
    cluster.answers = ["endless", cluster.killed, SOLVED, "left"]
    ended = run_all(abs, [(1,), (2,), (3,)], Cluster("tcp://here"), 0.05)
    outcomes = {each: finished_row(future).outcome for (each,), future in ended}
    assert outcomes == {1: "too long", 2: "died", 3: "solved"}


@pytest.mark.parametrize("who", ["scheduler", "last worker"])
def test_a_lost_cluster_is_one_line_and_a_table_of_known_rows(cluster, tmp_path, capsys, who):
    cluster.answers = [SOLVED, None]

    case = tmp_path / "beam.toml"
    case.write_text((ROOT / "examples" / "box.toml").read_text(encoding="utf-8"), encoding="utf-8")
    words = ["case", "run", str(case), "--out", str(tmp_path), "--scheduler", "tcp://here", "-q"]
    if who == "scheduler":
        cluster.answers[1] = CancelledError("lost")
    assert main([*words, "--set", "springs.cells=2,3"]) == 3
    message = capsys.readouterr().err
    assert f"--scheduler tcp://here: the {who} is lost; start one" in message
    assert message.count("\n") == 1
    table = (tmp_path / "beam-sweep/sweep.csv").read_text(encoding="utf-8").splitlines()
    assert len(table) == 2
    assert table[1].startswith("beam.toml,2,solved,agrees,")


def test_dask_itself(monkeypatch):
    """A real cluster of one thread loses its only worker."""
    pytest.importorskip("distributed")
    code = (
        "from distributed import LocalCluster\n"
        "if __name__ == '__main__':\n"
        "    with LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None) as c:\n"
        "        print(c.scheduler_address, flush=True); input()\n"
    )
    monkeypatch.setattr(workers, "GRACE", 2.0)
    with subprocess.Popen(
        [sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        try:
            made = Cluster(process.stdout.readline().strip())
            rows = run_all(max, [(1, 2), (3, 4)], made, 60.0)
            assert sorted(future.result() for _, future in rows) == [2, 4]
            made = Cluster(made._whose.split()[1])
            rows = run_all(time.sleep, [(0.0,), (600.0,)], made, 600.0)
            assert next(rows)[0] == (0.0,)
            process.kill()
            with pytest.raises(SolverError, match="is lost; start one"):
                next(rows)
        finally:
            process.kill()
