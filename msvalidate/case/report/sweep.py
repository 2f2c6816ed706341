"""Many cases of one file: keys set to each of some values, a row a combination.

Every row is written to a journal when it is known, under a key of all that it follows from: the
file, its mesh, the values, and the sources of this program. So a sweep that was killed goes on
where it was, and one that is asked again is read, not solved.
"""

from __future__ import annotations

import hashlib
import importlib
import json
import math
import multiprocessing
import re
import time
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ProcessPoolExecutor, wait
from functools import cache
from itertools import chain, islice, product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import scipy
import skfem
from matplotlib.figure import Figure

from msvalidate.bench.judging.sweep import end_with_parent
from msvalidate.bench.output.figures import add_shared_legend, new_figure, series_style
from msvalidate.case.compare.comparison import compare_case
from msvalidate.case.file.building import build_case
from msvalidate.case.file.reading import parse_source, read_source
from msvalidate.case.report.headline import overall
from msvalidate.problem import ProblemError, SolverError
from msvalidate.problem.records import dataclass

ROOT = Path(__file__).resolve().parents[2]
SOURCES = ("msvalidate", "reference_fem", "msvalidate_check")
SOLVED, REFUSED, FAILED, LATE, DIED = "solved", "refused", "failed", "too long", "died"
BARE = re.compile(r"((?:^|[,\[\s])[+-]?)\.(?=\d)")
"""A number without a digit before its point, which TOML lacks."""
MOST_LINES = 8
"""In the picture."""
Row = dict[str, Any]


@dataclass(frozen=True)
class Combination:
    """A case file with some of its keys set to other values.

    Parameters
    ----------
    file
        The case file.
    values
        Keys, as "springs.cells" or "load.1.pressure", and their values.
    """

    file: Path
    values: tuple[tuple[str, Any], ...]

    def change(self, given: dict[str, Any]) -> None:
        """Set the keys in a file's content; tables that are not there are made."""
        for name, value in self.values:
            *way, last = name.split(".")
            at: Any = given
            try:
                for step in way:
                    at = at[int(step) - 1] if isinstance(at, list) else at.setdefault(step, {})
                at[int(last) - 1 if isinstance(at, list) else last] = value
            except (IndexError, ValueError, AttributeError, TypeError) as error:
                raise ProblemError(
                    f"--set {name}: no such place in {self.file.name}; give a key as "
                    "springs.cells, of lists by number from 1, as load.1.pressure"
                ) from error

    @property
    def key(self) -> str:
        """What its row follows from, in 32 hexadecimal digits."""
        found = hashlib.sha256(_stamp().encode() + self.file.read_bytes())
        given = tomllib.loads(self.file.read_text(encoding="utf-8-sig"))
        self.change(given)
        mesh = given.get("body", {}).get("mesh") if isinstance(given.get("body"), dict) else None
        if isinstance(mesh, str) and (self.file.parent / mesh).is_file():
            found.update((self.file.parent / mesh).read_bytes())
        found.update(json.dumps([self.file.name, self.values], default=str).encode())
        return found.hexdigest()[:32]


@cache
def _stamp() -> str:
    """Of this program: its sources, and versions of what it computes with."""
    found = hashlib.sha256(repr((np.__version__, scipy.__version__, skfem.__version__)).encode())
    paths = [path for name in SOURCES for path in sorted((ROOT.parent / name).rglob("*.py"))]
    for path in paths or sorted(ROOT.rglob("*.py")):
        found.update(path.name.encode() + path.read_bytes())
    return found.hexdigest()


def read_values(words: Sequence[str]) -> dict[str, list[Any]]:
    """Keys and their values, of words as ``springs.cells=8,16``.

    Raises `ProblemError` if a word is none, or a key comes twice.
    """
    found: dict[str, list[Any]] = {}
    for word in words:
        name, is_there, right = word.partition("=")
        right = BARE.sub(r"\g<1>0.", right)
        try:
            values = tomllib.loads(f"values = [{right}]")["values"]
        except tomllib.TOMLDecodeError:
            values = [each.strip() for each in right.split(",")]
        if not (is_there and name and all(name.split(".")) and values and "" not in values):
            raise ProblemError(f"--set {word}: give key=value,value, as springs.cells=8,16,32")
        if name in found:
            raise ProblemError(f"--set {name}: comes twice; give all its values in one")
        found[name] = values
    return found


