"""The candidate: how an actuator comes to rest at a voltage, which of its motions are soft.

And the laws behind the thresholds that `which` computes.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from msvalidate import kit
from msvalidate.dielectric.actuator import (
    Actuator,
    ActuatorEquilibrium,
    PulledIn,
    at_voltage,
    lowest_modes,
    slab,
)

from . import film, homogeneous, pressed
from .slab import AXIAL, DIAGONAL, HEIGHT, LENGTH, PERMITTIVITY


class Laws(NamedTuple):
    """Of what the films are that `which` finds thresholds of, by other routes than closed forms.

    Parameters
    ----------
    straight, lattice, elements
        Pressure (Pa) -> thickness over that at no load (1) of a column: of springs whose stress is
        linear in it, of the lattice, and of finite elements with the lattice's energy.
    sheet
        Two stretches (1) -> energy over μ of a sheet that keeps its volume.
    wave
        κ = kh (1) -> field over √(μ/ε) at which a wave of a bonded film grows.
    """

    straight: Callable[[float], float] = pressed.straight_springs
    lattice: Callable[[float], float] = pressed.springs
    elements: Callable[[float], float] = pressed.elements
    sheet: homogeneous.Law = homogeneous.neo_hookean
    wave: Callable[[float], float] = film.field


class PullInSolver(NamedTuple):
    """What is judged.

    Parameters
    ----------
    at_voltage
        (actuator, voltage, start=, bracket=) -> `ActuatorEquilibrium`: stable rest at a voltage
        (V), walked to
        from an equilibrium; raises `PulledIn` where there is none.
    modes
        (held, count) -> eigenvalues (count,) in N/m and shapes (count, n, 2) of K_mech - K_elec.
    laws
        Of the films that are computed beside closed forms.
    """

    at_voltage: Callable[..., ActuatorEquilibrium] = at_voltage
    modes: Callable[..., tuple[kit.Array, kit.Array]] = lowest_modes
    laws: Laws = Laws()


SPRINGS = PullInSolver()
"""The network's own equilibrium and stiffness."""


def sliding(layers: int) -> Actuator:
    """A slab two cells long between frictionless walls, in the field of parallel plates."""
    return slab(
        2 * HEIGHT / layers,
        HEIGHT,
        layers,
        axial=AXIAL,
        diagonal=DIAGONAL,
        permittivity=PERMITTIVITY,
        sides="sliding",
        model="parallel_plates",
    )


def bonded(layers: int, length: float = LENGTH) -> Actuator:
    """The slab (m) with free ends, electrodes over both faces, in one medium."""
    return slab(length, HEIGHT, layers, axial=AXIAL, diagonal=DIAGONAL, permittivity=PERMITTIVITY)


def last_equilibrium(
    way: PullInSolver,
    actuator: Actuator,
    beyond: float,
    *,
    start: ActuatorEquilibrium | None = None,
    bracket: float,
) -> tuple[ActuatorEquilibrium, float]:
    """The last equilibrium on the way to a voltage (V), and one a small step on that is not held.

    Where all are held, that at `beyond` and `beyond`.
    """
    try:
        return way.at_voltage(actuator, beyond, start=start, bracket=bracket), beyond
    except PulledIn as error:
        return error.last, error.beyond


def middle(held: ActuatorEquilibrium) -> float:
    """Thickness in the middle of the top electrode, over that at no voltage (1)."""
    top = held.actuator.electrodes[0]
    height = held.actuator.network.start[top, 1]
    moved = held.position[top, 1] / height
    half, odd = divmod(len(top), 2)
    return float(moved[half] if odd else 0.5 * (moved[half - 1] + moved[half]))
