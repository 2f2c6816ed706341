"""Compiled integrals of the logarithm over pairs of straight segments, with their derivatives.

Points of the plane are complex numbers. From q + t·B on one segment to p + s·A on another, s and t
in 0 ... 1, is R = Z + s·A - t·B with Z = p - q, and the mean of ln r over both is the real part of

    Q(Z, A, B) = ∫∫ log R ds dt = -[F(Z+A-B) - F(Z+A) - F(Z-B) + F(Z)] / (A·B),

F(R) = R²/2·log R - 3R²/4, whose second derivative is the logarithm. Parallel, collinear, touching
segments are no exception; only crossing ones have no branch of the logarithm. The R of a pair fill
a parallelogram, and if 0 is not inside it, no point opposite to its middle M = Z + A/2 - B/2 is: in
units of M, all R are off the negative axis.

The four terms cancel where R² is far above A·B. So segments far from each other take the series

    Q = log M - Σ C_jk (A/M)^2j (B/M)^2k,  C_jk = (2j+2k-1)! / [(2j+1)! (2k+1)! 4^(j+k)],

from the even moments of s·A - t·B about its middle, and a segment near a much shorter one is taken
in pieces, each far from it or like it. Derivatives in Z, A and B give those in the ends.

`msvalidate.dielectric.charges` gives these their meaning; `tests` hold them against quadrature.
"""

from __future__ import annotations

import math

import numpy as np

from msvalidate.springs.kernels.compiling import compiled

FAR = 6.0
"""Distance of middles over the lengths' root mean square beyond which segments are far apart."""
ALIKE = 2.0
"""Ratio of lengths up to which the closed form serves segments that are near. It has then lost up
to 50 roundings in Q, and 500 in its second derivatives."""
TERMS = 8
"""Largest j + k of the series. What it leaves out is below 1/4·FAR**(-2·TERMS), 1e-13, in second
derivatives, and far below that in Q."""
LEFT_OUT = 4e-14
"""Four times what fewer terms may leave out in second derivatives, for segments further apart."""
SERIES = np.array(
    [
        [
            math.factorial(2 * j + 2 * k - 1)
            / (math.factorial(2 * j + 1) * math.factorial(2 * k + 1) * 4 ** (j + k))
            if 0 < j + k <= TERMS
            else 0.0
            for k in range(TERMS + 1)
        ]
        for j in range(TERMS + 1)
    ]
)


@compiled(inner=True)
def square_of(r: complex) -> float:
    """|R|², without a root."""
    return r.real * r.real + r.imag * r.imag


@compiled(inner=True)
def terms_of(middle: complex, a: complex, b: complex) -> int:
    """Number of terms for segments that are far apart; 0 if near."""
    square = 0.5 * (square_of(a) + square_of(b)) / square_of(middle)
    if not square < 1 / FAR**2:
        return 0
    count, left = 1, square
    while left > LEFT_OUT and count < TERMS:
        left *= square
        count += 1
    return count


@compiled(inner=True)
def series(middle: complex, a: complex, b: complex, terms: int) -> complex:
    """The sum that Q lacks to log M."""
    one = 1 / middle
    c, d = a * one * a * one, b * one * b * one
    total = 0j
    for j in range(terms, -1, -1):
        inner = 0j
        for k in range(terms - j, -1, -1):
            inner = inner * d + SERIES[j, k]
        total = total * c + inner
    return total


@compiled()
def _far(middle: complex, a: complex, b: complex, terms: int) -> tuple[complex, ...]:
    """As `jet`, by the series. Each term is a power of A, B and M, and so are its derivatives."""
    one, one_a, one_b = 1 / middle, 1 / a, 1 / b
    c, d = a * one * a * one, b * one * b * one
    all_of = in_a = in_b = aa = ab = bb = 0j  # the last five times powers of A and B
    power = 1 + 0j
    for j in range(terms + 1):
        term = power
        for k in range(terms + 1 - j):
            value = SERIES[j, k] * term
            all_of += value
            in_a += 2 * j * value
            in_b += 2 * k * value
            aa += 2 * j * (2 * j - 1) * value
            ab += 4 * j * k * value
            bb += 2 * k * (2 * k - 1) * value
            term *= d
        power *= c
    # At M, A and B; then M = Z + A/2 - B/2.
    m, m_a, m_b = in_a + in_b, in_a + aa + ab, in_b + bb + ab
    z = (1 + m) * one
    zz = -(1 + aa + 2 * ab + bb + 2 * m) * one * one
    za, zb = m_a * one * one_a, m_b * one * one_b
    return (
        0.5 * np.log(square_of(middle)) - all_of,
        z,
        0.5 * z - in_a * one_a,
        -0.5 * z - in_b * one_b,
        zz,
        0.5 * zz + za,
        -0.5 * zz + zb,
        0.25 * zz + za - aa * one_a * one_a,
        -0.25 * zz + 0.5 * (zb - za) - ab * one_a * one_b,
        0.25 * zz - zb - bb * one_b * one_b,
    )