def combinations(files: Sequence[Path], values: Mapping[str, list[Any]]) -> Iterator[Combination]:
    """Each file with each combination of values, the last key the fastest.

    Raises `ProblemError` if a file is no case, or a key none of its places.
    """
    for file in files:
        read_source(file)
        Combination(file, tuple((name, each[0]) for name, each in values.items())).change(
            tomllib.loads(file.read_text(encoding="utf-8-sig"))
        )
    for file in files:
        for each in product(*values.values()):
            yield Combination(file, tuple(zip(values, each, strict=True)))


def solve(asked: Combination) -> Row:
    """The row of a combination: what it leaves of a case."""
    began = time.monotonic()
    try:
        text = asked.file.read_text(encoding="utf-8-sig").replace("\r\n", "\n")
        source = parse_source(asked.file.name, text, asked.file.resolve().parent, asked.change)
        with np.errstate(over="ignore", invalid="ignore"):
            found = compare_case(build_case(source))
    except ProblemError as error:
        return _row(began, REFUSED, str(error))
    except SolverError as error:
        return _row(began, FAILED, str(error))
    except Exception as error:  # noqa: BLE001  a row, whatever it was
        return _row(began, DIED, f"{type(error).__name__}: {error}")
    first = found.rows[0]
    limits = " ".join(each.sentence for each in found.limitations[:1])
    return _row(began, SOLVED, limits, overall(found.rows), first.error, first.uncertainty)


def _row(
    began: float,
    outcome: str,
    said: str,
    verdict: str = "",
    difference: float = math.nan,
    uncertainty: float = math.nan,
) -> Row:
    """What is known of a combination that began at a time (s) of the monotonic clock."""
    seconds, said = round(time.monotonic() - began, 3), " ".join(said.split())
    row = {"outcome": outcome, "verdict": verdict, "difference": difference}
    return row | {"uncertainty": uncertainty, "said": said, "seconds": seconds}


class Workers:
    """Processes of this machine, one combination at a time each: one that is late is killed."""

    def __init__(self, jobs: int) -> None:
        self.slots: list[Executor] = [self._made() for _ in range(jobs)]
        wait([slot.submit(_stamp) for slot in self.slots])  # start-up is no combination's time

    @staticmethod
    def _made() -> ProcessPoolExecutor:
        context = multiprocessing.get_context("spawn")
        return ProcessPoolExecutor(1, context, initializer=end_with_parent)

    def renewed(self, slot: Executor, _future: Future[Row]) -> Executor:
        """Another worker for one that is late or dead."""
        for process in dict(getattr(slot, "_processes", None) or {}).values():
            process.kill()
        slot.shutdown(wait=False)
        made = self._made()
        made.submit(_stamp).result()
        return made

    def close(self) -> None:
        """End all of them."""
        for slot in self.slots:
            slot.shutdown(wait=False, cancel_futures=True)


class Cluster:
    """Workers of a Dask cluster: a combination that is late is given up; one that kills, fails."""

    def __init__(self, address: str) -> None:
        try:
            client = importlib.import_module("distributed").Client  # an extra
        except ImportError as error:
            raise ProblemError("--scheduler: needs dask; pip install msvalidate[dask]") from error
        try:
            self.client = client(address, timeout="10s")
        except (OSError, ValueError, TimeoutError) as error:
            raise ProblemError(f"--scheduler {address}: {error}; start one there") from error
        slots = max(1, sum(self.client.nthreads().values()))
        self.slots: list[Executor] = [self.client.get_executor(retries=0)] * slots

    def renewed(self, slot: Executor, future: Future[Row]) -> Executor:
        """The same executor: its combination is given up."""
        future.cancel()
        return slot

    def close(self) -> None:
        """Leave the cluster."""
        self.client.close()


