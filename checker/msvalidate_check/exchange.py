"""Files and folders are replaced whole: on the disk before they take their place, in one step.

What is new is built beside the old and changes places with it, so that whoever reads finds the one
or the other, whatever happens in between.
"""

from __future__ import annotations

import contextlib
import ctypes
import errno
import os
import secrets
import shutil
import sys
from collections.abc import Callable, Container, Iterator, Mapping
from pathlib import Path

try:
    import fcntl
except ImportError:  # not a Unix
    fcntl = None  # type: ignore[assignment]

Files = Mapping[str, bytes]
EXCHANGE = 2
"""RENAME_EXCHANGE of Linux's renameat2, RENAME_SWAP of macOS's renamex_np."""
NO_EXCHANGE = {errno.ENOSYS, errno.EINVAL, errno.EXDEV, errno.EBUSY, errno.EPERM, errno.EACCES}
STAGED, ASIDE = ".msvalidate-new-", ".msvalidate-old-"
"""How names begin of what is being written, and of what two renames put aside for a moment."""
OWN = ".msvalidate-run-"
"""How names begin of the folders that runs work in."""


@contextlib.contextmanager
def alone(folder: Path) -> Iterator[None]:
    """Wait until no other run stages anything in a folder, and keep others waiting."""
    if fcntl is None:
        yield
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX)
        yield
    finally:
        os.close(handle)


@contextlib.contextmanager
def stage_folder(folder: Path) -> Iterator[Path]:
    """A new folder in `folder`, gone at the end; what killed runs left is put back or cleared away.

    Call it alone: see `alone`.
    """
    for left in folder.glob(f"{ASIDE}*"):
        place = folder / left.name.removeprefix(ASIDE)
        if place.exists():
            shutil.rmtree(left, ignore_errors=True)
        else:
            left.rename(place)
    for left in folder.glob(f"{STAGED}{'[0-9a-f]' * 16}"):
        shutil.rmtree(left, ignore_errors=True)
    new = folder / f"{STAGED}{secrets.token_hex(8)}"
    new.mkdir()
    try:
        yield new
    finally:
        shutil.rmtree(new, ignore_errors=True)


@contextlib.contextmanager
def own_folder(beside: Path) -> Iterator[Path]:
    """A folder to work in while we live, gone at the end; those of killed runs are cleared away."""
    beside.mkdir(parents=True, exist_ok=True)
    with contextlib.ExitStack() as held:
        with alone(beside):
            for left in beside.glob(f"{OWN}*"):
                if _is_left(left):
                    shutil.rmtree(left, ignore_errors=True)
            own = beside / f"{OWN}{secrets.token_hex(8)}"
            own.mkdir()
            held.callback(shutil.rmtree, own, ignore_errors=True)
            held.enter_context(alone(own))
            (own / "run").mkdir()  # it may be exchanged for another while we hold the one above
        yield own / "run"


def _is_left(own: Path) -> bool:
    """Whether nobody lives who works in a folder of `own_folder`."""
    if fcntl is None:
        return False
    with contextlib.suppress(OSError):
        handle = os.open(own, os.O_RDONLY)
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        finally:
            os.close(handle)
        return True
    return False


def write(folder: Path, files: Files) -> None:
    """Write files to the disk itself: a name must not outlive its content."""
    folder.mkdir(exist_ok=True)
    for name, content in files.items():
        path = folder / name
        try:
            with path.open("wb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
        except OSError as error:
            raise OSError(error.errno, error.strerror, f"{folder.name}/{name}") from error


def replace(new: Path, old: Path) -> None:
    """Put a file or folder in another's place: in one step where that can be done."""
    if new.is_file() or not old.exists():
        new.replace(old)
    elif not exchange_folders(new, old):
        aside = old.with_name(f"{ASIDE}{old.name}")
        old.rename(aside)
        new.rename(old)
        shutil.rmtree(aside, ignore_errors=True)


def exchange_folders(one: Path, other: Path) -> bool:
    """Exchange two folders atomically, where the operating system can."""
    library = ctypes.CDLL(None, use_errno=True) if os.name == "posix" else None
    a, b = os.fsencode(one), os.fsencode(other)
    if library is not None and sys.platform == "darwin" and hasattr(library, "renamex_np"):
        failed = library.renamex_np(a, b, EXCHANGE)
    elif library is not None and hasattr(library, "renameat2"):
        here = -100  # AT_FDCWD: both paths are absolute
        failed = library.renameat2(here, a, here, b, EXCHANGE)
    else:
        return False
    if not failed:
        return True
    code = ctypes.get_errno()
    if code in NO_EXCHANGE:
        return False
    raise OSError(code, os.strerror(code), str(other))


def replace_folder(
    folder: Path,
    files: Mapping[str, Files],
    *,
    keep: bool = False,
    beside: tuple[Path, Callable[[], bytes]] | None = None,
) -> None:
    """Replace a folder of folders whole.

    Parameters
    ----------
    folder
        It is made if it is missing.
    files
        Name of a folder in it, "." for itself -> its files.
    keep
        Whether all else that lies in it goes into the new one as it is.
    beside
        A file elsewhere that is replaced with it, and what makes its content: both are on the disk
        before either takes its place, the file first.
    """
    folder = folder.resolve()
    folder.parent.mkdir(parents=True, exist_ok=True)
    with alone(folder.parent), stage_folder(folder.parent) as new:
        if keep and folder.is_dir():
            _copy_others(folder, new, files)
        for name, content in files.items():
            write(new / name, content)
        path = beside[0].resolve() if beside else None
        if beside and path and path.parent == folder.parent:  # which is alone and staged already
            write(new, {path.name: beside[1]()})
            replace(new / path.name, path)
            replace(new, folder)
        elif beside:
            replace_file(beside[0], beside[1], then=lambda: replace(new, folder))
        else:
            replace(new, folder)


def replace_one(folder: Path, files: Files) -> None:
    """Replace a folder of files whole; it is made, and those above it, if it is missing."""
    folder = folder.resolve()
    folder.parent.mkdir(parents=True, exist_ok=True)
    with alone(folder.parent), stage_folder(folder.parent) as new:
        write(new / folder.name, files)
        replace(new / folder.name, folder)


def _copy_others(old: Path, new: Path, names: Container[str]) -> None:
    """Copy what lies in a folder, but for some names in it, to the disk itself as `write` does."""

    def left_out(folder: str, found: list[str]) -> list[str]:
        return [name for name in found if Path(folder) == old and name in names]

    def copy(source: str, target: str) -> None:
        write(Path(target).parent, {Path(target).name: Path(source).read_bytes()})

    shutil.copytree(
        old, new, symlinks=True, ignore=left_out, copy_function=copy, dirs_exist_ok=True
    )


def replace_file(
    path: Path, content: Callable[[], bytes], then: Callable[[], None] = lambda: None
) -> None:
    """Replace a file whole, its content made when no other run can write it; `then` at once act."""
    path = path.resolve()
    with alone(path.parent), stage_folder(path.parent) as new:
        write(new, {path.name: content()})
        replace(new / path.name, path)
        then()
