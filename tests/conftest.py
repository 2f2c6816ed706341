"""Order of the tests: the longest files first, so that several workers end together."""

from __future__ import annotations

import contextlib
import os
import pickle
from functools import cache

import pytest

from msvalidate.judging import catalogue
from msvalidate.judging.sweep import Setting


def pytest_collection_modifyitems(items):
    items.sort(
        key=lambda item: (item.path.name != "test_studies.py", "studies" not in item.path.parts)
    )


@pytest.fixture(scope="session")
def small_form(tmp_path_factory):
    """Name of a study -> its evidence in the small form, made once in a run of the tests.

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
            evidence = catalogue.load(name).run(setting=Setting(quick=True))
            # Figures that are made by a function cannot leave the process.
            with contextlib.suppress(AttributeError, pickle.PicklingError):
                place.write_bytes(pickle.dumps(evidence))
            return evidence

    return of
