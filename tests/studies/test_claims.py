"""The study `claims`: verdicts follow numbers, every link is there, forms agree."""

import pandas as pd
import pytest
from msvalidate.studies.claims.record import AT_LEAST, AT_MOST, FAILS, HOLDS, NOT_YET, Check, Claim

from msvalidate.judging.sweep import Setting
from msvalidate.output.baseline import baseline_folder
from msvalidate.output.results import THIS_RUN, Results
from msvalidate.problem import ProblemError
from msvalidate.studies import claims
from tests.table import table

QUICK = Setting(quick=True)
SMALL = Check("a", "b", "a number", "1", lambda _: 0.0, AT_MOST, 2, "small")
LARGE = Check("a", "b", "another", "1", lambda _: 0.0, AT_LEAST, 5, "large")
BOTH = Claim(1, "1", "A sentence.", HOLDS, "theory", SMALL, "it is large", LARGE)
FORMS = ("quick", "full")


def damping(steps):
    """Results of a run in which every price of damping is as given."""
    where = baseline_folder("quick") / "damping"
    found = {path.stem: pd.read_csv(path) for path in where.glob("*.csv")}
    found["advice"] = found["advice"].assign(steps=steps)
    return Results("quick", run={"damping": found})


def row(evidence, number):
    """A sentence's row of the ledger."""
    return evidence.tables["ledger"].set_index("sentence").loc[number]


@table(
    ("claim", "plain", "under", "verdict"),
    [
        (BOTH, 2, 0, HOLDS),
        (BOTH, 2.1, 5, "holds only if it is large"),
        (BOTH, 2.1, 4.9, FAILS),
        (Claim(1, "1", "A sentence.", HOLDS, "theory", SMALL), 2.1, None, FAILS),
        (Claim(1, "1", "A sentence.", NOT_YET, "theory"), 0, None, NOT_YET),
    ],
)
def test_verdicts_follow_numbers(claim, plain, under, verdict):
    assert claim.decide(plain, under) == verdict


@table(("check", "number"), [(c, n) for c in (SMALL, LARGE) for n in (-3, 0, 2, 5, 7)])
def test_a_number_moved_past_its_bound_changes_sides(check, number):
    assert check.holds(check.moved(number)) != check.holds(number)


def test_every_sentence_has_one_row_with_a_reason_and_a_table_that_is_there():
    assert [claim.number for claim in claims.CLAIMS] == list(range(1, 66))
    for claim in claims.CLAIMS:
        assert 0 < len(claim.statement.split()) <= 15, claim.number
        assert len(claim.theory) > 10, claim.number
        assert bool(claim.condition) == bool(claim.conditional), claim.number
        for check in filter(None, (claim.check, claim.conditional)):
            for form in FORMS:
                assert (baseline_folder(form) / check.study / f"{check.table}.csv").is_file()


def test_small_and_full_form_come_to_the_same_verdicts():
    small, full = (pd.read_csv(baseline_folder(form) / "claims/ledger.csv") for form in FORMS)
    assert small["verdict"].tolist() == full["verdict"].tolist()


def test_numbers_of_this_run_come_before_those_of_the_baseline():
    ours = row(claims.run(setting=QUICK), 27)
    assert ours["number"] == pytest.approx(17238 / 8670)  # of the beam, as printed by `damping`
    theirs = row(claims.run(damping(steps=7.0), setting=QUICK), 27)
    assert (theirs["number"], theirs["verdict"]) == (1, HOLDS)
    assert theirs["taken_from_here"] == THIS_RUN


def test_a_missing_row_is_told_in_one_line_with_its_sentence():
    alone = {"figure3": pd.DataFrame({"scheme": ["leapfrog"], "leaves_at_step": ["x"]})}
    few = Results("quick", run={"stability": alone})
    one = [claim for claim in claims.CLAIMS if claim.number == 32]
    with pytest.raises(
        ProblemError, match=r"^sentence 32, from stability/figure3: .*no row"
    ) as told:
        claims.run(few, setting=QUICK, claims=one)
    assert "\n" not in str(told.value)
