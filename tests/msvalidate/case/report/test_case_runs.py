"""Cases solved: what they leave, what they say of springs, and that nothing is lost or executed."""

from __future__ import annotations

import io
import json
from contextlib import chdir, redirect_stderr, redirect_stdout
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import meshio
import numpy as np
import pytest

from msvalidate.case.compare import quantities
from msvalidate.case.compare.budget import budget, tables
from msvalidate.case.compare.comparison import OTHER_MATERIAL, break_springs, compare_case
from msvalidate.case.file.building import read_case
from msvalidate.case.file.case import LAWS, Case
from msvalidate.case.file.fracture import Fracture
from msvalidate.case.judge.results import read_result
from msvalidate.case.report import figures, files
from msvalidate.case.report.page import reference_sentence, sentences, shown_tables
from msvalidate.case.report.run import case_files, judged_files, reference_content
from msvalidate.case.springs.large import converge_case
from msvalidate.case.springs.lattice_springs import solve_springs
from msvalidate.cli.program import main
from msvalidate.linear_algebra.norms import max_length
from msvalidate.problem import (
    SIDES,
    Box,
    Contact,
    Isotropic,
    Obstacle,
    Polygon,
    Problem,
    ProblemError,
    Region,
    Segment,
    SolverError,
    Support,
    Traction,
    Weight,
    Zone,
)
from msvalidate.springs.bodies.toughness import critical_stretch
from msvalidate.springs.lattice import patterns
from msvalidate.springs.statics.equilibrium import equilibrium
from reference_fem import box_discretisation
from reference_fem.body import solve_problem
from reference_fem.converged import converge
from tests.msvalidate.springs.bodies.test_mesh_file import box_mesh
from tests.table import table

EXAMPLES = Path(__file__).parents[4] / "examples"
BEAM = Box((2.0, 1.0))


def beam(nu=1 / 3, **options):
    loads = (Traction(BEAM.side("right"), (0.0, -10.0)),)
    held = (Support(BEAM.side("left"), (0.0, 0.0)),)
    return Case(Problem(BEAM, Isotropic(1e5, nu), held, loads, "beam"), **options)


def pulled_down(nu=0.3, state="plane_strain", force=-1000.0, accuracy=0.01, **options):
    loads = (Traction(BEAM.side("right"), (0.0, force)),)
    held = (Support(BEAM.side("left"), (0.0, 0.0)),)
    problem = Problem(BEAM, Isotropic(1e5, nu, state), held, loads)
    return Case(problem, cells=10, accuracy=accuracy, **options)


def test_loads_of_fracture_are_whole():
    assert Fracture(critical_stretch=0.1).raised == 1.0


def test_what_one_more_mesh_takes_is_said():
    cube = Box((1.0, 1.0, 1.0))
    held, pull = Support(cube.side("left"), (0.0, 0.0, 0.0)), Traction(cube.side("top"), (1, 0, 0))
    asked = Problem(cube, Isotropic(1e5, 0.3, "solid"), (held,), (pull,))
    found = converge_case(Case(asked, accuracy=1e-6, memory=0.1), np.ones((1, 3)))
    said = reference_sentence(found)
    assert "Known better by one more mesh: 5.3e4 unknowns, 0.2 GB, " in said
    assert said.endswith("([compare] memory = 0.2).")
    assert reference_content(found)["more"]["unknowns"] == 3 * 8 * len(found.finest.body.points)
    known = replace(found, accuracy=1.0)
    assert "more mesh" not in reference_sentence(known)
    assert reference_content(known)["more"] is None


