"""Three ways to the same slabs at the voltages of Figure 8, each read off in the same numbers."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from msvalidate import kit
from msvalidate.dielectric.actuator import Actuator, relax_actuator
from msvalidate.dielectric.actuator.models import charge_actuator
from reference_fem import facing_slab
from reference_fem.actuator import SoftSlab, equilibrium_at
from reference_fem.large_strain import square_fibres

from .bodies import AXIAL, COVERED, DIAGONAL, HEIGHT, LENGTH, ActuatorSolver, body, upper_face

COARSE = 5
"""Layers of the lattice on which the report's way is walked a second time."""
SOURCES = ("springs", "the report's way", f"the report's way, {COARSE} layers", "FEM")
CHARGES_EVERY = 10
"""Steps of Algorithm 1 between two solutions for its charges: where it rests is the same."""
RESTING = 1e-5
"""Residual at which Algorithm 1 stops, over the forces that meet at a point."""
MIDDLE_HALF = 0.25
"""Part of the electrode on either side of its middle half."""


@dataclass(frozen=True, eq=False)
class Observation:
    """A slab at rest at a voltage.

    Parameters
    ----------
    voltage
        V.
    x
        (p,) places of the upper face's points at rest (m).
    move
        (p, 2) their displacements (m).
    covered
        (p,) whether they are under the upper electrode.
    inner
        Part of the upper electrode's charge on the middle half of its points.
    """

    voltage: float
    x: kit.Array
    move: kit.Array
    covered: kit.Mask
    inner: float


def run_springs(
    candidate: ActuatorSolver, covered: str, layers: int, voltages: tuple[float, ...]
) -> list[Observation]:
    """The candidate at each voltage, up to the last that it holds."""
    actuator = body(covered, layers)
    found = []
    for voltage in voltages:
        try:
            found.append(observe_actuator(actuator, voltage, candidate(actuator, voltage)))
        except kit.SolverError:
            break
    return found


def run_report_model(covered: str, layers: int, voltages: tuple[float, ...]) -> list[Observation]:
    """The report's way: Algorithm 1, its kernel and point forces, at each voltage from the last.

    Springs are rectangles 1 m deep: squares, where there are 10 layers.
    """
    actuator = replace(body(covered, layers), model="as_report")
    found: list[Observation] = []
    last = None
    for voltage in voltages:
        try:
            last = relax_actuator(
                actuator, voltage, start=last, charges_every=CHARGES_EVERY, tolerance=RESTING
            )
        except kit.SolverError:
            break
        found.append(observe_actuator(actuator, voltage, last.displacement))
    return found


def run_elements(covered: str, layers: int, voltages: tuple[float, ...]) -> list[Observation]:
    """Finite elements as large as the lattice's cells, at large strain."""
    slab = facing_slab(LENGTH, HEIGHT, covered=COVERED[covered])
    law = square_fibres(AXIAL, DIAGONAL)
    soft = SoftSlab(slab, law, layers, element="Q1", grading=1.0)
    points = body(covered, layers).network.points
    top = points[upper_face(points)]
    on = np.abs(top[:, 0] - 0.5 * LENGTH) <= 0.5 * LENGTH * COVERED[covered] + 1e-9
    conductor = soft.mesh.conductors[0]
    order = np.argsort(soft.mesh.body.points[conductor, 0], kind="stable")
    found: list[Observation] = []
    last = None
    for voltage in voltages:
        try:
            last = equilibrium_at(soft, voltage, start=last)
        except kit.SolverError:
            break
        charge = last.electric.potential.charge[conductor][order]
        pieces = 0.5 * (charge[1:] + charge[:-1])
        pieces[[0, -1]] += 0.5 * charge[[0, -1]]
        found.append(Observation(voltage, top[:, 0], last.at(top), on, inner_charge(pieces)))
    return found


def observe_actuator(actuator: Actuator, voltage: float, move: kit.Array) -> Observation:
    """What is read off an actuator whose points have moved (n, 2) in m."""
    network, (line, _) = actuator.network, actuator.electrodes
    top = upper_face(network.points)
    charges = charge_actuator(actuator, network.points + move, voltage).charges
    own = charges.charge[: len(line) - 1]
    return Observation(
        voltage, network.points[top, 0], move[top], np.isin(top, line), inner_charge(own)
    )


def inner_charge(pieces: kit.Array) -> float:
    """Part of charges (k,) in order along an electrode that is on its middle half."""
    k = len(pieces)
    out = round(MIDDLE_HALF * k)
    return float(pieces[out : k - out].sum() / pieces.sum())
