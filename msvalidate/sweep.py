"""Floor 3: how a study is run: small or full, from which seed, on which workers."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from concurrent.futures import Executor
from dataclasses import dataclass
from typing import TypeVar

from tqdm import tqdm

Case = TypeVar("Case")
Result = TypeVar("Result")


@dataclass(frozen=True)
class Setting:
    """How a study is run. The numbers depend on `quick` and `seed` alone.

    Parameters
    ----------
    quick
        The small form: fewer sizes, the same tolerances.
    seed
        Where random numbers start, if the study draws any.
    executor
        Runs the cases of a sweep: any `concurrent.futures` executor, or the one that a Dask
        client's ``get_executor()`` returns. None runs them here, one after another.
    progress
        Whether long sweeps show a bar on a terminal.
    """

    quick: bool = False
    seed: int = 0
    executor: Executor | None = None
    progress: bool = False

    def sweep(
        self, function: Callable[[Case], Result], cases: Iterable[Case], label: str
    ) -> list[Result]:
        """Results of the function, in the order of the cases whatever the workers."""
        todo = list(cases)
        run = map if self.executor is None else self.executor.map
        bar = tqdm(
            run(function, todo),
            total=len(todo),
            desc=label,
            delay=0.5,
            leave=False,
            disable=None if self.progress else True,
        )
        return list(bar)
