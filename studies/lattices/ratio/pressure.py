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
from matplotlib.figure import Figure
from scipy.linalg import eigh

import reference_fem
from msvalidate.bodies.calibrate import calibrate
from msvalidate.bodies.lattice_network import lattice_network
from msvalidate.judging.candidate import DisplacementSolver
from msvalidate.judging.compare import farthest_value, observed_order
from msvalidate.judging.evidence import Evidence, Observed, Tables, Tolerance, by_quantity
from msvalidate.judging.sweep import Setting
from msvalidate.lattice import fill, patterns
from msvalidate.network import Network, tangent
from msvalidate.network.laws.volumes import cell_volumes
from msvalidate.output import figures
from msvalidate.problem import (
    Array,
    Box,
    Isotropic,
    Problem,
    ProblemError,
    Support,
    prescribed_displacements,
)
from reference_fem.body import nodal_forces
from reference_fem.mixed import solve_mixed_on

from .bent import bend_block, box_of, counts, springs_of

HELD = {"left": ("left",), "all round": ("left", "right", "bottom", "top")}
LABELS = {"left": "held at the left", "all round": "held all round"}
SIZES, QUICK = (4, 8, 16, 24), (4, 8, 12)
BENT, QUICK_BENT = (8, 16, 32), (8, 16)
RATIOS = (0.45, 0.499, 0.4999)
NOTHING = 1e-10
"""Square of a push, relative to the largest, that is rounding."""
SMALL = 1e-4
"""Of a displacement (m) from which dilatations are taken: linear in it to rounding."""
FREE = 0.5
"""Part of the block, from its loaded end, that has no corner with singular stress but weak ones."""
TOLERANCES = (
    Tolerance(
        "patterns of pressure that push nothing: 2 held all round, else none", 0, "1",
        "black against white, and a constant; any free side is pushed by both",
    ),
    Tolerance(
        "least push of other patterns, held all round: order in the spacing, from 1", 0.25, "1",
        "the next term is of one order more: on 8 and 12 cells, as large as the first at one cell, "
        "it makes 0.1, and twice as large 0.22",
    ),
    Tolerance(
        "bent block, away from the clamped side: cell pressures from mixed elements', finest size",
        0.02, "1",
        "of order 2 but for the corners' own: some (1/16)² times 5; a pattern that alternates "
        "would not fall",
    ),
)  # fmt: skip
COLUMNS = {
    "held": "sides that are held: left, or all round",
    "cells_square": "cells along each edge of a square block",
    "silent": "patterns of cell pressures that push no point",
    "least_push": "least norm of the push of any other pattern, in the springs' energy, over the "
    "pattern's own norm, for springs of μ = 1 (1)",
    "push_order": "slope of log(least_push) against log(spacing) between the finest two sizes, 0 "
    "where no pattern gets silent (1)",
    "nu_pressed": "Poisson's ratio of the bent block, plane strain (1)",
    "cells_bent": "cells through the height of the bent block",
    "pressure_difference": "root mean square of cell pressures less those of mixed elements, over "
    "that of these, in the half of the block at the load (1)",
    "alternating": "root mean square of pressures' part that alternates along both axes over four "
    "cells, over that of pressures, same half (1)",
    "alternating_mixed": "the same of mixed elements' pressures at the cells' middles (1)",
}


