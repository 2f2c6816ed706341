"""Known mistakes in bodies in 2D and 3D: the true one is among the causes that are reported."""

from __future__ import annotations

import functools
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import eigh

from msvalidate.case.file.building import read_case
from msvalidate.case.file.case import make_lattice, spacing_of
from msvalidate.case.judge import judgement
from msvalidate.case.judge.judgement import judge_result
from msvalidate.case.judge.mistake_fields import known_mistakes
from msvalidate.case.judge.results import Result
from msvalidate.case.report.headline import recommend_for_field
from msvalidate.case.report.page import judged_sentences
from msvalidate.problem import Polygon, Traction, Weight, prescribed_displacements
from msvalidate.problem.records import replace
from msvalidate.springs.bodies.cut_network import cut_network
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.constants.routes import calibrate_by_route
from msvalidate.springs.lattice import CutLattice
from msvalidate.springs.statics.equilibrium import equilibrium
from msvalidate_check.beside import Field, Mistake
from msvalidate_check.diagnosis import explain
from msvalidate_check.mistakes import explain_mistakes
from reference_fem import box_discretisation, solve_problem
from reference_fem.body import nodal_forces
from reference_fem.converged import converge
from reference_fem.elasticity import stiffness
from reference_fem.first_mesh import kept_places
from reference_fem.mesh.outlines import outline_discretisation
from tests.table import table

TESTS = Path(__file__).parents[3]
E = 1e5
NOTICED = 3.0
"""Uncertainties by which a mistake must change the field for its cause to be distinguishable."""


BODIES = {path.stem: path for path in sorted((TESTS / "data" / "mistakes").glob("*.toml"))}
"""Case files of bodies in 2D and 3D, one of them in mm."""

MOST_NODES = 8_000
"""Nodes of the elements in 3D: two meshes of these take some seconds."""


def first_mesh(case):
    """In 3D fewer cells than the lattice has, so that two meshes are few nodes."""
    box = case.problem.domain
    if box.dim == 2:
        return {}
    cells = tuple(round((case.cells - 1) * side / min(box.size)) for side in box.size)
    return {"first": box_discretisation(box, cells, "H2"), "most_nodes": MOST_NODES}


OTHER_LAWS = judgement._with_other_laws


