"""The frozen set holds, its values are confirmed, and what is stated of them is true."""

import csv
import hashlib
from dataclasses import replace
from decimal import Decimal, localcontext
from pathlib import Path

import numpy as np
import pytest

from cases.make import versions
from cases.make.bodies import all_statements
from cases.make.confirmed import Confirmation, compared
from cases.make.errata import mended
from cases.make.versions import homes, read_answers, read_rows, set_path
from msvalidate_check import case_set, elastic_case
from msvalidate_check.case_set import case_facts, case_names
from msvalidate_check.command import run as command

CASES = Path(__file__).resolve().parents[2] / "cases"
SUMS = {
    1: "e2cf8d32cca2a6bf994c1c917e456e11800680de6f8461952e00a4d0d99e70b3",
    2: "3c64a604367e6d9ef6bb17fda5ad64c704275b87dde678b43dca14e57f37f148",
}
"""SHA-256 of the lists of checksums, by version: a frozen version never changes."""
MOST = 5e6
"""Bytes that `cases` may take."""
COVERED, OVERSTATED = 0.95, 3.0
"""Part of true errors within the stated ones, at least; and how far these are above, at most."""
BY_BALANCE = 1e-8
"""Of a value: an error below it is of rounding, no look at what elements can know."""


def digest(content):
    return hashlib.sha256(content).hexdigest()


@pytest.mark.parametrize("version", [1, 2])
def test_a_frozen_version_never_changes(version):
    home = CASES / f"v{version}"
    listed = (home / "SHA256SUMS").read_bytes()
    assert digest(listed) == SUMS[version]
    named = dict(reversed(line.split("  ")) for line in listed.decode().splitlines())
    assert {name: digest((home / name).read_bytes()) for name in named} == named
    there = {path.relative_to(home).as_posix() for path in home.rglob("*") if path.is_file()}
    assert there == {*(name for name in named if name[:3] != "../"), "SHA256SUMS"}
    # Of the files of version 1 each is listed once: as it is, or as version 2 has it.
    first = {p.relative_to(CASES / "v1").as_posix() for p in (CASES / "v1").rglob("*.*")}
    whole = [name.removeprefix("../v1/") for name in named]
    assert len(whole) == len(set(whole))
    assert {name for name in first if (CASES / "v1" / name).is_file()} <= set(whole)


def test_the_set_stays_small():
    files = [p for p in CASES.rglob("*") if p.is_file() and p.suffix != ".pyc"]
    assert sum(path.stat().st_size for path in files) < MOST


def test_the_checker_holds_the_same_numbers():
    names = {path.name for path in homes()[-1].iterdir() if path.is_dir()}
    assert names == set(case_names())
    for statement in all_statements():
        for nu, answer in read_answers(statement, homes()).items():
            case = elastic_case(statement.name, nu)
            size = np.linalg.norm(case.wanted, axis=1).max()
            assert np.array_equal(answer.displacement, case.wanted), (case.name, nu)
            assert case.uncertainty * size == pytest.approx(answer.uncertainty["displacement"])
            for name, (value, uncertainty) in case.quantities.items():
                assert np.array_equal(value, answer.quantities[name])
                assert uncertainty == answer.uncertainty[name]
        for mesh in case_facts(statement.name)["meshes"]:
            same_mesh(elastic_case(statement.name, nu, mesh))


def same_mesh(case):
    d = case.points.shape[1]
    path = set_path(f"{case.name}/{case.mesh}_nodes.csv", homes())
    nodes = np.loadtxt(path, delimiter=",", skiprows=1)
    assert np.array_equal(nodes[:, 1 : 1 + d], case.points)
    assert np.allclose(nodes[:, 1 + d], case.mass, rtol=1e-11)
    assert np.array_equal(nodes[:, 2 + 2 * d : 2 + 3 * d], case.held)
    cells = read_rows(f"{case.name}/{case.mesh}_cells.csv", homes())
    modulus = [float(row.get("E", case.E)) for row in cells]
    assert np.array_equal(modulus, case.modulus)
    assert len(set(modulus)) == (2 if "bimaterial" in case.name else 1)


