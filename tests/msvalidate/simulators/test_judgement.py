"""Bodies at rest, and the causes of what they answer."""

from dataclasses import replace

import numpy as np
import pytest

from msvalidate.problem import Isotropic, ProblemError
from msvalidate.simulators.bodies.blocks import (
    at_rest_both_ways,
    effective_on_mesh,
    frozen_case,
)
from msvalidate.simulators.bodies.bodies import factors
from msvalidate.simulators.bodies.laws import predicted
from msvalidate.simulators.bodies.tetrahedra import of_law
from msvalidate.simulators.exchange.asked import Asked
from msvalidate.simulators.exchange.protocol import Answer, CannotRepresent, Request
from msvalidate.simulators.verdict.judgement import judge_simulator
from msvalidate.simulators.verdict.sheet import sheet_of
from tests.table import table

SMITH = "Smith's neo-Hookean, Lamé's constants as they stand"
ASKED = Isotropic(1e7, 0.3, "solid")


def simulator_of(law, times=1.0):
    return lambda request: of_law(law)(replace(request, mass=times * request.mass))


def test_a_block_in_uniform_stress_shows_the_law_on_any_mesh():
    law = predicted(SMITH, ASKED.E, ASKED.nu)
    found = at_rest_both_ways(simulator_of(SMITH), "block_pull_space", "tet4", ASKED)
    each = effective_on_mesh(found)
    # Both signs averaged: what is left of a strain of a thousandth is its square.
    ratio = each.E / law.E
    assert ratio == pytest.approx(1.0, rel=1e-5)
    assert each.nu == pytest.approx(law.nu, abs=1e-5)


def test_causes_multiply_to_the_whole_and_mass_is_told_from_law():
    law = predicted(SMITH, ASKED.E, ASKED.nu)
    heavy = simulator_of(SMITH, times=1.25)
    found = at_rest_both_ways(heavy, "cantilever_gravity_space", "tet4", ASKED)
    each = factors(found, (law.E, law.nu), 1.25 * found.request.mass)
    product = each.law * each.resolution * each.mass * each.solver * each.left
    assert product == pytest.approx(each.total, rel=1e-12)
    assert each.mass == pytest.approx(1.25, rel=1e-9)
    assert each.law == pytest.approx(ASKED.E / law.E, rel=0.01)  # bent: the ratio hardly matters
    assert each.is_explained
    assert not factors(found, (law.E, law.nu)).is_explained


def test_a_simulator_without_motion_or_forces_is_held_against_its_documented_law():
    """As a static program that tells displacements alone: the gate says what it could not ask."""

    def simulate(request: Request) -> Answer:
        if request.task == "motion":
            raise CannotRepresent("no motion")
        return simulator_of("linear")(request)

    found = judge_simulator(simulate, ASKED, law="linear", meshes=("tet4",))
    assert (found.word, found.causes, found.reading) == ("agrees", (), None)
    assert np.isfinite([row.factors.total for row in found.bodies]).all()
    assert any("no motion" in note.why for note in found.notes)


@pytest.mark.parametrize("material", [ASKED, Isotropic(3e4, 0.45, "solid", 37.0)])
def test_any_material_is_judged_alike(material):
    found = judge_simulator(
        simulator_of("neo-Hookean, log J"), material, law="neo-Hookean, log J", meshes=("tet4",)
    )
    assert (found.word, found.causes, found.notes) == ("agrees", (), ())
    assert found.large is not None
    assert 0.03 < found.large.strain < 0.1
    assert found.large.apart < 1e-8


def test_settings_that_converge_are_asked_for_each_body():
    found = judge_simulator(
        simulator_of("linear"), ASKED, law="linear", meshes=("tet4",), converged={"n": 9}
    )
    assert (found.word, found.notes) == ("agrees", ())
    assert frozen_case("block_pull_space", "tet4", 0.32).nu == 0.3


def test_a_law_of_the_same_first_order_is_told_apart_at_large_strain():
    found = judge_simulator(
        simulator_of("Saint Venant-Kirchhoff"), ASKED, law="neo-Hookean, log J", meshes=("tet4",)
    )
    assert found.word == "not explained"
    assert found.causes[0].kind == "large strain"


