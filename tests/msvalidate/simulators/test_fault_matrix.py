"""Matrix of simulators with one known fault: the true cause is reported, and no wrong remedy."""

from __future__ import annotations

import shutil
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from msvalidate.problem import Isotropic
from msvalidate.simulators.bodies.tetrahedra import of_law, tetrahedra_of
from msvalidate.simulators.exchange.asked import Asked
from msvalidate.simulators.exchange.protocol import Answer
from msvalidate.simulators.verdict.judgement import judge_simulator
from msvalidate.simulators.verdict.sheet import sheet_of
from reference_fem.elasticity import stiffness
from studies.simulators.synthetic import synthetic_faults
from tests.test_command_line import run

MATERIAL = Isotropic(1e7, 0.3, "solid", 1000.0)
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


def answers_in(base, times, *fields):
    def simulate(request):
        answer = base(request)
        known = {name: getattr(answer, name) for name in fields}
        return replace(answer, **{n: times * x for n, x in known.items() if x is not None})

    return simulate


def damped(request):
    answer = clean(request)
    return answer if answer.velocity is None else replace(answer, velocity=0.9 * answer.velocity)


@cache
def matrix_of(mesh, E, nu):
    K = stiffness(tetrahedra_of(mesh), Isotropic(E, nu, "solid")).toarray()
    n = len(mesh.points)
    return K.reshape(3, n, 3, n).transpose(1, 0, 3, 2).reshape(3 * n, 3 * n)


class Constraints:
    """Implicit steps, each solved by a few Gauss-Seidel iterations from the free motion.

    A block at rest is the fixed point of such steps, with velocities set to zero after each. It
    depends on the time step and on the iterations, and no longer run changes it.
    """

    def __init__(self, names=("dt", "iterations"), states="change", iterations=5, dt=5e-3):
        self.names, self.states, self.iterations, self.dt = names, states, iterations, dt

    def __call__(self, request):
        rest, own = request.task == "rest", request.settings
        dt = float(own.get("dt", self.dt)) if rest else request.dt
        count = int(own.get("iterations", self.iterations))
        settings = {"dt": [dt, "s"], "iterations": [count, ""]}
        about = {
            "simulator": "constraints", "precision": "float64", "mass": "lumped",
            "forces_at": "end", "settings": {name: settings[name] for name in self.names},
        }  # fmt: skip
        free = ~request.held.ravel() | (not rest)
        K = matrix_of(request.mesh, request.material.E, request.material.nu)[np.ix_(free, free)]
        mass = np.repeat(request.mass, 3)[free]
        A = np.diag(mass / dt**2) + K
        error = np.linalg.matrix_power(np.eye(len(A)) - np.linalg.solve(np.tril(A), A), count)
        inverse = np.linalg.inv(A)
        if not rest:
            return self.motion(request, dt, (mass, inverse, error), about)
        force = request.load.ravel()[free]
        way = (inverse - error @ inverse) * (mass / dt**2) + error
        moved = (inverse - error @ inverse) @ force + error @ (force * dt**2 / mass)
        u = np.zeros(free.size)
        u[free] = np.linalg.solve(np.eye(len(A)) - way, moved)
        left = float(np.abs(force - K @ u[free]).max())
        stated = {"change": {"change_when_twice_as_long": 0.0}, "residual": {"residual": left}}
        about["at_rest"] = stated[self.states]
        return Answer(displacement=u.reshape(-1, 3), about=about)

    def motion(self, request, dt, step, about):
        mass, inverse, error = step
        X = request.mesh.points.ravel()
        weight = np.tile(request.gravity, len(request.mass))
        u, v = request.start.ravel() - X, np.zeros(X.size)
        for _ in range(request.steps):
            free = u + dt * v + dt**2 * weight
            solved = inverse @ (mass / dt**2 * free)
            new = solved + error @ (free - solved)
            u, v = new, (new - u) / dt
        return Answer(position=(X + u).reshape(-1, 3), velocity=v.reshape(-1, 3), about=about)


