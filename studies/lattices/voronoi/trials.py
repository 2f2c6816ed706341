"""Trials: one body each that might show a Poisson's ratio of zero, for the question `zero`."""

from __future__ import annotations

import math
from itertools import product
from typing import Any

import numpy as np

import reference_fem
from msvalidate.constants.stiffness import cubic_part, moduli
from msvalidate.judging.candidate import DisplacementSolver
from msvalidate.lattice import STIFFNESS_RULES
from msvalidate.lattice.tessellation import periodic_tessellation
from msvalidate.lattice.voronoi import pattern_of_tessellation
from msvalidate.problem import Anisotropic, Array, Box, Problem, SolverError, Support

from ..cases import Solid
from .strewn import (
    PLACES,
    STRAIN,
    from_points,
    is_within_part,
    ratio,
    stretch_body,
    strewn,
)

GRID = 10
"""Points to a side: few enough for motions without stiffness to be told."""
SLACK_COUNT = 100
ROUNDS = 60
"""Changes of which springs are slack, after which a network is given up."""
NO_FORCE = 1e-12
"""Change of length, of the largest, that is rounding: of springs between points held alike."""
THINNEST = 6.0
"""Spacings across a body of any aspect."""


def nearly_square(
    candidate: DisplacementSolver, solid: Solid, case: tuple[float, int]
) -> list[dict[str, Any]]:
    """Ratios of a square grid whose points have moved a little, endless and as a body, by rule."""
    jitter, seed = case
    rng = np.random.default_rng(seed)
    grid = 0.5 + np.indices((GRID, GRID)).reshape(2, -1).T
    points = grid + jitter * (2 * rng.random(grid.shape) - 1)
    cells = periodic_tessellation(points, (float(GRID),) * 2)
    body = from_points(points, Box((float(GRID),) * 2), "1")
    rows = []
    for rule in STIFFNESS_RULES:
        tensor = solid(pattern_of_tessellation(cells, rule), (1.0,)).tensor
        weighted = body.weighted(rule)
        move = candidate(*stretch_body(weighted, "half"), "linear")
        rows.append(
            {
                "jitter": jitter,
                "stiffness": rule,
                "neighbours": 2 * len(cells.springs) / GRID**2,
                "nu_endless": moduli(cubic_part(tensor)).nu,
                "nu_means": ratio(weighted, move),
            }
        )
    return rows


def few(candidate: DisplacementSolver, case: tuple[int, int]) -> list[dict[str, Any]]:
    """Ratio by the report's means of one strewn body, by how it is held and by rule.

    With the part of the measured points that cannot move up or down, as their height is held. The
    ratio is NaN of a mechanism: a point between two springs in line, as there are among few points.
    """
    count, seed = case
    body = strewn("uniform", count, "1", seed)
    rows = []
    for ends, rule in product(("slide", "clamped"), STIFFNESS_RULES):
        weighted = body.weighted(rule)
        problem, network = stretch_body(weighted, ends)
        try:
            nu = ratio(weighted, candidate(problem, network, "linear"))
        except SolverError:
            nu = math.nan
        bottom, top = body.ends("bottom", "top")
        held = network.held[bottom | top, 1].mean()
        rows.append(
            {"count": count, "ends": ends, "stiffness": rule, "nu": nu, "held_measured": held}
        )
    return rows


def with_slack(
    candidate: DisplacementSolver, case: tuple[str, float, int]
) -> tuple[str, float, float, float]:
    """Ratio of one body whose slack springs keep a part of their stiffness; part of them slack.

    Compressed springs are found by turns of solving and looking, until none changes.
    """
    slack, kept, seed = case
    body = strewn("uniform", SLACK_COUNT, "1", seed)
    problem, network = stretch_body(body)
    i, j = network.springs.T
    if slack == "surface":
        outer = np.zeros(len(network.points), dtype=bool)
        outer[np.concatenate([body.surface(side) for side in ("top", "bottom")])] = True
        loose = outer[i] & outer[j]
        move = candidate(problem, network.scaled(np.where(loose, kept, 1.0)), "linear")
        return slack, kept, ratio(body, move), float(loose.mean())
    loose = np.zeros(len(i), dtype=bool)
    for _ in range(ROUNDS):
        move = candidate(problem, network.scaled(np.where(loose, kept, 1.0)), "linear")
        longer = ((move[j] - move[i]) * network.vector).sum(axis=1)
        shorter = longer < -NO_FORCE * np.abs(longer).max()
        if (loose == shorter).all():
            break
        loose = shorter
    return slack, kept, ratio(body, move), float(loose.mean())


def clamped(candidate: DisplacementSolver, case: tuple[float, int]) -> list[float]:
    """Ratios of a strewn body between clamped ends, by place."""
    aspect, seed = case
    count = round(THINNEST**2 * max(aspect, 1 / aspect))
    body = strewn("uniform", count, "1", seed, aspect)
    move = candidate(*stretch_body(body, "clamped"), "linear")
    return [ratio(body, move, place) for place in PLACES]


def clamped_elastic(tensor: Array, aspect: float) -> list[float]:
    """The same of an elastic body 1 m high."""
    box = Box((aspect, 1.0))
    pull = STRAIN * aspect
    supports = (
        Support(box.side("left"), (0.0, 0.0)),
        Support(box.side("right"), (pull, 0.0)),
    )
    problem = Problem(box, Anisotropic(tensor), supports, name="clamped ends")
    mesh = reference_fem.box_discretisation(box, 12, "Q2", 2.0)
    x = np.linspace(0, aspect, 801)
    solution = reference_fem.solve_problem(problem, mesh)
    top, bottom = (solution.at(np.column_stack([x, 0 * x + y]))[:, 1] for y in (1.0, 0.0))
    width = bottom - top
    return [float(width[is_within_part(x / aspect, place)].mean() / STRAIN) for place in PLACES]
