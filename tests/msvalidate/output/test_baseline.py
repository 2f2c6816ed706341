"""The baseline: what has moved is told, with value, reference, error and limit."""

import errno
import io
import os
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from msvalidate.cli import program
from msvalidate.judging import catalogue
from msvalidate.judging.evidence import Evidence, Observed, Tolerance
from msvalidate.output import baseline, report, stored
from msvalidate_check import exchange
from msvalidate_check.baseline import HEADING
from tests.table import table

TABLE = pd.DataFrame(
    {
        "name": ["a", "b", "c"],
        "x": [1.0, -2.0, 3e-7],
        "order": [1.5, "not asymptotic", 2.0],
        "n": [1, 2, 3],
        "steps_per_second": [1.0, 2.0, 3.0],
    }
)
MEANING = {c: c for c in TABLE} | {"order": 'power; "not asymptotic" where there is none'}


def text(table):
    return stored.read_csv(io.BytesIO(stored.csv_bytes(table.drop(columns="steps_per_second"))))


def failures(table=TABLE, reference=None, rounding=None):
    reference = text(TABLE) if reference is None else reference
    rows = baseline.compare_tables("t", table, reference, rounding or {})
    return {row["quantity"]: row for row in rows if row["verdict"] != "pass"}


def changed(column, row, value):
    table = TABLE.copy()
    table[column] = table[column].astype(object)
    table.loc[row, column] = value
    return table


def test_the_same_table_holds():
    assert failures() == {}
    rows = baseline.compare_tables("t", TABLE, text(TABLE), {})
    assert [row["quantity"] for row in rows] == [
        "t.csv: columns: missing or extra",
        "t.csv: rows",
        *("t.csv: name", "t.csv: x", "t.csv: order", "t.csv: n"),
    ]
    assert {row["layer"] for row in rows} == {"baseline"}


def test_a_moved_number_is_told():
    row = failures(changed("x", 1, -2.00001))["t.csv: x"]
    assert (row["observed"], row["reference"]) == (-2.00001, -2.0)
    assert row["error"] == pytest.approx(1e-5)
    assert row["limit"] == pytest.approx(2e-6, rel=1e-2)
    assert row["because"].startswith("row 1: ")


@pytest.mark.parametrize(
    ("value", "held"), [(-2 - 1.9e-6, True), (-2 - 2.1e-6, False), (-2 + 2.1e-6, False)]
)
def test_the_limit_is_where_it_is_said_to_be(value, held):
    assert (failures(changed("x", 1, value)) == {}) == held


def test_near_zero_the_columns_range_counts():
    assert failures(changed("x", 2, 3e-7 + 2.9e-9)) == {}
    assert "t.csv: x" in failures(changed("x", 2, 3e-7 + 3.5e-9))


def test_rounding_of_a_column():
    spoilt = changed("x", 2, 4e-7)
    assert "t.csv: x" in failures(spoilt)
    assert failures(spoilt, rounding={"x": 2e-7}) == {}


@pytest.mark.parametrize(
    ("column", "row", "value"),
    [
        ("name", 0, "A"),
        ("order", 1, "none"),
        ("order", 1, 1.5),
        ("order", 0, "not asymptotic"),
        ("n", 2, 4),
    ],
)
def test_words_are_exact(column, row, value):
    assert list(failures(changed(column, row, value))) == [f"t.csv: {column}"]


def test_a_word_before_numbers():
    table = TABLE.assign(order=["not asymptotic", 1.5, 2.0])
    assert failures(table, text(table)) == {}


def test_what_depends_on_the_machine_is_left_out():
    assert failures(changed("steps_per_second", 0, 99.0)) == {}


@pytest.mark.parametrize("value", ["nan", "", "inf", "-inf", "NaN"])
def test_no_number_is_never_held(value):
    """Not even where both sides have it."""
    reference = text(TABLE)
    reference.loc[1, "x"] = value
    assert "t.csv: x" in failures(reference=reference)
    both = changed("x", 1, np.nan)
    assert "t.csv: x" in failures(both, reference)


