"""The question `iterations` sees rest states that lie, and errors that grow with iterations."""

import pytest

from studies.simulators import iterations


def state(dt, error, *, count=None, rest=0.0, by_dt=None, beside="corotated"):
    numbers = {"iterations": count, "dt": dt, "error": error, "rest": rest, "by_dt": by_dt}
    words = {"label": "", "beside": beside, "precision": "float64", "because": ""}
    return {**numbers, **words, "by_iterations": None, "seconds": 1.0}


def observed(monkeypatch, *given):
    record = {"name": "mine", "draft": True, "iterations": list(given)}
    plain = {
        "name": "plain",
        "draft": True,
        "iterations": [state(0.1, 0.0), state(0.05, 0.0, by_dt=0.0)],
    }
    monkeypatch.setattr(iterations, "records", lambda: [record, plain])
    return [tolerance.observed.value for tolerance in iterations.run().tolerances]


def test_error_that_grows_by_iterations(monkeypatch):
    rows = [state(0.1, error, count=count) for count, error in ((1, 0.1), (2, 0.5), (4, 0.3))]
    assert observed(monkeypatch, *rows) == [pytest.approx(0.2), 0, 0, 0]


def test_rest_that_half_the_step_moves(monkeypatch):
    rows = state(0.1, 0.0, rest=1e-3), state(0.05, 0.004, rest=1e-3, by_dt=0.004)
    assert observed(monkeypatch, *rows)[1:] == [pytest.approx(0.002, rel=1e-6), 0.004, 0]


def test_sweep_without_a_number(monkeypatch):
    assert observed(monkeypatch, state(0.1, None, count=1))[3] == 1
