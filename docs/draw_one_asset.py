"""Draw docs/one-asset.svg: which solids answer one E and nu, from the committed full baseline.

python docs/draw_one_asset.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from msvalidate.bench.output import figures
from msvalidate.bench.output.stored import draw_files
from msvalidate.simulators.bodies.laws import predicted

HERE = Path(__file__).resolve().parent
RECORDED = HERE.parent / "reports" / "baseline" / "full" / "simulators" / "recorded.csv"
SOLVERS = {"newton-semi": "semi-implicit", "newton-vbd": "VBD"}
ASKED = np.linspace(0.1, 0.49, 79)


def draw() -> Figure:
    """Lines: the law of the source. Marks: what one step of the program shows."""
    table = pd.read_csv(RECORDED).set_index("name")
    figure, axes = figures.new_figure(columns=2, size=(4.2, 3.2))
    for place, (name, label) in enumerate(SOLVERS.items()):
        row = table.loc[name]
        law = str(row["law_and_settings"]).partition("; ")[0]
        solids = [predicted(law, 1.0, nu) for nu in ASKED]
        lines = [solid.E for solid in solids], [solid.nu for solid in solids]
        reads = row[["probed_modulus", "probed_ratio"]].astype(float)
        for axis, line, read in zip(axes, lines, reads, strict=True):
            colour, asked = figures.COLOURS[place], float(row["asked_ratio"])
            axis.plot(ASKED, line, color=colour, label=f"{label}: law of its source")
            mark = figures.MARKERS[place]
            axis.plot(asked, read, mark, color=colour, label=f"{label}: read from the program")
    for axis, words in zip(axes, ("E over the asked", "Poisson's ratio"), strict=True):
        axis.set(xlabel="Poisson's ratio asked for", ylabel=f"{words}, as simulated")
    figures.add_shared_legend(figure, axes, columns=2)
    return figure


if __name__ == "__main__":
    caption = "One E and nu, two solids; of XPBD there is none at rest"
    made = draw_files("one-asset", caption, draw)["one-asset.svg"]
    (HERE / "one-asset.svg").write_bytes(made)
