"""Spring constants to elastic constants and back.

Voigt order xx, yy, xy with engineering shear strain. Spring constants (N/m) include the thickness,
so a plane tensor is in N/m: Pa times the thickness. In the plane ``nu`` means the in-plane ratio
C12/C11 and ``E`` the in-plane modulus C11 - C12²/C11: plane stress has nu2 = nu and E2 = E·t, plane
strain nu2 = nu/(1 - nu) and E2 = E·t/(1 - nu²).
"""

from __future__ import annotations

import math

import numpy as np

from msvalidate.lattice import Constants, Pattern
from msvalidate.lattice.patterns import cubic_tensor
from msvalidate.problem import VOIGT, Array, Isotropic, Material, ProblemError
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

CAUCHY = {2: 1 / 3, 3: 1 / 4}
"""Axes -> the only ratio of an isotropic solid of central springs whose points follow the strain:
they force C12 = C66 or C44 (Cauchy's relation), and isotropy C11 = C12 + 2·C66 or C44."""


AXES_OF = {3: 2, 6: 3}
"""Number of axes, by that of Voigt components."""
UNIT = {2: "N/m", 3: "Pa"}
ALIKE = 1e-9
"""Entries of a tensor closer than this fraction of the largest are one, or none."""


@dataclass(frozen=True)
class Moduli:
    """Elastic constants of a tensor along its axes.

    ``E`` (N/m in the plane, Pa in space) and ``nu`` in uniaxial stress along x; ``zener`` =
    2·C44/(C11 - C12), in the plane 2·C66/(C11 - C12), is 1 for an isotropic tensor.
    """

    E: float
    nu: float
    zener: float


def voigt_directions(normals: Array) -> Array:
    """Voigt vectors (m, 3) or (m, 6) of n⊗n for unit vectors n (m, 2) or (m, 3).

    Contracted with engineering strains they give the elongation along n: nᵀεn.

    Source: Voigt's notation as in [Nye1957], chapter VIII.
    """
    first, second = np.array(VOIGT[normals.shape[1]]).T
    return np.asarray(normals[:, first] * normals[:, second])


def spring_tensor(vectors: Array, stiffness: Array, volume: float) -> Array:
    """Homogenised tensor, (3, 3) or (6, 6), of springs under affine motion, each listed once.

    C = (1/V) Σ k L² v vᵀ with v the Voigt vector of n⊗n and n the spring's direction: the energy of
    a uniform strain. Exact where every point is a centre of symmetry, an upper bound elsewhere
    ([BornHuang1954], for central forces).

    Parameters
    ----------
    vectors, stiffness
        (m, d) in m and (m,) in N/m.
    volume
        Area (m²) or volume (m³) that the springs stand for.

    Raises
    ------
    ProblemError
        If an array does not fit, a value is not finite, or a spring has no length.
    """
    d = finite_coordinates("vectors", vectors, "m", (2, 3))
    k = finite("stiffness", stiffness, len(d))
    length = np.linalg.norm(d, axis=1)
    if not length.all():
        raise ProblemError(f"vectors: spring {int(length.argmin())} has no length; leave it out")
    v = voigt_directions(d / length[:, None]).T
    with np.errstate(over="ignore", invalid="ignore"):  # refused as infinite
        tensor = (v * (k * length**2)) @ v.T / positive_number("volume", volume, "m²")
    return np.array(finite("spring tensor", tensor))


