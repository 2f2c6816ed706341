"""Springs of a case on finer and finer lattices: whether their error is of spacing or of kind.

At rest on three lattices of spacings h, h/2 and h/4 the displacements of springs that stand for the
material close in on elasticity with an order p, u_h = u + C h^p. What they close in on,

    u ≈ u_{h/4} + (u_{h/4} - u_{h/2}) / (2^p - 1),

tells a network that is only coarse from one that is another material, whatever its spacing. One p
serves all points: the 2-norm of what changes is smoother than each part.

Source: Richardson's extrapolation as in [Roache1994].
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from contextlib import suppress
from typing import Any, Literal

import numpy as np
from scipy.spatial import KDTree

from msvalidate.case.file.case import (
    MESH_EDGES,
    Case,
    laid_problem,
    make_lattice,
    spacing_by_cells,
    spacing_of,
)
from msvalidate.case.file.part_mesh import edge_lattice
from msvalidate.case.file.units import quantity_text
from msvalidate.linear_algebra.norms import max_abs
from msvalidate.problem import Array, Isotropic, Mask, Mesh, Problem, ProblemError, SolverError
from msvalidate.problem.checks import require_type
from msvalidate.problem.motions import format_point
from msvalidate.problem.progress import report_step
from msvalidate.problem.records import dataclass, replace
from msvalidate.problem.shapes import STRAIGHT, weights_at
from msvalidate.springs.bodies.cut_network import cut_network
from msvalidate.springs.bodies.lattice_network import lattice_network, touching_points
from msvalidate.springs.constants.calibration import Calibration
from msvalidate.springs.constants.routes import calibrate_by_route
from msvalidate.springs.constants.zones import OneOrEach, calibrate_zones
from msvalidate.springs.lattice import CutLattice, Lattice, PatternLattice
from msvalidate.springs.lattice.cut import cell_weights, joins_corners
from msvalidate.springs.lattice.edges import EdgeLattice
from msvalidate.springs.network import Body, Network, mode_energy
from msvalidate.springs.statics.breaking import FractureResult
from msvalidate.springs.statics.contact import ContactEquilibrium, solve_contact
from msvalidate.springs.statics.equilibrium import Equilibrium, equilibrium
from msvalidate.springs.statics.stress import cell_stress, cell_volume, point_stress

MOST_FINE = {2: 150_000, 3: 80_000}
"""Points of the finest lattice, by the number of axes, beyond which there is none so fine."""
SAFETY, CAUTION = 1.25, 3.0
"""Factors on what is left by an order that three lattices show, and where they show none."""
LOWEST_ORDER, HIGHEST_ORDER = 0.4, 3.0
"""Orders that are believed: corners bring them below 1, what is smooth to 2."""
UNEVEN = 1.5
"""Factor on the changes of lattices cut to an outline: their errors decrease unevenly."""
LEAST_BEARING = 2
"""Points under an obstacle that show its patch: one alone goes by the logarithm of the spacing."""
TRIED, MOST_OFFERED = 30, 1000
"""Numbers of cells that are tried where a lattice is refused, and the most across."""
ROUNDING = 1e-10
"""Relative rounding of a change of displacements, or of a whole cell."""


@dataclass(frozen=True, eq=False)
class SpringAnswer:
    """Springs of a case at rest on one lattice.

    Parameters
    ----------
    problem
        What was solved: of springs on a mesh's edges, on the mesh with its cells cut and straight.
    spacing
        Side (m) of the cells; of a spring on each edge of a mesh, the mean edge.
    lattice, network, rest
        The body, its springs and where they come to rest.
    calibration
        What the constants came from; None where they were given, or are those of a mesh's edges.
    seconds
        That it took.
    geometry
        "linear": at rest to first order in the displacement; "nonlinear": in full.
    contact
        With an obstacle, if there is one; its forces are among the network's loads.
    growth
        What breaks as the loads are raised, if that is asked.
    no_finer
        Spacing (m) of the next finer lattice and its error, if that lattice has no answer.
    """

    problem: Problem
    spacing: float
    lattice: Lattice
    network: Network
    rest: Equilibrium
    calibration: Calibration | None
    seconds: float
    geometry: str = "linear"
    contact: ContactEquilibrium | None = None
    growth: FractureResult | None = None
    no_finer: tuple[float, str] | None = None

    def at(self, places: Array) -> Array:
        """Displacement (p, d) in m at places (p, d): at its own points exactly, else interpolated.

        Raises
        ------
        ProblemError
            If a place is none of the points, and the lattice has no square or cubic cells.
        """
        tree = KDTree(self.lattice.points)
        distance, point = tree.query(places)
        own = distance <= self.lattice.domain.tolerance
        found = self.rest.displacement[point]
        if not own.all():
            found[~own] = self._between(places[~own])
        return np.asarray(found)

    def _between(self, places: Array) -> Array:
        lattice = self.lattice
        if isinstance(lattice, EdgeLattice):
            x, room = lattice.points[lattice.cells], lattice.domain.tolerance
            cell, weights = weights_at(STRAIGHT[x.shape[:0:-1]], x, places, room)
            if cell.min() < 0:
                raise ProblemError(
                    f"springs on the mesh: place {format_point(places[cell.argmin()])} m is in "
                    "none of its straight cells; take a smaller spacing, or a place further inside"
                )
            moved = self.rest.displacement[lattice.cells[cell]]
            return np.asarray(np.einsum("pc,pcd->pd", weights, moved))
        if not isinstance(lattice, PatternLattice) or not joins_corners(lattice.pattern):
            raise ProblemError(
                f"springs on {lattice.name}: no displacement between points; compare at points "
                "'lattice', or take a square or cubic lattice"
            )
        points, weights = cell_weights(lattice.points, lattice.cells, lattice.spacing, places)
        return np.asarray(np.einsum("pc,pcd->pd", weights, self.rest.displacement[points]))

    @property
    def energy(self) -> float:
        """Strain energy (J)."""
        return mode_energy(self.network, self.network.points, self.rest.displacement) / 2

    def reaction(self, held: Mask) -> Array:
        """Force (d,) in N of a support that holds components (n, d) of points."""
        return np.asarray(np.where(held, self.rest.reaction, 0.0).sum(axis=0))

    def mean_stress(self, thickness: float) -> Array:
        """Mean stress (3,) or (6,) in Pa over the body's volume."""
        stress = cell_stress(self.network, self.lattice, self.rest, thickness=thickness)
        return np.asarray(np.average(stress, axis=0, weights=cell_volume(self.lattice)))

    def point_stress(self, thickness: float) -> Array:
        """Stress (n, 3) or (n, 6) in Pa at the lattice's points: of the cells around each.

        What springs and volumes of cells carry themselves; second order in the spacing at points
        that are `surrounded`. Raises `ProblemError` as `springs.statics.stress.cell_stress` does.
        """
        stress = cell_stress(self.network, self.lattice, self.rest, thickness=thickness)
        return point_stress(self.lattice, stress)

    @property
    def surrounded(self) -> Mask:
        """Points (n,) with cells of the pattern all around them, none of them cut."""
        lattice, corners = self.lattice, self.lattice.cells.shape[1]
        whole = lattice.cells
        if isinstance(lattice, CutLattice):
            whole = whole[lattice.fraction >= 1 - ROUNDING]
        return np.asarray(np.bincount(whole.ravel(), minlength=len(lattice.points)) == corners)


