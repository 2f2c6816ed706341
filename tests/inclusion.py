"""A disc or ball of another material in an endless body: closed forms, and meshes of it.

Strain inside is uniform [Eshelby1957]; outside it is that of [Goodier1933], derived here anew.
Plane, stressed far away by σxx = p + q and σyy = p - q, with Kolosov's κ (3 - 4 nu in plane strain,
(3 - nu)/(1 + nu) in plane stress) and K = 2μ/(κ - 1). In polar coordinates, a the radius:

    inside    u_r = (A + D cos 2θ) r,  u_θ = -D r sin 2θ
    outside   u_r = C r + b a²/r + (q r + (κ + 1) G a²/r + H a⁴/r³) cos 2θ / 2μ
              u_θ = (-q r - (κ - 1) G a²/r + H a⁴/r³) sin 2θ / 2μ

from φ = G a²/z and ψ = -q z - H a⁴/z³. Displacement and traction are continuous at r = a for
C = p/2K, b = C (K - K1)/(K1 + μ), A = C + b, G = q (μ - μ1)/(μ + κ μ1), H = -G,
D = (q - G)/2μ1. A hole, μ1 = K1 = 0, has G = q: Kirsch's plate.

In space under σ = p I the same way: u = (C + b a³/r³) x outside and A x inside, C = p/3K,
b = 3 C (K - K1)/(3 K1 + 4 μ), A = C + b.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from msvalidate.problem import SHAPES, Array, Ball, Index, Isotropic, Mesh

RADIUS = 0.5
DISC = Ball((0.0, 0.0), RADIUS)
BALL = Ball((0.0, 0.0, 0.0), RADIUS)


def moduli(material: Isotropic) -> tuple[float, float, float]:
    """μ, K and Kolosov's κ; of a solid K and no κ."""
    mu = material.E / (2 * (1 + material.nu))
    if material.state == "solid":
        return mu, material.E / (3 * (1 - 2 * material.nu)), np.nan
    strain = material.state == "plane_strain"
    kappa = 3 - 4 * material.nu if strain else (3 - material.nu) / (1 + material.nu)
    return mu, 2 * mu / (kappa - 1), kappa


def disc(x: Array, outer: Isotropic, inner: Isotropic, p: float, q: float) -> Array:
    """Displacement (n, 2) at places (n, 2) from the middle of a disc."""
    (mu, K, kappa), (mu1, K1, _) = moduli(outer), moduli(inner)
    C = p / (2 * K)
    b, G = C * (K - K1) / (K1 + mu), q * (mu - mu1) / (mu + kappa * mu1)
    D, r = (q - G) / (2 * mu1), np.hypot(*x.T)
    cos, sin = x.T / np.maximum(r, np.finfo(float).tiny)
    a, R = RADIUS, np.maximum(r, RADIUS)
    radial = (q * R + (kappa + 1) * G * a**2 / R - G * a**4 / R**3) / (2 * mu)
    around = (-q * R - (kappa - 1) * G * a**2 / R - G * a**4 / R**3) / (2 * mu)
    out = r > a
    cos2, sin2 = cos**2 - sin**2, 2 * cos * sin
    ur = np.where(out, C * R + b * a**2 / R + radial * cos2, (C + b) * r + D * r * cos2)
    ut = np.where(out, around * sin2, -D * r * sin2)
    return np.column_stack([ur * cos - ut * sin, ur * sin + ut * cos])


def ball(x: Array, outer: Isotropic, inner: Isotropic, p: float) -> Array:
    """Displacement (n, 3) at places (n, 3) from the middle of a ball."""
    (mu, K, _), (_, K1, _) = moduli(outer), moduli(inner)
    C = p / (3 * K)
    b = 3 * C * (K - K1) / (3 * K1 + 4 * mu)
    return (C + b * (RADIUS / np.maximum(np.linalg.norm(x, axis=1), RADIUS)) ** 3)[:, None] * x


def disc_mesh(n: int) -> Mesh:
    """A square of side 2 about a disc, of quadrilaterals with 9 nodes: n along each of 9 blocks.

    Cells of the disc are the zone "disc".
    """
    s, t = np.meshgrid(*[np.linspace(0, 1, 2 * n + 1)] * 2, indexing="ij")
    core = RADIUS / 2
    side = np.stack([np.ones_like(t), 2 * t - 1], axis=-1)
    turn = np.pi / 4 * (2 * t - 1)
    arc = RADIUS * np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    s = s[..., None]
    rings = (1 - s) * core * side + s * arc, (1 - s) * arc + s * side
    quarter = np.array([[0.0, -1.0], [1.0, 0.0]])
    blocks = [core * np.stack([2 * s[..., 0] - 1, 2 * t - 1], axis=-1)]
    for ring, k in product(rings, range(4)):
        blocks.append(ring @ np.linalg.matrix_power(quarter, k).T)
    points, cells, inner = _joined(blocks, n, 5)
    return Mesh(points, cells, "quad9", zones={"disc": inner})


def ball_mesh(n: int) -> Mesh:
    """The octant of `ball_cells` as a body; cells of the ball are the zone "disc"."""
    points, cells, inner = ball_cells(n)
    return Mesh(points, cells, "hexahedron27", zones={"disc": inner})


def ball_cells(n: int) -> tuple[Array, Index, Index]:
    """An octant of a cube of side 2 about a ball: points, cells, and which are the ball's.

    Of hexahedra with 27 nodes, n along each of 7 blocks.
    """
    grid = np.stack(np.meshgrid(*[np.linspace(0, 1, 2 * n + 1)] * 3, indexing="ij"), axis=-1)
    s, face = grid[..., :1], np.concatenate([np.ones_like(grid[..., :1]), grid[..., 1:]], axis=-1)
    core = RADIUS / 2
    arc = RADIUS * face / np.linalg.norm(face, axis=-1, keepdims=True)
    blocks = [core * grid]
    for ring, k in product(((1 - s) * core * face + s * arc, (1 - s) * arc + s * face), range(3)):
        blocks.append(np.roll(ring, k, axis=-1))
    return _joined(blocks, n, 4)


def _joined(blocks: list[Array], n: int, inner: int) -> tuple[Array, Index, Index]:
    """Points and cells of blocks of nodes (2n + 1, .., d), and which are of the first few."""
    d = blocks[0].shape[-1]
    shape = {2: "quad9", 3: "hexahedron27"}[d]
    places = np.concatenate([block.reshape(-1, d) for block in blocks])
    _, first, number = np.unique(
        np.round(places, 9) + 0.0, axis=0, return_index=True, return_inverse=True
    )
    local = (2 * SHAPES[shape].nodes).astype(int)
    low = np.array(list(product(range(0, 2 * n, 2), repeat=d)))
    at = low[:, None] + local
    each = np.ravel_multi_index(tuple(np.moveaxis(at, -1, 0)), (2 * n + 1,) * d)
    cells = np.concatenate([each + i * (2 * n + 1) ** d for i in range(len(blocks))])
    return places[first], number.ravel()[cells], np.arange(inner * n**d)
