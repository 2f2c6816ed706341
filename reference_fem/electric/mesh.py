"""The mesh of a slab and the air around it, and how it moves with the slab."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import numpy as np
from scipy.sparse import csr_matrix

from msvalidate.problem import Array, Index, Mask, ProblemError, SolverError, format_point
from msvalidate.problem.checks import (
    finite_coordinates,
    finite_number,
    positive_number,
    require_one_of,
    require_type,
    shaped,
    whole_number,
)
from msvalidate.problem.records import dataclass, replace
from reference_fem.electric.laplacian import scalar_factor, weighted_laplacian
from reference_fem.electric.lines import mesh_lines
from reference_fem.electric.slab import Slab
from reference_fem.mesh.boxes import lines_discretisation
from reference_fem.mesh.discretisation import COINCIDENT, Discretisation, make_discretisation
from reference_fem.mesh.elements import ELEMENTS, of_dimension

REACH = 30.0
"""Distance of the far boundary, in longer sides of the slab, unless given."""
GRADING = 3.0
"""Exponent of the spacing at edges of electrodes and corners, unless given."""


@dataclass(frozen=True, eq=False)
class SlabMesh:
    """Slab and air, meshed; the numbers of nodes stay as they are when the nodes move.

    Parameters
    ----------
    slab
        The question.
    body
        The mesh of slab and air.
    inside
        (c,) cells of the slab.
    nodes
        (m,) nodes of the slab, rising; arrays of the slab (m, ...) are in their order.
    base
        (m,) those of them on the bottom.
    conductors
        Nodes of each electrode.
    tips
        (t,) node of each end of each electrode.
    far
        Nodes of the far boundary.
    """

    slab: Slab
    body: Discretisation
    inside: Mask
    nodes: Index
    base: Mask
    conductors: tuple[Index, ...]
    tips: Index
    far: Index

    def __post_init__(self) -> None:
        arrays = (self.inside, self.nodes, self.base, *self.conductors, self.tips, self.far)
        for array in arrays:
            array.setflags(write=False)

    @property
    def permittivity(self) -> Array:
        """(c,) of the cells (F/m)."""
        return np.where(self.inside, self.slab.permittivity, self.slab.air)

    @cached_property
    def solid(self) -> Discretisation:
        """The slab alone, its nodes in the order of `nodes`."""
        cells = np.searchsorted(self.nodes, self.body.cells[self.inside])
        return make_discretisation(self.body.points[self.nodes], cells, self.body.element.name)

    @cached_property
    def air(self) -> Index:
        """Nodes (a,) of the air that are free to move with the slab: not on the far boundary."""
        others = np.setdiff1d(np.arange(len(self.body.points)), self.nodes)
        return np.setdiff1d(others, self.far)

    def carried(self, forces: Array) -> Array:
        """Forces (m, 2) on the slab that do the work of forces (n, 2) on all nodes (N/m).

        The air's nodes follow the slab as in `move_air`, so what acts on them acts on it: the
        transpose of that motion. Maxwell's forces so carried are the derivative of the energy in
        the slab's places, to rounding, whatever the mesh.

        Raises
        ------
        ProblemError
            If the forces are not two components for each node of the mesh.
        """
        shaped("forces on all nodes", np.asarray(forces), *self.body.points.shape)
        passed = self._follow.factor(forces[self.air])
        return np.asarray(forces[self.nodes] - self._follow.link.T @ passed)

    @cached_property
    def _follow(self) -> _Follow:
        # Small cells are made stiff, so that those at edges of electrodes keep their shape.
        K = weighted_laplacian(self.body, 1 / self.body.basis.dx.sum(axis=1))
        factor = scalar_factor(self.body, K, self.air)
        return _Follow(
            factor.solve,
            K[self.air][:, self.nodes],
        )


def slab_mesh(
    slab: Slab,
    layers: int,
    *,
    element: str = "Q2",
    grading: float = GRADING,
    reach: float | None = None,
) -> SlabMesh:
    """Structured mesh of quadrilaterals of a slab and its air.

    Parameters
    ----------
    slab
        The question.
    layers
        Cells up the slab's height, an even number. All spacings go with it, so that meshes of 10,
        20 and 40 layers are one family.
    element
        Of quadrilaterals: "Q1", "Q2" and so on.
    grading
        1 spaces lines near edges and corners evenly; g > 1 as s^g. Meshes that shall be moved far
        need a mild one.
    reach
        Distance (m) from the slab to the far boundary; 30 of its longer sides by default.

    Raises
    ------
    ProblemError
        If an argument is out of range, or the far boundary is nearer than the slab's height.
    """
    require_type("slab", slab, Slab)
    require_one_of(
        "element", element, [name for name in of_dimension(2) if not ELEMENTS[name].simplex]
    )
    half, odd = divmod(whole_number("layers", layers, 2), 2)
    if odd:
        raise ProblemError(f"layers: {layers}; give an even number, graded to both faces")
    if positive_number("mesh grading", grading) < 1:
        raise ProblemError(f"mesh grading: {grading}; it must be 1 or more")
    far = REACH * max(slab.length, slab.height) if reach is None else finite_number("reach", reach)
    if far < slab.height:
        where = "inside the slab" if far <= 0 else "too near"
        raise ProblemError(
            f"far boundary: {far:g} m from the slab is {where}; give several of its lengths, such "
            f"as {REACH * max(slab.length, slab.height):g} m"
        )
    lines = mesh_lines(slab, half, grading, far)
    closest = min(float(np.diff(line).min()) for line in lines) / ELEMENTS[element].degree
    told = COINCIDENT * max(float(np.ptp(line)) for line in lines)
    if closest <= 2 * told:
        raise ProblemError(
            f"mesh of the slab: nodes {closest:.2g} m apart, and places are told apart from "
            f"{told:.2g} m on; take less grading, fewer layers, a nearer far boundary, or move "
            "ends of electrodes apart"
        )
    return _mark_nodes(slab, lines_discretisation(lines, element))


def move_air(mesh: SlabMesh, displacement: Array) -> SlabMesh:
    """The mesh with the slab's nodes displaced and the air's carried along.

    Each component of the air's motion is harmonic with the inverse of cells' areas as weight; the
    far boundary stays.

    Parameters
    ----------
    mesh
        Where displacements are counted from.
    displacement
        (m, 2) of the slab's nodes (m).

    Raises
    ------
    ProblemError
        If the displacement is of another shape, or not finite.
    SolverError
        If a cell is turned inside out.
    """
    require_type("mesh", mesh, SlabMesh)
    u = finite_coordinates("displacement of the slab", displacement, len(mesh.nodes), 2)
    points = mesh.body.points.copy()
    points[mesh.nodes] += u
    points[mesh.air] -= mesh._follow.factor(mesh._follow.link @ u)
    try:
        body = make_discretisation(points, mesh.body.cells, mesh.body.element.name)
    except ProblemError as error:
        raise SolverError(_orient_outline(mesh, points, u)) from error
    return replace(mesh, body=body)


def _orient_outline(mesh: SlabMesh, points: Array, u: Array) -> str:
    """Describe the inverted cell under a displacement (m, 2), and a remedy."""
    kind, cells = mesh.body.element, mesh.body.cells
    swelling = mesh.body.swelling(points)
    if (swelling[mesh.inside] <= 0).any():  # the air only follows
        swelling[~mesh.inside] = np.inf
    worst = int(swelling.argmin())
    where = mesh.body.points[cells[worst, : kind.corners]].mean(axis=0)
    part = "the slab" if mesh.inside[worst] else "the air"
    return (
        f"moved mesh: a displacement of up to {np.abs(u).max():.3g} m turns the cell of {part} "
        f"around {format_point(where)} m inside out; take a smaller step or a less graded mesh"
    )


@dataclass(frozen=True, eq=False)
class _Follow:
    """Motion of the air mesh with the slab: K_aa u_a = -K_as u_s.

    `link` is K_as.
    """

    factor: Callable[[Array], Array]
    link: csr_matrix


def _mark_nodes(slab: Slab, body: Discretisation) -> SlabMesh:
    """The mesh with its parts found by their places."""
    x, y = body.points.T
    near = slab.tolerance
    middle = body.points[body.cells[:, : body.element.corners]].mean(axis=1)
    inside = (middle > 0).all(axis=1) & (middle < (slab.length, slab.height)).all(axis=1)
    nodes = np.unique(body.cells[inside])
    conductors, tips = [], []
    for electrode in slab.electrodes:
        on = np.abs(y - slab.level(electrode.side)) <= near
        on &= (x >= electrode.start - near) & (x <= electrode.end + near)
        found = np.flatnonzero(on)
        conductors.append(found)
        tips += [found[x[found].argmin()], found[x[found].argmax()]]
    low, high = body.points.min(axis=0), body.points.max(axis=0)
    far = np.flatnonzero(((body.points == low) | (body.points == high)).any(axis=1))
    base = np.abs(y[nodes]) <= near
    return SlabMesh(slab, body, inside, nodes, base, tuple(conductors), np.array(tips), far)
