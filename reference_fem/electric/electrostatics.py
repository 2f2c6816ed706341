"""Electrostatics of dielectrics: -div(ε grad φ) = ρ with conductors held at potentials.

In the plane, per depth. The potential is the one of least energy, so what the equations leave at
nodes of conductors is their charge, consistent with the energy to rounding: W = ½ΣQV. Forces are
its derivatives when nodes move at fixed potentials, which is Maxwell's stress

    F_i = +∂W/∂x_i = -∫ T·∇φ_i,    T = ε(E⊗E - ½E²I),

by the very quadrature that W is summed with. No normal and no jump of the field is asked for.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from msvalidate.problem import (
    Array,
    Index,
    Mask,
    ProblemError,
    SolverError,
    booleans,
    finite,
    instance,
    integers,
    place_name,
    shown,
)
from reference_fem.electric.laplacian import scalar_factor, weighted_laplacian
from reference_fem.mesh.assembly import nodal_sums, slopes
from reference_fem.mesh.discretisation import Discretisation, discretise
from reference_fem.stress import gradient
from reference_fem.systems.factor import Factor
from reference_fem.systems.solver import RESIDUAL


def no_nodes() -> Index:
    """Of a medium in which no conductor floats."""
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
        instance("body", self.body, Discretisation)
        if self.body.dim != 2:
            raise ProblemError(f"body: {self.body.dim}D; forces and charges here are of the plane")
        size = len(self.body.points)
        permittivity = finite("permittivity", self.permittivity)
        if permittivity.shape != (len(self.body.cells),):
            raise ProblemError(
                f"permittivity: shape {permittivity.shape}; give ({len(self.body.cells)},), one a "
                "cell"
            )
        if (permittivity <= 0).any():
            cell = int(np.flatnonzero(permittivity <= 0)[0])
            raise ProblemError(
                f"permittivity: {permittivity[cell]:g} F/m in cell {cell}; it must be above zero"
            )
        held = booleans("held", self.held, (size,))
        floating = np.unique(integers("floating", self.floating))
        if ((floating < 0) | (floating >= size)).any():
            raise ProblemError(f"floating: {shown(self.floating)}; nodes run from 0 to {size - 1}")
        if held[floating].any():
            raise ProblemError("floating: a node of it is held as well; leave it out of one")
        object.__setattr__(self, "permittivity", permittivity)
        object.__setattr__(self, "floating", floating)
        object.__setattr__(self, "held", held)
        _refuse_adrift(self.body, self.held)

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
        K, floating = self._relative, self.floating
        with np.errstate(over="ignore", invalid="ignore"):  # the residual refuses what is infinite
            share = load / self._unit
            phi = self._found(given, share)
            if len(floating):
                raised = np.zeros(len(given))
                raised[floating] = 1.0
                unit = self._found(raised, np.zeros(len(given)))
                phi += (share - K @ phi)[floating].sum() / (K @ unit)[floating].sum() * unit
            residual = np.abs((K @ phi - share)[self._free]).max(initial=0.0)
            scale = (abs(K) @ np.abs(phi) + np.abs(share))[self._free].max(initial=0.0)
            found = Potential(self, phi, self._unit * (K @ phi - share))
            if not (residual <= RESIDUAL * scale and np.isfinite(found.energy)):
                raise SolverError(
                    f"potential: residual {residual:.3g} V against terms of {scale:.3g} V, energy "
                    f"{found.energy:.3g} J/m; the system is badly scaled, take less graded cells "
                    "and units in which potentials and permittivities are ordinary numbers"
                )
        return found

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

    def _found(self, given: Array, share: Array) -> Array:
        phi = given.copy()
        phi[self._free] = 0.0
        if len(self._free):
            phi[self._free] = self._factor((share - self._relative @ phi)[self._free])
        return phi

    def _nodal(self, name: str, values: ArrayLike) -> Array:
        array = finite(name, values)
        if array.shape != self.held.shape:
            raise ProblemError(f"{name}: shape {array.shape}; give {self.held.shape}, one a node")
        return array


@dataclass(frozen=True, eq=False)
class Potential:
    """A solution: potential at the nodes, and what follows from it.

    Parameters
    ----------
    medium
        What it solves.
    values
        (n,) potential at the nodes (V).
    charge
        (n,) charge of conductors by node, per depth (C/m): what the equations leave there, which
        is nothing at nodes of no conductor. Sum it over a conductor.
    """

    medium: Dielectric
    values: Array
    charge: Array

    def __post_init__(self) -> None:
        for array in (self.values, self.charge):
            array.setflags(write=False)

    @property
    def energy(self) -> float:
        """½∫ε|E|² per depth (J/m)."""
        return 0.5 * float(self.values @ (self.medium.stiffness @ self.values))

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
        return -gradient(self.medium.body, self.values[:, None], points)[:, 0]

    @cached_property
    def forces(self) -> Array:
        """Maxwell's forces (n, 2) on the nodes, per depth (N/m): -∫ T·∇φ_i.

        They are the derivative of the energy in the places of nodes, conductors at their voltages.
        On conductors and faces of dielectrics they are the pull on them; elsewhere they are what
        the discretisation leaves, which is little but at edges of electrodes.
        """
        body = self.medium.body
        slope, measure = slopes(body.basis)
        nodes = body.cell_nodes.T
        E = -np.einsum("kacq,kc->acq", slope, self.values[nodes])
        weight = self.medium.permittivity[:, None] * measure
        stress = weight * (E[:, None] * E - 0.5 * (E**2).sum(axis=0) * np.eye(2)[:, :, None, None])
        each = -np.einsum("abcq,kbcq->akc", stress, slope)
        return nodal_sums(nodes, each, len(body.points))


def solve_potential(
    points: ArrayLike,
    cells: ArrayLike,
    element: str,
    permittivity: ArrayLike,
    fixed: Iterable[tuple[int, float]],
) -> Potential:
    """Potential on a mesh given as arrays.

    Parameters
    ----------
    points, cells, element
        (n, 2) in m, (c, nodes) in VTK order, and a name as `solve` takes them.
    permittivity
        (c,) of the cells, absolute (F/m).
    fixed
        Rows (node, potential in V).

    Raises
    ------
    ProblemError
        If the mesh or a row is wrong, a permittivity is not above zero, or a part of the mesh holds
        no potential.
    SolverError
        If the solution fails its residual check.
    """
    body = discretise(points, cells, element)
    held, values = np.zeros(len(body.points), dtype=bool), np.zeros(len(body.points))
    if not isinstance(fixed, Iterable):
        raise ProblemError(f"fixed: {shown(fixed)}; give rows (node, potential)")
    for row in fixed:
        pair = finite(f"fixed row {shown(row)}", row)
        if pair.shape != (2,) or pair[0] != np.floor(pair[0]) or not 0 <= pair[0] < len(held):
            raise ProblemError(
                f"fixed: row {shown(row)}; give (node, potential), nodes run to {len(held) - 1}"
            )
        node = int(pair[0])
        if held[node] and values[node] != pair[1]:
            raise ProblemError(f"fixed: node {node} has two different potentials")
        held[node], values[node] = True, pair[1]
    return Dielectric(body, finite("permittivity", permittivity), held).solve(values)


def _refuse_adrift(body: Discretisation, held: Mask) -> None:
    """A part of the mesh in which no potential is held has any."""
    count, part = connected_components(body.links, directed=False)
    lost = np.setdiff1d(np.arange(count), part[held])
    if len(lost):
        place = body.points[part == lost[0]][0]
        raise ProblemError(
            f"potential: held nowhere in the part of the mesh around {place_name(place)} m; give a "
            "node of it a potential"
        )
