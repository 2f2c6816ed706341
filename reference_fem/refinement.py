"""The reference's own discretisation error: refinement, observed order, Richardson's estimate."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from msvalidate.problem import Array, ProblemError, SolverError
from msvalidate.problem.checks import format_value, numbers, positive_number, whole_number
from msvalidate.problem.records import ReadOnly, dataclass

SAFETY = 1.25
"""Factor on Richardson's estimate where three meshes show a plausible order [Roache1994]."""
TRUSTED_ORDER = 2.0
"""Higher observed orders are not relied on: near a singular corner they come and go."""
CAUTION = 3.0
"""Factor on the last change where the order is implausible."""
CRAWLING_ORDER = 0.1
"""Order assumed where changes hardly shrink: what is left is then 14 times the last change."""
ROUNDING = 1e-11
"""Changes below this, relative to the values, are rounding: no order can be read off them."""
COARSE = 4
"""Cells a side of the coarsest mesh, below which part of an error of order 1 may hide in one of
order 2: the order seen is then between them, and falls on finer meshes."""
LOWEST_ORDER = 0.5
HIGHEST_ORDER = 4.5
"""Largest order that three meshes of quadratic elements may show, with room for scatter."""


@dataclass(frozen=True, eq=False)
class Estimate(ReadOnly):
    """Values on the finest mesh and how far they may be from the limit.

    Parameters
    ----------
    value, uncertainty
        (q,) in the unit of the quantity.
    order
        (q,) observed order; NaN where none can be given.
    status
        (q,) words: "asymptotic", "not asymptotic" (implausible order) or "exact" (changes are
        rounding).
    cells
        Cells per side of the finest mesh.
    """

    value: Array
    uncertainty: Array
    order: Array
    status: tuple[str, ...]
    cells: int


def refine(
    quantity: Callable[[int], ArrayLike],
    coarsest: int,
    tolerance: float,
    *,
    highest_order: float = HIGHEST_ORDER,
    finest: int = 512,
) -> Estimate:
    """Double the cells per side until the estimated error of every value is below `tolerance`.

    Parameters
    ----------
    quantity
        Function of the cells per side that returns values (q,).
    coarsest
        Cells per side to start from; at least three meshes are solved.
    tolerance
        Largest accepted uncertainty, in the unit of the quantity.
    highest_order
        Largest plausible order: twice the element's degree, with room for a fit's scatter.
    finest
        Cells per side beyond which to give up.

    Raises
    ------
    ProblemError
        If an argument is out of range, or the quantity is no row of numbers.
    SolverError
        If the finest mesh still misses the tolerance.
    """
    if not callable(quantity):
        raise ProblemError(
            f"refined quantity: {format_value(quantity)}; give a function of the cells"
        )
    positive_number("tolerance", tolerance)
    positive_number("highest order", highest_order)
    if whole_number("coarsest", coarsest, 1) * 4 > whole_number("finest", finest, 1):
        raise ProblemError(f"refinement: from {coarsest} cells to {finest}; leave room for three")
    cells = 4 * coarsest
    values = [_evaluate(quantity, n) for n in (coarsest, 2 * coarsest, cells)]
    while True:
        if len({value.shape for value in values}) > 1:
            raise ProblemError("refined quantity: gives another number of values on another mesh")
        estimate = richardson(values[-3], values[-2], values[-1], cells, highest_order)
        if estimate.uncertainty.max(initial=0.0) <= tolerance:
            return estimate
        if 2 * cells > finest:
            raise SolverError(
                f"reference not converged: uncertainty {estimate.uncertainty.max():.3g} at {cells} "
                f"cells, wanted {tolerance:.3g}; allow finer meshes or grade them to the corners"
            )
        cells *= 2
        values.append(_evaluate(quantity, cells))


def _evaluate(quantity: Callable[[int], ArrayLike], cells: int) -> Array:
    values = np.atleast_1d(numbers("refined quantity", quantity(cells)))
    if values.ndim != 1 or not values.size:
        raise ProblemError(
            f"refined quantity: shape {values.shape}; give one value or a row of them"
        )
    if not np.isfinite(values).all():
        raise SolverError(f"refined quantity: not a finite number on the mesh of {cells} cells")
    return values


def on_three_meshes(quantity: Callable[[int], Array], layers: int) -> tuple[Array, Array, Array]:
    """A quantity on a mesh and on those with a half and a quarter of its layers, coarsest first.

    Raises
    ------
    ProblemError
        If the layers are no multiple of 8.
    """
    if whole_number("layers", layers, 8) % 8:
        raise ProblemError(
            f"layers: {layers}; give a multiple of 8, for meshes of a quarter and a half of them"
        )
    return quantity(layers // 4), quantity(layers // 2), quantity(layers)


def richardson(
    coarse: Array, medium: Array, fine: Array, cells: int, highest_order: float
) -> Estimate:
    """Estimate from three meshes, each twice as fine as the last.

    Where the order is plausible: Richardson's error with that order, at most `TRUSTED_ORDER`, times
    `SAFETY`, and no less than a third of the change before the last. An order between 1 and 2 on a
    coarsest mesh below `COARSE` cells is taken for a sum a·h + b·h² of both, which leaves more: the
    last change times (5 - r)/3, where r is the one before over it. Where it is not: `CAUTION`
    times the last change or the one before, if that is larger; where changes hardly shrink, what a
    crawling order would leave.

    Source: Richardson's extrapolation as in [Roache1994].
    """
    first, last = np.abs(medium - coarse), np.abs(fine - medium)
    scale = np.maximum(np.abs(fine), np.finfo(float).tiny)
    exact = np.maximum(first, last) <= ROUNDING * scale
    with np.errstate(divide="ignore", invalid="ignore"):
        order = np.log2(first / last)
        left = 1 / (2 ** np.minimum(order, TRUSTED_ORDER) - 1)
        if cells < 4 * COARSE:
            left = np.where((order > 1) & (order < 2), (5 - first / last) / 3, left)
        remaining = SAFETY * last * left
    monotone = (medium - coarse) * (fine - medium) > 0
    plausible = ~exact & monotone & (order >= LOWEST_ORDER) & (order <= highest_order)
    slow = monotone & (order < LOWEST_ORDER)
    otherwise = np.where(slow, last / (2**CRAWLING_ORDER - 1), np.maximum(CAUTION * last, first))
    uncertainty = np.where(plausible, np.maximum(remaining, first / 3), otherwise)
    words = np.where(exact, "exact", np.where(plausible, "asymptotic", "not asymptotic"))
    return Estimate(
        value=fine,
        uncertainty=np.where(exact, np.maximum(first, last), uncertainty),
        order=np.where(plausible, order, np.nan),
        status=tuple(str(word) for word in words),
        cells=cells,
    )