class Bench:
    """A case with its elasticity at the points of its lattice, and what mistakes make of it."""

    def __init__(self, case):
        self.case, self.problem, self.laws = case, case.problem, None
        self.lattice = make_lattice(case, spacing_of(case))
        self.cut = cut = isinstance(self.lattice, CutLattice)
        self.inside = self.lattice.inside if cut else np.ones(len(self.lattice.points), dtype=bool)
        self.places = self.lattice.points[self.inside]
        self.build = cut_network if cut else lattice_network
        self.made = calibrate_by_route(self.problem.material, self.lattice, None, None)
        self.reference = converge(self.problem, self.places, case.accuracy, **first_mesh(case))
        self.elastic = self.reference.displacement.value
        self.catalogue = known_mistakes(case, self.places, self.reference)

    def with_other_laws(self, field, *rest):
        """The field with elasticity of other ratios, which all fields of the body share."""
        if self.laws is None:
            self.laws = OTHER_LAWS(field, *rest)
        shared = {name: getattr(self.laws, name) for name in ("ratios", "by_ratio", "other_state")}
        return replace(field, **shared)

    def changed(self, **changes):
        """Elasticity of a problem with other values of its material."""
        return self.solved(
            replace(self.problem, material=replace(self.problem.material, **changes))
        )

    def solved(self, problem):
        body = self.reference.finest.body
        own = solve_problem(self.problem, body).at(self.places)
        return self.elastic + solve_problem(problem, body).at(self.places) - own

    def springs(self, constants=None, change=lambda network: network, **options):
        network = self.build(self.problem, self.lattice, constants or self.made, **options)
        return equilibrium(change(network)).displacement[self.inside]

    def whole(self, constants=None):
        if not self.cut:
            return self.springs(constants, weights="equal")
        k = np.array(constants or self.made.constants)[self.lattice.kind]
        return self.springs(constants, lambda network: replace(network, stiffness=k))

    @property
    def alike(self):
        law = self.problem.material
        return E * (self.made.spacing if law.dim == 3 else law.thickness)

    def elements(self, across, simplex):
        """Linear elements with so many cells across the narrowest side."""
        domain = self.problem.domain
        if isinstance(domain, Polygon):
            body = outline_discretisation(domain, 1 / across, kept_places(self.problem))
        else:
            counts = [round(across * side / min(domain.size)) for side in domain.size]
            kind = {True: ("P1", "T1"), False: ("Q1", "H1")}[simplex][domain.dim - 2]
            body = box_discretisation(domain, tuple(counts), kind)
        return solve_problem(self.problem, body, allow_locked=True).at(self.places)

    def unfinished(self):
        """The state of a gradient descent in which a third of the slowest mode is missing."""
        solution = self.reference.solutions[0]
        body, law = solution.body, self.problem.material
        held, _ = prescribed_displacements(self.problem, body.points)
        free = ~held.T.ravel()
        K = stiffness(body, law).toarray()[np.ix_(free, free)]
        force = nodal_forces(self.problem, body).T.ravel()[free]
        rate, modes = eigh(K)
        lag = np.zeros(len(free))
        at = modes.T @ force / rate
        time = math.log(3.0) / rate[np.abs(at).argmax()]
        lag[free] = modes @ (at * np.exp(-rate * time))
        return self.elastic - body.interpolation(self.places) @ lag.reshape(body.dim, -1).T

    def rest_length(self):
        network = self.build(self.problem, self.lattice, self.made)
        longer = replace(network, rest_length=1.0005 * network.rest_length)
        return equilibrium(longer, "nonlinear").displacement[self.inside]

    def equal_masses(self):
        loads = [load for load in self.problem.loads if isinstance(load, Weight)]

        def even(network):
            mass = network.mass.mean() - network.mass
            more = sum(np.outer(mass, load.acceleration) for load in loads)
            return replace(network, force=network.force + more)

        return self.springs(change=even)

    def heavier(self):
        density = self.problem.material.density
        if not any(isinstance(load, Weight) for load in self.problem.loads):
            return self.elastic
        return self.changed(density=2 * density)

    def other_state(self):
        law = self.problem.material
        other = {"plane_stress": "plane_strain", "plane_strain": "plane_stress"}.get(law.state)
        return self.elastic if other is None else self.changed(state=other)

    def thinner(self):
        """A body of 0.7 times the thickness under the same forces, its weight apart."""
        if self.problem.domain.dim == 3:
            return self.elastic
        loads = [
            replace(load, traction=tuple(t / 0.7 for t in load.traction))
            if isinstance(load, Traction)
            else load
            for load in self.problem.loads
        ]
        return self.solved(replace(self.problem, loads=tuple(loads)))


def reversed_load(b, number):
    """Elasticity with one load in the opposite direction."""
    loads = list(b.problem.loads)
    name = "acceleration" if isinstance(loads[number], Weight) else "traction"
    value = tuple(-x for x in getattr(loads[number], name))
    loads[number] = replace(loads[number], **{name: value})
    return b.solved(replace(b.problem, loads=tuple(loads)))


