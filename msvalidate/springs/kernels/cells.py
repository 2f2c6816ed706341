"""Compiled forces of cells that resist a change of volume; plain form: `laws.volumes`.

The volume of a cell, in the plane its area, is a sum of determinants of its edges and diagonals. A
shape is one function of cells at rest and their displacement, both as `corners` has them; it gives
a multiple of the change V - V0, and of the slope ∂V/∂x at the corners but the first, whose own is
minus their sum. The change is what each column of a determinant adds as it moves,

    det(p, q, r) - det(P, Q, R) = det(p - P, q, r) + det(P, q - Q, r) + det(P, Q, r - R),

free of the digits that V and V0 share.
"""

from __future__ import annotations

from collections.abc import Callable

from numba.extending import overload

from msvalidate.problem import Array, Index
from msvalidate.springs.kernels.compiling import compiled
from msvalidate.springs.kernels.corners import gather, numbers, numbers_or_zero, pull
from msvalidate.springs.kernels.lanes import WIDTH, spread, total
from msvalidate.springs.kernels.values import Axes, Body, Corners, Lane, Type, Vector

Shape = Callable[[Body, Body], tuple[Lane, Body, float]]
"""Change of a multiple of V, its slope, and what part of it V is, of cells and a displacement."""


@compiled(fused=True, inner=True)
def _minus(a: Vector, b: Vector) -> Vector:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@compiled(fused=True, inner=True)
def _plus(a: Vector, b: Vector) -> Vector:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@compiled(fused=True, inner=True)
def _dot(a: Vector, b: Vector) -> Lane:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled(fused=True, inner=True)
def _cross(a: Vector, b: Vector) -> Vector:
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


@compiled(fused=True, inner=True)
def _area(P: Vector, Q: Vector, dp: Vector, dq: Vector) -> tuple[Lane, Vector, Vector]:
    """Change of p × q from P and Q on, and its slopes in p and q."""
    px, py, qx, qy = P[0] + dp[0], P[1] + dp[1], Q[0] + dq[0], Q[1] + dq[1]
    change = (dp[0] * qy - dp[1] * qx) + (P[0] * dq[1] - P[1] * dq[0])
    return change, (qy, -1.0 * qx), (-1.0 * py, px)


@compiled(fused=True, inner=True)
def _determinant(
    P: Vector, Q: Vector, R: Vector, dp: Vector, dq: Vector, dr: Vector
) -> tuple[Lane, Vector, Vector, Vector]:
    """Change of p·(q × r) from P, Q and R on, and its slopes in p, q and r."""
    p, q, r = _plus(P, dp), _plus(Q, dq), _plus(R, dr)
    across = _cross(q, r)
    change = _dot(dp, across) + _dot(P, _plus(_cross(dq, r), _cross(Q, dr)))
    return change, across, _cross(r, p), _cross(p, q)


def _triangle(X: Body, u: Body) -> tuple[Lane, Body, float]:
    """2 V = x1 × x2."""
    change, at_1, at_2 = _area(X[0], X[1], u[0], u[1])
    return change, (at_1, at_2), 1 / 2


def _quadrilateral(X: Body, u: Body) -> tuple[Lane, Body, float]:
    """2 V = x2 × (x3 - x1), of the diagonals."""
    across = X[2][0] - X[0][0], X[2][1] - X[0][1]
    moved_across = u[2][0] - u[0][0], u[2][1] - u[0][1]
    change, at_2, at_3 = _area(X[1], across, u[1], moved_across)
    return change, ((-1.0 * at_3[0], -1.0 * at_3[1]), at_2, at_3), 1 / 2


def _tetrahedron(X: Body, u: Body) -> tuple[Lane, Body, float]:
    """6 V = x1·(x2 × x3)."""
    change, at_1, at_2, at_3 = _determinant(X[0], X[1], X[2], u[0], u[1], u[2])
    return change, (at_1, at_2, at_3), 1 / 6


@compiled(fused=True, inner=True)
def _columns(
    a: Vector, b: Vector, c: Vector, d: Vector, end: Vector
) -> tuple[Vector, Vector, Vector]:
    """Columns p, q and r of one of the determinants of a hexahedron."""
    return _plus(_minus(c, a), _minus(d, b)), _minus(end, c), b


