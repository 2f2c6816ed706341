"""Three ways to lose stability, followed on one mesh: at the electrode's edge twice, and inside.

- `edge_flat`: the slab as it lies at no voltage, charged; when does its stiffness go?
- `edge_followed`: the slab as it is, its equilibria followed to where they end;
- `inside`: points within a height of the ends are held where an infinite slab has them at each
  voltage, so that there is no edge to give way first, and the rest is in equilibrium.

Held where they start, as `actuator.fix_near_tips` has them, the points at the edges would leave a
step in the surface that is an edge of its own.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from msvalidate import kit
from msvalidate.dielectric.actuator import Actuator, ActuatorEquilibrium, PulledIn, uniform

from .slab import AXIAL, DIAGONAL, HEIGHT, LENGTH, PERMITTIVITY, PULL_IN, REACH
from .way import PullInSolver, bonded, last_equilibrium

PARTS = (0.0, 0.25, 0.5, 0.7, 0.85, 0.95)
"""Of the critical voltage, at which the lowest eigenvalue is looked at, and at that voltage."""
BELOW = (0.25, 0.5, 0.7, 0.8, 0.87, 0.92)
"""Of the uniform pull-in voltage: below the instability inside, at which equilibria are found."""
HIGHEST = 1.6
"""Over the pull-in voltage: where the search for an edge's voltage on the flat slab ends."""
BRACKET = 1e-4
"""Part of the voltage to which a critical one is found."""
EDGE_BRACKET = 1e-6
"""The same where equilibria end: the lowest eigenvalue goes with the root of what is missing, and
that of the edge starts a hundred times above that of the slab as a whole."""


class Branch(NamedTuple):
    """What was followed: the last equilibrium, its mode (n, 2), and eigenvalues on the way.

    Parameters
    ----------
    last
        At the critical voltage; of the flat slab no equilibrium.
    mode
        (n, 2), of unit length.
    seen
        (voltage (V), lowest eigenvalue (N/m)) at rising voltages, the critical one last.
    """

    last: ActuatorEquilibrium
    mode: kit.Array
    seen: list[tuple[float, float]]


def closed(volts: float) -> float:
    """Thickness of the infinite slab at a voltage (V)."""
    return uniform.thickness(
        volts, height=HEIGHT, axial=AXIAL, diagonal=DIAGONAL, permittivity=PERMITTIVITY
    )


def edge_flat(way: PullInSolver, layers: int) -> Branch:
    """The flat slab: K_mech - K_elec at the start, the voltage raised until it loses its sign."""
    rest = way.at_voltage(bonded(layers), 0.0)

    def softest(volts: float) -> float:
        return float(way.modes(replace(rest, voltage=volts), 1)[0][0])

    most = HIGHEST * PULL_IN.voltage
    low = 0.05 * PULL_IN.voltage
    volts = brentq(softest, low, most, xtol=BRACKET * low) if softest(most) < 0 else most
    last = replace(rest, voltage=float(volts))
    seen = [(part * last.voltage, softest(part * last.voltage)) for part in (*PARTS, 1.0)]
    return Branch(last, way.modes(last, 1)[1][0], seen)


def edge_followed(way: PullInSolver, layers: int) -> Branch:
    """Equilibria of the slab as it is, to the last that is held."""
    actuator = bonded(layers)
    last, _ = last_equilibrium(way, actuator, PULL_IN.voltage, bracket=EDGE_BRACKET)
    held, seen = None, []
    for part in PARTS:
        held = way.at_voltage(actuator, part * last.voltage, start=held)
        seen.append((held.voltage, float(way.modes(held, 1)[0][0])))
    values, modes = way.modes(last, 1)
    return Branch(last, modes[0], [*seen, (last.voltage, float(values[0]))])


def inside(way: PullInSolver, layers: int) -> Branch:
    """Equilibria between ends that are pressed as an infinite slab is."""
    actuator = bonded(layers)
    held = pressed(way, actuator, 0.0)
    if held is None:
        raise kit.SolverError(f"bonded slab of {layers} layers: no equilibrium without a voltage")
    seen, bad = [(0.0, float(way.modes(held, 1)[0][0]))], PULL_IN.voltage
    for part in BELOW:
        found = pressed(way, actuator, part * PULL_IN.voltage, held)
        if found is None:
            bad = part * PULL_IN.voltage
            break
        held = found
        seen.append((held.voltage, float(way.modes(held, 1)[0][0])))
    while bad - held.voltage > BRACKET * bad:
        middle = 0.5 * (held.voltage + bad)
        found = pressed(way, actuator, middle, held)
        held, bad = (held, middle) if found is None else (found, bad)
    values, modes = way.modes(held, 1)
    return Branch(held, modes[0], [*seen, (held.voltage, float(values[0]))])


def pressed(
    way: PullInSolver, actuator: Actuator, volts: float, near: ActuatorEquilibrium | None = None
) -> ActuatorEquilibrium | None:
    """Equilibrium at a voltage (V) between ends pressed evenly; None where there is none.

    It is looked for from an equilibrium nearby, or from the state of an infinite slab.
    """
    network = actuator.network
    x, y = network.points.T
    ends = np.minimum(x - x.min(), x.max() - x) <= REACH * (1 + 1e-9)
    evenly = np.column_stack([np.zeros(len(y)), (closed(volts) - 1) * y])
    held = network.fixed | ends[:, None]
    gripped = replace(
        actuator, network=replace(network, fixed=held, displacement=np.where(held, evenly, 0.0))
    )
    place = evenly if near is None else near.displacement
    # As if at rest there at a voltage a hair below: the walk takes one step or none.
    start = ActuatorEquilibrium(gripped, volts * (1 - BRACKET), place, None, 0, 0.0)
    try:
        return way.at_voltage(gripped, volts, start=start, bracket=10 * BRACKET)
    except PulledIn:
        return None


FOLLOWED: dict[str, Callable[[PullInSolver, int], Branch]] = {
    "edge, flat": edge_flat,
    "edge, followed": edge_followed,
    "inside": inside,
}
"""Branch -> what follows it with cells up the slab's height."""


def wavelength(held: ActuatorEquilibrium, mode: kit.Array) -> float:
    """Wavelength (m) of a mode on the top electrode: where its Fourier integral is largest."""
    top = held.actuator.electrodes[0]
    x, up = held.actuator.network.points[top, 0], mode[top, 1]
    shortest = 2 * (x[1] - x[0])

    def power(q: kit.Array) -> kit.Array:
        return np.asarray(np.abs(np.exp(-1j * np.outer(q, x)) @ up) ** 2)

    grid = np.linspace(2 * np.pi / LENGTH, 2 * np.pi / shortest, 40 * len(x))
    at, step = grid[int(power(grid).argmax())], grid[1] - grid[0]
    found = minimize_scalar(
        lambda q: -power(np.array([q]))[0],
        bounds=(at - step, min(at + step, 2 * np.pi / shortest)),
        method="bounded",
        options={"xatol": 1e-9},
    )
    return float(2 * np.pi / found.x)


def at_edge(held: ActuatorEquilibrium, mode: kit.Array) -> float:
    """Part of a mode's square within half of `REACH` of the top electrode's edges."""
    points, top = held.actuator.network.points, held.actuator.electrodes[0]
    away = np.linalg.norm(points[:, None] - points[top[[0, -1]]], axis=2).min(axis=1)
    square = (mode**2).sum(axis=1)
    return float(square[away <= 0.5 * REACH * (1 + 1e-9)].sum() / square.sum())
