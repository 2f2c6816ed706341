"""What springs are good for: at most ten rows to choose by.

Question   For the bodies that the studies look at: which lattice and rule is best, how far is it
           from elasticity at a coarse and a fine spacing, and on what condition?
Candidate  What the other studies found, and the part of this one.
Reference  As in those studies.
Expected   Springs whose solid is the material agree on the finest lattice, and no refinement moves
           them away. Springs whose solid is another one differ on the finest.

What is named as springs is made of the names that their tables carry: of what ran. A row is of the
best springs of its body, or of the worst, and then names the best.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from msvalidate import kit
from msvalidate_check.text import percent
from msvalidate_check.verdict import AGREES, NOT_ASKED, NOT_RESOLVED, agreement

from ..large_strain import bending
from ..lattices.ratio import rubber
from . import models, ordinary, part

BAND = 0.05
"""What an engineer takes for agreement of displacements, as in the study `displacement`."""
ONE_PERCENT, TWENTY = 0.01, 20
BENT = 0.1
"""Strain of the bent block."""
BENDING = {
    "springs": "square, k2/k1 = 0.5",
    bending.TENSION: "square, k2/k1 = 1, no rest length, cells under pressure",
}
CRACKED = {
    "square-8": "square, k2/k1 = 0.5, half boundary springs",
    "triangular": "triangular, half boundary springs",
}
"""Springs of the bent block and of the plate with a crack -> their words."""
NEGLIGIBLE = 1e-3
"""A thousandth of the displacement: references are known to that."""
ERRORS = ("error_coarse", "error_at_20", "error_fine", "uncertainty_fine")
Line = dict[float, float]
"""Cells across -> error, positive."""
Tables = Mapping[str, pd.DataFrame]
YES, NO = "yes", "no"


@dataclass(frozen=True)
class Question:
    """A row: where its errors are; of linear elements on the same body, and whether both are timed.

    `told` makes of a table what `tell` makes, of all springs on the body: `row` takes the best of
    them, or the worst if that is asked. A condition may read the tables and which springs it is of.
    """

    body: str
    material: str
    condition: str | Callable[[Tables, str], str]
    study: str
    table: str
    told: Callable[[pd.DataFrame], pd.DataFrame]
    linear: Callable[[pd.DataFrame], pd.DataFrame] | None = None
    timed: bool = False
    worst: bool = False


def run(results: kit.Results, own: Mapping[str, pd.DataFrame]) -> kit.Evidence:
    """The rows, from the studies' tables; `own` are those of this study."""
    table = pd.DataFrame([row(question, results, own) for question in QUESTIONS])
    return kit.Evidence(
        tables={"good_for": table},
        tolerances=judge(table),
        columns=kit.columns(__file__),
        findings=findings(table),
    )


def row(
    question: Question, results: kit.Results, own: Mapping[str, pd.DataFrame]
) -> dict[str, object]:
    """One row of the table."""
    mine = question.study == "overview"
    found = own[question.table] if mine else results.table(question.study, question.table)
    told = question.told(found)
    lines = lines_of(told)
    if any(len(line) < 2 for line in lines.values()):
        few = next(name for name, line in lines.items() if len(line) < 2)
        raise kit.SolverError(f"{question.study}/{question.table}: too few sizes of {few}")
    best, springs = (pick(lines, key=lambda name: finest(lines[name])) for pick in (min, max))
    springs = springs if question.worst else best
    told, errors = told[told["springs"] == springs], lines[springs]
    (coarse, first), (fine, last) = list(errors.items())[:: len(errors) - 1]
    uncertainty = float(told.loc[told["across"] == fine, "uncertainty"].max())
    said = question.condition
    said = said if isinstance(said, str) else said({**own, question.table: found}, springs)
    if springs != best:
        said += f"; {best}: {percent(finest(lines[best]))}"
    return {
        "body": question.body,
        "springs": springs,
        "material": question.material,
        "across_coarse": int(coarse),
        "error_coarse": first,
        "error_at_20": at_cells(TWENTY, errors),
        "across_fine": int(fine),
        "error_fine": last,
        "uncertainty_fine": uncertainty,
        "verdict": agreement(last, uncertainty, BAND),
        "rises": rises(errors),
        "condition": said,
        "cells_over_linear": over_linear(question, errors, found),
        "time_over_linear_here": times_over_linear(question, springs, found),
        "study": question.study,
        "table": question.table,
        "taken_from_here": "this run" if mine else results.source(question.study),
    }


