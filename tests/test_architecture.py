"""The layout is kept: independence of the reference, floors, who writes files, docstrings.

Every rule is a function of source text that returns what is wrong, so that it can be tried on text
that breaks it: a guard that has never fired guards nothing.
"""

from __future__ import annotations

import ast
import graphlib
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("msvalidate", "reference_fem", "studies")


def module_name(path):
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


SOURCES = {
    module_name(path): path
    for package in PACKAGES
    for path in sorted((ROOT / package).rglob("*.py"))
}
every_module = pytest.mark.parametrize("module", SOURCES)


def source(module):
    return SOURCES[module].read_text(encoding="utf-8")


def imported(text):
    """Dotted names in all import statements, wherever they stand; relative ones keep their dots."""
    names = []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            origin = "." * node.level + (node.module or "")
            stem = origin if origin.endswith(".") else f"{origin}."
            names += [f"{stem}{alias.name}" for alias in node.names]
    return names


def within(name, package):
    return name == package or name.startswith(f"{package}.")


def test_sources_are_found():
    for package in PACKAGES:
        assert sum(within(module, package) for module in SOURCES) > 2, package


# --- independence of the reference, by its source -------------------------------------------------

FASTER = {"cvxopt"}  # a faster factor, where it is installed
OPTIONAL = {*FASTER, "pyfmmlib"}
ALLOWED = {"numpy", "pyamg", "scipy", "skfem", "reference_fem", *FASTER}
# Ways round an import statement: with these, a list of imports would prove nothing.
EVASIVE_MODULES = {"builtins", "importlib", "pkgutil", "runpy", "subprocess"}
EVASIVE_NAMES = {"__import__", "__builtins__", "eval", "exec", "import_module"}


def dependent(text):
    """What makes a module of the reference depend on more than the statement of the problem."""
    wrong = []
    for name in imported(text):
        top = name.partition(".")[0]
        known = top in ALLOWED or (top in sys.stdlib_module_names and top not in EVASIVE_MODULES)
        if not (known or within(name, "msvalidate.problem")):
            wrong.append(name)
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Name | ast.Attribute):
            name = node.id if isinstance(node, ast.Name) else node.attr
            loads_modules = isinstance(node, ast.Attribute) and ast.unparse(node) == "sys.modules"
            if name in EVASIVE_NAMES or loads_modules:
                wrong.append(ast.unparse(node))
    return wrong


@pytest.mark.parametrize("module", [m for m in SOURCES if within(m, "reference_fem")])
def test_reference_imports_only_what_it_may(module):
    assert dependent(source(module)) == []


def imported_at_once(text):
    """Packages whose import does not wait for a function to run."""
    tree = ast.parse(text)
    inside = {
        inner
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef)
        for inner in ast.walk(node)
    }
    names = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import | ast.ImportFrom) and node not in inside:
            names += imported(ast.unparse(node))
    return {name.partition(".")[0] for name in names}


@every_module
def test_what_is_optional_is_imported_when_it_is_used(module):
    assert not imported_at_once(source(module)) & OPTIONAL


def test_optional_guard_fires():
    assert imported_at_once("try:\n    import cvxopt.cholmod\nexcept ImportError:\n    pass")
    assert imported_at_once("from cvxopt import matrix") == {"cvxopt"}
    assert not imported_at_once("def has():\n    import cvxopt")


@pytest.mark.parametrize(
    "planted",
    [
        "import msvalidate",
        "import msvalidate.constants.stiffness",
        "import msvalidate.problem, msvalidate.lattice",
        "import msvalidate.constants.stiffness as problem",
        "import msvalidate.problems",
        "from msvalidate import lattice",
        "from msvalidate import problem, network",
        "from msvalidate.constants.stiffness import square_tensor",
        "from msvalidate.problem_of_mine import Box",
        "from msvalidate import *",
        "import studies",
        "from studies.poisson import block",
        "import numba",
        "import pandas as pd",
        "from . import body",
        "from .body import Solution",
        "from .. import msvalidate",
        "from ..msvalidate.stiffness import square_tensor",
        "def solve():\n    from msvalidate import stiffness",
        "if TYPE_CHECKING:\n    from msvalidate.lattice import Lattice",
        "try:\n    import msvalidate.kernels\nexcept ImportError:\n    pass",
        "import importlib",
        "from importlib import import_module",
        "import importlib.util as u",
        "__import__('msvalidate.constants.stiffness')",
        "load = __import__",
        "__builtins__['__import__']('msvalidate.constants.stiffness')",
        "exec('import msvalidate.constants.stiffness')",
        "eval('1')",
        "import runpy",
        "import sys\nsys.modules['msvalidate.constants.stiffness']",
        "import subprocess",
    ],
)
def test_import_guard_fires(planted):
    assert dependent(planted)


