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

from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd

from msvalidate import kit
from msvalidate.bench.judging.counting import predict_steps
from msvalidate.springs.dynamics.relax import relax
from msvalidate.springs.dynamics.relaxations import RELAXATIONS
from msvalidate.springs.dynamics.spectrum import extreme_frequencies
from msvalidate.springs.statics.equilibrium import equilibrium

from .. import cost, loading
from .bent import BOX, counts, springs_of

RATIOS, QUICK = (0.3, 0.45, 0.49, 0.499, 0.4999), (0.3, 0.485, 0.495)
CELLS = 8
METHODS = {"steps_leapfrog": "viscous_leapfrog", "steps_fire": "fire"}
LOOK_EVERY = 4
RESTART = {True: 40, False: 600}
"""Steps of FIRE, in the small form and in the full one: it stops where a power changes its sign,
now and then by rounding, and a stop costs 1 to 2 % of the steps, of 27,000 at the most."""
RULES = (
    kit.Rule(
        "highest frequency squared of rubber beyond that of one cell, 8 (λ + μ)/m, relative",
        1e-9, "1",
        "energy and mass of the body are sums over cells that are alike, so no quotient of sums is "
        "beyond that of one; left is rounding",
        table="rubber_rest", value=lambda rows: (rows["omega_high_cell"] ** 2 - 1).clip(lower=0.0),
    ),
    kit.Rule(
        "leapfrog steps over the prediction from frequencies", 0.05, "1",
        "the prediction takes the slowest mode for the whole displacement; looks are four steps "
        "apart, of 200 and more",
        table="rubber_rest", value=kit.Quotient("steps_leapfrog", "steps_foreseen"), reference=1.0,
    ),
    kit.Rule(
        "leapfrog steps against 1/(1 - 2 nu) above nu = 0.48: exponent, from 1/2", 0.03, "1",
        "λ + 2μ is 2μ (1 - nu)/(1 - 2 nu): while 1 - 2 nu changes three times, the root of 1 - nu "
        "and the lowest frequency change by 1 % each, 0.02/log(3) = 0.018 and less over a wider "
        "range; looks, four steps apart of 2000, make 0.002",
        table="rubber_rest", rows={"nu_settled": RATIOS[2:] + QUICK[1:]}, value="steps_leapfrog",
        power_of=lambda rows: 1 / (1 - 2 * rows["nu_settled"]), reference=0.5,
    ),
)  # fmt: skip


def run(setting: kit.Setting) -> kit.Evidence:
    """Bring blocks to rest, and judge the steps."""
    ratios = QUICK if setting.quick else RATIOS
    table = pd.DataFrame(setting.sweep(measure, ratios, "rubber to rest"))
    known = kit.columns(__file__)
    stops = replace(known["steps_fire"], rounding=RESTART[setting.quick])
    first, last = table.iloc[0], table.iloc[-1]
    finding = (
        f"From nu = {first['nu_settled']:g} to {last['nu_settled']:g} a bent block's condition "
        f"grows from {first['condition']:.2g} to {last['condition']:.2g} and the largest stable "
        f"step falls to {last['step_limit'] / first['step_limit']:.2g} of what it was: leapfrog "
        f"takes {last['steps_leapfrog']:.0f} steps to rest instead of "
        f"{first['steps_leapfrog']:.0f}, FIRE {last['steps_fire']:.0f} instead of "
        f"{first['steps_fire']:.0f}."
    )
    return kit.Evidence(
        {"rubber_rest": table},
        tolerances=RULES,
        columns={**known, "steps_fire": stops},
        findings=(finding,),
    )


def measure(nu: float) -> dict[str, object]:
    """One row of the table."""
    box = kit.Box(BOX[2])
    problem = loading.clamped(box, kit.Isotropic(1.0, nu, "plane_strain"), "shear", loading.STRAIN)
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
        "steps_foreseen": predict_steps(high / low, cost.ERROR),
    } | steps
