"""Lattices of springs as simulators: the solid that each is, and planted mistakes named first."""

import json
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from msvalidate.case.judge.mistakes import factorise_network
from msvalidate.problem import Isotropic, ProblemError
from msvalidate.problem.records import replace
from msvalidate.simulators.exchange.asked import Asked
from msvalidate.simulators.exchange.folders import request_files
from msvalidate.simulators.exchange.protocol import Answer, CannotRepresent
from msvalidate.simulators.gate.gate import stretched_block
from msvalidate.simulators.verdict.advice import next_step
from msvalidate.simulators.verdict.judgement import judge_simulator
from msvalidate.simulators.verdict.lattice import declared_cells, judge_lattice, with_lattice
from msvalidate.simulators.verdict.record import record_of
from msvalidate.simulators.verdict.sheet import sheet_of
from msvalidate.springs.network import internal_force, spring_network
from msvalidate_check.text import percent
from tests.msvalidate.simulators import position_based
from tests.table import table
from tests.test_command_line import run

EXAMPLE = Path(__file__).parents[3] / "examples" / "spring_simulator.py"
PLATE = Isotropic(1e7, 1 / 3, "plane_stress", 1000.0, 0.2)
SOLID = Isotropic(1e7, 1 / 4, "solid", 1000.0)
FEW = {"steps": 700}


def example(old="", new=""):
    """The simulator of the example in this process, with a text of it changed."""
    text = EXAMPLE.read_text(encoding="utf-8")
    assert old in text
    names = {"__name__": "example"}
    exec(text.replace(old, new) if old else text, names)  # noqa: S102

    def simulate(request):
        arrays, about = names["simulate"](request)
        return Answer(**arrays, about=about)

    return simulate


def judged(simulator, cells="quad", material=PLATE, settings=FEW, **more):
    """Judgement, kind of the advice, and sheet."""
    asked = Asked(simulator)
    found = judge_lattice(asked, cells, material, settings, **more)
    return found, next_step(found, asked).kind, sheet_of(found, asked)


RETURN = "    return np.r_[sides, diagonals], np.repeat([k1 / 2, k2]"
ONCE = "    sides = np.unique(np.sort(sides), axis=0)\n"
STATE = "request.mass[:, None], 0.0"
MISTAKES = {
    "boundary weight": (RETURN, ONCE + RETURN.replace("k1 / 2", "k1")),
    "ratio of constants": ("3 / 8 * E", "3 / 2 * E"),
    "units": ("3 / 4 * E * thickness, 3 / 8 * E", "750 * E * thickness, 375 * E"),
    "total mass": (STATE, f"2 * {STATE}"),
    "masses": (STATE, "np.full((len(X), 1), request.mass.mean()), 0.0"),
    "damping": ('"damping", 1.0)', '"damping", 100.0)'),
    "damping in motion": (STATE, STATE.replace("0.0", "50.0")),
    "rest": ('settings.get("steps", 900)', "60"),
    "rest length": ("np.linalg.norm(X[b]", "1.01 * np.linalg.norm(X[b]"),
    "over density": ("law.E, law.thickness", "law.E / law.density, law.thickness"),
    "gravity sign": ("m * request.gravity", "-m * request.gravity"),
    "mechanism": ("3 / 8 * E", "0 * E"),
    "thickness": ("law.E, law.thickness", "law.E, 1.0"),
}
"""Cause -> text of the example, and what stands there with that mistake."""


@pytest.mark.parametrize("cause", MISTAKES)
def test_a_planted_mistake_is_named_first(cause):
    found, advice, sheet = judged(example(*MISTAKES[cause]))
    assert found.causes[0].kind == cause, sheet.causes
    assert advice == f"mend lattice {cause}" or cause == advice.split()[-1] == "rest"


@pytest.mark.parametrize(
    ("material", "spacing"),
    [(PLATE, 2**-4), (replace(PLATE, E=1e5), 0.37 / 8), (replace(PLATE, E=7e10), 2**-4)],
)
def test_the_example_agrees_with_its_solid(material, spacing):
    found, advice, sheet = judged(example(), material=material, spacing=spacing)
    assert (found.word, found.causes, advice) == ("agrees", (), "own body")
    assert pytest.approx(material.E, rel=1e-6) == found.lattice.mean.E
    assert sheet.agrees
    assert "nu 0.3333 and Zener ratio 1;" in sheet.tables[1].below[0]
    kept = json.loads(json.dumps(record_of(found)["lattice"]))
    assert kept["springs"]["weight"] == pytest.approx(0.5)
    assert [body["network"] < 1e-3 for body in kept["bodies"]] == [True, True]


