"""Terminal output: results to stdout and messages to stderr, both short."""

from __future__ import annotations

import argparse
import contextlib
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from typing import TextIO

from msvalidate.bench.judging import catalogue
from msvalidate.cli.arguments import FAILED, HELD, PROGRAM, USAGE


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
    """The exit code of what is done; bad input, or no answer, is one line and its notes."""
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
        lines = [str(error), *getattr(error, "__notes__", ())]
        return tell_error("\n".join(lines), USAGE if isinstance(error, ProblemError) else FAILED)


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
