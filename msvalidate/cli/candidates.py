"""A candidate named on the command line: a function of a module, or of a file.

It is code of the user's own, run with the user's own rights, like a study of theirs.
"""

from __future__ import annotations

import difflib
import importlib
import inspect
import sys
from pathlib import Path
from types import ModuleType

from msvalidate import studies
from msvalidate.bench.judging.foreign import asks_displacements
from msvalidate.problem import ProblemError
from msvalidate.problem.checks import format_value

FORM = "give module:function, or file.py:function"
DISPLACEMENTS = ("problem", "network", "answer")
"""Arguments of a candidate for displacements, in order."""


def load_candidate(named: str) -> object:
    """Load the object ``module:function`` or ``file.py:function``.

    The name may have dots.

    Raises
    ------
    ProblemError
        If there is no such module, or nothing of that name in it, or it cannot be imported.
    """
    place, _, name = named.rpartition(":")
    if not place or not name:
        raise ProblemError(f"--candidate {format_value(named)}; {FORM}")
    found: object = _import(place)
    for part in name.split("."):
        if not hasattr(found, part):
            near = difflib.get_close_matches(part, dir(found), n=1)
            hint = f"did you mean {near[0]!r}?" if near else FORM
            raise ProblemError(f"--candidate {named}: no {part!r} in {place}; {hint}")
        found = getattr(found, part)
    return found


def check_candidate(named: str, study: str, module: ModuleType) -> None:
    """Raise `ProblemError` if what is named cannot be a candidate of a study."""
    run = inspect.signature(module.run)
    if "candidate" not in run.parameters or getattr(module, "READS_RESULTS", False):
        raise ProblemError(
            f"--candidate: {study} judges what other studies found, not a candidate; name another"
        )
    found = load_candidate(named)
    if not asks_displacements(module.run):
        return  # the study says itself what it asks for
    need = f"a function of ({', '.join(DISPLACEMENTS)}) that returns displacements (n, d) in m"
    if inspect.isclass(found) or not callable(found):
        raise ProblemError(f"--candidate {named}: {format_value(found)}; give {need}")
    try:
        signature = inspect.signature(found)
    except (TypeError, ValueError):
        return  # compiled, and silent: the call will tell
    try:
        signature.bind(*DISPLACEMENTS)
    except TypeError as error:
        raise ProblemError(f"--candidate {named}: {signature}, {error}; give {need}") from error


def shown_name(named: str) -> str:
    """A candidate's name as a report shows it, without the folders of its file."""
    place, _, name = named.rpartition(":")
    return f"{Path(place).name if _is_file(place) else place}:{name}"


def _is_file(place: str) -> bool:
    return place.endswith(".py")


def _import(place: str) -> ModuleType:
    """A module by its name, found from the current folder too, or by its file."""
    file = Path(place)
    if _is_file(place) and not file.is_file():
        raise ProblemError(f"--candidate: no file {file}; {FORM}")
    try:
        if _is_file(place):
            importlib.invalidate_caches()
            place = f"{studies.package(str(file.resolve().parent))}.{file.stem}"
        elif "" not in sys.path:
            sys.path.insert(0, "")
        return importlib.import_module(place)
    except (Exception, SystemExit) as error:  # whatever the user's own code raises
        said = " ".join(f"{type(error).__name__}: {error}".split())
        raise ProblemError(f"--candidate: {file} cannot be imported ({said}); mend it") from error
