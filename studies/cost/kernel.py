"""Kernel: what does a spring cost in a step, in which network, by which program?

Question   Nanoseconds a spring and step, against the number of points: by the compiled steps on
           their general path, on the path of uniform lattices, and on two threads.
Candidate  The package's `springs.kernels.Motion`, made ready before it is timed.
Reference  Other programs in the same process and in turn: NumPy's `bincount`, a matrix of SciPy,
           and LAMMPS, where it is installed.
Expected   The same per spring at the sizes until a network no longer fits into the caches, and no
           less than memory allows beyond.

One thread is timed by the clock of the process, two by the clock on the wall. A round is as many
steps as make about `WORK` springs. Seconds are told, and never judged.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from msvalidate import kit
from msvalidate.springs import kernels

from . import bodies, drawing, lammps_peer, plain
from .timing import ABSENT, ROUNDS, SINGLE, in_turn, summary

NODES = (1_000, 10_000, 100_000, 1_000_000)
QUICK_NODES = (1_000, 10_000)
MOST_NODES = {"random triangles": 100_000, "random tetrahedra": 100_000}
"""Of networks that take longer to make than to time."""
WORK, QUICK_WORK = 10_000_000, 400_000
"""Springs times steps of a round."""
SLOWER = {"NumPy bincount": 8, "SciPy sparse": 8, "LAMMPS": 4}
"""By how much less work a round of them is: each takes about so many times as long."""
LEAST_STEPS = 2
OUR_LEAST = 10
"""The same of ours, so that what a call prepares is a small part."""
KEEP = 0.99
"""Part of the velocity that a step keeps: nothing grows, nothing becomes too small to be a normal
number, which would take the processor longer."""
Moving = Callable[..., kernels.Motion]
"""`springs.kernels.Motion` or what stands for it."""


class Way(NamedTuple):
    """How steps are made: by which path of ours on how many threads, or by another program."""

    path: str
    threads: int = 1


OURS = {
    "general": Way("general"),
    "general, 2 threads": Way("general", 2),
    "uniform lattice": Way("lattice"),
}
OTHERS = ("NumPy bincount", "SciPy sparse", "LAMMPS")
WAYS = {
    "lattice": (*OURS, SINGLE, *OTHERS),
    "lattice with volume energy": ("general",),
    "random triangles": ("general", "general, 2 threads", "NumPy bincount"),
    "random tetrahedra": ("general",),
}
"""Network -> who moves it: LAMMPS makes its bonds by their lengths, and so only lattices'."""


def run(candidate: Moving, setting: kit.Setting) -> kit.Evidence:
    """Time every network at every size."""
    sizes = QUICK_NODES if setting.quick else NODES
    work = QUICK_WORK if setting.quick else WORK
    cases = [
        (name, nodes)
        for name in bodies.NETWORKS
        for nodes in sizes
        if nodes <= MOST_NODES.get(name, nodes)
    ]
    laps = setting.one_by_one(
        lambda case: time_kernel(candidate, work, *case), cases, "ns a spring and step"
    )
    rounds = pd.DataFrame([row for rows in laps for row in rows])
    table = summary(rounds.drop(columns="wall_ns_here"), "ns_here")
    return kit.Evidence(
        tables={"kernel": table, "kernel_rounds": rounds},
        figures={"kernel": drawing.kernel},
        columns=kit.columns(__file__),
        findings=findings(table),
    )


def time_kernel(candidate: Moving, work: int, name: str, nodes: int) -> list[dict[str, Any]]:
    """Rows of one network: every way, every round."""
    net = bodies.network(name, nodes)
    ways = WAYS[name]
    counts = {way: steps_of(way, work, net) for way in ways}
    with ExitStack() as at_end:
        acts = {way: stepping_function(candidate, way, net, counts[way], at_end) for way in ways}
        laps = in_turn({way: act for way, act in acts.items() if act})
    rows = []
    for way in ways:
        threads = OURS[way].threads if way in OURS else 1
        for number in range(ROUNDS):
            row = {
                "network": name,
                "axes": net.dim,
                "nodes": len(net.points),
                "springs": len(net.springs),
                "way": way,
                "threads": threads,
                "steps": counts[way],
                "round": number + 1,
            }
            seen: dict[str, Any] = {"ns_here": ABSENT, "wall_ns_here": ABSENT}
            if way in laps:
                one = laps[way][number]
                ns = 1e9 / (counts[way] * len(net.springs))
                seen["ns_here"] = ns * (one.cpu if threads == 1 else one.wall)
                seen["wall_ns_here"] = ns * one.wall
            rows.append(row | seen)
    return rows


def steps_of(way: str, work: int, net: kit.Network) -> int:
    """Steps of a round."""
    least = OUR_LEAST if way in (*OURS, SINGLE) else LEAST_STEPS
    return max(least, round(work / SLOWER.get(way, 1) / len(net.springs)))


def stepping_function(
    candidate: Moving, way: str, net: kit.Network, steps: int, at_end: ExitStack
) -> Callable[[], object] | None:
    """What takes so many steps of a network, each time from where it was; None for absent peers."""
    if way == "LAMMPS":
        peer = lammps_peer.stepping(net, steps)
        if peer is None:
            return None
        at_end.callback(peer[1])
        return peer[0]
    (u, v), dt = bodies.start(net), bodies.time_step(net)
    keep, push = np.full(len(u), KEEP), np.full(len(u), dt)
    if way in OURS:
        return partial(
            motion_function(candidate, net, OURS[way]).advance, u, v, keep, push, dt, steps
        )
    if way == SINGLE:
        motion = kernels.Motion(net, path="general", waves=1)
        return partial(motion.advance, u, v, keep, push, dt, steps)
    force = {"NumPy bincount": plain.by_bincount, "SciPy sparse": plain.by_sparse}[way](net)
    return partial(plain.advance, net, force, u, v, keep, push, dt, steps)


def motion_function(candidate: Moving, net: kit.Network, way: Way) -> kernels.Motion:
    """A network made ready for a path and so many threads."""
    return candidate(net, path=way.path, threads=way.threads)


def nanoseconds(table: pd.DataFrame, **wanted: object) -> float | None:
    """Median of the row that matches; None if there is none, or it is absent."""
    for column, value in wanted.items():
        table = table[table[column] == value]
    if table.empty or table["ns_here"].iloc[0] == ABSENT:
        return None
    return float(table["ns_here"].iloc[0])


def findings(table: pd.DataFrame) -> tuple[str, ...]:
    """Who is fastest on the largest lattice, and what networks cost beside it."""
    lattice = table[table["network"] == "lattice"]
    last = lattice[lattice["nodes"] == lattice["nodes"].max()]
    timed = last[last["ns_here"] != ABSENT].assign(ns=lambda t: t["ns_here"].astype(float))
    ranks = ", ".join(
        f"{row.way} {row.ns:.2g}"
        for row in timed.sort_values("ns", kind="stable").itertuples(index=False)
    )
    absent = ", ".join(last["way"][last["ns_here"] == ABSENT])
    missing = f" {absent}: not installed; pip install '.[peers]' brings it." if absent else ""
    points = f"{last['nodes'].max():,} points"
    return (f"A spring and step of the lattice of {points} took here, in ns: {ranks}.{missing}",)