# Two materials ------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["bimaterial_bar_plane_stress", "bimaterial_bar_space"])
def test_the_tables_of_two_materials_are_the_whole_question(name, tmp_path, capsys):
    """Elements of one's own, from what is handed out, close in on the answer at another ratio."""
    far = []
    for mesh in ("tri3", "tri3_2") if "plane" in name else ("tet4", "tet4_2"):
        case = elastic_case(name, 0.45, mesh)
        assert case.case_file.count("nu = 0.45\n") == 2
        move = solved(case)[case.named]
        far.append(np.abs(move - case.wanted).max() / np.abs(case.wanted).max())
        for key, away in case.coarse().items():
            if key.endswith(f" {mesh}"):  # what our own elements say, kept in half precision
                assert np.abs(move - away).max() < 1e-3 * np.abs(case.wanted).max()
    assert far[1] < 0.6 * far[0]
    assert command(["mesh", name, str(tmp_path)]) == 0
    assert "E = 1e+07 and 4e+07 Pa" in capsys.readouterr().out
    with (tmp_path / "cells.csv").open(newline="") as file:
        found = [float(row["E"]) for row in csv.DictReader(file)]
    assert np.array_equal(found, elastic_case(name).modulus)


def solved(case):
    """Displacement (n, d) in m of linear simplices, each of its own modulus."""
    d = case.points.shape[1]
    corners = case.points[case.cells]
    edges = corners[:, 1:] - corners[:, :1]
    volume = np.abs(np.linalg.det(edges)) / d / (d - 1) * case.thickness
    by_node = np.linalg.inv(edges).swapaxes(1, 2)
    by_node = np.concatenate([-by_node.sum(axis=1, keepdims=True), by_node], axis=1)
    nu, one = case.nu, np.eye(d)
    mu = case.modulus / (2 * (1 + nu))
    lam = 2 * mu * nu / ((1 - nu) if case.state == "plane_stress" else (1 - 2 * nu))
    stiffness = np.zeros((*case.points.shape, *case.points.shape))
    for g, v, m, k, nodes in zip(by_node, volume, mu, lam, case.cells, strict=True):
        own = m * np.einsum("ak,bk,ij->aibj", g, g, one) + m * np.einsum("aj,bi->aibj", g, g)
        own += k * np.einsum("ai,bj->aibj", g, g)
        at = (nodes[:, None, None, None], np.arange(d)[:, None, None])
        at += (nodes[:, None], np.arange(d))
        np.add.at(stiffness, at, v * own)
    whole = stiffness.reshape(case.points.size, -1)
    free = ~case.held.ravel()
    move = case.value.ravel().copy()
    load = (case.force.ravel() - whole @ move)[free]
    move[free] = np.linalg.solve(whole[np.ix_(free, free)], load)
    return move.reshape(case.points.shape)


# Confirmed twice ----------------------------------------------------------------------------------


def confirmations():
    return [
        Confirmation(
            row["case"], float(row["nu"]), row["quantity"], float(row["largest component"]),
            row["way"], row["second way"], float(row["its own uncertainty"]),
            float(row["second way's own uncertainty"]), float(row["difference of the ways"]),
            row["balance alone gives it"] == "yes",
        )
        for row in read_rows("confirmed.csv", homes())
    ]  # fmt: skip


def test_every_value_is_confirmed_by_a_second_way():
    rows = confirmations()
    stated = {
        (statement.name, nu, name): value
        for statement in all_statements()
        for nu, answer in read_answers(statement, homes()).items()
        for name, value in answer.uncertainty.items()
    }
    assert {(row.case, row.nu, row.quantity) for row in rows} == set(stated)
    assert all(row.way != row.second_way for row in rows)
    assert [row for row in rows if not row.is_confirmed] == []
    for row in rows:  # the table has three digits
        own = max(row.own, 0.0 if row.balanced or row.way == "closed form" else row.difference)
        assert stated[row.case, row.nu, row.quantity] >= 0.995 * own


def test_a_value_that_is_a_tenth_off_is_not_confirmed():
    for row in confirmations():
        if row.size > 1e-6:  # of a twisted bar stress has no mean
            assert not replace(row, difference=0.1 * row.size).is_confirmed, row
        elif row.quantity == "displacement":
            raise AssertionError(row)


def test_ways_that_contradict_each_other_stop_the_making(monkeypatch, tmp_path, capsys):
    from cases.make import __main__ as make  # noqa: PLC0415

    cook = next(each for each in all_statements() if each.name == "cook_plane_stress")
    (first, *_) = read_answers(cook, homes()).values()
    good = compared(cook, 0.0, ("elements", first), ("ngsolve", first))
    assert versions.refuse_unconfirmed(good) == 0
    away = replace(first, displacement=1.1 * first.displacement)
    wrong = compared(cook, 0.0, ("elements", first), ("ngsolve", away))
    assert [row.is_confirmed for row in wrong].count(False) == 1
    # What is stated of the value is as wide as the difference, and saves it no more.
    assert wrong[0].stated >= wrong[0].difference > wrong[0].own + wrong[0].second_own
    monkeypatch.setattr(make, "frozen_answer", lambda *_: (first, wrong))
    only = ["--only", "cook_plane_stress", "--out", str(tmp_path / "v")]
    assert make.main(["freeze", *only]) == 1
    assert "NOT CONFIRMED cook_plane_stress nu 0 displacement" in capsys.readouterr().err
    monkeypatch.setattr("cases.make.errata.mended", lambda *_: ({}, wrong))
    assert make.main(["errata", *only]) == 1
    assert not (tmp_path / "v").exists()


