"""Figures of relaxation: steps and seconds against the points; Newton's method beside elements."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from msvalidate.judging.evidence import Tables
from msvalidate.output import figures

C = figures.COLOURS
STYLES: dict[str, dict[str, Any]] = {
    "algorithm1": {"color": C[0], "marker": "o", "ls": "--"},
    "viscous_leapfrog": {"color": C[0], "marker": "s"},
    "kinetic_damping": {"color": C[2], "marker": "^"},
    "fire": {"color": C[3], "marker": "D"},
    "adaptive": {"color": C[4], "marker": "v"},
    "conjugate_gradients": {"color": C[5], "marker": "P"},
    "newton": {"color": C[1], "marker": "o"},
    "newton_multigrid": {"color": C[1], "marker": "s", "ls": "--"},
}
TIGHT = 1e-6


def draw(tables: Tables) -> Figure:
    """Steps and seconds to an error of 1e-6, the exponents of each method in the legend."""
    table = tables["relaxation"]
    table = table[(table["threshold"] == TIGHT) & (table["outcome"] == "reached")]
    figure, axes = figures.new(2, size=(4.0, 3.4))
    values = (
        ("steps_here", "steps", "steps to an error of 1e-6"),
        ("cpu_seconds", "seconds", "seconds to an error of 1e-6"),
    )
    for axis, (column, quantity, label) in zip(axes, values, strict=True):
        for method, rows in table.groupby("method", sort=False):
            name = f"{method}{exponents(tables, str(method))}".replace("_", " ")
            axis.loglog(rows["nodes"], rows[column], label=name, **STYLES[str(method)])
        law = 0.5 if quantity == "steps" else 1.5
        slope(axis, table, law)
        axis.set(xlabel="points", ylabel=label)
        axis.set_title("in brackets: exponents of steps and of seconds", fontsize=8)
    figures.shared_legend(figure, axes, columns=3)
    return figure


def exponents(tables: Tables, method: str) -> str:
    """Exponents of steps and seconds, in brackets."""
    grown = tables["relaxation_growth"]
    grown = grown[(grown["method"] == method) & (grown["threshold"] == TIGHT)]
    power = grown.set_index("quantity")["exponent_here"]
    if not {"steps", "seconds"} <= set(power.index):
        return ""
    return f" ({power['steps']:.2f}, {power['seconds']:.2f})"


def slope(axis: Any, table: Any, law: float) -> None:
    """A dotted line of the expected power, in the lower half of the picture."""
    nodes = np.array([table["nodes"].min(), table["nodes"].max()], dtype=float)
    low, high = axis.get_ylim()
    start = low * (high / low) ** 0.25
    axis.loglog(
        nodes,
        start * (nodes / nodes[0]) ** law,
        ":",
        color="black",
        label="points^0.5 and points^1.5",
    )


def draw_large(tables: Tables) -> Figure:
    """Newton's method with multigrid and elements on the same cells, in seconds."""
    table = tables["large"]
    figure, (axis,) = figures.new(size=(4.4, 3.4))
    axis.loglog(
        table["nodes"],
        table["newton_seconds"],
        "s-",
        color=C[1],
        label="springs: Newton with multigrid, 1 % strain",
    )
    axis.loglog(
        table["nodes"],
        table["elements_seconds"],
        "o-",
        color=C[0],
        label="elements: one linear solution",
    )
    axis.set(xlabel="points", ylabel="seconds on one core")
    axis.legend(fontsize=8)
    return figure
