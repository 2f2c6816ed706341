"""The command line: what it prints where, its exit codes, and what bad input leaves behind."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PROGRAM = [sys.executable, "-m", "msvalidate.study"]


def run(*arguments, cwd=None, script=None):
    """Run the program in a folder of its own; with `script`, python code that calls it."""
    command = [sys.executable, "-c", script] if script else PROGRAM
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    return subprocess.run(
        [*command, *arguments],
        capture_output=True,
        text=True,
        cwd=cwd,
        env=environment,
        check=False,
        timeout=120,
    )


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    return run("poisson", "--quick", "--out", "results", "--seed", "7", cwd=folder), folder


def test_a_study_writes_its_files(finished):
    done, folder = finished
    assert done.returncode == 0, done.stderr
    written = {p.relative_to(folder / "results").as_posix() for p in folder.rglob("*.*")}
    tables = {"summary", "finite_size", "modulus", "reference", "direction", "incompressible"}
    tables |= {"drift", "algorithm1", "rest", "block", "resolution", "verdict"}
    tables |= {"rotated", "rotated_order"}
    pictures = {"finite_size", "direction", "drift", "rest", "block", "rotated"}
    expected = {f"poisson/{name}.csv" for name in tables} | {"report.md"}
    expected |= {f"poisson/{name}.{kind}" for name in pictures for kind in ("png", "svg")}
    assert written == expected


def test_tables_on_stdout_messages_on_stderr(finished):
    done, _ = finished
    assert "poisson/finite_size" in done.stdout
    assert "poisson/verdict" in done.stdout
    assert "poisson: held" in done.stderr
    assert "\r" not in done.stderr, "no progress bar off a terminal"


def test_report_tells_where_it_comes_from(finished):
    done, folder = finished
    page = (folder / "results" / "report.md").read_text(encoding="utf-8")
    assert "| command | python -m msvalidate.study poisson --quick --out DIR --seed 7 |" in page
    assert "| seed | 7 |" in page
    assert str(folder) not in page + done.stdout


def test_quiet_run_prints_nothing(tmp_path):
    done = run("poisson", "--quick", "-q", "--no-plots", "--out=r", cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    assert not list(tmp_path.rglob("*.png"))
    assert "--out=DIR" in (tmp_path / "r" / "report.md").read_text(encoding="utf-8")


def test_list_names_each_study_with_its_question():
    done = run("list")
    assert done.returncode == 0
    questions = dict(line.split(maxsplit=1) for line in done.stdout.splitlines())
    assert questions["poisson"].startswith("Poisson's ratio of a lattice")
    assert questions["displacement"].startswith("Displacement: how far")


def test_help_and_list_import_nothing_heavy():
    """Waiting for numpy before printing a help text is what users notice first."""
    script = (
        "import sys; from msvalidate import study\n"
        "try: study.main(sys.argv[1:])\n"
        "except SystemExit: pass\n"
        "import json; print(json.dumps(sorted(sys.modules)), file=sys.stderr)"
    )
    for arguments in (["--help"], ["list"]):
        done = run(*arguments, script=script)
        loaded = set(json.loads(done.stderr.splitlines()[-1]))
        assert not loaded & {"numpy", "scipy", "pandas", "matplotlib", "numba", "skfem", "tqdm"}


BAD_COMMANDS = [
    ([], "the following arguments are required: NAME"),
    (["poison"], "unknown study 'poison': did you mean 'poisson'?"),
    (["poisson", "qqqq"], "unknown study 'qqqq': choose from: "),
    (["POISSON"], "unknown study 'POISSON': did you mean 'poisson'?"),
    (["../poisson"], "unknown study '../poisson': did you mean 'poisson'?"),
    (["poisson\u202e"], "unknown study"),  # a mark that turns the writing direction
    (["poisson", "--seed", "-1"], "argument --seed: '-1' is not a whole number, 0 or more"),
    (["poisson", "--seed", "1.5"], "argument --seed: '1.5' is not a whole number, 0 or more"),
    (["poisson", "--seed", "nan"], "argument --seed: 'nan' is not a whole number, 0 or more"),
    (["poisson", "--sed", "1"], "unrecognized arguments: --sed"),
    (["poisson", "--ou", "x"], "unrecognized arguments: --ou"),
    (["poisson", "--out"], "argument --out: expected one argument"),
    (["poisson", "--out", ""], "argument --out: '' is no name; name a folder"),
    (["poisson", "-q", "-v"], "argument -v/--verbose: not allowed with argument -q/--quiet"),
    (["poisson", "--out", "taken"], "--out taken: taken is a file; name a folder"),
    (["poisson", "--out", "taken/below"], "--out taken/below: taken is a file; name a folder"),
    (["list", "poisson"], "'list' stands alone"),
    (["all", "poisson"], "'all' stands alone"),
]


@pytest.mark.parametrize(("arguments", "message"), BAD_COMMANDS)
def test_bad_command_lines(arguments, message, tmp_path):
    (tmp_path / "taken").write_text("mine", encoding="utf-8")
    done = run(*arguments, cwd=tmp_path)
    assert done.returncode == 2
    assert message in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert done.stdout == ""
    assert [p.name for p in tmp_path.iterdir()] == ["taken"], "nothing is left behind"
    assert (tmp_path / "taken").read_text(encoding="utf-8") == "mine"


PATCHED = """
import sys
from msvalidate import catalogue, study
from types import SimpleNamespace
{body}
catalogue.load = lambda name: SimpleNamespace(__doc__="?", run=run)
sys.exit(study.main(["poisson", "--out", "r", *sys.argv[1:]]))
"""
ENDINGS = {
    "tolerance missed": (
        1,
        "poisson: FAIL gap: observed 2, reference 1, error 1 > limit 0.5 m",
        """
