"""The baseline: what has moved is told, with value, reference, error and limit."""

import errno
import gc
import os
from pathlib import Path
from types import SimpleNamespace

import pandas as pd
import pytest

from msvalidate.bench.judging import catalogue
from msvalidate.bench.judging.evidence import Evidence, Observed, Tolerance
from msvalidate.bench.output import baseline, screen
from msvalidate.cli import program
from msvalidate_check import exchange
from msvalidate_check.baseline import HEADING, differences
from tests.table import table, undated

TABLE = pd.DataFrame(
    {
        "name": ["a", "b", "c"],
        "x": [1e6, -2.0, 3e-7],
        "order": ["not asymptotic", 1.5, 2.0],
        "steps_per_second": [1.0, 2.0, 3.0],
    }
)
MEANING = {c: c for c in (*TABLE, "more")} | {"order": 'power; "not asymptotic" or "none"'}


def evidence(tables, **more):
    return Evidence(tables, {}, (), columns=MEANING, **more)


def changed(column, row, value):
    table = TABLE.copy()
    table[column] = table[column].astype(object)
    table.loc[row, column] = value
    return table


@pytest.fixture
def kept(tmp_path):
    """A folder that keeps the table, and what is then missed with another."""
    for name, content in baseline.baseline_files({"t": TABLE}).items():
        (tmp_path / name).write_bytes(content)

    def missed(table=TABLE, **more):
        found = evidence({"t": table}, **more)
        rows = baseline.compare(found.tables, tmp_path, found.rounding)
        assert {(row["layer"], row["quantity"]) for row in rows} == {("baseline", "t.csv")}
        return [row["because"] for row in rows if row["verdict"] != "pass"]

    missed.folder = tmp_path
    return missed


def test_the_limit_of_each_value_is_where_it_is_said_to_be(kept):
    room = 1e-9 * (1e6 + 2)  # of the column's range
    for move, held in ((0.99, True), (1.01, False), (-1.01, False)):
        assert (kept(changed("x", 1, -2 + move * (room + 2e-6))) == []) == held
        assert (kept(changed("x", 0, 1e6 + move * (room + 1.0))) == []) == held
        wide = kept(changed("x", 2, 3e-7 + move * (room + 0.1)), rounding={"x": 0.1})
        assert (wide == []) == held
    both = changed("x", 0, 1e6 + 0.9)
    both.loc[1, "x"] = -2.01
    (line,) = kept(both)
    assert line.startswith("x, row 1: was -2.0, is -2.01, moved by 0.01 (0.5 %), allowed 0.001")


@pytest.mark.parametrize(
    ("table", "said"),
    [
        (changed("name", 0, "A"), "name, row 0: was a, is A; words are exact"),
        (changed("order", 0, "none"), "order, row 0: was not asymptotic, is none"),
        (changed("order", 1, "none"), "order, row 1: was 1.5, is none"),
        (changed("order", 0, 1.5), "order, row 0: was not asymptotic, is 1.5"),
        (TABLE.head(2), "rows: were 3, are 2"),
        (TABLE.assign(more=1), "column more: new"),
        (TABLE.drop(columns="x"), "column x: missing"),
    ],
)
def test_what_differs_is_told(kept, table, said):
    (line,) = kept(table)
    assert line.startswith(said)


@pytest.mark.parametrize("value", ["nan", "", "inf", "-inf", "NaN"])
def test_no_number_is_never_held(kept, value):
    path = kept.folder / "t.csv"
    path.write_text(path.read_text().replace("-2.0", value))
    (line,) = kept()
    assert line.startswith(f"x, row 1: was {value}, is -2.0")


def test_an_empty_table_is_as_it_was():
    assert differences({"x": []}, {"x": []}) == []


def test_tables_that_are_new_missing_or_damaged(kept):
    (kept.folder / "u.csv").write_text("x\n1\n1,2,3\n")
    (kept.folder / "v.csv").write_text("")
    tables = dict.fromkeys("tuw", TABLE)
    rows = baseline.compare(tables, kept.folder, {})
    assert [(row["quantity"], row["verdict"], row["because"]) for row in rows[1:]] == [
        ("u.csv", "fail", "the baseline cannot be read: row 1 has 3 values for 1 columns"),
        ("v.csv", "fail", "the table is missing"),
        ("w.csv", "fail", "the table is new"),
    ]
    assert baseline.compare(tables, kept.folder / "none", {}) == [], "nothing to compare"


