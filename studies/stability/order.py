"""Order: how fast does the error fall with the step?

Question   Order of accuracy of each scheme on a smooth motion, without and with damping.
Candidate  `integrate.motion` on a network of 6 x 6 points that swings in its lowest mode, so little
           that it is linear. `motion` staggers the velocity of leapfrog.
Reference  The mode's motion in closed form, and each scheme's step as a matrix on paper, whose
           powers say what order is to be seen over these very steps. As printed, Verlet follows
           half of all forces: see `misprints`.
Expected   The order that each scheme claims, undamped. Under damping leapfrog keeps its second
           order, for its viscous force is centred; velocity Verlet falls to the first: two half
           kicks leave (1 - ch/2)² = 1 - ch + c²h²/4 of the velocity, where exp(-ch) has c²h²/2.
"""

from __future__ import annotations

from functools import partial
from itertools import product
from typing import NamedTuple

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from msvalidate import kit
from msvalidate.springs.dynamics.integrate import State, motion
from msvalidate.springs.dynamics.integrators import INTEGRATORS
from msvalidate.springs.dynamics.scheme import Integrator

from . import common, oscillator
from .common import Schemes
from .matrices import matrix_of
from .networks import Body, clamped, free_components, linear

BODY = Body("square", 6)
ANGLE = 2.0
"""ω times the time of the motion (rad): at no turning point, where first-order errors hide."""
AMPLITUDE = 1e-8
"""Over the side: the error of linearity and that of rounding positions are both near 1e-7 of it."""
STEPS = (100, 200, 400, 800)
QUICK_STEPS = (100, 200, 400)
RATIOS = (0.0, 0.3)
"""Damping ratio of the mode."""
LEFT = 5e-8
"""Of the amplitude, what is not the scheme's: positions of 1 m are rounded by 2e-8 of it, and the
force of springs that turn by 1e-8 is linear to some parts of that."""
LEFT_ALONE = 1e-13
"""The same of one oscillator: the rounding of 800 steps, 1e-16 each."""
CLEAR, CLEAR_ALONE = 5.0, 1e4
"""Times what is left that the least error of a fit has to be; steps of an oscillator may be few, so
that its order on paper, of powers of a matrix, is the same on every processor."""
BECAUSE = (
    "the step's matrix on paper has the very same errors but for {left} of the amplitude, "
    "{what}: the part of each error that this is, times what a point's logarithm "
    "weighs in the slope of the line"
)
ABOVE = 3.0
"""Times the largest error of its schemes that the line of an order begins at, in the figure."""


ON = ("scheme", "damping_ratio")
judged = partial(kit.Rule, unit="1", table="orders", value="order", reference="order_on_paper")


def quantity(name: str, ratio: float) -> str:
    """What is judged of one scheme."""
    return f"order of accuracy, {'damped' if ratio else 'undamped'}: {common.title(name)}"


def run(candidate: Schemes = INTEGRATORS, setting: kit.Setting = kit.FULL) -> kit.Evidence:
    """Errors of every scheme at a row of steps, and the orders fitted to them."""
    numbers = QUICK_STEPS if setting.quick else STEPS
    cases = list(product(candidate.items(), RATIOS))
    found = setting.sweep(partial(errors, numbers), cases, "orders")
    table = pd.DataFrame([row for rows in found for row in rows])
    orders = pd.DataFrame([fit_orders(table, case) for case in cases])
    rules = []
    for row, ((scheme_name, scheme), ratio) in zip(orders.to_dict("records"), cases, strict=True):
        name = quantity(scheme_name, ratio)
        moves = mover(scheme, ratio, numbers)
        what = "rounding" if moves.alone else "rounding and springs that turn"
        left = f"{moves.left:.0e}".replace("e-0", "e-")
        because = BECAUSE.format(left=left, what=what)
        limit = order_uncertainty(scheme, ratio, moves.steps, moves.left)
        rules.append(judged(name, limit, because=because, rows={k: row[k] for k in ON}))
    return kit.Evidence(
        tables={"errors": table, "orders": orders},
        tolerances=tuple(rules),
        figures={"order": draw},
        columns=kit.columns(__file__),
        findings=(finding(orders),),
    )


