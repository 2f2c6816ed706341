"""Cases: the layout that all benchmarks share: a value beside the accepted one, mesh by mesh.

A question makes a `Quantity` for every number that the literature, or a closed form, accepts, and
`rows` for every method that is to give it; `convergence` draws them.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from msvalidate import kit
from reference_fem.richardson import extrapolate_each

ROUNDING = 1e-10
"""Relative difference below which a value is exact: 1e-16 times a condition number of up to 1e6."""
PLAUSIBLE = (0.5, 6.0)
"""Orders that two meshes can show: quadratic elements have 4 in displacements at their corners."""
DOUBTFUL = 0.25
"""Part of a difference that the limit's own uncertainty may be: it moves an order by 0.3."""
FINDING_DIGITS = 3
VOLUME = " + volume energy"
"""In the names of methods that have one."""
LOOKS = {
    "FEM Q1": ("elements, linear (Q1)", 4, "o"),
    "FEM Q2": ("elements, quadratic (Q2)", 0, "s"),
    "FEM H2": ("elements, quadratic (H2)", 0, "s"),
    "springs, square": ("springs, square lattice", 1, "^"),
    "springs, square, cut": ("springs, cut square lattice", 1, "^"),
    "springs, square, cut, quadratic fit": ("springs, cut lattice, quadratic fit", 5, "v"),
    "springs, square, cut, quartic fit": ("springs, cut lattice, quartic fit", 2, "D"),
    "springs, edges of triangles": ("springs, edges of triangles", 5, "P"),
    "springs, cut cubic18": ("springs, cut cubic lattice, 18 neighbours", 1, "^"),
}
"""Method without volume energy -> its words in pictures, number of its colour, and marker."""
LAYOUT = (
    "benchmark", "quantity", "unit", "accepted", "source", "limit", "limit_uncertainty", "method",
    "nu", "cells", "value", "against_accepted", "against_limit", "uncertainty", "order",
)  # fmt: skip
"""Columns of a benchmark's table."""
judged = partial(kit.Rule, unit="1", by=("benchmark", "quantity", "nu", "method"), last=1)
"""A rule of the finest mesh of every quantity and method."""
fitted = partial(
    kit.Rule, unit="1", value="against_limit", power_of=kit.Quotient(1, "cells"),
    by=("method", "nu"), reference=2.0,
)  # fmt: skip
"""A rule of the order fitted to all meshes of each method and ratio."""
STATED = kit.Quotient("against_limit", "uncertainty")
"""Distance from the limit over the uncertainty that the meshes themselves state."""


@dataclass(frozen=True)
class Quantity:
    """A number of a benchmark and the value that is accepted for it.

    `limit`: what meshes converge to, where that is known better than the accepted value: in closed
    form or by our own finite elements, with its relative uncertainty.
    """

    benchmark: str
    name: str
    unit: str
    accepted: float
    source: str
    nu: float
    limit: float | None = None
    limit_uncertainty: float = 0.0

    @property
    def goal(self) -> float:
        """The limit where there is one of its own, else the accepted value."""
        return self.accepted if self.limit is None else self.limit


def rows(
    quantity: Quantity, method: str, cells: Sequence[int], values: Iterable[float]
) -> list[dict[str, object]]:
    """Rows of one method, coarsest mesh first."""
    found = list(values)
    known, goal = quantity.accepted, quantity.goal
    head = [quantity.benchmark, quantity.name, quantity.unit, known, quantity.source, goal]
    head += [quantity.limit_uncertainty, method, quantity.nu]
    away = [value / goal - 1 for value in found]
    table: list[dict[str, object]] = []
    for i, (n, value) in enumerate(zip(cells, found, strict=True)):
        row = (n, value, value / known - 1, away[i], uncertainty(cells[: i + 1], found))
        fall = order(cells, away, i, quantity.limit_uncertainty)
        table.append(dict(zip(LAYOUT, (*head, *row, fall), strict=True)))
    return table


def order(
    cells: Sequence[int], away: Sequence[float], at: int, uncertainty: float = 0.0
) -> float | str:
    """Power of the spacing with which a difference fell to row `at`, or a word; see `order`."""
    if at == 0:
        return "coarsest"
    before, after = away[at - 1], away[at]
    if abs(after) <= ROUNDING:
        return "exact"
    if uncertainty > DOUBTFUL * abs(after):
        return "not resolved"
    if before * after <= 0:
        return "not asymptotic"
    power = float(np.log(before / after) / np.log(cells[at] / cells[at - 1]))
    return power if PLAUSIBLE[0] <= power <= PLAUSIBLE[1] else "not asymptotic"


def uncertainty(cells: Sequence[int], values: Sequence[float]) -> float | str:
    """Richardson's of the last of these meshes, relative; three must double their cells."""
    at = len(cells)
    if at < 3 or cells[at - 3] * 4 != cells[at - 1] or cells[at - 2] * 2 != cells[at - 1]:
        return "none"
    rows = [np.array([value]) for value in values[:at]]
    estimate = extrapolate_each(rows, int(cells[at - 1]), PLAUSIBLE[1])
    return float(abs(estimate.uncertainty[0] / rows[-1][0]))


def finest(table: pd.DataFrame) -> pd.DataFrame:
    """The row of the finest mesh of every quantity and method, in their order."""
    keys = ["benchmark", "quantity", "nu", "method"]
    return table.groupby(keys, sort=False).tail(1).reset_index(drop=True)


