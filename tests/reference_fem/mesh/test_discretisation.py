"""Meshes, elements and interpolation, on distorted cells with straight edges."""

from __future__ import annotations

import numpy as np
import pytest

import reference_fem
from msvalidate.problem import Box, ProblemError
from reference_fem.mesh import make_discretisation
from reference_fem.mesh.elements import of_dimension
from tests.reference_fem.by_hand import with_middles
from tests.table import table

# A library's warning on the way to an answer is a failure here.
pytestmark = pytest.mark.filterwarnings("error")

PLANE = of_dimension(2)


def distorted(element, seed=0, n=4):
    """Points and cells (VTK order) of a unit square, inner corners moved by up to a fifth of h."""
    rng = np.random.default_rng(seed)
    y, x = np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1), indexing="ij")
    corners = np.column_stack([x.ravel(), y.ravel()])
    inner = ((corners > 0) & (corners < 1)).all(axis=1)
    corners[inner] += rng.uniform(-0.2 / n, 0.2 / n, (inner.sum(), 2))
    k = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    cells = np.stack([k[:-1, :-1], k[:-1, 1:], k[1:, 1:], k[1:, :-1]], axis=-1).reshape(-1, 4)
    return with_middles(corners, cells, element)


# --- interpolation --------------------------------------------------------------------------------


@table("place", [(1.01, 0.5), (0.5, -0.01), (-3.0, -3.0), (2.0, 2.0)])
@table("element", PLANE)
def test_point_outside_is_refused(element, place):
    body = make_discretisation(*distorted(element), element)
    with pytest.raises(ProblemError, match="must lie in the body"):
        body.interpolation(np.array([[0.5, 0.5], place]))


def test_point_that_is_no_number_is_refused():
    body = make_discretisation(*distorted("Q1"), "Q1")
    with pytest.raises(ProblemError, match="finite"):
        body.interpolation(np.array([[0.5, np.nan]]))


# --- bad meshes -----------------------------------------------------------------------------------


def test_quadratic_element_of_linear_points_is_refused():
    # Corners alone, repeated to fill the columns: no middle node exists.
    points, cells = distorted("Q1")
    with pytest.raises(ProblemError, match=r"cell 0 names point \d+ twice; Q2 lists corners, mid-"):
        make_discretisation(points, np.hstack([cells, cells, cells[:, :1]]), "Q2")


def test_nodes_that_are_not_those_of_the_cell_are_refused():
    body = reference_fem.box_discretisation(Box((1.0, 1.0)), 2, "Q2")
    cells = body.cells.copy()
    cells[1, 4:] = cells[2, 4:]
    with pytest.raises(ProblemError, match="cell 1 is inverted or folded: its curved sides turn"):
        make_discretisation(body.points, cells, "Q2")
