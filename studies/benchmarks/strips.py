"""Strips: what does a circular hole do to a plate of a finite width (Heywood)?

Question   Largest stress on the hole of a strip in tension, of which the hole takes 0.1 to 0.5 of
           the width, over the mean stress of the net section: K_tn.
Candidate  Square cells cut to the outline, springs alone (nu = 1/3).
Reference  Quadratic elements, and Kolosov's potentials as another way to the same value. Beside
           them Heywood's K_tn = 2 + (1 - d/W)³ [Heywood1952], a fit to measurements and series.
Expected   Elements and potentials agree within what both leave uncertain. Heywood is no limit that
           meshes go to: the table says how far it is from elements. A strip three times as long as
           wide is endless: what its ends do decays as exp(-4.2 y/W) on its way to the hole, and as
           much on its way back.
"""

from __future__ import annotations

from functools import partial

import numpy as np
import pandas as pd

from msvalidate.judging.candidate import DisplacementSolver, solve_springs
from msvalidate.judging.compare import farthest_value
from msvalidate.judging.evidence import Evidence, Observed, Tolerance, by_quantity
from msvalidate.judging.sweep import FULL, Setting
from msvalidate.problem import Array, Isotropic, Mesh, Problem, Traction
from reference_fem.refinement import Estimate, refine

from . import curved, strips_drawing
from .potentials import holed_strip
from .shapes import holed_plate

MODULUS, TENSION = 1e6, 1.0
OUTLINE = 16
"""As in `ellipse`."""
WIDTHS, QUICK_WIDTHS = (0.1, 0.2, 0.3, 0.4, 0.5), (0.3, 0.5)
"""d/W."""
HALF_LENGTH = 3.0
"""In half widths."""
CELLS, ACCURACY = 4, 2e-3
"""Cells round an eighth of the hole to start from; accuracy asked for, relative."""
LATTICE, QUICK_LATTICE = 120, 40
"""Springs: cells per half width; the narrowest hole has 12 of them in its radius, in
either form."""
TERMS = (20, 24)
"""Of the potentials; what fewer miss of more is their uncertainty. The powers of more terms are
dependent but for rounding, and what least squares make of them goes by the processor: of 30 terms
K_tn by 3e-7 of it, of 24 by 1e-8."""
DEPENDENT = 1e-7
"""Rounding of that uncertainty, which is 4e-6 or more: ten times what rounding leaves of K_tn."""
TOLERANCES = (
    Tolerance(
        "strips: uncertainty of elements, relative", ACCURACY, "1",
        "what is asked of them: a tenth of what they are to tell of Heywood's fit at d/W = 0.5",
    ),
    Tolerance(
        "strips: elements against potentials, relative to what both leave uncertain", 1.0, "1",
        "two ways to one value differ by no more than their uncertainties added up",
    ),
    Tolerance(
        "strips: elements against Heywood's fit, relative", 0.03, "1",
        "the fit's own accuracy: known to be good to 1 % for narrow holes and to some more as the "
        "hole takes half of the width, where the ligaments bend",
        layer="agreement",
    ),
    Tolerance(
        "strips: springs against elements, relative", 0.02, "1",
        "as of the endless plate, with 12 cells per radius in place of 16: (16/12)² of 1 %",
        layer="agreement",
    ),
)  # fmt: skip
COLUMNS = {
    "d_over_W": "diameter of the hole over the strip's width (1)",
    "heywood": "K_tn of Heywood's fit: largest stress over the net section's mean (1)",
    "K_elements": "K_tn by Q2 on the finest mesh (1)",
    "K_uncertainty": "how far K_elements may be off, relative, by Richardson's rule (1)",
    "K_potentials": "K_tn by Kolosov's potentials (1)",
    "potentials_uncertainty": "what 20 terms miss of 24, relative, or the traction missed on the "
    "sides over the largest stress, if that is more (1)",
    "K_springs": "K_tn by springs, quartic fit (1)",
    "heywood_off": "heywood over K_elements, less 1 (1)",
    "springs_off": "K_springs over K_elements, less 1 (1)",
}


