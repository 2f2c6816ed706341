"""Tests over members of a registry take all of them, or those that have a property."""

from __future__ import annotations

import ast
from pathlib import Path

from msvalidate.problem import SHAPES
from msvalidate.springs.constants.routes import ROUTES
from msvalidate.springs.dynamics.integrators import INTEGRATORS
from msvalidate.springs.dynamics.relaxations import RELAXATIONS
from msvalidate.springs.lattice import EDGE_RULES, WEIGHTS
from msvalidate.springs.lattice.patterns import all_patterns
from reference_fem.mesh.elements import ELEMENTS

HERE = Path(__file__).parent
REGISTRIES = (
    all_patterns(), INTEGRATORS, RELAXATIONS, ROUTES, WEIGHTS, EDGE_RULES, SHAPES, ELEMENTS,
)  # fmt: skip
MANY = 3
"""Names of one registry that are no chance examples any more."""


def partial_lists(source: str) -> list[str]:
    """Lists of names alone, over which a test in some source runs, that are part of a registry."""
    lists = [
        (row, {getattr(item, "value", getattr(item, "attr", item)) for item in row.elts})
        for test in ast.walk(ast.parse(source))
        for decorator in getattr(test, "decorator_list", ())
        for row in getattr(decorator, "args", [])[1:]
        if isinstance(row, ast.List | ast.Tuple | ast.Set)
    ]
    return [
        ast.unparse(row)
        for row, names in lists
        if any(MANY <= len(names) < len(known) and names <= set(known) for known in REGISTRIES)
    ]


def test_no_test_runs_over_a_list_of_names_kept_by_hand():
    lists = {path: partial_lists(path.read_text("utf-8")) for path in HERE.rglob("test_*.py")}
    assert {path: rows for path, rows in lists.items() if rows} == {}, "take the registry"


def test_a_list_kept_by_hand_is_noticed():
    test = "@pytest.mark.parametrize('name', {})\ndef test(name): ..."
    assert partial_lists(test.format("['square', 'bcc', 'fcc']"))
    assert partial_lists(test.format("('fire', 'newton', 'adaptive')"))
    assert not partial_lists(test.format("[*INTEGRATORS]"))
    assert not partial_lists(test.format("['shared', 'equal', 'per_cell']"))
    assert not partial_lists(test.format("['square', 'fcc']"))
