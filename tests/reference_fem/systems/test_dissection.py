"""Nested dissection: every unknown once, halves before what parts them, and few entries."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu

import reference_fem
from msvalidate.problem import Box, Isotropic
from reference_fem.elasticity import stiffness
from reference_fem.mesh.assembly import sparsity_pattern
from reference_fem.mesh.elements import ELEMENTS
from reference_fem.systems import dissection
from reference_fem.systems.dissection import elimination_order, node_order


@pytest.mark.parametrize("element", ELEMENTS)
@pytest.mark.parametrize("cells", [1, 2, 5])
def test_every_free_component_comes_once(element, cells):
    dim = ELEMENTS[element].dim
    body = reference_fem.box_discretisation(Box((1.0,) * dim), cells, element, 1.5)
    np.testing.assert_array_equal(np.sort(node_order(body)), np.arange(len(body.points)))
    held = np.random.default_rng(0).random(body.points.shape) < 0.3
    order = elimination_order(body, held)
    np.testing.assert_array_equal(np.sort(order), np.arange((~held).sum()))
    # Components of a node follow each other: their places among the free, node by node.
    free = np.flatnonzero(~held.T.ravel())[order] % len(body.points)
    assert (np.diff(free) != 0).sum() + 1 == (~held).any(axis=1).sum()


def test_a_bar_is_cut_in_its_middle_first(monkeypatch):
    monkeypatch.setattr(dissection, "SMALL", 1)
    body = reference_fem.box_discretisation(Box((8.0, 1.0)), (8, 1), "Q1")
    x = body.points[node_order(body), 0]
    np.testing.assert_array_equal(x[-2:], [4.0, 4.0])  # last, what parts the halves
    assert (x[:8] < 4).all()
    np.testing.assert_array_equal(x[6:8], [2.0, 2.0])  # and so in each half
    np.testing.assert_array_equal(x[14:16], [6.0, 6.0])


def test_cells_are_counted_not_metres(monkeypatch):
    # A bar of 8 m by 1 m with 2 cells along it and 16 across: cut across the 16.
    monkeypatch.setattr(dissection, "SMALL", 1)
    body = reference_fem.box_discretisation(Box((8.0, 1.0)), (2, 16), "Q1")
    np.testing.assert_array_equal(body.points[node_order(body)[-3:], 1], [0.5, 0.5, 0.5])


def entries(body, ordering):
    """Entries of a factor of a clamped body, with and without nested dissection."""
    held = np.repeat(body.points[:, :1] == 0, body.dim, axis=1)
    free = np.flatnonzero(~held.T.ravel())
    if ordering == "NATURAL":
        free = free[elimination_order(body, held)]
    law = Isotropic(1.0, 0.3, "solid" if body.dim == 3 else "plane_stress")
    A = csc_matrix(stiffness(body, law)[free][:, free])
    options = {"SymmetricMode": True}
    return splu(A, permc_spec=ordering, diag_pivot_thresh=0.0, options=options).nnz


@pytest.mark.parametrize(
    ("size", "cells", "element", "share"),
    [
        ((1.0, 1.0), 64, "Q1", 0.9),
        ((1.0, 1.0), 32, "P2", 1.0),
        ((1.0, 1.0, 1.0), 10, "H1", 0.9),
        ((1.0, 1.0, 1.0), 5, "T2", 1.0),
        ((1.0, 1.0, 0.2), (15, 15, 3), "H1", 0.8),
        ((10.0, 1.0, 1.0), (50, 4, 4), "H1", 1.1),
    ],
)
def test_no_more_entries_than_by_minimum_degree(size, cells, element, share):
    body = reference_fem.box_discretisation(Box(size), cells, element)
    assert entries(body, "NATURAL") <= share * entries(body, "MMD_AT_PLUS_A")


def test_a_body_of_many_parts_and_shapes_is_cut_too():
    one = reference_fem.box_discretisation(Box((1.0, 1.0)), 4, "P1", 3.0)
    offsets = np.array([[0.0, 0.0], [1e3, 0.0], [0.0, -1.1]])
    points = np.concatenate([one.points + offset for offset in offsets])
    cells = np.concatenate([one.cells + i * len(one.points) for i in range(3)])
    body = reference_fem.make_discretisation(points, cells, "P1")
    np.testing.assert_array_equal(np.sort(node_order(body)), np.arange(len(points)))


def test_a_pattern_is_the_sum_over_cells():
    random = np.random.default_rng(0)
    cells = np.array([random.permutation(9)[:4] for _ in range(6)])
    shared = sparsity_pattern(cells, 9)
    values = random.random((6, 4, 4))
    wanted = np.zeros((9, 9))
    for cell, block in zip(cells, values, strict=True):
        wanted[np.ix_(cell, cell)] += block
    summed = shared.gather @ values.ravel()
    np.testing.assert_allclose(shared.matrix(summed).toarray(), wanted, rtol=1e-14, atol=0)
    np.testing.assert_array_equal(shared.matrix(summed[shared.mirror]).toarray(), wanted.T)
    blocks = random.random((3, 3, len(summed)))
    whole = shared.component_major(blocks)
    assert whole.has_sorted_indices
    assert whole.has_canonical_format
    for a, b in np.ndindex(3, 3):
        found = whole[9 * a : 9 * (a + 1), 9 * b : 9 * (b + 1)].toarray()
        np.testing.assert_array_equal(found, shared.matrix(blocks[a, b]).toarray())


@pytest.mark.parametrize("element", ["Q1", "P2", "H1"])
def test_rounding_of_coordinates_changes_no_cut(element):
    # A square's or cube's axes are alike, and so are two cuts of an odd number of cells.
    dim = ELEMENTS[element].dim
    body = reference_fem.box_discretisation(Box((0.37,) * dim), 11 if dim == 2 else 5, element)
    usual, eps = node_order(body), np.finfo(float).eps
    for seed in range(5):
        off = np.random.default_rng(seed).integers(-2, 3, body.points.shape)
        other = reference_fem.make_discretisation(
            body.points + 0.37 * eps * off, body.cells, element
        )
        np.testing.assert_array_equal(node_order(other), usual)
