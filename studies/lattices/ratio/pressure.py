"""Pressure: do the pressures of cells alternate from cell to cell?

Question   How strongly the least of a body's patterns of cell pressures pushes its points, as cells
           shrink, and whether patterns that alternate show in a bent block's pressures.
Candidate  Square cells with a volume each, on springs.
Reference  A stable pair of displacement and pressure has a least push above zero whatever the size.
           Pressures of mixed elements at the middle of the same cells.
Expected   Cell by cell this is the element of bilinear displacement and constant pressure (Q1-P0),
           which is no stable pair [BolandNicolaides1985]: its least push falls as the spacing. Held
           all round, an even grid has two patterns that push nothing: a constant, and black against
           white. A pressure is κ times a dilatation, and so has no part in such patterns; what is
           left are those that push little. A free side forbids both.
"""

from __future__ import annotations

from functools import partial

import numpy as np
import pandas as pd
from scipy.linalg import eigh

import reference_fem
from msvalidate import kit
from msvalidate.springs.bodies.calibrate import calibrate
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.lattice import fill, patterns
from msvalidate.springs.network import Network, tangent
from msvalidate.springs.network.laws.volumes import Volumes, cell_volumes
from reference_fem.body import nodal_forces
from reference_fem.mixed import solve_mixed_on

from .bent import bend_block, box_of, counts, springs_of

ROUND = "all round"
HELD = {"left": ("left",), ROUND: ("left", "right", "bottom", "top")}
SIZES, QUICK = (4, 8, 16, 24), (4, 8, 12)
BENT, QUICK_BENT = (8, 16, 32), (8, 16)
RATIOS = (0.45, 0.499, 0.4999)
NOTHING = 1e-10
"""Square of a push, relative to the largest, that is rounding."""
SMALL = 1e-4
"""Of a displacement (m) from which dilatations are taken: linear in it to rounding."""
FREE = 0.5
"""Part of the block, from its loaded end, that has no corner with singular stress but weak ones."""
RULES = (
    kit.Rule(
        "patterns of pressure that push nothing: 2 held all round, else none", 0, "1",
        "black against white, and a constant; any free side is pushed by both",
        table="pressure_push", value="silent", reference=lambda rows: 2 * (rows["held"] == ROUND),
    ),
    kit.Rule(
        "least push of other patterns, held all round: order in the spacing, from 1", 0.25, "1",
        "the next term is of one order more: on 8 and 12 cells, as large as the first at one cell, "
        "it makes 0.1, and twice as large 0.22",
        table="pressure_push", rows={"held": ROUND}, last=2, value="least_push",
        power_of=kit.Quotient(1, "cells_square"), reference=1.0,
    ),
    kit.Rule(
        "bent block, away from the clamped side: cell pressures from mixed elements', finest size",
        0.02, "1",
        "of order 2 but for the corners' own: some (1/16)² times 5; a pattern that alternates "
        "would not fall",
        table="pressures", by=("nu_pressed",), last=1, value="pressure_difference",
    ),
)  # fmt: skip
FIGURES = {
    "pressure_push": kit.series(
        "pressure_push", title="Patterns of cell pressures that push least", x="cells_square",
        y="least_push", labels=("cells along an edge (1)", "least push of a pattern (1)"),
        by="held", words={"left": "held at the left", ROUND: "held all round"}, log="xy",
        orders=(-1,), size=(5.0, 3.3),
    ),
    "pressures": kit.series(
        "pressures", title="Pressures of cells in a bent block",
        x="cells_bent", labels=("cells through the height (1)", "part of the pressure (1)"),
        y={"pressure_difference": "from mixed elements'", "alternating": "alternating part",
           "alternating_mixed": "alternating part, mixed"},
        rows={"nu_pressed": RATIOS[1]}, log="xy", size=(5.8, 3.3),
    ),
}  # fmt: skip


def run(candidate: kit.DisplacementSolver, setting: kit.Setting) -> kit.Evidence:
    """Look for patterns that push little, and for their traces in a bent block."""
    sizes, across = (QUICK, QUICK_BENT) if setting.quick else (SIZES, BENT)
    todo = [(held, n) for held in HELD for n in sizes]
    pushes = pd.DataFrame(setting.sweep(push_row, todo, "pressures that push little"))
    bodies = [(nu, n) for nu in (RATIOS[1:2] if setting.quick else RATIOS) for n in across]
    pressed = pd.DataFrame(setting.sweep(partial(press_body, candidate), bodies, "cell pressures"))
    order = {
        held: kit.observed_order(1 / rows["cells_square"].iloc[-2:], rows["least_push"].iloc[-2:])
        for held, rows in pushes.groupby("held", sort=False)
    }
    silent = pushes[pushes["held"] == ROUND]["silent"].max()
    last = pressed.iloc[-1]
    theory = (
        f"Held all round, {silent} patterns of cell pressures push nothing, a constant and black "
        "against white; the least push of the others falls with order "
        f"{order[ROUND]:.2f} in the spacing (held at the left: {order['left']:.2f}), so "
        "pressures are not safe by theory as those of mixed elements are."
    )
    seen = (
        f"In a bent block at nu = {last['nu_pressed']:g} and {last['cells_bent']:.0f} cells, cell "
        "pressures away from the clamped side are off by "
        f"{last['pressure_difference']:.1g}, and alternate by {last['alternating']:.1g} of "
        f"themselves, those of mixed elements by {last['alternating_mixed']:.1g}: a trace of such "
        "patterns, and no more."
    )
    return kit.Evidence(
        {"pressure_push": pushes, "pressures": pressed},
        tolerances=RULES,
        figures=FIGURES,
        columns=kit.columns(__file__),
        findings=(theory, seen),
    )


