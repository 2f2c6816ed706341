"""Sweep: how thin does a slab get as the voltage rises, and where is it pulled in?

Question   Does the slab follow the curve l(V) of uniform compression up to its largest voltage, and
           does a bonded slab of finite length follow it in its middle?
Candidate  A way to rest at a voltage: of a slab between frictionless walls in the field of parallel
           plates, and of a bonded slab with the charges of its own electrodes.
Reference  V² = 2h²l²P(l)/ε with the lattice's stress P, and finite elements with the lattice's
           energy, which find the largest voltage at a turning point over the charge.
Expected   V = 6.348 V at l = 0.692 for k1 = 1, k2 = 0.5, h = 10, ε = 1. The slab between walls is
           uniform, so it follows the curve to rounding; at the largest voltage l goes with the root
           of what is missing of V. On the outside of two strips of width w stands a field of about
           2V/(πw), that of a layer of dipoles at its middle, and pulls the other way: the middle of
           a bonded slab is squeezed by ½ε(E² - E_out²), 1 % less for w = 6h. Its ends are drawn
           outwards, which reaches inwards as exp(-κx), κ = (π/2h)·√(C66/C11) = 0.907/h: shear of a
           bonded layer. That thins the middle of a short slab.
"""

from __future__ import annotations

from functools import partial
from time import perf_counter

import numpy as np
import pandas as pd
from scipy.optimize import brentq

from msvalidate import kit
from msvalidate.dielectric.actuator import ActuatorEquilibrium, uniform
from msvalidate.dielectric.actuator import sweep as raised
from reference_fem.actuator import SoftSlab, equilibrium_at, turning_point
from reference_fem.electric import facing_slab
from reference_fem.large_strain import square_fibres

from . import branches, pressed
from .branches import closed
from .slab import AXIAL, DIAGONAL, HEIGHT, LENGTH, PERMITTIVITY, PULL_IN
from .sweep_drawing import draw
from .way import PullInSolver, bonded, last_equilibrium, middle, sliding

PARTS = (0.2, 0.4, 0.6, 0.8, 0.9, 0.96, 0.99, 0.999)
"""Voltages of the slab between walls, over the pull-in voltage."""
WALLED_LAYERS = 5
BRACKET = 1e-9
"""Step over the voltage at which the search for the pull-in ends: l is then known to 2e-5."""
LONG = 10 * HEIGHT
"""Of a longer slab (m), to tell what its ends do."""
DECAY = float(0.5 * np.pi * np.sqrt(DIAGONAL / (AXIAL + DIAGONAL)) / HEIGHT)
"""κ (1/m) of what the ends do to a bonded layer."""
AS_IT_IS, ENDS_PRESSED = (0.1, 0.2, 0.3), (0.5, 0.7, 0.9)
"""Voltages of the bonded slab over the uniform pull-in: as it is, until its edges give way, and on,
with ends pressed evenly."""
ELEMENT_PARTS = (0.1, 0.2)
"""Of these, at which elements are asked: a little on, cells at the edges turn inside out."""
QUICK_LAYERS, LAYERS = (5,), (5, 10, 16)
"""Cells up the bonded slab."""
STEPS, QUICK_COSTLY, COSTLY, COSTLY_PART = 20, 5, 10, 0.4
"""Of the sweep whose cost is stated, of 61 x 11 points: steps, layers, and how far it goes."""
RULES = (
    kit.Rule(
        "thickness between walls against the closed form", 1e-7, "1",
        "uniform to rounding; equilibrium to 1e-10 of the forces, over the stiffness that is left "
        "near pull-in, a thirtieth of the first",
        table="between_walls", value="thickness", reference="thickness_exact",
    ),
    kit.Rule(
        "pull-in voltage over the closed form, from 1", 1e-6, "1",
        "voltages are flat there: a charge known to 1e-4 gives 1e-8 of the voltage, and a bracket "
        "of the voltage 1e-9",
        table="pull_in", value=kit.Quotient("pull_in_voltage", PULL_IN.voltage), reference=1.0,
    ),
    kit.Rule(
        "thickness at pull-in against the closed form", 8e-5, "1",
        "the root of 1e-9/3.4, 1.7e-5, from a bracket of the voltage; and 2(1 - l) = 0.62 times "
        "the part to which a charge is known, 1e-4, as the charge goes with the root of 1 - l",
        table="pull_in", value="pull_in_thickness", reference=PULL_IN.thickness,
    ),
    kit.Rule(
        "squeeze in the middle of the bonded slab over that with the outer field, from 1",
        0.05, "1",
        "what both ends do reaches the middle as 2·exp(-3κh) = 13 %, of a widening that thins the "
        "slab by a third or so of its squeeze, nu being 1/3",
        layer="agreement",
        table="bonded", value="squeeze_over_outer", reference=1.0,
    ),
)  # fmt: skip


