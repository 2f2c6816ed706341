"""Cells with curved sides: their map, integrals, loads, interpolation, and folds."""

from __future__ import annotations

import numpy as np
import pytest

import reference_fem
from msvalidate.problem import Box, Isotropic, ProblemError
from reference_fem.elasticity import solve_on, stiffness
from reference_fem.mesh import ELEMENTS, Facets, make_discretisation
from tests.reference_fem.by_hand import moment
from tests.table import table

# A library's warning on the way to an answer is a failure here.
pytestmark = pytest.mark.filterwarnings("error")

QUADRATIC = [name for name, kind in ELEMENTS.items() if kind.degree == 2]
# With a node amid all corners.
CENTRED = [name for name in QUADRATIC if len(ELEMENTS[name].middles[-1]) == 2 ** ELEMENTS[name].dim]
INNER, OUTER = 1.0, 2.0
ROUNDING = 1e-12
"""Relative: an integral sums a few hundred products; Newton ends at rounding."""


def annulus(element, n=3):
    """Points and cells of a quarter ring; in space it widens upwards and its top is vaulted."""
    d = ELEMENTS[element].dim
    flat = reference_fem.box_discretisation(Box((1.0,) * d), (n, 2 * n, n)[:d], element)
    s, t, *z = flat.points.T
    radius, angle = INNER + (OUTER - INNER) * s, np.pi / 2 * t
    if d == 2:
        return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)]), flat.cells.copy()
    radius = radius * (1 + 0.2 * z[0] ** 2)
    height = z[0] * (1 + 0.3 * s * (1 - s))
    points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), height])
    return points, flat.cells.copy()


def ring(element, n=3):
    points, cells = annulus(element, n)
    new = np.random.default_rng(0).permutation(len(points))  # node numbers must not matter
    moved = np.empty_like(points)
    moved[new] = points
    return make_discretisation(moved, new[cells], element)


def inside(body, number=200, seed=0):
    """Points of the body, made by its cells' own functions, and so not on a grid."""
    rng = np.random.default_rng(seed)
    kind = body.element
    local = rng.random((number, kind.dim))
    if kind.simplex:
        local = local[local.sum(axis=1) < 1]
    cell = rng.integers(len(body.cells), size=len(local))
    value, _ = kind.functions(local)
    return np.einsum("kq,kqd->qd", value, body.points[body.nodes_of(cell)])


# --- the map --------------------------------------------------------------------------------------


@pytest.mark.parametrize("element", QUADRATIC)
def test_interpolation_on_curved_cells_holds_linear_functions(element):
    body = ring(element)
    assert body.curved
    x = inside(body)
    assert len(x) > 20
    found = body.interpolation(x)
    assert np.abs(found @ body.points - x).max() <= ROUNDING
    assert np.abs(found.sum(axis=1) - 1).max() <= ROUNDING
    nodes = body.interpolation(body.points).toarray()
    assert np.abs(nodes - np.eye(len(body.points))).max() <= ROUNDING


@pytest.mark.parametrize("element", QUADRATIC)
def test_curved_cells_pass_the_patch_test(element):
    body = ring(element)
    x, d = body.points, body.dim
    law = Isotropic(2.0, 0.3, "plane_strain" if d == 2 else "solid")
    exact = x @ (1e-3 * np.arange(1, d * d + 1).reshape(d, d) ** 0.7)
    held = np.zeros(x.shape, dtype=bool)
    held[np.unique(body.surface)] = True
    assert not held.all()  # else nothing is solved
    found = solve_on(body, law, held, np.where(held, exact, 0.0), np.zeros(x.shape))
    assert np.abs(found - exact).max() <= ROUNDING * np.abs(exact).max()


# --- integrals ------------------------------------------------------------------------------------


@pytest.mark.parametrize("element", QUADRATIC)
def test_volume_is_the_flux_through_the_surface(element):
    # ∫ div x = d V, by two rules that have nothing in common; both integrate polynomials exactly.
    body = ring(element, 2)
    facets = Facets(body, body.surface)
    flux = (facets.measure * (facets.places * facets.normals).sum(axis=2)).sum()
    assert flux == pytest.approx(body.dim * body.basis.dx.sum(), rel=ROUNDING)
    out = (facets.measure[..., None] * facets.normals).sum(axis=(0, 1))
    assert np.abs(out).max() <= ROUNDING * facets.measure.sum()  # a closed surface


