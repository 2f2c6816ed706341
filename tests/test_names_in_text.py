"""Names in backticks, in docstrings, comments and documents, name something that is there.

A dotted name is a module (or the end of its name) and what it binds, a class and its member, or a
variable of the file and a member of some class; another name is any word of the code. A docstring
of a name that users import is read without its file, so its names import from where it says.
"""

from __future__ import annotations

import ast
import builtins
import contextlib
import importlib
import inspect
import keyword
import re
from functools import cache

import pytest

import msvalidate
import msvalidate_check
import reference_fem
from tests.test_architecture import ROOT, SOURCES, tree, within

TICKED = re.compile(r"(?<!`)`([A-Za-z_]\w*(?:\.[A-Za-z_]\w*)*)(?:\([^`]*\))?`(?!`)")
FILES = {"bib", "csv", "html", "inp", "json", "md", "msh", "npz", "toml", "txt", "vtu"}
FILES |= {"data", "dump", "in"}  # of LAMMPS
"""Ends of names of files, which look like dotted names."""
LIBRARIES = {"concurrent", "llvmlite", "loky", "numba", "numpy", "pandas", "scipy", "skfem"}
DOCUMENTS = [ROOT / "ARCHITECTURE.md", *(ROOT / "docs").glob("*.md")]
"""Decisions are left out: they name what was there when they were taken."""


def bound(node):
    """Names that a statement binds."""
    if isinstance(node, ast.FunctionDef | ast.ClassDef):
        return {node.name}
    if isinstance(node, ast.Import | ast.ImportFrom):
        return {alias.asname or alias.name for alias in node.names}
    targets = getattr(node, "targets", [getattr(node, "target", None)])
    return {n.id for t in targets if t for n in ast.walk(t) if isinstance(n, ast.Name)}


@cache
def top_names(module):
    return set().union(*(bound(node) for node in tree(module).body))


@cache
def members():
    """Class -> its members, with those of the classes that it is made of."""
    own, bases = {}, {}
    for module in SOURCES:
        for node in ast.walk(tree(module)):
            if isinstance(node, ast.ClassDef):
                found = own.setdefault(node.name, set()).union(*map(bound, node.body))
                found |= {  # what methods set on self
                    n.attr
                    for n in ast.walk(node)
                    if isinstance(n, ast.Attribute) and isinstance(n.ctx, ast.Store)
                }
                own[node.name] = found
                bases.setdefault(node.name, set()).update(ast.unparse(b) for b in node.bases)

    def with_bases(name):
        above = (with_bases(base) for base in bases.get(name, ()) if base != name)
        return own.get(name, set()).union(*above)

    return {name: with_bases(name) for name in own}


