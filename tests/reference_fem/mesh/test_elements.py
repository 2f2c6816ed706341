"""Every row of `ELEMENTS` against the shapes of floor 0, which share no code with the library."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
import skfem

from msvalidate.problem import SHAPES, Isotropic
from reference_fem.elasticity import elastic_tensor, stiffness
from reference_fem.mesh import ELEMENTS, make_discretisation

every = pytest.mark.parametrize("element", ELEMENTS)
SHARES = {
    "Q1": (1 / 4,),
    "P1": (1 / 3,),
    "H1": (1 / 8,),
    "T1": (1 / 4,),
    "Q2": (1 / 36, 1 / 9, 4 / 9),
    "S2": (-1 / 12, 1 / 3),
    "P2": (0.0, 1 / 3),
    "H2": (1 / 216, 1 / 54, 2 / 27, 8 / 27),
    "T2": (-1 / 20, 1 / 5),
}
"""Of a cell's weight: a corner's, a mid-side's, a face's, the middle's ([ZienkiewiczTaylorZhu2013];
of boxes, products of Simpson's 1/6, 4/6, 1/6)."""
SLANTED = np.array([[0.37, 0.11, -0.05], [-0.08, 0.29, 0.07], [0.03, -0.04, 0.41]])
"""Edges (m) of a parallelepiped: what the unit cell's axes are mapped to."""


def integrated_by_hand(shape, edges, C):
    """Stiffness (nodes·d, nodes·d) of one cell without curved sides: ∫ BᵀCB, Gauss's 5 points.

    A simplex is a cube collapsed: x, (1 - x) y, (1 - x)(1 - y) z.
    """
    d = shape.dim
    x, w = np.polynomial.legendre.leggauss(5)
    at = np.array(list(product((x + 1) / 2, repeat=d)))
    weight = np.prod(list(product(w / 2, repeat=d)), axis=1)
    if shape.simplex:
        left = np.cumprod(np.column_stack([np.ones(len(at)), 1 - at]), axis=1)[:, :d]
        weight *= left.prod(axis=1)
        at = at * left
    slopes = shape.slopes(at) @ np.linalg.inv(edges)
    pairs = [(a, a) for a in range(d)] + ([(0, 1)] if d == 2 else [(1, 2), (0, 2), (0, 1)])
    B = np.zeros((len(at), len(pairs), len(shape.nodes), d))
    for row, (a, b) in enumerate(pairs):
        B[:, row, :, a] += slopes[:, :, b]
        if a != b:
            B[:, row, :, b] += slopes[:, :, a]
    B = B.reshape(len(at), len(pairs), -1)
    weight *= abs(np.linalg.det(edges))
    return np.einsum("q,qim,ij,qjn->mn", weight, B, C, B)


@every
def test_the_stiffness_of_one_cell_is_the_integral_by_hand(element):
    kind = ELEMENTS[element]
    shape, d = SHAPES[kind.shape], kind.dim
    edges = SLANTED[:d, :d]
    law = Isotropic(7.0, 0.3, "plane_strain" if d == 2 else "solid")
    points = shape.nodes @ edges.T
    C = elastic_tensor(law)
    found = stiffness(make_discretisation(points, [range(kind.nodes)], element), law).toarray()
    by_node = np.arange(kind.nodes * d).reshape(d, -1).T.ravel()  # unknowns run by component
    wanted = integrated_by_hand(shape, edges, C)
    np.testing.assert_allclose(found[np.ix_(by_node, by_node)], wanted, atol=1e-13 * wanted.max())


@pytest.mark.parametrize("element", SHARES)
def test_weight_is_shared_out_as_in_textbooks(element):
    kind = ELEMENTS[element]
    body = make_discretisation(
        kind.places @ SLANTED[: kind.dim, : kind.dim].T, [range(kind.nodes)], element
    )
    found = np.zeros(kind.nodes)
    found[body.node] = skfem.LinearForm(lambda v, _: v).assemble(body.quadrature(4))
    sizes = [1] * kind.corners + [len(amid) for amid in kind.middles]
    order = {size: number for number, size in enumerate(sorted(set(sizes)))}
    wanted = [SHARES[element][order[size]] for size in sizes]
    np.testing.assert_allclose(found / found.sum(), wanted, atol=1e-14)
