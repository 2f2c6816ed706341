"""Displacements of the same elements, assembled and solved to a hundred digits.

Shares nothing with the code under test: integrals of polynomials on boxes and simplices in closed
form, over the rational numbers that the coordinates are, and ball arithmetic for the solution, whose
own error is known (python-flint).
"""

from __future__ import annotations

from itertools import product

import numpy as np
from flint import arb, arb_mat, ctx, fmpq

BITS = 400
"""Of the numbers: a condition of 1e30 leaves 90 digits."""


def exact(number):
    """A double as the fraction that it is."""
    return fmpq(*float(number).as_integer_ratio())


def lame(material):
    """Lamé's constants of the state, from the fractions that E and nu are."""
    E, nu = exact(material.E), exact(material.nu)
    if material.state == "plane_stress":
        return E * nu / (1 - nu * nu), E / (2 * (1 + nu))
    return E * nu / ((1 + nu) * (1 - 2 * nu)), E / (2 * (1 + nu))


def integrals(coefficients):
    """∫ f_i f_j, ∫ f_i' f_j and ∫ f_i' f_j' over (0, 1) of polynomials by rising powers."""
    slopes = [[k * c for k, c in enumerate(row)][1:] for row in coefficients]

    def pairs(left, right):
        return [
            [
                sum(
                    (p * q / fmpq(i + j + 1) for i, p in enumerate(a) for j, q in enumerate(b)),
                    fmpq(0),
                )
                for b in right
            ]
            for a in left
        ]

    return pairs(coefficients, coefficients), pairs(slopes, coefficients), pairs(slopes, slopes)


LINES = {
    1: integrals([[fmpq(1), fmpq(-1)], [fmpq(0), fmpq(1)]]),
    2: integrals(
        [
            [fmpq(1), fmpq(-3), fmpq(2)],
            [fmpq(0), fmpq(4), fmpq(-4)],
            [fmpq(0), fmpq(-1), fmpq(2)],
        ]
    ),
}


def box_products(x, degree):
    """∫ ∂c φi ∂d φj of a box of nodes (k, d), as [c][d][i][j]."""
    low, size = x.min(axis=0), np.ptp(x, axis=0)
    place = np.round(degree * (x - low) / size).astype(int)
    h = [exact(x[:, a].max()) - exact(x[:, a].min()) for a in range(x.shape[1])]
    mass, mixed, stiff = LINES[degree]

    def one(axis, c, d, i, j):
        if axis == c == d:
            return stiff[i][j] / h[axis]
        if axis == c:
            return mixed[i][j]
        return mixed[j][i] if axis == d else mass[i][j] * h[axis]

    def entry(c, d, i, j):
        value = fmpq(1)
        for axis in range(len(h)):
            value *= one(axis, c, d, int(place[i, axis]), int(place[j, axis]))
        return value

    return entry


def simplex_products(x, degree):
    """The same of a simplex of nodes (k, d), corners first."""
    d = x.shape[1]
    corner = [[exact(v) for v in row] for row in x[: d + 1]]
    sides = [[corner[j + 1][a] - corner[0][a] for a in range(d)] for j in range(d)]
    if d == 2:
        (a, b), (c, e) = sides
        det = a * e - b * c
        inverse = [[e / det, -b / det], [-c / det, a / det]]
    else:

        def cross(u, v):
            return [
                u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3] for i in range(3)
            ]

        det = sum((p * q for p, q in zip(sides[0], cross(sides[1], sides[2]))), fmpq(0))
        rows = [cross(sides[1], sides[2]), cross(sides[2], sides[0]), cross(sides[0], sides[1])]
        inverse = [[rows[j][a] / det for j in range(3)] for a in range(3)]
    slope = [[inverse[a][j] for a in range(d)] for j in range(d)]  # of barycentric 1 to d
    slope.insert(0, [-sum((s[a] for s in slope), fmpq(0)) for a in range(d)])
    volume = abs(det) / (2 if d == 2 else 6)
    edges = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))[: 3 if d == 2 else 6]
    # Gradients as Σ_a g[a] λ_a, with 1 = Σ λ.
    gradients = []
    for i in range(d + 1):
        weight = [fmpq(1)] * (d + 1)
        if degree == 2:
            weight = [fmpq(3 if a == i else -1) for a in range(d + 1)]
        gradients.append([[w * s for s in slope[i]] for w in weight])
    for i, j in edges if degree == 2 else ():
        zero = [fmpq(0)] * d
        each = [list(zero) for _ in range(d + 1)]
        each[i], each[j] = [4 * s for s in slope[j]], [4 * s for s in slope[i]]
        gradients.append(each)

    def entry(c, e, i, j):
        total = fmpq(0)
        for a, b in product(range(d + 1), repeat=2):
            share = fmpq(2 if a == b else 1) / ((d + 1) * (d + 2))
            total += gradients[i][a][c] * gradients[j][b][e] * share
        return total * volume

    return entry


def displacement(body, material, held, moved, force):
    """Displacement (n, d) in m, exact to the last bit of a double."""
    ctx.prec = BITS
    n, d = body.points.shape
    lam, mu = lame(material)
    t = exact(material.thickness)
    K = {}
    products = simplex_products if body.element.simplex else box_products
    for cell in body.cells:
        entry, made = products(body.points[cell], body.element.degree), {}
        for i, j in product(range(len(cell)), repeat=2):
            grid = [[entry(a, b, i, j) for b in range(d)] for a in range(d)]
            trace = sum((grid[a][a] for a in range(d)), fmpq(0))
            for a, b in product(range(d), repeat=2):
                made = lam * grid[a][b] + mu * grid[b][a] + (mu * trace if a == b else 0)
                key = int(cell[i]) * d + a, int(cell[j]) * d + b
                K[key] = K.get(key, fmpq(0)) + t * made
    free = np.flatnonzero(~held.ravel())
    number = {int(k): i for i, k in enumerate(free)}
    right = [arb(exact(force.ravel()[k])) for k in free]
    A = [[arb(0)] * len(free) for _ in free]
    for (row, column), value in K.items():
        if row not in number:
            continue
        if column in number:
            A[number[row]][number[column]] = arb(value)
        else:
            right[number[row]] -= arb(value * exact(moved.ravel()[column]))
    found = arb_mat(A).solve(arb_mat([[value] for value in right]))
    u = np.where(held, moved, 0.0).ravel()
    u[free] = [float(found[i, 0].mid()) for i in range(len(free))]
    return u.reshape(n, d)
