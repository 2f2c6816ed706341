"""Controls: candidates with a known fault, and the benchmark that must notice each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from scipy.spatial import KDTree

from msvalidate import kit
from msvalidate.springs.network import faults

Fault = Callable[[kit.Network, float], kit.Network]


def apply_fault(
    fault: Fault,
    size: float,
    problem: kit.Problem,
    network: kit.Network,
    answer: kit.Answer = "linear",
) -> kit.Array:
    """A candidate whose network has a fault."""
    return kit.solve_springs(problem, fault(network, size), answer)


def body_with(fault: Fault, size: float) -> kit.DisplacementSolver:
    """The spring network with a fault of this size."""
    return partial(apply_fault, fault, size)


def soften_volumes(network: kit.Network, size: float) -> kit.Network:
    """Cells without the part `size` of their volume stiffness."""
    if network.volumes is None:
        return network
    kappa = (1 - size) * network.volumes.stiffness
    return replace(network, volumes=replace(network.volumes, stiffness=kappa))


def shift_displacements(
    step: float, problem: kit.Problem, network: kit.Network, answer: kit.Answer = "linear"
) -> kit.Array:
    """A candidate whose displacements are those of places `step` (m) further along x.

    At a place without a point, those of the nearest.
    """
    move = kit.solve_springs(problem, network, answer)
    there = KDTree(network.points).query(network.points + step * np.eye(network.dim)[0])[1]
    return np.asarray(move[there])


ASKED: dict[str, tuple[Fault, float, str]] = {
    "patch with one spring missing": (faults.weaken_one_spring, 1.0, "patch"),
    "cantilever of springs 1 % stiffer": (faults.stiffen_all, 0.01, "cantilever"),
    "cantilever of wrong boundary weights": (faults.stiffen_boundary, 1.0, "cantilever"),
    "bending with springs 1e-6 stiffer": (faults.stiffen_all, 1e-6, "bending"),
    "bending with 1e-5 of its volume energy missing": (soften_volumes, 1e-5, "bending"),
    "three-point bending with springs 1 % stiffer": (faults.stiffen_all, 0.01, "three_point"),
    "Cook's membrane of springs 1 % stiffer": (faults.stiffen_all, 0.01, "cook"),
    "LE1 of springs 1 % stiffer": (faults.stiffen_all, 0.01, "ellipse"),
    "pressed ring of springs 1 % stiffer": (faults.stiffen_all, 0.01, "ring"),
    "pressed ring with a tenth of its volume energy missing": (soften_volumes, 0.1, "ring"),
    "hole in a plate of springs 2 % softer": (faults.stiffen_all, -0.02, "hole"),
    "strips of springs 2 % stiffer": (faults.stiffen_all, 0.02, "strips"),
    "thick plate of springs 3 % stiffer": (faults.stiffen_all, 0.03, "plate_springs"),
    "thick plate without its volume energy": (soften_volumes, 1.0, "plate_springs"),
    "frozen cases of springs 1 % stiffer": (faults.stiffen_all, 0.01, "frozen_cases"),
    "published meshes of springs 1 % stiffer": (faults.stiffen_all, 0.01, "published"),
}
"""Name -> fault, its size, and the question that must notice."""
FAULTS: dict[str, dict[str, Any]] = {
    name: {"candidate": body_with(fault, size), "questions": (question,)}
    for name, (fault, size, question) in ASKED.items()
} | {
    "LE1 read a cell of 1/32 m from its place": {
        "candidate": partial(shift_displacements, 1 / 32),
        "questions": ("ellipse",),
    },
}
"""Name -> arguments of the study's `run`."""
