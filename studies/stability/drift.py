"""Drift: does the energy stay over ten thousand periods?

Question   Does a scheme's energy drift, how far does it fluctuate within a period, and does a step
           keep areas in phase space, as symplectic schemes do?
Candidate  Each scheme's own step on an undamped oscillator, with plain numbers; leapfrog's velocity
           is taken in the middle between two halves of steps.
Reference  The shadow energy (v_n·x_n+1 - x_n·v_n+1)/(2h), the area between two states in phase
           space: a linear step multiplies it by its determinant, so any symplectic scheme conserves
           it, whatever its period; explicit Euler's, which is the energy, grows (1 + h²ω²)^63-fold
           in 63 steps. The quick mode runs 1000 periods and reports ten times their slope.
Expected   The mean shadow energy of a period changes by rounding only. The energy fluctuates by a
           power of the step, the scheme's order: as h² (Verlet, leapfrog) or as h (Euler-Cromer).
"""

from __future__ import annotations

import math
from itertools import islice

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from msvalidate import kit
from msvalidate.springs.dynamics.integrators import INTEGRATORS
from msvalidate.springs.dynamics.scheme import Integrator
from msvalidate.springs.dynamics.step_limits import one_step_matrix

from . import common, oscillator
from .common import Schemes
from .matrices import matrix_of

STEPS_A_PERIOD = 63
PERIODS = 10_000
QUICK_PERIODS = 1000
FEW_PERIODS = 20
"""In which explicit Euler's energy grows some hundred thousand times."""
FINENESS = (16, 32, 64, 128, 256)
"""Steps a period of the fluctuation."""
SHOWN = 40
"""Periods of each line in the figure."""
AREA = 1e-12
"""Change of an area in a step that is rounding."""
AREA_SIZE = 0.3
"""h·ω of the steps whose areas are measured."""
RULES = (
    kit.Rule(
        "relative drift of the energy in 10⁴ periods", 1e-10, "1",
        "none but rounding: 6e5 steps of 2e-16 are 1e-10 if all on one side; the slope of the "
        "periods that were run, times 10⁴",
        table="drift", value=lambda rows: pd.to_numeric(rows["drift"], errors="coerce").dropna(),
    ),
    kit.Rule(
        "exponent of the step in the energy's fluctuation", 0.1, "1",
        "the next term is smaller by (h·ω)², at most 0.15, at the coarsest of the steps only",
        table="fluctuation_powers", value="exponent", reference="exponent_expected",
    ),
    kit.Rule(
        "schemes that say they keep areas and do not, or the reverse", 0.0, "1",
        "the determinant of a linear step's matrix, to rounding",
        table="areas", value=lambda rows: rows["keeps_areas"] != rows["claims"],
    ),
)  # fmt: skip


def run(candidate: Schemes = INTEGRATORS, setting: kit.Setting = kit.FULL) -> kit.Evidence:
    """Drift and fluctuation of the energy of every scheme in its true form."""
    common.chosen(candidate)  # of which the findings speak
    schemes = {name: scheme for name, scheme in candidate.items() if not scheme.variant}
    periods = QUICK_PERIODS if setting.quick else PERIODS
    cases = [(s, periods if s.symplectic else FEW_PERIODS) for s in schemes.values()]
    means = dict(zip(schemes, setting.sweep(mean_energies, cases, "drift"), strict=True))
    table = pd.DataFrame([drift_row(name, schemes[name], mean) for name, mean in means.items()])
    wavering = {n: s for n, s in schemes.items() if s.symplectic and not s.keeps_energy}
    fluctuation = pd.DataFrame(
        [fluctuation_row(*each, steps) for each in wavering.items() for steps in FINENESS]
    )
    powers = pd.DataFrame([fit_powers(*each, fluctuation) for each in wavering.items()])
    areas = pd.DataFrame([area(name, scheme) for name, scheme in candidate.items()])
    grown = table.set_index("scheme")["growth_a_period"]
    swelling = [
        kit.Tolerance(
            f"{common.title(name)}'s growth of the energy in a period, over closed form", 1e-9, "1",
            "an identity: a step multiplies the energy by the determinant of its matrix, 1 + h²ω² "
            "of explicit Euler's; to the rounding of 1260 steps",
            observed=kit.Observed((1 + grown[name]) / closed_growth(scheme), 1.0),
        )
        for name, scheme in schemes.items() if not scheme.symplectic
    ]  # fmt: skip
    return kit.Evidence(
        tables={
            "drift": table,
            "energy": pd.concat([energy_lines(name, mean) for name, mean in means.items()]),
            "energy_in_a_period": pd.concat(
                [energy_in_period(name, s) for name, s in schemes.items()]
            ),
            "fluctuation": fluctuation,
            "fluctuation_powers": powers,
            "areas": areas,
        },
        tolerances=(*RULES, *swelling),
        figures={"drift": draw},
        columns=kit.columns(__file__),
        findings=(finding(table, powers),),
    )


def size(steps: int) -> float:
    """Step h·ω at which a scheme with trace 2 - h²ω² takes so many steps per period."""
    return 2 * math.sin(math.pi / steps)


def closed_growth(scheme: Integrator) -> float:
    """Factor by which the steps of a period multiply the shadow energy."""
    step = matrix_of(scheme, size(STEPS_A_PERIOD), 0.0)
    return float(np.linalg.det(step)) ** STEPS_A_PERIOD


def path(scheme: Integrator, steps: int, count: int) -> kit.Array:
    """Positions and velocities (2, count) of an oscillator of frequency and amplitude 1."""
    return np.array(list(islice(oscillator.states(scheme, size(steps)), count))).T


