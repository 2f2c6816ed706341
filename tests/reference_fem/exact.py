"""Displacements of elements to the last bit of a double, whatever the condition.

Nothing is shared with the code under test: integrals of polynomials on boxes and simplices in
closed form, over the rational numbers that the coordinates are, and ball arithmetic of a hundred
digits for the solution (python-flint). Large strain has a residual of its own in long doubles.
"""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from reference_fem.materials import CellMaterials

flint = pytest.importorskip("flint", reason="python-flint makes the exact values")
arb, arb_mat, ctx, fmpq = flint.arb, flint.arb_mat, flint.ctx, flint.fmpq

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


def pairs(left, right):
    """∫ f_i g_j over (0, 1) of polynomials by rising powers."""
    return [
        [
            sum(
                (p * q / fmpq(i + j + 1) for i, p in enumerate(a) for j, q in enumerate(b)), fmpq(0)
            )
            for b in right
        ]
        for a in left
    ]


def slopes(rows):
    return [[k * c for k, c in enumerate(row)][1:] for row in rows]


def integrals(f):
    """∫ f_i f_j, ∫ f_i' f_j and ∫ f_i' f_j' over (0, 1)."""
    return pairs(f, f), pairs(slopes(f), f), pairs(slopes(f), slopes(f))


LINEAR = [[fmpq(1), fmpq(-1)], [fmpq(0), fmpq(1)]]
QUADRATIC = [
    [fmpq(1), fmpq(-3), fmpq(2)],
    [fmpq(0), fmpq(4), fmpq(-4)],
    [fmpq(0), fmpq(-1), fmpq(2)],
]
LINES = {1: integrals(LINEAR), 2: integrals(QUADRATIC)}
BOTH = pairs(LINEAR, QUADRATIC), pairs(LINEAR, slopes(QUADRATIC))


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


def serendipity_products(x, degree):
    """The same of a rectangle of nodes (8, 2): the biquadratic functions, the middle's shared out.

    A field without x²y² has in the middle half the sum of its mid-sides less a quarter of its
    corners'.
    """
    whole = box_products(np.vstack([x, x[:4].mean(axis=0)]), degree)
    share = [fmpq(-1, 4)] * 4 + [fmpq(1, 2)] * 4

    def entry(c, d, i, j):
        value = whole(c, d, i, j) + share[j] * whole(c, d, i, 8)
        return value + share[i] * (whole(c, d, 8, j) + share[j] * whole(c, d, 8, 8))

    return entry


def products_of(kind):
    if kind.simplex:
        return simplex_products
    return box_products if kind.nodes == (kind.degree + 1) ** kind.dim else serendipity_products


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

        det = sum(
            (p * q for p, q in zip(sides[0], cross(sides[1], sides[2]), strict=True)), fmpq(0)
        )
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


