"""Geometry of charged pieces, and their potential integrals at points.

Charges are spread evenly over straight pieces: a spring, or the halves of the springs that meet at
a node. With u along a piece from its middle, z across it and l its length, the potential of a unit
of charge per depth is [J(u+l/2, z) - J(u-l/2, z)]/(4πεl). In the plane J is the antiderivative of
-2 ln r in u; in space, where the piece is a rectangle seen from half of its depth, that of
2 asinh(depth/(2r)).
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from scipy import sparse

from msvalidate.dielectric.charges.electrodes import Electrodes
from msvalidate.problem import Array, Index
from msvalidate.problem.records import dataclass

Place = Literal["springs", "nodes"]
PLACES: tuple[Place, ...] = ("springs", "nodes")
Kernel = Literal["report", "plane"]
KERNELS: tuple[Kernel, ...] = ("report", "plane")
ON_IT = 1e-13
"""Distance from a piece over its length below which a point lies on its line."""


@dataclass(frozen=True, eq=False)
class Pieces:
    """Straight pieces of even charge that make up the unknown charges, and places of these.

    Parameters
    ----------
    joints
        (e, n) sparse: the electrodes' n points and the springs' middles, as sums of these points.
    ends
        (p, 2) joints that each piece ends at.
    owner
        (p,) the charge that each piece carries a part of, in proportion to its length.
    charge_joint
        (k,) joints at which charges have their potential prescribed, and act as points.
    electrode
        (k,) which electrode each charge belongs to.
    """

    joints: sparse.csr_array
    ends: Index
    owner: Index
    charge_joint: Index
    electrode: Index


def pieces(electrodes: Electrodes, charges_on: Place) -> Pieces:
    """Whole springs, or halves of springs gathered at their nodes."""
    segments, n, m = electrodes.segments, len(electrodes.points), len(electrodes.segments)
    rows, middle = np.repeat(np.arange(m), 2), n + np.arange(m)
    middles = sparse.coo_array((np.full(2 * m, 0.5), (rows, segments.ravel())), shape=(m, n))
    joints = sparse.csr_array(sparse.vstack([sparse.eye_array(n), middles]))
    if charges_on == "springs":
        return Pieces(joints, segments, np.arange(m), middle, electrodes.electrode)
    nodes, number = np.unique(segments, return_inverse=True)
    first, last = number.reshape(segments.shape).T
    ends = np.concatenate(
        [np.column_stack([segments[:, 0], middle]), np.column_stack([middle, segments[:, 1]])]
    )
    electrode = np.empty(len(nodes), dtype=np.intp)
    electrode[first] = electrode[last] = electrodes.electrode
    return Pieces(joints, ends, np.concatenate([first, last]), nodes, electrode)


@dataclass(frozen=True, eq=False)
class Views:
    """Potentials (k, p) of unit charges per depth on pieces, and how they change.

    `pull` (k, p, 2) by moving the point, `turn` by turning the piece, `stretch` by lengthening it;
    `direction` and `normal` (p, 2) are directions of the pieces.
    """

    mean: Array
    pull: Array
    turn: Array
    stretch: Array
    direction: Array
    normal: Array


def views_of(
    points: Array, ends: Array, *, kernel: Kernel, permittivity: float, depth: float
) -> Views:
    """Influence of straight pieces on points (k, 2).

    The pieces run from ends[:, 0] to ends[:, 1], (p, 2, 2) in m.
    """
    along = ends[:, 1] - ends[:, 0]
    length = np.hypot(*along.T)
    direction = along / length[:, None]
    normal = np.column_stack([-direction[:, 1], direction[:, 0]])
    apart = points[:, None] - ends.mean(axis=1)
    u, z = (apart * direction).sum(axis=-1), (apart * normal).sum(axis=-1)
    z = np.where(np.abs(z) < ON_IT * length, 0.0, z)
    antiderivative = _in_plane if kernel == "plane" else _in_space
    right, right_u, right_z = antiderivative(u + 0.5 * length, z, depth)
    left, left_u, left_z = antiderivative(u - 0.5 * length, z, depth)
    scale = 1 / (4 * np.pi * permittivity * length)
    mean = scale * (right - left)
    in_u, in_z = scale * (right_u - left_u), scale * (right_z - left_z)
    return Views(
        mean=mean,
        pull=in_u[..., None] * direction + in_z[..., None] * normal,
        turn=in_u * z - in_z * u,
        stretch=0.5 * scale * (right_u + left_u) - mean / length,
        direction=direction,
        normal=normal,
    )


def _in_plane(x: Array, z: Array, _depth: float) -> tuple[Array, Array, Array]:
    """Antiderivative of -2 ln r in x, with its slopes in x and z; ln 0 only meets factors of 0."""
    r = np.hypot(x, z)
    log, angle = np.log(np.where(r > 0, r, 1.0)), quotient_angle(x, z)
    return -2 * (x * log - x + z * angle), -2 * log, -2 * angle


def _in_space(x: Array, z: Array, depth: float) -> tuple[Array, Array, Array]:
    """The same of ∫dw/√(r² + w²) over the depth, seen from half of it: 2 asinh(depth/(2r))."""
    y = np.full_like(x, 0.5 * depth)
    r = np.hypot(x, z)
    slope = 2 * np.arcsinh(y / np.where(r > 0, r, y))
    return (
        2 * corner_potential(x, y, z),
        np.where(r > 0, slope, 0.0),
        -2 * quotient_angle(x * y, z * np.sqrt(r**2 + y**2)),
    )


def corner_potential(x: Array, y: Array, z: Array) -> Array:
    """∫dA/r (m) over the rectangle from (0, 0) to (x, y), seen from height z above (0, 0).

    Signed as x·y is, so that any rectangle is a sum of four.
    """
    r = np.sqrt(x**2 + y**2 + z**2)
    flat = x * _asinh_over(y, np.hypot(x, z)) + y * _asinh_over(x, np.hypot(y, z))
    return flat - z * quotient_angle(x * y, z * r)


def quotient_angle(top: Array, bottom: Array) -> Array:
    """atan(top/bottom), and 0 where the bottom is: the mean of what both sides tend to."""
    top, bottom = np.broadcast_arrays(top, bottom)
    return np.arctan(np.divide(top, bottom, out=np.zeros(top.shape), where=bottom != 0))


def _asinh_over(top: Array, bottom: Array) -> Array:
    """asinh(top/bottom), 0 where the bottom is: there it only ever meets a factor of 0."""
    top, bottom = np.broadcast_arrays(top, bottom)
    quotient = np.divide(top, bottom, out=np.zeros(top.shape), where=bottom > 0)
    return np.asarray(np.arcsinh(quotient))
