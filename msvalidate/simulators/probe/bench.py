"""One step of a block from positions at rest, and what a simulator must say about it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal, get_args

import numpy as np

from msvalidate.problem import Array
from msvalidate.problem.checks import require_one_of
from msvalidate.problem.records import dataclass, field, replace
from msvalidate.simulators.exchange.protocol import (
    Answer,
    ForcesAt,
    Request,
    Simulator,
    SimulatorError,
    ask,
)
from msvalidate.simulators.probe.block import Block

Precision = Literal["float64", "float32"]
ROUNDING = {"float64": 2.0**-53, "float32": 2.0**-24}
"""Largest relative error of a rounded number."""
SAID = {
    "precision": get_args(Precision),
    "forces_at": get_args(ForcesAt),
    "mass": ("lumped", "consistent", "one point"),
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
        refuse_silence(answer)
        return answer

    def placed(self, move: Array) -> Array:
        """Positions (n, 3) m that the step starts from."""
        start = self.block.mesh.points + move
        return np.asarray(start.astype(self.precision), dtype=float)

    def with_step(self, dt: float) -> Bench:
        """The same with a step of another length, s."""
        return replace(self, dt=dt)


def refuse_silence(answer: Answer) -> None:
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
