"""Figure 3: which scheme is unstable, and are the other curves alike?

Question   "Explicit Euler is the most likely one to be unstable. Others methods have nearly the
           same smooth x-t curve": is it so at one step for all, below the limit and above it?
Candidate  Each of the four schemes, 6 x 6 particles with k2 = 2 k1, clamped on one side and pulled
           suddenly on the other, little damped.
Reference  Velocity Verlet with small steps; the stability limits in closed form.
Expected   Explicit Euler leaves at each step that the others bear: its limit is c/ω_max² here.
           The others differ by their error: the first order of Euler-Cromer is to be seen.
"""

from __future__ import annotations

from functools import partial
from itertools import product
from typing import NamedTuple

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from msvalidate import kit
from msvalidate.springs.dynamics.integrators import INTEGRATORS
from msvalidate.springs.dynamics.scheme import Integrator
from msvalidate.springs.dynamics.spectrum import extreme_frequencies
from msvalidate.springs.dynamics.step_limits import stability_limit
from msvalidate.springs.statics.equilibrium import equilibrium

from . import common, runs
from .common import Schemes

TRACTION = (0.1, 0.0)
"""Pull (N/m²): a strain of 6 %, springs stretch and turn."""
DAMPING = 0.2
"""Over critical damping of the lowest mode, 2ω_min: it overshoots."""
PARTS = (0.1, 0.25, 0.5, 0.9, 1.05, 1.2)
QUICK_PARTS = (0.25, 0.5, 1.05)
"""Step over the limit of Euler-Cromer."""
DRAWN = (0.5, 1.05)
PERIODS = 2.5
"""Of the lowest mode: length of the run."""
REACH = 4.0
"""Over the largest displacement at rest: a suddenly loaded body overshoots to twice it."""
FINE = 0.05
"""Step of the reference over the limit."""
OTHERS = common.REPORTED[1:]
NEARLY = 0.1
"""Distance between curves, over their range, that a reader of a printed figure hardly sees."""
LEAVES = kit.Rule(
    "schemes that leave below their limit, or stay above it", 0.0, "1",
    "steps are 5 % or more from every limit: growth is by tens of percents a step there, and "
    "the load excites the highest mode",
    table="figure3",
    value=lambda rows: (rows["leaves_at_step"] != "stays") != (rows["leaves_expected"] == "yes"),
)  # fmt: skip


def run(candidate: Schemes = INTEGRATORS, setting: kit.Setting = kit.FULL) -> kit.Evidence:
    """Run the four schemes at the same steps and compare their curves."""
    schemes = common.chosen(candidate)
    parts = QUICK_PARTS if setting.quick else PARTS
    cases = list(product(parts, schemes.items()))
    block = pulled_block()
    fine = displacement(block, INTEGRATORS["velocity_verlet"], FINE)[:2]
    found = setting.sweep(partial(curve, block, fine), cases, "Figure 3")
    table = pd.DataFrame([row for row, _ in found])
    curves = pd.concat(
        [line for (part, _), (_, line) in zip(cases, found, strict=True) if part in DRAWN]
    )
    apart = largest_distance(found, cases)
    near = kit.Tolerance(
        "other schemes' curves at half the limit, largest distance over their range", NEARLY, "1",
        "Euler-Cromer runs ahead by half a step, h/2·v: the lowest mode's h·ω is 0.06 here, "
        "so 3 % of its amplitude, and more where higher modes take part",
        layer="agreement", observed=kit.Observed(apart),
    )  # fmt: skip
    return kit.Evidence(
        tables={"figure3": table, "figure3_curves": curves},
        tolerances=(LEAVES, near),
        figures={"figure3": draw},
        columns=kit.columns(__file__),
        findings=(finding(table, apart),),
    )


class PulledBlock(NamedTuple):
    """What is run, and which particle of it is followed.

    `period` (s) is that of the lowest mode, `damping` in 1/s, `at_rest` (m) the largest
    displacement of the static solution.
    """

    network: kit.Network
    period: float
    damping: float
    at_rest: float
    particle: int

    def limit(self, scheme: Integrator) -> float:
        """A scheme's own stability limit (s)."""
        return stability_limit(scheme, *extreme_frequencies(self.network), self.damping)