@pytest.mark.parametrize(
    "allowed",
    [
        "import numpy as np",
        "from scipy.sparse.linalg import splu",
        "import skfem",
        "from dataclasses import dataclass",
        "from __future__ import annotations",
        "from msvalidate import problem",
        "import msvalidate.problem",
        "from msvalidate.problem import Box",
        "from msvalidate.problem.checks import Array",
        "from reference_fem.body import Solution",
    ],
)
def test_import_guard_lets_pass(allowed):
    assert dependent(allowed) == []


# --- independence of the reference, by what it loads ----------------------------------------------

LOAD_ALL = """
import importlib, pkgutil, sys
package = importlib.import_module(sys.argv[1])
for module in pkgutil.walk_packages(package.__path__, package.__name__ + "."):
    importlib.import_module(module.name)
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
forces = reference_fem.charged(slab).forces
moved = reference_fem.respond(slab, 1e-6 * forces, Isotropic(1.0, 0.3)).displacement
reference_fem.charged(reference_fem.moved_air(slab, moved))
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
        and not (name == "msvalidate" or within(name, "msvalidate.problem"))
    ]


def test_reference_loads_nothing_of_the_springs():
    modules = loaded_by("reference_fem", USE_REFERENCE)
    assert {"reference_fem", "reference_fem.body", "msvalidate.problem", "skfem"} <= set(modules)
    assert alien(modules) == []


@pytest.mark.parametrize(
    ("planted", "seen"),
    [
        ("import msvalidate.constants.stiffness", "msvalidate.constants.stiffness"),
        ("getattr(__import__('importlib'), 'import' + '_module')('msvalidate.lattice')", "lattice"),
        ("def solve():\n    import msvalidate.dynamics.spectrum", "msvalidate.dynamics.spectrum"),
        ("import numba", "numba"),
        ("import studies", "studies"),
    ],
)
def test_process_guard_fires(planted, seen, tmp_path):
    package = tmp_path / "planted_fem"
    package.mkdir()
    (package / "__init__.py").write_text("import reference_fem\n", encoding="utf-8")
    (package / "late.py").write_text(planted, encoding="utf-8")
    use = "package.late.solve()" if "solve" in planted else ""
    found = alien(loaded_by("planted_fem", use, tmp_path))
    assert any(name.endswith(seen) for name in found)


def test_springs_load_nothing_of_the_reference():
    # The other direction: what the reference computes must not reach the springs either.
    modules = loaded_by("msvalidate")
    assert {"msvalidate.network", "msvalidate.study"} <= set(modules)
    assert not [name for name in modules if within(name, "reference_fem") or within(name, "skfem")]


# --- floors ---------------------------------------------------------------------------------------

FLOORS = {
    "msvalidate": 0,  # the version only
    "msvalidate.problem": 0,
    "msvalidate.network.accurate": 1,
    "msvalidate.network.laws.accurate_cells": 1,
    "msvalidate.linear_algebra.blocks": 1,
    "msvalidate.bodies.lattice_network": 1,
    "msvalidate.bodies.calibrate": 1,
    "msvalidate.constants.lattice_constants": 1,
    "msvalidate.bodies.uniform_tension": 1,
    "msvalidate.judging.candidate": 2,
    "msvalidate.constants.cell_at_rest": 1,
    "msvalidate.constants.cell_multigrid": 1,
    "msvalidate.bodies.cut_network": 1,
    "msvalidate.tangent.cycles": 1,
    "msvalidate.network.displaced": 1,
    "msvalidate.linear_algebra.dissection": 1,
    "msvalidate.linear_algebra.double_double": 1,
    "msvalidate.electrostatics": 1,
    "msvalidate.network.faults": 1,
    "msvalidate.bodies.fit": 2,
    "msvalidate.network.folds": 1,
    "msvalidate.constants.homogenise": 1,
    "msvalidate.statics.imposing": 1,
    "msvalidate.tangent.inverse": 1,
    "msvalidate.kernels": 1,
    "msvalidate.lattice": 1,
    "msvalidate.network.layout": 1,
    "msvalidate.linear_algebra.factor": 1,
    "msvalidate.network.laws.local_shear": 1,
    "msvalidate.tangent.mechanism": 1,
    "msvalidate.bodies.mesh_file": 1,
    "msvalidate.tangent.multigrid": 1,
    "msvalidate.network": 1,
    "msvalidate.network.checks": 1,
    "msvalidate.linear_algebra.refine": 1,
    "msvalidate.network.residual": 1,
    "msvalidate.tangent.rounding": 1,
    "msvalidate.constants.routes": 1,
    "msvalidate.tangent.stability": 1,
    "msvalidate.constants.stable_range": 1,
    "msvalidate.judging.singularity": 1,
    "msvalidate.constants.spring_constants": 1,
    "msvalidate.constants.stiffness": 1,
    "msvalidate.network.laws.volumes": 1,
    "msvalidate.constants.waves": 1,
    "msvalidate.actuator": 2,
    "msvalidate.statics.equilibrium": 2,
    "msvalidate.statics.following": 2,
    "msvalidate.dynamics.hidden": 2,
    "msvalidate.dynamics.integrate": 2,
    "msvalidate.statics.linear_solution": 2,
    "msvalidate.dynamics.integrators": 2,
    "msvalidate.relaxation.relax": 2,
    "msvalidate.relaxation.run": 2,
    "msvalidate.relaxation.newton": 2,
    "msvalidate.statics.path": 2,
    "msvalidate.statics.polish": 2,
    "msvalidate.relaxation.relaxations": 2,
    "msvalidate.relaxation.viscous": 2,
    "msvalidate.dynamics.spectrum": 2,
    "msvalidate.statics.stress": 2,
    "msvalidate.statics.tangents": 2,
    "reference_fem": 2,
    "msvalidate.output.baseline": 3,
    "msvalidate.output.catalogue": 3,
    "msvalidate.judging.compare": 3,
    "msvalidate.judging.evidence": 3,
    "msvalidate.output.figures": 3,
    "msvalidate.cli.jobs": 3,
    "msvalidate.output.junit": 3,
    "msvalidate.cli.outcome": 3,
    "msvalidate.output.page": 3,
    "msvalidate.output.provenance": 3,
    "msvalidate.output.report": 3,
    "msvalidate.output.stored": 3,
    "msvalidate.judging.sweep": 3,
    "studies": 4,
    "msvalidate.cli.arguments": 5,
    "msvalidate.study": 5,
}
UNITS = (
    "msvalidate.actuator",
    "msvalidate.electrostatics",
    "msvalidate.kernels",
    "msvalidate.lattice",
    "msvalidate.problem",
    "reference_fem",
    "studies",
)
"""Packages that stand on one floor as a whole."""
JUDGE = ("msvalidate.judging.compare", "msvalidate.judging.evidence")


def standing(module):
    """The entry of `FLOORS` that a module belongs to."""
    return next((unit for unit in UNITS if within(module, unit)), module)


def resolved(name):
    """The module of ours that an imported name is, or is defined in; None for a library."""
    while name and name not in SOURCES:
        name = name.rpartition(".")[0]
    return name or None


def misplaced(module, text):
    """Imports that a module's place in the layout forbids."""
    wrong = []
    here = FLOORS[standing(module)]
    for name in imported(text):
        if name.startswith("."):
            wrong.append(f"{name}: relative")
        if name.endswith(".*"):
            wrong.append(f"{name}: star")
        target = resolved(name)
        if target is None:
            continue
        if FLOORS[standing(target)] > here:
            wrong.append(f"{name}: upwards")
        if target == "msvalidate.study":
            wrong.append(f"{name}: the command line is imported by nobody")
        if within(target, "reference_fem") and here < 4 and not within(module, "reference_fem"):
            wrong.append(f"{name}: the springs may not know the reference")
        if module in JUDGE and standing(target) not in {*JUDGE, "msvalidate.problem"}:
            wrong.append(f"{name}: the judge knows neither side")
    return wrong


