"""Surfaces: how smooth is the surface of a random network, at rest and under load?

Without points on the sides the surface is where random points happen to lie. The mean over a flat
side of the squared distance to the nearest point's depth has a closed form for uniform points:
half a ball around a place on the side is empty to radius r with probability exp(-πr²/2) in the
plane and exp(-2πr³/3) in space, all directions alike, so the depth's root mean square is

    √(1/π) = 0.564 spacings in the plane and √(Γ(5/3) (2π/3)^(-2/3)/3) = 0.429 in space,

whatever the number of points: in metres it falls as count^(-1/d), no faster.
"""

from __future__ import annotations

import math
from itertools import product
from typing import Any

import numpy as np
import pandas as pd
from scipy.special import stdtrit

from msvalidate import kit
from msvalidate.springs.lattice.point_sets import POINT_SETS, periodic_points
from msvalidate.springs.lattice.tessellation import bounded_tessellation

from . import drawing
from .networks import seeds
from .strewn import Strewn, stretch_body, strewn

COUNTS = {2: (100, 400, 1600), 3: (125, 343, 1000)}
AWAY = {2: 2.0, 3: 1.5}
"""Spacings from the other sides of points that count: nearer ones have a corner beside them. Of
uniform points 1 place in 500 or 1000 has its nearest farther away than that."""
DEPTH = {
    2: math.sqrt(1 / math.pi),
    3: math.sqrt(math.gamma(5 / 3) * (2 * math.pi / 3) ** (-2 / 3) / 3),
}
SURE = 0.999
DRAWN = 64
"""Points of the networks in the figure."""


def run(
    candidate: kit.DisplacementSolver, setting: kit.Setting, loaded: pd.DataFrame
) -> kit.Evidence:
    """Depths of surfaces, beside the table of loaded ones; networks are drawn."""
    sizes = {dim: counts[:1] if setting.quick else counts for dim, counts in COUNTS.items()}
    draws = seeds(setting)
    kinds = [(d, *kind) for d, counts in sizes.items() for kind in product(POINT_SETS, counts)]
    cases = [(*kind, seed) for kind in kinds for seed in draws]
    found = np.reshape(setting.sweep(depths, cases, "surfaces"), (len(kinds), len(draws), 2))
    rows, away = [], []
    for (dim, points, count), squares in zip(kinds, found, strict=True):
        mean, rough = np.sqrt(squares.mean(axis=0))
        if points == "uniform":
            error = squares[:, 0].std(ddof=1) / math.sqrt(len(draws))
            reach = stdtrit(len(draws) - 1, 0.5 + SURE / 2) * error
            away.append((squares[:, 0].mean() - DEPTH[dim] ** 2) / reach)
        rows.append(
            {
                "axes": dim,
                "point_set": points,
                "count": count,
                "seeds": len(draws),
                "depth": mean,
                "depth_exact": DEPTH[dim] if points == "uniform" else "none",
                "depth_std": np.sqrt(squares[:, 0]).std(ddof=1),
                "surface_roughness": rough,
            }
        )
    geometry = pd.DataFrame(rows)
    chance = kit.Tolerance(
        "uniform points: depth of the surface against its closed form",
        1.0, "half-widths of the 99.9 % interval",
        "Student's, of the mean over the seeds; what is farther out is no chance",
        observed=kit.farthest_value(away, 0.0),
    )  # fmt: skip
    shown = {points: sample(candidate, seeds(setting, 1)[0], points) for points in POINT_SETS}
    return kit.Evidence(
        {"random_surface": geometry, "random_surface_loaded": loaded},
        tolerances=(chance,),
        figures={"random_networks": drawing.drawn(shown)},
        columns=kit.columns(__file__),
        findings=(finding(geometry, loaded),),
    )


def depths(case: tuple[int, str, int, int]) -> tuple[float, float]:
    """Mean squares over the sides of the depth, and of its departure from its mean, in spacings."""
    dim, points, count, seed = case
    size = (count ** (1 / dim),) * dim
    cells = bounded_tessellation(periodic_points(points, count, size, seed), kit.Box(size))
    distance, area = cells.side_distance, cells.side_area
    depth, part = [], []
    for side in range(2 * dim):
        others = [other for other in range(2 * dim) if other // 2 != side // 2]
        middle = (area[:, side] > 0) & (distance[:, others] > AWAY[dim]).all(axis=1)
        depth.append(distance[middle, side])
        part.append(area[middle, side])
    y, weight = np.concatenate(depth), np.concatenate(part)
    mean = np.average(y, weights=weight)
    about = np.average((y - mean) ** 2, weights=weight)
    return float(np.average(y**2, weights=weight)), float(about)


def roughness(points: kit.Array, move: kit.Array, scale: float) -> float:
    """Rms departure of the right side's displacement along x from its best plane, times `scale`."""
    at = points[:, 0] == points[:, 0].max()
    plane = np.column_stack([np.ones(at.sum()), points[at, 1:]])
    fit, *_ = np.linalg.lstsq(plane, move[at, 0], rcond=None)
    return float(np.sqrt(np.mean((move[at, 0] - plane @ fit) ** 2)) * scale)


def mechanical(bodies: pd.DataFrame) -> dict[str, Any]:
    """What the table `random_surface_loaded` has of bodies of one family and size."""
    low, middle, high = np.quantile(bodies["roughness"], (0.25, 0.5, 0.75))
    rough = {"loaded_roughness": middle, "loaded_scatter": (high - low) / 2}
    return {"bodies": len(bodies)} | rough


def sample(
    candidate: kit.DisplacementSolver, seed: int, points: str
) -> tuple[Strewn, kit.Network, kit.Array]:
    """A network, its ends pulled apart, and how its points move (m)."""
    body = strewn(points, DRAWN, "A/L", seed)
    problem, network = stretch_body(body)
    return body, network, candidate(problem, network, "linear")


def finding(geometry: pd.DataFrame, loaded: pd.DataFrame) -> str:
    """How rough surfaces are."""
    plane = geometry[geometry["axes"] == 2]
    last = plane[plane["count"] == plane["count"].max()].set_index("point_set")
    deep = ", ".join(
        f"{last['depth'][points]:.2f} ({points.replace('_', ' ')})" for points in POINT_SETS
    )
    sides = loaded[loaded["axes"] == 2].groupby("spacings_a_side")["loaded_roughness"].mean()
    (few, rough), *_, (many, rougher) = zip(sides.index, sides, strict=True)
    return (
        "The report is right that its surface is not smooth: points strewn inside a sheet end "
        f"{deep} spacings from its side, rms, at the numbers tried: the surface is smoother by "
        "the root of the number of points only, and ten times smoother costs a hundred times the "
        "points. Points on the sides cure that. Under a uniform load such a side still departs "
        f"from a plane, by {rough:.1f} times strain and spacing at {few} spacings a side and "
        f"{rougher:.1f} times at {many}."
    )
