"""Energy balance of a motion with breaking springs.

A motion calls it as its `watch`.

Which springs break depends on the time step, so their number is told with its spread over steps;
what the ledger leaves does not: by velocity Verlet, whose springs break between two half kicks, it
falls with the square of the step, under viscosity too.
"""

from __future__ import annotations

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from msvalidate.problem import Array
from msvalidate.springs.dynamics.integrate import State, damping_rate
from msvalidate.springs.network import Configuration, Network
from msvalidate.springs.network.breakage import Breakage


class Ledger:
    """Watches a motion by velocity Verlet, and books each kind of energy on its own.

    `network`, `state`, `dt`, `damping`: as in `integrate.motion`; supports must not move.
    `breakage`: that of the motion.
    """

    def __init__(
        self, network: Network, breakage: Breakage, state: State, dt: float, damping: ArrayLike
    ) -> None:
        self.network, self.breakage, self.dt = network, breakage, dt
        self.drag = damping_rate(network, damping) * network.mass
        self.start = np.asarray(state.position, dtype=float)
        self.viscous = 0.0
        self.last = state
        self.rows: list[tuple[float, ...]] = []
        self.book(0, state)

    def dissipated(self, before: Array, half: Array, after: Array) -> float:
        """Viscous work (J) in a step.

        It follows from the velocities (n, d) before, in and after the step.

        Each half kick damps by the velocity before it, and goes on at the mean of its two.
        """
        first = (before * (before + half)).sum(axis=1) + (half * (half + after)).sum(axis=1)
        return self.dt / 4 * float(self.drag @ first)

    def __call__(self, step: int, state: State) -> None:
        """Book a step."""
        free = ~self.network.fixed
        before, self.last = self.last, state
        half = (state.position - before.position) / self.dt
        moving = before.velocity, half, state.velocity
        self.viscous += self.dissipated(*(free * v for v in moving))
        self.book(step, state)

    def book(self, step: int, state: State) -> None:
        """Add a row."""
        u = state.position - self.network.points
        v = np.where(self.network.fixed, 0.0, state.velocity)
        kinetic = float(self.network.mass @ (v**2).sum(axis=1)) / 2
        stored = Configuration(self.breakage.whole(self.network), u).energy()
        loads = float((self.network.force * (state.position - self.start)).sum())
        self.rows.append(
            (step * self.dt, kinetic, stored, self.viscous, self.breakage.released, loads)
        )

    def table(self) -> pd.DataFrame:
        """A row each step: time (s), and energies in J.

        Kinetic and stored; what viscosity and breaks took and loads gave since the start; `left`,
        what all that is beyond the first row's: 0 but for the step.
        """
        names = ("time", "kinetic", "stored", "viscous", "released", "external")
        table = pd.DataFrame(self.rows, columns=list(names))
        total = table[["kinetic", "stored", "viscous", "released"]].sum(axis=1) - table["external"]
        return table.assign(left=total - total.iloc[0])

    @property
    def closure(self) -> float:
        """Largest part that is left, over the energy released, or the first if nothing was."""
        table = self.table()
        energy = table["released"].iloc[-1] or table[["kinetic", "stored"]].iloc[0].sum() or 1.0
        return float(np.abs(table["left"]).max() / energy)