def pattern_tensor(pattern: Pattern, constants: Constants, spacing: float = 1.0) -> Array:
    """Tensor, (3, 3) in N/m or (6, 6) in Pa, of an endless lattice under affine motion.

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
    """Tensor (3, 3) in N/m of the square lattice: C11 = k1 + k2, C12 = C66 = k2, any spacing.

    Source: `spring_tensor` of its springs in closed form; [BornHuang1954], central forces.

    Raises
    ------
    ProblemError
        If a constant is not one finite number.
    """
    k1, k2 = finite_number("spring constant k1", k1), finite_number("spring constant k2", k2)
    return np.array([[k1 + k2, k2, 0.0], [k2, k1 + k2, 0.0], [0.0, 0.0, k2]])


def springs_ratio(law: Material) -> float:
    """The ratio of springs alone, where all points deform affinely.

    1/3 in plane stress, 1/4 in plane strain and in space. Source: Cauchy's relation,
    [BornHuang1954].
    """
    return CAUCHY[2 if getattr(law, "state", "") == "plane_stress" else 3]


def central_modulus(
    material: Isotropic, dim: int, what: str, route: str = "volume energy"
) -> float:
    """Modulus of the d axes, N/m in the plane or Pa, of a material that central springs can be.

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
    """E and ratio of the d axes of `what`: in-plane ones (E in N/m), or the solid's (Pa).

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
    """Lamé's constants λ, infinite at nu = 1/(d - 1), and μ, of E and nu of d axes.

    λ = E nu/((1 + nu)(1 - (d - 1) nu)), μ = E/(2(1 + nu)).

    Source: Hooke's law, [TimoshenkoGoodier1970], article 6.
    """
    mu, room = E / (2 * (1 + nu)), 1 - (dim - 1) * nu
    return (2 * mu * nu / room if room else math.inf), mu


def moduli(tensor: Array) -> Moduli:
    """E, nu along x and Zener ratio of a tensor of cubic (in the plane square) symmetry.

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
            "along the axes; give one, or ask for isotropic_moduli"
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
    """E and nu of the isotropic tensor nearest to a tensor, and how far the tensor is from it.

    Nearest in the sum of squares of all components: the mean over all rotations [Voigt1889]. From
    the invariants a = C_iijj and b = C_ijij, in d axes: bulk modulus a/d², and shear modulus
    (b - a/d)/((d - 1)(d + 2)), in Pa, or N/m in the plane.

    Returns
    -------
    Moduli
        Its zener is 2·C44/(C11 - C12) with C11, C12, C44 the means over the axes: it shows an
        anisotropy of cubic kind along them, and 1 of an isotropic tensor.

    Raises
    ------
    ProblemError
        If it is no Voigt tensor, or a uniform strain costs no energy.
    """
    C = check_voigt(tensor)
    d = AXES_OF[len(C)]
    largest = np.abs(C).max()
    lowest = np.linalg.eigvalsh(C / largest)[0] if largest else 0.0
    if lowest <= ALIKE:
        raise ProblemError(
            f"moduli: lowest eigenvalue {lowest * largest:g} {UNIT[d]}; some strain costs no energy"
        )
    bulk, mu = _invariant_moduli(C)
    mean = cubic_part(C)
    C12 = bulk - 2 * mu / d
    nu = C12 / ((d - 1) * C12 + 2 * mu)
    found = (2 * mu * (1 + nu), nu, 2 * mean[-1, -1] / (mean[0, 0] - mean[0, 1]))
    E, nu, zener = finite("moduli E, nu and zener", found).tolist()
    return Moduli(E=E, nu=nu, zener=zener)


def _invariant_moduli(C: Array) -> tuple[float, float]:
    """Bulk and shear modulus, in its unit, of the isotropic tensor nearest to a Voigt tensor."""
    d = AXES_OF[len(C)]
    bulk = C[:d, :d].mean()
    mu = (np.trace(C) + np.trace(C[d:, d:]) - d * bulk) / ((d - 1) * (d + 2))
    return float(bulk), float(mu)


def shear_modulus(material: Material) -> float:
    """μ, N/m with the thickness in the plane or Pa in space; of a tensor its isotropic part's."""
    if isinstance(material, Isotropic):
        return material.thickness * lame(material.dim, material.E, material.nu)[1]
    return material.thickness * _invariant_moduli(material.C)[1]


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
    """Voigt tensor of E and nu of its own axes: C12 = λ, C44 = μ, C11 = λ + 2μ (see `lame`)."""
    C12, C44 = lame(dim, E, nu)
    return cubic_tensor(dim, C12 + 2 * C44, C12, C44)


def cubic_part(tensor: Array) -> Array:
    """Mean of a Voigt tensor over all turns of the axes into each other: square or cubic.

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
    """Whether two tensors are one to within `ALIKE` of the largest entry."""
    return bool(np.abs(tensor - other).max() <= ALIKE * np.abs(tensor).max())


def is_of_material(tensor: Array, material: Isotropic) -> bool:
    """Whether a tensor (N/m in the plane, else Pa) is that of a material, to within `ALIKE`."""
    d = AXES_OF[len(tensor)]
    E, nu = axes_moduli(material, d, "tensor")
    return (d - 1) * nu < 1 and is_same_tensor(tensor, isotropic_tensor(d, E, nu))


def check_voigt(tensor: Array, dim: int | None = None) -> Array:
    """The tensor as an array, of the plane or of space, or as said."""
    C = finite("tensor", tensor)
    if C.shape not in {(3, 3), (6, 6)} or dim not in (None, AXES_OF[len(C)]):
        need = "a plane one, (3, 3)" if dim == 2 else "a plane one, (3, 3), or a solid's, (6, 6)"
        raise ProblemError(f"tensor: shape {C.shape}; give {need}")
    return C