MISTAKES = {
    "whole boundary springs": Bench.whole,
    "k2 = 2 k1": lambda b: b.springs((b.made.constants[0], 2 * b.made.constants[0])),
    "k2 = 2 k1, k1 = E t": lambda b: b.springs((b.alike, 2 * b.alike)),
    "k = E h": lambda b: b.springs((b.alike,) * 2),
    "k = E": lambda b: b.springs((E,) * 2),
    "k = E h, whole": lambda b: b.whole((b.alike,) * 2),
    "equal masses": Bench.equal_masses,
    "doubled mass": Bench.heavier,
    "rest length": Bench.rest_length,
    "coarse triangles": lambda b: b.elements(5, simplex=True),
    "coarse quadrilaterals": lambda b: b.elements(3, simplex=False),
    "coarse springs": Bench.springs,
    "not converged": Bench.unfinished,
    "unit of k": lambda b: b.elastic / 1000,
    "plane state": Bench.other_state,
    "thickness": Bench.thinner,
    "load": lambda b: 0.8 * b.elastic,
    "modulus": lambda b: b.elastic / 1.25 if b.problem.domain.dim == 3 else b.changed(E=1.25 * E),
}
"""Mistakes, and the field that each gives."""
WITH_SPRINGS = set(list(MISTAKES)[:7]) | {"rest length"}
"""Mistakes that are made with springs: those of right springs are not theirs."""
KINDS = {
    "k2 = 2 k1, k1 = E t": {"k2 = 2 k1"},
    "k = E h": {"k alike"},
    "k = E": {"k alike"},
    "k = E h, whole": {"k alike"},
    "coarse triangles": {"coarse mesh"},
    "coarse quadrilaterals": {"coarse mesh"},
}
"""Kinds of causes of mistakes that are not named as these."""


@functools.cache
def bench(body):
    return Bench(read_case(BODIES[body]))


def judged(monkeypatch, b, field):
    """The judgement of a field; its reference and catalogue are those of the bench."""
    monkeypatch.setattr(judgement, "converge_case", lambda *_: b.reference)
    monkeypatch.setattr(judgement, "known_mistakes", lambda *_: b.catalogue)
    monkeypatch.setattr(judgement, "RATIO_NODES", 1_000)  # of the meshes for other ratios
    monkeypatch.setattr(judgement, "_with_other_laws", b.with_other_laws)
    result = Result("field", field, b.places, None, math.nan, 1e-9)
    return judge_result(b.case, result)


def cell(monkeypatch, body, mistake):
    """Whether a mistake changes the field, the kinds that name it, and the judgement."""
    b = bench(body)
    field = MISTAKES[mistake](b)
    right = b.springs() if mistake in WITH_SPRINGS else b.elastic
    result = judged(monkeypatch, b, field)
    room = NOTICED * result.displacement.uncertainty * result.size
    changes = [np.linalg.norm(field - other, axis=1).max() for other in (right, b.elastic)]
    return min(changes) > room, KINDS.get(mistake, {mistake}), result


@pytest.mark.parametrize("body", BODIES)
def test_the_true_cause_is_among_those_reported(body, monkeypatch):
    missing = {}
    for mistake in MISTAKES:
        changed, kinds, result = cell(monkeypatch, body, mistake)
        reported = set().union(*(each.kinds for each in result.verdict.causes))
        if changed and not kinds & reported:
            missing[mistake] = reported
    assert not missing


@table(("body", "number", "words"), [
    ("column", 0, "the weight acts in the opposite direction"),
    ("cantilever", 0, "load 1 of the case acts in the opposite direction"),
])  # fmt: skip
def test_a_load_of_the_wrong_sign_is_named_first(body, number, words, monkeypatch):
    b = bench(body)
    first = judged(monkeypatch, b, reversed_load(b, number)).verdict.causes[0]
    assert words in first.said


def test_a_load_that_is_reversed_or_absent_beside_another_is_named():
    b = bench("column")
    box = b.problem.domain
    pull = Traction(box.side("top"), (3.0, 0.0))
    case = replace(b.case, problem=replace(b.problem, loads=(pull, *b.problem.loads)))
    other = replace(b.problem.loads[0], acceleration=(0.0, 9.81))
    body = box_discretisation(box, (4, 12), "Q2")
    for loads, words in [
        ((pull, other), "the weight acts in the opposite direction"),
        ((pull,), "the weight does not act"),
        (b.problem.loads, "load 1 of the case does not act"),
    ]:
        u = solve_problem(replace(case.problem, loads=loads), body).at(b.places)
        found = judge_result(case, Result("field", u, b.places, None, math.nan, 1e-9))
        assert words in recommend_for_field(found)


