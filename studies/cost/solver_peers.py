"""Peers of the solvers: how long do NGSolve and SciPy take on the same bodies?

Question   Seconds of one equilibrium of a clamped cube, and of a bar of 100 to 1, under end shear,
           beside other programs.
Candidate  `equilibrium` with the solver that it chooses.
Reference  `spsolve` and `cg` of SciPy on the same tangent; NGSolve, where it is installed.
Expected   The same displacement by SciPy; by NGSolve the same work of the load but for
           discretisation. Factors grow as the square of the points.

All are timed in turn from what is to be solved (network or mesh) to the displacement, assembly
included, on one thread. Ours is refined to the last digit and looked at
for motions without stiffness; conjugate gradients of others stop at a residual of `LEFT`. NGSolve
solves elements of first order on the same points: cubes by its sparse Cholesky and by conjugate
gradients with Jacobi's ("local"), tetrahedra by conjugate gradients with its multigrid over meshes
that are halved. Its h1amg is left out: on the same body it was singular in one call and off by
4e-4 of the work in another (6.2.2608); bddc of first order is a factor.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from scipy.sparse import csr_array, diags_array
from scipy.sparse.linalg import cg, spsolve

from msvalidate.judging.evidence import Evidence, Observed, Tolerance
from msvalidate.judging.sweep import Setting
from msvalidate.network import Network, tangent
from msvalidate.problem import Array, SolverError
from msvalidate.statics.equilibrium import Equilibrium

from . import bodies, kernel, ngsolve_peer, refinement
from .timing import ABSENT, QUICK_ROUNDS, SECONDS, in_turn, summary

CUBE, BAR = "cube", "bar of 100 to 1"
CELLS = {CUBE: bodies.cube_cells, BAR: bodies.bar_cells}
SIZES = {CUBE: (8, 12, 20, 32), BAR: (4,)}
"""Cells across, which can be halved: multigrid on meshes needs that."""
QUICK_SIZES = {CUBE: (4, 8)}
REPEATED = 4_000
"""Points beyond which all are timed once, without an untimed turn before."""
LEFT = 1e-8
"""Residual over the load at which conjugate gradients of others stop."""
OURS = "ours"
SPSOLVE, CG, JACOBI = "SciPy spsolve", "SciPy cg", "SciPy cg with Jacobi"
MOST_NODES = {SPSOLVE: 4_000, ngsolve_peer.CHOLESKY: 12_000}
"""Points up to which a factor without nested dissection, or of NGSolve, is waited for."""
TOLERANCES = (
    Tolerance(
        "SciPy's spsolve from ours on cubes, over the largest displacement, worst", 1e-9, "1",
        "rounding times the condition number, 1e-16 x 1e4, and some for the growth of pivots",
    ),
    Tolerance(
        "SciPy's cg from ours on cubes, over the largest displacement, worst", 1e-5, "1",
        "1e-8 of the load is left, times a few for the part that an end load has of the softest "
        "motion, times the root of the unknowns, 300, from a mean component to the largest",
    ),
)  # fmt: skip
COLUMNS = {
    **SECONDS,
    "shape": "plate or cube of lattice, clamped on one side and sheared on the other; the cube "
    "with a ball inside of stiffer or softer springs; a bar bent by its end; or random tetrahedra",
    "points": refinement.COLUMNS["points"],
    "round": kernel.COLUMNS["round"],
    "by": "ours as it chooses; SciPy on our tangent; or NGSolve on elements of its own",
    "steps_of_cg_here": 'steps of conjugate gradients; 0 of a factor and of ours, or "absent"',
    "from_ours_here": "largest distance from the displacement by ours over the largest one; of "
    'NGSolve, another discretisation, the distance of the load\'s work over ours (1), or "absent"',
}


class Answer(NamedTuple):
    """What one of them found: the work of the load (J), steps, and the displacement (n, d) in m."""

    work: float
    steps: int = 0
    displacement: Array | None = None


Rest = Callable[[Network, str], Equilibrium]


def run(rest: Rest, setting: Setting) -> Evidence:
    """Time all at every size, and hold the answers together."""
    sizes = QUICK_SIZES if setting.quick else SIZES
    rounds = 1 if setting.quick else QUICK_ROUNDS
    cases = [(shape, across) for shape, many in sizes.items() for across in many]
    pairs = setting.one_by_one(partial(time_solver, rest, rounds), cases, "peers of the solvers")
    laps = pd.DataFrame([row for rows, _ in pairs for row in rows])
    found = pd.DataFrame([row for _, rows in pairs for row in rows])
    table = summary(laps, "cpu_seconds")
    return Evidence(
        tables={
            "equilibrium_peers": table,
            "equilibrium_rounds": laps,
            "equilibrium_agreement": found,
        },
        observed={
            TOLERANCES[0].quantity: Observed(worst(found, (SPSOLVE,))),
            TOLERANCES[1].quantity: Observed(worst(found, (CG, JACOBI))),
        },
        tolerances=TOLERANCES,
        columns=COLUMNS,
        findings=findings(table),
    )


def time_solver(
    rest: Rest, rounds: int, case: tuple[str, int]
) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Rows of one body: every program and round; and what every program found."""
    shape, across = case
    cells = CELLS[shape](across)
    net = bodies.solid(cells)
    nodes = len(net.points)
    acts: dict[str, Callable[[], Answer] | None] = {
        OURS: partial(by_ours, rest, net),
        SPSOLVE: partial(by_spsolve, net),
        CG: partial(by_cg, net, jacobi=False),
        JACOBI: partial(by_cg, net, jacobi=True),
    }
    peer = ngsolve_peer.sheared(cells, bodies.SOLID, bodies.STRAIN, LEFT)
    for name in ngsolve_peer.SOLVERS:
        acts[name] = partial(by_ngsolve, peer, name) if peer else None
    acts = {name: act for name, act in acts.items() if nodes <= MOST_NODES.get(name, nodes)}
    answers: dict[str, Answer] = {}
    rounds = rounds if nodes <= REPEATED else 1
    there = {name: partial(_kept, answers, name, act) for name, act in acts.items() if act}
    laps = in_turn(there, rounds, warm=nodes <= REPEATED)
    head = {"shape": shape, "points": len(net.points)}
    rows = [
        head
        | {"by": name, "round": number + 1}
        | {"cpu_seconds": laps[name][number].cpu if name in laps else ABSENT}
        for name in acts
        for number in range(rounds)
    ]
    return rows, [head | describe_peers(answers, name) for name in acts]


