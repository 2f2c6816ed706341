"""Extrapolation of values on meshes that are refined by factors of two.

What they change by shows the order p, u_h = u + C h^p, and what is left (Richardson's
extrapolation, as in [Roache1994]). Corners, ends of supports and changes of material leave an order
between about 1 and 2 even of quadratic elements; smooth bodies have up to 4. A field has one p, of
the 2-norm of all components, which serves all but those that close in more slowly (`close_in`);
values that are questions of their own have each its own (`extrapolate_each`, and `refine`, which
makes the meshes). Where theory knows two orders, `extrapolate` goes by these.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from msvalidate.problem import Array, ProblemError, SolverError
from msvalidate.problem.checks import finite, format_value, numbers, positive_number, whole_number
from msvalidate.problem.records import ReadOnly, dataclass

SAFETY = 2.0
"""Factor on what the order seen leaves of a field's error. Where corners rule, orders fall on their
way to the corner's own, by up to a third on meshes as coarse as these. (1.5, chosen before any
error was measured, held 95 of 100; other bodies than those tried the factor since.)"""
SAFETY_OF_EACH = 1.25
"""The same of values with an order of their own, where it is plausible [Roache1994]."""
CAUTION = 3.0
"""Factor on the last change where no order is seen."""
TWO_MESHES = 2.0
"""Factor on the change between the only two meshes: what an order of 0.6 leaves, lower than that of
any corner of one material."""
LOWEST_ORDER, TRUSTED_ORDER = 0.5, 2.0
"""Orders that are believed; higher ones, which come and go at corners, count as the latter."""
HIGHEST_ORDER = 4.5
"""Largest order that three meshes of quadratic elements may show, with room for scatter."""
CRAWLING_ORDER = 0.1
"""Order assumed where changes hardly shrink: what is left is then 14 times the last change."""
COARSE = 4
"""Cells a side of the coarsest mesh, below which part of an error of order 1 may hide in one of
order 2: the order seen is then between them, and falls on finer meshes."""
ROUNDING, ROUNDING_OF_EACH = 1e-10, 1e-11
"""Change that is rounding: over a field's largest value, and over each value."""
NEAREST_ORDERS = 0.05
"""Orders closer than this cannot be told apart by three meshes."""


@dataclass(frozen=True, eq=False)
class Estimate(ReadOnly):
    """Values on the finest mesh and how far they may be from the limit.

    Parameters
    ----------
    value
        Any shape, in the unit of the quantity.
    uncertainty
        In the same unit: one for every component of a field, infinite where there is one mesh; else
        one a value.
    order
        Observed, as many; NaN where none can be given.
    added
        What the order says that is missing from each value, 0 where none is seen.
    status
        One a value: "asymptotic", "not asymptotic" (implausible order) or "exact" (changes are
        rounding). Of fields none.
    cells
        Cells per side of the finest mesh, where that is known.
    """

    value: Array
    uncertainty: Array
    order: Array
    added: Array
    status: tuple[str, ...] = ()
    cells: int = 0

    @property
    def extrapolated(self) -> Array:
        """Limit of the values by the observed order; the last value without one."""
        return self.value + self.added


def close_in(values: Sequence[Array], most: float = TRUSTED_ORDER) -> Estimate:
    """The last of some fields on meshes each twice as fine as the one before, and its error.

    With an order p seen on the last three, twice (u - u')/(2^p - 1), what is left by it. With
    no order, three times the larger of the last two changes; twice the only one of two meshes.

    Parameters
    ----------
    values
        Arrays of one shape.
    most
        Largest order that is believed. Below `LOWEST_ORDER` it is one that theory tells: changes
        that fall faster are those of other parts of the error.

    Source: Richardson's extrapolation as in [Roache1994].
    """
    fine = np.array(values[-1], dtype=float)
    if len(values) == 1:
        return unlimited(fine)
    least, size = SAFETY / (2**most - 1), float(np.abs(fine).max(initial=0.0))
    last = fine - values[-2]
    change = float(np.abs(last).max(initial=0.0))
    order, added = np.nan, np.zeros_like(fine)
    if change <= ROUNDING * size:
        uncertainty = max(change, ROUNDING * size)
    elif len(values) == 2:
        uncertainty = max(TWO_MESHES, least) * change
    else:
        before = values[-2] - values[-3]
        order = _order(before, last)
        if np.isnan(order):
            uncertainty = max(CAUTION, least) * max(change, float(np.abs(before).max()))
        else:
            added = _added(last, before, min(order, most))
            uncertainty = SAFETY * float(np.abs(added).max())
    return Estimate(fine, np.array(uncertainty), np.array(order), added)


def unlimited(value: Array) -> Estimate:
    """A field of which nothing says how far from its limit it is, if it has one."""
    return Estimate(value, np.array(np.inf), np.array(np.nan), np.zeros_like(value))


