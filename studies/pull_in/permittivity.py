"""Permittivity: is a slab of another permittivity pulled in where theory has it?

Question   Thickness and pull-in where the permittivity is not 1 F/m, of a slab between walls and of
           a bonded one.
Candidate  A way to rest at a voltage.
Reference  V² = 2h²l²P(l)/ε: the closed form at 1 F/m, its voltages divided by the root of the
           permittivity; finite elements between plates; the bonded slab at 1 F/m and as many times
           the voltage.
Expected   Equal: forces are ε·V² times a length, and nothing else asks for either.
"""

from __future__ import annotations

from dataclasses import replace

import pandas as pd

from msvalidate import kit
from msvalidate.dielectric.actuator import uniform
from reference_fem.actuator import SoftSlab, equilibrium_at
from reference_fem.electric import facing_slab
from reference_fem.large_strain import square_fibres

from .branches import closed
from .slab import AXIAL, DIAGONAL, HEIGHT, PULL_IN
from .way import PullInSolver, bonded, middle, sliding

OTHER = 2.7
"""F/m; the rest of the study has `slab.PERMITTIVITY`."""
PART, BONDED_PART = 0.9, 0.3
"""Voltages over the pull-in voltage, between walls and of the bonded slab."""
WALLED_LAYERS, BONDED_LAYERS = 5, 3
RULES = (
    kit.Rule(
        "thickness at another permittivity against that at 1 F/m, voltages by their root",
        1e-7, "1",
        "the same equation; equilibrium to 1e-10 of the forces, over the stiffness that is left at "
        "0.9 of pull-in, a fifth of the first",
        table="permittivity", value="thickness", reference="thickness_scaled",
    ),
)  # fmt: skip


def run(candidate: PullInSolver, setting: kit.Setting) -> kit.Evidence:
    """Press two slabs, and elements between plates."""
    volts = PART * PULL_IN.voltage / OTHER**0.5
    low = BONDED_PART * PULL_IN.voltage / OTHER**0.5
    short = bonded(BONDED_LAYERS)
    exact = closed(PART * PULL_IN.voltage)
    pressed = replace(sliding(WALLED_LAYERS), permittivity=OTHER)
    seen = {
        "between walls, springs": (middle(candidate.at_voltage(pressed, volts)), exact, volts),
        "between walls, elements": (elements(volts), exact, volts),
        "bonded, springs": (
            middle(candidate.at_voltage(replace(short, permittivity=OTHER), low)),
            middle(candidate.at_voltage(short, BONDED_PART * PULL_IN.voltage)),
            low,
        ),
    }
    table = pd.DataFrame(
        {
            "body": body,
            "permittivity": OTHER,
            "voltage": voltage,
            "thickness": thickness,
            "thickness_scaled": scaled,
        }
        for body, (thickness, scaled, voltage) in seen.items()
    )
    top = uniform.pull_in(height=HEIGHT, axial=AXIAL, diagonal=DIAGONAL, permittivity=OTHER)
    own = (
        kit.Tolerance(
            "pull-in voltage in closed form at another permittivity, times its root, from 1",
            1e-12, "1",
            "one product: rounding",
            observed=kit.Observed(top.voltage * OTHER**0.5 / PULL_IN.voltage, 1.0),
        ),
    )  # fmt: skip
    return kit.Evidence(
        tables={"permittivity": table},
        tolerances=(*RULES, *own),
        columns=kit.columns(__file__),
    )


def elements(volts: float) -> float:
    """Thickness between plates by finite elements (1)."""
    question = facing_slab(HEIGHT / 2, HEIGHT, permittivity=OTHER)
    law = square_fibres(AXIAL, DIAGONAL)
    plates = SoftSlab(question, law, layers=2, around="plates", element="Q1")
    return equilibrium_at(plates, volts).ratio
