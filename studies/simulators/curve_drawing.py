"""Figure of laws over the ratio asked for: lines as predicted, marks as read."""

from __future__ import annotations

import pandas as pd
from matplotlib.figure import Figure

from msvalidate import kit
from msvalidate.simulators.verdict.causes import STOPPED


def curve(tables: kit.Tables) -> Figure:
    """Poisson's ratio and modulus that two laws answer, against the ratio asked for."""
    table = tables["curve"]
    figure, axes = kit.figures.new_figure(columns=2, size=(3.7, 3.4))
    for axis, name, words in (
        (axes[0], "ratio", "Poisson's ratio answered (1)"),
        (axes[1], "modulus", "modulus answered\nover that asked for (1)"),
    ):
        for i, (law, rows) in enumerate(table.groupby("name", sort=False)):
            colour, label = kit.figures.COLOURS[i], str(law).replace("_", " ")
            stopped = str(rows["state_of_record"].iloc[0]).endswith(STOPPED)
            asked, drawn = rows["asked_ratio"], rows[[f"predicted_{name}", f"read_{name}"]]
            drawn = drawn.apply(pd.to_numeric, errors="coerce")
            axis.plot(
                asked, drawn[f"predicted_{name}"], color=colour,
                label=f"{label}, predicted",
            )  # fmt: skip
            axis.plot(
                asked, drawn[f"read_{name}"], kit.figures.MARKERS[i], color=colour,
                label=f"{label}, read{', not judged' * stopped}",
            )  # fmt: skip
        axis.set(xlabel="Poisson's ratio asked for (1)", ylabel=words)
    figure.suptitle("Two laws of one program: which solid answers?")
    kit.figures.add_shared_legend(figure, axes, columns=2)
    return figure
