"""Progress of long computations, as records of the standard logging.

Nothing is shown unless a handler listens: `msvalidate.cli.progress` has the one of the commands.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence

LOGGER = logging.getLogger("msvalidate.progress")
"""Records of level INFO; those of a stage have the attribute `stage`."""


def report_stage(name: str, stages: Sequence[str], running: Sequence[str] = ()) -> None:
    """Report the stage that begins, and all stages that run now."""
    number, names = stages.index(name) + 1, ", ".join(running or [name])
    LOGGER.info("step %d of %d, %s", number, len(stages), names, extra={"stage": True})


def report_step(text: str, *values: object) -> None:
    """Report a step of a stage; `text` takes the values as `logging` does, with %."""
    LOGGER.info(text, *values)
