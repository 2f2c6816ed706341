"""Passing: does underdamped motion push particles past each other?

Question   "Usually, underdamped system with over-shots will cause further unstable effect, for
           example, one particle pass another particle": how many cells of the lattice turn inside
           out on the way, against damping and time step?
Candidate  Euler-Cromer, the report's loop, on its 6 x 6 particles with k2 = 2 k1, clamped on one
           side and sheared suddenly on the other.
Reference  The static solution under the same load, whose cells are all the right way round.
Expected   Overshoot to about twice the static displacement folds cells that the load at rest does
           not. Overdamped, nothing does; critical damping of the lowest mode leaves all others
           underdamped. The step, below its limit, changes little.
"""

from __future__ import annotations

from functools import partial
from itertools import product

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from msvalidate import kit
from msvalidate.springs.dynamics.integrators import INTEGRATORS
from msvalidate.springs.dynamics.scheme import Integrator
from msvalidate.springs.dynamics.spectrum import extreme_frequencies
from msvalidate.springs.dynamics.step_limits import stability_limit
from msvalidate.springs.lattice import Lattice
from msvalidate.springs.statics.equilibrium import equilibrium

from . import common, runs
from .common import Schemes

LOADS = (0.03, 0.2, 0.3, 0.4)
QUICK_LOADS = (0.03, 0.3)
"""Shear traction (N/m²).

At equilibrium, 0.03 strains springs by up to 6 % and 0.2 by up to 46 %.
"""
DAMPINGS = (0.0, 0.1, 0.25, 0.5, 1.0, 2.0)
QUICK_DAMPINGS = (0.1, 1.0, 2.0)
"""Over critical damping of the lowest mode."""
PARTS = (0.3, 0.5, 0.7, 0.9, 1.2)
QUICK_PARTS = (0.5, 1.2)
"""Step over the limit."""
PERIODS = 1.0
"""Of the lowest mode: the first overshoot is the largest."""
REACH = 10.0
"""Displacement (m) of a point beyond which a motion counts as growing."""
judged = partial(kit.Rule, limit=0.0, unit="1", layer="agreement", table="passing")
RULES = (
    judged(
        "cells inside out at twice critical damping, most of all runs",
        rows={"c_over_critical": 2.0},
        value=lambda rows: pd.to_numeric(rows["cells_inverted"], errors="coerce").max(),
        because="nothing overshoots, and the cells of the static solution are the right way round",
    ),
    judged(
        "runs above the limit that do not grow, or below it that do",
        value=lambda rows: (rows["cells_inverted"] == "grows") != (rows["step_over_limit"] > 1),
        because="the largest step below is 0.9, the smallest above 1.2 of the limit at rest, which "
        "strain changes by less",
    ),
)  # fmt: skip


def run(candidate: Schemes = INTEGRATORS, setting: kit.Setting = kit.FULL) -> kit.Evidence:
    """Count the cells turned inside out at every load, damping and step."""
    loads = QUICK_LOADS if setting.quick else LOADS
    dampings = QUICK_DAMPINGS if setting.quick else DAMPINGS
    parts = QUICK_PARTS if setting.quick else PARTS
    scheme = common.chosen(candidate, ("euler_cromer",))["euler_cromer"]
    cases = list(product(loads, dampings, parts))
    table = pd.DataFrame(
        setting.sweep(partial(count_inverted, scheme), cases, "particles that pass")
    )
    return kit.Evidence(
        tables={"passing": table},
        tolerances=RULES,
        figures={"passing": draw},
        columns=kit.columns(__file__),
        findings=(finding(table),),
    )


def areas(grid: Lattice, position: kit.Array) -> kit.Array:
    """Signed areas (..., c) in m² of a square lattice's cells at positions (..., n, 2) in m."""
    low_left, low_right, high_right, high_left = (
        position[..., corner, :] for corner in grid.cells.T
    )
    rising, falling = high_right - low_left, high_left - low_right
    return np.asarray(0.5 * (rising[..., 0] * falling[..., 1] - rising[..., 1] * falling[..., 0]))


def count_inverted(scheme: Integrator, case: tuple[float, float, float]) -> dict[str, object]:
    """Row of one load, damping and step."""
    load, over_critical, part = case
    grid, network = runs.block((0.0, load))
    omega = extreme_frequencies(network)
    damping = 2 * over_critical * omega[0]
    dt = part * stability_limit(scheme, *omega, damping)
    steps = int(PERIODS * 2 * np.pi / omega[0] / dt)
    done = runs.release_network(network, scheme, dt, steps, damping, REACH)
    static = equilibrium(network)
    at_rest = np.linalg.norm(static.displacement, axis=1).max()
    farthest = np.linalg.norm(done.positions - network.points, axis=2).max()
    inverted = (areas(grid, done.positions) < 0).sum(axis=1).max()
    return {
        "traction": load,
        "c_over_critical": over_critical,
        "step_over_limit": part,
        "cells_inverted": "grows" if done.left else int(inverted),
        "cells_inverted_static": int((areas(grid, static.position) < 0).sum()),
        "largest_over_static": "grows" if done.left else float(farthest / at_rest),
    }


def finding(table: pd.DataFrame) -> str:
    """Whether the report is right, with the numbers of the largest load."""
    stays = table[(table["cells_inverted"] != "grows")]
    most = stays[stays["traction"] == stays["traction"].max()]
    worst = most.groupby("c_over_critical")["cells_inverted"].max()
    over = most.groupby("c_over_critical")["largest_over_static"].max()
    said = ", ".join(f"{n} at {d:g} (farthest {over[d]:.2f} of rest)" for d, n in worst.items())
    under, above = worst[worst.index < 1].max(), worst[worst.index > 1].max()
    return (
        f"Most cells of 25 turned inside out under {most['traction'].max():g} N/m², by damping "
        f"over critical: {said}; at rest {most['cells_inverted_static'].max()}. The report is "
        f"{'right' if under > 0 == above else 'not right'} that underdamped particles pass each "
        "other and overdamped ones do not."
    )


def draw(tables: kit.Tables) -> Figure:
    """Cells turned inside out against damping, a line a step, a panel a load."""
    table = tables["passing"]
    loads = sorted(set(table["traction"]))
    figure, axes = kit.figures.new_figure(
        len(loads), size=(7.2 / max(len(loads), 2), 3.3), sharey=True
    )
    for axis, load in zip(axes, loads, strict=True):
        rows = table[(table["traction"] == load) & (table["cells_inverted"] != "grows")]
        for i, (part, line) in enumerate(rows.groupby("step_over_limit")):
            axis.plot(
                line["c_over_critical"],
                line["cells_inverted"].astype(float),
                marker=kit.figures.MARKERS[i],
                color=kit.figures.COLOURS[i],
                mfc="none",
                label=f"step {part:g} of the limit",
            )
        axis.axvline(1, color="grey", lw=0.8, ls="--", label="critical damping")
        axis.set(title=f"traction {load:g} N/m²", xlabel="damping over\ncritical (1)")
    axes[0].set_ylabel("cells inside out, of 25 (1)")
    figure.suptitle("Cells that a pull turns inside out")
    kit.figures.add_shared_legend(figure, axes, columns=min(3, 1 + len(loads)))
    return figure