def run(candidate: PullInSolver, setting: kit.Setting) -> kit.Evidence:
    """Sweep the voltage of both slabs."""
    table = sweep_between_walls(candidate)
    ends = pull_in_voltage(candidate)
    layers = QUICK_LAYERS if setting.quick else LAYERS
    found = setting.sweep(partial(bonded_slab, candidate), layers, "voltages")
    long = pd.DataFrame([row for rows in found for row in rows])
    costs = pd.DataFrame([cost(QUICK_COSTLY if setting.quick else COSTLY)])
    told = long[long["thickness_elements"] != "not asked"]
    free = long[long["body"] == "as it is"].groupby("length_over_h")
    added = free["squeeze_over_outer"].first() - 1
    own = (
        kit.Tolerance(
            "what the ends add to the squeeze, of a slab of ten heights over that of one of six",
            0.03, "1",
            "exp(-2κh) = 0.163 from the slowest decay alone; the outer field lacks a part h/w of "
            "itself, 2e-3 and 4e-4 of the squeeze beside the 0.027 and 0.004 that the ends add",
            layer="agreement",
            observed=kit.Observed(added.iloc[1] / added.iloc[0],
            float(np.exp(-DECAY * (LONG - LENGTH) / 2))),
        ),
        kit.Tolerance(
            "squeeze in the middle of the bonded slab, springs over elements, from 1", 0.01, "1",
            "the same law and, three heights from the ends, the same field",
            layer="agreement",
            observed=kit.farthest_value(
                (1 - told["thickness"]) / (1 - told["thickness_elements"].astype(float)), 1.0
            ),
        ),
    )  # fmt: skip
    return kit.Evidence(
        tables={"between_walls": table, "pull_in": ends, "bonded": long, "sweep_cost": costs},
        tolerances=(*RULES, *own),
        figures={"sweep": draw},
        columns=kit.columns(__file__),
        findings=findings(ends, long, costs.iloc[0]),
        # How far equilibria and turning points stop from their limit.
    )


def sweep_between_walls(way: PullInSolver) -> pd.DataFrame:
    """The slab between walls, voltage by voltage."""
    actuator, plates = sliding(WALLED_LAYERS), between_plates()
    rows, held, soft = [], None, None
    for part in PARTS:
        volts = part * PULL_IN.voltage
        held = way.at_voltage(actuator, volts, start=held)
        soft = equilibrium_at(plates, volts, start=soft)
        rows.append(
            {
                "voltage_over_pull_in": part,
                "voltage": volts,
                "thickness": middle(held),
                "thickness_elements": soft.ratio,
                "thickness_exact": closed(volts),
                "iterations": held.iterations,
            }
        )
    return pd.DataFrame(rows)


def between_plates() -> SoftSlab:
    """The same of finite elements, one cell wide: past pull-in wider ones may fold sideways."""
    question = facing_slab(HEIGHT / 2, HEIGHT, permittivity=PERMITTIVITY)
    law = square_fibres(AXIAL, DIAGONAL)
    return SoftSlab(question, law, layers=2, around="plates", element="Q1")


def pull_in_voltage(way: PullInSolver) -> pd.DataFrame:
    """Pull-in by every route."""
    near = way.at_voltage(sliding(WALLED_LAYERS), 0.95 * PULL_IN.voltage)
    held, _ = last_equilibrium(
        way, near.actuator, 1.05 * PULL_IN.voltage, start=near, bracket=BRACKET
    )
    plates = between_plates()
    top = turning_point(plates, equilibrium_at(plates, 0.95 * PULL_IN.voltage))
    charged = pressed.pull_in(pressed.springs)
    routes = {
        "springs, voltage by voltage": (held.voltage, middle(held)),
        "springs, charge by charge": (charged.voltage, charged.thickness),
        "elements, charge by charge": (top.voltage, top.ratio),
        "closed form": (PULL_IN.voltage, PULL_IN.thickness),
    }
    return pd.DataFrame(
        [
            {"route": route, "pull_in_voltage": volts, "pull_in_thickness": part}
            for route, (volts, part) in routes.items()
        ]
    )