def test_a_linear_target_and_the_springs_law_make_up_large_displacements():
    # What the springs' own nonlinear rest adds, along the difference where it is largest.
    for state in ("plane_strain", "plane_stress"):
        found = compare_case(pulled_down(state=state))
        away = found.displacement - found.reference.displacement.value
        at = np.linalg.norm(away, axis=1).argmax()
        rest = equilibrium(found.springs[0].network, "nonlinear").displacement
        more = replace(found.springs[0], rest=SimpleNamespace(displacement=rest)).at(found.points)
        along = away[at] / np.linalg.norm(away[at])
        own = (more - found.displacement)[at] @ along / found.size
        parts = budget(found).set_index("part")["value"]
        assert abs(parts["linear reference"]) > 0.01
        assert parts["linear reference"] + parts["law"] == pytest.approx(own, rel=0.1)


@pytest.mark.parametrize(("law", "volume"), list(zip(LAWS, (0.0, 4e4), strict=True)))
def test_parts_of_large_displacements_add_up(law, volume):
    constants = {"constants": (8e4, 4e4), "volume": volume}
    found = compare_case(pulled_down(law=law, geometry="nonlinear", **constants))
    table = budget(found).set_index("part")
    names = list(table.index)
    parts = table["value"].iloc[: names.index("total")]
    assert list(parts.index) == ["spacing", "boundary", "material", "law"]
    assert parts.sum() == pytest.approx(table.loc["total", "value"], abs=1e-14)
    assert abs(parts["boundary"]) <= table.loc["boundary", "uncertainty"]
    assert {row.word for row in found.rows[1:]} == {"not asked"}
    assert str(found.notes[0]).startswith("reactions: not compared: to first order alone")


def test_laws_of_the_target_differ_where_displacements_are_large():
    places = np.array([(2.0, 0.5), (1.0, 0.0)])
    options = {"geometry": "nonlinear", "force": -1500.0, "accuracy": 1e-3}
    soft, stiff = (converge_case(pulled_down(law=law, **options), places) for law in LAWS)
    apart = max_length(soft.displacement.value - stiff.displacement.value)
    assert apart > 0.02 * max_length(soft.displacement.value)
    assert apart > 20 * max(soft.displacement.uncertainty, stiff.displacement.uncertainty)
    linear = [each.displacement.value - each.large[0] for each in (soft, stiff)]
    assert max_length(linear[0] - linear[1]) <= 1e-12 * apart


def test_what_a_body_of_no_known_law_has_is_said():
    steep = pulled_down(nu=0.46, force=-100.0)
    table = budget(compare_case(steep)).set_index("part")
    assert np.isnan(table.loc["law", "value"])
    assert "; none: large displacements: " in table.loc["law", "meaning"]
    with pytest.raises(ProblemError, match="of nearly incompressible bodies none"):
        compare_case(replace(steep, geometry="nonlinear"))


def test_springs_of_another_material_are_told_from_coarse_ones():
    found = compare_case(beam(cells=10, constants=(1e5, 2e5)))
    assert found.kind == OTHER_MATERIAL
    parts = budget(found).set_index("part")
    assert abs(parts.loc["material", "value"]) > 0.8 * parts.loc["total", "value"]
    assert found.rows[0].word == "differs"


def test_an_outline_is_cut_and_its_points_outside_are_no_obstacle(tmp_path):
    body = Polygon(((0.0, 0.0), (2.0, 0.0), (2.0, 1.4), (0.0, 0.8)))
    held = (Support(Segment((0.0, 0.8), (0.0, 0.0)), (0.0, 0.0)),)
    loads = (Traction(Segment((2.0, 0.0), (2.0, 1.4)), (0.0, -10.0)),)
    case = Case(Problem(body, Isotropic(1e5, 0.3), held, loads), spacing=0.07)
    found, _, content = case_files(case, plots=False)
    assert found.rows[0].word == "agrees"
    compared = read_vtu(tmp_path, content["compared.vtu"])
    assert np.isfinite(compared.point_data["displacement_elements"]).all()
    outside = len(found.springs[0].lattice.points) - len(compared.points)
    assert 0 < outside < len(compared.points) / 2


