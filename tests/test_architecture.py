"""The layout is kept: independence of the reference, floors, who writes files, docstrings.

Every rule is a function of a syntax tree that returns what is wrong, so that it can be tried on
text that breaks it: a guard that has never fired guards nothing. Each file is parsed once.
"""

from __future__ import annotations

import ast
import graphlib
import io
import os
import re
import subprocess
import sys
import tokenize
from functools import cache
from pathlib import Path

import pytest

from tests.table import stored_rows

ROOT = Path(__file__).resolve().parents[1]
HOMES = {
    "msvalidate": "msvalidate",
    "msvalidate_check": "checker/msvalidate_check",
    "reference_fem": "reference_fem",
    "msvalidate.studies": "studies",
}
"""Package -> its folder; the studies stand at the top and are imported under another name."""


def module_name(package, path):
    parts = path.relative_to(ROOT / HOMES[package]).with_suffix("").parts
    parts = parts[:-1] if parts[-1] == "__init__" else parts
    return ".".join([package, *parts])


SOURCES = {
    module_name(package, path): path
    for package, folder in HOMES.items()
    for path in sorted((ROOT / folder).rglob("*.py"))
}
FOLDERS = {path.parent.name for path in (ROOT / "msvalidate").glob("*/__init__.py")} - {"studies"}
"""Packages of msvalidate, each of which stands on one floor as a whole."""


@cache
def tree(module):
    return ast.parse(SOURCES[module].read_text(encoding="utf-8"))


def imported(parsed, module=""):
    """Dotted names in all import statements, wherever they stand; relative ones made absolute."""
    names = []
    for node in ast.walk(parsed):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            origin = "." * node.level + (node.module or "")
            if node.level and module:
                origin = absolute(module, node.level, node.module or "")
            stem = origin if origin.endswith(".") else f"{origin}."
            names += [f"{stem}{alias.name}" for alias in node.names]
    return names


def absolute(module, level, rest):
    """What a relative import means in a module."""
    is_package = SOURCES[module].name == "__init__.py"
    parts = module.split(".")
    parts = parts[: len(parts) - level + is_package]
    return ".".join([*parts, *([rest] if rest else [])])


def within(name, package):
    return name == package or name.startswith(f"{package}.")


def wrong_in(rule, modules=None):
    """Module -> what a rule finds in it, where it finds something."""
    found = {module: rule(tree(module)) for module in modules or SOURCES}
    return {module: wrong for module, wrong in found.items() if wrong}


def unnoticed(rule, planted):
    """Texts in which a rule finds nothing; said together, so that all misses are seen."""
    return [text for text in planted if not rule(ast.parse(text))]


def test_sources_are_found():
    for package in HOMES:
        least = 2 if package == "msvalidate_check" else 10
        assert sum(within(module, package) for module in SOURCES) > least, package
    assert {"problem", "springs", "bench", "cli"} <= FOLDERS


# --- independence of the reference, by its source -------------------------------------------------

FASTER = {"cvxopt"}  # a faster factor, where it is installed
ALLOWED = {"numpy", "pyamg", "scipy", "skfem", "reference_fem", *FASTER}
# The question, and solvers of any linear system: each side checks its own residual, and signs of
# pivots, which no residual shows, are held to dense eigenvalues.
SHARED = ("msvalidate.problem", "msvalidate.linear_algebra")
# Ways round an import statement: with these, a list of imports would prove nothing.
EVASIVE_MODULES = {"builtins", "importlib", "pkgutil", "runpy", "subprocess"}
EVASIVE_NAMES = {"__import__", "__builtins__", "eval", "exec", "import_module"}


def dependent(parsed):
    """What makes a module of the reference depend on more than the statement of the problem."""
    wrong = []
    for name in imported(parsed):
        top = name.partition(".")[0]
        known = top in ALLOWED or (top in sys.stdlib_module_names and top not in EVASIVE_MODULES)
        if not (known or any(within(name, each) for each in SHARED)):
            wrong.append(name)
    for node in ast.walk(parsed):
        if isinstance(node, ast.Name | ast.Attribute):
            name = node.id if isinstance(node, ast.Name) else node.attr
            loads_modules = isinstance(node, ast.Attribute) and ast.unparse(node) == "sys.modules"
            if name in EVASIVE_NAMES or loads_modules:
                wrong.append(ast.unparse(node))
    return wrong


