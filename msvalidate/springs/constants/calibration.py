"""A calibration: constants, the material that they make, and what a body does with them."""

from __future__ import annotations

from typing import Literal

from msvalidate.problem import Array
from msvalidate.problem.records import ReadOnly, dataclass
from msvalidate.springs.constants.stiffness import AXES_OF, UNIT
from msvalidate.springs.lattice import Constants

Verdict = Literal["exact", "first order", "unstable", "not known"]


@dataclass(frozen=True)
class TensionCheck:
    """Response of a calibrated lattice body to uniform tension along each axis.

    Parameters
    ----------
    verdict
        "exact": the body follows the material to rounding at any size. "first order": springs are
        cut at its sides, with an error proportional to the spacing. "unstable": its tangent is not
        positive definite. "not known": it was not tested.
    error
        Largest error of a displacement component, relative to the largest displacement, for the
        worst axis, if the verdict is "first order"; 0 if it is "exact", otherwise NaN.
    points
        Number of points of the tested body. A large body is represented by a smaller one of the
        same lattice, whose error is scaled with the spacing relative to the shortest side.
    """

    verdict: Verdict
    error: float
    points: int

    def __str__(self) -> str:
        if self.verdict == "exact":
            return "uniform strain is exact in this body"
        if self.verdict == "first order":
            return (
                "this body's sides cut springs: under uniform tension displacements are off by "
                f"about {100 * self.error:.2g} % of the largest, half of that with half the spacing"
            )
        if self.verdict == "unstable":
            return "this body is unstable: take another ratio or lattice"
        return "what this body does was not tried"


@dataclass(frozen=True, eq=False)
class Calibration(ReadOnly):
    """Spring constants of a lattice, and the isotropic material that they produce.

    Parameters
    ----------
    constants
        Constants of the central springs (N/m, thickness included; Pa for 3D mesh edges), one per
        kind.
    volume
        Stiffness κ of the volume energy of a cell (N/m with the thickness in 2D, Pa in 3D), the
        same for any cell size; 0 without one. With pressure in the cells it is λ.
    E, nu
        Young's modulus (Pa) and Poisson's ratio of the material.
    zener
        Zener ratio 2·C44/(C11 - C12) of the tensor, 1 if it is isotropic.
    route
        "springs", "volume energy" or "neo-Hookean".
    tensor
        Effective Voigt tensor of the periodic lattice, (3, 3) in N/m or (6, 6) in Pa.
    lattice, spacing, thickness
        Name of the pattern, length of its unit (m) and thickness (m) to which the constants apply.
        In 2D they apply to any spacing.
    body
        Response of the given body to uniform tension; None for a pattern.
    pressure
        Pressure in the cells at the reference positions, in the units of `volume`. If it is not 0,
        the springs are zero-length springs.
    pushing
        Number of springs with negative stiffness, and number of all springs.
    """

    constants: Constants
    volume: float
    E: float
    nu: float
    zener: float
    route: str
    tensor: Array
    lattice: str
    spacing: float
    thickness: float
    body: TensionCheck | None = None
    pressure: float = 0.0
    pushing: tuple[int, int] = (0, 0)

    def __str__(self) -> str:
        end = "moduli of the periodic lattice" if self.body is None else str(self.body)
        k = ", ".join(f"{each:.6g}" for each in self.constants)
        unit = UNIT[AXES_OF[len(self.tensor)]]
        kappa = f", κ = {self.volume:.6g} {unit}" if self.volume else ""
        if self.pressure:
            kappa = f" of no rest length, λ = {self.volume:.6g} {unit} and pressure "
            kappa += f"{self.pressure:.6g} {unit} in cells"
            if self.pushing[0]:
                kappa += f", {self.pushing[0]:,} of {self.pushing[1]:,} springs push"
        made = f"k = {k} N/m{kappa}: E = {self.E:g} Pa, nu = {self.nu:g}"
        return f"{self.lattice} lattice by {self.route}: {made}; {end}"
