"""The command line: what it prints where, its exit codes, and what bad input leaves behind."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.forked import completed
from tests.table import stored_rows, undated

ROOT = Path(__file__).parents[1]
PROGRAM = [sys.executable, "-m", "msvalidate.study"]


def run(*arguments, cwd=None, script=None, fresh=False, **variables):
    """Run the program in a folder of its own; with `script`, python code that calls it.

    Forked from a process with the libraries, unless a `fresh` one is asked for.
    """
    environment = os.environ | {"PYTHONPATH": str(ROOT)} | variables
    if not fresh and hasattr(os, "fork"):
        return completed(arguments, script, cwd, environment)
    command = [sys.executable, "-c", script] if script else PROGRAM
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
    results = folder / "results"
    written = {p.relative_to(results).as_posix() for p in results.rglob("*.*")}
    tables = {"summary", "finite_size", "modulus", "reference", "direction", "incompressible"}
    tables |= {"drift", "algorithm1", "block", "resolution", "verdict"}
    tables |= {"rotated", "rotated_order"}
    tables |= {"cube", "cube_cell", "cube_clamped", "cube_modulus", "cube_shape"}
    pictures = {"finite_size", "direction", "drift", "rest", "block", "rotated"}
    pictures |= {"cube", "cube_shape"}
    expected = {f"poisson/{name}.csv" for name in tables}
    expected |= {"poisson/study.json", "report.html", "verdict.json"}
    expected |= {f"poisson/{name}.{kind}" for name in pictures for kind in ("png", "svg")}
    assert written == expected


def test_findings_on_stdout_messages_on_stderr(finished):
    done, _ = finished
    summary, findings = (part.splitlines() for part in done.stdout.split("\n\n")[1:])
    assert done.stdout.startswith("poisson: Poisson's ratio of the square lattice")
    assert summary[1].split()[:4] == ["case", "springs", "scikit-fem", "difference"]
    assert len(summary) == 11
    assert max(map(len, summary)) <= 100
    assert findings[0].startswith(
        "  - Claim: The report's formula k2/(2 k1 + k2) fails for k2 = k1/2"
    )
    assert len(findings) < 10
    assert re.search(r"^poisson: (\d+) of \1 held, \d+\.\d s$", done.stderr, re.MULTILINE)


def test_report_tells_where_it_comes_from(finished):
    done, folder = finished
    about = json.loads((folder / "results/poisson/study.json").read_text(encoding="utf-8"))
    command = "python -m msvalidate.study poisson --quick --out DIR --seed 7"
    assert (about["origin"]["command"], about["origin"]["seed"]) == (command, "7")
    page = (folder / "results" / "report.html").read_text(encoding="utf-8")
    assert command in page
    assert str(folder) not in page + done.stdout


LIGHT = """
import sys
import time
from pathlib import Path
from types import SimpleNamespace
from msvalidate.cli import program as study
from msvalidate.bench.judging import catalogue
"""
STUDY = """
import pandas as pd
from msvalidate.bench.judging.evidence import Evidence, Observed, Tolerance
from msvalidate.bench.output import baseline
from msvalidate.bench.output.figures import new_figure
from msvalidate.problem import ProblemError, SolverError
def found(gap=0.0, reference=0.0, tables=None, figures={}, **more):
    tables = tables or {"t": pd.DataFrame({"x": [1.0]})}
    columns = {"x": "place (m)", "word": "w"}
    gaps, limits = {"gap": Observed(gap, reference)}, (Tolerance("gap", 0.5, "m", "so"),)
    return Evidence(tables, **{"observed": gaps, "tolerances": limits, "figures": figures,
                               "columns": columns} | more)
