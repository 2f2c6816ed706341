"""One affine state of a block: the forces that came of it, their mean stress, its mean strain."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from msvalidate.problem import VOIGT, Array
from msvalidate.problem.records import dataclass, replace
from msvalidate.simulators.exchange.protocol import SimulatorError
from msvalidate.simulators.probe.bench import Bench

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
        told = answer.force is not None
        if answer.force is not None:
            force = answer.force
        elif answer.velocity is not None:
            force = self.inertia(answer.velocity) / bench.dt
        else:
            raise SimulatorError("answer: neither force nor velocity")
        if told or self.forces_at == "start" or answer.position is None:
            place = bench.placed(move)
        else:
            place = answer.position
        gradient = (place - X).T @ bench.block.weights
        return Push(-force.T @ X / bench.block.volume, gradient, np.asarray(force))

    def with_step(self, dt: float) -> Station:
        """The same with a step of another length, s."""
        return replace(self, bench=self.bench.with_step(dt))


def voigt(tensor: Array) -> Array:
    """Components (6,) of the symmetric part of a tensor (3, 3), in order xx, yy, zz, yz, xz, xy."""
    first, second = np.transpose(VOIGT[3])
    return np.asarray((tensor + tensor.T)[first, second] / 2)
