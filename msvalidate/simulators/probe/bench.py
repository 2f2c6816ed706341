"""One step of a block from positions at rest, and what a simulator must say about it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, get_args

import numpy as np

from msvalidate.problem import VOIGT, Array
from msvalidate.problem.checks import require_one_of
from msvalidate.problem.records import dataclass, field, replace
from msvalidate.simulators.exchange.protocol import (
    Answer,
    ForcesAt,
    MassKind,
    Precision,
    Request,
    Simulator,
    SimulatorError,
    ask,
)
from msvalidate.simulators.probe.block import Block

ENGINEERING = np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])
"""Shear strains count twice."""


@dataclass(frozen=True, eq=False)
class Push:
    """What one state told.

    Parameters
    ----------
    stress
        (3, 3) mean of the first Piola-Kirchhoff stress, Pa.
    gradient
        (3, 3) mean of ∂u/∂X where the forces act.
    force
        (n, 3) on the nodes, N.
    """

    stress: Array
    gradient: Array
    force: Array


@dataclass(frozen=True, eq=False)
class Station:
    """A bench whose answers are read as forces.

    Parameters
    ----------
    inertia
        Velocities (n, 3) -> momentum, kg m/s.
    forces_at
        Of the step: "start" or "end".
    consistent
        Whether the mass matrix is not diagonal.
    solves_to
        Part of a step's change of velocity that its solver leaves, as stated.
    """

    bench: Bench
    inertia: Callable[[Array], Array]
    forces_at: str
    consistent: bool = False
    solves_to: float = 0.0

    def push(self, G: Array, *, gravity: tuple[float, ...] = (0.0, 0.0, 0.0)) -> Push:
        """The state c + (I + G)(X - c), c the origin, that is the block's middle.

        Raises
        ------
        CannotRepresent, SimulatorError
            As the simulator.
        """
        bench = self.bench
        X = bench.block.mesh.points
        move = X @ G.T
        answer = bench.step(move, gravity)
        force = answer.force
        if force is None:
            force = self.inertia(np.asarray(answer.velocity)) / bench.dt
        place = bench.placed(move) if self.forces_at == "start" else np.asarray(answer.position)
        gradient = (place - X).T @ bench.block.weights
        return Push(-force.T @ X / bench.block.volume, gradient, np.asarray(force))

    def with_step(self, dt: float) -> Station:
        """The same with a step of another length, s."""
        return replace(self, bench=replace(self.bench, dt=dt))


def voigt(tensor: Array) -> Array:
    """Components (6,) of the symmetric part of a tensor (3, 3), in order xx, yy, zz, yz, xz, xy."""
    first, second = np.transpose(VOIGT[3])
    return np.asarray((tensor + tensor.T)[first, second] / 2)


SAID = {
    "precision": get_args(Precision),
    "forces_at": get_args(ForcesAt),
    "mass": get_args(MassKind),
}
"""What an answer must say: none of it can be seen from a step, and each changes what is read."""


@dataclass(frozen=True, eq=False)
class Bench:
    """A simulator with a block: asked for one step, at rest, without weight unless it is given.

    Parameters
    ----------
    dt
        Length of the step, s.
    precision
        Positions are rounded to it, so that the simulator starts where it was told.
    """

    simulator: Simulator
    block: Block
    dt: float
    precision: Precision = "float64"
    settings: Mapping[str, Any] = field(default_factory=dict)

    def step(self, move: Array, gravity: tuple[float, ...] = (0.0, 0.0, 0.0)) -> Answer:
        """What comes of one step from the mesh displaced by `move` (n, 3) m.

        Raises
        ------
        CannotRepresent, SimulatorError
            As `ask`; and `SimulatorError` where the answer does not say what it must.
        """
        mesh = self.block.mesh
        request = Request(
            "motion",
            mesh,
            self.block.material,
            mass=self.block.lumped,
            gravity=np.array(gravity),
            force=np.zeros(mesh.points.shape),
            held=np.zeros(mesh.points.shape, dtype=bool),
            value=np.zeros(mesh.points.shape),
            start=self.placed(move),
            dt=self.dt,
            settings=self.settings,
            name="probe",
        )
        answer = ask(self.simulator, request)
        _refuse_silence(answer)
        return answer

    def placed(self, move: Array) -> Array:
        """Positions (n, 3) m that the step starts from."""
        start = self.block.mesh.points + move
        return np.asarray(start.astype(self.precision), dtype=float)


def _refuse_silence(answer: Answer) -> None:
    """Raise `SimulatorError` unless an answer says what `SAID` lists; forces, precision alone."""
    for name, known in SAID.items():
        if answer.force is not None and name != "precision":
            continue
        if name not in answer.about:
            raise SimulatorError(f"answer: no {name}; say {' or '.join(known)}")
        try:
            require_one_of(f"answer: {name}", answer.about[name], known)
        except ValueError as error:
            raise SimulatorError(str(error)) from error
