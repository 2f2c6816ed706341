"""The model of the report as a labelled variant, and single steps from it to the right one.

The report puts even charges on springs, asks for the potential at each spring's middle with the
kernel 1/(4πεr) of space, lets a charge at rest at infinity have none, and sums Coulomb's forces
between the springs' middles, half of each to each end of its spring. In a plane body every spring
is a rectangle, `depth` deep, of even charge: electrodes are plates of that depth in open space.
Three switches change one thing at a time:

kernel
    "report": rectangles in space. "plane": line charges, -ln r/(2πε), which add up to nothing.
charges_on
    "springs", or "nodes": lumps that spread evenly over the halves of the springs that meet there.
forces
    `report_forces`, sums over point charges, or `consistent_forces`, derivatives of the energy.

Charges, energies and forces are per depth, like those of `Moments`, whose collocation is the plane
kernel on springs.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from msvalidate.dielectric.charges.checks import (
    check_error,
    check_positive,
    check_voltages,
    logarithm_error,
    refuse_dense,
)
from msvalidate.dielectric.charges.electrodes import Electrodes
from msvalidate.dielectric.charges.moments import check_electrodes, factorise
from msvalidate.dielectric.charges.pieces import (
    KERNELS,
    PLACES,
    Kernel,
    Place,
    Views,
    pieces,
    views_of,
)
from msvalidate.problem import Array, Index
from msvalidate.problem.checks import length_in_metres, require_one_of, require_type
from msvalidate.problem.records import ReadOnly, dataclass


class ReportModel:
    """Electrodes with the factor of the report's equations, made once for any voltages.

    Parameters
    ----------
    electrodes
        One or more; two or more with the plane kernel.
    permittivity
        Of the medium all around (F/m).
    depth
        Of the rectangles (m); the plane kernel has none.
    kernel, charges_on
        See the module.

    Raises
    ------
    ProblemError
        If the plane kernel is given one electrode, or an argument is out of range.
    """

    def __init__(
        self,
        electrodes: Electrodes,
        *,
        permittivity: float = 1.0,
        depth: float = 1.0,
        kernel: Kernel = "report",
        charges_on: Place = "springs",
    ) -> None:
        require_type("electrodes", electrodes, Electrodes)
        refuse_dense("segments", len(electrodes.segments))
        require_one_of("kernel", kernel, KERNELS)
        require_one_of("charges_on", charges_on, PLACES)
        if kernel == "plane":
            check_electrodes(electrodes)
        self.electrodes = electrodes
        self.kernel: Kernel = kernel
        self.permittivity = check_positive("permittivity", permittivity, "F/m")
        self.depth = length_in_metres("depth", depth)
        self.pieces = pieces(electrodes, charges_on)
        coefficients = self.views().mean @ self.spread()
        if kernel == "plane":
            # As large as the rest, for a condition that does not hang on the unit of charge.
            border = float(np.abs(coefficients).max())
            coefficients = np.pad(coefficients, (0, 1), constant_values=border)
            coefficients[-1, -1] = 0.0
        self._inverse, self._condition = factorise(coefficients, symmetric=False)

    def charges(self, voltages: ArrayLike) -> ReportCharges:
        """Charges at potentials (k,) in V, one for each electrode.

        With the report's kernel these count from far away, and a common part of them matters.
        """
        given = check_voltages("an electrode", self.electrodes.count, voltages)
        charge = self.solve(given[self.pieces.electrode])
        return ReportCharges(
            self,
            given,
            charge,
            check_error(logarithm_error(self.electrodes.extent) * self._condition),
        )

    def solve(self, potential: Array, *, adjoint: bool = False) -> Array:
        """Charges (k, ...) in C/m at potentials at their joints (V); `adjoint` transposes."""
        if self.kernel == "plane":
            neutral = np.zeros((1, *potential.shape[1:]))
            potential = np.concatenate([potential, neutral])
        return self._inverse(potential, adjoint=adjoint)[: len(self.pieces.charge_joint)]

    def places(self) -> Array:
        """(e, 2) joints of the pieces (m)."""
        return np.asarray(self.pieces.joints @ self.electrodes.points)

    def lengths(self) -> Array:
        """(p,) of the pieces (m)."""
        at = self.places()[self.pieces.ends]
        return np.asarray(np.hypot(*(at[:, 1] - at[:, 0]).T))

    def spread(self) -> Array:
        """(p, k) part of each charge that each piece carries."""
        length, owner = self.lengths(), self.pieces.owner
        part = np.zeros((len(owner), len(self.pieces.charge_joint)))
        part[np.arange(len(owner)), owner] = length / np.bincount(owner, length)[owner]
        return part

    def views(self) -> Views:
        """Influence of the pieces on the joints of charges."""
        at = self.places()
        return views_of(
            at[self.pieces.charge_joint],
            at[self.pieces.ends],
            kernel=self.kernel,
            permittivity=self.permittivity,
            depth=self.depth,
        )


@dataclass(frozen=True, eq=False)
class ReportCharges(ReadOnly):
    """Charges at given voltages. Arrays are read-only.

    Parameters
    ----------
    moments
        What they solve.
    voltages
        (k,) of the electrodes (V).
    charge
        (c,) of the springs, or of the nodes, per depth (C/m).
    error
        How far the charges may be from the solution of their equations, as sums over all of the
        sizes of both, by the condition of the matrix.
    """

    moments: ReportModel
    voltages: Array
    charge: Array
    error: float

    @property
    def places(self) -> Array:
        """(c, 2) where the charges act as points (m)."""
        return np.asarray(self.moments.places()[self.moments.pieces.charge_joint])

    @property
    def totals(self) -> Array:
        """(k,) of the electrodes, per depth (C/m)."""
        electrode = self.moments.pieces.electrode
        count = self.moments.electrodes.count
        return np.asarray(np.bincount(electrode, self.charge, count), dtype=float)

    @property
    def energy(self) -> float:
        """½ΣQV per depth (J/m)."""
        return 0.5 * float(self.totals @ self.voltages)


def report_forces(charges: ReportCharges) -> Array:
    """Force (n, 2) per depth (N/m) on each point, by Coulomb's law between points.

    Of the force on a spring's middle each end takes half; a node takes its own. Across a gap h such
    sums with plane charges, l apart, err by coth(πh/l). With the report's kernel a spring is one
    point however deep it is: between wide electrodes of springs shorter than the gap, the sums are
    depth/(πh) times the force of even charge.
    """
    require_type("charges", charges, ReportCharges)
    moments = charges.moments
    apart, law, _ = _kernel_of_depth(moments, charges.places)
    force = (law * np.outer(charges.charge, charges.charge))[..., None] * apart
    return _sum_to_points(moments, moments.pieces.charge_joint, force.sum(axis=1))


def consistent_forces(charges: ReportCharges) -> Array:
    """Force (n, 2) per depth (N/m) on each point: the energy's derivative at fixed voltages.

    W = ½v'q with P q = v, so dW = -½ p'(dP)q with P'p = v: P is not symmetric.
    """
    require_type("charges", charges, ReportCharges)
    moments = charges.moments
    adjoint = moments.solve(charges.voltages[moments.pieces.electrode], adjoint=True)
    return np.asarray(-0.5 * np.einsum("i,inc->nc", adjoint, potential_slopes(charges)))


def potential_slopes(charges: ReportCharges) -> Array:
    """Derivatives (c, n, 2) in V/m of potentials at charges as points move with their charges."""
    moments = charges.moments
    of, view, length = moments.pieces, moments.views(), moments.lengths()
    gathered = np.bincount(of.owner, length)
    carried = charges.charge[of.owner] * length / gathered[of.owner]
    pull = carried[:, None] * view.pull
    # A longer piece sees itself thinner, and takes a larger part of its charge.
    usual = (view.mean @ moments.spread())[:, of.owner]
    share = charges.charge[of.owner] / gathered[of.owner]
    stretch = carried * view.stretch + share * (view.mean - usual)
    turn = carried * view.turn / length
    end = stretch[..., None] * view.direction + turn[..., None] * view.normal
    number, joints = np.arange(len(of.charge_joint)), of.joints.shape[0]
    at = np.zeros((joints, len(number), 2))
    np.add.at(at, of.ends[:, 0], np.swapaxes(-0.5 * pull - end, 0, 1))
    np.add.at(at, of.ends[:, 1], np.swapaxes(-0.5 * pull + end, 0, 1))
    at[of.charge_joint, number] += pull.sum(axis=1)
    total: Array = of.joints.T @ at.reshape(joints, -1)
    return np.swapaxes(total.reshape(-1, len(number), 2), 0, 1)


def report_tangent(charges: ReportCharges) -> Array:
    """Derivative (2n, 2n) of `report_forces` at fixed voltages, per depth (N/m²).

    Not symmetric: the point sums are no energy's derivative. Components of a point stand together.
    """
    require_type("charges", charges, ReportCharges)
    moments, at, charge = charges.moments, charges.places, charges.charge
    count = len(at)
    apart, law, power = _kernel_of_depth(moments, at)
    product = law * np.outer(charge, charge)
    toward = apart / np.sqrt((apart**2).sum(axis=-1) + np.eye(count))[..., None]
    bend = product[..., None, None] * (
        np.eye(2) - power * toward[..., :, None] * toward[..., None, :]
    )
    stiff = -np.swapaxes(bend, 1, 2)
    every = np.arange(count)
    stiff[every, :, every, :] += bend.sum(axis=1)
    answer = law[..., None] * apart * charge[:, None, None]
    answer[every, every] += (law[..., None] * apart * charge[:, None]).sum(axis=1)
    moved = -moments.solve(potential_slopes(charges).reshape(count, -1))
    weights = np.asarray(moments.pieces.joints[moments.pieces.charge_joint].todense())
    n = weights.shape[1]
    force = np.einsum("icjd,jn->icnd", stiff, weights).reshape(count, 2, 2 * n)
    force += np.einsum("ijc,jb->icb", answer, moved)
    return np.asarray(np.einsum("in,icb->ncb", weights, force).reshape(2 * n, 2 * n))


def _kernel_of_depth(model: ReportModel, at: Array) -> tuple[Array, Array, float]:
    """Vectors (k, k, 2) between points, Coulomb's law over them, and the power of r in it."""
    apart = at[:, None] - at[None, :]
    square = (apart**2).sum(axis=-1)
    np.fill_diagonal(square, np.inf)
    if model.kernel == "plane":
        return apart, 1 / (2 * np.pi * model.permittivity * square), 2.0
    return apart, model.depth / (4 * np.pi * model.permittivity * square**1.5), 3.0


def _sum_to_points(model: ReportModel, joints: Index, force: Array) -> Array:
    """Forces on joints as forces (n, 2) on the points that they are sums of."""
    at = np.zeros((model.pieces.joints.shape[0], 2))
    np.add.at(at, joints, force)
    return np.asarray(model.pieces.joints.T @ at)
