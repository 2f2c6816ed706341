"""A case: a problem, the springs that stand for it, and how the two are compared."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Literal

import numpy as np

from msvalidate.case.file.fracture import Fracture
from msvalidate.case.file.part_mesh import cuts_for, edge_lattice, straighten
from msvalidate.case.file.schema import QUANTITIES
from msvalidate.case.file.units import LENGTH, quantity_text
from msvalidate.problem import (
    Array,
    Box,
    Domain,
    Mesh,
    PointForce,
    Problem,
    ProblemError,
    Traction,
)
from msvalidate.problem.checks import (
    finite,
    finite_coordinates,
    finite_number,
    length_in_metres,
    positive_number,
    require_one_of,
    require_type,
    whole_number,
)
from msvalidate.problem.records import dataclass, field
from msvalidate.springs.constants.routes import check_route
from msvalidate.springs.lattice import Lattice, cut_lattice, fill
from msvalidate.springs.lattice.cut import joins_corners
from msvalidate.springs.lattice.pattern import Pattern
from msvalidate.springs.lattice.patterns import all_patterns
from reference_fem.effort import MEMORY

MESH_EDGES = "mesh edges"
"""The lattice that has a spring on each edge of the body's own mesh, cut on its own curves."""
EDGE_ROUTES = ("springs", "neo-Hookean")
"""Routes of springs along mesh edges.

They are unstressed, or zero-length springs under tension, which are elements.
"""
ACROSS = {2: 20, 3: 8}
"""Cells across the narrowest side where nothing is said, by the number of axes."""
MOST_CELLS = {2: 40_000, 3: 20_000}
"""Cells of a body up to which that is so: slender bodies have fewer across."""
MAX_REQUESTED = {2: 1_000_000, 3: 300_000}
"""Cells of a body that may be asked for: minutes, and some GB."""
LITTLE = 1.25
"""Largest factor by which the cell size may change to meet supports.

A requested number of cells is kept approximately.
"""
FITS = 4e-10
"""Relative tolerance with which whole cells fill a side of a box.

It is below half of the tolerance of `fill`.
"""
LAWS = {"st-venant-kirchhoff": "St Venant and Kirchhoff's", "neo-hookean": "the neo-Hookean"}
"""Laws of elements at large strain; all are the material's own at small strain."""
GEOMETRIES = ("linear", "nonlinear")
LINEAR_THEORY = ("", "requested", "frozen")
"""Who requests that a case is judged by linear theory, also out of its range: nobody, the case
itself, or the frozen set that it is of."""
BAND = 0.05
ACCURACY = 1e-3


