"""docs/one-asset.md: its numbers are those of the records in the committed baseline."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from msvalidate.simulators.bodies.laws import predicted

ROOT = Path(__file__).resolve().parents[1]
PAGE = (ROOT / "docs" / "one-asset.md").read_text(encoding="utf-8")
RECORDED = pd.read_csv(ROOT / "reports/baseline/full/simulators/recorded.csv").set_index("name")
NUMBERS = ["predicted_modulus", "predicted_ratio", "probed_modulus", "probed_ratio"]
SMITH = "Smith's neo-Hookean, Lamé's constants as they stand"


def shown(name):
    return [n if n == "none" else f"{float(n):.4f}" for n in RECORDED.loc[name, NUMBERS]]


@pytest.mark.parametrize("solver", ["semi-implicit", "VBD", "XPBD"])
def test_each_row_is_its_record(solver):
    name = f"newton-{solver.lower().partition('-')[0]}"
    record = RECORDED.loc[name]
    law, cause = (record[column].partition("; ")[0] for column in ("law_and_settings", "cause"))
    assert f"| {' | '.join([solver, law, *shown(name), cause])} |" in PAGE
    assert record["simulator"].title() in PAGE
    assert record["date"] in PAGE
    assert record["draft"] == "yes"
    assert "*Draft until" in PAGE
    assert (float(record["asked_modulus"]), float(record["asked_ratio"])) == (1e7, 0.3)


def solid(E, nu):
    found = predicted(SMITH, E, nu)
    return found.E, found.nu


def test_what_it_says_of_other_ratios_and_of_the_remedy():
    assert shown("pybullet-neo_hookean")[2:] == ["0.7322", "0.2692"]
    assert solid(1.3520, 0.3182) == pytest.approx((1, 0.3), abs=1e-4)
    assert solid(1.0, 5 / 26)[1] == pytest.approx(0, abs=1e-12)
    assert solid(1.0, 1 / 18 + 1e-9)[0] == pytest.approx(0, abs=1e-7)
    assert solid(1.0, 0.5 - 1e-9) == pytest.approx((3 / 4, 1 / 2), abs=1e-7)
    assert all(text in PAGE for text in ("1.3520 E′", "ν = 0.3182", "5/26", "1/18"))
