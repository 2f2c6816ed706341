"""A lattice that somebody adds: a function in `patterns`, and no row in any other table."""

from __future__ import annotations

import json
from math import sqrt

import pytest

from msvalidate.case.body_advice import advise_body
from msvalidate.case.case import Case
from msvalidate.case.springs import solve_springs
from msvalidate.cli.program import main
from msvalidate.constants.routes import calibrate_by_route, default_constants
from msvalidate.judging.evidence import all_passed, judge
from msvalidate.judging.sweep import Setting
from msvalidate.lattice import (
    Pattern,
    cut_lattice,
    diagonal_square,
    fill,
    fill_rotated,
    mesh_lattice,
    patterns,
    voronoi_box,
)
from msvalidate.lattice.pattern import SpringFormulas, pattern_by_shells
from msvalidate.problem import Box, Isotropic, Mesh, Problem, ProblemError, Support, Traction
from msvalidate.problem.records import dataclass, replace
from msvalidate.studies import lattices

PLATE = Box((0.37, 0.37))
LAW = Isotropic(1e6, 1 / 3, "plane_stress", thickness=0.2)
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


@pytest.fixture
def new_lattice(monkeypatch):
    monkeypatch.setattr(patterns, "square12", square12, raising=False)


@pytest.mark.usefixtures("new_lattice")
def test_advice_lists_it_with_numbers_and_without_formulas(capsys):
    words = "advise --E 1e6 --nu .3 --thickness 0.2 --spacing 1cm"
    assert main(words.split()) == 0
    lines = capsys.readouterr().out.splitlines()
    (at,) = (n for n, line in enumerate(lines) if line.startswith("square12, spacing 0.01 m"))
    assert lines[at + 1].count("along kind") == 3
    assert "constants of the calibration, for which no formula is recorded" in lines[at + 1]
    assert sum("no formula" in line for line in lines) == 1
    assert main([*words.split(), "--json"]) == 0
    records = {one["lattice"]: one for one in json.loads(capsys.readouterr().out)["lattices"]}
    own = calibrate_by_route(Isotropic(1e6, 0.3, thickness=0.2), square12(), 0.01, None)
    told = [kind["constant"] for kind in records["square12"]["kinds"]]
    assert told == pytest.approx(own.constants, rel=1e-12)


@pytest.mark.usefixtures("new_lattice")
def test_a_case_runs_on_it(tmp_path, capsys):
    (tmp_path / "plate.toml").write_text(CASE, encoding="utf-8")
    out = tmp_path / "out"
    assert main(["case", "run", str(tmp_path / "plate.toml"), "--out", str(out)]) in {0, 1}
    assert "square12, spacing 0.0925 m" in "".join(capsys.readouterr())


def test_study_lattices_judges_it(monkeypatch):
    few = {"square": patterns.square, "triangular": patterns.triangular, "square12": square12}
    monkeypatch.setattr(patterns, "all_patterns", lambda: few)
    found = lattices.run(setting=Setting(quick=True), questions=("solids", "choice"))
    assert all_passed(judge(found))
    assert "square 12" in set(found.tables["lattices"]["lattice"])
    assert all(draw(found.tables) for draw in found.figures.values())


def test_formulas_are_one_a_kind():
    with pytest.raises(ProblemError, match="formulas of 1 kinds; give 2, or none"):
        replace(patterns.square(), formulas=SpringFormulas((("the axes", "μt"),)))


# Labels of what was built ---------------------------------------------------------------------


def test_every_constructor_stores_its_rule_of_the_boundary():
    corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
    mesh = Mesh(corners, [[0, 1, 2, 3]], "quad")
    square = patterns.square()
    for lattice, rule in (
        (fill(square, PLATE, 4), "shared"),
        (diagonal_square(PLATE, 4), "shared"),
        (fill_rotated(square, PLATE, 0.05, 0.3), "shared"),
        (voronoi_box(PLATE, 0.09), "shared"),
        (cut_lattice(square, PLATE, 0.09), "cut"),
        (mesh_lattice(mesh), "edges"),
    ):
        assert lattice.boundary == rule, lattice.name


def test_what_is_said_of_the_boundary_is_the_lattices_own():
    """Another attribute of it decides nothing."""

    @dataclass(frozen=True, eq=False, kw_only=True)
    class Graded(type(fill(patterns.square(), PLATE, 1))):
        fraction: float = 0.5

    load, held = Traction(PLATE.side("right"), (1.0, 0.0)), Support(PLATE.side("left"), (0.0, 0.0))
    case = Case(Problem(PLATE, LAW, (held,), (load,)), cells=4)
    answer = solve_springs(case, 0.0925)
    graded = replace(answer, lattice=Graded(**vars(answer.lattice)))
    assert "count 1/2" in advise_body(case, graded)[0].boundary


def test_the_name_of_a_lattice_decides_nothing():
    """Its constants are those of what it repeats."""
    lattice = diagonal_square(PLATE, 4)
    own = default_constants(LAW, lattice)
    assert default_constants(LAW, replace(lattice, name="mine")) == own
    with pytest.raises(ProblemError, match="none known for triangular"):
        default_constants(LAW, replace(lattice, name="triangular", unit_cell=None))
    far = replace(square12(), name="square")
    tensor = calibrate_by_route(LAW, far, 0.1, "springs").tensor
    assert tensor == pytest.approx(calibrate_by_route(LAW, patterns.square(), 0.1, None).tensor)