@dataclass(frozen=True, eq=False)
class Case:
    """Comparison task: a problem, the lattice for the springs, and the comparison's settings.

    Parameters
    ----------
    problem
        Boundary value problem in d dimensions.
    lattice
        Name of a lattice, as in `patterns`, or "mesh edges". Default: "square" in 2D, "cubic18" in
        3D.
    spacing
        Side (m) of the lattice cells; for other than square or cubic cells, the length of a spring.
        For mesh edges, the approximate mean edge length; default: the file's own mesh.
    cells
        Number of cells across the narrowest side, instead of `spacing`. Default: 20 in 2D and 8 in
        3D, fewer in slender bodies, and up to almost twice as many in a box if whole cells then fit
        all its sides. For mesh edges the default is the file's own mesh.
    route
        "springs", "volume energy" or "neo-Hookean". Default: springs alone if they suffice,
        otherwise springs with a volume energy. Mesh edges take "springs", their default, or
        "neo-Hookean".
    constants, volume
        Spring constants, one per kind, and κ of the volume energy, instead of a route. Units: N/m,
        for 3D mesh edges Pa; κ in N/m in 2D and in Pa in 3D.
    points
        Points where displacements are compared: "lattice", "mesh" or coordinates (p, d) in m.
    quantities
        Compared quantities: "displacement", "reactions", "strain energy", "mean stress" and
        "point stress".
    band
        Largest relative difference that counts as agreement.
    accuracy
        Target relative error of the finite elements, from 1e-8 to 0.1.
    memory
        Memory (GB) for the finest 3D finite element mesh, from 0.1 to 1000.
    law
        Constitutive law of the elements at large strain: "st-venant-kirchhoff" or "neo-hookean".
    geometry
        "linear", or "nonlinear" to compare displacements at large displacement.
    linear_theory
        "", or "requested" or "frozen" to apply linear theory outside its range.
    fracture
        Criterion for breaking springs, if they break.
    notes
        Name -> remark that the report shows, such as the file.
    unit
        Unit of length in which results are shown, a key of `case.file.units.LENGTH`; values here
        stay in SI units.

    Raises
    ------
    ProblemError
        If a value is out of its range, or the lattice does not suit the body.

    Examples
    --------
    >>> from msvalidate import Box, Case, Isotropic, Problem, Support, Traction
    >>> box = Box((0.4, 0.1))
    >>> clamp = Support(box.side("left"), (0.0, 0.0))
    >>> pull = Traction(box.side("right"), (100.0, 0.0))
    >>> problem = Problem(box, Isotropic(E=1e5, nu=1 / 3), supports=(clamp,), loads=(pull,))
    >>> case = Case(problem, spacing=0.025)
    >>> case.lattice, case.band
    ('square', 0.05)
    """

    problem: Problem
    lattice: str | None = None
    spacing: float | None = None
    cells: int | None = None
    route: str | None = None
    constants: tuple[float, ...] | None = None
    volume: float = 0.0
    points: str | Array = "lattice"
    quantities: tuple[str, ...] = QUANTITIES
    band: float = BAND
    accuracy: float = ACCURACY
    memory: float = MEMORY
    law: str = "st-venant-kirchhoff"
    geometry: Literal["linear", "nonlinear"] = "linear"
    linear_theory: str = ""
    fracture: Fracture | None = None
    unit: str = "m"
    notes: Mapping[str, str] = field(default_factory=dict)
    """Name and text of the case's file, which the page shows."""

    def __post_init__(self) -> None:
        require_type("case: problem", self.problem, Problem)
        self._check_springs()
        self._check_comparison()

    def _check_springs(self) -> None:
        dim = self.problem.domain.dim
        if self.lattice is None:
            object.__setattr__(self, "lattice", "square" if dim == 2 else "cubic18")
        known = {name for name, make in all_patterns().items() if make().dim == dim}
        require_one_of("lattice", self.lattice, (*sorted(known), MESH_EDGES))
        self._check_spacing()
        if self.route is not None:
            if self.lattice == MESH_EDGES and self.route not in EDGE_ROUTES:
                springs, every = map(repr, EDGE_ROUTES)
                raise ProblemError(
                    f"route: {self.route!r} on {MESH_EDGES}; take {every}, or {springs} where the "
                    "ratio is theirs"
                )
            check_route(self.route)
        if self.constants is not None:
            self._check_constants(finite("constants", self.constants, "k"))
            if self.route is not None:
                raise ProblemError("constants and route: a route makes its own; give one of them")
        elif finite_number("volume", self.volume):
            raise ProblemError("volume: it goes with constants of springs; give these, or a route")

    def _check_constants(self, constants: Array) -> None:
        pattern = _pattern(self)
        if pattern is not None and len(constants) != pattern.kinds:
            raise ProblemError(
                f"constants: {len(constants)}; {self.lattice} has springs of {pattern.kinds} "
                "kinds, give one each"
            )
        low = float(constants.min())
        if low < 0:
            raise ProblemError(f"constants: {low:g} N/m; each must be 0 or more")

    def _check_spacing(self) -> None:
        if self.lattice == MESH_EDGES and not isinstance(self.problem.domain, Mesh):
            raise ProblemError(
                f"lattice {MESH_EDGES!r}: the body is a {self.problem.domain} and has none; give a "
                "mesh file, or another lattice"
            )
        if self.spacing is not None and self.cells is not None:
            raise ProblemError("spacing and cells: each tells the other; give one of them")
        if self.spacing is not None:
            length_in_metres("spacing", self.spacing)
        if self.cells is not None:
            whole_number("cells", self.cells, 1, 100_000)

    def _check_comparison(self) -> None:
        if isinstance(self.points, str):
            require_one_of("points", self.points, ("lattice", "mesh"))
            if self.points == "mesh" and not isinstance(self.problem.domain, Mesh):
                raise ProblemError(
                    f"points 'mesh': the body is a {self.problem.domain}; give points, or 'lattice'"
                )
        else:
            d = self.problem.domain.dim
            at = finite_coordinates("points", self.points, "p", d, need=f"give {d} numbers each")
            if not len(at):
                raise ProblemError("points: none; give at least one, or 'lattice'")
            object.__setattr__(self, "points", at)
        if not self.quantities:
            raise ProblemError(f"quantities: none; choose of {', '.join(QUANTITIES)}")
        for name in self.quantities:
            require_one_of("quantity", name, QUANTITIES)
        positive_number("band", self.band)
        require_one_of("law", self.law, LAWS)
        require_one_of("unit", self.unit, LENGTH)
        require_one_of("geometry", self.geometry, GEOMETRIES)
        require_one_of("linear theory", self.linear_theory, LINEAR_THEORY)
        if self.problem.contacts and self.geometry == "nonlinear":
            raise ProblemError(
                "geometry 'nonlinear': elements meet obstacles to first order; take 'linear', or "
                "`springs.statics.contact.solve_contact` for springs alone"
            )
        if self.fracture and (self.problem.contacts or self.geometry == "nonlinear"):
            raise ProblemError(
                "fracture: with an obstacle or geometry 'nonlinear'; springs break to first order "
                "under loads that are raised together: leave one of them out"
            )
        finite_number("accuracy", self.accuracy, least=1e-8, most=0.1)
        finite_number("memory", self.memory, least=0.1, most=1000.0)

    @property
    def are_elements(self) -> bool:
        """Return True if the springs are elements on the body's own mesh."""
        return self.lattice == MESH_EDGES and self.route == EDGE_ROUTES[1]

    @property
    def at_rest_on_edges(self) -> bool:
        """Return True for unstressed springs on mesh edges.

        They have the material on some meshes only.
        """
        return self.lattice == MESH_EDGES and not self.are_elements

    @property
    def name(self) -> str:
        """The problem's name."""
        return self.problem.name