@dataclass(frozen=True, eq=False)
class Extrapolation:
    """Limit of the displacements of springs as their spacing shrinks.

    Parameters
    ----------
    displacement
        (p, d) in m at the compared points.
    uncertainty
        How far (m) any of them may be from there.
    order
        Of the spacing, as three lattices show it; NaN where they show none, as against obstacles.
    """

    displacement: Array
    uncertainty: float
    order: float = math.nan


def solve_springs(case: Case, spacing: float) -> SpringAnswer:
    """Springs of a case at rest on a lattice of a spacing (m).

    Raises
    ------
    ProblemError
        If the lattice is none for the body, material, supports or loads.
    SolverError
        If there is no trustworthy answer.
    """
    began = time.perf_counter()
    contacts = case.problem.contacts
    bare = replace(case, problem=replace(case.problem, contacts=())) if contacts else case
    problem, lattice, network, calibration = make_network(bare, spacing)
    length = quantity_text(spacing, "m", case.unit)
    counts = (f"{len(lattice.cells):,}", f"{len(network.springs):,}")
    report_step("lattice %s, spacing %s, %s cells, %s springs", case.lattice, length, *counts)
    if contacts:
        problem = laid_problem(case, spacing)
        network = replace(network, body=Body(problem, lattice, calibration))
    rest, contact = solve_network(network, case.geometry)
    if contact:
        network = replace(network, force=network.force + contact.load)
    if case.lattice == MESH_EDGES:
        spacing = problem.domain.mean_edge  # type: ignore[union-attr]
    seconds = time.perf_counter() - began
    made = (lattice, network, rest, calibration, seconds, case.geometry, contact)
    return SpringAnswer(problem, spacing, *made)


