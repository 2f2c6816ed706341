"""A simulator that is a program of its own: run in a process of its own, with a time limit.

Its whole process group is ended with it, and with us, however we end. What it says is kept up to a
size, and read to the end whatever its size, so that it never waits for us.
"""

from __future__ import annotations

import contextlib
import os
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
from pathlib import Path
from typing import IO

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
from msvalidate_check import exchange

LIMIT = 300.0
"""Seconds that a program may take where nothing is said."""
KEPT = 100_000
"""Bytes of each of its streams that are kept from the beginning, and as many from the end."""
PIECE = 65_536
PATIENCE = 2.0
"""Seconds that streams may stay open after the program's end: a process that left its group may
hold them for ever."""
CASE, OUT, LOG = "case", "out", "log.txt"
GUARDED = """\
exec 3<&0 </dev/null
( (read word <&3; kill -KILL 0) >/dev/null 2>&1 & )
exec 3<&-
exec "$@"
"""
"""Becomes the program. What it leaves beside it, a child of neither, waits for our end of a pipe to
close, as it does however we end, and then ends the group. No signal that we catch would do."""


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
    """What results of an adapter are called: after the last file that its command names."""
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


def run_limited(words: list[str], folder: Path, limit: float) -> tuple[int | None, bytes, str]:
    """Run a program in a folder for at most `limit` seconds.

    Returns
    -------
    int or None, bytes, str
        Exit code, None if it had to be ended; what it said, shortened; its last line on stderr.
    """
    guarded = ["/bin/sh", "-c", GUARDED, words[0], *words] if os.name == "posix" else words
    try:
        process = subprocess.Popen(  # noqa: S603  the user's own command, no word of it a shell's
            guarded,
            cwd=folder,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            start_new_session=True,
        )
    except OSError as error:
        raise ProblemError(
            f"adapter {format_value(words[0])}: {error.strerror}; give a program that can be run"
        ) from error
    streams = [_Stream(each) for each in (process.stdout, process.stderr) if each is not None]
    code: int | None = None
    try:
        code = process.wait(limit)
    except subprocess.TimeoutExpired:
        pass
    finally:  # also when we are interrupted; and what a program that ended has left running
        _end_group(process)
    for stream in streams:
        stream.finish()
    told = [b"stdout:\n", streams[0].content, b"\nstderr:\n", streams[1].content, b"\n"]
    return code, b"".join(told), streams[1].last_line


def _end_group(process: subprocess.Popen[bytes]) -> None:
    if hasattr(os, "killpg"):
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)
    with contextlib.suppress(OSError):
        process.kill()
    process.wait()
    if process.stdin is not None:
        process.stdin.close()


class _Stream:
    """A stream read to its end by a thread of its own, its beginning and its end kept."""

    def __init__(self, pipe: IO[bytes]) -> None:
        self._pipe = pipe
        self._kept, self._lost = bytearray(), 0
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    def _read(self) -> None:
        with contextlib.suppress(OSError, ValueError):
            while piece := os.read(self._pipe.fileno(), PIECE):
                self._kept += piece
                more = max(len(self._kept) - 2 * KEPT, 0)
                del self._kept[KEPT : KEPT + more]
                self._lost += more

    def finish(self) -> None:
        """Wait for its end, but not for ever."""
        self._thread.join(PATIENCE)
        if not self._thread.is_alive():
            self._pipe.close()

    @property
    def content(self) -> bytes:
        """What is kept of it."""
        gap = f"\n... {self._lost} bytes left out ...\n".encode() if self._lost else b""
        return bytes(self._kept[:KEPT]) + gap + bytes(self._kept[KEPT:])

    @property
    def last_line(self) -> str:
        """Its last line that is not empty, in printable letters."""
        text = self.content.decode("utf-8", "replace")
        lines = [" ".join(line.split()) for line in text.splitlines() if line.strip()]
        shown = lines[-1] if lines else ""
        return "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in shown)[:500]
