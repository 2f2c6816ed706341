"""Bodies put to the solvers, each answer held to many digits: answered, refused, or missed.

python -m tests.truth.judge 0 2000     the bodies of these seeds, and what came of them
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from tqdm import tqdm

from msvalidate.problem import ProblemError, SolverError
from msvalidate.springs.dynamics.relax import relax
from msvalidate.springs.dynamics.relaxations import RELAXATIONS
from msvalidate.springs.statics.equilibrium import equilibrium
from tests.truth import exact
from tests.truth.bodies import Body, body

NOTICEABLE = 1e-14
"""True error above which a stated one may be compared with it: below, both are rounding."""


@dataclass(frozen=True)
class Verdict:
    """What came of a body: true and stated error where it was answered, else the refusal.

    `wrong` says why an answer is no stable equilibrium, if it is none.
    """

    body: Body
    stated: float = float("nan")
    true: float = float("nan")
    refusal: str = ""
    wrong: str = ""

    @property
    def missed(self) -> bool:
        """Whether a wrong number left the solver."""
        return not self.refusal and (bool(self.wrong) or not self.true <= self.stated)

    def __str__(self) -> str:
        kind = "ordinary" if self.body.ordinary else "hard"
        if self.refusal:
            return f"refused ({kind}): {self.body}: {self.refusal}"
        start = "missed" if self.missed else "answered"
        return (
            f"{start} ({kind}): {self.body}: stated error {self.stated:.2g}, true {self.true:.2g}"
            + (f", {self.wrong}" if self.wrong else "")
        )


@dataclass(frozen=True)
class Tally:
    """What came of many bodies."""

    verdicts: tuple[Verdict, ...]

    @property
    def missed(self) -> list[Verdict]:
        """Wrong answers."""
        return [v for v in self.verdicts if v.missed]

    @property
    def refused(self) -> list[Verdict]:
        """Bodies without an answer."""
        return [v for v in self.verdicts if v.refusal]

    @property
    def share_answered(self) -> float:
        """Part of the ordinary bodies that were answered."""
        ordinary = [v for v in self.verdicts if v.body.ordinary]
        return sum(not v.refusal for v in ordinary) / len(ordinary)

    @property
    def overstatement(self) -> float:
        """Median of stated over true error where the true one is no rounding."""
        ratios = [v.stated / v.true for v in self.verdicts if v.true > NOTICEABLE and not v.wrong]
        return float(np.median(ratios)) if ratios else float("nan")

    def __str__(self) -> str:
        lines = ["method                bodies  answered  refused  missed"]
        methods = Counter(v.body.method for v in self.verdicts)
        for method, count in [*methods.most_common(), ("all", len(self.verdicts))]:
            of = [v for v in self.verdicts if method in {"all", v.body.method}]
            refused, missed = sum(bool(v.refusal) for v in of), sum(v.missed for v in of)
            lines.append(f"{method:<20}{count:>8}{count - refused:>10}{refused:>9}{missed:>8}")
        ordinary = sum(v.body.ordinary for v in self.verdicts)
        return "\n".join(
            [
                *lines,
                f"ordinary bodies: {ordinary}, answered {100 * self.share_answered:.1f} %",
                f"median of stated over true error: {self.overstatement:.3g}",
            ]
        )


def judged(it: Body) -> Verdict:
    """One body, put to its solver, and the answer held to many digits."""
    try:
        if it.method in {"linear", "nonlinear"}:
            answer = equilibrium(it.network, it.method)
        else:
            answer = relax(it.network, RELAXATIONS[it.method]).equilibrium
    except (SolverError, ProblemError) as error:
        return Verdict(it, refusal=str(error))
    try:
        if it.method == "linear":
            truth = exact.linear(it.network)
        else:
            truth = exact.nonlinear(it.network, answer.displacement)
    except exact.SingularError:
        return Verdict(it, answer.error, wrong="no equilibrium is near")
    wrong = f"unstable, {truth.negative} negative modes" if truth.negative else ""
    return Verdict(it, answer.error, truth.error_of(answer.displacement), wrong=wrong)


def tally(seeds: Iterable[int]) -> Tally:
    """The bodies of these seeds, judged."""
    bodies = (body(seed) for seed in seeds)
    return Tally(tuple(judged(it) for it in bodies if it is not None))


def main(first: int, last: int) -> None:
    """Print every answer that is wrong, every refusal, and the counts."""
    result = tally(tqdm(range(first, last), disable=None))
    for verdict in [*result.refused, *result.missed]:
        print(verdict)
    print(result)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:3]))