def _hexahedron(X: Body, u: Body) -> tuple[Lane, Body, float]:
    """12 V, three determinants round the diagonal from corner 0 to corner 6.

    The volume of the trilinear map, so the one between bilinear faces.

    Source: [Grandy1997].
    """
    X1, X2, X3, X4, X5, X6, X7 = X
    u1, u2, u3, u4, u5, u6, u7 = u
    P, Q, R = _columns(X1, X2, X3, X7, X6)
    first, p1, q1, r1 = _determinant(P, Q, R, *_columns(u1, u2, u3, u7, u6))
    P, Q, R = _columns(X3, X7, X4, X5, X6)
    second, p2, q2, r2 = _determinant(P, Q, R, *_columns(u3, u7, u4, u5, u6))
    P, Q, R = _columns(X4, X5, X1, X2, X6)
    third, p3, q3, r3 = _determinant(P, Q, R, *_columns(u4, u5, u1, u2, u6))
    a, b, c = _minus(p3, p1), _minus(p1, p2), _minus(p2, p3)
    slope = (
        _minus(a, q3),
        _plus(a, r1),
        _minus(b, q1),
        _minus(c, q2),
        _plus(c, r3),
        _plus(_plus(q1, q2), q3),
        _plus(b, r2),
    )
    return first + second + third, slope, 1 / 12


_SHAPES: dict[tuple[int, int], Shape] = {
    (2, 2): _triangle,
    (2, 3): _quadrilateral,
    (3, 3): _tetrahedron,
    (3, 7): _hexahedron,
}
"""(axes, corners but the first) of a cell -> its shape."""


def _multiple(X: Body, u: Body) -> tuple[Lane, Body, float]:
    """The shape with so many corners, of cells."""
    raise NotImplementedError


@overload(_multiple, jit_options={"forceinline": True, "fastmath": {"contract"}})
def _multiple_of_shape(X: Body, u: Body) -> Shape:
    body: Type = (
        X  # Numba has makers of overloads annotated as what they make, but shows them types
    )
    return _SHAPES[len(body.dtype), len(body)]


@compiled(fused=True, inner=True)
def _response(
    axes: Axes,
    corners: Corners,
    X: Array,
    u: Array,
    laws: tuple[Index, Array, Array],
    first: int,
    count: int,
) -> tuple[Lane, Lane, Body]:
    """Energy of some cells, and their force: a factor and a slope."""
    cells, kappa, rest = laws
    at_rest = gather(axes, corners, X, cells, first, count)
    moves = gather(axes, corners, u, cells, first, count)
    multiple, slope, part = _multiple(at_rest, moves)
    change = part * multiple
    pressure = numbers_or_zero(kappa, first, count) * (change / numbers(rest, first, count))
    return 0.5 * (pressure * change), part * pressure, slope


@compiled(fused=True)
def push(
    axes: Axes,
    corners: Corners,
    X: Array,
    u: Array,
    cells: Index,
    kappa: Array,
    rest: Array,
    begin: int,
    end: int,
    F: Array,
) -> float:
    """Add the force of the cells from `begin` to `end` to F (n, d); return their energy.

    They sit at X + u, points at rest and displacements, and have the stiffness κ (c,) and the
    volume V0 (c,) at rest. `cells` (c, k), of any whole numbers, say where in X, u and F a corner's
    components begin: 3i of points (n, 3). Arrays are C-contiguous, and indices are not checked.
    """
    laws = cells, kappa, rest
    stored = spread(0.0)
    whole = end - (end - begin) % WIDTH
    for e in range(begin, whole, WIDTH):
        energies, pressure, slope = _response(axes, corners, X, u, laws, e, WIDTH)
        pull(axes, corners, F, cells, e, WIDTH, pressure, slope)
        stored = stored + energies
    if whole < end:
        energies, pressure, slope = _response(axes, corners, X, u, laws, whole, end - whole)
        pull(axes, corners, F, cells, whole, end - whole, pressure, slope)
        stored = stored + energies
    return total(stored)
