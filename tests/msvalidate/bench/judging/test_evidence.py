"""Evidence refuses what cannot be judged; a judgement fails what is not a number."""

import numpy as np
import pandas as pd
import pytest

from msvalidate.bench.judging.compare import farthest_value, fitted_power, observed_order
from msvalidate.bench.judging.evidence import (
    Evidence,
    Observed,
    Tolerance,
    all_passed,
    gather_evidence,
    judge,
    merge,
)
from msvalidate.problem import ProblemError, SolverError

LIMIT = Tolerance("gap", 0.1, "m", "because")
TABLE = pd.DataFrame({"x": [1.0, 2.0]})
COLUMNS = {"x": "place (m)"}


def evidence(value=0.0, table=TABLE, tolerances=(LIMIT,), columns=COLUMNS):
    return Evidence({"table": table}, {"gap": Observed(value)}, tolerances, columns=columns)


@pytest.mark.parametrize(
    ("value", "verdict"),
    [(0.1, "pass"), (-0.1, "pass"), (0.11, "fail"), (np.nan, "fail"), (np.inf, "fail")],
)
def test_judgement(value, verdict):
    row = judge(evidence(value)).iloc[0]
    assert row["verdict"] == verdict
    assert all_passed(judge(evidence(value))) == (verdict == "pass")


def test_judgement_of_nothing_is_not_held():
    assert not all_passed(judge(Evidence({}, {}, ())))


@pytest.mark.parametrize(
    ("table", "message"),
    [
        (TABLE.head(0), "no rows; nothing was compared"),
        (TABLE.assign(x=[1.0, np.nan]), "x is nan in row 1"),
        (TABLE.assign(x=[np.inf, 1.0]), "x is inf in row 0"),
        (TABLE.assign(x=["none", np.nan]), "x is nan in row 1"),
        (TABLE.assign(x=[None, "none"]), "x is .* in row 0"),
    ],
)
def test_tables_without_numbers_are_failures(table, message):
    with pytest.raises(SolverError, match=message):
        evidence(table=table)


@pytest.mark.parametrize(
    "tolerances", [(), (LIMIT, LIMIT), (LIMIT, Tolerance("other", 1.0, "m", "because"))]
)
def test_every_observation_has_one_tolerance(tolerances):
    with pytest.raises(ValueError, match="observed without a tolerance, the reverse, or twice"):
        evidence(tolerances=tolerances)


def test_every_column_has_a_meaning():
    with pytest.raises(ValueError, match=r"columns without a meaning: \['place'\]"):
        evidence(table=TABLE.rename(columns={"x": "place"}), columns={})


@pytest.mark.parametrize(
    "fault", [{"limit": np.inf}, {"limit": -1.0}, {"unit": ""}, {"because": ""}]
)
def test_a_tolerance_must_be_one(fault):
    with pytest.raises(ValueError, match="needs a finite limit, a unit and a reason"):
        Tolerance(**({"quantity": "gap", "limit": 1.0, "unit": "m", "because": "so"} | fault))


def test_words_among_numbers_are_declared():
    mixed = pd.DataFrame({"x": [1.0, "none"]})
    with pytest.raises(ValueError, match=r"x holds \['none'\] among numbers"):
        evidence(table=mixed)
    assert evidence(table=mixed, columns={"x": 'place (m); "none" where there is none'}).tables
    assert evidence(table=pd.DataFrame({"x": ["some", "none"]})).tables, (
        "words alone need no naming"
    )


def test_merged_columns_round_by_the_larger():
    parts = [Evidence({}, {}, (), rounding={"x": size, f"y{size}": size}) for size in (2.0, 1.0)]
    assert merge(*parts).rounding == {"x": 2.0, "y2.0": 2.0, "y1.0": 1.0}


def test_a_column_means_one_thing_in_a_study():
    other = Evidence({"more": TABLE}, {}, (), columns={"x": "time (s)"})
    with pytest.raises(ValueError, match="column x means two things"):
        merge(evidence(), other)


def test_merged_parts_keep_their_names_apart():
    with pytest.raises(ValueError, match="both name"):
        merge(evidence(), evidence())


def test_worst_is_the_farthest_and_stops_at_nan():
    assert farthest_value([1.0, 5.0, 2.0], [1.0, 2.0, 9.0]) == Observed(2.0, 9.0, 3)
    assert np.isnan(farthest_value([1.0, np.nan, 99.0], 0.0).value)
    with pytest.raises(ValueError, match="no values"):
        farthest_value([], [])


def test_observed_order():
    h = np.array([1.0, 0.5, 0.25])
    # The slope of an exact power law carries only the rounding of the fit.
    assert observed_order(h, 3 * h**1.7) == pytest.approx(1.7, abs=1e-12)
    assert np.isnan(observed_order(h, [1e-16, 1e-16, 2e-16])), "an order fitted to rounding"
    assert np.isnan(observed_order(h[:1], [1.0]))
    assert np.isnan(observed_order(h, [1.0, np.nan, 0.1]))


def test_the_interval_of_a_power_holds_it_as_often_as_it_says():
    rng = np.random.default_rng(3)
    sizes, hits = np.geomspace(10, 1000, 5), 0
    for _ in range(2000):
        fit = fitted_power(sizes, sizes**0.5 * np.exp(rng.normal(0, 0.1, 5)))
        hits += fit.low <= 0.5 <= fit.high
    assert hits / 2000 == pytest.approx(0.95, abs=0.02)  # four standard errors of the count


@pytest.mark.parametrize(
    ("sizes", "values"),
    [([1, 2], [1, 2]), ([1, 2, 2], [1, 2, 3]), ([1, 2, 3], [1, 0, 3]), ([1, 2, 3], [1, 2])],
)
def test_no_power_to_fit(sizes, values):
    with pytest.raises(ProblemError, match="sizes"):
        fitted_power(sizes, values)


def test_answers_are_those_of_the_questions_asked():
    one, two = (
        Evidence(
            {name: TABLE}, {name: Observed(0.0)}, (Tolerance(name, 1.0, "m", "why"),), {}, COLUMNS
        )
        for name in ("one", "two")
    )
    study = {"one": lambda: one, "two": lambda: two}
    assert list(gather_evidence(study).tables) == ["one", "two"]
    assert list(gather_evidence(study, ("two",)).tables) == ["two"]
    for none in ((), ("three",), "one"):
        with pytest.raises(ProblemError, match=r"questions: .*; choose from one, two"):
            gather_evidence(study, none)
