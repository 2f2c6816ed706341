"""Agreement: do all paths of the kernel make the same motion, and notice one that fails?

Question   How far apart are the trajectories of every path, on one thread and on two, after 2000
           steps? Does a run that diverges, or a NaN, come out of every path as what it is?
Candidate  The package's `springs.kernels.Motion`.
Reference  The plain NumPy form, step by step.
Expected   Rounding: sums in another order. Two threads add up as one does, but where their shares
           meet.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd

from msvalidate import kit

from . import bodies, kernel, plain
from .kernel import OURS, Moving

NODES = 225
STEPS = 2000
KEEP = 0.999
"""Of the velocity in a step: the motion halves in 700 steps, and what differs does not hide."""
TOO_LONG = 8.0
"""Times the step that is used otherwise: about four times the limit."""
FAR = 1e3
"""Displacement, in sizes of the body, that says that a run has diverged."""
FEW = 400
APART = ["apart_here", "threads_apart_here"]


def run(candidate: Moving, setting: kit.Setting) -> kit.Evidence:
    """Move each small network by every path."""
    rows = [row for name in bodies.NETWORKS for row in compare_paths(candidate, name)]
    table = pd.DataFrame(rows)
    unseen = int((table[["diverged", "nan"]] != "noticed").to_numpy().sum())
    worst = table[APART].max(skipna=False)  # NaN counts as largest: it fails
    judged = (
        kit.Tolerance(
            f"a path from the plain form after {STEPS} steps, over the largest displacement, worst",
            1e-12, "1",
            "2000 steps that each round by 2^-53, all one way, make 2e-13 of what moves; random "
            "tetrahedra have slivers whose forces are some times larger than those of a whole cell",
            observed=kit.Observed(float(worst["apart_here"])),
        ),
        kit.Tolerance(
            "two threads from one, the same path, worst", 1e-13, "1",
            "sums over a point's springs are the same but where two threads' shares meet: a part "
            "of what the paths may differ by",
            observed=kit.Observed(float(worst["threads_apart_here"])),
        ),
        kit.Tolerance(
            "runs that diverged or held a NaN and were not noticed", 0, "1",
            "a number that is not finite or is far too large must come out as it is",
            observed=kit.Observed(unseen),
        ),
    )  # fmt: skip
    finite = np.isfinite(table[APART])
    shown = table.assign(**table[APART].astype(object).where(finite, "no number"))
    return kit.Evidence(
        tables={"agreement": shown},
        tolerances=judged,
        columns=kit.columns(__file__),
    )


def compare_paths(candidate: Moving, name: str) -> list[dict[str, Any]]:
    """Rows of one network: each path that it has."""
    net = bodies.network(name, NODES)
    true = displacement_after_steps(
        net, lambda *given: plain.advance(net, plain.whole(net), *given)
    )
    size = float(np.abs(true).max())
    alone: dict[str, kit.Array] = {}
    rows = []
    for title in (way for way in kernel.WAYS[name] if way in OURS):
        way = OURS[title]
        walk = kernel.motion_function(candidate, net, way).advance
        here = displacement_after_steps(net, walk)
        alone.setdefault(way.path, here)
        rows.append(
            {
                "network": name,
                "nodes": len(net.points),
                "springs": len(net.springs),
                "way": title,
                "threads": way.threads,
                "apart_here": float(np.abs(here - true).max()) / size,
                "threads_apart_here": float(np.abs(here - alone[way.path]).max()) / size,
                "diverged": _is_noticed(runs_far(net, walk)),
                "nan": _is_noticed(keeps_nan(net, walk)),
            }
        )
    return rows


def displacement_after_steps(net: kit.Network, walk: Callable[..., object]) -> kit.Array:
    """Displacement after `STEPS` from a random start."""
    (u, v), dt = bodies.start(net), bodies.time_step(net)
    walk(u, v, np.full(len(u), KEEP), np.full(len(u), dt), dt, STEPS)
    return u


def runs_far(net: kit.Network, walk: Callable[..., object]) -> bool:
    """Whether too long a step ends far away, or in what is no number."""
    (u, v), dt = bodies.start(net), TOO_LONG * bodies.time_step(net)
    with np.errstate(all="ignore"):
        walk(u, v, np.full(len(u), KEEP), np.full(len(u), dt), dt, FEW)
        return not float(np.abs(u).max()) < FAR * bodies.SIDE


def keeps_nan(net: kit.Network, walk: Callable[..., tuple[int, float, bool]]) -> bool:
    """Whether a NaN at a free point, and the energy of such a motion, come out as NaN."""
    (u, v), dt = bodies.start(net), bodies.time_step(net)
    u[np.flatnonzero(~net.fixed.all(axis=1))[0]] = np.nan
    _, energy, _ = walk(u, v, np.full(len(u), KEEP), np.full(len(u), dt), dt, 3)
    return bool(np.isnan(u).any() and np.isnan(energy))


def _is_noticed(seen: bool) -> str:
    return "noticed" if seen else "missed"
