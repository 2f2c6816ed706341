"""Which solid the network in a springs.csv and a points.csv is."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from msvalidate.case.identify import Identified, with_cells
from msvalidate.case.repeating import SAME, repeating_cell
from msvalidate.constants.homogenise import homogenise_network
from msvalidate.constants.stiffness import ALIKE
from msvalidate.dynamics.spectrum import highest_frequency
from msvalidate.network import spring_network
from msvalidate.network.checks import refuse_first_bad
from msvalidate.network.laws.volumes import Volumes
from msvalidate.problem import AXES, Array, Index, Mask, ProblemError
from msvalidate.problem.checks import finite, finite_coordinates
from msvalidate.problem.records import replace


def identify_files(springs: Path, period: tuple[float, ...] | None = None) -> Identified:
    """The solid of a network in a springs.csv, with points.csv beside it, and cells.csv if there.

    Columns as `case run` leaves them: i, j, stiffness (N/m), if there rest_length (m); id, x, y, z
    (m), if there mass (kg); p0, p1 .. and kappa.

    Parameters
    ----------
    period
        Edges (m) of a periodic sample: springs run to the nearest image, or to the one that columns
        image_x and so on count. None takes the points for a finite piece of what repeats.

    Raises
    ------
    ProblemError
        If a file is not there or holds something else, or the piece has no tensor of its own.
    """
    name, table = springs.name, _table(springs, ("i", "j", "stiffness"))
    points = _table(springs.parent / "points.csv", ("x", "y"))
    axes = [axis for axis in AXES if axis in points and (axis != "z" or np.ptp(points["z"]) > 0)]
    x = finite_coordinates("points.csv: coordinates", points[axes].to_numpy())
    ids = pd.Index(points.get("id", pd.RangeIndex(len(x))))
    pairs = _rows_of(name, table[["i", "j"]], ids)
    k = finite(f"{name}: stiffness", table["stiffness"].to_numpy())
    refuse_first_bad(f"{name}: stiffness", k, k < 0, "N/m; give 0 or more")
    mass = finite("points.csv: mass", points["mass"].to_numpy()) if "mass" in points else None
    cells, vectors = _cells(springs.parent / "cells.csv", ids), x[pairs[:, 1]] - x[pairs[:, 0]]
    if period is not None:
        if cells:
            raise ProblemError("cells.csv: a periodic sample is of springs alone; move it away")
        vectors = _across(name, vectors, period, table)
        _refuse_stressed(name, vectors, table)
        solid = homogenise_network(len(x), pairs, vectors, k, math.prod(period))
        found = with_cells(f"{name}: a periodic sample of {len(x)} points", solid, 0.0)
        if mass is None:
            return found
        # The sum of norms in a point's row of the dynamical matrix [Gershgorin1931].
        most = 2 * np.bincount(pairs.ravel(), np.repeat(k, 2), len(x)) / mass
        return replace(found, omega=math.sqrt(most.max()), whose="any wave at most")
    _refuse_stressed(name, vectors, table)
    cell = repeating_cell(x, pairs, k)
    what = f"{name}: a cell of {cell.points} points repeats, inside are {cell.inside.sum()} of "
    solid = homogenise_network(*cell[:-1])
    kappa = _kappa_inside(*cells, cell.inside) if cells else 0.0
    found = with_cells(f"{what}{len(x)} points", solid, kappa)
    if mass is None:
        return found
    volumes = Volumes(x, *cells) if cells else None
    body = spring_network(x, pairs, k, mass=mass, volumes=volumes)
    return replace(found, omega=highest_frequency(body), whose="this body, nothing held")


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


def _cells(path: Path, ids: Any) -> tuple[Index, Array] | None:
    """Corners (c, corners) and κ (c,) of cells, where there is a file of them."""
    if not path.exists():
        return None
    table = _table(path, ("p0", "p1", "p2", "kappa"))
    corners = [f"p{number}" for number in range(8) if f"p{number}" in table]
    kappa = finite("cells.csv: kappa", table["kappa"].to_numpy())
    return _rows_of(path.name, table[corners], ids), kappa


def _kappa_inside(corners: Index, kappa: Array, inside: Mask) -> float:
    """κ of all cells with points inside at all corners."""
    own = kappa[inside[corners].all(axis=1)]
    if not len(own) or np.ptp(own) > ALIKE * np.abs(own).max():
        raise ProblemError("cells.csv: kappa is not one number inside; give one material")
    return float(own[0])


def _across(name: str, vectors: Array, period: tuple[float, ...], table: pd.DataFrame) -> Array:
    """Vectors (m, d) of springs to the image that is meant."""
    d = vectors.shape[1]
    edges = finite("period", period, d, need=f"the points have {d} axes, give as many lengths")
    columns = [f"image_{axis}" for axis in AXES[:d]]
    if set(columns) <= set(table):
        return np.asarray(vectors + finite(f"{name}: image", table[columns].to_numpy()) * edges)
    found = np.asarray(vectors - edges * np.round(vectors / edges))
    if not np.linalg.norm(found, axis=1).all():
        raise ProblemError(f"{name}: a spring to its own image; count in {', '.join(columns)}")
    return found


def _refuse_stressed(name: str, vectors: Array, table: pd.DataFrame) -> None:
    """Raise `ProblemError` where rest lengths are no distances."""
    if "rest_length" in table:
        rest = finite(f"{name}: rest_length", table["rest_length"].to_numpy())
        length = np.linalg.norm(vectors, axis=1)
        remedy = "m is not the distance; give points at rest, and image_x .. of periodic springs"
        refuse_first_bad(
            f"{name}: rest_length", rest, np.abs(length - rest) > SAME * length, remedy
        )