def test_springs_unlike_along_the_axes_have_their_own_masses_and_loads():
    alike = "np.repeat([k1 / 2, k2], [len(sides), len(diagonals)])"
    unlike = "np.r_[np.tile([k1, k1 / 2], len(sides) // 2), np.full(len(diagonals), k2)]"
    found, _, sheet = judged(example(alike, unlike))
    assert found.lattice.springs.misfit > 0.01
    assert found.lattice.total == 1.0
    assert {body.factor for body in found.lattice.bodies} == {1.0}
    assert not any("total mass" in cause for cause in sheet.causes)


def test_constraints_with_few_iterations_need_more():
    found, advice, sheet = judged(position_based.simulate, settings={})
    assert [cause.kind for cause in found.causes][:1] == ["time step"]
    assert advice == "settle"
    assert "iterations=24" in sheet.next


@table(
    ("about", "cells"),
    [
        ({"cells": ["quad", "tetra"]}, ("quad", 2)),
        ({}, ("tetra", 3)),
        (None, ("tetra", 3)),
        ({"cells": ["points"], "dimension": 2}, ("points", 2)),
        ({"cells": ["points"]}, None),
        ({"cells": ["quads"]}, None),
    ],
)
def test_an_adapter_declares_its_cells_or_has_tetrahedra(about, cells):
    def simulate(request):
        if about is None:
            raise CannotRepresent(f"a {request.task}")
        return Answer(about=about)

    if cells is None:
        with pytest.raises(ProblemError, match="declared cells"):
            declared_cells(simulate)
    else:
        assert declared_cells(simulate) == cells


