"""Processes of their own for tests with a fault: forks of one that has the libraries imported."""

from __future__ import annotations

import importlib
import json
import os
import resource
import signal
import sys
import time
import traceback
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[2]
OPTIONS = [
    "-q", "-p", "no:cacheprovider", "--hypothesis-seed=0",
    "-W", "ignore::pytest.PytestAssertRewriteWarning",  # imported before, for all faults at once
]  # fmt: skip


def prepare() -> None:
    """Import others' packages once: a fault's process is a fork of this one."""
    resource.setrlimit(resource.RLIMIT_AS, (8 << 30, 8 << 30))
    for name in (
        "hypothesis", "hypothesis.strategies", "hypothesis.extra.numpy", "jinja2", "matplotlib",
        "matplotlib.pyplot", "meshio", "numba", "numpy", "pandas", "pyamg", "pytest",
        "_pytest.assertion.rewrite", "scipy.integrate", "scipy.interpolate", "scipy.optimize",
        "scipy.sparse.linalg", "scipy.spatial", "scipy.special", "scipy.stats", "shapely",
        "skfem", "skfem.helpers",
    ):  # fmt: skip
        importlib.import_module(name)
    from hypothesis import Phase, settings  # noqa: PLC0415

    # A failing example is enough: few are tried, none is made smaller, stored, or looked at twice.
    made = settings.__init__

    def few(self: settings, parent: settings | None = None, **given: Any) -> None:
        made(self, parent, **given | {"max_examples": min(given.get("max_examples", 10), 10)})

    settings.__init__ = few
    settings.register_profile(
        "mutants",
        phases=[Phase.explicit, Phase.generate],
        database=None,
        deadline=None,
        report_multiple_bugs=False,
    )
    settings.load_profile("mutants")


def forked(work, tree: Path, out: Path, limit: int, *, cold: bool = False) -> tuple[object, float]:
    """Do some work in a process of its own, in the tree; return its exit code and its seconds."""
    cache = out / ("cold" if cold else "warm")
    cache.mkdir(exist_ok=True)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    child = os.fork()
    if not child:
        code = 70
        try:
            _enter(tree, out, cache, limit)
            code = int(work())
        except BaseException:  # noqa: BLE001  nothing may run on as a second parent
            traceback.print_exc()
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(code)
    ends = time.monotonic() + 4 * limit  # asleep, it takes no processor time
    while True:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            break
        if time.monotonic() > ends:
            os.killpg(child, signal.SIGKILL)
            os.waitpid(child, 0)
            return "timeout", float(limit)
        time.sleep(0.05)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    if os.WIFSIGNALED(status):
        late = os.WTERMSIG(status) in (signal.SIGXCPU, signal.SIGKILL)
        return "timeout" if late else "crash", seconds
    return os.WEXITSTATUS(status), seconds


def _enter(tree: Path, out: Path, cache: Path, limit: int) -> None:
    import numba  # noqa: PLC0415

    os.setpgid(0, 0)
    resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 5))
    os.chdir(tree)
    ours = [str(tree), str(tree / "checker")]
    os.environ |= {"PYTHONPATH": os.pathsep.join(ours), "NUMBA_CACHE_DIR": str(cache)}
    numba.config.CACHE_DIR = str(cache)
    others = {ROOT, ROOT / "checker"}
    sys.path[:] = [*ours, *(p for p in sys.path if Path(p or ".").resolve() not in others)]
    text = os.open(out / "output.txt", os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    for stream in (1, 2):
        os.dup2(text, stream)


def tested_by(tests: list[str]) -> int:
    return pytest.main([*OPTIONS, "-x", "--tb=line", *tests])


def traced(tests: list[str], store: Path, tree: Path) -> int:
    options = [*OPTIONS, "--tb=short", "-m", "not slow"]
    return pytest.main([*options, *tests], plugins=[Trace(store, tree)])


class Trace:
    """A plugin of pytest that writes down which lines of the packages each test runs."""

    def __init__(self, store: Path, tree: Path) -> None:
        self.store, self.tree = store, f"{tree}/"
        self.files: dict[str, bool] = {}
        self.lines: dict[str, set[int]] = {}

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item):
        self.lines, start = {}, time.process_time()
        sys.settrace(self._called)
        try:
            return (yield)
        finally:
            sys.settrace(None)
            line = {
                "test": item.nodeid,
                "seconds": round(time.process_time() - start, 3),
                "lines": {k.removeprefix(self.tree): sorted(v) for k, v in self.lines.items()},
            }
            with self.store.open("a", encoding="utf-8") as file:
                file.write(json.dumps(line) + "\n")

    def _called(self, frame, _event, _arg):
        name = frame.f_code.co_filename
        if name not in self.files:
            ours = ("msvalidate/", "reference_fem/", "checker/msvalidate_check/")
            self.files[name] = name.startswith(tuple(f"{self.tree}{folder}" for folder in ours))
        if not self.files[name]:
            return None
        self.lines.setdefault(name, set()).add(frame.f_lineno)
        return self._stepped

    def _stepped(self, frame, event, _arg):
        if event == "line":
            self.lines[frame.f_code.co_filename].add(frame.f_lineno)
        return self._stepped
