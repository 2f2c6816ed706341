"""Growth: by how much does a scheme grow that no step makes stable?

Question   Explicit Euler without damping, and Verlet with the old force in both kicks: have they a
           small step that is stable, or do they only grow slowly?
Candidate  Each scheme's own step on an oscillator; growth from the energy over many steps.
Reference  |λ| of the step's matrix in closed form, √(1 + swelling·h²ω²): the root of its
           determinant, since its eigenvalues are a conjugate pair.
Expected   Equal, and above 1 at each step.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from msvalidate import kit
from msvalidate.springs.dynamics.implicit import ModeAcceleration
from msvalidate.springs.dynamics.integrators import INTEGRATORS
from msvalidate.springs.dynamics.scheme import Integrator, MotionState

from . import common
from .bounded import energy
from .common import Schemes
from .networks import OSCILLATOR, linear

GROWING = tuple(name for name, scheme in INTEGRATORS.items() if scheme.swelling > 0)
"""Schemes that no step makes stable."""
STEPS = 1000
SIZES = (0.05, 0.1, 0.2, 0.5)
"""h·ω; the energy grows by (1 + h²ω²)^steps at most, less than a number holds."""
GROWTH = kit.Rule(
    "growth a step of schemes that are never stable undamped, measured over closed form", 0.01, "1",
    "the energy wavers by h·ω/2 on its way; over the steps of a run a line through its "
    "logarithm is within 1 % of growth's own",
    table="growth", value=kit.Quotient("growth_measured", "growth_predicted"), reference=1.0,
)  # fmt: skip
ANY_SIZES = (0.1, 1.0, 10.0, 100.0)
"""h·ω of schemes without a limit."""
STAYS = kit.Rule(
    "growth a step of schemes that say they are stable at any step", 1e-12, "1",
    "none but rounding: a velocity takes half of h·ω times the rounding of an acceleration, 100 "
    "times 1e-16 in a step",
    table="any_step", value="growth_here",
)  # fmt: skip


def run(candidate: Schemes = INTEGRATORS, setting: kit.Setting = kit.FULL) -> kit.Evidence:
    """Run the schemes that no step makes stable without damping, and those that every step does."""
    return kit.merge(growing(candidate), staying(candidate))


def growing(candidate: Schemes) -> kit.Evidence:
    """Schemes that no step makes stable."""
    schemes = common.chosen(candidate, GROWING)
    table = pd.DataFrame(
        [
            {
                "scheme": name,
                "h_omega": size,
                "growth_measured": factor - 1,
                "growth_predicted": np.sqrt(1 + scheme.swelling * size**2) - 1,
                "steps_to_double": np.log(2) / np.log(factor),
            }
            for name, scheme in schemes.items()
            for size, factor in zip(SIZES, growth_factors(scheme, np.array(SIZES)), strict=True)
        ]
    )
    claimed = max(scheme.limit(0.0) for scheme in schemes.values())
    unstable = kit.Tolerance(
        "undamped limits claimed where every step grows", 0.0, "rad",
        "a growth factor above 1 at every step: the limit is 0",
        observed=kit.Observed(claimed if (table["growth_measured"] > 0).all() else np.nan),
    )  # fmt: skip
    return kit.Evidence(
        tables={"growth": table},
        tolerances=(GROWTH, unstable),
        columns=kit.columns(__file__),
        findings=(finding(table),),
    )


def staying(candidate: Schemes) -> kit.Evidence:
    """Schemes that are stable at any step, if there are any."""
    sizes = np.array(ANY_SIZES)
    rows = [
        {"scheme": name, "h_omega": size, "growth_here": factor - 1}
        for name, scheme in candidate.items()
        if np.isinf(scheme.limit(0.0))
        for size, factor in zip(ANY_SIZES, growth_factors(scheme, sizes), strict=True)
    ]
    if not rows:
        return kit.Evidence({}, {}, ())
    table = pd.DataFrame(rows)
    return kit.Evidence(
        tables={"any_step": table},
        tolerances=(STAYS,),
        columns=kit.columns(__file__),
    )


def growth_factors(scheme: Integrator, sizes: kit.Array) -> kit.Array:
    """Factors (n,) by which the amplitude of an undamped oscillator grows in a step of h·ω (n,)."""
    body, acceleration = linear(OSCILLATOR), ModeAcceleration(1.0)
    x = np.ones((1, len(sizes)))
    now = MotionState(x, np.zeros_like(x), acceleration(x))
    history = [energy(body, now)]
    for _ in range(STEPS):
        now = scheme.step(acceleration, now, sizes, 0.0)  # type: ignore[arg-type]
        history.append(energy(body, now))
    rate = np.polyfit(np.arange(STEPS + 1), np.log(history), 1)[0]
    return np.asarray(np.exp(0.5 * rate))


def finding(table: pd.DataFrame) -> str:
    """How soon explicit Euler doubles."""
    euler = table[table["scheme"] == "explicit_euler"]
    growing = euler[euler["growth_measured"] > 0]
    if growing.empty:
        return f"Explicit Euler without damping grows at none of {len(euler)} steps."
    first, last = growing.iloc[0], growing.iloc[-1]
    at = "every step" if len(growing) == len(euler) else f"{len(growing)} of {len(euler)} steps"
    return (
        f"Explicit Euler without damping grows at {at}: its amplitude doubles in "
        f"{first['steps_to_double']:.0f} steps at h·ω = {first['h_omega']:g}, in "
        f"{last['steps_to_double']:.1f} at {last['h_omega']:g}."
    )
