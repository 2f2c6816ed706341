"""The set's own value of each quantity, and the second way that confirms it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cases.make.answer import Answer, answer_path, load_answer
from cases.make.closed_forms import closed_form
from cases.make.statements import Statement

Array = np.ndarray
ELEMENTS, NGSOLVE, CLOSED = "elements", "ngsolve", "closed form"
"""Names of the ways: `reference_fem` on meshes each twice as fine; NGSolve by elements of high
degree on hp-refined meshes; a formula."""


@dataclass(frozen=True)
class Confirmation:
    """One quantity of one case at one ratio, found in two ways.

    Parameters
    ----------
    case, nu, quantity
        Which.
    size
        Of the value: its largest component; the displacement's for its slope.
    estimate, uncertainty
        Of the value, in its unit: as its own way tells it; and as it is stated, wider where the
        second way differs by more than both tell.
    by, other_by
        The ways.
    difference, other_uncertainty
        Largest of the components, in the unit of the value.
    """

    case: str
    nu: float
    quantity: str
    size: float
    estimate: float
    uncertainty: float
    by: str
    other_by: str
    difference: float
    other_uncertainty: float

    @property
    def is_inside(self) -> bool:
        """Whether the two ways differ by no more than both leave open."""
        return self.difference <= self.uncertainty + self.other_uncertainty


def frozen_answer(statement: Statement, nu: float) -> tuple[Answer, list[Confirmation]]:
    """What the set says at one ratio, and what confirms it."""
    elements = load_answer(answer_path(ELEMENTS, statement.name, nu))
    exact = closed_form(statement, nu)
    if exact is not None:
        rows = _compared(statement.name, nu, (CLOSED, exact), (ELEMENTS, elements))
        return _widened(replace(exact, order=elements.order, nodes=elements.nodes), rows), rows
    other = load_answer(answer_path(NGSOLVE, statement.name, nu))
    rows = _compared(statement.name, nu, (ELEMENTS, elements), (NGSOLVE, other))
    # High degrees tell a slope from one mesh; differences of elements near 1/2 in space do not.
    return _widened(replace(elements, by_ratio=other.by_ratio), rows), rows


def _widened(answer: Answer, rows: list[Confirmation]) -> Answer:
    """The same answer with the uncertainties that are stated."""
    return replace(answer, uncertainty={row.quantity: row.uncertainty for row in rows})


def _compared(
    name: str, nu: float, own: tuple[str, Answer], other: tuple[str, Answer]
) -> list[Confirmation]:
    (by, one), (other_by, two) = own, other
    pairs = {"displacement": (one.displacement, two.displacement)}
    pairs |= {key: (value, two.quantities[key]) for key, value in one.quantities.items()}
    rows = []
    for key, (a, b) in pairs.items():
        apart, size = float(np.abs(a - b).max()), float(np.abs(a).max())
        mine, others = one.uncertainty[key], two.uncertainty[key]
        stated = mine if apart <= mine + others else apart
        rows.append(Confirmation(name, nu, key, size, mine, stated, by, other_by, apart, others))
    return rows
