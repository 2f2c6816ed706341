"""Remedies that messages name are applied once: the next message must not refuse them."""

from __future__ import annotations

import ast
import re

import pytest

from msvalidate.case.file.building import read_case
from msvalidate.case.file.case import spacing_of
from msvalidate.case.springs.lattice_springs import solve_springs
from msvalidate.problem import ProblemError
from tests.msvalidate.case.file.test_case_files import GOOD, write
from tests.table import stored_rows, table
from tests.test_architecture import SOURCES, tree

LIBRARY = re.compile(r"\b[a-z_]+=(True|False|None)\b")


def changed(text, changes):
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new)
    return text


def solved(folder, text):
    case = read_case(write(folder, text.replace("END", "")))
    return solve_springs(case, spacing_of(case))


@table(("refusal", "words", "remedy"), stored_rows("remedies"))
def test_each_remedy_ends_its_refusal(tmp_path, refusal, words, remedy):
    text = changed(f"{GOOD}\nEND\n", refusal)
    with pytest.raises(ProblemError, match=re.escape(words)):
        solved(tmp_path, text)
    solved(tmp_path, changed(text, remedy))


def library_words(parsed):
    """Arguments of Python in messages of errors, which commands print too."""
    raised = (node.exc for node in ast.walk(parsed) if isinstance(node, ast.Raise) and node.exc)
    texts = (node for error in raised for node in ast.walk(error) if isinstance(node, ast.Constant))
    return [node.value for node in texts if LIBRARY.search(str(node.value))]


def test_messages_name_no_arguments_of_the_library():
    assert library_words(ast.parse("raise ProblemError(f'{x}: no; take allow_folded=True')"))
    ours = [name for name in SOURCES if name.startswith("msvalidate.")]
    assert {name: words for name in ours if (words := library_words(tree(name)))} == {}