def test_reference_imports_only_what_it_may():
    assert wrong_in(dependent, [m for m in SOURCES if within(m, "reference_fem")]) == {}


def imported_at_once(parsed):
    """Packages whose import does not wait for a function to run."""
    inside = {
        inner
        for node in ast.walk(parsed)
        if isinstance(node, ast.FunctionDef)
        for inner in ast.walk(node)
    }
    names = []
    for node in ast.walk(parsed):
        if isinstance(node, ast.Import | ast.ImportFrom) and node not in inside:
            names += imported(ast.Module([node], []))
    return {name.partition(".")[0] for name in names}


def test_what_is_optional_is_imported_when_it_is_used():
    assert wrong_in(lambda parsed: imported_at_once(parsed) & FASTER) == {}


def test_optional_guard_fires():
    planted = "try:\n    import cvxopt.cholmod\nexcept ImportError:\n    pass"
    assert imported_at_once(ast.parse(planted)) == {"cvxopt"}
    assert imported_at_once(ast.parse("from cvxopt import matrix")) == {"cvxopt"}
    assert not imported_at_once(ast.parse("def has():\n    import cvxopt"))


def test_import_guard_fires():
    planted = (
        "import msvalidate",
        "import msvalidate.springs.constants",
        "import msvalidate.problem, msvalidate.springs.lattice",
        "import msvalidate.springs.constants as problem",
        "import msvalidate.problems",
        "from msvalidate import lattice",
        "from msvalidate import Problem",
        "from msvalidate import problem, network",
        "from msvalidate.springs.constants.stiffness import square_tensor",
        "from msvalidate.problem_of_mine import Box",
        "from msvalidate import *",
        "import studies",
        "from msvalidate.studies.poisson import block",
        "import numba",
        "import pandas as pd",
        "from . import body",
        "from .body import Solution",
        "from .. import msvalidate",
        "from ..msvalidate.constants import stiffness",
        "def solve():\n    from msvalidate import constants",
        "if TYPE_CHECKING:\n    from msvalidate.springs.lattice import Lattice",
        "try:\n    import msvalidate.springs.kernels\nexcept ImportError:\n    pass",
        "import importlib",
        "from importlib import import_module",
        "import importlib.util as u",
        "__import__('msvalidate.springs.constants')",
        "load = __import__",
        "__builtins__['__import__']('msvalidate.springs.constants')",
        "exec('import msvalidate.springs.constants')",
        "eval('1')",
        "import runpy",
        "import sys\nsys.modules['msvalidate.springs.constants']",
        "import subprocess",
    )
    assert unnoticed(dependent, planted) == []


def test_import_guard_lets_pass():
    allowed = (
        "import numpy as np",
        "from scipy.sparse.linalg import splu",
        "import skfem",
        "from dataclasses import dataclass",
        "from __future__ import annotations",
        "from msvalidate import problem",
        "import msvalidate.problem",
        "from msvalidate.problem import Box",
        "from msvalidate.problem.checks import finite",
        "from reference_fem.body import Solution",
    )
    assert unnoticed(dependent, allowed) == list(allowed)


# --- what others take along -----------------------------------------------------------------------


def heavy(parsed):
    """Imports of what the checker's wheel does not ask for."""
    known = {"numpy", "msvalidate_check", *sys.stdlib_module_names}
    return [name for name in imported(parsed) if name.partition(".")[0] not in known]


def test_the_checker_needs_numpy_only():
    plugin = "msvalidate_check.pytest_plugin"
    found = wrong_in(heavy, [m for m in SOURCES if within(m, "msvalidate_check")])
    assert found.pop(plugin) == ["pytest"]
    assert found == {}
    planted = ("import scipy", "def f():\n    from msvalidate.problem import Box", "import pytest")
    assert unnoticed(heavy, planted) == []


# --- independence of the reference, by what it loads ----------------------------------------------

