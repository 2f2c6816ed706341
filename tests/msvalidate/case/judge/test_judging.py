"""Displacements from files: every seeded fault is named with its size, and nothing else is."""

from __future__ import annotations

import functools
import struct
import tracemalloc
import zlib
from dataclasses import replace

import meshio
import numpy as np
import pandas as pd
import pytest

from msvalidate.case.file.case import Case
from msvalidate.case.judge import judgement
from msvalidate.case.judge.judgement import budget, driven_by, judge_result
from msvalidate.case.judge.mistake_fields import Catalogue
from msvalidate.case.judge.own_network import judge_network, network_record
from msvalidate.case.judge.results import read_result
from msvalidate.case.report.page import judged_sentences
from msvalidate.cli.simulators import _result as simulated
from msvalidate.problem import (
    Box,
    Contact,
    Isotropic,
    Obstacle,
    Problem,
    ProblemError,
    SolverError,
    Support,
    Traction,
)
from msvalidate.simulators.exchange.export import export_case, on_mesh
from msvalidate.simulators.exchange.protocol import Answer
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.lattice import square
from msvalidate.springs.statics.equilibrium import equilibrium
from msvalidate_check.beside import Mistake
from reference_fem import box_discretisation, solve_problem
from tests.table import stored_rows, table

BEAM = Box((2.0, 1.0))
HELD = (Support(BEAM.side("left"), (0.0, 0.0)),)


@functools.cache
def problem(nu=0.3, load=-10.0):
    loads = (Traction(BEAM.side("right"), (0.5 * load, load)),)
    return Problem(BEAM, Isotropic(1e5, nu, "plane_strain"), HELD, loads, "beam")


PULLED = Problem(
    BEAM, Isotropic(1e5, 0.3, "plane_strain"), (*HELD, Support(BEAM.side("right"), (0.01, 0.002)))
)
MESH = box_discretisation(BEAM, (32, 16), "Q2")
X = MESH.points[np.random.default_rng(4).permutation(len(MESH.points))[:400]]


@functools.cache
def elastic(nu=0.3, pulled=False):
    return solve_problem(PULLED if pulled else problem(nu), MESH).at(X)


def elastic_in_plane_stress(nu=0.3):
    law = Isotropic(1e5, nu, "plane_stress")
    return solve_problem(replace(problem(), material=law), MESH).at(X)


@functools.cache
def case_of(target, accuracy):
    """Return the same case for a problem, so that its models are solved once."""
    return Case(target, accuracy=accuracy)


MODELS = {"converge_case": {}, "known_mistakes": {}, "answer_in_full": {}}
"""Models that depend on the case and the points alone, and their results."""


def shared(model, results):
    """Solve a model once for all fields of a case at the same points."""

    def solved(case, points, *rest):
        key = case, points.tobytes() if isinstance(points, np.ndarray) else id(points)
        if key not in results:
            results[key] = model(case, points, *rest)
        return results[key]

    return solved


@pytest.fixture(autouse=True)
def shared_models(monkeypatch):
    for name, results in MODELS.items():
        monkeypatch.setattr(judgement, name, shared(getattr(judgement, name), results))


def judged(tmp_path, points, move, asked=None, **options):
    path = tmp_path / "field.npz"
    np.savez(path, points=points, displacement=move, **options.pop("arrays", {}))
    case = case_of(asked or problem(), options.pop("accuracy", 2e-3))
    return judge_result(case, read_result(path, 2), **options)


def names(found):
    return [each.name for each in found.verdict.causes]


def one_moved(move):
    moved = move.copy()
    moved[17] += (0.3 * np.abs(move).max(), 0)
    return moved


def rigid(move):
    turn = np.column_stack([-X[:, 1], X[:, 0]])
    return move + 0.3 * np.abs(move).max() * (turn + 1)