def _added(last: Array, before: Array, order: float) -> Array:
    """Extrapolated remainder after the last change of each component.

    Or by the component's own, where it closes in from one side and that is lower: next to a corner
    that points inwards a value closes in more slowly than those that rule the order.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        own = np.log2(before / last)  # not a number where the changes have different signs
    own = np.where(own >= LOWEST_ORDER, np.minimum(own, order), order)
    return np.asarray(last / (2**own - 1))


def _order(first: Array, last: Array) -> float:
    """Order that a change and the one after it show; NaN if it is none to believe.

    The lower of what all components together show and of what the largest changes do.
    """
    ratios = [
        np.linalg.norm(first) / np.linalg.norm(last),
        np.abs(first).max() / np.abs(last).max(),
    ]
    ratio = float(min(ratios))
    return float(np.log2(ratio)) if ratio >= 2**LOWEST_ORDER else float("nan")


def extrapolate_each(
    values: Sequence[Array], cells: int, highest_order: float = HIGHEST_ORDER
) -> Estimate:
    """The last of three or more rows of values on meshes each twice as fine, each with its error.

    Where the order is plausible: Richardson's error with that order, at most `TRUSTED_ORDER`, times
    `SAFETY_OF_EACH`, and no less than a third of the change before the last. An order between 1 and
    2 on a coarsest mesh below `COARSE` cells is taken for a sum a·h + b·h² of both, which leaves
    more: the last change times (5 - r)/3, where r is the one before over it. Where it is not:
    `CAUTION` times the last change or the one before, if that is larger; where changes hardly
    shrink, what a crawling order would leave.

    Parameters
    ----------
    values
        Rows (q,).
    cells
        Cells per side of the finest mesh.
    highest_order
        Largest plausible order: twice the element's degree, with room for scatter.

    Source: Richardson's extrapolation as in [Roache1994].
    """
    coarse, medium, fine = values[-3:]
    before, after = medium - coarse, fine - medium
    first, last = np.abs(before), np.abs(after)
    scale = np.maximum(np.abs(fine), np.finfo(float).tiny)
    exact = np.maximum(first, last) <= ROUNDING_OF_EACH * scale
    with np.errstate(divide="ignore", invalid="ignore"):
        order = np.log2(first / last)
        left = 1 / (2 ** np.minimum(order, TRUSTED_ORDER) - 1)
        if cells < 4 * COARSE:
            left = np.where((order > 1) & (order < 2), (5 - first / last) / 3, left)
        remaining, added = SAFETY_OF_EACH * last * left, after * left
    monotone = before * after > 0
    plausible = ~exact & monotone & (order >= LOWEST_ORDER) & (order <= highest_order)
    slow = monotone & (order < LOWEST_ORDER)
    otherwise = np.where(slow, last / (2**CRAWLING_ORDER - 1), np.maximum(CAUTION * last, first))
    uncertainty = np.where(plausible, np.maximum(remaining, first / 3), otherwise)
    words = np.where(exact, "exact", np.where(plausible, "asymptotic", "not asymptotic"))
    return Estimate(
        value=fine,
        uncertainty=np.where(exact, np.maximum(first, last), uncertainty),
        order=np.where(plausible, order, np.nan),
        added=np.where(plausible, added, 0.0),
        status=tuple(str(word) for word in words),
        cells=cells,
    )


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
        As for `reference_fem.richardson.extrapolate_each`.
    finest
        Cells per side beyond which to give up.

    Raises
    ------
    ProblemError
        If an argument is out of range, or the quantity is no row of numbers.
    SolverError
        If the finest mesh still misses the tolerance.
    """
    positive_number("tolerance", tolerance)
    positive_number("highest order", highest_order)
    if whole_number("coarsest", coarsest, 1) * 4 > whole_number("finest", finest, 1):
        raise ProblemError(f"refinement: from {coarsest} cells to {finest}; leave room for three")
    cells, values = coarsest, [_evaluate(quantity, coarsest)]
    while 2 * cells <= finest:
        cells *= 2
        values.append(_evaluate(quantity, cells))
        if len(values) < 3:
            continue
        if len({value.shape for value in values}) > 1:
            raise ProblemError("refined quantity: gives another number of values on another mesh")
        estimate = extrapolate_each(values, cells, highest_order)
        if estimate.uncertainty.max() <= tolerance:
            return estimate
    raise SolverError(
        f"reference not converged: uncertainty {estimate.uncertainty.max():.3g} at {cells} "
        f"cells, wanted {tolerance:.3g}; allow finer meshes or grade them to the corners"
    )


def _evaluate(quantity: Callable[[int], ArrayLike], cells: int) -> Array:
    """Values (q,) of a quantity on the mesh of so many cells per side, looked into."""
    if not callable(quantity):
        raise ProblemError(
            f"refined quantity: {format_value(quantity)}; give a function of the cells"
        )
    values = np.atleast_1d(numbers("refined quantity", quantity(cells)))
    if values.ndim != 1 or not values.size:
        raise ProblemError(
            f"refined quantity: shape {values.shape}; give one value or a row of them"
        )
    if not np.isfinite(values).all():
        raise SolverError(f"refined quantity: not a finite number on the mesh of {cells} cells")
    return values


def extrapolate(
    quantity: Callable[[int], ArrayLike], coarsest: int, orders: tuple[float, float]
) -> tuple[Array, Array]:
    """Limits (q,) of a quantity from four even meshes of known orders, and how far they may be off.

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
        If the orders are not two different ones above zero.
    """
    given = finite("orders", orders)
    if given.shape != (2,) or (given <= 0).any() or abs(np.diff(given)[0]) < NEAREST_ORDERS:
        raise ProblemError(f"orders: {format_value(orders)}; give two different ones above zero")
    values = np.array([_evaluate(quantity, coarsest * 2**i) for i in range(4)])
    # Row i of the system: the mesh 2^i times as fine; the first unknown is the limit.
    finer = 2.0 ** np.arange(3)
    system = np.column_stack([np.ones(3), finer ** -given[0], finer ** -given[1]])
    coarse, fine = (np.linalg.solve(system, values[i : i + 3])[0] for i in (0, 1))
    return fine, np.abs(fine - coarse) / (2 ** given.min() - 1)