LOAD_ALL = """
import importlib, pkgutil, sys
BOTH = ("api", "studies", "__main__", "case", "cases", "simulators", "new")
def load(name):
    package = importlib.import_module(name)
    for module in pkgutil.iter_modules(getattr(package, "__path__", ())):
        # Cases compare both sides, as studies do.
        if module.name not in BOTH:
            load(f"{name}.{module.name}")
    return package
package = load(sys.argv[1])
exec(sys.argv[2])
print(*sorted(sys.modules), sep="\\n")
"""
# An import inside a function is not seen until the function runs.
USE_REFERENCE = """
import numpy as np
import reference_fem
from msvalidate.problem import (
    BodyForce, Box, Isotropic, PointForce, Problem, Support, Traction
)
box = Box((1.0, 1.0))
support, pull = Support(box.side("left"), (0.0, 0.0)), Traction(box.side("right"), (1.0, 0.0))
loads = (pull, BodyForce((0.0, -1.0)), PointForce((1.0, 1.0), (0.0, 1.0)))
problem = Problem(box, Isotropic(1.0, 0.3), (support,), loads)
def middle(cells):
    body = reference_fem.box_discretisation(box, cells)
    return reference_fem.solve_problem(problem, body).at(np.array([[0.5, 0.5]]))[0]
reference_fem.refine(middle, 1, 1.0)
slab = reference_fem.slab_mesh(reference_fem.facing_slab(2.0, 1.0), 2)
forces = reference_fem.solve_charges(slab).forces
moved = reference_fem.respond(slab, 1e-6 * forces, Isotropic(1.0, 0.3)).displacement
reference_fem.solve_charges(reference_fem.move_air(slab, moved))
"""


def loaded_by(package, use="", folder=ROOT):
    """Modules in a fresh process that has imported a package with all that is in it and used it."""
    done = subprocess.run(
        [sys.executable, "-c", LOAD_ALL, package, use],
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(folder), str(ROOT)])},
        capture_output=True,
        text=True,
        check=False,
        cwd=ROOT,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


def alien(modules):
    """Loaded modules that the springs and the reference must not have in common."""
    return [
        name
        for name in modules
        if any(within(name, package) for package in ("msvalidate", "studies", "numba"))
        and not (name == "msvalidate" or any(within(name, each) for each in SHARED))
    ]


def test_reference_loads_nothing_of_the_springs():
    modules = loaded_by("reference_fem", USE_REFERENCE)
    assert {"reference_fem", "reference_fem.body", "msvalidate.problem", "skfem"} <= set(modules)
    assert alien(modules) == []


PLANTED = {
    "early": "import msvalidate.springs.constants.stiffness",
    "hidden": "getattr(__import__('importlib'), 'import' + '_module')("
    "'msvalidate.springs.lattice')",
    "late": "def solve():\n    import msvalidate.springs.network.mechanism",
    "front": "import msvalidate\nmsvalidate.relax",
    "library": "import numba",
}


def test_process_guard_fires(tmp_path):
    package = tmp_path / "planted_fem"
    package.mkdir()
    (package / "__init__.py").write_text("import reference_fem\n", encoding="utf-8")
    for name, text in PLANTED.items():
        (package / f"{name}.py").write_text(text, encoding="utf-8")
    found = set(alien(loaded_by("planted_fem", "package.late.solve()", tmp_path)))
    seen = ("constants.stiffness", "lattice", "network.mechanism", "dynamics.relax")
    seen = [f"springs.{name}" for name in seen]
    assert {"numba", *(f"msvalidate.{name}" for name in seen)} <= found


def test_springs_load_nothing_of_the_reference():
    # The other direction: what the reference computes must not reach the springs either.
    modules = loaded_by("msvalidate")
    assert {"msvalidate.springs.network", "msvalidate.cli.program"} <= set(modules)
    assert not [name for name in modules if within(name, "reference_fem") or within(name, "skfem")]


# --- floors ---------------------------------------------------------------------------------------

JUDGE = tuple(
    f"msvalidate.bench.judging.{name}" for name in ("columns", "compare", "evidence", "rules")
)
MAIN = ("msvalidate.__main__", "msvalidate.study")
"""Programs: what they define would exist twice, so they are imported by nobody."""


