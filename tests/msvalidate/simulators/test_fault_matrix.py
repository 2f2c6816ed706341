"""Matrix of simulators with one known fault: the true cause is reported, and no wrong remedy."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from msvalidate.problem import Isotropic
from msvalidate.simulators.bodies.tetrahedra import of_law
from msvalidate.simulators.exchange.asked import Asked
from msvalidate.simulators.exchange.protocol import Answer, CannotRepresent
from msvalidate.simulators.verdict.judgement import judge_simulator
from msvalidate.simulators.verdict.sheet import sheet_of
from msvalidate.springs.constants.stiffness import CAUCHY, central_modulus
from msvalidate.springs.lattice import mesh_lattice
from msvalidate.springs.network import spring_network
from msvalidate.springs.statics.equilibrium import equilibrium
from studies.simulators.synthetic import synthetic_faults
from tests.test_command_line import run

HARD = Isotropic(1e7, CAUCHY[3], "solid", 1000.0)
SOFT = Isotropic(2e4, 0.1, "solid", 37.0)
LONGER, DAMPING, HAND_ON, SHORTER = "run it longer", "damping off", "hand on E", "shorter"
clean = of_law("linear")
springs = synthetic_faults()["k = E h on each edge"].simulate


def stiffer(base, times):
    return lambda request: base(
        replace(request, material=replace(request.material, E=times * request.material.E))
    )


def scaled(base, times, field):
    """Requests of which one array is in another unit."""
    return lambda request: base(replace(request, **{field: times * getattr(request, field)}))


def answers_in(times, *fields):
    def simulate(request):
        answer = clean(request)
        known = {name: getattr(answer, name) for name in fields}
        return replace(answer, **{n: times * x for n, x in known.items() if x is not None})

    return simulate


def damped(request):
    answer = clean(request)
    return answer if answer.velocity is None else replace(answer, velocity=0.9 * answer.velocity)


def changed(names, factor, at_rest, forces_at="start", base=clean):
    """Rest with a factor of dt, iterations, steps and E; `names` are those of its settings."""

    def simulate(request):
        answer = base(request)
        own = {"dt": 0.01, "iterations": 10, "steps": 200} | dict(request.settings)
        about = dict(answer.about) | {"forces_at": forces_at}
        about["settings"] = {name: [own[name], ""] for name in names}
        if answer.displacement is None:
            return replace(answer, about=about)
        times = factor(own, request.material.E / simulate.E)
        about["at_rest"] = at_rest(own, float(np.abs(answer.displacement).max()))
        return replace(answer, displacement=times * answer.displacement, about=about)

    return simulate


def constraints(names, residual=False):
    """Few iterations in a step leave the body soft, whatever its modulus and length of run."""

    def stated(_, size):
        return {"residual": 1e9} if residual else {"change_when_twice_as_long": 0 * size}

    return changed(names, lambda o, E: 1 + 500 * E * o["dt"] / o["iterations"], stated, "end")


def settling(names):
    """Few iterations in a step, and a run whose length leaves a little as well."""

    def soft(settings, E):
        return (1 + 500 * E * settings["dt"] / settings["iterations"]) * (
            1 - np.exp(-settings["steps"] / 20)
        )

    return changed(names, soft, lambda *_: {"change_when_twice_as_long": 0.0}, "end")


def unfinished(names, told=True, base=clean):
    """Runs that stop before they are at rest; half the step is half the time."""

    def left(own, times=1):
        return np.exp(-times * own["steps"] * own["dt"])

    def stated(own, size):
        return {"change_when_twice_as_long": 3 * size * (left(own) - left(own, 2))} if told else {}

    return changed(names, lambda own, _: 1 - left(own), stated, base=base)


GIVEN = "give lengths"
FAULTS = {
    "springs, k × 1000": (stiffer(springs, 1e3), "units", {DAMPING, HAND_ON, LONGER}),
    "springs, k × 0.001": (stiffer(springs, 1e-3), "units", {DAMPING, HAND_ON, LONGER}),
    "springs, k × 1e6": (stiffer(springs, 1e6), "units", {DAMPING, HAND_ON, LONGER}),
    "springs, masses in grams": (scaled(springs, 1e3, "mass"), "units", {DAMPING, LONGER}),
    "springs, masses in tonnes": (scaled(springs, 1e-3, "mass"), "units", {DAMPING, LONGER}),
    "springs, gravity in mm/s²": (scaled(springs, 1e3, "gravity"), "units", {DAMPING, LONGER}),
    "springs, forces in kN": (scaled(springs, 1e-3, "force"), "units", {DAMPING, LONGER}),
    "E in kPa": (stiffer(clean, 1e-3), "units", {DAMPING, HAND_ON, LONGER}),
    "E × 1000": (stiffer(clean, 1e3), "units", {DAMPING, HAND_ON, LONGER}),
    "rest in mm": (answers_in(1e3, "displacement"), "units", {DAMPING, HAND_ON, LONGER}),
    "all in mm": (
        answers_in(1e3, "displacement", "position", "velocity"), "units", {DAMPING, LONGER},
    ),
    "damping left on": (damped, "gate", {LONGER, GIVEN}),
    "constraints": (constraints(("dt", "iterations")), "time step", {LONGER, HAND_ON, GIVEN}),
    "constraints, residual": (
        constraints(("dt", "iterations"), residual=True), "time step", {LONGER, HAND_ON, GIVEN},
    ),
    "constraints, dt": (constraints(("dt",)), "time step", {LONGER, HAND_ON, GIVEN}),
    "constraints, unnamed": (constraints(()), "time step", {LONGER, HAND_ON, GIVEN}),
    "constraints, iterations": (
        constraints(("iterations",), residual=True), "time step", {LONGER, HAND_ON},
    ),
    "constraints, settling": (
        settling(("dt", "iterations", "steps")), "time step", {LONGER, "steps=", HAND_ON, GIVEN},
    ),
    "short run, k × 0.001": (
        unfinished(("dt", "steps"), base=stiffer(springs, 1e-3)), "units",
        {LONGER, SHORTER, "steps=", "dt=", DAMPING, HAND_ON},
    ),
    "short run, steps": (unfinished(("steps",)), "rest", {SHORTER, DAMPING, HAND_ON}),
    "short run, both": (unfinished(("dt", "steps")), "rest", {SHORTER, "dt=", HAND_ON}),
    "short run, untold": (unfinished(("dt", "steps"), told=False), "rest", {SHORTER, "dt="}),
    "short run, dt": (unfinished(("dt",)), "rest", {DAMPING, HAND_ON}),
    "state survives": (
        synthetic_faults()["state survives"].simulate, "gate", {HAND_ON, LONGER, SHORTER},
    ),
}  # fmt: skip
"""Fault -> the simulator, the kind of the true cause, and remedies that would be wrong."""
REMEDIES = {"rest": ("longer", "steps="), "time step": ("step", "dt="), "units": ("k in N/m",)}


@pytest.mark.parametrize("material", [HARD, SOFT], ids=["hard", "soft"])
@pytest.mark.parametrize("fault", FAULTS)
def test_the_true_cause_is_reported_and_no_wrong_remedy(fault, material):
    simulate, kind, forbidden = FAULTS[fault]
    simulate.E = material.E
    asked = Asked(simulate)
    found = judge_simulator(asked, material, parts=("gate",))
    sheet = sheet_of(found, asked, ("gate",))
    kinds = [cause.kind for cause in found.causes]
    assert kind in kinds, sheet.lines(fault)
    assert not [each for each in forbidden if each in sheet.next], sheet.next
    assert any(each in sheet.next for each in REMEDIES.get(kind, ("",))), sheet.next
    if kind == "units" and "rest in" not in fault:
        assert sheet.word.startswith("units?")
    if kind in {"rest", "time step"}:
        assert kinds[0] in {"rest", "time step"}
        assert sheet.word.startswith("not converged")
        assert sheet.causes[0].startswith("solver: not converged")


# Known mistakes, by bodies at rest ----------------------------------------------------------------


def at_rest(displacement_of):
    def simulate(request):
        if request.task == "motion":
            raise CannotRepresent("no motion")
        about = {"simulator": "static", "precision": "float64", "at_rest": {"residual": 0.0}}
        return Answer(displacement=displacement_of(request), about=about)

    return simulate


def on_edges(times=None, mass=lambda m: m):
    """Springs on the edges of the mesh, all of `times` E h, or with the right constants."""

    def solve(request):
        points, law = request.mesh.points, replace(request.material, nu=CAUCHY[3])
        edges = mesh_lattice(request.mesh, "area", positive=True)
        k = central_modulus(law, 3, "springs") * edges.factor
        if times is not None:
            length = np.linalg.norm(np.diff(points[edges.springs], axis=1)[:, 0], axis=1)
            k = np.full(len(k), times * law.E * length.mean())
        force = request.force + np.outer(mass(request.mass), request.gravity)
        fixed = {"fixed": request.held, "displacement": request.value}
        network = spring_network(points, edges.springs, k, mass=request.mass, force=force, **fixed)
        return equilibrium(network).displacement

    return at_rest(solve)


def elements(change):
    return at_rest(lambda request: clean(change(request)).displacement)


def equal(mass):
    return np.full(len(mass), mass.mean())


MISTAKES = {
    "one k, 3 E h": (on_edges(3.0), {"k alike"}),
    "springs, equal masses": (on_edges(mass=equal), {"coarse springs", "equal masses"}),
    "springs, doubled masses": (on_edges(mass=lambda m: 2 * m), {"doubled mass"}),
    "elements, equal masses": (
        elements(lambda r: replace(r, mass=equal(r.mass))), {"equal masses"},
    ),
    "elements, doubled masses": (
        elements(lambda r: replace(r, mass=2 * r.mass)), {"modulus", "load"},
    ),
    "elements, E / 2": (
        elements(lambda r: replace(r, material=replace(r.material, E=r.material.E / 2))), {"law"},
    ),
}  # fmt: skip


@pytest.mark.parametrize("material", [HARD, Isotropic(3e4, 0.4, "solid", 50.0)])
@pytest.mark.parametrize("name", MISTAKES)
def test_a_known_mistake_is_among_the_causes_and_a_factor_has_rivals(name, material):
    simulate, true = MISTAKES[name]
    asked = Asked(simulate)
    found = judge_simulator(asked, material, meshes=("tet4",), parts=("bodies",))
    text = "\n".join(sheet_of(found, asked, ("bodies",)).causes)
    assert true <= {cause.kind for cause in found.causes}, text
    assert ("modulus" in text or "law: E" in text) <= ("loads" in text or "masses" in text), text


STEPPED = """
import csv, json, sys
case, out = sys.argv[1:]
dt = json.load(open(case + "/request.json"))["settings"].get("dt", 0.1)
with open(case + "/points.csv") as points, open(out + "/result.csv", "w") as file:
    rows = [[1e-3 * (1 + dt) * float(x) for x in row[1:]] for row in [*csv.reader(points)][1:]]
    csv.writer(file).writerows([["ux", "uy"], *rows])
about = dict(simulator="stepped", version="1", law="", precision="float64", forces_at="end")
about |= dict(settings={"dt": [dt, "s"]}, at_rest={"change_when_twice_as_long": 0})
json.dump(about, open(out + "/result.json", "w"))
"""


def test_simulate_reports_a_dependence_on_the_time_step_first(tmp_path):
    (tmp_path / "stepped.py").write_text(STEPPED, encoding="utf-8")
    shutil.copy(Path(__file__).parents[3] / "examples" / "box.toml", tmp_path)
    words = ("simulate", "box.toml", "--with", "stepped.py", "--cells", "2", "--no-plots")
    done = run(*words, cwd=tmp_path)
    head, first, *_ = done.stdout.splitlines()
    assert head.startswith("stepped: ")
    assert first.startswith("solver: not converged: 4.5 % of a displacement changes")
    assert "run longer" not in done.stdout
    (page,) = tmp_path.glob("reports/simulators/box-stepped/case.html")
    assert "changes with the time step" in page.read_text(encoding="utf-8")
