"""Picture of Cook's membrane: deformed, coloured by stress, springs beside finite elements."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation

from msvalidate.judging.evidence import Tables
from msvalidate.output import figures
from msvalidate.problem import Array

from . import sketches
from .curved_drawing import DIVERGING, SEQUENTIAL

CELLS, PLACES = 24, 16
"""Cells along the width of what is drawn, and of the mesh that it is drawn on."""
FIT = 2
"""Degree of the polynomial through displacements whose strain is drawn."""
SHRUNK = 0.4
"""Factor on the displacements: for E = 1 and F = 1 they are half as large as the panel."""
WORDS = {"springs": "springs, cut lattice", "fem": "finite elements"}
CORNERS = ((0.0, 0.0), (48.0, 44.0), (48.0, 60.0), (0.0, 44.0))
"""Corners of the panel at rest (m)."""
COLUMNS = {
    "x": "place along x (m)",
    "y": "place along y (m)",
    **{f"u{a}_{name}": f"displacement along {a}, {word} (m)"
       for name, word in WORDS.items() for a in "xy"},
    **{f"stress_{name}": f"larger principal stress, {word}, both by the same fit (Pa)"
       for name, word in WORDS.items()},
}  # fmt: skip


def shape(places: Array, seen: dict[str, tuple[Array, Array]]) -> pd.DataFrame:
    """Places (n, 2), and of each body its displacements (n, 2) and larger principal stress."""
    table: dict[str, Array] = {"x": places[:, 0], "y": places[:, 1]}
    for name, (move, stress) in seen.items():
        xx, yy, xy = stress.T
        table |= {f"ux_{name}": move[:, 0], f"uy_{name}": move[:, 1]}
        table[f"stress_{name}"] = (xx + yy) / 2 + np.hypot((xx - yy) / 2, xy)
    return pd.DataFrame(table)


def on_edges(tables: Tables) -> Figure:
    """Springs on the edges of meshes: differences to the limit, an axis for every rule."""
    table = tables["cook_edges"]
    named = table["method"].str.extract(r"edges of (?P<mesh>.*), rule (?P<rule>.*)")
    meshes = list(dict.fromkeys(named["mesh"]))
    rules = list(table.groupby(named["rule"], sort=False))
    figure, axes = figures.new_figure(len(rules), size=(3.3, 3.6), sharex=True, sharey=True)
    for axis, (rule, rows) in zip(axes, rules, strict=True):
        for mesh, line in rows.groupby(named["mesh"], sort=False):
            place = meshes.index(str(mesh))
            style = {"color": figures.COLOURS[place], "marker": figures.MARKERS[place]}
            axis.semilogx(line["cells"], 100 * line["against_limit"], label=str(mesh), **style)
        axis.set(title=f"springs by rule {rule}", xlabel="cells along the width (1)")
        axis.set_xticks(sorted(set(rows["cells"])), sorted(set(rows["cells"])))
        axis.minorticks_off()
        axis.axhspan(-5, 5, color="grey", alpha=0.25, lw=0, label="agrees: within 5 %")
    axes[0].set_ylabel("difference (%)")
    figure.suptitle("Cook's membrane by a spring on every edge of a mesh")
    figures.add_shared_legend(figure, axes, columns=2)
    return figure


def deformed(tables: Tables) -> Figure:
    """The panel moved by its displacements, in the colours of its stress and of the difference."""
    table = tables["cook_shape"]
    stresses = {name: table[f"stress_{name}"].to_numpy() for name in WORDS}
    top = max(float(stress.max()) for stress in stresses.values())
    away = 100 * (stresses["springs"] - stresses["fem"]) / top
    most = float(np.abs(away).max())
    same = Normalize(min(float(stress.min()) for stress in stresses.values()), top)
    drawn = [(name, word, stresses[name], same, SEQUENTIAL) for name, word in WORDS.items()]
    drawn.append(("springs", "springs - elements", away, Normalize(-most, most), DIVERGING))
    figure, axes = figures.new_figure(3, size=(2.3, 4.0), sharex=True, sharey=True)
    rim, shown = np.array(CORNERS), []
    right = np.isclose(table["x"], rim[1, 0])
    for axis, (name, word, value, norm, colours) in zip(axes, drawn, strict=True):
        x, y = (table[a] + SHRUNK * table[f"u{a}_{name}"] for a in "xy")
        shown.append(
            axis.tripcolor(
                Triangulation(x, y, triangles()), value, shading="gouraud", cmap=colours,
                norm=norm, rasterized=True,
            )
        )  # fmt: skip
        axis.fill(*rim.T, fill=False, ec="#666666", lw=0.9)
        mark_loads(axis, rim, np.column_stack([x, y])[right])
        axis.set(xlabel="x (m)", aspect="equal", title=word)
        axis.grid(visible=False)
    bar: dict[str, Any] = {"orientation": "horizontal", "aspect": 30}
    figure.colorbar(shown[0], ax=axes[:2], label="larger principal stress (Pa)", shrink=0.6, **bar)
    bar["aspect"] = 18
    figure.colorbar(shown[2], ax=axes[2], label="of the largest stress (%)", shrink=0.9, **bar)
    axes[0].set_ylabel("y (m)")
    figure.suptitle(f"Cook's membrane: stress, displacements times {SHRUNK}")
    return figure


def mark_loads(axis: Axes, corners: Array, loaded: Array | None = None) -> None:
    """The clamp on the left, and arrows up on the right edge, or beside moved places of it."""
    (_, low), (right, bottom), (_, top), (_, high) = corners
    sketches.clamp(axis, (0.0, low), (0.0, high), 4.0)
    if loaded is None:
        loaded = np.array([(right, bottom), (right, top)])
    (x, y), length = loaded[loaded[:, 1].argsort(kind="stable")].T, (top - bottom) / 3
    at = np.linspace(y[0], y[-1], 4)[1:]
    beside = np.column_stack([np.interp(at, y, x) + 2.0, at])
    sketches.forces(axis, beside, (0.0, 0.85 * length))


def triangles() -> Array:
    """Corners (t, 3) of triangles between the places, which lie in rows of a mapped square."""
    number = np.arange((PLACES + 1) ** 2).reshape(PLACES + 1, PLACES + 1)
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]
    return np.concatenate(
        [np.stack(corners, axis=-1).reshape(-1, 3) for corners in ((a, b, c), (a, c, d))]
    )
