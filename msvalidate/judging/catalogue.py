"""Which studies there are: ours, those in a user's folders, and those of installed packages.

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
from functools import cache
from pathlib import Path
from types import ModuleType

from msvalidate import studies

GROUP = "msvalidate.studies"
"""Entry points of this group name a study of another package: ``name = "package.module"``."""
ORDER = (
    "overview",
    "displacement",
    "poisson",
    "lattices",
    "benchmarks",
    "convergence",
    "stability",
    "damping",
    "cost",
    "actuator",
    "pull_in",
    "electrostatics",
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
    """A study's docstring from its source: Python drops it under -OO."""
    return ast.get_docstring(ast.parse(_text(_first(_source(name))))) or ""


def words(name: str) -> set[str]:
    """All texts that stand as such in a study's sources: names of tables are among them."""
    place = _source(name)
    sources = sorted(place.rglob("*.py")) if place.is_dir() else [place]
    nodes = [node for source in sources for node in ast.walk(ast.parse(_text(source)))]
    texts = [node.value for node in nodes if isinstance(node, ast.Constant)]
    return {text for text in texts if isinstance(text, str)}


def alone(name: str) -> bool:
    """Whether a study must run alone: its constant `ALONE` is true.

    One that compares times does, as what runs beside it would take some of them.
    """
    return bool(getattr(load(name), "ALONE", False))


def reads_results(name: str) -> bool:
    """Whether a study puts together what others found: its constant `READS_RESULTS` is true.

    It runs after them, and its candidate is their `output.results.Results`.
    """
    return bool(getattr(load(name), "READS_RESULTS", False))


def is_ours(name: str) -> bool:
    """Whether a study comes with this package, and so has a baseline in it."""
    return name in _in_folder(str(studies.OURS))


def suggestion(name: str) -> str:
    """Words that point from an unknown name to the nearest known one, or to all."""
    near = difflib.get_close_matches(name.lower(), [*names(), "all", "list"], n=1, cutoff=0.5)
    return f"did you mean {near[0]!r}?" if near else f"choose from: {', '.join(names())}"


def load(name: str) -> ModuleType:
    """Import a study.

    Raises
    ------
    ImportError
        If a module that it needs is missing, or it has no function `run`.
    """
    place = _places()[name]
    module = importlib.import_module(place if isinstance(place, str) else f"{GROUP}.{name}")
    if not hasattr(module, "run"):
        raise ImportError(
            f"study {name}: {module.__file__} has no function run(candidate, setting=…)"
        )
    return module


def join(folder: Path) -> None:
    """Let the studies of a folder be found, here and in processes that are started from here.

    Every module in it that defines `run` is a study; one whose name begins with ``_`` is none.

    Raises
    ------
    ImportError
        If there is no such folder, or no study in it, or one by the name of another study.
    """
    place = str(folder.resolve())
    if not folder.is_dir():
        raise ImportError(f"--studies {folder}: no such folder")
    found = _in_folder(place)
    if not found:
        raise ImportError(
            f"--studies {folder}: no study in it; one is a module with a function run"
        )
    if place in studies.__path__:
        return
    for name in found:
        if name in _places():
            raise ImportError(f"--studies {folder}: there is a study {name} already; rename one")
    os.environ[studies.VARIABLE] = os.pathsep.join([*studies.joined(), place])
    studies.__path__.append(place)
    importlib.invalidate_caches()


def _places() -> dict[str, Path | str]:
    """Name -> the source of a study, or the module that an entry point names."""
    found: dict[str, Path | str] = dict(_installed())
    for folder in reversed(studies.__path__):
        found |= _in_folder(folder)
    return found


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
    """Whether a module binds the name `run` as it is imported."""
    try:
        tree = ast.parse(_text(source))
    except (SyntaxError, ValueError):  # said by Python when it is run
        return True
    bound = [node.name for node in tree.body if isinstance(node, ast.FunctionDef)]
    bound += [
        alias.asname or alias.name
        for node in tree.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    ]
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


def _text(source: Path) -> str:
    return source.read_text(encoding="utf-8")
