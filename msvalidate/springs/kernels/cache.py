"""Cache of compiled kernels between processes, and its invalidation.

Compiled functions hold code of functions of other files, so that none is as new as its own file
alone. All that is kept lies in a folder named by one stamp: the sources of all kernels, and the
versions of Python, numba and llvmlite. In it is a file a compiled form, named by signature and
processor, so that two processes that compile at once write the same file or two different ones.
Older folders are cleared away when a new one is begun.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import pickle
import secrets
import shutil
import sys
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any, cast

import llvmlite
import numba
from numba.core import config
from numba.core.compiler import CompileResult
from numba.core.serialize import dumps
from numba.misc.appdirs import AppDirs

from msvalidate.problem.progress import report_step

HERE = Path(__file__).resolve().parent
OUTSIDE = (
    HERE.parent / "network" / "layout.py",
    *sorted((HERE.parents[1] / "dielectric" / "kernels").glob("*.py")),
)
"""Files beyond this folder that are compiled, or whose constants become part of compiled code."""
NAMED = "msvalidate-"
"""Prefix of the names of folders; the stamp follows."""
KEPT = 4
"""Folders that stay, the newest of them: a change that is taken back finds its own again."""
OPTIONS = ("OPT", "BOUNDSCHECK", "LOOP_VECTORIZE", "SLP_VECTORIZE", "DEBUGINFO_DEFAULT")
"""Settings of numba, by NUMBA_OPT and so on, that make other code of the same source."""


def stamp(sources: Path = HERE, outside: tuple[Path, ...] = OUTSIDE) -> str:
    """Name of all that compiled code is made of, but for the processor; 16 hexadecimal digits."""
    found = hashlib.sha256()
    versions = sys.version, numba.__version__, llvmlite.__version__
    found.update(repr(versions).encode())
    for path in (*sorted(sources.glob("*.py")), *outside):
        content = path.read_bytes()
        found.update(f"\n{path.name} {len(content)}\n".encode() + content)
    return found.hexdigest()[:16]


@lru_cache(maxsize=1)
def folder() -> Path | None:
    """The folder of this process; None if there is no place for one.

    It lies where NUMBA_CACHE_DIR says, beside the package's own compiled files, or in the user's
    cache: the first of these where something can be written.
    """
    try:
        name = f"{NAMED}{stamp()}"
    except OSError:  # no source to be read: a program packed into one file
        return None
    asked, own = getattr(config, "CACHE_DIR", ""), cast(Any, AppDirs)
    user = Path(own(appname="numba", appauthor=False).user_cache_dir)
    places = [*([Path(asked)] if asked else []), HERE / "__pycache__", user]
    return next((place / name for place in places if _writable(place / name)), None)


def _writable(place: Path) -> bool:
    """Return True if a folder is writable, or can be made."""
    try:
        place.stat()
    except FileNotFoundError:
        above = place.parent
        return above != place and not place.is_symlink() and _writable(above)
    except OSError:  # a name too long, links in a circle, a file above it
        return False
    return place.is_dir() and os.access(place, os.W_OK | os.X_OK)


class KernelCache:
    """Cache of a function's compiled forms, with numba's interface.

    A file that cannot be read, or is not as it was written, is none; where none can be written,
    the next process compiles again.
    """

    def __init__(self, function: Callable[..., Any], options: object) -> None:
        code = function.__code__
        place = Path(code.co_filename).stem, function.__qualname__, code.co_firstlineno
        self._name = "{}.{}-{}".format(*place).replace("<", "").replace(">", "")
        self._options = repr(options), tuple(getattr(config, name, None) for name in OPTIONS)
        folder()  # before any source can change

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """A form that was kept; None if there is none."""
        target_context.refresh()
        path = self._path(sig, target_context.codegen())
        try:
            content = path.read_bytes() if path else b""
        except OSError:
            content = b""
        told, data = content[:32], content[32:]
        if not data or hashlib.sha256(data).digest() != told:
            report_step("first run: compiling %s; later runs load it", self._name)
            return None
        rebuilt: Any = CompileResult._rebuild
        return rebuilt(target_context, *pickle.loads(data))  # noqa: S301  our own

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep a form that was compiled: whole, or not at all."""
        path = self._path(sig, data.codegen)
        if path is None or data.lifted or data.library.has_dynamic_globals:
            return
        if path.parent.name != f"{NAMED}{stamp()}":  # a source was changed while this process ran
            return
        pickled: Any = dumps
        content = pickled(data._reduce())
        part = path.with_name(f"{path.name}.{secrets.token_hex(8)}")
        try:
            if not path.parent.is_dir():
                path.parent.mkdir(parents=True, exist_ok=True)
                _clear_away(path.parent)
            part.write_bytes(hashlib.sha256(content).digest() + content)
            part.replace(path)
        except OSError:  # a full disk, or another process that clears away
            with contextlib.suppress(OSError):
                part.unlink()

    def _path(self, sig: Any, codegen: Any) -> Path | None:
        """The file of a form on the processor that numba compiles for."""
        home = folder()
        if home is None:
            return None
        key = repr((sig, codegen.magic_tuple(), self._options))
        return home / f"{self._name}.{hashlib.sha256(key.encode()).hexdigest()[:16]}.kernel"


def _clear_away(new: Path) -> None:
    """Remove all but the newest folders beside a new one, and what numba itself once kept there."""
    folders = [p for p in new.parent.glob(f"{NAMED}{'[0-9a-f]' * 16}") if p.is_dir() and p != new]
    for old in sorted(folders, key=lambda path: path.stat().st_mtime)[: 1 - KEPT]:
        shutil.rmtree(old, ignore_errors=True)
    if new.parent == HERE / "__pycache__":
        for old in new.parent.glob("*.nb[ic]"):
            old.unlink(missing_ok=True)
