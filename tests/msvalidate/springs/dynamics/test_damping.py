"""The quickest damping: closed forms, real steps, what a load does not excite."""

import re

import numpy as np
import pytest
from scipy.optimize import brentq

from msvalidate.problem import Box, PointForce, ProblemError, SolverError, Support
from msvalidate.springs.dynamics.damping import quickest_damping
from msvalidate.springs.dynamics.integrate import State, euler_cromer, recommended_time_step
from msvalidate.springs.dynamics.integrators import EULER_CROMER
from msvalidate.springs.network import spring_network
from msvalidate.springs.statics.equilibrium import equilibrium
from tests.table import table


def one_spring(size=1.0, k=3.0, mass=0.5, force=1.0, **named):
    held = named.pop("fixed", [[1, 1], [0, 1]])
    load = [[0, 0], [force, 0]]
    points = [[0.0, 0.0], [size, 0.0]]
    return spring_network(points, [[0, 1]], k, mass=mass, fixed=held, force=load, **named)


@table(
    ("size", "k", "mass", "force", "accuracy"),
    [
        (1.0, 3.0, 0.5, 1.0, 1e-3),
        (0.37, 1e12, 1e-9, 1e-300, 1e-4),
        (370.0, 1e-9, 1e3, 1e150, 1e-1),
    ],
)
def test_one_mode_overshoots_by_the_accuracy(size, k, mass, force, accuracy):
    found = quickest_damping(one_spring(size, k, mass, force), accuracy=accuracy)
    omega, fold = (k / mass) ** 0.5, -np.log(accuracy)
    assert found.omega == pytest.approx(omega)
    # The first overshoot is exp(-πs/√(ω² - s²)); a step of the rates or two above it is taken.
    least = 2 * omega * fold / np.hypot(fold, np.pi)
    assert 1.0 <= found.rate / least <= 1.011
    s = found.rate / 2 / omega
    w = np.sqrt(1 - s * s)

    def beyond(x):
        return np.exp(-s * x) * (np.cos(w * x) + s / w * np.sin(w * x)) - accuracy

    assert found.seconds * omega == pytest.approx(brentq(beyond, 0, np.pi / w), rel=1e-3)


@pytest.mark.parametrize("given", ["corner", "end moved"])
def test_steps_to_rest_are_as_stated_and_fewer_than_at_other_rates(lattice_body, given):
    box = Box((2.0, 1.0))
    left, right = box.side("left"), box.side("right")
    named = {"loads": (PointForce((2.0, 1.0), (0.0, -1e-6)),)}
    if given == "end moved":
        named = {"supports": (Support(left, (0.0, 0.0)), Support(right, (None, 1e-6)))}
    network = lattice_body(box.size, (8, 4), **named)
    rest, mass = equilibrium(network).position, network.mass[:, None]

    def seconds(rate):
        dt = 0.2 * recommended_time_step(network, EULER_CROMER, damping=rate)
        now, left = State(network.start, np.zeros(rest.shape)), []
        for _ in range(int(1.5 * found.seconds / dt / 10)):
            left.append(np.sqrt((mass * (now.position - rest) ** 2).sum()))
            now = euler_cromer(network, now, dt, 10, rate, warn=False)
        return 10 * dt * (np.flatnonzero(np.array(left) > 1e-3 * left[0])[-1] + 1)

    found = quickest_damping(network)
    own = seconds(found.rate)
    assert own == pytest.approx(found.seconds, rel=0.04)
    assert own < min(seconds(part * found.rate) for part in (0.8, 0.95, 1.2))


STEADY = "quickest damping: no load or prescribed displacement acts on what is free to move"


@table(
    ("network", "accuracy", "error", "message"),
    [
        (one_spring(force=0.0), 1e-3, ProblemError, STEADY),
        (one_spring(fixed=np.ones((2, 2))), 1e-3, ProblemError, STEADY),
        (one_spring(), 0.0, ProblemError, "accuracy of rest: 0; give a part of the way, 1e-6"),
        (one_spring(fixed=[[1, 1], [0, 0]]), 1e-3, ProblemError, "leave the body free: rotation"),
        (one_spring(fixed=[[1, 1], [0, 1]], k=0.0), 1e-3, SolverError, "nothing resists point 1"),
        (
            spring_network(
                [[0, 0], [1, 0], [2, 0]], [[0, 1], [1, 2]], 1.0, rest_length=1.5,
                fixed=[[1, 1], [0, 0], [1, 1]], force=[[0, 0], [1, 0], [0, 0]],
            ),
            1e-3, SolverError, "unstable at its reference points; relieve its prestress",
        ),
    ],
)  # fmt: skip
def test_what_does_not_come_to_rest_is_refused(network, accuracy, error, message):
    with pytest.raises(error, match=re.escape(message)):
        quickest_damping(network, accuracy=accuracy)
