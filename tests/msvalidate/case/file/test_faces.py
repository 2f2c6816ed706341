"""Sides of meshes are described, listed and drawn where a case has to name one."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from msvalidate.case.file.building import read_case
from msvalidate.case.file.faces import face_lines
from msvalidate.case.report.outlines import hidden
from msvalidate.case.report.sides import draw_sides
from msvalidate.cli.program import main
from msvalidate.problem import Box, Mesh
from msvalidate.springs.bodies.mesh_file import read_mesh
from tests.msvalidate.springs.bodies.test_mesh_file import box_mesh, written
from tests.table import refused, table

CASE = """schema = 1
body = {{ mesh = "{}", unit = "mm" }}
material = {{ E = 1e9, nu = 0.3 }}
"""
SUPPORT = '[[support]]\non = "wall"\n'


UPRIGHT = np.eye(3)


def tube(turn=UPRIGHT):
    """Quarter of a tube of lengths in mm, whose axis is turned from z."""
    box = box_mesh("H2")
    r, t, z = box.points[:, 0] + 4, box.points[:, 1] * np.pi / 2, box.points[:, 2]
    points = np.column_stack([r * np.cos(t), r * np.sin(t), z]) @ turn.T
    return Mesh(1e-3 * points, box.cells, box.shape, box.boundaries)


def test_sides_are_described_in_the_unit_of_the_case():
    inner, outer = face_lines(tube(), "mm")
    assert inner == (
        "left: cylinder, r 4 mm, along z, area 3.14 mm², centre (2.546, 2.546, 0.25) mm"
    )
    assert outer.startswith("right: cylinder, r 6 mm, along z, area 4.711 mm²")
    assert "r 0.004 m, along z, area 3.14e-06 m²" in face_lines(tube(), "m")[0]
    tilted = tube(np.array([[0.6, 0, 0.8], [0, 1, 0], [-0.8, 0, 0.6]]))
    assert re.search(r"r 4 mm, along \(0\.8\d*, \S+, 0\.(6|59)", face_lines(tilted, "mm")[0])
    mesh = tube()
    bent = replace(mesh, points=mesh.points + np.outer(2e3 * mesh.points[:, 2] ** 2, [1, 0, 0]))
    assert face_lines(bent, "mm")[0].startswith("left: curved, area")
    low = box_mesh("Q1")
    low = replace(low, points=low.points - [2, 0.5 + 1e-7])
    assert face_lines(low, "mm")[1] == "right: line, facing x, length 1000 mm, centre (0, 0) mm"


@pytest.mark.parametrize("wrong", ["", SUPPORT])
def test_a_side_that_is_missing_is_chosen_from_a_list_and_a_picture(tmp_path, capsys, wrong):
    mesh, _ = written(box_mesh("H1"), tmp_path, "gmsh22")
    file = tmp_path / "part.toml"
    file.write_text(CASE.format(mesh.name) + wrong, encoding="utf-8")
    assert main(["case", "run", str(file), "--out", str(tmp_path)]) == 2
    message = capsys.readouterr().err
    assert "left: plane, facing -x, area 0.5 mm², centre (0, 0.5, 0.25) mm" in message
    picture = tmp_path / "part-sides.png"
    assert f"picture: {picture}" in message
    assert picture.read_bytes()[1:4] == b"PNG"
    example = re.search(r'on = ".*"', message)[0]
    file.write_text(CASE.format(mesh.name) + f"[[support]]\n{example}\n", encoding="utf-8")
    assert read_case(file).problem.supports[0].region.name == "left"


def test_pictures_label_each_side_where_it_is_visible():
    box, whole = Box((2.0, 1.0, 0.5)), box_mesh("H1")
    names = {"left": "face 1", "right": "face 2", "front": "a$b", "back": "3", "top": "4"}
    on = {new: box.side(old).select(whole.points, 1e-9) for old, new in names.items()}
    mesh = whole.named({name: whole.surface[own[whole.surface].all(1)] for name, own in on.items()})
    figure = draw_sides(mesh, "mm")
    first, second = figure.axes
    labels = [{text.get_text() for text in axis.texts} for axis in (first, second)]
    assert labels == [{"2", "a$b"}, {"1", "3", "4"}]
    assert [first.get_zlabel(), first.get_xlabel()] == ["z (mm)", "x (mm)"]
    middles = np.array([[2, 0.5, 0.25], [0, 0.5, 0.25], [1, 0.5, 0.5], [1, 0.5, 0]])
    surface = mesh.points[mesh.surface]
    assert hidden(first, middles, surface).tolist() == [False, True, False, True]
    assert hidden(second, middles, surface).tolist() == [True, False, True, False]


@table("unit, size", [("MILLI", 1e-3), ("CENTI", 1e-2), ("", 1.0)])
def test_a_bracket_with_fillet_and_holes_has_the_numbers_of_its_step_file(tmp_path, unit, size):
    gmsh = pytest.importorskip("gmsh")
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    occ = gmsh.model.occ
    occ.fuse([(3, occ.addBox(0, 0, 0, 60, 40, 6))], [(3, occ.addBox(0, 0, 0, 6, 40, 50))])
    occ.synchronize()
    ((_, edge),) = gmsh.model.getEntitiesInBoundingBox(5, -1, 5, 7, 41, 7, 1)
    whole = occ.fillet([1], [edge], [8])
    holes = occ.addCylinder(-1, 20, 36, 8, 0, 0, 4), occ.addCylinder(42, 20, -1, 0, 0, 8, 4)
    occ.cut(whole, [(3, hole) for hole in holes])
    occ.synchronize()
    file = tmp_path / "bracket.step"
    gmsh.write(str(file))
    gmsh.finalize()
    text = file.read_text().replace(".MILLI.,.METRE.", f".{unit}.,.METRE." if unit else "$,.METRE.")
    file.write_text(text)
    mesh = read_mesh(file, size, cell=8 * size)
    lines = [line.partition(": ")[2] for line in face_lines(mesh, "m")]
    assert mesh.span[0] == pytest.approx((0, 60 * size))
    for radius, axis in ((8, "y"), (4, "x"), (4, "z")):
        assert any(f"r {radius * size:g} m, along {axis}" in line for line in lines), lines
    assert sum("plane, facing" in line for line in lines) == 8
    file.write_text(text[: len(text) // 2])
    with refused("gmsh makes no mesh of it"):
        read_mesh(file)