RIVALS = {"not converged", "k alike", "k alike and whole boundary springs"}
"""Known mistakes that change this short beam almost by a factor, which follow the factors."""
FAULTS = [
    ("clean", lambda u: u, [], None),
    ("modulus 1 % lower", lambda u: 1.01 * u, ["load", "modulus", "thickness"], 1.01),
    ("inches", lambda u: u / 0.0254, ["load", "modulus", "thickness", "unit"], 1 / 0.0254),
    ("millimetres, 2 % too stiff", lambda u: 980 * u,
        ["load", "modulus", "thickness", "unit", "unit of k"], 1e3),
    ("rigid motion", rigid, ["rigid motion"], None),
    ("ratio .25 and modulus", lambda _: 1.2 * elastic(0.25), ["scale and ratio"], 0.25),
    ("plane stress", lambda _: elastic_in_plane_stress(), ["plane state"], None),
    ("x never written", lambda u: u * [0, 1], ["component"], None),
]  # fmt: skip


@table(("fault", "change", "causes", "value"), FAULTS)
def test_each_fault_is_named_with_its_size(tmp_path, fault, change, causes, value):
    close = 1e-3 if "ratio" in fault else 2e-3
    found = judged(tmp_path, X, change(elastic()), accuracy=close)
    own = [each for each in names(found) if each not in RIVALS]
    assert sorted(own) == causes, fault
    assert names(found)[: len(own)] == own
    if value is not None:
        assert found.verdict.causes[0].value == pytest.approx(value, rel=0.02)
    parts = budget(found).set_index("part")["value"]
    assert parts[["scale", "rigid motion", "shape"]].sum() == pytest.approx(parts["total"])


RUBBER = {
    "ratio 0": (lambda _: elastic(0.0), "ratio", 0.0),
    "plane stress": (lambda _: elastic_in_plane_stress(0.4999), "plane state", None),
    "ratio and unit": (lambda _: 1e3 * elastic(0.3), "unit and ratio", 0.3),
    "modulus": (lambda u: 1.3 * u, "modulus", 1.3),
    "x too small": (lambda u: u * [0.5, 1], "", None),
    "noise": (lambda u: u + 1e-4 * np.random.default_rng(2).normal(size=u.shape), "", None),
}


@pytest.mark.parametrize("fault", RUBBER)
def test_wrong_fields_of_rubber_are_judged_where_elements_exist(tmp_path, fault):
    """At ratios of 0, which trials meet, mixed elements have no pressure."""
    change, cause, value = RUBBER[fault]
    u = solve_problem(problem(0.4999), MESH, mixed=True).at(X)
    found = judged(tmp_path, X, change(u), problem(0.4999), accuracy=0.02)
    assert found.verdict.word == "differs"
    assert names(found)[:1] == ([cause] if cause else [])
    if value is not None:
        assert found.verdict.causes[0].value == pytest.approx(value, abs=0.03)


def test_simulate_names_the_linear_elements_of_the_mesh_it_asked_for():
    case = Case(problem(), accuracy=5e-3)
    request = export_case(case, cells=3, shape="triangle")
    move = on_mesh(request, replace(request.material, nu=0.3))
    found = judge_result(case, simulated(request, Answer(move)))
    assert found.verdict.word == "differs"
    assert names(found) == ["coarse mesh"]
    assert "linear elements on its triangle mesh" in found.verdict.causes[0].said
    move = on_mesh(request, replace(request.material, nu=0.1))
    other = judge_result(case, simulated(request, Answer(move)))
    assert names(other)[:1] == ["coarse mesh and ratio"]
    assert other.verdict.causes[0].value == pytest.approx(0.1, abs=1e-3)


def test_a_model_without_an_answer_is_recorded(tmp_path, monkeypatch):
    def fail():
        raise SolverError("no factor")

    catalogue = Catalogue((Mistake("coarse mesh", fail),), [])
    monkeypatch.setattr("msvalidate.case.judge.judgement.known_mistakes", lambda *_: catalogue)
    found = judged(tmp_path, X, 1.2 * elastic())
    assert "modulus" in names(found)
    assert "known mistakes are not compared: no factor." in " ".join(judged_sentences(found)[1])


def test_exchanged_axes_of_a_slender_cantilever_end_in_a_verdict(tmp_path):
    """The best factor of such a field is 0."""
    beam = Box((10.0, 1.0))
    held, pull = (
        Support(beam.side("left"), (0.0, 0.0)),
        Traction(beam.side("right"), (0.0, -1.0)),
    )
    slender = Problem(beam, Isotropic(1e6, 0.3, "plane_stress"), (held,), (pull,))
    mesh = box_discretisation(beam, (40, 4), "Q2")
    move = solve_problem(slender, mesh).displacement[:, ::-1]
    assert judged(tmp_path, mesh.points, move, slender).verdict.word == "differs"