"""
PATCHED = """
BODY
catalogue.load = lambda name: SimpleNamespace(__doc__="?", run=run)
sys.exit(study.main(["poisson", "--out", "r", *sys.argv[1:]]))
"""
MISSED = "def run(setting): return found(2.0, 1.0)"


def patched(body, script=PATCHED, made=STUDY):
    """A script that runs the program, whose study is the function `run` of a body."""
    return LIGHT + made + script.replace("BODY", body)


TINY = '''"""How long is μ ± σ²?"""
import pandas as pd
from msvalidate.bench.judging.evidence import Evidence, Observed, Tolerance
FAULTS = {}
def run(setting):
    table = pd.DataFrame({"length": range(50), "word": "μ ± σ²"})
    return Evidence({"t": table}, {"gap": Observed(0.0)}, (Tolerance("gap", 0.5, "m", "so"),),
                    columns={"length": "place (m)", "word": "σ²"}, findings=("found: μ",))
'''


@pytest.fixture
def tiny(tmp_path):
    """Environment in which there is a study `tiny`, whose tables and findings are no ASCII."""
    (tmp_path / "own").mkdir()
    (tmp_path / "own" / "tiny.py").write_text(TINY, encoding="utf-8")
    return {"MSVALIDATE_STUDIES": str(tmp_path / "own")}


def test_quiet_run_prints_nothing(tmp_path, tiny):
    done = run("tiny", "-q", "--no-plots", "--out=r", cwd=tmp_path, fresh=True, **tiny)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    assert not list(tmp_path.rglob("*.png"))
    assert "--out=DIR" in (tmp_path / "r" / "report.html").read_text(encoding="utf-8")


TWO_TABLES = patched("""
def run(setting):
    tables = {name: pd.DataFrame({"x": range(50)}) for name in ("block", "cube")}
    return found(tables=tables, findings=("found",))""")


def test_tables_are_printed_when_asked_for(tmp_path):
    done = run("-v", cwd=tmp_path, script=TWO_TABLES)
    for words in ("poisson/block\n", "poisson/cube\n", "poisson/verdict\n", "  - found\n"):
        assert words in done.stdout
    assert done.stdout.count("\n49\n") == 2


def test_without_a_word_it_is_said_what_to_do_first():
    done = run()
    assert (done.returncode, done.stderr) == (2, "")
    assert "poisson      one study, ten seconds" in done.stdout
    assert len(done.stdout.splitlines()) <= 10


def test_a_command_helps_with_its_own_options():
    whole = {verb: run(*verb.split(), "--help").stdout for verb in ("", "run", "check", "list")}
    shown = {verb: set(re.findall(r"--[a-z-]+", text)) for verb, text in whole.items()}
    assert {"--quick", "--seed", "--table"} <= shown["run"] - shown["check"] - shown["list"]
    assert {"--full", "--update", "--junit"} <= shown["check"] - shown["run"] - shown[""]
    assert all(text.isascii() and text.startswith("usage: ") for text in whole.values())
    assert run("run", "poison").stderr == run("poison").stderr.replace("y --h", "y run --h")


@pytest.mark.parametrize(
    "name", ["python -m msvalidate", "python -m msvalidate.study", "msvalidate"]
)
def test_hints_name_the_program_as_it_was_called(name, tmp_path):
    script = tmp_path / "msvalidate"  # as pip installs it
    script.write_text("from msvalidate.cli.program import run\nrun()\n", encoding="utf-8")
    command = [sys.executable, *name.split()[1:]] if " " in name else [sys.executable, str(script)]
    for words in ([], ["--help"], ["chek"], ["case", "rnu"], ["adapter", "check", "--help"]):
        environment = os.environ | {"PYTHONPATH": str(ROOT)}
        done = subprocess.run(
            [*command, *words], capture_output=True, text=True, env=environment, check=False
        )
        said = re.findall(r"(?:python -m )?msvalidate(?:\.\w+)?(?=[: ])", done.stdout + done.stderr)
        assert set(said) == {name}, (words, done.stderr)


MANY = patched("""
def run(setting):
    gaps = (2.0, 1.5, 9.0, 3.0, float("nan"), 4.0, 5.0, 6.0, 1.1)
    observed = {f"gap {i}": Observed(gap) for i, gap in enumerate(gaps)}
    return found(observed=observed, tolerances=tuple(
        Tolerance(name, 1.2, "m", "so") for name in observed))""")


def test_the_worst_failures_are_told_and_where_the_others_are(tmp_path):
    done = run("--no-plots", cwd=tmp_path, script=MANY)
    assert done.returncode == 1
    told = re.findall(r"FAIL gap (\d)", done.stderr)
    assert told == ["2", "7", "6", "5", "3"]
    assert f"poisson: … 3 more in r{os.sep}poisson{os.sep}verdict.csv\n" in done.stderr
    assert "poisson: FAILED, 9 rows: 1 held, 8 missed, " in done.stderr


def test_a_table_alone_is_printed_whole(tmp_path):
    done = run("--table", "block", cwd=tmp_path, script=TWO_TABLES)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == ["poisson/block", "x", *map(str, range(50))]


def test_a_table_that_was_not_made(tmp_path):
    """Named in the study's sources, so it could not be known before."""
    done = run("--table", "finite_size", cwd=tmp_path, script=TWO_TABLES)
    assert done.returncode == 2
    assert "--table finite_size: no such table; choose from block, cube, verdict" in done.stderr
    assert (tmp_path / "r" / "poisson" / "block.csv").is_file(), "the results are kept"


