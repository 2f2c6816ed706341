"""The constants that make a body's lattice an isotropic material, or why there are none.

What a body made of the lattice will do under uniform tension is told with them: see
`msvalidate.bodies.uniform_tension`.
"""

from __future__ import annotations

from dataclasses import replace

from msvalidate.bodies.uniform_tension import check_uniform_tension
from msvalidate.constants.calibration import Calibration
from msvalidate.constants.routes import calibrate_by_route
from msvalidate.lattice import Lattice, Pattern
from msvalidate.problem import Isotropic
from msvalidate.problem.material import State


def calibrate(
    E: float,
    nu: float,
    lattice: Pattern | Lattice,
    plane: State = "plane_stress",
    *,
    thickness: float = 1.0,
    spacing: float | None = None,
    route: str | None = None,
) -> Calibration:
    """Constants that make a lattice an isotropic material.

    Parameters
    ----------
    E, nu
        Young's modulus (Pa) and Poisson's ratio of the three-dimensional material.
    lattice
        What repeats, or a body made of it.
    plane
        "plane_stress" or "plane_strain" for a plane lattice, "solid" for one in space.
    thickness
        Out-of-plane thickness (m) of a plane body.
    spacing, route
        As for `calibrate_material`.

    Raises
    ------
    ProblemError
        As for `calibrate_material`, or if there is no such material.
    """
    material = Isotropic(E=E, nu=nu, state=plane, thickness=thickness)
    return calibrate_material(material, lattice, spacing=spacing, route=route)


def calibrate_material(
    material: Isotropic,
    lattice: Pattern | Lattice,
    *,
    spacing: float | None = None,
    route: str | None = None,
) -> Calibration:
    """Constants that give a lattice the moduli of a material, by one route or the first possible.

    The endless lattice is that material. Of a body, `Calibration.body` says how far it is.

    Parameters
    ----------
    material, lattice
        What is to be, and of what.
    spacing
        Length (m) of a pattern's unit, by default 1; a body has its own.
    route
        One of `ROUTES`; None takes springs alone where they will do, or else a volume energy.

    Raises
    ------
    ProblemError
        With the reason and the nearest that there is, if there is no way.
    """
    found = calibrate_by_route(material, lattice, spacing, route)
    if isinstance(lattice, Pattern):
        return found
    return replace(found, body=check_uniform_tension(material, lattice, found))
