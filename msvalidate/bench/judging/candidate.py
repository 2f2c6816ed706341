"""Candidates of a study: predictors of displacements, by default the spring network.

A candidate may be anybody's, so every study passes its own through here, once, where it begins
(`check_displacements`, `check_actuator`, `check_motion`, `check_functions`, `check_table`): what it
then answers is an array of the
right shape, finite and in the right unit, or one line that says what it is instead.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, Literal, TypeVar, get_args

import numpy as np

from msvalidate.problem import Array, Problem, ProblemError, SolverError
from msvalidate.problem.checks import format_value, numbers, require_one_of, require_type
from msvalidate.springs.dynamics.integrate import State
from msvalidate.springs.dynamics.relax import algorithm1
from msvalidate.springs.network import Network, mode_energy
from msvalidate.springs.statics.equilibrium import equilibrium

AT_REST = 3e-11
"""Largest relative residual of a candidate's equilibrium.

A slow mode has up to a hundred times as much relative displacement.
"""
Answer = Literal["linear", "nonlinear", "relaxed"]
"""Static equilibrium to first order, or in full, or where Algorithm 1 comes to rest."""
DisplacementSolver = Callable[[Problem, Network, Answer], Array]
"""Function that predicts the displacement (n, d) in m of a network's points.

Its argument is the problem or the network.
"""
Kind = TypeVar("Kind")
SUPPORTED = 1e-6
"""Relative violation of a support that another interpretation may leave.

Solvers satisfy supports to rounding; other interpretations differ by the coordinate or by a factor
of a thousand.
"""
THOUSAND = 1000.0
"""Millimetres in a metre."""
NEARLY = 2.0
"""Largest ratio of an answer's energy to that of its loads for a valid interpretation.

Elastic bodies and lattices with other constants differ by less from the network of the study.
"""
FAR = 10.0
"""Factor beyond which it is not."""


def solve_springs(problem: Problem, network: Network, answer: Answer = "linear") -> Array:  # noqa: ARG001
    """The spring network's own answer.

    Raises
    ------
    ProblemError
        If there is no such answer, or no network.
    SolverError
        If there is no trustworthy answer.
    """
    require_one_of("answer", answer, get_args(Answer))
    if answer == "relaxed":
        return algorithm1(network, tolerance=AT_REST).equilibrium.displacement
    return equilibrium(network, answer).displacement


def check_displacements(candidate: DisplacementSolver) -> DisplacementSolver:
    """A candidate for displacements, with its answers looked at.

    Raises
    ------
    ProblemError
        If it is no function. Its answers raise it too: see `check_displacement`.
    """
    predict = _check_callable(candidate, "(problem, network, answer) that predicts displacements")
    return partial(_checked_displacement, predict)


def _checked_displacement(
    predict: DisplacementSolver, problem: Problem, network: Network, answer: Answer = "linear"
) -> Array:
    return check_displacement(predict(problem, network, answer), network)


def check_actuator(candidate: Callable[[Any, float], Array]) -> Callable[[Any, float], Array]:
    """A candidate for an actuator's displacements, as `check_displacements`."""
    predict = _check_callable(candidate, "(actuator, voltage) that predicts displacements")
    return partial(_checked_actuator, predict)


def _checked_actuator(predict: Callable[[Any, float], Array], actuator: Any, volts: float) -> Array:
    return check_displacement(predict(actuator, volts), actuator.network)


def check_motion(candidate: Callable[..., State]) -> Callable[..., State]:
    """A candidate for a motion, as `check_displacements`."""
    move = _check_callable(candidate, "(network, state, dt, steps, damping) that gives a State")
    return partial(_checked_motion, move)


def _checked_motion(
    move: Callable[..., State], network: Network, state: State, *given: Any, **named: Any
) -> State:
    found = move(network, state, *given, **named)
    if not isinstance(found, State):
        raise ProblemError(
            f"candidate: {format_value(found)}; give a State, of position and velocity at the "
            "network's points"
        )
    position = _check_array("positions", found.position, network, "m")
    velocity = _check_array("velocities", found.velocity, network, "m/s")
    start, held = np.asarray(state.position)[network.fixed], network.fixed
    if _is_met_by(position[held] - start, position[held] + network.points[held] - start):
        raise ProblemError(
            f"candidate: positions {position.shape} whose held components are those of "
            "displacements; add network.points"
        )
    return State(position, velocity)


def check_functions(candidate: object, kind: type[Kind]) -> Kind:
    """A candidate of several functions, all of them there; raise `ProblemError` if it is none."""
    if not isinstance(candidate, kind):
        raise ProblemError(
            f"candidate: {format_value(candidate)}; give a {kind.__name__}, the study's "
            "own with what is yours in its place"
        )
    fields = getattr(kind, "_fields", None) or kind.__dataclass_fields__  # type: ignore[attr-defined]
    for name in fields:
        value = getattr(candidate, name)
        if not (callable(value) or isinstance(value, tuple | Mapping)):
            raise ProblemError(f"candidate: {name} is {format_value(value)}; give a function")
    return candidate