def test_list_names_each_study_with_its_title():
    done = run("list")
    assert done.returncode == 0
    titles = dict(line.split(maxsplit=1) for line in done.stdout.splitlines())
    assert titles["poisson"] == "Poisson's ratio of the square lattice"
    assert titles["displacement"] == "Displacement errors of the report's load cases"


def test_help_and_list_import_nothing_heavy():
    """Waiting for numpy before printing a help text is what users notice first."""
    script = (
        "import sys; from msvalidate.cli import program as study\n"
        "try: study.main(sys.argv[1:])\n"
        "except SystemExit: pass\n"
        "import json; print(json.dumps(sorted(sys.modules)), file=sys.stderr)"
    )
    for arguments in (["--help"], ["list"]):
        done = run(*arguments, script=script, fresh=True)
        loaded = set(json.loads(done.stderr.splitlines()[-1]))
        assert not loaded & {"numpy", "scipy", "pandas", "matplotlib", "numba", "skfem", "tqdm"}


@pytest.mark.parametrize(("arguments", "message"), stored_rows("command_lines"))
def test_bad_command_lines(arguments, message, tmp_path):
    (tmp_path / "taken").write_text("mine", encoding="utf-8")
    done = run(*arguments, cwd=tmp_path)
    assert done.returncode == 2
    assert message in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert done.stdout == ""
    assert [p.name for p in tmp_path.iterdir()] == ["taken"], "nothing is left behind"
    assert (tmp_path / "taken").read_text(encoding="utf-8") == "mine"


ENDINGS = [
    ("def run(setting): return found(2.0, 1.0)", 1,
        "poisson: FAIL gap: observed 2, reference 1, error 1 > limit 0.5 m"),
    ("def run(setting): raise ProblemError('spring constants: -1; give 0 or more')", 2,
        "study poisson: spring constants: -1"),
    ("def run(setting): raise SolverError('diverged by step 7')", 3,
        "study poisson: diverged by step 7"),
    ("def run(setting): sys.exit(0)", 3, "study poisson: crashed: SystemExit: 0"),
    ("def run(setting): return found(figures={'f': lambda tables: 1 / 0})", 3,
        "study poisson: crashed: ZeroDivisionError: "),
    ("def run(setting): raise FileNotFoundError('/home/someone/secret')", 3,
        "study poisson: crashed: FileNotFoundError: /home/someone/secret"),
]  # fmt: skip


