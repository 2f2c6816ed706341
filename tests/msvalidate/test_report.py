"""Reports: whole files or none, aligned tables, no host, user or path."""

import getpass
import socket
from datetime import UTC, datetime
from pathlib import Path

import pandas as pd
import pytest

from msvalidate import figures, provenance, report
from msvalidate.evidence import Evidence, Observed, Tolerance, judge
from msvalidate.problem import ProblemError


def drawn(tables):
    """A straight line."""
    figure, (axis,) = figures.new()
    axis.plot(tables["line"]["x"], tables["line"]["x"], label="x")
    figures.shared_legend(figure, [axis])
    return figure


@pytest.fixture
def result():
    evidence = Evidence(
        tables={"line": pd.DataFrame({"x": [float(i) for i in range(50)]})},
        observed={"gap": Observed(2.0, 1.0)},
        tolerances=(Tolerance("gap", 0.5, "m", "half a gap"),),
        figures={"line": drawn},
        columns={"x": "place (m)"},
        findings=("A finding.",),
    )
    return report.Result("lines", "How long?", evidence, judge(evidence))


def test_study_files(result, tmp_path):
    report.write_study(result, tmp_path)
    files = {path.name for path in (tmp_path / "lines").iterdir()}
    assert files == {"line.csv", "verdict.csv", "line.png", "line.svg"}
    read = pd.read_csv(tmp_path / "lines" / "line.csv")
    pd.testing.assert_frame_equal(read, result.evidence.tables["line"])
    assert (tmp_path / "lines" / "line.png").read_bytes().startswith(b"\x89PNG")


def test_same_tables_draw_the_same_picture(result, tmp_path):
    for folder in ("a", "b"):
        report.write_study(result, tmp_path / folder)
    for kind in report.FORMATS:
        one, two = (tmp_path / f / "lines" / f"line.{kind}" for f in ("a", "b"))
        assert one.read_bytes() == two.read_bytes()


def test_no_plots_leaves_no_stale_picture(result, tmp_path):
    report.write_study(result, tmp_path)
    report.write_study(result, tmp_path, plots=False)
    assert {p.suffix for p in (tmp_path / "lines").iterdir()} == {".csv"}


def test_interrupted_write_keeps_the_old_file(result, tmp_path, monkeypatch):
    report.write_study(result, tmp_path)
    before = {p.name: p.read_bytes() for p in (tmp_path / "lines").iterdir()}

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(report.os, "fsync", full)
    with pytest.raises(OSError, match="No space"):
        report.write_study(result, tmp_path)
    assert {p.name: p.read_bytes() for p in (tmp_path / "lines").iterdir()} == before


def test_report_page(result, tmp_path):
    report.write_report([result], {"other": "diverged"}, {"seed": "0"}, tmp_path)
    page = (tmp_path / "report.md").read_text(encoding="utf-8")
    for piece in (
        "| lines | **FAIL** | 0 of 1 |",
        "| other | **not finished** | diverged |",
        "How long?",
        "- A finding.",
        "half a gap",
        "![A straight line.](lines/line.png)",
        "[CSV](lines/line.csv), 50 rows",
        "10 more rows in the CSV",
        "| x | place (m) |",
        "| seed | 0 |",
    ):
        assert piece in page


def test_text_table_says_what_it_leaves_out(result):
    table = result.evidence.tables["line"]
    assert report.text_table(table).endswith("… 10 more rows")
    assert "more rows" not in report.text_table(table, None)


def test_unwritable_places(tmp_path):
    file = tmp_path / "file"
    file.touch()
    with pytest.raises(ProblemError, match="is a file; name a folder"):
        report.refuse_unwritable(file / "below")
    report.refuse_unwritable(tmp_path / "not" / "yet" / "there")
    assert not (tmp_path / "not").exists(), "asking must not create"


def test_provenance_names_no_host_user_or_path():
    origin = provenance.provenance(["python", "-m", "x"], 3, datetime.now(UTC))
    assert list(origin) == [
        "msvalidate",
        "Python",
        "libraries",
        "processor",
        "system",
        "seed",
        "command",
        "time",
    ]
    text = " ".join(origin.values())
    assert socket.gethostname() not in text
    assert str(Path.home()) not in text
    assert getpass.getuser() not in text.split()