def unfinished(names, tell=True):
    """Runs that stop before they are at rest; half the step is half the time."""

    def simulate(request):
        answer = clean(request)
        if answer.displacement is None:
            return answer
        dt, steps = (float(request.settings.get(k, x)) for k, x in (("dt", 0.01), ("steps", 200)))
        decay, size = 0.02 * steps * dt / 0.01, float(np.abs(answer.displacement).max())
        settings = {"dt": [dt, "s"], "steps": [int(steps), ""]}
        about = dict(answer.about) | {"settings": {name: settings[name] for name in names}}
        change = 3 * size * (np.exp(-decay) - np.exp(-2 * decay))
        about["at_rest"] = {"change_when_twice_as_long": change} if tell else {}
        return replace(answer, displacement=(1 - np.exp(-decay)) * answer.displacement, about=about)

    return simulate


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
    "displacements in mm": (
        answers_in(clean, 1e3, "displacement"), "units", {DAMPING, HAND_ON, LONGER},
    ),
    "positions in mm": (
        answers_in(clean, 1e3, "displacement", "position", "velocity"), "units",
        {DAMPING, HAND_ON, LONGER},
    ),
    "damping left on": (damped, "gate", {LONGER, "give lengths"}),
    "constraints": (Constraints(), "time step", {LONGER, DAMPING, HAND_ON}),
    "constraints, residual": (Constraints(states="residual"), "time step", {LONGER, HAND_ON}),
    "constraints, unnamed": (Constraints(()), "time step", {LONGER, HAND_ON}),
    "constraints, iterations alone": (
        Constraints(("iterations",), "residual"), "time step", {LONGER, HAND_ON},
    ),
    "constraints, long steps": (
        Constraints(dt=0.02, iterations=10), "time step", {LONGER, DAMPING, HAND_ON},
    ),
    "short run, steps named": (unfinished(("steps",)), "rest", {SHORTER, DAMPING, HAND_ON}),
    "short run, both named": (unfinished(("dt", "steps")), "rest", {SHORTER, "dt=", HAND_ON}),
    "short run, untold": (unfinished(("dt", "steps"), tell=False), "rest", {SHORTER, "dt="}),
    "short run, dt named": (unfinished(("dt",)), "rest", {DAMPING, HAND_ON}),
    "state survives": (
        synthetic_faults()["state survives"].simulate, "gate", {HAND_ON, LONGER, SHORTER},
    ),
}  # fmt: skip
"""Fault -> the simulator, the kind of the true cause, and remedies that would be wrong."""
REMEDIES = {"rest": ("longer", "--set steps="), "time step": ("step",), "units": ("k in N/m",)}


@pytest.mark.parametrize("material", [MATERIAL, SOFT], ids=["hard", "soft"])
@pytest.mark.parametrize("fault", FAULTS)
def test_the_true_cause_is_reported_and_no_wrong_remedy(fault, material):
    simulate, kind, forbidden = FAULTS[fault]
    asked = Asked(simulate)
    found = judge_simulator(asked, material, parts=("gate",))
    sheet = sheet_of(found, asked, ("gate",))
    kinds = [cause.kind for cause in found.causes]
    assert kind in kinds, sheet.lines(fault)
    assert not [each for each in forbidden if each in sheet.next], sheet.next
    assert any(each in sheet.next for each in REMEDIES.get(kind, ("",)))
    if kind in {"rest", "time step"}:
        assert kinds[0] in {"rest", "time step"}
        assert sheet.word.startswith("not converged")
        assert sheet.lines(fault)[2].strip().startswith("solver: not converged")


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
    assert first.startswith(
        "  solver: not converged: 4.5 % of a displacement changes with the time"
    )
    assert "run longer" not in done.stdout
    (page,) = tmp_path.glob("reports/simulators/box-stepped/case.html")
    assert "changes with the time step" in page.read_text(encoding="utf-8")
