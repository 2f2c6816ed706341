"""From a case to what a simulator is asked: a mesh of linear cells, masses, forces, supports.

A mesh file's quadratic cells become linear ones between their corners. Loads are integrated over
the cells that the file has, bent sides too, and what goes to a mid-side then goes to the corners
in the shares of a linear field: on straight sides these are the linear cells' own consistent
forces, on bent ones force and moment stay those of the true side.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from msvalidate.case.advise.nearest_ratio import change_by_ratio
from msvalidate.case.file.case import Case, spacing_of
from msvalidate.case.springs.lattice_springs import SpringAnswer, make_network, solve_springs
from msvalidate.case.springs.network_files import SHAPE_OF
from msvalidate.problem import (
    SHAPES,
    Array,
    Box,
    Index,
    Isotropic,
    Material,
    Mesh,
    Polygon,
    Problem,
    ProblemError,
    Weight,
    prescribed_displacements,
)
from msvalidate.problem.checks import format_value, require_one_of, whole_number
from msvalidate.simulators.exchange.lammps import lammps_files
from msvalidate.simulators.exchange.protocol import Request, Springs
from msvalidate.springs.constants.homogenise import deforms_affinely
from msvalidate.springs.constants.stiffness import ALIKE, NEAR_RATIO, springs_ratio
from msvalidate.springs.lattice import Lattice
from msvalidate.springs.lattice.patterns import all_patterns
from msvalidate.springs.network import Network
from reference_fem.body import nodal_forces
from reference_fem.elasticity import solve_on
from reference_fem.first_mesh import first_mesh, grid_lines, kept_places
from reference_fem.mesh.boxes import lines_discretisation
from reference_fem.mesh.discretisation import Discretisation
from reference_fem.mesh.elements import of_shape
from reference_fem.mesh.from_mesh import mesh_discretisation
from reference_fem.mesh.outlines import outline_discretisation
from reference_fem.mesh.subdivide import subdivide

CELLS = {2: ("triangle", "quad"), 3: ("tetra", "hexahedron")}
"""Shapes of linear cells by the number of axes; the first is taken where none is asked for."""
ACROSS = 8
"""Cells across the narrowest side of a box or an outline where nothing is said."""
MOST_HALVINGS = 6


def export_case(
    case: Case,
    *,
    cells: int | None = None,
    shape: str | None = None,
    springs: bool = False,
    settings: Mapping[str, Any] | None = None,
) -> Request:
    """Make the request for the equilibrium of a case.

    Parameters
    ----------
    case
        A body of one isotropic material.
    cells
        Across the narrowest side of a box or an outline, by default `ACROSS`. A mesh file's own
        cells are kept, or halved until their mean edge is that small.
    shape
        Of the cells: see `CELLS`. A mesh file has its own.
    springs
        Give the network that stands for the case too: nodes are its points, on its own lattice;
        its ratio is that of springs alone, and the case's within `NEAR_RATIO` of it.
    settings
        Of the simulator, by its own names.

    Raises
    ------
    ProblemError
        If the material has a tensor or zones, the body cannot have such cells, a support or load
        does not meet them, or the network is more than springs.
    """
    problem = case.problem
    if not isinstance(problem.material, Isotropic) or problem.zones:
        what = "several materials" if problem.zones else "a material given by its tensor"
        raise ProblemError(f"export: {what}; simulators are asked for one isotropic material")
    if cells is not None:
        whole_number("--cells", cells, 1, 100_000)
    if springs:
        return _spring_request(case, cells, shape, settings or {})
    require_one_of("--shape", shape or CELLS[problem.domain.dim][0], CELLS[problem.domain.dim])
    return replace(request_on(problem, _lay_cells(problem, cells, shape)), settings=settings or {})


def request_on(problem: Problem, body: Discretisation) -> Request:
    """Request for the equilibrium of a problem of one isotropic material on linear cells."""
    others, gravity = _loads_apart(problem)
    mesh, share = _linear_cells(body)
    held, value = prescribed_displacements(problem, mesh.points)
    return Request(
        task="rest",
        mesh=mesh,
        material=problem.material,  # type: ignore[arg-type]  # looked into before
        mass=lumped_mass(mesh, problem.material),  # type: ignore[arg-type]
        gravity=gravity,
        force=np.asarray(share.T @ nodal_forces(others, body)),
        held=held,
        value=value,
        name=problem.name,
    )


def on_mesh(request: Request, law: Material) -> Array:
    """Displacement (n, d) in m of linear elements of a material on a request's own mesh."""
    value, body = np.where(request.held, request.value, 0.0), mesh_discretisation(request.mesh)
    return solve_on(body, law, request.held, value, request.load, allow_locked=True)


