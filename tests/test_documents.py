"""Blocks of Python in README and the documents run, in a folder with the files that they name."""

from __future__ import annotations

import contextlib
import io
import os
import re
import runpy
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from msvalidate.bench.output import animation
from msvalidate.case.file.case import Case
from msvalidate.problem import Box, Isotropic, Problem, Support, Traction
from msvalidate.simulators.exchange import program
from msvalidate.simulators.exchange.export import export_case
from msvalidate.simulators.exchange.program import Program
from msvalidate.simulators.exchange.template import adapter_template
from msvalidate.simulators.gate.gate import motion
from reference_fem import box_discretisation
from tests.msvalidate.springs.bodies.test_mesh_file import written
from tests.reference_fem.mesh.test_from_mesh import mesh_of

ROOT = Path(__file__).resolve().parents[1]
FOLDERS = ("", "docs/**/", "checker/**/", "cases/", "simulators/", "examples/")
PAGES = {path.relative_to(ROOT).as_posix() for each in FOLDERS for path in ROOT.glob(f"{each}*.md")}
FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
OTHER_LANGUAGES = {"", "sh", "text", "toml", "yaml"}
SOLVER = """
import runpy
example = runpy.run_path({path!r})["solve"]
def solve(points, cells, E, nu, force, held, value):
    return example(points, cells, E[0], nu, "space", 1.0, force, held, value)
def tip():
    return 1.2e-4, -3.4e-4
"""
TIED = """
import numpy as np
class Body:
    "Points that springs of 1 MN/m tie to their places."
    def __init__(self, points, cells, E, nu, mass):
        self.start, self.x, self.v = points.copy(), points.copy(), np.zeros_like(points)
        self.mass, self.free = mass[:, None], True
    def hold(self, held):
        self.free = ~held
    def step(self, dt, force=0.0, gravity=0.0, damping=0.0):
        pull = (force - 1e6 * (self.x - self.start)) / self.mass + gravity - damping * self.v
        self.v = self.free * (self.v + dt * pull)
        self.x = self.x + dt * self.v
"""


def fences(page):
    return FENCE.findall((ROOT / page).read_text(encoding="utf-8"))


def blocks(page):
    return [text for language, text in fences(page) if language == "python"]


WITH_BLOCKS = sorted(page for page in PAGES if blocks(page))


# What pages say that is there --------------------------------------------------------------------


def mesh_in_mm():
    """Straight triangles, and a boundary named clamp."""
    mesh = mesh_of(box_discretisation(Box((2.0, 1.0)), (4, 3), "P1"))
    path, _ = written(mesh, Path(), "gmsh22")
    text = path.read_text(encoding="utf-8").replace('"left"', '"clamp"')
    Path("part.msh").write_text(text, encoding="utf-8")


def own_solver():
    path = ROOT / "checker" / "example" / "my_solver.py"
    Path("my_solver.py").write_text(SOLVER.format(path=str(path)), encoding="utf-8")


def own_adapter():
    """What `adapter new mine` writes, and the solver that the page calls my_solver."""
    Path("mine.py").write_text(adapter_template("mine"), encoding="utf-8")
    Path("my_solver.py").write_text(TIED, encoding="utf-8")


FILES = {
    "docs/library.md": mesh_in_mm,
    "checker/README.md": own_solver,
    "docs/simulators.md": own_adapter,
}


# How blocks run ----------------------------------------------------------------------------------


def run_in_process(words, _folder, _limit):
    """Run an adapter as `program.run_limited` does, without a new process."""
    before, sys.argv = sys.argv, words[1:]
    try:
        with contextlib.redirect_stderr(io.StringIO()) as said:
            runpy.run_path(words[1], run_name="__main__")
        code = 0
    except SystemExit as end:
        code = end.code or 0
    finally:
        sys.argv = before
    return code, b"", said.getvalue().strip().rpartition("\n")[2]


def run_tests(block):
    """Run a block of tests twice: it passes, and passes again with the numbers that it wrote.

    The tests run in processes of their own, as `pytester` would take back what was imported.
    """
    Path("test_block.py").write_text(block, encoding="utf-8")
    plugin = ("-p", "msvalidate_check.pytest_plugin", "--msvalidate-baseline", "base")
    update = ("--msvalidate-update", "--msvalidate-reason", "new")
    for more in (update, ()):
        words = [sys.executable, "-m", "pytest", *plugin, *more, "test_block.py"]
        ended = subprocess.run(words, capture_output=True, text=True, check=False)
        print(ended.stdout)  # noqa: T201
        assert f"{block.count('def test_')} passed" in ended.stdout, ended.stderr


def run_adapter(block):
    """A block in place of part 2 of the template answers questions of both kinds."""
    box = Box((1.0, 1.0, 1.0))
    held, pull = Support(box.side("left"), (0.0,) * 3), Traction(box.side("right"), (1e3, 0, 0))
    rest = export_case(Case(Problem(box, Isotropic(1e5, 0.3, "solid"), (held,), (pull,))), cells=2)
    parts = re.split(r"^(?=# [123]\. )", adapter_template("mine"), flags=re.MULTILINE)
    Path("own.py").write_text("".join([*parts[:2], block, parts[3]]), encoding="utf-8")
    moved = Program("own.py")(rest).displacement
    np.testing.assert_allclose(moved[~rest.held], rest.force[~rest.held] / 1e6, rtol=1e-6, atol=0)
    start = rest.mesh.points + 1e-3
    answer = Program("own.py")(motion(rest, start))
    assert (answer.velocity < 0).all()


@pytest.mark.parametrize("page", WITH_BLOCKS)
def test_blocks_run_one_after_the_other(page, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "my_solver", raising=False)  # that of another page
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(ROOT), str(ROOT / "checker")]))
    monkeypatch.setattr(program, "run_limited", run_in_process)
    monkeypatch.setattr(animation, "MAX_SHOWN", 3)
    FILES.get(page, lambda: None)()
    names = {"__name__": page}
    for number, block in enumerate(blocks(page)):
        if "def test_" in block:
            run_tests(block)
        elif 'request["task"]' in block:
            run_adapter(block)
        else:
            exec(compile(block, f"{page}, block {number}", "exec"), names)  # noqa: S102
    printed = capsys.readouterr().out
    texts = [text for language, text in fences(page) if language == ""]
    assert page != "checker/README.md" or texts[0] in printed


def test_blocks_of_python_are_marked_as_such():
    languages = {language for page in PAGES for language, _ in fences(page)}
    assert languages - OTHER_LANGUAGES == {"python"}
