"""Every number that states an uncertainty or an error has a test of its coverage."""

import ast
import csv
from pathlib import Path

ROOT = Path(__file__).parents[1]
LIST = ROOT / "tests" / "uncertainties.csv"
"""By attribute the test that compares it with a finer or independent solution, or why none does."""


def fields(kind):
    """Names and types of a class's fields and properties."""
    for node in kind.body:
        if isinstance(node, ast.AnnAssign):
            yield ast.unparse(node.target), ast.unparse(node.annotation)
        elif isinstance(node, ast.FunctionDef) and any(
            "property" in ast.unparse(each) for each in node.decorator_list
        ):
            yield node.name, ast.unparse(node.returns)


def stated():
    """Attributes of public classes that are numbers named error or uncertainty."""
    for package in ("msvalidate", "reference_fem"):
        for path in (ROOT / package).rglob("*.py"):
            module = ".".join(path.relative_to(ROOT).with_suffix("").parts)
            for kind in ast.parse(path.read_text(encoding="utf-8")).body:
                if isinstance(kind, ast.ClassDef) and kind.name[0] != "_":
                    for name, type_ in fields(kind):
                        if ("error" in name or "uncertainty" in name) and "str" not in type_:
                            yield f"{module}.{kind.name}.{name}"


def test_every_stated_uncertainty_has_a_test_of_its_coverage():
    with LIST.open(encoding="utf-8", newline="") as file:
        rows = {row["attribute"]: row for row in csv.DictReader(file)}
    assert sorted(rows) == sorted(stated())
    for attribute, row in rows.items():
        assert bool(row["test"]) != bool(row["reason"]), attribute
        if row["test"]:
            path, name = row["test"].split("::")
            assert f"\ndef {name}(" in (ROOT / path).read_text(encoding="utf-8"), attribute