def solve_network(
    network: Network, geometry: Literal["linear", "nonlinear"] = "linear", **options: Any
) -> tuple[Equilibrium, ContactEquilibrium | None]:
    """Equilibrium of a network, with the contact if its problem has an obstacle.

    The options are those of `equilibrium`. Raises `ProblemError` for unknown options, and for any
    with an obstacle.
    """
    require_type("network", network, Network)
    known = ("path", "start", "allow_folded", "solver")
    for name in options.keys() - set(known):
        raise ProblemError(
            f"solve: option {name!r}; choose {', '.join(known)}, or geometry='nonlinear' for large "
            "displacements"
        )
    body = network.body
    if body is None or not body.problem.contacts:
        return equilibrium(network, geometry, **options), None
    if options or geometry == "nonlinear":
        raise ProblemError("solve: springs meet an obstacle to first order; leave options out")
    try:
        contact = solve_contact(network, touching_points(body.problem, body.lattice))
    except SolverError:
        body.problem.refuse_slight_force()
        raise
    return contact.equilibrium, contact


def make_network(
    case: Case, spacing: float
) -> tuple[Problem, Lattice, Network, Calibration | None]:
    """Problem, lattice, network and calibration of springs of a spacing (m).

    Raises `ProblemError` as `solve_springs`.
    """
    problem = laid_problem(case, spacing)
    edges = case.lattice == MESH_EDGES
    lattice = (
        edge_lattice(problem, rests=not case.are_elements) if edges else make_lattice(case, spacing)
    )
    constants, calibration = _constants(case, lattice)
    volume = case.volume if case.constants is not None else 0.0
    build = cut_network if isinstance(lattice, CutLattice) else lattice_network
    network = build(problem, lattice, constants, volume=volume)  # type: ignore[arg-type]
    return problem, lattice, network, calibration


def _constants(case: Case, lattice: Lattice) -> tuple[OneOrEach | None, Calibration | None]:
    """Constants of a network, and their calibration, if there is one."""
    if case.problem.zones:
        if case.constants is not None or case.at_rest_on_edges:
            what = "constants" if case.constants is not None else "springs on mesh edges"
            raise ProblemError(
                f"{what}: the body is of several materials; take a route, and for a mesh's edges "
                "route 'neo-Hookean'"
            )
        each = calibrate_zones(case.problem, lattice, route=case.route)
        return each, each[0]
    if case.constants is not None:
        return case.constants, None
    if case.at_rest_on_edges:
        return None, None
    material = case.problem.material
    if not isinstance(material, Isotropic):
        raise ProblemError("springs: the material is a tensor; give their constants")
    found = calibrate_by_route(material, lattice, None, case.route)
    return found, found


def solve_finer(case: Case) -> tuple[SpringAnswer, ...]:
    """Springs as asked, then on lattices twice and four times as fine, as far as they are few."""
    asked = spacing_of(case)
    try:
        first = solve_springs(case, asked)
    except ProblemError as error:
        raise ProblemError(f"{error}{_offer_cells(case)}") from error
    dim, points = case.problem.domain.dim, len(first.lattice.points)
    found = [first]
    for times in (2, 4):
        if points * times**dim > MOST_FINE[dim]:
            break
        try:
            found.append(solve_springs(case, asked / times))
        except (ProblemError, SolverError) as error:  # the limit is read from fewer lattices
            found[-1] = replace(found[-1], no_finer=(asked / times, str(error)))
            break
    return tuple(found)


