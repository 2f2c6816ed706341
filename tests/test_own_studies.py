"""A user's own studies are found, judged and told; a package called ``studies`` is no obstacle."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from msvalidate.bench.judging import catalogue

STUDY = '''"""Is a bar of two springs in series as soft as theory says?"""
from msvalidate import equilibrium, spring_network
from msvalidate.bench.judging.evidence import Evidence, Observed, Tolerance
from msvalidate.bench.judging.sweep import Setting

from ._bar import points

FAULTS = {"stiffer by 1 %": {"candidate": 1.01}}


def run(candidate=1.0, setting=Setting()):
    stiffness = [candidate, candidate]
    network = spring_network(
        points(), [[0, 1], [1, 2]], stiffness,
        fixed=[[True, True], [False, True], [False, True]], force=[[0, 0], [0, 0], [0.1, 0]],
    )
    end = equilibrium(network).displacement[2, 0]
    return Evidence(
        tables={},
        observed={"end": Observed(end, 0.2)},
        tolerances=[Tolerance("end", 1e-12, "m", "two springs in series: rounding")],
    )
'''
BAR = "import numpy as np\n\n\ndef points():\n    return np.array([[0.0, 0], [1, 0], [2, 0]])\n"


@pytest.fixture
def own(tmp_path):
    """A folder with a study `bar` in `mine`, and a package `studies` that ends Python."""
    for folder, files in {
        "mine": {"bar.py": STUDY, "_bar.py": BAR, "notes.py": '"""No study."""\n'},
        "studies": {"__init__.py": "raise SystemExit('the wrong package')\n"},
    }.items():
        (tmp_path / folder).mkdir()
        for name, text in files.items():
            (tmp_path / folder / name).write_text(text, encoding="utf-8")
    return tmp_path


def run(folder, *arguments):
    return subprocess.run(
        [sys.executable, "-m", "msvalidate", *arguments],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(folder)},
        capture_output=True,
        text=True,
        check=False,
    )


def test_a_study_of_ones_own_is_run_and_judged(own):
    done = run(own, "check", "bar", "--studies", "mine", "--jobs", "2")
    assert (done.returncode, "bar: 1 of 1 held" in done.stderr) == (0, True), done.stderr
    assert (own / "reports" / "latest" / "verdict.json").is_file()
    (own / "mine" / "bar.py").write_text(STUDY.replace("=1.0, s", "=1.01, s"), encoding="utf-8")
    assert run(own, "bar", "--studies", "mine").returncode == 1


def test_a_study_of_ones_own_is_held_to_a_baseline_of_ones_own(own):
    text = STUDY.replace("tables={},", 'tables={"t": pd.DataFrame({"end": [end]})},')
    text = text.replace(
        "tolerances=[", 'columns={"end": "displacement (m)"},\n        tolerances=['
    )
    text = text.replace("from msvalidate import", "import pandas as pd\nfrom msvalidate import", 1)
    (own / "mine" / "bar.py").write_text(text, encoding="utf-8")
    check = ("check", "bar", "--studies", "mine", "--baseline", "base")
    done = run(own, *check, "--update", "--reason", "first")
    assert (done.returncode, "baseline of bar renewed; REASONS.md" in done.stderr) == (0, True)
    (own / "mine" / "bar.py").write_text(text.replace("0.1, 0]", "0.100001, 0]"), encoding="utf-8")
    table = own / "base" / "quick" / "bar" / "t.csv"
    assert abs(float(table.read_text(encoding="utf-8").split()[1]) - 0.2) < 1e-12
    done = run(own, *check)
    assert (done.returncode, "bar: FAIL t.csv: " in done.stderr) == (1, True)


def test_it_is_listed_and_helpers_are_not(own):
    listed = run(own, "list", "--studies", "mine").stdout.splitlines()
    assert [line.split()[0] for line in listed] == [*catalogue.names(), "bar"]
    assert not any("notes" in line or "_bar" in line for line in listed)


def test_a_study_of_an_installed_package_is_found(own):
    information = own / "springy-1.0.dist-info"
    information.mkdir()
    (information / "METADATA").write_text("Name: springy\nVersion: 1.0\n", encoding="utf-8")
    entry = "[msvalidate.studies]\nsprings_in_series = mine.bar\n"
    (information / "entry_points.txt").write_text(entry, encoding="utf-8")
    assert "springs_in_series  Is a bar of two springs" in run(own, "list").stdout
    assert "1 of 1 held" in run(own, "springs_in_series", "--quick").stderr


def test_what_cannot_be_found_is_refused(own):
    (own / "empty").mkdir()
    (own / "double").mkdir()
    (own / "double" / "poisson.py").write_text(STUDY, encoding="utf-8")
    refusals = {
        ("list", "--studies", "nowhere"): "no such folder",
        ("list", "--studies", "empty"): "no study in it",
        ("list", "--studies", "double"): "there is a study poisson already",
        ("check", "bar", "--studies", "mine", "--update", "--reason", "x"): "has no baseline",
    }
    for arguments, why in refusals.items():
        done = run(own, *arguments)
        assert (done.returncode, why in done.stderr) == (2, True), (arguments, done.stderr)


def test_folders_keep_their_helpers_apart(own):
    for name, end in (("one", 0.2), ("two", 0.4)):
        (own / name).mkdir()
        (own / name / "_mine.py").write_text(f"END = {end}\n", encoding="utf-8")
        text = STUDY.replace("Observed(end, 0.2)", "Observed(end, END)")
        text = text.replace("import points", "import points\nfrom ._mine import END")
        (own / name / f"bar_{name}.py").write_text(text, encoding="utf-8")
        helper = (own / "mine" / "_bar.py").read_text(encoding="utf-8")
        (own / name / "_bar.py").write_text(helper, encoding="utf-8")
    done = run(own, "bar_one", "bar_two", "--studies", "one", "--studies", "two", "--jobs", "2")
    assert "bar_one: 1 of 1 held" in done.stderr
    assert "bar_two: FAILED, 1 row: 0 held" in done.stderr


@pytest.mark.parametrize(
    ("folder", "name", "text", "said"),
    [
        ("co:lon", "bar.py", STUDY, "':' separates folders"),
        ("names", "list.py", STUDY, "'list' is a command"),
        ("few", "bar.py", "x = 1\n", "no study in it"),
    ],
)
def test_a_folder_that_cannot_be_told_is_refused(own, folder, name, text, said):
    (own / folder).mkdir()
    (own / folder / name).write_text(text, encoding="utf-8")
    done = run(own, "list", "--studies", folder)
    assert (done.returncode, said in done.stderr) == (2, True), done.stderr


def test_one_broken_study_costs_the_list_no_other(own):
    (own / "mine" / "broken.py").write_text("def run(:\n", encoding="utf-8")
    listed = run(own, "list", "--studies", "mine")
    assert "broken" in listed.stdout
    assert "line 1" in listed.stdout
    assert "poisson " in listed.stdout
    assert run(own, "broken", "--studies", "mine").returncode == 2
