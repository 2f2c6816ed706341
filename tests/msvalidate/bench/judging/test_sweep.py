"""Sweeps: the same numbers in the same order, whatever the workers."""

import math
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context

import pytest
from msvalidate.studies.poisson import direction

from msvalidate.bench.judging.sweep import Setting

CASES = list(range(20))


def test_serial_keeps_order():
    assert Setting().sweep(math.sqrt, CASES, "roots") == [math.sqrt(n) for n in CASES]


def test_threads_keep_order():
    with ThreadPoolExecutor(3) as pool:
        found = Setting(executor=pool).sweep(math.sqrt, CASES, "roots")
    assert found == [math.sqrt(n) for n in CASES]


@pytest.mark.parametrize("workers", [1, 2])
def test_processes_give_the_same_table(workers):
    alone = direction.run(setting=Setting(quick=True)).tables["direction"]
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        shared = direction.run(setting=Setting(quick=True, executor=pool)).tables["direction"]
    assert alone.equals(shared), "bit for bit"


def test_errors_come_through():
    with pytest.raises(ValueError, match=r"math domain|nonnegative"):
        Setting().sweep(math.sqrt, [-1.0], "roots")