def run(candidate: DisplacementSolver = solve_springs, setting: Setting = FULL) -> Evidence:
    """Compare springs, elements, potentials and Heywood's fit."""
    widths = QUICK_WIDTHS if setting.quick else WIDTHS
    fine = QUICK_LATTICE if setting.quick else LATTICE
    table = pd.DataFrame(setting.sweep(partial(row, candidate, fine), widths, "strips"))
    return Evidence(
        tables={"strips": table},
        observed=observe(table),
        tolerances=TOLERANCES,
        columns=COLUMNS,
        figures={"strips": strips_drawing.strips},
        findings=(finding(table),),
        rounding={"potentials_uncertainty": DEPENDENT},
    )


def problem(mesh: Mesh) -> Problem:
    """Quarter strip of half width 1 m, unit tension at its end."""
    return Problem(
        mesh,
        Isotropic(E=MODULUS, nu=curved.SPRINGS_ALONE),
        curved.quarter_supports(mesh),
        (Traction(mesh.side("end"), (0.0, TENSION)),),
        name="strip with a hole",
    )


def row(candidate: DisplacementSolver, cells: int, part: float) -> dict[str, object]:
    """One row of the table, of a hole that takes this part of the width.

    `cells`: of the springs' lattice, per half width.
    """
    net = 1 - part
    elements = estimate(part)
    by_elements = net * float(elements.value[0])
    fewer, more = (holed_strip(part, HALF_LENGTH, terms) for terms in TERMS)
    values = [each.sum(complex(part)) for each in (fewer, more)]
    body = curved.spring_body(
        candidate, problem(holed_plate(part, 1.0, HALF_LENGTH, OUTLINE).mesh), 1 / cells
    )
    by_springs = net * float(body.stress(np.array([[part, 0.0]]), "quartic")[0, 1]) / TENSION
    heywood = 2 + net**3
    return {
        "d_over_W": part,
        "heywood": heywood,
        "K_elements": by_elements,
        "K_uncertainty": float(elements.uncertainty[0] / elements.value[0]),
        "K_potentials": net * values[1],
        "potentials_uncertainty": max(abs(values[0] / values[1] - 1), more.missed / values[1]),
        "K_springs": by_springs,
        "heywood_off": heywood / by_elements - 1,
        "springs_off": by_springs / by_elements - 1,
    }


def estimate(part: float) -> Estimate:
    """Stress (Pa) across the hole of a strip by finite elements, refined, with its uncertainty."""

    def stress(cells: int) -> Array:
        mesh = holed_plate(part, 1.0, HALF_LENGTH, cells).mesh
        return np.asarray(curved.elastic(problem(mesh)).stress(np.array([[part, 0.0]]))[:, 1])

    return refine(stress, CELLS, ACCURACY * 3.0 * TENSION)


def observe(table: pd.DataFrame) -> dict[str, Observed]:
    """The judged quantities."""
    apart = (table["K_potentials"] / table["K_elements"] - 1).abs()
    values = (
        farthest_value(table["K_uncertainty"], 0.0),
        farthest_value(apart / (table["K_uncertainty"] + table["potentials_uncertainty"]), 0.0),
        farthest_value(table["heywood_off"], 0.0),
        farthest_value(table["springs_off"], 0.0),
    )
    return by_quantity(TOLERANCES, values)


def finding(table: pd.DataFrame) -> str:
    """How far springs and Heywood's fit are off."""
    off = ", ".join(
        f"{100 * each['heywood_off']:+.2g} % at d/W = {each['d_over_W']:g}"
        for each in table.to_dict("records")
    )
    return (
        f"Heywood's fit for strips is off by {off}; springs by at most "
        f"{100 * table['springs_off'].abs().max():.2g} %."
    )