import pandas as pd
from msvalidate.evidence import Evidence, Observed, Tolerance
def run(setting):
    return Evidence({"t": pd.DataFrame({"x": [1.0]})}, {"gap": Observed(2.0, 1.0)},
                    (Tolerance("gap", 0.5, "m", "so"),), columns={"x": "place (m)"})""",
    ),
    "bad input": (
        2,
        "study poisson: spring constants: -1",
        """
from msvalidate.problem import ProblemError
def run(setting): raise ProblemError("spring constants: -1; give 0 or more")""",
    ),
    "solver failed": (
        3,
        "study poisson: diverged by step 7",
        """
from msvalidate.problem import SolverError
def run(setting): raise SolverError("diverged by step 7")""",
    ),
    "crash": (
        3,
        "study poisson: crashed: FileNotFoundError: /home/someone/secret",
        "def run(setting): raise FileNotFoundError('/home/someone/secret')",
    ),
}


@pytest.mark.parametrize("ending", ENDINGS)
def test_exit_codes(ending, tmp_path):
    code, message, body = ENDINGS[ending]
    done = run(cwd=tmp_path, script=PATCHED.format(body=body))
    assert done.returncode == code
    assert message in done.stderr
    assert "Traceback" not in done.stderr
    page = (tmp_path / "r" / "report.md").read_text(encoding="utf-8")
    assert ("**FAIL**" if code == 1 else "**not finished**") in page
    assert "/home/someone" not in page


def test_verbose_crash_shows_where(tmp_path):
    done = run("-v", cwd=tmp_path, script=PATCHED.format(body=ENDINGS["crash"][2]))
    assert done.returncode == 3
    assert "Traceback" in done.stderr


def test_read_only_folder(tmp_path):
    script = "import os; os.access = lambda *_: False\n" + PATCHED.format(body="run = None")
    done = run(cwd=tmp_path, script=script)
    assert done.returncode == 2
    assert "--out r: no permission to write there; name another folder" in done.stderr
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("made", "message"),
    [
        ("r/poisson", "is a file; name another folder"),
        ("r/report.md/x", "is a folder; name another"),
    ],
)
def test_places_that_are_taken_are_found_before_the_work(made, message, tmp_path):
    (tmp_path / made).parent.mkdir(parents=True)
    (tmp_path / made).write_text("mine", encoding="utf-8")
    done = run("poisson", "--out", "r", cwd=tmp_path)
    assert done.returncode == 2
    assert message in done.stderr
    assert len(list(tmp_path.rglob("*.*"))) <= 1, "no CSV, no report"


def test_a_full_disk_names_the_file_that_was_wanted(tmp_path):
    full = "import errno, os\ndef no(*_): raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))"
    body = f"{full}\nos.fsync = no\n" + ENDINGS["tolerance missed"][2]
    done = run(cwd=tmp_path, script=PATCHED.format(body=body))
    assert done.returncode == 2
    assert "--out r: No space left on device: r/poisson/t.csv" in done.stderr
    assert not [p for p in tmp_path.rglob("*") if p.is_file()], "nothing half-written"


@pytest.mark.parametrize("arguments", [["list"], ["poisson", "--quick", "--no-plots"]])
def test_a_reader_that_leaves_is_no_failure(arguments, tmp_path):
    process = subprocess.Popen(
        [*PROGRAM, *arguments],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    process.stdout.close()
    errors = process.stderr.read()
    process.stderr.close()
    assert process.wait(60) == 0
    assert "Error" not in errors


def test_a_missed_tolerance_is_told_even_to_a_reader_that_left(tmp_path):
    no_reader = "import os\nr, w = os.pipe()\nos.dup2(w, 1)\nos.close(r)"
    body = no_reader + ENDINGS["tolerance missed"][2]
    done = run(cwd=tmp_path, script=PATCHED.format(body=body))
    assert done.returncode == 1
    assert "Traceback" not in done.stderr
    assert "Error" not in done.stderr


def test_a_terminal_without_unicode_still_gets_its_tables(tmp_path):
    done = subprocess.run(
        [*PROGRAM, "poisson", "--quick", "--no-plots"],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(ROOT), "PYTHONIOENCODING": "ascii"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr


def test_interrupt_ends_quietly(tmp_path):
    process = subprocess.Popen(
        [*PROGRAM, "poisson", "--out", "r", "-v"],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        stderr=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        # A shell's background job ignores interrupts, and its children with it.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # noqa: PLW1509
    )
    assert process.stderr.readline().startswith("poisson: "), "the study has begun"
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=30)
    assert process.returncode == 130
    assert "Traceback" not in errors
    assert not (tmp_path / "r" / "report.md").exists()


def test_a_foreign_package_named_studies_is_refused(tmp_path):
    (tmp_path / "studies").mkdir()
    (tmp_path / "studies" / "__init__.py").touch()
    done = run("poisson", cwd=tmp_path)
    assert done.returncode == 2
    assert "another package named 'studies' comes before msvalidate's own" in done.stderr
