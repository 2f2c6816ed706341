"""Algorithm 1: does the report's loop reach the equilibrium, and the linear ratio?

Question   Does Euler-Cromer with virtual viscosity bring the report's 6 x 6 particles to the static
           equilibrium, and the ratio to its small-strain value?
Candidate  `algorithm1`, step and damping chosen from the network's own frequencies.
Reference  Newton's method on the same network; the linear solution.
Expected   The same rest position, to the residual at which it stops; a ratio that differs from the
           linear one in proportion to the strain.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import product

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from msvalidate import kit
from msvalidate.springs import lattice
from msvalidate.springs.dynamics.relax import algorithm1
from msvalidate.springs.dynamics.run import Relaxation

from . import block

CELLS = 5
WEIGHTS = "equal"
CONSTANTS = (0.5, 2.0)
"""k2/k1: isotropic, and the report's "incompressible"."""
STRAINS = (1e-4, 1e-3, 1e-2)
MAGNIFIED = 20
"""Factor on the displacements in the picture of the block."""
ARROW = 0.12
"""Length (m) of the arrows there."""
RULES = (
    kit.Rule(
        "rest position against Newton, relative to the largest displacement", 1e-8, "1",
        "stops at 1e-10 of the forces; their error grows by at most the condition number, 4e2",
        table="algorithm1", value="difference",
    ),
    kit.Rule(
        "order in the strain of the ratio towards the linear one, k2 = 2 k1", 0.01, "1",
        "the first term of the series; the next is smaller by the strain, at most 1e-2, times a "
        "factor of up to 4, and the line runs over two decades: it weighs 1/(2 ln 10) in the slope",
        table="algorithm1", rows={"k2": CONSTANTS[-1]}, power_of="strain", reference=1.0,
        value=lambda rows: (rows["nu_algorithm1"] - rows["nu_linear"]).abs(),
    ),
    kit.Rule(
        "ratio against the linear one, times 1/strain", 0.35, "1",
        "the bulk drifts by 0.28 per strain at k2 = 2 k1; equal springs on the edge change it by "
        "the order of 1/N = 0.2 of that",
        table="algorithm1",
        value=lambda rows: (rows["nu_algorithm1"] - rows["nu_linear"]) / rows["strain"],
    ),
)  # fmt: skip


def run(
    relaxation: Callable[[kit.Network], Relaxation] = algorithm1,
    candidate: kit.DisplacementSolver = kit.solve_springs,
    setting: kit.Setting = kit.FULL,
) -> kit.Evidence:
    """Relax the report's block and compare it with Newton's method."""
    cases = list(product(CONSTANTS, STRAINS))
    found = setting.sweep(partial(relax_block, relaxation, candidate), cases, "Algorithm 1")
    table = pd.DataFrame([row for row, _ in found])
    last = found[-1][1]
    history = pd.DataFrame(last.history, columns=["step", "residual_N", "kinetic_energy_J"])
    places = np.hstack([last.equilibrium.position, last.equilibrium.displacement])
    return kit.Evidence(
        tables={"algorithm1": table, "block": pd.DataFrame(places, columns=["x", "y", "ux", "uy"])},
        tolerances=RULES,
        drawn={"rest": history.astype({"step": int})},
        figures={"rest": draw, "block": draw_block},
        cover="block",
        columns=kit.columns(__file__),
    )


def relax_block(
    relaxation: Callable[[kit.Network], Relaxation],
    candidate: kit.DisplacementSolver,
    case: tuple[float, float],
) -> tuple[dict[str, object], Relaxation]:
    """One row, and the run that it tells of."""
    k2, strain = case
    problem, network = block.spring_block("slide", k2, CELLS, WEIGHTS, strain)
    rest = relaxation(network)
    newton, linear = (candidate(problem, network, g) for g in ("nonlinear", "linear"))
    move = rest.equilibrium.displacement
    row = {
        "weights": WEIGHTS,
        "k1": block.K1,
        "k2": k2,
        "strain": strain,
        "steps": rest.steps,
        "step_over_limit": rest.dt / rest.stability_limit,
        "difference": float(np.abs(move - newton).max() / np.abs(newton).max()),
        "nu_algorithm1": block.ratio(network.points, move, "edges"),
        "nu_newton": block.ratio(network.points, newton, "edges"),
        "nu_linear": block.ratio(network.points, linear, "edges"),
    }
    return row, rest


def draw(tables: kit.Tables) -> Figure:
    """Residual and kinetic energy against the step: equal springs, k2 = 2 k1, strain 1 %."""
    rest = tables["rest"]
    figure, (force, energy) = kit.figures.new_figure(2, size=(3.4, 2.8))
    force.semilogy(rest["step"], rest["residual_N"], color=kit.figures.COLOURS[0])
    force.set(ylabel="residual force (N)", title="what is left of the forces")
    moving = rest[rest["kinetic_energy_J"] > 0]
    energy.semilogy(moving["step"], moving["kinetic_energy_J"], color=kit.figures.COLOURS[1])
    energy.set(ylabel="kinetic energy (J)", title="what is left of the motion")
    for axis in (force, energy):
        axis.set_xlabel("time step (1)")
    figure.suptitle("Algorithm 1 comes to rest: springs alike, k2 = 2 k1, strain 1 %")
    return figure


def draw_block(tables: kit.Tables) -> Figure:
    """The report's 5 x 5 cells of equal springs with its k2 = 2 k1 at 1 % strain, ends sliding."""
    block_table = tables["block"]
    moved = block_table[["x", "y"]].to_numpy()
    first = moved - block_table[["ux", "uy"]].to_numpy()
    shown = first + MAGNIFIED * (moved - first)
    figure, (axis,) = kit.figures.new_figure(size=(4.6, 4.5))
    springs = lattice.square(block.BOX, CELLS).springs
    kit.body_drawing.draw_springs(
        axis, first, springs, "springs, at rest", kit.body_drawing.AT_REST
    )
    kit.body_drawing.draw_springs(axis, shown, springs, "springs, pulled")
    kit.body_drawing.draw_particles(axis, shown)
    k2, strain = CONSTANTS[-1], STRAINS[-1]
    problem, _ = block.spring_block("slide", k2, CELLS, WEIGHTS, strain)
    stretch = 1 + MAGNIFIED * strain * np.array([1.0, -k2 / (block.K1 + k2)])
    corners = block.SIDE * np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) * stretch
    elastic = "elastic body, ratio k2/(k1 + k2)"
    kit.body_drawing.draw_outline(axis, corners, elastic, color=kit.figures.COLOURS[1])
    held, _ = kit.prescribed_displacements(problem, first)
    kit.body_drawing.draw_supports(axis, shown, held)
    pulled = shown[np.isclose(first[:, 0], block.SIDE)] + (ARROW, 0)
    pull = np.tile((1.0, 0.0), (len(pulled), 1))
    kit.body_drawing.draw_loads(axis, pulled, pull, ARROW, "prescribed displacement")
    axis.set(aspect="equal", xlabel="x (m)", ylabel="y (m)", xlim=(-0.08, 1.4), ylim=(-0.06, 1.06))
    axis.grid(visible=False)
    title = f"Springs alike, k2 = 2 k1, pulled by 1 %;\ndisplacements × {MAGNIFIED}"
    figure.suptitle(title)
    kit.figures.add_shared_legend(figure, [axis], columns=2)
    return figure
