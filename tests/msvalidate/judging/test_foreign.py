"""Somebody else's candidate: right in single precision never differs, wrong by 1 % never agrees."""

from functools import partial

import numpy as np
import pandas as pd
import pytest

from msvalidate.judging.accuracy import Accurate, Perturbed
from msvalidate.judging.candidate import check_displacements, solve_springs
from msvalidate.judging.evidence import Evidence, Observed, Tolerance, gather_evidence
from msvalidate.judging.foreign import TABLE, judge_candidate, solve_faulty
from msvalidate.judging.sweep import FULL
from msvalidate.problem import ProblemError
from studies.poisson import block

SOFT = partial(solve_faulty, "every spring 1 % softer")
PROBLEM, NETWORK = block.spring_block("traction", 0.5, 5, "shared")
TRUTH = block.axial_strain(NETWORK.points, solve_springs(PROBLEM, NETWORK))
ROWS = (
    Tolerance("end strain, relative", 1e-9, "1", "the same springs"),
    Tolerance("end strain, in a band", 0.05, "1", "a band"),
    Tolerance("second difference at the end", 1e-12, "1", "uniform strain"),
)


def study(candidate=solve_springs, setting=FULL, questions=None):  # noqa: ARG001
    """A block under traction."""
    move = check_displacements(candidate)(PROBLEM, NETWORK)
    strain = block.axial_strain(NETWORK.points, move) / TRUTH
    row = move[np.abs(NETWORK.points[:, 1]) < 1e-9, 0]
    bend = float(np.abs(np.diff(row, 2)).max() / np.ptp(row))
    values = (Observed(strain, 1.0), Observed(strain, 1.0), Observed(bend))
    evidence = Evidence(
        {"strain": pd.DataFrame({"strain": [strain]})},
        {t.quantity: value for t, value in zip(ROWS, values, strict=True)},
        ROWS,
        columns={"strain": "over that of the springs (1)"},
    )
    return gather_evidence({"strain": lambda: evidence}, questions)


def poor(candidate=1.0, setting=FULL):
    """A study that asks for no displacements."""
    raise AssertionError((candidate, setting))


def single(predict):
    def rounded(problem, network, answer="linear"):
        return (network.points + predict(problem, network, answer)).astype(
            np.float32
        ) - network.points

    return rounded


def verdicts(candidate, **stated):
    return list(judge_candidate(study, candidate, **stated).verdict["verdict"])


OPEN = "not resolved"


@pytest.mark.parametrize(
    ("candidate", "expected"),
    [
        (solve_springs, ["agrees", "agrees", "agrees"]),
        (SOFT, ["differs", "agrees", "agrees"]),
        # That the strain is uniform no softer spring changes: nothing shows what is left of it.
        (single(solve_springs), ["agrees", "agrees", OPEN]),
        (single(SOFT), ["differs", "agrees", OPEN]),
        (Accurate(Perturbed(solve_springs, 1e-4, 9), 1e-4), [OPEN, OPEN, OPEN]),
    ],
)
def test_verdicts(candidate, expected):
    assert verdicts(candidate) == expected


def test_a_widened_limit_says_so():
    found = judge_candidate(study, single(solve_springs))
    row = found.verdict.iloc[0]
    assert "limit 1e-09 widened to" in row["because"]
    assert row["error"] < row["limit"] < 1e-3
    table = found.evidence.tables[TABLE].iloc[0]
    assert table["own_limit"] + table["widening"] == pytest.approx(row["limit"])
    assert "read off its numbers" in found.evidence.findings[0]


def test_an_accuracy_is_stated_or_refused():
    assert verdicts(single(solve_springs), accuracy=0.0)[0] == "differs", "its own word counts"
    with pytest.raises(ProblemError, match="leave it out"):
        judge_candidate(poor, 2.0, accuracy=1e-7)
    with pytest.raises(ProblemError, match="did you mean 'strain'"):
        judge_candidate(study, solve_springs, questions=("strian",))
