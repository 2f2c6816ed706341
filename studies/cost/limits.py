"""Limits: what keeps the kernel from being faster, instructions or memory? How fast is real time?

Question   What part of the machine's memory bandwidth and of its arithmetic does each path reach,
           and by which of them is it held? How many seconds of a body's motion does a second make?
Candidate  The times of the question `kernel`.
Reference  The bandwidth of y = a x + y over arrays of several sizes, and the multiply-adds of a
           product of matrices, both by BLAS on one core, in the same process. Bytes of a step are
           those of the tables that a path reads and writes, each once. Paths take several steps in
           a pass over memory; one that takes a step a pass is timed beside them.
Expected   In the caches springs cost the same at each size: instructions. A network that the caches
           do not hold costs no less than its bytes over the bandwidth, and more where neighbours
           are far apart in memory, as in space: springs wait for places.

An operation is an addition, multiplication, division or root: 7 d + 2 a spring and 5 d a point.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from scipy.linalg.blas import daxpy, dgemm

from msvalidate import kit
from msvalidate.springs import kernels
from msvalidate.springs.dynamics.spectrum import highest_frequency
from msvalidate.springs.dynamics.step_limits import SAFETY

from . import bodies, drawing, kernel
from .timing import ABSENT, ROUNDS, SINGLE, in_turn

KILOBYTES = (256, 4_096, 262_144)
"""Both arrays together: the second level of cache, the third, and memory. In the first a call of
BLAS takes as long as its work."""
DOUBLE = 8
"""Bytes of a number."""
MOVED = 268_435_456
"""Bytes of a round of small arrays, repeated; larger ones are passed over once."""
MATRIX = 512
PART_OF_LEVEL = 0.5
"""Share of the bandwidth of cache or memory beyond which it is what holds a path; it is beside the
times, and judges nothing."""
FLAT = 1.5
"""Growth of the time a spring beyond which it is no longer that of instructions alone."""
COARSE = 8
"""Cells along the plate whose highest frequency is solved for."""


def run(timed: pd.DataFrame, setting: kit.Setting) -> kit.Evidence:
    """Measure the machine, and hold the times of `kernel` beside it."""
    machine = ceilings()
    memory = float(machine["gigabytes_per_second"].iloc[-1])
    arithmetic = 1e-9 * products_per_second()
    reached = pd.DataFrame(shares(timed, machine, arithmetic))
    small, fine = (plate_frequency(n) for n in (COARSE, 4 * COARSE))
    real = pd.DataFrame(real_time(timed, fine))
    own = (
        kit.Tolerance(
            "highest frequency x spacing of plates, finest over coarsest", 0.02, "1",
            "the highest mode lives in a few cells: the edge shares its mass, whatever the size; "
            "the coarsest plate of 8 cells is as wide as the mode",
            observed=kit.Observed(fine / small, 1.0),
        ),
    )  # fmt: skip
    return kit.Evidence(
        tables={
            "bandwidth": machine,
            "arithmetic": pd.DataFrame([{"gigaflops_per_second": arithmetic, "threads": 1}]),
            "limits": reached,
            "real_time": real,
        },
        tolerances=own,
        figures={"roofline": drawing.roofline, "real_time": drawing.real_time},
        columns=kit.columns(__file__),
        findings=(*findings(reached, memory, arithmetic), *describe_limits(real)),
    )


def ceilings() -> pd.DataFrame:
    """The table `bandwidth`: medians of y = a x + y in place, which reads two and writes one."""
    arrays = {size: np.ones((2, size * 1000 // (2 * DOUBLE))) for size in KILOBYTES}
    laps = in_turn(
        {size: partial(_updated, pair[0], pair[1], _passes(size)) for size, pair in arrays.items()}
    )
    rows = []
    for size, times in laps.items():
        moved = 3 * DOUBLE * arrays[size].shape[1] * _passes(size)
        speed = moved / float(np.median([one.cpu for one in times]))
        rows.append({"kilobytes": size, "gigabytes_per_second": 1e-9 * speed})
    return pd.DataFrame(rows)


def _updated(x: kit.Array, y: kit.Array, passes: int) -> None:
    for _ in range(passes):
        daxpy(x, y, a=1e-9)


def _passes(size: int) -> int:
    return max(1, MOVED // (size * 1000))


def products_per_second() -> float:
    """Operations a second of a product of two matrices, one multiplication and addition a pair."""
    a = np.asfortranarray(np.random.default_rng(0).random((MATRIX, MATRIX)))
    laps = in_turn({"product": partial(dgemm, 1.0, a, a)}, ROUNDS)["product"]
    return 2 * MATRIX**3 / float(np.median([one.cpu for one in laps]))


def traffic(net: kit.Network, way: str) -> float:
    """Bytes that a step must read and write by a path of ours, a point: its tables, once each."""
    path = kernel.OURS["general" if way == SINGLE else way]
    return kernel.motion_function(kernels.Motion, net, path).bytes_a_step / len(net.points)


def level(machine: pd.DataFrame, way: str, held: float) -> float:
    """Bandwidth (1e9 bytes/s) of where so many bytes of a step come from.

    Of arrays that are at least as large; steps that follow each other in one pass over memory meet
    in the second level of cache.
    """
    speeds = machine["gigabytes_per_second"]
    enough = machine["kilobytes"] * 1000 >= (held if way == SINGLE else 0.0)
    return float(speeds[enough].iloc[0] if enough.any() else speeds.iloc[-1])


def operations(net: kit.Network) -> float:
    """Operations of springs and steps, a point; see the module's text."""
    return 5 * net.dim + (7 * net.dim + 2) * len(net.springs) / len(net.points)


