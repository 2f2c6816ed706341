"""Which springs stand for which elastic target."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from msvalidate import kit
from msvalidate.springs.constants.homogenise import interior_tensor
from msvalidate.springs.constants.isotropic import isotropic_constants
from msvalidate.springs.lattice import patterns

from . import load_cases
from .load_cases import DENSITY, MODULUS, THICKNESS


@dataclass(frozen=True)
class Model:
    """Springs that stand for a target: `constants` (N/m) by kind on a `lattice`."""

    name: str
    lattice: str
    constants: tuple[float, ...]
    target: kit.Isotropic

    @property
    def is_target(self) -> bool:
        """Whether the homogenised lattice is the target itself (the study compares the tensors)."""
        return self.name == "isotropic"

    @property
    def k(self) -> tuple[float, float]:
        """Axial and diagonal constants (N/m); a triangular lattice has no diagonals."""
        return (self.constants[0], self.constants[1] if len(self.constants) > 1 else 0.0)


def plane_stress(E: float, nu: float) -> kit.Isotropic:
    """A target: plane stress at the cases' thickness."""
    return kit.Isotropic(E=E, nu=nu, state="plane_stress", density=DENSITY, thickness=THICKNESS)


CAUCHY = plane_stress(MODULUS, 1 / 3)
INCOMPRESSIBLE = plane_stress(MODULUS, 0.5)
"""The report's claim for k2 = 2 k1: nu2 = 1/2; E is the lattice's axial modulus, 5/3 k1."""


def isotropic(lattice: str) -> Model:
    """Springs of a lattice that are `CAUCHY` by themselves."""
    pattern = patterns.all_patterns()[lattice]()
    return Model("isotropic", lattice, isotropic_constants(CAUCHY, pattern, 1.0), CAUCHY)


MODELS = (
    isotropic("square"),
    Model(
        "k2 = 2 k1",
        "square",
        (0.6 * MODULUS * THICKNESS, 1.2 * MODULUS * THICKNESS),
        INCOMPRESSIBLE,
    ),
    isotropic("triangular"),
)
ISOTROPIC = MODELS[0]


def homogenised(model: Model) -> kit.Anisotropic:
    """The elastic body that the inside of the lattice is."""
    grid = load_cases.body(model.lattice, "pressure", 5).grid()
    tensor = interior_tensor(grid, model.constants, "shared") / THICKNESS
    # Rounding is no anisotropy: what should be zero is.
    tensor[np.abs(tensor) < 1e-14 * tensor.max()] = 0.0
    return kit.Anisotropic(tensor, density=DENSITY, thickness=THICKNESS)
