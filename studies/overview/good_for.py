"""What springs are good for: at most eight rows to choose by.

Question   For the bodies that the studies look at: which lattice and rule is best, how far is it
           from elasticity at a coarse and a fine spacing, and on what condition?
Candidate  What the other studies found, and the part of this one.
Reference  As in those studies.
Expected   Springs whose solid is the material agree, better with every refinement. Springs whose
           solid is another one differ, however fine they are.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from msvalidate.judging.compare import NOT_ASKED
from msvalidate.judging.evidence import Evidence, Observed, Tolerance, by_quantity
from msvalidate.output.results import Results
from msvalidate.problem import SolverError
from msvalidate_check.words import AGREES, NOT_RESOLVED, agreement

from . import part

BAND = 0.05
"""What an engineer takes for agreement of displacements, as in the study `displacement`."""
ONE_PERCENT, TWENTY = 0.01, 20
NEGLIGIBLE = 1e-3
"""A thousandth of the displacement: references are known to that."""
HALF = "half springs on the boundary"
TOLERANCES = (
    Tolerance(
        "springs that are the material: error at the finest spacing, worst body", BAND, "1",
        "a lattice whose tensor is the material's converges to it; the finest of every body is "
        "some 20 spacings across or more in the plane, and 8 in space",
        layer="agreement",
    ),
    Tolerance(
        "springs that are the material: bodies whose error rises at a refinement", 0, "1",
        "refinement brings a consistent model nearer, until the reference's own error shows",
    ),
    Tolerance(
        "springs that are another material: bodies that agree at the finest spacing", 0, "1",
        "a wrong tensor stays wrong, however many springs there are",
    ),
)  # fmt: skip
COLUMNS = {
    "body": "what was loaded, or the question",
    "springs": "the best lattice and rule that were tried for it, or the usual ones where it warns",
    "material": 'whether the springs\' solid is the material: "yes" or "no"',
    "across_coarse": "cells or spacings across, few (1)",
    "error_coarse": "difference from linear elasticity at that, over the displacement (1)",
    "error_at_20": "the same at 20 across, on the line of errors in logarithms, or "
    '"not asked" beyond its ends (1)',
    "across_fine": "cells or spacings across, many (1)",
    "error_fine": "difference from linear elasticity at that, over the displacement (1)",
    "rises": "refinements at which the error rises, beyond a thousandth (1)",
    "verdict": f'"agrees" within {BAND:g} at the fine spacing, else "differs"',
    "condition": "what must hold for it",
    "cells_over_linear": "cells across for an error of 1 % over those of linear quadrilaterals on "
    f'the same body; "never" where more do not help, "{NOT_RESOLVED}" where 1 % is beyond the '
    f'sizes looked at, "{NOT_ASKED}" where elements were not (1)',
    "time_over_linear_here": "the same of seconds from the problem to the displacement, or "
    f'"never", "{NOT_RESOLVED}" or "{NOT_ASKED}" (1)',
    "study": "that found it",
    "table": "of that study",
    "taken_from_here": "this run, stored results, or the committed baseline",
}
LINEAR_PARTS = ("boundary", "discretisation", "model_form")
"""Of the budget of errors in `displacement`."""
Line = dict[float, float]
"""Cells across -> error, positive."""


@dataclass(frozen=True)
class Question:
    """A row: where its errors are; of linear elements on the same body, and who was timed."""

    body: str
    springs: str
    material: bool
    condition: str
    study: str
    table: str
    errors: Callable[[pd.DataFrame], Line]
    linear: Callable[[pd.DataFrame], Line] | None = None
    model: str | None = None


def run(results: Results, own: Mapping[str, pd.DataFrame]) -> Evidence:
    """The rows, from the studies' tables; `own` are those of this study."""
    table = pd.DataFrame([row(question, results, own) for question in QUESTIONS])
    return Evidence(
        tables={"good_for": table},
        observed=by_quantity(TOLERANCES, observe(table)),
        tolerances=TOLERANCES,
        columns=COLUMNS,
        findings=findings(table),
        rounding={
            "error_at_20": 1e-7,
            "error_coarse": 1e-7,
            "error_fine": 1e-7,
            "cells_over_linear": 1e-5,
        },
    )


def row(question: Question, results: Results, own: Mapping[str, pd.DataFrame]) -> dict[str, object]:
    """One row of the table."""
    mine = question.study == "overview"
    found = own[question.table] if mine else results.table(question.study, question.table)
    errors = dict(sorted(question.errors(found).items()))
    if len(errors) < 2:
        raise SolverError(f"{question.study}/{question.table}: too few sizes of {question.springs}")
    (coarse, first), (fine, last) = list(errors.items())[:: len(errors) - 1]
    return {
        "body": question.body,
        "springs": question.springs,
        "material": "yes" if question.material else "no",
        "across_coarse": int(coarse),
        "error_coarse": first,
        "error_at_20": at_cells(TWENTY, errors),
        "across_fine": int(fine),
        "error_fine": last,
        "verdict": agreement(last, 0.0, BAND),
        "rises": rises(errors),
        "condition": question.condition,
        "cells_over_linear": over_linear(question, errors, found),
        "time_over_linear_here": times_over_linear(question, found),
        "study": question.study,
        "table": question.table,
        "taken_from_here": "this run" if mine else results.source(question.study),
    }


def over_linear(question: Question, errors: Line, found: pd.DataFrame) -> float | str:
    """Cells across that 1 % takes, over those of linear elements."""
    if question.linear is None:
        return NOT_ASKED
    linear = dict(sorted(question.linear(found).items()))
    return over(*(cost_of_one_percent(line, list(line)) for line in (errors, linear)))