def run_all(
    asked: Iterator[Combination], workers: Workers | Cluster, limit: float
) -> Iterator[tuple[Combination, Row]]:
    """Rows as they are known, in any order; each combination gets `limit` (s)."""
    idle, busy = list(workers.slots), dict[Future[Row], tuple[Combination, Executor, float]]()
    while True:
        for one in islice(asked, len(idle)):
            slot = idle.pop()
            busy[slot.submit(solve, one)] = one, slot, time.monotonic()
        if not busy:
            return
        first = min(began for _, _, began in busy.values())
        wait(busy, max(0.0, first + limit - time.monotonic()), FIRST_COMPLETED)
        now = time.monotonic()
        for future, (one, slot, began) in list(busy.items()):
            if not future.done() and now - began < limit:
                continue
            del busy[future]
            error = future.exception() if future.done() else None
            if future.done() and error is None:
                idle.append(slot)
                yield one, future.result()
                continue
            outcome = (LATE, f"longer than {limit:g} s") if error is None else (DIED, str(error))
            idle.append(workers.renewed(slot, future))
            yield one, _row(began, *outcome)


def read_journal(path: Path) -> dict[str, Row]:
    """Rows that are known, by key; a line that was cut short is none."""
    found: dict[str, Row] = {}
    if path.is_file():
        for line in path.read_text(encoding="utf-8").splitlines():
            try:
                row = json.loads(line)
                found[row.pop("key")] = row
            except (ValueError, KeyError, AttributeError):
                continue
    return found


def sweep(
    asked: Callable[[], Iterator[Combination]],
    journal: Path,
    workers: Callable[[], Workers | Cluster],
    limit: float,
    tell: Callable[[int, Combination, Row], None],
) -> pd.DataFrame:
    """The table of all combinations, of which those in the journal are not solved again.

    What was late or died is tried again. `workers` are made if there is anything to do.
    """
    known = read_journal(journal)
    known = {key: row for key, row in known.items() if row["outcome"] not in (LATE, DIED)}
    todo = (one for one in asked() if one.key not in known)
    one = next(todo, None)
    if one is not None:
        journal.parent.mkdir(parents=True, exist_ok=True)
        made = workers()
        try:
            with journal.open("a", encoding="utf-8") as file:
                if file.tell():
                    file.write("\n")  # ends a line that was cut short
                for done, row in run_all(chain([one], todo), made, limit):
                    known[done.key] = row
                    file.write(json.dumps({"key": done.key, **row}) + "\n")
                    file.flush()
                    tell(len(known), done, row)
        finally:
            made.close()
    rows = [{"file": each.file.name, **dict(each.values), **known[each.key]} for each in asked()]
    return pd.DataFrame(rows)


def draw_sweep(table: pd.DataFrame, names: Sequence[str]) -> Figure:
    """Difference of the first quantity against the first key of numbers, a line for each other."""
    numbers = [name for name in names if table[name].map(np.isreal).all()]
    figure, (axis,) = new_figure(size=(5.6, 3.8))
    shown = table[table["outcome"] == SOLVED]
    x = numbers[0] if numbers else None
    others = [name for name in ("file", *names) if name != x and table[name].nunique() > 1]
    words = [shown[name].map(str) for name in others]
    groups: list[Any] = [((), shown)]
    if others:
        groups = list(shown.groupby(words, sort=False))
    for place, (key, own) in enumerate(groups[:MOST_LINES]):
        own_words = key if isinstance(key, tuple) else (key,)
        label = ", ".join(f"{n} {w}" for n, w in zip(others, own_words, strict=True)) or None
        along = own[x] if x else range(1, len(own) + 1)
        axis.plot(along, 100 * own["difference"], label=label, **series_style(place))
    axis.set(xlabel=x or "combination", ylabel="difference from elasticity (%)", yscale="log")
    if others:
        add_shared_legend(figure, [axis], 2)
    return figure
