"""Figure of strips with a hole: concentration of stress by the hole's part of the width."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from msvalidate.judging.evidence import Tables
from msvalidate.output import figures


def strips(tables: Tables) -> Figure:
    """K_tn by all ways, and how far Heywood's fit and springs are from elements."""
    rows = tables["strips"]
    part = rows["d_over_W"]
    figure, (values, off) = figures.new_figure(2, size=(3.3, 3.3))
    smooth = np.linspace(part.min(), part.max(), 60)
    values.plot(smooth, 2 + (1 - smooth) ** 3, "-", color="black", lw=1, label="Heywood's fit")
    ways = (
        ("K_elements", "finite elements"),
        ("K_potentials", "Kolosov's potentials"),
        ("K_springs", "springs"),
    )
    for i, (column, label) in enumerate(ways):
        colour, size = figures.COLOURS[i], 9 - 2 * i
        style: dict[str, Any] = {
            "color": colour,
            "marker": figures.MARKERS[i],
            "ls": "",
            "ms": size,
        }
        values.plot(part, rows[column], mfc="none", label=label, **style)
    doubt = 100 * rows["K_uncertainty"]
    off.fill_between(part, -doubt, doubt, color="#cccccc", lw=0, label="uncertainty of elements")
    off.plot(part, 100 * rows["heywood_off"], "-o", color="black", label="Heywood's fit")
    off.plot(part, 100 * rows["springs_off"], "--^", color=figures.COLOURS[2], label="springs")
    values.set_ylabel("largest stress over net section's mean (1)")
    off.set_ylabel("difference to finite elements (%)")
    for axis in (values, off):
        axis.set_xlabel("diameter over width, d/W (1)")
        axis.legend(fontsize=8)
    figure.suptitle("Strips with a hole in tension: largest stress on the hole")
    return figure
