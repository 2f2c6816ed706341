"""Where does the energy go while a body breaks in motion?

Question   Kinetic, stored, viscous and released energy of a strip that breaks from rest; how does
           what is left fall with the time step?
Candidate  Springs that break between two half kicks of velocity Verlet.
Reference  Nothing is left.
Expected   Second order in the step. Which springs break depends on the step.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from msvalidate import kit
from msvalidate.problem import Array
from msvalidate.problem.records import replace
from msvalidate.springs.bodies.toughness import crossings
from msvalidate.springs.dynamics.integrate import State, euler_cromer, motion
from msvalidate.springs.dynamics.integrators import EULER_CROMER, VELOCITY_VERLET
from msvalidate.springs.dynamics.ledger import Ledger
from msvalidate.springs.network import Network
from msvalidate.springs.network.breakage import Breakage
from msvalidate.springs.statics.equilibrium import equilibrium

from .springs import LATTICES, Grow, filled, pulled

STRETCH, RATE, TIME, OVER = 0.01, 0.1, 30.0, 1.15
"""Critical stretch, viscous rate (1/s), time (s), load over that of the first break."""
RULES = (
    kit.Rule(
        "order in the time step of what the ledger leaves", 0.3, "1",
        "velocity Verlet; other springs break at each step", table="books",
        power_of="dt", value="left", reference=2.0,
    ),
    kit.Rule(
        "what the ledger leaves at the finest step, over the released", 1e-4, "1",
        "second order", table="books", rows={"finest": True}, value="left",
    ),
    kit.Rule(
        "compiled and plain loops: springs that break in one alone", 0.5, "1",
        "the same operations", table="loops", value="other",
    ),
    kit.Rule(
        "compiled and plain loops: energy released, relative", 1e-9, "1", "rounding",
        table="loops", value="released", reference=1.0,
    ),
)  # fmt: skip
FIGURES = {
    "ledger": kit.series(
        "course", title="A strip that breaks: where the energy is", x="time",
        y={"stored": "stored", "kinetic": "kinetic", "viscous": "taken by viscosity",
           "released": "released by breaks"},
        size=(5.6, 3.6), labels=("time (s)", "energy over that at the start (1)"),
    ),
}  # fmt: skip


class Mends(Breakage):
    """Springs that come back when they shorten."""

    def look(self, displacement: Array) -> bool:
        """As of springs that break, after those below the critical stretch came back."""
        whole = Breakage(self.given, self.critical_stretch)
        whole.look(displacement)
        back = self.broken & ~whole.broken
        if back.any():
            stiffness = np.where(back, self.given.stiffness, self.network.stiffness)
            self.network = replace(self.network, stiffness=stiffness)
            self.broken = self.broken & ~back
        return super().look(displacement) or bool(back.any())

    def __init__(self, network: Network, critical_stretch: float) -> None:
        super().__init__(network, critical_stretch)
        self.given = network


class Late(Ledger):
    """Viscous work by the velocity after each step."""

    def __call__(self, step: int, state: State) -> None:
        """Book a step."""
        v = np.where(self.network.fixed, 0.0, state.velocity)
        self.viscous += self.dissipated(v, v, v)
        self.book(step, state)


def run(
    grow: Grow,
    setting: kit.Setting,
    springs: type[Breakage] = Breakage,
    ledger: type[Ledger] = Ledger,
) -> kit.Evidence:
    """A strip let go at more than it bears, by steps that are halved."""
    network = pulled(filled("square-8", 24, 11), LATTICES["square-8"][1])
    cut = crossings(network.points, network.springs, 5.5) <= 8
    network = replace(network, stiffness=np.where(cut, 0.0, network.stiffness))
    load = OVER * grow(network, STRETCH, most_breaks=1).load
    network = replace(network, displacement=load * network.displacement)
    start = State(equilibrium(network).position, np.zeros_like(network.points))
    rows, halved = [], 4 if setting.quick else 5
    for times in range(halved):
        dt = 0.1 / 2**times if setting.quick else 0.2 / 2**times
        broken = springs(network, STRETCH)
        book = ledger(network, broken, start, dt, RATE)
        steps = round(TIME / dt)
        motion(network, start, VELOCITY_VERLET, dt, steps, RATE, watch=book, breakage=broken)
        course = book.table()
        rows.append({
            "dt": dt, "broken": int(broken.broken.sum()), "left": book.closure,
            "finest": times == halved - 1,
        })  # fmt: skip
    course = course.iloc[:: len(course) // 40]
    energies = ["stored", "kinetic", "viscous", "released"]
    tables = {
        "books": pd.DataFrame(rows), "loops": pd.DataFrame([loops(network, start)]),
    }  # fmt: skip
    drawn = course[["time"]].join(course[energies] / course["stored"].iloc[0])
    counts = tables["books"]["broken"]
    finding = (
        f"A strip let go at {OVER:g} times the load of its first break breaks "
        f"{counts.min()} to {counts.max()} springs, by the time step; its ledger closes to "
        f"{rows[-1]['left']:.0e} of what is released, with the square of the step."
    )
    return kit.Evidence(
        tables, tolerances=RULES, columns=kit.columns(__file__), findings=(finding,),
        figures=FIGURES, drawn={"course": drawn},
    )  # fmt: skip


def loops(network: Network, start: State, dt: float = 0.1) -> dict[str, object]:
    """The compiled loop beside the plain one."""
    plain, fast = (Breakage(network, STRETCH) for _ in range(2))
    steps = round(TIME / dt)
    motion(network, start, EULER_CROMER, dt, steps, RATE, breakage=plain)
    euler_cromer(network, start, dt, steps, RATE, breakage=fast)
    return {
        "dt": dt, "broken": int(plain.broken.sum()),
        "other": int((plain.broken ^ fast.broken).sum()),
        "released": fast.released / plain.released,
    }  # fmt: skip
