"""Verdict of a case as one sentence, and the recommendation that follows from the same numbers.

The badge, the sentence and the recommendation are all derived from the record of the comparison, so
none of them contradicts another. Pages and terminals show them as they are.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from msvalidate.case.compare.choice import BETTER, BEYOND, MAIN, Choice
from msvalidate.case.compare.comparison import COARSE, OTHER_MATERIAL, Comparison
from msvalidate.case.compare.quantities import NotCompared
from msvalidate.case.file.units import quantity_text
from msvalidate.case.judge.judgement import Judged, driven_by
from msvalidate.problem import Array, Problem
from msvalidate.problem.records import dataclass
from msvalidate_check.beside import best_scale, longest
from msvalidate_check.scales import FITS
from msvalidate_check.text import FLOOR, number_text, percent
from msvalidate_check.verdict import (
    AGREES,
    DIFFERS,
    NOT_ASKED,
    NOT_AT_REST,
    NOT_RESOLVED,
    Difference,
)

WORST_FIRST = (DIFFERS, NOT_AT_REST, NOT_RESOLVED, AGREES, NOT_ASKED)
"""Words of several quantities: the first that one of them has is the case's."""
SPRINGS, ELEMENTS, NEITHER = "springs", "elements", ""
"""Recommended method; `NEITHER` if the record does not decide."""
MAX_STIFFNESS = 0.1
"""Difference up to which a part of the displacement and of the stiffness are the same number."""
MAX_FACTOR = 2.0
"""Factor of the displacements beyond which they are reported as a multiple."""
DISPLACEMENT = "displacement"
LARGEST = "largest displacement at compared points"
"""Name of the displacement's row in a summary."""
FOLLOWS = (DISPLACEMENT, "strain energy")
"""Quantities whose differences fall together as the lattice is refined."""


@dataclass(frozen=True)
class Recommendation:
    """Method to use, and the reason.

    Parameters
    ----------
    use
        `SPRINGS`, `ELEMENTS` or `NEITHER`.
    reason
        Clause without its full stop.
    """

    use: str
    reason: str

    @property
    def sentence(self) -> str:
        """Recommendation as one sentence."""
        return f"{f'Use {self.use}' if self.use else 'No choice yet'}: {self.reason}."


def overall(rows: Sequence[Difference]) -> str:
    """Word of a case: the worst of its quantities'."""
    words = {row.word for row in rows}
    return next((word for word in WORST_FIRST if word in words), NOT_ASKED)


def part_text(part: float, uncertainty: float) -> str:
    """Relative difference as text; below its uncertainty a bound is given in place of digits."""
    known = uncertainty if math.isfinite(uncertainty) else FLOOR
    return percent(part, max(FLOOR, known))


def springs_sentence(found: Comparison) -> str:
    """Verdict on the springs of a case as one sentence."""
    word = overall(found.rows)
    if word == NOT_ASKED:
        why = "; ".join(
            f"{each.quantity}, {each.why}" if isinstance(each, NotCompared) else each
            for each in found.notes
        )
        return f"Nothing was compared: {why}."
    if word not in {AGREES, DIFFERS}:
        return f"Not resolved: {_unresolved_reason(found.rows, found)}."
    values, wanted = found.displacement, found.reference.displacement.value
    error, problem = found.reference.error, found.case.problem
    sentence = "Displacements are not resolved, as elasticity's own error is not known."
    if math.isfinite(error):
        sentence = _difference_sentence("The springs", values, wanted, error, problem, plural=True)
    others = [
        f"{row.quantity} ({part_text(row.error, row.uncertainty)})"
        for row in found.rows
        if row.word == DIFFERS and row.quantity != DISPLACEMENT
    ]
    return f"{sentence} Outside the band: {', '.join(others)}." if others else sentence


def field_sentence(found: Judged) -> str:
    """Verdict on a judged field as one sentence."""
    row = found.displacement
    if row.word not in {AGREES, DIFFERS}:
        return f"Not resolved: {_unresolved_reason((row,), found)}."
    wanted, values = found.reference.displacement.value, found.matched.displacement
    return _difference_sentence("The field", values, wanted, row.uncertainty, found.case.problem)


def _difference_sentence(
    subject: str,
    values: Array,
    reference: Array,
    uncertainty: float,
    problem: Problem,
    *,
    plural: bool = False,
) -> str:
    """Sentence about the difference of displacements (p, d) in m from their reference.

    A stiffness is named only if one factor explains most of the difference and loads move the body.
    Of a single field, a part that no factor explains is stated as well.
    """
    s, be = ("", "are") if plural else ("s", "is")
    size, least = longest(reference) or 1.0, max(uncertainty, FLOOR)
    difference = longest(values - reference) / size
    if difference <= least:
        return f"{subject} agree{s} with elasticity to within {percent(least)}."
    scale = best_scale(values, reference)
    misfit = longest(values - scale * reference) / size
    if not (scale > 0 and misfit <= MAIN * min(difference, scale)):
        shape = ", mostly in shape" if misfit > MAIN * difference else ""
        return f"{subject} differ{s} from elasticity by {percent(difference)}{shape}."
    if not 1 / MAX_FACTOR < scale < MAX_FACTOR:
        return f"{subject} displace{s} {number_text(scale, 3)} times as much as elasticity."
    uniform = plural or misfit <= max(FITS * difference, least)
    part = difference if uniform else abs(1 - scale)
    size_words = f"{percent(part)} too {'large' if scale > 1 else 'small'}"
    evenly = "" if plural else "uniformly " if uniform else "on average "
    rest = "" if uniform else f" A difference of {percent(misfit)} is not uniform."
    if driven_by(problem) == "supports":
        return f"{subject}: displacements are {evenly}{size_words}.{rest}"
    stiffness = "soft" if scale > 1 else "stiff"
    if part > MAX_STIFFNESS:
        return f"{subject} {be} {evenly}too {stiffness}: displacements are {size_words}.{rest}"
    return f"{subject} {be} {evenly}{percent(part)} too {stiffness}.{rest}"


