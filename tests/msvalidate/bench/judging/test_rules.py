"""Rules read the farthest of the rows they name, and refuse what they cannot read."""

import numpy as np
import pandas as pd
import pytest

from msvalidate.bench.judging.compare import Observed
from msvalidate.bench.judging.evidence import Evidence, judge
from msvalidate.bench.judging.rules import Difference, Quotient, Rule, read_rule
from msvalidate.problem import SolverError

BARS = pd.DataFrame(
    {
        "body": ["bar", "bar", "bar", "plate", "plate", "plate"],
        "cells": [2, 4, 8, 2, 4, 8],
        "seen": [1.5, 1.25, 1.125, 3.75, 1.6, 1.171875],
        "exact": [1.0] * 6,
        "noted": ["none", 1.0, 1.0, 1.0, 1.0, 1.0],
    }
)


def rule(**given):
    return Rule("gap", 0.5, "m", "so", **{"table": "bars", "value": "seen"} | given)


def read(**given):
    return read_rule(rule(**given), {"bars": BARS})


@pytest.mark.parametrize(("given", "seen"), [
    ({"reference": "exact"}, Observed(3.75, 1.0, 6, "body plate, cells 2")),
    ({"reference": 3.0}, Observed(1.125, 3.0, 6, "body bar, cells 8")),
    ({"rows": {"body": "bar", "cells": (2, 4)}, "value": Quotient("exact", "seen")}, Observed(0.8,
        0.0, 2, "body bar, cells 4")),
    ({"by": ("body",), "last": 1, "value": Difference("seen", 1)}, Observed(0.171875, 0.0, 2,
        "body plate, cells 8")),
    ({"value": lambda rows: rows["seen"].sum()}, Observed(BARS["seen"].sum(), 0.0, 1)),
])  # fmt: skip
def test_the_farthest_row_is_named(given, seen):
    assert read(**given) == seen


def test_an_order_and_a_growth_are_exponents_of_each_group():
    power = {"value": Difference("seen", "exact"), "by": ("body",)}
    order = read(power_of=Quotient(1, "cells"), reference=1.0, **power)
    assert (order.rows, order.at) == (6, "body plate, cells 8")
    assert order.value == pytest.approx(2.0, abs=1e-12)  # of the plate: 2.75, .6, .171875 -> 2
    growth = read(power_of="cells", last=2, rows={"body": "bar"}, **power)
    assert (growth.value, growth.rows) == (pytest.approx(-1.0), 2)


@pytest.mark.parametrize(
    ("given", "error", "said"),
    [
        ({"table": "bar"}, ValueError, "no table bar; choose from bars"),
        ({"value": "see"}, ValueError, "no column see in bars; choose from body, cells"),
        ({"rows": {"bodies": "bar"}}, ValueError, "no column bodies in bars"),
        ({"by": ("size",)}, ValueError, "no column size"),
        ({"rows": {"body": "disc"}}, SolverError, "body 'disc'; it has bar, plate"),
        ({"rows": {"cells": "2"}}, SolverError, "cells '2'; it has 2, 4, 8"),
        ({"value": "noted"}, SolverError, "could not convert string to float: 'none'"),
    ],
)
def test_what_selects_or_holds_nothing_is_refused(given, error, said):
    with pytest.raises(error, match=rf"^rule 'gap': .*{said}"):
        read(**given)


def test_no_number_fails_and_is_named():
    log = rule(value=lambda rows: np.where(rows["cells"] == 4, np.nan, 0.1))
    columns = dict.fromkeys(BARS, 'one, or "none" (1)')
    row = judge(Evidence({"bars": BARS}, tolerances=(log,), columns=columns)).iloc[0]
    assert (row["verdict"], row["rows"], row["at"]) == ("fail", 6, "body bar, cells 4, noted 1")


def test_a_swapped_pair_is_judged_as_before():
    rules = tuple(
        Rule(body, limit, "m", "so", table="bars", value="seen", rows={"body": body})
        for body, limit in (("bar", 2.0), ("plate", 3.0))
    )
    columns = dict.fromkeys(BARS, 'one, or "none" (1)')
    both = [
        judge(Evidence({"bars": BARS}, tolerances=order, columns=columns)).set_index("quantity")
        for order in (rules, rules[::-1])
    ]
    pd.testing.assert_frame_equal(both[0], both[1].loc[["bar", "plate"]])
    assert list(both[0]["verdict"]) == ["pass", "fail"]


def test_an_observation_by_hand_does_not_hide_what_the_table_holds():
    columns = dict.fromkeys(BARS, 'one, or "none" (1)')
    found = Evidence({"bars": BARS}, {"gap": Observed(0.0)}, (rule(),), columns=columns)
    assert found.observed["gap"].value == 3.75


def test_six_columns_name_a_row_and_none_that_is_the_same_in_all():
    wide = pd.DataFrame({f"c{i}": ["a", "b"] for i in range(8)} | {"one": "x", "gap": [1.0, 2.0]})
    found = read_rule(rule(value="gap"), {"bars": wide})
    assert found.at == "c0 b, c1 b, c2 b, c3 b, c4 b, c5 b"
    few = wide[["one", "c0", "gap"]]
    assert read_rule(rule(value="gap", reference=0.5), {"bars": few}).at == "c0 b"


def test_groups_are_judged_in_the_order_of_their_rows():
    away = BARS.iloc[::-1].assign(seen=1.5)
    assert read_rule(rule(by=("body",), last=1), {"bars": away}).at == "body plate, cells 2"
