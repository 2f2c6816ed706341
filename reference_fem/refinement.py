"""The reference's own discretisation error: refinement, observed order, Richardson's estimate."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from msvalidate.problem import Array, ProblemError, SolverError, finite, positive

SAFETY = 1.25
"""Factor on Richardson's estimate where three meshes show a plausible order (Roache 1994,
doi:10.1115/1.2910291)."""
CAUTION = 3.0
"""Factor on the last change where they do not."""
ROUNDING = 1e-11
"""Changes below this, relative to the values, are rounding: no order can be read off them."""
LOWEST_ORDER = 0.5


@dataclass(frozen=True, eq=False)
class Estimate:
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
    quantity: Callable[[int], Array],
    coarsest: int,
    tolerance: float,
    *,
    highest_order: float = 4.5,
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
    SolverError
        If the finest mesh still misses the tolerance.
    """
    positive("tolerance", tolerance)
    if coarsest < 1 or 4 * coarsest > finest:
        raise ProblemError(f"refinement: from {coarsest} cells to {finest}; leave room for three")
    cells = 4 * coarsest
    values = [finite("refined quantity", quantity(n)) for n in (coarsest, 2 * coarsest, cells)]
    while True:
        estimate = richardson(values[-3], values[-2], values[-1], cells, highest_order)
        if estimate.uncertainty.max(initial=0.0) <= tolerance:
            return estimate
        if 2 * cells > finest:
            raise SolverError(
                f"reference not converged: uncertainty {estimate.uncertainty.max():.3g} at {cells} "
                f"cells, wanted {tolerance:.3g}; allow finer meshes or grade them to the corners"
            )
        cells *= 2
        values.append(finite("refined quantity", quantity(cells)))


def richardson(
    coarse: Array, medium: Array, fine: Array, cells: int, highest_order: float
) -> Estimate:
    """Estimate from three meshes, each twice as fine as the last."""
    first, last = np.abs(medium - coarse), np.abs(fine - medium)
    scale = np.maximum(np.abs(fine).max(initial=0.0), np.finfo(float).tiny)
    exact = np.maximum(first, last) <= ROUNDING * scale
    with np.errstate(divide="ignore", invalid="ignore"):
        order = np.log2(first / last)
        richardson = SAFETY * last / (2**order - 1)
    monotone = (medium - coarse) * (fine - medium) > 0
    plausible = ~exact & monotone & (order >= LOWEST_ORDER) & (order <= highest_order)
    uncertainty = np.where(plausible, richardson, CAUTION * last)
    words = np.where(exact, "exact", np.where(plausible, "asymptotic", "not asymptotic"))
    return Estimate(
        value=fine,
        uncertainty=np.where(exact, np.maximum(first, last), uncertainty),
        order=np.where(plausible, order, np.nan),
        status=tuple(str(word) for word in words),
        cells=cells,
    )