def test_a_body_is_the_same_as_a_box_and_as_an_outline(tmp_path):
    # The largest displacement and difference are at corners of the body.
    plain, outlined = beam(cells=6), Polygon(((0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)))
    drawn = Case(replace(plain.problem, domain=outlined), cells=6)
    box, polygon = compare_case(plain), compare_case(drawn)
    np.testing.assert_allclose(polygon.points, box.points, atol=1e-12)
    np.testing.assert_allclose(polygon.displacement, box.displacement, atol=1e-9 * box.size)
    assert polygon.size == pytest.approx(box.size, rel=2 * box.reference.error)
    left = abs(polygon.rows[0].error - box.rows[0].error)
    assert left <= 2 * (polygon.reference.error + box.reference.error)
    fields = read_vtu(tmp_path, files.field_files(polygon)["compared.vtu"])
    assert np.isfinite(fields.point_data["displacement_elements"]).all()


def test_between_points_of_a_cube_displacements_are_interpolated():
    box, law = Box((1.0, 1.0, 1.0)), Isotropic(1e5, 1 / 4, "solid")
    rollers = [
        ("left", (0.0, None, None)),
        ("bottom", (None, 0.0, None)),
        ("back", (None, None, 0.0)),
    ]
    held = tuple(Support(box.side(name), value) for name, value in rollers)
    places = np.random.default_rng(2).random((20, 3))
    pulled = Problem(box, law, held, (Traction(box.side("right"), (10.0, 0.0, 0.0)),))
    for lattice in ("cubic18", "cubic26"):
        answer = solve_springs(Case(pulled, lattice=lattice), 1 / 3)
        wanted = 1e-4 * places * [1, -0.25, -0.25]
        np.testing.assert_allclose(answer.at(places), wanted, atol=1e-14)
    sagging = Problem(
        box, law, (Support(box.side("left"), (0.0,) * 3),), (Weight((0.0, -9.81, 0.0)),)
    )
    elasticity = converge(sagging, places, 0.02, most_nodes=3000).displacement.value
    found = solve_springs(Case(sagging, points=places), 1 / 8).at(places)
    assert max_length(found - elasticity) < 0.05 * max_length(elasticity)


@table(
    ("lattice", "nu", "verdict"),
    [
        ("square", 0.3, "agrees"),
        ("square", 0.4999, "agrees"),
        ("triangular", 0.3, "agrees"),
        ("triangular", 0.4999, "not asked"),
    ],
)
def test_stress_is_the_springs_own(lattice, nu, verdict):
    # A strain fitted to displacements, times a tensor of 1e4 E, was 47 times elasticity's stress.
    box = Box((1.0, 1.73205080757) if lattice == "triangular" else (2.0, 1.0))
    held = (
        Support(box.side("bottom"), (0.0, 0.0)),
        Support(box.side("top"), (0.0, -0.01)),
    )
    case = Case(
        Problem(box, Isotropic(1e5, nu, "plane_strain"), held),
        lattice=lattice,
        cells=10,
        quantities=("point stress",),
        accuracy=0.01,
        band=0.1,
    )
    (row,) = compare_case(case).rows
    assert row.word == verdict
    if verdict == "agrees":
        assert row.found == pytest.approx(row.wanted, rel=0.05)


def read_vtu(folder, content):
    (folder / "fields.vtu").write_bytes(content)
    return meshio.read(folder / "fields.vtu")


@pytest.fixture(scope="module")
def run_beam():
    found, _, content = case_files(beam(cells=8))
    return found, content


