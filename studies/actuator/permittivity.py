"""Permittivity: does it enter as the square of the voltage does?

Question   Displacement of the slab where the permittivity is not 1 F/m, as it is in the report.
Candidate  The actuator at rest at a voltage, in one medium all around.
Reference  The same slab at 1 F/m under as many times the voltage as the root of the permittivity;
           finite elements likewise.
Expected   Equal: charges are ε·V times a length, and forces ε·V² times one; nothing else asks for
           either. A permittivity that is left out changes the displacement by its own factor.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd

from msvalidate import kit

from .bodies import COVERED, ActuatorSolver, body, elastic, uniform_deflection, upper_face

PERMITTIVITY, VOLTAGE, LAYERS, MESH = 2.7, 0.1, 3, 4
"""F/m, V, and cells up the slab of springs and up that of elements."""
RULES = (
    kit.Rule(
        "displacement at 2.7 F/m over that at 1 F/m and √2.7 times the voltage, from 1", 1e-7, "1",
        "the same equation: rest is found to 1e-10 of the forces that meet at a point, which are "
        "at most some hundreds of times the electrodes' own",
        table="permittivity", value="over_scaled", reference=1.0,
    ),
)  # fmt: skip


def run(candidate: ActuatorSolver, setting: kit.Setting = kit.FULL) -> kit.Evidence:
    """Move both slabs at one permittivity and at the other."""
    rows = []
    for covered in COVERED:
        plain = body(covered, LAYERS)
        dense, scaled = replace(plain, permittivity=PERMITTIVITY), VOLTAGE * PERMITTIVITY**0.5
        top = upper_face(plain.network.points)
        for by, moved in (("springs", candidate), ("FEM", partial(elastic, MESH))):
            rows.append(row(covered, by, moved(dense, VOLTAGE)[top], moved(plain, scaled)[top]))
    table = pd.DataFrame(rows)
    return kit.Evidence(
        tables={"permittivity": table},
        tolerances=RULES,
        columns=kit.columns(__file__),
    )


def row(covered: str, solved_by: str, move: kit.Array, scaled: kit.Array) -> dict[str, object]:
    """Row of displacements (p, 2) in m of the upper face, at the permittivity and scaled."""
    largest = np.unravel_index(np.abs(scaled).argmax(), scaled.shape)
    middle = -float(move[len(move) // 2, 1])
    return {
        "covered": covered,
        "solved_by": solved_by,
        "permittivity": PERMITTIVITY,
        "over_uniform": middle / uniform_deflection(VOLTAGE, PERMITTIVITY),
        "over_scaled": float(move[largest] / scaled[largest]),
    }
