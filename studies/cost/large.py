"""Large bodies: a network stretched by a hundredth beside elements on the same cells; memory.

Question   How long does Newton's method with multigrid take to bring a large network to rest,
           beside one linear solution by elements of as many nodes? How many bytes a point?
Candidate  The relaxation `newton_multigrid`, and `reference_fem` as it chooses.
Reference  Each the other's.
Expected   A few iterations of Newton's method, each no more than a linear solution, as many at each
           size: cost as the points.

Memory is what NumPy holds at most while something is made or solved, by `tracemalloc`; factors that
compiled libraries keep are not in it.
"""

from __future__ import annotations

import math
import tracemalloc
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

from msvalidate import kit
from msvalidate.springs import kernels
from msvalidate.springs.dynamics.relax import relax
from msvalidate.springs.dynamics.run import Method
from msvalidate.springs.network import tangent
from reference_fem.elasticity import stiffness

from . import bodies, drawing, fem, kernel
from .fem_ways import Solve
from .timing import ROUNDS, in_turn

NODES = (10_000, 100_000, 1_000_000)
QUICK_NODES = (500, 1_500, 5_000)
REPEATED = 200_000
"""Nodes beyond which a run is timed once."""
PULL = 0.01
"""Strain along the plate."""
AT_REST = 1e-8
"""Tolerance of the residual: displacements are then far better than the 1e-6 that is asked for."""
WEIGHED, QUICK_WEIGHED = 30_000, 5_000
METHOD = "newton_multigrid"


def run(method: Method, ways: Mapping[str, Solve], setting: kit.Setting) -> kit.Evidence:
    """Time both at every size, and weigh what they hold."""
    sizes = QUICK_NODES if setting.quick else NODES
    repeated = 0 if setting.quick else REPEATED
    timed = partial(beside, method, ways["auto"], repeated)
    table = pd.DataFrame(setting.one_by_one(timed, sizes, "large networks"))
    weighed = memory(method, ways["auto"], QUICK_WEIGHED if setting.quick else WEIGHED)
    arrays = pd.DataFrame([count_cycles(nodes) for nodes in sizes[:2]])
    done = (table["iterations"] > 0).all()
    cycles = kit.fitted_power(table["nodes"], table["cycles_here"]).exponent if done else math.nan
    spread = float(np.ptp(table["iterations"])) if done else math.nan
    ratio = float((arrays["counted"] / arrays["predicted"]).max())
    own = (
        kit.Tolerance(
            "iterations of Newton's method with multigrid at 1 % strain, most less fewest over "
            "sizes",
            1, "1",
            "the same continuous problem at any size; a residual near the tolerance may ask for "
            "one more",
            observed=kit.Observed(spread),
        ),
        kit.Tolerance(
            "exponent of its multigrid cycles in nodes", 0.15, "1",
            "no growth but a logarithm: a cycle or two more on ten for each decade of nodes",
            observed=kit.Observed(cycles),
        ),
        kit.Tolerance(
            "bytes that a network keeps, a point, counted over predicted", 1e-12, "1",
            "a plate of n x n points has 4n² - 6n + 2 springs: a count, to the rounding of a "
            "quotient",
            observed=kit.Observed(ratio, 1.0),
        ),
    )  # fmt: skip
    return kit.Evidence(
        tables={"large": table, "memory": weighed, "network_arrays": arrays},
        tolerances=own,
        figures={"large": drawing.large},
        columns=kit.columns(__file__),
        findings=findings(table, weighed),
    )


def stretched_body(nodes: int) -> kit.Network:
    """The plate pulled along its length."""
    return bodies.plate(bodies.along(nodes, 2), strain=(PULL, 0.0))


