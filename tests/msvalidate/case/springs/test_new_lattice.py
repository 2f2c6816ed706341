"""A lattice that somebody adds: a function in `patterns`, and no row in any other table."""

from __future__ import annotations

from math import sqrt

import pytest

from msvalidate.case.compare.body_advice import advise_body
from msvalidate.case.file.case import Case
from msvalidate.case.springs.lattice_springs import solve_springs
from msvalidate.cli.program import main
from msvalidate.problem import Box, Isotropic, Mesh, Problem, Support
from msvalidate.problem.records import dataclass, replace
from msvalidate.springs.constants.routes import calibrate_by_route, default_constants
from msvalidate.springs.lattice import (
    Pattern,
    PatternLattice,
    cut_lattice,
    diagonal_square,
    fill,
    mesh_lattice,
    patterns,
    voronoi_box,
)
from msvalidate.springs.lattice.pattern import pattern_by_shells

PLATE = Box((0.37, 0.37))
LAW = Isotropic(1e6, 1 / 3, thickness=0.2)
CASE = """
schema = 1
name = "plate"
[body]
box = [0.37, 0.37]
[material]
E = 1e6
nu = 0.3
state = "plane_stress"
thickness = 0.2
[[support]]
on = "left"
[[load]]
on = "right"
traction = [1.0, 0.0]
[springs]
lattice = "square12"
cells = 4
"""


def square12() -> Pattern:
    """Square lattice with twelve neighbours."""
    rules = {"even": (1.0, 1.0, 0.25)}
    return pattern_by_shells("square 12", (1.0, 1.0), [(0, 0)], (1.0, sqrt(2), 2.0), rules)


@pytest.fixture(autouse=True)
def new_lattice(monkeypatch):
    monkeypatch.setattr(patterns, "square12", square12, raising=False)


def test_advice_lists_it_with_numbers_and_without_formulas(capsys):
    words = "advise --E 1e6 --nu .3 --thickness 0.2 --spacing 1cm"
    assert main([*words.split(), "-v"]) == 0
    (line,) = (line for line in capsys.readouterr().out.splitlines() if "no formula" in line)
    assert "constants of the calibration, for which no formula is recorded" in line
    own = calibrate_by_route(Isotropic(1e6, 0.3, thickness=0.2), square12(), 0.01, None)
    assert all(f"k{n} = {k:.6g} N/m along kind {n}" in line for n, k in enumerate(own.constants, 1))


def test_a_case_runs_on_it(tmp_path, capsys):
    (tmp_path / "plate.toml").write_text(CASE, encoding="utf-8")
    words = ["case", "run", str(tmp_path / "plate.toml"), "--out", str(tmp_path / "out")]
    assert main(words) in {0, 1}
    assert "square12, 0.0925 m" in "".join(capsys.readouterr())


def test_every_constructor_stores_its_rule_of_the_boundary():
    square, cell = patterns.square(), [[0, 0], [1, 0], [1, 1], [0, 1]]
    assert fill(square, PLATE, 4).boundary == voronoi_box(PLATE, 0.09).boundary == "shared"
    assert cut_lattice(square, PLATE, 0.09).boundary == "cut"
    assert mesh_lattice(Mesh(cell, [[0, 1, 2, 3]], "quad")).boundary == "edges"


@dataclass(frozen=True, eq=False, kw_only=True)
class Graded(PatternLattice):
    """A lattice with a name that cut lattices have too."""

    fraction: float = 0.5


def test_other_attributes_decide_nothing_of_the_boundary():
    case = Case(Problem(PLATE, LAW, (Support(PLATE.side("left"), (0.0, 0.0)),)), cells=4)
    answer = solve_springs(case, 0.0925)
    graded = replace(answer, lattice=Graded(**vars(answer.lattice)))
    assert "count 1/2" in advise_body(case, graded)[0].boundary


def test_the_name_of_a_lattice_decides_nothing_of_its_constants():
    lattice = diagonal_square(PLATE, 4)
    assert default_constants(LAW, replace(lattice, name="mine")) == default_constants(LAW, lattice)
    other = replace(square12(), name="square")
    tensors = [calibrate_by_route(LAW, p, 0.1, None).tensor for p in (other, patterns.square())]
    assert tensors[0] == pytest.approx(tensors[1])
