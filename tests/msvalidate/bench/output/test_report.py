"""Folders of results: exchanged whole, never mixed or half-written; what they hold, read back."""

import getpass
import json
import os
import shutil
import socket
from datetime import UTC, datetime
from pathlib import Path

import pandas as pd
import pytest

from msvalidate.bench.judging.evidence import Evidence, Observed, Tolerance, judge
from msvalidate.bench.output import figures, provenance, report, stored
from msvalidate.problem import ProblemError
from msvalidate_check import exchange


def drawn(tables):
    """A straight line."""
    figure, (axis,) = figures.new_figure()
    axis.plot(tables["line"]["x"], tables["line"]["x"], label="x")
    figures.add_shared_legend(figure, [axis])
    return figure


def evidence(gap=2.0, rows=50):
    return Evidence(
        tables={"line": pd.DataFrame({"x": [i / 7 for i in range(rows)]})},
        observed={"gap": Observed(gap, 1.0)},
        tolerances=(Tolerance("gap", 0.5, "m", "half a gap"),),
        figures={"line": drawn},
        columns={"x": "place (m)"},
        findings=("A finding.",),
    )


def result(name="poisson", gap=2.0):
    found = evidence(gap)
    return stored.Result(name, "How long?", found, judge(found))


def files(name="poisson", gap=2.0, plots=True, seconds=0.0):
    return stored.result_files(result(name, gap), {"seed": "0"}, plots=plots, seconds=seconds)


def content(folder):
    return {
        p.relative_to(folder).as_posix(): p.read_bytes() for p in folder.rglob("*") if p.is_file()
    }


def test_verdict_json(tmp_path):
    broken, good = files("displacement", gap=float("nan")), files(gap=1.2, seconds=2.5)
    report.publish({"displacement": broken, "poisson": good}, tmp_path / "r")
    found = json.loads((tmp_path / "r" / "verdict.json").read_text(encoding="utf-8"))
    keys = [
        "study",
        "layer",
        "quantity",
        "unit",
        "observed",
        "reference",
        "error",
        "limit",
        "verdict",
        "because",
        "rows",
        "at",
        "seconds",
    ]
    assert [list(row) for row in found] == [keys, keys]
    assert [row["seconds"] for row in found] == [None, 2.5]  # of results of old, and of new ones
    broken, good = found
    assert (broken["study"], broken["observed"], broken["verdict"]) == (
        "displacement",
        None,
        "fail",
    )
    assert (good["observed"], good["limit"], good["verdict"]) == (1.2, 0.5, "pass")
    assert good["because"] == "half a gap"
    assert good["layer"] == "theory"


def test_other_studies_stay(tmp_path):
    out = tmp_path / "r"
    report.publish({"poisson": files()}, out)
    before = content(out)
    report.publish({"displacement": files("displacement")}, out)
    after = content(out)
    assert {k: v for k, v in after.items() if k.startswith("poisson/")} == {
        k: v for k, v in before.items() if k.startswith("poisson/")
    }
    assert len(json.loads(after["verdict.json"])) == 2
    assert b"displacement" in after["report.html"]


def test_an_unfinished_study_keeps_the_results_of_the_run_before(tmp_path):
    out = tmp_path / "r"
    report.publish({"poisson": files(gap=1.2)}, out)

    def again(folder):
        return stored.unfinished_files(folder, "How long?", {"seed": "1"}, "diverged")

    (study,) = report.publish({}, out, {"poisson": again})
    assert (study.error, study.held, study.origin) == ("diverged", False, {"seed": "0"})
    assert list(study.tables) == ["line"]
    (row,) = json.loads((out / "verdict.json").read_text(encoding="utf-8"))
    assert (row["quantity"], row["verdict"], row["because"]) == (
        "study finished",
        "fail",
        "diverged",
    )


def test_an_unfinished_study_without_a_run_before(tmp_path):
    out = tmp_path / "r"
    report.publish(
        {}, out, {"poisson": lambda f: stored.unfinished_files(f, "Why?", {}, "diverged")}
    )
    assert set(content(out)) == {"poisson/study.json", "report.html", "verdict.json"}
    assert "diverged" in (out / "report.html").read_text(encoding="utf-8")


def test_a_full_disk_keeps_the_old_results(tmp_path, monkeypatch):
    out = tmp_path / "r"
    report.publish({"poisson": files()}, out)
    before = content(tmp_path)
    written = []

    def full(_):
        written.append(1)
        if len(written) == 3:
            raise OSError(28, "No space left on device")

    monkeypatch.setattr(report.os, "fsync", full)
    with pytest.raises(OSError, match="No space"):
        report.publish({"poisson": files(gap=1.2)}, out)
    assert content(tmp_path) == before


