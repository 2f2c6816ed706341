"""Results of a run in its folder, replaced atomically.

A run's results are built beside the folder and change places with it in one step, so that a reader,
or the next run, finds the old results or the new ones whatever happens in between. Where a folder
cannot be exchanged (a mount point, another file system, other people's files in it), each study's
folder and each page is replaced whole, one after another.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from msvalidate.bench.judging import catalogue
from msvalidate.bench.output.page import render_page
from msvalidate.bench.output.stored import (
    ABOUT,
    SUFFIXES,
    Stored,
    known_files,
    read_result,
    unreadable_result,
    verdict_json,
)
from msvalidate.problem import ProblemError
from msvalidate.problem.checks import format_value
from msvalidate_check import exchange

PAGES = ("report.html", "verdict.json")
"""Files in a results folder next to the studies' folders."""


def refuse_unwritable(out: Path, names: Sequence[str] = ()) -> None:
    """Raise `ProblemError`, before any work is done, if results could not be written to `out`.

    The folder is made, and removed again if it was not there. Folders of the named studies will lie
    in it.
    """
    if _place(out) == _place(out).parent:
        raise ProblemError(f"--out {out}: the root of all folders; name one in it")
    for name in names:
        if (out / name).exists() and not (out / name).is_dir():
            raise ProblemError(f"--out {out}: {out / name} is a file; name another folder")
    _refuse_foreign(out, names)
    _refuse_foreign_folder(out)
    for name in PAGES:
        if (out / name).is_dir():
            raise ProblemError(f"--out {out}: {out / name} is a folder; name another one")
    for folder in (out, *out.parents):
        if folder.exists() and not folder.is_dir():
            raise ProblemError(f"--out {out}: {folder} is a file; name a folder")
    _refuse_unmakeable(out)


def _refuse_foreign_folder(out: Path) -> None:
    """Raise `ProblemError` for a folder with files, none of which a run wrote."""
    names = sorted(path.name for path in out.iterdir()) if out.is_dir() and _writable(out) else []
    others = [name for name in names if not name.startswith(".")]
    if others and not {*PAGES, *_studies(out)} & {*others}:
        raise ProblemError(
            f"--out {out}: holds {format_value(others[0])} and no results; name a folder of its "
            f"own, such as {out / 'results'}"
        )


def _refuse_unmakeable(out: Path) -> None:
    """Make the folder and something in it, and leave no trace."""
    made = [folder for folder in (out, *out.parents) if not folder.exists()]
    try:
        out.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=out, prefix=exchange.STAGED):
            pass
    except OSError as error:
        raise ProblemError(f"--out {out}: {error.strerror}; name another folder") from error
    finally:
        for folder in made:
            with contextlib.suppress(OSError):
                folder.rmdir()


def refuse_place(option: str, path: Path, out: Path) -> None:
    """Raise `ProblemError`, before any work is done, if no file could be written at `path`."""
    if _place(out) in _place(path).parents:
        raise ProblemError(f"{option} {path}: inside --out {out}; name a place outside")
    if path.is_dir():
        raise ProblemError(f"{option} {path}: a folder; name a file")
    if path.exists() and not path.is_file():
        raise ProblemError(f"{option} {path}: a device or a pipe, which would be lost; name a file")
    if not path.parent.is_dir():
        raise ProblemError(f"{option} {path}: no folder {path.parent}; make it or name another")
    if not _writable(path.parent):
        raise ProblemError(f"{option} {path}: no permission to write there; name another place")


def refuse_folder(option: str, path: Path, out: Path, *, written: bool) -> None:
    """Raise `ProblemError`, before any work, if `path` is no folder apart, or cannot be written."""
    found, results = _place(path), _place(out)
    if results in (found, *found.parents) or found in results.parents:
        raise ProblemError(f"{option} {path}: shares a folder with --out {out}; name another")
    if found.exists() and not found.is_dir():
        raise ProblemError(f"{option} {path}: a file; name a folder")
    above = next(each for each in (found, *found.parents) if each.exists())
    if written and not (above.is_dir() and _writable(above)):
        raise ProblemError(f"{option} {path}: no permission to write there; name another place")