def lumped_mass(mesh: Mesh, material: Isotropic) -> Array:
    """Mass (n,) in kg at the nodes of linear cells: the row sums ∫ ρ N of the consistent ones."""
    shape = mesh.kind
    if shape.simplex:
        at, weight = shape.middle[None], np.array([1 / (2.0 if mesh.dim == 2 else 6.0)])
    else:  # two of Gauss's points along each axis: N det J is of degree 3 along it at most
        line = 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3)
        at = np.array(np.meshgrid(*[line] * mesh.dim)).reshape(mesh.dim, -1).T
        weight = np.full(len(at), 1 / len(at))
    slopes = np.einsum("cka,qkb->cqab", mesh.points[mesh.cells], shape.slopes(at))
    parts = np.einsum("cq,q,qk->ck", np.linalg.det(slopes), weight, shape.values(at))
    total = material.density * material.thickness * parts
    return np.asarray(np.bincount(mesh.cells.ravel(), total.ravel(), len(mesh.points)))


def _loads_apart(problem: Problem) -> tuple[Problem, Array]:
    """The problem without its weight, and the sum (d,) of the accelerations of that, in m/s²."""
    weights = [load for load in problem.loads if isinstance(load, Weight)]
    others = tuple(load for load in problem.loads if not isinstance(load, Weight))
    gravity = np.sum([load.acceleration for load in weights], axis=0) if weights else 0.0
    return replace(problem, loads=others), np.zeros(problem.domain.dim) + gravity


# Cells --------------------------------------------------------------------------------------------


def _lay_cells(problem: Problem, cells: int | None, shape: str | None) -> Discretisation:
    """Cells of a body: linear, or as its mesh file has them."""
    domain = problem.domain
    if isinstance(domain, Mesh):
        return _own_cells(domain, cells, shape)
    h = min(high - low for low, high in domain.span) / (cells or ACROSS)
    if isinstance(domain, Box):
        element = of_shape(shape or CELLS[domain.dim][0]).name
        return lines_discretisation(grid_lines(problem, h, least=1), element)
    if isinstance(domain, Polygon) and shape in (None, "triangle"):
        return outline_discretisation(domain, h, kept_places(problem))
    raise ProblemError(f"--shape: {shape} in a {domain}; an outline is cut into triangles")


def _own_cells(mesh: Mesh, cells: int | None, shape: str | None) -> Discretisation:
    own = mesh.kind.straight.name
    if shape not in (None, own):
        raise ProblemError(f"--shape: {shape}; the mesh file's cells are {own}; leave it out")
    body = mesh_discretisation(mesh)
    if cells is None:
        return body
    wanted = min(high - low for low, high in mesh.span) / cells
    times = int(np.ceil(np.log2(mesh.mean_edge / wanted) - 1e-9))
    if times > MOST_HALVINGS:
        raise ProblemError(
            f"--cells: {cells} need each cell of the mesh file halved {times} times, and the most "
            f"is {MOST_HALVINGS}; ask for fewer"
        )
    return subdivide(body, max(times, 0))


def _linear_cells(body: Discretisation) -> tuple[Mesh, csr_array]:
    """The cells between corners, and what part (all nodes, corners) of a node's goes to each."""
    shape = SHAPES[body.element.shape]
    corners = body.cells[:, : shape.corners]
    used, number = np.unique(corners, return_inverse=True)
    cells = number.reshape(corners.shape)
    mesh = Mesh(body.points[used], cells, shape.straight.name)
    # A node that several cells share lies on a side, whose shares are the same in each of them.
    node, first = np.unique(body.cells, return_index=True)
    cell, place = np.divmod(first, body.cells.shape[1])
    weight = shape.straight.values(shape.nodes)[place]
    rows = np.repeat(node, shape.corners)
    columns = cells[cell].ravel()
    size = (len(body.points), len(used))
    return mesh, csr_array((weight.ravel(), (rows, columns)), shape=size)


# Springs ------------------------------------------------------------------------------------------


