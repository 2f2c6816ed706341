"""What is said of a field: its faults are told, and bad input in one line."""

import shutil
import subprocess
import sys
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from msvalidate.case.file.building import read_case
from msvalidate.case.judge.judgement import judge_result
from msvalidate.case.judge.results import Result
from msvalidate_check import CheckError, assert_elastic, check, elastic_case
from msvalidate_check.case_set import case_facts, case_names
from msvalidate_check.command import run as command
from msvalidate_check.diagnosis import Field, explain, split
from msvalidate_check.material import nearest_material
from msvalidate_check.points import nearest_of_pairs
from tests.checker.faulty_fields import faulty_fields, judged
from tests.checker.faulty_pairs import GARBAGE, faulty_pairs, told_of
from tests.table import table

ROOT = Path(__file__).resolve().parents[2]
SET = ROOT / "cases" / "v1"
SPLIT_APART = 2e-3
"""Of the largest displacement: the accuracy that `case judge` asks of its own elasticity, of each
part of a difference."""


# The verdict --------------------------------------------------------------------------------------


@pytest.mark.parametrize("part", [1, 4])
def test_faults_are_named_with_their_size(part):
    count, right, sized, alarms = Counter(), Counter(), Counter(), Counter()
    clean = {"none", "float32", "six digits", "float32 positions"}
    for faulty in faulty_fields(part):
        good, told, fits = judged(faulty)
        count[faulty.fault] += 1
        right[faulty.fault] += good
        sized[faulty.fault] += fits
        alarms[faulty.fault] += faulty.fault in clean and bool(told)
    assert count.total() >= 200
    assert right.total() >= 0.99 * count.total(), right
    assert sized.total() >= 0.95 * count.total(), sized
    assert alarms.total() == 0, alarms
    assert min(right[fault] / count[fault] for fault in count) >= 0.9, right


def test_two_faults_are_named_or_none_and_garbage_has_no_cause():
    told, false = Counter(), []
    for doubly in faulty_pairs():
        word, is_false, said = told_of(doubly)
        told[doubly.faults in GARBAGE, word] += 1
        if is_false:
            false.append((doubly.faults, str(doubly.case), said))
    assert not false
    pairs = sum(told[False, word] for word in ("right", "part", "none", "wrong"))
    garbage = told[True, "none"] + told[True, "wrong"]
    assert pairs >= 100
    assert garbage >= 100
    assert told[False, "wrong"] <= 0.02 * pairs
    assert (
        told[False, "right"] >= 0.75 * pairs
    )  # what is simple is found, not only not told wrongly
    assert told[True, "wrong"] <= 0.02 * garbage


def test_garbage_has_no_modulus():
    case = elastic_case("twisted_bar", 0.3)
    noise = np.random.default_rng(5).normal(size=case.wanted.shape)
    verdict = check(case, None, 1e3 * np.abs(case.wanted).max() * noise)
    assert np.isnan([verdict.E, verdict.effective_nu]).all()
    assert "cause: none of those known" in str(verdict)
    assert "nearest elasticity" not in str(verdict)
    assert "times the largest displacement" in str(verdict)


X2 = np.random.default_rng(0).uniform(size=(30, 2))
U2 = np.stack([X2[:, 0] * (1 + X2[:, 1]), 0.3 * X2[:, 1] ** 2], axis=1)
SHUFFLED = U2[np.random.default_rng(1).permutation(30)]


@table("found, wanted, uncertainty, causes", [
    (1.1 * U2[:, ::-1], U2, 1e-6, ["axes and scale"]),
    (U2[:, ::-1] + 1e-3, U2, 1e-6, ["axes"]),
    (X2 + 1.3 * U2, U2, 1e-6, ["positions and scale"]),
    (1003 * SHUFFLED, U2, 5e-3, ["node order and unit"]),
    (-U2 * [1, 0], U2 * [1, 0], 1e-6, ["sign"]),
    (0 * U2 + 1.0, 0 * U2, 1e-6, ["rigid motion"]),
])  # fmt: skip
@pytest.mark.parametrize("size", [1e-3, 1e3])
def test_a_cause_is_told_once_and_in_a_body_of_any_size(found, wanted, uncertainty, causes, size):
    field = Field(size * X2, size * found, size * wanted, uncertainty, "both", ((0, size),) * 2)
    assert [each.name for each in explain(field)] == causes


