"""Subsets of the registries by what their members are: a new member joins by itself."""

from __future__ import annotations

from msvalidate.springs.constants.homogenise import deforms_affinely
from msvalidate.springs.lattice.cut import joins_corners
from msvalidate.springs.lattice.patterns import AXES, all_patterns

LATTICES = all_patterns()
ISOTROPIC = [name for name, make in LATTICES.items() if make().formulas is not AXES]
"""Lattices that some spring constants make isotropic."""
AFFINE = [name for name in ISOTROPIC if deforms_affinely(LATTICES[name]())]
"""Those of them whose points follow a uniform strain, so that a volume energy brings any ratio."""
GRIDS = [name for name in AFFINE if joins_corners(LATTICES[name]())]
"""Those of them whose springs join the corners of a square or a cube."""
