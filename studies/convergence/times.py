"""Times: how long do the relaxations run, beside a finite element solution of the same body?

Question   Seconds to a displacement error of 1e-3 and 1e-6, and their growth with the nodes. What
           it costs to know the frequencies that set step and damping is told apart.
Candidate  The table of relaxations, each for the steps that it was counted to need.
Reference  scikit-fem on the same body and cells (Q1, in space H1): mesh, assembly and solution, by
           a sparse factor and in space by multigrid too.
Expected   Seconds grow as steps x springs: nodes^(3/2) in the plane, nodes^(4/3) in space; nested
           dissection of a plane mesh as nodes^1.5 at worst, as nodes^1.1 to 1.3 at these sizes, of
           a cube towards nodes^2, multigrid as the nodes. `space` judges the counts behind these.

Each cell of the table runs alone, in this process; the command line leaves one thread to dense
algebra, and nothing else here has more. The median of several runs, in the small form of one. The
seconds depend on the machine and are never judged.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from functools import cache, partial
from statistics import median
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

import reference_fem
from msvalidate import kit
from msvalidate.bench.judging import counting
from msvalidate.bench.judging.counting import TIGHT
from msvalidate.bench.output.figures import add_shared_legend, new_figure
from msvalidate.springs.dynamics.divergence import SPECTRUM_ERROR
from msvalidate.springs.dynamics.relax import relax
from msvalidate.springs.dynamics.run import Method, Run
from msvalidate.springs.dynamics.spectrum import extreme_frequencies

from . import bodies, steps

REPEATS = 3
DECIDED = 1.0
"""Width of an interval beyond which an exponent is not worth telling."""
ELEMENTS = {
    2: {"fem_q1": ("Q1", "auto")},
    3: {"fem_h1": ("H1", "superlu"), "fem_h1_multigrid": ("H1", "multigrid")},
}
"""Axes of a body -> name in tables -> element and solver."""
FACTOR = {"marker": "^", "color": "black", "label": "linear elements, factor"}
MULTIGRID = {
    "marker": "v",
    "color": "black",
    "linestyle": "--",
    "label": "linear elements, multigrid",
}
ELEMENTS_DRAWN: dict[str, dict[str, Any]] = {
    "fem_q1": FACTOR,
    "fem_h1": FACTOR,
    "fem_h1_multigrid": MULTIGRID,
}
BODY = ["body", "cells_x", "cells_y", "nodes", "threshold"]


def run(
    candidate: Mapping[str, Method], counted: pd.DataFrame, setting: kit.Setting
) -> kit.Evidence:
    """Time each run of the table of steps that came to its end, and the same bodies by elements."""
    repeats = 1 if setting.quick else REPEATS
    if setting.quick:
        counted = counted[counted["threshold"] == TIGHT]
    todo = records(counted[counted["outcome"] == "reached"])
    rows = setting.one_by_one(partial(time_relaxation, candidate, repeats), todo, "seconds to rest")
    rows += time_elements(counted, repeats)
    table = pd.DataFrame(rows)
    grown = growth(table)
    return kit.Evidence(
        tables={"times": table, "growth_of_times": grown},
        figures={"times": draw},
        columns=kit.columns(__file__),
        findings=findings(table, grown),
    )


def records(table: pd.DataFrame) -> list[dict[str, Any]]:
    """Rows of a table, by column."""
    return [{str(column): value for column, value in row.items()} for _, row in table.iterrows()]


def time_relaxation(
    candidate: Mapping[str, Method], repeats: int, row: Mapping[str, Any]
) -> dict[str, object]:
    """One relaxation for as many steps as it needs, several times."""
    method = candidate[row["method"]]
    body, fineness, count = str(row["body"]), int(row["cells_y"]), int(row["steps"])
    network, known = bodies.network(body, fineness), bodies.frequencies(body, fineness)
    built, solved = setup(body, fineness)

    runs: list[Run] = []

    def watch(run: Run) -> bool:
        runs[:] = [run]
        return run.steps >= count

    def relaxed() -> tuple[float, float]:
        done = relax(
            network,
            method,
            tolerance=counting.AT_REST,
            max_steps=2 * count,
            watch=watch,
            look_every=count,
            frequencies=known,
        )
        # A method whose step or damping follows from natural frequencies has read them.
        return built + solved * ("frequencies" in vars(runs[0])), done.seconds

    return _row(row, method.name, relaxed, repeats)


@cache
def setup(body: str, fineness: int) -> tuple[float, float]:
    """Seconds that a network takes to build, and its frequencies to solve for."""
    started = time.perf_counter()
    network = bodies.network(body, fineness)
    built = time.perf_counter()
    extreme_frequencies(network, tolerance=SPECTRUM_ERROR)
    return built - started, time.perf_counter() - built


def time_elements(counted: pd.DataFrame, repeats: int) -> list[dict[str, object]]:
    """The same bodies by finite elements; one solution serves for every threshold."""
    kinds = [name for name in BODY if name != "threshold"]
    rows = []
    for first in records(counted[kinds].drop_duplicates()):
        for name, (element, solver) in ELEMENTS[bodies.dim(first["body"])].items():
            solved = partial(time_solution, first["body"], int(first["cells_y"]), element, solver)
            row = _row(first, name, solved, repeats)
            rows += [row | {"threshold": threshold} for threshold in counted["threshold"].unique()]
    return rows


def time_solution(body: str, fineness: int, element: str, solver: str) -> tuple[float, float]:
    """Seconds of the mesh, and of what follows."""
    started = time.perf_counter()
    cells = bodies.cells(body, fineness)
    mesh = reference_fem.box_discretisation(bodies.box(body), cells, element)
    meshed = time.perf_counter()
    reference_fem.solve_problem(bodies.problem(body), mesh, solver=solver)
    return meshed - started, time.perf_counter() - meshed


def _row(
    row: Mapping[str, Any], method: str, once: Callable[[], tuple[float, float]], repeats: int
) -> dict[str, object]:
    setups, seconds = zip(*(once() for _ in range(repeats)), strict=True)
    return {
        **{key: row[key] for key in BODY if key in row},
        "method": method,
        "setup_seconds": median(setups),
        "wall_seconds": median(seconds),
        "least_seconds": min(seconds),
    }


def growth(table: pd.DataFrame) -> pd.DataFrame:
    """Exponents of the seconds in the number of nodes, from the larger networks.

    Below a thousandth of a second a run costs what its set-up costs; three sizes are kept at least.
    """
    rows = []
    for (body, method, threshold), part in table.groupby(
        ["body", "method", "threshold"], sort=False
    ):
        if len(part) < 3:
            continue
        fit = kit.fitted_power(part["nodes"].iloc[-4:], part["wall_seconds"].iloc[-4:])
        row = {"body": body, "method": method, "threshold": threshold}
        rows.append(row | {f"{name}_of_seconds": end for name, end in fit._asdict().items()})
    return pd.DataFrame(rows)


def findings(table: pd.DataFrame, grown: pd.DataFrame) -> tuple[str, ...]:
    """Who is fastest on the largest bodies, and how seconds grow."""
    tight = table[table["threshold"] == TIGHT]
    said = []
    for body in bodies.SIZES:
        part = tight[tight["body"] == body]
        last = part[part["nodes"] == part["nodes"].max()].sort_values("wall_seconds", kind="stable")
        ranks = ", ".join(
            f"{row.method} {row.wall_seconds:.2g} s after {row.setup_seconds:.2g} s"
            for row in last.itertuples(index=False)
        )
        said.append(
            f"On this machine the {body} of {part['nodes'].max():,} nodes took, after its set-up: "
            f"{ranks}."
        )
    for body in ("plate", "cube"):
        part = grown[(grown["body"] == body) & (grown["threshold"] == TIGHT)]
        decided = part[part["high_of_seconds"] - part["low_of_seconds"] < DECIDED]
        powers = ", ".join(
            f"{row.method} nodes^{row.exponent_of_seconds:.2f} [{row.low_of_seconds:.2f}, "
            f"{row.high_of_seconds:.2f}]"
            for row in decided.itertuples(index=False)
        )
        if powers:
            said.append(f"Seconds on the {body}, where its sizes decide their growth: {powers}.")
    return tuple(said)


def draw(tables: kit.Tables) -> Figure:
    """Seconds to an error of 1e-6 against the nodes, with lattice or mesh and frequencies."""
    table = tables["times"]
    tight = table[table["threshold"] == TIGHT]
    figure, axes = new_figure(len(bodies.SIZES), size=(2.4, 3.9), sharex=True, sharey=True)
    for axis, body in zip(axes, bodies.SIZES, strict=True):
        part = tight[tight["body"] == body]
        for method, rows in part.groupby("method", sort=False):
            seconds = rows["wall_seconds"] + rows["setup_seconds"]
            how = ELEMENTS_DRAWN.get(str(method)) or steps.style(str(method))
            axis.loglog(rows["nodes"], seconds, **how)
        axis.set(title=body, xlabel="nodes (1)")
    axes[0].set_ylabel("time to an error of 1e-6 (s)")
    figure.suptitle("Seconds that each way to rest takes, with its set-up")
    add_shared_legend(figure, axes, columns=3)
    return figure
