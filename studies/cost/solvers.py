"""Solvers: how do seconds, memory and steps of an equilibrium grow, and is its stated error true?

Question   Seconds of one linear equilibrium as the package solves it, by a factor or by multigrid,
           against the points; on plates, cubes, slender bars, random tetrahedra, and cubes with a
           core stiffer or softer by 1e6. How many steps of multigrid, how many bytes?
Candidate  `equilibrium` with the solver that it chooses.
Reference  The other solver on the same network, in turn. Where a factor cannot be afforded,
           multigrid on the same points in random order: other aggregates, other sums.
Expected   Work and memory of multigrid in proportion to the points, its steps the same at each
           size. Two answers are no further apart than their stated errors together.

A factor's work grows as the square of the points in space, so it is asked only up to `FACTORED`.
Seconds are told and not judged. `solver_peers` has NGSolve and SciPy on the same cubes.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from msvalidate import kit
from msvalidate.springs.network import Configuration, spring_network
from msvalidate.springs.network.inverse import Solver
from msvalidate.springs.network.multigrid import Cycles
from msvalidate.springs.statics.equilibrium import Equilibrium, equilibrium

from . import bodies, drawing, large
from .timing import GROWTH, QUICK_ROUNDS, Act, Lap, in_turn, lap

Rest = Callable[[kit.Network, str], Equilibrium]
BODIES: dict[str, Callable[[int], kit.Network]] = {
    "plate": bodies.lattice,
    "cube": bodies.cube,
    "cube, core stiffer by 1e6": partial(bodies.with_core, times=1e6),
    "cube, core softer by 1e6": partial(bodies.with_core, times=1e-6),
    "bar of 100 to 1": bodies.bar,
    "random tetrahedra": bodies.tetrahedra,
}
GROWING = ("plate", "cube")
"""Bodies of the same shape at every size, whose growth is fitted."""
SIZES = dict.fromkeys(BODIES, (10_000, 30_000)) | {
    "plate": (10_000, 30_000, 100_000, 300_000),
    "cube": (10_000, 30_000, 100_000),
    "bar of 100 to 1": (4_000, 30_000),
}
QUICK_SIZES = dict.fromkeys(BODIES, (1_000,)) | dict.fromkeys(GROWING, (300, 1_000, 3_000))
WEIGHED, QUICK_WEIGHED = (3_000, 10_000, 30_000), (1_000, 2_000, 4_000)
"""Points of the cubes whose memory is looked at."""
FACTORED = {2: 150_000, 3: 15_000}
"""Points up to which a factor is asked for where multigrid was chosen: ten seconds or so."""
REPEATED = 12_000
"""Points beyond which an equilibrium is timed once, without an untimed turn before."""


class Beside(NamedTuple):
    """What answers as well: its name, what it does, and the network's points in its order."""

    name: str
    act: Callable[[], Equilibrium]
    order: kit.Index


def run(rest: Rest, steps: Callable[[kit.Network], int], setting: kit.Setting) -> kit.Evidence:
    """Solve each body twice, count steps, and weigh what multigrid holds."""
    sizes = QUICK_SIZES if setting.quick else SIZES
    rounds = 1 if setting.quick else QUICK_ROUNDS
    cases = [(body, nodes) for body, many in sizes.items() for nodes in many]
    rows = setting.one_by_one(partial(measure, rest, steps, rounds), cases, "equilibria")
    table = pd.DataFrame(rows)
    weighed = pd.DataFrame(
        [held_at_most(rest, nodes) for nodes in (QUICK_WEIGHED if setting.quick else WEIGHED)]
    )
    grown = growth(table)
    return kit.Evidence(
        tables={"equilibria": table, "equilibria_growth": grown, "equilibria_memory": weighed},
        tolerances=judge(table, grown, weighed),
        figures={"equilibria": drawing.equilibria},
        columns=kit.columns(__file__),
        findings=findings(table, grown),
    )


def measure(
    rest: Rest, steps: Callable[[kit.Network], int], rounds: int, case: tuple[str, int]
) -> dict[str, Any]:
    """Row of one body: its equilibrium as chosen, and what answers as well."""
    body, nodes = case
    net = BODIES[body](nodes)
    found, first = solve_with(partial(rest, net, "auto"))
    theirs = other(rest, net, found)
    again, second = solve_with(theirs.act)
    acts: dict[str, Act] = {"ours": partial(rest, net, "auto"), "theirs": theirs.act}
    laps = {"ours": [first], "theirs": [second]}
    if len(net.points) <= REPEATED:
        laps = in_turn(acts, rounds, warm=False)
    u, v = found.displacement, again.displacement[np.argsort(theirs.order, kind="stable")]
    return {
        "shape": body,
        "points": len(net.points),
        "springs": len(net.springs),
        "solver": by(found),
        "corrections_here": found.iterations - 1,
        "steps_of_multigrid_here": steps(net),
        "cpu_seconds": float(np.median([one.cpu for one in laps["ours"]])),
        "beside": theirs.name,
        "beside_cpu_seconds": float(np.median([one.cpu for one in laps["theirs"]])),
        "rounds": len(laps["ours"]),
        "stated_here": found.error,
        "beside_stated_here": again.error,
        "from_beside_here": float(np.abs(u - v).max() / np.abs(u).max()),
    }