def shares(timed: pd.DataFrame, machine: pd.DataFrame, arithmetic: float) -> list[dict[str, Any]]:
    """Rows of the table `limits`: one thread's paths of ours, networks of springs alone."""
    rows, memory = [], float(machine["gigabytes_per_second"].iloc[-1])
    ours = timed[timed["way"].isin((*kernel.OURS, SINGLE)) & (timed["threads"] == 1)]
    ours = ours[ours["network"] != "lattice with volume energy"]
    for (_, _), part in ours.groupby(["network", "way"], sort=False):
        smallest = float(part["ns_here"].iloc[0])
        for row in part.to_dict("records"):
            net = network_of(row)
            a_node = float(row["ns_here"]) * len(net.springs) / len(net.points)
            moved, done = traffic(net, str(row["way"])), operations(net)
            flow = moved / a_node
            there = level(machine, str(row["way"]), moved * len(net.points))
            rows.append(
                {key: row[key] for key in ("network", "axes", "nodes", "springs", "way")}
                | {
                    "bytes_a_node": moved,
                    "operations_a_node": done,
                    "ns_here": row["ns_here"],
                    "gigabytes_per_second": flow,
                    "share_here": flow / memory,
                    "gigaflops_per_second": done / a_node,
                    "arithmetic_share_here": done / a_node / arithmetic,
                    "grown_here": float(row["ns_here"]) / smallest,
                    "held_here": held(flow / there, float(row["ns_here"]) / smallest),
                }
            )
    return rows


def held(part: float, grown: float) -> str:
    """What holds a path that reaches this part of a bandwidth, and takes so many times as long."""
    if part >= PART_OF_LEVEL:
        return "bandwidth"
    return "latency" if grown >= FLAT else "instructions"


def network_of(row: dict[Any, Any]) -> kit.Network:
    """The network that a row is of."""
    near = [n for n in (*kernel.NODES, *kernel.QUICK_NODES) if abs(n - row["nodes"]) <= 0.1 * n]
    networks = (bodies.network(str(row["network"]), n) for n in near)
    return next(net for net in networks if len(net.points) == row["nodes"])


def plate_frequency(cells: int) -> float:
    """Highest frequency (rad/s) of the plate times its spacing (m)."""
    return highest_frequency(bodies.plate(cells)) * bodies.SIDE / cells


def real_time(timed: pd.DataFrame, speed: float) -> list[dict[str, Any]]:
    """Rows of the table `real_time`: the step over the time that it takes.

    The step goes as the spacing, and as the root of density over modulus.
    """
    rows = []
    ours = timed[(timed["network"] == "lattice") & timed["way"].isin(kernel.OURS)]
    for name, E in bodies.MATERIALS.items():
        times = np.sqrt(E / bodies.E * bodies.DENSITY / bodies.DENSITIES[name])
        for row in ours[ours["ns_here"] != ABSENT].to_dict("records"):
            spacing = bodies.SIDE / (round(np.sqrt(row["nodes"])) - 1)
            step = SAFETY * 2 * spacing / (speed * times)
            wall = 1e-9 * float(row["ns_here"]) * row["springs"]
            rows.append(
                {"material": name}
                | {key: row[key] for key in ("nodes", "way", "threads")}
                | {"time_step": float(step), "real_time_here": float(step) / wall}
            )
    return rows


def findings(reached: pd.DataFrame, memory: float, arithmetic: float) -> tuple[str, ...]:
    """What holds each path on its largest network."""
    machine = (
        f"One core of this machine moves {memory:.3g} GB/s to and from memory, and makes "
        f"{arithmetic:.3g} GFLOP/s in a product of matrices."
    )
    said = [machine]
    for (name, way), part in reached.groupby(["network", "way"], sort=False):
        last = part.iloc[-1]
        said.append(
            f"{name}, {way}, {last['nodes']:,} points: {last['ns_here']:.2g} ns a spring and step, "
            f"{last['bytes_a_node']:.0f} bytes a point, {last['share_here']:.0%} of the memory's "
            f"bandwidth and {last['arithmetic_share_here']:.0%} of the arithmetic, "
            f"{last['grown_here']:.2f} times the smallest network's: {last['held_here']}."
        )
    return tuple(said)


def describe_limits(real: pd.DataFrame) -> tuple[str, ...]:
    """Up to how many points each material moves in real time."""
    said = []
    for name, part in real[real["threads"] == 1].groupby("material", sort=False):
        able = part[part["real_time_here"] >= 1]["nodes"]
        known = f"up to {able.max():,} points" if len(able) else "at none of these sizes"
        said.append(f"{name} on one thread in real time: {known}.")
    return tuple(said)
