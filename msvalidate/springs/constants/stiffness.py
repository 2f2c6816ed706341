"""Spring constants to elastic constants and back.

Voigt order xx, yy, xy with engineering shear strain. Spring constants (N/m) include the thickness,
so a plane tensor is in N/m: Pa times the thickness. In the plane ``nu`` means the in-plane ratio
C12/C11 and ``E`` the in-plane modulus C11 - C12²/C11: plane stress has nu2 = nu and E2 = E·t, plane
strain nu2 = nu/(1 - nu) and E2 = E·t/(1 - nu²).
"""

from __future__ import annotations

import math
from typing import TypeVar

import numpy as np

from msvalidate.problem import VOIGT, Anisotropic, Array, Isotropic, Material, ProblemError
from msvalidate.problem.checks import (
    finite,
    finite_coordinates,
    finite_number,
    format_value,
    length_in_metres,
    positive_number,
    require_type,
)
from msvalidate.problem.records import dataclass
from msvalidate.springs.lattice import Constants, Pattern
from msvalidate.springs.lattice.patterns import cubic_tensor

Number = TypeVar("Number", float, Array)
CAUCHY = {2: 1 / 3, 3: 1 / 4}
"""Number of axes -> Poisson's ratio of affine lattices of central springs.

Cauchy's relation C12 = C66 (C44 in 3D) and isotropy, C11 = C12 + 2·C66 (C44), leave no other.
"""


AXES_OF = {1: 1, 3: 2, 6: 3}
"""Number of axes, by that of Voigt components."""
UNIT = {1: "N", 2: "N/m", 3: "Pa"}
NEAR_RATIO = 0.01
"""Largest difference from the ratio of springs alone at which they replace the material.

Displacements then change by about as much, and every command reports the change."""
ALIKE = 1e-9
"""Entries of a tensor closer than this fraction of the largest are one, or none."""


@dataclass(frozen=True)
class Moduli:
    """Elastic moduli of a tensor along its axes.

    Parameters
    ----------
    E, nu
        Young's modulus (N/m in 2D, Pa in 3D) and Poisson's ratio in uniaxial stress along x.
    zener
        Zener ratio 2·C44/(C11 - C12), in 2D 2·C66/(C11 - C12); 1 for an isotropic tensor.
    """

    E: float
    nu: float
    zener: float


def voigt_directions(normals: Array) -> Array:
    """Voigt vectors (m, 1), (m, 3) or (m, 6) of n⊗n for unit vectors.

    The vectors n are (m, d). Contracted with engineering strains they give the elongation along n:
    nᵀεn.

    Source: Voigt's notation as in [Nye1957], chapter VIII.
    """
    first, second = np.array(VOIGT.get(normals.shape[1], ((0, 0),))).T
    return np.asarray(normals[:, first] * normals[:, second])


def spring_tensor(vectors: Array, stiffness: Array, volume: float) -> Array:
    """Homogenised tensor of springs under affine motion, each listed once.

    Its shape is (1, 1) in N, (3, 3) in N/m or (6, 6) in Pa, for d = 1, 2 or 3.

    C = (1/V) Σ k L² v vᵀ with v the Voigt vector of n⊗n and n the spring's direction: the energy of
    a uniform strain. Exact where every point is a centre of symmetry, an upper bound elsewhere
    ([BornHuang1954], for central forces).

    Parameters
    ----------
    vectors, stiffness
        (m, d) in m and (m,) in N/m.
    volume
        Length (m), area (m²) or volume (m³) that the springs stand for, above 0.

    Raises
    ------
    ProblemError
        If an array does not fit, a value is not finite, a spring has no length, or the volume is
        not above 0.
    """
    d = finite_coordinates("vectors", vectors, "m", (1, 2, 3))
    k = finite("stiffness", stiffness, len(d))
    length = np.linalg.norm(d, axis=1)
    if not length.all():
        raise ProblemError(f"vectors: spring {int(length.argmin())} has no length; leave it out")
    v = voigt_directions(d / length[:, None]).T
    with np.errstate(over="ignore", invalid="ignore"):  # refused as infinite
        tensor = (v * (k * length**2)) @ v.T / positive_number("volume", volume, "m²")
    return np.array(finite("spring tensor", tensor))


