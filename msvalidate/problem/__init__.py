"""Floor 0: what is asked, as data: domain, material, supports and loads, for d = 2 and 3 alike.

Both solvers receive the same `Problem`. Nothing here predicts a deformation; the one computation,
`free_motions`, decides whether the question has an answer at all.

SI units throughout. In the plane, tractions (Pa) and body forces (N/m³) act over the thickness of
the material; point forces are in N.
"""

from msvalidate.problem.domain import MOST_VERTICES, SIDES, Box, Domain, Polygon, corners_of
from msvalidate.problem.material import Anisotropic, Isotropic, Material
from msvalidate.problem.motions import free_motions, place_name, refuse_free_motions, rigid_motions
from msvalidate.problem.region import Part, Region, Segment
from msvalidate.problem.statement import (
    BodyForce,
    Load,
    PointForce,
    Problem,
    Support,
    Traction,
    prescribed,
    vectors_at,
)
from msvalidate.problem.values import (
    AXES,
    LONGEST,
    MOST_POINTS,
    Array,
    Field,
    Index,
    Mask,
    ProblemError,
    SolverError,
    chosen,
    coordinates,
    counts,
    direction,
    finite,
    instance,
    metres,
    number,
    numbers,
    positive,
    refuse_too_many,
    rotation,
    shown,
    whole,
)

__all__ = [
    "AXES",
    "LONGEST",
    "MOST_POINTS",
    "MOST_VERTICES",
    "SIDES",
    "Anisotropic",
    "Array",
    "BodyForce",
    "Box",
    "Domain",
    "Field",
    "Index",
    "Isotropic",
    "Load",
    "Mask",
    "Material",
    "Part",
    "PointForce",
    "Polygon",
    "Problem",
    "ProblemError",
    "Region",
    "Segment",
    "SolverError",
    "Support",
    "Traction",
    "chosen",
    "coordinates",
    "corners_of",
    "counts",
    "direction",
    "finite",
    "free_motions",
    "instance",
    "metres",
    "number",
    "numbers",
    "place_name",
    "positive",
    "prescribed",
    "refuse_free_motions",
    "refuse_too_many",
    "rigid_motions",
    "rotation",
    "shown",
    "vectors_at",
    "whole",
]
