"""Linear elastic materials, isotropic and anisotropic."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np

from msvalidate.problem.arrays import Array
from msvalidate.problem.checks import (
    finite,
    finite_number,
    format_value,
    positive_number,
    require_one_of,
)
from msvalidate.problem.errors import ProblemError
from msvalidate.problem.records import dataclass

State = Literal["plane_stress", "plane_strain", "solid"]


@dataclass(frozen=True)
class Isotropic:
    """Isotropic linear elastic material.

    Parameters
    ----------
    E
        Young's modulus (Pa) of the three-dimensional material, > 0.
    nu
        Poisson's ratio of the three-dimensional material, -1 < nu <= 1/2.
    state
        "plane_stress" or "plane_strain" in 2D, "solid" in 3D.
    density
        Mass density (kg/m³), > 0. Masses and `Weight` depend on it. Default: water, 1000 kg/m³.
    thickness
        Out-of-plane thickness (m) of a 2D body, > 0; it must stay 1 for a solid.

    Raises
    ------
    ProblemError
        If a value is out of its range, or the state is none of the three.

    Examples
    --------
    >>> from msvalidate import Isotropic
    >>> rubber = Isotropic(E=1e6, nu=0.49, state="plane_strain", thickness=0.002)
    >>> rubber.dim
    2
    """

    E: float
    nu: float
    state: State = "plane_stress"
    density: float = 1000.0
    thickness: float = 1.0

    def __post_init__(self) -> None:
        if positive_number("Young's modulus E", self.E, "Pa") < np.finfo(float).tiny:
            raise ProblemError(f"Young's modulus E: {self.E:g} Pa; take a unit in which it is more")
        _check_body(self)
        nu = finite_number("Poisson's ratio nu", self.nu)
        if not -1 < nu <= 0.5:
            raise ProblemError(
                f"Poisson's ratio nu: {format_value(self.nu)}; a stable material has -1 < nu <= 1/2"
            )
        require_one_of("material state", self.state, get_args(State))

    @property
    def dim(self) -> int:
        """Number of axes, 2 or 3."""
        return 3 if self.state == "solid" else 2


@dataclass(frozen=True, eq=False)
class Anisotropic:
    """Linear elastic material given by its stiffness tensor.

    Parameters
    ----------
    C
        Stiffness tensor (Pa) in Voigt notation [Nye1957] with engineering shear strains: shape
        (3, 3) in the order xx, yy, xy, or (6, 6) in the order xx, yy, zz, yz, xz, xy. A 2D tensor
        relates the in-plane components, so it already contains plane stress or plane strain.
    density
        Mass density (kg/m³), > 0.
    thickness
        Out-of-plane thickness (m) of a 2D body, > 0; it must stay 1 for a solid.

    Raises
    ------
    ProblemError
        If the tensor has another shape, is not symmetric or is not positive definite, or if density
        or thickness are out of range.

    Examples
    --------
    >>> from msvalidate import Anisotropic
    >>> plate = Anisotropic([[2e5, 5e4, 0.0], [5e4, 1e5, 0.0], [0.0, 0.0, 4e4]], thickness=0.001)
    >>> plate.dim
    2
    """

    C: Array
    density: float = 1000.0
    thickness: float = 1.0

    def __post_init__(self) -> None:
        C = finite("stiffness tensor C", self.C)
        if C.shape not in {(3, 3), (6, 6)}:
            raise ProblemError(f"stiffness tensor C: shape {C.shape}; give (3, 3) or (6, 6)")
        largest = np.abs(C).max() or 1.0
        ratios = C / largest  # of which neither the largest nor the smallest unit makes infinities
        if np.abs(ratios - ratios.T).max() > 1e-12:
            raise ProblemError("stiffness tensor C: not symmetric; no elastic energy belongs to it")
        lowest = np.linalg.eigvalsh(ratios)[0]
        if lowest <= 1e-12:
            raise ProblemError(
                f"stiffness tensor C: lowest eigenvalue {float(lowest) * float(largest):g} Pa; "
                "some strain costs no energy"
            )
        object.__setattr__(self, "C", C)
        _check_body(self)

    @property
    def dim(self) -> int:
        """Number of axes, 2 or 3."""
        return 2 if self.C.shape == (3, 3) else 3


Material = Isotropic | Anisotropic


def _check_body(material: Material) -> None:
    """Refuse a density or a thickness out of range."""
    positive_number("density", material.density, "kg/m³")
    positive_number("thickness", material.thickness, "m")
    if material.dim == 3 and material.thickness != 1:
        raise ProblemError(f"thickness: {material.thickness} m; a solid has none, leave it at 1")
