"""Resting: what does a ratio near 1/2 cost a relaxation?

Question   Condition of the stiffness, highest frequency, and steps to rest of a bent block as nu
           goes to 1/2.
Candidate  Square cells with the volume energy in plane strain; leapfrog with critical damping, and
           FIRE, to a displacement error of 1e-6.
Reference  Frequency: ω² m = 4 (λ + 2μ) of the endless lattice, where a wave alternates along one
           axis; 8 (λ + μ) of one cell alone, which swells. Steps: those that the slowest mode alone
           takes, from the two frequencies.
Expected   The lowest frequency hardly changes, the highest grows with λ: as 1/(1 - 2 nu), and steps
           with its root. Rubber of 0.499 costs some ten times the steps of 0.3.
"""

from __future__ import annotations

from functools import partial

import numpy as np
import pandas as pd

from msvalidate.dynamics.spectrum import extreme_frequencies
from msvalidate.judging.compare import farthest_value
from msvalidate.judging.evidence import Evidence, Observed, Tolerance, by_quantity
from msvalidate.judging.sweep import Setting
from msvalidate.problem import Box, Isotropic
from msvalidate.relaxation.relax import relax
from msvalidate.relaxation.relaxations import RELAXATIONS
from msvalidate.statics.equilibrium import equilibrium

from .. import cost, loading
from .bent import BOX, counts, springs_of

RATIOS, QUICK = (0.3, 0.45, 0.49, 0.499, 0.4999), (0.3, 0.485, 0.495)
CELLS = 8
METHODS = {"steps_leapfrog": "viscous_leapfrog", "steps_fire": "fire"}
LOOK_EVERY = 4
RUBBER = 0.48
RESTART = {True: 40, False: 600}
"""Steps of FIRE, in the small form and in the full one: it stops where a power changes its sign,
now and then by rounding, and a stop costs 1 to 2 % of the steps, of 27,000 at the most."""
TOLERANCES = (
    Tolerance(
        "highest frequency squared of rubber beyond that of one cell, 8 (λ + μ)/m, relative",
        1e-9, "1",
        "energy and mass of the body are sums over cells that are alike, so no quotient of sums is "
        "beyond that of one; left is rounding",
    ),
    Tolerance(
        "leapfrog steps over the prediction from frequencies", 0.05, "1",
        "the prediction takes the slowest mode for the whole displacement; looks are four steps "
        "apart, of 200 and more",
    ),
    Tolerance(
        "leapfrog steps against 1/(1 - 2 nu) above nu = 0.48: exponent, from 1/2", 0.03, "1",
        "λ + 2μ is 2μ (1 - nu)/(1 - 2 nu): while 1 - 2 nu changes three times, the root of 1 - nu "
        "and the lowest frequency change by 1 % each, 0.02/log(3) = 0.018 and less over a wider "
        "range; looks, four steps apart of 2000, make 0.002",
    ),
)  # fmt: skip
COLUMNS = {
    "nu_settled": "Poisson's ratio of the bent block, plane strain (1)",
    "lame_over_mu": "Lamé's λ over μ (1)",
    "condition": "largest over least eigenvalue of the stiffness by masses (1)",
    "omega_high": "highest frequency of the body, in units of the root of μ/m of a point (1)",
    "omega_low": "its lowest, same unit (1)",
    "omega_high_over": "omega_high over that of the endless lattice, root of 4 (λ + 2μ)/μ (1)",
    "omega_high_cell": "omega_high over that of one cell alone, root of 8 (λ + μ)/μ (1)",
    "step_limit": "largest stable step of leapfrog, 2/omega_high (1)",
    "steps_foreseen": "steps of leapfrog that the slowest mode takes to an error of 1e-6",
    "steps_leapfrog": "steps of leapfrog, critically damped, to a displacement error of 1e-6",
    "steps_fire": "steps of FIRE to the same",
}


def run(setting: Setting) -> Evidence:
    """Bring blocks to rest, and judge the steps."""
    ratios = QUICK if setting.quick else RATIOS
    table = pd.DataFrame(setting.sweep(measure, ratios, "rubber to rest"))
    high = table[table["nu_settled"] > RUBBER]
    slope = np.polyfit(np.log(1 - 2 * high["nu_settled"]), np.log(high["steps_leapfrog"]), 1)[0]
    values = (
        Observed(max(0.0, float((table["omega_high_cell"] ** 2).max() - 1))),
        farthest_value(table["steps_leapfrog"] / table["steps_foreseen"], 1.0),
        Observed(-float(slope), 0.5),
    )
    return Evidence(
        tables={"rubber_rest": table},
        observed=by_quantity(TOLERANCES, values),
        tolerances=TOLERANCES,
        columns=COLUMNS,
        rounding={"condition": 1e-6, "steps_leapfrog": 4, "steps_fire": RESTART[setting.quick]},
        findings=findings(table),
    )


def findings(table: pd.DataFrame) -> tuple[str, ...]:
    """What the last ratio costs over the first."""
    first, last = table.iloc[0], table.iloc[-1]
    said = (
        f"From nu = {first['nu_settled']:g} to {last['nu_settled']:g} a bent block's condition "
        f"grows from {first['condition']:.2g} to {last['condition']:.2g} and the largest stable "
        "step "
        f"falls to {last['step_limit'] / first['step_limit']:.2g} of what it was: leapfrog takes "
        f"{last['steps_leapfrog']:.0f} steps to rest instead of {first['steps_leapfrog']:.0f}, "
        f"FIRE {last['steps_fire']:.0f} instead of {first['steps_fire']:.0f}."
    )
    return (said,)


def measure(nu: float) -> dict[str, object]:
    """One row of the table."""
    box = Box(BOX[2])
    problem = loading.clamped(box, Isotropic(1.0, nu, "plane_strain"), "shear", loading.STRAIN)
    network = springs_of(problem, "square", counts(box, CELLS))
    low, high = extreme_frequencies(network)
    unit = np.sqrt(1 / (2 * (1 + nu)) / network.mass.max())
    lame = 2 * nu / (1 - 2 * nu)
    rest = equilibrium(network, "nonlinear").displacement
    steps = {
        name: relax(
            network,
            RELAXATIONS[method],
            tolerance=cost.AT_REST,
            watch=partial(cost.near, rest),
            look_every=LOOK_EVERY,
            frequencies=(low, high),
        ).steps
        for name, method in METHODS.items()
    }
    return {
        "nu_settled": nu,
        "lame_over_mu": lame,
        "condition": (high / low) ** 2,
        "omega_high": high / unit,
        "omega_low": low / unit,
        "omega_high_over": high / unit / np.sqrt(4 * (lame + 2)),
        "omega_high_cell": high / unit / np.sqrt(8 * (lame + 1)),
        "step_limit": 2 * unit / high,
        "steps_foreseen": cost.predict(high / low),
    } | steps
