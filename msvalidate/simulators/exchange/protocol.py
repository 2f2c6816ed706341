"""Request to a simulator and its answer, in memory or as files.

A simulator is any function from a `Request` to an `Answer`. One that is a program of its own is
asked through files (`folders`, `program`); nothing of it is imported here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, Literal, get_args

import numpy as np

from msvalidate.problem import Array, Index, Isotropic, Mask, Mesh, ProblemError, SolverError
from msvalidate.problem.checks import positive_number, require_one_of, whole_number
from msvalidate.problem.records import dataclass, field


def solves_to(about: Mapping[str, Any]) -> float:
    """Relative residual of a step's change of velocity, as stated; else 0."""
    return float(about.get("solves_to") or 0.0)


def stated_residual_motion(request: Request, answer: Answer) -> float:
    """Residual motion relative to the largest displacement, as stated; else NaN.

    `at_rest` of the answer holds one of

    - `change_when_twice_as_long` (m): over the largest displacement.
    - `largest_speed` v (m/s): the body swings by v/ω, with Rayleigh's estimate of its lowest
      frequency for the answer's own shape, ω² = Σ F u / Σ m u² [Rayleigh1877].
    - `residual` r (N), on any node: n nodes pulled by it all one way, over the sum of the loads'
      sizes: n r / Σ |F|.

    The last two are estimates, and need loads: a body that supports alone move gives NaN.
    """
    stated = dict(answer.about.get("at_rest", {}))
    u = answer.displacement
    if u is None or not stated:
        return math.nan
    size = float(np.linalg.norm(u, axis=1).max())
    if not size:
        return math.nan
    if "change_when_twice_as_long" in stated:
        return float(stated["change_when_twice_as_long"]) / size
    force = np.where(request.held, 0.0, request.load)
    work = float((force * u).sum())
    if "largest_speed" in stated:
        moved = float((request.mass[:, None] * u**2).sum())
        if work <= 0 or request.value.any():
            return math.nan
        return float(stated["largest_speed"]) * math.sqrt(moved / work) / size
    pull = float(np.linalg.norm(force, axis=1).sum())
    return len(u) * float(stated["residual"]) / pull if pull else math.nan


FORMAT = 1
"""Version of the files.

A change that older adapters cannot read makes it 2.
"""
CANNOT = 77
"""Exit code of an adapter whose program cannot represent what is asked."""
LARGEST = 1e30
"""Largest number in an answer, in m, m/s or N.

Its powers are still numbers, and nothing moves so far.
"""
Task = Literal["rest", "motion", "declare"]
"""Solve for equilibrium, take steps from given positions, or declare the program's cells."""
DIMENSION = {"quad": 2, "triangle": 2, "hexahedron": 3, "tetra": 3}
"""Cells that a program may declare, and their number of axes; "points" needs a dimension."""
ForcesAt = Literal["start", "end"]
"""At which positions of a step the forces act that changed its velocities."""
Precision = Literal["float64", "float32"]
MassKind = Literal["lumped", "consistent", "one point"]
ROUNDING = {"float64": 2.0**-53, "float32": 2.0**-24}
"""Largest relative error of a rounded number."""


class CannotRepresent(ProblemError):  # noqa: N818  read as what a simulator says
    """The simulator has no way to do what is asked; the message is its reason."""


class SimulatorError(SolverError):
    """A simulator crashed, took too long, or left an answer that is none."""


class NotAskedError(SimulatorError):
    """A question that was left out, after one that took too long."""

    def __init__(self) -> None:
        super().__init__("not asked any more")


class OutOfTime(SimulatorError):  # noqa: N818  read as what happened
    """A simulator was not done in the time that it was given."""


@dataclass(frozen=True, eq=False)
class Springs:
    """Springs between a request's nodes, for codes that know nothing else.

    Parameters
    ----------
    ends
        (m, 2) nodes.
    stiffness, length
        (m,) N/m, and m at rest.
    """

    ends: Index
    stiffness: Array
    length: Array