@pytest.mark.parametrize(("body", "code", "message"), ENDINGS)
def test_exit_codes(body, code, message, tmp_path):
    done = run(cwd=tmp_path, script=patched(body))
    assert done.returncode == code
    assert message in done.stderr
    assert "Traceback" not in done.stderr
    page = (tmp_path / "r" / "report.html").read_text(encoding="utf-8")
    assert ("checks missed" if code == 1 else "not finished") in page
    assert "/home/someone" not in page
    (row,) = json.loads((tmp_path / "r" / "verdict.json").read_text(encoding="utf-8"))
    assert row["verdict"] == "fail"


def test_each_study_has_its_own_seconds(tmp_path):
    script = patched(MISSED).replace(
        'catalogue.load = lambda name: SimpleNamespace(__doc__="?", run=run)',
        """
def slow(setting):
    time.sleep(1.0)
    return run(setting)
def load(name):
    return SimpleNamespace(__doc__="?", run=slow if name == "actuator" else run)
catalogue.load, catalogue.names = load, lambda: ["actuator", "poisson"]""",
    )
    script = script.replace('"poisson", "--out"', '"all", "--out"')
    done = run("--no-plots", cwd=tmp_path, script=script)
    about = {
        name: json.loads((tmp_path / "r" / name / "study.json").read_text(encoding="utf-8"))
        for name in ("actuator", "poisson")
    }
    assert about["actuator"]["seconds"] > 1 > about["poisson"]["seconds"] + 0.2
    page = (tmp_path / "r" / "report.html").read_text(encoding="utf-8")
    for name, each in about.items():
        assert f"took {each['seconds']:.1f} s" in each["origin"]["time"]
        assert f"0 of 1 tolerance held, {each['seconds']:.1f} s</p>" in page
        assert f"{name}: FAILED, 1 row: 0 held, 1 missed, {each['seconds']:.1f} s\n" in done.stderr
    rows = json.loads((tmp_path / "r" / "verdict.json").read_text(encoding="utf-8"))
    assert [row["seconds"] for row in rows] == [each["seconds"] for each in about.values()]


def test_verbose_crash_shows_where(tmp_path):
    done = run("-v", cwd=tmp_path, script=patched(ENDINGS[-1][0]))
    assert done.returncode == 3
    assert "Traceback" in done.stderr


BROKEN = "from msvalidate.bench.output import report\nreport.publish = lambda *_: {}['key']\n"


@pytest.mark.parametrize("verbose", [True, False])
def test_a_fault_of_the_program_is_one_line_and_no_missed_tolerance(verbose, tmp_path):
    script = BROKEN + patched(MISSED)
    done = run(*["-v"][: int(verbose)], cwd=tmp_path, script=script)
    assert done.returncode == 3
    assert "error: a fault of the program itself: KeyError: 'key'; -v shows" in done.stderr
    assert ("Traceback" in done.stderr) == verbose
    assert done.stderr.count("msvalidate.study: error: ") == 1


@pytest.mark.parametrize("backend", ["module://matplotlib_inline.backend_inline", "nonsense"])
def test_a_backend_that_is_not_there_is_not_missed(backend, tmp_path):
    body = f"""
def run(setting):
    exec({STUDY!r}, globals())
    return found(figures={{"f": lambda tables: new_figure()[0]}})"""
    script = patched(body, made="")  # no library is there before the program sets its own
    done = run(cwd=tmp_path, script=script, fresh=True, MPLBACKEND=backend)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "r" / "poisson" / "f.png").read_bytes().startswith(b"\x89PNG")


def shell(line, cwd):
    """A line of a shell that runs the program by its name, `study`."""
    script = f'study() {{ "{sys.executable}" -m msvalidate.study "$@"; }}\n{line}'
    return subprocess.run(
        ["bash", "-c", script],  # noqa: S607
        capture_output=True,
        text=True,
        cwd=cwd,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        check=False,
        timeout=100,
    )