def run(candidate: DisplacementSolver, setting: Setting) -> Evidence:
    """Look for patterns that push little, and for their traces in a bent block."""
    sizes, across = (QUICK, QUICK_BENT) if setting.quick else (SIZES, BENT)
    todo = [(held, n) for held in HELD for n in sizes]
    pushes = pd.DataFrame(setting.sweep(push_row, todo, "pressures that push little"))
    shown = [(nu, n) for nu in (RATIOS[1:2] if setting.quick else RATIOS) for n in across]
    fields = pd.DataFrame(setting.sweep(partial(press_body, candidate), shown, "cell pressures"))
    orders = pd.DataFrame(
        {"held": held, "push_order": observed_order(1 / mine["cells_square"], mine["least_push"])}
        for held, rows in pushes.groupby("held", sort=False)
        for mine in [rows.iloc[-2:]]
    )
    finest = fields[fields["cells_bent"] == max(across)]
    round_order = orders.set_index("held")["push_order"]["all round"]
    wrong = pushes["silent"] != pushes["held"].map({"left": 0, "all round": 2})
    values = (
        Observed(float(wrong.sum())),
        Observed(float(round_order), 1.0),
        farthest_value(finest["pressure_difference"], 0.0),
    )
    return Evidence(
        tables={"pressure_push": pushes, "push_order": orders, "pressures": fields},
        observed=by_quantity(TOLERANCES, values),
        tolerances=TOLERANCES,
        figures={"pressures": draw},
        columns=COLUMNS,
        rounding={"least_push": 1e-9, "push_order": 1e-6}
        | dict.fromkeys(("pressure_difference", "alternating", "alternating_mixed"), 1e-8),
        findings=findings(pushes, orders, fields),
    )


def findings(pushes: pd.DataFrame, orders: pd.DataFrame, fields: pd.DataFrame) -> tuple[str, ...]:
    """Whether pressures alternate."""
    order = orders.set_index("held")["push_order"]
    silent = pushes[pushes["held"] == "all round"]["silent"].max()
    last = fields.iloc[-1]
    theory = (
        f"Held all round, {silent} patterns of cell pressures push nothing, a constant and black "
        "against white; the least push of the others falls with order "
        f"{order['all round']:.2f} in the spacing (held at the left: {order['left']:.2f}), so "
        "pressures are not safe by theory as those of mixed elements are."
    )
    seen = (
        f"In a bent block at nu = {last['nu_pressed']:g} and {last['cells_bent']:.0f} cells, cell "
        "pressures away from the clamped side are off by "
        f"{last['pressure_difference']:.1g}, and alternate by {last['alternating']:.1g} of "
        f"themselves, those of mixed elements by {last['alternating_mixed']:.1g}: a trace of such "
        "patterns, and no more."
    )
    return theory, seen


def push_row(todo: tuple[str, int]) -> dict[str, object]:
    """One row of the table `pressure_push`.

    With K of the springs and B of the cells' dilatations, BᵀV⁻¹B u = β² K u: the numbers β that
    are not zero are the pushes, as many as there are cells but for the silent patterns.
    """
    held, n = todo
    box = Box((1.0, 1.0))
    supports = tuple(Support(box.side(side), (0.0, 0.0)) for side in HELD[held])
    problem = Problem(box, Isotropic(1.0, 1 / 3), supports, name="patterns of pressure")
    lattice = fill(patterns.square(), box, n)
    springs = calibrate(2 * (1 + 1 / 3), 1 / 3, lattice).constants
    plain = lattice_network(problem, lattice, springs)
    whole = lattice_network(problem, lattice, springs, volume=1.0)
    free = np.flatnonzero(~plain.held.ravel())
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


def press_body(candidate: DisplacementSolver, todo: tuple[float, int]) -> dict[str, object]:
    """One row of the table `pressures`."""
    nu, n = todo
    own, mixed, middle = fields(candidate, nu, n)
    length = middle[:, 0].max() + middle[0, 0]
    near = middle[:, 0] > (1 - FREE) * length
    grid = tuple(len(np.unique(np.round(middle[near, axis], 9))) for axis in (0, 1))
    order = np.lexsort(np.round(middle[near], 9).T[::-1])
    a, b = (field[near][order].reshape(grid) for field in (own, mixed))
    return {
        "nu_pressed": nu,
        "cells_bent": n,
        "pressure_difference": _size(a - b) / _size(b),
        "alternating": _size(_alternating(a)) / _size(a),
        "alternating_mixed": _size(_alternating(b)) / _size(b),
    }


