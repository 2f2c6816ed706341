"""Floor 1: spring constants to elastic constants and back.

Voigt order xx, yy, xy with engineering shear strain. Spring constants (N/m) include the thickness,
so a plane tensor is in N/m: Pa times the thickness. In the plane ``nu`` means the in-plane ratio
C12/C11 and ``E`` the in-plane modulus C11 - C12²/C11: plane stress has nu2 = nu and E2 = E·t, plane
strain nu2 = nu/(1 - nu) and E2 = E·t/(1 - nu²).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from msvalidate.lattice import WEIGHTS, Lattice, boundary_weights
from msvalidate.problem import (
    Array,
    Isotropic,
    Material,
    ProblemError,
    chosen,
    coordinates,
    direction,
    finite,
    instance,
    number,
    positive,
    shown,
)

CAUCHY_PLANE = 1 / 3
"""The only in-plane ratio of an isotropic network of central springs: they force C12 = C66
(Cauchy's relation), and isotropy C11 = C12 + 2·C66."""


@dataclass(frozen=True)
class PlaneModuli:
    """Elastic constants of a plane tensor along its axes.

    ``E`` (N/m) and ``nu`` in uniaxial stress along x; ``zener`` = 2·C66/(C11 - C12) is 1 for an
    isotropic tensor.
    """

    E: float
    nu: float
    zener: float


def spring_tensor(vectors: Array, stiffness: Array, volume: float) -> Array:
    """Homogenised tensor (3, 3) of springs under affine motion, each spring listed once.

    C = (1/V) Σ k L² v vᵀ with v = (nx², ny², nx·ny) and n the spring's direction: the energy of a
    uniform strain. Exact where every point is a centre of symmetry, an upper bound elsewhere (Born
    and Huang, *Dynamical Theory of Crystal Lattices*, 1954, for central forces).

    Parameters
    ----------
    vectors, stiffness
        (m, 2) in m and (m,) in N/m.
    volume
        Area (m²) that the springs stand for.

    Raises
    ------
    ProblemError
        If an array does not fit, a value is not finite, or a spring has no length.
    """
    d, k = coordinates("vectors", vectors), finite("stiffness", stiffness)
    if d.shape[1:] != (2,) or k.shape != d.shape[:1]:
        raise ProblemError(
            f"spring tensor: vectors {d.shape}, stiffness {k.shape}; give (m, 2) and (m,)"
        )
    length = np.linalg.norm(d, axis=1)
    if not length.all():
        raise ProblemError(f"vectors: spring {int(length.argmin())} has no length; leave it out")
    x, y = (d / length[:, None]).T
    v = np.stack([x**2, y**2, x * y])
    with np.errstate(over="ignore", invalid="ignore"):  # refused as infinite
        tensor = (v * (k * length**2)) @ v.T / positive("volume", volume, "m²")
    return np.array(finite("spring tensor", tensor))


def network_tensor(lattice: Lattice, constants: tuple[float, ...], weights: str) -> Array:
    """Tensor (3, 3) in N/m of the *interior* of the lattice, as built under a weight rule.

    A `diagonal_square` has lost the springs that its boundary cut, and comes near its interior's
    tensor only as it grows.

    Raises
    ------
    ProblemError
        If the constants are not one a kind, or there is no such rule.
    """
    instance("lattice", lattice, Lattice)
    k = finite("spring constants", constants)
    if k.shape != lattice.sharing.shape:
        raise ProblemError(
            f"spring constants: {shown(constants)}; give {len(lattice.sharing)}, one a kind"
        )
    chosen("boundary weights", weights, WEIGHTS)
    if weights == "per_cell":  # inside, every cell that a spring borders brings one of its own
        k = k * lattice.sharing
    # With shared boundary springs the whole lattice is made of interior cells, none of them cut.
    per_spring = k[lattice.kind] * boundary_weights(lattice, "shared")
    return spring_tensor(lattice.vectors, per_spring, lattice.domain.volume)


def square_tensor(k1: float, k2: float) -> Array:
    """Tensor (3, 3) in N/m of the square lattice: C11 = k1 + k2, C12 = C66 = k2, any spacing.

    Raises
    ------
    ProblemError
        If a constant is not one finite number.
    """
    k1, k2 = number("spring constant k1", k1), number("spring constant k2", k2)
    return np.array([[k1 + k2, k2, 0.0], [k2, k1 + k2, 0.0], [0.0, 0.0, k2]])


def square_constants(material: Isotropic, *, isotropic: bool = True) -> tuple[float, float]:
    """Spring constants (k1, k2) in N/m of the square lattice that stands for a plane material.

    Parameters
    ----------
    material
        Plane stress or plane strain.
    isotropic
        True asks for the material in every direction, which one in-plane ratio allows. False asks
        for its modulus and ratio along the lattice axes only.

    Raises
    ------
    ProblemError
        With the reason, if the lattice cannot be that material.
    """
    E, nu = in_plane(material)
    instance("isotropic", isotropic, bool)
    if isotropic and abs(nu - CAUCHY_PLANE) > 1e-9:
        raise ProblemError(
            f"square lattice: in-plane ratio {nu:.6g} ({material.state}, nu = {material.nu:g}); "
            "central springs are isotropic at 1/3 only (C12 = C66): take nu = 1/3 in plane stress "
            "or 1/4 in plane strain, or match along the axes alone (isotropic=False)"
        )
    if not 0 < nu < 1:
        raise ProblemError(
            f"square lattice: in-plane ratio {nu:.6g}; k2/(k1 + k2) stays in 0 < nu < 1 (at 0 the "
            "diagonals vanish, at 1 the axial springs, and the lattice is a mechanism)"
        )
    C11 = E / (1 - nu**2)
    number("spring constants: C11", C11)
    return C11 * (1 - nu), C11 * nu


def triangular_constants(material: Isotropic) -> tuple[float]:
    """Spring constant (k,) in N/m of the triangular lattice: E2 = 2k/√3, always isotropic.

    Raises
    ------
    ProblemError
        If the in-plane ratio is not 1/3.
    """
    E, nu = in_plane(material)
    if abs(nu - CAUCHY_PLANE) > 1e-9:
        raise ProblemError(
            f"triangular lattice: in-plane ratio {nu:.6g} ({material.state}, nu = "
            f"{material.nu:g}); central springs have 1/3 only: take nu = 1/3 in plane stress or "
            "1/4 in plane strain"
        )
    return (math.sqrt(3) / 2 * E,)


def default_constants(material: Material, lattice: Lattice) -> tuple[float, ...]:
    """Spring constants (N/m), one a kind, of the lattice that is the material.

    Raises
    ------
    ProblemError
        If it cannot be, or the material is given as a tensor.
    """
    instance("lattice", lattice, Lattice)
    if not isinstance(material, Isotropic):
        raise ProblemError("spring constants: the material is a tensor; give the constants")
    if lattice.name == "triangular":
        return triangular_constants(material)
    if lattice.name.startswith("square"):
        return square_constants(material)
    raise ProblemError(f"spring constants: none known for {lattice.name}; give the constants")


def in_plane(material: Isotropic) -> tuple[float, float]:
    """In-plane modulus (N/m, thickness included) and ratio of an isotropic material.

    Raises
    ------
    ProblemError
        If the material is a solid, or modulus times thickness is beyond all numbers.
    """
    if not isinstance(material, Isotropic):
        raise ProblemError(f"in-plane constants: {shown(material)}; the material must be isotropic")
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


def plane_moduli(tensor: Array) -> PlaneModuli:
    """E (N/m), nu along the axes and Zener ratio of a tensor with C11 = C22, C16 = C26 = 0.

    Raises
    ------
    ProblemError
        If it is no plane tensor, or a uniaxial stress has no one strain (C11 = 0 or C11 = C12).
    """
    C = _plane(tensor)
    C11, C12, C66 = C[0, 0], C[0, 1], C[2, 2]
    if C11 in (0.0, C12):
        raise ProblemError(
            f"plane moduli: C11 = {C11:g}, C12 = {C12:g} N/m; some strain costs no energy"
        )
    with np.errstate(over="ignore", invalid="ignore"):
        found = (C11 - C12**2 / C11, C12 / C11, 2 * C66 / (C11 - C12))
    E, nu, zener = finite("plane moduli E, nu and zener", found).tolist()
    return PlaneModuli(E=E, nu=nu, zener=zener)


def rotated(tensor: Array, angle: float) -> Array:
    """Tensor (3, 3) of the material turned counter-clockwise by `angle` (rad).

    Raises
    ------
    ProblemError
        If it is no plane tensor, or the angle is not one finite number.
    """
    C, turn = _plane(tensor), direction("angle", angle)
    c, s = np.cos(turn), np.sin(turn)
    # Stress of the turned body from its own stress: the Bond matrix for Voigt stress vectors.
    bond = np.array(
        [[c * c, s * s, -2 * c * s], [s * s, c * c, 2 * c * s], [c * s, -c * s, c * c - s * s]]
    )
    with np.errstate(over="ignore", invalid="ignore"):
        return np.array(finite("turned tensor", bond @ C @ bond.T))


def directional_ratio(tensor: Array, angle: float) -> float:
    """Poisson's ratio when the body is pulled along the direction at `angle` (rad) to x.

    Stress n⊗n gives strain S:(n⊗n); nu is minus its part across, m⊗m, over its part along, n⊗n.

    Raises
    ------
    ProblemError
        If it is no plane tensor, is singular, or the angle is not one finite number.
    """
    C, turn = _plane(tensor), direction("angle", angle)
    c, s = np.cos(turn), np.sin(turn)
    along, across = np.array([c * c, s * s, c * s]), np.array([s * s, c * c, -c * s])
    if np.linalg.matrix_rank(C) < len(along):
        raise ProblemError("directional ratio: the tensor is singular; some strain costs no energy")
    with np.errstate(all="ignore"):
        strain = np.linalg.solve(C, along)
        return number("directional ratio", -(across @ strain) / (along @ strain))


def _plane(tensor: Array) -> Array:
    C = finite("tensor", tensor)
    if C.shape != (3, 3):
        raise ProblemError(f"tensor: shape {C.shape}; give a plane one, (3, 3)")
    return C
