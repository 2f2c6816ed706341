"""The study `benchmarks`: its layout, closed forms by other routes, its bodies, and an identity."""

import numpy as np
import pandas as pd
import pytest
from msvalidate.studies.benchmarks import (
    cantilever,
    cases,
    cook,
    models,
    patch_bodies,
)
from msvalidate.studies.benchmarks import three_point as beam
from scipy.integrate import quad

import reference_fem
from msvalidate.problem import Isotropic, Mesh, ProblemError
from reference_fem.elasticity import elastic_tensor

QUANTITY = cases.Quantity("a benchmark", "a length", "m", 2.0, "by hand", 0.3)


# Layout -------------------------------------------------------------------------------------------


def test_rows_say_how_far_off_and_with_which_order():
    table = pd.DataFrame(cases.rows(QUANTITY, "springs", (4, 8, 16), (2.16, 2.04, 2.01)))
    assert set(table) == set(cases.LAYOUT)
    assert table["against_accepted"].tolist() == pytest.approx([0.08, 0.02, 0.005])
    assert table["order"].tolist() == ["coarsest", pytest.approx(2.0), pytest.approx(2.0)]
    # Richardson's: 1.25 of 0.03/(2² - 1) is less than a third of the change before, 0.12/3.
    assert table["uncertainty"].tolist() == ["none", "none", pytest.approx(0.04 / 2.01)]


@pytest.mark.parametrize(
    ("before", "after", "uncertainty", "word"),
    [
        (0.1, 1e-13, 0.0, "exact"),
        (0.1, 0.01, 0.003, "not resolved"),
        (0.1, -0.01, 0.0, "not asymptotic"),
        (0.1, 0.09, 0.0, "not asymptotic"),
    ],
)
def test_what_is_no_order_is_a_word(before, after, uncertainty, word):
    assert cases.order((4, 8), (before, after), 1, uncertainty) == word


def test_orders_go_by_the_cells_that_there_are():
    assert cases.order((8, 12), (0.09, 0.04), 1) == pytest.approx(2.0)
    assert cases.uncertainty((4, 8, 12), (1.0, 1.1, 1.2)) == "none"


def test_rounding_of_orders_is_what_a_rounded_value_moves_the_worst_of_them():
    rows = []
    for away in ((0.04, 0.01), (4e-5, 1e-5)):
        rows += cases.rows(QUANTITY, "FEM Q2", (4, 8), QUANTITY.goal * (1 + np.array(away)))
    moved = cases.order((4, 8), (4e-5, 1e-5 - cases.ROUNDING), 1) - 2
    found = cases.rounding_of_orders(pd.DataFrame(rows))
    assert found == pytest.approx(moved, rel=1e-4)
    assert cases.rounding_of_orders(pd.DataFrame(rows[:1])) == 0.0, "no order, nothing to round"


def test_a_limit_of_its_own_is_told_from_the_accepted_value():
    known = cases.Quantity("b", "q", "m", 2.0, "rounded", 0.3, limit=2.02, limit_uncertainty=1e-4)
    (row,) = cases.rows(known, "FEM Q2", (4,), (2.02,))
    assert (row["against_limit"], row["against_accepted"]) == (0.0, pytest.approx(0.01))


# Closed forms -------------------------------------------------------------------------------------


@pytest.mark.parametrize(("nu", "tip"), [(0.3, 0.0089000), (1 / 3, 0.0089111)])
def test_the_cantilever_has_its_known_deflection(nu, tip):
    assert cantilever.deflection(nu) == pytest.approx(tip, abs=5e-8)
    end = cantilever.exact(nu, np.array([cantilever.END]))
    assert -end[0, 1] == pytest.approx(cantilever.deflection(nu), rel=1e-14)


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.49])
def test_the_cantilevers_field_has_the_stress_of_a_beam(nu):
    """By differences: σxx = P (L - x) y/I, σyy = 0, τ = -P (D²/4 - y²)/(2I)."""
    place, step = np.array([[13.0, 8.5]]), 1e-3
    gradient = np.stack(
        [
            (cantilever.exact(nu, place + e) - cantilever.exact(nu, place - e))[0] / (2 * step)
            for e in step * np.eye(2)
        ],
        axis=1,
    )
    strain = np.array([gradient[0, 0], gradient[1, 1], gradient[0, 1] + gradient[1, 0]])
    stress = elastic_tensor(Isotropic(E=cantilever.MODULUS, nu=nu)) @ strain
    y, across = 2.5, cantilever.LOAD / cantilever.INERTIA
    want = [across * (48 - 13) * y, 0.0, -across / 2 * (36 - y**2)]
    # A cubic's central difference is off by its third derivative · step²/6, 1e-8 of the strain.
    np.testing.assert_allclose(stress, want, atol=1e-6 * abs(want[0]))


