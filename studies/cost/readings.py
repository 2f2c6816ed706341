"""How a target is read from the tables of the other questions: ratios, round by round."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import pandas as pd

from msvalidate import kit

from .timing import ABSENT, SINGLE, ratios


class Reading(NamedTuple):
    """Values of rounds, or least, median and most of them; and how many rounds there were."""

    values: list[float]
    rounds: int


Measured = Reading | str
"""What was read, or why nothing was."""
SMALL_FORM = "its size is left to the full form"
NO_PEER = "the peer is not installed"


def chosen(
    tables: kit.Tables, name: str, near: Mapping[str, int], **wanted: object
) -> pd.DataFrame:
    """Rows of a table that match, in columns of sizes to a tenth."""
    table = tables[name]
    for column, size in near.items():
        table = table[(table[column] / size - 1).abs() < 0.1]
    for column, value in wanted.items():
        table = table[table[column] == value]
    return table


def compared(
    table: pd.DataFrame, value: str, over: Mapping[str, object], under: Mapping[str, object]
) -> Measured:
    """Ratios of rounds, or why there are none."""
    found = [] if table.empty else ratios(table, value, over, under)
    if found:
        return Reading(found, len(found))
    return NO_PEER if (table[value] == ABSENT).any() else SMALL_FORM


def ours_over(way: str, peer: str, nodes: int, tables: kit.Tables) -> Measured:
    """Nanoseconds of a peer over those of a way of ours."""
    table = chosen(tables, "kernel_rounds", {"nodes": nodes}, network="lattice")
    return compared(table, "ns_here", {"way": peer}, {"way": way})


def network_over(name: str, nodes: int, tables: kit.Tables) -> Measured:
    """Time a spring of a network over that of the lattice, both on the general path."""
    table = chosen(tables, "kernel_rounds", {"nodes": nodes}, way="general")
    return compared(table, "ns_here", {"network": name}, {"network": "lattice"})


def speed_up(nodes: int, tables: kit.Tables) -> Measured:
    """Wall time of one thread over that of two."""
    table = chosen(tables, "kernel_rounds", {"nodes": nodes}, network="lattice")
    one, two = {"way": "general"}, {"way": "general, 2 threads"}
    return compared(table, "wall_ns_here", one, two)


def share(nodes: int, tables: kit.Tables) -> Measured:
    """Share of the memory's bandwidth by counted bytes, where each step is a pass over memory."""
    limits, rounds = (
        chosen(tables, name, {"nodes": nodes}, network="lattice", way=SINGLE)
        for name in ("limits", "kernel_rounds")
    )
    if limits.empty:
        return SMALL_FORM
    known = limits.iloc[0]
    shares = [float(known["share_here"] * known["ns_here"] / ns) for ns in rounds["ns_here"]]
    return Reading(shares, len(shares))


def elements(
    axes: int, unknowns: int, task: str, over: str, under: str, tables: kit.Tables
) -> Measured:
    """Seconds of one program over another's."""
    table = chosen(tables, "fem_rounds", {"unknowns": unknowns}, axes=axes, task=task)
    return compared(table, "cpu_seconds", {"program": over}, {"program": under})


def newton_over_elements(nodes: int, tables: kit.Tables) -> Measured:
    """Newton's method with multigrid at 1 % strain over a linear solution by elements."""
    table = chosen(tables, "large", {"nodes": nodes})
    if table.empty:
        return SMALL_FORM
    names = ("least_over_elements_here", "over_elements_here", "most_over_elements_here")
    row = table.iloc[0]
    return Reading([float(row[name]) for name in names], int(row["rounds"]))


def newton_growth(tables: kit.Tables) -> Measured:
    """Exponent of its seconds between the smallest and the largest plate."""
    table = tables["large"]
    first, last = table.iloc[0], table.iloc[-1]
    if last["nodes"] < 900_000:
        return SMALL_FORM
    gain = math.log(last["newton_seconds"] / first["newton_seconds"])
    return Reading([gain / math.log(last["nodes"] / first["nodes"])], int(last["rounds"]))


def seconds_at_rest(shape: str, points: int, tables: kit.Tables) -> Measured:
    """Seconds of an equilibrium of springs."""
    table = chosen(tables, "equilibria", {"points": points}, shape=shape)
    if table.empty:
        return SMALL_FORM
    return Reading([float(table["cpu_seconds"].iloc[0])], int(table["rounds"].iloc[0]))


def growth_at_rest(shape: str, points: int, tables: kit.Tables) -> Measured:
    """Exponent of these seconds, where the largest body has so many points."""
    if chosen(tables, "equilibria", {"points": points}, shape=shape).empty:
        return SMALL_FORM
    grown = chosen(tables, "equilibria_growth", {}, shape=shape, quantity="seconds")
    return Reading([float(grown["exponent_here"].iloc[0])], 1)


def beside_steps(nodes: int, tables: kit.Tables) -> Measured:
    """Seconds over steps times the kernel's, of the explicit method that is fastest."""
    tight = tables["relaxation"]["threshold"].min()
    table = chosen(tables, "relaxation", {"nodes": nodes}, threshold=tight)
    table = table[table["kernel_seconds"] > 0]
    if table.empty:
        return SMALL_FORM
    best = table.sort_values("cpu_seconds", kind="stable").iloc[0]
    names = ("least_cpu_seconds", "cpu_seconds", "most_cpu_seconds")
    rounds = int(best["rounds"])
    return Reading([float(best[name] / best["kernel_seconds"]) for name in names], rounds)


def largest(name: str, column: str, tables: kit.Tables) -> Measured:
    """Largest number of a column of a table."""
    values = pd.to_numeric(tables[name][column], errors="coerce")
    return Reading([float(values.max())], 1) if values.notna().any() else SMALL_FORM