def _kept(answers: dict[str, Answer], name: str, act: Callable[[], Answer]) -> None:
    answers[name] = act()


def describe_peers(answers: dict[str, Answer], name: str) -> dict[str, Any]:
    """How many steps a program took, and how far it is from ours."""
    if name not in answers:
        return {"by": name, "steps_of_cg_here": ABSENT, "from_ours_here": ABSENT}
    found, ours = answers[name], answers[OURS]
    apart = abs(found.work / ours.work - 1)
    if found.displacement is not None and ours.displacement is not None:
        largest = np.abs(ours.displacement).max()
        apart = float(np.abs(found.displacement - ours.displacement).max() / largest)
    return {"by": name, "steps_of_cg_here": found.steps, "from_ours_here": apart}


def by_ours(rest: Rest, net: Network) -> Answer:
    """As the package chooses."""
    u = rest(net, "auto").displacement
    return Answer(float(np.vdot(net.force, u)), 0, u)


def by_spsolve(net: Network) -> Answer:
    """SciPy's factor, as it orders by itself."""
    A, load = system(net)
    return answer(net, spsolve(A.tocsc(), load))


def by_cg(net: Network, *, jacobi: bool) -> Answer:
    """SciPy's conjugate gradients, plain or over the diagonal.

    Raises
    ------
    SolverError
        If they do not get to `LEFT`.
    """
    A, load = system(net)
    counted: list[int] = []
    over = diags_array(1 / A.diagonal()) if jacobi else None
    x, failed = cg(A, load, rtol=LEFT, M=over, callback=lambda _: counted.append(1))
    if failed:
        raise SolverError(f"SciPy cg: {failed} steps do not suffice; take a smaller body")
    return answer(net, x, len(counted))


def by_ngsolve(peer: ngsolve_peer.Sheared, name: str) -> Answer:
    """NGSolve by one of its solvers."""
    return Answer(*peer(name))


def system(net: Network) -> tuple[csr_array, Array]:
    """Tangent and load of what is free."""
    (free,) = np.nonzero(~net.held.ravel())
    return tangent(net, net.points)[free][:, free], net.force.ravel()[free]


def answer(net: Network, free: Array, steps: int = 0) -> Answer:
    """From the displacement of what is free."""
    u = np.zeros(net.points.shape)
    u[~net.held] = free
    return Answer(float(np.vdot(net.force, u)), steps, u)


def worst(found: pd.DataFrame, names: tuple[str, ...]) -> float:
    """Largest distance from ours on a cube; NaN counts as largest."""
    values = found.loc[found["by"].isin(names) & (found["shape"] == CUBE), "from_ours_here"]
    return float(values.astype(float).max(skipna=False))


def findings(table: pd.DataFrame) -> tuple[str, ...]:
    """Seconds of every program on the largest cube and bar."""
    said = []
    for shape, part in table.groupby("shape", sort=False):
        most = part["points"].max()
        there = part[(part["points"] == most) & (part["cpu_seconds"] != ABSENT)]
        told = "; ".join(
            f"{row.by}: {float(row.cpu_seconds):.2g} s" for row in there.itertuples(index=False)
        )
        said.append(f"A {shape} of {most:,} points was at rest, assembly included: {told}.")
    return tuple(said)
