"""A candidate beside its reference: differences, and the verdict that follows, each one record.

The word is never stored beside the numbers that it follows from: a `Difference` has it of itself.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from msvalidate_check.beside import Field, longest, split
from msvalidate_check.causes import Cause, phrase
from msvalidate_check.diagnosis import FITS, NOTICED, explain

AGREES, DIFFERS, NOT_RESOLVED, NOT_AT_REST = "agrees", "differs", "not resolved", "not at rest"
NOT_ASKED = "not asked"
"""The word where there is no number: a candidate was not looked at."""


def agreement(
    difference: float, uncertainty: float, band: float, residual_motion: float = 0.0
) -> str:
    """Whether a candidate agrees with its reference within a band, whatever they leave open.

    Parameters
    ----------
    difference
        From the reference, in the unit of the band.
    uncertainty
        How far the reference may be off.
    band
        Largest difference that agrees.
    residual_motion
        How far the candidate may still be from where it comes to rest.

    Returns
    -------
    str
        `AGREES` or `DIFFERS` where neither uncertainty nor residual motion can change that; else
        `NOT_AT_REST` or `NOT_RESOLVED`, after the larger of the two.
    """
    left = abs(uncertainty) + abs(residual_motion)
    if abs(difference) + left <= band:
        return AGREES
    if abs(difference) - left > band:
        return DIFFERS
    return NOT_AT_REST if abs(residual_motion) > abs(uncertainty) else NOT_RESOLVED


@dataclass(frozen=True)
class Difference:
    """One quantity of a candidate beside its reference's.

    Parameters
    ----------
    quantity, unit
        What, and the unit of its sizes.
    found, wanted
        Sizes of the candidate's and of the reference's, in the unit.
    error
        Of the two, over the size of the reference's; NaN where it was not asked.
    uncertainty
        How far reference and digits leave it open, on the same scale.
    band
        Largest error that agrees.
    residual_motion
        How much the candidate may still change, on the same scale; NaN if nobody says.
    of
        Which of the quantities asked for it is one of, where it has a name of its own.
    out_of_range
        True outside the range of the theory that the reference follows: no number decides there.
    """

    quantity: str
    unit: str = ""
    found: float = math.nan
    wanted: float = math.nan
    error: float = math.nan
    uncertainty: float = math.nan
    band: float = math.nan
    residual_motion: float = math.nan
    of: str = ""
    out_of_range: bool = False

    @property
    def word(self) -> str:
        """`agreement`, `NOT_ASKED`, or `NOT_RESOLVED` out of the range."""
        if math.isnan(self.error):
            return NOT_ASKED
        if self.out_of_range:
            return NOT_RESOLVED
        rest = 0.0 if math.isnan(self.residual_motion) else self.residual_motion
        return agreement(self.error, self.uncertainty, self.band, rest)


@dataclass(frozen=True, eq=False)
class Verdict:
    """What is said of a candidate; true where it agrees in all.

    Parameters
    ----------
    word
        What it is in a word.
    causes
        All that explain a difference, the likeliest first; none where there is none to explain.
    differences
        Of quantities; displacements first.
    parts
        Largest "scale", "rigid motion" and "shape" of the displacements' difference, over the
        largest displacement.
    """

    word: str
    causes: tuple[Cause, ...] = ()
    differences: tuple[Difference, ...] = ()
    parts: Mapping[str, float] = field(default_factory=dict)

    def __bool__(self) -> bool:
        return self.word == AGREES and all(each.word == AGREES for each in self.differences)

    @property
    def displacement(self) -> Difference:
        """The displacements' difference."""
        return self.differences[0]

    def fits(self, cause: Cause) -> bool:
        """Return true if a cause leaves at most a tenth of the difference, or the uncertainty."""
        own = self.displacement
        difference = own.error * own.wanted / (max(own.found, own.wanted) or 1.0)
        return cause.left <= max(FITS * difference, own.uncertainty)

    @property
    def indistinguishable(self) -> int:
        """Number of causes that leave as little as the best to within the uncertainty."""
        fitted = [each.left for each in self.causes if each.kind != "rest"]
        least = min(fitted, default=0.0)
        return sum(left - least <= self.displacement.uncertainty for left in fitted)


def judge_field(
    given: Field,
    band: float,
    residual_motion: float = math.nan,
    explained: Callable[[Field], tuple[Cause, ...]] = explain,
) -> Verdict:
    """Displacements beside elasticity's: the verdict, with all causes that explain them.

    That the field is not at rest comes first of these, where that may do.

    Parameters
    ----------
    given
        The field, whose uncertainty is elasticity's and that of the numbers.
    band, residual_motion
        As of a `Difference`.
    explained
        Gives the causes; by default all that the field can be asked for.
    """
    own = Difference(
        "displacement", "m", longest(given.found), longest(given.wanted),
        given.left(given.found), given.uncertainty, band, residual_motion,
    )  # fmt: skip
    causes = explained(given)
    if residual_motion >= own.error > NOTICED * own.uncertainty:
        causes = (Cause("rest", residual_motion, phrase("rest"), 0.0), *causes)
    parts = {name: longest(part) / given.size for name, part in split(given).items()}
    return Verdict(own.word, causes, (own,), parts)
