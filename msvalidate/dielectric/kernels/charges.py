"""Compiled sums over all pairs of segments: potentials, fields, forces and their changes.

The integrals over a pair are those of `segments`, and points of the plane complex numbers as there.
`msvalidate.dielectric.charges` gives them their meaning.
"""

from __future__ import annotations

import numpy as np

from msvalidate.dielectric.kernels.segments import (
    jet,
    log_of,
    mean_log,
    series,
    square_of,
    terms_of,
)
from msvalidate.problem import Array, Index
from msvalidate.springs.kernels.compiling import compiled
from msvalidate.springs.kernels.values import Complex

ON_IT = 1e-12
"""Distance from a segment over its length below which a point lies on it."""


@compiled()
def means(start: Complex, along: Complex) -> Array:
    """Means of ln r between all segments (m, m), each with itself on the diagonal."""
    m = len(start)
    mean = np.empty((m, m))
    for i in range(m):
        mean[i, i] = np.log(abs(along[i])) - 1.5
        for j in range(i):
            mean[i, j] = mean[j, i] = mean_log(start[i] - start[j], along[i], along[j])
    return mean


@compiled()
def seen(points: Complex, start: Complex, along: Complex) -> Array:
    """Means of ln r over each segment as seen from points (k, m), on the segment too."""
    mean = np.empty((len(points), len(start)))
    for i in range(len(points)):
        for j in range(len(start)):
            middle = points[i] - start[j] - 0.5 * along[j]
            terms = terms_of(middle, 0j, along[j]) if middle != 0 else 0
            if terms:
                tail = series(middle, 0j, along[j], terms).real
                mean[i, j] = 0.5 * np.log(square_of(middle)) - tail
                continue
            near, far = (points[i] - start[j]) / along[j], (points[i] - start[j]) / along[j] - 1
            inside = (near * log_of(near) - far * log_of(far)).real
            mean[i, j] = np.log(abs(along[j])) - 1 + inside
    return mean


@compiled()
def fields(points: Complex, start: Complex, along: Complex) -> Complex:
    """Means of 1/R over each segment as seen from points (k, m).

    The conjugate is the field of a unit line charge, times 2πε: on the segment the mean of its
    sides, NaN at its ends.
    """
    mean = np.empty((len(points), len(start)), dtype=np.complex128)
    for i in range(len(points)):
        for j in range(len(start)):
            near, far = (points[i] - start[j]) / along[j], (points[i] - start[j]) / along[j] - 1
            if min(abs(near), abs(far)) < ON_IT:
                mean[i, j] = np.nan
                continue
            turned = np.log(near / far)
            beside = abs(near.imag) < ON_IT and near.real > 0 and far.real < 0
            mean[i, j] = (turned.real if beside else turned) / along[j]
    return mean


@compiled()
def pulled(start: Complex, along: Complex, ends: Index, charge: Array, nodes: int) -> Complex:
    """Derivative of Σᵢⱼ qᵢ·qⱼ·(mean of ln r)ᵢⱼ in the nodes (n,).

    Complex: that of a point z in x is its real part, in y minus its imaginary part.
    """
    total = np.zeros(nodes, dtype=np.complex128)
    for i in range(len(start)):
        square = charge[i] * charge[i] / along[i]
        total[ends[i, 0]] -= square
        total[ends[i, 1]] += square
        for j in range(i):
            slope = jet(start[i] - start[j], along[i], along[j])
            twice = 2 * charge[i] * charge[j]
            total[ends[i, 0]] += twice * (slope[1] - slope[2])
            total[ends[i, 1]] += twice * slope[2]
            total[ends[j, 0]] -= twice * (slope[1] + slope[3])
            total[ends[j, 1]] += twice * slope[3]
    return total


@compiled()
def turned(
    start: Complex, along: Complex, ends: Index, weight: Array, charge: Array, nodes: int
) -> tuple[Complex, Complex, Complex]:
    """Derivatives in the nodes of Σⱼ Lᵢⱼ·chargeⱼ, of Σⱼ Lᵢⱼ·weightⱼ, and second ones.

    L are means of ln r between segments. Derivatives are (m, n), (m, n) and (n, n), the last of
    Σᵢⱼ weightᵢ·Lᵢⱼ·chargeⱼ. Complex: that of a point z in x is its real part, in y minus its
    imaginary part.
    """
    seen = np.zeros((len(start), nodes), dtype=np.complex128)
    sent = np.zeros((len(start), nodes), dtype=np.complex128)
    second = np.zeros((nodes, nodes), dtype=np.complex128)
    slope, bend = np.empty(4, dtype=np.complex128), np.empty((4, 4), dtype=np.complex128)
    at = np.empty(4, dtype=np.intp)
    for i in range(len(start)):
        one = 1 / along[i]
        seen[i, ends[i, 0]] -= charge[i] * one
        seen[i, ends[i, 1]] += charge[i] * one
        sent[i, ends[i, 0]] -= weight[i] * one
        sent[i, ends[i, 1]] += weight[i] * one
        square = weight[i] * charge[i] * one * one
        second[ends[i, 0], ends[i, 0]] -= 0.5 * square
        second[ends[i, 1], ends[i, 1]] -= 0.5 * square
        second[ends[i, 0], ends[i, 1]] += square
        for j in range(i):
            _, z, a, b, zz, za, zb, aa, ab, bb = jet(start[i] - start[j], along[i], along[j])
            at[0], at[1], at[2], at[3] = ends[i, 0], ends[i, 1], ends[j, 0], ends[j, 1]
            # In the four ends: Z = p - q, A = p' - p, B = q' - q.
            slope[0], slope[1], slope[2], slope[3] = z - a, a, -z - b, b
            # Of second ones this is a half, the other half is its transpose.
            bend[0, 0], bend[0, 1], bend[1, 1] = 0.5 * (zz + aa) - za, za - aa, 0.5 * aa
            bend[0, 2], bend[0, 3] = za + ab - zz - zb, zb - ab
            bend[1, 2], bend[1, 3] = -za - ab, ab
            bend[2, 2], bend[2, 3], bend[3, 3] = 0.5 * (zz + bb) + zb, -zb - bb, 0.5 * bb
            both = weight[i] * charge[j] + weight[j] * charge[i]
            for c in range(4):
                seen[i, at[c]] += charge[j] * slope[c]
                seen[j, at[c]] += charge[i] * slope[c]
                sent[i, at[c]] += weight[j] * slope[c]
                sent[j, at[c]] += weight[i] * slope[c]
                for d in range(c, 4):
                    second[at[c], at[d]] += both * bend[c, d]
    for c in range(nodes):
        for d in range(c + 1):
            second[c, d] += second[d, c]
            second[d, c] = second[c, d]
    return seen, sent, second
