"""Judged: which solid is the candidate, and what of its answers has no cause?

Question   Does the candidate pass the gate, which law does one step of it show, and what do its
           bodies at rest miss of elasticity?
Candidate  A simulator asked for E = 10 MPa and a ratio of 0.3.
Reference  What it was asked for; linear elements of the law read, on the same mesh.
Expected   The law that was asked for within what the probe knows (0.5 %), each node's own share of
           mass, and bodies within 1 % of what law, mass and mesh predict.
"""

from __future__ import annotations

import math

import pandas as pd

from msvalidate import kit
from msvalidate.simulators.exchange.protocol import Simulator
from msvalidate.simulators.probe.reading import BAND, SHOWN
from msvalidate.simulators.verdict.judgement import Judgement, judge_simulator

from .gaps import fill_gaps, with_none

ASKED = kit.Isotropic(1e7, 0.3, "solid", 1000.0)
MESHES = ("tet4", "tet4_2")
NONE = 1e3
"""Stands for a number that the candidate does not let be read: beyond every limit."""
COLUMNS = {
    "body": "pulled, sheared or bent",
    "case": "case of the frozen set",
    "mesh": "its mesh",
    "error": "largest difference from elasticity, over the largest displacement (1)",
    "modulus_on_mesh": "modulus of the linear elements on the same mesh that are nearest (Pa)",
    "ratio_on_mesh": "their ratio (1)",
    "law_factor": "times the displacement, by the law read",
    "resolution_factor": "times the displacement, by linear elements on this mesh",
    "mass_factor": "times the displacement, by the masses read",
    "solver_factor": "times the displacement, by what more iterations or smaller steps change",
    "not_explained_factor": "times the displacement, by what is left",
    "apart": "largest difference from what the causes predict, over the largest displacement (1)",
}


FACTORS = ("law", "resolution", "mass", "solver", "left", "apart")
"""Of `Factors`, in the order of their columns."""


def run(candidate: Simulator) -> kit.Evidence:
    """Judge the candidate."""
    found = judge_simulator(candidate, ASKED, meshes=MESHES)
    table = pd.DataFrame(body_rows(found), columns=[*COLUMNS])
    return kit.Evidence(
        tables={"judged": fill_gaps(table)} if len(table) else {},
        tolerances=judge(found),
        columns=with_none(COLUMNS, *list(COLUMNS)[4:]),
        rounding=dict.fromkeys(
            (
                "error", "ratio_on_mesh", "law_factor", "resolution_factor", "mass_factor",
                "solver_factor", "not_explained_factor", "apart",
            ),
            1e-8,
        )
        | {"modulus_on_mesh": 0.1},
    )  # fmt: skip


def body_rows(found: Judgement) -> list[dict[str, object]]:
    """Rows of the table of bodies."""
    rows = []
    for row in found.bodies:
        factors = row.factors
        parts = (
            (math.nan,) * 6
            if factors is None
            else (
                factors.law,
                factors.resolution,
                factors.mass,
                factors.solver,
                factors.left,
                factors.apart,
            )
        )
        values = (
            row.body, row.case, row.mesh, row.error, row.on_mesh.E, row.on_mesh.nu, *parts,
        )  # fmt: skip
        rows.append(dict(zip(COLUMNS, values, strict=True)))
    return rows


def judge(found: Judgement) -> tuple[kit.Tolerance, ...]:
    """What the judgement of a simulator says of each quantity."""
    reading = found.reading
    E = NONE if reading is None or reading.E is None else reading.E / found.asked.E
    nu = NONE if reading is None or reading.nu is None else reading.nu
    masses = None if reading is None else reading.masses
    told = reading is not None and reading.is_valid
    off = masses.off if masses is not None else (0.0 if told else NONE)
    apart = [NONE if row.factors is None else row.factors.apart for row in found.bodies]
    return (
        kit.Tolerance(
            "judged: rows of the gate that stop it", 0, "1", "nothing of a stopped one counts",
            observed=kit.Observed(float(len(found.gate.stops) or not found.gate.passed)),
        ),
        kit.Tolerance(
            "judged: modulus read by the probe, over the asked", SHOWN, "1",
            "the probe shows no number that it does not know to this",
            observed=kit.Observed(E, 1.0),
        ),
        kit.Tolerance(
            "judged: ratio read by the probe", SHOWN, "1", "as the modulus",
            observed=kit.Observed(nu, found.asked.nu),
        ),
        kit.Tolerance(
            "judged: largest mass of a node over the asked, less 1", BAND, "1",
            "masses are read to 0.001; a node of another cell's share is off by a third and more",
            observed=kit.Observed(off),
        ),
        kit.Tolerance(
            "judged: largest part of bodies at rest that no cause explains", BAND, "1",
            "small strains of a thousandth, both signs averaged, leave a hundred thousandth",
            observed=kit.Observed(max(apart, default=NONE)),
        ),
    )  # fmt: skip
