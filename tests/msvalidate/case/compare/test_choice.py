"""What spacing and mesh a difference takes, what elements do better, what curved supports cost."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from msvalidate.case.compare import choice
from msvalidate.case.compare.budget import budget, mesh_rows
from msvalidate.case.compare.choice import _equal_cost, choice_sentences, choose
from msvalidate.case.compare.comparison import NOT_TOLD, compare_case
from msvalidate.case.file.case import Case
from msvalidate.case.report.headline import recommend
from msvalidate.case.report.page import sentences
from msvalidate.linear_algebra.norms import max_length
from msvalidate.problem import (
    Box,
    Contact,
    Isotropic,
    Obstacle,
    Polygon,
    Problem,
    Segment,
    Support,
    Traction,
)

BEAM, LAW = Box((2.0, 1.0)), Isotropic(1e5, 0.3)
SLANTED = Polygon(((0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.3, 1.0)))
SLANT = Segment((0.3, 1.0), (0.0, 0.0))


def beam(**options):
    held, load = Support(BEAM.side("left"), (0.0, 0.0)), Traction(BEAM.side("right"), (0.0, -10.0))
    return Case(
        Problem(BEAM, LAW, (held,), (load,)),
        quantities=("displacement",),
        accuracy=0.005,
        **options,
    )


def slanted():
    load = Traction(Segment((2.0, 0.0), (2.0, 1.0)), (0.0, -10.0))
    problem = Problem(SLANTED, LAW, (Support(SLANT, (0.0, 0.0)),), (load,))
    return Case(problem, cells=8, quantities=("displacement",), accuracy=0.005)


@pytest.fixture(scope="module")
def bent():
    found = compare_case(beam(cells=9))
    return found, choose(found)


def long_beam():
    """A beam whose advised spacing for 5 % was 5.07 % off."""
    box = Box((10.0, 1.0))
    held, load = Support(box.side("left"), (0.0, 0.0)), Traction(box.side("right"), (0.0, -1.0))
    return Case(Problem(box, LAW, (held,), (load,)), cells=4)


def pressed():
    """A block below a disc whose advised spacing for 5 % was 9.4 % off."""
    box = Box((1.0, 1.0))
    contact = Contact(box.side("top"), Obstacle("disc", (0.37, 1.0), (0.0, -1.0), 1.5), depth=0.01)
    held = (Support(box.side("bottom"), (0.0, 0.0)),)
    return Case(Problem(box, Isotropic(1e5, 0.3), held, contacts=(contact,)), cells=6)


@pytest.mark.parametrize("make", [long_beam, pressed, slanted])
def test_an_advised_spacing_has_the_verdict_that_it_promises(make):
    case = replace(make(), accuracy=1e-3, quantities=("displacement", "strain energy"))
    for need in choose(compare_case(case)).springs:
        if need.count and need.where != "beyond":
            tried = compare_case(replace(case, cells=need.cells, spacing=None, band=need.target))
            words = {row.quantity: row.word for row in tried.rows}
            assert words["displacement"] == "agrees"
            assert words["strain energy"] in ("agrees", "not asked")


def test_another_material_has_no_spacing():
    chosen = choose(compare_case(beam(cells=6, constants=(1e5, 2e5))))
    assert [need.where for need in chosen.springs] == ["none", "none"]
    assert "Estimated for 5 %, springs: no spacing does" in choice_sentences(chosen)[0]


@pytest.mark.parametrize("offset", [0.0, -0.02, 0.01])
def test_no_spacing_is_extrapolated_while_springs_bridge_a_gap(offset):
    left, right = 1.0 + offset, 1.04 + offset
    slot = ((right, 1.0), (right, 0.25), (left, 0.25), (left, 1.0))
    body = Polygon(((0.0, 0.0), (2.0, 0.0), (2.0, 1.0), *slot, (0.0, 1.0)))
    ends = Segment((0.0, 1.0), (0.0, 0.0)), Segment((2.0, 0.0), (2.0, 1.0))
    supports, loads = (Support(ends[0], (0.0, 0.0)),), (Traction(ends[1], (10.0, 0.0)),)
    coarse = Case(Problem(body, LAW, supports, loads), spacing=0.25, accuracy=0.01, unit="mm")
    found = compare_case(replace(coarse, quantities=("displacement",)))
    chosen = choose(found)
    assert found.kind == NOT_TOLD
    assert found.gaps[0][0] == pytest.approx([(left + right) / 2, found.gaps[0][0, 1], 0.04])
    assert [need.where for need in chosen.springs] == ["bridged"] * 2
    assert "springs: resolve the gap of 40 mm first;" in choice_sentences(chosen, "mm")[0]
    assert "a gap of 40 mm" in recommend(found, chosen).sentence
    assert "40 mm wide at" in "".join(sentences(found)[1])


def test_a_mesh_of_as_many_nodes_as_the_finest_springs_is_compared():
    asked = SimpleNamespace(lattice=SimpleNamespace(points=np.zeros((9, 2))))
    reference = SimpleNamespace(error=0.0)
    found = SimpleNamespace(springs=[asked], reference=reference, points=asked.lattice.points)
    rows = [{"points": 4, "difference": 0.2}, {"points": 9, "difference": 0.1}]
    cost = _equal_cost(found, rows, [{"nodes": 9, "difference": 0.05}])
    assert cost == pytest.approx((18, 2.0))


def test_what_every_lattice_meets_takes_the_coarsest():
    rollers = (Support(BEAM.side("left"), (0.0, None)), Support(BEAM.side("bottom"), (None, 0.0)))
    pulled = Problem(BEAM, LAW, rollers, (Traction(BEAM.side("right"), (10.0, 0.0)),))
    found = compare_case(Case(pulled, cells=8, quantities=("displacement",)))
    need = choose(found).springs[0]
    assert found.kind == ""
    assert "no difference remains on any of these lattices" in " ".join(sentences(found)[1])
    assert (need.where, need.cells, need.count) == ("coarsest", 1, 11)


def test_a_lattice_that_is_cut_is_taken_before_one_that_fills_far_off():
    box = Box((5.6, 1.9))  # which 19 cells across fill, and no number near 10
    case = Case(Problem(box, LAW, (Support(box.side("left"), (0.0, 0.0)),)), cells=19)
    found = SimpleNamespace(case=case, springs=(SimpleNamespace(spacing=0.1),))
    assert choice._laid(found, 0.2).cells in {9, 10}


def test_what_a_slanted_support_costs_is_a_part_and_a_straight_one_costs_nothing(bent):
    found = compare_case(slanted())
    parts = budget(found).set_index("part")
    own = ["spacing", "support", "boundary", "material"]
    assert parts.loc[own, "value"].sum() == pytest.approx(parts.loc["total", "value"])
    assert parts.loc["support", "value"] > 0.5 * parts.loc["total", "value"]
    away = found.displacement - found.reference.displacement.value
    assert max_length(away - found.support) < 0.4 * max_length(away)
    assert found.kind == "coarse"  # what is left closes in, though the whole falls unevenly
    assert abs(parts.loc["boundary", "value"]) < parts.loc["boundary", "uncertainty"]
    assert parts.loc["boundary", "uncertainty"] == parts.loc["spacing", "uncertainty"]
    assert parts.loc["total", "value"] == pytest.approx(max_length(away) / found.size)
    off = max_length(found.reference.by_mesh[0] - found.reference.displacement.value)
    assert mesh_rows(found)[0]["difference"] == pytest.approx(off / found.size)
    assert "a support that no line of the lattice runs along" in choose(found).reasons
    said = sentences(replace(found, kind=NOT_TOLD))[1][0]  # as the budget has it
    assert "material is right to 0." in said
    assert "from material" not in said
    assert "A support that no line of the lattice runs along costs up to" in said
    assert not bent[0].support.any()
    assert "support" not in set(budget(bent[0])["part"])


def test_a_spacing_that_reaches_a_target_is_finer_than_one_that_was_measured_worse():
    found = compare_case(beam(cells=8))
    spacing = found.springs[0].spacing
    rows = [{"spacing": spacing, "springs": 200, "seconds": 0.1, "off": 0.051}]
    wanted = choice.Need(0.05, choice.BETWEEN, spacing=0.99 * spacing)
    need = choice._costed(found, rows, wanted, 0.05)
    assert need.count
    assert need.spacing < 0.999 * spacing