def errors(
    numbers: tuple[int, ...], case: tuple[tuple[str, Integrator], float]
) -> list[dict[str, object]]:
    """Rows of one scheme at one damping ratio."""
    (name, scheme), ratio = case
    exact, moves = exact_swing(scheme.share, ratio), mover(scheme, ratio, numbers)
    force = "under half the force" if scheme.share < 1 else "under the force"
    if moves.alone:
        swung = partial(oscillator.swing, scheme, angle=ANGLE, ratio=ratio)
    else:
        swung = partial(swing, lowest_mode(), scheme, ratio=ratio)
    return [
        {
            "scheme": name,
            "damping_ratio": ratio,
            "motion": force + ", of one oscillator" if moves.alone else force,
            "steps": steps,
            "h_omega": ANGLE / steps,
            "mode_error": abs(swung(steps) - exact),
        }
        for steps in moves.steps.tolist()
    ]


def exact_swing(share: float, ratio: float) -> float:
    """Exact motion from 1 at rest, under a share of all forces, viscous too: 2 rad later.

    Source: free vibration of one degree of freedom, [Rayleigh1877].
    """
    # Roots of s² + 2·decay·s + share, in units of ω.
    decay = share * ratio
    root = np.sqrt(share - decay**2)
    swing = np.cos(root * ANGLE) + decay / root * np.sin(root * ANGLE)
    return float(np.exp(-decay * ANGLE) * swing)


class Mode(NamedTuple):
    """A network, its lowest mode (n, d), 1 at the most, and the mode's frequency (rad/s)."""

    network: kit.Network
    shape: kit.Array
    omega: float


def lowest_mode() -> Mode:
    """The lowest mode of the body."""
    _, network = clamped(BODY)
    moving = linear(BODY)
    components = np.zeros(network.points.size)
    components[free_components(network)] = moving.lowest[:, 0]
    shape = components.reshape(network.points.shape)
    return Mode(network, shape / np.abs(shape).max(), moving.omega[0])


def swing(moving: Mode, scheme: Integrator, steps: int, ratio: float = 0.0) -> float:
    """Position of the mode after `ANGLE`, started at rest from 1."""
    network, shape, omega = moving
    dt, damping = ANGLE / steps / omega, 2 * ratio * omega
    state = State(network.points + AMPLITUDE * shape, np.zeros_like(shape))
    end = motion(network, state, scheme, dt, steps, damping, warn=False)
    moved = (end.position - network.points) / AMPLITUDE
    return float((moved * shape).sum() / (shape**2).sum())


def fit_orders(
    table: pd.DataFrame, case: tuple[tuple[str, Integrator], float]
) -> dict[str, object]:
    """Row of orders."""
    (name, scheme), ratio = case
    rows = table[(table["scheme"] == name) & (table["damping_ratio"] == ratio)]
    power = kit.fitted_power(rows["h_omega"], rows["mode_error"])
    return {
        "scheme": name,
        "damping_ratio": ratio,
        "motion": rows["motion"].iloc[0],
        "order": power.exponent,
        "order_low": power.low,
        "order_high": power.high,
        "order_expected": scheme.damped_order if ratio else scheme.order,
        "order_on_paper": on_paper(scheme, ratio, rows["steps"].to_numpy()),
    }


class Mover(NamedTuple):
    """What moves to tell an order: its steps, and what is in its errors beside the scheme's own.

    Parameters
    ----------
    steps
        (s,) numbers of steps.
    left
        Of each error what is rounding, or springs that turn, over the amplitude (1).
    alone
        Whether it is one oscillator and no network.
    """

    steps: kit.Index
    left: float
    alone: bool = False

    def shows(self, scheme: Integrator, ratio: float) -> bool:
        """Whether every error on paper stands clear of what is left."""
        clear = CLEAR_ALONE if self.alone else CLEAR
        return bool((errors_on_paper(scheme, ratio, self.steps) >= clear * self.left).all())