@pytest.mark.skipif(os.name != "posix", reason="needs a shell")
@pytest.mark.parametrize(
    ("line", "code", "said"),
    stored_rows("closed_streams"),
)
def test_streams_that_are_closed_full_or_left(line, code, said, tmp_path):
    done = shell(line, tmp_path)
    assert done.returncode == code, done.stderr
    assert said in done.stderr
    assert "Traceback" not in done.stderr
    assert len(done.stderr.splitlines()) <= 1
    assert not list(tmp_path.iterdir())


def test_results_and_exit_code_without_any_stream(tmp_path):
    body = "import os\nfor number in range(3): os.close(number)\nsys.stdout = sys.stderr = None\n"
    script = (
        f"import sys\nfrom msvalidate.cli import program as study\n{body}study._prepare_streams()\n"
    )
    script += patched(MISSED)
    done = run(cwd=tmp_path, script=script)
    assert (done.returncode, done.stdout, done.stderr) == (1, "", "")
    assert (tmp_path / "r" / "poisson" / "t.csv").read_text(encoding="utf-8") == "x\n1.0\n"


@pytest.mark.skipif(os.name != "posix", reason="needs links and pipes")
@pytest.mark.parametrize(
    ("arguments", "said"),
    stored_rows("links_and_pipes"),
)
def test_links_in_a_circle_devices_and_pipes(arguments, said, tmp_path):
    (tmp_path / "loop").symlink_to("loop")
    os.mkfifo(tmp_path / "pipe")
    done = run(*arguments, cwd=tmp_path)
    assert done.returncode == 2
    assert said in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert {p.name for p in tmp_path.iterdir()} == {"loop", "pipe"}
    assert (tmp_path / "pipe").is_fifo()


def test_python_that_drops_docstrings(tmp_path):
    script = patched(MISSED).replace('__doc__="?"', "__doc__=None")
    done = run(cwd=tmp_path, script=script, fresh=True, PYTHONOPTIMIZE="2")
    assert done.returncode == 1, done.stderr
    page = (tmp_path / "r" / "report.html").read_text(encoding="utf-8")
    assert "ratio of the square lattice" in page


def test_read_only_folder(tmp_path):
    """As who runs the tests may write anywhere, the system is made to refuse."""
    no = (
        "import errno, os, pathlib\n"
        "def no(*_, **__): raise OSError(errno.EACCES, os.strerror(errno.EACCES))\n"
        "pathlib.Path.mkdir = no\n"
    )
    done = run(cwd=tmp_path, script=no + patched("run = None"))
    assert done.returncode == 2
    assert "--out r: Permission denied; name another folder" in done.stderr
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(("made", "message"), [
    ("r/poisson", "is a file; name another folder"),
    ("r/report.html/x", "is a folder; name another"),
    ("r/poisson/notes.txt", "no run wrote poisson/notes.txt, which would be lost; move it"),
])  # fmt: skip
def test_places_that_are_taken_are_found_before_the_work(made, message, tmp_path):
    (tmp_path / made).parent.mkdir(parents=True)
    (tmp_path / made).write_text("mine", encoding="utf-8")
    done = run("poisson", "--out", "r", cwd=tmp_path)
    assert done.returncode == 2
    assert message in done.stderr
    assert len(list(tmp_path.rglob("*.*"))) <= 1, "no CSV, no report"


def test_a_full_disk_names_the_file_that_was_wanted(tmp_path):
    full = "import errno, os\ndef no(*_): raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))"
    body = f"{full}\nos.fsync = no\n" + MISSED
    done = run(cwd=tmp_path, script=patched(body))
    assert done.returncode == 2
    assert "error: No space left on device: poisson/t.csv" in done.stderr
    assert not [p for p in tmp_path.rglob("*") if p.is_file()], "nothing half-written"


def test_a_reader_that_leaves_is_no_failure(tmp_path, tiny):
    process = subprocess.Popen(
        [*PROGRAM, "tiny", "--quick", "--no-plots"],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(ROOT)} | tiny,
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
    no_reader = "import os\nr, w = os.pipe()\nos.dup2(w, 1)\nos.close(r)\n"
    body = no_reader + MISSED
    done = run(cwd=tmp_path, script=patched(body))
    assert done.returncode == 1
    assert "Traceback" not in done.stderr
    assert "Error" not in done.stderr