def pattern_tensor(pattern: Pattern, constants: Constants, spacing: float = 1.0) -> Array:
    """Stiffness tensor of a periodic lattice under affine motion.

    It is (3, 3) in N/m or (6, 6) in Pa.

    Source: [BornHuang1954], for central forces.

    Parameters
    ----------
    pattern
        What repeats.
    constants
        Spring constants (N/m), one a kind.
    spacing
        Length (m) of the pattern's unit; a plane tensor does not depend on it.

    Raises
    ------
    ProblemError
        If the constants are not one a kind, or the spacing is no length.
    """
    require_type("pattern", pattern, Pattern)
    a = length_in_metres("spacing", spacing)
    volume = math.prod(pattern.size) * a**pattern.dim
    return spring_tensor(a * pattern.vectors, pattern.stiffness(constants), volume)


def square_tensor(k1: float, k2: float) -> Array:
    """Tensor (3, 3) in N/m of the square lattice, at any spacing.

    C11 = k1 + k2 and C12 = C66 = k2.

    Source: `spring_tensor` of its springs in closed form; [BornHuang1954], central forces.

    Raises
    ------
    ProblemError
        If a constant is not one finite number.
    """
    k1, k2 = finite_number("spring constant k1", k1), finite_number("spring constant k2", k2)
    return np.array([[k1 + k2, k2, 0.0], [k2, k1 + k2, 0.0], [0.0, 0.0, k2]])


def springs_ratio(law: Material) -> float:
    """Poisson's ratio of a material by springs alone, if all points deform affinely.

    It is 1/3 in plane stress and 1/4 otherwise: in plane strain, in 3D, and for a tensor, which has
    no state. Source: Cauchy's relation, [BornHuang1954].
    """
    return CAUCHY[2 if getattr(law, "state", "") == "plane_stress" else 3]


def central_modulus(
    material: Isotropic, dim: int, what: str, route: str = "volume energy"
) -> float:
    """Modulus (N/m in 2D, Pa in 3D) of a material with the Cauchy relation.

    It is the modulus of the d axes.

    The message names a `route` to other materials.

    Raises
    ------
    ProblemError
        If its ratio is not the only one of `CAUCHY`, or it is of another dimension.
    """
    E, nu = axes_moduli(material, dim, what)
    if abs(nu - CAUCHY[dim]) > ALIKE:
        raise ProblemError(
            f"{what}: ratio {nu:.6g} of its axes ({material.state}, nu = {material.nu:g}); central "
            f"springs make it isotropic at {CAUCHY[dim]:.6g} only (λ = μ): take nu = 1/3 in plane "
            f"stress, 1/4 in plane strain or in space, or route {route!r}, or give the constants"
        )
    return E


def in_plane_moduli(material: Isotropic) -> tuple[float, float]:
    """In-plane modulus (N/m, thickness included) and ratio of an isotropic material.

    Source: [TimoshenkoGoodier1970], plane stress and plane strain.

    Raises
    ------
    ProblemError
        If the material is a solid, or modulus times thickness is beyond all numbers.
    """
    if not isinstance(material, Isotropic):
        raise ProblemError(
            f"in-plane constants: {format_value(material)}; the material must be isotropic"
        )
    E, nu, t = material.E, material.nu, material.thickness
    if not 0 < E * t < math.inf:
        raise ProblemError(
            f"in-plane modulus: {E:g} Pa times a thickness of {t:g} m is {E * t:g} N/m; choose "
            "units that give ordinary numbers"
        )
    if material.state == "plane_stress":
        return E * t, nu
    if material.state == "plane_strain":
        return E * t / (1 - nu**2), nu / (1 - nu)
    raise ProblemError("in-plane constants: the material is a solid; take plane stress or strain")


def axes_moduli(material: Isotropic, dim: int, what: str) -> tuple[float, float]:
    """Young's modulus and Poisson's ratio of the d axes of a material.

    They are the in-plane ones (E in N/m) in 2D, or those of the solid (Pa).

    Raises
    ------
    ProblemError
        If the material is of another dimension.
    """
    if dim == 2:
        return in_plane_moduli(material)
    if material.state != "solid":
        raise ProblemError(f"{what}: material in {material.state}; give a solid")
    return material.E, material.nu


