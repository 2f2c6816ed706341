"""The gate: clean simulators pass it, and each fault is stopped at its own row."""

from __future__ import annotations

import numpy as np
import pytest

from msvalidate.problem import Isotropic
from msvalidate.simulators.exchange.protocol import Answer, CannotRepresent, SimulatorError
from msvalidate.simulators.gate.gate import gate
from msvalidate.simulators.gate.rows import MOVING, PASSED, STOPPED
from msvalidate.simulators.verdict.sentences import text_of
from msvalidate_check.causes import Phrase
from reference_fem import mesh_discretisation
from reference_fem.elasticity import stiffness
from tests.table import table

SOFT = Isotropic(1e5, 0.3, "plane_strain", 1200.0, 0.5)


class Linear:
    """Linear elements, explicit in time; a fault is a method or number that is another."""

    grip, fall, drift, solves_to, stiff = 0.0, 1.0, 0.0, 0.0, 1.0
    precision, at_rest = "float64", {"change_when_twice_as_long": 0.0}

    def __init__(self, **faults):
        self.asked = 0
        for name, value in faults.items():
            setattr(self, name, value)

    def left(self, _settings):
        return 0.0

    def matrix(self, request):
        K = stiffness(mesh_discretisation(request.mesh), request.material).toarray() * self.stiff
        d, n = request.mesh.dim, len(request.mesh.points)
        return K.reshape(d, n, d, n).transpose(1, 0, 3, 2).reshape(n * d, n * d)

    def about(self, request):
        settings = {"iterations": [request.settings.get("iterations", 10), ""]}
        told = {"precision": self.precision, "at_rest": self.at_rest, "settings": settings}
        return told | {"solves_to": self.solves_to}

    def __call__(self, request):
        self.asked += 1
        if request.task == "motion":
            return self.moved(request)
        K, free = self.matrix(request), ~request.held.ravel()
        u = np.zeros(free.size)
        u[free] = np.linalg.solve(K[np.ix_(free, free)], request.force.ravel()[free])
        u *= 1 - self.left({"iterations": 10, **request.settings})
        return Answer(displacement=self.kept(request, u), about=self.about(request))

    def kept(self, request, u):
        x = request.mesh.points
        if self.precision == "float32":
            return (x.astype(np.float32) + u.reshape(x.shape).astype(np.float32)) - x
        return u.reshape(x.shape)

    def moved(self, request):
        number = np.float32 if self.precision == "float32" else float
        K, X = self.matrix(request).astype(number), request.mesh.points.astype(number)
        x, v = request.start.astype(number), np.zeros_like(X)
        for _ in range(request.steps):
            f = -(K @ (x - X).ravel()).reshape(X.shape) - self.grip * (x - X)
            v = v + number(request.dt) * (f / request.mass[:, None] + self.fall * request.gravity)
            before, x = x, (x + number(request.dt) * v + self.drift).astype(number)
            v = (x - before) / number(request.dt)  # as programs of positions do
        return Answer(position=x.astype(float), velocity=v.astype(float), about=self.about(request))


class Static(Linear):
    def moved(self, request):
        if request.steps > 1:
            raise CannotRepresent("no time in it")
        f = -(self.matrix(request) @ (request.start - request.mesh.points).ravel())
        return Answer(force=f.reshape(request.start.shape), about=self.about(request))


def verdicts(found):
    return {row.name: row.verdict for row in found.rows}


CLEAN = [
    Linear(),
    Linear(precision="float32"),
    Linear(at_rest={}),
    Linear(at_rest={}, left=lambda s: 1e-3 / s["iterations"]),
    Linear(at_rest={"change_when_twice_as_long": 1e-6}, left=lambda s: 1e-3 / s["iterations"]),
    Linear(fall=1.009, solves_to=0.01),
]


