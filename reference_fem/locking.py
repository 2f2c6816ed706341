"""Volumetric locking of linear elements near incompressibility.

A linear cell of size h that is bent by a curvature κ changes its volume by κh, which costs energy
λ(κh)², where the body of size H asks for μ(κH)². The ratio of the two,

    (λ/μ) (h/H)²,

is the part by which the cells are too stiff: at 1 the constraint of the cells rules, not the body,
and refinement first hardly changes the answer, so that three meshes agree on a wrong one
([Hughes2000], section 4.4). Cells of the second degree lose an order at most, and mixed elements
nothing. Plane stress has no such constraint: its λ is at most 2μ.
"""

from __future__ import annotations

import numpy as np

from msvalidate.problem import Array, SolverError, enclosed_volume, facet_areas
from reference_fem.mesh.discretisation import Discretisation

LOCKED = 0.2
"""Share of energy above which it is refused: a tenth or two of the displacement may be missing."""
NEARLY = 20.0
"""λ/μ (nu = 0.476) below which cells are not called locked: too coarse they may be, as any."""


def refuse_locked(body: Discretisation, C: Array) -> None:
    """Raise a `SolverError` where a body's cells lock with a Voigt tensor C (Pa).

    Raises
    ------
    SolverError
        If the cells are of the first degree, the material nearly incompressible, and the cells not
        small enough for that.
    """
    if not body.element.locks or not np.isfinite(C).all():  # the residual refuses the latter
        return
    ratio = bulk_over_shear(C)
    if ratio <= NEARLY:
        return
    size = body_thickness(body)
    share = ratio * cell_size(body) ** 2 / size**2
    if share > LOCKED:
        name, (better, *_) = body.element.name, body.element.raised
        raise SolverError(
            f"finite elements: cells of {name} lock: lambda/mu is {ratio:.3g}, and cells of "
            f"{cell_size(body):.3g} m in a body {size:.3g} m thick store {share:.2g} of its energy "
            f"as change of volume; take nu = {NEARLY / (2 * NEARLY + 2):.3f} or less, or quadratic "
            f"cells ({better})"
        )


def bulk_over_shear(C: Array) -> float:
    """λ/μ of an isotropic Voigt tensor (3, 3) or (6, 6); of others, what answers to it.

    How little hydrostatic stress swells the body, against its stiffness in shear, in the mean. A
    body that is stiff along fibres alone swells, and does not lock.
    """
    d = 2 if len(C) == 3 else 3
    root = np.sqrt(np.repeat([1.0, 2.0], [d, len(C) - d]))  # Mandel's: rotations keep lengths
    stiffness, modes = np.linalg.eigh(C / np.abs(C).max() * np.outer(root, root))
    stiffness = np.maximum(stiffness, np.finfo(float).eps * stiffness.max())  # laws may have none
    swelling = np.repeat([1.0, 0.0], [d, len(C) - d]) / np.sqrt(d)
    share = (swelling @ modes) ** 2
    shear = float((1 - share) @ stiffness) / (len(C) - 1)
    return (1 / (float(share @ (1 / stiffness)) * shear) - 1) * 2 / d


def body_thickness(body: Discretisation) -> float:
    """Thickness (m) of a slender or flat body: twice its volume over its surface."""
    facets = body.points[body.surface]
    return 2 * enclosed_volume(facets) / float(facet_areas(facets).sum())


def cell_size(body: Discretisation) -> float:
    """Root mean square, over the volume, of the cells' largest extents (m)."""
    extent = np.ptp(body.points[body.cells], axis=1).max(axis=1)
    return float(np.sqrt(np.average(extent**2, weights=np.asarray(body.basis.dx).sum(axis=1))))