def solve_with(act: Callable[[], Equilibrium]) -> tuple[Equilibrium, Lap]:
    """What an act answers, and what it takes."""
    found: list[Equilibrium] = []
    taken = lap(lambda: found.append(act()))
    return found[0], taken


def other(rest: Rest, net: kit.Network, found: Equilibrium) -> Beside:
    """The other solver, or, where a factor is dear, multigrid on the points in random order."""
    n, dim = net.points.shape
    if by(found) == "direct":
        return Beside("multigrid", partial(rest, net, "multigrid"), np.arange(n))
    if n <= FACTORED[dim]:
        return Beside("direct", partial(rest, net, "direct"), np.arange(n))
    order = np.random.default_rng(0).permutation(n)
    shuffled = renumber(net, order)
    return Beside("multigrid, in random order", partial(rest, shuffled, "multigrid"), order)


def renumber(net: kit.Network, order: kit.Index) -> kit.Network:
    """A network of springs alone with its points (n,) in another order, its springs in another."""
    place = np.argsort(order, kind="stable")
    turn = np.random.default_rng(1).permutation(len(net.springs))
    return spring_network(
        net.points[order],
        place[net.springs][turn],
        net.stiffness[turn],
        rest_length=net.rest_length[turn],
        mass=net.mass[order],
        fixed=net.fixed[order],
        force=net.force[order],
    )


def by(found: Equilibrium) -> str:
    """Name of the solver that was chosen."""
    return found.solver.name if found.solver else "none"


def held_at_most(rest: Rest, nodes: int) -> dict[str, Any]:
    """Row of a cube: what NumPy holds while it is solved by multigrid."""
    net = bodies.cube(nodes)
    _, peak = large.weigh_memory(partial(rest, net, "multigrid"))
    return {
        "points": len(net.points),
        "springs": len(net.springs),
        "most_bytes": peak,
        "most_a_spring_bytes": peak / len(net.springs),
    }


def growth(table: pd.DataFrame) -> pd.DataFrame:
    """Exponents of steps and of seconds in the points, of bodies that grow in one shape."""
    rows = []
    for body in GROWING:
        part = table[table["shape"] == body]
        for quantity, column in (("steps", "steps_of_multigrid_here"), ("seconds", "cpu_seconds")):
            fit = kit.fitted_power(part["points"], part[column].astype(float))
            row = {"shape": body, "quantity": quantity}
            rows.append(row | dict(zip(GROWTH, fit, strict=True)))
    return pd.DataFrame(rows)


def judge(
    table: pd.DataFrame, grown: pd.DataFrame, weighed: pd.DataFrame
) -> tuple[kit.Tolerance, ...]:
    """What is held to the tolerances; the worst of each."""
    steps = grown.loc[grown["quantity"] == "steps", "exponent_here"]
    both = table["stated_here"] + table["beside_stated_here"]
    most = table.loc[table["solver"] == "multigrid", "corrections_here"]
    stated = table[["stated_here", "beside_stated_here"]].to_numpy().max()
    return (
        kit.Tolerance(
            "exponent of multigrid's steps in points, plates and cubes, worst", 0.15, "1",
            "0: a W-cycle takes as much off at any size; a step or two more on ten for each decade",
            observed=kit.Observed(float(steps.abs().max())),
        ),
        kit.Tolerance(
            "difference of two answers over the sum of their stated errors, worst", 1.0, "1",
            "each says how far it may be off, at the most",
            observed=kit.Observed(float((table["from_beside_here"] / both).max(skipna=False))),
        ),
        kit.Tolerance(
            "stated error, worst", 1e-12, "1",
            "refined until doubles have no more digits, 1e-16; of a bar the rounding of springs' "
            "vectors counts by the square of its slenderness, 1e4",
            observed=kit.Observed(float(stated)),
        ),
        kit.Tolerance(
            "corrections of multigrid, most", 1.0, "1",
            "2: a solution and each correction leave 1e-5 of what was there, the third time 1e-15; "
            "one more where that is not yet below rounding",
            observed=kit.Observed(float(most.max()), 2.0),
        ),
        kit.Tolerance(
            "exponent of multigrid's bytes in springs, cubes", 0.1, "1",
            "1: blocks of the tangent and of coarse levels, some part of these; the coarse ones "
            "lack neighbours at the surface, a few hundredths a decade. Of a factor's entries it "
            "is 4/3",
            observed=kit.Observed(kit.fitted_power(weighed["springs"],
            weighed["most_bytes"]).exponent, 1.0),
        ),
    )  # fmt: skip


def findings(table: pd.DataFrame, grown: pd.DataFrame) -> tuple[str, ...]:
    """Seconds of the largest plate and cube, and how they grow."""
    said = []
    power = grown[grown["quantity"] == "seconds"].set_index("shape")["exponent_here"]
    for body in GROWING:
        last = table[table["shape"] == body].iloc[-1]
        said.append(
            f"A {body} of {last['points']:,} points was at rest in {last['cpu_seconds']:.3g} s by "
            f"{last['solver']}, seconds as points^{power[body]:.2f}."
        )
    return tuple(said)


def solve_refined(network: kit.Network, solver: str) -> Equilibrium:
    """The linear equilibrium by a solver."""
    return equilibrium(network, solver=solver)


def steps(network: kit.Network) -> int:
    """Steps of multigrid that the network's own load takes."""
    found = Solver(network, "multigrid").regular(Configuration(network)).inverse
    found.solve(network.force[~network.fixed])
    return found.steps if isinstance(found, Cycles) else 0