def push_row(todo: tuple[str, int]) -> dict[str, object]:
    """One row of the table `pressure_push`.

    With K of the springs and B of the cells' dilatations, BᵀV⁻¹B u = β² K u: the numbers β that
    are not zero are the pushes, as many as there are cells but for the silent patterns.
    """
    held, n = todo
    box = kit.Box((1.0, 1.0))
    supports = tuple(kit.Support(box.side(side), (0.0, 0.0)) for side in HELD[held])
    problem = kit.Problem(box, kit.Isotropic(1.0, 1 / 3), supports, name="patterns of pressure")
    lattice = fill(patterns.square(), box, n)
    springs = calibrate(2 * (1 + 1 / 3), 1 / 3, lattice).constants
    plain = lattice_network(problem, lattice, springs)
    whole = lattice_network(problem, lattice, springs, volume=1.0)
    free = np.flatnonzero(~plain.fixed.ravel())
    K = tangent(plain, plain.points)[free][:, free].toarray()
    added = tangent(whole, whole.points)[free][:, free].toarray() - K
    squares = eigh(added, K, eigvals_only=True)[::-1]
    # There may be fewer free components than cells: then the rest of the patterns are silent.
    cells = np.zeros(n * n)
    cells[: len(squares)] = squares[: n * n]
    loud = cells > NOTHING * squares[0]
    return {
        "held": held,
        "cells_square": n,
        "silent": int((~loud).sum()),
        "least_push": float(np.sqrt(cells[loud].min())),
    }


def press_body(candidate: kit.DisplacementSolver, todo: tuple[float, int]) -> dict[str, object]:
    """One row of the table `pressures`."""
    nu, n = todo
    own, mixed, middle = fields(candidate, nu, n)
    near = middle[:, 0] > (1 - FREE) * (middle[:, 0].max() + middle[0, 0])
    order = np.lexsort(np.round(middle[near], 9).T[::-1])
    a, b = (field[near][order].reshape(-1, n) for field in (own, mixed))
    return {
        "nu_pressed": nu,
        "cells_bent": n,
        "pressure_difference": _size(a - b) / _size(b),
        "alternating": _size(_alternating(a)) / _size(a),
        "alternating_mixed": _size(_alternating(b)) / _size(b),
    }


def fields(
    candidate: kit.DisplacementSolver, nu: float, cells: int
) -> tuple[kit.Array, kit.Array, kit.Array]:
    """Pressures (c,) in Pa in cells by springs and by mixed elements, and the middles (c, 2)."""
    problem = bend_block("plane_strain", nu)
    along = counts(box_of(problem), cells)
    network = springs_of(problem, "square", along)
    move = candidate(problem, network, "linear")
    lame = nu / ((1 + nu) * (1 - 2 * nu))
    own = lame * dilatation(network, move)
    mesh = reference_fem.box_discretisation(box_of(problem), along, "Q2")
    held, moved = kit.prescribed_displacements(problem, mesh.points)
    _, p = solve_mixed_on(mesh, problem.material, held, moved, nodal_forces(problem, mesh))
    place = np.full(len(mesh.points), -1)
    place[mesh.vertices] = np.arange(len(p))
    corners = mesh.cells[:, :4]
    middle, theirs = mesh.points[corners].mean(axis=1), p[place[corners]].mean(axis=1)
    ours = network.points[_volumes(network).cells].mean(axis=1)
    first, second = (np.lexsort(np.round(at, 9).T) for at in (ours, middle))
    return own[first], theirs[second], ours[first]


def dilatation(network: Network, move: kit.Array) -> kit.Array:
    """Part (c,) by which cells swell, to first order in a displacement (n, 2)."""
    volumes, points = _volumes(network), network.points
    factor = SMALL / np.abs(move).max()
    high, low = (cell_volumes(points + s * move, volumes.cells) for s in (factor, -factor))
    return np.asarray((high - low) / (2 * factor * volumes.rest_volume))


def _volumes(network: Network) -> Volumes:
    if network.volumes is None:
        raise kit.ProblemError("cell pressures: no volumes; give a network that has some")
    return network.volumes


def _alternating(field: kit.Array) -> kit.Array:
    """Part of a field on a grid that changes its sign from cell to cell along both axes."""
    return np.asarray(field[:-1, :-1] - field[1:, :-1] - field[:-1, 1:] + field[1:, 1:]) / 4


def _size(field: kit.Array) -> float:
    return float(np.sqrt(np.mean(field**2)))
