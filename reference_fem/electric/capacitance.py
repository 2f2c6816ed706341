"""Capacitance of a slab's electrodes: meshes refined, the far boundary bracketed and doubled."""

from __future__ import annotations

import numpy as np

from msvalidate.problem import Array, ProblemError
from msvalidate.problem.checks import length_in_metres, whole_number
from msvalidate.problem.records import dataclass
from reference_fem.electric.charges import FAR, solve_charges
from reference_fem.electric.mesh import GRADING, SlabMesh, slab_mesh
from reference_fem.electric.slab import Slab
from reference_fem.mesh.elements import ELEMENTS
from reference_fem.refinement import HIGHEST_ORDER, SAFETY, on_three_meshes, richardson

MOST_DOUBLINGS = 60
"""Of a far boundary: a mesh tells places apart to fewer digits than that."""


@dataclass(frozen=True)
class Capacitance:
    """Capacitance per depth of a slab's two electrodes, in endless air.

    Parameters
    ----------
    value
        Extrapolated over three meshes, from the mean of both far boundaries (F/m).
    uncertainty
        How far it may be off (F/m): of the mesh, and half of what the far boundaries differ by.
    order
        Observed over the three meshes; NaN where none can be given.
    natural, floating
        On the finest mesh with either far boundary (F/m).
    layers
        Of the finest mesh.
    """

    value: float
    uncertainty: float
    order: float
    natural: float
    floating: float
    layers: int


def capacitance(
    slab: Slab,
    layers: int,
    *,
    element: str = "Q2",
    grading: float = GRADING,
    reach: float | None = None,
) -> Capacitance:
    """Capacitance per depth (F/m) of two electrodes, from three meshes and both far boundaries.

    Parameters
    ----------
    slab
        With two electrodes; its voltages play no part.
    layers
        Of the finest mesh, a multiple of 8.
    element, grading, reach
        As for `slab_mesh`.

    Raises
    ------
    ProblemError
        If there are not two electrodes, or an argument is out of range.
    """

    def both(n: int) -> Array:
        return _between_bounds(slab_mesh(slab, n, element=element, grading=grading, reach=reach))

    coarse, medium, fine = on_three_meshes(both, layers)
    means = [np.atleast_1d(pair.mean()) for pair in (coarse, medium, fine)]
    estimate = richardson(means[0], means[1], means[2], layers, HIGHEST_ORDER)
    value, left, order = (
        float(each[0]) for each in (estimate.value, estimate.uncertainty, estimate.order)
    )
    if np.isfinite(order):
        # Of energies the order is known: twice the element's degree, or the grading where √r rules.
        known = min(2.0 * ELEMENTS[element].degree, grading)
        last = float(means[2][0] - means[1][0])
        value += last / (2**order - 1)
        left = SAFETY * abs(last) / (2 ** min(order, known) - 1)
    far = 0.5 * abs(fine[1] - fine[0])
    return Capacitance(value, float(left + far), order, float(fine[0]), float(fine[1]), layers)


def far_boundary(
    slab: Slab,
    layers: int,
    reach: float,
    doublings: int = 1,
    *,
    element: str = "Q2",
    grading: float = GRADING,
) -> Array:
    """Capacitance on one mesh as the box is doubled: rows (reach, natural, floating) in m and F/m.

    Both errors fall with the square of the box's size, as those of a dipole's images do: what a
    doubling changes is three times the error that is left.

    Parameters
    ----------
    slab, layers, element, grading
        As for `capacitance`.
    reach
        Distance (m) of the nearest far boundary.
    doublings
        How often it is doubled.

    Raises
    ------
    ProblemError
        If there are not two electrodes, or an argument is out of range.
    """
    rows = []
    for times in range(whole_number("doublings", doublings, 0, MOST_DOUBLINGS) + 1):
        far = 2**times * length_in_metres("reach", reach)
        mesh = slab_mesh(slab, layers, element=element, grading=grading, reach=far)
        rows.append([far, *_between_bounds(mesh)])
    return np.array(rows)


def _between_bounds(mesh: SlabMesh) -> Array:
    """Capacitance with the natural and with the floating far boundary (F/m)."""
    if len(mesh.conductors) != 2:
        raise ProblemError(f"electrodes: {len(mesh.conductors)}; a capacitance is of two")
    return np.array([solve_charges(mesh, (1.0, 0.0), far).totals[0] for far in FAR])