def test_a_missing_row_column_and_nothing_at_all():
    assert list(failures(TABLE.head(2))) == ["t.csv: rows"]
    assert list(failures(TABLE.assign(more=1))) == ["t.csv: columns: missing or extra"]
    found = failures(TABLE.drop(columns="x"))["t.csv: columns: missing or extra"]
    assert found["because"].endswith("missing: x")
    assert "t.csv: rows" in failures(TABLE.head(0), text(TABLE).head(0))


def evidence(tables):
    return Evidence(tables, {}, (), columns=MEANING)


def test_tables_of_a_study(tmp_path):
    for name, content in baseline.baseline_files(evidence({"t": TABLE})).items():
        (tmp_path / name).write_bytes(content)
    assert (tmp_path / "t.csv").read_text().startswith("name,x,order,n\n")
    rows = baseline.compare(evidence({"t": TABLE}), tmp_path)
    assert {row["verdict"] for row in rows} == {"pass"}
    first, *_ = baseline.compare(evidence({"t": TABLE, "u": TABLE}), tmp_path)
    assert (first["verdict"], first["because"][-8:]) == ("fail", "extra: u")
    assert baseline.compare(evidence({"t": TABLE}), tmp_path / "none") == []
    (tmp_path / "t.csv").rename(tmp_path / "u.csv")
    assert baseline.compare(evidence({"t": TABLE}), tmp_path)[0]["because"].endswith(
        "missing: u; extra: t"
    )
    (tmp_path / "u.csv").unlink()
    assert baseline.compare(evidence({"t": TABLE}), tmp_path) == [], "nothing to compare with"


@pytest.mark.parametrize(
    ("before", "after"),
    [
        (
            "# C\n\n## Unreleased\n\n### Added\n",
            "### Numbers\n\n- Baseline (quick): so\n\n### Added\n",
        ),
        (
            "## Unreleased\n\n### Numbers\n\n- old\n\n## 1\n",
            "### Numbers\n\n- Baseline (quick): so\n- old\n\n## 1\n",
        ),
        (
            "## Unreleased\n\n## 1\n\n### Numbers\n\n- old\n",
            "### Numbers\n\n- Baseline (quick): so\n\n## 1\n\n### Numbers\n\n- old\n",
        ),
    ],
)
@pytest.mark.parametrize("end", [b"\n", b"\r\n"])
def test_a_line_in_the_changelog(before, after, end, tmp_path, monkeypatch):
    place = tmp_path / "CHANGELOG.md"
    place.write_bytes(before.encode().replace(b"\n", end))
    monkeypatch.setattr(baseline, "CHANGELOG", place)
    wanted = f"## Unreleased\n\n{after}".encode().replace(b"\n", end)
    assert baseline.changelog_entry("quick", "so").endswith(wanted)


def test_a_line_in_the_changelog_names_studies(tmp_path, monkeypatch):
    place = tmp_path / "CHANGELOG.md"
    place.write_text("## Unreleased\n", encoding="utf-8")
    monkeypatch.setattr(baseline, "CHANGELOG", place)
    line = "- Baseline (quick; stability, damping): so\n"
    assert line in baseline.changelog_entry("quick", "so", ["stability", "damping"]).decode()


# --- check of some studies ------------------------------------------------------------------------

STUDIES = ["damping", "poisson", "stability"]


class Checkout:
    """A checkout with three studies of one table; `x` is its value that moves."""

    def __init__(self, folder):
        self.quick, self.changelog = folder / "base" / "quick", folder / "CHANGELOG.md"
        self.x, self.ran = 1.0, []

    def load(self, name):
        def run(setting):
            if not setting.quick:
                raise AssertionError("check runs the small form")
            self.ran.append(name)
            return Evidence(
                {"t": pd.DataFrame({"x": [self.x]})},
                {"gap": Observed(0.0)},
                (Tolerance("gap", 0.5, "m", "so"),),
                columns={"x": "m"},
            )

        return SimpleNamespace(__doc__="?", run=run)

    def check(self, *arguments):
        """Run a check; its exit code and the studies that it ran."""
        self.ran = []
        return program.main(["check", "-q", *arguments]), self.ran

    def files(self):
        return {p.relative_to(self.quick): p.read_bytes() for p in self.quick.rglob("*.*")}


