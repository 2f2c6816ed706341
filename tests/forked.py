"""The program in processes of its own, forked from one that has imported the libraries.

A fresh interpreter takes a second of imports before it says anything; a fork takes none, and is as
far from the tests' own process. What imports itself, environment read at import, or the stream of a
shell is about has to be asked of a fresh one.
"""

from __future__ import annotations

import multiprocessing
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from unittest.mock import patch

PRELOADED = [
    "tests.forked",
    "msvalidate.cli.program",
    "msvalidate.cli.jobs",
    "msvalidate.bench.output.report",
    "msvalidate.springs.statics.equilibrium",
    "msvalidate.studies.poisson",
    "matplotlib.backends.backend_agg",
    "matplotlib.backends.backend_svg",
]


def completed(
    arguments: Sequence[str], script: str | None, cwd: Path | None, environment: Mapping[str, str]
) -> subprocess.CompletedProcess[str]:
    """Run the program, or a script that calls it; its exit code and what it said."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(PRELOADED)
    with tempfile.TemporaryDirectory() as folder:
        said = [Path(folder) / name for name in ("out", "err")]
        process = context.Process(
            target=_act, args=(list(arguments), script, cwd, dict(environment), said)
        )
        # From Python 3.14 on the server has our arguments, by which the program would call itself.
        with patch.object(sys, "argv", ["program"]):
            process.start()
        process.join(120)
        if process.exitcode is None:
            process.kill()
            raise subprocess.TimeoutExpired(["msvalidate", *arguments], 120)
        out, err = (path.read_text(encoding="utf-8") for path in said)
        return subprocess.CompletedProcess(list(arguments), process.exitcode, out, err)


def _act(
    arguments: list[str],
    script: str | None,
    cwd: Path | None,
    environment: dict[str, str],
    said: list[Path],
) -> None:
    for number, path in enumerate(said, 1):
        file = os.open(path, os.O_WRONLY | os.O_CREAT)
        os.dup2(file, number)
        os.close(file)
    for stream in (sys.stdout, sys.stderr):
        stream.reconfigure(encoding="utf-8")
    os.environ.clear()
    os.environ.update(environment)
    if cwd:
        os.chdir(cwd)
    sys.argv = ["program", *arguments]
    if script is None:
        from msvalidate.cli import program  # noqa: PLC0415

        program.run()
    else:
        exec(compile(script, "<script>", "exec"), {"__name__": "__main__"})  # noqa: S102