BOTH_SIDES = {"reference_fem", "studies", "case", "simulators"}
"""Folders that may know the reference."""


def folder_of(module):
    """The folder that a module stands in: studies, reference_fem, or a package of msvalidate."""
    if module.startswith("msvalidate.studies."):
        return "studies"
    if module == "msvalidate.studies":  # where they are
        return "msvalidate"
    top, _, rest = module.partition(".")
    return rest.partition(".")[0] or top if top == "msvalidate" else top


def resolved(name):
    """The module of ours that an imported name is, or is defined in; None for a library."""
    while name and name not in SOURCES:
        name = name.rpartition(".")[0]
    return name or None


def circle(graph):
    """What uses itself by a detour, or nothing."""
    try:
        graphlib.TopologicalSorter(graph).prepare()
    except graphlib.CycleError as error:
        return error.args[1]
    return []


def used(parsed_by_module, unit=lambda module: module):
    """Unit -> units that it imports; a unit is a module by default."""
    graph = {unit(module): set() for module in parsed_by_module}
    for module, parsed in parsed_by_module.items():
        targets = {resolved(name) for name in imported(parsed, module)} - {None, module}
        graph[unit(module)] |= {unit(target) for target in targets} - {unit(module)}
    return graph


def trees(package=""):
    return {module: tree(module) for module in SOURCES if not package or within(module, package)}


def test_no_module_imports_itself_by_a_detour():
    # Two modules on one floor may use each other one way only.
    assert circle(used(trees())) == []


def test_folders_use_each_other_one_way_only():
    graph = used(trees(), folder_of)
    # What stands at the top of msvalidate: the version and the names that a user meets first.
    for targets in graph.values():
        targets.discard("msvalidate")
    assert set(graph) >= FOLDERS
    assert circle(graph) == []


def part(module, package="reference_fem"):
    """The subpackage (or module) of a package that a module is in, or else the module."""
    depth = package.count(".") + 2
    return ".".join(module.split(".")[:depth]) if within(module, package) else module


PARTED = ["reference_fem"]
PARTED += [f"msvalidate.{name}" for name in ("springs", "case", "simulators", "dielectric")]


@pytest.mark.parametrize("package", PARTED)
def test_subpackages_use_each_other_one_way_only(package):
    graph = used(trees(package), lambda module: part(module, package))
    assert len(graph) > 3
    assert circle(graph) == []


def floors_drawn(whole="floor"):
    """Folder -> its floor, as ARCHITECTURE.md draws them, counted from the ground."""
    text = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
    rows = re.findall(rf"^{whole} +(\d+) +((?:[a-z_]+/ *)+)", text, flags=re.M)
    return {name.strip("/"): int(floor) for floor, names in rows for name in names.split()}


def test_the_drawing_is_true():
    drawn = floors_drawn()
    assert set(drawn) == {*FOLDERS, "msvalidate_check", "reference_fem", "studies"}
    upwards = [
        f"{folder} uses {target}"
        for folder, targets in used(trees(), folder_of).items()
        for target in targets
        if folder in drawn and target in drawn and drawn[target] >= drawn[folder]
    ]
    assert upwards == []


@pytest.mark.parametrize("name", ["springs", "case"])
def test_the_drawing_of_a_package_is_true(name):
    package, drawn = f"msvalidate.{name}", floors_drawn(name)
    graph = used(trees(package), lambda module: part(module, package))
    inside = {each: each.rpartition(".")[2] for each in graph if each.startswith(f"{package}.")}
    assert set(drawn) == set(inside.values())
    upwards = [
        f"{each} uses {low}"
        for each in inside
        for low in graph[each] & set(inside)
        if drawn[inside[low]] >= drawn[inside[each]]
    ]
    assert upwards == []