def beside(method: Method, solve: Solve, repeated: int, nodes: int) -> dict[str, Any]:
    """Row of one size."""
    net, given = stretched_body(nodes), fem.block(2, bodies.along(nodes, 2))
    K = stiffness(given.body, given.material)
    found: list[Any] = []

    def newton() -> None:
        try:
            found[:] = [relax(net, method, tolerance=AT_REST)]
        except kit.SolverError:
            found[:] = []

    acts: dict[str, Callable[[], object]] = {
        "newton": newton,
        "elements": partial(solve, given.body, K, given.held, given.force),
    }
    rounds = ROUNDS if nodes <= repeated else 1
    laps = in_turn(acts, rounds, warm=nodes <= fem.LONG)
    ours, theirs = (np.array([one.cpu for one in laps[name]]) for name in acts)
    return {
        "nodes": len(net.points),
        "springs": len(net.springs),
        "rounds": rounds,
        "iterations": found[0].steps if found else 0,
        "cycles_here": found[0].evaluations if found else 0,
        "newton_seconds": float(np.median(ours)),
        "elements_seconds": float(np.median(theirs)),
        "over_elements_here": float(np.median(ours / theirs)),
        "least_over_elements_here": float((ours / theirs).min()),
        "most_over_elements_here": float((ours / theirs).max()),
    }


def memory(method: Method, solve: Solve, nodes: int) -> pd.DataFrame:
    """The table `memory`: what is held, a point."""
    along = bodies.along(nodes, 2)
    net = stretched_body(nodes)
    (u, v), dt = bodies.start(net), bodies.time_step(net)
    keep, push = np.full(len(u), kernel.KEEP), np.full(len(u), dt)
    given = fem.block(2, along)
    K = stiffness(given.body, given.material)
    weighing: dict[str, Callable[[], object]] = {
        "network": partial(stretched_body, nodes),
        "steps of the network": lambda: kernels.Motion(net).advance(u, v, keep, push, dt, 1),
        "tangent": partial(tangent, net, net.points),
        "Newton's method with multigrid": partial(relax, net, method, tolerance=AT_REST),
        "mesh of elements": partial(fem.block, 2, along),
        "stiffness of elements": partial(fem.time_assembly, given),
        "solution by elements": partial(solve, given.body, K, given.held, given.force),
    }
    rows = []
    for what, act in weighing.items():
        kept, peak = weigh_memory(act)
        row = {"what": what, "nodes": len(net.points)}
        rows.append(row | {"kept_bytes": kept / len(u), "peak_bytes": peak / len(u)})
    return pd.DataFrame(rows)


def weigh_memory(act: Callable[[], object]) -> tuple[int, int]:
    """Bytes that are left after an act, and the most that were held during it."""
    tracemalloc.start()
    try:
        with suppress(kit.SolverError):  # what fails has held what it held
            made = act()
            found = tracemalloc.get_traced_memory()
            del made
            return found
        return tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()


def count_cycles(nodes: int) -> dict[str, Any]:
    """Bytes of a network's own arrays, a point, counted and foreseen."""
    net = stretched_body(nodes)
    by_spring = (net.springs, net.stiffness, net.rest_length)
    by_point = (net.points, net.mass, net.fixed, net.displacement, net.force)
    a_point = net.dim * (3 * 8 + 1) + 8  # points, displacement, force; held; mass
    a_spring = 2 * net.springs.itemsize + 2 * 8  # ends; stiffness, rest length
    side = round(math.sqrt(len(net.points)))
    springs = 4 * side**2 - 6 * side + 2
    return {
        "nodes": len(net.points),
        "counted": sum(array.nbytes for array in (*by_spring, *by_point)) / len(net.points),
        "predicted": a_point + a_spring * springs / side**2,
    }


def findings(table: pd.DataFrame, weighed: pd.DataFrame) -> tuple[str, ...]:
    """Newton's method over elements on the largest plate; memory."""
    last = table.iloc[-1]
    told = ", ".join(f"{row.what} {row.peak_bytes:,.0f}" for row in weighed.itertuples(index=False))
    rest = (
        f"At 1 % strain Newton's method with multigrid brought {last['nodes']:,.0f} points to rest "
        f"in {last['iterations']:.0f} iterations and {last['newton_seconds']:.3g} s, "
        f"{last['over_elements_here']:.2f} times one linear solution by elements."
    )
    return rest, f"Bytes a point at most, of {weighed['nodes'].iloc[0]:,} points: {told}."
