"""A failure is told what it looks like: a fault that the study knows, of any size, or none."""

from __future__ import annotations

from functools import partial

import numpy as np
import pandas as pd
import pytest
from msvalidate.studies.poisson import controls

from msvalidate.judging.evidence import judge
from msvalidate.judging.suspects import Suspect, find_suspect, record_faults
from msvalidate.judging.sweep import Setting
from msvalidate.network import faults
from msvalidate.output.baseline import recorded_faults
from msvalidate.studies import poisson

NUMBER = 12


def verdict(observed):
    rows = {"quantity": [f"q{i}" for i in range(NUMBER)], "observed": observed}
    return pd.DataFrame(rows | {"layer": "theory", "reference": 0.5, "limit": 1e-5, "verdict": "?"})


@pytest.fixture
def moves():
    return np.random.default_rng(5).normal(size=(2, NUMBER))


@pytest.fixture
def recorded(moves):
    spoilt = {name: verdict(1 + move) for name, move in zip("ab", moves, strict=True)}
    return record_faults(verdict(np.ones(NUMBER)), spoilt)


@pytest.mark.parametrize("size", [1.0, -0.4, 3.0])
def test_a_fault_of_any_size_is_named(moves, recorded, size):
    found = find_suspect(verdict(1 + size * moves[1]), recorded)
    assert (found.fault, found.size) == ("b", pytest.approx(size))


def test_a_few_quantities_may_move_otherwise(moves, recorded):
    moved = 1 + moves[0]
    moved[:3] = [np.nan, 1 + 9 * moves[0][1], 1.0]
    assert find_suspect(verdict(moved), recorded).fault == "a"


def test_no_other_is_named(moves, recorded):
    for other in (np.zeros(NUMBER), moves[0] + moves[1], np.ones(NUMBER), np.full(NUMBER, np.inf)):
        assert find_suspect(verdict(1 + other), recorded) is None


def test_one_that_breaks_an_identity_the_other_way_is_cleared(moves, recorded):
    moved = moves[0].copy()
    moved[np.abs(moved).argmax()] *= -1
    assert find_suspect(verdict(1 + moved), recorded) is None


def test_two_that_move_alike_are_not_told_apart(moves):
    alike = {"a": verdict(1 + moves[0]), "b": verdict(1 + 2 * moves[0])}
    recorded = record_faults(verdict(np.ones(NUMBER)), alike)
    assert find_suspect(verdict(1 + moves[0]), recorded) is None


def test_of_other_quantities_nothing_is_said(recorded):
    assert find_suspect(verdict(2 * np.ones(NUMBER)).iloc[1:], recorded) is None


def test_the_diagonals_of_poisson_are_named_from_what_is_committed():
    spoilt = partial(controls.apply_fault, faults.stiffen_diagonals, 0.02)
    found = find_suspect(
        judge(poisson.run(spoilt, Setting(quick=True))), recorded_faults("poisson")
    )
    assert found == Suspect("diagonals 1 % stiffer", pytest.approx(2, rel=0.05))