@pytest.mark.parametrize("foreign", ["notes.txt", "poisson/notes.txt", "optuna/study.json"])
def test_files_of_other_people_stay(foreign, tmp_path):
    """A folder that holds more than results is not exchanged: its parts are."""
    out = tmp_path / "r"
    (out / foreign).parent.mkdir(parents=True)
    (out / foreign).write_text("mine", encoding="utf-8")
    report.publish({"displacement": files("displacement")}, out)
    report.publish({"displacement": files("displacement", gap=1.2)}, out)
    assert (out / foreign).read_text(encoding="utf-8") == "mine"
    assert json.loads((out / "verdict.json").read_text(encoding="utf-8"))[0]["verdict"] == "pass"
    assert not list(out.glob(".*"))


def test_a_folder_without_results_is_refused_and_one_with_results_is_not(tmp_path):
    (tmp_path / "notes.txt").write_text("mine", encoding="utf-8")
    with pytest.raises(
        ProblemError, match=r"'notes\.txt' and no results; name a folder of its own"
    ):
        report.refuse_unwritable(tmp_path, ["poisson"])
    report.publish({"poisson": files()}, tmp_path)
    report.refuse_unwritable(tmp_path, ["poisson"])


@pytest.mark.parametrize("foreign", ["notes.txt", "my.csv", "thesis/chapter.txt"])
def test_files_of_other_people_in_a_studys_folder_are_refused(foreign, tmp_path):
    out = tmp_path / "r"
    for written in (False, True):  # beside no results, and beside results
        if written:
            shutil.rmtree(out)
            report.publish({"poisson": files()}, out)
        (out / "poisson" / foreign).parent.mkdir(parents=True, exist_ok=True)
        (out / "poisson" / foreign).write_text("mine", encoding="utf-8")
        for act in (
            lambda: report.refuse_unwritable(out, ["poisson"]),
            lambda: report.publish({"poisson": files()}, out),
        ):
            with pytest.raises(ProblemError, match="no run wrote poisson/"):
                act()
        assert (out / "poisson" / foreign).read_text(encoding="utf-8") == "mine"


def test_folders_that_only_look_like_ours_stay(tmp_path):
    mine = tmp_path / f"{exchange.STAGED}mine"
    mine.mkdir()
    report.publish({"poisson": files()}, tmp_path / "r")
    assert mine.is_dir()


def test_what_was_put_aside_is_put_back(tmp_path, monkeypatch):
    """A run killed between two renames: the next one finds what it put aside."""
    monkeypatch.setattr(exchange, "exchange_folders", lambda *_: False)
    out = tmp_path / "r"
    report.publish({"poisson": files()}, out)
    (out / "poisson").rename(out / f"{exchange.ASIDE}poisson")
    report.publish({"displacement": files("displacement")}, out)
    assert [study.name for study in report.stored_studies(out)] == ["displacement", "poisson"]
    assert not list(out.glob(".*"))


def test_the_folders_mode_stays(tmp_path):
    out = tmp_path / "r"
    report.publish({"poisson": files()}, out)
    out.chmod(0o700)
    report.publish({"poisson": files()}, out)
    assert out.stat().st_mode & 0o777 == 0o700


def test_results_in_the_current_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for gap in (2.0, 1.2):
        report.publish({"poisson": files(gap=gap)}, Path())
        assert Path("poisson/line.csv").is_file(), "the ground is still there"


def test_where_folders_cannot_be_exchanged(tmp_path, monkeypatch):
    monkeypatch.setattr(exchange, "exchange_folders", lambda *_: False)
    out = tmp_path / "r"
    for gap in (2.0, 1.2):
        report.publish({"poisson": files(gap=gap)}, out)
    assert json.loads((out / "verdict.json").read_text(encoding="utf-8"))[0]["verdict"] == "pass"
    assert not list(tmp_path.glob(".*"))
    assert not list(out.glob(".*"))


def said(key, value, text=None):
    """What puts another value, or text in its place, into `study.json`."""

    def damage(folder):
        about = json.loads((folder / "study.json").read_text(encoding="utf-8")) | {key: value}
        changed = json.dumps(about)
        if text:
            changed = changed.replace(f'"{key}": {value}', f'"{key}": {text}')
        (folder / "study.json").write_text(changed, encoding="utf-8")

    return damage