def test_ratios_for_which_no_elasticity_is_known_are_refused_before_anything_is_asked():
    with pytest.raises(ProblemError, match=r"give one from 0 to 0.45"):
        judge_simulator(None, Isotropic(1e7, 0.49, "solid"))


def test_a_law_whose_ratio_is_below_those_known_is_explained():
    """Asked for 0.2, it is a solid of ratio - 0.25."""
    law = "neo-Hookean without logarithm, Lamé's constants as they stand"
    material = Isotropic(1e7, 0.2, "solid")
    found = judge_simulator(simulator_of(law), material, law=law, meshes=("tet4",))
    assert found.word == "differs with cause"
    assert all(row.factors.is_explained for row in found.bodies)


def coarse(points, move):
    """Displacements of positions that have 14 binary digits."""
    x = points + move
    grid = 2.0 ** (np.floor(np.log2(np.maximum(np.abs(x), 1e-9))) - 14)
    return np.round(x / grid) * grid - points


def aside(points, move):  # noqa: ARG001
    """The end two hundredths of what the loads move aside, whatever they are."""
    out = move.copy()
    out[-1] += 1e-5 * np.sign(move[-1].sum())
    return out


@pytest.mark.parametrize(
    ("fault", "precision", "state"),
    [
        (coarse, "float32", "differs with cause"),
        (coarse, "float64", "not explained"),
        (aside, "float32", "not explained"),
    ],
)
def test_coarse_positions_are_a_cause_and_other_faults_are_not(fault, precision, state):
    def simulate(request: Request) -> Answer:
        found = simulator_of("linear")(request)
        if request.task != "rest" or not request.name.startswith("block_pull_space"):
            return found
        move = fault(request.mesh.points, found.displacement)
        return Answer(displacement=move, about={**found.about, "precision": precision})

    found = judge_simulator(simulate, ASKED, law="linear", meshes=("tet4",))
    rounded = [cause for cause in found.causes if cause.kind == "rounding"]
    assert (found.word, bool(rounded)) == (state, state == "differs with cause")


@pytest.mark.parametrize(
    ("name", "fault", "said"),
    [
        ("cantilever", lambda u: 0.5 * u, "cantilever_gravity_space on tet4: 0.5 of the"),
        ("", lambda u: 0.9 * u, "0.1 of the displacement not explained"),
        ("block_pull", lambda u: u + 3e-4, "goes one way, whatever the loads"),
    ],
)
def test_what_bodies_at_rest_do_apart_from_the_law_is_not_called_law_or_mass(name, fault, said):
    """As the probe reads the law that was asked for, and the bodies are not of it."""

    def simulate(request: Request) -> Answer:
        found = simulator_of("linear")(request)
        if request.task != "rest" or not request.name.startswith(name):
            return found
        return Answer(displacement=fault(found.displacement), about=found.about)

    found = judge_simulator(simulate, ASKED, law="linear", meshes=("tet4",))
    assert found.word == "not explained"
    assert not [cause for cause in found.causes if cause.kind in {"law", "mass"}]
    assert any(said in cause.said for cause in found.causes)


def test_bodies_that_stay_where_they_are_are_no_answer():
    def simulate(request: Request) -> Answer:
        found = simulator_of("linear")(request)
        if request.task != "rest" or "_space" not in request.name:
            return found
        return Answer(displacement=0 * found.displacement, about=found.about)

    found = judge_simulator(simulate, ASKED, law="linear", meshes=("tet4",))
    assert (found.word, found.bodies) == ("not explained", ())
    assert "cantilever_gravity_space does not move" in "\n".join(note.why for note in found.notes)


def test_better_elements_are_not_taken_for_another_law():
    """Elasticity itself at the named points, as elements of high order answer."""

    def simulate(request: Request) -> Answer:
        found = simulator_of("linear")(request)
        if request.task != "rest" or "_space" not in request.name:
            return found
        case = frozen_case(*request.name.split(", "), ASKED.nu)
        move, sign = found.displacement.copy(), np.sign((request.force + request.gravity).sum())
        move[case.named] = sign * np.sign(case.force.sum()) * case.at_ratio(ASKED.nu)
        return Answer(displacement=move, about=found.about)

    found = judge_simulator(simulate, ASKED, law="linear", meshes=("tet4",))
    assert (found.word, found.causes) == ("agrees", ())