def pulled_block() -> PulledBlock:
    """The report's block, with the middle particle of the side that is pulled."""
    _, network = runs.block(TRACTION)
    lowest, _ = extreme_frequencies(network)
    at_rest = float(np.abs(equilibrium(network).displacement).max())
    right = np.flatnonzero(network.points[:, 0] == network.points[:, 0].max())
    middle = int(right[len(right) // 2])
    return PulledBlock(network, 2 * np.pi / lowest, 2 * DAMPING * lowest, at_rest, middle)


def displacement(
    block: PulledBlock, scheme: Integrator, part: float
) -> tuple[kit.Array, kit.Array, int]:
    """Times in periods and displacements (m) of the particle; the step that leaves, or 0."""
    dt = part * block.limit(INTEGRATORS["euler_cromer"])
    steps = int(PERIODS * block.period / dt)
    reach = REACH * block.at_rest
    found = runs.release_network(block.network, scheme, dt, steps, block.damping, reach)
    x = found.positions[:, block.particle, 0] - block.network.points[block.particle, 0]
    time = np.arange(len(x)) * (dt / block.period)
    return np.asarray(time), np.asarray(x), found.left


def curve(
    block: PulledBlock,
    fine: tuple[kit.Array, kit.Array],
    case: tuple[float, tuple[str, Integrator]],
) -> tuple[dict[str, object], pd.DataFrame]:
    """Row of a scheme at a step, and its curve; `fine` is the reference's."""
    part, (name, scheme) = case
    time, x, left = displacement(block, scheme, part)
    exact_time, exact = fine
    own = block.limit(scheme) / block.limit(INTEGRATORS["euler_cromer"])
    distance = np.abs(x - np.interp(time, exact_time, exact)).max() / np.ptp(exact)
    row = {
        "scheme": name,
        "step_over_limit": part,
        "limit_over": own,
        "leaves_at_step": left or "stays",
        "leaves_expected": "yes" if part > own else "no",
        "distance": "leaves" if left else distance,
    }
    line = {
        "scheme": name,
        "step_over_limit": part,
        "step": np.arange(len(x)),
        "time": time,
        "x": x,
    }
    return row, pd.DataFrame(line)


def largest_distance(
    found: list[tuple[dict[str, object], pd.DataFrame]],
    cases: list[tuple[float, tuple[str, Integrator]]],
) -> float:
    """Largest distance of the others' curves at half the limit, over their range; NaN if gone."""
    lines = [
        line["x"].to_numpy()
        for (part, (name, _)), (row, line) in zip(cases, found, strict=True)
        if part == DRAWN[0] and name in OTHERS and row["leaves_at_step"] == "stays"
    ]
    if len(lines) < len(OTHERS):
        return float("nan")
    together = np.array(lines)
    return float(np.ptp(together, axis=0).max() / np.ptp(together))


def finding(table: pd.DataFrame, apart: float) -> str:
    """The report's two sentences, in numbers."""
    own = table[table["scheme"] == "explicit_euler"]["limit_over"].iloc[0]
    early = table[(table["step_over_limit"] <= DRAWN[0]) & (table["leaves_at_step"] != "stays")]
    gone = ", ".join(map(common.title, dict.fromkeys(early["scheme"]))) or "no scheme"
    below = table[table["step_over_limit"] == DRAWN[0]].set_index("scheme")
    said = ", ".join(
        f"{common.title(name)} {below['leaves_at_step'][name]}" for name in below.index
    )
    far = ", ".join(
        f"{common.title(name)} {100 * below['distance'][name]:.1f} %"
        for name in OTHERS
        if below["distance"][name] != "leaves"
    )
    return (
        f"Figure 3: with steps up to {DRAWN[0]:g} of Euler-Cromer's limit {gone} leaves the "
        f"picture (at that step by step number: {said}); explicit Euler's own limit is "
        f"{1 / own:.0f} times smaller. The others' curves are at most {100 * apart:.1f} % of their "
        "range apart, which is "
        f"{'nearly the same' if apart < NEARLY else 'not the same'}; from the curve of fine steps: "
        f"{far}."
    )


def draw(tables: kit.Tables) -> Figure:
    """The report's Figure 3 redrawn: one particle under all schemes, below and above the limit."""
    curves = tables["figure3_curves"]
    figure, axes = kit.figures.new_figure(2, size=(3.6, 3.2), sharey=True)
    top = 1.5 * curves[curves["scheme"].isin(OTHERS)]["x"].abs().quantile(0.98)
    for axis, part in zip(axes, DRAWN, strict=True):
        for name, line in curves[curves["step_over_limit"] == part].groupby("scheme", sort=False):
            scheme = str(name)
            axis.plot(
                line["time"],
                line["x"],
                marker=common.marker(scheme),
                markevery=8 if part < 1 else 1,
                ms=3.5,
                mfc="none",
                lw=1,
                color=common.colour(scheme),
                label=common.title(scheme),
            )
        axis.set(xlabel="time over the lowest\nmode's period (1)", ylim=(-0.3 * top, top))
        axis.set_title(f"step {part:g} of Euler-Cromer's limit")
    axes[0].set_ylabel("displacement x of a particle (m)")
    figure.suptitle("One particle under four schemes, after the report's Figure 3")
    kit.figures.add_shared_legend(figure, axes)
    return figure
