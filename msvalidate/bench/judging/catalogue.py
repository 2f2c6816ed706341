"""Catalogue of studies: built-in, in a user's folders, and in installed packages.

Names and questions are read from the sources; a study is imported when it is run.
"""

from __future__ import annotations

import ast
import difflib
import importlib
import importlib.metadata
import importlib.util
import os
import pkgutil
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import cast

from msvalidate import studies

GROUP = "msvalidate.studies"
"""Entry points of this group name a study of another package: ``name = "package.module"``."""
RESERVED = (
    *("all", "list", "run", "check", "report", "case", "study", "advise", "simulate", "adapter"),
)
"""Words of the command line, which no study may be called."""
ORDER = (
    "overview",
    "displacement",
    "poisson",
    "lattices",
    "large_strain",
    "contact",
    "fracture",
    "benchmarks",
    "convergence",
    "stability",
    "damping",
    "cost",
    "actuator",
    "pull_in",
    "electrostatics",
    "simulators",
    "claims",
)
"""The reader's order of our studies; others follow by name."""


def names() -> list[str]:
    """Names of all studies, in the reader's order."""
    rank = {name: place for place, name in enumerate(ORDER)}
    return sorted(_places(), key=lambda name: (rank.get(name, len(rank)), name))


def question(name: str) -> str:
    """First line of a study's docstring, without importing the study."""
    return docstring(name).partition("\n")[0]


def docstring(name: str) -> str:
    """A study's docstring from its source: Python drops it under -OO.

    Raises
    ------
    ImportError
        If its source cannot be read as Python.
    """
    return ast.get_docstring(_parse(name, _first(_source(name)))) or ""


def words(name: str) -> set[str]:
    """All string constants in a study's sources, including names of tables."""
    place = _source(name)
    sources = sorted(place.rglob("*.py")) if place.is_dir() else [place]
    nodes = [node for source in sources for node in ast.walk(_parse(name, source))]
    texts = [node.value for node in nodes if isinstance(node, ast.Constant)]
    return {text for text in texts if isinstance(text, str)}


def alone(name: str) -> bool:
    """Return True if a study must run alone, by its constant `ALONE`.

    One that compares times does, as what runs beside it would take some of them.
    """
    return bool(getattr(load(name), "ALONE", False))


def reads_results(name: str) -> bool:
    """Return True if a study combines results of others, by `READS_RESULTS`.

    It runs after them, and its candidate is their `bench.output.results.Results`.
    """
    return bool(getattr(load(name), "READS_RESULTS", False))


def is_ours(name: str) -> bool:
    """Return True if a study, and its baseline, is part of this package."""
    return name in _in_folder(str(studies.OURS))


def suggestion(name: str, known: Sequence[str] = ()) -> str:
    """Suggest the known name of a study or command nearest to an unknown one."""
    near = difflib.get_close_matches(name.lower(), known or [*names(), *RESERVED], 1, cutoff=0.5)
    choices = ", ".join(known or names())
    return f"did you mean {near[0]!r}?" if near else f"choose from: {choices}"


def load(name: str) -> ModuleType:
    """Import a study.

    Raises
    ------
    ImportError
        If a module that it needs is missing, or it has no function `run`.
    """
    place = _places()[name]
    try:
        module = importlib.import_module(place if isinstance(place, str) else _module(place))
    except (ImportError, SyntaxError) as error:
        raise ImportError(f"study {name}: {error}; mend {_source(name)}") from error
    if not hasattr(module, "run"):
        raise ImportError(
            f"study {name}: {module.__file__} has no function run(candidate, setting=…)"
        )
    return module


