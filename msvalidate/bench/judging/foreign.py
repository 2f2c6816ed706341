"""A study's judgement of somebody else's candidate, by limits that know how accurate it is.

A limit was set for numbers in double precision. A candidate in single precision misses an identity
of 1e-12 without being wrong. So each limit is widened by what the same inaccuracy does to the
number: the study is run with its own springs, and again with these perturbed. What a
widened limit can no longer tell is found in the same way, with springs that are wrong by 1 %.

An accuracy is relative: the largest error of a component of a position (rest point plus
displacement), over the largest coordinate of the positions. Of the coordinate and not of the body's
size, since numbers lose digits with their distance from the origin.
"""

from __future__ import annotations

import inspect
import zlib
from collections.abc import Callable, Iterable, Mapping
from functools import partial

import numpy as np
import pandas as pd

from msvalidate.bench.judging.candidate import Answer, solve_springs
from msvalidate.bench.judging.evidence import Evidence, Observed, judge_one
from msvalidate.bench.judging.sweep import FULL, Setting
from msvalidate.problem import Array, Problem, ProblemError, SolverError
from msvalidate.problem.checks import finite_number
from msvalidate.problem.records import dataclass, replace
from msvalidate.springs.network import Network, faults
from msvalidate_check.verdict import AGREES, DIFFERS, NOT_RESOLVED

Run = Callable[..., Evidence]
SINGLE, DOUBLE = float(np.finfo(np.float32).eps) / 2, float(np.finfo(float).eps)
"""Relative accuracies of single and double precision.

A candidate has single precision by default; limits are set for double precision.
"""
SEEDS = (1, 2, 3, 4)
"""Seeds of the perturbations."""
MARGIN = 4.0
"""Safety factor of the largest change that widens a limit.

In 150 draws of ten rows of `poisson`, the next change was up to 2.9 times as large.
"""
FAULT = 0.01
"""Relative size of faults that a row must still detect, if its own limit does."""
FAULTS: Mapping[str, tuple[Callable[[Network, float], Network], float]] = {
    "every spring 1 % softer": (faults.stiffen_all, -FAULT),
    "diagonals 1 % softer": (faults.stiffen_diagonals, -FAULT),
}
"""Controls: name -> what is done to the network, and how much of it."""
CLOSE = 1.0
"""Largest widening, relative to a row's own limit, that needs no control."""


@dataclass(frozen=True)
class Judged:
    """Evidence of a candidate, its verdict, and the relative accuracy assumed."""

    evidence: Evidence
    verdict: pd.DataFrame
    accuracy: float | None


def judge_candidate(
    run: Run,
    candidate: object,
    setting: Setting = FULL,
    questions: Iterable[str] | None = None,
    accuracy: float | None = None,
) -> Judged:
    """Run a study on a candidate and judge it.

    A candidate for displacements is judged by limits widened by its accuracy; others, of which no
    position is asked, by the study's own.

    Parameters
    ----------
    run
        The study's `run`.
    candidate
        What it judges, of the study's kind.
    setting
        Cases are run one after another.
    questions
        Of the study; None asks all.
    accuracy
        Relative (see above); None for that of single precision.

    Raises
    ------
    ProblemError
        If there is no such question, the accuracy is none, or is stated where no position is asked.
        What the study raises comes through.
    """
    asked = {} if questions is None else {"questions": tuple(questions)}
    ask = partial(run, setting=replace(setting, executor=None), **asked)
    if not asks_displacements(run):
        if accuracy is not None:
            raise ProblemError(
                f"accuracy: {accuracy!r}; this study asks for no displacements of a network; leave "
                "it out"
            )
        evidence = ask(candidate=candidate)
        return Judged(evidence, _judge(evidence, {}, {}), None)
    known = SINGLE if accuracy is None else finite_number("accuracy", accuracy, least=0.0, most=0.5)
    evidence = ask(candidate=candidate)
    widenings: dict[str, float] = {}
    hidden: dict[str, tuple[str, ...]] = {}
    if known > DOUBLE:
        widenings, hidden = measure_widenings(ask, evidence, known)
    verdict = _judge(evidence, widenings, hidden, known)
    told = _tell(verdict, known, stated=accuracy is not None)
    return Judged(replace(evidence, findings=(told, *evidence.findings)), verdict, known)


def asks_displacements(run: Run) -> bool:
    """Return True if a study's candidate predicts displacements of a network.

    The default candidate is then the springs.
    """
    parameters = inspect.signature(run).parameters
    return "candidate" in parameters and parameters["candidate"].default is solve_springs


