"""Electrostatics of dielectrics: -div(ε grad φ) = ρ with conductors held at potentials.

In the plane, per depth. The potential is the one of least energy, so what the equations leave at
nodes of conductors is their charge, consistent with the energy to rounding: W = ½ΣQV. Forces are
its derivatives when nodes move at fixed potentials, which is Maxwell's stress

    F_i = +∂W/∂x_i = -∫ T·∇φ_i,    T = ε(E⊗E - ½E²I),

by the very quadrature that W is summed with. No normal and no jump of the field is asked for.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from msvalidate.linear_algebra.factor import Factor
from msvalidate.problem import Array, Index, Mask, ProblemError, SolverError, format_point
from msvalidate.problem.checks import boolean_mask, finite, format_value, integers, require_type
from msvalidate.problem.records import ReadOnly, dataclass, field
from reference_fem.electric.laplacian import scalar_factor, weighted_laplacian
from reference_fem.mesh.discretisation import Discretisation
from reference_fem.mesh.gradients import Gradients, gradients_at_points
from reference_fem.stress import displacement_gradient
from reference_fem.systems.refined import Refined, refine_solution, share_left
from reference_fem.systems.solver import RESIDUAL

LEAST_KNOWN = 1e-6
"""Error of a potential, or charge left where there is none, beyond which a solution is refused."""


def no_nodes() -> Index:
    """Empty node array, for a medium without a floating conductor."""
    return np.zeros(0, dtype=np.intp)


@dataclass(frozen=True, eq=False)
class Dielectric:
    """A medium with conductors in it, ready for any voltages: its factor is made once, when needed.

    Parameters
    ----------
    body
        The mesh, of one element.
    permittivity
        (c,) of the cells, absolute (F/m).
    held
        (n,) nodes whose potential is given.
    floating
        (k,) nodes of one more conductor, of unknown potential and no charge: a far boundary that
        is earthed nowhere. None by default.

    Raises
    ------
    ProblemError
        If the body is not plane, an array is of another shape, a permittivity is not above zero, a
        floating node is not there or held as well, or a part of the body holds no potential.
    """

    body: Discretisation
    permittivity: Array
    held: Mask
    floating: Index = field(default_factory=no_nodes)

    def __post_init__(self) -> None:
        require_type("body", self.body, Discretisation)
        if self.body.dim != 2:
            raise ProblemError(f"body: {self.body.dim}D; forces and charges here are of the plane")
        size = len(self.body.points)
        permittivity = finite("permittivity", self.permittivity, len(self.body.cells))
        if (permittivity <= 0).any():
            cell = int(np.flatnonzero(permittivity <= 0)[0])
            raise ProblemError(
                f"permittivity: {permittivity[cell]:g} F/m in cell {cell}; it must be above zero"
            )
        held = boolean_mask("held", self.held, (size,))
        floating = np.unique(integers("floating", self.floating))
        if ((floating < 0) | (floating >= size)).any():
            raise ProblemError(
                f"floating: {format_value(self.floating)}; nodes run from 0 to {size - 1}"
            )
        if held[floating].any():
            raise ProblemError("floating: a node of it is held as well; leave it out of one")
        object.__setattr__(self, "permittivity", permittivity)
        object.__setattr__(self, "floating", floating)
        object.__setattr__(self, "held", held)
        _refuse_floating_alone(self.body, self.held)

    def solve(self, values: Array, charge: Array | None = None) -> Potential:
        """Potential under values (n,) where it is held (V) and free charges (n,) (C/m), if any.

        Charges in the volume are consistent ones: ρ_i = ∫ρ φ_i.

        Raises
        ------
        ProblemError
            If a value is no finite number or the shape is another.
        SolverError
            If memory does not suffice, or the solution fails its residual check.
        """
        given = np.where(self.held, self._nodal("potentials", values), 0.0)
        load = np.zeros(len(given)) if charge is None else self._nodal("charges", charge)
        with np.errstate(over="ignore", invalid="ignore"):  # what is infinite is refused below
            share = load / self._unit
            refined = self._refined(given, share)
            left = self._charge(refined.value) - share
            residual = np.abs(left[self._free]).max(initial=0.0)
            error = max(refined.error, self._unbalanced(left, share))
            scale = (abs(self._relative) @ np.abs(refined.value) + np.abs(share))[self._free]
            found = Potential(self, refined.value, self._unit * left, error)
            most = scale.max(initial=0.0)
            if not (residual <= RESIDUAL * most and np.isfinite(found.energy)):
                raise SolverError(
                    f"potential: residual {residual:.3g} V against terms of {most:.3g} V, energy "
                    f"{found.energy:.3g} J/m; the system is badly scaled, take less graded cells "
                    "and units in which potentials and permittivities are ordinary numbers"
                )
        self._refuse_lost(error)
        return found

    def _refined(self, given: Array, share: Array) -> Refined:
        """Potentials (n,), from what is held and charges in the unit."""
        fixed = given[self.held]
        # What all potentials have in common makes no charge, and would cost digits.
        middle = 0.5 * fixed.max() + 0.5 * fixed.min()
        start = np.where(self.held, given - middle, 0.0)
        found = refine_solution(self._charge, self._inverse, start, share, self._share)
        return Refined(found.value + middle, found.error, found.corrections)

    def _inverse(self, charge: Array) -> Array:
        """Potentials (n,) of charges (n,) in the unit, zero where held."""
        change = self._found(charge)
        if self._raised is not None:
            raised, its_charge = self._raised
            left = charge - self._charge(change)
            change = change + left[self.floating].sum() / its_charge * raised
        return change

    @cached_property
    def _share(self) -> float:
        """Relative error that a correction leaves."""
        moves = ~self.held
        moves[self.floating] = False
        return share_left(self._charge, self._inverse, self.body.points, moves, 1)

    def _unbalanced(self, left: Array, share: Array) -> float:
        """Charge that is left where there is none, over that on conductors and in the volume.

        A factor that has lost all digits of how a part is held makes no correction to it: that does
        not show in the corrections, and does here.
        """
        on_free = np.abs(left[self._free]).sum() + abs(left[self.floating].sum())
        size = np.abs(left[self.held]).sum() + np.abs(share).sum()
        return float(on_free / size) if size else (0.0 if on_free == 0 else np.inf)

    def _refuse_lost(self, error: float) -> None:
        if not error <= LEAST_KNOWN:
            low, high = float(self.permittivity.min()), float(self.permittivity.max())
            known = f"known to {error:.2g} of itself only" if error < 1 else "all rounding"
            raise SolverError(
                f"potential: {known}, permittivities from {low:g} to "
                f"{high:g} F/m leave rounding no more; take a conductor, its nodes held or "
                "floating, for the largest, or cells less graded"
            )

    @cached_property
    def _raised(self) -> tuple[Array, float] | None:
        """Potentials (n,) of a floating conductor raised alone by 1 V, and its charge in the unit.

        None if no conductor floats.
        """
        if not len(self.floating):
            return None
        raised = np.zeros(len(self.held))
        raised[self.floating] = 1.0
        raised = raised + self._found(-self._charge(raised))
        return raised, self._energy(raised)

    def _charge(self, potential: Array) -> Array:
        """∫ε ∇φ·∇φi (n,) in the unit, cell by cell: charges at the nodes."""
        flux = self._weight * self._cells.of(potential[None])
        return np.asarray(self._cells.gathered(flux)[0])

    def _energy(self, potential: Array) -> float:
        """∫ε|∇φ|² in the unit, twice the energy."""
        return float((self._weight * (self._cells.of(potential[None]) ** 2)).sum())

    @cached_property
    def _cells(self) -> Gradients:
        return gradients_at_points(self.body)

    @cached_property
    def _weight(self) -> Array:
        """Permittivity in the unit times the measure (q, c)."""
        return self._cells.measure * (self.permittivity / self._unit)

    @property
    def stiffness(self) -> csr_matrix:
        """∫ε ∇φi·∇φj (n, n) in F/m."""
        return self._unit * self._relative

    @property
    def _unit(self) -> float:
        """Permittivity (F/m) that the others are measured by, which may be as small as air's."""
        return float(self.permittivity.max())

    @cached_property
    def _relative(self) -> csr_matrix:
        return weighted_laplacian(self.body, self.permittivity / self._unit)

    @cached_property
    def _free(self) -> Index:
        fixed = self.held.copy()
        fixed[self.floating] = True
        return np.flatnonzero(~fixed)

    @cached_property
    def _factor(self) -> Factor:
        return scalar_factor(self.body, self._relative, self._free)

    def _found(self, charge: Array) -> Array:
        """Potentials (n,) of charges (n,) at the free nodes, all others at 0 V."""
        phi = np.zeros(len(charge))
        if len(self._free):
            phi[self._free] = self._factor.solve(charge[self._free])
        return phi

    def _nodal(self, name: str, values: ArrayLike) -> Array:
        return finite(name, values, len(self.held))


