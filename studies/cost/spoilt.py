"""Kernels, relaxations and solvers with a known fault, for the negative controls of this study."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from msvalidate import kit
from msvalidate.linear_algebra.choice import Choice
from msvalidate.linear_algebra.conjugate_gradients import conjugate_gradients
from msvalidate.springs import kernels
from msvalidate.springs.dynamics.integrators import LEAPFROG
from msvalidate.springs.dynamics.relaxations import RELAXATIONS
from msvalidate.springs.dynamics.run import Run
from msvalidate.springs.dynamics.step_limits import SAFETY
from msvalidate.springs.dynamics.viscous import viscous
from msvalidate.springs.network import Configuration
from msvalidate.springs.network.multigrid import PART, make_cycle, restrained_tangent
from msvalidate.springs.statics.equilibrium import Equilibrium, equilibrium

from . import bodies, fem_ways
from .fem_ways import Found

LEAPFROGGING = RELAXATIONS["viscous_leapfrog"]
COARSE = 300
"""Nodes at which a step that shrinks with the network is the usual one."""
SLOPPY = 1e-3
"""Part of an answer that a careless solver leaves."""
MOST_STEPS = 5_000


def drop_spring(net: kit.Network, **how: Any) -> kernels.Motion:
    """Motion of the network without its last spring, which then is no uniform lattice."""
    kept = np.ones(len(net.springs))
    kept[-1] = 0.0
    return kernels.Motion(net.scaled(kept), **how | {"path": "general"})


class Blind(kernels.Motion):
    """Motion that makes numbers of what is none, and brings back what is far away."""

    def advance(self, displacement: kit.Array, *state: Any, **how: Any) -> tuple[int, float, bool]:
        """As `springs.kernels.Motion` has it, but for that."""
        done, energy, fell = super().advance(displacement, *state, **how)
        seen = np.nan_to_num(displacement, copy=False)
        np.clip(seen, -bodies.SIDE, bodies.SIDE, out=displacement)
        return done, float(np.nan_to_num(energy)), fell


def _half_counted(run: Run) -> Iterator[None]:
    """Steps of which every other one is told."""
    tell = run.moved
    run.moved = lambda steps=0, evaluations=0: tell((steps + 1) // 2, evaluations)  # type: ignore[method-assign]
    yield from LEAPFROGGING.walk(run)


def _ever_shorter(run: Run) -> Iterator[None]:
    """A step that shrinks with the spacing where the limit does already."""
    lowest, highest = run.frequencies
    dt = SAFETY * 2 / highest * min(1.0, (COARSE / len(run.network.points)) ** 0.5)
    yield from viscous(LEAPFROG, dt=dt, damping=2 * lowest).walk(run)


def round_positions(body: Any, K: Any, held: Any, force: kit.Array) -> Found:
    """A solution kept in single precision."""
    found = fem_ways.by("auto", body, K, held, force)
    single = np.asarray(found.displacement, dtype=np.float32).astype(float)
    return found._replace(displacement=single)


def careless_steps(net: kit.Network, solver: str) -> Equilibrium:
    """By multigrid a thousandth off, and stated to be right to the last digit."""
    if solver == "direct":
        return equilibrium(net, solver=solver)
    A = restrained_tangent(Configuration(net))
    found = conjugate_gradients(A, net.force.ravel(), make_cycle(A, Configuration(net)), SLOPPY)
    u = found.solution.reshape(net.points.shape)
    said = Choice("multigrid", "in haste")
    return Equilibrium(u, net.points + u, np.zeros_like(u), 0.0, 3, error=1e-16, solver=said)


def without_levels(net: kit.Network) -> int:
    """Steps of conjugate gradients over the diagonal, without coarse levels."""
    A = restrained_tangent(Configuration(net))
    over = 1 / A.diagonal()
    return conjugate_gradients(
        A, net.force.ravel(), lambda load: over * load, PART, most=MOST_STEPS
    ).steps


HALF_COUNTED, EVER_SHORTER = (
    RELAXATIONS | {"viscous_leapfrog": replace(LEAPFROGGING, walk=walk)}
    for walk in (_half_counted, _ever_shorter)
)
"""Tables of relaxations, one of them with the fault."""