def misplaced(module, parsed):
    """Imports that a module's place in the layout forbids."""
    wrong = []
    here = folder_of(module)
    for name in imported(parsed):
        if name.startswith(".") and here != "studies":
            wrong.append(f"{name}: relative")
        if name.endswith(".*") and module != "msvalidate.kit":  # which offers what is asked, whole
            wrong.append(f"{name}: star")
        target = resolved(name)
        if target is None:
            continue
        if target in MAIN:
            wrong.append(f"{name}: the command line is imported by nobody")
        if target == "msvalidate" and "__version__" not in name:
            wrong.append(f"{name}: the front door is for users; name the module")
        if folder_of(target) == "reference_fem" and here not in BOTH_SIDES:
            wrong.append(f"{name}: the springs may not know the reference")
        known = target in (*JUDGE, "msvalidate_check.verdict") or within(
            target, "msvalidate.problem"
        )
        if module in JUDGE and not known:
            wrong.append(f"{name}: the judge knows neither side")
        if folder_of(target) in {"cli", "studies"} - {here} and module not in MAIN:
            wrong.append(f"{name}: upwards")
    return wrong


def test_imports_are_where_they_may_be():
    found = {module: misplaced(module, tree(module)) for module in SOURCES}
    assert {module: wrong for module, wrong in found.items() if wrong} == {}


@pytest.mark.parametrize(("module", "planted", "why"), stored_rows("planted_imports"))
def test_floor_guard_fires(module, planted, why):
    assert why in " ".join(misplaced(module, ast.parse(planted)))


def test_floor_guard_lets_pass():
    judging = "msvalidate.bench.judging"
    allowed = {
        "msvalidate.springs.kernels": "from msvalidate.springs.network import Network",
        f"{judging}.compare": f"from {judging}.evidence import Observed",
        f"{judging}.evidence": "import pandas as pd\nfrom msvalidate.problem import Array",
        "msvalidate.studies.poisson.block": "import reference_fem\nfrom . import controls",
        "msvalidate.cli.program": "from msvalidate.bench.output import report",
    }
    found = {module: misplaced(module, ast.parse(text)) for module, text in allowed.items()}
    assert not any(found.values()), found


def test_circle_guard_fires():
    planted = {
        "msvalidate.springs.lattice": "from msvalidate.springs.network import Network",
        "msvalidate.springs.network": "def f(): from msvalidate.springs.constants import stiffness",
        "msvalidate.springs.constants.stiffness": "import msvalidate.springs.lattice",
        "reference_fem.mesh.boxes": "from reference_fem.electric.slab import Slab",
        "reference_fem.electric.mesh": "from reference_fem.mesh.checks import checked_cells",
    }
    parsed = {module: ast.parse(text) for module, text in planted.items()}
    assert len(set(circle(used(parsed)))) == 3
    reference = {module: text for module, text in parsed.items() if within(module, "reference_fem")}
    assert not circle(used(reference))
    assert len(set(circle(used(reference, part)))) == 2


# --- files ----------------------------------------------------------------------------------------

WRITERS = {
    *("write_text", "write_bytes", "touch", "mkdir", "makedirs", "mkstemp", "mkdtemp", "fdopen"),
    *("NamedTemporaryFile", "TemporaryFile", "TemporaryDirectory", "unlink", "rmtree", "rmdir"),
    *("copyfile", "copytree", "symlink_to", "chmod", "savefig", "imsave", "print_figure"),
    *("save", "savez", "savez_compressed", "savetxt", "tofile", "memmap", "dump", "basicConfig"),
    *("to_csv", "to_json", "to_parquet", "to_pickle", "to_excel", "to_feather", "to_hdf", "to_sql"),
}
"""Functions and methods that put something into a file or change a folder."""
WRITING = {
    "msvalidate.case.report.files": ("folder.mkdir(",),
    "msvalidate.cli.cases": ("(folder / name).unlink(",),
    "msvalidate_check.exchange": ("",),
    "msvalidate.springs.bodies.geometry_file": ("tempfile.TemporaryDirectory(",),
    "msvalidate.springs.bodies.mesh_file": ("tempfile.TemporaryDirectory(", "copy.write_bytes("),
    "msvalidate.bench.output.report": ("",),
    "msvalidate.bench.output.animation": ("images[0].save(content,",),
    "msvalidate.bench.output.vtu": ("tempfile.TemporaryDirectory(",),
    "msvalidate.simulators.exchange.program": ("tempfile.TemporaryDirectory(",),
    "msvalidate.bench.output.stored": ("figure.savefig(page,", "table.to_csv(index="),
    "msvalidate.cli.program": ("os.open(os.devnull,",),
    "msvalidate.cli.terminal": ("open(os.devnull,",),
    "msvalidate.cli.progress": ("open(number,", "self._log."),
    "msvalidate.linear_algebra.factor": ("os.open(os.devnull,",),
    "msvalidate.springs.kernels.cache": (
        *("path.parent.mkdir(", "part.write_bytes(", "part.unlink()"),
        *("shutil.rmtree(old,", "old.unlink("),
    ),
}
"""Who may write, beginning with which calls: `stored` and `animation` make bytes and text, in
memory; `cache` is where compiled code is kept."""


