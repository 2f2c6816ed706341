"""The solver on meshes given as arrays: independent values, patch test, materials, bad input."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import reference_fem
from msvalidate.problem import Anisotropic, Isotropic, ProblemError
from reference_fem.elasticity import stiffness
from reference_fem.mesh.elements import ELEMENTS, of_dimension
from tests.reference_fem.by_hand import SKEW, with_middles
from tests.table import stored_rows

# A library's warning on the way to an answer, such as MatrixRankWarning, is a failure here.
pytestmark = pytest.mark.filterwarnings("error")

CASES = sorted((Path(__file__).parents[1] / "data" / "fem").glob("*_plane_*.json"))
CASES += sorted((Path(__file__).parents[1] / "data" / "fem").glob("*_3d_*.json"))
PLANE = of_dimension(2)
ROUNDING = 1e-12
"""Relative: a direct solve of a few hundred unknowns leaves 1e-14."""
MATERIALS = {
    "plane stress": Isotropic(1e6, 0.25, "plane_stress", thickness=1e-3),
    "plane strain": Isotropic(1e6, 0.25, "plane_strain", thickness=1e-3),
    "anisotropic": Anisotropic(1e6 * SKEW, thickness=1e-3),
}


# --- independent values ---------------------------------------------------------------------------


def solve_file(path):
    case = json.loads(path.read_text(encoding="utf-8"))
    law = case["material"]
    assert law["model"] == "linear"
    material = Isotropic(law["E"], law["nu"], law["state"], thickness=case["thickness"])
    found = reference_fem.solve(
        case["nodes"],
        case["cells"],
        case["element"],
        material,
        case["fixed"],
        case["nodal_forces"],
    )
    return found, np.array(case["displacements"])


def test_there_are_values_of_another_program():
    found = {path.stem.split("_plane")[0][-2:] for path in CASES}
    assert found == {"Q1", "Q2", "P1", "P2", "H1", "T1"}


@pytest.mark.parametrize("path", CASES, ids=lambda path: path.stem)
def test_independent_values(path):
    found, expected = solve_file(path)
    # Both sides solve one linear system exactly; left is rounding times its condition, 1e-12.
    assert np.abs(found - expected).max() <= 1e-9 * np.abs(expected).max()


# --- patch test -----------------------------------------------------------------------------------

# [MacNealHarder1985]: the mesh of their membrane patch test.
OUTLINE = [(0, 0), (0.24, 0), (0.24, 0.12), (0, 0.12)]
INNER = [(0.04, 0.02), (0.18, 0.03), (0.16, 0.08), (0.08, 0.08)]
QUADRILATERALS = [(0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7), (4, 5, 6, 7)]


def patch(element):
    return with_middles(OUTLINE + INNER, QUADRILATERALS, element)


def affine(points):
    x, y = points.T
    return 1e-3 * np.column_stack([x + y / 2, y + x / 2])


def boundary(points):
    x, y = points.T
    return np.isclose(x % 0.24, 0) | np.isclose(y % 0.12, 0)


def held_on_boundary(points, displacement):
    nodes = np.flatnonzero(boundary(points))
    return [(node, axis, displacement[node, axis]) for node in nodes for axis in (0, 1)]


@pytest.mark.parametrize("element", PLANE)
@pytest.mark.parametrize("name", MATERIALS)
def test_patch(name, element):
    points, cells = patch(element)
    assert not boundary(points).all()  # else nothing is solved
    fixed = held_on_boundary(points, affine(points))
    found = reference_fem.solve(points, cells, element, MATERIALS[name], fixed, [])
    assert np.abs(found - affine(points)).max() <= ROUNDING * np.abs(affine(points)).max()


@pytest.mark.parametrize("element", PLANE)
def test_patch_needs_the_force_that_macneal_and_harder_state(element):
    # Their stress under this displacement, plane stress, E = 1e6, nu = 1/4: 1333, 1333 and 400.
    points, cells = patch(element)
    body = reference_fem.make_discretisation(points, cells, element)
    K = stiffness(body, MATERIALS["plane stress"])
    force = (K @ affine(points).T.ravel()).reshape(2, -1).T
    right, top = np.isclose(points[:, 0], 0.24), np.isclose(points[:, 1], 0.12)
    assert force[right].sum(axis=0) == pytest.approx([4000 / 3 * 0.12e-3, 400 * 0.12e-3], rel=1e-12)
    assert force[top].sum(axis=0) == pytest.approx([400 * 0.24e-3, 4000 / 3 * 0.24e-3], rel=1e-12)
    assert np.abs(force[~boundary(points)]).max() <= 1e-12 * np.abs(force).max()


# --- stiffness ------------------------------------------------------------------------------------


@pytest.mark.parametrize("element", PLANE)
@pytest.mark.parametrize("name", MATERIALS)
def test_stiffness_is_symmetric_and_only_rigid_motions_are_free(name, element):
    points, cells = patch(element)
    K = stiffness(
        reference_fem.make_discretisation(points, cells, element), MATERIALS[name]
    ).toarray()
    assert np.abs(K - K.T).max() <= ROUNDING * np.abs(K).max()
    energies = np.linalg.eigvalsh(K)
    # Rigid motions are three; reduced integration would show as a fourth (an hourglass).
    assert np.abs(energies[:3]).max() <= ROUNDING * energies[-1]
    assert energies[3] > 1e-6 * energies[-1]
    x, y = points.T
    one, zero = np.ones(len(x)), np.zeros(len(x))
    rigid = np.array([[*one, *zero], [*zero, *one], [*-y, *x]])
    assert np.abs(K @ rigid.T).max() <= ROUNDING * np.abs(K).max()


@pytest.mark.parametrize("element", PLANE)
def test_answer_does_not_depend_on_numbering(element):
    points, cells = patch(element)
    rng = np.random.default_rng(7)
    new = rng.permutation(len(points))  # old number -> new number
    moved = np.empty_like(points)
    moved[new] = points
    left = np.flatnonzero(points[:, 0] == 0)
    fixed = [(node, axis, 0.0) for node in left for axis in (0, 1)]
    material = MATERIALS["anisotropic"]
    still = reference_fem.solve(points, cells, element, material, fixed, [(1, 1, 1.0)])
    again = reference_fem.solve(
        moved,
        rng.permutation(new[cells]),
        element,
        material,
        [(new[node], axis, value) for node, axis, value in fixed],
        [(new[1], 1, 0.25), (new[1], 1, 0.75)],  # rows for one component add up
    )
    assert np.abs(again[new] - still).max() <= 1e-10 * np.abs(still).max()


# --- materials ------------------------------------------------------------------------------------


def test_prescribed_values_are_returned_as_given():
    points, cells = patch("Q1")
    fixed = [(node, axis, 0.1 * node - axis) for node in range(len(points)) for axis in (0, 1)]
    found = reference_fem.solve(points, cells, "Q1", Isotropic(1.0, 0.3), fixed, [(1, 0, 9.0)])
    expected = 0.1 * np.arange(len(points))[:, None] - [0, 1]
    np.testing.assert_array_equal(found, expected)


# --- bad input ------------------------------------------------------------------------------------

POINTS = [(0, 0), (1, 0), (1, 1), (0, 1), (2, 0), (2, 1)]
CELLS = [(0, 1, 2, 3), (1, 4, 5, 2)]
CLAMP = [(0, 0, 0.0), (0, 1, 0.0), (3, 0, 0.0), (3, 1, 0.0)]
GOOD = {
    "points": POINTS,
    "cells": CELLS,
    "element": "Q1",
    "material": Isotropic(1.0, 0.3),
    "fixed": CLAMP,
    "nodal_forces": [(4, 1, -1.0)],
}
BAD = {name: row for name, *row in stored_rows("meshes_to_solve")} | {
    "no cells": ({"cells": np.zeros((0, 4), dtype=int)}, [r"cells: .*\(0, 4\)"]),
    "incompressible": (
        {"material": Isotropic(1.0, 0.5, "plane_strain")},
        ["nu = 1/2: .* take nu = 0.4999, or mixed"],
    ),
    "solid": ({"material": Isotropic(1.0, 0.3, "solid")}, ["material: 3D, the body 2D"]),
    "solid tensor": ({"material": Anisotropic(np.eye(6))}, ["material: 3D, the body 2D"]),
}


@pytest.mark.parametrize(("change", "fragments"), BAD.values(), ids=BAD)
def test_bad_input_is_named(change, fragments):
    with pytest.raises(ProblemError) as caught:
        reference_fem.solve(**(GOOD | change))
    for fragment in fragments:
        assert caught.match(fragment)


@pytest.mark.parametrize("element", [e for e in PLANE if ELEMENTS[e].degree == 2])
@pytest.mark.parametrize("node", [8, -1])  # the first mid-side node; the last, in Q2 a centre
def test_displaced_middle_node_bends_the_cell_and_the_patch_still_holds(element, node):
    points, cells = patch(element)
    points[node] += 1e-3  # a hundredth of an edge
    assert reference_fem.make_discretisation(points, cells, element).curved
    fixed = held_on_boundary(patch(element)[0], affine(points))
    found = reference_fem.solve(points, cells, element, MATERIALS["plane stress"], fixed, [])
    assert np.abs(found - affine(points)).max() <= ROUNDING * np.abs(affine(points)).max()
