"""Verdicts of the commands in and out of the range of the theory: files, tables, exit codes."""

from __future__ import annotations

import json
import re
from functools import cache

import numpy as np
import pytest

from msvalidate.case.building import read_case
from msvalidate.case.run import case_files
from msvalidate.case.springs import solve_springs
from msvalidate.cli.program import main

BODY = """
schema = 1
[body]
box = [{size}]
unit = "{unit}"
[material]
E = {E}
nu = {nu}
state = "plane_strain"
thickness = {thickness}
{law}
[[support]]
on = "{held}"
{more}
[springs]
cells = {cells}
[reference]
accuracy = 0.02
[compare]
quantities = ["displacement"]
{compare}
"""
CANTILEVER = {
    "size": "10, 1", "unit": "m", "E": 1e6, "nu": 0.3, "law": "", "held": "left", "cells": 2,
    "thickness": 0.2,
    "more": '[[load]]\non = "right"\ntraction = [0, -1e4]', "compare": "band = 0.3",
}  # fmt: skip
COLUMN = CANTILEVER | {"more": '[[load]]\non = "right"\ntraction = [-9e3, 0]'}
BLOCK = CANTILEVER | {"size": "0.37, 0.37", "held": "bottom", "E": 1e5, "cells": 4}
MOVED = '[[support]]\non = "top"\nvalue = [0, {}]'
NONLINEAR = 'geometry = "nonlinear"'
FOLDED = BLOCK | {
    "more": MOVED.format(-0.148), "cells": 2, "law": 'law = "neo-hookean"', "compare": NONLINEAR,
}  # fmt: skip
TORN = BLOCK | {
    "nu": 0.25, "more": MOVED.format(0.03) + "\n[fracture]\ncritical_stretch = 0.01",
}  # fmt: skip
ROLLER = BLOCK | {
    "size": "70, 17.5", "unit": "mm", "E": 0.275e6, "nu": 0.475, "cells": 6, "thickness": 28,
    "more": '[[contact]]\non = "top"\nparabola = { at = [35, 17.5], radius = 35 }\nforce = 380',
}  # fmt: skip
OUTSIDE = {
    "cantilever": (CANTILEVER, "differ from it by 0.79 of"),
    "cantilever, nearly incompressible": (CANTILEVER | {"nu": 0.47}, "Green's strain exceeds"),
    "column": (COLUMN, "no stable equilibrium beyond 0.2"),
    "folded": (FOLDED, "no stable equilibrium beyond 0."),
    "torn": (TORN, "separates at 0.265"),
    "roller": (ROLLER, "compresses the layer below it, 0.0175 m thick, by 0."),
    "roller, thickness in m": (ROLLER | {"thickness": 0.028}, "compresses the layer below it"),
}
INSIDE = {
    "small strain": CANTILEVER | {"E": 1e15, "compare": "band = 0.3"},
    "block": BLOCK | {"more": MOVED.format(1e-3)},
    "rubber": BLOCK | {"nu": 0.499, "more": MOVED.format(1e-3), "compare": "band = 0.2"},
    "nonlinear": BLOCK | {"more": MOVED.format(-0.04), "compare": NONLINEAR},
    "pressed": ROLLER | {"E": 1e8, "compare": "band = 0.5"},
    "whole": TORN | {"more": TORN["more"].replace("0.03", "1e-4")},
}


def write(folder, values, name="case"):
    path = folder / f"{name}.toml"
    path.write_text(BODY.format(**values), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def record(tmp_path_factory):
    """Name of a case -> what it leaves, solved once."""

    @cache
    def of(name):
        values = INSIDE[name] if name in INSIDE else OUTSIDE[name][0]
        return record_of(write(tmp_path_factory.mktemp("case"), values))

    return of


def record_of(path):
    """Verdict and all text that a case leaves, page and tables together."""
    _, content = case_files(read_case(path), plots=False)
    text = [each.decode() for name, each in content.items() if name.endswith((".json", ".csv"))]
    page = re.sub(r'<p class="more"><b>agrees.*?</p>', "", content["case.html"].decode())
    return json.loads(content["verdict.json"]), "\n".join(text), page


@pytest.mark.parametrize("name", OUTSIDE)
def test_no_surface_prints_agrees_out_of_the_range(name, record):
    (verdict, text, page), (_, reason) = record(name), OUTSIDE[name]
    assert verdict["verdict"] == "not resolved"
    assert reason in verdict["reasons"][0]
    assert "agrees" not in text
    assert ">agrees<" not in page
    assert reason.replace("'", "&#39;") in page


@pytest.mark.parametrize("name", [*INSIDE, *OUTSIDE])
def test_no_record_that_agrees_lacks_a_part(name, record):
    verdict, text, page = record(name)
    if name in INSIDE:
        assert verdict["verdict"] == "agrees"
    if "agrees" in text:
        for words in (
            "not found",
            "no stable equilibrium",
            "come apart",
            "separates",
            "not solved",
        ):
            assert words not in text + page


def test_commands_end_with_the_same_word(tmp_path, capsys):
    # An exact field of linear theory, which is 40 m for a beam of 10 m.
    path = write(tmp_path, CANTILEVER)
    case = read_case(path)
    answer = solve_springs(case, 0.25)
    field = np.hstack([answer.lattice.points, answer.rest.displacement])
    np.savetxt(tmp_path / "u.csv", field, delimiter=",", header="x,y,ux,uy", comments="")
    out = ("--out", str(tmp_path / "out"), "--no-plots")
    for words in (["run", str(path)], ["judge", str(path), str(tmp_path / "u.csv")]):
        assert main(["case", *words, *out]) == 1
        said = capsys.readouterr()
        assert ": not resolved\n  " in said.out
        assert "agrees" not in said.out + said.err
    assert (
        main(
            [
                "case",
                "run",
                str(path),
                *out,
                "--set",
                "material.E=1e6,1e12",
                "--set",
                "springs.cells=4",
            ]
        )
        == 0
    )
    capsys.readouterr()
    _, large, small = (tmp_path / "out/case-sweep/sweep.csv").read_text("utf-8").splitlines()
    assert ",solved,not resolved," in large
    assert "Linear theory is out of its range" in large
    assert ",solved,agrees," in small


def test_a_case_that_requests_linear_theory_is_judged_by_it(tmp_path):
    requested = CANTILEVER | {"compare": 'geometry = "linear"\nband = 0.3'}
    verdict, _, _ = record_of(write(tmp_path, requested))
    assert verdict["verdict"] == "agrees"
    assert verdict["reasons"][0] == 'Judged by linear theory, as geometry = "linear" requests.'
    assert verdict["reasons"][1].startswith("Linear theory is out of its range: nonlinear elements")
    # What is no matter of geometry counts all the same.
    torn = TORN | {"compare": 'geometry = "linear"'}
    verdict, _, _ = record_of(write(tmp_path, torn))
    assert verdict["verdict"] == "not resolved"
    assert "requests" in verdict["reasons"][0]
    assert "separates" in verdict["reasons"][1]
