"""Trials: one body each that might show a Poisson's ratio of zero, for the question `zero`."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from msvalidate import kit
from msvalidate.bench.judging.candidate import AT_REST
from msvalidate.springs.constants.stiffness import cubic_part, moduli
from msvalidate.springs.dynamics.integrators import EULER_CROMER
from msvalidate.springs.dynamics.relax import relax
from msvalidate.springs.dynamics.run import Run
from msvalidate.springs.dynamics.spectrum import extreme_frequencies
from msvalidate.springs.dynamics.viscous import viscous
from msvalidate.springs.lattice import STIFFNESS_RULES
from msvalidate.springs.lattice.tessellation import periodic_tessellation
from msvalidate.springs.lattice.voronoi import pattern_of_tessellation
from msvalidate.springs.statics.equilibrium import equilibrium

from ..cases import Solid
from .strewn import STRAIN, from_points, gauge, ratio, stretch_body, strewn

GRID = 10
"""Points to a side: few enough for motions without stiffness to be noticed."""
COUNT = 100
"""Points of bodies with slack springs, and of those stopped early."""
ROUNDS = 60
"""Changes of which springs are slack, after which a network is given up."""
NO_FORCE = 1e-12
"""Change of length, of the largest, that is rounding: of springs between points held alike."""
LOADS = ("moved", "pulled")
DAMPINGS = (1, 100)
"""Over twice the lowest frequency, which is critical for the slowest motion; the report prefers an
overdamped system."""
EARLY = 0.1
"""Of the largest velocity so far: the report's loop ends when the largest falls below some ε."""


def nearly_square(
    candidate: kit.DisplacementSolver, solid: Solid, case: tuple[float, int]
) -> list[dict[str, Any]]:
    """Ratios of a square grid whose points have moved a little, endless and as a body, by rule."""
    jitter, seed = case
    rng = np.random.default_rng(seed)
    grid = 0.5 + np.indices((GRID, GRID)).reshape(2, -1).T
    points = grid + jitter * (2 * rng.random(grid.shape) - 1)
    cells = periodic_tessellation(points, (float(GRID),) * 2)
    rows = []
    for rule in STIFFNESS_RULES:
        tensor = solid(pattern_of_tessellation(cells, rule), (1.0,)).tensor
        body = from_points(points, kit.Box((float(GRID),) * 2), rule)
        move = candidate(*stretch_body(body, "half"), "linear")
        rows.append(
            {
                "jitter": jitter,
                "stiffness": rule,
                "neighbours": 2 * len(cells.springs) / GRID**2,
                "nu_endless": moduli(cubic_part(tensor)).nu,
                "nu_means": ratio(body, move),
            }
        )
    return rows


def strewn_ratio(
    candidate: kit.DisplacementSolver,
    seed: int,
    count: int,
    rule: str = "1",
    ends: str = "slide",
    aspect: float = 1.0,
    place: str = "whole",
) -> float:
    """Ratio by the report's means of one strewn body, `aspect` times as long as high.

    NaN of a mechanism: a point between two springs in line, as there are among few points.
    """
    body = strewn("uniform", count, rule, seed, aspect)
    try:
        return ratio(body, candidate(*stretch_body(body, ends), "linear"), place)
    except kit.SolverError:
        return math.nan


def slack_ratio(candidate: kit.DisplacementSolver, slack: str, kept: float, seed: int) -> float:
    """Ratio of one body whose slack springs, compressed or at the surface, keep a part of k.

    Compressed springs are found by turns of solving and looking, until none changes.
    """
    body = strewn("uniform", COUNT, "1", seed)
    problem, network = stretch_body(body)
    i, j = network.springs.T
    outer = np.zeros(len(network.points), dtype=bool)
    outer[np.concatenate([body.surface(side) for side in ("top", "bottom")])] = True
    loose = outer[i] & outer[j] if slack == "surface" else np.zeros(len(i), dtype=bool)
    for _ in range(ROUNDS):
        move = candidate(problem, network.scaled(np.where(loose, kept, 1.0)), "linear")
        longer = ((move[j] - move[i]) * network.vector).sum(axis=1)
        shorter = longer < -NO_FORCE * np.abs(longer).max()
        if slack == "surface" or (loose == shorter).all():
            break
        loose = shorter
    return ratio(body, move)


def stop(load: str, damping: int, seed: int) -> tuple[float, float, float]:
    """Ratio of one body stopped early, at rest if critically damped, and by linear equilibrium.

    Ends are moved apart at once, as those of a body with held ends are, so that the width has yet
    to follow the strain between them; or pulled by forces.
    """
    body = strewn("uniform", COUNT, "1", seed)
    _, network = stretch_body(body)
    static = equilibrium(network)
    left, right = body.ends("left", "right")
    if load == "pulled":
        # The same ends, each point drawn by the force that held it.
        held = np.array(network.fixed)
        held[right, 0] = False
        force = np.where(right[:, None], static.reaction, 0.0)
        still = np.zeros(held.shape)
        network = replace(network, fixed=held, displacement=still, force=np.array(force))
    lowest, highest = extreme_frequencies(network)
    seen: list[float] = []
    fastest = 0.0

    def shown(move: kit.Array) -> float:
        axial = (move[right, 0].mean() - move[left, 0].mean()) / gauge(body)
        return float(ratio(body, move) * STRAIN / axial)

    def look(run: Run) -> bool:
        nonlocal fastest
        speed = float(np.abs(run.velocity).max())
        fastest = max(fastest, speed)
        if run.steps and not seen and speed < EARLY * fastest:
            seen.append(shown(run.displacement))
        return damping > 1 and bool(seen)

    end = relax(
        network,
        viscous(EULER_CROMER, damping=2 * lowest * damping),
        tolerance=AT_REST,
        watch=look,
        look_every=1,
        frequencies=(lowest, highest),
    )
    rest = shown(end.equilibrium.displacement) if damping == 1 else math.nan
    return seen[0], rest, shown(static.displacement)