def _offer_cells(case: Case) -> str:
    """The number of cells nearest to what is asked with which a lattice can be laid, tried."""
    if case.lattice == MESH_EDGES:
        return ""
    for other in at_other_cells(case, spacing_of(case)):
        spacing = spacing_of(other)
        with suppress(ProblemError):
            make_network(other, spacing)
            size = quantity_text(spacing, "m", case.unit)
            return f"; give cells = {other.cells} (spacing {size}) in its place"
    return ""


def at_other_cells(case: Case, wanted: float) -> Iterator[Case]:
    """The case at numbers of cells, from the one that is nearest to a spacing (m) on."""
    one = spacing_by_cells(replace(case, cells=1, spacing=None)) / wanted
    numbers = sorted(range(1, MOST_OFFERED + 1), key=lambda n: abs(math.log(n / one)))
    for cells in numbers[:TRIED]:
        yield replace(case, cells=cells, spacing=None)


def compared_points(case: Case, lattice: Lattice | None = None) -> Array:
    """Places (p, d) in m at which a case compares, all of them in the body.

    Those of a lattice, where the case says no others: by default of the case's own.
    """
    if not isinstance(case.points, str):
        return case.points
    if case.points == "mesh" and isinstance(case.problem.domain, Mesh):
        return np.asarray(case.problem.domain.points)
    laid = make_lattice(case, spacing_of(case)) if lattice is None else lattice
    if isinstance(laid, CutLattice):
        return np.asarray(laid.points[laid.inside])
    return np.asarray(laid.points)


def displacements_at(answers: tuple[SpringAnswer, ...], places: Array) -> tuple[list[Array], str]:
    """Displacement (p, d) in m at places of each lattice, up to a finer one that has none there.

    The text is the reason why a finer one has none; empty if all have them.
    """
    found = [answers[0].at(places)]
    try:
        for answer in answers[1:]:
            found.append(answer.at(places))
    except ProblemError as error:  # of cells that are no squares or cubes: no point there
        return found, str(error)
    return found, ""


def extrapolate(answers: tuple[SpringAnswer, ...], values: list[Array]) -> Extrapolation:
    """Extrapolate displacements (p, d) in m from one to three lattices."""
    fine = values[-1]
    if len(values) == 1:
        return Extrapolation(fine, math.inf)
    last = fine - values[-2]
    size, change = max_abs(fine), max_abs(last)
    if change <= ROUNDING * size:
        return Extrapolation(fine, max(change, ROUNDING * size))
    if contact := answers[-1].contact:
        # A patch ends between two points, elsewhere on each lattice: changes show no order.
        before = max_abs(values[1] - values[0]) / 2
        bears = all((one.force > 0).sum() >= LEAST_BEARING for one in contact.contacts)
        return Extrapolation(fine, CAUTION * max(change, before) if bears else max(size, change))
    if len(values) == 2:  # as if the order were 1
        return Extrapolation(fine + last, CAUTION * change)
    first = values[1] - values[0]
    before = max(max_abs(first), ROUNDING * size)
    order = float(np.log2(max(float(np.linalg.norm(first)), before) / np.linalg.norm(last)))
    if not LOWEST_ORDER <= order <= HIGHEST_ORDER:
        # Changes that grow may grow as much again: the body is not resolved yet.
        return Extrapolation(fine, CAUTION * max(change**2 / before, before))
    left = last / (2 ** min(order, 2.0) - 1)
    uncertainty = SAFETY * max_abs(left)
    if isinstance(answers[-1].lattice, CutLattice):
        # An outline cuts the cells of each lattice differently, so the last change may be small by
        # chance. The cut's error is of first order: half the change before bounds it as well.
        uncertainty = max(uncertainty, UNEVEN * max(change, before / 2))
    return Extrapolation(fine + left, uncertainty, order)
