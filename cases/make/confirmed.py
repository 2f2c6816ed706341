"""The value of each quantity, the second way that confirms it, and what is stated of it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from cases.make.answer import Answer, answer_path, load_answer
from cases.make.balance import known_by_balance
from cases.make.closed_forms import closed_form
from cases.make.statements import Statement

Array = np.ndarray
ELEMENTS, NGSOLVE, CLOSED = "elements", "ngsolve", "closed form"
"""Names of the ways: `reference_fem` on meshes each twice as fine; NGSolve by elements of high
degree on hp-refined meshes; a formula."""
SAFETY = 1.5
"""Times what extrapolation added: the own uncertainty of `elements`, from version 2 on. Set after
a third solver's numbers were seen: in version 1 it was 1, and too small by up to 1.39 where the two
ways agree within it. 2 would overstate displacements 3.6 times in the median."""
DIGITS = 3
"""Of an uncertainty that is stated, rounded up."""


@dataclass(frozen=True)
class Confirmation:
    """One quantity of one case at one ratio, found in two ways.

    Parameters
    ----------
    case, nu, quantity
        Which.
    size
        Of the value, its largest component, in its unit.
    way, second_way
        How the value was found, and how it was found again.
    own, second_own
        What each way says of its own error, in the unit of the value, before it knows the other.
    difference
        Of the two ways, largest of the components.
    balanced
        Whether balance of forces alone gives the value, so that a difference is the second way's.
    """

    case: str
    nu: float
    quantity: str
    size: float
    way: str
    second_way: str
    own: float
    second_own: float
    difference: float
    balanced: bool = False

    @property
    def is_confirmed(self) -> bool:
        """Whether the two ways differ by no more than both tell of themselves."""
        return self.difference <= self.own + self.second_own

    @property
    def stated(self) -> float:
        """Uncertainty that is stated: the own one; of elements never below the difference."""
        wide = self.way == ELEMENTS and not self.balanced
        return rounded_up(max(self.own, self.difference) if wide else self.own)


def rounded_up(value: float) -> float:
    """The next number of few digits."""
    if not value:
        return 0.0
    unit = 10.0 ** (math.floor(math.log10(value)) - DIGITS + 1)
    near = float(f"{value:.{DIGITS}g}")
    return near if near >= value else float(f"{near + unit:.{DIGITS}g}")


def frozen_answer(statement: Statement, nu: float) -> tuple[Answer, list[Confirmation]]:
    """What the set says at one ratio, and what confirms it."""
    elements = load_answer(answer_path(ELEMENTS, statement.name, nu))
    exact = closed_form(statement, nu)
    if exact is not None:
        rows = compared(statement, nu, (CLOSED, exact), (ELEMENTS, elements))
        return as_stated(replace(exact, order=elements.order, nodes=elements.nodes), rows), rows
    other = load_answer(answer_path(NGSOLVE, statement.name, nu))
    rows = compared(statement, nu, (ELEMENTS, elements), (NGSOLVE, other))
    # High degrees tell a slope from one mesh; differences of elements near 1/2 in space do not.
    return as_stated(replace(elements, by_ratio=other.by_ratio), rows), rows


def as_stated(answer: Answer, rows: list[Confirmation]) -> Answer:
    """The same answer with the uncertainties that are stated."""
    return replace(answer, uncertainty={row.quantity: row.stated for row in rows})


def own_uncertainty(way: str, told: float) -> float:
    """What a way's value is uncertain by, from what its program told."""
    return SAFETY * told if way == ELEMENTS else told


def compared(
    statement: Statement, nu: float, own: tuple[str, Answer], second: tuple[str, Answer]
) -> list[Confirmation]:
    """Every quantity in two ways; a way is its name and its answer."""
    (way, one), (second_way, two) = own, second
    pairs = {"displacement": (one.displacement, two.displacement)}
    pairs |= {key: (value, two.quantities[key]) for key, value in one.quantities.items()}
    rows = []
    for key, (a, b) in pairs.items():
        told = one.uncertainty[key]
        row = Confirmation(
            statement.name, nu, key, float(np.abs(a).max()), way, second_way,
            own_uncertainty(way, told), own_uncertainty(second_way, two.uncertainty[key]),
            float(np.abs(a - b).max()), known_by_balance(statement, key, told),
        )  # fmt: skip
        rows.append(row)
    return rows
