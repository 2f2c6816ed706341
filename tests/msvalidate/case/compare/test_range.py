"""Verdicts of the commands in and out of the range of the theory: files, tables, exit codes."""

from __future__ import annotations

import json
import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from msvalidate.case.compare.comparison import compare_case
from msvalidate.case.file.building import read_case
from msvalidate.case.report.run import case_files
from msvalidate.case.springs.lattice_springs import solve_springs
from msvalidate.cli.program import main
from msvalidate.problem.records import replace
from msvalidate_check.verdict import AGREES

RANGE = Path(__file__).parents[3] / "data" / "range"
INSIDE, OUTSIDE = (sorted((RANGE / name).glob("*.toml")) for name in ("inside", "outside"))
"""Case files in and out of the range of the theory; those out of it begin with the reason."""
CANTILEVER, TORN = (RANGE / "outside" / name for name in ("cantilever.toml", "torn.toml"))


def stem(path):
    return path.stem


@cache
def record_of(path):
    """Verdict and all text that a case leaves, page and tables together."""
    *_, content = case_files(read_case(path), plots=False)
    text = [each.decode() for name, each in content.items() if name.endswith((".json", ".csv"))]
    page = re.sub(r'<p class="more"><b>agrees.*?</p>', "", content["case.html"].decode())
    page = page.replace("\N{NO-BREAK SPACE}", " ")
    return json.loads(content["verdict.json"]), "\n".join(text), page


@pytest.mark.parametrize("path", OUTSIDE, ids=stem)
def test_no_surface_prints_agrees_out_of_the_range(path):
    verdict, text, page = record_of(path)
    reason = path.read_text("utf-8").splitlines()[0].removeprefix("# ")
    assert verdict["verdict"] == "not resolved"
    assert reason in verdict["reasons"][0]
    assert "agrees" not in text
    assert "Estimated for" not in text, "no advice on a theory out of its range"
    assert verdict["choice"]["springs"] == []
    assert ">agrees<" not in page
    assert reason.replace("'", "&#39;") in page


REMOVED = "not found|no stable equilibrium|come apart|separates|not solved"


@pytest.mark.parametrize("path", INSIDE, ids=stem)
def test_no_record_that_agrees_lacks_a_part(path):
    verdict, text, page = record_of(path)
    assert verdict["verdict"] == "agrees"
    assert not re.search(REMOVED, text + page)


WITHOUT_OBSTACLE = [p for p in (*INSIDE, *OUTSIDE) if "contact" not in p.read_text("utf-8")]


@pytest.mark.parametrize("path", WITHOUT_OBSTACLE, ids=stem)
def test_halving_the_mesh_does_not_change_the_range_verdict(path):
    """The verdict of the case itself is that of its folder, by the tests above."""
    case = read_case(path)
    finer = replace(case, cells=2 * case.cells, accuracy=case.accuracy / 8)
    decides = any(limitation.decides for limitation in compare_case(finer).limitations)
    assert decides == (path in OUTSIDE)


def test_commands_end_with_the_same_word(tmp_path, capsys):
    # An exact field of linear theory, which is 40 m for a beam of 10 m.
    path, case = CANTILEVER, read_case(CANTILEVER)
    answer = solve_springs(case, 0.25)
    field = np.hstack([answer.lattice.points, answer.rest.displacement])
    np.savetxt(tmp_path / "u.csv", field, delimiter=",", header="x,y,ux,uy", comments="")
    out = ("--out", str(tmp_path / "out"), "--no-plots")
    for words in (["run", str(path)], ["judge", str(path), str(tmp_path / "u.csv")]):
        assert main(["case", *words, *out]) == 1
        said = capsys.readouterr()
        assert ": Not resolved: " in said.out
        assert "agrees" not in said.out + said.err
    assert main(["case", "run", str(path), *out, "--set", "material.E=1e6,1e12"]) == 1
    capsys.readouterr()
    _, large, small = (tmp_path / "out/cantilever-sweep/sweep.csv").read_text("utf-8").splitlines()
    assert ",solved,not resolved," in large
    assert "Linear theory is out of its range" in large
    assert ",solved,agrees," in small


def requested(path, folder):
    """Record of a case that requests linear theory."""
    text = path.read_text("utf-8").replace("[compare]", '[compare]\ngeometry = "linear"')
    (folder / path.name).write_text(text, encoding="utf-8")
    return record_of(folder / path.name)[0]


def test_a_case_that_requests_linear_theory_is_judged_by_it(tmp_path):
    verdict = requested(CANTILEVER, tmp_path)
    assert verdict["verdict"] == "agrees"
    assert verdict["reasons"][0] == 'Judged by linear theory, as geometry = "linear" requests.'
    assert verdict["reasons"][1].startswith("Linear theory is out of its range: nonlinear elements")
    # What is no matter of geometry counts all the same.
    verdict = requested(TORN, tmp_path)
    assert verdict["verdict"] == "not resolved"
    assert "requests" in verdict["reasons"][0]
    assert "separates" in verdict["reasons"][1]


FLAT = """schema = 1
[body]
box = [2, 1]
[material]
E = 1e6
nu = 0.3
state = "plane_stress"
[[support]]
on = "bottom"
components = ["y"]
[[support]]
at = { x = 0, y = 0 }
components = ["x"]
[[contact]]
on = "top"
half_space = { at = [1, 1] }
depth = 0.002
[springs]
cells = 4
"""


def test_a_support_at_a_point_goes_with_an_obstacle(tmp_path):
    # Uniform compression: force E (depth / height) width, to the first order.
    (tmp_path / "flat.toml").write_text(FLAT, encoding="utf-8")
    rows = {row.quantity: row for row in compare_case(read_case(tmp_path / "flat.toml")).rows}
    assert rows["contact force"].wanted == pytest.approx(4000.0, rel=5e-3)
    assert rows["displacement"].word == AGREES
