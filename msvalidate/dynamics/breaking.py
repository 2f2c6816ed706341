"""A body that breaks in motion, with its ledger: where the energy went.

Which springs break depends on the time step, so their number is told with its spread over steps;
what the ledger leaves does not: it falls with the square of the step.
"""

from __future__ import annotations

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from msvalidate.dynamics.integrate import State, damping_rate, motion
from msvalidate.dynamics.integrators import VELOCITY_VERLET
from msvalidate.network import Configuration, Network
from msvalidate.network.breakage import Breakage
from msvalidate.problem import Array
from msvalidate.problem.records import dataclass


@dataclass(frozen=True, eq=False)
class Breaking:
    """A motion in which springs broke.

    Parameters
    ----------
    state
        At the end.
    breakage
        Which springs broke.
    ledger
        A row each step: time (s), and in J what is kinetic and stored, what viscosity and breaks
        took and loads gave since the start; `left` is the sum of all that less the first row's,
        which would be 0.
    """

    state: State
    breakage: Breakage
    ledger: pd.DataFrame

    @property
    def closure(self) -> float:
        """Largest part that is left, over the energy released; 0 where nothing broke."""
        released = self.breakage.released
        return float(np.abs(self.ledger["left"]).max()) / released if released else 0.0


def break_up(
    network: Network,
    state: State,
    critical_stretch: float,
    dt: float,
    steps: int,
    damping: ArrayLike = 0.0,
) -> Breaking:
    """Motion of a network whose springs break, by velocity Verlet, and its ledger.

    Supports stay where they are. A spring breaks between two half kicks, with the energy that it
    has there; viscous work is by the trapezoidal rule of the velocities at the ends of a step. So
    what the ledger leaves is of second order in dt.

    Parameters
    ----------
    network, critical_stretch
        As of `Breakage`.
    state, dt, steps, damping
        As of `motion`.

    Raises
    ------
    ProblemError, SolverError
        As `Breakage` and `motion`.
    """
    breakage = Breakage(network, critical_stretch)
    ledger = Ledger(network, breakage, state, dt, damping)
    end = motion(
        network, state, VELOCITY_VERLET, dt, steps, damping, watch=ledger, breakage=breakage
    )
    return Breaking(end, breakage, ledger.table())


class Ledger:
    """Watches a motion, and books each kind of energy on its own.

    Parameters
    ----------
    network, breakage, state, dt, damping
        As in `break_up`.
    """

    def __init__(
        self, network: Network, breakage: Breakage, state: State, dt: float, damping: ArrayLike
    ) -> None:
        self.network, self.breakage, self.dt = network, breakage, dt
        self.drag = damping_rate(network, damping) * network.mass
        self.start = np.asarray(state.position, dtype=float)
        self.viscous = 0.0
        self.power = self.dissipated(np.where(network.held, 0.0, state.velocity))
        self.rows: list[tuple[float, ...]] = []
        self.book(0, state)

    def dissipated(self, velocity: Array) -> float:
        """Power (W) of viscosity at a velocity (n, d)."""
        return float(self.drag @ (velocity**2).sum(axis=1))

    def __call__(self, step: int, state: State) -> None:
        """Book a step."""
        before, self.power = self.power, self.dissipated(state.velocity)
        self.viscous += self.dt * (before + self.power) / 2
        self.book(step, state)

    def book(self, step: int, state: State) -> None:
        """Add a row."""
        u = state.position - self.network.points
        v = np.where(self.network.held, 0.0, state.velocity)
        kinetic = float(self.network.mass @ (v**2).sum(axis=1)) / 2
        stored = Configuration(self.breakage.network, u).energy()
        loads = float((self.network.force * (state.position - self.start)).sum())
        self.rows.append(
            (step * self.dt, kinetic, stored, self.viscous, self.breakage.released, loads)
        )

    def table(self) -> pd.DataFrame:
        """What was booked."""
        names = ("time", "kinetic", "stored", "viscous", "released", "external")
        table = pd.DataFrame(self.rows, columns=list(names))
        total = table[["kinetic", "stored", "viscous", "released"]].sum(axis=1) - table["external"]
        return table.assign(left=total - total.iloc[0])