def test_no_modulus_shows_where_supports_alone_move_the_body(tmp_path):
    found = judged(tmp_path, X, 1.1 * elastic(pulled=True), PULLED)
    assert names(found)[:1] == ["scale"]
    assert "No modulus shows" in found.verdict.causes[0].said


def test_the_depth_of_an_obstacle_moves_a_body_as_supports_do():
    disc = Obstacle("disc", (1.0, 1.0), (0.0, -1.0), 0.5)
    by_depth, by_force = (
        replace(PULLED, supports=HELD, contacts=(Contact(BEAM.side("top"), disc, *pressed),))
        for pressed in ((0.01, None), (0.0, 5.0))
    )
    assert (driven_by(by_depth), driven_by(by_force)) == ("supports", "loads")


@pytest.mark.parametrize(
    ("numbers_per_metre", "unit"), [(1e6, "micrometres"), (1.0, "metres"), (1 / 0.0254, "inches")]
)
def test_a_unit_is_named_relative_to_that_of_the_file(tmp_path, numbers_per_metre, unit):
    found = judged(tmp_path, 1e3 * X, numbers_per_metre * elastic(), unit=1e-3)
    assert found.verdict.causes[0].kind == "unit" or "unit" in names(found)
    assert unit in found.verdict.causes[0].said


def test_one_place_with_two_displacements_leaves_the_verdict_open(tmp_path):
    move = elastic()
    found = judged(tmp_path, np.r_[X, X[-1:]], np.r_[move, 3 * move[-1:]])
    assert found.verdict.word == "not resolved"
    assert any("differ by up to" in note for note in found.matched.notes)
    with pytest.raises(ProblemError, match="points in the body"):
        judged(tmp_path, np.r_[X, 50 + X, 90 + X], np.tile(move, (3, 1)))


def test_what_is_not_at_rest(tmp_path):
    slow = 0.94 * elastic()
    known = judged(tmp_path, X, slow, arrays={"at_rest": 0.07})
    assert known.verdict.word == "not at rest"
    assert names(known)[0] == "rest"
    stated = judged(tmp_path, X, slow, residual_motion=0.07)
    assert stated.verdict.word == "not at rest"
    unknown = judged(tmp_path, X, slow)
    assert unknown.verdict.word == "differs"
    assert np.isnan(unknown.displacement.residual_motion)
    rest = [budget(each).set_index("part")["value"]["rest"] for each in (stated, unknown)]
    np.testing.assert_array_equal(rest, [0.0, np.nan])


def test_points_in_any_order_outside_doubled_and_in_a_unit(tmp_path):
    places = np.concatenate([X, [[5.0, 5.0]], X[:1], X[1:2] - [0, 1e-12]])
    move = np.concatenate([elastic(), [[0, 0]], elastic()[:2]])
    found = judged(tmp_path, 1e3 * places, 1e3 * move, unit=1e-3)
    assert found.verdict.word == "agrees"
    assert len(found.matched.places) == len(X)
    np.testing.assert_allclose(found.matched.outside, [[5, 5]])
    assert len(found.matched.doubled) == 2
    notes = " ".join(found.matched.notes)
    assert "1 of 401 points lie outside" in notes
    assert "2 places stand in the file more than once" in notes
    with pytest.raises(ProblemError, match="are they in mm"):
        judged(tmp_path, 1e3 * X, 1e3 * elastic())
    with pytest.raises(ProblemError, match="axes in another order"):
        judged(tmp_path, X[:, ::-1] + [0, 3.0], elastic())


def test_a_place_repeated_often_takes_no_more_memory_than_its_points(tmp_path):
    rng = np.random.default_rng(7)
    often = np.repeat(X[:1], 20_000, axis=0) + 1e-13 * rng.normal(size=(20_000, 2))
    move = np.concatenate([elastic(), elastic()[:1].repeat(20_000, axis=0)])
    judged(tmp_path, X, elastic())  # what is imported at first use does not count
    tracemalloc.start()
    judged(tmp_path, X, elastic())
    alone = tracemalloc.get_traced_memory()[1]
    tracemalloc.reset_peak()
    found = judged(tmp_path, np.concatenate([X, often]), move)
    more = tracemalloc.get_traced_memory()[1] - alone
    tracemalloc.stop()
    assert len(found.matched.places) == len(X)
    assert len(found.matched.doubled) == 20_000
    assert more < 5e7  # 2 kB a point; all pairs would be 3e9 bytes