def fields(candidate: DisplacementSolver, nu: float, cells: int) -> tuple[Array, Array, Array]:
    """Pressures (c,) in Pa in cells by springs and by mixed elements, and the middles (c, 2)."""
    problem = bend_block("plane_strain", nu)
    along = counts(box_of(problem), cells)
    network = springs_of(problem, "square", along)
    move = candidate(problem, network, "linear")
    lame = nu / ((1 + nu) * (1 - 2 * nu))
    own = lame * dilatation(network, move)
    mesh = reference_fem.box_discretisation(box_of(problem), along, "Q2")
    held, moved = prescribed_displacements(problem, mesh.points)
    _, p = solve_mixed_on(mesh, problem.material, held, moved, nodal_forces(problem, mesh))
    place = np.full(len(mesh.points), -1)
    place[mesh.vertices] = np.arange(len(p))
    corners = mesh.cells[:, :4]
    middle, theirs = mesh.points[corners].mean(axis=1), p[place[corners]].mean(axis=1)
    if network.volumes is None:
        raise ProblemError("cell pressures: no volumes; give a network that has some")
    ours = network.points[network.volumes.cells].mean(axis=1)
    first, second = (np.lexsort(np.round(at, 9).T) for at in (ours, middle))
    return own[first], theirs[second], ours[first]


def dilatation(network: Network, move: Array) -> Array:
    """Part (c,) by which cells swell, to first order in a displacement (n, 2)."""
    if network.volumes is None:
        raise ProblemError("dilatation of cells: no volumes; give a network that has some")
    cells, points = network.volumes.cells, network.points
    step = SMALL / np.abs(move).max() * move
    swollen = cell_volumes(points + step, cells) - cell_volumes(points - step, cells)
    return np.asarray(swollen / (2 * network.volumes.rest_volume) * np.abs(move).max() / SMALL)


def _alternating(field: Array) -> Array:
    """Part of a field on a grid that changes its sign from cell to cell along both axes."""
    return np.asarray(field[:-1, :-1] - field[1:, :-1] - field[:-1, 1:] + field[1:, 1:]) / 4


def _size(field: Array) -> float:
    return float(np.sqrt(np.mean(field**2)))


def draw(tables: Tables) -> Figure:
    """Least push against the size; pressures' differences and what alternates of them."""
    pushes, shown = tables["pressure_push"], tables["pressures"]
    figure, (left, right) = figures.new_figure(2, size=(3.3, 3.3))
    for number, (held, mine) in enumerate(pushes.groupby("held", sort=False)):
        left.loglog(
            mine["cells_square"],
            mine["least_push"],
            figures.MARKERS[number] + "-",
            color=figures.COLOURS[number],
            label=LABELS[str(held)],
        )
    cells = np.array(sorted(set(pushes["cells_square"])), dtype=float)
    left.loglog(cells, 2 / cells, ":", color="grey", label="slope -1")
    left.set_xticks(cells, [f"{n:g}" for n in cells])
    left.set_title("patterns that push least")
    left.set(xlabel="cells along an edge (1)", ylabel="least push of a pattern (1)")
    nu = shown["nu_pressed"].max()
    mine = shown[shown["nu_pressed"] == nu]
    for number, (name, label) in enumerate(
        (
            ("pressure_difference", "from mixed elements'"),
            ("alternating", "alternating part"),
            ("alternating_mixed", "alternating part, mixed"),
        )
    ):
        right.loglog(
            mine["cells_bent"],
            mine[name],
            figures.MARKERS[number + 2] + "-",
            color=figures.COLOURS[number + 2],
            label=label,
        )
    cells = np.array(sorted(set(mine["cells_bent"])), dtype=float)
    right.set_xticks(cells, [f"{n:g}" for n in cells])
    right.set(xlabel="cells through the height (1)", ylabel="part of the pressure (1)")
    right.set_title(f"bent block, plane strain, nu = {nu:g}")
    figure.suptitle("Pressures of cells: patterns that alternate")
    for axis in (left, right):
        axis.legend(fontsize=8)
    return figure