def energies(scheme: Integrator, steps: int) -> kit.Array:
    """Energy (steps,) of the oscillator through the first period."""
    return np.asarray(0.5 * (path(scheme, steps, steps) ** 2).sum(axis=0))


def mean_energies(case: tuple[Integrator, int]) -> kit.Array:
    """Mean shadow energy (periods,) of a scheme, period by period."""
    scheme, periods = case
    x, v = path(scheme, STEPS_A_PERIOD, STEPS_A_PERIOD * periods + 1)
    shadow = 0.5 * (v[:-1] * x[1:] - x[:-1] * v[1:]) / size(STEPS_A_PERIOD)
    return np.asarray(shadow.reshape(periods, -1).mean(axis=1))


def drift_row(name: str, scheme: Integrator, means: kit.Array) -> dict[str, object]:
    """Row of one scheme."""
    slope = float(np.polyfit(np.arange(len(means)), means / means[0] - 1, 1)[0])
    return {
        "scheme": name,
        "periods": len(means),
        "steps_a_period": STEPS_A_PERIOD,
        "growth_a_period": math.expm1(math.log(means[-1] / means[0]) / (len(means) - 1)),
        "drift": abs(slope) * PERIODS if scheme.symplectic else "grows" if slope > 0 else "decays",
    }


def energy_lines(name: str, means: kit.Array) -> pd.DataFrame:
    """Lines of the figure: change of the mean shadow energy, for some of the periods."""
    at = np.unique(np.geomspace(1, len(means), SHOWN).round().astype(int)) - 1
    change = means[at] / means[0] - 1
    return pd.DataFrame({"scheme": name, "period": at + 1, "energy_change": change})


def energy_in_period(name: str, scheme: Integrator) -> pd.DataFrame:
    """Energy step by step through the first period."""
    energy = energies(scheme, STEPS_A_PERIOD)
    change = {"step": np.arange(len(energy)), "energy_over_first": energy / energy[0]}
    return pd.DataFrame({"scheme": name} | change)


def fluctuation_row(name: str, scheme: Integrator, steps: int) -> dict[str, object]:
    """Row of one scheme at so many steps a period."""
    energy = energies(scheme, steps)
    return {
        "scheme": name,
        "steps_a_period": steps,
        "h_omega": size(steps),
        "fluctuation": 0.5 * np.ptp(energy) / energy.mean(),
    }


def fit_powers(name: str, scheme: Integrator, fluctuation: pd.DataFrame) -> dict[str, object]:
    """Row of the fitted exponents."""
    rows = fluctuation[fluctuation["scheme"] == name]
    power = kit.fitted_power(rows["h_omega"], rows["fluctuation"])
    return {
        "scheme": name,
        "exponent": power.exponent,
        "exponent_low": power.low,
        "exponent_high": power.high,
        "exponent_expected": scheme.order,
    }


def area(name: str, scheme: Integrator) -> dict[str, object]:
    """Row: what a step makes of areas."""
    change = float(np.linalg.det(one_step_matrix(scheme, 1.0, AREA_SIZE))) - 1
    return {
        "scheme": name,
        "h_omega": AREA_SIZE,
        "area_change": change,
        "keeps_areas": "yes" if abs(change) < AREA else "no",
        "claims": "yes" if scheme.symplectic else "no",
    }


def finding(table: pd.DataFrame, powers: pd.DataFrame) -> str:
    """Drift and fluctuation in a sentence."""
    drifts = pd.to_numeric(table["drift"], errors="coerce")
    # The orbit closes after 63 steps, so that even rounding may repeat itself: no drift is claimed
    # to be smaller than that.
    drift = max(drifts.max(), np.finfo(float).eps)
    euler = table[table["scheme"] == "explicit_euler"].iloc[0]
    exponents = ", ".join(
        f"{common.title(name)} {exponent:.2f}"
        for name, exponent in zip(powers["scheme"], powers["exponent"], strict=True)
    )
    return (
        f"Over {table['periods'].max()} periods of {STEPS_A_PERIOD} steps the energy of the "
        f"schemes that keep areas drifts by no more than {drift:.0e} in 10⁴ periods; "
        f"explicit Euler's grows {1 + euler['growth_a_period']:.2f}-fold in each. Exponent of the "
        f"step in the fluctuation: {exponents}."
    )


def draw(tables: kit.Tables) -> Figure:
    """Mean energy against time, energy within a period, and its fluctuation against the step."""
    figure, (mean, inside, falls) = kit.figures.new_figure(3, size=(2.4, 3.2))
    for axis, name, x, y in (
        (mean, "energy", "period", "energy_change"),
        (inside, "energy_in_a_period", "step", "energy_over_first"),
        (falls, "fluctuation", "h_omega", "fluctuation"),
    ):
        for scheme, rows in tables[name].groupby("scheme", sort=False):
            axis.plot(
                rows[x],
                rows[y] + 1 if axis is mean else rows[y],
                marker="" if axis is inside else common.marker(str(scheme)),
                markevery=4 if axis is mean else 1,
                color=common.colour(str(scheme)),
                mfc="none",
                label=common.title(str(scheme)),
            )
    for axis in (mean, falls):
        axis.set(xscale="log", yscale="log")
    over = "mean shadow energy\nover the first (1)"
    mean.set(xlabel="period (1)", ylabel=over, title="over many periods")
    mean.set_xticks([1, 10, 100, 1000, 10000], ["1", "", "100", "", "10000"])
    inside.set(
        xlabel="time step (1)", ylabel="energy over\nthe first (1)", title="in the first period"
    )
    falls.set(xlabel="h·ω (rad)", ylabel="fluctuation\nof the energy (1)", title="against the step")
    figure.suptitle("Energy of an undamped oscillator, by each scheme")
    kit.figures.add_shared_legend(figure, [mean], columns=3)
    return figure
