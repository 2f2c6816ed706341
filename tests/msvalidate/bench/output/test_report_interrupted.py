"""Reports under kill -9 and beside other runs: results are old or new, each study whole."""

import json
import os
import signal
import subprocess
import sys
import time
from functools import partial
from itertools import pairwise
from pathlib import Path

import pytest

from msvalidate.bench.output import report
from msvalidate_check import exchange
from tests.msvalidate.bench.output.test_report import content
from tests.msvalidate.bench.output.test_report import files as drawn_files

ROOT = Path(__file__).parents[4]
files = partial(drawn_files, plots=False)


def test_what_a_killed_run_left_is_cleared_away(tmp_path):
    (tmp_path / f"{exchange.STAGED}{'0' * 16}" / "poisson").mkdir(parents=True)
    report.publish({"poisson": files()}, tmp_path / "r")
    assert [p.name for p in tmp_path.iterdir()] == ["r"]


WRITER = """
import sys
import time
from pathlib import Path
sys.path[:0] = [{root!r}]
from msvalidate.bench.output import report
from msvalidate_check import exchange
from tests.msvalidate.bench.output.test_report_interrupted import files
gap = float(sys.argv[1])
if sys.argv[3:] == ["apart"]:
    exchange.exchange_folders = lambda *_: False
new = {{name: files(name, gap) for name in ("poisson", "displacement")}}
print("ready", flush=True)
while True:
    report.publish(new, Path(sys.argv[2]))
    time.sleep(0.01)  # locks are not fair: leave the other run its turn
"""


def writer(gap, out, *how):
    script = WRITER.format(root=str(ROOT))
    process = subprocess.Popen(
        [sys.executable, "-c", script, str(gap), str(out), *how],
        stdout=subprocess.PIPE,
        text=True,
    )
    process.stdout.readline()
    return process


def rows_of(out, study):
    rows = json.loads((out / "verdict.json").read_bytes())
    found = [row for row in rows if row["study"] == study]
    assert found
    return found


def turns(seen):
    """How often results were another run's than before."""
    return sum(a != b for a, b in pairwise(seen))


def values(out):
    return {row["observed"] for row in json.loads((out / "verdict.json").read_bytes())}


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="needs kill -9")
def test_killed_at_any_instant(tmp_path):
    """Killed while it publishes, again and again, a run leaves old results or new ones, whole."""
    out = tmp_path / "r"
    whole = {}
    for gap in (1.2, 1.4):
        report.publish({n: files(n, gap) for n in ("poisson", "displacement")}, out)
        whole[gap] = content(out)
    for turn in range(8):
        process = writer((1.2, 1.4)[turn % 2], out)
        time.sleep(0.005 * turn)
        process.send_signal(signal.SIGKILL)
        process.wait()
        process.stdout.close()
        assert content(out) in whole.values()
    report.publish({"poisson": files()}, out)
    assert [p.name for p in tmp_path.iterdir()] == ["r"]


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="needs kill -9")
def test_killed_where_folders_cannot_be_exchanged(tmp_path):
    """Studies may then be of two runs, but each is whole, and the next run finds them all."""
    out = tmp_path / "r"
    names = ("poisson", "displacement")
    report.publish({n: files(n, 1.2) for n in names}, out)
    for turn in range(5):
        process = writer((1.4, 1.2)[turn % 2], out, "apart")
        time.sleep(0.007 * turn)
        process.send_signal(signal.SIGKILL)
        process.wait()
        process.stdout.close()
        report.publish({"poisson": files(gap=1.3)}, out)
        assert {row["observed"] for row in rows_of(out, "displacement")} <= {1.2, 1.4}
        assert {row["observed"] for row in rows_of(out, "poisson")} == {1.3}
    assert not list(out.glob(".*"))


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="folders are locked on Unix")
def test_two_runs_at_once_do_not_mix(tmp_path):
    out = tmp_path / "r"
    report.publish({n: files(n, 1.2) for n in ("poisson", "displacement")}, out)
    both = [writer(gap, out) for gap in (1.2, 1.4)]
    seen = []
    try:
        until = time.monotonic() + 60  # a machine in trouble; else the runs take turns at once
        while time.monotonic() < until and turns(seen) < 10:
            seen.append(values(out))
    finally:
        for process in both:
            process.kill()
            process.wait()
            process.stdout.close()
    assert all(len(found) == 1 for found in seen), "both studies are of one run"
    assert turns(seen) == 10, "both have been at it"
