"""`compare.validity`: limitations, their numbers and remedies, and recorded exceptions."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from msvalidate.case.compare import comparison, quantities
from msvalidate.case.compare.choice import choice_sentences, choose
from msvalidate.case.compare.comparison import compare_case
from msvalidate.case.compare.validity import (
    WORDS,
    Limitation,
    layer_thickness,
    limitations,
    strain_exceeded,
)
from msvalidate.case.file.building import read_case
from msvalidate.case.file.case import Case
from msvalidate.case.file.fracture import Fracture
from msvalidate.case.judge.judgement import judge_result
from msvalidate.case.judge.results import Result
from msvalidate.case.springs import lattice_springs
from msvalidate.case.springs.large import answer_in_full, converge_case
from msvalidate.problem import (
    Ball,
    Box,
    Contact,
    Isotropic,
    Obstacle,
    Polygon,
    Problem,
    ProblemError,
    SolverError,
    Support,
    Traction,
    Zone,
)
from reference_fem.converged import converge
from reference_fem.mesh.boxes import box_discretisation

CASES = Path(__file__).parents[4] / "cases"
SIDE = 0.37


def block(E=1e5, nu=0.3, top=None, traction=(0.0, 0.0), sides=(SIDE, SIDE), **options):
    """A plane block of 0.37 m, 0.2 m thick, on a fixed side."""
    box = Box(sides)
    held = [Support(box.side("bottom"), (0.0, 0.0))]
    held += [Support(box.side("top"), (0.0, top * SIDE))] if top else []
    loads = (Traction(box.side("top"), traction),) if any(traction) else ()
    law = Isotropic(E, nu, "plane_strain", 1000.0, 0.2)
    contacts = options.pop("contacts", ())
    problem = Problem(box, law, tuple(held), loads, "block", contacts=contacts)
    options = {"cells": 2, "accuracy": 0.02, "quantities": ("displacement",)} | options
    return Case(problem, **options)


def slender(E, traction=(0.0, -1e3), **options):
    """A cantilever that stands on its clamp, ten times as high as wide."""
    sides = (SIDE / 10, SIDE)
    return block(E, traction=traction, sides=sides, cells=1, **options)


def pressed(force=None, depth=0.0, nu=0.3, **options):
    box = Box((SIDE, SIDE))
    disc = Obstacle("disc", (SIDE / 2, SIDE), (0.0, -1.0), SIDE)
    contacts = (Contact(box.side("top"), disc, depth, force),)
    return block(nu=nu, contacts=contacts, **{"cells": 8} | options)


TORN = Fracture(0.01)


def multiplied(case, factor):
    """The case with all loads, motions and obstacles multiplied."""
    problem = case.problem
    move = tuple(
        replace(s, displacement=tuple(None if u is None else factor * u for u in s.displacement))
        for s in problem.supports
    )
    loads = tuple(
        replace(each, traction=tuple(factor * t for t in each.traction)) for each in problem.loads
    )
    contacts = tuple(
        replace(each, depth=factor * each.depth, force=each.force and factor * each.force)
        for each in problem.contacts
    )
    changed = replace(problem, supports=move, loads=loads, contacts=contacts)
    return replace(case, problem=changed)


REMEDIED = {
    "strain": slender(1e6, (1e3, 0.0), nu=0.47),
    "unstable": slender(1e5, (0.0, -1e4)),
    "separated": block(top=0.08, nu=0.25, fracture=TORN),
    "penetration": pressed(force=1.5e3),
    "strained forces": block(top=0.3, quantities=("displacement", "reactions")),
    "penetration by depth": pressed(depth=0.2 * SIDE),
}


@pytest.mark.parametrize("name", REMEDIED)
def test_the_remedy_works_when_it_is_tried(name):
    kind = name.removesuffix(" by depth")
    (first, *_) = compare_case(REMEDIED[name]).limitations
    assert first.kind == kind
    assert f"{first.factor:.2g}"[:3] in first.sentence
    after = compare_case(multiplied(REMEDIED[name], first.factor)).limitations
    assert kind not in {each.kind for each in after}


def test_nonlinear_elements_are_the_remedy_of_a_beam_that_bends_far():
    case = slender(1e6, (1e3, 0.0))
    (first,) = compare_case(case).limitations
    assert first.kind == "nonlinear"
    assert compare_case(replace(case, geometry="nonlinear")).limitations == ()
    (requested,) = compare_case(replace(case, linear_theory="requested")).limitations
    assert not requested.decides
    assert requested.sentence == 'Judged by linear theory, as geometry = "linear" requests.'
    with pytest.raises(ProblemError, match="linear theory"):
        replace(case, linear_theory="mine")


def test_a_remedy_names_fracture_only_if_springs_break():
    case = slender(1e6, (1e3, 0.0), nu=0.25)
    for torn in (None, Fracture(10.0)):
        sentences = [e.sentence for e in compare_case(replace(case, fracture=torn)).limitations]
        assert any("Linear theory is out of its range" in each for each in sentences)
        assert any("without [fracture]" in each for each in sentences) == (torn is not None)


def test_every_sentence_has_its_words():
    for kind, words in WORDS.items():
        one = Limitation(kind, 0.3, 0.1, 0.27, "detail")
        assert one.sentence.startswith(one.fact)
        assert all(len(each.split()) <= 27 for each in words.values())
        assert one.decides == (kind not in ("requested", "frozen"))


def test_a_field_of_linear_theory_is_not_resolved_where_that_does_not_hold():
    case = slender(1e6, (1e3, 0.0))
    places = np.array([(0.0, SIDE), (0.0, SIDE / 2)])
    for E, word in ((1e6, "not resolved"), (1e10, "agrees")):
        case = slender(E, (1e3, 0.0))
        exact = converge_case(case, places).displacement.value
        found = judge_result(case, Result("mine", exact, places, None, 0.0, 0.0))
        assert found.verdict.word == found.displacement.word == word
        assert bool(found.verdict) == (word == "agrees")
        assert [each.kind for each in found.limitations] == ["nonlinear"] * (word != "agrees")


def test_a_finer_lattice_without_an_answer_is_a_limitation(monkeypatch):
    solve = lattice_springs.solve_springs

    def failing(case, spacing):
        if spacing < SIDE / 5:
            raise SolverError("folds")
        return solve(case, spacing)

    monkeypatch.setattr(lattice_springs, "solve_springs", failing)
    found = compare_case(block(top=1e-3))
    (one,) = found.limitations
    assert (one.kind, one.value) == ("lattice", SIDE / 8)
    assert found.rows[0].word == "not resolved"
    assert found.differences[0].word == "agrees"


def test_a_quantity_or_material_without_an_answer_is_a_limitation(monkeypatch):
    def failing(*_):
        raise SolverError("no energy")

    monkeypatch.setattr(quantities, "_energy", failing)
    case = block(top=1e-3, quantities=("displacement", "strain energy"))
    (one,) = compare_case(case).limitations
    assert one.sentence.startswith("strain energy: not compared: no energy.")
    monkeypatch.setattr(comparison, "homogenise", failing)
    kinds = [each.kind for each in compare_case(block(top=1e-3, constants=(1e4, 1e4))).limitations]
    assert kinds == ["material"]


def test_coarser_lattices_without_an_answer_are_told(monkeypatch):
    def failing(*_):
        raise SolverError("too coarse")

    found = compare_case(block(top=1e-3, cells=4))
    monkeypatch.setattr("msvalidate.case.compare.choice.solve_springs", failing)
    said = choice_sentences(choose(found))
    assert any("left out of this choice: too coarse." in each for each in said)


def test_a_finer_mesh_without_an_equilibrium_is_a_limitation():
    case = block(top=1e-3)
    reference = converge_case(case, np.array([(0.1, 0.1)]))
    full = answer_in_full(case, reference)
    assert limitations(case, reference, lambda: full) == ()
    target = full.target._replace(no_finer=SolverError("rounding"))
    (one,) = limitations(case, reference, lambda: replace(full, target=target))
    assert one.kind == "unsolved"
    none = replace(full, target=None, failure=SolverError("no"))
    (one,) = limitations(case, reference, lambda: none)
    assert one.sentence.startswith("Nonlinear elements have no answer: no.")


def test_a_later_separation_names_another_remedy():
    growth = SimpleNamespace(ended="parted", load=2.0)
    case = block(top=1e-3)
    reference = converge_case(case, np.array([(0.1, 0.1)]))
    full = answer_in_full(case, reference)
    (one,) = limitations(case, reference, lambda: full, growth)
    assert "Set raised to 1.8 or less" in one.sentence
    growth.ended = "raised"
    assert limitations(case, reference, lambda: full, growth) == ()


@pytest.mark.parametrize("scale", [1e-9, 0.04, 0.3])
def test_strain_is_greens(scale):
    # Linear displacements of a stretch, then of a turn, whose strain is quadratic.
    box = Box((SIDE, SIDE))
    body = box_discretisation(box, (4, 4), "Q2")
    for gradient, expected in (
        (np.diag([scale, 0.0]), scale + scale**2 / 2),
        (np.array([(0.0, -scale), (scale, 0.0)]), scale**2 / 2),
    ):
        solution = SimpleNamespace(body=body, displacement=body.points @ gradient.T)
        assert strain_exceeded(solution) == pytest.approx(expected, rel=1e-9, abs=1e-22)
        half = strain_exceeded(SimpleNamespace(body=body, displacement=solution.displacement), 0.5)
        assert half <= 0.5 * expected * (1 + 1e-12)


def test_strain_in_a_corner_alone_does_not_count():
    box = Box((1.0, 1.0))
    law = Isotropic(1e5, 0.3, "plane_strain")
    held = (Support(box.side("bottom"), (0.0, 0.0)),)
    problem = Problem(box, law, held, (Traction(box.side("top"), (0.0, 4e3)),))
    for solution in converge(problem, np.array([(1.0, 1.0)]), 1e-4).solutions[-2:]:
        corner = np.abs(solution.strain(np.array([(1e-6, 1e-6)]))).max()
        assert strain_exceeded(solution) < 0.05 < corner


def plate_with_hole():
    """A square of 1 with a slot that its outline goes around, and the same in mm."""
    corners = ((0, 0), (1, 0), (1, 1), (0, 1), (0, 0.6), (0.7, 0.6), (0.7, 0.4), (0, 0.4))
    return Polygon(tuple((float(x), float(y)) for x, y in corners))


@pytest.mark.parametrize("scale", [1.0, 1e-3])
def test_a_layer_ends_at_a_hole_or_another_material(scale):
    law = Isotropic(1e5, 0.3, "plane_strain")
    down = np.array([0.0, -1.0])
    box = Box((2 * scale, scale))
    zone = Zone(Ball((scale, scale), 0.3 * scale), Isotropic(1e7, 0.3, "plane_strain"))
    slotted = Polygon(tuple((scale * x, scale * y) for x, y in plate_with_hole().corners))
    for domain, x, zones, thickness in (
        (box, 0.3, (), 1.0),
        (slotted, 0.3, (), 0.4),
        (slotted, 0.9, (), 1.0),
        (box, 1.0, (zone,), 0.3),
    ):
        problem = Problem(domain, law, (), (), "layer", zones=zones)
        top = scale * np.array([x, 1.0])
        assert layer_thickness(problem, top, down) == pytest.approx(thickness * scale, rel=1e-4)
    assert layer_thickness(problem, scale * np.array([1.0, 1.0]), -down) < 1e-5 * scale


def test_the_frozen_set_is_judged_by_linear_theory(tmp_path):
    folders = {path.parent.name: path for path in sorted(CASES.glob("v1/*/case.toml"))}
    folders |= {path.parent.name: path for path in sorted(CASES.glob("v2/*/case.toml"))}
    assert len(folders) == 51
    plane = [path for name, path in folders.items() if "space" not in name]
    for path in plane[:: len(plane) // 8]:
        assert read_case(path).linear_theory == "frozen"
    own = CASES / "v1/bimaterial_bar_plane_stress"
    shutil.copytree(own, tmp_path / own.name)
    shutil.copy(CASES / "v1/SHA256SUMS", tmp_path)
    path = tmp_path / own.name / "case.toml"
    frozen = read_case(path)
    exact = converge_case(frozen, frozen.points).displacement.value
    result = Result("exact", exact, frozen.points, None, 0.0, 0.0)
    judged = judge_result(frozen, result)
    assert judged.verdict.word == "agrees"
    assert judged.limitations[0].kind == "frozen"
    path.write_text(path.read_text("utf-8") + "\n", encoding="utf-8")
    changed = read_case(path)
    assert changed.linear_theory == ""
    assert judge_result(changed, result).verdict.word == "not resolved"