def test_fields_are_those_of_the_tables(tmp_path, run_beam):
    found, content = run_beam
    springs = read_vtu(tmp_path, content["springs.vtu"])
    elements = read_vtu(tmp_path, content["elements.vtu"])
    lattice = found.springs[0].lattice
    np.testing.assert_array_equal(springs.points[:, :2], lattice.points)
    (lines,) = springs.cells
    assert lines.type == "line"
    np.testing.assert_array_equal(lines.data, lattice.springs)
    moved = springs.point_data["displacement"]
    np.testing.assert_array_equal(moved[:, :2], found.springs[0].rest.displacement)
    compared = read_vtu(tmp_path, content["compared.vtu"])
    np.testing.assert_array_equal(compared.points[:, :2], found.points)
    np.testing.assert_array_equal(compared.point_data["difference"], found.relative)
    assert elements.cells[0].type == "quad9"
    solution = found.reference.finest
    at = elements.point_data["displacement_elements"][:, :2]
    np.testing.assert_array_equal(at, solution.displacement)
    stress = solution.stress(solution.body.points.copy()[:9])
    names = ("stress_xx", "stress_yy", "stress_xy")
    at = np.column_stack([elements.point_data[name][:9] for name in names])
    np.testing.assert_allclose(at, stress, atol=1e-9 * np.abs(stress).max())
    assert set(elements.point_data) >= {*names, "stress_zz", "von_mises"}


@pytest.mark.parametrize(
    ("state", "size"), [("plane_stress", 1.0), ("plane_strain", 0.79**0.5), ("solid", 1.0)]
)
def test_stress_at_the_nodes_is_that_of_uniaxial_tension_and_pure_shear(tmp_path, state, size):
    """Von Mises stress: σ, in plane strain σ √(1 - ν + ν²); √3 τ."""
    nu, d = 0.3, 3 if state == "solid" else 2
    box, law = Box((2.0, 1.0, 0.5)[:d]), Isotropic(1e5, nu, state)
    free = [None] * d
    rollers = [
        Support(box.side(name), (*free[:a], 0.0, *free[a + 1 :]))
        for a, name in enumerate(("left", "bottom", "back")[:d])
    ]
    pull = Traction(box.side("right"), (100.0, 0.0, 0.0)[:d])
    sheared = tuple([lambda x: 0.01 * x[:, 1], 0.0, 0.0][:d])
    whole = [Support(box.side(name), sheared) for name in SIDES if SIDES[name][0] < d]
    problems = [Problem(box, law, tuple(rollers), (pull,)), Problem(box, law, tuple(whole), ())]
    for problem, part, stress, mises in zip(
        problems,
        ("stress_xx", "stress_xy"),
        (100.0, 0.01 * law.E / 2.6),
        (100.0 * size, 0.01 * law.E / 2.6 * 3**0.5),
        strict=True,
    ):
        body = box_discretisation(box, (2, 1, 1)[:d], "H2" if d == 3 else "Q2")
        made = files.stress_fields(solve_problem(problem, body), problem)
        content = files.vtu_bytes(body.points, {body.element.shape: body.cells}, made)
        read = read_vtu(tmp_path, content).point_data
        zero = {"stress_yy", "stress_yz", "stress_xz", "stress_xx", "stress_xy"} & set(read)
        np.testing.assert_allclose(read[part], stress)
        np.testing.assert_allclose(read["von_mises"], mises)
        for name in zero - {part}:
            np.testing.assert_allclose(read[name], 0.0, atol=1e-9 * stress)


def test_files_say_the_same(run_beam):
    found, content = run_beam
    verdict = json.loads(content["verdict.json"])
    assert {row["quantity"]: row["verdict"] for row in verdict["quantities"]} == {
        row.quantity: row.word for row in found.rows
    }
    first = verdict["quantities"][0]
    assert first["difference"] == found.rows[0].error
    page = content["case.html"].decode()
    assert 'src="http' not in page
    assert 'href="http' not in page
    assert "<script" not in page
    assert page.count("<figure>") == 4


