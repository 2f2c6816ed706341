"""Gallery scripts of docs/gallery: form of all, and the results that three of them print."""

import ast
import re
import runpy
from pathlib import Path

import matplotlib.pyplot as plt

from tests.table import table

SCRIPTS = sorted((Path(__file__).resolve().parents[1] / "docs" / "gallery").glob("plot_*.py"))


@table("path", SCRIPTS)
def test_form(path):
    lines = path.read_text("utf-8").splitlines()
    title, rule, empty, question = ast.get_docstring(ast.parse("\n".join(lines))).split("\n")[:4]
    assert title
    assert rule == "=" * len(title)
    assert (empty, question[-1]) == ("", "?")
    assert 30 <= len(lines) <= 80


@table("number", [1, 5, 10])
def test_printed_difference(number, capsys):
    plt.switch_backend("Agg")
    plt.close("all")
    runpy.run_path(str(SCRIPTS[number - 1]))
    pairs = re.findall(r": (\S+), at most (\S+)", capsys.readouterr().out)
    assert pairs
    assert all(abs(float(value)) <= float(limit) for value, limit in pairs)