def publish(
    studies: Mapping[str, exchange.Files],
    out: Path,
    unfinished: Mapping[str, Callable[[Path], exchange.Files]] | None = None,
) -> list[Stored]:
    """Replace the results of some studies in `out`, and the pages over all that lie there.

    The studies come with their files, and those that did not finish with a function of their old
    folder that gives them; results of others stay. Returned are those given, as they are stored
    now, whatever another run does next.

    Raises `OSError` if a file cannot be written, and what was there is still there; `ProblemError`
    if other people's files lie where a study's folder goes.
    """
    out = out.resolve()
    out.parent.mkdir(parents=True, exist_ok=True)
    with exchange.alone(out.parent):
        late = unfinished or {}
        new_files = {**studies, **{name: make(out / name) for name, make in late.items()}}
        _refuse_foreign(out, list(new_files))
        whole = _only_results(out) and not _holds(out, Path.cwd()) and _writable(out.parent)
        if not (whole and _exchanged_whole(new_files, out)):
            _exchanged_one_by_one(new_files, out)
        return [read_result(out / name) for name in new_files]


def _exchanged_whole(studies: Mapping[str, exchange.Files], out: Path) -> bool:
    """Put new results and those that stay in the place of the old in one step, if that is known."""
    with exchange.stage_folder(out.parent) as new:
        for name, files in studies.items():
            exchange.write(new / name, files)
        for name in set(_studies(out)) - set(studies):
            exchange.write(new / name, {p.name: p.read_bytes() for p in (out / name).iterdir()})
        exchange.write(new, _pages(new))
        if not out.exists():
            new.rename(out)
            return True
        shutil.copymode(out, new)
        return exchange.exchange_folders(new, out)


def _exchanged_one_by_one(studies: Mapping[str, exchange.Files], out: Path) -> None:
    out.mkdir(exist_ok=True)
    with exchange.alone(out), exchange.stage_folder(out) as new:
        for name, files in studies.items():
            exchange.write(new / name, files)
            exchange.replace(new / name, out / name)
        exchange.write(new, _pages(out))
        for name in PAGES:
            exchange.replace(new / name, out / name)


def rebuild(out: Path) -> list[Stored]:
    """Make the pages of `out` again from what its studies left; return the studies.

    One that cannot be read has the reason for its error, and costs the others nothing.

    Raises `ProblemError` if there is no result.
    """
    if not _studies(out):
        raise ProblemError(f"--out {out}: no results there; run a study first")
    publish({}, out)
    return stored_studies(out)


def stored_studies(out: Path) -> list[Stored]:
    """The studies whose results lie in a folder, by name; of damaged ones no more than that."""
    return [_read_or_said(out / name) for name in _studies(out)]


def _pages(folder: Path) -> dict[str, bytes]:
    studies = stored_studies(folder)
    return {"report.html": render_page(studies).encode(), "verdict.json": verdict_json(studies)}


def _read_or_said(folder: Path) -> Stored:
    """Result of a study, or the reason why it cannot be read.

    Damage to one result does not affect the others.
    """
    try:
        return read_result(folder)
    except ProblemError as error:
        return unreadable_result(folder.name, str(error))


def _studies(folder: Path) -> list[str]:
    """Names of the studies that left results in a folder."""
    return [name for name in catalogue.names() if _is_file(folder / name / ABOUT)]


def _is_file(path: Path) -> bool:
    """Return True if a readable path is a file."""
    try:
        return path.is_file()
    except OSError:
        return False


def _refuse_foreign(out: Path, names: Sequence[str]) -> None:
    """Raise `ProblemError` if a study's folder holds what no run wrote: it would be lost."""
    for name in names:
        folder = out / name
        if not folder.is_dir():
            continue
        written = known_files(folder)
        if not written and _is_file(folder / ABOUT):
            raise ProblemError(
                f"--out {out}: {name}/{ABOUT} is damaged, so what lies beside it may be anybody's; "
                "move the folder away or name another"
            )
        for path in sorted(folder.iterdir()):
            if path.name not in written or path.is_dir():
                raise ProblemError(
                    f"--out {out}: no run wrote {name}/{path.name}, which would be lost; move it "
                    "away or name another folder"
                )


def _only_results(out: Path) -> bool:
    """Return True if a folder contains only results, so that it may be replaced."""
    if not out.exists():
        return True
    known = catalogue.names()
    try:
        for path in out.iterdir():
            if path.name in PAGES or path.name.startswith(exchange.STAGED):
                continue
            if path.name not in known or not path.is_dir() or path.is_symlink():
                return False
            if any(p.suffix not in SUFFIXES or not p.is_file() for p in path.iterdir()):
                return False
            if not all(os.access(p, os.R_OK) for p in path.iterdir()):
                return False
    except OSError:
        return False
    return True


def _place(path: Path) -> Path:
    """Resolve a path, even with links in a circle."""
    return Path(os.path.realpath(path))


def _writable(folder: Path) -> bool:
    return os.access(folder, os.W_OK | os.X_OK)


def _holds(folder: Path, other: Path) -> bool:
    """Return True if a folder is another one or contains it.

    Replacing it would then remove the other.
    """
    return folder == other or folder in other.parents
