"""Floor 3: which studies there are, found in their folder; questions are read, not imported."""

from __future__ import annotations

import ast
import difflib
import importlib
import importlib.util
import pkgutil
from pathlib import Path
from types import ModuleType

HOME = Path(__file__).resolve().parents[1] / "studies"


def names() -> list[str]:
    """Names of all studies, in alphabetical order."""
    return sorted(m.name for m in pkgutil.iter_modules([str(HOME)]) if not m.name.startswith("_"))


def question(name: str) -> str:
    """First line of a study's docstring, without importing the study."""
    return docstring(name).partition("\n")[0]


def docstring(name: str) -> str:
    """A study's docstring as its source has it: Python may have been told to drop it."""
    source = HOME / f"{name}.py"
    if not source.exists():
        source = HOME / name / "__init__.py"
    return ast.get_docstring(ast.parse(source.read_text(encoding="utf-8"))) or ""


def words(name: str) -> set[str]:
    """All texts that stand as such in a study's sources: names of tables are among them."""
    folder = HOME / name
    sources = sorted(folder.rglob("*.py")) if folder.is_dir() else [HOME / f"{name}.py"]
    trees = [ast.parse(source.read_text(encoding="utf-8")) for source in sources]
    nodes = [node for tree in trees for node in ast.walk(tree) if isinstance(node, ast.Constant)]
    return {node.value for node in nodes if isinstance(node.value, str)}


def alone(name: str) -> bool:
    """Whether a study asks to be run with none beside it: it has a constant `ALONE` that is true.

    One that compares times does, as what runs beside it would take some of them.
    """
    return bool(getattr(load(name), "ALONE", False))


def suggestion(name: str) -> str:
    """Words that point from an unknown name to the nearest known one, or to all."""
    near = difflib.get_close_matches(name.lower(), [*names(), "all", "list"], n=1, cutoff=0.5)
    return f"did you mean {near[0]!r}?" if near else f"choose from: {', '.join(names())}"


def load(name: str) -> ModuleType:
    """Import a study.

    Raises
    ------
    ImportError
        If another package called ``studies`` comes first on the path.
    """
    spec = importlib.util.find_spec("studies")
    if spec is None or spec.origin is None or Path(spec.origin).resolve().parent != HOME:
        raise ImportError(
            "another package named 'studies' comes before msvalidate's own; "
            "run from another folder or rename it"
        )
    return importlib.import_module(f"studies.{name}")