# --- loads ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("element", ELEMENTS)
def test_tractions_of_uniform_stress_are_what_the_stiffness_needs(element):
    # K u of a linear u is ∫ φ σ·n over the surface, node by node, however it is curved.
    d = ELEMENTS[element].dim
    body = ring(element, 2)
    law = Isotropic(2.0, 0.3, "plane_strain" if d == 2 else "solid")
    gradient = 1e-2 * np.arange(1, d * d + 1).reshape(d, d) ** 0.7
    strain = (gradient + gradient.T) / 2
    mu, lam = 2 / 2.6, 2 * 0.3 / (1.3 * 0.4)
    sigma = 2 * mu * strain + lam * np.trace(strain) * np.eye(d)
    u = body.points @ gradient.T
    internal = (stiffness(body, law) @ u.T.ravel()).reshape(d, -1).T
    facets = Facets(body, body.surface)
    external = facets.integrated(facets.normals @ sigma)
    # Both rules are exact: J⁻¹ det J is a polynomial, and so is the normal times the stretch.
    assert np.abs(internal - external).max() <= ROUNDING * np.abs(external).max()
    assert np.abs(external.sum(axis=0)).max() <= ROUNDING * np.abs(external).sum()
    assert np.abs(moment(body.points, external)).max() <= 1e-11 * np.abs(external).sum()


# --- folds ----------------------------------------------------------------------------------------


def one_cell(element):
    kind = ELEMENTS[element]
    return kind.places.copy(), np.arange(kind.nodes)[None]


@table("element", QUADRATIC)
def test_mid_side_beyond_the_quarter_of_its_edge_is_refused(element):
    # On a straight edge the Jacobian at its end is 4s - 1 times the straight one's.
    points, cells = one_cell(element)
    kind = ELEMENTS[element]
    a, b = kind.middles[0]
    for share, fine in ((0.26, True), (0.25, False), (0.2, False)):
        points[kind.corners] = (1 - share) * points[a] + share * points[b]
        if fine:
            assert make_discretisation(points, cells, element).curved
        else:
            with pytest.raises(ProblemError, match="cell 0 is inverted or folded: its curved"):
                make_discretisation(points, cells, element)


def least_jacobian(element, points, n=21):
    """By brute force: central differences would do, but the slopes are tested elsewhere."""
    kind = ELEMENTS[element]
    axes = np.meshgrid(*[np.linspace(0, 1, n)] * kind.dim, indexing="ij")
    local = np.column_stack([axis.ravel() for axis in axes])
    if kind.simplex:
        local = local[local.sum(axis=1) <= 1 + 1e-12]
    _, slope = kind.functions(local)
    return np.linalg.det(np.einsum("kjq,kd->qjd", slope, points[kind.listed])).min()


@table("element", QUADRATIC)
def test_a_cell_is_refused_when_and_only_when_it_folds(element):
    verdicts = []
    for seed in range(60):
        rng = np.random.default_rng(seed)
        points, cells = one_cell(element)
        points += rng.uniform(-1, 1, points.shape) * rng.choice([0.05, 0.15, 0.25])
        least = least_jacobian(element, points)
        if abs(least) < 0.01:  # the grid of samples cannot tell either
            continue
        if least > 0:
            assert make_discretisation(points, cells, element).curved
        else:
            with pytest.raises(ProblemError, match="cell 0 is inverted or folded"):
                make_discretisation(points, cells, element)
        verdicts.append(least > 0)
    assert 8 < sum(verdicts) < len(verdicts) - 8, "both must occur"


@table("element", CENTRED)
def test_a_fold_between_the_corners_is_refused(element):
    points, cells = one_cell(element)
    points[-1, 0] += 0.4  # the centre: at the corners the Jacobian does not feel it
    with pytest.raises(ProblemError, match="cell 0 is inverted or folded"):
        make_discretisation(points, cells, element)


def test_the_folded_cell_is_named_among_straight_ones():
    flat = reference_fem.box_discretisation(Box((1.0, 1.0)), 3, "P2")
    points = flat.points.copy()
    points[flat.cells[11, 3]] = points[flat.cells[11, 0]] * 0.9 + points[flat.cells[11, 1]] * 0.1
    with pytest.raises(ProblemError, match=r"cell (\d+) is inverted or folded") as caught:
        make_discretisation(points, flat.cells, "P2")
    number = int(str(caught.value).split()[2])
    assert flat.cells[11, 3] in flat.cells[number]


@table("element", QUADRATIC)
def test_middles_in_another_order_are_refused(element):
    points, cells = one_cell(element)
    kind = ELEMENTS[element]
    cells[0, kind.corners : kind.corners + 2] = cells[0, kind.corners : kind.corners + 2][::-1]
    with pytest.raises(ProblemError, match="list corners, mid-sides, centre in VTK order"):
        make_discretisation(points, cells, element)


def test_neighbours_that_do_not_share_their_mid_side_are_refused():
    flat = reference_fem.box_discretisation(Box((2.0, 1.0)), (2, 1), "Q2")
    middle = flat.cells[0, 5]
    assert middle in flat.cells[1]
    points = np.vstack([flat.points, flat.points[middle] + [0.01, 0.0]])
    cells = flat.cells.copy()
    cells[1][cells[1] == middle] = len(points) - 1
    with pytest.raises(ProblemError, match="names other nodes than its neighbours do on the sides"):
        make_discretisation(points, cells, "Q2")
