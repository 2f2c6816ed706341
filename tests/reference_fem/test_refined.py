"""Answers of slender, far and thin bodies: right within the error that they state, or refused.

The oracle shares nothing with the code under test: integrals of polynomials on boxes and simplices
in closed form, over the rational numbers that the coordinates are, and ball arithmetic of a hundred
digits for the solution (python-flint).
"""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

import reference_fem
from msvalidate.problem import Box, Isotropic, Problem, ProblemError, SolverError, Support, Traction
from reference_fem.elasticity import make_solver, stiffness
from reference_fem.mesh.elements import ELEMENTS
from reference_fem.systems import Solver

flint = pytest.importorskip("flint", reason="python-flint makes the exact values")
arb, arb_mat, ctx, fmpq = flint.arb, flint.arb_mat, flint.ctx, flint.fmpq
pytestmark = pytest.mark.filterwarnings("error")

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


def exact_displacement(body, material, held, moved, force):
    """Displacement (n, d) in m, exact to the last bit of a double."""
    ctx.prec = BITS
    n, d = body.points.shape
    lam, mu = lame(material)
    t = exact(material.thickness)
    K = {}
    products = products_of(body.element)
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


REFUSED = None
DRAWN = {2: ("Q1", "Q2", "P1", "P2"), 3: ("H1", "H2", "T1", "T2")}
"""Fixed: the seeds below were chosen for what they draw from these."""


def drawn(seed, ordinary, element=None):
    """A body, its material, what is held, and forces on its nodes, by chance."""
    rng = np.random.default_rng(seed)
    if element is None:
        d = 2 if rng.random() < 0.7 else 3
        element = str(rng.choice(DRAWN[d]))
    d = ELEMENTS[element].dim
    small = d == 3 and ELEMENTS[element].degree == 2
    along = int(rng.integers(2, 3 if small else 6 if d == 3 else 10))
    across = int(rng.integers(1, 2 if d == 3 else 3))
    height = 0.37
    ratio = 10 ** rng.uniform(0, 3 if ordinary else 4)
    box = Box((height * ratio, *([height] * (d - 1))))
    cells = (along, *([across] * (d - 1)))
    made = reference_fem.box_discretisation(box, cells, element)
    points = made.points
    if rng.random() < 0.5:
        points = points + rng.normal(size=d) * box.size[0] * 10 ** rng.uniform(
            0, 3 if ordinary else 7
        )
    nu = rng.uniform(-0.5, 0.49)
    if d == 2:
        state = str(rng.choice(["plane_stress", "plane_strain"]))
        material = Isotropic(10 ** rng.uniform(0, 9), nu, state, thickness=0.2)
    else:
        material = Isotropic(10 ** rng.uniform(0, 9), nu, "solid")
    body = reference_fem.make_discretisation(points, made.cells, element)
    x = body.points[:, 0]
    held = np.zeros(points.shape, dtype=bool)
    held[x == x.min()] = True
    force = np.zeros(points.shape)
    loaded = x == x.max() if rng.random() < 0.5 else ~held[:, 0]
    force[loaded] = rng.normal(size=(loaded.sum(), d)) * material.E * 1e-6
    moved = np.zeros(points.shape)
    if rng.random() < 0.3:
        moved[held] = rng.normal(size=held.sum()) * 1e-6
    return body, material, held, moved, force


def stated_and_true(seed, ordinary, element=None):
    """Stated and true error of one body, relative to its largest displacement."""
    try:
        body, material, held, moved, force = drawn(seed, ordinary, element)
        solver = make_solver(body, material, held, allow_locked=True)
        found, how = solver.solve(moved, force)
    except (SolverError, ProblemError):
        return REFUSED
    right = exact_displacement(body, material, held, moved, force)
    return how.error, np.abs(found - right).max() / np.abs(right).max()


def judged(seeds, ordinary):
    """No answer is off by more than it says; ordinary bodies are answered, and not vaguely."""
    pairs = [stated_and_true(seed, ordinary) for seed in seeds]
    known = np.array([pair for pair in pairs if pair is not REFUSED])
    stated, true = known.T
    missed = np.array(seeds)[[p is not REFUSED for p in pairs]][true > stated]
    assert not len(missed), f"seeds {missed}"
    if ordinary:
        assert len(known) >= 0.95 * len(pairs)
    worth = true > 1e-14
    if worth.sum() >= 20:  # fewer have no median to speak of
        assert np.median(stated[worth] / true[worth]) <= 100
    return len(known), len(pairs), stated, true


def test_stated_errors_of_ordinary_bodies():
    judged(range(6), ordinary=True)


@pytest.mark.parametrize("ordinary", [True, False])
@pytest.mark.parametrize("element", ELEMENTS)
def test_stated_errors_of_each_element(element, ordinary):
    for seed in (1, 2):
        pair = stated_and_true(seed, ordinary, element)
        assert pair is not REFUSED or not ordinary
        if pair is not REFUSED:
            stated, true = pair
            assert true <= stated


