"""Case files: what they mean, and one line with file, line, key and remedy for what they cannot."""

from __future__ import annotations

import re
import tomllib
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest

from msvalidate.case.compare.comparison import compare_case
from msvalidate.case.file.building import read_case
from msvalidate.case.file.case import Case, make_lattice, spacing_of
from msvalidate.case.file.reading import CaseError, key_lines
from msvalidate.case.file.schema import CaseFile
from msvalidate.case.judge.results import read_result
from msvalidate.case.report.run import case_files, judged_files
from msvalidate.case.springs.lattice_springs import make_network, solve_finer
from msvalidate.cli.program import main
from msvalidate.problem import (
    Box,
    Isotropic,
    PointForce,
    Polygon,
    Problem,
    ProblemError,
    Region,
    Segment,
    Support,
    Traction,
)
from tests.msvalidate.case.file import mutated
from tests.table import stored_rows, table

GOOD = """\
schema = 1
name = "beam"
[body]
box = [4.0, 1.0]
[material]
E = 1e5
nu = 0.3
state = "plane_stress"
[[support]]
on = "left"
[[load]]
on = "right"
traction = [0, -1]
"""
MESH = """$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
1
1 1 "clamp"
$EndPhysicalNames
$Nodes
4
1 0 0 0
2 2 0 0
3 2 1 0
4 0 1 0
$EndNodes
$Elements
3
1 1 2 1 1 4 1
2 2 2 2 1 1 2 3
3 2 2 2 1 1 3 4
$EndElements
"""


def write(folder, text):
    path = folder / "beam.toml"
    path.write_text(text, encoding="utf-8")
    (folder / "part.msh").write_text(MESH, encoding="utf-8")
    return path


def changed(*changes):
    text = GOOD
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new)
    return text


BOX, LOAD, HELD = "box = [4.0, 1.0]", 'on = "right"\ntraction = [0, -1]', 'on = "left"'


@table(("changes", "said"), stored_rows("case_files"))
def test_bad_files_are_told_in_one_line(tmp_path, changes, said):
    path = write(tmp_path, changed(*changes))
    with pytest.raises(ProblemError) as told:
        read_case(path)
    message = str(told.value)
    assert message.startswith("case beam.toml")
    assert said in message
    assert "\n" not in message


@pytest.mark.parametrize("given", [5, None, b"beam.toml", [1]])
def test_what_is_no_case_is_told_in_one_line(given):
    acts = (read_case, compare_case, case_files, lambda case: judged_files(case, case))
    for act in (*acts, lambda path: read_result(path, 2)):
        with pytest.raises(ProblemError, match=r"; give a"):
            act(given)


def test_changed_files_are_read_or_refused():
    """A look; the module itself tries a hundred thousand."""
    told = mutated.try_all(1500)
    assert told["read"] > 10
    assert told["in several lines"] == 0


def test_files_that_are_none(tmp_path):
    for content, said in ((b"\xff\xfe\x00", "is no UTF-8"), (b"", "no schema")):
        path = tmp_path / "odd.toml"
        path.write_bytes(content)
        with pytest.raises(CaseError, match=said):
            read_case(path)
    with pytest.raises(CaseError, match="No such file"):
        read_case(tmp_path / "none.toml")
    with pytest.raises(CaseError, match="Is a directory"):
        read_case(tmp_path)


def test_lengths_are_in_the_unit(tmp_path):
    text = changed(
        (BOX, BOX + '\nunit = "cm"'),
        ("state", "thickness = 1\nstate"),
        (HELD, HELD + '\ncomponents = ["y", "x"]\nvalue = [1, 2]'),
        (
            LOAD,
            "force = [1, 2]\npoint = [4, 0.5]\n[springs]\nspacing=0.25\n[compare]\npoints=[[1,1]]",
        ),
    )
    case = read_case(write(tmp_path, text))
    assert case.problem.supports[0].displacement == pytest.approx((0.02, 0.01))
    assert case.problem.loads == (PointForce((0.04, 0.005), (1.0, 2.0)),)
    assert spacing_of(case) == pytest.approx(2.5e-3)
    np.testing.assert_allclose(case.points, [[0.01, 0.01]])


