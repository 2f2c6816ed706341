"""Negative controls of the ledger: numbers past their bounds, and results that are altered."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import pandas as pd

from msvalidate.output.results import Results

from .record import Check, Claim
from .sentences import CLAIMS

AS_IT_STANDS, CONDITION = "as it stands", "condition"
Change = Callable[[pd.DataFrame], pd.DataFrame]


@dataclass(frozen=True)
class Alteration:
    """A change to one table of one study."""

    study: str
    name: str
    change: Change


@dataclass(frozen=True)
class AlteredResults(Results):
    """Results of which one table is changed."""

    alter: Alteration | None = None

    def table(self, study: str, name: str) -> pd.DataFrame:
        """A table, changed if it is the one."""
        table = super().table(study, name)
        if self.alter and (study, name) == (self.alter.study, self.alter.name):
            return self.alter.change(table)
        return table


def altered(results: Results, alter: Alteration | None) -> Results:
    """Results with a change, if there is one."""
    if alter is None:
        return results
    return AlteredResults(results.form, results.run, results.folder, alter)


def move_past_bounds(
    claims: Sequence[Claim], plain: Mapping[int, float], under: Mapping[int, float]
) -> pd.DataFrame:
    """Each number of judged sentences reflected in its bound, and the verdict with it.

    A condition counts where the sentence does not hold as it stands.
    """
    found = []
    for claim in claims:
        if claim.check is None:
            continue
        number, other = plain[claim.number], under.get(claim.number)
        before = claim.decide(number, other)
        after = claim.decide(claim.check.moved(number), other)
        found.append(moved_row(claim, AS_IT_STANDS, claim.check, number, (before, after)))
        if claim.conditional and other is not None and not claim.check.holds(number):
            after = claim.decide(number, claim.conditional.moved(other))
            found.append(moved_row(claim, CONDITION, claim.conditional, other, (before, after)))
    return pd.DataFrame(found)


def moved_row(
    claim: Claim, part: str, check: Check, number: float, verdicts: tuple[str, str]
) -> dict[str, object]:
    """Verdict of a sentence before and after one of its numbers is moved."""
    before, after = verdicts
    return {
        "sentence": claim.number,
        "part": part,
        "number": number,
        "bound": float(check.bound),
        "side": check.side,
        "moved": check.moved(number),
        "verdict": before,
        "verdict_moved": after,
        "flips": "yes" if before != after else "no",
    }


class TypedClaim(Claim):
    """A sentence whose verdict is written down instead of computed."""

    def decide(self, plain: float, under_condition: float | None) -> str:  # noqa: ARG002
        """The verdict that is expected, whatever the numbers."""
        return self.expected


def cells_ratio(table: pd.DataFrame) -> pd.DataFrame:
    """The ratio of one cell in blocks of every size."""
    return table.assign(nu_springs=table["nu_cell_formula"])


def half_misfits(table: pd.DataFrame) -> pd.DataFrame:
    """Half of every misfit to a curve."""
    misfit = table["measured"] == "rms misfit over height"
    bodies = ("in_springs", "in_homogenised")
    return table.assign(**{body: table[body].mask(misfit, table[body] / 2) for body in bodies})


def no_difference(table: pd.DataFrame) -> pd.DataFrame:
    """Printed schemes that differ from nothing."""
    return table.assign(difference=0.0)


def of_plane(table: pd.DataFrame) -> pd.DataFrame:
    """The plane's charge at every depth."""
    return table.assign(as_report_over_plane=1.0)


def turned_about(table: pd.DataFrame) -> pd.DataFrame:
    """Steps of the strongest damping in the place of the weakest, body by body."""
    steps = table.groupby("body")["steps"].transform(lambda s: s.to_numpy()[::-1])
    return table.assign(steps=steps)


def folded_overdamped(table: pd.DataFrame) -> pd.DataFrame:
    """Folded cells in overdamped runs as well."""
    over = table["c_over_critical"] >= 2
    stable = table["cells_inverted"] != "grows"
    return table.assign(cells_inverted=table["cells_inverted"].mask(over & stable, 1.0))


def typed(claims: Sequence[Claim]) -> tuple[Claim, ...]:
    """Sentences whose verdicts are written down."""
    names = Claim.__dataclass_fields__
    return tuple(TypedClaim(**{name: getattr(claim, name) for name in names}) for claim in claims)


FAULTS: dict[str, dict[str, Any]] = {
    "the cell's ratio in blocks of every size": {
        "alter": Alteration("poisson", "finite_size", cells_ratio)
    },
    "half of every misfit to a curve": {
        "alter": Alteration("displacement", "statements", half_misfits)
    },
    "printed Verlet follows the motion": {
        "alter": Alteration("stability", "misprints", no_difference)
    },
    "the plane's charge at every depth": {
        "alter": Alteration("electrostatics", "depths", of_plane)
    },
    "too much damping costs what too little does": {
        "alter": Alteration("damping", "advice", turned_about)
    },
    "overdamped particles pass each other": {
        "alter": Alteration("stability", "passing", folded_overdamped)
    },
    "a sentence left out": {"claims": CLAIMS[:-1]},
    "verdicts written down": {"claims": typed(CLAIMS)},
}
"""Negative controls: arguments of `run` under which a tolerance must fail."""