def test_every_module_stands_on_a_floor():
    assert {standing(module) for module in SOURCES} == set(FLOORS)


@every_module
def test_imports_run_downwards(module):
    assert misplaced(module, source(module)) == []


@pytest.mark.parametrize(
    ("module", "planted", "why"),
    [
        ("msvalidate.problem.domain", "from msvalidate import lattice", "upwards"),
        ("msvalidate.lattice", "from msvalidate.relaxation.relax import algorithm1", "upwards"),
        (
            "msvalidate.relaxation.relax",
            "from msvalidate.judging.evidence import Evidence",
            "upwards",
        ),
        ("msvalidate.output.report", "import studies.poisson", "upwards"),
        ("studies.poisson", "def f():\n    import msvalidate.study", "upwards"),
        ("reference_fem.body", "from msvalidate.judging.sweep import Setting", "upwards"),
        ("msvalidate.study", "from msvalidate import study", "imported by nobody"),
        ("msvalidate.statics.equilibrium", "import reference_fem", "may not know the reference"),
        (
            "msvalidate.judging.sweep",
            "from reference_fem import refine",
            "may not know the reference",
        ),
        ("msvalidate.judging.compare", "from msvalidate.network import Network", "neither side"),
        ("msvalidate.judging.evidence", "import reference_fem.body", "neither side"),
        (
            "msvalidate.judging.evidence",
            "from msvalidate.output.figures import new",
            "neither side",
        ),
        ("msvalidate.network", "from msvalidate.problem import *", "star"),
        ("msvalidate.network", "from numpy import *", "star"),
        ("msvalidate.network", "from . import lattice", "relative"),
    ],
)
def test_floor_guard_fires(module, planted, why):
    assert why in " ".join(misplaced(module, planted))