def test_a_point_without_a_place_near_it_has_none():
    pair = np.array([0]), np.array([1])
    assert nearest_of_pairs(np.zeros((1, 2)), np.zeros((3, 2)), *pair).tolist() == [-1, 0, -1]


def test_elements_of_one_cell_agree_by_number_by_place_and_in_any_order():
    case = elastic_case("block_pull", 0.3, "tet4_2")
    fine = case.points * [1e-3, -0.3e-3, -0.3e-3]
    by_place = check(case, case.points[::-1], fine[::-1])
    assert by_place
    assert by_place.error < 1e-12
    number = np.arange(len(fine))
    shuffled = np.random.default_rng(1).permutation(number)
    assert check(case, shuffled, fine[shuffled]).error == by_place.error
    assert check(case, None, fine).error == by_place.error
    part = check(case, number[:20], fine[:20])
    assert part.notes
    assert part


def test_quantities_are_held_to_the_band():
    case = elastic_case("cook", 0.3)
    wanted = {name: value for name, (value, _) in case.quantities.items()}
    assert check(case, None, case.wanted, quantities=wanted)
    wanted["strain energy"] = 1.05 * wanted["strain energy"]
    verdict = check(case, None, case.wanted, quantities=wanted)
    assert not verdict
    assert "strain energy: differs, 5 % off" in str(verdict)
    with pytest.raises(AssertionError, match="strain energy: differs"):
        assert_elastic(case, None, case.wanted, quantities=wanted)


@pytest.mark.parametrize("name", case_names())
def test_case_judge_says_the_same(name, tmp_path):
    """A field 3 % too soft, bent, turned and shifted a little: beside both references."""
    case = elastic_case(name, case_facts(name)["ratios"][-1 if "rubber" in name else 2])
    shutil.copytree(SET / name, tmp_path / name)
    path = tmp_path / name / "case.toml"
    text = path.read_text().replace("nu = 0.49\n", f"nu = {case.nu:g}\n")
    path.write_text(text)
    x, size = case.points[case.named], np.linalg.norm(case.wanted, axis=1).max()
    turn = 0.01 * size * np.column_stack([-x[:, 1], x[:, 0], *x.T[2:]]) / np.abs(x).max()
    field = 1.03 * case.wanted + turn + 0.004 * size * np.cos(7 * x / np.ptp(x))
    here = check(case, x, field)
    found = judge_result(read_case(path), Result("field", field, x, None, np.nan, 0.0))
    there = split(
        Field(
            found.matched.places, found.matched.displacement,
            found.reference.displacement.value, 0.0, case.driven,
            tuple(zip(x.min(axis=0), x.max(axis=0), strict=True)),
        )
    )  # fmt: skip
    # `case judge` makes its own elements on even meshes: it may know less, and then says so.
    assert found.verdict.word in {check(case, x, field, band=0.05).word, "not resolved"}
    uncertainty = SPLIT_APART + found.reference.error
    assert here.error == pytest.approx(found.displacement.error, abs=uncertainty)
    for part, values in there.items():
        largest = np.linalg.norm(values, axis=1).max() / found.size
        assert here.parts[part] == pytest.approx(largest, abs=uncertainty), part


# Bad input ----------------------------------------------------------------------------------------

CASE = elastic_case("block_gravity", 0.3)
X, U = CASE.points[CASE.named], CASE.wanted
OTHER = elastic_case("cantilever_load", 0.3)


