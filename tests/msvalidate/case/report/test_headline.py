"""The verdict sentence and the recommendation of a case follow from the same record."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from msvalidate.case.compare.choice import BETWEEN, Choice, Need
from msvalidate.case.compare.comparison import COARSE, NOT_TOLD, OTHER_MATERIAL
from msvalidate.case.file.case import Case
from msvalidate.case.file.units import quantity_text
from msvalidate.case.report import headline
from msvalidate.problem import Box, Isotropic, Problem, ProblemError, Support, Traction
from msvalidate_check.verdict import AGREES, DIFFERS, NOT_RESOLVED, Difference
from tests.table import table

BOX = Box((0.37, 0.2))
HELD = Support(BOX.side("left"), (0.0, 0.0))
LOADED = Problem(BOX, Isotropic(1e5, 0.3), (HELD,), (Traction(BOX.side("right"), (1.0, 0.0)),))
MOVED = Problem(BOX, Isotropic(1e5, 0.3), (HELD, Support(BOX.side("right"), (1e-3, 0.0))))
REFERENCE = np.array([[0.0, 0.0], [1.0, 0.5], [2.0, -1.0]])


def row(error, uncertainty=1e-4, quantity="displacement"):
    return Difference(quantity, "m", 1.0, 1.0, error, uncertainty, 0.05)


def compared(values, rows, problem=LOADED, kind="", size=1e-9):
    return SimpleNamespace(
        gaps=((),),
        rows=rows,
        displacement=size * values,
        reference=SimpleNamespace(
            displacement=SimpleNamespace(value=size * REFERENCE),
            error=rows[0].uncertainty,
            more=None,
            no_limit=(),
        ),
        case=Case(problem, unit="mm"),
        limitations=(),
        kind=kind,
    )


RIPPLE = REFERENCE / 1.03 + 0.01 * np.array([[1.0, 0.0], [0.0, -1.0], [1.0, 1.0]])
BENT = REFERENCE + np.array([[0.0, 0.0], [0.3, 0.0], [0.0, 0.1]])


@table(
    ("values", "problem", "sentence"),
    [
        (REFERENCE / 1.02, LOADED, "The springs are 2 % too stiff."),
        (
            REFERENCE * 1.2,
            LOADED,
            "The springs are too soft: displacements are 20 % too large.",
        ),
        (REFERENCE * 1.02, MOVED, "The springs: displacements are 2 % too large."),
        (BENT, LOADED, "The springs differ from elasticity by 13 %, mostly in shape."),
        (-REFERENCE, LOADED, "The springs differ from elasticity by 200 %."),
        (REFERENCE * 12, LOADED, "The springs displace 12 times as much as elasticity."),
        (REFERENCE, LOADED, "The springs agree with elasticity to within 0.01 %."),
    ],
)
@pytest.mark.parametrize("size", [1e-9, 0.3])
def test_the_sentence_names_a_stiffness_only_if_one_factor_explains_the_difference(
    values, problem, sentence, size
):
    error = float(np.linalg.norm(values - REFERENCE, axis=1).max() / np.sqrt(5))
    assert (
        headline.springs_sentence(compared(values, (row(error),), problem, size=size)) == sentence
    )


def test_quantities_outside_the_band_are_named_beside_the_stiffness():
    rows = row(0.02), row(0.12, quantity="mean stress")
    sentence = headline.springs_sentence(compared(REFERENCE / 1.02, rows))
    assert sentence == "The springs are 2 % too stiff. Outside the band: mean stress (12 %)."


def test_what_the_uncertainty_leaves_open_is_not_decided():
    found = compared(REFERENCE * 1.04, (row(0.04, 0.03),))
    sentence = "Not resolved: displacement differs by 4 % ± 3 %, for a band of 5 %."
    assert headline.springs_sentence(found) == sentence
    assert headline.recommend(found, Choice()).use == headline.NEITHER
    assert "smaller [compare] accuracy" in headline.recommend(found, Choice()).reason
    found.reference.no_limit = ("a support at a point carries a force; support a side",)
    assert headline.recommend(found, Choice()).reason == found.reference.no_limit[0]


FINER = Choice(springs=(Need(0.05, BETWEEN, 778, 0.1, 18, 1e-3),))
NEARER = Choice(springs=FINER.springs, unknowns=1616, times=9.5)


@table(
    ("rows", "kind", "chosen", "use", "words"),
    [
        ((row(0.02),), "", NEARER, "springs", "at 1,616 unknowns, elements"),
        ((row(0.2),), COARSE, NEARER, "elements", "9.5 times more accurate"),
        ((row(0.2),), COARSE, FINER, "springs", "a spacing of 1 mm (778 springs)"),
        ((row(0.2), row(0.2, 0.01, "strain energy")), COARSE, FINER, "springs", "of 1 mm"),
        ((row(0.2),), NOT_TOLD, FINER, "elements", "no tested spacing"),
        ((row(0.2),), OTHER_MATERIAL, FINER, "elements", "at any spacing"),
        ((row(0.02), row(0.3, 0.01, "mean stress")), COARSE, FINER, "elements", "mean stress"),
    ],
)
def test_advice_follows_the_badge(rows, kind, chosen, use, words):
    found = compared(REFERENCE / 1.02, rows, kind=kind)
    advice = headline.recommend(found, chosen)
    assert advice.use == use
    assert words in advice.sentence
    if headline.overall(rows) == AGREES:
        assert advice.use == headline.SPRINGS, "a badge 'agrees' never stands above 'use elements'"


def test_a_difference_below_its_uncertainty_is_a_bound():
    assert headline.part_text(2e-14, 1e-10) == "< 0.01 %"
    assert headline.part_text(2e-4, 1e-3) == "< 0.1 %"
    assert headline.part_text(0.02, float("nan")) == "2 %"


def test_a_judged_field_begins_with_its_stiffness():
    own = row(0.01)
    found = SimpleNamespace(
        displacement=own,
        matched=SimpleNamespace(displacement=REFERENCE / 0.99),
        reference=SimpleNamespace(displacement=SimpleNamespace(value=REFERENCE)),
        case=Case(LOADED),
        limitations=(),
    )
    assert headline.field_sentence(found) == "The field is uniformly 1 % too soft."
    found.matched.displacement = RIPPLE
    sentence = headline.field_sentence(found)
    assert sentence.startswith("The field is on average ")
    assert sentence.endswith(" % is not uniform.")
    found.displacement = replace(own, out_of_range=True)
    assert found.displacement.word == NOT_RESOLVED
    assert headline.field_sentence(found).startswith("Not resolved: ")
    assert row(0.2).word == DIFFERS


def test_quantities_are_shown_in_the_unit_of_the_file():
    assert quantity_text(7.352e-05, "m", "mm") == "0.07352 mm"
    assert quantity_text(5.82e6, "Pa", "mm") == "5.82 MPa"
    assert quantity_text(5.82e6, "Pa", "m") == "5.82e+06 Pa"
    assert quantity_text(80.0, "N", "mm") == "80 N"
    assert quantity_text(float("nan"), "m", "mm") == ""
    with pytest.raises(ProblemError, match="unit"):
        Case(LOADED, unit="furlong")


class Named:
    """A cause with a name and what it leaves."""

    def __init__(self, name, part):
        vars(self).update(name=name, left=part)

    def __str__(self):
        return f"{self.name}."


@pytest.mark.parametrize(
    ("notes", "text"),
    [
        ({}, "Check the most likely cause first: whole springs. As likely: mesh."),
        ({"convergence": "half the step."}, "Let the simulator converge first: half the step."),
    ],
)
def test_the_cause_that_leaves_least_is_recommended_after_convergence(notes, text):
    causes = [Named("modulus", 4e-3), Named("whole springs", 2e-3), Named("mesh", 2.1e-3)]
    field = SimpleNamespace(
        case=SimpleNamespace(notes=notes, band=0.05),
        displacement=SimpleNamespace(word="differs", uncertainty=2e-4),
        verdict=SimpleNamespace(causes=causes, fits=lambda cause: cause.left < 1e-2),
    )
    assert headline.recommend_for_field(field) == text
