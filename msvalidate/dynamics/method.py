"""What a relaxation method is: a generator that moves a run, and how it is named."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from msvalidate.dynamics.run import LOOK_EVERY, Run
from msvalidate.problem.records import dataclass


@dataclass(frozen=True)
class Method:
    """A relaxation method.

    Parameters
    ----------
    name, title
        Its name in tables, and in sentences.
    walk
        Moves a run for ever, from one `yield` to the next, each where a look may be taken: the
        first before any step, the others at most `Run.block` steps on.
    look_every
        Steps between two looks, at the least.
    """

    name: str
    title: str
    walk: Callable[[Run], Iterator[None]]
    look_every: int = LOOK_EVERY
