"""Somebody else's candidate: right in single precision never differs, wrong by 1 % never agrees."""

from functools import partial

import numpy as np
import pandas as pd
import pytest

from msvalidate.bench.judging.candidate import check_displacements, solve_springs
from msvalidate.bench.judging.evidence import Evidence, Observed, Tolerance, gather_evidence
from msvalidate.bench.judging.foreign import judge_candidate, solve_faulty, solve_perturbed
from msvalidate.bench.judging.sweep import FULL
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


OPEN = "not resolved"


@pytest.mark.parametrize(
    ("candidate", "accuracy", "expected"),
    [
        (solve_springs, 0.0, ["agrees", "agrees", "agrees"]),
        (SOFT, 0.0, ["differs", "agrees", "agrees"]),
        (single(solve_springs), 0.0, ["differs", "agrees", "differs"]),
        # That the strain is uniform no softer spring changes: nothing shows what is left of it.
        (solve_springs, None, ["agrees", "agrees", OPEN]),
        (single(solve_springs), None, ["agrees", "agrees", OPEN]),
        (single(SOFT), None, ["differs", "agrees", OPEN]),
        (partial(solve_perturbed, 1e-4, 9), 1e-4, [OPEN, OPEN, OPEN]),
    ],
)
def test_verdicts(candidate, accuracy, expected):
    found = judge_candidate(study, candidate, accuracy=accuracy)
    assert list(found.verdict["verdict"]) == expected


def test_a_widened_limit_says_so():
    found = judge_candidate(study, single(solve_springs))
    row = found.verdict.iloc[0]
    assert "limit 1e-09 widened to" in row["because"]
    assert row["error"] < row["limit"] < 1e-3
    assert "that of single precision" in found.evidence.findings[0]


def test_what_is_no_accuracy_is_refused():
    for accuracy in (-1e-9, 1.0, float("nan"), "fine"):
        with pytest.raises(ProblemError, match="accuracy"):
            judge_candidate(study, solve_springs, accuracy=accuracy)
    with pytest.raises(ProblemError, match="leave it out"):
        judge_candidate(poor, 2.0, accuracy=1e-7)
    with pytest.raises(ProblemError, match="did you mean 'strain'"):
        judge_candidate(study, solve_springs, questions=("strian",))


def test_a_perturbation_is_as_large_as_said_and_the_same_again():
    move = solve_springs(PROBLEM, NETWORK)
    for seed in (1, 2):
        moved = solve_perturbed(1e-6, seed, PROBLEM, NETWORK)
        off = np.abs(moved - move).max() / np.abs(NETWORK.points + move).max()
        assert 0.9e-6 < off <= 1e-6 * (1 + 1e-9)
        assert (moved == solve_perturbed(1e-6, seed, PROBLEM, NETWORK)).all()