@pytest.mark.parametrize("simulator", CLEAN)
def test_a_clean_simulator_passes(simulator):
    found = gate(simulator, SOFT)
    assert found.stops == ()
    assert found.passed
    wanted = {"rest stays at rest", "free fall", "small turn", "twice the modulus"}
    wanted |= {"twice the iterations", "the same again"}
    assert {name for name, verdict in verdicts(found).items() if verdict == PASSED} == wanted
    by = {row.name: row for row in found.rows}
    assert by["free fall: integrator"].because == Phrase("semi-implicit")
    assert by["turn by 30°"].value > 0.1


@pytest.mark.parametrize("stiff", [1e5, 1e-3])
@np.errstate(over="ignore", invalid="ignore")  # its steps are too long for it
def test_rounding_at_a_turn_is_judged_by_the_stiffness_that_is_measured(stiff):
    assert verdicts(gate(Linear(precision="float32", stiff=stiff), SOFT))["small turn"] == PASSED
    assert verdicts(gate(Linear(stiff=stiff, grip=10 * stiff), SOFT))["small turn"] == STOPPED


def test_elements_near_incompressibility_are_of_no_other_unit():
    """Their wave modulus is 34 times E."""
    assert gate(Linear(), Isotropic(1e5, 0.495, "solid", 1200.0)).units == ()


def test_a_static_program_passes_without_falling():
    found = gate(Static(), SOFT)
    assert found.passed
    assert verdicts(found)["free fall"] == "cannot"
    assert verdicts(found)["small turn"] == PASSED


class Deaf(Linear):
    """Takes E as 1e5 whatever is asked."""

    def matrix(self, request):
        return super().matrix(request) * 1e5 / request.material.E


class Forgetful(Linear):
    def left(self, _settings):
        return 1e-4 * self.asked


class Broken(Linear):
    def kept(self, *_):
        raise SimulatorError("it crashed")


FAULTS = [
    (Linear(drift=1e-9), {"rest stays at rest", "free fall"}),
    (Linear(fall=1.001), {"free fall"}),
    (Linear(fall=1.011, solves_to=0.01), {"free fall"}),
    (Linear(grip=10.0), {"small turn", "free fall"}),
    (Deaf(), {"twice the modulus"}),
    (Linear(left=lambda s: 1.0 / (10 + s["iterations"])), {"twice the iterations"}),
    (Linear(at_rest={}, left=lambda s: 0.1 / s["iterations"]), {"twice the iterations"}),
    (Forgetful(), {"the same again", "twice the iterations"}),
    (Broken(), {"pulled block at rest"}),
]


@table(("simulator", "stopped"), FAULTS)
def test_a_fault_is_stopped_at_its_row(simulator, stopped):
    found = gate(simulator, SOFT)
    assert {name for name, verdict in verdicts(found).items() if verdict == STOPPED} == stopped
    assert not found.passed


def test_what_moves_as_much_as_it_says_is_not_at_rest():
    """It halves what is left with twice the iterations, and states all of that."""
    moving = Linear(left=lambda s: 3.0 / (s["iterations"] + 2))
    moving.at_rest = {"change_when_twice_as_long": 5e-4}
    found = gate(moving, SOFT)
    assert (found.stops, found.passed) == ((), True)
    assert [row.name for row in found.rows if row.verdict == MOVING] == ["twice the iterations"]
    assert found.moving == pytest.approx((1 - 3 / 22) / (1 - 3 / 12) - 1, rel=1e-3)


def test_a_rest_that_it_is_not_at_is_told():
    lying = Linear(at_rest={"change_when_twice_as_long": 0.0}, left=lambda s: 1 / s["iterations"])
    (row,) = gate(lying, SOFT).stops
    said = "its rest is stated to 0, and it moves by 0.056 with iterations 20"
    assert text_of(row.because) == said


def test_nothing_that_could_be_tried_is_no_pass():
    def refuse(_request):
        raise CannotRepresent("no such material")

    found = gate(refuse, SOFT)
    assert not found.passed
    assert set(verdicts(found).values()) == {"cannot"}
