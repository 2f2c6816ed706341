"""Effective solid of the network in a springs.csv and a points.csv.

What repeats in a finite piece is found from its points inside: those with the same springs around
them are translations apart, and translations span the cell. At the boundary springs are missing or
count in part: what repeats has all of them.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from msvalidate.case.advise.identify import Identified, mass_density, with_bounds, with_cells
from msvalidate.problem import AXES, Array, Index, Mask, ProblemError
from msvalidate.problem.checks import finite, finite_coordinates, format_value
from msvalidate.problem.records import replace
from msvalidate.springs.constants.bounds import point_simplices, tensor_bounds
from msvalidate.springs.constants.homogenise import NO_SPRING, homogenise_network
from msvalidate.springs.constants.stiffness import ALIKE
from msvalidate.springs.dynamics.spectrum import highest_frequency
from msvalidate.springs.lattice.ties import level_numbers
from msvalidate.springs.network import Network, spring_network
from msvalidate.springs.network.checks import refuse_first_bad
from msvalidate.springs.network.laws.volumes import Volumes

SAME = 1e-4
"""Tolerance of places and stiffnesses that count as equal.

It is relative to the shortest spring and to the largest stiffness: files with five digits suffice.
"""


def identify_files(
    springs: Path,
    period: tuple[float, ...] | None = None,
    density: float | None = None,
    thickness: float | None = None,
) -> Identified:
    """The solid of a network in a springs.csv, with points.csv beside it, and cells.csv if there.

    Columns as `case run` leaves them: i, j, stiffness (N/m), if there rest_length (m); id, x, y, z
    (m), if there mass (kg); p0, p1 .. and kappa.

    Parameters
    ----------
    period
        Edges (m) of a periodic sample: springs run to the nearest image, or to the one that columns
        image_x and so on count. None takes the points for a finite piece: where a cell repeats,
        the tensor is that of the endless lattice, else it is known by bounds. Points on a line are
        a chain, whose stiffness is EA (N).
    density, thickness
        kg/m³ and m of points without a column of masses; see `mass_density`.

    Raises
    ------
    ProblemError
        If a file is not there or holds something else, or the piece has no tensor of its own.
    """
    name, table = springs.name, _table(springs, ("i", "j", "stiffness"))
    points = _table(springs.with_name("points.csv"), ("x",))
    axes = [axis for axis in AXES if axis in points]
    x = _own_axes(finite_coordinates("points.csv: coordinates", points[axes].to_numpy()))
    ids = pd.Index(points.get("id", pd.RangeIndex(len(x))))
    if not ids.is_unique:
        twice = format_value(ids[ids.duplicated()][0])
        raise ProblemError(f"points.csv: id {twice} comes twice; give each point its own")
    pairs = _rows_of(name, table[["i", "j"]], ids)
    k = finite(f"{name}: stiffness", table["stiffness"].to_numpy())
    refuse_first_bad(f"{name}: stiffness", k, k < 0, "N/m; give 0 or more")
    alone = pairs[:, 0] == pairs[:, 1]
    if alone.any() and period is None:
        row = int(alone.argmax()) + 1
        raise ProblemError(f"{name}: row {row} joins a point to itself; leave it out")
    vectors = x[pairs[:, 1]] - x[pairs[:, 0]]
    if period is not None:
        vectors = _across(name, vectors, period, np.ptp(x, axis=0), table)
    length = np.linalg.norm(vectors, axis=1)
    refuse_first_bad(f"{name}: length", length, length == 0, "m; leave that spring out")
    if "rest_length" in table:
        rest = finite(f"{name}: rest_length", table["rest_length"].to_numpy())
        remedy = "m is not the distance; give points at rest, and image_x .. of periodic springs"
        bad = np.abs(length - rest) > SAME * length
        refuse_first_bad(f"{name}: rest_length", rest, bad, remedy)
    cells = springs.with_name("cells.csv")
    mass, note = _masses(points, x, float(length.mean()), density, thickness, period)
    if period is not None:
        if cells.exists():
            raise ProblemError("cells.csv: a periodic sample is of springs alone; move it away")
        solid = homogenise_network(len(x), pairs, vectors, k, math.prod(period))
        found = with_cells(f"{name}: a periodic sample of {len(x)} points", solid, 0.0)
        if mass is None:
            return found
        # The sum of norms in a point's row of the dynamical matrix [Gershgorin1931].
        most = 2 * np.bincount(pairs.ravel(), np.repeat(k, 2), len(x)) / mass
        return replace(found, omega=math.sqrt(most.max()), whose=f"any wave at most{note}")
    found, volumes = _piece(name, x, pairs, k, cells, ids)
    flat = x if x.shape[1] > 1 else np.column_stack([x, np.zeros(len(x))])
    body = spring_network(flat, pairs, k, mass=1.0 if mass is None else mass, volumes=volumes)
    if mass is not None:
        whose = f"this body, nothing held{note}"
        found = replace(found, omega=highest_frequency(body), whose=whose)
    return replace(found, network=_with_columns(body, points))


def _with_columns(network: Network, points: pd.DataFrame) -> Network:
    """The network with the supports and forces of a table, where it has their columns."""

    def values(prefix: str) -> Array:
        columns = [f"{prefix}{axis}" for axis in AXES[: network.dim]]
        if not set(columns) <= set(points):
            return np.zeros(network.points.shape)
        return finite(f"points.csv: {columns[0]} ..", points[columns].to_numpy())

    return replace(
        network, fixed=values("held_") != 0, displacement=values("move_"), force=values("force_")
    )


def _piece(
    name: str, x: Array, pairs: Index, k: Array, cells: Path, ids: Any
) -> tuple[Identified, Volumes | None]:
    """The solid of a finite piece, and its cells that resist a change of volume."""
    repeating = _repeating_cell(x, pairs, k)
    if repeating is None:
        if cells.exists():
            raise ProblemError("cells.csv: bounds are of springs alone; move it away")
        stiff = k > NO_SPRING * k.max()
        rows = tensor_bounds(x, pairs[stiff], k[stiff])
        what = f"{name}: nothing repeats between {len(x)} points"
        if rows[0].idle:
            what += f", of which {rows[0].idle} without a force in any spring are left out"
        if rows[0].points + rows[0].idle == len(x) and x.shape[1] > 1:
            what += ", which are too few for an inside: the bounds are those of the piece"
        return with_bounds(what, rows), None
    cell, inside = repeating
    kappa, volumes = _cells(cells, ids, inside, x) if cells.exists() else (0.0, None)
    what = f"{name}: a cell of {cell[0]} points repeats, inside are {inside.sum()} of {len(x)}"
    return with_cells(f"{what} points", homogenise_network(*cell), kappa), volumes


def _own_axes(x: Array) -> Array:
    """Points (n, 1) along their line, (n, 2) where z is 0 everywhere, or as they are."""
    away = x - x[0]
    line = away[np.linalg.norm(away, axis=1).argmax()]
    length = float(np.linalg.norm(line))
    if length and np.linalg.norm(away - np.outer(away @ line, line) / length**2) <= SAME * length:
        return np.asarray(away @ line / length)[:, None]
    return x if np.ptp(x[:, -1]) else x[:, :2]


def _masses(
    points: pd.DataFrame,
    x: Array,
    mean_length: float,
    density: float | None,
    thickness: float | None,
    period: tuple[float, ...] | None,
) -> tuple[Array | None, str]:
    """Masses (n,) in kg of a table or of a density, None if there are none, and a note."""
    if "mass" in points:
        if density is not None:
            raise ProblemError("--density: points.csv has masses; leave one of them out")
        return finite("points.csv: mass", points["mass"].to_numpy()), ""
    per_volume, note = mass_density(x.shape[1], density, thickness)
    if per_volume is None:
        return None, ""
    if period is not None:
        return np.full(len(x), per_volume * math.prod(period) / len(x)), f", {note}"
    volume = point_simplices(x, mean_length)[1]  # points apart from the body have the least
    return per_volume * np.maximum(volume, volume[volume > 0].min()), f", {note}"


def _table(path: Path, need: tuple[str, ...]) -> pd.DataFrame:
    """A table with some columns."""
    columns = f"give a table with columns {', '.join(need)}"
    try:
        table = pd.read_csv(path, skipinitialspace=True)
    except (OSError, ValueError) as error:  # no such file; no table; no text
        why = getattr(error, "strerror", None) or " ".join(str(error).split())
        raise ProblemError(f"{path.name}: {why}; {columns}") from error
    missing = [name for name in need if name not in table]
    if missing or not len(table):
        raise ProblemError(f"{path.name}: no {missing[0] if missing else 'rows'}; {columns}")
    return table


def _rows_of(name: str, given: pd.DataFrame, ids: Any) -> Index:
    """Rows (k, any) of points.csv that ids name."""
    found = np.column_stack([ids.get_indexer(given[column]) for column in given])
    if (found < 0).any():
        row, column = np.argwhere(found < 0)[0]
        raise ProblemError(
            f"{name}: {given.columns[column]} = {given.iloc[row, column]} in row {row + 1} is no "
            "point of points.csv; add it, or leave that row out"
        )
    return np.asarray(found)


def _cells(path: Path, ids: Any, inside: Mask, x: Array) -> tuple[float, Volumes]:
    """κ of all cells with points inside at all corners, and all cells."""
    table = _table(path, ("p0", "p1", "p2", "kappa"))
    corners = _rows_of(path.name, table.filter(regex=r"^p\d$"), ids)
    kappa = finite("cells.csv: kappa", table["kappa"].to_numpy())
    own = kappa[inside[corners].all(axis=1)]
    if not len(own) or np.ptp(own) > ALIKE * np.abs(own).max():
        raise ProblemError("cells.csv: kappa is not one number inside; give one material")
    return float(own[0]), Volumes(x, corners, kappa)


def _across(
    name: str, vectors: Array, period: tuple[float, ...], span: Array, table: pd.DataFrame
) -> Array:
    """Vectors (m, d) of springs to the image that is meant."""
    d = vectors.shape[1]
    edges = finite("--period", period, d, need=f"the points have {d} axes, give as many lengths")
    for edge, wide in zip(edges.tolist(), span.tolist(), strict=True):
        if edge <= wide * (1 + SAME):
            raise ProblemError(
                f"--period: {edge:g} m where points span {wide:g} m; give more, and each point of "
                "the sample once (of two opposite sides one)"
            )
    columns = [f"image_{axis}" for axis in AXES[:d]]
    if set(columns) <= set(table):
        return np.asarray(vectors + finite(f"{name}: image", table[columns].to_numpy()) * edges)
    found = np.asarray(vectors - edges * np.round(vectors / edges))
    if not np.linalg.norm(found, axis=1).all():
        raise ProblemError(f"{name}: a spring to its own image; count in {', '.join(columns)}")
    return found


Cell = tuple[int, Index, Array, Array, float]
"""Arguments of `homogenise_network`."""


def _repeating_cell(x: Array, pairs: Index, stiffness: Array) -> tuple[Cell, Mask] | None:
    """The cell that repeats in a piece, and the points (n,) that are inside; None if nothing does.

    Of points (n, d) in m and springs (m, 2) of (m,) N/m. Inside are those with all their springs.
    Raises `ProblemError` if stiffness changes inside.
    """
    n, d = x.shape
    start, end = np.concatenate([pairs, pairs[:, ::-1]]).T  # each spring from both ends
    vectors, k = x[end] - x[start], np.tile(stiffness, 2)
    room = SAME * float(np.linalg.norm(vectors, axis=1).min())
    way = _classes(level_numbers(vectors, room))
    kind = _classes(np.column_stack([way, level_numbers(k, SAME * k.max())]))
    # Sets of kinds are told by sums of random numbers, exact, and alike by chance in 1 of 1e12.
    lot = np.random.default_rng(0).integers(2**40, size=len(start))
    star, shape = (_classes(np.bincount(start, lot[each], n)) for each in (kind, way))
    alike = x[star == np.bincount(star).argmax()]
    steps = alike - alike[np.linalg.norm(alike - alike.mean(axis=0), axis=1).argmin()]
    basis: list[Array] = []
    for step in steps[np.argsort(np.linalg.norm(steps, axis=1), kind="stable")]:
        if len(basis) < d and np.linalg.matrix_rank(np.array([*basis, step]), tol=room) > len(
            basis
        ):
            basis.append(step)
    if len(basis) < d:
        return None
    part = (x - x[0]) @ np.linalg.inv(basis)
    site = _classes(level_numbers((part - np.floor(part + SAME)) @ np.array(basis), room))
    sites = int(site.max()) + 1
    # Of each site, one of the points with the springs that most of its points have.
    usual = np.array([np.bincount(star[site == each]).argmax() for each in range(sites)])
    inside = star == usual[site]
    chosen = np.array([np.flatnonzero(inside & (site == each))[0] for each in range(sites)])
    own, back = np.isin(start, chosen), np.roll(np.arange(len(start)), len(pairs))
    # All springs are among those of the sites, which have them from both ends alike.
    ways, kinds = ((site[start] * sites + site[end]) * len(start) + each for each in (way, kind))
    if not (np.isin(ways, ways[own]).all() and np.isin(kinds[back[own]], kinds[own]).all()):
        return None
    complete, by_side = shape == shape[chosen][site], np.zeros(n, dtype=bool)
    by_side[start[~complete[end]]] = True
    if (complete & ~inside & ~by_side).any():
        raise ProblemError("springs: their stiffness changes inside; give those of one material")
    springs, size = np.column_stack([site[start], site[end]])[own], abs(np.linalg.det(basis))
    return (sites, springs, vectors[own], k[own] / 2, size), inside


def _classes(rows: Index) -> Index:
    """Number of each row among those that differ."""
    return np.asarray(np.unique(rows, axis=0, return_inverse=True)[1].ravel())