def writes(parsed):
    """Calls in a source text that write files."""
    found = []
    for node in ast.walk(parsed):
        if not isinstance(node, ast.Call):
            continue
        name = getattr(node.func, "attr", getattr(node.func, "id", ""))
        if name in WRITERS or (name == "open" and not reads_only(node)):
            found.append(ast.unparse(node))
    return found


def reads_only(call):
    """Whether an `open` or `Path.open` has a mode that can be seen to read; a variable cannot."""
    builtin = isinstance(call.func, ast.Name)
    given = [k.value for k in call.keywords if k.arg == "mode"] or call.args[builtin : builtin + 1]
    modes = [node.value if isinstance(node, ast.Constant) else "w" for node in given]
    return not any(isinstance(mode, str) and set(mode) & set("wax+") for mode in modes)


def test_only_the_report_writes_files():
    found = wrong_in(writes)
    assert set(WRITING) <= set(found)  # else the rule has lost its subject
    others = {
        module: [call for call in calls if not call.startswith(WRITING.get(module, ()))]
        for module, calls in found.items()
    }
    assert {module: calls for module, calls in others.items() if calls} == {}


def test_writing_guard_fires():
    planted = (
        "open('a', 'w')",
        "open('a', mode='a')",
        "open('a', 'rb+')",
        "open('a', mode)",
        "with Path('a').open('x') as file: pass",
        "Path('a').write_text('b')",
        "table.to_csv('a.csv')",
        "figure.savefig('a.png')",
        "np.save('a', x)",
        "np.savetxt('a', x)",
        "json.dump(x, file)",
        "out.mkdir()",
        "def f():\n    return [open(p, 'w') for p in paths]",
    )
    assert unnoticed(writes, planted) == []
    allowed = ("open('a')", "open('a', 'rb')", "p.open()", "p.open('r')", "p.read_text()")
    assert unnoticed(writes, allowed) == list(allowed)


# --- mesh files -----------------------------------------------------------------------------------


def uses_meshio(parsed):
    """Imports of the library that reads mesh files; it may also write, and end the program."""
    return [name for name in imported(parsed) if within(name, "meshio")]


def test_two_modules_know_meshio():
    known = {"msvalidate.springs.bodies.mesh_file", "msvalidate.bench.output.vtu"}
    assert set(wrong_in(uses_meshio)) == known
    assert "meshio.write" not in SOURCES["msvalidate.springs.bodies.mesh_file"].read_text(
        encoding="utf-8"
    )


def test_meshio_guard_fires():
    planted = (
        "import meshio",
        "import meshio as m",
        "from meshio import read",
        "def f():\n import meshio.vtk",
    )
    assert unnoticed(uses_meshio, planted) == []


# --- sorts ----------------------------------------------------------------------------------------

UNSTABLE = {"argpartition", "partition", "reverse_cuthill_mckee", "nlargest"}
"""What leaves ties to an algorithm that goes by the processor, and cannot be told not to."""


def by_processor(parsed):
    """Calls whose order of ties goes by the processor; arguments sorted by two columns are not."""
    found = []
    for node in ast.walk(parsed):
        if not isinstance(node, ast.Call):
            continue
        name = getattr(node.func, "attr", getattr(node.func, "id", ""))
        string = isinstance(node.func, ast.Attribute) and len(node.args) == 1 and not node.keywords
        given = {k.arg: ast.unparse(k.value) for k in node.keywords}
        several = name == "sort_values" and node.args and isinstance(node.args[0], ast.List)
        sorts = name in {"argsort", "sort_values"} and not several
        if sorts and given.get("kind") != "'stable'":
            found.append(ast.unparse(node))
        if name in UNSTABLE and not (name == "partition" and string):
            found.append(ast.unparse(node))
    return found


