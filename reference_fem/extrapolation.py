"""Richardson extrapolation of values on refined meshes with orders known from theory."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from msvalidate.problem import Array, ProblemError
from msvalidate.problem.checks import finite, format_value, numbers, whole_number
from msvalidate.problem.records import ReadOnly, dataclass

NEAREST_ORDERS = 0.05
"""Orders closer than this cannot be told apart by three meshes."""


@dataclass(frozen=True, eq=False)
class Limit(ReadOnly):
    """Values (q,) at vanishing spacing, and how far they may be off, in their unit.

    `cells`: cells per side of the finest mesh.
    """

    value: Array
    uncertainty: Array
    cells: int


def extrapolate(
    quantity: Callable[[int], ArrayLike], coarsest: int, orders: tuple[float, float]
) -> Limit:
    """Limit of a quantity from four even meshes, each twice as fine as the last.

    On even meshes a corner or edge of exponent λ leaves an error of order 2λ in the spacing, beside
    the 2 of linear elements: value = limit + a·h^p + b·h^q, known from three meshes. What
    is left out, of corners for example, falls at least with the lower order p, so the limit from
    the three finer meshes is nearer by 2^p or more than that from the three coarser: the
    uncertainty is what they disagree about, over 2^p - 1.

    Parameters
    ----------
    quantity
        Function of the cells per side that returns values (q,).
    coarsest
        Cells per side to start from; meshes have 1, 2, 4 and 8 times as many.
    orders
        p and q, in any order.

    Raises
    ------
    ProblemError
        If the orders are not two different ones above zero, or the quantity is no row of finite
        numbers.
    """
    p, q = _orders(orders)
    start = whole_number("coarsest", coarsest, 1)
    if not callable(quantity):
        raise ProblemError(
            f"extrapolated quantity: {format_value(quantity)}; give a function of cells"
        )
    rows = [
        np.atleast_1d(finite(f"values at {n} cells", numbers("values", quantity(n))))
        for n in (start, 2 * start, 4 * start, 8 * start)
    ]
    values = np.array(rows)
    # Row i of the system: the mesh 2^i times as fine; the first unknown is the limit.
    finer = 2.0 ** np.arange(3)
    system = np.column_stack([np.ones(3), finer**-p, finer**-q])
    coarse, fine = (np.linalg.solve(system, values[i : i + 3])[0] for i in (0, 1))
    return Limit(fine, np.abs(fine - coarse) / (2 ** min(p, q) - 1), 8 * start)


def _orders(orders: tuple[float, float]) -> tuple[float, float]:
    given = finite("orders", orders)
    if given.shape != (2,) or (given <= 0).any() or abs(np.diff(given)[0]) < NEAREST_ORDERS:
        raise ProblemError(f"orders: {format_value(orders)}; give two different ones above zero")
    return float(given[0]), float(given[1])
