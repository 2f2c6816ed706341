"""Cells with curved sides: which they are; and whether the map onto any cell folds.

The map from the unit cell is x(ξ) = Σ x_k φ_k(ξ), with the element's own functions (isoparametric:
[ZienkiewiczTaylorZhu2013], chapter 5).
"""

from __future__ import annotations

from functools import cache
from itertools import product

import numpy as np
from scipy.special import binom, factorial

from msvalidate.problem import Array, Index, Mask, ProblemError
from msvalidate.problem.records import dataclass
from reference_fem.mesh.elements import ELEMENTS, Element
from reference_fem.mesh.maps import determinant

STRAIGHT = 1e-8
"""Nodes this close to their places on straight edges, relative to the cell, are on them."""
ROUNDING = 1e-14
"""Relative rounding of coordinates."""
FLAT = 1e-12
"""Jacobian relative to the lengths of the cell's edges, at or below which it is none."""
HALVINGS = 5
"""Maximum number of bisections per axis to prove a positive Jacobian."""
CELLS_AT_ONCE = 10_000
"""A hexahedron's Jacobian is sampled at 216 points: 20 kB."""


def is_bent(points: Array, cells: Index, kind: Element) -> Mask:
    """Cells (c,) of which a node lies off its place amid straight edges."""
    if kind.degree == 1:
        return np.zeros(len(cells), dtype=bool)
    x = points[cells]
    off = np.abs(x - kind.means @ x[:, : kind.corners]).max(axis=(1, 2))
    size = np.ptp(x[:, : kind.corners], axis=1).max(axis=1)
    return np.asarray(off > STRAIGHT * size + ROUNDING * np.abs(points).max())


def refuse_folded(points: Array, cells: Index, number: Index, kind: Element) -> None:
    """Raise unless the Jacobian of each cell is positive everywhere.

    Its Jacobian is a polynomial, so it lies between the least and the largest of its Bernstein
    coefficients, and the coefficients at corners are values of it. A cell is halved (de Casteljau)
    until all of them are above zero or one at a corner is not [JohnenRemacleGeuzaine2013].

    Parameters
    ----------
    points, cells
        (n, d) in m and (c, nodes) in VTK order.
    number
        (c,) what to call the cells.

    Raises
    ------
    ProblemError
        If a cell folds, or comes so close to it that it cannot be told.
    """
    for start in range(0, len(cells), CELLS_AT_ONCE):
        chunk = cells[start : start + CELLS_AT_ONCE]
        folded = _first_folded(points[chunk[:, kind.listed]], kind)
        if folded is not None:
            why = (
                "inverted, flat or folded; list its corners in VTK order: counter-clockwise, in "
                "space those of the first face as seen from the rest"
                if kind.degree == 1
                else "inverted or folded: its curved sides turn it inside out; put mid-side nodes "
                "near the middle of less curved edges, and list corners, mid-sides, centre in VTK "
                "order"
            )
            raise ProblemError(f"cells: cell {number[start + folded]} is {why}")


def _first_folded(nodes: Array, kind: Element) -> int | None:
    """The first of the cells (c, nodes, d) that is found to fold, in the library's order."""
    rule = _bernstein(kind.name)
    _, slope = kind.functions(rule.places)
    columns = np.einsum("kjq,ckd->jqcd", slope, nodes)
    jacobian = determinant(columns.reshape(kind.dim, -1, kind.dim)).reshape(-1, len(nodes))
    lengths = np.linalg.norm(columns, axis=3).max(axis=1).prod(axis=0)
    lengths = np.maximum(lengths, np.finfo(float).tiny)  # of corners that coincide
    value, cell = (rule.coefficients @ jacobian).T / lengths[:, None], np.arange(len(nodes))
    for _ in range(HALVINGS * kind.dim):
        folded = (value[:, rule.corners] <= FLAT).any(axis=1)
        if folded.any():
            return int(cell[folded].min())
        doubtful = (value <= FLAT).any(axis=1)
        cell = np.tile(cell[doubtful], 2)
        value = np.concatenate([value[doubtful] @ half.T for half in rule.halves])
    return int(cell.min()) if len(cell) else None


@dataclass(frozen=True, eq=False)
class _Bernstein:
    """Bernstein's form of a Jacobian: (n,) coefficients, of which those at `corners` are values.

    `coefficients` makes them from its values at `places` (n, d), and `halves` those of each half of
    the cell from those of the whole.
    """

    places: Array
    coefficients: Array
    halves: tuple[Array, Array]
    corners: Mask


@cache
def _bernstein(name: str) -> _Bernstein:
    """Bernstein matrices for the Jacobian of an element of degree p.

    Each column of the map's derivative is one degree lower along its own axis, so that the product
    of d has degree pd - 1 along each axis of the unit cube; over the unit simplex it has (p - 1) d.
    """
    kind = ELEMENTS[name]
    d = kind.dim
    degree = (kind.degree - 1) * d if kind.simplex else kind.degree * d - 1
    powers = np.array(list(product(range(degree + 1), repeat=d)))
    if kind.simplex:
        powers = powers[powers.sum(axis=1) <= degree]
        powers = np.column_stack([powers, degree - powers.sum(axis=1)])
    places = powers[:, :d] / max(degree, 1)
    inverse = np.asarray(np.linalg.inv(_polynomials(powers, degree, places)), dtype=np.float64)
    halves = [inverse @ _polynomials(powers, degree, x) for x in _halve_cell(places, kind.simplex)]
    corners: Mask = np.all(np.isin(powers, (0, degree)), axis=1)
    return _Bernstein(places, inverse, (halves[0], halves[1]), corners)


def _polynomials(powers: Index, degree: int, x: Array) -> Array:
    """Bernstein polynomials (m, n) at x (m, d), by powers (n, d), or (n, d + 1) of simplices.

    Of each coordinate: C(n, k) x^k (1 - x)^(n - k). Of coordinates that add up to 1: n!/Π k! Π x^k.
    """
    if powers.shape[1] == x.shape[1]:
        each = binom(degree, powers) * x[:, None] ** powers * (1 - x[:, None]) ** (degree - powers)
        return np.asarray(each.prod(axis=2))
    share = np.column_stack([x, np.maximum(1 - x.sum(axis=1), 0.0)])
    many = factorial(degree) / factorial(powers).prod(axis=1)
    return np.asarray(many * (share[:, None] ** powers).prod(axis=2))


def _halve_cell(places: Array, simplex: bool) -> tuple[Array, Array]:
    """Positions (n, d) of points of the unit cell in its two halves.

    A simplex is cut amid its first edge, and the new corner put last; a cube across its first axis,
    and the axes turned: so all sides are halved.
    """
    d = places.shape[1]
    if simplex:
        corners = np.vstack([np.zeros(d), np.eye(d)])
        cut = [np.vstack([end, corners[2:], corners[:2].mean(axis=0)]) for end in corners[:2]]
        low, high = (v[0] + places @ (v[1:] - v[0]) for v in cut)
        return low, high
    low = np.roll(places, 1, axis=1) * [0.5, *[1.0] * (d - 1)]
    return low, low + 0.5 * np.eye(d)[0]
