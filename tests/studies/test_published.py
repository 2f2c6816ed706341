"""The question `published`: printed table, claim and reasons; a fault of 1 % is noticed."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from msvalidate.studies.benchmarks import (
    controls,
    framed_plate,
    published,
    published_membranes,
    published_sources,
    spring_meshes,
)

from msvalidate.judging.candidate import solve_springs
from msvalidate.judging.evidence import Evidence, all_passed, judge
from msvalidate.judging.sweep import Setting
from msvalidate.network import faults
from msvalidate.problem import Box, SolverError
from reference_fem import box_discretisation, refine


@pytest.fixture(scope="module")
def evidence() -> Evidence:
    return published.run(setting=Setting(quick=True))


def test_printed_table_is_found_again(evidence: Evidence) -> None:
    assert all_passed(judge(evidence))
    table = evidence.tables["published"]
    assert list(table["cells"]) == [n for n in spring_meshes.PRINTED if n <= published.QUICK]
    assert np.abs(table["from_printed"]).max() < 1e-12
    # Every row is stiffer than the plate with bars, and that than the plate.
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


def test_springs_a_little_stiffer_are_noticed() -> None:
    verdict = judge(
        published.run(controls.body_with(faults.stiffen_all, 1e-9), Setting(quick=True))
    )
    failed = set(verdict["quantity"][verdict["verdict"] == "fail"])
    assert any("from the printed" in quantity for quantity in failed)
    assert any("from the form" in quantity for quantity in failed)
    # What does not depend on the candidate still holds.
    assert not any("finite elements" in quantity for quantity in failed)


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


def test_weak_bars_have_their_first_effect() -> None:
    assert spring_meshes.leading() == pytest.approx(20 / 9)
    assert spring_meshes.weak_frame() == pytest.approx(20 / 9, abs=1e-4)


def test_refinement_that_misses_is_refused() -> None:
    box, problem = spring_meshes.tension(1, spring_meshes.elastic())
    with pytest.raises(SolverError, match="reference not converged"):
        refine(lambda n: framed_plate.work_on(box, problem, 1.0, n), 2, 1e-12, finest=8)


def test_sources_say_what_was_not_had() -> None:
    table = published_sources.table()
    assert list(table["used"]).count("row by row") == 1
    missing = published_sources.without_numbers()
    assert len(missing) == (table["used"] == "none").sum() > 0
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