@compiled(inner=True)
def log_of(r: complex) -> complex:
    """Logarithm of a number; 0 for 0.

    0 is the corner where neighbours touch: any number serves, because it meets factors of 0 only.
    """
    return 0j if r == 0 else np.log(r)


@compiled()
def _near(z: complex, a: complex, b: complex) -> tuple[complex, ...]:
    """As `jet`, in closed form, in units of M."""
    middle = z + 0.5 * (a - b)
    one = 1 / middle
    z, a, b = z * one, a * one, b * one
    r0, r1, r2, r3 = z + a - b, z + a, z - b, z
    log0, log1, log2, log3 = log_of(r0), log_of(r1), log_of(r2), log_of(r3)
    first0, first1 = r0 * (log0 - 1), r1 * (log1 - 1)
    first2, first3 = r2 * (log2 - 1), r3 * (log3 - 1)
    second0, second1 = r0 * (0.5 * first0 - 0.25 * r0), r1 * (0.5 * first1 - 0.25 * r1)
    second2, second3 = r2 * (0.5 * first2 - 0.25 * r2), r3 * (0.5 * first3 - 0.25 * r3)
    one_a, one_b = 1 / a, 1 / b
    area, two = one_a * one_b, one * one
    q = -area * (second0 - second1 - second2 + second3)
    in_z = -area * (first0 - first1 - first2 + first3)
    in_a = -area * (first0 - first1) - q * one_a
    in_b = area * (first0 - first2) - q * one_b
    along_a, along_b = area * (log0 - log1), area * (log0 - log2)
    return (
        0.5 * np.log(square_of(middle)) + q,
        one * in_z,
        one * in_a,
        one * in_b,
        -two * area * (log0 - log1 - log2 + log3),
        -two * (along_a + in_z * one_a),
        two * (along_b - in_z * one_b),
        -two * (along_a + 2 * in_a * one_a),
        two * (area * (log0 - q) - in_a * one_b - in_b * one_a),
        -two * (along_b + 2 * in_b * one_b),
    )


@compiled()
def _pieces(z: complex, a: complex, b: complex) -> tuple[complex, ...]:
    """As `jet`, for A the longer: it is cut until each piece is like B or far from it."""
    q = in_z = in_a = in_b = zz = za = zb = aa = ab = bb = 0j
    s = 0.0
    while s < 1:
        h, corner = 1 - s, z + s * a
        terms = terms_of(corner + 0.5 * (h * a - b), h * a, b)
        while terms == 0 and h * abs(a) > ALIKE * abs(b):
            h *= 0.5
            terms = terms_of(corner + 0.5 * (h * a - b), h * a, b)
        if terms:
            part = _far(corner + 0.5 * (h * a - b), h * a, b, terms)
        else:
            part = _near(corner, h * a, b)
        q += h * part[0]
        in_z += h * part[1]
        in_a += h * (s * part[1] + h * part[2])
        in_b += h * part[3]
        zz += h * part[4]
        za += h * (s * part[4] + h * part[5])
        zb += h * part[6]
        aa += h * (s * s * part[4] + 2 * s * h * part[5] + h * h * part[7])
        ab += h * (s * part[6] + h * part[8])
        bb += h * part[9]
        s += h
    return q, in_z, in_a, in_b, zz, za, zb, aa, ab, bb


@compiled()
def jet(z: complex, a: complex, b: complex) -> tuple[complex, ...]:
    """Q of two segments with its derivatives: in Z, A and B; in ZZ, ZA, ZB, AA, AB and BB.

    Of Q itself only the real part has a meaning.
    """
    middle = z + 0.5 * (a - b)
    terms = terms_of(middle, a, b)
    if terms:
        return _far(middle, a, b, terms)
    if abs(b) > abs(a):
        q, in_z, in_a, in_b, zz, za, zb, aa, ab, bb = _pieces(-z, b, a)
        return q, -in_z, in_b, in_a, zz, -zb, -za, bb, ab, aa
    return _pieces(z, a, b)


@compiled()
def mean_log(z: complex, a: complex, b: complex) -> float:
    """Mean of ln r between two segments, not the same one: the real part of Q."""
    middle = z + 0.5 * (a - b)
    terms = terms_of(middle, a, b)
    if terms:
        return float(0.5 * np.log(square_of(middle)) - series(middle, a, b, terms).real)
    return float(jet(z, a, b)[0].real)
