"""Rest states over time step and iterations: what a sweep tells of a program that stops early."""

from dataclasses import replace

import pytest

from msvalidate.problem import Isotropic
from msvalidate.simulators.bodies.tetrahedra import of_law
from msvalidate.simulators.exchange.protocol import CannotRepresent
from simulators.sweep import Sweep, rest_states

SOLID = Isotropic(1e7, 0.3, "solid", 1000.0)
exact = of_law("linear")


def unsettled(request):
    """Elements at rest, and a tenth of that for each iteration that is not taken, over dt²."""
    answer, asked = exact(request), request.settings
    beyond = 1 + 0.1 * (asked["dt"] / 1e-3) ** 2 / asked["iterations"]
    return replace(answer, displacement=beyond * answer.displacement)


def test_error_is_what_iterations_and_step_leave():
    rows = rest_states(unsettled, SOLID, {}, Sweep((2e-3, 1e-3), (1, 2)))
    found = [[row[name] for row in rows] for name in ("error", "by_iterations", "by_dt")]
    assert found[0] == pytest.approx([0.4, 0.2, 0.1, 0.05], rel=1e-8)
    assert found[1] == [None, pytest.approx(0.2, rel=1e-8), None, pytest.approx(0.05, rel=1e-8)]
    assert found[2] == [None, None, pytest.approx(0.3, rel=1e-8), pytest.approx(0.15, rel=1e-8)]


def test_state_that_is_not_there_says_why():
    def first_alone(request):
        if request.settings["iterations"] > 1:
            raise CannotRepresent("one iteration alone")
        return unsettled(request)

    one, two = rest_states(first_alone, SOLID, {}, Sweep((1e-3,), (1, 2)))
    assert one["because"] == ""
    assert (two["error"], two["because"]) == (None, "one iteration alone")
