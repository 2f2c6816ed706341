"""The grid that numbers were rounded to is found, and an even answer is not taken for one."""

import numpy as np
import pytest

from msvalidate.judging.accuracy import Accurate, Perturbed, Recorded, measure_grid
from msvalidate.judging.candidate import solve_springs
from msvalidate.problem import ProblemError
from studies.poisson import block

PROBLEM, NETWORK = block.spring_block("clamped", 0.5, 6, "shared")
EVEN, STRETCHED = block.spring_block("slide", 1.0, 5, "shared")
MOVE = solve_springs(PROBLEM, NETWORK)


def single(problem, network, answer="linear"):
    place = network.points + solve_springs(problem, network, answer)
    return place.astype(np.float32) - network.points


@pytest.mark.parametrize(
    ("rounded", "accuracy"),
    [
        (lambda u, _: u, 0.0),
        (lambda u, x: (x + u).astype(np.float32) - x, 2.0**-24),
        (lambda u, _: u.astype(np.float32), 2.0**-24 * 1e-3),
        (lambda u, x: (x + u).astype(np.float16) - x, None),
        (lambda u, x: np.round(x + u, 6) - x, 0.5e-6),
        (lambda u, _: np.round(1000 * u, 5) / 1000, 0.5e-8),
    ],
)
def test_the_grid_of_a_format_is_measured(rounded, accuracy):
    found = measure_grid(NETWORK.points, np.asarray(rounded(MOVE, NETWORK.points), float))
    if accuracy is None:
        assert found is None, "a thousandth on a grid of as much shows too few levels"
    else:
        assert found == pytest.approx(accuracy, rel=0.15)


def test_an_even_answer_is_not_rounded():
    even = solve_springs(EVEN, STRETCHED)
    assert measure_grid(STRETCHED.points, even) is None
    seen = Recorded(solve_springs)
    seen(EVEN, STRETCHED)
    seen(PROBLEM, NETWORK)
    assert seen.accuracy == 0
    seen = Recorded(single)
    seen(EVEN, STRETCHED)
    seen(PROBLEM, NETWORK)
    assert seen.accuracy == pytest.approx(2.0**-24, rel=0.1)


def test_two_tolerances_of_its_own_are_an_accuracy():
    loose = Accurate(Perturbed(solve_springs, 1e-5, 1), tighter=solve_springs)
    seen = Recorded(loose)
    seen(PROBLEM, NETWORK)
    assert seen.accuracy == pytest.approx(1e-5, rel=0.1)


def test_a_perturbation_is_as_large_as_said_and_the_same_again():
    for seed in (None, 1, 2):
        moved = Perturbed(solve_springs, 1e-6, seed)(PROBLEM, NETWORK)
        off = np.abs(moved - MOVE).max() / np.abs(NETWORK.points + MOVE).max()
        assert 0.9e-6 < off <= 1e-6 * (1 + 1e-9)
        assert (moved == Perturbed(solve_springs, 1e-6, seed)(PROBLEM, NETWORK)).all()


@pytest.mark.parametrize("accuracy", [-1e-9, 1.0, float("nan"), "fine"])
def test_what_is_no_accuracy_is_refused(accuracy):
    with pytest.raises(ProblemError, match="accuracy"):
        Accurate(solve_springs, accuracy)
