"""Moduli, ratios and causes that carry a number, asked of fields whose truth is known."""

import math
from collections import Counter

import numpy as np
import pytest

from msvalidate_check import check, elastic_case
from msvalidate_check.case_set import case_facts, case_names

SHEARED = ("block_shear", "cell_shear")
PRESSED = ("block_pressure", "cell_pressure")
SCALES = {"modulus", "load", "thickness", "scale"}


def moduli(state, E, nu):
    """Shear modulus, and pressure over change of volume, in the plane of area."""
    plane = {"plane_stress": 2 * (1 - nu), "plane_strain": 2 * (1 + nu) * (1 - 2 * nu)}
    return {"E": E, "G": E / 2 / (1 + nu), "K": E / plane.get(state, 3 * (1 - 2 * nu)), "nu": nu}


def usual(name):
    ratios = case_facts(name)["ratios"]
    return elastic_case(name, 0.3 if 0.3 in ratios else ratios[-1])


def causes(verdict):
    return [each.name for each in verdict.causes]


def lies_within_its_uncertainty(verdict, true):
    """Names of the numbers that are told; the truth lies within the uncertainty of each of them."""
    told = set()
    for name, wanted in true.items():
        found, uncertainty = (
            getattr(verdict.material, key) for key in (name, f"{name}_uncertainty")
        )
        assert math.isnan(found) == math.isnan(uncertainty)
        if not math.isnan(found):
            assert abs(found - wanted) <= uncertainty, (
                verdict.case,
                name,
                found,
                wanted,
                uncertainty,
            )
            assert uncertainty < 0.1 * (1.0 if name == "nu" else wanted)
            told.add(name)
    return told


@pytest.mark.parametrize("name", case_names())
def test_what_is_told_of_a_material_is_true_within_its_uncertainty(name):
    for nu in case_facts(name)["ratios"]:
        case = elastic_case(name, nu)
        for times, u in (
            (1.0, case.wanted), (1.0, case.wanted.astype(np.float32)), (1.1, 1.1 * case.wanted),
        ):  # fmt: skip
            exact = {"accuracy": 0.0} if u.dtype == float else {}
            verdict = check(case, None, u, **exact)
            true = moduli(case.state, case.E / times, nu)
            told = lies_within_its_uncertainty(verdict, true)
            if name.startswith(SHEARED):
                assert told == {"G"}
            elif name.startswith(PRESSED):
                assert told == {"K"}
            elif case.driven == "supports":
                assert told <= {"nu"}
            else:
                assert told & {"E", "G", "K"}
            if "cell_pull" in name and u.dtype == float:
                assert verdict.material.E_uncertainty < 1e-9 * case.E
            if times == 1 or case.driven != "supports":
                assert verdict.material.left <= verdict.uncertainty + 1e-12
            if times > 1 and not verdict:
                scale = [each.value for each in verdict.causes if each.name in SCALES]
                assert (
                    pytest.approx([times] * len(scale), rel=1e-6 + 3 * verdict.uncertainty) == scale
                )
                assert scale or case.driven == "supports"
        other = elastic_case(name, case_facts(name)["ratios"][1])
        lies_within_its_uncertainty(
            check(case, None, other.wanted), moduli(case.state, case.E, other.nu)
        )


@pytest.mark.parametrize("name", case_names())
def test_no_field_is_a_fault_of_the_program(name):
    """Of some of these elasticity's scale is rounding alone."""
    for nu in case_facts(name)["ratios"]:
        case = elastic_case(name, nu)
        w, x = case.wanted, case.points[case.named]
        size, middle = np.abs(w).max(), x - x.mean(axis=0)
        drifts = [size * along + 0 * w for along in np.eye(w.shape[1])]
        uniaxial = [size * x * along for along in np.eye(w.shape[1])]
        for u in (*drifts, *uniaxial, middle):
            verdict = check(case, None, u)
            assert "nan" not in str(verdict)
            assert verdict.word == "agrees" or verdict.error > 1e-9
            assert verdict.material.E > 0 or math.isnan(verdict.material.E)


def test_a_uniform_state_is_told_by_the_modulus_that_shows_with_its_uncertainty():
    case = elastic_case("cell_shear", 0.3, state="space")
    text = str(check(case, None, 1.1 * case.wanted, accuracy=0.0))
    assert "modulus E 0.9091 times as large?" in text
    assert "nearest elasticity: G = 3.497e+06 ± 0." in text
    assert "E =" not in text
    assert "nu = 0.3:" in text
    assert text.count("nu =") == 1
    bent = case.wanted + np.array([0.0, 0.0, 1e-3 * np.abs(case.wanted).max()])
    times = float((bent * case.wanted).sum() / (case.wanted**2).sum())
    size = np.linalg.norm(case.wanted, axis=1).max()
    wanted = np.linalg.norm(bent - times * case.wanted, axis=1).max() / size
    assert check(case, None, bent).material.left == pytest.approx(wanted)