def test_stated_errors_of_bodies_to_ten_thousand_to_one():
    judged(range(100, 106), ordinary=False)


@pytest.mark.parametrize("seed", [5249, 5329, 5348])
def test_directions_are_gone_along_until_nothing_is_left_of_a_first_step(seed):
    # The factor is blind to the softest motion; a first step along it, as long as the answer and
    # more, left 1.8e-5 of 5249's answer, a hundred thousand times the last correction.
    stated, true = stated_and_true(seed, ordinary=False)
    assert true <= stated
    assert true <= 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("first", range(1000, 2000, 100))
def test_stated_errors_of_many_bodies(first):
    judged(range(first, first + 70), ordinary=False)
    judged(range(first + 70, first + 100), ordinary=True)


# --- beams by their formula -----------------------------------------------------------------------


def end_loaded(length, cells, element, nu=0.0):
    """Tip (m) of a cantilever of height 1 whose formula says -4, and its solution."""
    d = ELEMENTS[element].dim
    box = Box((length, *([1.0] * (d - 1))))
    material = Isotropic(1e6, nu, "plane_stress" if d == 2 else "solid")
    pull = (0.0, -1e6 / length**3, *([0.0] * (d - 2)))
    problem = Problem(
        box,
        material,
        (Support(box.side("left"), (0.0,) * d),),
        (Traction(box.side("right"), pull),),
    )
    mesh = reference_fem.box_discretisation(box, cells, element)
    found = reference_fem.solve_problem(problem, mesh)
    return found.at(np.array([[length, *([0.5] * (d - 1))]]))[0, 1], found


@pytest.mark.parametrize(
    ("length", "cells", "element"),
    [
        (4e3, (1000, 1), "Q2"),
        pytest.param(1e4, (10_000, 1), "Q2", marks=pytest.mark.slow),
        *(
            (1e4, (1000, 1) if kind.dim == 2 else (60, 1, 1), name)
            for name, kind in ELEMENTS.items()
            if kind.degree == 2
        ),
    ],
)
def test_slender_beams_bend_as_they_should(length, cells, element):
    tip, found = end_loaded(length, cells, element)
    # A cubic is off its parts of the second degree by 1/(4 n^2) of the deflection between nodes.
    assert abs(tip + 4) <= 4 * (1 / cells[0] ** 2 + 4 / length**2 + found.error)
    assert found.error <= 1e-9


def test_strains_of_slender_beams_have_their_digits():
    length = 1e4
    _, found = end_loaded(length, (1000, 1), "Q2")
    # M = F (L - x) and I = 1/12, amid cells: there a cubic's curvature is the mean over the cell.
    x, y = length / 2 + np.array([5.0, 1005.0]), 0.9
    sigma = found.stress(np.column_stack([x, np.full(2, y)]))[:, 0]
    wanted = 1e6 / length**3 * (length - x) * (y - 0.5) * 12
    assert np.abs(sigma / wanted - 1).max() <= 1e-5


def test_a_solver_without_its_tensor_refuses_what_entries_cannot_tell():
    _, found = end_loaded(1e4, (1000, 1), "Q2")
    held = np.repeat(found.body.points[:, :1] == 0, 2, axis=1)
    force = np.zeros(held.shape)
    force[found.body.points[:, 0] == 1e4, 1] = 1e-6
    K = stiffness(found.body, found.material)
    with pytest.raises(SolverError, match="too slender"):
        Solver(found.body, K, held).solve(np.zeros(held.shape), force)
    # 37 to 1 is told by entries as well, and by cells better.
    _, short = end_loaded(37.0, (37, 1), "Q2")
    held = np.repeat(short.body.points[:, :1] == 0, 2, axis=1)
    force = np.zeros(held.shape)
    force[short.body.points[:, 0] == 37, 1] = 1e-6
    K = stiffness(short.body, short.material)
    u, how = Solver(short.body, K, held).solve(np.zeros(held.shape), force)
    v, better = make_solver(short.body, short.material, held).solve(np.zeros(held.shape), force)
    assert better.error < how.error < 1e-7
    assert np.abs(u - v).max() <= how.error * np.abs(v).max()


def test_mixed_elements_of_a_slender_beam():
    length, nu = 300.0, 0.4999
    box = Box((length, 1.0))
    material = Isotropic(1e6, nu, "plane_strain", thickness=0.2)
    problem = Problem(
        box,
        material,
        (Support(box.side("left"), (0.0, 0.0)),),
        (Traction(box.side("right"), (0.0, -1e6 / (4 * length**3) * 4)),),
    )
    mesh = reference_fem.box_discretisation(box, (400, 1), "Q2")
    found = reference_fem.solve_problem(problem, mesh, mixed=True)
    # Plane strain bends by E/(1 - nu^2); the clamped end holds the change across: of order 1/L.
    tip = found.at(np.array([[length, 0.5]]))[0, 1]
    assert abs(tip / (-4 * (1 - nu**2)) - 1) <= 5 / length
    assert found.error <= 1e-6
