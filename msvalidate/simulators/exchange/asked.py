"""A program that is asked many questions: counted, with what is left, and not where none helps."""

from __future__ import annotations

import time
from collections.abc import Collection, Mapping
from typing import Any

from msvalidate.problem.progress import report_step
from msvalidate.problem.records import dataclass, field
from msvalidate.simulators.exchange.protocol import (
    Answer,
    CannotRepresent,
    NotAskedError,
    OutOfTime,
    Request,
    Simulator,
    SimulatorError,
)

USUAL = {"gate": 11, "probe": 67, "bodies": 12}
"""Questions of a part, where none of its answers asks for more."""
MASSES = 34
"""Number of requests of the probe that programs with forces omit."""


@dataclass(frozen=True)
class Note:
    """Request that was not made or not answered, and the reason.

    `asked` is false after a question that took too long.
    """

    what: str
    why: str
    asked: bool = True


def note_of(what: str, error: Exception) -> Note:
    """A note on an error."""
    return Note(what, str(error), not isinstance(error, NotAskedError))


class NoAnswerError(Exception):
    """A simulator that failed at the first question; nothing can be said of it."""


@dataclass
class Asked:
    """A simulator, and what came of asking it.

    Parameters
    ----------
    simulator
        Answers requests.
    parts
        Of a judgement, that the questions are of.
    count, answers
        Of questions so far, and of those that were answered.
    refusals, failures
        What it said that it cannot represent, and how it failed to answer.
    ended
        Whether it is asked no more, as one question took too long.
    about
        What it says of itself.
    """

    simulator: Simulator
    parts: Collection[str] = tuple(USUAL)
    count: int = 0
    answers: int = 0
    refusals: list[str] = field(default_factory=list)
    failures: list[Note] = field(default_factory=list)
    ended: bool = False
    about: Mapping[str, Any] = field(default_factory=dict)
    began: float = field(default_factory=time.perf_counter)
    tells_forces: bool = False

    @property
    def left(self) -> str:
        """Estimated number of further requests and their time."""
        some = sum(USUAL[part] for part in self.parts)
        some -= MASSES * (self.tells_forces and "probe" in self.parts)
        more = max(some - self.count, 0)
        seconds = (time.perf_counter() - self.began) / max(self.count, 1) * more
        return f"some {more} left, {seconds:.0f} s" if more else "the last ones"

    def __call__(self, request: Request) -> Answer:
        """Pass a request to the simulator and return its answer.

        Raises
        ------
        NoAnswerError
            If the first question fails.
        CannotRepresent, SimulatorError
            As the simulator, and the latter for all questions after one that took too long: others
            would take as long.
        """
        if self.ended:
            raise NotAskedError
        self.count += 1
        asked = f"question {self.count}, {request.task}"
        before = f"; {self.left}" if self.count > 1 else ""
        report_step("%s of %s%s", asked, request.name or "a block", before)
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
        self.tells_forces = self.tells_forces or answer.force is not None
        return answer

    def _fail(self, asked: str, error: SimulatorError) -> None:
        if self.count == 1:
            raise NoAnswerError(f"{asked}: {error}") from error
        self.failures.append(Note(asked, str(error)))
        self.ended = self.ended or isinstance(error, OutOfTime)
