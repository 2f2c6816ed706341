"""Each scheme's step of x'' = -x - c·x' as a matrix on paper, which knows nothing of its code.

A matrix (2, 2) takes (x, v) over a step h; v of a staggered scheme is half a step back.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from msvalidate import kit
from msvalidate.springs.dynamics.scheme import Integrator
from msvalidate.springs.dynamics.step_limits import one_step_matrix


def velocity_first(h: float, keep: float, push: float) -> kit.Array:
    """V' = keep·v - push·x, x' = x + h·v'."""
    return np.array([[1 - h * push, h * keep], [-push, keep]])


def explicit_euler(h: float, c: float) -> kit.Array:
    """Both from the old state."""
    return np.array([[1, h], [-h, 1 - c * h]])


def velocity_verlet(h: float, c: float) -> kit.Array:
    """Kick, drift, kick; the second damps before it adds the force, as the first does."""
    kick, drift = np.array([[1, 0], [-h / 2, 1 - c * h / 2]]), np.array([[1, h], [0, 1]])
    return np.asarray(kick @ drift @ kick)


def runge_kutta(h: float, c: float) -> kit.Array:
    """The exponential's series to the fourth power."""
    turn = h * np.array([[0.0, 1.0], [-1.0, -c]])
    square = turn @ turn
    return np.eye(2) + turn + square / 2 + turn @ square / 6 + square @ square / 24


def average_acceleration(h: float, c: float) -> kit.Array:
    """The exponential's rational form of the first order in numerator and denominator."""
    half = 0.5 * h * np.array([[0.0, 1.0], [-1.0, -c]])
    return np.asarray(np.linalg.solve(np.eye(2) - half, np.eye(2) + half))


MATRICES: Mapping[str, Callable[[float, float], kit.Array]] = {
    "explicit_euler": explicit_euler,
    "euler_cromer": lambda h, c: velocity_first(h, 1 - c * h, h),
    "leapfrog": lambda h, c: velocity_first(
        h, (1 - c * h / 2) / (1 + c * h / 2), h / (1 + c * h / 2)
    ),
    "velocity_verlet": velocity_verlet,
    "runge_kutta": runge_kutta,
    "average_acceleration": average_acceleration,
    "euler_cromer_as_printed": explicit_euler,
    "verlet_as_printed": lambda h, c: velocity_first(h, 1 - c * h / 2, h / 2),
    "verlet_lagged": lambda h, c: np.array([[1 - h * h / 2, h * (1 - c * h / 2)], [-h, 1 - c * h]]),
}
"""Name of a scheme -> its matrix by h and c, where ω = 1."""


def matrix_of(scheme: Integrator, h: float, c: float) -> kit.Array:
    """Matrix of a scheme, by its name; of one that is not on paper, that of its own step."""
    on_paper = MATRICES.get(scheme.name)
    return one_step_matrix(scheme, 1.0, h, c) if on_paper is None else on_paper(h, c)