def over_linear(question: Question, errors: Line, found: pd.DataFrame) -> float | str:
    """Cells across that 1 % takes, over those of linear elements."""
    needed = cost_of_one_percent(errors, list(errors))
    if question.linear is None:
        return needed if needed == "never" else NOT_ASKED
    linear = line_of(question.linear(found))
    return over(needed, cost_of_one_percent(linear, list(linear)))


def times_over_linear(question: Question, springs: str, found: pd.DataFrame) -> float | str:
    """Seconds that 1 % takes, over those of linear elements, where both were timed."""
    if not question.timed or "solve_seconds" not in found:
        return NOT_ASKED
    parts = (found[found["model"] == name] for name in (springs, part.LINEAR[1]))
    return over(
        *(part.reach(ONE_PERCENT, p["across"], p["error"], p["solve_seconds"]) for p in parts)
    )


def cost_of_one_percent(line: Line, costs: list[float]) -> float | str:
    """Cost at which the error is 1 %, or why it is at no size."""
    return part.reach(ONE_PERCENT, list(line), list(line.values()), costs)


def over(springs: float | str, elements: float | str) -> float | str:
    """A cost over another; "never" where springs do not get there, else "not resolved"."""
    if springs == "never":
        return "never"
    if isinstance(springs, str) or isinstance(elements, str):
        return NOT_RESOLVED
    return springs / elements


def at_cells(cells: float, line: Line) -> float | str:
    """Error at so many cells across, between its sizes."""
    if not min(line) <= cells <= max(line):
        return NOT_ASKED
    sizes, errors = (np.log(list(values)) for values in (line.keys(), line.values()))
    return float(np.exp(np.interp(np.log(cells), sizes, errors)))


def rises(line: Line) -> int:
    """Refinements at which an error rises, by more than what references leave open."""
    steps = np.diff(list(line.values()))
    return int((steps > NEGLIGIBLE).sum())


def tell(
    rows: pd.DataFrame,
    springs: str | list[str],
    across: str,
    error: str | pd.Series,
    uncertainty: str,
) -> pd.DataFrame:
    """Rows of a table as what is told of them: springs, cells across, error, uncertainty."""
    size = rows[error] if isinstance(error, str) else error
    numbers = {"across": rows[across], "error": size, "uncertainty": rows[uncertainty]}
    told = pd.DataFrame({name: column.astype(float).abs() for name, column in numbers.items()})
    return told.assign(springs=springs)


def finest(line: Line) -> float:
    """Error on the most cells."""
    return line[max(line)]


def lines_of(told: pd.DataFrame) -> dict[str, Line]:
    """Springs -> cells across -> error."""
    return {str(name): line_of(own) for name, own in told.groupby("springs", sort=False)}


def line_of(told: pd.DataFrame) -> Line:
    """Cells across -> largest error of all rows of that many."""
    sizes = told["error"].groupby(told["across"]).max()
    return dict(zip(sizes.index.to_list(), sizes.to_list(), strict=True))


def of_part(table: pd.DataFrame) -> pd.DataFrame:
    """Rows of the part's springs."""
    return tell_model(table[~table["model"].str.endswith(" elements")])


def of_linear(table: pd.DataFrame) -> pd.DataFrame:
    """Rows of its linear quadrilaterals."""
    return tell_model(table[table["model"] == part.LINEAR[1]])


def tell_model(rows: pd.DataFrame) -> pd.DataFrame:
    """Rows of the part."""
    return tell(rows, rows["model"].to_list(), "across", "error", "reference_error")


def of_cook(family: str) -> Callable[[pd.DataFrame], pd.DataFrame]:
    """Rows of the methods of a family on Cook's membrane."""

    def told(table: pd.DataFrame) -> pd.DataFrame:
        mine = table[table["method"].str.startswith(family)]
        springs = [method_label(name) for name in mine["method"]]
        return tell(mine, springs, "cells", "against_limit", "limit_uncertainty")

    return told


