"""Frontier: which error against the elastic solution does a second buy?

Question   Springs and elements with as many nodes are not equally accurate. How does the error
           against the true elastic solution fall with the time that is spent?
Candidate  The spring network, relaxed by kinetic damping and by Newton's method with a direct
           solver; the network is isotropic and stands for the elastic body.
Reference  scikit-fem with Q1 and Q2 on even meshes of the same cells; the true solution by Q2 on
           meshes graded to the corners, refined until its own error is known.
Expected   At equal nodes springs are like linear elements. In the end every model has the order of
           the clamped corners, twice the exponent of their singularity; Q2 shows it from the start,
           the others fall towards it from 2. An explicit relaxation takes sqrt(kappa) evaluations
           where a direct solver takes one factorisation.

Times are from the problem to the displacement: lattice or mesh, assembly, solution.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from statistics import median

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

import reference_fem
from msvalidate import kit
from msvalidate.bench.judging.singularity import clamped_free_exponent
from msvalidate.bench.output.figures import COLOURS, MARKERS, add_shared_legend, new_figure
from msvalidate.springs.dynamics.relax import relax
from msvalidate.springs.dynamics.run import Method

from . import bodies, summary

FINENESSES = {"plate": (8, 16, 32, 64, 128), "beam": (4, 8, 16, 32)}
QUICK = {"plate": (8, 16, 32), "beam": (4, 8, 16)}
ACCURACY = {"plate": 2e-5, "beam": 2e-5}
"""Of the reference, over the largest displacement: below the smallest error of any model."""
QUICK_ACCURACY = {"plate": 4e-4, "beam": 5e-5}
"""The same of the small form, whose models are coarser."""
COARSEST = {"plate": 8, "beam": 4}
GRADING = {"plate": 3.0, "beam": 1.5}
"""Towards the corners, where the stress of a clamped edge is singular."""
REPEATS = 3
KINETIC, NEWTON = "springs, kinetic damping", "springs, Newton"
INSIDE = 1 - 1e-9
DRAWN = {KINETIC: COLOURS[2], NEWTON: COLOURS[0], "Q1 elements": "black", "Q2 elements": COLOURS[1]}
"""Colours: those of the same methods in the other figures."""
ROUNDING = {
    **dict.fromkeys(("error", "reference_error"), 1e-9),
    "order": 1e-5,
    **dict.fromkeys(("low_order", "high_order"), 5e-5),
}
"""Displacements are known to rounding times the condition of the finest graded mesh, 1e-16 x 1e7,
relative, so the smallest errors of three sizes, 1.3e-4, to 8e-6 of them. An order over a factor of
4 is then known to 8e-6/ln 4, and the ends of its interval, 12.7 times as wide as the scatter of
three sizes (Student), to 6 times 8e-6."""
HUNDREDTH = 0.01
AT_REST = 1e-7
"""Tolerance of the explicit relaxation: its own error is then far below that of the spacing."""
RULES = (
    kit.Rule(
        "springs over Q1 elements on the same cells, error, worst factor between them", 2.5, "1",
        "bent, N cells of springs are too stiff by 1.25/N^2, Q1 with full integration by about "
        "half of that; on the plate they are nearer to each other",
        layer="agreement", table="frontier", rows={"model": (NEWTON, "Q1 elements")},
        value=lambda rows: _worst_factor(rows), reference=1.0,  # noqa: PLW0108  defined below
    ),
    kit.Rule(
        "order of Q2 elements against twice the exponent of the clamped corner, worst body",
        0.1, "1",
        "the fit is over three to five sizes, and the smooth part of the error, of order 4, is a "
        "tenth of the whole on the coarsest",
        table="frontier_orders", rows={"model": "Q2 elements"}, value="order",
        reference=lambda _: 2 * clamped_free_exponent(bodies.tensor(), np.pi / 2),
    ),
    kit.Rule(
        "uncertainty of the reference over the smallest error that it judges, worst body", 1.0, "1",
        "an error below it is none; the uncertainty is what the last refinement changed, several "
        "times what it left",
        table="frontier", value=kit.Quotient("reference_error", "error"),
    ),
)  # fmt: skip
Answer = Callable[[int], tuple[kit.Array, int]]
"""Displacement (q, 2) in m at the probes and number of nodes, for a fineness."""


def run(candidate: Mapping[str, Method], setting: kit.Setting) -> kit.Evidence:
    """Errors and times of each model at each fineness."""
    sizes = QUICK if setting.quick else FINENESSES
    accuracy = QUICK_ACCURACY if setting.quick else ACCURACY
    solved = setting.sweep(partial(elastic, accuracy), bodies.PLANE, "elastic solution")
    truth = dict(zip(bodies.PLANE, solved, strict=True))
    repeats = 1 if setting.quick else REPEATS
    found = {
        (model, body, fineness): measure(answer, fineness, repeats)
        for body in bodies.PLANE
        for model, answer in models(candidate, body).items()
        for fineness in sizes[body]
    }
    table = pd.DataFrame([row(key, what, truth[key[1]]) for key, what in found.items()])
    fitted = orders(table)
    apart = [
        bodies.relative_distance(what.displacement, found[NEWTON, *key[1:]].displacement)
        / (AT_REST * bodies.root_kappa(*key[1:]))
        for key, what in found.items()
        if key[0] == KINETIC
    ]
    relaxed = kit.Tolerance(
        "relaxed springs against Newton's, relative distance over sqrt(kappa), times 1e7", 1.0, "1",
        "stops at 1e-7 of the forces, times a lever of the order of kappa^(1/2)",
        observed=kit.Observed(max(apart)),
    )  # fmt: skip
    return kit.Evidence(
        tables={
            **summary.summarise(candidate, truth[summary.BODY], probes(summary.BODY), repeats),
            "frontier": table,
            "frontier_orders": fitted,
        },
        tolerances=(*RULES, relaxed),
        figures={"frontier": draw},
        columns=kit.columns(__file__),
        findings=findings(table),
    )


def elastic(accuracy: Mapping[str, float], body: str) -> tuple[kit.Array, float]:
    """Displacement (q, 2) in m of the elastic body at the probes, and its relative uncertainty."""
    problem, size = (
        bodies.problem(body),
        float(np.abs(bodies.rest_displacement(body, COARSEST[body])).max()),
    )

    def displacement(fineness: int) -> kit.Array:
        mesh = reference_fem.box_discretisation(
            bodies.box(body), bodies.cells(body, fineness), "Q2", grading=GRADING[body]
        )
        return reference_fem.solve_problem(problem, mesh).at(probes(body)).ravel() / size

    estimate = reference_fem.refine(displacement, COARSEST[body], accuracy[body])
    value = size * estimate.value.reshape(-1, 2)
    return value, float(size * np.linalg.norm(estimate.uncertainty) / np.linalg.norm(value))


def probes(body: str) -> kit.Array:
    """Points (q, 2) in m of the coarsest lattice, which every finer one has too.

    Those on the loaded edge are left out: at its corners the shear ends in a jump, and the error
    of every model falls there with order 1, whatever it does elsewhere.
    """
    points = bodies.network(body, COARSEST[body]).points
    return np.asarray(points[points[:, 0] < INSIDE * points[:, 0].max()])


def models(candidate: Mapping[str, Method], body: str) -> dict[str, Answer]:
    """The ways to predict a body's displacement."""
    return {
        KINETIC: partial(solve_springs, candidate["kinetic_damping"], body),
        NEWTON: partial(solve_springs, candidate["newton"], body),
        "Q1 elements": partial(solve_elements, "Q1", body),
        "Q2 elements": partial(solve_elements, "Q2", body),
    }


