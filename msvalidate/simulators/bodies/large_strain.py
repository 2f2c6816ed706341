"""Beyond first order: a body at 5 % strain beside linear tetrahedra of the *same* law.

The probe reads a law's derivative at rest. Whether the rest of the law is the documented one shows
only where strains are large, and only beside elements of that law on the same mesh: linear
elasticity is no reference there.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from msvalidate.linear_algebra.norms import max_abs, max_length
from msvalidate.problem import Array, Isotropic, SolverError
from msvalidate.problem.records import dataclass, replace
from msvalidate.simulators.bodies import blocks
from msvalidate.simulators.bodies.tetrahedra import Stress, at_rest, linear_elements
from msvalidate.simulators.exchange.protocol import (
    CannotRepresent,
    Request,
    Simulator,
    ask,
    stated_residual_motion,
)
from msvalidate.simulators.probe.block import Block

STRAIN = 0.05
"""Largest principal strain of linear elements under the loads that are asked for."""
BODIES = ("clamped_shear_space", "block_gravity_space")
"""Cases of the set, the first that a program can represent counts."""
MESH = "tet4"


@dataclass(frozen=True)
class AtLargeStrain:
    """A body at large strain.

    Parameters
    ----------
    case
        Of the frozen set, its loads multiplied.
    strain
        Largest principal value of Green's strain of the elements of the same law.
    apart
        Largest difference from those, over the largest displacement.
    from_linear
        The same of linear elements of the law's first order: how much there was to be seen.
    rest
        Part of the displacement that may still change, as stated; NaN if nobody says.
    """

    case: str
    strain: float
    apart: float
    from_linear: float
    rest: float


def at_large_strain(
    simulator: Simulator,
    material: Isotropic,
    stress: Stress,
    settings: Mapping[str, Any],
    mass_of: Callable[[Request], Array | None],
) -> AtLargeStrain:
    """Bring a body to rest under loads that strain it, and hold it against elements of its law.

    Parameters
    ----------
    simulator, material, settings
        As of `judge_simulator`.
    stress
        The documented law with the constants that it takes for this material.
    mass_of
        (n,) kg of a request's nodes as measured; None where they are those asked.

    Raises
    ------
    CannotRepresent, SimulatorError
        As the simulator says of the last body.
    SolverError
        If elements of the law do not come to rest there.
    """
    refused: CannotRepresent | None = None
    for name in BODIES:
        request = _strained(name, material, settings)
        try:
            answer = ask(simulator, request)
        except CannotRepresent as error:
            refused = error
            continue
        mass = mass_of(request)
        weighed = request if mass is None else replace(request, mass=mass)
        try:
            wanted, solid = at_rest(weighed, stress)
        except SolverError as error:
            raise SolverError(f"{name} at {STRAIN:.0%} strain: {error}") from error
        F = solid.gradient(wanted)
        green = np.linalg.eigvalsh((np.swapaxes(F, -1, -2) @ F - np.eye(3)) / 2)
        linear = linear_elements(weighed, material.E, material.nu)
        found = np.asarray(answer.displacement)
        return AtLargeStrain(
            name,
            float(np.abs(green).max()),
            max_length(found - wanted) / max_length(wanted),
            max_length(linear - wanted) / max_length(wanted),
            stated_residual_motion(request, answer),
        )
    raise refused or CannotRepresent("no body")


def _strained(name: str, material: Isotropic, settings: Mapping[str, Any]) -> Request:
    """A case of the set as a request, its loads multiplied so that they strain it by `STRAIN`."""
    request = blocks.request_of(blocks.frozen_case(name, MESH, material.nu), material, settings)
    move = linear_elements(request, material.E, material.nu)
    slopes = Block(request.mesh, material).slopes
    G = np.einsum("cka,ckb->cab", move[request.mesh.cells], slopes)
    times = STRAIN / max_abs(np.linalg.eigvalsh((G + np.swapaxes(G, 1, 2)) / 2))
    return replace(
        request,
        force=times * request.force,
        gravity=times * request.gravity,
        name=f"{request.name}, loads times {times:.4g}",
    )
