"""The bodies that are let go, and their modes: `dynamics.damping` has how each comes to rest."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
from scipy.linalg import eigh

from msvalidate import kit
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.constants.homogenise import interior_tensor
from msvalidate.springs.dynamics.integrate import State, euler_cromer
from msvalidate.springs.dynamics.integrators import EULER_CROMER
from msvalidate.springs.dynamics.step_limits import stability_limit
from msvalidate.springs.lattice import square
from msvalidate.springs.network import tangent
from msvalidate.springs.statics.equilibrium import equilibrium

MotionSolver = Callable[[kit.Network, State, float, int, Any], State]
"""A candidate: state after so many steps of dt (s) with a damping (1/s)."""
MOTION = partial(euler_cromer, warn=False)
"""The compiled Euler-Cromer. Steps beyond its limit are asked for on purpose here."""

ISOTROPIC = (1.0, 0.5)
"""Spring constants (N/m), axial and diagonal: the tensor is isotropic, Poisson's ratio 1/3."""
DENSITY = 1.0
"""Mass an area (kg/m²), at a thickness of 1 m."""
LOAD = 1e-6
"""Displacement (1) of the loaded end over the body's length: the motion is then linear but for
parts in a million, and rounding is a part in 1e9."""
SAFETY = 0.9
"""Part of Euler-Cromer's limit, at the damping in question, that a step takes."""


@dataclass(frozen=True, eq=False)
class Body:
    """A loaded network, where it comes to rest, and its modes about the reference points.

    Parameters
    ----------
    name
        In tables.
    network
        Loaded; it starts at its reference points.
    rest
        (n, d) displacement (m) at rest.
    frequencies
        (m,) rad/s, ascending.
    shapes
        (m, n·d) mass-normalised: shapes · M · shapesᵀ = 1.
    """

    name: str
    network: kit.Network
    rest: kit.Array
    frequencies: kit.Array
    shapes: kit.Array

    @property
    def start(self) -> State:
        """At rest at the reference points: the load comes suddenly."""
        return State(self.network.points, np.zeros_like(self.network.points))

    @property
    def unloaded(self) -> kit.Network:
        """The network without its load."""
        return replace(self.network, force=np.zeros_like(self.network.force))

    def amplitudes(self, field: kit.Array) -> kit.Array:
        """Modal amplitudes (m,) of a displacement or velocity (n, d), in its unit times √kg."""
        return np.asarray(self.shapes @ (self.network.mass[:, None] * field).ravel())

    def norm(self, field: kit.Array) -> float:
        """√Σ m|u|² of a displacement or velocity (n, d): the amplitudes' length."""
        return float(np.sqrt(self.network.mass @ (field**2).sum(axis=1)))

    def error(self, state: State) -> float:
        """Distance from rest over the whole way to rest, in the norm of masses."""
        return self.norm(state.position - self.network.points - self.rest) / self.size

    def left(self, state: State) -> float:
        """A bound of `error` from now on.

        Viscosity lets no mode's v² + ω²x² grow, so x² stays below x² + (v/ω)² of now.
        """
        swing = self.norm(state.velocity) / (self.frequencies[0] * self.size)
        return float(np.hypot(self.error(state), swing))

    @cached_property
    def size(self) -> float:
        """The way to rest (m·√kg)."""
        return self.norm(self.rest)

    @cached_property
    def shares(self) -> kit.Array:
        """Amplitudes (m,) of the modes in the way to rest, over its size."""
        return np.abs(self.amplitudes(self.rest)) / self.size

    def lowest_excited(self, visible: float) -> int:
        """First mode with a share above `visible`: what is below is never seen in an error."""
        return int(np.flatnonzero(self.shares > visible)[0])

    def time_step(self, damping: float, part: float = SAFETY) -> float:
        """Time step (s): `part` of Euler-Cromer's limit with a damping (1/s)."""
        ends = float(self.frequencies[0]), float(self.frequencies[-1])
        return part * stability_limit(EULER_CROMER, *ends, damping)


def loaded(
    name: str,
    cells: tuple[int, int],
    load: str,
    *,
    constants: tuple[float, float] = ISOTROPIC,
    equal: bool = False,
) -> Body:
    """A rectangle 1 m high of square cells, clamped at its left and loaded at its right.

    Parameters
    ----------
    name, cells
        In tables; along and across.
    load
        "along" pulls at the right end, "across" bends or shears.
    constants
        Of axial and diagonal springs (N/m).
    equal
        Whether all springs and all masses count alike, as in the report; else by their cells.
    """
    weights = "equal" if equal else "shared"
    box = kit.Box((cells[0] / cells[1], 1.0))
    grid = square(box, cells)
    material = kit.Anisotropic(interior_tensor(grid, constants, weights), density=DENSITY)
    wall = kit.Support(box.side("left"), (0.0, 0.0))
    direction = (1.0, 0.0) if load == "along" else (0.0, 1.0)

    def under(stress: float) -> kit.Network:
        pull = kit.Traction(box.side("right"), (stress * direction[0], stress * direction[1]))
        problem = kit.Problem(box, material, (wall,), (pull,), name=name)
        return lattice_network(
            problem, grid, constants, weights=weights, mass="equal" if equal else "shared"
        )

    reach = np.abs(equilibrium(under(1.0)).displacement).max()
    network = under(LOAD * box.size[0] / reach)
    rest = equilibrium(network, "nonlinear").displacement
    frequencies, shapes = modes(network)
    along, across = cells
    return Body(f"{name}, {along} x {across}", network, rest, frequencies, shapes)


def modes(network: kit.Network) -> tuple[kit.Array, kit.Array]:
    """All frequencies (m,) in rad/s and mass-normalised shapes (m, n·d), zero where it is held."""
    free = np.flatnonzero(~network.fixed.ravel())
    scale = 1 / np.sqrt(np.repeat(network.mass, network.dim)[free])
    K = tangent(network, network.points)[free][:, free].toarray()
    squares, vectors = eigh(scale[:, None] * K * scale)
    shapes = np.zeros((len(free), network.points.size))
    shapes[:, free] = (scale[:, None] * vectors).T
    return np.sqrt(squares), shapes


def one_step(omegas: kit.Array, dt: float, damping: float) -> kit.Array:
    """Matrices (m, 2, 2) by which a step of Euler-Cromer takes (x, v) of modes to the next.

    v' = (1 - hc)·v - hω²·x and x' = x + h·v'.
    """
    kick, kept = -dt * omegas**2, np.full(len(omegas), 1 - dt * damping)
    return np.moveaxis(np.array([[1 + dt * kick, dt * kept], [kick, kept]]), 2, 0)
