"""Newton's iteration of implicit steps, against the root of one equation by bracketing."""

import numpy as np
import pytest
from scipy.optimize import brentq

from msvalidate.problem import ProblemError, SolverError
from msvalidate.springs.dynamics import implicit
from msvalidate.springs.dynamics.implicit import NetworkAcceleration, increment
from msvalidate.springs.dynamics.integrate import State, motion
from msvalidate.springs.dynamics.integrators import INTEGRATORS
from msvalidate.springs.network import spring_network

STIFFNESS, MASS = 3.0, 2.0


def tightened_string(far=0.0):
    """A point between two supports 1 m off, free to move sideways: its force begins as a cubic."""
    points = far + np.array([[-1.0, 0], [0, 0], [1, 0]])
    held = [[True, True], [True, False], [True, True]]
    return spring_network(points, [[0, 1], [1, 2]], STIFFNESS, mass=MASS, fixed=held)


def acceleration_of(network):
    return NetworkAcceleration(network)


def aside(y):
    """Displacements that move the point sideways by y (m)."""
    x = np.zeros((3, 2))
    x[1, 1] = y
    return x


def solved(acceleration, y, b, q, p=1.0):
    """The point's δ (m) of one step, from y."""
    x, push = aside(y), np.zeros((3, 2))
    push[1, 1] = b
    move, after = increment(acceleration, x, acceleration(x), push, p, q)
    np.testing.assert_allclose(after, acceleration(x + move), rtol=1e-12, atol=1e-12)
    return move[1, 1]


def root(y, b, q, p=1.0):
    """The same by bracketing: two springs of 1 m at rest, of which each pulls aside."""

    def excess(delta):
        at_end = y + delta
        pull = -2 * STIFFNESS * at_end * (1 - 1 / np.hypot(1, at_end)) / MASS
        return p * delta - q * pull - b

    farthest = 2 * (abs(b) + abs(y)) + 1  # the force drives back to y = 0, so no farther
    return brentq(excess, -farthest, farthest, xtol=1e-300, rtol=1e-15)


CASES = [(0.0, 0.5, 1.0), (0.5, 0.1, 1.0), (0.0, 50.0, 1.0), (0.0, 5.0, 1e3), (1.0, 0.1, 1e6)]
"""(y, b, q) in m, m, s²: from the straight string the first tangent knows of no stiffness; the last
ends where rounding of forces moves the point by more than that of positions."""

UNFINISHED = r"implicit step: a move of \S+ m is still corrected by \S+ m after 30 Newton"


class Never(NetworkAcceleration):
    """A tangent that is never made anew."""

    def solve(self, x, residual, p, q, *, fresh):  # noqa: ARG002
        return super().solve(x, residual, p, q, fresh=False)


def test_without_a_fresh_tangent_a_step_from_the_straight_string_fails():
    network = tightened_string()
    with pytest.raises(SolverError, match=UNFINISHED):
        solved(Never(network), *CASES[0])


@pytest.mark.parametrize("q", [1e6, 1.0])
def test_a_tangent_that_is_far_too_stiff_is_not_taken_for_rounding(q):
    """Left by another place, or by a step that was longer: its first corrections are 1e-9 m."""
    acceleration = acceleration_of(tightened_string())
    longer = 1e6 if q == 1e6 else 1e16
    acceleration.solve(aside(1.0), np.zeros((3, 2)), 1.0, longer, fresh=True)
    assert solved(acceleration, 0.0, 1e-3, q) == pytest.approx(root(0.0, 1e-3, q), rel=1e-9)


def test_a_quiet_motion_keeps_its_tangent(monkeypatch):
    """Forty steps that turn the string's slope by a tenth, with two factors, not eighty."""
    made = []
    whole = implicit.factorise
    monkeypatch.setattr(implicit, "factorise", lambda *given: made.append(1) or whole(*given))
    network = tightened_string()
    start = State(network.points + aside(1.0), np.zeros((3, 2)))
    motion(network, start, INTEGRATORS["average_acceleration"], 0.01, 40)
    assert len(made) <= 2


def nowhere(acceleration):
    return increment(acceleration, np.zeros((3, 2)), np.zeros((3, 2)), np.zeros((3, 2)), 1.0, 1.0)


@pytest.mark.parametrize(
    ("make", "error", "message"),
    [
        (
            lambda: solved(acceleration_of(tightened_string()), 0.0, 5.0, 1e14),
            SolverError,
            rf"{UNFINISHED} iterations; take smaller steps",
        ),
        (
            lambda: solved(acceleration_of(tightened_string()), 0.0, np.inf, 1.0),
            SolverError,
            "implicit step: it is beyond all numbers; take smaller steps",
        ),
        (
            lambda: acceleration_of(tightened_string())(np.full((3, 2), 1e101)),
            SolverError,
            r"motion: positions beyond 1e\+100 m; take smaller steps",
        ),
        (lambda: nowhere(np.negative), ProblemError, "acceleration: a plain function; an implicit"),
    ],
    ids=["no convergence", "overflow", "away", "plain function"],
)
def test_a_refusal_says_what_and_the_remedy(make, error, message):
    with pytest.raises(error, match=f"^{message}"):
        make()