def solve_springs(method: Method, body: str, fineness: int) -> tuple[kit.Array, int]:
    """The network's displacement (q, 2) in m at the probes, and its number of points."""
    network = bodies.network(body, fineness)
    found = relax(network, method, tolerance=AT_REST).equilibrium.displacement
    along, across = bodies.cells(body, fineness)
    grid = found.reshape(across + 1, along + 1, 2)
    every = fineness // COARSEST[body]
    return grid[::every, :-1:every].reshape(-1, 2), len(network.points)


def solve_elements(element: str, body: str, fineness: int) -> tuple[kit.Array, int]:
    """The elements' displacement (q, 2) in m at the probes, and the number of nodes."""
    problem = bodies.problem(body)
    mesh = reference_fem.box_discretisation(bodies.box(body), bodies.cells(body, fineness), element)
    return reference_fem.solve_problem(problem, mesh).at(probes(body)), len(mesh.points)


@dataclass(frozen=True, eq=False)
class Measurement:
    """A model's displacement (q, 2) in m at the probes, its nodes, and the median time (s)."""

    displacement: kit.Array
    nodes: int
    seconds: float


def measure(answer: Answer, fineness: int, repeats: int) -> Measurement:
    """Ask a model several times, and time it."""
    seconds = []
    for _ in range(repeats):
        started = time.perf_counter()
        displacement, nodes = answer(fineness)
        seconds.append(time.perf_counter() - started)
    return Measurement(displacement, nodes, median(seconds))