def method_label(name: str) -> str:
    """A method of Cook's membrane in words."""
    on_edges = name.replace("springs, edges", "springs on edges")
    return models.lattice_label(on_edges.removeprefix("springs, "))


def of_bent(table: pd.DataFrame) -> pd.DataFrame:
    """Block whose ends turn, of springs."""
    mine = table[table["model"].isin(BENDING) & np.isclose(table["strain"], BENT)]
    return tell(mine, mine["model"].map(BENDING).to_list(), "cells", "difference", "reference")


def of_patches(table: pd.DataFrame) -> pd.DataFrame:
    """Half-width of a patch at the worst of eight loads, by cells in it."""
    springs = "square, k2/k1 = 0.5, half boundary springs"
    return tell(table, [springs] * len(table), "cells", "worst", "reference")


def of_cracks(table: pd.DataFrame) -> pd.DataFrame:
    """Strength beside Griffith's of a critical stretch that is set from growth, by the crack."""
    springs = table["lattice"].map(CRACKED).to_list()
    return tell(table, springs, "cells", table["strength"] - 1, "reference")


def own_energy(tables: Tables, springs: str) -> str:
    """What the other rule for the critical stretch does to the strength."""
    mine = tables["griffith"][tables["griffith"]["lattice"].map(CRACKED) == springs]
    more = np.sqrt(float(mine["ratio"].iloc[0])) - 1
    return f"critical stretch set from growth; from broken springs' energy, {percent(more)} more"


def of_rubber(table: pd.DataFrame) -> pd.DataFrame:
    """Bent block, nearly incompressible, the largest ratio there is."""
    words = table["model"].map(rubber.MODELS)
    plane = table[(table["state"] == "plane_strain") & words.str.startswith("springs")]
    nearest = plane[plane["nu_rubber"] == plane["nu_rubber"].max()]
    springs = words[nearest.index].to_list()
    numbers = "cells_through", "deflection_difference", "deflection_uncertainty"
    return tell(nearest, springs, *numbers)


def of_solids(table: pd.DataFrame) -> pd.DataFrame:
    """Cases in space, of the sizes that every case has."""
    cases = table.groupby(["lattice", "cells_high"])["case"].transform("nunique")
    mine = table[cases == table["case"].nunique()]
    springs = [models.lattice_label(name) for name in mine["lattice"]]
    return tell(mine, springs, "cells_high", "against_own_body", "fem_uncertainty")


def of_ordinary(body: ordinary.Part) -> Callable[[pd.DataFrame], pd.DataFrame]:
    """Rows of an ordinary part, of a lattice and of its own mesh's edges."""

    def told(table: pd.DataFrame) -> pd.DataFrame:
        mine = table[table["body"] == body.body]
        springs = [models.lattice_label(name) for name in mine["lattice"]]
        return tell(mine, springs, "cells_across", "difference", "uncertainty")

    return told


def others(body: ordinary.Part, tables: Tables, springs: str) -> str:
    """Springs on an ordinary part other than these, with their error on the most cells."""
    mine = tables["ordinary"][tables["ordinary"]["body"] == body.body]
    rest = mine[mine["lattice"].map(models.lattice_label) != springs]
    last = rest.groupby("lattice", sort=False)["difference"].last()
    return "; ".join(f"{name}: {percent(error)}" for name, error in last.items())


def other_support(tables: Tables, springs: str) -> str:
    """What other springs do, and all of them if the same plate is held at a bolt hole."""
    same = lines_of(of_ordinary(ordinary.BOLTED)(tables["ordinary"]))[springs]
    sides, holes = (others(p, tables, springs) for p in (ordinary.CLAMPED, ordinary.BOLTED))
    return f"{sides}; held at a bolt hole, {percent(finest(same))}; {holes}"


def thin_walls(tables: Tables, springs: str) -> str:
    """How many cells the bracket's walls are thick, and what other springs do."""
    mine = tables["ordinary"][tables["ordinary"]["body"] == ordinary.BRACKET.body]
    spacings = mine[mine["lattice"].map(models.lattice_label) == springs]["spacing"]
    cells = " and ".join(f"{ordinary.MM * ordinary.WALL / h:.3g}" for h in spacings)
    soft = " (one: hourglass modes)" if springs == ordinary.ON_MESH else ""
    return f"walls {cells} cells thick{soft}; {others(ordinary.BRACKET, tables, springs)}"