def nearest_case(case: Case) -> Case:
    """The case at the ratio that springs alone have there; itself where it has that ratio.

    Itself too where none is to be chosen: of given constants, of a material that is no isotropic
    one or several, and of a lattice whose springs have many ratios.
    """
    if case.are_elements:
        raise ProblemError(
            "springs of no rest length beside cells: LAMMPS has bonds alone; export --to csv or "
            "json, or take [springs] on = 'lattice'"
        )
    law, pattern = case.problem.material, all_patterns().get(str(case.lattice))
    free = case.constants is not None or (pattern and not deforms_affinely(pattern()))
    if free or case.problem.zones or not isinstance(law, Isotropic):
        return case
    nu = springs_ratio(law)
    if abs(law.nu - nu) <= ALIKE:
        return replace(case, route="springs")
    problem = replace(case.problem, material=replace(law, nu=nu))
    return replace(case, problem=problem, route="springs")


def ratio_words(case: Case) -> str:
    """Describe the effect of the springs' own Poisson's ratio on a case.

    The text is empty if the ratios are equal.

    The effect is that on elasticity, by elements on one mesh: changes need no finer one.

    Of elasticity at both ratios, by elements on one mesh: changes need no finer one.
    """
    problem, other = case.problem, nearest_case(case).problem
    law = problem.material
    if other is problem or not isinstance(law, Isotropic):
        return ""
    near = springs_ratio(law)
    part = 100 * change_by_ratio(problem, law, near, first_mesh(problem))
    where = law.state.replace("_", " ").replace("solid", "space")
    return (
        f"springs alone have ratio {near:.6g} in {where}, the case {law.nu:g}: that changes "
        f"elasticity's displacement here by {part:.2g} % of the largest"
    )


def refuse_cells(case: Case, network: Network) -> None:
    """Raise `ProblemError` where a case's network at `nearest_case` is more than springs."""
    if network.volumes is not None:
        nu = springs_ratio(case.problem.material)
        what = "volume" if case.constants is not None else "a ratio in its regions"
        mend = "leave it out" if case.constants is not None else f"give each nu = {nu!r}"
        raise ProblemError(
            f"springs alone: the case has {what} that takes cells which resist a change of volume; "
            f"{mend}, or write the cells too: case export --to csv"
        )


def lammps_of(case: Case) -> tuple[SpringAnswer, dict[str, bytes]]:
    """Springs alone at `nearest_case`, at rest to first order, and LAMMPS's files of them."""
    near = nearest_case(case)
    answer = solve_springs(near, spacing_of(near))
    refuse_cells(near, answer.network)
    ratio = getattr(near.problem.material, "nu", math.nan)
    said = f"{' '.join(case.name.split())}: springs alone, {answer.lattice.name}, nu = {ratio:.6g}"
    return answer, lammps_files(answer.network, answer.rest, said)


def _spring_request(
    case: Case, cells: int | None, shape: str | None, settings: Mapping[str, Any]
) -> Request:
    """The network that stands for a case, if springs alone do to a hundredth of the ratio."""
    if shape is not None:
        raise ProblemError("--shape: with --springs cells are the lattice's; leave it out")
    if cells is not None:
        case = replace(case, cells=cells, spacing=None)
    others, gravity = _loads_apart(case.problem)
    near = nearest_case(replace(case, problem=others))
    own, nu = (getattr(each.problem.material, "nu", 0.0) for each in (case, near))
    if abs(own - nu) > NEAR_RATIO:
        raise ProblemError(
            f"--springs: at ratio {own:g} the {case.lattice} lattice has cells that resist a "
            f"change of volume beside its springs; take nu within {NEAR_RATIO:g} of {nu:.6g}, "
            "which springs alone have, or write the cells too: case export --to csv"
        )
    _, lattice, network, _ = make_network(near, spacing_of(near))
    refuse_cells(near, network)
    return Request(
        task="rest",
        mesh=_lattice_mesh(lattice),
        material=case.problem.material,  # type: ignore[arg-type]  # looked into before
        mass=np.array(network.mass),
        gravity=gravity,
        force=np.array(network.force),
        held=np.array(network.fixed),
        value=np.array(network.displacement),
        settings=settings,
        springs=Springs(
            np.array(network.springs), np.array(network.stiffness), np.array(network.rest_length)
        ),
        name=case.problem.name,
    )


def _lattice_mesh(lattice: Lattice) -> Mesh:
    """A lattice's points and cells, where these are linear ones that take in every point."""
    cells: Index = lattice.cells
    shape = SHAPE_OF.get((lattice.points.shape[1], cells.shape[1]))
    if shape is None or len(np.unique(cells)) < len(lattice.points):
        raise ProblemError(
            f"--springs: lattice {format_value(lattice.name)} has points that are corners of no "
            "cell, and adapters are given a mesh; take a square or cubic one"
        )
    return Mesh(lattice.points, cells, shape)
