"""Picture of Cook's membrane: deformed, coloured by stress, springs beside finite elements."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation

from msvalidate.judging.evidence import Tables
from msvalidate.output import figures
from msvalidate.problem import Array

from .curved_drawing import DIVERGING, SEQUENTIAL

CELLS, PLACES = 24, 16
"""Cells along the width of what is drawn, and of the mesh that it is drawn on."""
FIT = 2
"""Degree of the polynomial through displacements whose strain is drawn."""
SHRUNK = 0.4
"""Factor on the displacements: for E = 1 and F = 1 they are half as large as the panel."""
WORDS = {"springs": "springs, square, cut", "fem": "finite elements"}
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


def deformed(tables: Tables) -> Figure:
    """The panel moved by its displacements, in the colours of its stress and of the difference."""
    table = tables["cook_shape"]
    stresses = {name: table[f"stress_{name}"].to_numpy() for name in WORDS}
    top = max(float(stress.max()) for stress in stresses.values())
    away = 100 * (stresses["springs"] - stresses["fem"]) / top
    most = float(np.abs(away).max())
    same = Normalize(min(float(stress.min()) for stress in stresses.values()), top)
    drawn = [(name, word, stresses[name], same, SEQUENTIAL) for name, word in WORDS.items()]
    drawn.append(("springs", "springs - finite elements", away, Normalize(-most, most), DIVERGING))
    figure, axes = figures.new_figure(3, size=(2.9, 4.2), sharey=True)
    for axis, (name, word, value, norm, colours) in zip(axes, drawn, strict=True):
        x, y = (table[a] + SHRUNK * table[f"u{a}_{name}"] for a in "xy")
        shown = axis.tripcolor(
            Triangulation(x, y, triangles()), value, shading="gouraud", cmap=colours, norm=norm,
            rasterized=True,
        )  # fmt: skip
        rim = np.array([(0, 0), (48, 44), (48, 60), (0, 44)])
        axis.fill(*rim.T, fill=False, ec="#666666", lw=0.9)
        axis.set(xlabel="x (m)", aspect="equal")
        axis.set_title(f"{word}\ndisplacements x {SHRUNK}", fontsize=9)
        label = (
            "difference, of the largest (%)" if value is away else "larger principal stress (Pa)"
        )
        figure.colorbar(shown, ax=axis, orientation="horizontal", shrink=0.9, label=label)
    axes[0].set_ylabel("y (m)")
    return figure


def triangles() -> Array:
    """Corners (t, 3) of triangles between the places, which lie in rows of a mapped square."""
    number = np.arange((PLACES + 1) ** 2).reshape(PLACES + 1, PLACES + 1)
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]
    return np.concatenate(
        [np.stack(corners, axis=-1).reshape(-1, 3) for corners in ((a, b, c), (a, c, d))]
    )