def test_a_body_under_an_obstacle_is_compared_by_its_patch():
    disc = Obstacle("disc", (1.0, 1.0), (0.0, -1.0), 3.0)
    held = (Support(BEAM.side("bottom"), (0.0, 0.0)),)
    contact = (Contact(BEAM.side("top"), disc, force=1e3),)
    problem = Problem(BEAM, Isotropic(1e5, 1 / 3), held, name="pressed", contacts=contact)
    found, _, content = case_files(Case(problem, cells=20))
    rows = {row.quantity: row for row in found.rows}
    for name in ("displacement", "contact depth", "contact half-width", "largest pressure"):
        assert rows[name].word == "agrees"
        assert rows[name].error < 0.02 + rows[name].uncertainty
    assert rows["reactions"].word == "not asked"
    pressed = found.springs[0].contact.contacts[0]
    assert pressed.total == pytest.approx(1e3)
    table = tables(found)["contact"]
    assert table["force"].sum() == pytest.approx(pressed.force.sum())
    assert {"contact.csv", "pressure.svg", "springs.vtu"} <= set(content)
    assert b"contact_pressure" in content["springs.vtu"]
    cells = pressed.half_width / found.springs[0].spacing
    assert f"The patch has {cells:.2g} cells in its half-width".encode() in content["case.html"]


def test_springs_that_break_are_counted_drawn_and_told():
    held = (
        Support(BEAM.side("bottom"), (0.0, 0.0)),
        Support(BEAM.side("top"), (0.0, 0.005)),
    )
    problem = Problem(BEAM, Isotropic(1e5, 1 / 3), held, name="torn")
    case = Case(problem, cells=6, fracture=Fracture(0.01, raised=4.0))
    found, _, content = case_files(case)
    growth = found.springs[0].growth
    assert growth.ended == "parted"
    table = tables(found)["breaks"]
    assert list(table["spring"]) == list(growth.broken)
    assert {"breaks.csv", "breaks.svg", "springs.vtu"} <= set(content)
    assert b'Name="broken"' in content["springs.vtu"]
    assert f"{len(growth.broken)} springs have broken in".encode() in content["case.html"]
    assert b"The body has come apart" in content["case.html"]
    one = found.springs[0]
    asked = break_springs(Fracture(G_c=7.5), case, one)
    made = critical_stretch(patterns.square(), one.calibration, 7.5)
    assert not asked.breaks
    assert asked.critical_stretch == pytest.approx(made.critical_stretch)


def test_a_name_is_no_path_and_no_markup(tmp_path):
    text = (EXAMPLES / "box.toml").read_text(encoding="utf-8")
    text = text.replace('"cantilever"', '"../../x<script>alert(1)</script>"')
    text += "\n[springs]\ncells = 4\n[reference]\naccuracy = 0.05\n"
    path = tmp_path / "..x<b>.toml"
    path.write_text(text, encoding="utf-8")
    *_, content = case_files(read_case(path), plots=False)
    page = content["case.html"].decode()
    assert "<script" not in page
    assert "&lt;script&gt;" in page
    assert files.folder_name("../../x<script>") == "x-script"
    assert files.folder_name("...") == "case"


def program(folder, *words):
    """Run a command in this process, with the folder as the working directory."""
    out, err = io.StringIO(), io.StringIO()
    with chdir(folder), redirect_stdout(out), redirect_stderr(err):
        code = main(["case", *words])
    return SimpleNamespace(returncode=code, stdout=out.getvalue(), stderr=err.getvalue())