def measure_widenings(
    ask: Run, evidence: Evidence, accuracy: float
) -> tuple[dict[str, float], dict[str, tuple[str, ...]]]:
    """Change of each number of a study by an accuracy, and faults that it hides.

    Parameters
    ----------
    ask
        The study's `run`, but for the candidate.
    evidence
        Of any candidate: its quantities and limits.
    accuracy
        Relative.

    Returns
    -------
    tuple
        Quantity -> widening of its limit, in its unit, not finite where no number is left; and
        quantity -> the faults of 1 % that it notices by its own limit, with "" before them if the
        widened one may let each of them pass. "May": the inaccuracy may hide as much of an error
        as it may add.
    """
    truth = ask(candidate=solve_springs).observed
    moves: dict[str, list[float]] = {name: [] for name in evidence.observed}
    for seed in SEEDS:
        try:
            moved = ask(candidate=partial(solve_perturbed, accuracy, seed)).observed
        except (ProblemError, SolverError) as error:
            raise ProblemError(
                f"accuracy: {accuracy:.3g}; the study's own springs, perturbed by as much, cannot "
                f"be judged ({error}); give more digits, and --accuracy"
            ) from error
        for name, of_seed in moves.items():
            of_seed.append(abs(_offset(moved[name]) - _offset(truth[name])))
    widening = {name: MARGIN * float(np.max(found)) for name, found in moves.items()}
    spoilt = {name: ask(candidate=partial(solve_faulty, name)).observed for name in FAULTS}
    hidden: dict[str, tuple[str, ...]] = {}
    for tolerance in evidence.tolerances:
        name = tolerance.quantity
        own = [f for f in FAULTS if not spoilt[f][name].error <= tolerance.limit]
        # Not (a > b): what is no number is hidden.
        lost = [f for f in own if not spoilt[f][name].error > tolerance.limit + 2 * widening[name]]
        if lost:
            hidden[name] = tuple(lost)
        elif not own and not widening[name] <= CLOSE * tolerance.limit:
            hidden[name] = ()
    return widening, hidden


def solve_faulty(
    fault: str, problem: Problem, network: Network, answer: Answer = "linear"
) -> Array:
    """The springs' answer with one of the faults of `FAULTS`: displacements (n, d) in m."""
    act, size = FAULTS[fault]
    return solve_springs(problem, act(network, size), answer)


def solve_perturbed(
    accuracy: float, seed: int, problem: Problem, network: Network, answer: Answer = "linear"
) -> Array:
    """The springs' answer with random errors, even between ± accuracy: displacements (n, d) in m.

    They are the same for the same network, loads, answer and seed.
    """
    move = solve_springs(problem, network, answer)
    reach = accuracy * float(np.abs(network.points + move).max())
    given = network.points, network.stiffness, network.force, network.displacement
    what = zlib.crc32(answer.encode() + b"".join(each.tobytes() for each in given))
    chance = np.random.default_rng([seed, what])  # not by digits of the move, which processors have
    return np.asarray(move + reach * chance.uniform(-1, 1, move.shape))


def _offset(seen: Observed) -> float:
    return seen.value - seen.reference


def _judge(
    evidence: Evidence,
    widenings: Mapping[str, float],
    hidden: Mapping[str, tuple[str, ...]],
    accuracy: float = 0.0,
) -> pd.DataFrame:
    """Verdict in the words for a candidate; see `judge_one` for the columns."""
    rows = []
    for tolerance in evidence.tolerances:
        name = tolerance.quantity
        widening = widenings.get(name, 0.0)
        row = judge_one(tolerance, evidence.observed[name])
        error, limit = evidence.observed[name].error, tolerance.limit + widening
        row["limit"] = limit
        if widening > tolerance.limit * 1e-3 or not np.isfinite(widening):
            row["because"] = (
                f"{tolerance.because}; limit {tolerance.limit:.3g} widened to {limit:.3g} by "
                f"accuracy {accuracy:.2g}"
            )
        if not np.isfinite(limit):
            row["verdict"] = NOT_RESOLVED
        elif not error <= limit:
            row["verdict"] = DIFFERS
        else:
            row["verdict"] = NOT_RESOLVED if name in hidden else AGREES
        if row["verdict"] == NOT_RESOLVED:
            row["because"] = f"{row['because']}: {_reason(hidden.get(name, ()))}"
        rows.append(row)
    return pd.DataFrame(rows)


def _reason(lost: tuple[str, ...]) -> str:
    """Why a row is not resolved."""
    if lost:
        return f"then {' and '.join(lost)} may pass, which the limit itself notices"
    return "no fault of 1 % that was tried shows what it then still notices"


def _tell(verdict: pd.DataFrame, accuracy: float, *, stated: bool) -> str:
    """Describe the number of rows with each verdict, and the accuracy."""
    counts = verdict["verdict"].value_counts()
    words = ", ".join(f"{word}: {counts.get(word, 0)}" for word in (AGREES, DIFFERS, NOT_RESOLVED))
    if accuracy <= DOUBLE:
        told = "The candidate is judged by the study's own limits, as it is stated to be exact"
    else:
        source = "as stated" if stated else "that of single precision, as no other is stated"
        told = f"The candidate's positions are taken to be accurate to {accuracy:.2g} of the "
        told += f"largest coordinate ({source}), and every limit is widened by what that does to "
        told += "its number" + ("" if stated else "; --accuracy states another, 0 for doubles")
    return f"{told}: {len(verdict)} rows, {words}."