def bonded_slab(way: PullInSolver, layers: int) -> list[dict[str, object]]:
    """Rows of one bonded slab: as it is, then between ends pressed evenly."""
    actuator = bonded(layers)
    rows: list[dict[str, object]] = []
    held = None
    for part in AS_IT_IS:
        held = way.at_voltage(actuator, part * PULL_IN.voltage, start=held)
        rows.append(bonded_row("as it is", layers, held))
        if layers == LAYERS[0] and part in ELEMENT_PARTS:
            rows[-1]["thickness_elements"] = elements(held.voltage)
    for part in ENDS_PRESSED:
        found = branches.pressed(way, actuator, part * PULL_IN.voltage)
        if found is not None:
            rows.append(bonded_row("ends pressed evenly", layers, found))
    if layers == LAYERS[0]:
        far = way.at_voltage(bonded(layers, LONG), AS_IT_IS[0] * PULL_IN.voltage)
        rows.append(bonded_row("as it is", layers, far))
    return rows


def bonded_row(body: str, layers: int, held: ActuatorEquilibrium) -> dict[str, object]:
    """What a bonded slab shows in its middle."""
    length = float(np.ptp(held.actuator.network.points[:, 0]))
    less = outer(held.voltage, length)
    return {
        "body": body,
        "length_over_h": length / HEIGHT,
        "layers": layers,
        "voltage_over_pull_in": held.voltage / PULL_IN.voltage,
        "voltage": held.voltage,
        "thickness": middle(held),
        "thickness_exact": closed(held.voltage),
        "thickness_outer": less,
        "thickness_elements": "not asked",
        "squeeze_over_outer": (1 - middle(held)) / (1 - less),
        "iterations": held.iterations,
    }


def elements(volts: float) -> float:
    """Thickness in the middle of the bonded slab by finite elements, air around (1)."""
    question = facing_slab(LENGTH, HEIGHT, permittivity=PERMITTIVITY, air=PERMITTIVITY)
    soft = SoftSlab(question, square_fibres(AXIAL, DIAGONAL), layers=4)
    return equilibrium_at(soft, volts).ratio


def outer(volts: float, length: float) -> float:
    """Thickness of an infinite slab on which the outer field of strips pulls back (1)."""

    def excess(part: float) -> float:
        fields = volts / (part * HEIGHT), 2 * volts / (np.pi * length)
        pull = 0.5 * PERMITTIVITY * (fields[0] ** 2 - fields[1] ** 2)
        return uniform.pressure(part, axial=AXIAL, diagonal=DIAGONAL) - pull

    return float(brentq(excess, closed(volts), 1.0))


def cost(layers: int) -> dict[str, object]:
    """A sweep of the report's slab, as a user would ask for it."""
    actuator = bonded(layers)
    start = perf_counter()
    volts = COSTLY_PART * PULL_IN.voltage * np.arange(1, STEPS + 1) / STEPS
    found = raised(actuator, volts)
    return {
        "layers": layers,
        "points": len(actuator.network.points),
        "segments": sum(len(line) - 1 for line in actuator.electrodes),
        "steps": STEPS,
        "voltage_over_pull_in": found.last.voltage / PULL_IN.voltage,
        "iterations": sum(held.iterations for held in found.equilibria),
        "sweep_seconds": perf_counter() - start,
    }


def findings(ends: pd.DataFrame, long: pd.DataFrame, cost: pd.Series) -> tuple[str, ...]:
    """Where the slab is pulled in, and what its ends change."""
    routes = ", ".join(
        f"{row.pull_in_voltage:.5f} V at l = {row.pull_in_thickness:.4f} by {row.route}"
        for row in ends.itertuples()
    )
    most = long[long["voltage_over_pull_in"] == long["voltage_over_pull_in"].max()].iloc[-1]
    free = long[long["body"] == "as it is"]
    short, far = (own.iloc[0] for _, own in free.groupby("length_over_h"))
    pressed_ends = (
        f"In the middle of a slab six heights long whose ends are pressed evenly the thickness at "
        f"{most['voltage_over_pull_in']:g} of that voltage is {most['thickness']:.4f}, "
        f"{most['thickness_exact']:.4f} in an infinite one, {most['thickness_outer']:.4f} if the "
        "field outside pulls back on it."
    )
    free_ends = (
        f"Free ends are drawn outwards and thin the middle: the squeeze is "
        f"{100 * (short['squeeze_over_outer'] - 1):.2g} % larger six heights long, "
        f"{100 * (far['squeeze_over_outer'] - 1):.2g} % ten heights long."
    )
    spent = (
        f"A sweep of {cost['points']:g} points to {cost['voltage_over_pull_in']:g} of it takes "
        f"{cost['iterations']:g} linear solves for {cost['steps']:g} steps, and here "
        f"{cost['sweep_seconds']:.1f} s."
    )
    return f"Pull-in of the uniform slab: {routes}.", pressed_ends, free_ends, spent
