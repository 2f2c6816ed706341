"""Published: is a published table of spring meshes found again, row by row, and why is it so?

Question   The apparent stiffness of N x N meshes of springs in uniaxial tension: total force over
           mean elongation. Sides of cells have χ N/m, diagonals 1 N/m, loads and elongations of
           corner points count half. Is it as printed, and what sets it apart from elasticity?
Candidate  Linear equilibrium of the same network: `square`, its springs on edges whole ("equal").
Reference  S. Brisard, "What is homogenization? Part 5", "Symbolic analysis of a spring mesh" and
           "Numerical analysis of a spring mesh", sbrisard.github.io, May 2021: eight numbers for
           χ = 2 printed in full, and closed forms for N = 1, 2, 3 and any χ. A blog: not refereed,
           but complete. Beside them elasticity, E = χ(χ + 2)/(χ + 1) and nu = 1/(1 + χ) in N/m,
           and finite elements of the plate, bare and framed by bars. Refereed papers with tables of
           springs against finite elements could not be had beyond their first pages; the table
           `published_sources` says which, and what is used of each: of one its abstract's moduli,
           see `published_membranes`.
Expected   The printed numbers to rounding. Elasticity at χ = 2 is 8/3, and with springs on edges
           shared between cells so is every mesh. A whole spring on an edge has half its constant
           too much: a bar of EA = χ/2 N m/m. To first order bars take the strain of the plate, 1 of
           two and -nu of two, and the stiffness is E + χ(1 + nu²)/N, 8/3 + (20/9)/N. The framed
           plate has the rest, but for the lattice's own error of order 2.
"""

from __future__ import annotations

from functools import partial

import numpy as np
import pandas as pd

from msvalidate.judging.candidate import DisplacementSolver, solve_springs
from msvalidate.judging.compare import farthest_value, observed_order
from msvalidate.judging.evidence import Evidence, Observed, Tolerance, by_quantity
from msvalidate.judging.sweep import FULL, Setting

from . import cases, published_drawing, published_membranes, published_sources
from . import spring_meshes as meshes

QUICK = 32
"""Largest mesh of the small form."""
ROUNDING = float(4 * np.finfo(float).eps * max(meshes.PRINTED) ** 2)
TOLERANCES = (
    Tolerance(
        "published meshes: stiffness from the printed, relative", ROUNDING, "1",
        "rounding of two solvers: four eps times the matrix's condition, which grows as N², 128²",
    ),
    Tolerance(
        "published closed forms: stiffness from the form, relative", 1e-12, "1",
        "rounding: eps times the ratio of constants, 100, times the 32 unknowns of 3 x 3 cells",
    ),
    Tolerance(
        "published meshes, springs on edges shared: stiffness from elasticity, relative",
        ROUNDING, "1",
        "uniform tension is exact at any size: rounding as above",
    ),
    Tolerance(
        "published plate: finite elements from elasticity, relative", 1e-10, "1",
        "uniform stress is in the elements' space: a direct solve leaves 1e-13",
    ),
    Tolerance(
        "published frame: first effect of weak bars, from χ(1 + nu²)", 1e-4, "1",
        "bars ten times as strong are off by ten times as much, 3e-4: the next order, 30 EA",
    ),
    Tolerance(
        "published meshes against the framed plate: order",
        float(np.log2((1 + meshes.PART) / (1 - meshes.PART))), "1",
        "a lattice is of order 2; what the plate's uncertainty, 1/20 of each of two differences, "
        "may make of it",
    ),
    published_membranes.TOLERANCE,
)  # fmt: skip
COLUMNS = {
    **published_sources.COLUMNS,
    **published_membranes.COLUMNS,
    "cells": cases.COLUMNS["cells"],
    "chi": "constant of springs along sides over that of diagonals, χ (1)",
    "stiffness_printed": "apparent stiffness as printed (N/m)",
    "stiffness": "the same of the candidate's network, springs on edges whole (N/m)",
    "from_printed": "stiffness over stiffness_printed, less 1 (1)",
    "stiffness_elastic": "of the elastic plate in closed form (N/m)",
    "stiffness_bars": "stiffness_elastic and the first effect of bars, χ(1 + nu²)/N (N/m)",
    "stiffness_fem": "of the elastic plate by finite elements (N/m)",
    "from_fem": "stiffness over stiffness_fem, less 1 (1)",
    "stiffness_framed": "of the plate with a bar along each edge, by finite elements (N/m)",
    "framed_uncertainty": "of stiffness_framed, relative (1)",
    "from_framed": "stiffness over stiffness_framed, less 1 (1)",
    "stiffness_shared": "of the candidate's network, springs on edges shared: half (N/m)",
    "from_elastic": "stiffness_shared over stiffness_elastic, less 1 (1)",
    "too_stiff": "stiffness of the candidate's network over the plate's, less 1 (1)",
    "too_stiff_printed": 'the same of the number as printed, or "not printed" (1)',
    "stiffness_form": "apparent stiffness by the printed closed form (N/m)",
    "from_form": "stiffness over stiffness_form, less 1 (1)",
}


