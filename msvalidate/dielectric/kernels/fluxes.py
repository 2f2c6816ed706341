"""Compiled flux of the field of one straight segment through another, with its derivatives.

Letters as in `kernels.segments`. Of the flux of a unit line charge, spread evenly over q + t·B, the
part Im G/(2π) crosses p + s·A to the right of A, and Re G/(2πε) is the voltage lost along A:

    G = A·∂Q/∂Z = ∫∫ A/(Z + s·A - t·B) ds dt.

Im G is the angle under which a segment is seen, averaged over the other: around a closed line it
adds up to π for every segment of that line, exactly, and no charge is lost.
"""

from __future__ import annotations

import numpy as np

from msvalidate.dielectric.kernels.segments import jet
from msvalidate.problem import Array, Index
from msvalidate.springs.kernels.compiling import compiled
from msvalidate.springs.kernels.values import Complex

TOUCHING = 1e-9
"""Distance of two corners over the lengths of their segments below which they are one corner."""
CHAIN = np.array([[1.0, -1, 0], [0, 1, 0], [-1, 0, -1], [0, 0, 1]])
"""Derivatives of Z, A and B in the four ends of a pair."""


@compiled()
def crossed(start: Complex, along: Complex) -> Complex:
    """G between all segments (m, m): through the first, of charge on the second. 0 by itself."""
    m = len(start)
    part = np.zeros((m, m), dtype=np.complex128)
    for i in range(m):
        for j in range(i):
            in_z = jet(start[i] - start[j], along[i], along[j])[1]
            part[i, j] = along[i] * in_z
            part[j, i] = -along[j] * in_z
    return part


@compiled()
def dragged(
    start: Complex, along: Complex, ends: Index, weight: Array, charge: Array, nodes: int
) -> Complex:
    """Derivative of Σᵢⱼ weightᵢ·chargeⱼ·Im Gᵢⱼ in the nodes (n,), complex.

    That of a point in x is its real part, in y minus its imaginary part.
    """
    total = np.zeros(nodes, dtype=np.complex128)
    for i in range(len(start)):
        for j in range(i):
            through_i, through_j = weight[i] * charge[j], weight[j] * charge[i]
            if through_i == 0 and through_j == 0:
                continue
            _, mean, _, _, zz, za, zb, _, _, _ = jet(start[i] - start[j], along[i], along[j])
            both = through_i * along[i] - through_j * along[j]
            in_z = both * zz
            in_a = both * za + through_i * mean
            in_b = both * zb - through_j * mean
            # The real part of -iG is the imaginary part of G.
            total[ends[i, 0]] -= 1j * (in_z - in_a)
            total[ends[i, 1]] -= 1j * in_a
            total[ends[j, 0]] += 1j * (in_z + in_b)
            total[ends[j, 1]] -= 1j * in_b
    return total


@compiled(inner=True)
def _inverse(r: complex, nothing: float) -> complex:
    """1/R; at a corner where neighbours touch it only meets factors of 0, and 0 serves."""
    return 0j if abs(r) < nothing else 1 / r


@compiled()
def twisted(
    start: Complex, along: Complex, ends: Index, weight: Array, charge: Array, nodes: int
) -> tuple[Complex, Complex, Complex]:
    """Derivatives in the nodes of Σⱼ Im Gᵢⱼ·chargeⱼ, of Σᵢ weightᵢ·Im Gᵢⱼ, and second ones of both.

    They are (m, n), (m, n) and (n, n), complex as those of `kernels.charges`. Second derivatives of
    G are quotients of 1/R at the corners of a pair.
    """
    m = len(start)
    through = np.zeros((m, nodes), dtype=np.complex128)
    sent = np.zeros((m, nodes), dtype=np.complex128)
    second = np.zeros((nodes, nodes), dtype=np.complex128)
    bend, at = np.empty((3, 3), dtype=np.complex128), np.empty(4, dtype=np.intp)
    for i in range(m):
        for j in range(m):
            if i == j:
                continue
            z, a, b = start[i] - start[j], along[i], along[j]
            _, mean, _, _, zz, za, zb, _, _, _ = jet(z, a, b)
            slope = a * zz, mean + a * za, a * zb
            near = TOUCHING * (abs(a) + abs(b))
            both, only_a = _inverse(z + a - b, near), _inverse(z + a, near)
            only_b, none = _inverse(z - b, near), _inverse(z, near)
            bend[0, 0] = -(both - only_a - only_b + none) / b
            bend[0, 1] = bend[1, 0] = bend[1, 1] = -(both - only_a) / b
            bend[0, 2] = bend[2, 0] = (both - only_b - slope[0]) / b
            bend[1, 2] = bend[2, 1] = (both - slope[1]) / b
            bend[2, 2] = -(both - only_b + 2 * slope[2]) / b
            at[0], at[1], at[2], at[3] = ends[i, 0], ends[i, 1], ends[j, 0], ends[j, 1]
            for c in range(4):
                moved = 0j
                for k in range(3):
                    moved += slope[k] * CHAIN[c, k]
                through[i, at[c]] += charge[j] * moved
                sent[j, at[c]] += weight[i] * moved
                for d in range(4):
                    for k in range(3):
                        for o in range(3):
                            turned = CHAIN[c, k] * bend[k, o] * CHAIN[d, o]
                            second[at[c], at[d]] += weight[i] * charge[j] * turned
    return -1j * through, -1j * sent, -1j * second
