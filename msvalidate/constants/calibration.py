"""A calibration: constants, the material that they make, and what a body does with them."""

from __future__ import annotations

from typing import Literal

from msvalidate.constants.stiffness import AXES_OF, UNIT
from msvalidate.lattice import Constants
from msvalidate.problem import Array
from msvalidate.problem.records import ReadOnly, dataclass

Verdict = Literal["exact", "first order", "unstable", "not known"]


@dataclass(frozen=True)
class TensionCheck:
    """Response of a body of a calibrated lattice to uniform tension along each axis.

    Parameters
    ----------
    verdict
        "exact": it follows the material to rounding, whatever its size. "first order": its sides
        cut springs, which leaves an error that halves with the spacing. "unstable": its tangent
        has a negative or no stiffness for some motion, so that it has no equilibrium to show.
        "not known": it was not tried.
    error
        The largest error of a displacement's component over the largest displacement, of the worst
        axis, where the verdict is of first order; 0 where it is exact, or else NaN.
    points
        Of the body that was tried: that one, or a smaller one of the same lattice, whose error is
        then taken to be in proportion to the spacing over the body's least length.
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
    """Constants of a lattice, and the isotropic material that they make.

    Parameters
    ----------
    constants
        Of the central springs (N/m, thickness included), one a kind.
    volume
        κ of the energy of a cell's volume, 0 if there is none: N/m in the plane (thickness
        included), Pa in a solid; the same for cells of any size. λ where they are under pressure.
    E, nu
        Young's modulus (Pa) and Poisson's ratio of the material that the tensor is.
    zener
        2·C44/(C11 - C12) of the tensor, 1 where it is isotropic.
    route
        One of `ROUTES`.
    tensor
        Voigt tensor, (3, 3) in N/m or (6, 6) in Pa, of the endless lattice, its points at rest.
    lattice, spacing, thickness
        What all of this is for: the pattern's name, its unit's length (m), and the thickness (m).
        In the plane it serves any spacing.
    body
        What the body does that was given; None of a pattern, and all of the above is of endless
        lattices.
    pressure
        Of cells at rest, in the units of `volume`: then springs have no rest length, and pull
        against it (`laws.zero_length`, `laws.logarithmic`).
    pushing
        Springs of negative stiffness, of how many: none but along a mesh's edges.
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
        end = "of an endless lattice; bodies differ" if self.body is None else str(self.body)
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