def spacing_of(case: Case) -> float:
    """Spacing (m) of the lattice that a case asks for.

    Where it is told by cells, the nearest one whose lines run through all supports; through their
    ends inside a box's sides too, where that takes little. Of mesh edges the nearest mean length
    that halving the file's cells leads to.
    """
    domain = case.problem.domain
    if case.lattice == MESH_EDGES and isinstance(domain, Mesh):
        by_cells = spacing_by_cells(case) if case.cells else domain.mean_edge
        return float(domain.mean_edge / 2 ** cuts_for(domain, case.spacing or by_cells))
    if case.spacing is not None:
        return float(case.spacing)
    asked, pattern = spacing_by_cells(case), _pattern(case)
    if pattern is None or not joins_corners(pattern):
        return asked
    on, ends = _support_lines(case.problem)
    for lengths in (np.append(on, ends), on):
        if not len(lengths):
            break
        cells = lengths.min() / asked
        many = np.arange(math.ceil(cells / LITTLE), cells * LITTLE + 1)
        tried = np.append(asked, lengths.min() / many)
        missed = np.abs(lengths[:, None] - tried * np.rint(lengths[:, None] / tried))
        tried = tried[(missed <= case.problem.domain.tolerance).all(axis=0)]
        if len(tried):
            return float(tried[np.abs(np.log(tried / asked)).argmin()])
    return asked


def _support_lines(problem: Problem) -> tuple[Array, Array]:
    """Distances (m) of supports, and of their ends, from the lattice's origin.

    Only ends inside the sides of a box count.
    """
    span, room = np.array(problem.domain.span), problem.domain.tolerance
    base = np.append(_origin(problem), span[2:, 0])
    on, ends = [], []
    for support in problem.supports:
        corners = support.region.corners(problem.domain.span)
        flat = np.ptp(corners, axis=0) <= room
        on.append(np.abs(corners[0] - base)[flat])
        inside = ((corners > span[:, 0] + room) & (corners < span[:, 1] - room)) & ~flat
        ends.append(np.abs(corners - base)[inside & isinstance(problem.domain, Box)])
    lengths = np.concatenate([[], *on]), np.concatenate([[], *ends])
    return lengths[0][lengths[0] > room], lengths[1][lengths[1] > room]


def spacing_by_cells(case: Case) -> float:
    """Spacing (m) by the number of cells, the case's or the usual one."""
    domain, pattern = case.problem.domain, _pattern(case)
    cell = np.ones(domain.dim) if pattern is None else np.array(pattern.size)
    sides = np.array([high - low for low, high in domain.span])
    narrowest = float((sides / cell).min())
    if case.cells is not None:
        return narrowest / case.cells
    least: float = (domain.volume / cell.prod() / MOST_CELLS[domain.dim]) ** (1 / domain.dim)
    across = max(1, min(ACROSS[domain.dim], math.floor(narrowest / least)))
    if isinstance(domain, Box):  # a number that fits all sides, if there is one nearby
        for many in range(across, min(2 * across, across + 20)):
            if _divides(narrowest / many * cell, domain):
                return narrowest / many
    return narrowest / across