def row(
    key: tuple[str, str, int], found: Measurement, truth: tuple[kit.Array, float]
) -> dict[str, object]:
    """One row: the error of a model, and the time to have its displacement."""
    model, body, fineness = key
    cells_x, cells_y = bodies.cells(body, fineness)
    return {
        "body": body,
        "model": model,
        "cells_x": cells_x,
        "cells_y": cells_y,
        "nodes": found.nodes,
        "error": bodies.relative_distance(found.displacement, truth[0]),
        "reference_error": truth[1],
        "wall_seconds": found.seconds,
    }


def orders(table: pd.DataFrame) -> pd.DataFrame:
    """Observed order of each model's error in the cells across."""
    rows = []
    for (body, model), part in table.groupby(["body", "model"], sort=False):
        power, low, high = kit.fitted_power(part["cells_y"], part["error"])
        order = {"order": -power, "low_order": -high, "high_order": -low}
        rows.append({"body": body, "model": model} | order)
    return pd.DataFrame(rows)


def _worst_factor(table: pd.DataFrame) -> float:
    springs, elements = (
        table[table["model"] == model]["error"].to_numpy() for model in (NEWTON, "Q1 elements")
    )
    return float(np.exp(np.abs(np.log(springs / elements)).max()))


def findings(table: pd.DataFrame) -> tuple[str, ...]:
    """What each model reaches on its finest mesh, and the seconds to a hundredth."""
    said = []
    for body in bodies.PLANE:
        part = table[table["body"] == body]
        models = {str(model): rows for model, rows in part.groupby("model", sort=False)}
        finest = ", ".join(
            f"{model} {rows['error'].iloc[-1]:.2g} ({rows['nodes'].iloc[-1]:,} nodes, "
            f"{rows['wall_seconds'].iloc[-1]:.2g} s)"
            for model, rows in models.items()
        )
        said.append(f"Error of the {body} against elasticity on the finest mesh: {finest}.")
        needed = {model: seconds_to(HUNDREDTH, rows) for model, rows in models.items()}
        told = ", ".join(f"{model} {seconds:.2g} s" for model, seconds in needed.items() if seconds)
        if told:
            said.append(f"To {HUNDREDTH:.0%} of the {body}'s elastic displacement: {told}.")
    return tuple(said)


def seconds_to(error: float, rows: pd.DataFrame) -> float | None:
    """Time at which a model reaches an error, in logarithms; None outside its sizes."""
    falling = np.log(rows["error"].to_numpy())[::-1]
    if not falling[0] <= np.log(error) <= falling[-1] or (np.diff(falling) <= 0).any():
        return None
    seconds = np.log(rows["wall_seconds"].to_numpy())[::-1]
    return float(np.exp(np.interp(np.log(error), falling, seconds)))


def draw(tables: kit.Tables) -> Figure:
    """Error against the elastic solution for the time spent; each point one fineness."""
    table = tables["frontier"]
    figure, axes = new_figure(len(bodies.PLANE), size=(3.5, 3.8), sharex=True, sharey=True)
    for axis, body in zip(axes, bodies.PLANE, strict=True):
        part = table[table["body"] == body]
        for index, (model, rows) in enumerate(part.groupby("model", sort=False)):
            style = {"marker": MARKERS[index], "color": DRAWN[str(model)]}
            axis.loglog(rows["wall_seconds"], rows["error"], label=str(model), **style)
        own = part["reference_error"].iloc[0]
        axis.axhline(own, ls=":", color="grey", label="the reference's own error")
        axis.set(title=body, xlabel="time from problem\nto displacement (s)")
    axes[0].set_ylabel("error at the coarsest lattice's\npoints, over displacements (1)")
    figure.suptitle("What error a second buys: each point one fineness")
    add_shared_legend(figure, axes, columns=2)
    return figure