@table("ask, said", [
    (lambda: elastic_case("block_pul"), "did you mean block_pull?"),
    (lambda: elastic_case("cook", 0.33), "nu = 0.33: cook_plane_stress has 0,"),
    (lambda: elastic_case("cook", 0.3, "tri6"), "mesh 'tri6': cook_plane_stress"),
    (lambda: elastic_case("cook", 0.3, state="space"), "cook is in plane_stress"),
    (lambda: elastic_case("cook", 0.3, state="plain"), "state 'plain': give one of"),
    (lambda: check(CASE, None, U[:5]), "displacement: 5 points; block_gravity_plane"),
    (lambda: check(CASE, X, U[:5]), "5 of them for 20 points"),
    (lambda: check(CASE, X, np.where(U == 0, np.nan, U)), "nan along x at point 0"),
    (lambda: check(CASE, X, U.T), "shape (2, 20); give an array (n, 2)"),
    (lambda: check(CASE, 1e3 * X, U), "are they in mm?"),
    (lambda: check(CASE, X[:, ::-1], U), "are the axes in another order?"),
    (lambda: check(CASE, X + 10, U), "is the origin another one?"),
    (lambda: check(CASE, OTHER.points, OTHER.wanted), "or another case"),
    (lambda: check(CASE, np.arange(20) + 90, U), "nodes 90 to 109"),
    (lambda: check(CASE, np.arange(20) / 2, U), "numbers that are not whole"),
    (lambda: check(CASE, X, [["a", "b"]] * 20), "displacement: not numbers"),
    (lambda: check("cook", X, U), "case: 'cook'; give what elastic_case returns"),
    (lambda: check(CASE, X, 1e200 * U), "at point"),
    (lambda: check(CASE, X, [[1], [1, 2]]), "displacement: not numbers"),
    (lambda: check(CASE, X, U > 0), "displacement: true and false"),
    (lambda: check(CASE, X, np.ma.masked_less(U, 0)), "displacement: masked"),
    (lambda: check(CASE, X, U, quantities={"strain energy": "x"}), "strain energy: 'x'"),
    (lambda: check(CASE, X, U, quantities=[("strain energy", 1)]), "quantities: a list"),
    (lambda: check(CASE, np.r_[X, X[-1:]], np.r_[U, 3 * U[-1:]]), "stands 2 times"),
    (lambda: elastic_case("cook", "x"), "nu: 'x'; give a number"),
    (lambda: elastic_case(["cook"]), "case: ['cook'] is no name"),
    (lambda: elastic_case("cook_plane_strain", state="plane_stress"), "leave one of them out"),
    (lambda: check(CASE, X, U, band=-1), "band: -1; give a number from 0"),
    (lambda: check(CASE, X, U, at_rest=np.nan), "at_rest: nan"),
    (lambda: check(CASE, X, U, quantities={"energy": 1}), "'energy': block_gravity"),
])  # fmt: skip
def test_bad_input_is_one_line(ask, said):
    with pytest.raises(CheckError) as error:
        ask()
    assert said in str(error.value)
    assert "\n" not in str(error.value)


# The command line and the C++ example -------------------------------------------------------------


def write_field(path, case, field):
    axes = "xyz"[: field.shape[1]]
    head = ",".join(["id", *axes, *(f"u{a}" for a in axes)])
    x = case.points[case.named]
    np.savetxt(
        path, np.column_stack([case.named, x, field]), "%.17g", ",", header=head, comments=""
    )