def test_what_is_linear_elements_elsewhere_is_no_better_element():
    """A pulled block nearer to elasticity than linear elements, whose cantilever is as they are."""

    def simulate(request: Request) -> Answer:
        found = simulator_of("linear")(request)
        if request.held.any(axis=1).sum() != request.held.all(axis=1).sum():
            raise CannotRepresent("no rollers")
        if not request.name.startswith("clamped_pull_space"):
            return found
        case = frozen_case(*request.name.split(", "), ASKED.nu)
        move, sign = found.displacement.copy(), np.sign(request.force.sum() * case.force.sum())
        move[case.named] = (move[case.named] + 3 * sign * case.at_ratio(ASKED.nu)) / 4
        return Answer(displacement=move, about=found.about)

    found = judge_simulator(simulate, ASKED, law="linear", meshes=("tet4",))
    assert found.word == "not explained"


def settling(request, left, told):
    """Linear tetrahedra of which a part is left, and what is said of that over the displacement."""
    found = simulator_of("linear")(request)
    if found.displacement is None:
        return found
    size = float(np.linalg.norm(found.displacement, axis=1).max())
    about = {**found.about, "at_rest": {"change_when_twice_as_long": told * size}}
    iterations = request.settings.get("iterations", 10)
    about["settings"] = {"iterations": [iterations, "1"]}
    return Answer(displacement=(1 - left(iterations)) * found.displacement, about=about)


@pytest.mark.parametrize(
    ("left", "told", "state", "said"),
    [
        (lambda n: 0.3 * 10 / n, 0.25, "not at rest", "not converged: 36 % of a displacement may"),
        (lambda _: 0.04, 0.13, "not at rest", "converged: 14 % of a displacement may still"),
        (lambda _: 0.004, 0.02, "not at rest", "converged: 2 % of a displacement may still"),
        (lambda _: 0.004, 0.009, "agrees", ""),
        (lambda _: 0.5, 0.02, "not explained", "0.5 of the displacement not explained"),
    ],
)
def test_not_at_rest_is_a_state_of_its_own(left, told, state, said):
    asked = Asked(lambda request: settling(request, left, told))
    found = judge_simulator(asked, ASKED, law="linear", meshes=("tet4",))
    assert (found.word, said in " ".join(map(str, found.causes))) == (state, True), found.causes
    text = "\n".join(sheet_of(found, asked).lines("mine"))
    assert ("run it longer" in text) == (state == "not at rest")
    assert ("± " in text.partition("bodies at rest")[2]) == (told > 0.01)


@pytest.mark.parametrize(
    ("law", "named", "said"),
    [
        (SMITH, "", f"E 0.7322 times the asked, nu 0.2692 for 0.3: as {SMITH} (--law smith-raw)"),
        (SMITH, "linear", "law: read as E 7.322e+06 Pa, nu 0.2692; its documents say 1e+07 Pa"),
        ("neo-Hookean, log J", "", ""),
    ],
)
def test_a_law_is_told_with_the_nearest_of_the_catalogue(law, named, said):
    found = judge_simulator(simulator_of(law), ASKED, law=named, parts=("probe",))
    assert (found.word == "not explained") == bool(named)
    assert said in " ".join(map(str, found.causes))
    assert bool(said) == bool(found.causes)


def noise(v, part=1e-3):
    """The same of each answer."""
    return 1 + part * np.random.default_rng(0).normal(size=v.shape)


@pytest.mark.parametrize(
    ("law", "off", "stated", "said"),
    [
        ("linear", lambda _: 1.009, 0.01, ""),
        ("linear", noise, 0.01, ""),
        ("linear", lambda _: 1.04, 0.05, ""),
        (SMITH, lambda _: 1.009, 0.01, "law: E 0.7388 times the asked"),
        ("linear", lambda _: 1.009, 0.001, "free fall"),
    ],
)
def test_what_steps_are_solved_to_is_in_all_that_is_read_of_them(law, off, stated, said):
    def simulate(request: Request) -> Answer:
        found = simulator_of(law)(request)
        if found.velocity is None:
            return found
        v = off(found.velocity) * found.velocity
        return replace(found, velocity=v, about={**found.about, "solves_to": stated})

    found = judge_simulator(simulate, ASKED, parts=("gate", "probe"))
    assert (bool(found.causes), said in " ".join(map(str, found.causes))) == (bool(said), True), (
        found.causes
    )
    if found.reading is not None:
        true, each = predicted(law, ASKED.E, ASKED.nu), found.reading.elastic
        assert abs(each.E - true.E) <= each.E_error <= 1.2 * stated * true.E
        assert abs(each.nu - true.nu) <= each.nu_error <= 1.2 * stated