def test_the_cantilevers_springs_get_the_parabolas_consistent_forces():
    cells = 4
    asked = cantilever.problem(0.3, cantilever.DEPTH / cells)
    grid = cantilever.square(cantilever.BEAM, (4 * cells, cells))
    network = models.network_of(asked, grid)
    h = cantilever.DEPTH / cells
    end = network.points[:, 0] == cantilever.LENGTH
    for (_, place), force in zip(network.points[end], network.force[end], strict=True):
        low, high = max(place - h, 0.0), min(place + h, cantilever.DEPTH)

        def part(y, place=place):
            shear = cantilever.LOAD / (2 * cantilever.INERTIA) * (36 - (y - 6) ** 2)
            return shear * (1 - abs(y - place) / h)

        want, _ = quad(part, low, high, points=[place])
        assert -force[1] == pytest.approx(want, rel=1e-10)
    assert -network.force[:, 1].sum() == pytest.approx(cantilever.LOAD, rel=1e-12)


@pytest.mark.parametrize(
    ("kind", "loaded", "part", "sheared"),
    [
        ("supported", 1e-4, 1 / 48, 4),
        ("clamped", 1e-4, 1 / 192, 4),
        ("supported", beam.LENGTH, 5 / 384, 8),
        ("clamped", beam.LENGTH, 1 / 384, 8),
    ],
)
def test_beam_theory_of_a_load_at_one_place_and_all_along(monkeypatch, kind, loaded, part, sheared):
    monkeypatch.setattr(beam, "LOADED", loaded)
    bending = part * beam.LOAD * beam.LENGTH**3 / (beam.MODULUS * beam.INERTIA)
    shear = beam.LOAD * beam.LENGTH / (sheared * 5 / 6 * beam.MODULUS / 2.6)
    assert beam.theory(kind, 0.3) == pytest.approx(
        bending + shear, rel=1e-4 if loaded < 1 else 1e-12
    )


# Bodies -------------------------------------------------------------------------------------------


def test_one_of_the_published_hexahedra_is_folded():
    """At an inner corner; the mesh refuses it, and takes it with that point moved in."""
    points, cells = patch_bodies.places(3), np.array(patch_bodies.HEXAHEDRA)
    with pytest.raises(ProblemError, match="cell 3"):
        Mesh(points, cells, "hexahedron")
    x = points[cells[3]]
    at_corner = np.linalg.det([x[2] - x[3], x[3] - x[0], x[7] - x[3]])
    assert at_corner == pytest.approx(-0.0127, abs=1e-4)
    assert patch_bodies.published("H").volume == pytest.approx(1.0, rel=1e-14)
    assert patch_bodies.published("T").volume == pytest.approx(1.0, rel=1e-14)


def test_cooks_panel_is_the_mapped_square():
    corners = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
    np.testing.assert_array_equal(cook.map_to_panel(corners), cook.PANEL.vertices)
    assert cook.problem(cook.PANEL).loads[0].traction[1] * cook.EDGE == 1.0
    # Williams 1952, clamped and free in plane stress: κ sin²(λα) = (κ + 1)²/4 - λ² sin²α with
    # κ = (3 - nu)/(1 + nu).
    kappa, exponent = (3 - 1 / 3) / (1 + 1 / 3), cook.corner_order() / 2
    left = (kappa + 1) ** 2 / 4 - exponent**2 * np.sin(cook.CORNER) ** 2
    assert left == pytest.approx(kappa * np.sin(exponent * cook.CORNER) ** 2, abs=1e-9)


def test_equal_springs_are_those_of_equilateral_triangles_inside():
    asked = ("triangle", cook.RISING)
    whole, shared = (cook.on_edges(*asked, rule, 4) for rule in ("equal", "equilateral"))
    ends, cells = shared.springs[:, None], shared.cells
    borders = (cells[None, :, :, None] == ends[:, :, None]).any(axis=2).all(axis=2).sum(axis=1)
    assert whole.factor == pytest.approx(shared.factor * 2 / borders)


def test_the_reference_in_the_candidates_place_agrees_with_itself():
    """Three-point bending: what the network moves by is looked up in the problem's own solution."""

    def elastic(problem, network, answer):
        assert answer == "linear"
        middle, half = beam.LENGTH / 2, beam.LOADED / 2
        through = ((middle - half, middle + half), (beam.HEIGHT / 2,))
        mesh = reference_fem.box_discretisation(
            problem.domain, (8 * 4, 4), "Q2", beam.GRADING, through=through
        )
        return reference_fem.solve_problem(problem, mesh).at(network.points)

    for kind in beam.KINDS:
        seen = beam.spring_deflection(elastic, kind, 0.45, 8)
        assert seen == pytest.approx(beam.elastic_deflection(kind, 0.45, 4), rel=1e-12)
