"""Single steps of a block from positions at rest, and required statements."""

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
    Simulator,
    SimulatorError,
    ask,
)
from msvalidate.simulators.probe.block import Block, wave_speed

ENGINEERING = {2: np.array([1.0, 1.0, 2.0]), 3: np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])}
"""Factors of strains by the number of axes: shear strains count twice."""


@dataclass(frozen=True, eq=False)
class Push:
    """Mean stress, gradient and nodal forces in one state.

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

    def odd(self, back: Push) -> Push:
        """Half the difference to what the opposite gradient told: even parts drop out."""
        stress, gradient = self.stress - back.stress, self.gradient - back.gradient
        return Push(stress / 2, gradient / 2, (self.force - back.force) / 2)


def voigt(tensor: Array) -> Array:
    """Components (6,) or (3,) of the symmetric part of a tensor (d, d), in Voigt's order."""
    first, second = np.transpose(VOIGT[len(tensor)])
    return np.asarray((tensor + tensor.T)[first, second] / 2)


SAID = {
    "precision": get_args(Precision),
    "forces_at": get_args(ForcesAt),
    "mass": get_args(MassKind),
}
"""Statements that an answer must contain.

No step shows them, and each changes the result.
"""


@dataclass(frozen=True, eq=False)
class Bench:
    """A simulator with a block: asked for one step, at rest, without weight unless it is given.

    Parameters
    ----------
    dt
        Length of the step, s.
    precision
        Positions are rounded to it, so that the simulator starts where it was told.
    inertia
        Velocities (n, 3) -> momentum, kg m/s.
    forces_at
        Of the step: "start" or "end".
    consistent
        Whether the mass matrix is not diagonal.
    solves_to
        Part of a step's change of velocity that its solver leaves, as stated.
    settle
        Displacements (n, d) of a uniform strain -> those that a step starts from.
    """

    simulator: Simulator
    block: Block
    dt: float
    precision: Precision = "float64"
    settings: Mapping[str, Any] = field(default_factory=dict)
    inertia: Callable[[Array], Array] = lambda v: v
    forces_at: str = "start"
    consistent: bool = False
    solves_to: float = 0.0
    settle: Callable[[Array], Array] = lambda u: u

    def push(self, G: Array, *, gravity: tuple[float, ...] = ()) -> Push:
        """Measure the response to a uniform displacement gradient G.

        Points are at c + (I + G)(X - c), with c the block's middle, the origin.

        Raises
        ------
        CannotRepresent, SimulatorError
            As the simulator.
        """
        X, block = self.block.mesh.points, self.block
        move = self.settle(X @ G.T)
        answer = self.step(move, gravity)
        force = answer.force
        if force is None:
            force = np.asarray(self.inertia(np.asarray(answer.velocity)) / self.dt)
        place = self.placed(move) if self.forces_at == "start" else np.asarray(answer.position)
        return Push(-force.T @ X / block.volume, (place - X).T @ block.weights, force)

    def step(self, move: Array, gravity: tuple[float, ...] = ()) -> Answer:
        """Request one step from the mesh displaced by `move` (n, 3) m.

        Raises
        ------
        CannotRepresent, SimulatorError
            As `ask`; and `SimulatorError` where the answer does not say what it must.
        """
        start = self.placed(move)
        request = self.block.request("motion", start=start, dt=self.dt, settings=self.settings)
        answer = ask(self.simulator, replace(request, gravity=np.array(gravity or request.gravity)))
        _refuse_silence(answer)
        return answer

    def placed(self, move: Array) -> Array:
        """Positions (n, 3) m that the step starts from."""
        start = self.block.mesh.points + move
        return np.asarray(start.astype(self.precision), dtype=float)


def first_step(
    simulator: Simulator, block: Block, settings: Mapping[str, Any] | None
) -> tuple[Bench, Answer]:
    """Take a step without strain, and return its bench and answer.

    The bench has the precision, and the place of the forces, that the answer states.
    The step is the largest power of two (s) below the time in which a pressure wave of the
    requested material crosses the smallest cell. A power of two is exact.
    """
    dt = float(2.0 ** np.floor(np.log2(block.height / wave_speed(block.material))))
    bench = Bench(simulator, block, dt, "float32", dict(settings or {}))
    first = bench.step(np.zeros(block.mesh.points.shape))
    forces_at = "start" if first.force is not None else str(first.about["forces_at"])
    return replace(bench, precision=first.about["precision"], forces_at=forces_at), first


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