def test_the_example_runs_as_an_adapter(tmp_path):
    done = run("adapter", "check", str(EXAMPLE), "--only", "gate", "--out", ".", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("spring_simulator: passes the gate")
    kept = tmp_path / "spring_simulator-check-run" / "case"
    assert json.loads((kept / "request.json").read_text())["cells"] == "quad"


def test_the_example_names_the_shape_of_its_cells(tmp_path):
    body = str(EXAMPLE.with_name("box.toml"))
    done = run("simulate", body, "--with", str(EXAMPLE), "--cells", "2", cwd=tmp_path)
    assert done.returncode == 4
    assert "take --shape quad" in done.stderr + done.stdout


def test_points_alone_have_no_cells():
    points = replace(stretched_block(PLATE, {}, "quad"), points_only=True)
    files = request_files(points)
    assert {name for name in files if "." in name} == {"request.json", "points.csv", "nodal.csv"}
    assert json.loads(files["request.json"])["cells"] == "points"


# Programs of other kinds ------------------------------------------------------------------------


def static(springs_of):
    """Forces of springs between points, and their equilibrium by one solve."""

    def simulate(request):
        ends, k = springs_of(request)
        X = request.mesh.points
        network = spring_network(
            X,
            ends,
            k,
            mass=request.mass,
            fixed=request.held,
            displacement=np.where(request.held, request.value, 0.0),
            force=request.load,
        )
        about = {"simulator": "static", "version": "1", "law": "", "precision": "float64"}
        if request.task == "rest":
            u = factorise_network(network)(network)
            return Answer(displacement=u, about=about | {"at_rest": {"residual": 0.0}})
        if request.steps > 1:
            raise CannotRepresent("static")
        return Answer(force=internal_force(network, request.start), about=about)

    return simulate


def cubes(k2):
    """Springs of each cube, a quarter of an edge and half of a face's diagonal."""

    def springs_of(request):
        h = request.mesh.mean_edge
        corners = np.array(list(combinations(range(8), 2)))
        ends = request.mesh.cells[:, corners].reshape(-1, 2)
        d = np.diff(request.mesh.points[ends], axis=1)[:, 0]
        axes = (np.abs(d) > h / 2).sum(axis=1)
        k = request.material.E / 2.5 * h * np.array([0, 1 / 4, k2 / 2, 0])[axes]
        return ends[axes < 3], k[axes < 3]

    return springs_of


def edges(constant):
    """Springs along the edges of simplices, k = constant · E times thickness or spacing."""

    def springs_of(request):
        cells, law = request.mesh.cells, request.material
        pairs = np.array(list(combinations(range(cells.shape[1]), 2)))
        ends = np.unique(np.sort(cells[:, pairs].reshape(-1, 2)), axis=0)
        size = law.thickness if law.dim == 2 else request.mesh.mean_edge
        return ends, np.full(len(ends), constant * law.E * size)

    return springs_of


def neighbours(request):
    """Springs between all points nearer than 2.1 spacings, softer the longer they are."""
    assert request.points_only
    X = request.mesh.points
    distance = np.linalg.norm(X[:, None] - X[None], axis=2)
    h = distance[distance > 0].min()
    ends = np.argwhere(np.triu((distance > 0) & (distance < 2.1 * h)))
    return ends, request.material.E * request.material.thickness * h / distance[tuple(ends.T)]


def test_cubes_are_a_solid_and_a_wrong_ratio_of_constants_is_named():
    found, _, _ = judged(static(cubes(1.0)), "hexahedron", SOLID)
    assert (found.word, found.causes) == ("agrees", ())
    assert found.lattice.mean.nu == pytest.approx(1 / 4, abs=1e-6)
    found, advice, _ = judged(static(cubes(2.0)), "hexahedron", SOLID)
    assert advice == "mend lattice ratio of constants"
    assert found.lattice.mean.zener == pytest.approx(4 / 3, rel=1e-5)


def test_equal_springs_on_triangles_are_isotropic():
    found, advice, _ = judged(static(edges(3 / 4)), "triangle")
    # C11 = 3/2 k and C12 = k/2 make E = 4/3 k; boundary springs count whole.
    assert advice == "mend lattice boundary weight"
    assert (found.lattice.mean.E, found.lattice.springs.weight) == pytest.approx((1e7, 1.0), 1e-5)


def test_points_are_relaxed_where_a_uniform_strain_leaves_forces():
    found, _, _ = judged(static(neighbours), "points", parts=("probe",))
    # Of an endless lattice: k h² n⊗n over neighbours at 1, √2 and 2 spacings, k as 1/length.
    k = 1e7 * np.array([1 + 4 / 2, 2 / np.sqrt(2) / 2 * 2])
    C = found.lattice.C
    assert (C[0, 0], C[0, 1]) == pytest.approx((k[0] + k[1] / 2, k[1] / 2), rel=5e-3)
    assert found.lattice.steps.relaxed


def test_springs_on_tetrahedra_have_a_homogenised_solid():
    simulator = static(edges(1 / 3))
    found = judge_simulator(simulator, Isotropic(1e7, 0.3, "solid"), parts=("probe",))
    assert found.reading.E is None
    lattice = with_lattice(found, simulator, {}).lattice
    assert 0.2 < lattice.mean.nu < 0.3
    assert lattice.springs.misfit < 1e-5


def test_a_program_that_has_rest_alone_is_fitted():
    def rest(request):
        if request.task == "motion":
            raise CannotRepresent("no motion")
        return example("3 / 8 * E", "3 / 2 * E")(request)

    found, advice, _ = judged(rest)
    assert advice == "mend lattice ratio of constants"
    assert found.lattice.mean.zener == pytest.approx(4, rel=1e-2)


def random_neighbours(rng):
    """Springs between neighbours at three distances, and the tensor of an endless lattice."""
    law, k = PLATE, PLATE.E * rng.uniform(0.3, 1.0, 3)

    def springs_of(request):
        X = request.mesh.points
        distance = np.linalg.norm(X[:, None] - X[None], axis=2)
        distance /= distance[distance > 0].min()
        ends = np.argwhere(np.triu((distance > 0) & (distance < 2.1)))
        number = np.searchsorted((1.2, 1.7), distance[tuple(ends.T)])
        return ends, law.thickness * k[number]

    diagonal = k[0] + k[1] + 4 * k[2]
    return springs_of, np.array([[diagonal, k[1], 0], [k[1], diagonal, 0], [0, 0, k[1]]])


@pytest.mark.parametrize("seed", range(3))
def test_the_error_of_a_measured_tensor_covers(seed):
    springs_of, C = random_neighbours(np.random.default_rng(seed))
    found, _, sheet = judged(static(springs_of), "points", parts=("probe",))
    true = np.abs(found.lattice.C - C).max() / C.max()
    assert found.lattice.error == found.lattice.steps.error
    assert true <= found.lattice.error < 0.2
    assert f"its tensor known to {percent(found.lattice.error)}" in sheet.tables[0].below[0]