@dataclass(frozen=True, eq=False)
class Request:
    """Task for a simulator.

    Parameters
    ----------
    task
        "rest": displacement at rest under gravity, forces and supports. "motion": position and
        velocity after `steps` steps of `dt` from `start` at zero velocity, under gravity alone:
        no supports, forces, damping or contact. A static program may answer a motion of one step
        by the forces that the body puts on its nodes at `start`.
    mesh
        Nodes and linear cells: triangle or quad in the plane, tetra or hexahedron in space.
    material
        Asked E, nu, density, plane state and thickness.
    mass
        (n,) lumped, kg.
    gravity
        (d,) m/s².
    force
        (n, d) on the nodes, N, gravity not among them.
    held, value
        (n, d) which components supports hold, and where (m, displacement).
    start
        (n, d) positions (m) of a motion.
    dt, steps
        Of a motion: s, and how many.
    settings
        Of the simulator alone, by its own names: law, iterations and so on.
    springs
        In place of the material, for codes of springs.
    name
        Of the case.
    points_only
        Leave the cells out, for programs that make the springs between points themselves.
    """

    task: Task
    mesh: Mesh
    material: Isotropic
    mass: Array
    gravity: Array
    force: Array
    held: Mask
    value: Array
    start: Array | None = None
    dt: float | None = None
    steps: int = 1
    settings: Mapping[str, Any] = field(default_factory=dict)
    springs: Springs | None = None
    name: str = "case"
    points_only: bool = False

    def __post_init__(self) -> None:
        require_one_of("task", self.task, get_args(Task))
        if self.task == "motion":
            if self.start is None or self.dt is None:
                raise ProblemError("motion: no start or dt; give positions and a step")
            positive_number("dt", self.dt, "s")
            whole_number("steps", self.steps, 1)

    @property
    def load(self) -> Array:
        """(n, d) N on the nodes, weight among them."""
        return np.asarray(self.force + self.mass[:, None] * self.gravity)


@dataclass(frozen=True, eq=False)
class Answer:
    """Answer of a simulator.

    Parameters
    ----------
    displacement
        (n, d) m, of task "rest".
    position, velocity
        (n, d) m and m/s after the last step, of task "motion".
    force
        (n, d) N that the body puts on its nodes at `start`, from programs without motion.
    about
        What `result.json` holds: simulator, version, law, settings, steps, dt, precision
        ("float64" or "float32"), mass ("lumped", "consistent", or "one point": see `probe_mesh`),
        forces_at ("start" of a step where it is explicit, "end" where it is implicit), solves_to,
        at_rest, seconds, notes.
    """

    displacement: Array | None = None
    position: Array | None = None
    velocity: Array | None = None
    force: Array | None = None
    about: Mapping[str, Any] = field(default_factory=dict)


Simulator = Callable[[Request], Answer]


def ask(simulator: Simulator, request: Request) -> Answer:
    """A simulator's answer, with the arrays that the task needs, of the right shape, of numbers.

    Raises
    ------
    CannotRepresent
        If the simulator says so.
    SimulatorError
        If it leaves no such answer.
    """
    answer = simulator(request)
    needed = ("displacement",) if request.task == "rest" else ("position", "velocity")
    if request.task == "declare":
        return answer
    if request.task == "motion" and answer.force is not None:
        needed = ("force",)
    for name in needed:
        _refuse_misfit(name, getattr(answer, name), request.mesh.points.shape)
    return answer


def _refuse_misfit(name: str, array: Array | None, shape: tuple[int, ...]) -> None:
    if array is None:
        raise SimulatorError(f"answer: no {name}; give {name} {shape}")
    if array.shape != shape:
        raise SimulatorError(f"answer: {name} {array.shape}; give {shape}, a row a node")
    bad = np.argwhere(~(np.abs(array) <= LARGEST))
    if len(bad):
        raise SimulatorError(
            f"answer: {name} {array[tuple(bad[0])]:.3g} at node {bad[0][0]}, {len(bad)} in all; "
            "did it diverge?"
        )
