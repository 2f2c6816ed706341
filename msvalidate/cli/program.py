"""The command line, ``python -m msvalidate.study NAME``.

It defines no types and is imported by nobody: run as a module it is ``__main__``, and whatever it
defined would exist twice. Heavy imports wait until a study is really run.
"""

from __future__ import annotations

import argparse
import os
import sys
import threading
import traceback
from collections.abc import Callable, Sequence
from importlib import import_module
from typing import Any, NoReturn

from msvalidate.cli.arguments import FAILED, HELD, INTERRUPTED, parse
from msvalidate.cli.terminal import attempt, nowhere, print_lines, tell, tell_error

LOADING = 5.0
"""Seconds between lines of a command that still loads its libraries."""


def main(arguments: Sequence[str]) -> int:
    """Run what the command line asks for; return the exit code."""
    args = parse(arguments)
    # One thread for dense algebra: the sparse solves here gain nothing from more, and sums come out
    # the same on any number of cores. Who asks for more has them, but not in each of several jobs.
    for library in ("OPENBLAS", "MKL", "OMP"):
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")
        if args.jobs > 1:
            os.environ[f"{library}_NUM_THREADS"] = "1"
    # Figures are made without a window; the library refuses to start with one that is not there.
    os.environ["MPLBACKEND"] = "agg"
    try:
        return attempt(lambda: _load(args.act, quiet=args.quiet)(args))
    except Exception as error:  # noqa: BLE001  a fault of ours: one line, and a code of its own
        if args.verbose:
            tell(traceback.format_exc())
        said = " ".join(f"{type(error).__name__}: {error}".split())
        return tell_error(f"a fault of the program itself: {said}; -v shows where", FAILED)


def _load(act: str, *, quiet: bool) -> Callable[[argparse.Namespace], int]:
    """Load the function of a command, and report that unless it is quiet.

    Its libraries take seconds on a busy machine.
    """
    module, _, name = act.partition(":")
    loaded = threading.Event()

    def report() -> None:
        while not (loaded.wait(LOADING) or quiet):
            tell("loading libraries")

    threading.Thread(target=report, daemon=True).start()
    try:
        function: Callable[[argparse.Namespace], int]
        function = getattr(import_module(f"msvalidate.cli.{module}"), name)
    finally:
        loaded.set()
    return function


def _prepare_streams() -> None:
    """Streams that take any letter; what was closed (``>&-``, cron) leads nowhere.

    The numbers of closed ones are taken, else the first file that is opened would be stdout.
    """
    while (number := os.open(os.devnull, os.O_RDWR)) <= 2:
        pass
    os.close(number)
    for name in ("stdout", "stderr"):
        stream: Any = getattr(sys, name) or nowhere()
        stream.reconfigure(errors="replace")
        setattr(sys, name, stream)


def run() -> NoReturn:
    """Run the command line as a program: streams that take any letter, and an exit code."""
    _prepare_streams()
    try:
        code = main(sys.argv[1:])
    except SystemExit as end:  # --help, or wrong usage
        code = end.code if isinstance(end.code, int) else HELD
    except KeyboardInterrupt:
        code = tell_error("interrupted; results are as they were", INTERRUPTED)
    sys.exit(max(code, print_lines([])))  # what --help left unwritten