@dataclass(frozen=True, eq=False)
class Potential(ReadOnly):
    """A solution: potential at the nodes, and what follows from it.

    Source: forces by Maxwell's stress, [Maxwell1873].

    Parameters
    ----------
    medium
        What it solves.
    values
        (n,) potential at the nodes (V).
    charge
        (n,) charge of conductors by node, per depth (C/m): what the equations leave there, which
        is nothing at nodes of no conductor. Sum it over a conductor.
    error
        Largest error of a potential, relative to the largest of what is left when all have their
        middle taken off, or charge left over where there is none, over all charge, if that is more.
        Charges and energy share it. What the mesh leaves out is not in it.
    """

    medium: Dielectric
    values: Array
    charge: Array
    error: float

    @property
    def energy(self) -> float:
        """½∫ε|E|² per depth (J/m)."""
        return 0.5 * self.medium._unit * self.medium._energy(self.values)

    def at(self, points: ArrayLike) -> Array:
        """Potential (p,) in V at points (p, 2) in m of the mesh.

        Raises
        ------
        ProblemError
            If a point lies outside the mesh.
        """
        return np.asarray(self.medium.body.interpolation(points) @ self.values)

    def field(self, points: ArrayLike) -> Array:
        """Field E = -grad φ (p, 2) in V/m at points (p, 2) in m of the mesh.

        Where cells meet, the mean over them: on a charged face that is no field of either side, so
        ask a little off it.

        Raises
        ------
        ProblemError
            If a point lies outside the mesh.
        """
        return -displacement_gradient(self.medium.body, self.values[:, None], points)[:, 0]

    @cached_property
    def forces(self) -> Array:
        """Maxwell's forces (n, 2) on the nodes, per depth (N/m): -∫ T·∇φ_i.

        They are the derivative of the energy in the places of nodes, conductors at their voltages.
        On conductors and faces of dielectrics they are the pull on them; elsewhere they are what
        the discretisation leaves, which is little but at edges of electrodes.
        """
        cells = self.medium._cells
        (E,) = cells.of(-self.values[None])
        weight = self.medium._unit * self.medium._weight
        stress = weight * (E[:, None] * E - 0.5 * (E**2).sum(axis=0) * np.eye(2)[:, :, None, None])
        return -cells.gathered(stress).T


def _refuse_floating_alone(body: Discretisation, held: Mask) -> None:
    """A part of the mesh in which no potential is held has any."""
    count, part = connected_components(body.links, directed=False)
    lost = np.setdiff1d(np.arange(count), part[held])
    if len(lost):
        place = body.points[part == lost[0]][0]
        raise ProblemError(
            f"potential: held nowhere in the part of the mesh around {format_point(place)} m; give "
            f"a "
            "node of it a potential"
        )
