"""What spacing and mesh a difference takes, what elements do better, what curved supports cost."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from msvalidate.case.budget import budget
from msvalidate.case.case import Case, make_lattice
from msvalidate.case.choice import Choice, Need, choice_sentences, choose
from msvalidate.case.comparison import NOT_TOLD, compare_case
from msvalidate.case.page import sentences
from msvalidate.case.springs import make_network, solve_springs
from msvalidate.case.supports import held_as
from msvalidate.linear_algebra.norms import max_length
from msvalidate.problem import Box, Isotropic, Polygon, Problem, Segment, Support, Traction
from reference_fem.body import solve_problem
from reference_fem.mesh.boxes import box_discretisation

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


def test_the_spacing_that_is_advised_gives_the_difference(bent):
    found, chosen = bent
    for need in chosen.springs:
        assert not any(np.isclose(need.spacing, each.spacing) for each in found.springs)
        assert need.least < need.spacing < need.most
        asked = compare_case(beam(cells=need.cells))
        assert 0.6 * need.target <= asked.rows[0].difference <= 1.4 * need.target
        assert asked.springs[0].spacing == need.spacing
        assert need.count == pytest.approx(len(asked.springs[0].lattice.springs), rel=0.1)
        assert make_lattice(asked.case, need.spacing).regular  # filled, as the lattices solved


def test_elements_are_as_much_nearer_at_equal_cost_as_is_said(bent):
    found, chosen = bent
    nodes = chosen.unknowns // 2
    across = int(np.sqrt(nodes / 8))
    mesh = box_discretisation(BEAM, (2 * across, across), "Q2")
    springs = solve_springs(beam(cells=1), 1 / round(np.sqrt(len(mesh.points) / 2)))
    at = springs.lattice.points
    wanted = found.reference.finest.at(at)
    elements = solve_problem(found.case.problem, mesh).at(at)
    times = max_length(springs.rest.displacement - wanted) / max_length(elements - wanted)
    assert chosen.use_elements
    assert max(3.0, 0.8 * chosen.times) <= times <= 4 * chosen.times  # doubts count against them


def test_another_material_has_no_spacing():
    chosen = choose(compare_case(beam(cells=6, constants=(1e5, 2e5))))
    assert [need.where for need in chosen.springs] == ["none", "none"]
    assert "for about 5 % in displacement: no spacing does" in choice_sentences(chosen)[0]


def test_what_every_lattice_meets_takes_the_coarsest():
    rollers = (Support(BEAM.side("left"), (0.0, None)), Support(BEAM.side("bottom"), (None, 0.0)))
    pulled = Problem(BEAM, LAW, rollers, (Traction(BEAM.side("right"), (10.0, 0.0)),))
    need = choose(compare_case(Case(pulled, cells=8, quantities=("displacement",)))).springs[0]
    assert (need.where, need.cells, need.count) == ("coarsest", 1, 11)


def test_beside_a_support_a_linear_motion_goes_on_as_it_is():
    A = np.array([[1e-3, 2e-3], [-4e-3, 5e-3]])
    case = slanted()
    lattice, network, _ = make_network(case, 1 / 8)
    moved = held_as(case.problem, lattice, network, lambda x: x @ A.T, 0.0)
    beside = network.held.all(axis=1) & ~SLANT.select(lattice.points, SLANTED.tolerance)
    assert 0 < lattice.inside[beside].mean() < 1
    wanted = (lattice.points @ A.T)[beside]
    np.testing.assert_allclose(moved.displacement[beside], wanted, atol=1e-15)


def test_what_a_slanted_support_costs_is_a_part_and_a_straight_one_costs_nothing(bent):
    found = compare_case(slanted())
    parts = budget(found).set_index("part")
    own = ["spacing", "support", "boundary", "material"]
    assert parts.loc[own, "value"].sum() == pytest.approx(parts.loc["total", "value"])
    assert parts.loc["support", "value"] > 0.5 * parts.loc["total", "value"]
    away = found.displacement - found.reference.displacement.value
    assert max_length(away - found.support) < 0.4 * max_length(away)
    assert found.kind == "coarse"  # what is left closes in, though the whole falls unevenly
    assert abs(parts.loc["boundary", "value"]) < parts.loc["boundary", "doubt"]
    assert "a support that no line of the lattice runs along" in choose(found).reasons
    said = sentences(replace(found, kind=NOT_TOLD))[1][0]  # as the budget has it
    assert "material is right to 0." in said
    assert "from material" not in said
    assert not bent[0].support.any()
    assert "support" not in set(budget(bent[0])["part"])


def test_words_are_of_the_record():
    known = Need(0.05, "between", 12400, 2.0, 14, 7e-4, 5e-4, 1e-3)
    vague = Need(0.01, "beyond", 150000, 30.0, 52, 2e-4, 4e-5, 3e-4)
    fine = Need(0.05, "coarsest", 340, 0.1)
    assert choice_sentences(Choice((known, vague), (fine,), 680, 4.2, ("walls",))) == (
        (
            "Springs for about 5 % in displacement: cells = 14 (0.0007 m, from 0.0005 to 0.001 m), "
            "12,400 springs, 2 s; for about 1 % in displacement: uncertain, perhaps cells = 52 "
            "(0.0002 m, from 4e-05 to 0.0003 m), "
            "150,000 springs, 30 s, finer than was solved."
        ),
        "Elements for about 5 % in displacement: at most 340 nodes, 0.1 s.",
        "Use elements: at 680 unknowns they are 4.2 times nearer than springs: walls.",
    )
