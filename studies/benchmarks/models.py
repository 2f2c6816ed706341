"""Models: the springs that stand for a material, with a volume energy where its ratio asks."""

from __future__ import annotations

import numpy as np

from msvalidate import kit
from msvalidate.springs.bodies.calibrate import calibrate_material
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.constants.stiffness import CAUCHY
from msvalidate.springs.lattice import Lattice

from . import cases


def method(lattice: str, nu: float, dim: int = 2) -> str:
    """Name of the network that stands for a ratio: in the plane, that of strains in it."""
    return f"springs{'' if np.isclose(nu, CAUCHY[dim]) else cases.VOLUME}, {lattice}"


def network_of(problem: kit.Problem, grid: Lattice) -> kit.Network:
    """Network for an isotropic problem: springs alone where they will do, or cells beside them.

    Raises
    ------
    ProblemError
        If the material is not isotropic, or the lattice cannot be it.
    """
    if not isinstance(problem.material, kit.Isotropic):
        raise kit.ProblemError(f"{problem.name}: give an isotropic material")
    return lattice_network(problem, grid, calibrate_material(problem.material, grid))