def times_over_linear(question: Question, found: pd.DataFrame) -> float | str:
    """Seconds that 1 % takes, over those of linear elements, where both were timed."""
    if question.model is None or "solve_seconds" not in found:
        return NOT_ASKED
    parts = (found[found["model"] == name] for name in (question.model, part.LINEAR[1]))
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


def worst(table: pd.DataFrame, across: str, error: str) -> Line:
    """Cells across -> largest error of all rows of that many."""
    sizes = table[error].astype(float).abs().groupby(table[across].astype(float)).max()
    return dict(zip(sizes.index.to_list(), sizes.to_list(), strict=True))


def of_part(model: str) -> Callable[[pd.DataFrame], Line]:
    """Errors of a model of the part."""
    return lambda table: worst(table[table["model"] == model], "across", "error")


def of_cook(method: str) -> Callable[[pd.DataFrame], Line]:
    """Errors of a method on Cook's membrane."""
    return lambda table: worst(table[table["method"] == method], "cells", "against_limit")


def of_load_cases(ratio: float, weights: str) -> Callable[[pd.DataFrame], Line]:
    """Worst probe of the report's load cases on square cells with k2 = `ratio` k1.

    Of the difference from the target, what linear equilibria have: the part of large displacements
    and of motion left over is another question.
    """

    def errors(table: pd.DataFrame) -> Line:
        alike = np.isclose(table["k2"].astype(float), ratio * table["k1"].astype(float))
        mine = table[alike & (table["lattice"] == "square") & (table["weights"] == weights)]
        linear = sum(mine[name].astype(float) for name in LINEAR_PARTS)
        return worst(mine.assign(linear=linear), "cells_y", "linear")

    return errors


def of_rubber(table: pd.DataFrame) -> Line:
    """Bent block, nearly incompressible, the largest ratio there is."""
    plane = table[(table["state"] == "plane_strain") & (table["model"] == "square")]
    nearest = plane[plane["nu_rubber"] == plane["nu_rubber"].max()]
    return worst(nearest, "cells_through", "deflection_difference")


def of_solids(table: pd.DataFrame) -> Line:
    """Worst case in space of the lattice that is isotropic, of the sizes that every case has."""
    mine = table[table["lattice"] == "cubic 18"]
    cases = mine.groupby("cells_high")["case"].nunique()
    shared = cases[cases == mine["case"].nunique()].index
    return worst(mine[mine["cells_high"].isin(shared)], "cells_high", "against_own_body")


QUESTIONS = (
    Question(
        "block of ratio 0.4 in plane strain, clamped and sheared",
        part.VOLUME, True, f"any ratio below 1/2; {HALF}",
        "overview", "part", of_part(part.VOLUME), of_part("Q1 elements"), part.VOLUME,
    ),
    Question(
        "pressure, shear and bending in the plane, ratio 1/3",
        "square, central springs, k2 = k1/2", True, f"ratio 1/3 only; {HALF}",
        "displacement", "cases", of_load_cases(0.5, "shared"),
    ),
    Question(
        "bent rubber block, ratio 0.4999 in plane strain",
        "square, springs and volume energy", True, f"{HALF}; linear elements lock here",
        "lattices", "rubber", of_rubber,
    ),
    Question(
        "cubes and cantilever in space, ratio 1/4",
        "cubic with 18 neighbours, central springs", True, "ratio 1/4, or a volume energy beside",
        "displacement", "solid", of_solids,
    ),
    Question(
        "Cook's membrane: a slanted outline that the lattice misses",
        "square lattice cut to the outline", True, "cut cells counted by their part inside",
        "benchmarks", "cook", of_cook("springs, square, cut"), of_cook("FEM Q1"),
    ),
    Question(
        "the same block of ratio 0.4, random points",
        part.EVEN, False, "do not use: a ratio of its own, and scatter from draw to draw",
        "overview", "part", of_part(part.EVEN), of_part("Q1 elements"), part.EVEN,
    ),
    Question(
        "Cook's membrane: a spring on every edge of a triangle mesh",
        "equal springs on mesh edges", False, "do not use: the mesh decides the material",
        "benchmarks", "cook", of_cook("springs, edges of triangles"), of_cook("FEM Q1"),
    ),
    Question(
        "pressure, shear and bending, asked to be incompressible",
        "square, k2 = 2 k1, full springs on the boundary", False,
        "do not use: another material, stiffened at its edges",
        "displacement", "cases", of_load_cases(2.0, "equal"),
    ),
)  # fmt: skip


def observe(table: pd.DataFrame) -> list[Observed]:
    """What the tolerances judge, in their order."""
    good, other = (table[table["material"] == word] for word in ("yes", "no"))
    return [
        Observed(float(good["error_fine"].max())),
        Observed(float((good["rises"] > 0).sum())),
        Observed(float((other["verdict"] == AGREES).sum())),
    ]


def findings(table: pd.DataFrame) -> tuple[str, ...]:
    """Where springs may be used, and where not."""
    good, other = (table[table["material"] == word] for word in ("yes", "no"))
    finest, most = good["error_fine"].max(), good["error_coarse"].max()
    left, still = other["error_fine"].min(), other["error_fine"].max()
    near = f"come within {finest:.1%} of elasticity on the finest lattice of every body"
    return (
        f"Springs whose solid is the material {near}; the coarsest are off by up to {most:.0%}.",
        f"Springs whose solid is another are off by {left:.0%} to {still:.0%} on the finest.",
    )
