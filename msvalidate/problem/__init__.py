"""Boundary value problem as data: domain, material, supports, loads and contacts.

Both solvers receive the same `Problem`. Nothing here predicts a deformation; the one computation,
`free_motions`, decides whether the question has an answer at all.

SI units throughout. In the plane, tractions (Pa) and body forces (N/m³) act over the thickness of
the material; point forces are in N.
"""

from msvalidate.problem.arrays import AXES, LONGEST, PLACEMENT, VOIGT, Array, Field, Index, Mask
from msvalidate.problem.contact import OBSTACLES, Contact, Obstacle
from msvalidate.problem.domain import (
    MOST_VERTICES,
    SIDES,
    Box,
    Domain,
    Polygon,
    corners_of,
    measure_of,
)
from msvalidate.problem.errors import ProblemError, SolverError, UnstableError
from msvalidate.problem.loads import BodyForce, Load, PointForce, Traction, Weight
from msvalidate.problem.material import Anisotropic, Isotropic, Material
from msvalidate.problem.mesh import Mesh
from msvalidate.problem.motions import format_point, refuse_free_motions, rigid_motions
from msvalidate.problem.region import Boundary, Part, Region, Segment
from msvalidate.problem.shapes import SHAPES, Shape, enclosed_volume, facet_areas, facet_middles
from msvalidate.problem.statement import (
    Problem,
    Support,
    prescribed_displacements,
    prescribed_displacements_at,
    vectors_at,
)
from msvalidate.problem.zone import Ball, CellSet, Zone
from msvalidate.problem.zones import cut_cells, materials_at, materials_of_cells

__all__ = [
    "AXES",
    "LONGEST",
    "MOST_VERTICES",
    "OBSTACLES",
    "PLACEMENT",
    "SHAPES",
    "SIDES",
    "VOIGT",
    "Anisotropic",
    "Array",
    "Ball",
    "BodyForce",
    "Boundary",
    "Box",
    "CellSet",
    "Contact",
    "Domain",
    "Field",
    "Index",
    "Isotropic",
    "Load",
    "Mask",
    "Material",
    "Mesh",
    "Obstacle",
    "Part",
    "PointForce",
    "Polygon",
    "Problem",
    "ProblemError",
    "Region",
    "Segment",
    "Shape",
    "SolverError",
    "Support",
    "Traction",
    "UnstableError",
    "Weight",
    "Zone",
    "corners_of",
    "cut_cells",
    "enclosed_volume",
    "facet_areas",
    "facet_middles",
    "format_point",
    "materials_at",
    "materials_of_cells",
    "measure_of",
    "prescribed_displacements",
    "prescribed_displacements_at",
    "refuse_free_motions",
    "rigid_motions",
    "vectors_at",
]
