"""Make a version of the set: `python -m cases.make ready`, `solve`, `peer`, then `freeze`.

Answers are kept in `build/cases` and found again, so that a run that was cut off goes on where it
was. A version that is frozen is never written again: errata make a new one.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from cases.make.answer import Answer, answer_path, save_answer
from cases.make.bodies import all_statements
from cases.make.confirmed import ELEMENTS, NGSOLVE, Confirmation, frozen_answer
from cases.make.statements import Statement

HOME = Path(__file__).resolve().parents[2]
CHECKER = HOME / "checker" / "msvalidate_check"
VERSION = 1
LICENCE = """\
The data in this folder (meshes, case files, tables) are dedicated to the public domain under
CC0 1.0 Universal: https://creativecommons.org/publicdomain/zero/1.0/legalcode

To the extent possible under law, the authors of msvalidate have waived all copyright and related or
neighbouring rights to them. They may be copied, changed and used for any purpose, without asking.
"""
DIGESTS = '''"""Checksums of the frozen sets, by version: written by `make cases`, never changed."""

from __future__ import annotations

DIGESTS = {digests!r}
"""Version -> SHA-256 of its file."""
'''


def main(arguments: list[str] | None = None) -> int:
    """Run one step; the exit code."""
    parser = argparse.ArgumentParser(prog="python -m cases.make", description=__doc__)
    parser.add_argument("step", choices=("ready", "solve", "peer", "freeze"))
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
        return _refuse_frozen(HOME / "cases" / f"v{VERSION}")
    if given.step == "freeze":
        return _freeze(chosen, given.out)
    return _solve_all(chosen) if given.step == "solve" else _ask_peer(chosen)


def _solve_all(chosen: list[Statement]) -> int:
    from cases.make.reference import answer_of  # noqa: PLC0415

    return _answer_all(ELEMENTS, chosen, answer_of)


def _ask_peer(chosen: list[Statement]) -> int:
    try:
        from cases.make.ngsolve_peer import answer_of  # noqa: PLC0415
    except ImportError as error:
        _say(f"peer: {error}; pip install 'msvalidate[peers]'")
        return 2
    return _answer_all(NGSOLVE, [each for each in chosen if not each.is_uniform], answer_of)


def _answer_all(
    who: str, chosen: list[Statement], answer_of: Callable[[Statement, float], Answer]
) -> int:
    """Answers that are not kept yet."""
    wanted = [(each, nu) for each in chosen for nu in each.ratios]
    left = [(each, nu) for each, nu in wanted if not answer_path(who, each.name, nu).is_file()]
    _say(f"{who}: {len(wanted) - len(left)} answers kept, {len(left)} to find")
    for number, (statement, nu) in enumerate(left, 1):
        began = time.perf_counter()
        answer = answer_of(statement, nu)
        save_answer(answer_path(who, statement.name, nu), answer)
        size = float(np.abs(answer.displacement).max())
        _say(
            f"{number:4d} of {len(left)}  {statement.name} nu {nu:g}: displacement known to "
            f"{answer.uncertainty['displacement'] / size:.1e}, {time.perf_counter() - began:.0f} s"
        )
    return 0


def _freeze(chosen: list[Statement], out: Path | None) -> int:
    from cases.make.files import case_files, confirmed_csv  # noqa: PLC0415
    from cases.make.pack import archive, packed_case  # noqa: PLC0415

    home = HOME / "cases" / f"v{VERSION}" if out is None else out
    if _refuse_frozen(home):
        return 2
    rows: list[Confirmation] = []
    files: dict[str, bytes] = {"LICENSE": LICENCE.encode()}
    arrays: dict[str, np.ndarray] = {}
    facts: dict[str, object] = {}
    for statement in chosen:
        answers = {}
        for nu in statement.ratios:
            answers[nu], more = frozen_answer(statement, nu)
            rows += more
        for name, content in case_files(statement, answers).items():
            files[f"{statement.name}/{name}"] = content
        own, facts[statement.name] = packed_case(statement, answers)
        arrays |= own
        _say(f"{statement.name}: written")
    wrong = [row for row in rows if not row.is_inside]
    for row in wrong:
        _say(
            f"NOT CONFIRMED {row.case} nu {row.nu:g} {row.quantity}: {row.difference:.2e} apart, "
            f"{row.uncertainty:.2e} and {row.other_uncertainty:.2e} left open"
        )
    if wrong and out is None:
        return 1
    files["confirmed.csv"] = confirmed_csv(rows)
    packed = archive(arrays, facts)
    _write(home, files)
    if out is None:
        (CHECKER / f"set_{VERSION}.npz").write_bytes(packed)
        text = DIGESTS.replace("{digests!r}", repr({VERSION: _digest(packed)}).replace("'", '"'))
        (CHECKER / "frozen.py").write_text(text, encoding="utf-8")
    else:
        (home / f"set_{VERSION}.npz").write_bytes(packed)
    size = sum(map(len, files.values()))
    _say(f"{len(chosen)} cases, {len(files)} files of {size:,} bytes, packed {len(packed):,}")
    return 0


def _refuse_frozen(home: Path) -> int:
    """2 with a word why, if a version is there; else 0."""
    if not home.exists():
        return 0
    _say(f"{home.name}: frozen; it is never written again. Errata make a new version")
    return 2


def _write(home: Path, files: dict[str, bytes]) -> None:
    """All files of a version at once: beside, then renamed."""
    new = home.with_name(f"{home.name}.new-{os.getpid()}")
    for name, content in files.items():
        path = new / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    (new / "SHA256SUMS").write_text("".join(_sums(files)), encoding="utf-8")
    new.replace(home)


def _sums(files: dict[str, bytes]) -> Iterator[str]:
    for name, content in sorted(files.items()):
        yield f"{_digest(content)}  {name}\n"


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)  # noqa: T201


if __name__ == "__main__":
    sys.exit(main())