def rounding_of_orders(table: pd.DataFrame) -> float:
    """How far `ROUNDING` of a mesh's value moves its order from twice the spacing, at most."""
    left = np.abs(table["against_limit"].to_numpy())[np.isfinite(orders(table))]
    return ROUNDING / (math.log(2) * float(left.min(initial=np.inf)))


def orders(table: pd.DataFrame) -> kit.Array:
    """Orders (rows,), words, which are none, as NaN: what has no order fails where one is due."""
    return np.asarray(pd.to_numeric(table["order"], errors="coerce"))


def of_springs(table: pd.DataFrame) -> pd.DataFrame:
    """Rows of networks, those of elements left out."""
    return table[table["method"].str.startswith("springs")]


def has_layout(table: pd.DataFrame) -> bool:
    """Whether a table has the layout."""
    return set(LAYOUT) <= set(table)


def summary(tables: kit.Tables) -> pd.DataFrame:
    """All benchmarks on their finest meshes, of those tables that have the layout."""
    found = [finest(table[list(LAYOUT)]) for table in tables.values() if has_layout(table)]
    return pd.concat(found, ignore_index=True)


def describe(table: pd.DataFrame) -> str:
    """Words for a finding: each method's difference to the accepted value on its finest mesh."""
    seen = finest(table)
    many = [seen[column].nunique() > 1 for column in ("quantity", "nu", "cells")]
    words = []
    for row in seen.to_dict("records"):
        about = [row["method"]]
        about += [row["quantity"]] if many[0] else []
        about += [f"nu = {row['nu']:.3g}"] if many[1] else []
        about += [f"{row['cells']:g} cells"] if many[2] else []
        percent = 100 * row["against_accepted"]
        words.append(f"{percent:+.{FINDING_DIGITS - 1}g} % ({', '.join(about)})")
    return "; ".join(words) + ("" if many[2] else f", at {seen['cells'].iloc[0]:g} cells")


def convergence(name: str, body: str, xlabel: str, tables: kit.Tables) -> Figure:
    """Differences to the limit against cells, an axis for every quantity and Poisson's ratio."""
    panels = list(tables[name].groupby(["quantity", "nu"], sort=False))
    columns = min(len(panels), 2)
    lines = -(-len(panels) // columns)
    few = lines <= 2
    size = (4.8, 4.2) if columns == 1 else (3.3, 3.2) if few else (3.8, 7.5 / lines)
    figure, axes = kit.figures.new_figure(columns, lines, size=size, sharex=True, sharey=True)
    for axis in axes[len(panels) :]:
        axis.remove()
    for axis, ((quantity, nu), rows_here) in zip(axes, panels, strict=False):
        draw(axis, rows_here)
        volume = rows_here["method"].str.contains(VOLUME, regex=False).any()
        words = [quantity_words(str(quantity)), f"nu = {nu:.3g}{VOLUME if volume else ''}"]
        axis.set_title(("\n" if few else ", ").join(words), fontsize=9 if few else 8)
        axis.tick_params(labelbottom=few or axis in axes[len(panels) - columns :])
    cells = sorted(set(tables[name]["cells"]))
    axes[0].set_xticks(cells, [str(n) for n in cells])
    for axis in axes[len(panels) - columns : len(panels)]:  # the lowest of every column
        axis.set_xlabel(xlabel)
    for axis in axes[:: columns * max(1, lines // 2)]:
        axis.set_ylabel("difference (%)")
    figure.suptitle(f"{body}: differences to the limit")
    kit.figures.add_shared_legend(figure, axes[: len(panels)], columns=columns)
    return figure


def quantity_words(quantity: str) -> str:
    """A quantity as a picture names it; places are in metres."""
    return quantity.replace("u_y", "displacement uy").replace("midspan", "deflection at midspan")


def method_look(method: str) -> tuple[str, dict[str, Any]]:
    """Words for a method and its style, the same with a volume energy, in every figure the same."""
    plain = method.replace(VOLUME, "")
    words, colour, marker = LOOKS.get(plain, (plain, 3, "X"))
    style = {"color": kit.figures.COLOURS[colour], "marker": marker}
    return words, style | {"ls": "--" if plain.startswith("FEM") else "-"}


def draw(axis: Axes, table: pd.DataFrame) -> None:
    """Series of one quantity, what is exact left out, and the uncertainty of its limit."""
    for method, series in table.groupby("method", sort=False):
        words, style = method_look(str(method))
        size = 100 * series["against_limit"].abs()
        shown = size > 100 * ROUNDING
        axis.loglog(series["cells"][shown], size[shown], label=words, **style)
    uncertainty = float(table["limit_uncertainty"].max())
    if uncertainty:
        axis.axhline(100 * uncertainty, color="grey", ls=":", label="uncertainty of the limit")
    ticks = sorted(set(table["cells"]))
    axis.set_xticks(ticks, [str(n) for n in ticks])


def drawing(name: str, body: str, xlabel: str) -> Any:
    """`convergence` of one table, as `Evidence.figures` wants it; the caption names the body."""

    def draw_convergence(tables: kit.Tables) -> Figure:
        return convergence(name, body, xlabel, tables)

    draw_convergence.__doc__ = f"{body}: differences to the limit, mesh by mesh."
    return draw_convergence