@table(("mass", "kept", "kinds", "said"), [
    (1, 0.9, ["damping"], "damping: a step from rest loses 0.1 of the velocity"),
    (2, 1.0, ["law"], "law: E 0.5 times the asked, nu 0.3 for 0.3; or masses 2 times as large"),
])  # fmt: skip
def test_steps_alone_show_damping_and_e_over_the_mass(mass, kept, kinds, said):
    def simulate(request: Request) -> Answer:
        found = simulator_of("linear", mass)(request)
        return replace(found, velocity=kept * found.velocity)

    found = judge_simulator(simulate, ASKED, parts=("probe",))
    assert [each.kind for each in found.causes] == kinds
    assert found.causes[0].said.startswith(said), found.causes


def test_doubled_masses_do_not_halve_the_modulus_of_the_table():
    heavy = Asked(simulator_of("linear", 2.0))
    found = judge_simulator(heavy, ASKED, meshes=("tet4",), parts=("probe", "bodies"))
    (law,) = (t for t in sheet_of(found, heavy).tables if t.title.startswith("law"))
    (row,) = (row for row in law.rows if row[0].startswith("read"))
    assert row[0] == "read, masses 2 times"
    assert float(row[3]) == pytest.approx(1.0, abs=1e-3)
    alone = judge_simulator(heavy, ASKED, parts=("probe",))
    (law,) = (t for t in sheet_of(alone, heavy).tables if t.title.startswith("law"))
    assert law.rows[-1][0] == "read, masses as asked"


def test_e_and_masses_over_the_density_are_told_as_that_and_not_as_units():
    def simulate(request: Request) -> Answer:
        light = replace(request.material, E=request.material.E / 1000, density=1.0)
        mass = request.mass / 1000
        return simulator_of("linear")(replace(request, material=light, mass=mass))

    found = judge_simulator(simulate, ASKED, law="linear", meshes=("tet4",))
    assert any(
        "as E over the density; then divide forces by it too" in c.said for c in found.causes
    )
    assert all(row.factors.is_explained for row in found.bodies)

    def millimetres(request: Request) -> Answer:
        answer = simulator_of("linear")(request)
        if answer.displacement is None:
            return answer
        return Answer(displacement=1000 * answer.displacement, about=answer.about)

    found = judge_simulator(
        millimetres, ASKED, law="linear", meshes=("tet4",), parts=("probe", "bodies")
    )
    assert not [cause for cause in found.causes if "density" in cause.said]


def test_equal_masses_are_told_with_how_far_a_node_is_off():
    def simulate(request: Request) -> Answer:
        each = np.full(len(request.mass), request.mass.mean())
        return simulator_of("linear")(replace(request, mass=each))

    found = judge_simulator(simulate, ASKED, parts=("probe",))
    (cause,) = found.causes
    assert cause.kind == "mass"
    assert cause.said == "mass: equal masses on all nodes; a node has 0.38 to 8 times its share"


def test_the_headline_says_what_is_the_mesh():
    asked = Asked(simulator_of("linear"))
    sheet = sheet_of(judge_simulator(asked, ASKED), asked)
    assert sheet.word == "the law agrees; the coarse mesh makes an error of 49 % in the bent beam"
    gate = judge_simulator(asked, ASKED, parts=("gate",))
    said = sheet_of(gate, asked, ("gate",)).next
    assert said == "`adapter check ADAPTER --only probe --only bodies` asks the rest"


def test_a_fall_that_goes_up_is_told_by_its_sign():
    asked = Asked(
        lambda request: simulator_of("linear")(replace(request, gravity=-request.gravity))
    )
    found = sheet_of(judge_simulator(asked, ASKED, parts=("gate",)), asked, ("gate",))
    assert found.next == "free fall: it falls up: turn the sign of gravity"