def test_ties_are_sorted_by_number():
    assert wrong_in(by_processor) == {}


def test_sorting_guard_fires():
    planted = (
        "np.argsort(x)",
        "x.argsort()",
        "np.argsort(x, kind='quicksort')",
        "table.sort_values('x')",
        "table.sort_values('x', kind='heapsort')",
        "np.argpartition(x, 3)",
        "np.partition(x, 3)",
        "order = reverse_cuthill_mckee(graph)",
        "def f():\n    return [np.argsort(row) for row in rows]",
    )
    assert unnoticed(by_processor, planted) == []
    allowed = (
        "np.argsort(x, axis=1, kind='stable')",
        "table.sort_values(['x', 'y'])",
        "'a b'.partition(' ')",
        "np.sort(x)",
    )
    assert unnoticed(by_processor, allowed) == list(allowed)


# --- limits ---------------------------------------------------------------------------------------

SLACK = 0.03
"""Part by which a limit of tokens may exceed their number."""
BESIDE = {"adapters": "simulators", "tests": "tests", "cases": "cases", "examples": "examples"}
WORDS = 1400
"""Maximum number of words in ARCHITECTURE.md."""


def documented(parsed):
    """Lines of docstrings, also of those below constants."""
    kinds = ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef
    lines = set()
    for node in ast.walk(parsed):
        body = node.body if isinstance(getattr(node, "body", None), list) else []
        for before, text in zip([None, *body], body, strict=False):
            string = isinstance(text, ast.Expr) and isinstance(text.value, ast.Constant)
            first = before is None and isinstance(node, kinds)
            owned = first or isinstance(before, ast.Assign | ast.AnnAssign)
            if string and owned and isinstance(text.value.value, str):
                lines.update(range(text.lineno, text.end_lineno + 1))
    return lines


@cache
def code_tokens(source):
    """Number of names, operators, numbers and strings; an f-string is one, in any Python."""
    kinds = {tokenize.NAME, tokenize.OP, tokenize.NUMBER, tokenize.STRING}
    start, end = (getattr(tokenize, f"FSTRING_{name}", None) for name in ("START", "END"))
    inside, count, skipped = 0, 0, documented(ast.parse(source))
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        counted = token.type == start or (token.type in kinds and token.start[0] not in skipped)
        count += counted and not inside
        inside += (token.type == start) - (token.type == end)
    return count


def longest_chain(graph):
    """Number of modules in the longest chain of imports."""
    length = {}
    for module in graphlib.TopologicalSorter(graph).static_order():
        length[module] = 1 + max((length[each] for each in graph.get(module, ())), default=0)
    return max(length.values(), default=0)


def limited():
    """Package -> its tokens, dependencies between subpackages, import depth and `fmt: skip`."""
    inside = {name: f"msvalidate/{name}" for name in FOLDERS}
    rows = {}
    for name, folder in (HOMES | inside | BESIDE).items():
        texts = [path.read_text(encoding="utf-8") for path in sorted((ROOT / folder).rglob("*.py"))]
        package = f"msvalidate.{name}" if name in inside else name
        graph = used(trees(package)) if name not in BESIDE else {}
        here = {m for m in graph if (folder_of(m) == "studies") == (name == "msvalidate.studies")}
        graph = {module: graph[module] & here for module in here}
        below = {part(m, package) for m in graph if m.startswith(f"{package}.")}
        below = {each for each in below if SOURCES.get(each, ROOT).name == "__init__.py"}
        arrows = {(part(m, package), part(t, package)) for m in graph for t in graph[m]}
        rows[name.removeprefix("msvalidate.")] = (
            sum(map(code_tokens, texts)),
            sum(a != b and {a, b} <= below for a, b in arrows),
            longest_chain(graph),
            sum(text.count("# fmt: " + each) for text in texts for each in ("skip", "off")),
        )
    return rows


