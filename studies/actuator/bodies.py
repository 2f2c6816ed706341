"""The slabs of the study, who moves them, and what is read off their upper face."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from msvalidate import kit
from msvalidate.dielectric.actuator import Actuator, at_voltage, slab
from msvalidate.dielectric.actuator.models import charge_actuator
from msvalidate.springs.constants.homogenise import interior_tensor
from msvalidate.springs.constants.stiffness import moduli
from msvalidate.springs.lattice import square
from msvalidate.springs.statics.equilibrium import equilibrium
from reference_fem import facing_slab, respond, slab_mesh, solve_charges

LENGTH, HEIGHT = 60.0, 10.0
"""Of the slab, bonded at its base (m)."""
AXIAL, DIAGONAL = 1.0, 0.5
"""Spring constants (Pa) for which square cells with diagonals are isotropic."""
COVERED = {"full": 1.0, "partial": 1 / 3}
"""Name in tables -> part of the upper face under the electrode, in its middle."""

ActuatorSolver = Callable[[Actuator, float], kit.Array]
"""Displacement (n, 2) in m of an actuator's points at rest at a voltage (V)."""
Spoil = Callable[[Actuator, kit.Array], kit.Array]
"""Forces (k, 2) in N on the electrodes' points, top then bottom, in place of the right ones."""


def body(covered: str, layers: int, ratio: float = 1.0) -> Actuator:
    """The slab with as many cells up its height, its upper face covered as `COVERED` says.

    Its permittivity is 1 F/m; with a ratio above 1 it lies in air of that much less.
    """
    part = COVERED[covered]
    found = slab(LENGTH, HEIGHT, layers, covered=part, axial=AXIAL, diagonal=DIAGONAL)
    return found if ratio == 1 else replace(found, model="in_air", permittivity_ratio=ratio)


def tips(covered: str) -> kit.Array:
    """Where (m) along the slab the upper electrode begins and ends."""
    half = 0.5 * LENGTH * COVERED[covered]
    return 0.5 * LENGTH + half * np.array([-1.0, 1.0])


def springs(actuator: Actuator, voltage: float) -> kit.Array:
    """The network at rest, its charges at rest with it."""
    return at_voltage(actuator, voltage).displacement


def linear_response(spoil: Spoil | None, actuator: Actuator, voltage: float) -> kit.Array:
    """Linear response (n, 2) in m to forces at the points' first places, spoilt if asked to be."""
    network = actuator.network
    electric = charge_actuator(actuator, network.start, voltage)
    pull = electric.forces()
    force = np.array(network.force)
    force[electric.loaded] += pull if spoil is None else spoil(actuator, pull)
    return equilibrium(replace(network, force=force)).displacement


def elastic(layers: int, actuator: Actuator, voltage: float) -> kit.Array:
    """Finite elements in the springs' place: the slab's linear response."""
    network, (top, _) = actuator.network, actuator.electrodes
    ends = network.points[top[[0, -1]], 0]
    length, height = network.points.max(axis=0)
    question = facing_slab(
        length,
        height,
        voltage,
        covered=float(np.ptp(ends) / length),
        permittivity=actuator.permittivity,
        air=actuator.permittivity / actuator.permittivity_ratio,
    )
    mesh = slab_mesh(question, layers)
    return respond(mesh, solve_charges(mesh).forces, plane_material()).at(network.points)


def plane_material() -> kit.Isotropic:
    """The isotropic body that the springs are, from the lattice's homogenised tensor."""
    cell = square(kit.Box((1.0, 1.0)), (1, 1))
    found = moduli(interior_tensor(cell, (AXIAL, DIAGONAL), "shared"))
    return kit.Isotropic(found.E, found.nu, "plane_stress")


def upper_face(points: kit.Array) -> kit.Index:
    """Numbers of the points of the upper face, from left to right."""
    at = np.flatnonzero(np.isclose(points[:, 1], points[:, 1].max()))
    return at[np.argsort(points[at, 0], kind="stable")]


def uniform_deflection(voltage: float, permittivity: float = 1.0) -> float:
    """Deflection (m) to first order of a slab that stays uniform: εV²/(2·h·C22)."""
    return permittivity * voltage**2 / (2 * HEIGHT * (AXIAL + DIAGONAL))