def join(folder: Path) -> None:
    """Add a folder of studies, for this process and its child processes.

    Every module in it that defines `run` is a study; one whose name begins with ``_`` is none.

    Raises
    ------
    ImportError
        If there is no such folder, or no study in it, or one by the name of another study.
    """
    place = os.path.realpath(folder)  # `resolve` raises of links in a circle, till Python 3.12
    if os.pathsep in place:
        raise ImportError(f"--studies {folder}: {os.pathsep!r} separates folders; rename it")
    if place in studies.joined():
        return
    check_folder(f"--studies {folder}", place, set(_places()))
    os.environ[studies.VARIABLE] = os.pathsep.join([*studies.joined(), place])
    importlib.invalidate_caches()


def check_joined() -> None:
    """Raise ImportError for a folder of the environment without valid studies."""
    known = set(_in_folder(str(studies.OURS)))
    for folder in studies.joined():
        check_folder(f"{studies.VARIABLE} {folder}", folder, known)
        known |= set(_in_folder(folder))


def check_folder(said: str, folder: str, known: set[str]) -> None:
    """Raise ImportError, starting with `said`, for a folder without valid studies."""
    if not Path(folder).is_dir():
        raise ImportError(f"{said}: no such folder")
    found = _in_folder(folder)
    if not found:
        raise ImportError(f"{said}: no study in it; one is a module with a function run")
    for name in found:
        if name in RESERVED:
            raise ImportError(f"{said}: {name!r} is a command; rename the study")
        if name in known:
            raise ImportError(f"{said}: there is a study {name} already; rename one")


def _places() -> dict[str, Path | str]:
    """Name -> the source of a study, or the module that an entry point names."""
    found: dict[str, Path | str] = dict(_installed())
    for folder in reversed([str(studies.OURS), *studies.joined()]):
        found |= _in_folder(folder)
    return found


def _module(place: Path) -> str:
    """The name under which a study in a folder is imported."""
    ours = place.parent == studies.OURS
    return f"{GROUP if ours else studies.package(str(place.parent))}.{place.stem}"


@cache
def _installed() -> dict[str, str]:
    return {entry.name: entry.module for entry in importlib.metadata.entry_points(group=GROUP)}


def _in_folder(folder: str) -> dict[str, Path]:
    found = {}
    for module in pkgutil.iter_modules([folder]):
        place = Path(folder, module.name if module.ispkg else f"{module.name}.py")
        if not module.name.startswith("_") and _runs(_first(place)):
            found[module.name] = place
    return found


@cache
def _runs(source: Path) -> bool:
    """Return True if a module defines the name `run` at import."""
    try:
        tree = ast.parse(_text(source))
    except (SyntaxError, ValueError):  # said when it is run
        return True
    bound: list[str] = []
    for node in tree.body:
        if isinstance(node, ast.FunctionDef):
            bound.append(node.name)
        elif isinstance(node, ast.Assign):
            bound += [target.id for target in node.targets if isinstance(target, ast.Name)]
        elif isinstance(node, ast.ImportFrom):
            bound += [alias.asname or alias.name for alias in node.names]
    return "run" in bound


def _source(name: str) -> Path:
    """The file, or the folder, of a study."""
    place = _places()[name]
    if isinstance(place, Path):
        return place
    spec = importlib.util.find_spec(place)
    if spec is None or spec.origin is None:
        raise ImportError(
            f"study {name}: there is no module {place}, which an installed package names"
        )
    source = Path(spec.origin)
    return source.parent if source.name == "__init__.py" else source


def _first(place: Path) -> Path:
    return place / "__init__.py" if place.is_dir() else place


def _parse(name: str, source: Path) -> ast.Module:
    """The syntax of a study's source."""
    try:
        # Parsing drops docstrings under -OO itself from Python 3.14 on.
        tree = compile(_text(source), source.name, "exec", ast.PyCF_ONLY_AST, optimize=0)
        return cast("ast.Module", tree)
    except (SyntaxError, ValueError) as error:
        raise ImportError(f"study {name}: {source}: {error}; mend it") from error


def _text(source: Path) -> str:
    return source.read_text(encoding="utf-8")
