"""Electrostatics on meshes given as arrays: independent values, closed forms, rates, forces."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import skfem

from msvalidate.problem import Box, ProblemError
from reference_fem import Dielectric, box_discretisation, make_discretisation
from reference_fem.mesh.assembly import basis_gradients
from tests.table import table

pytestmark = pytest.mark.filterwarnings("error")

CASES = sorted((Path(__file__).parents[2] / "data" / "fem").glob("electro_*.json"))
ELEMENTS = ("Q1", "Q2")
ROUNDING = 1e-12
"""Relative: a direct solve of a few hundred unknowns leaves 1e-14."""


# --- independent values ---------------------------------------------------------------------------


def at_corners(body, forces):
    """Forces (v, 2) of the corners' bilinear functions, which are sums of the element's own."""
    kind = body.element
    total = np.zeros(forces.shape)
    counted = set()
    for cell in body.cells:
        for place, node in enumerate(cell):
            if node not in counted:
                counted.add(node)
                total[cell[: kind.corners]] += np.outer(kind.means[place], forces[node])
    return total


def solve_potential(points, cells, element, permittivity, fixed):
    """On a mesh as arrays, held as rows (node, V) say."""
    values = np.full(len(points), np.nan)
    for node, value in fixed:
        values[int(node)] = value
    held = np.isfinite(values)
    medium = Dielectric(make_discretisation(points, cells, element), permittivity, held)
    return medium.solve(np.where(held, values, 0.0))


def test_there_are_independent_values_for_every_element():
    assert {path.stem[-2:] for path in CASES} == set(ELEMENTS)


@pytest.mark.parametrize("path", CASES, ids=lambda path: path.stem)
def test_independent_values(path):
    case = json.loads(path.read_text(encoding="utf-8"))
    found = solve_potential(
        case["nodes"],
        case["cells"],
        case["element"],
        case["cell_permittivity"],
        case["fixed_potential"],
    )
    expected, force = np.array(case["potential"]), np.array(case["maxwell_forces"])
    # Both sides solve one linear system exactly; left is rounding times its condition, 1e-12.
    assert np.abs(found.values - expected).max() <= 1e-9 * np.abs(expected).max()
    assert found.energy == pytest.approx(case["energy"], rel=1e-9)
    corners = at_corners(found.medium.body, found.forces)[case["corner_nodes"]]
    assert np.abs(corners - force).max() <= 1e-9 * np.abs(force).max()


# --- uniform fields -------------------------------------------------------------------------------


def distorted(element, seed=1):
    """Four by four cells of a unit square, their inner corners moved at random."""
    body = box_discretisation(Box((1.0, 1.0)), 4, element)
    kind, points = body.element, body.points.copy()
    corner = np.unique(body.cells[:, : kind.corners])
    inner = corner[((points[corner] > 0) & (points[corner] < 1)).all(axis=1)]
    points[inner] += np.random.default_rng(seed).uniform(-0.06, 0.06, (len(inner), 2))
    for cell in body.cells:
        points[cell] = kind.means @ points[cell[: kind.corners]]
    return points, body.cells


def on_boundary(points):
    return np.isclose(points % 1, 0).any(axis=1)


@pytest.mark.parametrize("element", ELEMENTS)
def test_uniform_field_is_exact_and_pulls_no_inner_node(element):
    points, cells = distorted(element)
    field = np.array([0.3, -0.7])
    exact = 2.0 - points @ field
    edge = np.flatnonzero(on_boundary(points))
    assert len(edge) < len(points)  # else nothing is solved
    found = solve_potential(
        points, cells, element, np.full(16, 2.5), np.column_stack([edge, exact[edge]])
    )
    assert np.abs(found.values - exact).max() <= ROUNDING * np.abs(exact).max()
    x = np.random.default_rng(2).uniform(0, 1, (20, 2))
    assert np.abs(found.at(x) - (2.0 - x @ field)).max() <= ROUNDING
    assert np.abs(found.field(x) - field).max() <= 1e-11  # divided by the size of cells
    assert found.energy == pytest.approx(0.5 * 2.5 * field @ field, rel=ROUNDING)
    inner = ~on_boundary(points)
    assert np.abs(found.forces[inner]).max() <= ROUNDING
    assert np.abs(found.charge[inner]).max() <= ROUNDING


def test_floating_conductor_takes_no_charge():
    # A bar from a quarter of the height up to three has the mean potential of the plates.
    body = box_discretisation(Box((1.0, 1.0)), 8, "Q2")
    x, y = body.points.T
    bar = np.flatnonzero((x == 0.5) & (y >= 0.25) & (y <= 0.75))
    held = np.isin(y, (0.0, 1.0)) & (x <= 0.75)
    found = Dielectric(body, np.ones(64), held, bar).solve(np.where(y == 1, 3.0, 1.0))
    assert np.ptp(found.values[bar]) == 0
    assert found.values[bar[0]] == pytest.approx(2.0, rel=ROUNDING)
    assert abs(found.charge[bar].sum()) <= ROUNDING
    assert np.abs(found.charge[bar]).max() > 1e-2  # induced, but none in all


# --- rates ----------------------------------------------------------------------------------------

LEFT, RIGHT = 1.0, 5.0


def exact(x, y):
    return np.sin(2 * np.pi * x) * np.cos(np.pi * y) / np.where(x < 0.5, LEFT, RIGHT)


def errors(element, cells):
    """Root mean square error and that of the energy, of a field bent at a face between two media.

    φ = sin 2πx cos πy / ε: continuous where it bends, x = 1/2, with a continuous flux.
    """
    body = box_discretisation(Box((1.0, 1.0)), cells, element)
    x, y = body.points.T
    middle = body.points[body.cells[:, :4]].mean(axis=1)[:, 0]
    medium = Dielectric(body, np.where(middle < 0.5, LEFT, RIGHT), on_boundary(body.points))
    fine = body.quadrature(8)
    source = skfem.LinearForm(
        lambda v, w: 5 * np.pi**2 * np.sin(2 * np.pi * w.x[0]) * np.cos(np.pi * w.x[1]) * v
    ).assemble(fine)
    load = np.zeros(len(x))
    load[body.node] = source
    found = medium.solve(exact(x, y), load)
    values = np.asarray(fine.interpolate(found.values[body.node]))
    places = np.asarray(fine.global_coordinates())
    gap = (((values - exact(*places)) ** 2) * fine.dx).sum() ** 0.5
    energy = 5 * np.pi**2 / 16 * (1 / LEFT + 1 / RIGHT)
    return gap, abs(found.energy / energy - 1)


@pytest.mark.parametrize(("element", "degree"), [("Q1", 1), ("Q2", 2)])
def test_rates_of_a_manufactured_solution(element, degree):
    (gap, energy), (finer, less) = errors(element, 16), errors(element, 32)
    # Theory: degree + 1 and twice the degree; 16 cells a side are near enough to it for 0.1.
    assert np.log2(gap / finer) == pytest.approx(degree + 1, abs=0.1)
    assert np.log2(energy / less) == pytest.approx(2 * degree, abs=0.1)
    assert finer < {"Q1": 2e-3, "Q2": 2e-5}[element]


# --- forces ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("element", ELEMENTS)
def test_forces_are_derivatives_of_the_energy(element):
    # At fixed potentials F = +dW/dx, at every node: an electrode with tips, in two media.
    points, cells = distorted(element)
    middle = points[cells[:, :4]].mean(axis=1)
    permittivity = np.where(middle[:, 1] < 0.5, 3.0, 1.0)
    y = box_discretisation(Box((1.0, 1.0)), 4, element).points
    bar = np.isclose(y[:, 1], 0.5) & (y[:, 0] >= 0.25) & (y[:, 0] <= 0.75)
    held = bar | (y[:, 1] == 0)
    values = bar.astype(float)

    def energy(moved):
        return Dielectric(make_discretisation(moved, cells, element), permittivity, held).solve(
            values
        )

    found = energy(points)
    step, worst = 1e-5, 0.0
    rng = np.random.default_rng(3)
    nodes = [*np.flatnonzero(bar), *rng.choice(len(points), 8, replace=False)]
    for node in nodes:
        for axis in (0, 1):
            shift = np.zeros(points.shape)
            shift[node, axis] = step
            slope = (energy(points + shift).energy - energy(points - shift).energy) / (2 * step)
            worst = max(worst, abs(slope - found.forces[node, axis]))
    # Central differences: step² of the third derivative, some 1e3, and rounding over the step.
    assert worst <= 1e-6 * np.abs(found.forces).max()
    assert np.abs(found.forces[bar]).max() > 0.1
    # Moving all together costs nothing.
    assert np.abs(found.forces.sum(axis=0)).max() <= ROUNDING * np.abs(found.forces).sum()


def test_slopes_are_those_of_the_cells():
    points, cells = distorted("Q2")
    body = make_discretisation(points, cells, "Q2")
    slope, measure = basis_gradients(body.basis)
    nodes = body.nodes_of(np.arange(len(cells)))
    linear = np.einsum("kacq,kc->acq", slope, points[nodes] @ [2.0, -3.0])
    assert np.abs(linear - np.array([2.0, -3.0])[:, None, None]).max() <= 1e-11
    assert measure.sum() == pytest.approx(1.0, rel=ROUNDING)


# --- bad input ------------------------------------------------------------------------------------


def square(**changed):
    points, cells = distorted("Q1")
    fixed = [(0, 0.0), (4, 1.0)]
    given = {"permittivity": np.ones(16), "fixed": fixed, **changed}
    return solve_potential(points, cells, "Q1", **given)


@table(
    ("changed", "words"),
    [
        ({"permittivity": np.append(np.ones(15), -2.0)}, "permittivity: -2 F/m in cell 15"),
        ({"permittivity": np.zeros(16)}, "must be above zero"),
        ({"permittivity": np.full(16, np.nan)}, "permittivity: nan at index 0"),
        ({"permittivity": np.ones(15)}, r"permittivity: shape \(15,\); give \(16,\)"),
        ({"fixed": []}, "held nowhere"),
    ],
)
def test_bad_input_gets_a_clear_line(changed, words):
    with pytest.raises(ProblemError, match=words) as caught:
        square(**changed)
    assert "\n" not in str(caught.value)


def test_dielectric_refuses_what_does_not_fit():
    body = box_discretisation(Box((1.0, 1.0)), 2, "Q1")
    held = np.arange(9) == 0
    with pytest.raises(ProblemError, match="held: "):
        Dielectric(body, np.ones(4), held[:5])
    with pytest.raises(ProblemError, match="is held as well"):
        Dielectric(body, np.ones(4), held, np.array([0, 1]))
    with pytest.raises(ProblemError, match=r"floating: \[99\]; nodes run from 0 to 8"):
        Dielectric(body, np.ones(4), held, np.array([99]))
    with pytest.raises(ProblemError, match=r"potentials: shape \(3,\)"):
        Dielectric(body, np.ones(4), held).solve(np.ones(3))
    cube = box_discretisation(Box((1.0, 1.0, 1.0)), 1, "H1")
    with pytest.raises(ProblemError, match="body: 3D"):
        Dielectric(cube, np.ones(1), np.arange(8) == 0)
    with pytest.raises(ProblemError, match="potentials: nan"):
        Dielectric(body, np.ones(4), held).solve(np.full(9, np.nan))
    with pytest.raises(ProblemError, match=r"charges: shape \(8,\)"):
        Dielectric(body, np.ones(4), held).solve(np.zeros(9), np.zeros(8))


def test_a_part_without_a_potential_is_refused():
    points = [(0, 0), (1, 0), (1, 1), (0, 1), (3, 0), (4, 0), (4, 1), (3, 1)]
    with pytest.raises(ProblemError, match=r"part of the mesh around \(3, 0\)"):
        solve_potential(points, [[0, 1, 2, 3], [4, 5, 6, 7]], "Q1", [1.0, 1.0], [(0, 1.0)])
