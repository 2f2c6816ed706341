"""High-level functions: from a body to springs and elements; they choose the defaults.

`compare` is in `case.report.solutions`, `plot` in `case.report.body_plot`, `animate` in
`bench.output.animation`, `run` in `bench.judging.sweep`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Literal

from msvalidate.case.file.case import ACCURACY, Case, spacing_of
from msvalidate.case.report.solutions import ElementSolution, SpringSolution, solve_elements
from msvalidate.case.springs.lattice_springs import make_network, solve_network
from msvalidate.problem import (
    Domain,
    Isotropic,
    Material,
    Part,
    PointForce,
    Problem,
    ProblemError,
    Support,
    Traction,
    Weight,
)
from msvalidate.problem.checks import format_value
from msvalidate.problem.loads import as_tuple
from msvalidate.problem.records import replace
from msvalidate.springs.network import Network

Geometry = Literal["linear", "nonlinear"]


def body(
    domain: Domain,
    material: Material,
    *,
    fixed: str | Part | Sequence[str | Part] | Mapping[str | Part, Any] = (),
    traction: Mapping[str | Part, Sequence[float]] | None = None,
    force: Mapping[tuple[float, ...], Sequence[float]] | None = None,
    gravity: Sequence[float] | None = None,
) -> Problem:
    """Return the boundary value problem of a body with named sides.

    Parameters
    ----------
    domain, material
        Body and its material. The material of a 3D body is a solid whatever its 2D state.
    fixed
        Clamped sides, by name or as a `Region` or `Segment`; or side -> prescribed displacement
        (m), with None for a free component (Dirichlet boundary conditions).
    traction, force, gravity
        Side -> force per area (Pa), a Neumann boundary condition; point (m) -> force (N);
        acceleration (m/s²) that acts on the density. Each has d components.

    Raises
    ------
    ProblemError
        If a side does not exist, or a value does not fit the domain.

    Examples
    --------
    >>> import msvalidate as ms
    >>> steel = ms.Isotropic(E=210e9, nu=0.3, thickness=0.2)
    >>> problem = ms.body(ms.Box(0.37, 0.2), steel, fixed="left", traction={"right": (1e6, 0)})
    """
    for name, value in (("traction", traction or {}), ("force", force or {})):
        if not isinstance(value, Mapping):
            example = {"traction": '{"right": (0, -10)}', "force": "{(4, 0.5): (0, -10)}"}[name]
            raise ProblemError(f"{name}: {format_value(value)}; give a mapping, such as {example}")
    names = [fixed] if isinstance(fixed, str | Part) else fixed
    if not isinstance(names, Iterable):
        raise ProblemError(f'fixed: {format_value(fixed)}; give sides, such as "left"')
    each = names if isinstance(names, Mapping) else dict.fromkeys(names, 0.0)
    loads = [Traction(side, value) for side, value in (traction or {}).items()]
    points = [PointForce(at, as_tuple(value)) for at, value in (force or {}).items()]
    weight = [] if gravity is None else [Weight(as_tuple(gravity))]
    if getattr(domain, "dim", 2) == 3 and isinstance(material, Isotropic):
        material = replace(material, state="solid")
    supports = tuple(Support(side, value) for side, value in each.items())
    return Problem(domain, material, supports, (*loads, *points, *weight))


def build(
    problem: Problem,
    lattice: str | None = None,
    *,
    cells: int | None = None,
    spacing: float | None = None,
    route: str | None = None,
    constants: tuple[float, ...] | None = None,
) -> Network:
    """Build the springs of a problem on a lattice, calibrated to its material.

    Parameters
    ----------
    problem
        Boundary value problem.
    lattice
        Name of a lattice of `patterns`, or "mesh edges". Default: "square" in 2D, "cubic18" in 3D.
    cells, spacing
        Number of cells across the narrowest side, or the cell size (m); see `Case`.
    route, constants
        "springs", "volume energy" or "neo-Hookean"; default: springs alone if they suffice,
        otherwise with a volume energy. Or spring constants per kind (N/m; Pa for 3D mesh edges).

    Returns
    -------
    Network
        Its field ``body`` has the lattice and the calibration, which ``print(network)`` reports.

    Raises
    ------
    ProblemError
        If the lattice does not suit body or material.

    Examples
    --------
    >>> import msvalidate as ms
    >>> problem = ms.body(ms.Box(4, 1), ms.Isotropic(E=1e5, nu=0.3), fixed="left")
    >>> network = ms.build(problem, "square", cells=8)
    >>> network.body.constants.route
    'volume energy'
    """
    case = Case(problem, lattice, spacing, cells, route, constants)
    bare = replace(case, problem=replace(problem, contacts=()))
    _, _, network, _ = make_network(bare, spacing_of(bare))
    if problem.contacts and network.body:
        network = replace(network, body=network.body._replace(problem=problem))
    return network


def solve(
    network: Network | Problem,
    geometry: Geometry = "linear",
    **options: Any,
) -> SpringSolution:
    """Compute the static equilibrium of springs, with energy, stress, table and plot.

    Parameters
    ----------
    network
        Network, or a problem, whose default network is built.
    geometry
        "linear" for small displacements, or "nonlinear".
    options
        Options of `springs.statics.equilibrium.equilibrium`: path, start, allow_folded, solver.

    Raises
    ------
    ProblemError, SolverError
        As for that function.

    Examples
    --------
    >>> import msvalidate as ms
    >>> rubber = ms.Isotropic(E=1e5, nu=0.3)
    >>> problem = ms.body(ms.Box(0.4, 0.1), rubber, fixed="left", gravity=(0, -9.81))
    >>> springs = ms.solve(ms.build(problem, cells=4))
    >>> springs.displacement.shape, springs.stress.shape
    ((85, 2), (85, 3))
    """
    network = build(network) if isinstance(network, Problem) else network
    solved, contact = solve_network(network, geometry, **options)
    return SpringSolution(**vars(solved), network=network, geometry=geometry, contact=contact)


equilibrium = solve  # the name by which the functions of the long way call it


def reference(
    problem: Problem, rtol: float = ACCURACY, geometry: Geometry = "linear"
) -> ElementSolution:
    """Solve a problem by scikit-fem elements, refined until their error is small.

    Source: Richardson extrapolation over meshes, each twice as fine as the last [Roache1994].

    Parameters
    ----------
    problem
        Boundary value problem.
    rtol
        Requested error of displacements relative to the largest, 1e-8 to 0.1.
    geometry
        "linear", or "nonlinear" for the law of St. Venant and Kirchhoff at large displacement.

    Returns
    -------
    ElementSolution
        Displacement (m) at the nodes of the coarsest mesh, with the error that was reached.

    Raises
    ------
    ProblemError, SolverError
        If there is no solution, or none is found.

    Examples
    --------
    >>> import msvalidate as ms
    >>> rubber = ms.Isotropic(E=1e5, nu=0.3)
    >>> problem = ms.body(ms.Box(0.4, 0.1), rubber, fixed="left", gravity=(0, -9.81))
    >>> elements = ms.reference(problem, rtol=1e-2)
    >>> elements.error < 1e-2
    True
    """
    case = Case(problem, accuracy=rtol, geometry=geometry, quantities=("displacement",))
    return solve_elements(case)