def test_fitted_constants_are_no_rivals_of_a_mesh_that_fits(monkeypatch):
    b = bench("block")
    h = b.made.spacing
    for field, first in [
        (b.elements(2, simplex=False), "coarse mesh"),
        (b.springs([k / h for k in b.made.constants]), "coarse springs and k without h"),
    ]:
        causes = judged(monkeypatch, b, field).verdict.causes
        assert causes[0].name == first
        assert "k alike" not in set().union(*(each.kinds for each in causes))


def test_nothing_is_missing_of_a_field_that_states_to_be_converged(monkeypatch):
    b = bench("cantilever")
    monkeypatch.setattr(judgement, "converge_case", lambda *_: b.reference)
    for rest, named in ((math.nan, True), (0.0, False)):
        found = judge_result(b.case, Result("field", b.unfinished(), b.places, None, rest, 1e-9))
        assert ("not converged" in {each.kind for each in found.verdict.causes}) == named


FACTOR = 0.02
"""Relative error of a modulus that is fitted besides a mistake: as much as agrees by default."""


# On the bar in 3D a factor alone fits within the uncertainty: no second mistake shows.
@pytest.mark.parametrize("body", ["cantilever"])
@table(("mistake", "kind"), [
    ("coarse quadrilaterals", "coarse mesh"),
    ("coarse springs", "coarse springs"),
    ("whole boundary springs", "whole boundary springs"),
])  # fmt: skip
def test_a_mistake_and_a_wrong_modulus_are_both_named(mistake, kind, body, monkeypatch):
    b = bench(body)
    causes = judged(monkeypatch, b, MISTAKES[mistake](b) / 0.8).verdict.causes
    (both,) = (each for each in causes if each.kinds == {kind, "scale"})
    assert both.left == min(each.left for each in causes)
    assert both.of["other"]["part"] == pytest.approx(0.8, rel=FACTOR)
    assert "a modulus 0.8 or loads 1.25 times as large besides" in both.said


@table(("cells", "element", "part"), [
    ((6, 2), "Q1", 1.0),
    ((12, 4), "P1", 1.0),
    ((24, 8), "Q1", 0.4),
    ((40, 12), "P1", 0.05),
])  # fmt: skip
def test_a_coarse_mesh_is_named_at_its_own_nodes_or_some_of_them(cells, element, part):
    b = bench("cantilever")
    body = box_discretisation(b.problem.domain, cells, element)
    some = np.random.default_rng(3).random(len(body.points)) < part
    u = solve_problem(b.problem, body, allow_locked=True).displacement[some]
    found = judge_result(b.case, Result("field", u, body.points[some], None, math.nan, 1e-9))
    assert "coarse mesh" in {each.kind for each in found.verdict.causes}
    if part == 1:  # the lines of the mesh are those of its nodes
        assert found.verdict.causes[0].kind == "coarse mesh"
        assert found.verdict.causes[0].left < 1e-9


@table(("factor", "rivals"), [(0.85, "coarse mesh"), (1.3, "k alike"), (1e-3, "k alike")])
def test_a_factor_in_bending_is_reported_with_its_rivals(factor, rivals, monkeypatch):
    b = bench("cantilever")
    causes = judged(monkeypatch, b, factor * b.elastic).verdict.causes
    kinds = [each.kind for each in causes]
    assert "modulus" in kinds
    assert kinds.index("modulus") < kinds.index(rivals)
    assert [each.left for each in causes] == sorted(each.left for each in causes)
    if factor == 1e-3:
        assert {"unit", "unit of k"} <= set(kinds[:4])


def test_units_of_stiffness_are_named_beside_lengths_for_springs_too(monkeypatch):
    b = bench("cantilever")
    causes = judged(monkeypatch, b, b.springs([1e3 * k for k in b.made.constants])).verdict.causes
    assert {"unit", "unit of k"} <= set().union(*(each.kinds for each in causes[:4]))
    assert "from a confusion of N/m and N/mm" in " ".join(each.said for each in causes[:4])