def test_the_commands(tmp_path):
    assert program(tmp_path, "new", "my").returncode == 0
    text = (tmp_path / "my.toml").read_text(encoding="utf-8")
    assert program(tmp_path, "new", "my").returncode == 2
    done = program(tmp_path, "run", "my.toml", "none.toml", "--out", "new", "--no-plots")
    assert done.returncode == 2
    assert "my: The springs are" in done.stdout
    assert "case 'none.toml': No such file" in done.stderr.splitlines()[-1]
    kept = (tmp_path / "new" / "my" / "verdict.json").read_bytes()
    # What is asked next has no answer: what was there stays.
    (tmp_path / "my.toml").write_text(text.replace("nu = 0.333", "nu = 0.9"), encoding="utf-8")
    assert program(tmp_path, "run", "my.toml", "--out", "new", "--no-plots").returncode == 2
    assert (tmp_path / "new" / "my" / "verdict.json").read_bytes() == kept
    (tmp_path / "new" / "my" / "mine.txt").write_text("kept", encoding="utf-8")
    (tmp_path / "my.toml").write_text(text, encoding="utf-8")
    done = program(tmp_path, "run", "my.toml", "--out", "new", "--no-plots")
    assert done.returncode == 2
    assert "'mine.txt', which no case left there" in done.stderr
    assert (tmp_path / "new" / "my" / "mine.txt").read_text(encoding="utf-8") == "kept"
    names = ("springs.vtu", "points.csv", "compared.csv")
    files = [tmp_path / "new" / "my" / name for name in names]
    judged = program(tmp_path, "judge", "my.toml", str(files[0]), "--out", "new", "--no-plots")
    assert judged.returncode == 0
    assert "springs.vtu: The field is uniformly 0.4 % too stiff." in judged.stdout
    field, *tables = (read_result(file, 2) for file in files)
    for table_field in tables:
        for name in ("points", "displacement"):
            values = getattr(field, name), getattr(table_field, name)
            np.testing.assert_allclose(*values, rtol=1e-9, atol=1e-12)
    assert json.loads(program(tmp_path, "schema").stdout)["$ref"]
    with pytest.raises(SystemExit, match="2"):
        program(tmp_path)


def test_a_new_case_is_not_written_through_a_link(tmp_path):
    (tmp_path / "k.toml").symlink_to("elsewhere.toml")
    done = program(tmp_path, "new", "k")
    assert done.returncode == 2
    assert "k.toml is there already" in done.stderr
    assert not (tmp_path / "elsewhere.toml").exists()


def test_a_name_that_is_too_long_is_no_fault_of_writing(tmp_path):
    done = program(tmp_path, "new", 300 * "a")
    assert done.returncode == 2
    assert "error: File name too long: " in done.stderr
    assert len(done.stderr) < 200


def test_an_even_pressure_is_drawn_by_arrows_of_one_length():
    case = beam(cells=4, accuracy=0.05, quantities=("displacement",))
    loads = (
        Traction(BEAM.side("top"), (0.0, -10.0)),
        Traction(BEAM.side("right"), (-5.0, 0.0)),
        Weight((0.0, -9.81)),
    )
    found = compare_case(replace(case, problem=replace(case.problem, loads=loads)))
    at, arrow = figures._arrows(found)
    size = np.linalg.norm(arrow, axis=1).round(12)
    assert sorted(set(size)) == [0.5, 1.0]
    assert (at[size == 0.5][:, 0] == 2.0).all()
    assert 4 < len(at) <= figures.MOST_ARROWS


def test_folders_of_others_are_left(tmp_path):
    (tmp_path / "a").write_text("", encoding="utf-8")
    with pytest.raises(ProblemError, match="which no case left there"):
        files.refuse_foreign(tmp_path, "a.toml")
    with pytest.raises(ProblemError, match="is a file"):
        files.refuse_foreign(tmp_path / "a", "a.toml")
    files.publish(tmp_path / "b", {"page": b""}, "b.toml")
    files.publish(tmp_path / "b", {"page": b"again"}, "b.toml")
    with pytest.raises(ProblemError, match=r"results of 'b\.toml'; name another folder"):
        files.publish(tmp_path / "b", {"page": b""}, "<b>.toml")


def test_regions_of_another_material_are_known_to_both_sides(tmp_path):
    case = read_case(EXAMPLES / "bimaterial.toml")
    found, _, content = case_files(case, plots=False)
    by = {row.quantity: row.word for row in found.rows}
    assert by["displacement"] == by["reaction"] == by["mean stress"] == "agrees"
    assert by["point stress"] == "not asked"
    head, _ = sentences(replace(found, differences=found.differences[-1:]))
    assert head == (
        "Nothing was compared: point stress, the body is of several materials, whose stresses jump "
        "between them."
    )
    elements = read_vtu(tmp_path, content["elements.vtu"])
    (material,) = elements.cell_data["material"]
    assert material.mean() == pytest.approx(0.5)
    assert "region 1" in content["case.html"].decode()