def test_errata_are_what_the_code_makes_of_version_1():
    chosen = [e for e in all_statements() if e.name.startswith(("bimaterial", "lame", "l_shape"))]
    files, _ = mended(chosen)
    assert {name.split("/")[1] for name in files if "/" in name} >= {
        "quantities.csv", "displacement.csv", "case.toml", "tet4_cells.csv",
    }  # fmt: skip
    for name, content in files.items():
        if name != "confirmed.csv":
            assert (homes()[0] / name).read_bytes() == content, name


# What is stated is true ---------------------------------------------------------------------------


@pytest.mark.parametrize("kinds", [("displacement",), ("strain energy",), ("",)])
def test_errors_that_are_stated_are_true_ones_and_not_far_above(kinds):
    """Where the second way knows a value twice as well as is stated, it is the truth.

    Held to it is what `elements` tell before the difference enters: after that none is outside.
    """
    pairs = [
        (row.own, max(row.difference, 1e-12 * row.size))
        for row in confirmations()
        if row.way == "elements"
        and row.quantity.startswith(kinds)
        and not row.balanced
        and BY_BALANCE * row.size < row.own < row.size
        and row.second_own <= row.own / 2
    ]
    stated, true = np.array(pairs).T
    assert len(pairs) >= (60 if kinds != ("",) else 150)
    assert (true <= stated).mean() >= COVERED
    assert np.median(stated / true) <= OVERSTATED


@pytest.mark.parametrize("state", ["plane_strain", "plane_stress"])
def test_the_ring_is_lames_to_what_is_stated(state):
    """In 40 digits, from the numbers as they are written."""
    name = f"lame_ring_{state}"
    nodes = read_rows(f"{name}/quad4_nodes.csv", homes())
    uncertainty = {
        row["nu"]: Decimal(row["uncertainty"])
        for row in read_rows(f"{name}/quantities.csv", homes())
        if row["quantity"] == "displacement"
    }
    with localcontext() as context:
        context.prec = 40
        for row in read_rows(f"{name}/displacement.csv", homes()):
            x, y = (Decimal(nodes[int(row["id"])][axis]) for axis in "xy")
            nu, r = Decimal(row["nu"]), (x * x + y * y).sqrt()
            inward = (1 - 2 * nu) * (1 + nu) if state == "plane_strain" else 1 - nu
            factor = Decimal(10_000) / 3 * (inward + (1 + nu) / (r * r)) / Decimal(10_000_000)
            for found, at in ((row["ux"], x), (row["uy"], y)):
                assert abs(Decimal(found) - factor * at) <= uncertainty[row["nu"]], row


def test_no_value_is_rounded_beyond_its_uncertainty():
    assert rounded_too_far(homes()) == []
    assert len(rounded_too_far(homes(1))) > 300  # Lamé's ring, and energies of a block


def rounded_too_far(folders):
    """Values that half a unit of their last digit may take off further than is stated."""
    found = []
    for name in case_names():
        quantities = read_rows(f"{name}/quantities.csv", folders)
        stated = {(row["nu"], row["quantity"]): Decimal(row["uncertainty"]) for row in quantities}
        values = [(row["nu"], row["quantity"], row["value"]) for row in quantities if row["value"]]
        values += [
            (row["nu"], "displacement", row[key])
            for row in read_rows(f"{name}/displacement.csv", folders)
            for key in ("ux", "uy", "uz")
            if key in row
        ]
        for nu, quantity, value in values:
            if half_a_unit(value) > stated[nu, quantity]:
                found.append((name, nu, quantity, value))
    return found


def half_a_unit(text):
    """Of the last digit written; of numbers shorter than the twelve that are written, 0."""
    number = Decimal(text).as_tuple()
    return Decimal(10) ** int(number.exponent) / 2 if len(number.digits) >= 12 else Decimal(0)


def test_a_set_that_was_changed_is_refused(tmp_path):
    path = tmp_path / "set_2.npz"
    content = bytearray((case_set.HERE / "set_2.npz").read_bytes())
    assert len(content) < 9e5
    content[len(content) // 2] ^= 1
    path.write_bytes(content)
    with pytest.raises(case_set.CheckError, match="the file was changed; install"):
        case_set._checked(path, case_set.DIGESTS[2])
    with pytest.raises(case_set.CheckError, match="No such file"):
        case_set._checked(tmp_path / "none.npz", "")
