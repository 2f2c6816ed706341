"""The block under end load: its loadings, the definitions of its Poisson's ratio, the candidate."""

from __future__ import annotations

import numpy as np

import reference_fem
from msvalidate import lattice
from msvalidate.bodies.lattice_network import lattice_network
from msvalidate.constants.homogenise import interior_tensor
from msvalidate.judging.candidate import Answer
from msvalidate.network import Network
from msvalidate.problem import (
    Anisotropic,
    Array,
    Box,
    Domain,
    Mask,
    Polygon,
    Problem,
    Region,
    Support,
    Traction,
)

COLUMNS = {
    "lattice": "which lattice",
    "weights": "rule for springs on the boundary: shared, equal or per_cell",
    "k1": "stiffness of axial springs (N/m)",
    "k2": "stiffness of diagonal springs (N/m)",
    "cells": "cells per side, N: of a block at 45 degrees the squares, of triangles their sides",
    "loading": "slide, traction or clamped ends",
    "angle_deg": "direction of the pull to the axial springs, of triangles to their rows (degrees)",
    "strain": "axial strain (1)",
    "nu_tensor": "Poisson's ratio from the homogenised tensor (1)",
    "nu_fem": "Poisson's ratio of the elastic body, by finite elements (1)",
    "nu_springs": "Poisson's ratio of the candidate's block; \"none\" where there is no block (1)",
}
"""What columns of several tables mean."""
SIDE = 1.0
BOX = Box((SIDE, SIDE))
QUARTER = Box((SIDE / 2, SIDE / 2))
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


def finite_elements(problem: Problem, spring_network: Network, answer: Answer = "linear") -> Array:
    """The reference in the candidate's place: an identity control of the linear questions."""
    if isinstance(problem.domain, Polygon):
        side = float(spring_network.rest_length.min())
        mesh = reference_fem.polygon_discretisation(problem.domain, side, "P2")
    else:
        mesh = reference_fem.box_discretisation(BOX, 32, "Q2", GRADING)
    return reference_fem.solve_problem(problem, mesh).at(spring_network.points)


def loaded_block(
    loading: str, tensor: Array, strain: float = STRAIN, body: Domain = BOX
) -> Problem:
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
    left, right = Region((0.0, None)), Region((width, None))
    corner = Region((0.0, 0.0))
    pull = strain * width
    loads: tuple[Traction, ...] = ()
    if loading == "slide":
        supports: tuple[Support, ...] = (
            Support(left, (0.0, None)),
            Support(right, (pull, None)),
            Support(corner, (None, 0.0)),
        )
    elif loading == "clamped":
        supports = (Support(left, (0.0, 0.0)), Support(right, (pull, 0.0)))
    else:
        stress = strain * (tensor[0, 0] - tensor[0, 1] ** 2 / tensor[0, 0])
        supports = (Support(corner, (0.0, 0.0)), Support(Region((0.0, height)), (0.0, None)))
        loads = (Traction(left, (-stress, 0.0)), Traction(right, (stress, 0.0)))
    return Problem(body, Anisotropic(tensor), supports, loads, name=f"block, {loading}")


def clamped_quarter(tensor: Array, strain: float = STRAIN) -> Problem:
    """The quarter of the clamped block beyond its two middle lines, which symmetry holds.

    Displacements count from the block's middle, the quarter's origin.
    """
    middle = (
        Support(QUARTER.side("left"), (0.0, None)),
        Support(QUARTER.side("bottom"), (None, 0.0)),
    )
    end = Support(QUARTER.side("right"), (strain * SIDE / 2, 0.0))
    return Problem(QUARTER, Anisotropic(tensor), (*middle, end), name="quarter block, clamped")


def spring_block(
    loading: str, k2: float, cells: int, weights: str, strain: float = STRAIN
) -> tuple[Problem, Network]:
    """The block as a problem, its material the tensor of the lattice's interior, and as springs."""
    grid = lattice.square(BOX, cells)
    constants = (K1, k2)
    problem = loaded_block(loading, interior_tensor(grid, constants, weights), strain)
    return problem, lattice_network(problem, grid, constants, weights=weights)


def edge_points(points: Array) -> Array:
    """Those of the points on the block's edges: all that `ratio` and `axial_strain` look at."""
    return points[(_at(points, 0.0) | _at(points, SIDE)).any(axis=1)]


def end_traction(problem: Problem) -> float:
    """Traction (Pa) along x on the right end of a block under traction."""
    load = problem.loads[-1]
    if not isinstance(load, Traction) or callable(load.traction):
        raise TypeError("the block is not under uniform traction")
    return load.traction[0]


def axial_strain(points: Array, displacement: Array) -> float:
    """Difference of the plain mean displacement of the two ends, over the length."""
    x = points[:, 0]
    right, left = displacement[_at(x, SIDE), 0], displacement[_at(x, 0.0), 0]
    return float((right.mean() - left.mean()) / SIDE)


def ratio(points: Array, displacement: Array, definition: str) -> float:
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


def _at(values: Array, place: float) -> Mask:
    return np.asarray(np.abs(values - place) < 1e-9)