def test_a_field_that_may_still_move_is_said_not_to_be_converged_first(monkeypatch):
    b = bench("cantilever")
    monkeypatch.setattr(judgement, "converge_case", lambda *_: b.reference)
    result = Result("field", b.unfinished(), b.places, None, 0.5, 1e-9)
    found = judge_result(b.case, result)
    assert found.verdict.word == "not at rest"
    assert found.verdict.causes[0].kind == "rest"
    assert judged_sentences(found)[1][0].startswith("Rest: they may still change by 50 %")


@table(("part", "words"), [(0.0, "Fits ("), (0.18, "Comes near, but does not fit (")])
def test_only_a_cause_that_leaves_at_most_a_tenth_fits(part, words, monkeypatch):
    b = bench("plate_with_hole")
    change = b.unfinished() - b.elastic
    other = part * np.linalg.norm(change, axis=1).max() * np.sin(20 * b.places[:, :1])
    result = judged(monkeypatch, b, b.elastic + change + [0.0, 1.0] * other)
    said = [each for each in judged_sentences(result)[1] if "missing; take more iter" in each]
    assert [each.startswith(words) for each in said] == [True]


@pytest.mark.parametrize(("excess", "count"), [(1e-5, 1), (1e-3, 2)])
def test_a_rest_length_that_changes_little_is_no_rival(excess, count):
    rng = np.random.default_rng(3)
    places, elastic, change = rng.normal(size=(3, 20, 2))
    coarse, longer = 0.8 * elastic, 100 * change
    rest = [(part, coarse + part * longer) for part in (-0.5, 0.5)]
    mistakes = (
        Mistake("coarse springs", lambda: [(0.0, elastic), (0.1, coarse)]),
        Mistake("rest length", lambda: rest, simpler="coarse springs"),
    )
    field = Field(
        places, coarse + excess * longer, elastic, 1e-6, "loads", ((-3, 3),) * 2, mistakes=mistakes
    )
    causes = list(explain_mistakes(field))
    assert [each.kind for each in causes] == ["coarse springs", "rest length"][:count]
    assert all("rest lengths differ" in each.said and "+0.001" in each.said for each in causes[1:])


@pytest.mark.parametrize(("noise", "first"), [(0.0, "coarse mesh"), (5e-3, "modulus")])
def test_a_uniform_factor_has_sizes_as_rivals_where_a_mesh_fits(noise, first):
    rng = np.random.default_rng(5)
    places, elastic, other = rng.normal(size=(3, 40, 2))
    coarse = 0.8 * elastic + 2e-3 * other
    mesh = Mistake("coarse mesh", lambda: [(0.0, elastic), (0.1, coarse)])
    candidate = coarse + noise * rng.normal(size=(40, 2))
    field = Field(places, candidate, elastic, 1e-7, "loads", ((-3, 3),) * 2, mistakes=(mesh,))
    kinds = [each.kind for each in explain(field)]
    assert {"modulus", "load", "thickness", "coarse mesh"} <= set(kinds)
    assert kinds[0] == first


def test_models_that_are_too_large_are_left_out_and_reported():
    b = bench("block")
    made = known_mistakes(replace(b.case, cells=20), b.places, b.reference)
    assert not made.omitted
    whole = next(each for each in made.mistakes if each.kind == "whole boundary springs")
    assert len(whole.path()) == 2
    assert "Springs at 0.05 m are not tried: more than 3,000 unknowns." in made.omitted


def test_lengths_of_causes_are_in_the_unit_of_the_case(monkeypatch):
    b = bench("millimetres")
    found = judged(monkeypatch, b, MISTAKES["coarse quadrilaterals"](b))
    (mesh,) = (each for each in found.verdict.causes if each.kind == "coarse mesh")
    assert f"about {1e3 * mesh.value:.3g} mm:" in mesh.said
    assert not [each for each in judged_sentences(found)[1] if " m:" in each or " m " in each]
