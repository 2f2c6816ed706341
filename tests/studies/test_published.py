"""The question `published`: printed table, claim and reasons; a fault of 1 % is noticed."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from msvalidate.studies.benchmarks import (
    framed_plate,
    spring_meshes,
)

from msvalidate.bench.judging.candidate import solve_springs
from msvalidate.problem import Box
from reference_fem import box_discretisation


def test_closed_form_of_one_cell_by_hand() -> None:
    """Quarter of a cell: half a side, to the middle of which the corner leans, and a half diagonal.

    Of the corner's move (u, v) a side along x takes 2u, one along y 2v and a diagonal (u + v)√2:
    energy 4χ(u² + v²) + 2(u + v)², work of two forces of ½ N on 2u each.
    """
    chi = Fraction(3, 7)
    matrix = ((8 * chi + 4, Fraction(4)), (Fraction(4), 8 * chi + 4))
    (a, b), (c, d) = matrix
    move = 2 * d / (a * d - b * c)  # of the work 2u's slope, 2, by Cramer's rule
    stiffness = 1 / (2 * move)
    assert stiffness == Fraction(4) * chi * (chi + 1) / (2 * chi + 1)
    assert spring_meshes.apparent_stiffness(solve_springs, 1, float(chi)) == pytest.approx(
        float(stiffness), rel=1e-13
    )


def test_bars_are_bars() -> None:
    """A uniform strain stores EA ε²/2 a metre, and a rigid turn nothing."""
    mesh = box_discretisation(Box((3.0, 2.0)), 4, "Q2", 2.0)
    frame = framed_plate.frame(mesh)
    x, y = mesh.points.T
    stretch = np.concatenate([0.1 * x, 0.2 * y])
    assert stretch @ (frame @ stretch) == pytest.approx(2 * 3 * 0.1**2 + 2 * 2 * 0.2**2)
    turn = np.concatenate([-y, x])
    assert np.abs(frame @ turn).max() < 1e-12
    square = np.concatenate([x**2, 0 * y])  # strain 2x: ∫4x² over both long sides
    assert square @ (frame @ square) == pytest.approx(2 * 4 * 3.0**3 / 3)


def test_a_plate_without_bars_is_elastic() -> None:
    box, problem = spring_meshes.tension(3, spring_meshes.elastic())
    assert framed_plate.work_on(box, problem, 0.0, 4) == pytest.approx(3 / 8, rel=1e-12)
