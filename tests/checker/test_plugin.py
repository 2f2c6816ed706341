"""Numbers of a user's tests are held to those kept; a number moves only with a reason, or not."""

from __future__ import annotations

import errno
import os

import numpy as np
import pandas as pd
import pytest

from msvalidate_check import exchange
from msvalidate_check.baseline import HEADING, make_columns
from tests.table import stored_rows, table, undated

PLUGIN = ("-p", "msvalidate_check.pytest_plugin", "-p", "xdist", "-p", "no:cacheprovider")
FOLDER = ("--msvalidate-baseline", "base")
UPDATE = (*FOLDER, "--msvalidate-update", "--msvalidate-reason", "so")
TESTS = """
import numpy as np
def test_tip(msvalidate_baseline):
    msvalidate_baseline.check("tip", {"u": 1e-4, "kind": "tet4"})
def test_rows(msvalidate_baseline):
    u = np.array([0.5, 0.25, -2.0])
    msvalidate_baseline.check("rows", {"x": [0, 1, 2], "u": u}, relative=1e-3)
"""


@pytest.fixture
def project(pytester, monkeypatch):
    """A folder with two tests and their baseline, and how to run them there."""
    monkeypatch.delenv("PYTEST_ADDOPTS", raising=False)
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")  # ten times as fast
    (pytester.path / "base/quick/bar").mkdir(parents=True)
    (pytester.path / "base/quick/bar/t.csv").write_text("x\n1\n", encoding="utf-8")

    def run(*options, tests=TESTS):
        pytester.path.joinpath("test_mine.py").write_text(tests, encoding="utf-8")
        return pytester.runpytest_inprocess(*PLUGIN, *options)

    run.folder = pytester.path / "base"
    run.files = lambda: {
        path.relative_to(run.folder).as_posix(): undated(path.read_text(encoding="utf-8"))
        for path in sorted(run.folder.rglob("*"))
        if path.is_file()
    }
    run.first = run(*UPDATE)
    return run


def test_first_numbers_are_written_with_their_reason(project):
    project.first.assert_outcomes(passed=2)
    project.first.stdout.fnmatch_lines(["baseline renewed: rows, tip; REASONS.md says why"])
    assert project.files() == {
        "REASONS.md": f"{HEADING}- baseline (pytest; rows, tip): so; rows is new; tip is new\n",
        "pytest/rows.csv": "x,u\n0,0.5\n1,0.25\n2,-2.0\n",
        "pytest/tip.csv": "u,kind\n0.0001,tet4\n",
        "quick/bar/t.csv": "x\n1\n",
    }
    project(*FOLDER).assert_outcomes(passed=2)


def test_columns_of_any_kind_are_kept_with_all_their_digits():
    frame = pd.DataFrame({"word": ["a", "b"], "n": [1, 2], "third": np.ones(2, "f4") / 3})
    columns = make_columns("t", dict(frame) | {"is": [True, False], "wide": [1, np.longdouble(2)]})
    assert columns == {
        "word": ["a", "b"],
        "n": ["1", "2"],
        "third": ["0.3333333432674408"] * 2,
        "is": ["True", "False"],
        "wide": ["1.0", "2.0"],
    }


@table(("old", "new", "said"), stored_rows("recorded_numbers"))  # fmt: skip
def test_what_moved_or_cannot_be_kept_is_told(project, old, new, said):
    done = project(*FOLDER, "--tb=short", tests=TESTS.replace(old, new))
    assert done.ret == pytest.ExitCode.TESTS_FAILED
    assert said in done.stdout.str()
    assert "pytest_plugin.py" not in done.stdout.str(), "the failure is shown where the test is"
    moved = "BaselineError" not in done.stdout.str()
    how = 'pytest --msvalidate-baseline base --msvalidate-update --msvalidate-reason "why"'
    assert (how in done.stdout.str()) == moved


def test_within_its_limit_nothing_moves(project):
    before = project.files()
    near = TESTS.replace("0.25", "0.2501").replace("1e-4", "1.0000005e-4")
    project(*FOLDER, tests=near).assert_outcomes(passed=2)
    done = project(*UPDATE, tests=near)
    done.stdout.fnmatch_lines(["baseline left as it was: no number moved"])
    assert project.files() == before


def test_only_what_moved_is_renewed_and_only_if_all_passes(project):
    before, moved = project.files(), TESTS.replace("1e-4", "2e-4")
    done = project(*UPDATE, tests=moved + "def test_other(): assert False\n")
    assert done.ret == pytest.ExitCode.TESTS_FAILED
    done.stdout.fnmatch_lines(["baseline left as it was: not all tests passed; mend that first"])
    assert project.files() == before
    assert project(*UPDATE, "-k", "tip", tests=moved).ret == 0
    line = "- baseline (pytest; tip): so; tip: u, row 0: was 0.0001, is 0.0002, moved by 0.0001 "
    line += "(100 %), allowed 1e-10\n"
    renewed = {"pytest/tip.csv": "u,kind\n0.0002,tet4\n", "REASONS.md": before["REASONS.md"] + line}
    assert project.files() == before | renewed


