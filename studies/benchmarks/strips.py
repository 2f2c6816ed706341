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

from msvalidate import kit
from reference_fem.richardson import Estimate, refine

from . import curved
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


def _over_uncertainty(rows: pd.DataFrame) -> pd.Series:
    """Difference of elements and potentials over what both leave uncertain."""
    apart = rows["K_potentials"] / rows["K_elements"] - 1
    return apart / (rows["K_uncertainty"] + rows["potentials_uncertainty"])


RULES = (
    kit.Rule(
        "strips: uncertainty of elements, relative", ACCURACY, "1",
        "what is asked of them: a tenth of what they are to tell of Heywood's fit at d/W = 0.5",
        table="strips", value="K_uncertainty",
    ),
    kit.Rule(
        "strips: elements against Heywood's fit, relative", 0.03, "1",
        "the fit's own accuracy: known to be good to 1 % for narrow holes and to some more as the "
        "hole takes half of the width, where the ligaments bend",
        layer="agreement",
        table="strips", value="heywood_off",
    ),
    kit.Rule(
        "strips: springs against elements, relative", 0.02, "1",
        "as of the endless plate, with 12 cells per radius in place of 16: (16/12)² of 1 %",
        layer="agreement",
        table="strips", value="springs_off",
    ),
    kit.Rule(
        "strips: elements against potentials, relative to what both leave uncertain", 1.0, "1",
        "two ways to one value differ by no more than their uncertainties added up",
        table="strips", value=_over_uncertainty,
    ),
)  # fmt: skip
FIGURE = kit.series(
    "strips", title="Strips with a hole in tension: largest stress on the hole",
    x="d_over_W", line="", labels=("diameter over width, d/W (1)", "K_tn, over the net mean (1)"),
    y={"K_elements": "elements", "K_potentials": "Kolosov's potentials", "K_springs": "springs"},
    beside={"heywood": "Heywood's fit"}, size=(4.8, 3.6),
)  # fmt: skip


def run(
    candidate: kit.DisplacementSolver = kit.solve_springs, setting: kit.Setting = kit.FULL
) -> kit.Evidence:
    """Compare springs, elements, potentials and Heywood's fit."""
    widths = QUICK_WIDTHS if setting.quick else WIDTHS
    fine = QUICK_LATTICE if setting.quick else LATTICE
    table = pd.DataFrame(setting.sweep(partial(row, candidate, fine), widths, "strips"))
    return kit.Evidence(
        tables={"strips": table},
        tolerances=RULES,
        columns=kit.columns(__file__),
        figures={"strips": FIGURE},
        findings=(finding(table),),
    )


def problem(mesh: kit.Mesh) -> kit.Problem:
    """Quarter strip of half width 1 m, unit tension at its end."""
    return kit.Problem(
        mesh,
        kit.Isotropic(E=MODULUS, nu=curved.SPRINGS_ALONE),
        curved.quarter_supports(mesh),
        (kit.Traction(mesh.side("end"), (0.0, TENSION)),),
        name="strip with a hole",
    )


def row(candidate: kit.DisplacementSolver, cells: int, part: float) -> dict[str, object]:
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

    def stress(cells: int) -> kit.Array:
        mesh = holed_plate(part, 1.0, HALF_LENGTH, cells).mesh
        return np.asarray(curved.elastic(problem(mesh)).stress(np.array([[part, 0.0]]))[:, 1])

    return refine(stress, CELLS, ACCURACY * 3.0 * TENSION)


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
