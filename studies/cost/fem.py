"""Elements: what do assembly and solution of a finite element body cost, beside their peers?

Question   Seconds to assemble the stiffness of a clamped block and to solve for its displacement,
           in the plane and in space, against the unknowns; and for many loads on one body.
Candidate  `reference_fem` as it chooses: first order, E = 1 Pa, nu = 0.3.
Reference  `scipy.sparse.linalg.spsolve` of the same matrix, and [NGSolve], its own matrix and its
           sparse Cholesky, where it is installed.
Expected   The same displacement by every way. In space a factor grows as the square of the
           unknowns, multigrid as the unknowns.

Assembly is from the mesh to the matrix, the pattern of its entries included. A solution is from the
matrix and the load to the displacement, with its own check. One thread, the clock of the process.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from scipy.sparse.linalg import spsolve

import reference_fem
from msvalidate import kit
from reference_fem.elasticity import stiffness

from . import drawing, fem_ways, ngsolve_peer
from .fem_ways import Solve
from .timing import ABSENT, GROWTH, QUICK_ROUNDS, ROUNDS, in_turn, summary

CELLS = {2: (22, 70, 223), 3: (9, 14, 20, 24)}
"""Along a side: 1e3 to 1e5 unknowns in the plane, 3e3 to 4.7e4 in space."""
ASSEMBLED: dict[int, tuple[int, ...]] = {2: (), 3: (20,)}
"""Of these, bodies that are assembled and not solved."""
COMPARED = {2: 20, 3: 8}
"""Cells along the body on which all ways are compared."""
QUICK_CELLS = {2: (11, 22, 32), 3: (4, 6, 8)}
NU = 0.3
LONG = 30_000
"""Unknowns beyond which there is no untimed turn: what it would warm is a small part."""
MANY = 20
"""Loads on one body, in the row of a factor used again."""
ELEMENT = {2: "Q1", 3: "H1"}


@dataclass(frozen=True, eq=False)
class Block:
    """A unit square or cube, clamped on the left and pulled on the right: what is solved."""

    cells: tuple[int, ...]
    material: kit.Isotropic
    body: Any
    held: kit.Mask
    force: kit.Array

    @property
    def unknowns(self) -> int:
        """Components of all nodes."""
        return int(self.held.size)


def block(dim: int, cells: int, material: kit.Isotropic | None = None) -> Block:
    """A block of so many cells along each side."""
    box = kit.Box((1.0,) * dim)
    shape = (cells,) * dim
    material = material or elastic(dim)
    body = reference_fem.box_discretisation(box, shape, ELEMENT[dim])
    held = np.repeat(body.points[:, :1] == 0, dim, axis=1)
    # Along a row of points on the right, each has the part of the cells that it belongs to.
    part = np.ones(len(body.points))
    for axis in range(1, dim):
        at_end = np.isclose(body.points[:, axis] % 1.0, 0.0)
        part *= np.where(at_end, 0.5, 1.0) / cells
    force = np.zeros(held.shape)
    force[:, 0] = np.where(body.points[:, 0] == 1, part, 0.0)
    return Block(shape, material, body, held, force)


def elastic(dim: int) -> kit.Isotropic:
    """Plane stress, or a solid, with E = 1 Pa."""
    return kit.Isotropic(E=1.0, nu=NU, state="plane_stress" if dim == 2 else "solid")


def run(candidate: Mapping[str, Solve], setting: kit.Setting) -> kit.Evidence:
    """Time assembly and solution at every size, and hold the ways of ours together."""
    sizes, rounds = (QUICK_CELLS, QUICK_ROUNDS) if setting.quick else (CELLS, ROUNDS)
    cases = [(dim, cells) for dim, many in sizes.items() for cells in many]
    pairs = setting.one_by_one(
        lambda case: time_solution(candidate["auto"], *case, rounds), cases, "elements"
    )
    laps = pd.DataFrame([row for rows, _ in pairs for row in rows])
    chosen = pd.DataFrame([row for _, row in pairs])
    table = summary(laps, "cpu_seconds")
    apart = pd.DataFrame([row for dim in (2, 3) for row in agreement(candidate, dim)])
    seen = pd.to_numeric(apart["difference_here"], errors="coerce")
    absent = apart["difference_here"] == ABSENT
    largest = float(seen[~absent].max(skipna=False))
    own = (
        kit.Tolerance(
            "displacement by each way from that by spsolve, over the largest, worst", 1e-9, "1",
            "rounding times the condition number, 1e-16 x 1e6 at most at these sizes; multigrid "
            "stops at a thousandth of what is asked here",
            observed=kit.Observed(largest),
        ),
    )  # fmt: skip
    return kit.Evidence(
        tables={
            "fem": table,
            "fem_rounds": laps,
            "fem_choice": chosen,
            "fem_agreement": apart,
            "fem_growth": growth(table),
        },
        tolerances=own,
        figures={"fem": drawing.elements},
        columns=kit.columns(__file__),
        findings=findings(table, chosen),
    )


def time_solution(
    solve: Solve, dim: int, cells: int, rounds: int = ROUNDS
) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """Rows of one body, every task, program and round; and how ours solved."""
    given = block(dim, cells)
    K = stiffness(given.body, given.material)
    system = (given.body, K, given.held, given.force)
    peer = ngsolve_peer.block(given.cells, given.material, 1.0)
    if peer:
        peer.assemble()
    free = np.flatnonzero(~given.held.T.ravel())
    inside, load = K[free][:, free].tocsc(), given.force.T.ravel()[free]
    acts: dict[tuple[str, str], Callable[[], object] | None] = {
        ("assembly", "ours"): partial(time_assembly, given),
        ("assembly", "NGSolve"): peer.assemble if peer else None,
        ("solution", "ours"): partial(solve, *system),
        ("solution", "ours, SuperLU"): partial(fem_ways.by, "superlu", *system),
        ("solution", "ours, multigrid"): partial(fem_ways.by, "multigrid", *system),
        ("solution", "spsolve"): partial(spsolve, inside, load),
        ("solution", "NGSolve"): peer.solve if peer else None,
        ("20 loads", "ours"): partial(fem_ways.many, *system, MANY),
    }
    if cells in ASSEMBLED[dim]:
        acts = {name: act for name, act in acts.items() if name[0] == "assembly"}
    there = {name: act for name, act in acts.items() if act}
    laps = in_turn(there, rounds, warm=given.unknowns < LONG)
    head = {"axes": dim, "unknowns": given.unknowns}
    rows = [
        head
        | {"task": task, "program": program, "round": number + 1}
        | {"cpu_seconds": laps[task, program][number].cpu if (task, program) in laps else ABSENT}
        for task, program in acts
        for number in range(rounds)
    ]
    found = solve(*system)
    return rows, head | {"choice_here": found.choice, "residual_here": found.residual}


def time_assembly(given: Block) -> object:
    """The stiffness of a body without anything kept from before."""
    fresh = reference_fem.make_discretisation(
        given.body.points, given.body.cells, ELEMENT[given.body.dim]
    )
    return stiffness(fresh, given.material)


def agreement(ways: Mapping[str, Solve], dim: int) -> list[dict[str, Any]]:
    """Rows of every way of ours on one body, beside `spsolve`."""
    given = block(dim, COMPARED[dim])
    K = stiffness(given.body, given.material)
    free = np.flatnonzero(~given.held.T.ravel())
    true = np.zeros(given.unknowns)
    true[free] = spsolve(K[free][:, free].tocsc(), given.force.T.ravel()[free])
    reference = true.reshape(dim, -1).T
    rows = []
    for way, solve in ways.items():
        found = solve(given.body, K, given.held, given.force)
        apart = (
            ABSENT
            if found.displacement is None
            else float(np.abs(found.displacement - reference).max() / np.abs(reference).max())
        )
        rows.append({"axes": dim, "unknowns": given.unknowns, "way": way, "difference_here": apart})
    return rows


def growth(table: pd.DataFrame) -> pd.DataFrame:
    """Exponents of the seconds in the unknowns."""
    rows = []
    for (axes, task, program), part in table.groupby(["axes", "task", "program"], sort=False):
        row = {"axes": axes, "task": task, "program": program}
        if len(part) < 3 or (part["cpu_seconds"] == ABSENT).any():
            rows.append(row | dict.fromkeys(GROWTH, ABSENT))
            continue
        fit = kit.fitted_power(part["unknowns"], part["cpu_seconds"].astype(float))
        rows.append(row | dict(zip(GROWTH, fit, strict=True)))
    return pd.DataFrame(rows)


def findings(table: pd.DataFrame, chosen: pd.DataFrame) -> tuple[str, ...]:
    """Seconds on the largest bodies."""
    said = []
    for axes, part in table.groupby("axes"):
        last = part[(part["unknowns"] == part["unknowns"].max()) & (part["cpu_seconds"] != ABSENT)]
        told = "; ".join(
            f"{row.task}, {row.program}: {float(row.cpu_seconds):.2g} s"
            for row in last.itertuples(index=False)
        )
        choice = chosen[chosen["axes"] == axes].iloc[-1]["choice_here"]
        said.append(
            f"On this machine {part['unknowns'].max():,} unknowns of {axes} axes took: {told}. "
            f"Ours chose {choice}."
        )
    return tuple(said)
