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
           shared between cells so are the meshes. A whole spring on an edge has half its constant
           too much: a bar of EA = χ/2 N m/m. To first order bars take the strain of the plate, 1 of
           two and -nu of two, and the stiffness is E + χ(1 + nu²)/N, 8/3 + (20/9)/N. The framed
           plate has the rest, but for the lattice's own error of order 2.
"""

from __future__ import annotations

import tomllib
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd

from msvalidate import kit

from . import published_membranes
from . import spring_meshes as meshes

with (Path(__file__).parent / "data" / "published_sources.toml").open("rb") as file:
    SOURCES = pd.DataFrame(tomllib.load(file)["source"])
QUICK = 32
"""Largest mesh of the small form."""
ROUNDING = float(4 * np.finfo(float).eps * max(meshes.PRINTED) ** 2)
rounded = partial(kit.Rule, unit="1", table="published")
RULES = (
    rounded(
        "published meshes: stiffness from the printed, relative", ROUNDING, value="from_printed",
        because="rounding of two solvers: four eps times the matrix's condition, which grows as "
        "N², 128²",
    ),
    rounded(
        "published closed forms: stiffness from the form, relative", 1e-12,
        table="published_forms", value="from_form",
        because="rounding: eps times the ratio of constants, 100, times the 32 unknowns of 3 x 3 "
        "cells",
    ),
    rounded(
        "published meshes, springs on edges shared: stiffness from elasticity, relative",
        ROUNDING, value="from_elastic",
        because="uniform tension is exact at any size: rounding as above",
    ),
    rounded(
        "published plate: finite elements from elasticity, relative", 1e-10,
        value=kit.Quotient("stiffness_fem", "stiffness_elastic"), reference=1.0,
        because="uniform stress is in the elements' space: a direct solve leaves 1e-13",
    ),
    rounded(
        "published meshes against the framed plate: order",
        float(np.log2((1 + meshes.PART) / (1 - meshes.PART))), last=2, value="from_framed",
        power_of=kit.Quotient(1, "cells"), reference=2.0,
        because="a lattice is of order 2; what the plate's uncertainty, 1/20 of each of two "
        "differences, may make of it",
    ),
    rounded(
        "published membranes, points held: area modulus over shear modulus", 1e-12,
        table="published_membrane", rows={"points": ("regular", *published_membranes.RANDOM)},
        value=kit.Quotient("area_held", "shear_held"), reference=2.0,
        because="Cauchy's relation holds spring by spring: rounding of sums over 4800 springs",
    ),
)  # fmt: skip
FIGURE = kit.series(
    "published", title="Squares of springs in tension: differences to elements",
    x="cells", labels=("cells along an edge, N (1)", "stiffer by, relative (1)"),
    y={"from_fem": "than a plate", "from_framed": "than a framed plate"},
    beside={"framed_uncertainty": "the framed plate's uncertainty"}, log="xy",
    level={meshes.WITHIN: "1 %"}, size=(5.4, 4.0),
)  # fmt: skip


def run(
    candidate: kit.DisplacementSolver = kit.solve_springs, setting: kit.Setting = kit.FULL
) -> kit.Evidence:
    """Make the published meshes and judge them."""
    wanted = [n for n in meshes.PRINTED if n <= QUICK or not setting.quick]
    rows = setting.sweep(partial(meshes.mesh_row, candidate), wanted, "published meshes")
    table = pd.DataFrame(rows)
    forms = pd.DataFrame(
        meshes.form_row(candidate, n, chi) for n in meshes.FORMS for chi in meshes.RATIOS
    )
    frame = kit.Tolerance(
        "published frame: first effect of weak bars, from χ(1 + nu²)", 1e-4, "1",
        "bars ten times as strong are off by ten times as much, 3e-4: the next order, 30 EA",
        observed=kit.Observed(meshes.weak_frame(), meshes.leading()),
    )  # fmt: skip
    claim, membrane = meshes.claimed(candidate), published_membranes.measure(setting)
    return kit.Evidence(
        tables={
            "published": table,
            "published_claim": claim,
            "published_forms": forms,
            "published_membrane": membrane,
            "published_sources": SOURCES,
        },
        tolerances=(*RULES, frame),
        columns=kit.columns(__file__),
        figures={"published": FIGURE},
        findings=(
            describe_confirmed(table, forms),
            describe_claim(claim),
            reason(table),
            published_membranes.finding(membrane),
            describe_missing(),
        ),
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
        f"{effect:.3f}/N N/m at many. With these springs shared the meshes tried are exact, to "
        f"{table['from_elastic'].abs().max():.0e}. Finite elements of a plate framed by such bars "
        f"are met to {last['from_framed']:.0e} at {rows.index[-1]} cells, with order 2."
    )


def describe_missing() -> str:
    """Of which papers there is nothing here."""
    without = SOURCES["paper"][SOURCES["used"] == "none"]
    return (
        "Numbers of refereed papers that could not be had, so that nothing of them is compared: "
        f"{'; '.join(without)}."
    )
