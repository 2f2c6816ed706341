"""Terminal output: results to stdout and messages to stderr, both short."""

from __future__ import annotations

import argparse
import contextlib
import logging
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TextIO

from msvalidate.cli.arguments import FAILED, HELD, PROGRAM, USAGE
from msvalidate.judging import catalogue


def tell(message: str) -> None:
    """A line to stderr; one that cannot be read any more is not missed."""
    with contextlib.suppress(OSError):
        print(message, file=sys.stderr, flush=True)  # a killed run has said all that it could
        return
    sys.stderr = nowhere()


def tell_error(message: str, code: int) -> int:
    """An error in one line; its exit code."""
    tell(f"{PROGRAM}: error: {message}")
    return code


def attempt(act: Callable[[], int]) -> int:
    """The exit code of what is done; bad input, or no answer, is said in one line."""
    try:
        return act()
    except ImportError as error:
        return tell_error(str(error), USAGE)
    except OSError as error:
        from msvalidate.problem.checks import format_value

        name = format_value(str(error.filename)).strip("'")
        return tell_error(f"{error.strerror}: {name}" if error.filename else str(error), USAGE)
    except (ValueError, RuntimeError) as error:
        from msvalidate.problem import ProblemError, SolverError

        if not isinstance(error, ProblemError | SolverError):
            raise
        return tell_error(str(error), USAGE if isinstance(error, ProblemError) else FAILED)


@contextlib.contextmanager
def naming(said: str, but: tuple[str, ...] = ()) -> Iterator[None]:
    """Let errors begin with what they are about, `but` for those that begin with such words."""
    from msvalidate.problem import ProblemError, SolverError

    try:
        yield
    except (ProblemError, SolverError) as error:
        text = " ".join(str(error).split())
        error.args = (text if text.startswith(but or ("\0",)) else f"{said}: {text}",)
        raise


def print_lines(lines: Sequence[str]) -> int:
    """Lines to stdout; the exit code of a place where they do not fit."""
    try:
        for line in lines:
            print(line)
        print(end="", flush=True)
    except BrokenPipeError:  # the reader left; the verdict stands
        sys.stdout = nowhere()
    except OSError as error:  # a full disk; results are in files
        sys.stdout = nowhere()
        return tell_error(f"stdout: {error.strerror}", USAGE)
    return HELD


def nowhere() -> TextIO:
    """A stream that leads nowhere."""
    return open(os.devnull, "w", encoding="utf-8")  # noqa: PTH123  as long as the process


def list_studies(_args: argparse.Namespace) -> int:
    """Each study with what it asks, or why it cannot be read: which costs no other its line."""
    names = catalogue.names()
    asked = dict.fromkeys(names, "")
    for name in names:
        try:
            asked[name] = catalogue.question(name)
        except ImportError as error:
            asked[name] = f"(cannot be read: {error})"
    width = max(map(len, names))
    return print_lines([f"{name:<{width}}  {said}" for name, said in asked.items()])


def announce_compilation() -> None:
    """Let a first run say, once, that it compiles kernels, which only it has to wait for."""
    kernels = logging.getLogger("msvalidate.kernels.cache")

    def tell_once(_record: logging.LogRecord) -> bool:
        kernels.removeFilter(tell_once)
        tell("first run: compiling, some 5 to 20 s; later runs find it compiled")
        return False

    kernels.setLevel(logging.INFO)
    kernels.addFilter(tell_once)


class Progress:
    """Steps of something that takes a while: a terminal shows the one that is taken, written over.

    What was done is elsewhere a line of stderr, and a line of the file `log`.
    """

    def __init__(self, name: str, *, shown: bool, log: Path | None = None) -> None:
        self._name, self._shown, self._log = name, shown, log
        self._written_over = shown and sys.stderr.isatty()
        self._lines: list[str] = []

    def __call__(self, step: str) -> None:
        """Say what is being done now."""
        self._show(f"{self._name}: {step} ...")

    def done(self, said: str) -> None:
        """Say what was done."""
        self._lines.append(f"{self._name}: {said}")
        if self._shown and not self._written_over:
            tell(self._lines[-1])
        if self._log is not None:
            from msvalidate_check import exchange

            text = "\n".join([*self._lines, ""])
            with contextlib.suppress(OSError):
                exchange.replace_file(self._log, text.encode)

    def clear(self) -> None:
        """Take the line away."""
        self._show("")

    def _show(self, text: str) -> None:
        if self._written_over:
            sys.stderr.write(f"\r\033[K{text}")
            sys.stderr.flush()
