"""Make a version of the set: `python -m cases.make ready`, `solve`, `peer`, then `freeze`.

Version 2 was made by `errata` from version 1's files alone. Answers are kept in `build/cases` and
found again, so that a run that was cut off goes on where it was. A version that is frozen is never
written again: errata make a new one.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from cases.make.answer import Answer, answer_path, save_answer
from cases.make.bodies import all_statements
from cases.make.confirmed import ELEMENTS, NGSOLVE, Confirmation, frozen_answer
from cases.make.statements import Statement
from cases.make.versions import (
    VERSIONS,
    digest,
    home,
    refuse_frozen,
    refuse_unconfirmed,
    say,
    write_version,
)
from msvalidate_check import frozen

HOME = Path(__file__).resolve().parents[2]
CHECKER = HOME / "checker" / "msvalidate_check"
VERSION = VERSIONS[-1]
STEPS = {
    "ready": "whether a version may be made",
    "solve": "ask reference_fem",
    "peer": "ask NGSolve",
    "freeze": "write a version from their answers",
    "errata": "write version 2 from the files of version 1",
}
LICENCE = """\
The data in this folder (meshes, case files, tables) are dedicated to the public domain under
CC0 1.0 Universal: https://creativecommons.org/publicdomain/zero/1.0/legalcode

To the extent possible under law, the authors of msvalidate have waived all copyright and related or
neighbouring rights to them. They may be copied, changed and used for any purpose, without asking.
"""
DIGESTS = '''"""Checksums of the frozen sets, by version: written by `make cases`, never changed."""

from __future__ import annotations

DIGESTS = {
{digests}}
"""Version -> SHA-256 of its file."""
'''


def main(arguments: list[str] | None = None) -> int:
    """Run one step; the exit code."""
    parser = argparse.ArgumentParser(prog="python -m cases.make", description=__doc__)
    parser.add_argument("step", choices=tuple(STEPS), help="; ".join(map(": ".join, STEPS.items())))
    parser.add_argument("--only", default="", help="cases whose names begin so")
    parser.add_argument("--dim", type=int, choices=(2, 3), help="of the plane, or of space, only")
    parser.add_argument("--out", type=Path, help="folder to write the set to, to compare it")
    given = parser.parse_args(arguments)
    chosen = [
        each
        for each in all_statements()
        if each.name.startswith(given.only) and given.dim in (None, each.dim)
    ]
    if not chosen:
        parser.error(f"--only {given.only!r}: no case begins so")
    if given.step == "ready":
        return refuse_frozen(home())
    if given.step in ("freeze", "errata"):
        return (_freeze if given.step == "freeze" else _mend)(chosen, given.out)
    return _solve_all(chosen) if given.step == "solve" else _ask_peer(chosen)


def _solve_all(chosen: list[Statement]) -> int:
    from cases.make.reference import answer_of  # noqa: PLC0415

    return _answer_all(ELEMENTS, chosen, answer_of)


def _ask_peer(chosen: list[Statement]) -> int:
    try:
        from cases.make.ngsolve_peer import answer_of  # noqa: PLC0415
    except ImportError as error:
        say(f"peer: {error}; pip install 'msvalidate[peers]'")
        return 2
    return _answer_all(NGSOLVE, [each for each in chosen if not each.is_uniform], answer_of)


def _answer_all(
    who: str, chosen: list[Statement], answer_of: Callable[[Statement, float], Answer]
) -> int:
    """Answers that are not kept yet."""
    wanted = [(each, nu) for each in chosen for nu in each.ratios]
    left = [(each, nu) for each, nu in wanted if not answer_path(who, each.name, nu).is_file()]
    say(f"{who}: {len(wanted) - len(left)} answers kept, {len(left)} to find")
    for number, (statement, nu) in enumerate(left, 1):
        began = time.perf_counter()
        answer = answer_of(statement, nu)
        save_answer(answer_path(who, statement.name, nu), answer)
        size = float(np.abs(answer.displacement).max())
        say(
            f"{number:4d} of {len(left)}  {statement.name} nu {nu:g}: displacement known to "
            f"{answer.uncertainty['displacement'] / size:.1e}, {time.perf_counter() - began:.0f} s"
        )
    return 0


def _freeze(chosen: list[Statement], out: Path | None) -> int:
    """Write a version from the programs' answers."""
    from cases.make.files import case_files, confirmed_csv  # noqa: PLC0415

    folder = home() if out is None else out
    if refuse_frozen(folder):
        return 2
    rows: list[Confirmation] = []
    files: dict[str, bytes] = {"LICENSE": LICENCE.encode()}
    for statement in chosen:
        answers = {}
        for nu in statement.ratios:
            answers[nu], more = frozen_answer(statement, nu)
            rows += more
        for name, content in case_files(statement, answers).items():
            files[f"{statement.name}/{name}"] = content
        say(f"{statement.name}: written")
    if refuse_unconfirmed(rows):
        return 1
    files["confirmed.csv"] = confirmed_csv(rows)
    write_version(folder, files, {})
    return _pack(chosen, (folder,), CHECKER if out is None else out)


def _mend(chosen: list[Statement], out: Path | None) -> int:
    """Write version 2: the files of version 1 that errata change."""
    from cases.make.errata import errata_text, mended, unchanged  # noqa: PLC0415

    folder = home() if out is None else out
    if refuse_frozen(folder):
        return 2
    files, rows = mended(chosen)
    if refuse_unconfirmed(rows):
        return 1
    files["ERRATA.md"] = errata_text(chosen, rows).encode()
    write_version(folder, files, unchanged(files))
    say(f"{len(files)} files of {sum(map(len, files.values())):,} bytes differ from version 1's")
    return _pack(chosen, (folder, home(1)), CHECKER if out is None else out)


def _pack(chosen: list[Statement], folders: tuple[Path, ...], to: Path) -> int:
    """Write the checker's file of a set, and its checksum beside the checker."""
    from cases.make.pack import pack_set  # noqa: PLC0415

    packed = pack_set(chosen, folders)
    (to / f"set_{VERSION}.npz").write_bytes(packed)
    if to == CHECKER:
        digests = frozen.DIGESTS | {VERSION: digest(packed)}
        rows = "".join(f'    {version}: "{sum_}",\n' for version, sum_ in digests.items())
        text = DIGESTS.replace("{digests}", rows)
        (CHECKER / "frozen.py").write_text(text, encoding="utf-8")
    say(f"{len(chosen)} cases packed in {len(packed):,} bytes")
    return 0


if __name__ == "__main__":
    sys.exit(main())
