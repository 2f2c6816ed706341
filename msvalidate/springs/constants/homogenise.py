"""The elastic solid that a lattice is: its tensor, affine and relaxed.

A uniform strain moves the cells as wholes; inside a cell the points move on until no force is left.
What that releases lies between the affine tensor, which holds them back, and the relaxed one:

    C = C_affine - (1/V) Fᵀ K⁺ F,

K the stiffness of the periodic motions and F the forces that unit strains leave on the points.
Where every point is a centre of symmetry F is zero and the affine tensor is exact.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from msvalidate.problem import Array, ProblemError
from msvalidate.problem.checks import (
    finite,
    format_value,
    indices,
    length_in_metres,
    refuse_too_many,
    require_one_of,
    require_type,
    whole_number,
)
from msvalidate.problem.records import ReadOnly, dataclass, replace
from msvalidate.springs.constants.cell_at_rest import elongations, relax_cell
from msvalidate.springs.constants.stiffness import (
    ALIKE,
    moduli,
    spring_tensor,
    voigt_directions,
)
from msvalidate.springs.lattice import (
    WEIGHTS,
    Constants,
    Lattice,
    Pattern,
    PatternLattice,
    boundary_weights,
)
from msvalidate.springs.lattice.filled import cells_bordered
from msvalidate.springs.network.inverse import SOLVERS

NO_SPRING = 1e-24
"""Stiffness of a spring, over the stiffest one's, below which it is none."""


@dataclass(frozen=True, eq=False)
class Homogenised(ReadOnly):
    """Effective stiffness of a periodic lattice.

    Parameters
    ----------
    affine, tensor
        Voigt tensors, (1, 1) in N for a chain, (3, 3) in N/m or (6, 6) in Pa: with affine motion of
        the points, which is an upper bound, and with the points in equilibrium.
    floppy
        Number of periodic mechanisms besides translations; None if it was not counted, in which
        case there are none.
    error
        Largest error of an entry of the tensor, relative to the root of the product of its two
        diagonal entries, from the energy of the last correction.
    solver
        "direct" or "multigrid".
    """

    affine: Array
    tensor: Array
    floppy: int | None
    error: float
    solver: str

    @property
    def E(self) -> float:
        """Young's modulus (N/m in 2D, Pa in 3D) along the axes of the lattice.

        Raises `ProblemError` if the tensor is not of cubic symmetry along them.
        """
        return moduli(self.tensor).E

    @property
    def nu(self) -> float:
        """Poisson's ratio in uniaxial stress along an axis; raises as `E`."""
        return moduli(self.tensor).nu

    @property
    def zener(self) -> float:
        """Zener ratio, 1 for an isotropic tensor; raises as `E`."""
        return moduli(self.tensor).zener


def homogenise(
    pattern: Pattern, constants: Constants, spacing: float = 1.0, *, solver: str = "auto"
) -> Homogenised:
    """Compute the effective (homogenised) stiffness tensor of a periodic lattice.

    The unit cell (representative volume element) is in equilibrium under each uniform strain, with
    periodic boundary conditions. Sources: [Hill1963] (energy of the mean strain), [BornHuang1954]
    (equilibrium of the points inside the cell).

    Parameters
    ----------
    pattern
        Unit cell of the lattice, such as ``patterns.square()``.
    constants
        Spring constants (N/m), one per kind of spring.
    spacing
        Length (m) of the unit of the pattern; a 2D tensor does not depend on it.
    solver
        "auto", "direct" or "multigrid".

    Returns
    -------
    Homogenised
        Its field ``tensor`` is the Voigt tensor, (3, 3) in N/m in 2D or (6, 6) in Pa in 3D;
        ``affine`` is the upper bound without relaxation of the points inside the cell. ``E``,
        ``nu`` and ``zener`` are the moduli of a cubic or square tensor along its axes.

    Raises
    ------
    ProblemError
        If there is not one constant per kind, a constant is negative, or the spacing is not
        positive.
    SolverError
        If a large unit cell has a mechanism, or the tensor cannot be determined.

    Examples
    --------
    >>> from msvalidate import homogenise, patterns
    >>> solid = homogenise(patterns.triangular(), (1.0,))
    >>> print(f"{solid.E:.6f} N/m, nu = {solid.nu:.6f}")  # 2/√3 k and 1/3
    1.154701 N/m, nu = 0.333333
    """
    require_type("pattern", pattern, Pattern)
    a = length_in_metres("spacing", spacing)
    size = a * np.array(pattern.size)
    return homogenise_network(
        len(pattern.points),
        pattern.springs,
        a * pattern.vectors,
        pattern.stiffness(constants),
        float(np.prod(size)),
        solver=solver,
    )


