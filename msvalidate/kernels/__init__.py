"""Floor 1: the compiled loops: forces of springs and cells, and steps of what moves by them.

The only compiled code of the package. Its plain form is `msvalidate.network.internal_force` and the
plain loop of `msvalidate.integrate`; tests hold the two together on random networks. `axes` is a
tuple with one entry per axis: its length is a constant of the compiled form, so inner loops unroll.
Cells have three axes always, in the plane the normal as one more corner: see `msvalidate.volumes`.

Displacements are advanced, not positions: a spring is its vector at rest plus the difference of two
displacements. Positions are rounded to an eps of the body, and stiff modes that decay slowly gather
that rounding over 1/(damping·dt) steps; on long bodies of many points it would keep Algorithm 1
from coming to rest.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from msvalidate.kernels import springs
from msvalidate.network import Network
from msvalidate.problem import Array, ProblemError


def force_and_energy(network: Network, displacement: Array, out: Array) -> float:
    """Write the force (n, d) in N at a displacement into `out`; return the energy (J) stored."""
    axes = tuple(range(network.dim))
    return float(springs.force_and_energy(axes, displacement, *_laws(network), out))


def curvature(network: Network, displacement: Array, way: Array) -> float:
    """Second derivative (N·m) of the stored energy along `way` (n, d) in m: wayᵀ K way."""
    axes = tuple(range(network.dim))
    return float(springs.curvature(axes, displacement, way, *_laws(network)))


def advance(
    network: Network,
    displacement: Array,
    velocity: Array,
    keep: Array,
    push: Array,
    dt: float,
    steps: int,
    *,
    kinetic: float = 0.0,
    to_peak: bool = False,
) -> tuple[int, float, bool]:
    """Advance displacement (m) and velocity (m/s), both (n, d), in place; held components stay.

    v = keep·v + push·(F_internal + F_external)/m, then u += dt·v, with `keep` (n,) and `push` (n,)
    in s: every scheme with one velocity a step and viscosity. Returns the steps done, the kinetic
    energy (J) of the last, and whether it ended there because that fell: `to_peak` stops after the
    first such step, counted from `kinetic`.
    """
    axes = tuple(range(network.dim))
    with np.errstate(over="ignore"):  # the motion that it gives is refused
        kick = np.where(network.held, 0.0, (push / network.mass)[:, None])
    velocity[network.held] = 0.0
    done, energy, fell = springs.advance(
        axes,
        displacement,
        velocity,
        *_laws(network),
        network.force,
        network.mass,
        keep,
        kick,
        dt,
        steps,
        kinetic,
        to_peak,
        np.empty_like(displacement),
    )
    return int(done), float(energy), bool(fell)


def _laws(network: Network) -> tuple[Any, Any, Any, Any, Any]:
    """Springs, and cells as one tuple; where there are none, of the same types and empty."""
    if network.shear is not None:
        raise ProblemError(
            "network: its shear springs have no compiled form, which relaxations and long motions "
            "take; ask for equilibrium, or take a volume energy"
        )
    each = network.springs, network.vector, network.stiffness, network.rest_length
    cells = network.volumes
    if cells is None:
        none = np.zeros(0)
        empty = np.zeros((0, 3), dtype=np.intp)
        return *each, (network.points, empty, empty, 1.0, none, none)
    triangles, part = cells.surface
    laws = network.points, cells.cells, triangles, part, cells.stiffness, cells.rest_volume
    return *each, laws