def check_table(candidate: object, kind: type[Kind], own: Mapping[str, Kind]) -> Mapping[str, Kind]:
    """Check a candidate that is a table of records with all names of the study."""
    if not isinstance(candidate, Mapping):
        raise ProblemError(
            f"candidate: {format_value(candidate)}; give a table, name -> {kind.__name__}, the "
            f"study's "
            "own with what is yours in its place"
        )
    missing = [name for name in own if name not in candidate]
    if missing:
        raise ProblemError(f"candidate: no {', '.join(missing)}; the study asks about it")
    for name, value in candidate.items():
        require_type(f"candidate: {name}", value, kind)
    return candidate


def check_displacement(found: object, network: Network) -> Array:
    """Check an answer and return it as displacements (n, d) in m.

    Raises
    ------
    ProblemError
        If it is no array of numbers of this shape, or what it does at the supports, or the energy
        that it stores in the network, is that of positions or of another unit.
    SolverError
        If a number is not finite.
    """
    move = _check_array("displacements", found, network, "m")
    slip = _guess_mistake(move, network)
    if slip:
        raise ProblemError(f"candidate: displacements {move.shape} that {slip}")
    return move


def _check_callable(candidate: Kind, what: str) -> Kind:
    if not callable(candidate):
        raise ProblemError(f"candidate: {format_value(candidate)}; give a function of {what}")
    return candidate


def _check_array(what: str, found: object, network: Network, unit: str) -> Array:
    """An array of a network's shape, of finite numbers."""
    shape = network.points.shape
    need = f"{what} {shape} in {unit} at network.points"
    if found is None:
        raise ProblemError(f"candidate: None; return {need}")
    array = numbers(f"candidate, {need}", found)
    if array.shape != shape:
        raise ProblemError(
            f"candidate: shape {array.shape}; give {need}{_guess_shape(array, network)}"
        )
    bad = np.argwhere(~np.isfinite(array))
    if len(bad):
        at = tuple(int(i) for i in bad[0])
        raise SolverError(
            f"candidate: {array[at]} at index {at}, {len(bad)} in all; give {need}, all finite"
        )
    return array


def _guess_shape(array: Array, network: Network) -> str:
    """Guess the meaning of an array of the wrong shape."""
    n, d = network.points.shape
    if array.shape == (d, n):
        return " (this is the transpose)"
    if array.shape == (n * d,):
        return f" (this is flat; reshape it to {n, d})"
    if array.shape == (np.count_nonzero(~network.fixed),):
        return " (these are free components alone)"
    if array.shape == (n, 3) and d == 2:
        return " (leave the third component out)"
    return ""


def _guess_mistake(move: Array, network: Network) -> str:
    """Guess what the given numbers are, if not displacements; "" without a sign.

    Held components tell it where they are not at 0. The energy of a linear answer is the work of
    its loads, motionᵀ K motion = force · motion, so their ratio tells it where nothing is moved by
    supports: it grows as the answer, and is near 1 for any solid like the network.
    """
    held, points = network.fixed, network.points
    asked = network.displacement[held]
    missed = move[held] - asked
    positions = "are positions; take network.points off"
    if _is_met_by(missed, missed - points[held]):
        return f"at the supports {positions}"
    for times, unit in ((THOUSAND, "mm"), (1 / THOUSAND, "km")):
        if asked.any() and _is_met_by(missed, move[held] - times * asked):
            return f"at the supports are {times:g} times those asked for; give m (are they {unit}?)"
    if asked.any() or not network.force.any():
        return ""
    ratio = _energy_over_work(move, network)
    if _is_within(_energy_over_work(move - points, network), NEARLY) and not _is_within(ratio, FAR):
        return f"store {ratio:.3g} times the work of the loads: they look like {positions}"
    for times, unit in ((THOUSAND, "mm"), (1 / THOUSAND, "km")):
        if _is_within(ratio / times, NEARLY):
            return (
                f"store {ratio:.3g} times the work of the loads, so are about as many times too "
                f"large; give m (are they {unit}?)"
            )
    return ""


def _is_met_by(missed: Array, otherwise: Array) -> bool:
    """Return True if another interpretation satisfies every violated support."""
    off = float(np.abs(missed).max(initial=0.0))
    return off > 0 and float(np.abs(otherwise).max()) <= SUPPORTED * off


def _energy_over_work(move: Array, network: Network) -> float:
    with np.errstate(all="ignore"):  # whatever is asked about: what overflows is no likely slip
        work = float((network.force * move).sum())
        return mode_energy(network, network.points, move) / work if work else 0.0


def _is_within(ratio: float, factor: float) -> bool:
    return 1 / factor <= ratio <= factor
