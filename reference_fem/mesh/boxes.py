"""Meshes of boxes: quadrilaterals or triangles, hexahedra or tetrahedra between lines."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from msvalidate.problem import Array, Box, Index, ProblemError
from msvalidate.problem.checks import (
    cell_counts,
    finite_coordinates,
    format_value,
    positive_number,
    refuse_too_many,
    require_one_of,
)
from reference_fem.mesh.discretisation import Discretisation, make_discretisation
from reference_fem.mesh.elements import ELEMENTS, Element, of_dimension


def box_discretisation(
    box: Box,
    cells: int | tuple[int, ...],
    element: str = "Q2",
    grading: float = 1.0,
    towards: Literal["both", "high"] = "both",
    through: tuple[tuple[float, ...], ...] | None = None,
) -> Discretisation:
    """Mesh of a box.

    Parameters
    ----------
    box
        The domain.
    cells
        Number of quadrilaterals or hexahedra along each axis (one number serves all); triangles
        cut each in two, tetrahedra in six.
    element
        A name in `mesh.ELEMENTS` of the box's dimension: "Q2", "P1", "H1" and so on.
    grading
        1 spaces the lines evenly; g > 1 draws them to both ends of each axis as s^g, towards the
        corners, where clamped bodies have singular stress.
    towards
        "both" ends of each axis, or the "high" end alone: one corner's part of a symmetric body.
    through
        Coordinates (m) along each axis that mesh lines must pass through, such as the ends of a
        loaded part; None asks for none. The lines between two of them are spaced as said for the
        whole; each part takes its share of the cells by its length.

    Raises
    ------
    ProblemError
        If an argument is out of range, the element is not one of the box's dimension, or the cells
        are too many.
    """
    _refuse_other_element(box, element)
    kind, each = ELEMENTS[element], cell_counts("mesh cells", cells, box.dim)
    _refuse_too_many_nodes(f"mesh of {' x '.join(map(str, each))} cells", each, element)
    if through is None:
        through = ((),) * box.dim
    _refuse_wrong_lines(box, grading, towards, through)
    lines = [
        _add_midpoints(_lines(places, length, n, grading, towards), kind.degree)
        for places, length, n in zip(through, box.size, each, strict=True)
    ]
    closest = min(float(np.diff(line).min()) for line in lines)
    if closest <= 4 * box.tolerance:
        raise ProblemError(
            f"mesh grading: {grading} with {format_value(cells)} cells puts lines {closest:.2g} m "
            f"apart, "
            f"nearer than two places are told apart ({box.tolerance:.2g} m); take less grading or "
            "cells"
        )
    return _grid_mesh(lines, element)


def lines_discretisation(lines: Sequence[Array], element: str) -> Discretisation:
    """Mesh of a box between lines at coordinates (m), rising, along each axis.

    The first lines need not be at 0. Elements are those of `box_discretisation`.

    Raises
    ------
    ProblemError
        If the element is unknown or the cells are too many.
    """
    require_one_of("element", element, of_dimension(len(lines)))
    name = f"mesh between {' x '.join(str(len(line)) for line in lines)} lines"
    _refuse_too_many_nodes(name, [len(line) - 1 for line in lines], element)
    return _grid_mesh([_add_midpoints(line, ELEMENTS[element].degree) for line in lines], element)


def _grid_mesh(lines: Sequence[Array], element: str) -> Discretisation:
    """Mesh whose nodes stand where coordinates (m) along each axis cross."""
    grid = np.meshgrid(*reversed(lines), indexing="ij")
    points = np.column_stack([x.ravel() for x in reversed(grid)])
    cells = _cells(np.arange(len(points)).reshape(grid[0].shape), ELEMENTS[element])
    used = np.zeros(len(points), dtype=bool)  # not every element has middles
    used[cells] = True
    return make_discretisation(points[used], (np.cumsum(used) - 1)[cells], element)


def _refuse_other_element(box: Box, element: str) -> None:
    if not isinstance(box, Box):
        raise ProblemError(f"mesh: {_element_name(element)} in a {format_value(box)}; give a Box")
    fitting = of_dimension(box.dim)
    if not isinstance(element, str) or element not in fitting:
        raise ProblemError(
            f"mesh: {_element_name(element)} in a {format_value(box)}; in {box.dim}D, give one of "
            f"{', '.join(fitting)}"
        )


def _refuse_too_many_nodes(name: str, cells: Sequence[int], element: str) -> None:
    """`name`: of the mesh, which has so many cells along each axis."""
    kind = ELEMENTS[element]
    refuse_too_many(name, math.prod(kind.degree * n + 1 for n in cells), kind.most_nodes)


def _refuse_wrong_lines(box: Box, grading: float, towards: object, through: object) -> None:
    if not isinstance(through, tuple | list) or len(through) != box.dim:
        raise ProblemError(
            f"mesh lines through {format_value(through)}: give coordinates for each axis, as "
            "((), (0.4, 0.6))"
        )
    if not isinstance(towards, str) or towards not in ("both", "high"):
        raise ProblemError(f"mesh grading towards {format_value(towards)}; choose both or high")
    if positive_number("mesh grading", grading) < 1:
        raise ProblemError(f"mesh grading: {grading}; it must be 1 or more")


def _element_name(name: object) -> str:
    """A name that was given for one of ours, without its quotes."""
    return format_value(name).strip("'")


def _lines(through: ArrayLike, length: float, cells: int, grading: float, towards: str) -> Array:
    """Coordinates of mesh lines from 0 to `length` (m) and through all places given, in order.

    The cells are shared out among the parts by length.
    """
    inner = finite_coordinates("mesh lines through", through)
    places = np.array([0.0, *np.atleast_1d(inner).ravel(), length])
    width = np.diff(places)
    if inner.ndim != 1 or (width <= 0).any():
        raise ProblemError(
            f"mesh lines through {format_value(through)}: give coordinates in order, between 0 and "
            f"{length:g} m"
        )
    share = cells * width / length
    counts = np.floor(share + (0.5 + 1e-9)).astype(int)  # halves go up, whatever their last digit
    if counts.sum() != cells or counts.min() < 1:
        raise ProblemError(
            f"mesh lines through {format_value(through)}: {cells} cells do not divide among the "
            f"parts; "
            "choose a number that does"
        )
    parts = [
        start + part * _graded_line(int(n), grading, towards)
        for start, part, n in zip(places, width, counts, strict=False)
    ]
    # An end that two parts share is taken from the places themselves.
    return np.concatenate([*(part[:-1] for part in parts), places[-1:]])


def _graded_line(n: int, grading: float, towards: str) -> Array:
    """Coordinates of n + 1 lines on [0, 1], drawn to both ends alike or to 1."""
    if towards == "high":
        return np.asarray(1 - (1 - np.linspace(0, 1, n + 1)) ** grading)
    s = np.linspace(-1, 1, n + 1)
    return np.asarray(0.5 * (1 + np.sign(s) * (1 - (1 - np.abs(s)) ** grading)))


def _add_midpoints(line: Array, degree: int) -> Array:
    """The coordinates with the midpoints between them, for quadratic elements."""
    if degree == 1:
        return line
    fine = np.empty(2 * len(line) - 1)
    fine[::2], fine[1::2] = line, 0.5 * (line[1:] + line[:-1])
    return fine


def _cells(number: Index, kind: Element) -> Index:
    """Cells (c, nodes) from the node numbers, [layer, row, column], of a box's grid.

    Each block of `degree` intervals is cut as the element says, one cut of all blocks after the
    other.
    """
    size = [n - kind.degree for n in number.shape]
    found = []
    for places in kind.in_block:
        starts = [
            tuple(slice(p, n + p, kind.degree) for p, n in zip(place[::-1], size, strict=True))
            for place in places.tolist()
        ]
        found.append(np.column_stack([number[start].ravel() for start in starts]))
    return np.concatenate(found)
