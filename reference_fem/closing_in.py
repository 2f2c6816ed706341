"""What values on meshes each twice as fine as the last close in on, and how far the last is.

What they change by shows the order p, u_h = u + C h^p, and what they close in on (Richardson's
extrapolation, as in [Roache1994]). Corners, ends of supports and changes of material leave an order
between about 1 and 2 even of quadratic elements; smooth bodies have up to 4. One p, of the 2-norm
of all components, serves all of them, but those that close in more slowly.
"""

from __future__ import annotations

import numpy as np

from msvalidate.problem import Array
from msvalidate.problem.records import ReadOnly, dataclass

SAFETY = 2.0
"""Factor on what the order seen leaves of a value's error. Where corners rule, orders fall on their
way to the corner's own, by up to a third on meshes as coarse as these. (1.5, chosen before any
error was measured, held 95 of 100; other bodies than those tried the factor since.)"""
CAUTION = 3.0
"""Factor on the last change where no order is seen."""
TWO_MESHES = 2.0
"""Factor on the change between the only two meshes: what an order of 0.6 leaves, lower than that of
any corner of one material."""
LOWEST_ORDER, TRUSTED_ORDER = 0.5, 2.0
"""Orders that are believed; higher ones, which come and go at corners, count as the latter."""
ROUNDING = 1e-10
"""Change, over the largest value, that is rounding."""


@dataclass(frozen=True, eq=False)
class Converged(ReadOnly):
    """A quantity on a sequence of meshes, and how far the last is from the limit.

    Parameters
    ----------
    value
        Any shape: on the finest mesh.
    uncertainty
        Of every component, in the unit of the value; infinite where there is one mesh.
    order
        Observed; NaN where none is seen.
    added
        What the order says that is missing from each component, 0 where none is seen.
    """

    value: Array
    uncertainty: float
    order: float
    added: Array

    @property
    def extrapolated(self) -> Array:
        """What the values close in on by the order seen; the last one where none is."""
        return self.value + self.added

    @property
    def extrapolated_uncertainty(self) -> float:
        """Of every component of the extrapolated value: all that was added, or as of the last."""
        return float(np.abs(self.added).max(initial=0.0)) or self.uncertainty


def close_in(values: list[Array], most: float = TRUSTED_ORDER) -> Converged:
    """The last of some values on meshes each twice as fine as the one before, and its error.

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
    size = float(np.abs(fine).max(initial=0.0))
    if len(values) == 1:
        return Converged(fine, np.inf, np.nan, np.zeros_like(fine))
    none = np.zeros_like(fine)
    least = SAFETY / (2**most - 1)
    last = fine - values[-2]
    change = float(np.abs(last).max(initial=0.0))
    if change <= ROUNDING * size:
        return Converged(fine, max(change, ROUNDING * size), np.nan, none)
    if len(values) == 2:
        return Converged(fine, max(TWO_MESHES, least) * change, np.nan, none)
    order = _order(values[-3:])
    before = float(np.abs(values[-2] - values[-3]).max(initial=0.0))
    if np.isnan(order):
        return Converged(fine, max(CAUTION, least) * max(change, before), np.nan, none)
    added = _added(last, values[-2] - values[-3], min(order, most))
    return Converged(fine, SAFETY * float(np.abs(added).max()), order, added)


def _added(last: Array, before: Array, order: float) -> Array:
    """What the last of two changes leaves to add to each component, by the order of all of them.

    Or by the component's own, where it closes in from one side and that is lower: next to a corner
    that points inwards a value closes in more slowly than those that rule the order.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        own = np.log2(before / last)  # not a number where the changes have different signs
    own = np.where(own >= LOWEST_ORDER, np.minimum(own, order), order)
    return np.asarray(last / (2**own - 1))


def _order(values: list[Array]) -> float:
    """Order that three values show, each on a mesh twice as fine; NaN if it is none to believe.

    The lower of what all components together show and of what the largest changes do.
    """
    coarse, medium, fine = values
    first, last = medium - coarse, fine - medium
    ratios = [
        np.linalg.norm(first) / np.linalg.norm(last),
        np.abs(first).max() / np.abs(last).max(),
    ]
    ratio = float(min(ratios))
    return float(np.log2(ratio)) if ratio >= 2**LOWEST_ORDER else float("nan")