@pytest.mark.parametrize(
    ("module", "allowed"),
    [
        ("msvalidate.kernels", "from msvalidate.network import Network"),
        ("msvalidate.judging.compare", "from msvalidate.judging.evidence import Observed"),
        (
            "msvalidate.judging.evidence",
            "import pandas as pd\nfrom msvalidate.problem import SolverError",
        ),
        ("studies.poisson.block", "import reference_fem\nfrom msvalidate import lattice"),
        ("msvalidate.study", "from msvalidate import report"),
    ],
)
def test_floor_guard_lets_pass(module, allowed):
    assert misplaced(module, allowed) == []


def cycle(texts, unit=lambda module: module):
    """Units that import each other in a circle, or nothing; a unit is a module by default."""
    graph = {unit(module): set() for module in texts}
    for module, text in texts.items():
        targets = {resolved(name) for name in imported(text)} - {None, module}
        graph[unit(module)] |= {unit(target) for target in targets} - {unit(module)}
    try:
        graphlib.TopologicalSorter(graph).prepare()
    except graphlib.CycleError as error:
        return error.args[1]
    return []


def test_no_module_imports_itself_by_a_detour():
    # Two modules on one floor may use each other one way only.
    assert cycle({module: source(module) for module in SOURCES}) == []


def part(module):
    """The sub-package of the reference that a module is in, or else the module."""
    return ".".join(module.split(".")[:2]) if within(module, "reference_fem") else module


def test_parts_of_the_reference_use_each_other_one_way_only():
    texts = {module: source(module) for module in SOURCES if within(module, "reference_fem")}
    assert {"reference_fem.mesh", "reference_fem.electric"} <= {part(module) for module in texts}
    assert cycle(texts, part) == []


def test_parts_guard_fires():
    planted = {
        "reference_fem.mesh.boxes": "from reference_fem.electric.slab import Slab",
        "reference_fem.electric.mesh": "from reference_fem.mesh.checks import checked_cells",
    }
    assert not cycle(planted)
    assert len(set(cycle(planted, part))) == 2


def test_cycle_guard_fires():
    planted = {
        "msvalidate.lattice": "from msvalidate.network import Network",
        "msvalidate.network": "def f():\n    from msvalidate import stiffness",
        "msvalidate.constants.stiffness": "import msvalidate.lattice",
    }
    assert len(set(cycle(planted))) == 3


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
    "msvalidate.output.report": ("",),
    "msvalidate.output.stored": ("figure.savefig(page,", "table.to_csv(index="),
    "msvalidate.study": ("open(os.devnull,", "os.open(os.devnull,"),
    "msvalidate.linear_algebra.factor": ("os.open(os.devnull,",),
    "msvalidate.kernels.cache": (
        *("path.parent.mkdir(", "part.write_bytes(", "part.unlink()"),
        *("shutil.rmtree(old,", "old.unlink("),
    ),
}
"""Who may write, beginning with which calls: `stored` makes bytes and text, in memory; `cache` is
where compiled code is kept."""