def judged(column, value):
    """What puts a value into `verdict.csv`."""

    def damage(folder):
        table = pd.read_csv(folder / "verdict.csv").astype(object)
        table[column] = value
        table.to_csv(folder / "verdict.csv", index=False)

    return damage


def in_place(name, make):
    """What puts something else in a file's place."""

    def damage(folder):
        (folder / name).unlink()
        make(folder / name)

    return damage


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda f: (f / "line.csv").unlink(), "line.csv is missing; run it again"),
        (lambda f: (f / "study.json").write_text("{}"), "not what a run writes"),
        (lambda f: (f / "study.json").write_text("["), "not what a run writes"),
        (lambda f: (f / "verdict.csv").write_text("a\n1\n"), "verdict.csv: Object missing"),
        (said("question", None), "study.json: Expected `str`, got `null` - at `$.question`"),
        (said("findings", 3), "Expected `array`, got `int` - at `$.findings`"),
        (said("columns", {"x": [1]}), "Expected `str`, got `array` - at `$.columns[...]`"),
        (said("captions", []), "Expected `object`, got `array` - at `$.captions`"),
        (said("tables", ["../line"]), "study.json: Expected `str` matching regex"),
        (said("question", "\ud800"), "study.json: "),
        (said("more", 0, "[" * 10**6 + "]" * 10**6), "study.json: "),
        (lambda f: (f / "study.json").write_bytes(b'{"question": "\xff'), "study.json: "),
        (judged("observed", "wide"), "verdict.csv: Expected `float`, got `str`"),
        (judged("verdict", "maybe"), "verdict.csv: Invalid enum value 'maybe'"),
        (lambda f: (f / "line.csv").write_text("x\n1,2\n"), "line.csv: row 0 has 2 values for 1"),
        (lambda f: (f / "line.csv").write_bytes(b"x\n\xff\n"), "line.csv: 'utf-8' codec"),
        (lambda f: (f / "line.csv").write_bytes(b""), "line.csv: not even a heading"),
        (in_place("line.csv", os.mkfifo), "line.csv is no file"),
        (in_place("line.svg", os.mkdir), "line.svg is no file"),
        (in_place("line.csv", lambda p: p.symlink_to(p.name)), "Too many levels of symbolic"),
        (lambda f: (f / "line.svg").unlink(), "line.svg is missing; run it again"),
    ],
)
def test_damaged_results_are_named_and_cost_no_others(damage, message, tmp_path):
    out = tmp_path / "r"
    report.publish({"poisson": files()}, out)
    damage(out / "poisson")
    report.publish({"displacement": files("displacement", gap=1.2, plots=False)}, out)
    fresh, study = report.rebuild(out)
    assert fresh.held
    assert message in study.error
    assert "\n" not in study.error
    good, bad = json.loads((out / "verdict.json").read_text(encoding="utf-8"))
    assert (good["study"], good["verdict"]) == ("displacement", "pass")
    assert (bad["study"], bad["quantity"]) == ("poisson", "study finished")
    assert str(tmp_path) not in (out / "report.html").read_text(encoding="utf-8")


def test_a_study_whose_list_of_files_is_damaged_is_not_replaced(tmp_path):
    report.publish({"poisson": files()}, tmp_path / "r")
    (tmp_path / "r" / "poisson" / "study.json").write_text('{"files": 3}', encoding="utf-8")
    with pytest.raises(ProblemError, match=r"poisson/study.json is damaged, so what lies beside"):
        report.refuse_unwritable(tmp_path / "r", ["poisson"])


def test_unwritable_places(tmp_path):
    file = tmp_path / "file"
    file.touch()
    with pytest.raises(ProblemError, match="is a file; name a folder"):
        report.refuse_unwritable(file / "below")
    report.refuse_unwritable(tmp_path / "not" / "yet" / "there")
    assert not (tmp_path / "not").exists(), "asking leaves nothing"
    with pytest.raises(ProblemError, match="name another folder"):
        report.refuse_unwritable(Path("/proc/nowhere"))


def test_provenance_names_no_host_user_or_path():
    now = datetime.now(UTC)
    origin = provenance.collect_provenance(["python", "-m", "x"], 3, now, 1.5, form="quick")
    labels = "msvalidate Python libraries processor system seed form command time"
    assert list(origin) == labels.split()
    text = " ".join(origin.values())
    assert socket.gethostname() not in text
    assert str(Path.home()) not in text
    assert getpass.getuser() not in text.split()