def test_a_terminal_without_unicode_still_gets_its_tables(tmp_path, tiny):
    ascii_only = {"PYTHONIOENCODING": "ascii"} | tiny
    done = run("tiny", "--quick", "--no-plots", cwd=tmp_path, fresh=True, **ascii_only)
    assert done.returncode == 0, done.stderr
    assert "found: ?" in done.stdout


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
    begun = next(line for line in process.stderr if line != "loading libraries\n")
    assert begun.startswith("poisson: "), "the study has begun"
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=30)
    assert process.returncode == 130
    assert "Traceback" not in errors
    assert not (tmp_path / "r").exists()


# --- check and report -----------------------------------------------------------------------------

CHECKED = """
BODY
catalogue.names = lambda: ["poisson"]
catalogue.load = lambda name: SimpleNamespace(__doc__="?", run=run)
baseline.CHECKOUT, baseline.HOME = Path("base"), Path("base")
sys.exit(study.main(sys.argv[1:]))
"""


def small(x="2.0", gap="0.1"):
    table = f'{{"x": [1.0, {x}], "word": ["a", "b"]}}'
    body = f"def run(setting): return found({gap}, tables={{'t': pd.DataFrame({table})}})"
    return patched(body, CHECKED)


@pytest.fixture(scope="module")
def renewed(tmp_path_factory):
    """A folder with a baseline of its own, made by the command itself."""
    folder = tmp_path_factory.mktemp("renewed")
    (folder / "pyproject.toml").touch()  # a checkout's
    done = run("check", "--update", "--reason", "first", cwd=folder, script=small())
    assert done.returncode == 0, done.stderr
    return folder


@pytest.fixture
def checked(renewed, tmp_path):
    shutil.copytree(renewed, tmp_path, dirs_exist_ok=True)
    return tmp_path


def test_check_holds_against_its_own_baseline(checked):
    assert (
        checked / "base" / "quick" / "poisson" / "t.csv"
    ).read_text() == "x,word\n1.0,a\n2.0,b\n"
    reasons = undated((checked / "base/REASONS.md").read_text(encoding="utf-8"))
    assert "- baseline (quick): first; poisson/t is new\n" in reasons
    done = run("check", "--junit", "j.xml", cwd=checked, script=small())
    assert done.returncode == 0, done.stderr
    assert "poisson: 2 of 2 held, " in done.stderr
    assert done.stdout == ""
    suite = '<testsuite name="poisson" tests="2" failures="0" errors="0" time="'
    assert suite in (checked / "j.xml").read_text(encoding="utf-8")


def test_a_moved_digit_fails_the_check(checked):
    done = run("check", "--junit", "j.xml", cwd=checked, script=small(x="2.00001"))
    assert done.returncode == 1
    (line,) = [line for line in done.stderr.splitlines() if "FAIL " in line]
    assert "FAIL t.csv: x, row 1: was 2.0, is 2.00001, moved by 1e-05" in line
    junit = (checked / "j.xml").read_text(encoding="utf-8")
    assert 'failures="1"' in junit
    assert '<failure message="t.csv: x, row 1: was 2.0' in junit
    rows = json.loads((checked / "reports/latest/verdict.json").read_text(encoding="utf-8"))
    assert [row["quantity"] for row in rows if row["verdict"] == "fail"] == ["t.csv"]


@pytest.mark.parametrize(
    ("damage", "said"),
    [
        ("x,word\n1.0,a\n2.000005,b\n", "FAIL t.csv: x, row 1: was 2.000005, is 2.0, moved by"),
        ("", "FAIL t.csv: column x: new"),
        ("x,word\n1.0,a,9\n2.0,b\n", "cannot be read: row 0 has 3 values for 2 columns"),
        ('x,word\n"1.0,a\n', "the baseline cannot be read: "),
    ],
)
def test_a_spoilt_baseline_fails_the_check(damage, said, checked):
    (checked / "base" / "quick" / "poisson" / "t.csv").write_text(damage, encoding="utf-8")
    done = run("check", cwd=checked, script=small())
    assert done.returncode == 1
    assert said in done.stderr