def pressure_products(x, d):
    """∫ q_i ∂c φ_j, as [c][i][j], and ∫ q_i q_j of a box of nodes (k, d), q at its corners."""
    low, size = x.min(axis=0), np.ptp(x, axis=0)
    place = np.round(2 * (x - low) / size).astype(int)
    h = [exact(x[:, a].max()) - exact(x[:, a].min()) for a in range(d)]

    def divergence(c, i, j):
        value = fmpq(1)
        for a in range(d):
            p, q = int(place[i, a]) // 2, int(place[j, a])
            value *= BOTH[1][p][q] if a == c else BOTH[0][p][q] * h[a]
        return value

    def mass(i, j):
        value = fmpq(1)
        for a in range(d):
            value *= LINES[1][0][int(place[i, a]) // 2][int(place[j, a]) // 2] * h[a]
        return value

    return divergence, mass


def elastic_entries(x, kind, lam, mu):
    """Pairs (node and axis twice) of a cell of nodes (k, d), with λ and μ."""
    entry, d = products_of(kind)(x, kind.degree), x.shape[1]
    for i, j in product(range(len(x)), repeat=2):
        grid = [[entry(a, b, i, j) for b in range(d)] for a in range(d)]
        trace = sum((grid[a][a] for a in range(d)), fmpq(0))
        for a, b in product(range(d), repeat=2):
            yield i, a, j, b, lam * grid[a][b] + mu * grid[b][a] + (mu * trace if a == b else 0)


def system(body, law, mixed):
    """Entries of K by row and column, point-major, pressures after all displacements; their count.

    A pressure is its material's at a corner.
    """
    n, d = body.points.shape
    K, pressures = {}, {}

    def add(row, column, value):
        K[row, column] = K.get((row, column), fmpq(0)) + exact(law.thickness) * value

    for number, cell in enumerate(body.cells.tolist()):
        own = int(law.number[number]) if isinstance(law, CellMaterials) else 0
        material = law.materials[own] if isinstance(law, CellMaterials) else law
        x, (lam, mu) = body.points[cell], lame(material) if not mixed else (fmpq(0), None)
        E, nu = exact(material.E), exact(material.nu)
        for i, a, j, b, value in elastic_entries(x, body.element, lam, mu or E / (2 * (1 + nu))):
            add(cell[i] * d + a, cell[j] * d + b, value)
        if not mixed:
            continue
        divergence, mass = pressure_products(x, d)
        soft, corners = (1 + nu) * (1 - 2 * nu) / (E * nu), range(body.element.corners)
        p = [pressures.setdefault((own, cell[i]), len(pressures)) + n * d for i in corners]
        for i, j, c in product(corners, range(len(cell)), range(d)):
            add(p[i], cell[j] * d + c, divergence(c, i, j))
            add(cell[j] * d + c, p[i], divergence(c, i, j))
        for i, j in product(corners, repeat=2):
            add(p[i], p[j], -soft * mass(i, j))
    return K, len(pressures)


def exact_displacement(body, law, held, moved, force, mixed=False):
    """Displacement (n, d) in m, exact to the last bit of a double."""
    ctx.prec = BITS
    n, d = body.points.shape
    K, count = system(body, law, mixed)
    free = np.flatnonzero(np.append(~held.ravel(), np.ones(count, dtype=bool)))
    number = {int(k): i for i, k in enumerate(free)}
    given = np.append(force.ravel(), np.zeros(count))
    right = [arb(exact(given[k])) for k in free]
    A = [[arb(0)] * len(free) for _ in free]
    for (row, column), value in K.items():
        if row not in number:
            continue
        if column in number:
            A[number[row]][number[column]] = arb(value)
        else:
            right[number[row]] -= arb(value * exact(moved.ravel()[column]))
    found = arb_mat(A).solve(arb_mat([[value] for value in right]))
    u = np.append(np.where(held, moved, 0.0).ravel(), np.zeros(count))
    u[free] = [float(found[i, 0].mid()) for i in range(len(free))]
    return u[: n * d].reshape(n, d)


def large_strain_displacement(solid, lam, mu, force, start):
    """Displacement (n, d) near a start at which St Venant and Kirchhoff's law holds the forces.

    S = λ tr(E) I + 2μ E with E = (FᵀF - I)/2, by the mesh's own rule; its residual in long doubles.
    """
    body, long = solid.body, np.longdouble
    kind, X = body.element, np.asarray(body.basis.X)
    slope = kind.functions(X.T)[1].astype(long)  # (k, d, q)
    nodes, d = body.cell_nodes, body.dim
    x = body.points.astype(long)[nodes[:, : kind.corners]]  # sides are straight
    shape = np.array([kind.linear.lbasis(X, i)[1] for i in range(kind.corners)]).astype(long)
    J = np.einsum("kjq,ckd->cqdj", shape, x - x[:, :1])
    (a, b), (c, e) = J[..., 0, :].transpose(2, 0, 1), J[..., 1, :].transpose(2, 0, 1)
    det = a * e - b * c
    inverse = np.stack([np.stack([e, -b], -1), np.stack([-c, a], -1)], -2) / det[..., None, None]
    G = np.einsum("kjq,cqjd->cqkd", slope, inverse)
    weight = long(solid.thickness) * np.abs(det) * np.asarray(body.basis.W).astype(long)
    u = start.astype(long)
    for _ in range(40):
        v = u[nodes]
        F = np.einsum("ckd,cqke->cqde", v - v[:, :1], G)
        strain = (F + F.swapaxes(2, 3) + np.einsum("cqad,cqae->cqde", F, F)) / 2
        S = 2 * long(mu) * strain
        trace = np.trace(strain, axis1=2, axis2=3)
        for axis in range(d):
            S[..., axis, axis] += long(lam) * trace
            F[..., axis, axis] += 1
        each = np.einsum("cqae,cqeb,cqkb,cq->cka", F, S, G, weight)
        left = force.astype(long)
        np.add.at(left, nodes, -each)
        K = solid.tangent(u.astype(float))
        free = np.flatnonzero(~solid.held.T.ravel())
        step = np.zeros(u.size)
        step[free] = np.linalg.solve(K[free][:, free].toarray(), left.T.ravel()[free].astype(float))
        u = u + solid.by_node(step)
        if np.abs(step).max() <= 1e-18 * np.abs(u).max():
            break
    return u
