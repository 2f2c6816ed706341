"""Figures made from a table in a few words: series of lines and points, values at points."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from itertools import cycle
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from msvalidate.bench.judging.evidence import Tables
from msvalidate.bench.output import figures

LINES = ("-", "--", ":", "-.")
"""Line styles of columns next to the judged one."""
Draw = Callable[[Tables], Figure]
Words = Mapping[Any, str]
GREY: dict[str, Any] = {"color": "grey", "lw": 0.9}


def series(
    table: str,
    *,
    title: str,
    x: str,
    y: str | Mapping[str, str],
    labels: tuple[str, str],
    by: str | Sequence[str] = (),
    beside: Mapping[str, str] | None = None,
    panel: str | Sequence[str] = (),
    rows: Mapping[str, object] | None = None,
    words: Words | None = None,
    log: str = "",
    line: str = "-",
    orders: Sequence[float] = (),
    level: Mapping[float, str] | None = None,
    across: int = 3,
    size: tuple[float, float] = (3.4, 3.0),
    **axes: Any,
) -> Draw:
    """A function of tables that draws columns of one against another, a colour a series.

    Parameters
    ----------
    table, rows
        Its name, and column -> the value, or tuple of values, of the rows that are drawn.
    title
        Above the figure, and its caption.
    x, y
        Column along the axis, of numbers or words, and that of the points, or column -> legend of
        several. On a logarithmic axis distances from zero are drawn; words among numbers are not.
    labels
        Of the axes, with units.
    by, panel
        Columns whose values make series, and panels, `across` of them in a row.
    beside
        Column -> legend, drawn as thin lines without points: black if one for all series.
    words
        Value of a cell -> what legends and titles call it.
    log
        Axes that are logarithmic: "x", "y" or "xy".
    line
        Style of lines between points, as matplotlib's; "" draws none.
    orders
        Slopes of dotted lines through the first point: orders, where x is a spacing.
    level
        Value of y -> legend of a dashed line there.
    size, axes
        Inches of a panel; what else its axes are set to.
    """
    columns = {y: ""} if isinstance(y, str) else y

    def draw(tables: Tables) -> Figure:
        shown = select(tables[table], rows)
        names = [name for name, _ in _groups(shown, by)]
        figure, panels = _panels(shown, panel, words, across, size, labels)
        for axis, own in panels:
            axis.set(**{f"{way}scale": "log" for way in log})
            for name, one in _groups(own, by):
                legend = _name(name, words)
                _draw_one(axis, one, x, columns, names.index(name), legend, line, "y" in log)
            _draw_beside(axis, own, x, beside or {}, by, names, "y" in log)
            for value, legend in (level or {}).items():
                axis.axhline(value, ls="--", label=legend, **GREY)
            for order in orders:
                _draw_slope(axis, order)
            axis.set(**axes)
        figure.suptitle(title)
        if by or beside or level or orders or len(columns) > 1:
            figures.add_shared_legend(figure, [axis for axis, _ in panels], columns=3)
        return figure

    draw.__doc__ = title
    return draw


def field(
    table: str,
    *,
    title: str,
    at: tuple[str, str],
    value: str,
    label: str,
    size: tuple[float, float] = (3.4, 3.0),
) -> Draw:
    """A function of tables that draws a value at points of a body in the plane.

    Columns `at` are the coordinates (m), and `value` colours the points, by a label with its unit.
    Table, title and size are as for `series`.
    """

    def draw(tables: Tables) -> Figure:
        shown = tables[table]
        figure, (axis,) = figures.new_figure(size=size)
        dots = axis.scatter(shown[at[0]], shown[at[1]], c=shown[value], s=12)
        axis.set(aspect="equal", xlabel="x (m)", ylabel="y (m)")
        figure.colorbar(dots, ax=axis, label=label)
        figure.suptitle(title)
        return figure

    draw.__doc__ = title
    return draw


def select(table: pd.DataFrame, rows: Mapping[str, object] | None) -> pd.DataFrame:
    """Rows whose columns have these values, or one of the tuple of them."""
    for name, wanted in (rows or {}).items():
        table = table[table[name].isin(wanted if isinstance(wanted, tuple) else (wanted,))]
    return table


def _panels(
    table: pd.DataFrame,
    panel: str | Sequence[str],
    words: Words | None,
    across: int,
    size: tuple[float, float],
    labels: tuple[str, str],
) -> tuple[Figure, list[tuple[Axes, pd.DataFrame]]]:
    """Titled axes with their rows of a table; labels stand below and at the left."""
    groups = _groups(table, panel)
    wide = min(across, len(groups))
    figure, places = figures.new_figure(wide, -(-len(groups) // wide), size=size, sharey=True)
    for unused in places[len(groups) :]:
        figure.delaxes(unused)
    for place, (axis, (key, _)) in enumerate(zip(places, groups, strict=False)):
        axis.set_title(_name(key, words))
        axis.set_xlabel(labels[0] if place + wide >= len(groups) else "")
        axis.set_ylabel(labels[1] if place % wide == 0 else "")
    return figure, [(axis, own) for axis, (_, own) in zip(places, groups, strict=False)]


def _groups(table: pd.DataFrame, by: str | Sequence[str]) -> list[tuple[Any, pd.DataFrame]]:
    keys = [by] if isinstance(by, str) else list(by)
    return list(table.groupby(keys, sort=False)) if keys else [((), table)]


def _name(key: tuple[Hashable, ...], words: Words | None) -> str:
    plain = (f"{part:g}" if isinstance(part, float) else str(part) for part in key)
    return ", ".join((words or {}).get(part, text) for part, text in zip(key, plain, strict=True))


def _draw_one(
    axis: Axes,
    rows: pd.DataFrame,
    x: str,
    y: Mapping[str, str],
    place: int,
    name: str,
    line: str,
    positive: bool,
) -> None:
    for offset, (column, legend) in enumerate(y.items()):
        style = figures.series_style(place if name else place + offset)
        style["marker"] = figures.MARKERS[(place + offset) % len(figures.MARKERS)]
        if not line:  # points that coincide stay visible: earlier ones are larger
            style |= {"mfc": "none", "ms": max(4.0, 9.0 - 2 * (place + offset))}
        label = ", ".join(part for part in (name, legend) if part)
        axis.plot(*_places(rows, x, column, positive), ls=line or "none", label=label, **style)


def _draw_beside(
    axis: Axes,
    rows: pd.DataFrame,
    x: str,
    beside: Mapping[str, str],
    by: str | Sequence[str],
    names: list[Any],
    positive: bool,
) -> None:
    thin: dict[str, Any] = {"color": "black", "lw": 0.9}
    for style, (column, legend) in zip(cycle(LINES), beside.items(), strict=False):
        own = _groups(rows, by)
        alike = len({tuple(zip(one[x], one[column], strict=True)) for _, one in own}) == 1
        for name, one in own[:1] if alike else own:
            tint = {} if alike else {"color": figures.series_style(names.index(name))["color"]}
            axis.plot(*_places(one, x, column, positive), ls=style, **thin | tint)
        axis.plot([], [], ls=style, label=legend, **thin)


def _places(rows: pd.DataFrame, x: str, y: str, positive: bool) -> tuple[Any, pd.Series]:
    """Positions of points along an axis; words get positions of their own."""
    along = rows[x] if rows[x].dtype.kind in "fiu" else rows[x].astype(str)
    values = pd.to_numeric(rows[y], errors="coerce")
    return along, values.abs() if positive else values


def _draw_slope(axis: Axes, order: float) -> None:
    """A dotted line with this slope through the lowest point at the largest x."""
    lines = [np.array(curve.get_xydata(), dtype=float) for curve in axis.get_lines()]
    x, y = np.concatenate([one for one in lines if len(one)]).T
    ends = np.array([x.min(), x.max()])
    top = np.nanmin(y[x == x.max()])
    axis.plot(ends, top * (ends / x.max()) ** order, ":", label=f"order {abs(order):g}", **GREY)
