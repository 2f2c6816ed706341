"""JSON, JUnit and baseline of the commands that judge."""

from __future__ import annotations

import json
from argparse import Namespace
from xml.etree import ElementTree as ET

import pandas as pd
import pytest

from msvalidate.cli import gating
from msvalidate.cli.arguments import options_of
from msvalidate.problem import ProblemError

JUDGING = ("check", "case run", "case judge", "simulate", "adapter check")
OPTIONS = ("--json", "--junit", "--baseline", "--update", "--reason")


@pytest.mark.parametrize("name", JUDGING)
def test_commands_that_judge_have_the_same_options(name):
    options = options_of(name)
    assert {option: "metavar" in options[option] for option in OPTIONS} == {
        "--json": False,
        "--junit": True,
        "--baseline": True,
        "--update": False,
        "--reason": True,
    }


@pytest.fixture
def conclude(tmp_path, monkeypatch):
    """Conclude a result with a displacement, and return the exit code."""
    monkeypatch.chdir(tmp_path)

    def act(u, code=0, error="", **options):
        defaults = dict.fromkeys(("json", "junit", "baseline", "update", "reason"))
        args = Namespace(out=tmp_path / "out", **(defaults | options))
        gating.refuse_outputs(args, gating.CASES)
        rows = [gating.row("agreement", "u", "agrees", observed=u, reference=1.0)]
        tables = {"quantities": pd.DataFrame({"u": [u], "unit": ["m"]})}
        result = gating.Judged("bar", pd.DataFrame(rows), {"u": u}, tables)
        if error:
            result = gating.unfinished("bar", error)
        return gating.conclude(args, gating.CASES, [result], code)

    act.folder = tmp_path
    return act


def test_a_moved_number_is_a_failure_until_it_has_a_reason(conclude, capsys):
    base = {"baseline": conclude.folder / "base"}
    with pytest.raises(ProblemError, match="no case baseline in it; make one by adding --update"):
        conclude(1.0, **base)
    assert conclude(1.0, **base, update=True, reason="first") == 0
    assert conclude(1.0, **base) == 0
    assert conclude(1.01, **base) == 1
    line = "bar: baseline quantities.csv: u, row 0: was 1.0, is 1.01, moved by 0.01 (1 %)"
    assert line in capsys.readouterr().err
    assert conclude(1.01, **base, update=True, reason="finer") == 0
    assert conclude(1.01, **base) == 0
    last = (conclude.folder / "base" / "REASONS.md").read_text("utf-8").splitlines()[-1]
    assert "baseline (case; bar): finer; bar/quantities: u, row 0: was 1.0, is 1.01" in last


def test_json_and_junit_are_complete(conclude, capsys):
    path = conclude.folder / "j.xml"
    assert conclude(1.0, json=True, junit=path) == 0
    assert json.loads(capsys.readouterr().out) == {"u": 1.0}
    suite = ET.parse(path).find("testsuite")  # noqa: S314  our own
    assert {name: suite.get(name) for name in ("name", "tests", "failures", "errors")} == {
        "name": "bar",
        "tests": "1",
        "failures": "0",
        "errors": "0",
    }
    assert conclude(1.0, code=3, error="it crashed", junit=path) == 3
    error = ET.parse(path).find("testsuite/testcase/error")  # noqa: S314  our own
    assert error.get("message") == "it crashed"


def test_a_command_that_fails_leaves_a_junit_file(tmp_path):
    path = tmp_path / "j.xml"
    with (
        pytest.raises(ProblemError, match="no mesh"),
        gating.failures(Namespace(junit=path), "bar"),
    ):
        raise ProblemError("case bar: no mesh")
    error = ET.parse(path).find("testsuite/testcase/error")  # noqa: S314  our own
    assert error.get("message") == "case bar: no mesh"


def test_a_result_without_baseline_or_without_numbers_is_no_success(conclude, capsys):
    base = {"baseline": conclude.folder / "base"}
    (base["baseline"] / "case").mkdir(parents=True)
    assert conclude(1.0, **base) == 1
    assert "no baseline; make one by adding --update" in capsys.readouterr().err
    assert conclude(1.0, code=3, error="it crashed", **base, update=True, reason="x") == 3
    assert "baseline unchanged: bar has no result" in capsys.readouterr().err
    assert not (base["baseline"] / "case" / "bar").exists()
