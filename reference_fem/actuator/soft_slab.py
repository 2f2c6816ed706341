"""A soft slab with electrodes, ready to be squeezed: its mesh, its supports, its field at 1 V."""

from __future__ import annotations

from functools import cached_property
from typing import Literal

import numpy as np

from msvalidate.problem import Array, Mask, ProblemError, SolverError
from msvalidate.problem.checks import (
    finite_coordinates,
    finite_number,
    positive_number,
    require_one_of,
    require_type,
    whole_number,
)
from msvalidate.problem.records import dataclass
from reference_fem.electric.charges import solve_charges
from reference_fem.electric.electrostatics import Dielectric, Potential
from reference_fem.electric.mesh import SlabMesh, move_air, slab_mesh
from reference_fem.electric.slab import Slab
from reference_fem.large_strain.hyperelastic import Law
from reference_fem.large_strain.solid import Solid
from reference_fem.mesh.boxes import lines_discretisation
from reference_fem.mesh.discretisation import Discretisation, make_discretisation
from reference_fem.systems.solver import refuse_shapes

GRADING = 1.5
"""Exponent of the spacing at edges of electrodes, unless given: cells at the edges turn inside out
sooner, the smaller they are."""

Around = Literal["air", "plates"]


@dataclass(frozen=True, eq=False)
class SoftSlab:
    """A slab bonded to its base, of one law, with electrodes.

    Parameters
    ----------
    slab
        Its shape, permittivities and electrodes, whose voltages are multiples of the voltage asked
        for, as `facing_slab` gives them.
    law
        Energy density of the slab, of two axes.
    layers
        Cells up the slab's height; an even number in air.
    around
        "air": the field reaches out to a far boundary and the sides are free. "plates": both faces
        wholly covered and sides that slide up and down, as in the middle of a slab without end.
        There is no field outside the electrodes then, however the top bends.
    element, grading, reach
        Of the mesh, as for `slab_mesh`; no field passes the far boundary.
    depth
        Of the slab (m), across the plane.
    frame
        Distance (m) from the ends of electrodes on the top within which a frame holds the slab. At
        0 they are free: the field pulls at an end with a force in a point, which nothing withstands
        but the size of the cells, so that the end pulls in first and at a voltage of the mesh.

    Raises
    ------
    ProblemError
        If the parts do not fit together.
    """

    slab: Slab
    law: Law
    layers: int = 8
    around: Around = "air"
    element: str = "Q2"
    grading: float = GRADING
    reach: float | None = None
    depth: float = 1.0
    frame: float = 0.0

    def __post_init__(self) -> None:
        require_type("slab", self.slab, Slab)
        require_one_of("around", self.around, ("air", "plates"))
        positive_number("depth", self.depth, "m")
        whole_number("layers", self.layers, 1)
        if not 0 <= finite_number("frame", self.frame) < self.slab.length:
            raise ProblemError(
                f"frame: {self.frame} m; give a distance from 0 to below the slab's length"
            )
        if getattr(self.law, "dim", None) != 2:
            raise ProblemError("law: not one of two axes; give one of plane strain")
        if self.around == "plates":
            _refuse_margins(self.slab)

    @cached_property
    def mesh(self) -> SlabMesh:
        """Slab and air at rest."""
        return slab_mesh(
            self.slab, self.layers, element=self.element, grading=self.grading, reach=self.reach
        )

    @cached_property
    def body(self) -> Discretisation:
        """The slab at rest."""
        if self.around == "air":
            return self.mesh.solid
        slab = self.slab
        along = max(1, round(self.layers * slab.length / slab.height))
        lines = (
            np.linspace(0.0, slab.length, along + 1),
            np.linspace(0.0, slab.height, self.layers + 1),
        )
        return lines_discretisation(lines, self.element)

    @cached_property
    def solid(self) -> Solid:
        """The slab with its supports."""
        x, y = self.body.points.T
        held = np.zeros(self.body.points.shape, dtype=bool)
        held[np.abs(y) <= self.slab.tolerance] = True
        held[self._framed()] = True
        if self.around == "plates":
            held[np.minimum(x, self.slab.length - x) <= self.slab.tolerance, 0] = True
        return Solid(self.body, self.law, held, self.depth)

    def _framed(self) -> Mask:
        """Nodes (m,) that the frame holds."""
        near = np.zeros(len(self.body.points), dtype=bool)
        for electrode in self.slab.electrodes:
            if electrode.side == "top" and self.frame:
                for end in (electrode.start, electrode.end):
                    away = np.linalg.norm(self.body.points - (end, self.slab.height), axis=1)
                    near |= away <= self.frame + self.slab.tolerance
        return near

    def electric(self, displacement: Array) -> Electric:
        """Charges and forces at a voltage of 1 V, the slab's nodes displaced (m, 2) in m.

        Raises
        ------
        ProblemError
            If the displacement is of another shape, or not finite.
        SolverError
            If a cell is turned inside out.
        """
        if self.around == "air":
            found = solve_charges(move_air(self.mesh, displacement))
            # Air follows the slab as it did from rest: with that motion's transpose, forces are the
            # derivative of the energy.
            return Electric(
                self.depth * self.mesh.carried(found.solution.forces),
                self.depth * found.totals,
                2 * self.depth * found.energy,
                found.solution,
            )
        u = finite_coordinates("displacement of the slab", displacement)
        refuse_shapes(self.body, **{"displacement of the slab": u})
        return self._between_plates(u)

    def _between_plates(self, displacement: Array) -> Electric:
        moved = _move_body(self.body, displacement)
        y = self.body.points[:, 1]
        held, values = np.zeros(len(y), dtype=bool), np.zeros(len(y))
        faces = []
        for electrode in self.slab.electrodes:
            on = np.abs(y - self.slab.level(electrode.side)) <= self.slab.tolerance
            held |= on
            values[on] = electrode.voltage
            faces.append(on)
        permittivity = np.full(len(self.body.cells), self.slab.permittivity)
        found = Dielectric(moved, permittivity, held).solve(values)
        totals = np.array([found.charge[on].sum() for on in faces])
        return Electric(
            self.depth * found.forces, self.depth * totals, 2 * self.depth * found.energy, found
        )


@dataclass(frozen=True, eq=False)
class Electric:
    """The field of a slab at 1 V.

    Parameters
    ----------
    forces
        Maxwell's, on the slab's nodes (m, 2), in N at 1 V.
    totals
        Charge of each electrode (k,) in C at 1 V.
    capacitance
        Twice the energy at 1 V, in F.
    potential
        (V) at the nodes of the moved mesh.
    """

    forces: Array
    totals: Array
    capacitance: float
    potential: Potential


def _move_body(body: Discretisation, displacement: Array) -> Discretisation:
    """The slab alone, its nodes displaced (m, 2)."""
    try:
        return make_discretisation(body.points + displacement, body.cells, body.element.name)
    except ProblemError as error:
        raise SolverError(
            f"moved slab: a displacement of up to {np.abs(displacement).max():.3g} m turns a cell "
            "inside out; take a smaller step"
        ) from error


def _refuse_margins(slab: Slab) -> None:
    """Plates cover both faces."""
    for electrode in slab.electrodes:
        whole_face = (
            electrode.start <= slab.tolerance and electrode.end >= slab.length - slab.tolerance
        )
        if not whole_face or len(slab.electrodes) != 2:
            raise ProblemError(
                f"plates: an electrode from {electrode.start:g} to {electrode.end:g} m; between "
                f"plates two cover both faces, from 0 to {slab.length:g} m"
            )
