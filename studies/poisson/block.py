"""The block under end load: its loadings, the definitions of its Poisson's ratio, the candidate."""

from __future__ import annotations

import numpy as np

import reference_fem
from msvalidate import kit
from msvalidate.springs import lattice
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.constants.homogenise import interior_tensor

SIDE = 1.0
BOX = kit.Box((SIDE, SIDE))
QUARTER = kit.Box((SIDE / 2, SIDE / 2))
LOADINGS = ("slide", "traction", "clamped")
DEFINITIONS = ("edges", "middle")
K1 = 1.0
RATIOS = (0.25, 0.5, 1.0, 2.0)
"""k2/k1."""
STRAIN = 1e-3
"""Nominal axial strain; a linear answer does not depend on it."""
GRADING = 2.25
"""Mesh lines crowd to the corners, where a clamped end has singular stress: 64 x 64 elements are
then within 2e-5 of the limit, against 3e-4 on even lines."""


def finite_elements(
    problem: kit.Problem, spring_network: kit.Network, answer: kit.Answer = "linear"
) -> kit.Array:
    """The reference in the candidate's place: an identity control of the linear questions."""
    if isinstance(problem.domain, kit.Polygon):
        side = float(spring_network.rest_length.min())
        mesh = reference_fem.polygon_discretisation(problem.domain, side, "P2")
    else:
        mesh = reference_fem.box_discretisation(BOX, 32, "Q2", GRADING)
    return reference_fem.solve_problem(problem, mesh).at(spring_network.points)


def loaded_block(
    loading: str, tensor: kit.Array, strain: float = STRAIN, body: kit.Domain = BOX
) -> kit.Problem:
    """Unit square, or another body with straight ends, pulled along x.

    Parameters
    ----------
    loading
        "slide": end displacement prescribed, ends free to slide along y. "traction": uniform
        traction on both ends, statically determinate supports. "clamped": both components
        prescribed on both ends.
    tensor
        (3, 3) in N/m: the material, at thickness 1 m.
    strain
        Nominal axial strain.
    body
        Its left end runs from the origin up to its height.
    """
    (_, width), (_, height) = body.span
    left, right = kit.Region((0.0, None)), kit.Region((width, None))
    corner = kit.Region((0.0, 0.0))
    pull = strain * width
    loads: tuple[kit.Traction, ...] = ()
    if loading == "slide":
        supports: tuple[kit.Support, ...] = (
            kit.Support(left, (0.0, None)),
            kit.Support(right, (pull, None)),
            kit.Support(corner, (None, 0.0)),
        )
    elif loading == "clamped":
        supports = (kit.Support(left, (0.0, 0.0)), kit.Support(right, (pull, 0.0)))
    else:
        stress = strain * (tensor[0, 0] - tensor[0, 1] ** 2 / tensor[0, 0])
        supports = (
            kit.Support(corner, (0.0, 0.0)),
            kit.Support(kit.Region((0.0, height)), (0.0, None)),
        )
        loads = (kit.Traction(left, (-stress, 0.0)), kit.Traction(right, (stress, 0.0)))
    return kit.Problem(body, kit.Anisotropic(tensor), supports, loads, name=f"block, {loading}")


def clamped_quarter(tensor: kit.Array, strain: float = STRAIN) -> kit.Problem:
    """The quarter of the clamped block beyond its two middle lines, which symmetry holds.

    Displacements count from the block's middle, the quarter's origin.
    """
    middle = (
        kit.Support(QUARTER.side("left"), (0.0, None)),
        kit.Support(QUARTER.side("bottom"), (None, 0.0)),
    )
    end = kit.Support(QUARTER.side("right"), (strain * SIDE / 2, 0.0))
    return kit.Problem(
        QUARTER, kit.Anisotropic(tensor), (*middle, end), name="quarter block, clamped"
    )


def spring_block(
    loading: str, k2: float, cells: int, weights: str, strain: float = STRAIN
) -> tuple[kit.Problem, kit.Network]:
    """The block as a problem, its material the tensor of the lattice's interior, and as springs."""
    grid = lattice.square(BOX, cells)
    constants = (K1, k2)
    problem = loaded_block(loading, interior_tensor(grid, constants, weights), strain)
    return problem, lattice_network(problem, grid, constants, weights=weights)


def edge_points(points: kit.Array) -> kit.Array:
    """Those of the points on the block's edges: all that `ratio` and `axial_strain` look at."""
    return points[(_at(points, 0.0) | _at(points, SIDE)).any(axis=1)]


def end_traction(problem: kit.Problem) -> float:
    """Traction (Pa) along x on the right end of a block under traction."""
    load = problem.loads[-1]
    if not isinstance(load, kit.Traction) or callable(load.traction):
        raise TypeError("the block is not under uniform traction")
    return load.traction[0]


def axial_strain(points: kit.Array, displacement: kit.Array) -> float:
    """Difference of the plain mean displacement of the two ends, over the length."""
    x = points[:, 0]
    right, left = displacement[_at(x, SIDE), 0], displacement[_at(x, 0.0), 0]
    return float((right.mean() - left.mean()) / SIDE)


def ratio(points: kit.Array, displacement: kit.Array, definition: str) -> float:
    """Poisson's ratio of the block: minus lateral over axial strain.

    ``edges``: lateral strain between the plain means of all nodes of the top and bottom edge,
    corners included. ``middle``: at half length; where no column of points reaches both edges
    there, the mean of the two nearest that do.
    """
    x, y = points.T
    columns = np.unique(np.round(x[_at(y, SIDE)], 12))
    if definition == "middle":
        distance = np.abs(columns - SIDE / 2)
        columns = columns[distance < distance.min() + 1e-9]
    chosen = (np.abs(x[:, None] - columns) < 1e-9).any(axis=1)
    top, bottom = chosen & _at(y, SIDE), chosen & _at(y, 0.0)
    lateral = (displacement[top, 1].mean() - displacement[bottom, 1].mean()) / SIDE
    return float(-lateral / axial_strain(points, displacement))


def _at(values: kit.Array, place: float) -> kit.Mask:
    return np.asarray(np.abs(values - place) < 1e-9)
