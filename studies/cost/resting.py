"""Runs of the question `relaxation`: counted to an error, and timed for as many steps."""

from __future__ import annotations

from functools import cache, partial

import numpy as np

from msvalidate import kit
from msvalidate.bench.judging import counting
from msvalidate.springs import kernels
from msvalidate.springs.dynamics.relax import relax
from msvalidate.springs.dynamics.run import Method
from msvalidate.springs.dynamics.spectrum import extreme_frequencies
from msvalidate.springs.dynamics.step_limits import SAFETY
from msvalidate.springs.statics.equilibrium import equilibrium

from . import bodies, kernel
from .timing import Act, in_turn

ONCE = 20_000
"""Nodes beyond which a run is timed once."""
STEPPED = ("viscous_leapfrog", "algorithm1", "kinetic_damping")
"""Methods whose steps are all the kernel's."""
TIMED = ("cpu_seconds", "least_cpu_seconds", "most_cpu_seconds", "kernel_seconds", "rounds")


def plate(nodes: int) -> kit.Network:
    """The network of about so many nodes."""
    return bodies.network("lattice", nodes)


@cache
def rest(nodes: int) -> kit.Array:
    """Its own equilibrium (n, d) in m, by Newton's method with a direct solver."""
    return equilibrium(plate(nodes), "nonlinear").displacement


@cache
def frequencies(nodes: int) -> tuple[float, float]:
    """Its lowest and highest natural frequency (rad/s)."""
    return extreme_frequencies(plate(nodes))


def counted(method: Method, nodes: int) -> dict[float, tuple[int, int]]:
    """Threshold -> steps and evaluations at the first look that met it."""
    reference = rest(nodes)
    largest = np.abs(reference).max()
    return counting.count_steps(
        method,
        plate(nodes),
        frequencies(nodes),
        lambda move: float(np.abs(move - reference).max() / largest),
    )


def seconds(method: Method, nodes: int, steps: int, rounds: int) -> dict[str, float]:
    """Seconds of a run of so many steps with its own looks, and of as many steps of the kernel."""
    net, known = plate(nodes), frequencies(nodes)
    (u, v), dt = bodies.start(net), SAFETY * 2 / known[1]
    keep, push = np.full(len(u), kernel.KEEP), np.full(len(u), dt)
    relaxed: Act = partial(
        relax,
        net,
        method,
        tolerance=counting.AT_REST,
        max_steps=2 * steps,
        watch=lambda run: run.steps >= steps,
        frequencies=known,
    )
    acts = {"relaxation": relaxed}
    if method.name in STEPPED:
        acts["kernel"] = partial(kernels.Motion(net).advance, u, v, keep, push, dt, steps)
    once = nodes > ONCE or rounds == 1
    laps = in_turn(acts, 1 if once else rounds, warm=not once)
    times = [one.cpu for one in laps["relaxation"]]
    alone = [one.cpu for one in laps.get("kernel", [])]
    beside = float(np.median(alone)) if alone else 0.0
    told = (float(np.median(times)), min(times), max(times), beside, len(times))
    return dict(zip(TIMED, told, strict=True))
