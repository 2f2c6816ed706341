"""Programs run in a process of their own, with limits of time and memory.

The whole process group ends with the program, and with the caller, however the caller ends. Output
is stored up to a size and read to its end, so that the program never waits for a reader.
"""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import threading
from pathlib import Path
from typing import IO

from msvalidate.problem import ProblemError
from msvalidate.problem.checks import format_value

LIMIT = 300.0
"""Seconds that a program may take by default."""
STORED = 100_000
"""Bytes that are stored from the beginning of a stream, and from its end."""
PIECE = 65_536
PATIENCE = 2.0
"""Seconds that streams may stay open after the program's end.

A process that left its group may keep them open for ever."""
GUARDED = """\
exec 3<&0 </dev/null
( (read word <&3; kill -KILL 0) >/dev/null 2>&1 & )
exec 3<&-
exec "$@"
"""
"""Shell script that becomes the program.

Its background process, which is no child of the program, waits until our end of a pipe closes, as
it does however we end, and then ends the group. No signal handler of ours would do.
"""
BOUNDED = """\
ulimit -v {}
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
"""
"""Start of the script with a limit of memory (KiB); threads would reserve more."""


def run_limited(
    words: list[str], folder: Path, limit: float, memory: float = 0.0
) -> tuple[int | None, bytes, str]:
    """Run a program in a folder, with limits of time and memory.

    Parameters
    ----------
    words, folder
        The command, and the folder that it starts in.
    limit
        Seconds after which it is ended.
    memory
        Bytes that each of its processes may reserve, on POSIX systems; 0 sets no limit.

    Returns
    -------
    int or None, bytes, str
        Exit code, None if it had to be ended; its output, shortened; its last line on stderr.

    Raises
    ------
    ProblemError
        If the program cannot be started.
    """
    script = (BOUNDED.format(int(memory / 1024)) if memory else "") + GUARDED
    guarded = ["/bin/sh", "-c", script, words[0], *words] if os.name == "posix" else words
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
            f"program {format_value(words[0])}: {error.strerror}; give one that can be run"
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
    """A stream that a thread reads to its end, with its beginning and end stored."""

    def __init__(self, pipe: IO[bytes]) -> None:
        self._pipe = pipe
        self._stored, self._lost = bytearray(), 0
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    def _read(self) -> None:
        with contextlib.suppress(OSError, ValueError):
            while piece := os.read(self._pipe.fileno(), PIECE):
                self._stored += piece
                more = max(len(self._stored) - 2 * STORED, 0)
                del self._stored[STORED : STORED + more]
                self._lost += more

    def finish(self) -> None:
        """Wait for its end, but not for ever."""
        self._thread.join(PATIENCE)
        if not self._thread.is_alive():
            self._pipe.close()

    @property
    def content(self) -> bytes:
        """Stored bytes, with a note of the bytes left out."""
        gap = f"\n... {self._lost} bytes left out ...\n".encode() if self._lost else b""
        return bytes(self._stored[:STORED]) + gap + bytes(self._stored[STORED:])

    @property
    def last_line(self) -> str:
        """Last line that is not empty, in printable letters."""
        text = self.content.decode("utf-8", "replace")
        lines = [" ".join(line.split()) for line in text.splitlines() if line.strip()]
        shown = lines[-1] if lines else ""
        return "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in shown)[:500]
