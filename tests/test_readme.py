"""README names every table that studies leave, and its code is of this package."""

from __future__ import annotations

import ast
import importlib
import re
from pathlib import Path

import pytest

from tests.table import table

ROOT = Path(__file__).resolve().parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
FULL = ROOT / "reports" / "baseline" / "full"
STUDIES = sorted(folder.name for folder in FULL.iterdir() if folder.is_dir())
BLOCKS = re.findall(r"```python\n(.*?)```", README, re.DOTALL)


def unnamed(study, text, tables):
    """Tables of a study that no text names; "begin" and "end" let a part of a name stand for it."""
    section = text[text.index(f"**`{study}`**") :]
    section = section[section.index("Its tables") :].split("\n**`")[0].split("\n## ")[0]
    names = set(re.findall(r"`([a-z0-9_]+)(?:\.csv)?`", section))
    starts = tuple(f"{name.rstrip('_')}_" for name in names if "begin" in section)
    ends = tuple(name for name in names if name.startswith("_"))
    return {
        t for t in tables if t not in names and not t.startswith(starts) and not t.endswith(ends)
    }


@table("study", STUDIES)
def test_every_table_is_named(study):
    assert not unnamed(study, README, {path.stem for path in (FULL / study).glob("*.csv")})


def test_a_table_left_out_is_noticed():
    text = (
        "**`one`** asks.\n\nIts tables: `a.csv`, `b`, and those that end in `_c`.\n\n**`two`** `d`"
    )
    assert unnamed("one", text, {"a", "b", "x_c", "d", "b_e"}) == {"d", "b_e"}


@pytest.mark.parametrize("number", range(len(BLOCKS)))
def test_what_its_code_imports_is_there(number):
    for node in ast.walk(ast.parse(BLOCKS[number])):
        if isinstance(node, ast.ImportFrom):
            module = importlib.import_module(node.module)
            for alias in node.names:
                whole = f"{node.module}.{alias.name}"
                assert hasattr(module, alias.name) or importlib.import_module(whole), whole
