"""Spring networks of the edges of a mesh, and their accuracy.

**The rule** ``area`` takes a cell's edges, and the diagonals of quadrilaterals and of hexahedra's
faces, with stiffness w E V/L²: V the cell's area (times the thickness) or volume, L the edge's
length, w by the shape of the cell. For triangles w = 1 is the plainest rule of [vanGelder1998],
and for tetrahedra its counterpart. Under affine motion a cell of such springs has the
tensor E Σ w v vᵀ, v of the edges' directions, whatever their lengths. Its isotropic part is then
the material's, modulus E and ratio 1/3 in the plane or 1/4 in space, in a cell of any shape: its
invariants C_iijj and C_ijij are both E Σ w, so Σ w = 3 in the plane and 6 in space does it. The
rest of the tensor is zero if the edges point evenly: in equilateral triangles, in squares with
w = 3/8 for sides and 3/4 for diagonals, and in cubes with 1/10 for edges and 2/5 for diagonals.
Three springs along the sides of any other triangle are never isotropic: stiffnesses above zero with
Σ w v vᵀ isotropic need Σ w e^(2iθ) = Σ w e^(4iθ) = 0, three numbers on a circle that sum to zero
twice, which 60 degrees alone allows.

**The rule** ``equilateral`` gives each edge √3/4 E t a triangle, as if all were equilateral.
**The rule** ``cotangent`` gives it -(3/2) E t A ∇φi·∇φj, φ the linear shape functions of the
triangle: ¾ E t cot γ, γ the angle opposite; in tetrahedra -2 E V ∇φi·∇φj. A cell then answers a
uniform dilatation with a uniform pressure exactly, for its springs close, Σ cot γ e⊗e = 2 A I. In
quadrilaterals and hexahedra all pairs of corners have a spring, of -∫∇φi·∇φj by the two Gauss
points an axis that integrate a distorted cell's volume and its slopes exactly: such cells are
bilinear and trilinear elements with one mean J each.

Equilateral triangles make all three one and the same, the matrix of linear finite elements at a
ratio of 1/3. On other meshes a network *of springs at rest* is another material, as Van Gelder says
of his own rule: no stiffness makes it exact. Springs of no rest length, under tension beside cells
under pressure, do: by the rule ``cotangent`` and the route "neo-Hookean" of
`springs.constants.routes` they are linear elements, on any mesh, at any ratio and strain. There
obtuse angles give springs that push, of negative stiffness; what is stable is the sum, so these are
allowed there.

At rest an irregular mesh answers uniform stress with a strain that is not, and
whose mean is not E's, and finer cells of the same shapes do not mend it. Squares whose corners are
moved by up to a fifth of a side have E 5 % low and a ratio of 0.36, and displacements off by as
much at any number of cells; the error goes as the square of the irregularity. Delaunay triangles of
jittered points come to E 2 % low and 0.29, squares all cut one way into triangles to E 7 % high and
0.07, for they have lost half their diagonals, and cubes cut into six tetrahedra to E 14 % high and
0.07 for 1/4.
"""

from __future__ import annotations

import math
from itertools import combinations, product

import numpy as np

from msvalidate.problem import SHAPES, Array, Index, Mesh, ProblemError, Shape
from msvalidate.problem.checks import require_one_of, require_type
from msvalidate.problem.records import dataclass
from msvalidate.springs.lattice.corners import corner_volumes
from msvalidate.springs.lattice.filled import VTK_ORDER, Lattice

EDGE_RULES = ("area", "equilateral", "cotangent")
"""Rules for the stiffness of a mesh's edges: see the module's text."""
REST_SHARE = {2: 3 / 2, 3: 2.0}
"""Number of axes -> stiffness of a "cotangent" spring, in units of -E V ∇φi·∇φj.

The springs have a rest length; V is the volume of the cell.
"""
ROUNDING = 1e-14
"""Smallest stiffness of a spring, relative to the magnitudes of its contributions."""
EDGE_SHARES = {"quad": (3 / 8, 3 / 4), "hexahedron": (1 / 10, 2 / 5)}
"""Factors of edges and of face diagonals that make squares and cubes isotropic."""