@pytest.mark.parametrize("name", ["clamped_pull_plane_strain", "cook_plane_strain"])
def test_a_uncertainty_is_what_the_worst_errors_of_all_components_do(name):
    case, part = elastic_case(name, 0.3), 1e-3
    error = part * np.linalg.norm(case.wanted, axis=1).max()
    told = check(case, None, case.wanted, accuracy=part).material
    for number in ("E", "nu"):
        signs = np.zeros(case.wanted.shape)
        for at in np.ndindex(signs.shape):
            one = np.array(case.wanted)
            one[at] += error
            moved = check(case, None, one, accuracy=part).material
            signs[at] = np.sign(getattr(moved, number) - getattr(told, number))
        worst = check(case, None, case.wanted + error * signs, accuracy=part).material
        off = abs(getattr(worst, number) - getattr(told, number))
        assert off == pytest.approx(getattr(told, f"{number}_uncertainty"), rel=0.1)


def other_state(name):
    return name.replace(*(("stress", "strain") if "stress" in name else ("strain", "stress")))


def test_the_other_plane_state_is_named_by_its_signature():
    pairs = 0
    for name in case_names():
        if other_state(name) == name or other_state(name) not in case_names():
            continue
        verdict = check(usual(name), None, usual(other_state(name)).wanted)
        if name.startswith(SHEARED):
            assert verdict  # shear is the same in both states
            continue
        pairs += 1
        assert "plane state" in causes(verdict)
        said = next(each.said for each in verdict.causes if each.name == "plane state")
        # Plane strain is plane stress of the material with the same E/(1 - nu²) and nu/(1 - nu).
        E, nu = (1.099, 0.4286) if "stress" in name else (0.9467, 0.2308)
        assert f"E {E} times as large, nu = {nu}" in said
        assert set(causes(verdict)) - {"plane state"} <= SCALES | {"ratio"}
        if set(causes(verdict)) != {"plane state"}:
            assert name.startswith((*PRESSED, "clamped_press"))
    assert pairs == 30


def test_a_thickness_is_named_beside_the_load_where_it_explains_as_much():
    for name in case_names():
        case = usual(name)
        told = causes(check(case, None, 1.2 * case.wanted))
        alike = case.driven == "loads" and case.state != "space"
        assert ("thickness" in told) == alike, name
        assert ("load" in told) == (case.driven != "supports") or "rubber_block_space" in name


def test_a_component_that_was_never_written_is_named_first():
    for name in case_names():
        case = usual(name)
        for axis in range(case.points.shape[1]):
            u = case.wanted * (np.arange(case.points.shape[1]) != axis)
            exact = {"accuracy": 0.0} if u.dtype == float else {}
            verdict = check(case, None, u, **exact)
            if not u.any() or verdict.error <= 0.02:
                continue
            assert causes(verdict)[0] == "component", (name, axis, verdict.causes)
            assert f"no displacement along {'xyz'[axis]}" in verdict.causes[0].said
            if verdict.error > 0.2:
                assert "component and unit" in causes(check(case, None, 1e3 * u)), (name, axis)


def test_mirrored_places_are_named_beside_the_order_of_nodes():
    case = elastic_case("cook", 0.3, state="plane_stress")
    assert causes(check(case, None, case.wanted[::-1])) == ["node order"]
    case = elastic_case("block_gravity", 0.3, state="plane_stress")
    x = case.points[case.named]
    there = x.min(axis=0) + x.max(axis=0) - x
    nearest = np.abs(x[None] - there[:, None]).max(axis=2).argmin(axis=1)
    told = causes(check(case, None, case.wanted[nearest]))
    assert {"node order", "places"} <= set(told)


def test_a_unit_beside_an_order_of_nodes_may_be_off_by_no_more_than_lengths_are():
    case = elastic_case("cook", 0.3)
    for times, name in ((1.0, "node order and unit"), (1.0005, "node order and unit"), (1.002, "")):
        told = causes(check(case, None, times * 1e3 * case.wanted[::-1]))
        assert told == ([name] if name else []), times


def test_noise_and_half_bodies_have_no_cause_and_small_changes_no_other():
    chance, told = np.random.default_rng(340), Counter()
    for name in case_names():
        case = usual(name)
        x, u = case.points[case.named], case.wanted
        noise = np.abs(u).max() * chance.normal(size=u.shape)
        half = x[:, 0] <= np.median(x[:, 0])
        some = half if not half.all() and half.sum() > 2 else slice(None)
        near = min(case.nu + 0.005, case.ratios[1])
        fields = (
            ("noise", slice(None), u + 0.003 * noise, case.nu),
            ("noise", slice(None), u + 0.01 * noise, case.nu),
            ("half", some, u, case.nu), ("half", some, u.astype(np.float32), case.nu),
            ("softer", some, 1.1 * u, case.nu),
            ("ratio", slice(None), case.at_ratio(near), near),
            ("ratio", slice(None), case.at_ratio(case.nu - 0.005), case.nu - 0.005),
        )  # fmt: skip
        for kind, part, field, nu in fields:
            verdict = check(case, x[part], field[part])
            allowed = SCALES | {"ratio"} if kind in {"ratio", "softer"} else set()
            if kind == "softer" and name == "cell_shear_space":  # of one side, which turns too
                allowed.add("rigid motion")
            assert set(causes(verdict)) <= allowed, (name, kind, verdict.causes)
            lies_within_its_uncertainty(
                verdict, moduli(case.state, case.E / (1.1 if kind == "softer" else 1), nu)
            )
            told[kind] += 1
    assert told.total() >= 340