def mover(scheme: Integrator, ratio: float, numbers: tuple[int, ...]) -> Mover:
    """The network, or one oscillator for a scheme whose errors the network's rounding would hide.

    Its steps are halved until they show. (A network's highest mode would not be stable at them.)

    Raises
    ------
    SolverError
        If not even the fewest show the scheme's order.
    """
    network = Mover(np.array(numbers), LEFT)
    if network.shows(scheme, ratio):
        return network
    steps = np.array(numbers)
    while steps[0] > 1:
        if (alone := Mover(steps, LEFT_ALONE, alone=True)).shows(scheme, ratio):
            return alone
        steps = steps // 2
    raise kit.SolverError(f"{scheme.name}: order of accuracy: its errors are rounding at any step")


def on_paper(scheme: Integrator, ratio: float, numbers: kit.Index) -> float:
    """Order that the errors of a scheme's matrix show, steps by steps in `numbers`."""
    return float(
        kit.fitted_power(ANGLE / numbers, errors_on_paper(scheme, ratio, numbers)).exponent
    )


def order_uncertainty(
    scheme: Integrator, ratio: float, numbers: kit.Index, left: float = LEFT
) -> float:
    """How far what is left on every error moves the fitted order at most."""
    size = np.log(ANGLE / numbers)
    weight = np.abs(size - size.mean()) / ((size - size.mean()) ** 2).sum()
    return float(weight @ (left / errors_on_paper(scheme, ratio, numbers)))


def errors_on_paper(scheme: Integrator, ratio: float, numbers: kit.Index) -> kit.Array:
    """Errors (n,) of the matrix's powers after `ANGLE`, over the amplitude."""
    exact, sizes, left = exact_swing(scheme.share, ratio), ANGLE / numbers, []
    for h, steps in zip(sizes, numbers, strict=True):
        # A staggered velocity is half a step back, where the mean of two around the start is zero.
        start = np.array([1.0, h / 2 if scheme.staggered else 0.0])
        power = np.linalg.matrix_power(matrix_of(scheme, float(h), 2 * ratio), int(steps))
        left.append(abs((power @ start)[0] - exact))
    return np.array(left)


def finding(orders: pd.DataFrame) -> str:
    """Orders of the report's four, in a sentence."""
    said = []
    for name in common.REPORTED:
        rows = orders[orders["scheme"] == name]
        free, damped = (rows[rows["damping_ratio"] == ratio]["order"].iloc[0] for ratio in RATIOS)
        said.append(f"{common.title(name)} {free:.2f} ({damped:.2f})")
    return (
        f"Order of accuracy without damping, and in brackets at a damping ratio of {RATIOS[1]:g}: "
        + ", ".join(said)
        + "."
    )


def draw(tables: kit.Tables) -> Figure:
    """Error against the step, without and with damping."""
    table = tables["errors"]
    figure, axes = kit.figures.new_figure(2, size=(3.5, 3.8), sharey=True)
    for axis, ratio in zip(axes, RATIOS, strict=True):
        rows = table[table["damping_ratio"] == ratio]
        for name, line in rows.groupby("scheme", sort=False):
            scheme = str(name)
            axis.loglog(
                line["h_omega"],
                line["mode_error"],
                marker=common.marker(scheme),
                color=common.colour(scheme),
                mfc="none",
                ls="-" if scheme in common.TRUE else "--",
                label=common.title(scheme),
            )
        orders = tables["orders"][tables["orders"]["damping_ratio"] == ratio]
        expected = orders.set_index("scheme")["order_expected"].to_dict()
        for power, style in zip((1, 2, 4), (":", "-.", "--"), strict=True):
            line = rows[rows["scheme"].map(expected) == power]
            if len(line):
                ends = np.array([line["h_omega"].min(), line["h_omega"].max()])
                guide = ABOVE * line["mode_error"].max() * (ends / ends[1]) ** power
                axis.loglog(ends, guide, style, color="grey", lw=1, label=f"order {power}")
        axis.set_title("undamped" if not ratio else f"damping ratio {ratio:g}")
        axis.set_xlabel("h·ω (rad)")
    axes[0].set_ylabel("error over amplitude (1)")
    figure.suptitle("Error of each scheme against its step")
    kit.figures.add_shared_legend(figure, axes, columns=3)
    return figure