def limits(text):
    """Package -> its limits, as the table of ARCHITECTURE.md has them."""
    rows = re.findall(r"^\| (\w+) \| (\d+) \| (\d+) \| (\d+) \| (\d+) \|$", text, flags=re.M)
    return {name: tuple(map(int, numbers)) for name, *numbers in rows}


def off_limits(rows, allowed):
    """Differences between sizes and limits, one line each."""
    wrong = [f"{name}: no row in ARCHITECTURE.md" for name in sorted({*rows} - {*allowed})]
    wrong += [f"{name}: a row, and no such package" for name in sorted({*allowed} - {*rows})]
    columns = ("tokens", "dependencies", "import depth", "fmt: skip")
    for name in sorted({*rows} & {*allowed}):
        for column, count, most in zip(columns, rows[name], allowed[name], strict=True):
            if count > most:
                wrong.append(
                    f"{name}: {column} {count}, at most {most}: remove some, or raise the limit "
                    "and give the reason in the commit message"
                )
            elif count < (1 - SLACK) * most - 1:
                wrong.append(f"{name}: {column} {count}, limit {most}: python {__file__} lowers it")
    return wrong


def test_no_package_exceeds_its_limits():
    text = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
    assert off_limits(limited(), limits(text)) == []
    assert len(text.split()) <= WORDS


def test_limits_guard_fires():
    table = "| a | 100 | 2 | 5 | 0 |\n| b | 200 | 0 | 1 | 0 |\n| c | 9 | 0 | 1 | 0 |\n\n| d | e |\n"
    rows = {"a": (101, 2, 6, 1), "b": (190, 0, 1, 0), "d": (1, 0, 0, 0)}
    found = off_limits(rows, limits(table))
    assert [line.partition(":")[0] for line in found] == ["d", "c", "a", "a", "a", "b"]
    assert (
        off_limits({"a": (98, 2, 5, 0), "b": (200, 0, 1, 0), "c": (9, 0, 1, 0)}, limits(table))
        == []
    )


def test_tokens_are_those_of_code():
    source = (
        '"""Text."""\nA = 1\n"""Text."""\ndef f(x):  # text\n    """Text."""\n    return f"{x} y"\n'
    )
    assert code_tokens(source) == 3 + 6 + 2
    assert code_tokens("A = (\n    1,\n    2,\n)\n") == code_tokens("A = (1, 2,)\n") == 8


def test_chain_of_imports_is_its_number_of_modules():
    assert longest_chain({"a": {"b", "c"}, "b": {"c"}, "c": set()}) == 3


def lower_limits():
    """Limits that exceed what they limit, lowered to it."""
    path, rows = ROOT / "ARCHITECTURE.md", limited()
    text = path.read_text(encoding="utf-8")
    for name, most in limits(text).items():
        least = map(min, most, rows.get(name, most))
        row = " | ".join(map(str, (name, *least)))
        text = re.sub(rf"^\| {name} \|(?: \d+ \|){{4}}$", f"| {row} |", text, flags=re.M)
    path.write_text(text, encoding="utf-8")


# --- docstrings -----------------------------------------------------------------------------------


def undocumented(parsed):
    """Public names without a docstring: the module, its functions and classes, their methods."""
    missing = [] if ast.get_docstring(parsed) else ["module"]
    defined = ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef

    def visit(body, prefix):
        for node in body:
            if not isinstance(node, defined) or node.name.startswith("_"):
                continue
            if not ast.get_docstring(node):
                missing.append(prefix + node.name)
            if isinstance(node, ast.ClassDef):
                visit(node.body, f"{prefix}{node.name}.")

    visit(parsed.body, "")
    return missing


def test_public_names_have_docstrings():
    assert wrong_in(undocumented) == {}


def test_docstring_guard_fires():
    planted = (
        "class Named:\n    '''Known.'''\n    def said(self):\n        '''Known.'''\n"
        "    def unsaid(self): ...\n    def _private(self): ...\n"
        "class Unnamed: ...\ndef loud(): ...\nasync def late(): ...\ndef _quiet(): ...\n"
    )
    assert undocumented(ast.parse(planted)) == ["module", "Named.unsaid", "Unnamed", "loud", "late"]
    assert undocumented(ast.parse('"""Said."""')) == []


if __name__ == "__main__":
    lower_limits()
