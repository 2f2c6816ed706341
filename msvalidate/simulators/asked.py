"""A program that is asked many questions: counted, with what is left, and not where none helps."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import Any

from msvalidate.problem.records import dataclass, field
from msvalidate.simulators.protocol import (
    Answer,
    CannotRepresent,
    OutOfTime,
    Request,
    Simulator,
    SimulatorError,
)

UNASKED = "not asked any more"
"""What is said of questions after one that took too long."""


class NoAnswerError(Exception):
    """A simulator that failed at the first question; nothing can be said of it."""


@dataclass
class Asked:
    """A simulator, and what came of asking it.

    Parameters
    ----------
    simulator, show, done
        Asked; told what is asked now, and what was asked.
    count, answers
        Of questions so far, and of those that were answered.
    refusals, failures
        What it said that it cannot represent, and how it failed to answer.
    ended
        Why it is asked no more; "" while it is.
    about
        What it says of itself.
    """

    simulator: Simulator
    show: Callable[[str], None] = lambda _: None
    done: Callable[[str], None] = lambda _: None
    count: int = 0
    answers: int = 0
    refusals: list[str] = field(default_factory=list)
    failures: list[str] = field(default_factory=list)
    ended: str = ""
    about: Mapping[str, Any] = field(default_factory=dict)

    def __call__(self, request: Request) -> Answer:
        """Its answer.

        Raises
        ------
        NoAnswerError
            If the first question fails.
        CannotRepresent, SimulatorError
            As the simulator, and the latter for all questions after one that took too long: others
            would take as long.
        """
        if self.ended:
            raise SimulatorError(UNASKED)
        self.count += 1
        asked = f"question {self.count}, {request.task}"
        self.show(f"{asked} of {request.name or 'a block'}")
        began = time.perf_counter()
        try:
            answer = self.simulator(request)
        except CannotRepresent as error:
            self.refusals.append(str(error))
            raise
        except SimulatorError as error:
            self._fail(asked, error)
            raise
        self.answers += 1
        self.about = answer.about
        taken = time.perf_counter() - began
        self.done(f"{asked} of {request.name or 'a block'}: {taken:.2g} s")
        return answer

    def _fail(self, asked: str, error: SimulatorError) -> None:
        said = f"{asked}: {error}"
        if self.count == 1:
            raise NoAnswerError(said) from error
        self.failures.append(said)
        if isinstance(error, OutOfTime):
            self.ended = said