def _unresolved_reason(rows: Sequence[Difference], found: Comparison | Judged) -> str:
    """Reason why no verdict holds: the range of the theory, else the uncertainty, or the motion."""
    decisive = [each.fact for each in found.limitations if each.decides]
    if decisive:
        return decisive[0][:1].lower() + decisive[0][1:].rstrip(".")
    row = next(row for row in rows if row.word in {NOT_AT_REST, NOT_RESOLVED})
    if row.word == NOT_AT_REST:
        return f"the displacements may still change by {percent(row.residual_motion)}"
    size = part_text(row.error, row.uncertainty)
    known = percent(row.uncertainty)
    return f"{row.quantity} differs by {size} ± {known}, for a band of {percent(row.band)}"


def _unresolved_remedy(compared: Comparison | Judged, word: str) -> str:
    """Clause that names what a verdict needs."""
    if word == NOT_ASKED:
        return "no quantity was compared"
    if compared.reference.no_limit:
        return compared.reference.no_limit[0]
    remedies = [each.remedy for each in compared.limitations if each.decides and each.remedy]
    if remedies:
        return remedies[0][:1].lower() + remedies[0][1:].rstrip(".")
    more = compared.reference.more
    if more is not None:
        return f"a finer mesh takes [compare] memory = {math.ceil(more.bytes / 1e8) / 10:g} (GB)"
    return "a smaller [compare] accuracy narrows the uncertainty"


def recommend(found: Comparison, chosen: Choice) -> Recommendation:
    """Method for a case: springs if they agree in all quantities or a finer lattice would.

    The verdict decides first, so a badge *agrees* never stands beside advice against springs.
    """
    word, band = overall(found.rows), percent(found.case.band)
    if word == AGREES:
        cheaper = _more_accurate_elements(chosen)
        more = f"; for a program that has both, {cheaper}" if cheaper else ""
        return Recommendation(SPRINGS, f"they agree within the band of {band}{more}")
    if word != DIFFERS:
        return Recommendation(NEITHER, _unresolved_remedy(found, word))
    return _after_difference(found, chosen)


def _after_difference(found: Comparison, chosen: Choice) -> Recommendation:
    """Recommendation if some quantity lies outside the band."""
    off = [row for row in found.rows if row.word == DIFFERS]
    others = [row for row in off if row.quantity not in FOLLOWS]
    worst = max(others or off, key=lambda row: row.error / row.band)
    cheaper, band = _more_accurate_elements(chosen), found.case.band
    finer = [each for each in chosen.springs if each.count and each.target <= band]
    if found.kind == OTHER_MATERIAL:
        reason = "the springs differ from elasticity at any spacing"
    elif len(found.gaps[0]):
        width = quantity_text(found.gaps[0][0, 2], "m", found.case.unit)
        reason = f"the springs bridge a gap of {width}, which their cells do not resolve"
    elif others:
        reason = f"{worst.quantity} differs by {part_text(worst.error, worst.uncertainty)}"
    elif cheaper or not finer or found.kind != COARSE:
        reason = cheaper or "no tested spacing reaches the band"
    else:
        spacing = quantity_text(finer[0].spacing, "m", found.case.unit)
        reaches = "is estimated to reach" if finer[0].where == BEYOND else "reaches"
        reason = f"a spacing of {spacing} ({finer[0].count:,} springs) {reaches} the band"
        return Recommendation(SPRINGS, reason)
    return Recommendation(ELEMENTS, reason)


def _more_accurate_elements(chosen: Choice) -> str:
    """Clause on elements of equal cost if they are much more accurate; else empty."""
    if not chosen.times >= BETTER:
        return ""
    why = ", ".join(chosen.reasons)
    return (
        f"at {chosen.unknowns:,} unknowns, elements are {chosen.times:.2g} times more accurate"
        f"{f' ({why})' if why else ''}"
    )


def recommend_for_field(found: Judged) -> str:
    """Next step for a judged field, as one sentence."""
    if found.displacement.word == AGREES:
        return f"No change is needed within the band of {percent(found.case.band)}."
    if unconverged := found.case.notes.get("convergence"):
        return f"Let the simulator converge first: {unconverged}"
    causes, uncertainty = found.verdict.causes, found.displacement.uncertainty
    fitting = [each for each in causes if found.verdict.fits(each)]
    if fitting:
        room = min(each.left for each in fitting) + uncertainty
        first, *others = [each for each in fitting if each.left <= room]
        also = dict.fromkeys(each.name for each in others)
        more = f" As likely: {', '.join(also)}." if also else ""
        end = "" if str(first).endswith(("?", ".")) else "."
        return f"Check the most likely cause first: {first}{end}{more}"
    if found.displacement.word == NOT_RESOLVED:
        return f"No verdict yet: {_unresolved_remedy(found, NOT_RESOLVED)}."
    near = f" The nearest, which does not fit: {causes[0]}" if causes else ""
    return f"Check loads, supports, material and noise: no single known cause fits.{near}"