def test_sides_of_outlines_and_meshes(tmp_path):
    outline = "polygon = [[0, 0], [4, 0], [4, 2], [0, 1]]"
    text = changed(
        (BOX, outline), ('on = "right"\ntraction = [0, -1]', 'on = "edge 3"\npressure = 2')
    )
    problem = read_case(write(tmp_path, text)).problem
    assert isinstance(problem.domain, Polygon)
    normal = np.array([-1, 4]) / np.sqrt(17)
    np.testing.assert_allclose(problem.loads[0].traction, -2 * normal)
    mesh = changed(
        (BOX, 'mesh = "part.msh"'),
        (HELD, 'on = "clamp"'),
        ('on = "right"\ntraction = [0, -1]', "node = 2\nforce = [0, -1]"),
    )
    problem = read_case(write(tmp_path, mesh)).problem
    assert problem.supports[0].region.name == "clamp"
    assert problem.loads[0].at == (2.0, 1.0)


def test_the_template_is_a_case(tmp_path):
    assert main(["case", "new", str(tmp_path / "new")]) == 0
    case = read_case(tmp_path / "new.toml")
    assert case.name == "new"
    assert spacing_of(case) == 0.05


def test_slender_bodies_have_few_cells_across():
    box = Box((1e4, 1.0))
    held = Support(box.side("left"), (0.0, 0.0))
    case = Case(Problem(box, Isotropic(1e5, 1 / 3), (held,)))
    assert spacing_of(case) == 0.5
    assert len(make_lattice(case, 0.5).points) == 3 * 20_001


def test_cells_that_are_no_squares_fill_boxes_of_their_proportions():
    sides = (1.0, 1.73205080757)  # as a file has it
    box = Box(sides)
    problem = Problem(box, Isotropic(1e5, 1 / 3), (Support(box.side("left"), (0.0, 0.0)),))
    case = Case(problem, lattice="triangular", cells=10)
    assert spacing_of(case) == pytest.approx(0.1)
    assert len(make_lattice(case, 0.1).points) == 11 * 11 + 10 * 10


MISFITS = [
    ("triangular", Box((4.0, 1.0)), 0.05, "give a box of 4 x 1.03923048454 m, or a lattice that"),
    ("triangular", Box((1.0, 1.73205080757)), 0.06, "do not fill the box 1 x 1.73205 m; give a b"),
    ("honeycomb", Polygon(((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))), 0.1, "only square, square4 can"),
    ("bcc", Box((1.0, 1.0, 1.03)), 0.125, "give a box of 1 x 1 x 1 m, or a lattice that"),
]  # fmt: skip


@table(("lattice", "body", "spacing", "said"), MISFITS)
def test_what_would_fit_is_told(lattice, body, spacing, said):
    plane = body.dim == 2
    below = Segment((0.0, 0.0), (1.0, 0.0)) if plane else body.side("bottom")
    law = Isotropic(1e5, 0.3, "plane_stress" if plane else "solid")
    case = Case(Problem(body, law, (Support(below, (0.0,) * body.dim),)), lattice=lattice)
    with pytest.raises(ProblemError, match=f"^lattice {lattice}: ") as told:
        make_lattice(case, spacing)
    assert said in str(told.value)


def plane_box(size, supports, loads=(), **options):
    held = [Support(Region(at), value) for at, value in supports]
    pulled = [Traction(Region(at), (1.0, -2.0)) for at in loads]
    law = Isotropic(1e5, 0.3, "plane_strain")
    return Case(Problem(Box(size), law, tuple(held), tuple(pulled)), **options)


ENDS = [((0.0, None), (0.0, 0.0)), ((5.6, None), (None, 0.1))]