def writes(text):
    """Calls in a source text that write files."""
    found = []
    for node in ast.walk(ast.parse(text)):
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


@every_module
def test_only_the_report_writes_files(module):
    found = writes(source(module))
    if module in WRITING:
        assert found  # else the rule has lost its subject
    assert [call for call in found if not call.startswith(WRITING.get(module, ()))] == []


@pytest.mark.parametrize(
    "planted",
    [
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
    ],
)
def test_writing_guard_fires(planted):
    assert writes(planted)


@pytest.mark.parametrize(
    "allowed",
    ["open('a')", "open('a', 'rb')", "p.open()", "p.open('r')", "p.read_text()", "json.dumps(x)"],
)
def test_writing_guard_lets_pass(allowed):
    assert writes(allowed) == []


# --- mesh files -----------------------------------------------------------------------------------


def uses_meshio(text):
    """Imports of the library that reads mesh files; it may also write, and end the program."""
    return [name for name in imported(text) if within(name, "meshio")]


@every_module
def test_only_one_module_knows_meshio(module):
    assert bool(uses_meshio(source(module))) == (module == "msvalidate.bodies.mesh_file")
    assert "meshio.write" not in source(module)


@pytest.mark.parametrize(
    "planted",
    [
        "import meshio",
        "import meshio as m",
        "from meshio import read",
        "def f():\n import meshio.vtk",
    ],
)
def test_meshio_guard_fires(planted):
    assert uses_meshio(planted)


# --- sorts ----------------------------------------------------------------------------------------

UNSTABLE = {"argpartition", "partition", "reverse_cuthill_mckee", "nlargest"}
"""What leaves ties to an algorithm that goes by the processor, and cannot be told not to."""


def by_processor(text):
    """Calls whose order of ties goes by the processor; arguments sorted by two columns are not."""
    found = []
    for node in ast.walk(ast.parse(text)):
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


@every_module
def test_ties_are_sorted_by_number(module):
    assert by_processor(source(module)) == []


@pytest.mark.parametrize(
    "planted",
    [
        "np.argsort(x)",
        "x.argsort()",
        "np.argsort(x, kind='quicksort')",
        "table.sort_values('x')",
        "table.sort_values('x', kind='heapsort')",
        "np.argpartition(x, 3)",
        "np.partition(x, 3)",
        "order = reverse_cuthill_mckee(graph)",
        "def f():\n    return [np.argsort(row) for row in rows]",
    ],
)
def test_sorting_guard_fires(planted):
    assert by_processor(planted)


@pytest.mark.parametrize(
    "allowed",
    [
        "np.argsort(x, axis=1, kind='stable')",
        "table.sort_values(['x', 'y'])",
        "'a b'.partition(' ')",
        "np.sort(x)",
    ],
)
def test_sorting_guard_lets_pass(allowed):
    assert by_processor(allowed) == []


# --- docstrings -----------------------------------------------------------------------------------


def undocumented(text):
    """Public names without a docstring: the module, its functions and classes, their methods."""
    tree = ast.parse(text)
    missing = [] if ast.get_docstring(tree) else ["module"]
    defined = ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef

    def visit(body, prefix):
        for node in body:
            if not isinstance(node, defined) or node.name.startswith("_"):
                continue
            if not ast.get_docstring(node):
                missing.append(prefix + node.name)
            if isinstance(node, ast.ClassDef):
                visit(node.body, f"{prefix}{node.name}.")

    visit(tree.body, "")
    return missing


@every_module
def test_public_names_have_docstrings(module):
    assert undocumented(source(module)) == []


def test_docstring_guard_fires():
    planted = (
        "class Named:\n    '''Known.'''\n    def said(self):\n        '''Known.'''\n"
        "    def unsaid(self): ...\n    def _private(self): ...\n"
        "class Unnamed: ...\ndef loud(): ...\nasync def late(): ...\ndef _quiet(): ...\n"
    )
    assert undocumented(planted) == ["module", "Named.unsaid", "Unnamed", "loud", "late"]
    assert undocumented('"""Said."""') == []