@pytest.fixture
def checkout(tmp_path, monkeypatch):
    """With a baseline of its own, renewed by the command itself."""
    made = Checkout(tmp_path)
    made.changelog.write_text("## Unreleased\n", encoding="utf-8")
    (tmp_path / "pyproject.toml").touch()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(catalogue, "names", lambda: STUDIES)
    monkeypatch.setattr(catalogue, "load", made.load)
    monkeypatch.setattr(program.gc, "freeze", lambda: None)
    monkeypatch.setattr(baseline, "HOME", tmp_path / "package")
    monkeypatch.setattr(baseline, "CHECKOUT", tmp_path / "base")
    monkeypatch.setattr(baseline, "CHANGELOG", made.changelog)
    assert made.check("--update", "--reason", "first") == (0, STUDIES)
    return made


@pytest.mark.parametrize(
    ("names", "run"),
    [
        ([], STUDIES),
        (["all"], STUDIES),
        (["stability"], ["stability"]),
        (["stability", "damping", "stability"], ["stability", "damping"]),
    ],
)
def test_check_runs_what_is_named(names, run, checkout, capsys):
    assert checkout.check(*names) == (0, run)
    checkout.x = 1.1
    assert checkout.check(*names) == (1, run)
    missed = capsys.readouterr().err.splitlines()
    assert [line.partition(": FAIL t.csv: x")[0] for line in missed] == run


def test_update_renews_the_named_studies_only(checkout, capsys):
    # Not as `files` would write it, beside what is none of its affair.
    (checkout.quick / "poisson" / "t.csv").write_bytes(b"x\r\n1.00")
    (checkout.quick / "oldstudy" / "deep").mkdir(parents=True)
    (checkout.quick / "oldstudy" / "deep" / "t.csv").write_bytes(b"\xff\n")
    (checkout.quick / "notes.txt").write_bytes(b"mine")
    (checkout.quick / "damping" / "gone.csv").write_bytes(b"y\n1\n")
    before, checkout.x = checkout.files(), 2.0
    done = checkout.check("stability", "--update", "--reason", "so", "damping")
    assert done == (0, ["stability", "damping"])
    renewed = {Path(name, "t.csv"): b"x\n2.0\n" for name in ("stability", "damping")}
    before.pop(Path("damping", "gone.csv"))
    assert checkout.files() == before | renewed
    assert "- Baseline (quick; stability, damping): so\n" in checkout.changelog.read_text("utf-8")
    assert "quick baseline of stability, damping renewed" in capsys.readouterr().err


def test_strangers_are_the_affair_of_all_studies_only(checkout, capsys):
    (checkout.quick / "oldstudy").mkdir()
    (checkout.quick / "oldstudy" / "t.csv").write_bytes(b"x\n1.0\n")
    assert checkout.check("poisson") == (0, ["poisson"])
    assert "oldstudy" not in capsys.readouterr().err
    assert checkout.check("all") == (4, STUDIES)
    assert "quick baseline: oldstudy is no study" in capsys.readouterr().err
    assert checkout.check("all", "--update", "--reason", "so") == (0, STUDIES)
    assert sorted(p.name for p in checkout.quick.iterdir()) == STUDIES
    assert "- Baseline (quick): so\n" in checkout.changelog.read_text("utf-8")


def test_a_first_baseline_of_one_study(checkout, capsys):
    exchange.replace_folder(checkout.quick, {})
    assert checkout.check("poisson") == (4, ["poisson"])
    assert "make one with check poisson --update" in capsys.readouterr().err
    assert checkout.check("poisson", "--update", "--reason", "so") == (0, ["poisson"])
    assert list(checkout.files()) == [Path("poisson", "t.csv")]


def test_a_full_disk_leaves_the_baseline_of_all_as_it_was(checkout, monkeypatch, capsys):
    before, checkout.x = checkout.files(), 2.0
    no = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    def full(folder, files, write=exchange.write):
        if folder.parent.parent == checkout.quick.parent:
            raise no
        write(folder, files)

    monkeypatch.setattr(exchange, "write", full)
    assert checkout.check("poisson", "--update", "--reason", "so")[0] == 2
    assert "No space left on device" in capsys.readouterr().err
    assert checkout.files() == before
    assert [p.name for p in checkout.quick.parent.iterdir()] == ["quick"]