@cache
def words(module):
    """Every identifier of a module, and every text constant of one word."""
    found = set()
    for node in ast.walk(tree(module)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and " " not in node.value:
            found |= set(re.findall(r"\w+", node.value))
        for field in ("id", "attr", "arg", "name", "asname"):
            name = getattr(node, field, None)
            found |= set(name.split(".")) if isinstance(name, str) else set()
    return found


@cache
def all_words():
    modules = {part for module in SOURCES for part in module.split(".")}
    return modules.union(*(words(module) for module in SOURCES)) | set(keyword.kwlist)


@cache
def is_there(name):
    """Whether a dotted name is a module, in a module, or in a class."""
    parts = name.split(".")
    for cut in range(len(parts), 0, -1):
        place, rest = ".".join(parts[:cut]), parts[cut:]
        for module in SOURCES:
            if module == place or module.endswith(f".{place}"):
                there = not rest or rest[0] in top_names(module)
                if there and (len(rest) < 2 or rest[1] in members().get(rest[0], ())):
                    return True
    return len(parts) == 2 and parts[1] in members().get(parts[0], ())


def resolves(name, local=frozenset()):
    """Whether a name in backticks stands for something; `local` are the words of its file."""
    parts = name.split(".")
    if len(parts) == 1:
        return name in all_words()
    if parts[0] in LIBRARIES or parts[-1] in FILES or is_there(name):
        return True
    of_variable = parts[0] in local and not parts[0][0].isupper()
    return of_variable and len(parts) == 2 and any(parts[1] in of for of in members().values())


def unresolved(module):
    # Backticks are no syntax of Python: all stand in strings and comments.
    names = set(TICKED.findall(SOURCES[module].read_text(encoding="utf-8")))
    # Studies name tables and rows, which they make of parts.
    if within(module, "msvalidate.studies"):
        names = {name for name in names if "." in name}
    return sorted(name for name in names if not resolves(name, words(module)))


PUBLIC = (msvalidate, msvalidate_check, reference_fem)
"""Packages whose `__all__` users import from."""


def public_docstrings():
    """Owner, object and docstring of all public names and of the members of classes."""
    for owner in (getattr(package, name) for package in PUBLIC for name in package.__all__):
        if callable(owner):
            yield owner, owner, inspect.getdoc(owner) or ""
        for name, value in vars(owner).items() if inspect.isclass(owner) else ():
            plain = getattr(value, "fget", getattr(value, "func", value))
            if not name.startswith("_") and callable(plain):
                yield owner, plain, plain.__doc__ or ""


def members_of(thing):
    """Members, fields and parameters of a module, class or function."""
    code = getattr(thing, "__code__", None)
    parameters = code.co_varnames[: code.co_argcount + code.co_kwonlyargcount] if code else ()
    return {*dir(thing), *getattr(thing, "__annotations__", ()), *parameters}


def has(thing, names):
    """Return True if an object has a chain of members; the last may be a field."""
    for name in names[:-1]:
        thing = getattr(thing, name, None)
    return not names or names[-1] in members_of(thing)


@cache
def imports(name, module):
    """Return True if a name imports as it stands, from its package or from beside its module."""
    parts, package = name.split("."), module.partition(".")[0]
    for start in ("", f"{package}.", f"{module.rpartition('.')[0]}.", "msvalidate."):
        for cut in range(len(parts), -1, -1):
            with contextlib.suppress(ImportError, ValueError):
                place = importlib.import_module((start + ".".join(parts[:cut])).strip("."))
                if has(place, parts[cut:]) and (cut or place in PUBLIC):
                    return True
    return False


def reachable(name, owner, thing):
    """Return True if the reader of a public docstring can find a name in it."""
    first, last = name.split(".")[0], name.split(".")[-1]
    known = members_of(thing) | members_of(owner) | LIBRARIES | set(keyword.kwlist)
    return first in known | set(dir(builtins)) or last in FILES or imports(name, owner.__module__)


def test_names_in_docstrings_of_public_names_are_imported_from_where_they_say():
    lost = {
        f"{thing.__qualname__}: {name}"
        for owner, thing, text in public_docstrings()
        for name in TICKED.findall(text)
        if not reachable(name, owner, thing)
    }
    assert sorted(lost) == []


def test_a_public_docstring_that_leaves_out_the_module_is_noticed():
    step = msvalidate.recommended_time_step
    named = (  # from its own package, from ours, its parameter, a class
        *("step_limits.SAFETY", "springs.dynamics.step_limits.SAFETY"),
        *("integrator", "Problem.materials"),
    )
    assert [name for name in named if not reachable(name, step, step)] == []
    lost = ("SAFETY", "euler_cromer", "step_limits.NOTHING", "Problem.nothing")
    assert [name for name in lost if reachable(name, step, step)] == []


def test_statements_of_import_in_texts_run():
    for path in [*SOURCES.values(), ROOT / "README.md", *DOCUMENTS]:
        for statement in re.findall(r"`(from [\w.]+ import [^`\n]+)`", path.read_text("utf-8")):
            exec(statement, {})  # noqa: S102


def test_names_in_docstrings_and_comments_are_there():
    found = {module: unresolved(module) for module in SOURCES}
    assert {module: names for module, names in found.items() if names} == {}


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: path.name)
def test_names_in_documents_are_there(path):
    names = set(TICKED.findall(path.read_text(encoding="utf-8")))
    assert sorted(name for name in names if not resolves(name)) == []


def test_a_name_that_is_gone_is_noticed():
    there = (
        *("msvalidate.springs.statics.path", "statics.path.LoadPath", "path.LoadPath.stops"),
        *("LoadPath.stops", "network.points", "verdict.json", "equilibrium", "scipy.sparse"),
    )
    gone = (
        *("statics.path.Way", "path.LoadPath.nowhere", "LoadPath.nowhere", "Way.stops"),
        *("network.nowhere", "nobody.points", "nowhere_at_all"),
    )
    assert [name for name in there if not resolves(name, {"network"})] == []
    assert [name for name in gone if resolves(name, {"network"})] == []


def test_names_that_moved_are_where_the_changelog_says():
    rows = re.findall(
        r"^\| `(\S+)` \| `(\S+)` \|$", (ROOT / "CHANGELOG.md").read_text("utf-8"), re.M
    )
    assert len(rows) > 10
    assert [new for _, new in rows if not is_there(new)] == []
    assert [old for old, _ in rows if is_there(old)] == []