def interior_tensor(lattice: Lattice, constants: Constants, weights: str) -> Array:
    """Effective tensor of the *interior* of a lattice, built by a rule for weights.

    It is (3, 3) in N/m or (6, 6) in Pa.

    Of a piece of a pattern it is the solid of what repeats, its points at rest. A `diagonal_square`
    has lost the springs that its boundary cut, and comes near its interior's tensor only as it
    grows.

    Source: [BornHuang1954], for central forces.

    Raises
    ------
    ProblemError
        If the constants are not one a kind, there is no such rule, or the lattice is irregular.
    """
    require_type("lattice", lattice, Lattice)
    k = finite(
        "spring constants", constants, lattice.kinds, need=f"give {lattice.kinds}, one a kind"
    )
    require_one_of("boundary weights", weights, WEIGHTS)
    if isinstance(lattice, PatternLattice):
        pattern = lattice.pattern
        if weights == "per_cell":  # every cell that a spring borders brings one of its own
            pattern = replace(pattern, factor=pattern.factor * cells_bordered(pattern))
        return homogenise(pattern, constants, lattice.spacing).tensor
    if not lattice.regular:
        raise ProblemError(
            f"{lattice.name} lattice: its interior is not what its springs add up to; ask "
            "homogenised of the pattern that it was made from, or of a periodic sample of its kind"
        )
    # With shared boundary springs the whole lattice is made of interior cells, none of them cut.
    inside = lattice.sharing if weights == "per_cell" else 1
    per_spring = k[lattice.kind] * lattice.factor * inside * boundary_weights(lattice, "shared")
    return spring_tensor(lattice.vectors, per_spring, lattice.domain.volume)


def deforms_affinely(pattern: Pattern) -> bool:
    """Return True if every point follows a uniform strain, for any constants.

    They do where each kind of spring by itself leaves no force on them: where every point is a
    centre of symmetry. The affine tensor is then exact, and linear in the constants.

    Raises
    ------
    ProblemError
        If it is no pattern.
    """
    require_type("pattern", pattern, Pattern)
    length = np.linalg.norm(pattern.vectors, axis=1)
    normal = pattern.vectors / length[:, None]
    # A unit strain stretches a spring by L v, and it pulls at both ends.
    moved = elongations(len(pattern.points), pattern.springs, normal)
    stretch = length[:, None] * voigt_directions(normal)
    for kind in range(pattern.kinds):
        k = np.where(pattern.kind == kind, pattern.factor, 0.0)
        force = moved.T @ (k[:, None] * stretch)
        if np.abs(force).max() > ALIKE * float((k * length).max()):
            return False
    return True


def homogenise_network(
    count: int,
    springs: ArrayLike,
    vectors: ArrayLike,
    stiffness: ArrayLike,
    volume: float,
    *,
    solver: str = "auto",
) -> Homogenised:
    """The solid that a periodic network is, from its springs alone.

    Source: [Hill1963] (energies of means), [BornHuang1954] (points at rest inside a cell).

    Parameters
    ----------
    count
        Number of points in the periodic cell.
    springs, vectors, stiffness
        (m, 2) pairs of points, (m, d) in m from the first to the image of the second that it is
        joined to, and (m,) in N/m; unstressed.
    volume
        Of the periodic cell, in m (d = 1), m² or m³.
    solver
        "direct": all motions of a small cell, or a factor, whose work and memory grow with the
        powers 2 and 4/3 of the points in space; "multigrid": conjugate gradients, in proportion to
        the points; "auto" takes what takes less time, and a factor where those do not answer.

    Raises
    ------
    ProblemError
        If an array does not fit, a value is not finite, a stiffness is negative, or there is no
        such solver.
    SolverError
        If a large network has a motion without stiffness, or the tensor can't be told.
    """
    n = whole_number("points of the cell", count, 1)
    refuse_too_many("periodic network", n)
    require_one_of("solver", solver, SOLVERS)
    vector, k = finite("vectors", vectors), finite("stiffness", stiffness)
    if not k.size or k.min() < 0:
        raise ProblemError(
            f"stiffness: {format_value(stiffness)}; give numbers of 0 or more, one a spring"
        )
    affine = spring_tensor(vector, k, volume)
    k = np.where(k >= NO_SPRING * k.max(), k, 0.0)
    pairs = indices("springs", springs, n, len(k), 2)
    length = np.linalg.norm(vector, axis=1)[:, None]
    normal = vector / length
    found = relax_cell(n, pairs, normal, k, length * voigt_directions(normal), solver)
    tensor = np.einsum("mv,mw->vw", found.elongation, k[:, None] * found.elongation) / volume
    return Homogenised(affine, (tensor + tensor.T) / 2, found.floppy, found.error, found.solver)
