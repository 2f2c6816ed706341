"""Figure of the question `kernel`: nanoseconds a spring and step against the points."""

from __future__ import annotations

from typing import Any

from matplotlib.figure import Figure

from msvalidate.judging.evidence import Tables
from msvalidate.output import figures

from .timing import ABSENT, SINGLE

C = figures.COLOURS
STYLES: dict[str, dict[str, Any]] = {
    "general": {"color": C[0], "marker": "o"},
    "general, 2 threads": {"color": C[0], "marker": "o", "ls": "--", "mfc": "none"},
    SINGLE: {"color": C[0], "marker": "o", "ls": "-.", "ms": 3},
    "uniform lattice": {"color": C[2], "marker": "s"},
    "uniform lattice, 2 threads": {"color": C[2], "marker": "s", "ls": "--", "mfc": "none"},
    "NumPy bincount": {"color": C[1], "marker": "^"},
    "SciPy sparse": {"color": C[5], "marker": "v"},
    "LAMMPS": {"color": C[3], "marker": "D"},
}
NETWORK_STYLES: dict[str, dict[str, Any]] = {
    "lattice": {"color": C[0], "marker": "o"},
    "lattice with volume energy": {"color": C[1], "marker": "s"},
    "random triangles": {"color": C[2], "marker": "^"},
    "random tetrahedra": {"color": C[3], "marker": "D"},
}


def draw(tables: Tables) -> Figure:
    """The lattice by every program, with what memory allows; networks on the general path."""
    table = tables["kernel"]
    table = table[table["ns_here"] != ABSENT]
    table = table.assign(ns=table["ns_here"].astype(float))
    figure, (left, right) = figures.new(2, size=(4.3, 4.0), sharey=True)
    lattice = table[table["network"] == "lattice"]
    for way, rows in lattice.groupby("way", sort=False):
        left.loglog(rows["nodes"], rows["ns"], label=str(way), **STYLES[str(way)])
    allowed(left, tables)
    general = table[table["way"] == "general"]
    for name, rows in general.groupby("network", sort=False):
        right.loglog(rows["nodes"], rows["ns"], label=str(name), **NETWORK_STYLES[str(name)])
    left.set_title("lattice, eight neighbours", fontsize=9)
    right.set_title("general path, one thread", fontsize=9)
    for axis in (left, right):
        axis.set(xlabel="points")
        low, high = axis.get_ylim()
        axis.set_ylim(min(low, 1.0), max(high, 10.0))
        axis.tick_params(labelleft=True)
        axis.legend(loc="upper center", bbox_to_anchor=(0.5, -0.18), ncols=2, fontsize=8)
    left.set_ylabel("ns a spring and step")
    return figure


def allowed(axis: Any, tables: Tables) -> None:
    """Draw what the memory's bandwidth allows where each step passes over it, if measured."""
    if "limits" not in tables:
        return
    memory = float(tables["bandwidth"]["gigabytes_per_second"].iloc[-1])
    rows = tables["limits"][tables["limits"]["way"] == SINGLE]
    ns = rows["bytes_a_node"] * rows["nodes"] / rows["springs"] / memory
    axis.loglog(rows["nodes"], ns, ":", color="black", lw=1.1, label="memory, a step a pass")
