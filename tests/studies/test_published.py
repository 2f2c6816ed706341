"""The question `published`: printed table, claim and reasons; a fault of 1 % is noticed."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from msvalidate.studies.benchmarks import (
    framed_plate,
    published,
    published_membranes,
    spring_meshes,
)

from msvalidate.judging.candidate import solve_springs
from msvalidate.judging.evidence import Evidence
from msvalidate.judging.sweep import Setting
from msvalidate.problem import Box
from reference_fem import box_discretisation


@pytest.fixture(scope="module")
def evidence() -> Evidence:
    return published.run(setting=Setting(quick=True))


def test_meshes_are_stiffer_than_the_plate_with_bars_and_that_than_the_plate(
    evidence: Evidence,
) -> None:
    table = evidence.tables["published"]
    assert (table["stiffness"] > table["stiffness_framed"]).all()
    assert (table["stiffness_framed"] > table["stiffness_fem"]).all()


def test_the_text_names_too_small_a_mesh(evidence: Evidence) -> None:
    named, beyond, within = evidence.tables["published_claim"].itertuples()
    assert named.cells == 64
    assert named.too_stiff == pytest.approx(named.too_stiff_printed, rel=1e-9)
    assert named.too_stiff > 0.01
    assert within.cells == beyond.cells + 1
    assert beyond.too_stiff > 0.01 >= within.too_stiff


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


def test_sources_say_what_was_not_had() -> None:
    table = published.SOURCES
    assert list(table["used"]).count("row by row") == 1
    missing = table["paper"][table["used"] == "none"]
    assert all(name in published.describe_missing() for name in missing)


def test_random_membranes_soften(evidence: Evidence) -> None:
    """Regular √3/4 and √3/2; random ones at rest below, held above and twice their shear."""
    table = evidence.tables["published_membrane"].set_index("points")
    regular = table.loc["regular"]
    assert regular["shear_modulus"] == pytest.approx(np.sqrt(3) / 4)
    assert regular["area_modulus"] == pytest.approx(np.sqrt(3) / 2)
    for points in published_membranes.RANDOM:
        row = table.loc[points]
        assert row["shear_modulus"] < regular["shear_modulus"] < row["shear_held"]
        assert row["area_modulus"] < regular["area_modulus"] < row["area_held"]
        assert row["area_over_shear"] < 2
    assert published_membranes.finding(table.reset_index()).startswith("Not confirmed")