@dataclass(frozen=True, eq=False, kw_only=True)
class EdgeLattice(Lattice):
    """Lattice with a spring along each edge of a mesh.

    Parameters
    ----------
    rule
        Rule for the stiffness: "area", "cotangent" or "equilateral".
    gifts
        Contribution of each cell to the factors of its springs, shape (c, e).
    of
        Indices of these springs, shape (c, e).
    """

    rule: str
    gifts: Array
    of: Index
    boundary: str = "edges"


def mesh_lattice(mesh: Mesh, rule: str = "area", *, positive: bool = True) -> EdgeLattice:
    """Make a lattice with a spring along every edge of a mesh.

    Quadrilaterals and hexahedra also get springs along diagonals. The lattice has one spring
    constant, E·t (N/m) in 2D or E (Pa) in 3D; ``factor`` relates each spring to it. Source:
    [vanGelder1998] for triangles.

    Parameters
    ----------
    mesh
        Mesh of triangles, quadrilaterals, tetrahedra or hexahedra without mid-side nodes.
    rule
        Stiffness of an edge of length L in a cell of area or volume V: "area" is proportional to
        V/L²; "cotangent" is proportional to -V times the scalar product of the shape functions'
        gradients; "equilateral", for triangles only, is √3/4 E·t per triangle.
    positive
        True to reject springs with zero or negative stiffness. By "cotangent" such springs occur if
        the angles opposite an edge add up to 180 degrees or more. They are valid for zero-length
        springs, by the route "neo-Hookean" of `calibrate`.

    Returns
    -------
    EdgeLattice
        The points (n, d) of the mesh and its springs (m, 2); facets are those of the mesh, so that
        supports and loads can refer to named boundaries.

    Raises
    ------
    ProblemError
        If the cells have mid-side nodes, the rule does not apply to them, or `positive` is True and
        a stiffness is not positive.

    Examples
    --------
    >>> from msvalidate import Mesh, mesh_lattice
    >>> corners = [[0, 0], [1, 0], [1, 1], [0, 1]]
    >>> mesh = Mesh(points=corners, cells=[[0, 1, 2], [0, 2, 3]], shape="triangle")
    >>> lattice = mesh_lattice(mesh)
    >>> lattice.springs.tolist()
    [[0, 1], [0, 2], [0, 3], [1, 2], [2, 3]]
    >>> lattice.factor.round(6).tolist()
    [0.5, 0.5, 0.5, 0.5, 0.5]
    """
    require_type("mesh", mesh, Mesh)
    _refuse_other_cells(mesh, rule)
    cells = mesh.cells
    volume = corner_volumes(mesh.points, cells)
    ends, weights = _edges(mesh.shape, cells.shape[1], rule)
    pairs = np.sort(cells[:, ends], axis=2)  # (c, edges, 2)
    gifts = (
        _cotangents(mesh.points[cells], ends, mesh.kind)
        if rule == "cotangent"
        else _edge_contributions(mesh.points[pairs], weights, volume.sum(axis=1), rule)
    )
    springs, which = np.unique(pairs.reshape(-1, 2), axis=0, return_inverse=True)
    factor = _factors(springs, which.ravel(), gifts.ravel(), positive=positive)
    # Corners of a lattice's facets are listed the first axis fastest.
    surface = mesh.surface[:, VTK_ORDER[2]] if mesh.shape == "hexahedron" else mesh.surface
    return EdgeLattice(
        name=f"{mesh.shape} edges",
        domain=mesh,
        points=mesh.points,
        springs=springs,
        cells=cells,
        facets=surface,
        point_volume=np.bincount(cells.ravel(), volume.ravel()).astype(float),
        factor=factor,
        regular=False,
        rule=rule,
        gifts=gifts,
        of=which.reshape(gifts.shape),
    )