def lame(dim: int, E: float, nu: float) -> tuple[float, float]:
    """Lamé constants λ and μ from E and nu of d axes.

    Both have the unit of E: N/m with the thickness in 2D, Pa in 3D. λ is infinite at
    nu = 1/(d - 1).

    λ = E nu/((1 + nu)(1 - (d - 1) nu)), μ = E/(2(1 + nu)).

    Source: Hooke's law, [TimoshenkoGoodier1970], article 6.
    """
    mu, room = E / (2 * (1 + nu)), 1 - (dim - 1) * nu
    return (2 * mu * nu / room if room else math.inf), mu


def moduli(tensor: Array) -> Moduli:
    """Young's modulus, Poisson's ratio and Zener ratio of a cubic or square tensor.

    They are those along x.

    Source: [Nye1957], chapter VIII; the ratio of anisotropy is that of [Zener1948].

    Raises
    ------
    ProblemError
        If it is no such tensor, or a uniaxial stress has no one strain (C11 = 0 or C11 = C12).
    """
    C = check_voigt(tensor)
    d = AXES_OF[len(C)]
    C11, C12, C44 = C[0, 0], C[0, 1], C[-1, -1]
    if not is_same_tensor(C, cubic_tensor(d, C11, C12, C44)):
        raise ProblemError(
            f"moduli: tensor with diagonal {format_value(np.diag(C).tolist())} is not of cubic "
            f"symmetry "
            "along the axes; give one, or take isotropic_moduli(tensor)"
        )
    if C11 in (0.0, C12):
        raise ProblemError(
            f"moduli: C11 = {C11:g}, C12 = {C12:g} {UNIT[d]}; some strain costs no energy"
        )
    with np.errstate(over="ignore", invalid="ignore"):
        nu = C12 / (C11 + (d - 2) * C12)
        found = (C11 - (d - 1) * C12 * nu, nu, 2 * C44 / (C11 - C12))
    E, nu, zener = finite("moduli E, nu and zener", found).tolist()
    return Moduli(E=E, nu=nu, zener=zener)


def isotropic_moduli(tensor: Array) -> Moduli:
    """Compute the moduli of the isotropic tensor nearest to a stiffness tensor.

    The nearest tensor in the sum of squares of all components is the mean over all rotations
    [Voigt1889]. With the invariants a = C_iijj and b = C_ijij in d dimensions, the bulk modulus is
    a/d² and the shear modulus (b - a/d)/((d - 1)(d + 2)).

    Parameters
    ----------
    tensor
        Voigt tensor with engineering shear strains, (3, 3) in N/m in 2D or (6, 6) in Pa in 3D.

    Returns
    -------
    Moduli
        Young's modulus E (N/m in 2D, Pa in 3D), Poisson's ratio nu (C12/C11 in 2D) and the Zener
        ratio 2·C44/(C11 - C12), in 2D 2·C66/(C11 - C12), of the cubic mean over the axes, which is
        1 for an isotropic tensor.

    Raises
    ------
    ProblemError
        If the tensor has another shape, is not symmetric or not positive definite.

    Examples
    --------
    >>> import numpy as np
    >>> from msvalidate import isotropic_moduli
    >>> moduli = isotropic_moduli(np.array([[9.0, 3.0, 0.0], [3.0, 9.0, 0.0], [0.0, 0.0, 3.0]]) / 8)
    >>> print(f"{moduli.E:.3f} {moduli.nu:.3f} {moduli.zener:.3f}")
    1.000 0.333 1.000
    """
    C = check_voigt(tensor)
    d = AXES_OF[len(C)]
    largest = np.abs(C).max()
    lowest = np.linalg.eigvalsh(C / largest)[0] if largest else 0.0
    if lowest <= ALIKE:
        raise ProblemError(
            f"moduli: lowest eigenvalue {lowest * largest:g} {UNIT[d]}; some strain costs no energy"
        )
    mean = cubic_part(C)
    zener = 2 * mean[-1, -1] / (mean[0, 0] - mean[0, 1])
    found = (*young_and_ratio(d, *invariant_moduli(C)), zener)
    E, nu, zener = finite("moduli E, nu and zener", found).tolist()
    return Moduli(E=E, nu=nu, zener=zener)


