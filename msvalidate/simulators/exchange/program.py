"""A simulator as a program: called through files, its endings turned into errors."""

from __future__ import annotations

import contextlib
import os
import shlex
import shutil
import signal
import sys
import tempfile
from pathlib import Path

from msvalidate.problem import ProblemError
from msvalidate.problem.checks import format_value, positive_number
from msvalidate.problem.records import dataclass
from msvalidate.simulators.exchange.answers import read_answer
from msvalidate.simulators.exchange.folders import REQUEST, write_request
from msvalidate.simulators.exchange.protocol import (
    CANNOT,
    Answer,
    CannotRepresent,
    OutOfTime,
    Request,
    SimulatorError,
)
from msvalidate.springs.bodies.process import LIMIT, run_limited
from msvalidate_check import exchange

CASE, OUT, LOG = "case", "out", "log.txt"


@dataclass(frozen=True)
class Program:
    """An adapter: called with a `Request`, runs ``COMMAND CASE_DIR OUT_DIR``, returns its answer.

    Parameters
    ----------
    command
        Words as in a shell, which none is used for. Files that it names are looked for where we
        are; a .py file is run with our own Python. The program's own folder is OUT_DIR.
    limit
        Seconds after which it is ended.
    keep
        Folder in which CASE_DIR and OUT_DIR of the latest call stay, as `case` and `out`; by
        default nothing stays. What the program said is ``log.txt`` in OUT_DIR. Each call works in a
        folder of its own beside it, which takes its place in one step at the end.

    Raises
    ------
    ProblemError
        If the command has no words or names no program, or the limit is not above zero.
    """

    command: str
    limit: float = LIMIT
    keep: Path | None = None

    def __post_init__(self) -> None:
        positive_number("--limit", self.limit, "s")
        words_of(self.command)

    def __call__(self, request: Request) -> Answer:
        """The program's answer.

        Raises
        ------
        CannotRepresent
            If it ends with exit code 77; the reason is the last line that it says on stderr.
        SimulatorError
            If it takes too long, ends with another code but 0, or leaves no answer.
        ProblemError
            If `keep` holds other files.
        """
        if self.keep is None:
            with tempfile.TemporaryDirectory("", "msvalidate-", ignore_cleanup_errors=True) as name:
                return self._run(request, Path(name).resolve())
        keep = Path(self.keep).resolve()
        _refuse_others(keep)
        with exchange.own_folder(keep.parent) as own:
            try:
                return self._run(request, own)
            finally:  # also when we are interrupted
                with exchange.alone(keep.parent):
                    exchange.replace(own, keep)

    def _run(self, request: Request, folder: Path) -> Answer:
        case, out = folder / CASE, folder / OUT
        write_request(request, case)
        exchange.replace_one(out, {LOG: b""})
        words = [*words_of(self.command), str(case), str(out)]
        code, said, complaint = run_limited(words, out, self.limit)
        exchange.replace_file(out / LOG, lambda: said)
        self._refuse_ending(code, complaint)
        return read_answer(out, request)

    def _refuse_ending(self, code: int | None, complaint: str) -> None:
        if code is None:
            raise OutOfTime(
                f"adapter: not done after {self.limit:g} s, and ended; give it longer by --limit, "
                "or fewer cells"
            )
        if code == CANNOT:
            raise CannotRepresent(complaint or "it does not say why")
        if code < 0:
            name = signal.strsignal(-code) or f"signal {-code}"
            raise SimulatorError(f"adapter: ended by the system ({name}): {complaint or 'no word'}")
        if code:
            raise SimulatorError(f"adapter: exit code {code}: {complaint or 'no word on stderr'}")


def _refuse_others(keep: Path) -> None:
    """Raise `ProblemError` where a folder that would be replaced holds more than a run."""
    marks = {CASE: REQUEST, OUT: LOG}
    others = keep.exists() and not (
        keep.is_dir()
        and all(
            path.name in marks and (path / marks[path.name]).is_file() for path in keep.iterdir()
        )
    )
    if others:
        raise ProblemError(f"folder {keep}: holds what no adapter left there; name another")


def words_of(command: str) -> list[str]:
    """A command's words: the program found, files made absolute.

    Raises
    ------
    ProblemError
        If there are none, a quotation is not closed, or there is no such program.
    """
    try:
        words = shlex.split(command)
    except ValueError as error:
        raise ProblemError(f"adapter {format_value(command)}: {error}; close it") from error
    if not words or "\0" in command:
        raise ProblemError(f"adapter {format_value(command)}: no program; give a command")
    words = [_absolute(word) for word in words]
    script = words[0].endswith(".py")
    found = sys.executable if script and Path(words[0]).is_file() else shutil.which(words[0])
    if found is None:
        raise ProblemError(
            f"adapter {format_value(words[0])}: no such program, or none that can be run; give "
            "its path"
        )
    return [found, *words] if found == sys.executable and script else [found, *words[1:]]


def label_of(command: str) -> str:
    """Name of an adapter's results: the last file in its command."""
    words = words_of(command)
    files = [word for word in words if os.path.isfile(word)]  # noqa: PTH113  long ones are none
    return Path((files or words)[-1]).stem


def _absolute(word: str) -> str:
    """A word that names a file from here, so that it does from anywhere; others as they are."""
    with contextlib.suppress(OSError, ValueError):
        looks = os.sep in word or "." in word
        if looks and not word.startswith("-") and Path(word).exists():
            # Not resolved: a virtual environment's Python is a link, and must be called by it.
            return str(Path(word).absolute())
    return word
