"""Progress of a command: plain lines on standard error, and with time stamps in a log file."""

from __future__ import annotations

import contextlib
import logging
import os
import sys
import threading
import time
from datetime import datetime
from pathlib import Path
from typing import TextIO

from msvalidate.cli.terminal import tell
from msvalidate.problem.progress import LOGGER

PAUSE = 2.0
"""Seconds between two lines, at least: shorter steps are in the log alone."""
SILENCE = 4.0
"""Seconds without a line after which one repeats the step, well below 10 s: libraries delay it."""


def log_path(folder: Path) -> Path:
    """Log file of a command, beside its folder of results, which is replaced as a whole."""
    whole = folder.absolute()
    return whole.with_name(f"{whole.name or 'root'}.log")


class Progress(logging.Handler):
    """Steps of a command as lines, while it is a context.

    Standard error gets a step once `PAUSE` has passed since the line before, and after `SILENCE` a
    line that repeats the step with its duration. The log has all steps and these lines.

    Parameters
    ----------
    name
        First word of each line.
    shown
        False if standard error gets no line.
    log
        Log file; a command shorter than `PAUSE` leaves none.
    """

    def __init__(self, name: str, *, shown: bool, log: Path | None = None) -> None:
        super().__init__()
        self._name, self._shown, self._log = name, shown, log
        self._stage, self._step, self._lines = "", "reading", list[str]()
        self._began = self._printed = time.monotonic()
        self._pending, self._mode = False, "w"
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._watch, daemon=True)

    def __enter__(self) -> Progress:
        self._stream = _own_stream()
        LOGGER.addHandler(self)
        self._level = LOGGER.level
        LOGGER.setLevel(logging.INFO)
        self._thread.start()
        return self

    def __exit__(self, *_error: object) -> None:
        LOGGER.removeHandler(self)
        LOGGER.setLevel(self._level)
        self._end.set()
        self._thread.join()
        if self._mode == "a":  # of steps after the last line
            self._write_log()
        if self._stream is not None:
            self._stream.close()

    def emit(self, record: logging.LogRecord) -> None:
        """Take a stage or a step as what is being done now."""
        text = record.getMessage()
        if getattr(record, "stage", False):
            self._stage = self._step = text
        else:
            self._step = f"{self._stage}: {text}" if self._stage else text
        self._began, self._pending = time.monotonic(), True
        self._stamp(self._step)
        self._print_late(self._began)

    def _watch(self) -> None:
        """Print what is late until the command ends."""
        while not self._end.wait(PAUSE):
            self.acquire()  # as for `emit`
            try:
                self._print_late(time.monotonic())
            finally:
                self.release()

    def _print_late(self, now: float) -> None:
        """Print the step, or that it goes on, if it is time for a line."""
        if self._pending and now - self._printed >= PAUSE:
            self._print(self._step, now)
        elif now - self._printed >= SILENCE:
            again = f"still on: {self._step}; {now - self._began:.0f} s"
            self._stamp(again)
            self._print(again, now)

    def _print(self, text: str, now: float) -> None:
        self._printed, self._pending = now, False
        self._write_log()
        if self._shown and self._stream is None:
            tell(f"{self._name}: {text}")
        elif self._shown and self._stream is not None:
            with contextlib.suppress(OSError):
                print(f"{self._name}: {text}", file=self._stream, flush=True)

    def _stamp(self, text: str) -> None:
        if self._log is not None:
            when = f"{datetime.now().astimezone():%Y-%m-%d %H:%M:%S}"
            self._lines.append(f"{when} {self._name}: {text}\n")

    def _write_log(self) -> None:
        """Append new lines to the log; one that cannot be written is left out."""
        if self._log is None or not self._lines:
            return
        with contextlib.suppress(OSError):
            self._log.parent.mkdir(parents=True, exist_ok=True)
            with self._log.open(self._mode, encoding="utf-8") as file:
                file.writelines(self._lines)
            self._mode = "a"
        self._lines.clear()


def _own_stream() -> TextIO | None:
    """Standard error by a number of its own; None if it has no number.

    Libraries that write to the terminal are silenced by redirecting the usual number
    (`linear_algebra.factor.silence_library`), which would suppress the progress as well.
    """
    try:
        number = os.dup(sys.stderr.fileno())
    except (OSError, ValueError, AttributeError):
        return None
    return open(number, "w", encoding=sys.stderr.encoding, errors="replace")  # noqa: PTH123