QUESTIONS = (
    Question(
        "block of Poisson's ratio 0.4, plane strain, clamped and sheared", YES,
        "any ratio below 1/2",
        "overview", "part", of_part, of_linear, timed=True,
    ),
    Question(
        "neo-Hookean block bent to 10 % strain", YES, "any ratio: finite elements, node for node",
        "large_strain", "bending", of_bent,
    ),
    Question(
        "patch under a round obstacle, ratio 1/3: half-width", YES,
        "by the forces' second moment; counting points errs by a cell",
        "contact", "patches", of_patches,
    ),
    Question(
        "strength of a plate with an edge crack along a row, ratio 1/3", YES, own_energy,
        "fracture", "griffith", of_cracks,
    ),
    Question(
        "bent rubber block, ratio 0.4999 in plane strain", YES, "linear elements lock here",
        "lattices", "rubber", of_rubber,
    ),
    Question(
        "cubes and cantilever in space, ratio 1/4", YES, "ratio 1/4, or a volume energy beside",
        "displacement", "solid", of_solids,
    ),
    Question(
        "Cook's membrane, whose outline the lattice misses", YES,
        "cut cells counted by their part inside",
        "benchmarks", "cook", of_cook("springs"), of_cook("FEM Q1"),
    ),
    Question(
        ordinary.CLAMPED.body, YES, other_support,
        "overview", "ordinary", of_ordinary(ordinary.CLAMPED),
    ),
    Question(
        ordinary.BRACKET.body, YES, thin_walls,
        "overview", "ordinary", of_ordinary(ordinary.BRACKET),
    ),
    Question(
        "Cook's membrane: the worst mesh tried", NO, "do not use: another material",
        "benchmarks", "cook_edges", of_cook("springs"), worst=True,
    ),
)  # fmt: skip


def judge(table: pd.DataFrame) -> tuple[kit.Tolerance, ...]:
    """What the tolerances judge, in their order."""
    good, other = (table[table["material"] == word] for word in ("yes", "no"))
    return (
        kit.Tolerance(
            "springs that are the material: error at the finest spacing, worst body", BAND, "1",
            "a lattice whose tensor is the material's converges to it; the finest of every body is "
            "some 20 spacings across or more in the plane, and 8 in space",
            layer="agreement",
            observed=kit.Observed(float(good["error_fine"].max())),
        ),
        kit.Tolerance(
            "springs that are the material: bodies whose error rises at a refinement", 0, "1",
            "refinement brings a consistent model nearer, until the reference's own error shows",
            observed=kit.Observed(float((good["rises"] > 0).sum())),
        ),
        kit.Tolerance(
            "springs that are another material: bodies that agree at the finest spacing", 0, "1",
            "a wrong tensor stays wrong, however many springs there are",
            observed=kit.Observed(float((other["verdict"] == AGREES).sum())),
        ),
    )  # fmt: skip


def findings(table: pd.DataFrame) -> tuple[str, ...]:
    """Where springs may be used, and where not."""
    good, other = (table[table["material"] == word] for word in ("yes", "no"))
    fine, most = good["error_fine"].max(), good["error_coarse"].max()
    still = " to ".join(dict.fromkeys(f"{other['error_fine'].agg(f):.0%}" for f in ("min", "max")))
    near = f"come within {fine:.1%} of elasticity at {across(good, 'fine')} cells across"
    far = f"at {across(good, 'coarse')} cells they are off by up to {most:.0%}"
    return (
        f"The best springs of {len(good)} bodies {near}; {far}.",
        f"Springs whose solid is another are off by {still} at {across(other, 'fine')} cells.",
    )


def across(rows: pd.DataFrame, end: str) -> str:
    """Fewest and most cells across at the coarse or the fine end of rows."""
    cells = rows[f"across_{end}"]
    return " to ".join(dict.fromkeys(f"{cells.agg(f):g}" for f in ("min", "max")))