# --- check of some studies ------------------------------------------------------------------------

STUDIES = ["damping", "poisson", "stability"]


class Checkout:
    """A checkout with three studies of one table; `x` is its value that moves."""

    def __init__(self, folder):
        self.quick, self.reasons = folder / "base" / "quick", folder / "base" / "REASONS.md"
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
    (tmp_path / "pyproject.toml").touch()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(catalogue, "names", lambda: STUDIES)
    monkeypatch.setattr(catalogue, "load", made.load)
    monkeypatch.setattr(gc, "freeze", lambda: None)
    monkeypatch.setattr(screen, "bibliography", dict)  # a wheel has it below HOME
    monkeypatch.setattr(baseline, "HOME", tmp_path / "package")
    monkeypatch.setattr(baseline, "CHECKOUT", tmp_path / "base")
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
    assert [line.partition(": FAIL t.csv: ")[0] for line in missed] == run


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
    reasons = undated(checkout.reasons.read_text("utf-8"))
    assert "- baseline (quick; stability, damping): so; stability/t: x, row 0: was 1.0" in reasons
    assert "quick baseline of stability, damping renewed" in capsys.readouterr().err


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
    assert {p.name for p in checkout.quick.parent.iterdir()} == {"quick", "REASONS.md"}


def test_an_installed_package_keeps_its_own_baseline(checkout, capsys):
    Path("pyproject.toml").unlink()
    assert checkout.check("poisson", "--update", "--reason", "so") == (2, [])
    assert "own baseline stays; give --baseline DIR" in capsys.readouterr().err


# --- a baseline of one's own ----------------------------------------------------------------------


def test_a_baseline_of_ones_own_takes_the_place_of_ours(checkout, capsys):
    ours, said = checkout.files(), checkout.reasons.read_bytes()
    own, checkout.x = Path("mine") / "base", 2.0
    at = ("--baseline", str(own))
    assert checkout.check("poisson", *at) == (2, [])
    assert 'make one by adding --update --reason "first"' in capsys.readouterr().err
    assert checkout.check("poisson", "--update", "--reason", "so", *at)[0] == 0
    (own / "pytest").mkdir()
    (own / "pytest" / "tip.csv").write_bytes(b"u\n1\n")
    assert checkout.check("damping", "--update", "--reason", "more", *at)[0] == 0
    lines = ("poisson): so; poisson/t is new", "damping): more; damping/t is new")
    reasons = "".join(f"- baseline (quick; {line}\n" for line in lines)
    assert undated((own / "REASONS.md").read_text("utf-8")) == HEADING + reasons
    assert {p.relative_to(own).as_posix(): p.read_bytes() for p in own.rglob("*.csv")} == {
        "pytest/tip.csv": b"u\n1\n",
        "quick/damping/t.csv": b"x\n2.0\n",
        "quick/poisson/t.csv": b"x\n2.0\n",
    }
    assert checkout.check("poisson", "damping", *at)[0] == 0
    checkout.x = 2.1
    assert checkout.check("poisson", *at)[0] == 1
    assert (checkout.files(), checkout.reasons.read_bytes()) == (ours, said)


@table(("options", "said"), [
    (["--baseline", "pyproject.toml"], "--baseline pyproject.toml: a file; name a folder"),
    (["--baseline", "reports"], "shares a folder with --out reports/latest; name another"),
    (["--baseline", "reports/latest/b"], "shares a folder with --out reports/latest"),
    (["--baseline", "./base"], "--baseline base: our own; leave --baseline out"),
    (["--baseline", "pyproject.toml/b", "--update", "--reason", "so"], "no permission to write"),
    (["--baseline", "odd", "--update", "--reason", "so"], "REASONS.md: not UTF-8 at byte 0"),
])  # fmt: skip
def test_no_place_for_a_baseline_is_told_before_the_work(checkout, capsys, options, said):
    Path("odd").mkdir(exist_ok=True)
    Path("odd/REASONS.md").write_bytes(b"\xe9")
    assert checkout.check("poisson", *options) == (2, [])
    (line,) = capsys.readouterr().err.splitlines()
    assert said in line
    assert list(Path("odd").iterdir()) == [Path("odd/REASONS.md")]