def _refuse_other_cells(mesh: Mesh, rule: str) -> None:
    """Raise `ProblemError` where a rule is not for a mesh's cells."""
    require_one_of("stiffness of a mesh's edges", rule, EDGE_RULES)
    if mesh.kind.degree != 1:
        raise ProblemError(
            f"mesh lattice: {mesh.shape} cells have mid-sides; give a mesh of straight cells"
        )
    if rule == "equilateral" and mesh.shape != "triangle":
        raise ProblemError(
            f"mesh lattice: rule {rule!r} is for triangles, the cells are {mesh.shape}; take 'area'"
        )


def _edges(shape: str, corners: int, rule: str) -> tuple[Index, Array]:
    """Ends (e, 2) among a cell's corners of its springs, and their weights (e,)."""
    pairs = np.array(list(combinations(range(corners), 2)))
    if shape not in EDGE_SHARES or rule == "cotangent":
        return pairs, np.ones(len(pairs))
    # Along an edge one coordinate of a cell changes, along a face's diagonal two.
    at = SHAPES[shape].nodes
    changes = np.abs(at[pairs[:, 0]] - at[pairs[:, 1]]).sum(axis=1)
    inside = changes <= 2
    return pairs[inside], np.array(EDGE_SHARES[shape])[changes[inside].astype(int) - 1]


def _edge_contributions(ends: Array, weights: Array, volume: Array, rule: str) -> Array:
    """Stiffness (c, e) that each cell gives its springs (c, e, 2, d), in units of E·t or E."""
    square = ((ends[:, :, 1] - ends[:, :, 0]) ** 2).sum(axis=2)
    if rule == "equilateral":
        return np.full(square.shape, math.sqrt(3) / 4)
    return np.asarray(weights * volume[:, None] / square)


def _cotangents(corners: Array, ends: Index, shape: Shape) -> Array:
    """The same (c, e) of cells with corners (c, k, d): from slopes of shape functions."""
    d = corners.shape[2]
    gauss = 0.5 + np.array([-0.5, 0.5]) / math.sqrt(3)
    at = np.array(list(product(gauss, repeat=d))) if not shape.simplex else shape.middle[None]
    size = 1 / math.factorial(d) if shape.simplex else 1 / len(at)  # of the unit cell, by place
    found = np.zeros((len(corners), len(ends)))
    for slope in shape.slopes(at):
        jacobian = np.einsum("kd,ckx->cxd", slope, corners)
        there = slope @ np.linalg.inv(jacobian)
        both = (there[:, ends[:, 0]] * there[:, ends[:, 1]]).sum(axis=2)
        found -= REST_SHARE[d] * size * np.linalg.det(jacobian)[:, None] * both
    return found


def _factors(springs: Index, which: Index, gifts: Array, *, positive: bool) -> Array:
    """Relative stiffness (m,) of springs: the sum of the contributions (e,) of cells.

    `which` (e,) are the springs of the contributions. If stiffnesses must be `positive`,
    `ProblemError` is raised for one of zero or less.

    Contributions cancel at right angles. Magnitudes below `ROUNDING` of the contributions are
    therefore raised to it, so that the parts of cells can be divided by the sum.
    """
    factor = np.bincount(which, gifts).astype(float)
    slack = np.flatnonzero(factor <= 0)
    if positive and len(slack):
        raise ProblemError(
            f"mesh lattice: the spring between points {springs[slack[0]].tolist()} would have "
            f"{factor[slack[0]]:.3g} of E; make the mesh one of Delaunay's, take 'area', or "
            "springs of no rest length, by route 'neo-Hookean', which may push"
        )
    least = ROUNDING * np.bincount(which, np.abs(gifts))
    return np.where(np.abs(factor) < least, np.copysign(least, factor), factor)