def test_the_command_line(tmp_path, capsys):
    write_field(tmp_path / "field.csv", CASE, 1.03 * U)
    field = ["field", "block_gravity", str(tmp_path / "field.csv")]
    assert command(field) == 1
    assert "gravity or masses 1.03 times as large?" in capsys.readouterr().out
    assert command([*field, "--band", "0.05"]) == 0
    np.savez(tmp_path / "field.npz", displacement=U, id=np.arange(20), at_rest=0.5)
    assert command(["field", "block_gravity", str(tmp_path / "field.npz")]) == 1
    assert "not at rest" in capsys.readouterr().out
    assert command(["list"]) == 0
    assert "cook_plane_strain" in capsys.readouterr().out
    assert command(["mesh", "cook", "--mesh", "tri3", str(tmp_path / "mesh")]) == 0
    nodes = np.loadtxt(tmp_path / "mesh" / "nodes.csv", delimiter=",", skiprows=1)
    assert np.array_equal(nodes[:, 1:3], elastic_case("cook", mesh="tri3").points)
    for content, said in (
        ("x,y\n1,2\n", "name them ux, uy"),
        ("ux,uy\n1,a\n", "line 2: uy 'a'"),
        (f"id,ux,uy\n{10**20},1,1\n", "id 1e+20; number nodes from 0"),
    ):
        (tmp_path / "bad.csv").write_text(content)
        assert command(["field", "cook", str(tmp_path / "bad.csv")]) == 2
        assert said in capsys.readouterr().err
    assert command(["field", "cook", "."]) == 2
    assert ".: give a .csv or .npz file" in capsys.readouterr().err
    assert command(["field", "cook", str(tmp_path / "none.csv")]) == 2
    assert "No such file" in capsys.readouterr().err


@pytest.mark.skipif(not shutil.which("g++"), reason="no C++ compiler")
@pytest.mark.parametrize("name", ["clamped_shear_plane_strain", "clamped_shear_space"])
def test_the_check_in_cpp_says_the_same(name, tmp_path):
    source = ROOT / "checker" / "example" / "cpp" / "check.cpp"
    assert len(source.read_text().splitlines()) <= 60
    built = tmp_path / "check"
    subprocess.run(["g++", "-O2", "-Wall", "-Werror", "-o", built, source], check=True)  # noqa: S607
    case = elastic_case(name, 0.3)
    x = case.points[case.named]
    field = 1.002 * case.wanted + 1e-5 * np.roll(x, 1, axis=1) ** 2
    head = ",".join(["id", *(f"u{a}" for a in "xyz"[: x.shape[1]])])
    rows = np.column_stack([case.named, field])
    path = tmp_path / "field.csv"
    np.savetxt(path, rows, "%.17g", ",", header=head, comments="")
    good = path.read_text()
    done = subprocess.run(
        [built, SET / name, "0.3", tmp_path / "field.csv"],
        capture_output=True,
        text=True,
        check=True,
    )
    told = dict(line.rsplit(" ", 1) for line in done.stdout.splitlines())
    verdict = check(case, x, field)
    assert float(told["error"]) == pytest.approx(verdict.error, abs=2e-6)
    for part, size in verdict.parts.items():
        assert float(told[part]) == pytest.approx(size, abs=1e-5)
    nearest = nearest_material(case, case.named, field, 0.0)
    assert float(told["nu"]) == pytest.approx(nearest.nu, abs=2e-3)
    rows = good.splitlines()
    for content, said in {
        "\n".join(rows[1:]): "no header id,ux,uy",
        "\n".join(rows[:8]): "no node 7",
        "\n".join([*rows, rows[3]]): "a node twice",
        good.replace(rows[5], rows[5].replace(",", ",nan", 1)): "give finite numbers",
        good.replace(rows[5], "4,x,0,0"): "give finite numbers",
        good.replace(rows[5], "4,1"): "give finite numbers",
        "": "no header id,ux,uy",
    }.items():
        path.write_text(content)
        done = subprocess.run(
            [built, SET / name, "0.3", path], capture_output=True, text=True, check=False
        )
        assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1), said
        assert said in done.stderr
    path.write_text(good)
    for nu, said in {"0.33": "no answer for this NU", "x": "give CASE_FOLDER NU"}.items():
        done = subprocess.run(
            [built, SET / name, nu, path], capture_output=True, text=True, check=False
        )
        assert done.returncode == 2
        assert said in done.stderr


def test_the_checker_imports_numpy_alone():
    code = "import msvalidate_check, sys; print(*sorted({m.split('.')[0] for m in sys.modules}))"
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        cwd=ROOT / "checker",
    )
    assert not {"scipy", "pandas", "msvalidate", "pytest", "skfem"} & set(done.stdout.split())
