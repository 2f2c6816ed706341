"""Solids at large strain: laws, forces and tangent of a `Solid`, and `deform` under dead loads."""

from reference_fem.large_strain.by_cell import CellLaws, laws_of, neo_hookean, st_venant_kirchhoff
from reference_fem.large_strain.equilibrium import LargeStrainSolution, deform
from reference_fem.large_strain.hyperelastic import (
    Fibres,
    Law,
    NeoHookean,
    StVenantKirchhoff,
    square_fibres,
)
from reference_fem.large_strain.plane_stress import PlaneStress
from reference_fem.large_strain.rubber import Ogden
from reference_fem.large_strain.solid import Solid

__all__ = [
    "CellLaws",
    "Fibres",
    "LargeStrainSolution",
    "Law",
    "NeoHookean",
    "Ogden",
    "PlaneStress",
    "Solid",
    "StVenantKirchhoff",
    "deform",
    "laws_of",
    "neo_hookean",
    "square_fibres",
    "st_venant_kirchhoff",
]