def test_what_a_solver_says_is_made_printable(tmp_path):
    body = 'def run(setting): raise SolverError("bad \\x1b[31m \\x00 \\udc80")'
    done = run("check", "--junit", "j.xml", cwd=tmp_path, script=patched(body, CHECKED))
    assert done.returncode == 3
    assert "\x1b" not in done.stderr
    assert "\x1b" not in (tmp_path / "j.xml").read_text(encoding="utf-8")


@pytest.mark.parametrize("arguments", [["check"], ["check", "--full"]])
def test_no_baseline_is_exit_code_4(arguments, tmp_path):
    done = run(*arguments, cwd=tmp_path, script=small())
    form = "full" if "--full" in arguments else "quick"
    assert done.returncode == 4
    assert f"study poisson: no {form} baseline, nothing compared" in done.stderr


def test_a_study_that_fails_its_theory_makes_no_baseline(checked):
    before = (checked / "base" / "quick" / "poisson" / "t.csv").read_bytes()
    script = small(x="3.0", gap="0.7")
    done = run("check", "--update", "--reason", "moved", cwd=checked, script=script)
    assert done.returncode == 1
    assert "baseline left as it was: poisson did not hold; mend that first" in done.stderr
    assert (checked / "base" / "quick" / "poisson" / "t.csv").read_bytes() == before
    assert ": moved" not in (checked / "base/REASONS.md").read_text(encoding="utf-8")


def test_report_makes_the_page_again(checked):
    page = checked / "reports" / "latest" / "report.html"
    before = page.read_bytes()
    page.unlink()
    done = run("report", cwd=checked, script=small())
    assert done.returncode == 0, done.stderr
    assert page.read_bytes() == before


def test_a_place_for_junit_that_is_taken(checked):
    places = {
        "base": "a folder; name a file",
        "no/j.xml": "no folder no; make it",
        "reports/latest/verdict.json": "inside --out reports/latest; name a place outside",
    }
    for place, said in places.items():
        done = run("check", "--junit", place, cwd=checked, script=small())
        assert done.returncode == 2
        assert f"--junit {place}: {said}" in done.stderr
        assert len(done.stderr.splitlines()) == 1


SINGLE = """
import numpy as np
from msvalidate.bench.judging.candidate import solve_springs


def mine(problem, network, answer):
    place = network.points + solve_springs(problem, network, answer)
    return place.astype(np.float32) - network.points
"""


def test_a_candidate_has_a_page_of_its_own(tmp_path):
    (tmp_path / "own.py").write_text(SINGLE, encoding="utf-8")
    asked = ["poisson", "--quick", "--questions", "algorithm1", "--no-plots", "--junit", "j.xml"]
    asked += ["--accuracy", "3e-8"]  # of positions below 1 m in single precision
    done = run(*asked, "--candidate", "own.py:mine", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "poisson: own.py:mine, 3 rows, agrees: 2, not resolved: 1" in done.stderr
    folder = tmp_path / "reports" / "candidate"
    rows = json.loads((folder / "verdict.json").read_text(encoding="utf-8"))
    assert {(row["candidate"], "widened to" in row["because"]) for row in rows} == {
        ("own.py:mine", True)
    }
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert "Verdict on own.py:mine" in page
    assert "algorithm1; the others were not asked" in page
    assert "The software's own verdict" not in page
    assert "What springs are good for" not in page
    assert "<skipped" in (tmp_path / "j.xml").read_text(encoding="utf-8")
    again = run("report", "--out", "reports/candidate", cwd=tmp_path)
    assert again.returncode == 0, again.stderr