def test_numbers_of_the_cases_points(tmp_path):
    at = np.array([[2.0, 0.0], [2.0, 1.0], [1.0, 0.5]])
    case = Case(problem(), points=at)
    move = solve_problem(problem(), MESH).at(at)
    path = tmp_path / "few.csv"
    pd.DataFrame({"id": [2, 0], "ux": move[[2, 0], 0], "uy": move[[2, 0], 1]}).to_csv(
        path, index=False
    )
    found = judge_result(case, read_result(path, 2))
    assert found.verdict.word == "agrees"
    np.testing.assert_array_equal(found.matched.missing, at[1:2])
    pd.DataFrame({"id": [3], "ux": [0.0], "uy": [0.0]}).to_csv(path, index=False)
    with pytest.raises(ProblemError, match="the case has points 0 to 2"):
        judge_result(case, read_result(path, 2))


def test_formats_hold_the_same(tmp_path):
    move = elastic()
    pd.DataFrame(np.c_[X, move], columns=["x", "y", "ux", "uy"]).to_csv(
        tmp_path / "a.csv", index=False
    )
    np.savez(tmp_path / "a.npz", x=X, u=move)
    fields = {"displacement": np.c_[move, 0 * move[:, :1]], "force": np.ones((len(X), 3))}
    vertices = [("vertex", np.arange(len(X))[:, None])]
    meshio.Mesh(np.c_[X, 0 * X[:, :1]], vertices, point_data=fields).write(tmp_path / "a.vtu")
    for name in ("a.csv", "a.npz", "a.vtu"):
        found = read_result(tmp_path / name, 2)
        np.testing.assert_allclose(found.points, X, rtol=1e-12)
        np.testing.assert_allclose(found.displacement, move, rtol=1e-12)
    other = read_result(tmp_path / "a.vtu", 2 + 1, "force")
    assert (other.displacement == 1).all()


@table(
    ("name", "content", "said"),
    stored_rows("result_files"),
)
def test_bad_results_are_told_in_one_line(tmp_path, name, content, said):
    path = tmp_path / name
    path.write_bytes(content.encode("latin-1"))
    with pytest.raises(ProblemError) as told:
        read_result(path, 2)
    assert str(told.value).startswith(f"result '{name}'")
    assert said in str(told.value)
    assert "\n" not in str(told.value)


def test_arrays_that_are_none(tmp_path):
    for arrays, said in (
        ({"displacement": np.array([{"a": 1}], dtype=object)}, "no .npz of plain arrays"),
        ({"displacement": np.array(["a"])}, "give numbers"),
        ({"displacement": np.zeros((3, 2)), "points": np.zeros((2, 2))}, "points: shape"),
        ({"displacement": np.zeros((3, 4)), "points": np.zeros((3, 2))}, "displacement: shape"),
        ({"displacement": np.full((3, 2), np.nan), "points": np.zeros((3, 2))}, "nan along x"),
        ({"velocity": np.zeros((3, 2))}, "no displacement: it holds 'velocity'"),
        ({"displacement": np.zeros((1, 2)), "id": [0], "at_rest": -1.0}, "at_rest"),
    ):
        np.savez(tmp_path / "a.npz", **arrays)
        with pytest.raises(ProblemError, match=said):
            read_result(tmp_path / "a.npz", 2)


def blocks(values, size):
    """An array in blocks as VTK packs them: their number and sizes, then each by zlib."""
    data = values.tobytes()
    packed = [zlib.compress(data[k : k + size]) for k in range(0, len(data), size)]
    head = (len(packed), size, 0, *map(len, packed))
    return struct.pack(f"<{len(head)}I", *head) + b"".join(packed)