def test_lines_of_cells_run_through_supports_and_where_they_end():
    apart = spacing_of(plane_box((5.6, 1.9), ENDS, cells=8))
    assert round(5.6 / apart, 9).is_integer()
    assert apart == pytest.approx(1.9 / 8, rel=0.02)
    part = spacing_of(plane_box((4.2, 0.8), [((0.0, (0.0, 0.284)), (0.0, 0.0))], cells=8))
    assert part == pytest.approx(0.284 / 3)
    told = plane_box((5.6, 1.9), ENDS, spacing=0.25)
    with pytest.raises(
        ProblemError, match=r"along x = 5.6 m; .*; give cells = 8 \(spacing"
    ) as refused:
        solve_finer(told)
    many = int(re.search(r"cells = (\d+)", str(refused.value))[1])
    assert make_network(replace(told, spacing=None, cells=many), apart)
    assert "origin" not in str(refused.value)
    turned = plane_box((1.0, 1.73205080757), ENDS[:1], lattice="triangular", spacing=0.06)
    with pytest.raises(ProblemError, match=r"do not fill.*; give cells = 17 \(spacing 0.05882 m\)"):
        solve_finer(turned)


@pytest.mark.parametrize("cells", [8, None])
def test_few_ordinary_boxes_are_refused(cells):
    draw = np.random.default_rng(7)
    for number in range(40):
        a, b = round(draw.uniform(1, 6), 1), round(draw.uniform(0.5, 2), 1)
        end = round(b * draw.uniform(0.3, 0.8), 3)
        held = [
            [((0.0, (0.0, end)), (0.0, 0.0))],
            [((None, 0.0), (0.0, 0.0)), ((None, b), (0.01, -0.01))],
            [((0.0, None), (0.0, None)), ((None, 0.0), (None, 0.0))],
            [((0.0, None), (0.0, 0.0)), ((a, None), (None, 0.01))],
        ][number % 4]
        case = plane_box((a, b), held, [(a, (0.0, end))] if number % 4 == 2 else (), cells=cells)
        make_network(case, spacing_of(case))


def test_lines_of_keys():
    text = 'a = 1\n[t]\nb = [\n  1, # x = 2\n]\n"c d" = { e = 1, f = [2] }\n'
    text += '[[r]]\n[[r]]\ng.h = """\ni = 3\n"""\nj = 1\n'
    tomllib.loads(text)
    lines = key_lines(text)
    assert lines[("a",)] == 1
    assert lines[("t", "b")] == 3
    assert lines[("t", "c d", "e")] == 6
    assert lines[("r", 1)] == 8
    assert lines[("r", 1, "g", "h")] == 9
    assert lines[("r", 1, "j")] == 12
    assert ("i",) not in lines


def test_the_schema_names_every_table():
    tables = msgspec.json.schema(CaseFile)["$defs"]["CaseFile"]["properties"]
    assert set(tables) >= {"schema", "body", "material", "support", "load", "springs", "compare"}


@pytest.mark.parametrize("path", sorted((Path(__file__).parents[4] / "examples").glob("*.toml")))
def test_examples_are_cases(path):
    case = read_case(path)
    assert len(path.read_text(encoding="utf-8").splitlines()) <= 22
    assert case.problem.supports


def test_a_spacing_beyond_the_body_is_refused_with_cells_that_fit(tmp_path):
    text = f"{GOOD}[springs]\nspacing = 200\n"
    with pytest.raises(ProblemError, match=r"give cells = 1 \(spacing 1 m\) in its place"):
        solve_finer(read_case(write(tmp_path, text)))
    solve_finer(read_case(write(tmp_path, text.replace("spacing = 200", "cells = 1"))))


def test_a_density_is_a_default_only_if_the_file_gives_none(tmp_path):
    assert read_case(write(tmp_path, GOOD)).notes["density"] == "1000 kg/m³ (default)"
    given = GOOD.replace("nu = 0.3", "nu = 0.3\ndensity = 1000")
    assert "density" not in read_case(write(tmp_path, given)).notes