def invariant_moduli(C: Array) -> tuple[float, float]:
    """Bulk and shear modulus of the isotropic tensor nearest to a tensor.

    They have the unit of the Voigt tensor.
    """
    d = AXES_OF[len(C)]
    bulk = C[:d, :d].mean()
    mu = (np.trace(C) + np.trace(C[d:, d:]) - d * bulk) / ((d - 1) * (d + 2))
    return float(bulk), float(mu)


def young_and_ratio(dim: int, bulk: Number, mu: Number) -> tuple[Number, Number]:
    """Young's modulus and Poisson's ratio of d axes from the bulk and shear modulus.

    E grows with each of the two, and the ratio with the first over the second.
    """
    C12 = bulk - 2 * mu / dim
    nu = C12 / ((dim - 1) * C12 + 2 * mu)
    return 2 * mu * (1 + nu), nu


def shear_modulus(material: Material) -> float:
    """Shear modulus μ of a material, N/m with the thickness in 2D, Pa in 3D.

    For a tensor it is that of the nearest isotropic tensor.
    """
    if isinstance(material, Isotropic):
        return material.thickness * lame(material.dim, material.E, material.nu)[1]
    return material.thickness * invariant_moduli(material.C)[1]


def isotropic_part(tensor: Array) -> Array:
    """Mean of a Voigt tensor over all rotations: the isotropic tensor nearest to it.

    Raises
    ------
    ProblemError
        As for `isotropic_moduli`.
    """
    mean = isotropic_moduli(tensor)
    return isotropic_tensor(AXES_OF[len(check_voigt(tensor))], mean.E, mean.nu)


def isotropic_tensor(dim: int, E: float, nu: float) -> Array:
    """Voigt tensor of the moduli of the d axes (see `lame`).

    C12 = λ, C44 = μ and C11 = λ + 2μ.
    """
    C12, C44 = lame(dim, E, nu)
    return cubic_tensor(dim, C12 + 2 * C44, C12, C44)


def cubic_part(tensor: Array) -> Array:
    """Project a Voigt tensor on square (2D) or cubic (3D) symmetry along the axes.

    Raises
    ------
    ProblemError
        If it is no Voigt tensor.
    """
    C = check_voigt(tensor)
    d = AXES_OF[len(C)]
    normal, along = C[:d, :d], np.trace(C[:d, :d])
    across = (normal.sum() - along) / (d * (d - 1))
    return cubic_tensor(d, along / d, across, np.trace(C[d:, d:]) / (len(C) - d))


def is_same_tensor(tensor: Array, other: Array) -> bool:
    """Return True if two tensors agree within `ALIKE` of the largest entry."""
    return bool(np.abs(tensor - other).max() <= ALIKE * np.abs(tensor).max())


def is_of_material(tensor: Array, material: Material) -> bool:
    """Return True if a tensor is that of a material, within `ALIKE`.

    It is in N/m in 2D, in Pa in 3D.
    """
    d = AXES_OF[len(tensor)]
    if isinstance(material, Anisotropic):
        return is_same_tensor(tensor, material.thickness * material.C)
    E, nu = axes_moduli(material, d, "tensor")
    return (d - 1) * nu < 1 and is_same_tensor(tensor, isotropic_tensor(d, E, nu))


def check_voigt(tensor: Array, dim: int | None = None) -> Array:
    """Return a symmetric Voigt tensor as an array, of 2D or 3D, or of `dim`."""
    C = finite("tensor", tensor)
    if C.shape not in {(3, 3), (6, 6)} or dim not in (None, AXES_OF[len(C)]):
        need = "a plane one, (3, 3)" if dim == 2 else "a plane one, (3, 3), or a solid's, (6, 6)"
        raise ProblemError(f"tensor: shape {C.shape}; give {need}")
    apart = np.abs(C - C.T)
    if apart.max() > ALIKE * np.abs(C).max():
        i, j = np.unravel_index(apart.argmax(), C.shape)
        raise ProblemError(
            f"tensor: not symmetric, C[{i}, {j}] = {C[i, j]:g} and C[{j}, {i}] = {C[j, i]:g}; give "
            "(C + C.T) / 2"
        )
    return C
