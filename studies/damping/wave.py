"""Wave: how fast does the strain wave run, and what comes back from the held edge?

Question   Does a blow on the right end run through the lattice at elasticity's speed, and is it
           turned round at the held left end as elasticity says?
Candidate  Algorithm 1's motion, without damping, of a bar of lattice cells under a smooth pulse of
           traction.
Reference  √(C11/ρ) where no point may move across (plane strain waves), √(E2/ρ) in a slender bar
           with free sides, and the dispersion of both; ρ is the mass an area.
Expected   ω = c0·k·(1 - β·k²) with β = (a² - c0²h²)/24 from spacing and time step: the chain of
           columns has ω = (2c0/a)·sin(ka/2), and the scheme sin(ωh/2)/(h/2) in the place of ω.
           Free sides add (nu·κ)²/2, the inertia of moving across (Love), κ² the mean square height
           of the masses: H²/12, times 1 + 2/N² on N cells; and they take off nu²a²/(8(1 + nu)),
           because a diagonal sees the strain across at its two ends, half a spacing from its
           middle, as cos(ka/2) of it. A Gaussian pulse of standard deviation s then loses the part
           3β/s² of the speed of its peak, which sinks by 3(βd/s³)² on a way d. A held end returns
           the velocity inverted and feels twice the stress.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from itertools import product
from typing import NamedTuple

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from msvalidate import kit
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.constants.stiffness import moduli, square_tensor
from msvalidate.springs.dynamics.integrate import State
from msvalidate.springs.lattice import square
from msvalidate.springs.network import internal_force

from .bodies import DENSITY, ISOTROPIC, MotionSolver

LENGTH = 1.0
HEIGHT = 0.02
"""Of the slender bar (m)."""
DEVIATION = 0.05
"""Standard deviation of the pulse along the bar (m)."""
QUICK_CELLS, CELLS = (100, 200), (100, 200, 400)
"""Cells along the bar."""
SIDES = ("held", "free")
BLOCKS = 8
"""Blocks of constant traction in the time in which the pulse runs one standard deviation."""
CELLS_A_STEP = 50
"""Cells along the bar for each step of a block: h is then 0.31 of a/c0, a third of the limit."""
DELAY = 5.0
"""Standard deviations by which the blow's peak follows the start: it begins with 4e-6 of it."""
STRENGTH = 1e-6
"""Strain of the pulse: the wave is then linear."""
STATIONS = (0.7, 0.3)
"""Where the peak is timed (m): clear of the blow, and of what has come back from the wall."""
MIRROR = 0.3
"""Where the pulse is measured on its way to the wall and back (m)."""
SHOWN = (40, 40)
"""Columns and times in the picture of the wave, at most."""
ROUNDING = {"loss": 3e-7, "velocity": 1e-6}
"""Displacements of 1e-8 m are handed on as positions of 1 m, once a look: 1e-8 of them each, which
a hundred looks gather. The plain form and both compiled paths differ by up to 1.4e-7 and 4e-7."""
HELD = {"sides": "held"}
RULES = (
    kit.Rule(
        "loss of speed over 3β/s², from 1", 0.1, "1",
        "the next terms of the dispersion are smaller by the order of (a/s)², at most 0.04, and "
        "(H/s)² = 0.16, with factors below one half",
        table="wave", value=kit.Quotient("loss", "loss_predicted"), reference=1.0,
    ),
    kit.Rule(
        "order in the spacing of the loss of speed, sides held", 0.1, "1",
        "the loss is 3(a² - c0²h²)/24s², h in proportion to a; the next term is of order four, on "
        "the coarsest bar a fiftieth of it",
        table="wave", rows=HELD, value="loss", power_of="spacing_m", reference=2.0,
    ),
    kit.Rule(
        "speed extrapolated to no spacing against c0, sides held", 2e-4, "1",
        "what the line through the two finest, in a², leaves of the fourth order",
        table="wave", rows=HELD, value=lambda rows: extrapolate(rows),  # noqa: PLW0108  defined below
    ),
    kit.Rule(
        "velocity returned from the held end, over what came, from -1", 0.01, "1",
        "a held end inverts every frequency whole; the peak has sunk by 3(β/s³)²(1.3² - 0.7²) m², "
        "0.3 % on the coarsest chain and twice that on the coarsest slender bar",
        table="wave", value="returned", reference=-1.0,
    ),
    kit.Rule(
        "stress at the held end over ρ·c0·v of what came, from 2", 0.02, "1",
        "both waves add there; the peak sinks as above, c0 is the speed of long waves only, and a "
        "clamped end of a slender bar cannot narrow, over a length of the order of H",
        table="wave", value="wall_stress", reference=2.0,
    ),
)  # fmt: skip


