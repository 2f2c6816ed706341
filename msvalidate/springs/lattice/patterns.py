"""The lattices: one function each, found by what it returns.

Closed forms are the affine rule C_ijkl = (1/2V) Σ k L² n_i n_j n_k n_l over all neighbours of a
point of volume V ([BornHuang1954], for central forces): exact where every point is a centre of
symmetry, as it is in all of these but honeycomb. There central forces make C12 = C44 (Cauchy), so
isotropic means C11 = 3·C12.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from inspect import isfunction, signature
from itertools import product
from math import sqrt

import numpy as np

from msvalidate.problem import Array
from msvalidate.springs.lattice.pattern import Constants, Pattern, SpringFormulas, pattern_by_shells

AXES = SpringFormulas((("the axes", ""),))
"""Formulas of lattices that no constants make isotropic, with springs along the axes alone."""


def all_patterns() -> dict[str, Callable[[], Pattern]]:
    """All lattices of this module: its functions without arguments that return a `Pattern`."""
    return {
        name: item
        for name, item in vars(sys.modules[__name__]).items()
        if isfunction(item) and not name.startswith("_") and _returns_pattern(item)
    }


def _returns_pattern(function: Callable[..., object]) -> bool:
    asked = signature(function)
    needs = [item for item in asked.parameters.values() if item.default is item.empty]
    return not needs and asked.return_annotation in {"Pattern", Pattern}


def square() -> Pattern:
    """Square lattice with eight neighbours: k1 along the axes, k2 along the diagonals."""
    rules = {"isotropic": (1.0, 0.5), "equal": (1.0, 1.0), "report's 2 k1": (1.0, 2.0)}

    def tensor(k: Constants) -> Array:
        return cubic_tensor(2, k[0] + k[1], k[1])

    formulas = SpringFormulas((("the axes", "2μt"), ("the diagonals", "μt")), "μt/3")
    lengths = (1.0, sqrt(2))
    return pattern_by_shells("square", (1.0, 1.0), [(0, 0)], lengths, rules, tensor, formulas)


def square4() -> Pattern:
    """Square lattice with four neighbours: Poisson's ratio 0, no shear stiffness.

    The Voronoi cells of a square grid have these springs.
    """

    def tensor(k: Constants) -> Array:
        return cubic_tensor(2, k[0], 0.0)

    rules = {"equal": (1.0,)}
    return pattern_by_shells("square 4", (1.0, 1.0), [(0, 0)], (1.0,), rules, tensor, AXES)


def triangular() -> Pattern:
    """Triangular lattice with six neighbours, rows along x: isotropic for every k."""

    def tensor(k: Constants) -> Array:
        return cubic_tensor(2, 3 * sqrt(3) / 4 * k[0], sqrt(3) / 4 * k[0])

    points = [(0, 0), (0.5, sqrt(3) / 2)]
    sides = (("the triangles' sides", "4/√3·μt"),)
    formulas = SpringFormulas(sides, "μt/√3", "OstojaStarzewski2002")
    return pattern_by_shells(
        "triangular", (1.0, sqrt(3)), points, (1.0,), {"equal": (1.0,)}, tensor, formulas
    )


def honeycomb() -> Pattern:
    """Honeycomb with springs to 3 nearest (k1) and 6 next neighbours (k2), isotropic.

    The spacing is the nearest distance.

    Its points are no centres of symmetry. A uniform shear moves the two sublattices apart until the
    nearest springs bear nothing of it: they resist a change of area alone, by √3/6·k1, while each
    sublattice is a triangular lattice of k2. So the ratio (k1 + 3 k2)/(k1 + 9 k2) runs from 1/3 to
    1, though all forces are central: Cauchy's relation holds for centres of symmetry only.
    """

    def tensor(k: Constants) -> Array:
        area, shear = sqrt(3) / 6 * k[0], sqrt(3) / 2 * k[1]
        return cubic_tensor(2, area + 3 * shear, area + shear, shear)

    points = [(0, 0), (0, 1), (sqrt(3) / 2, 3 / 2), (sqrt(3) / 2, 5 / 2)]
    rules = {"ratio 1/2": (3.0, 1.0), "equal": (1.0, 1.0)}
    sides = ("the hexagons' sides", "2√3·({λ} - μ)t")
    formulas = SpringFormulas((sides, ("their short diagonals", "2/√3·μt")))
    lengths = (1.0, sqrt(3))
    return pattern_by_shells("honeycomb", (sqrt(3), 3.0), points, lengths, rules, tensor, formulas)


def cubic6() -> Pattern:
    """Cubic lattice with six neighbours: Poisson's ratio 0, no shear stiffness."""

    def tensor(k: Constants) -> Array:
        return cubic_tensor(3, k[0], 0.0)

    rules = {"equal": (1.0,)}
    return pattern_by_shells("cubic 6", (1.0,) * 3, [(0, 0, 0)], (1.0,), rules, tensor, AXES)