ROUNDED = {
    **dict.fromkeys(("from_printed", "from_elastic", "from_fem", "too_stiff"), ROUNDING),
    **dict.fromkeys(("stiffness", "stiffness_shared"), 3 * ROUNDING),
    **dict.fromkeys(("stiffness_framed", "framed_uncertainty", "from_framed"), 1e-9),
    "stiffness_fem": 1e-10,
    "from_form": 1e-12,
    **dict.fromkeys(("shear_modulus", "area_modulus", "shear_held", "area_held"), 1e-10),
    **dict.fromkeys(("area_over_shear", "membrane_scatter"), 1e-9),
}
"""Sizes below which values are rounding."""


def run(candidate: DisplacementSolver = solve_springs, setting: Setting = FULL) -> Evidence:
    """Make the published meshes and judge them."""
    wanted = [n for n in meshes.PRINTED if n <= QUICK or not setting.quick]
    rows = setting.sweep(partial(meshes.mesh_row, candidate), wanted, "published meshes")
    table = pd.DataFrame(rows)
    forms = pd.DataFrame(
        meshes.form_row(candidate, n, chi) for n in meshes.FORMS for chi in meshes.RATIOS
    )
    claim, membrane = meshes.claimed(candidate), published_membranes.measure(setting)
    values = observe(table, forms, membrane)
    return Evidence(
        tables={
            "published": table,
            "published_claim": claim,
            "published_forms": forms,
            "published_membrane": membrane,
            "published_sources": published_sources.table(),
        },
        observed=by_quantity(TOLERANCES, values),
        tolerances=TOLERANCES,
        columns=COLUMNS,
        figures={"published": published_drawing.draw},
        findings=(
            describe_confirmed(table, forms),
            describe_claim(claim),
            reason(table),
            published_membranes.finding(membrane),
            describe_missing(),
        ),
        rounding=ROUNDED,
    )


def observe(
    table: pd.DataFrame, forms: pd.DataFrame, membrane: pd.DataFrame
) -> tuple[Observed, ...]:
    """One value for each of `TOLERANCES`."""
    last = table.iloc[-2:]
    return (
        farthest_value(table["from_printed"], 0.0),
        farthest_value(forms["from_form"], 0.0),
        farthest_value(table["from_elastic"], 0.0),
        farthest_value(table["stiffness_fem"] / table["stiffness_elastic"] - 1, 0.0),
        Observed(meshes.weak_frame(), meshes.leading()),
        Observed(observed_order(1 / last["cells"].to_numpy(float), last["from_framed"]), 2.0),
        published_membranes.observe(membrane),
    )


def describe_confirmed(table: pd.DataFrame, forms: pd.DataFrame) -> str:
    """What was found of the published numbers."""
    return (
        f"Brisard's printed table of spring meshes is found again in each of {len(table)} rows, to "
        f"{table['from_printed'].abs().max():.0e}; so are the printed closed forms of 1, 2 and 3 "
        f"cells, at {forms['chi'].nunique()} ratios of constants, to "
        f"{forms['from_form'].abs().max():.0e}."
    )


def describe_claim(claim: pd.DataFrame) -> str:
    """What was found of the text about the numbers."""
    first = claim["cells"].iloc[-1]
    verdict = "Confirmed" if first <= meshes.CLAIMED else "Not confirmed"
    return (
        f"{verdict}: the text that {meshes.CLAIMED} cells bring the error within 1 %. They are "
        f"{100 * claim['too_stiff'][0]:.2f} % too stiff here, and "
        f"{100 * claim['too_stiff_printed'][0]:.2f} % as printed; the first mesh within 1 % has "
        f"{first} cells."
    )


def reason(table: pd.DataFrame) -> str:
    """Why the published meshes approach elasticity slowly."""
    rows = table.set_index("cells")
    last = rows.iloc[-1]
    effect = rows.index[-1] * (last["stiffness_bars"] - last["stiffness_elastic"])
    return (
        "The slow approach to elasticity is no property of the lattice but of springs on edges "
        f"that keep their whole constant: {100 * rows['from_fem'][8]:.1f} % too stiff at 8 cells, "
        f"{effect:.3f}/N N/m at many. With these springs shared every mesh is exact, to "
        f"{table['from_elastic'].abs().max():.0e}. Finite elements of a plate framed by such bars "
        f"are met to {last['from_framed']:.0e} at {rows.index[-1]} cells, with order 2."
    )


def describe_missing() -> str:
    """Of which papers there is nothing here."""
    return (
        "Numbers of refereed papers that could not be had, so that nothing of them is compared: "
        f"{'; '.join(published_sources.without_numbers())}."
    )
