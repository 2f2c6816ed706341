"""What was done, step by step: on a terminal, in a pipe, and in a file."""

from __future__ import annotations

import contextlib
import sys
from pathlib import Path

from msvalidate.cli.cases import Progress
from msvalidate.cli.terminal import tell


class Steps(Progress):
    """Steps of something that takes minutes.

    A terminal shows the one that is taken now, written over; elsewhere each that was done is a line
    of stderr. `log` holds these lines too, and is begun anew.
    """

    def __init__(self, name: str, *, shown: bool, log: Path | None = None) -> None:
        super().__init__(name, shown=shown)
        self._line = shown and not sys.stderr.isatty()
        self._log = log

    def done(self, said: str) -> None:
        """Say what was done."""
        line = f"{self._name}: {said}"
        if self._line:
            tell(line)
        if self._log is not None:
            with contextlib.suppress(OSError), self._log.open("a", encoding="utf-8") as file:
                file.write(f"{line}\n")