# --- a baseline of one's own ----------------------------------------------------------------------


def test_a_baseline_of_ones_own_takes_the_place_of_ours(checkout, capsys):
    ours, said = checkout.files(), checkout.changelog.read_bytes()
    own, checkout.x = Path("mine") / "base", 2.0
    at = ("--baseline", str(own))
    assert checkout.check("poisson", *at) == (4, ["poisson"])
    assert "check poisson --update --baseline mine/base" in capsys.readouterr().err
    assert checkout.check("poisson", "--update", "--reason", "so", *at)[0] == 0
    (own / "pytest").mkdir()
    (own / "pytest" / "tip.csv").write_bytes(b"u\n1\n")
    assert checkout.check("damping", "--update", "--reason", "more", *at)[0] == 0
    assert {p.relative_to(own).as_posix(): p.read_bytes() for p in own.rglob("*.*")} == {
        "REASONS.md": HEADING.encode()
        + b"- Baseline (quick; poisson): so\n- Baseline (quick; damping): more\n",
        "pytest/tip.csv": b"u\n1\n",
        "quick/damping/t.csv": b"x\n2.0\n",
        "quick/poisson/t.csv": b"x\n2.0\n",
    }
    assert checkout.check("poisson", "damping", *at)[0] == 0
    checkout.x = 2.1
    assert checkout.check("poisson", *at)[0] == 1
    assert (checkout.files(), checkout.changelog.read_bytes()) == (ours, said)


@table(
    ("options", "said"),
    [
        (["--baseline", "CHANGELOG.md"], "--baseline CHANGELOG.md: a file; name a folder"),
        (["--baseline", "reports"], "shares a folder with --out reports/latest; name another"),
        (["--baseline", "reports/latest/b"], "shares a folder with --out reports/latest"),
        (["--baseline", "./base"], "--baseline base: our own; leave --baseline out"),
        (["--baseline", "CHANGELOG.md/b", "--update", "--reason", "so"], "no permission to write"),
        (["--baseline", "odd", "--update", "--reason", "so"], "REASONS.md: not UTF-8 at byte 0"),
    ],
)
def test_no_place_for_a_baseline_is_told_before_the_work(checkout, capsys, options, said):
    Path("odd").mkdir(exist_ok=True)
    Path("odd/REASONS.md").write_bytes(b"\xe9")
    assert checkout.check("poisson", *options) == (2, [])
    (line,) = capsys.readouterr().err.splitlines()
    assert said in line
    assert list(Path("odd").iterdir()) == [Path("odd/REASONS.md")]


def test_a_reason_stands_before_its_numbers_move(checkout, monkeypatch):
    """Ended, as by a kill, before each step in turn that changes a file or folder."""
    at, count, end = ("poisson", "--update", "--baseline", "own", "--reason"), 0, 99
    assert checkout.check(*at, "first")[0] == 0
    table, log = Path("own/quick/poisson/t.csv"), Path("own/REASONS.md")
    before, said = table.read_bytes(), log.read_bytes()

    def counted(act):
        def step(*given):
            nonlocal count
            count += 1
            if count == end:
                raise KeyboardInterrupt
            return act(*given)

        return step

    for module, name in ((os, "fsync"), (exchange, "exchange_folders"), (exchange, "replace")):
        monkeypatch.setattr(module, name, counted(getattr(module, name)))
    monkeypatch.setattr(report, "publish", lambda *_: [])
    found, checkout.x = [], 2.0
    for step in range(1, 20):
        count, end = 0, step
        try:
            done = checkout.check(*at, "moved")
        except KeyboardInterrupt:
            done = None
        found.append((table.read_bytes() != before, log.read_bytes() != said))
        if done:
            break
        table.write_bytes(before)
        log.write_bytes(said)
    assert (found[-1], len(found) > 4) == ((True, True), True)
    assert (True, False) not in found, "a number never moves without a reason"
    assert found.count((False, True)) <= 2, "the rename, and the exchange in it"
    assert {path.name for path in Path("own").iterdir()} == {"REASONS.md", "quick"}
