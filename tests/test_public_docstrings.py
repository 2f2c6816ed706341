"""Docstrings of the public names: their examples run, and every parameter is described."""

from __future__ import annotations

import doctest
import inspect
import re
from pathlib import Path

import pytest

import msvalidate

PUBLIC = {
    name: value
    for name in msvalidate.__all__
    for value in [getattr(msvalidate, name)]
    if inspect.isfunction(value) or inspect.isclass(value)
}


def failed_examples(name, value):
    """Return a report of the examples that fail, or the name of an object without an example."""
    report = []
    (test,) = doctest.DocTestFinder(recurse=False).find(value, name, globs={})
    doctest.DocTestRunner(verbose=False).run(test, out=report.append)
    return "".join(report) if test.examples else f"{name}: no example"


def undescribed(value):
    """Return the parameters of a function or class that its docstring does not describe."""
    text = inspect.getdoc(value) or ""
    section = re.search(r"^Parameters\n-+\n(.*?)(?=^\w+\n-+$|\Z)", text, re.M | re.S)
    lines = re.findall(r"^[a-zA-Z]\S*(?:, \w+)*$", section[1] if section else "", re.M)
    described = {name for line in lines for name in line.split(", ")}
    is_error = inspect.isclass(value) and issubclass(value, Exception)
    expected = () if is_error else inspect.signature(value).parameters
    return sorted(set(expected) ^ described)


def test_examples_of_public_names_run():
    reports = [failed_examples(name, value) for name, value in PUBLIC.items()]
    assert "\n".join(filter(None, reports)) == ""


def test_the_page_of_the_api_lists_every_public_function_and_class():
    page = Path(__file__).parents[1].joinpath("docs/api.md").read_text(encoding="utf-8")
    listed = re.findall(r"^   ([A-Za-z_]\w+)$", page, re.M)
    assert sorted(listed) == sorted(PUBLIC.keys() - {"ProblemError", "SolverError", "equilibrium"})


def test_parameters_of_public_names_are_described():
    wrong = {name: undescribed(value) for name, value in PUBLIC.items()}
    assert {name: parameters for name, parameters in wrong.items() if parameters} == {}


@pytest.mark.parametrize("text", ["Sum.", "Sum.\n\n>>> 1 + 1\n3"], ids=["missing", "wrong"])
def test_a_missing_or_wrong_example_is_noticed(text):
    def add(one, other):
        return one + other

    add.__doc__ = text
    assert failed_examples("add", add)


def test_a_missing_or_wrong_parameter_is_noticed():
    def add(one, other):
        """Return a sum.

        Parameters
        ----------
        one, another
            Numbers.
        """
        return one + other

    assert undescribed(add) == ["another", "other"]
