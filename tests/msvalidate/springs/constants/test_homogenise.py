"""The solid that an endless lattice is: closed forms and independent values."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from msvalidate.problem import VOIGT, Box, SolverError
from msvalidate.springs.constants.homogenise import homogenise, homogenise_network, interior_tensor
from msvalidate.springs.constants.stiffness import isotropic_moduli, moduli, pattern_tensor
from msvalidate.springs.lattice import fill_rotated, patterns, repeat_cell, voronoi_box
from tests.table import refused, table

LATTICES = patterns.all_patterns()
DATA = Path(__file__).parents[3] / "data" / "springs"


def zener(C):
    return 2 * C[-1, -1] / (C[0, 0] - C[0, 1])


CLOSED = [name for name, make in LATTICES.items() if make().tensor is not None]


@pytest.mark.parametrize("name", CLOSED)
@pytest.mark.parametrize("times", [1, 2])
def test_the_closed_form_holds_for_any_constants_and_spacing(name, times):
    pattern = LATTICES[name]()
    rng = np.random.default_rng(1)
    constants = tuple(rng.uniform(0.2, 2, pattern.kinds).tolist())
    found = homogenise(repeat_cell(pattern, times), constants, 0.3)
    exact = pattern.tensor(constants) * (1 if pattern.dim == 2 else 1 / 0.3)
    np.testing.assert_allclose(found.tensor, exact, atol=1e-13 * np.abs(exact).max())
    if name != "honeycomb":  # every point is a centre of symmetry
        np.testing.assert_allclose(found.affine, exact, atol=1e-13 * np.abs(exact).max())
        affine = pattern_tensor(pattern, constants, 0.3)
        np.testing.assert_allclose(affine, exact, atol=1e-13 * np.abs(exact).max())


@pytest.mark.parametrize(
    ("name", "constants", "ratio", "A"),
    [
        ("square", (1.0, 0.5), 1 / 3, 1.0),
        ("square", (1.0, 2.0), 2 / 3, 4.0),
        ("triangular", (0.7,), 1 / 3, 1.0),
        ("cubic18", (1.0, 1.0), 1 / 4, 1.0),
        ("cubic26", (1.0 + 8 / 3, 1.0, 1.0), 1 / 4, 1.0),
        ("cubic26", (2.0 + 8 / 3 * 0.3, 2.0, 0.3), 1 / 4, 1.0),
        ("cubic26", (1.0, 1.0, 1.0), 0.35, 7 / 3),
        ("bcc", (1.0, 2 / 3), 1 / 4, 1.0),
        ("fcc", (1.0, 1 / 4), 1 / 4, 1.0),
        ("fcc", (1.0, 0.0), 1 / 3, 2.0),
    ],
)
def test_ratio_and_anisotropy_of_known_lattices(name, constants, ratio, A):
    found = moduli(homogenise(LATTICES[name](), constants).tensor)
    assert (found.nu, found.zener) == pytest.approx((ratio, A), rel=1e-12)


# Independent values -------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def oracle():
    return json.loads((DATA / "s5_tensor_periodic2d.json").read_text())


def springs_of(oracle):
    x, pairs = np.array(oracle["points"]), np.array(oracle["springs"])
    cell = np.array(oracle["cell"])
    return pairs, x[pairs[:, 1]] + np.array(oracle["image_shift"]) * cell - x[pairs[:, 0]]


def test_a_random_network_has_the_tensor_that_another_program_found(oracle):
    pairs, vectors = springs_of(oracle)
    volume = float(np.prod(oracle["cell"]))
    found = homogenise_network(len(oracle["points"]), pairs, vectors, oracle["stiffness"], volume)
    C, affine = (np.array(oracle["tensor"][key]) for key in ("C", "C_affine"))
    np.testing.assert_allclose(found.tensor, C, atol=1e-12 * C.max())
    np.testing.assert_allclose(found.affine, affine, atol=1e-12 * affine.max())
    assert found.floppy == 0


def random_network(rng, d, n=5):
    """A few points, each joined to the nearest images of all others: rigid, far from affine."""
    x = rng.uniform(0, 1, (n, d))
    i, j = np.triu_indices(n, 1)
    steps = np.indices((3,) * d).reshape(d, -1).T - 1
    vectors = (x[j] - x[i])[:, None] + steps
    pairs = np.repeat(np.column_stack([i, j]), len(steps), axis=0)
    near = np.linalg.norm(vectors, axis=2).ravel() < 1.2
    vectors = vectors.reshape(-1, d)[near]
    return n, pairs[near], vectors, rng.uniform(0.5, 2, near.sum())


# Properties -----------------------------------------------------------------------------------


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10_000), d=st.sampled_from([2, 3]))
def test_relaxing_never_stiffens_and_central_forces_obey_cauchy_when_affine(seed, d):
    network = random_network(np.random.default_rng(seed), d)
    found = homogenise_network(*network, 1.0)
    scale = np.abs(found.affine).max()
    np.testing.assert_allclose(found.tensor, found.tensor.T)
    assert np.linalg.eigvalsh(found.affine - found.tensor)[0] > -1e-12 * scale
    assert np.linalg.eigvalsh(found.tensor)[0] > -1e-12 * scale
    assert found.affine[0, 1] == pytest.approx(
        found.affine[VOIGT[d].index((0, 1)), VOIGT[d].index((0, 1))], rel=1e-12
    )


def test_a_large_floppy_network_is_refused():
    with pytest.raises(SolverError, match="can move without stretching a spring"):
        homogenise(repeat_cell(patterns.square4(), 13), (1.0,))


@pytest.mark.parametrize(
    "lattice",
    [
        voronoi_box(Box((1.0, 1.0)), 0.3),
        fill_rotated(patterns.square(), Box((1.0, 1.0)), 0.2, 0.3),
    ],
    ids=lambda lattice: lattice.name,
)
def test_springs_of_an_irregular_body_are_not_taken_for_its_solid(lattice):
    # Summed up they would give the affine bound, and of a turned one with the boundary's braces.
    with refused(f"{lattice.name} lattice: its interior is not what its springs add up to"):
        interior_tensor(lattice, (1.0,) * lattice.kinds, "shared")


# Bad input ------------------------------------------------------------------------------------


@table(("call", "message"), [
    (lambda: homogenise(None, (1.0,)), "pattern: None; give a Pattern"),
    (lambda: homogenise(patterns.square(), (1.0,)), "(1.0,); give 2, one a kind"),
    (lambda: homogenise(patterns.square(), (1.0, math.nan)), "square: spring constants: nan"),
    (lambda: homogenise(patterns.square(), (1.0, 1.0), 0.0), "spacing: 0.0 m"),
    (lambda: homogenise_network(0, [[0, 0]], [[1.0, 0]], [1.0], 1.0), "points of the cell: 0"),
    (lambda: homogenise_network(1, [[0, 1]], [[1.0, 0]], [1.0], 1.0),
        "springs: points 0 to 1; there are 1"),
    (lambda: homogenise_network(1, [[0, 0.5]], [[1.0, 0]], [1.0], 1.0),
        "springs: [[0, 0.5]]; give"),
    (lambda: homogenise_network(1, [[0, 0]], [[0.0, 0]], [1.0], 1.0), "spring 0 has no length"),
    (lambda: homogenise_network(1, [[0, 0]], [[1.0, 0]], [1.0], 0.0), "volume: 0.0"),
    (lambda: homogenise_network(1, [[0, 0]], [[1.0, 0]], [-1.0], 1.0), "stiffness: [-1.0]; give"),
    (lambda: homogenise_network(1, [], [], [], 1.0), "stiffness: []; give"),
    (lambda: homogenise_network(10**9, [[0, 1]], [[1.0, 0]], [1.0], 1.0),
        "points, and the most is"),
    (lambda: repeat_cell(patterns.fcc(), 10**6), "repeated cell: 4e+18 points"),
    (lambda: moduli(np.diag([1.0, 2.0, 3.0])), "is not of cubic symmetry along the axes"),
    (lambda: isotropic_moduli(np.diag([1.0, 1.0, 0.0])), "some strain costs no energy"),
    (lambda: isotropic_moduli(np.eye(3) + np.eye(3, k=1)), "C[0, 1] = 1 and C[1, 0] = 0; give"),
])  # fmt: skip
def test_bad_input_is_refused(call, message):
    with refused(message):
        call()


# Stiff beside soft -------------------------------------------------------------------------------


def column(count, times):
    """A column of points 0.37 m apart, its upper half stiffer by so many times; its stiffness."""
    springs, ways, k, along = [], [], [], []
    for j in range(count):
        one = 1.0 if j < count // 2 else times
        springs += [[j, j]] + 3 * [[j, (j + 1) % count]]
        ways += [[1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [-1.0, 1.0]]
        k += [one, one, one / 2, one / 2]
        along.append(1 / (1.5 * one))  # the upright and two diagonals, in series from row to row
    return (count, springs, 0.37 * np.array(ways), k, count * 0.37**2), count / sum(along)


@pytest.mark.parametrize("times", [1e3, 1e9])
@pytest.mark.parametrize("count", [2, 10, 100, 400])
def test_rows_in_series_are_as_soft_as_their_springs_say(count, times):
    # Modes without 1e-10 of the largest stiffness counted as floppy: 17.4 for 3.0 at 100 and 1e9.
    cell, stiffness = column(count, times)
    found = homogenise_network(*cell)
    assert found.tensor[1, 1] == pytest.approx(stiffness, rel=found.error)
    assert found.floppy in {0, None}
    # Rounding of elongations weighs as the root of what stiffnesses are apart, between strains.
    assert found.error <= 1e-12 + 1e-15 * times**0.5