@pytest.mark.parametrize(("part", "agrees"), [(0.6, True), (0.4, False)])
def test_stress_has_twice_the_band_and_no_more(run_beam, part, agrees):
    case, stress = run_beam[0].case, run_beam[0].rows[-1]
    case = replace(case, band=part * stress.error, quantities=("point stress",))
    assert (compare_case(case).rows[0].word == "agrees") == agrees


@pytest.mark.parametrize(("start", "told"), [(1.0, False), (0.9, True)])
def test_regions_that_overlap_are_told(start, told):
    law = Isotropic(1e6, 0.3)
    zones = tuple(Zone(Region((span, None)), law) for span in ((0.0, 1.0), (start, 2.0)))
    case = beam(cells=10, accuracy=0.01, quantities=("displacement",))
    _, reasons = sentences(compare_case(replace(case, problem=replace(case.problem, zones=zones))))
    assert reasons[1].endswith("Region 2 overlaps region 1: the later one counts there.") == told


def test_a_foreign_field_of_a_softer_material():
    case = read_case(EXAMPLES / "bracket.toml")
    result = read_result(EXAMPLES / "softer.vtu", 2)
    found, _ = judged_files(case, result, unit=1e-3, plots=False)
    assert {each.name for each in found.verdict.causes} == {"load", "modulus", "thickness"}
    assert found.verdict.causes[0].value == pytest.approx(1.01, abs=1e-4)


@pytest.mark.parametrize(
    "name", ["box", "bracket", "ring", "bimaterial", "l_shape", "rubber", "plate"]
)
def test_every_example_is_known_well_enough(name):
    found = compare_case(read_case(EXAMPLES / f"{name}.toml"))
    assert found.reference.resolved
    assert found.rows[0].error < 0.06
    assert found.kind in {"coarse", "not told"}
    words = {row.word for row in found.rows} - {"not asked"}
    assert words - {"agrees"} == ({"not resolved"} if name in ("rubber", "plate") else set())
    assert found.limitations == ()


def test_every_column_of_every_table_is_explained(run_beam):
    made = tables(run_beam[0])
    shown = {each.name: each.columns for each in shown_tables(made)}
    assert all(column.meaning for columns in shown.values() for column in columns)
    told = [(c.name, c.meaning) for c in shown["lattices"]]
    assert ("springs", "of the lattice") in told


def test_pictures_of_meshes_name_sides_and_have_z_upwards():
    mesh = box_mesh("H1", (2, 1, 1))
    law = Isotropic(1e5, 0.25, "solid")
    held = (Support(mesh.side("left"), (0.0, 0.0, 0.0)),)
    pull = (Traction(mesh.side("right"), (0.0, 0.0, -10.0)),)
    found = compare_case(Case(Problem(mesh, law, held, pull), cells=2, accuracy=0.1))
    for figure in (
        figures.draw_fields(found),
        figures.draw_difference(found.points, found.relative, found.reference),
    ):
        axis = figure.axes[0]
        assert (axis.get_ylabel(), axis.get_zlabel()) == ("y (m)", "z (m)")
        low, high = axis.get_zlim()
        assert high - low < 2.0  # z is the shortest side, of 0.5 m
    labels = {text.get_text() for text in figures.draw_fields(found).axes[0].get_legend().texts}
    assert labels >= {"held: left", "load: right"}


def test_a_mean_stress_of_unknown_error_is_not_resolved():
    springs = SimpleNamespace(mean_stress=lambda _: np.array([1.0, 0.0, 0.0]))
    wanted = SimpleNamespace(value=np.array([2.0, 0.0, 0.0]), uncertainty=np.inf)
    reference = SimpleNamespace(mean_stress=wanted)
    (row,) = quantities._mean_stress(beam(), springs, reference)
    assert row.word == "not resolved"
    wanted.uncertainty = 3.0
    with pytest.raises(SolverError, match="known to 3"):
        quantities._mean_stress(beam(), springs, reference)
