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
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from scipy.special import stdtrit

from msvalidate.judging.candidate import DisplacementSolver
from msvalidate.judging.evidence import Observed, Tolerance
from msvalidate.judging.sweep import Setting
from msvalidate.lattice.point_sets import POINT_SETS, periodic_points
from msvalidate.lattice.tessellation import bounded_tessellation
from msvalidate.problem import Array, Box

from .networks import seeds
from .strewn import STRAIN, stretch_body, strewn

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
TOLERANCES = (
    Tolerance(
        "uniform points: depth of the surface against its closed form",
        1.0, "half-widths of the 99.9 % interval",
        "Student's, of the mean over the seeds; what is farther out is no chance",
    ),
)  # fmt: skip
COLUMNS = {
    "count": "points in the periodic cell, or in the body (1)",
    "depth": "distance of the surface's points from the flat side, rms over the side (spacings)",
    "depth_exact": 'its closed form, or "none" (spacings)',
    "depth_std": "standard deviation of depth over the networks (spacings)",
    "surface_roughness": "departure of the same points from their own mean plane, rms (spacings)",
    "seeds": "random networks drawn (1)",
    "bodies": "random bodies drawn (1)",
    "loaded_roughness": "departure of the loaded side's displacement from a plane, rms, median "
    "over the bodies (strain times spacing)",
    "loaded_scatter": "half the distance of its quartiles (strain times spacing)",
    "x": "start of a spring (spacings)",
    "y": "start of a spring (spacings)",
    "x_end": "end of a spring (spacings)",
    "y_end": "end of a spring (spacings)",
    "ux": "displacement of its start over the strain (spacings)",
    "uy": "displacement of its start over the strain (spacings)",
    "ux_end": "displacement of its end over the strain (spacings)",
    "uy_end": "displacement of its end over the strain (spacings)",
    "part": "what a line of the drawing is: a spring, or part of the surface",
}


def geometrical(setting: Setting) -> tuple[pd.DataFrame, dict[str, Observed]]:
    """Table `random_surface`, and what is judged of it."""
    sizes = {dim: counts[:1] if setting.quick else counts for dim, counts in COUNTS.items()}
    draws = seeds(setting)
    kinds = [
        (dim, points, count)
        for dim, counts in sizes.items()
        for points in POINT_SETS
        for count in counts
    ]
    found = iter(
        setting.sweep(depths, [(*kind, seed) for kind in kinds for seed in draws], "surfaces")
    )
    rows, away = [], []
    for dim, points, count in kinds:
        squares = np.array([next(found) for _ in draws])
        mean, rough = np.sqrt(squares.mean(axis=0))
        exact: float | str = DEPTH[dim] if points == "uniform" else "none"
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
                "depth_exact": exact,
                "depth_std": np.sqrt(squares[:, 0]).std(ddof=1),
                "surface_roughness": rough,
            }
        )
    farthest = max(away, key=abs)
    return pd.DataFrame(rows), {TOLERANCES[0].quantity: Observed(float(farthest))}


def depths(case: tuple[int, str, int, int]) -> tuple[float, float]:
    """Mean squares over the sides of the depth, and of its departure from its mean, in spacings."""
    dim, points, count, seed = case
    size = (count ** (1 / dim),) * dim
    cells = bounded_tessellation(periodic_points(points, count, size, seed), Box(size))
    distance, area = cells.side_distance, cells.side_area
    depth, part = [], []
    for side in range(2 * dim):
        others = [other for other in range(2 * dim) if other // 2 != side // 2]
        middle = (area[:, side] > 0) & (distance[:, others] > AWAY[dim]).all(axis=1)
        depth.append(distance[middle, side])
        part.append(area[middle, side])
    y, weight = np.concatenate(depth), np.concatenate(part)
    mean = np.average(y, weights=weight)
    return float(np.average(y**2, weights=weight)), float(
        np.average((y - mean) ** 2, weights=weight)
    )


def roughness(points: Array, move: Array, scale: float) -> float:
    """Rms departure of the right side's displacement along x from its best plane, times `scale`."""
    at = points[:, 0] == points[:, 0].max()
    plane = np.column_stack([np.ones(at.sum()), points[at, 1:]])
    fit, *_ = np.linalg.lstsq(plane, move[at, 0], rcond=None)
    return float(np.sqrt(np.mean((move[at, 0] - plane @ fit) ** 2)) * scale)


def mechanical(
    family: tuple[int, str, str], cells: int, bodies: list[dict[str, float]]
) -> dict[str, Any]:
    """One row of the table `random_surface_loaded`."""
    dim, points, rule = family
    low, middle, high = np.quantile([body["roughness"] for body in bodies], (0.25, 0.5, 0.75))
    return {
        "axes": dim,
        "point_set": points,
        "stiffness": rule,
        "spacings_a_side": cells,
        "bodies": len(bodies),
        "loaded_roughness": middle,
        "loaded_scatter": (high - low) / 2,
    }


def surface_rows(candidate: DisplacementSolver, setting: Setting) -> pd.DataFrame:
    """Table `random_networks`: springs and surface of a network of each kind of point set."""
    tables = setting.sweep(
        partial(lines, candidate, seeds(setting, 1)[0]), POINT_SETS, "drawn networks"
    )
    return pd.concat(tables, ignore_index=True)


def lines(candidate: DisplacementSolver, seed: int, points: str) -> pd.DataFrame:
    """Lines of one network, its ends pulled apart."""
    body = strewn(points, DRAWN, "A/L", seed)
    problem, network = stretch_body(body)
    move = candidate(problem, network, "linear") / STRAIN
    surface = [body.surface(side) for side in ("left", "right", "bottom", "top")]
    pairs = {
        "spring": network.springs,
        "surface": np.concatenate([np.column_stack([s[:-1], s[1:]]) for s in surface]),
    }
    tables = []
    for part, ends in pairs.items():
        (x, y), (x_end, y_end) = network.points[ends[:, 0]].T, network.points[ends[:, 1]].T
        (ux, uy), (ux_end, uy_end) = move[ends[:, 0]].T, move[ends[:, 1]].T
        tables.append(
            pd.DataFrame(
                {
                    "point_set": points,
                    "part": part,
                }
                | {"x": x, "y": y, "x_end": x_end, "y_end": y_end}
                | {"ux": ux, "uy": uy, "ux_end": ux_end, "uy_end": uy_end}
            )
        )
    return pd.concat(tables)


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
        f"{deep} spacings from its side, rms, whatever their number: the surface is smoother by "
        "the root of the number of points only, and ten times smoother costs a hundred times the "
        "points. Points on the sides cure that. Under a uniform load such a side still departs "
        f"from a plane, by {rough:.1f} times strain and spacing at {few} spacings a side and "
        f"{rougher:.1f} times at {many}."
    )