def appended(path, points, move, size):
    """A .vtu of triangles with its arrays behind all tags, as ParaView writes them by default."""
    cells = np.arange(3)
    ends, kind = np.array([3]), np.array([5], dtype=np.uint8)
    arrays = {"Points": points, "displacement": move, "connectivity": cells, "offsets": ends}
    tags, content = {}, b""
    for name, values in (arrays | {"types": kind}).items():
        type_ = {"f": "Float64", "i": "Int64", "u": "UInt8"}[values.dtype.kind]
        tags[name] = (
            f'<DataArray type="{type_}" Name="{name}" format="appended" offset="{len(content)}"'
            f' NumberOfComponents="{values.shape[1] if values.ndim == 2 else 1}"/>'
        )
        content += blocks(values, size)
    topology = "".join(tags[name] for name in ("connectivity", "offsets", "types"))
    head = (
        '<VTKFile type="UnstructuredGrid" byte_order="LittleEndian" header_type="UInt32"'
        ' compressor="vtkZLibDataCompressor"><UnstructuredGrid>'
        f'<Piece NumberOfPoints="{len(points)}" NumberOfCells="1"><Points>{tags["Points"]}</Points>'
        f"<Cells>{topology}</Cells><PointData>{tags['displacement']}</PointData></Piece>"
        '</UnstructuredGrid><AppendedData encoding="raw">_'
    )
    path.write_bytes(head.encode() + content + b"\n</AppendedData></VTKFile>")


def test_blocks_are_read_and_refused_before_they_take_memory_or_time(tmp_path):
    path, x = tmp_path / "a.vtu", np.c_[X[:3], np.zeros(3)]
    u = 1e-3 * np.cos(x) * [1, 1, 0]
    appended(path, x, u, 7)
    found = read_result(path, 2)
    assert np.array_equal(found.points, x[:, :2])
    assert np.array_equal(found.displacement, u[:, :2])
    appended(path, np.zeros((5_000_000, 3)), u, 1_000_000)
    assert path.stat().st_size < 200_000
    tracemalloc.start()
    with pytest.raises(ProblemError, match=r"more than 1e\+08 bytes when unpacked"):
        read_result(path, 2)
    assert tracemalloc.get_traced_memory()[1] < 6e8
    tracemalloc.stop()
    np.savez_compressed(tmp_path / "a.npz", displacement=np.zeros((10_000_000, 2)))
    tracemalloc.start()
    with pytest.raises(ProblemError, match=r"1\.6e\+08 bytes when unpacked; the most is"):
        read_result(tmp_path / "a.npz", 2)
    assert tracemalloc.get_traced_memory()[1] < 1e7
    tracemalloc.stop()


@pytest.mark.parametrize(
    ("stiffer", "factor", "columns", "kinds"),
    [
        (1.0, 1.0, True, ["equilibrium", "same solid"]),
        (1.0, 0.8, True, ["not equilibrium", "same solid"]),
        (1.5, 1.0, True, ["equilibrium", "another solid"]),
        (1.5, 1.0, False, ["no equilibrium", "another solid"]),
    ],
)
def test_a_network_is_distinguished_from_its_solver(tmp_path, stiffer, factor, columns, kinds):
    asked = replace(problem(), material=Isotropic(1e5, 1 / 3))
    network = lattice_network(asked, square(BEAM, (16, 8)))
    network = replace(network, stiffness=stiffer * network.stiffness)
    named = {"": network.points}
    if columns:
        named |= {"held_": network.fixed.astype(int), "force_": network.force}
    axes = {f"{name}{a}": each[:, i] for name, each in named.items() for i, a in enumerate("xy")}
    pd.DataFrame(axes).to_csv(tmp_path / "points.csv")
    ends = dict(zip("ij", network.springs.T, strict=True)) | {"stiffness": network.stiffness}
    pd.DataFrame(ends).to_csv(tmp_path / "springs.csv")
    found = judged(tmp_path, network.points, factor * equilibrium(network).displacement, asked)
    own = judge_network(found, tmp_path)
    assert list(own.kinds) == ["identified", *kinds]
    assert own.solid_difference == pytest.approx(1 - 1 / stiffer, abs=1e-6)
    record = network_record(own)
    assert f"E = {1e5 * stiffer:g} N/m" in " ".join(record["sentences"])