class Bar(NamedTuple):
    """A bar at rest: its network, long-wave speed (m/s), β (m²) but for the step, and moduli."""

    network: kit.Network
    speed: float
    beta: float
    modulus: float
    spacing: float
    height: float


class Flight(NamedTuple):
    """What was seen at each look (k): time (s), mid-line velocity (k, columns), wall force (N)."""

    time: kit.Array
    velocity: kit.Array
    wall: kit.Array
    dt: float


def run(candidate: MotionSolver, setting: kit.Setting) -> kit.Evidence:
    """Strike both bars at every resolution."""
    cells = QUICK_CELLS if setting.quick else CELLS
    cases = list(product(SIDES, cells))
    found = setting.sweep(partial(strike_bar, candidate), cases, "strain wave")
    table = pd.DataFrame([row for row, _ in found])
    return kit.Evidence(
        tables={"wave": table, "wave_xt": found[len(cells) - 1][1]},
        tolerances=RULES,
        figures={"wave": draw},
        columns=kit.columns(__file__),
        findings=(finding(table),),
    )


def bar(sides: str, cells: int) -> Bar:
    """A bar held at its left end; one cell high where nothing may move across."""
    spacing = LENGTH / cells
    across = max(1, round(HEIGHT / spacing)) if sides == "free" else 1
    box = kit.Box((LENGTH, across * spacing))
    tensor = square_tensor(*ISOTROPIC)
    left = kit.Support(box.side("left"), (0.0, 0.0))
    problem = kit.Problem(box, kit.Anisotropic(tensor, density=DENSITY), (left,), name="bar")
    network = lattice_network(problem, square(box, (cells, across)), ISOTROPIC)
    beta, modulus = spacing**2 / 24, float(tensor[0, 0])
    if sides == "held":
        held = np.array(network.fixed)
        held[:, 1] = True
        network = replace(network, fixed=held)
    else:
        found = moduli(tensor)
        modulus = found.E
        middle = network.points[:, 1] - network.points[:, 1].mean()
        square_height = float(network.mass @ middle**2 / network.mass.sum())
        beta += found.nu**2 * (square_height / 2 - spacing**2 / (8 * (1 + found.nu)))
    speed = float(np.sqrt(modulus / DENSITY))
    return Bar(network, speed, beta, modulus, spacing, box.size[1])


def strike_bar(
    candidate: MotionSolver, case: tuple[str, int]
) -> tuple[dict[str, object], pd.DataFrame]:
    """One row, and the wave in place and time."""
    sides, cells = case
    body = bar(sides, cells)
    flight = track_wave(candidate, body)
    x = np.unique(body.network.points[:, 0])
    v = STRENGTH * body.speed
    there, back = (arrival_time(flight, x, MIRROR, way) for way in (-1, 1))
    first, second = (arrival_time(flight, x, place, -1) for place in STATIONS)
    speed = (STATIONS[0] - STATIONS[1]) / (second[0] - first[0])
    beta = body.beta - (body.speed * flight.dt) ** 2 / 24
    row = {
        "sides": sides,
        "cells": cells,
        "cells_across": round(body.height / body.spacing),
        "spacing_m": body.spacing,
        "spacing_over_s": body.spacing / DEVIATION,
        "dt_s": flight.dt,
        "speed_m_s": speed,
        "c0_m_s": body.speed,
        "loss": 1 - speed / body.speed,
        "loss_predicted": 3 * beta / DEVIATION**2,
        "returned": -back[1] / there[1],
        "wall_stress": peak(flight.time, flight.wall)[1]
        / (body.height * DENSITY * body.speed * there[1]),
    }
    return row, picture(flight, x, v)


def track_wave(candidate: MotionSolver, body: Bar) -> Flight:
    """Strike the bar's right end and watch until the wave has come back to the middle."""
    network = body.network
    block = DEVIATION / body.speed / BLOCKS
    steps = round(LENGTH / body.spacing) // CELLS_A_STEP
    dt = block / steps
    end = network.points[:, 0] > LENGTH - body.spacing / 2
    share = network.mass * end / network.mass[end].sum()
    row = network.points[:, 1] < body.spacing / 2
    wall = network.points[:, 0] < body.spacing / 2
    state = State(network.points, np.zeros_like(network.points))
    looks = int(np.ceil((LENGTH + STATIONS[0] + 2 * DELAY * DEVIATION) / DEVIATION * BLOCKS))
    velocity, wall_force = [], []
    for look in range(looks):
        # The mean of the block: at its middle, with the Gaussian's own curvature left out.
        late = (look + 0.5) / BLOCKS - DELAY
        total = body.modulus * STRENGTH * body.height * np.exp(-(late**2) / 2)
        force = np.column_stack([-total * share, np.zeros(len(share))])
        loaded = replace(network, force=force) if late < DELAY else network
        state = candidate(loaded, state, dt, steps, 0.0)
        velocity.append(state.velocity[row, 0])
        wall_force.append(-float(internal_force(network, state.position)[wall, 0].sum()))
    time = block * np.arange(1.0, looks + 1)
    return Flight(np.asarray(time), np.array(velocity), np.array(wall_force), dt)


