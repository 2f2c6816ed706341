"""Order of the tests, and what small forms of studies left or leave."""

from __future__ import annotations

import contextlib
import csv
import os
import pickle
import signal
from functools import cache
from pathlib import Path

import pytest

from msvalidate.bench.judging import catalogue

pytest_plugins = ["pytester"]  # runs of pytest in a test, for the plugin that others install

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    # What a shell starts in the background ignores interrupts, and so would all that tests start.
    signal.signal(signal.SIGINT, signal.default_int_handler)

SLOW = Path(__file__).with_name("slow.csv")
"""Tests that are too long for each change: in `kept`, parts of names of the cases that stay in
`make test`, parted by |. `make slow` runs the rest."""


LONGEST = {"test_studies.py", "test_command_line.py", "test_jobs.py", "test_documents.py"}
LONGEST |= {"test_case_runs.py", "test_mistakes.py", "test_judging.py", "test_check.py"}
LONGEST |= {"test_range.py", "test_sweep.py", "test_general.py", "test_commands.py"}
"""Files of more than ten seconds; a worker takes a file whole."""


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Mark what the list says; the longest files first, so that several workers end together."""
    with SLOW.open(encoding="utf-8", newline="") as file:
        listed = {row["test"]: row["kept"] for row in csv.DictReader(file)}
    for item in items:
        name, bracket, case = item.nodeid.partition("[")
        if name in listed:
            kept = [part for part in listed[name].split("|") if part]
            if not any(part in bracket + case for part in kept):
                item.add_marker(pytest.mark.slow)
    items.sort(key=lambda item: (item.path.name not in LONGEST, "studies" not in item.path.parts))


@pytest.fixture(scope="session")
def small_tables():
    """Name of a study -> its tables in the small form, as the baseline has them.

    `check` runs every study and holds it to these, so tests of what a table says do not run it
    once more. Columns that depend on the machine are left out.
    """
    import pandas as pd  # noqa: PLC0415  a second, which most tests need not wait for

    from msvalidate.bench.output import baseline  # noqa: PLC0415

    @cache
    def of(name):
        paths = sorted((baseline.baseline_folder("quick") / name).glob("*.csv"))
        assert paths, f"no baseline of {name}"
        return {path.stem: pd.read_csv(path) for path in paths}

    return of


@pytest.fixture(scope="session")
def small_form(tmp_path_factory):
    """Name of a study -> its evidence in the small form, made once in a run of the tests; slow.

    Several files of tests look at the same small forms; workers share them through files.
    """
    folder = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:  # whose own folder is in the one of all
        folder = folder.parent

    @cache
    def of(name):
        place = folder / f"{name}.pickle"
        with (folder / f"{name}.lock").open("w") as lock:
            with contextlib.suppress(ImportError):  # where there are no such locks, two may work
                import fcntl  # noqa: PLC0415

                fcntl.flock(lock, fcntl.LOCK_EX)
            if place.exists():
                return pickle.loads(place.read_bytes())  # noqa: S301  our own
            from msvalidate.bench.judging.sweep import Setting  # noqa: PLC0415  not for all tests

            evidence = catalogue.load(name).run(setting=Setting(quick=True))
            # Figures that are made by a function cannot leave the process.
            with contextlib.suppress(AttributeError, pickle.PicklingError):
                place.write_bytes(pickle.dumps(evidence))
            return evidence

    return of
