"""Field: which potential and field does a charged slab have around it?

Question   Potential in and around a slab of rubber in air with a top that is covered in part.
Candidate  `SlabInAir`, its potential from free and bound charge.
Reference  Finite elements of slab and air.
Expected   One potential, whoever finds it. Field lines bend at bare faces: the normal field is ε_r
           times as large outside.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from msvalidate import kit
from msvalidate.dielectric.charges.faces import slab_faces
from reference_fem.electric import FAR

from . import in_air
from .common import ChargeSolver
from .in_air import LENGTH, VOLTAGES, Case

CASES = (Case(1 / 3, 1.0), Case(1 / 3, 3.0))
SEGMENTS, LAYERS = 120, 8
WIDE, HIGH = (-4.5, 4.5), (-1.75, 2.75)
SHOWN = ("potential", "field_x", "field_y")
GRID = (53, 27)
"""Points of the picture along and up. None of them lies on a face: fields jump there."""
RULES = (
    kit.Rule(
        "potential in and around the slab, charges against elements", 2e-3, "of the voltage",
        "elements of 8 layers err by 6e-4 in the capacitance, by order 3 from the 1.3e-3 by which "
        "6 and 12 layers differ, and next to an edge by two or three times as much",
        table="field", value="potential", reference="potential_elements",
    ),
)  # fmt: skip


def run(candidate: ChargeSolver, setting: kit.Setting) -> kit.Evidence:
    """Look at the potential on a grid of points."""
    table = pd.concat([inspect_field(candidate, case) for case in CASES], ignore_index=True)
    del setting  # one size serves both forms: it is a picture
    return kit.Evidence(
        tables={"field": table},
        tolerances=RULES,
        figures={"field": draw},
        columns=kit.columns(__file__),
    )


def inspect_field(candidate: ChargeSolver, case: Case) -> pd.DataFrame:
    """Potential and field of one slab."""
    x, y = (np.linspace(*ends, n) for ends, n in zip((WIDE, HIGH), GRID, strict=True))
    points = np.column_stack([part.ravel() for part in np.meshgrid(x, y)])
    faces = slab_faces(LENGTH, 1.0, SEGMENTS, covered=case.covered)
    found = candidate.in_air(faces, ratio=case.ratio).charges(VOLTAGES)
    field, right = found.field(points), np.array([LENGTH / 2, 0.0])
    elements = [in_air.reference(case, LAYERS, far).potential(points + right) for far in FAR]
    return pd.DataFrame(
        {
            "permittivity_ratio": case.ratio,
            "x": points[:, 0],
            "y": points[:, 1],
            "potential": found.potential(points),
            "potential_elements": np.mean(elements, axis=0),
            "field_x": field[:, 0],
            "field_y": field[:, 1],
        }
    )


def draw(tables: kit.Tables) -> Figure:
    """Potential and field lines, equal axes."""
    table = tables["field"]
    figure, axes = kit.figures.new_figure(1, 2, size=(6.4, 3.2), sharex=True)
    levels = np.linspace(-0.5, 0.5, 11)
    for axis, ratio in zip(axes, table["permittivity_ratio"].unique(), strict=True):
        rows = table[table["permittivity_ratio"] == ratio]
        grids = {c: rows.pivot_table(index="y", columns="x", values=c) for c in SHOWN}
        potential = grids["potential"]
        x, y = potential.columns.to_numpy(), potential.index.to_numpy()
        shades = axis.contourf(x, y, potential, levels, cmap="RdBu_r", extend="both")
        lines: dict[str, Any] = {"colors": "white", "linewidths": 0.4, "linestyles": "solid"}
        axis.contour(x, y, potential, levels, **lines)
        field = (grids["field_x"], grids["field_y"])
        axis.streamplot(x, y, *field, color="#444444", linewidth=0.6, arrowsize=0.6, density=0.5)
        low = (-LENGTH / 2, 0)
        axis.add_patch(
            Rectangle(low, LENGTH, 1, fill=False, ls="--", ec="black", lw=0.9, label="slab")
        )
        half = CASES[0].covered * LENGTH / 2
        axis.plot([-half, half], [1, 1], color="black", lw=3, label="electrodes")
        axis.plot([], [], color="#444444", lw=0.6, marker=">", ms=3, label="field lines")
        axis.plot([-LENGTH / 2, LENGTH / 2], [0, 0], color="black", lw=3)
        axis.grid(visible=False)
        axis.set(title=f"permittivity {ratio:g} times that of air", aspect="equal")
        axis.set_ylabel("y over height (1)")
    axes[-1].set_xlabel("x over height (1)")
    figure.suptitle("Potential and field lines around a slab covered by a third")
    figure.colorbar(shades, ax=axes, label="potential over voltage (1)")
    kit.figures.add_shared_legend(figure, axes)
    return figure