def arrival_time(flight: Flight, x: kit.Array, place: float, way: int) -> tuple[float, float]:
    """Time (s) and speed (m/s) of the peak that passes a place to the left (-1) or right (1)."""
    at = int(np.abs(x - place).argmin())
    return peak(flight.time, way * flight.velocity[:, at])


def peak(time: kit.Array, values: kit.Array) -> tuple[float, float]:
    """Time and height of the highest peak: a Gaussian through three points."""
    i = int(np.clip(values.argmax(), 1, len(values) - 2))
    low, top, high = np.log(np.maximum(values[i - 1 : i + 2], 1e-300))
    bend, tilt = low + high - 2 * top, (high - low) / 2
    step = time[1] - time[0]
    return float(time[i] - step * tilt / bend), float(np.exp(top - tilt**2 / bend / 2))


def extrapolate(held: pd.DataFrame) -> float:
    """Loss of speed at no spacing, by a line in its square through the two finest bars."""
    finest = held.nsmallest(2, "spacing_m")
    square, loss = finest["spacing_m"].to_numpy() ** 2, finest["loss"].to_numpy()
    return float(loss[0] - square[0] * (loss[1] - loss[0]) / (square[1] - square[0]))


def picture(flight: Flight, x: kit.Array, unit: float) -> pd.DataFrame:
    """Velocity in place and time, at no more than `SHOWN` of each."""
    columns, times = (
        np.arange(0, size, max(1, size // most))
        for size, most in zip((len(x), len(flight.time)), SHOWN, strict=True)
    )
    grid = flight.velocity[np.ix_(times, columns)] / unit
    t, places = np.meshgrid(flight.time[times], x[columns], indexing="ij")
    return pd.DataFrame({"time_s": t.ravel(), "x": places.ravel(), "velocity": grid.ravel()})


def finding(table: pd.DataFrame) -> str:
    """Speeds on the finest bars."""
    finest = table[table["cells"] == table["cells"].max()].set_index("sides")
    speed, c0 = finest["speed_m_s"], finest["c0_m_s"]
    return (
        f"The wave runs at {speed['held']:.5g} m/s with the sides held (√(C11/ρ) = "
        f"{c0['held']:.5g}) and at {speed['free']:.5g} m/s along a slender bar (√(E2/ρ) = "
        f"{c0['free']:.5g}); the held end returns {finest['returned']['held']:.4g} of its "
        f"velocity, and the wall feels {finest['wall_stress']['held']:.4g} times its stress."
    )


def draw(tables: kit.Tables) -> Figure:
    """The wave in place and time, and the loss of speed against the spacing."""
    wave, table = tables["wave_xt"], tables["wave"]
    figure, (diagram, losses) = kit.figures.new_figure(2, size=(3.6, 3.3))
    grid = wave.pivot_table(index="time_s", columns="x", values="velocity")
    shades = diagram.pcolormesh(
        grid.columns, grid.index, grid, cmap="RdBu", vmin=-1, vmax=1, rasterized=True
    )
    figure.colorbar(shades, ax=diagram, label="over that struck (1)")
    diagram.set_title("velocity; sides held, struck at the right")
    diagram.set(xlabel="place along the bar (m)", ylabel="time (s)")
    for place, (sides, own) in enumerate(table.groupby("sides", sort=False)):
        style, fineness = kit.figures.series_style(place), own["spacing_over_s"] ** 2
        losses.plot(fineness, own["loss"], ls="", label=f"sides {sides}", **style)
        losses.plot(fineness, own["loss_predicted"], color=style["color"], lw=0.9)
    losses.plot([], [], color="black", lw=0.9, label="3β/s², predicted")
    losses.set(title="speed lost to dispersion", xlim=(0, None), ylim=(0, None))
    losses.set_xlabel("(spacing over the pulse's\nstandard deviation s)² (1)")
    losses.set_ylabel("speed lost, 1 - c/c0 (1)")
    figure.suptitle("A wave along a bar of springs")
    losses.legend()
    return figure