@table(
    ("options", "said"),
    [
        ([*FOLDER, "--msvalidate-update"], "go together; give both or none"),
        ([*FOLDER, "--msvalidate-reason", "so"], "go together; give both or none"),
        ([*FOLDER, *UPDATE, "--msvalidate-reason", " "], "' '; say why in one line"),
        ([*UPDATE, "--msvalidate-reason", "a\nb"], "'a\\nb'; say why in one line"),
        (UPDATE[2:], "no folder to write to; give --msvalidate-baseline DIR"),
        (["--msvalidate-baseline", "test_mine.py"], "test_mine.py: a file; name a folder"),
        (["--msvalidate-baseline", ""], "'' is no folder; name one"),
        ([*UPDATE, "-n", "2"], "one process writes a baseline; leave -n and --dist out"),
    ],
)
def test_wrong_usage_is_one_line(project, options, said):
    before = project.files()
    done = project(*options)
    assert done.ret == pytest.ExitCode.USAGE_ERROR
    (line,) = [line for line in done.stderr.str().splitlines() if line.strip()]
    assert said in line
    assert project.files() == before


def test_a_damaged_file_fails_and_can_be_renewed(project):
    for damage, said in (
        (b"u,kind\n1\n", "the file cannot be read: row 0 has 1 values for 2 columns"),
        (b"u,kind\n", "rows: were 0, are 1"),
        (b"", "rows: were 0, are 1"),
        (b"\xff", "the file cannot be read: 'utf-8' codec can't decode byte*"),
        (b"u,kind\nnan,tet4\n", "u, row 0: was nan, is 0.0001; words are exact"),
    ):
        (project.folder / "pytest/tip.csv").write_bytes(damage)
        project(*FOLDER).stdout.fnmatch_lines([f"E* {said}"])
    assert project(*UPDATE).ret == 0
    project(*FOLDER).assert_outcomes(passed=2)


def test_reasons_that_cannot_be_added_to_leave_all_as_it_was(project):
    (project.folder / "REASONS.md").write_bytes(b"\xe9")
    done = project(*UPDATE, tests=TESTS.replace("1e-4", "2e-4"))
    assert done.ret == pytest.ExitCode.USAGE_ERROR
    done.stdout.fnmatch_lines(["baseline not written: REASONS.md: not UTF-8 at byte 0; save*"])
    assert (project.folder / "pytest/tip.csv").read_text(
        encoding="utf-8"
    ) == "u,kind\n0.0001,tet4\n"


def test_a_full_disk_leaves_all_as_it_was(project, monkeypatch):
    def full(folder, files, write=exchange.write):
        if files.keys() & {"REASONS.md"}:  # when the tables are staged
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), "REASONS.md")
        write(folder, files)

    before = project.files()
    monkeypatch.setattr(exchange, "write", full)
    done = project(*UPDATE, tests=TESTS.replace("1e-4", "2e-4"))
    assert done.ret == pytest.ExitCode.USAGE_ERROR
    done.stdout.fnmatch_lines(["baseline not written: No space left on device: REASONS.md; mend*"])
    assert project.files() == before


def test_the_folder_may_be_a_setting_and_must_be_somewhere(project, pytester):
    project().stdout.fnmatch_lines(["*no folder to look in; run pytest with*"])
    pytester.makeini("[pytest]\nmsvalidate_baseline = base\n")
    project().assert_outcomes(passed=2)
    done = project(tests=TESTS.replace("1e-4", "2e-4"))
    done.stdout.fnmatch_lines(
        ['*if that is meant: pytest --msvalidate-update --msvalidate-reason "why"']
    )


def test_tables_that_no_test_recorded_are_told(project):
    done = project(*FOLDER, "-k", "tip")
    done.stdout.fnmatch_lines(["baseline: no test of this run recorded rows"])
    assert "no test of this run" not in project(*FOLDER).stdout.str()


@pytest.mark.slow
@pytest.mark.usefixtures("project")
def test_workers_compare(pytester):
    done = pytester.runpytest_subprocess(*PLUGIN, *FOLDER, "-n", "2")
    done.assert_outcomes(passed=2)
    moved = TESTS.replace("1e-4", "2e-4")
    pytester.path.joinpath("test_mine.py").write_text(moved, encoding="utf-8")
    done = pytester.runpytest_subprocess(*PLUGIN, *FOLDER, "-n", "2")
    done.assert_outcomes(passed=1, failed=1)
    done.stdout.fnmatch_lines(["*u, row 0: was 0.0001, is 0.0002, moved by*"])


def test_files_and_folders_are_replaced_whole_and_a_folder_in_use_stays(tmp_path):
    exchange.replace_one(tmp_path / "one", {"x": b"1"})
    exchange.replace_file(tmp_path / "file", lambda: b"2")
    beside = tmp_path / "other" / "file"
    beside.parent.mkdir()
    exchange.replace_folder(tmp_path / "more", {"in": {"x": b"3"}}, beside=(beside, lambda: b"4"))
    written = [tmp_path / "one" / "x", tmp_path / "file", tmp_path / "more" / "in" / "x", beside]
    assert [path.read_bytes() for path in written] == [b"1", b"2", b"3", b"4"]
    with exchange.own_folder(tmp_path) as first, exchange.own_folder(tmp_path) as second:
        assert first.is_dir()
        assert second.is_dir()