def make_lattice(case: Case, spacing: float) -> Lattice:
    """The lattice of a case at a spacing (m).

    A box whose sides, with what is held and loaded of them, are whole numbers of cells is filled;
    else the lattice is cut to the body's outline, its lines through the supports as far as one
    origin allows that. Raises `ProblemError` if the lattice cannot be laid into the body.
    """
    domain, pattern = case.problem.domain, _pattern(case)
    cells = domain.volume / spacing**domain.dim
    most = MAX_REQUESTED[domain.dim]
    if cells > most:
        raise ProblemError(
            f"spacing {quantity_text(spacing, 'm', case.unit)}: {cells:.3g} cells in the body, and "
            f"the most is {most:g}; take a larger one"
        )
    if pattern is None:
        return edge_lattice(laid_problem(case, spacing), rests=not case.are_elements)
    if isinstance(domain, Box) and is_filled(case, spacing):
        return fill(pattern, domain, _counts(spacing * np.array(pattern.size), domain))
    if not joins_corners(pattern):
        raise ProblemError(f"lattice {case.lattice}: {_misfit(pattern, spacing, domain)}")
    return cut_lattice(pattern, domain, spacing, origin=_origin(case.problem))


def laid_problem(case: Case, spacing: float) -> Problem:
    """Return the problem that springs of a spacing (m) solve.

    On mesh edges the body has the sides of the cut cells.
    """
    domain = case.problem.domain
    if case.lattice != MESH_EDGES or not isinstance(domain, Mesh):
        return case.problem
    return straighten(case.problem, cuts_for(domain, spacing))


def is_filled(case: Case, spacing: float) -> bool:
    """Return True if cells of a side (m) fill a case's body.

    Otherwise the lattice is cut to it.
    """
    domain, pattern = case.problem.domain, _pattern(case)
    if pattern is None or not isinstance(domain, Box):
        return False
    fits = _divides(spacing * np.array(pattern.size), domain)
    return fits and (not joins_corners(pattern) or _ends_on_lines(case.problem, spacing))


def _pattern(case: Case) -> Pattern | None:
    """Unit cell of the lattice; None for a mesh's edges."""
    return None if case.lattice == MESH_EDGES else all_patterns()[str(case.lattice)]()


def _misfit(pattern: Pattern, spacing: float, domain: Domain) -> str:
    """Why a lattice that cannot be cut does not go into a body, and what would."""
    makers = all_patterns().items()
    others = [name for name, make in makers if joins_corners(make()) and make().dim == domain.dim]
    listed = ", ".join(others)
    if not isinstance(domain, Box):
        return f"only {listed} can be cut to a {domain}; take one of these"
    cell = spacing * np.array(pattern.size)
    sides = np.maximum(_counts(cell, domain), 1) * cell
    return (
        f"cells of {' x '.join(f'{side:g}' for side in cell)} m do not fill the {domain}; give "
        f"a box of {' x '.join(f'{side:.12g}' for side in sides)} m, or a lattice that can be cut: "
        f"{listed}"
    )


def _counts(cell: Array, box: Box) -> tuple[int, ...]:
    return tuple(round(side / edge) for side, edge in zip(box.size, cell.tolist(), strict=True))


def _divides(cell: Array, box: Box) -> bool:
    """Return True if cells of sides (d,) in m fill a box."""
    return all(
        count >= 1 and abs(count * edge - side) <= FITS * side
        for count, edge, side in zip(_counts(cell, box), cell.tolist(), box.size, strict=True)
    )


def _ends_on_lines(problem: Problem, spacing: float) -> bool:
    """Return True if supports, tractions and point forces end on lattice lines."""
    parts = [each.region for each in problem.supports if each.region.is_facet]
    parts += [each.region for each in problem.loads if isinstance(each, Traction | PointForce)]
    span, room = problem.domain.span, problem.domain.tolerance
    ends = np.concatenate([part.corners(span) for part in parts] or [np.zeros((1, len(span)))])
    return bool((np.abs(ends - spacing * np.rint(ends / spacing)) <= room).all())


def _origin(problem: Problem) -> tuple[float, ...]:
    """A place on the flat supports, along each axis the first that has one; 0 along others."""
    domain = problem.domain
    at = [0.0] * domain.dim
    for axis in range(domain.dim):
        for support in problem.supports:
            corners = support.region.corners(domain.span)
            if np.ptp(corners[:, axis]) <= domain.tolerance:
                at[axis] = float(corners[0, axis])
                break
        else:
            at[axis] = domain.span[axis][0]
    return tuple(at[:2]) if domain.dim == 3 else tuple(at)
