"""A soft slab at rest in its field, near where it was: field and body solved in turn.

    ∫ P(F):∂φ/∂X dX = f(u),    f = +∂/∂u (½ C(u) V²)  at a fixed voltage V.

The field on the moved mesh, then the body at large strain under forces held still, and so on. Near
a rest this map has the derivative K_mech⁻¹ K_elec, so its largest eigenvalue, the gain, says both
how fast it converges and how near the body is to pulling in: there the gain is 1. Secants of past
turns [Anderson1965, WalkerNi2011] take the slow parts out.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from msvalidate.problem import Array, ProblemError
from msvalidate.problem.checks import finite_number, require_one_of, require_type
from msvalidate.problem.records import ReadOnly, dataclass
from reference_fem.actuator.soft_slab import Electric, SoftSlab
from reference_fem.actuator.staggered import fixed_point
from reference_fem.large_strain.equilibrium import LargeStrainSolution, deform

TOLERANCE = 1e-8
"""Movement, relative to the slab's height, that one more turn may make."""
LEAST_PART = 0.2
"""Part of the forces' change, from turn to turn, that the body must be able to follow."""
LARGEST = 1e100
"""Voltage (V) or charge (C) beyond which its square is hardly a number."""


@dataclass(frozen=True, eq=False)
class ActuatedSlab(ReadOnly):
    """A slab at rest at a voltage.

    Parameters
    ----------
    actuator
        The question.
    voltage
        In V.
    charge
        (k,) in C, of each electrode.
    displacement
        (m, 2) in m, of the nodes of `actuator.body`.
    deformed
        The body at rest under the last forces.
    electric
        The field at 1 V, on the mesh before its last movement.
    iterations
        Turns of field and body.
    residual
        Movement of the last of them, relative to the slab's height.
    """

    actuator: SoftSlab
    voltage: float
    charge: Array
    displacement: Array
    deformed: LargeStrainSolution
    electric: Electric
    iterations: int
    residual: float

    def at(self, points: ArrayLike) -> Array:
        """Displacement (p, 2) in m at points (p, 2) of the slab at rest.

        Raises
        ------
        ProblemError
            If a point lies outside the slab.
        """
        return self.deformed.at(points)

    @property
    def ratio(self) -> float:
        """Thickness of the slab over that at rest, in the middle of its length."""
        slab = self.actuator.slab
        return 1 + float(self.at([[slab.length / 2, slab.height]])[0, 1]) / slab.height


def solve_actuated(
    actuator: SoftSlab,
    drive: Literal["voltage", "charge"],
    value: float,
    start: ActuatedSlab | None,
) -> ActuatedSlab:
    """The slab at rest near `start`, at a voltage (V) or a charge (C), in one step.

    Raises
    ------
    ProblemError
        If an argument is out of range.
    SolverError
        If field and body do not settle, or a cell turns inside out on the way.
    """
    refuse_start(actuator, start)
    require_one_of("drive", drive, ("voltage", "charge"))
    if abs(finite_number(drive, value)) > LARGEST:
        unit = "V" if drive == "voltage" else "C"
        raise ProblemError(
            f"{drive}: {value:g} {unit}; take units in which it is below {LARGEST:g}"
        )
    solid, nothing = actuator.solid, np.zeros(actuator.body.points.shape)

    def answer(u: Array) -> tuple[Array, tuple[float, Electric, LargeStrainSolution]]:
        electric = actuator.electric(u)
        voltage = value if drive == "voltage" else value / electric.capacitance
        body = deform(solid, nothing, voltage**2 * electric.forces, start=u, least_part=LEAST_PART)
        return body.displacement, (voltage, electric, body)

    begin = nothing if start is None else start.displacement
    height = actuator.slab.height
    turns = fixed_point(answer, begin, TOLERANCE * height)
    voltage, electric, body = turns.found
    return ActuatedSlab(
        actuator=actuator,
        voltage=voltage,
        charge=voltage * electric.totals,
        displacement=body.displacement,
        deformed=body,
        electric=electric,
        iterations=turns.count,
        residual=turns.left / height,
    )


def refuse_start(actuator: SoftSlab, start: ActuatedSlab | None) -> None:
    """Raise a `ProblemError` for what is no slab, or no equilibrium of it to start from."""
    require_type("actuator", actuator, SoftSlab)
    if start is not None:
        require_type("start", start, ActuatedSlab)
        if start.actuator is not actuator:
            raise ProblemError("start: of another slab; start from an equilibrium of this one")