def cubic18() -> Pattern:
    """Cubic lattice with eighteen neighbours: k1 along edges, k2 along the faces' diagonals."""

    def tensor(k: Constants) -> Array:
        return cubic_tensor(3, k[0] + 2 * k[1], k[1])

    rules = {"isotropic": (1.0, 1.0), "report's 2 k1": (1.0, 2.0)}
    formulas = SpringFormulas((("the axes", "μh"), ("the faces' diagonals", "μh")), "μh/5")
    lengths = (1.0, sqrt(2))
    return pattern_by_shells("cubic 18", (1.0,) * 3, [(0, 0, 0)], lengths, rules, tensor, formulas)


def cubic26() -> Pattern:
    """Cubic lattice with twenty-six neighbours: edges k1, faces' diagonals k2, the cube's k3.

    Its formulas are those with k2 = k3; others are the material too.
    """

    def tensor(k: Constants) -> Array:
        return cubic_tensor(3, k[0] + 2 * k[1] + 4 / 3 * k[2], k[1] + 4 / 3 * k[2])

    rules = {"isotropic": (11 / 3, 1.0, 1.0), "equal": (1.0, 1.0, 1.0)}
    shells = (1.0, sqrt(2), sqrt(3))
    cross = (("the faces' diagonals", "3/7·μh"), ("the cubes' diagonals", "3/7·μh"))
    formulas = SpringFormulas((("the axes", "11/7·μh"), *cross), "μh/9")
    return pattern_by_shells("cubic 26", (1.0,) * 3, [(0, 0, 0)], shells, rules, tensor, formulas)


def bcc() -> Pattern:
    """Body-centred cubic lattice, spacing its cubic edge: 8 nearest k1, 6 next k2."""

    def tensor(k: Constants) -> Array:
        return cubic_tensor(3, 2 / 3 * k[0] + 2 * k[1], 2 / 3 * k[0])

    rules = {"isotropic": (1.0, 2 / 3), "equal": (1.0, 1.0)}
    points = [(0, 0, 0), (0.5, 0.5, 0.5)]
    formulas = SpringFormulas((("half the cubes' diagonals", "3/2·μh"), ("the axes", "μh")))
    return pattern_by_shells("BCC", (1.0,) * 3, points, (sqrt(3) / 2, 1.0), rules, tensor, formulas)


def fcc() -> Pattern:
    """Face-centred cubic lattice, spacing its cubic edge: 12 nearest k1, 6 next k2."""

    def tensor(k: Constants) -> Array:
        return cubic_tensor(3, 2 * k[0] + 4 * k[1], k[0])

    rules = {"isotropic": (1.0, 0.25), "nearest only": (1.0, 0.0)}
    points = [point for point in product((0, 0.5), repeat=3) if sum(point) in {0, 1}]
    formulas = SpringFormulas((("half the faces' diagonals", "μh"), ("the axes", "1/4·μh")))
    return pattern_by_shells("FCC", (1.0,) * 3, points, (sqrt(0.5), 1.0), rules, tensor, formulas)


def cubic_tensor(dim: int, C11: float, C12: float, C44: float | None = None) -> Array:
    """Voigt tensor, (3, 3) or (6, 6), with square or cubic symmetry along the axes.

    `C44` defaults to C12, Cauchy's relation for central forces; in the plane it is C66.

    Source: [Nye1957], chapter VIII, cubic symmetry.
    """
    shears = dim * (dim - 1) // 2
    C = np.zeros((dim + shears, dim + shears))
    C[:dim, :dim] = C12
    np.fill_diagonal(C, [C11] * dim + [C12 if C44 is None else C44] * shears)
    return C
