"""The command line of simulators: from nothing to a verdict, exit codes, nothing overwritten."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from tests.table import table
from tests.test_command_line import run

EXAMPLES = Path(__file__).parents[3] / "examples"


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A folder with a space in its name, a case and a new adapter."""
    folder = tmp_path_factory.mktemp("my work")
    shutil.copy(EXAMPLES / "box.toml", folder)
    done = run("adapter", "new", "toy", cwd=folder)
    assert done.returncode == 0, done.stderr
    assert done.stderr.startswith("toy.py written; it runs as it is: ")
    return folder


def test_the_template_is_judged_at_once(place):
    words = ("simulate", "box.toml", "--with", "toy.py", "--cells", "16", "--no-plots")
    done = run(*words, cwd=place)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("toy: agrees\n")
    folder = place / "reports" / "simulators"
    verdict = json.loads((folder / "box-toy" / "verdict.json").read_text(encoding="utf-8"))
    assert verdict["verdict"] == "agrees"
    assert 0 < verdict["rest"] < 1e-6
    page = (folder / "box-toy" / "case.html").read_text(encoding="utf-8")
    for text in ("linear elasticity, toy solver of the template", "1105 of 2048 triangle"):
        assert text in page
    assert str(place) not in page
    kept = {path.name for path in (folder / "box-toy-run" / "out").iterdir()}
    assert kept == {"log.txt", "result.json", "result.npz"}
    again = run(*words, "-q", cwd=place)
    assert (again.returncode, again.stdout, again.stderr) == (0, "", "")


def test_a_case_is_exported_whole(place):
    words = ("case", "export", "box.toml", "for them", "--cells", "3", "--springs")
    done = run(*words, "--set", "law=neo", "--set", "n=[1,2]", cwd=place)
    assert done.returncode == 0, done.stderr
    assert done.stderr == "for them: mesh of 36 quad cells, 4 x 1 m, 52 nodes\n"
    written = {path.name for path in (place / "for them").iterdir()}
    assert written == {
        *("request.json", "points.csv", "cells.csv", "nodal.csv", "springs.csv"),
        *("mesh.vtu", "mesh.msh", "mesh.inp", "case.toml"),
    }
    about = json.loads((place / "for them" / "request.json").read_text(encoding="utf-8"))
    assert about["settings"] == {"law": "neo", "n": [1, 2]}
    assert run(*words, cwd=place).returncode == 0  # its own export is replaced


ENDS = {
    "soft.py": "sys.argv[0]",
    "ends_77.py": "sys.exit(print('no clamps', file=sys.stderr) or 77)",
    "ends_1.py": "sys.exit('it diverged')",
}
BAD = [
    (("simulate", "box.toml", "--with", "ends_77.py"), 4, "cannot represent: no clamps"),
    (("simulate", "box.toml", "--with", "ends_1.py"), 3, "exit code 1: it diverged"),
    (("simulate", "box.toml", "--with", "soft.py"), 3, "no result.json"),
    (("simulate", "box.toml", "--with", "toy.py", "--shape", "quad"), 4, "cells quad; triangles"),
    (("simulate", "box.toml", "--with", "toy.py", "--set", "iterations=3"), 1, "not at rest"),
    (("simulate", "box.toml", "--with", "none.py"), 2, "no such program"),
    (("simulate", "box.toml", "--with", ""), 2, "no program; give a command"),
    (("simulate", "box.toml", "--with", "toy.py", "--limit", "0"), 2, "--limit: 0"),
    (("simulate", "none.toml", "--with", "toy.py"), 2, "case 'none.toml': No such file"),
    (("simulate", "box.toml"), 2, "the following arguments are required: --with"),
    (("simulate", "box.toml", "--with", "toy.py", "--set", "a"), 2, "'a'; give NAME=VALUE"),
    (("simulate", "box.toml", "--with", "toy.py", "--set", "a=NaN"), 2, "NaN is no number"),
    (("simulate", "box.toml", "--with", "toy.py", "--out", "box.toml"), 2, "box.toml"),
    (("case", "export", "box.toml", "."), 2, "holds what no request left there"),
    (("case", "export", "box.toml", "box.toml"), 2, "no folder of a request"),
    (("case", "export", "box.toml", "x", "--shape", "tetra"), 2, "choose triangle or quad"),
    (("adapter", "new", "toy"), 2, "toy.py is there already; give another name"),
    (("adapter", "new", "../a b"), 2, "is no name; give letters, digits, - and _"),
    (("adapter", "new", 'x"; y'), 2, "is no name; give letters"),
    (("adapter", "new", "nowhere/x"), 2, "no folder nowhere; make it first"),
    (("adapter", "old", "x"), 2, "invalid choice: 'old'"),
]


@table(("words", "code", "told"), BAD)
def test_what_goes_wrong_is_one_line_and_a_code(place, words, code, told):
    for name, body in ENDS.items():
        (place / name).write_text(f"import sys\n{body}\n", encoding="utf-8")
    done = run(*words, cwd=place)
    said = done.stdout + done.stderr
    assert (done.returncode, told in said) == (code, True), said
    assert "Traceback" not in said
    if code > 1:
        assert done.stderr.count("\n") == 1


@pytest.mark.slow
def test_an_adapter_is_checked(place):
    done = run("adapter", "check", "toy.py", "--law", "linear", "--json", "toy.json", cwd=place)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("toy: agrees\n")
    assert "read        E 1e+07 ± " in done.stdout
    found = json.loads((place / "toy.json").read_text(encoding="utf-8"))
    assert found["large"]["apart"] < 1e-8


def test_an_adapter_that_the_gate_stops(place):
    text = (place / "toy.py").read_text(encoding="utf-8").replace('material["E"],', "2e7,")
    (place / "deaf.py").write_text(text, encoding="utf-8")
    done = run("adapter", "check", "deaf.py", cwd=place)
    assert done.returncode == 1
    assert "stopped  twice the modulus" in done.stdout


@table(
    "text, words, code, said",
    [
        (
            "raise SystemExit('no licence')",
            (),
            3,
            "3 questions and no answer: adapter: exit code 1",
        ),
        ("import time; time.sleep(60)", ("--limit", "0.5"), 3, "question 1, motion: adapter: not"),
        ("import sys; sys.exit(print('hair', file=sys.stderr) or 77)", (), 4, "represent: hair"),
        ("", ("--law", "jelly"), 2, "--law 'jelly': not known; see adapter laws"),
        ("", ("--nu", "0.49"), 2, "ratio 0.49; give one from 0 to 0.45"),
        ("", ("--json", "no/x.json"), 2, "no folder no; make it first"),
    ],
)
def test_adapters_that_cannot_be_checked(place, text, words, code, said):
    (place / "bad.py").write_text(text, encoding="utf-8")
    done = run("adapter", "check", "bad.py", *words, cwd=place)
    assert (done.returncode, done.stdout) == (code, "")
    assert said in done.stderr
    assert done.stderr.count("\n") == 1
