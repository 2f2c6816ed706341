"""Which solid springs are: lattices by name, finite pieces and periodic samples in files."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pandas as pd
import pytest
from scipy.spatial import KDTree

from msvalidate.case.advise.identify import identified_lines, identify_lattice
from msvalidate.case.advise.identify_files import _own_axes, identify_files
from msvalidate.case.judge.mistakes import mistake_lines
from msvalidate.cli.program import main
from msvalidate.problem import Box, Isotropic, Problem, Support
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.constants.bounds import tensor_bounds
from msvalidate.springs.constants.homogenise import homogenise_network
from msvalidate.springs.constants.routes import calibrate_by_route
from msvalidate.springs.constants.stiffness import isotropic_moduli, moduli
from msvalidate.springs.lattice import boundary_weights, fill, repeat_cell, voronoi
from tests.registries import AFFINE, LATTICES
from tests.table import refused

SPACING = 0.37 / 5


def written(folder, points, springs, stiffness, **more):
    """The files of a network: what is given of points and cells, the rest of springs."""
    table = pd.DataFrame(dict(zip("xyz", points.T, strict=False)))
    table.insert(0, "id", np.arange(len(points)) + 5)
    if "mass" in more:
        table["mass"] = more.pop("mass")
    table.to_csv(folder / "points.csv", index=False)
    ends = {"i": springs[:, 0] + 5, "j": springs[:, 1] + 5, "stiffness": stiffness}
    pd.DataFrame(ends | more).to_csv(folder / "springs.csv", index=False)
    return folder / "springs.csv"


def constants_of(pattern):
    return tuple(1.0 + 0.3 * kind for kind in range(pattern.kinds))


def closed_tensor(pattern):
    scale = SPACING if pattern.dim == 3 else 1.0
    return pattern.tensor(constants_of(pattern)) / scale


def piece(name, cells=5):
    pattern = LATTICES[name]()
    body = fill(pattern, Box(tuple(SPACING * cells * e for e in pattern.size)), cells)
    weights = boundary_weights(body, "shared")
    return body, np.array(constants_of(pattern))[body.kind] * weights


@pytest.mark.parametrize("name", LATTICES)
def test_a_lattice_is_known_in_each_way(name, tmp_path):
    pattern = LATTICES[name]()
    k, expected = constants_of(pattern), closed_tensor(pattern)
    body, stiffness = piece(name)
    sample = repeat_cell(pattern, 3)
    each = [
        identify_lattice(name, k, SPACING),
        identify_files(written(tmp_path, body.points, body.springs, stiffness)),
        identify_files(
            written(tmp_path, SPACING * sample.points, sample.springs, sample.stiffness(k)),
            tuple(SPACING * edge for edge in sample.size),
        ),
    ]
    for found in each:
        assert np.abs(found.tensor - expected).max() <= 1e-9 * expected.max()
        assert (found.stable == "stable") == (name not in {"square4", "cubic6"})


def test_a_hole_a_turn_and_stiffer_sides_change_nothing_inside(tmp_path):
    body, stiffness = piece("triangular", 8)
    ends = body.points[body.springs]
    sides = ((ends == ends.min(axis=(0, 1))) | (ends == ends.max(axis=(0, 1)))).any(axis=(1, 2))
    stiffness = stiffness * np.where(sides, 2.0, 1.0)
    away = np.linalg.norm(body.points - body.points.mean(axis=0), axis=1) > 2 * SPACING
    number = np.cumsum(away) - 1
    stay = away[body.springs].all(axis=1)
    c, s = np.cos(0.3), np.sin(0.3)
    points = body.points[away] @ np.array([[c, s], [-s, c]])
    found = identify_files(written(tmp_path, points, number[body.springs[stay]], stiffness[stay]))
    expected = closed_tensor(LATTICES["triangular"]())  # isotropic: no turn changes it
    assert np.abs(found.tensor - expected).max() <= 1e-9 * expected.max()


@pytest.mark.parametrize("name", AFFINE)
def test_a_body_of_a_material_is_that_material(name, tmp_path):
    pattern = LATTICES[name]()
    E, nu, d = 2.8e9, 0.4, pattern.dim
    material = Isotropic(E, nu, "plane_stress" if d == 2 else "solid", 1234.0, 0.2 if d == 2 else 1)
    calibration = calibrate_by_route(material, pattern, SPACING, None)
    box = Box(tuple(4 * SPACING * edge for edge in pattern.size))
    problem = Problem(box, material, (Support(box.side("left"), (0.0,) * d),))
    network = lattice_network(problem, fill(pattern, box, 4), calibration)
    corners = network.volumes.cells
    cells = pd.DataFrame({f"p{i}": corner + 5 for i, corner in enumerate(corners.T)})
    kappa = np.full(len(corners), calibration.volume)
    kappa[(network.points[corners, 0] == 0).any(axis=1)] *= 3  # which counts inside alone
    cells.assign(kappa=kappa).to_csv(tmp_path / "cells.csv", index=False)
    springs = written(
        tmp_path,
        network.points,
        network.springs,
        network.stiffness,
        mass=network.mass,
        rest_length=network.rest_length,
    )
    found = identify_files(springs)
    np.testing.assert_array_equal(found.network.volumes.stiffness, kappa)
    text = " ".join(" ".join(identified_lines(found, 0.2)).split())
    where = "plane stress" if d == 2 else "isotropic"
    assert f"{where} E = {E:.6g} Pa, nu = 0.4" in text.replace("2800000000 ", "2.8e+09 ")
    assert "of this body, nothing held" in text
    middle = network.points[corners].mean(axis=1) - np.array(box.size) / 2
    kappa[np.linalg.norm(middle, axis=1).argmin()] *= 1 + 2e-9
    cells.assign(kappa=kappa).to_csv(tmp_path / "cells.csv", index=False)
    with refused("kappa is not one number inside"):
        identify_files(springs)


@pytest.mark.parametrize("dim", [2, 3])
def test_random_periodic_networks(dim, tmp_path):
    # Against a dense least-squares minimum of the energy under each unit strain.
    p = voronoi(40, dim=dim, seed=3)
    k, v = p.stiffness((3.0,)), 0.1 * p.vectors
    length = np.linalg.norm(v, axis=1)
    n = v / length[:, None]
    pairs = (
        [(0, 0), (1, 1), (0, 1)] if dim == 2 else [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)]
    )
    stretch = np.stack([length * n[:, a] * n[:, b] for a, b in pairs], axis=1)
    B = np.zeros((len(v), len(p.points), dim))
    rows = np.arange(len(v))
    np.add.at(B, (rows, p.springs[:, 1]), n)
    np.add.at(B, (rows, p.springs[:, 0]), -n)
    root = np.sqrt(k)[:, None]
    B = root * B.reshape(len(v), -1)
    rest = root * stretch - B @ np.linalg.lstsq(B, root * stretch)[0]
    period = tuple(0.1 * edge for edge in p.size)
    expected = rest.T @ rest / np.prod(period)
    images = {f"image_{axis}": p.image[:, a] for a, axis in enumerate("xyz"[:dim])}
    files = written(tmp_path, 0.1 * p.points, p.springs, k, rest_length=length, **images)
    found = identify_files(files, period)
    assert np.abs(found.tensor - expected).max() <= 1e-9 * expected.max()


@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize(("dim", "count"), [(2, 900), (3, 1331)])
def test_bounds_of_random_networks_hold_the_tensor_of_the_periodic_one(dim, count, seed):
    rng = np.random.default_rng(seed)
    if seed % 2:  # Voronoi facets, constants spread further
        p = voronoi(count, dim=dim, seed=seed)
        size, k = np.array(p.size), p.factor * np.exp(0.5 * rng.normal(size=len(p.springs)))
        x, pairs, vectors = p.points, p.springs, p.vectors
    else:  # any two points nearer than a reach
        size = np.full(dim, count ** (1 / dim))
        x = rng.random((count, dim)) * size
        pairs = KDTree(x, boxsize=size).query_pairs({2: 2.2, 3: 1.8}[dim], output_type="ndarray")
        vectors = x[pairs[:, 1]] - x[pairs[:, 0]]
        vectors, k = vectors - size * np.round(vectors / size), np.ones(len(pairs))
    whole = homogenise_network(count, pairs, vectors, k, float(np.prod(size))).tensor
    inner = np.abs(vectors - x[pairs[:, 1]] + x[pairs[:, 0]]).max(axis=1) < 1e-9
    rows = tensor_bounds(x, pairs[inner], k[inner])
    exact = isotropic_moduli(whole)
    for row in rows:
        ordered = np.linalg.eigvalsh(row.upper - row.lower)[0]
        assert ordered > 0
        low, high = row.moduli
        assert np.all(low < [exact.E, exact.nu, exact.zener])
        assert np.all(high > [exact.E, exact.nu, exact.zener])
    # Larger windows are the union of smaller ones: the theorem of partition for the upper bound.
    for large, small in pairwise(rows):
        assert np.linalg.eigvalsh(small.upper - large.upper)[0] > -1e-2 * whole.max()
        assert np.ptp(large.moduli[:, 0]) < np.ptp(small.moduli[:, 0])
    assert dim == 3 or len(rows) > 1


def test_a_chain_has_its_axial_stiffness(tmp_path):
    # Bonds to three neighbours of constant c/distance: EA = 2E/(A·δ²) summed is c·h·(1 + 2 + 3).
    at, axis = SPACING * np.arange(30.0), np.array([0.6, 0.0, 0.8])
    pairs = np.array([(i, i + r) for r in (1, 2, 3) for i in range(30 - r)])
    k = 2.0 / np.subtract(*at[pairs].T[::-1])
    files = written(tmp_path, np.outer(at, axis), pairs, k, mass=np.ones(30))
    found = identify_files(files)
    assert found.tensor[0, 0] == pytest.approx(2.0 * 6, rel=1e-9)
    assert "EA" in identified_lines(found)[-3]
    assert math.isfinite(found.omega)
    uneven = np.cumsum(1 + np.random.default_rng(0).random(20))
    pairs, k = np.column_stack([np.arange(19), np.arange(1, 20)]), np.linspace(1, 3, 19)
    found = identify_files(written(tmp_path, uneven[:, None], pairs, k))
    assert found.tensor[0, 0] == pytest.approx(np.ptp(uneven) / (1 / k).sum(), rel=1e-9)
    with refused("--density: a chain has no volume"):
        identify_files(tmp_path / "springs.csv", density=1000.0)


def test_peridynamic_bonds_are_a_solid(tmp_path):
    # 28 neighbours within 3.015 spacings, c/length with c = 9E/(πδ³), every bond to both points.
    x = np.array([(i, j) for i in range(21) for j in range(21)], dtype=float)
    pairs = KDTree(x).query_pairs(3.015, output_type="ndarray")
    assert np.bincount(pairs.ravel()).max() == 28
    k = 9 / (np.pi * 3.015**3) / np.linalg.norm(x[pairs[:, 1]] - x[pairs[:, 0]], axis=1)
    found = moduli(identify_files(written(tmp_path, x, pairs, k)).tensor)
    assert [found.E, found.nu, found.zener] == pytest.approx([1.0486, 0.318, 0.934], abs=6e-4)


def test_known_mistakes_are_listed_in_each_state():
    for name, states in (("square", ("plane_stress", "plane_strain")), ("cubic18", ("solid",))):
        for state in states:
            lines = mistake_lines(Isotropic(1e5, 0.3, state), name, 0.37)
            assert any(each.startswith("k = E·h") for each in lines)


def test_how_stable_it_is():
    sides = identify_lattice("fcc", (1.0, 0.25), 1.0, volume=-1.0, density=1.0)  # nu = 0
    assert sides.stable.startswith("endless stable, a body not: FCC lattice: a free block")


def test_other_classes_are_refused(tmp_path):
    rng = np.random.default_rng(1)
    body, k = piece("square", 8)
    for column, value, said in (
        ("stiffness", -3.0, "stiffness: -3 at index 3 N/m; give 0 or more"),
        ("j", 999, "springs.csv: j = 999 in row 4 is no point of points.csv"),
        ("rest_length", 0.5, "m is not the distance"),
    ):
        files = written(tmp_path, body.points, body.springs, k)
        given = pd.read_csv(files).assign(rest_length=np.linalg.norm(body.vectors, axis=1))
        given.loc[3, column] = value
        given.to_csv(files, index=False)
        with refused(said):
            identify_files(files)
    for column, value, message in (
        ("id", 0, "points.csv: id 0 comes twice; give each point its own"),
        ("x", "1,2", "points.csv: coordinates"),
    ):
        files = written(tmp_path, body.points, body.springs, k)
        points = pd.read_csv(files.with_name("points.csv"), dtype=object)
        points["id"] = range(len(points))
        points.loc[3, column] = value
        points.to_csv(files.with_name("points.csv"), index=False)
        with refused(message):
            identify_files(files)
    with refused("period: shape (3,); the points have 2 axes"):
        identify_files(written(tmp_path, body.points, body.springs, k), (1.0, 1.0, 1.0))
    with refused("springs.csv: length: 0 at index 72 m; leave that spring out"):
        identify_files(written(tmp_path, body.points[:, :1], body.springs, k))
    shaken = body.points + 0.1 * SPACING * rng.normal(size=body.points.shape)
    files = written(tmp_path, shaken, body.springs, k)
    assert identify_files(files).bounds[0].points < len(shaken)
    few, inside = piece("square", 2)
    shaken = few.points + 0.1 * SPACING * rng.normal(size=few.points.shape)
    assert (
        "too few for an inside"
        in identify_files(written(tmp_path, shaken, few.springs, inside)).what
    )
    with refused("give a larger piece, or a periodic sample and its --period"):
        identify_files(written(tmp_path, shaken[:4], np.array([(0, 1), (1, 3)]), inside[:2]))
    right = (body.points[body.springs, 0] > 4 * SPACING).all(axis=1)
    with refused("stiffness changes inside; give those of one material"):
        identify_files(written(tmp_path, body.points, body.springs, np.where(right, k / 2, k)))
    with refused("points move on in a uniform strain"):
        identify_lattice("honeycomb", (1.0, 1.0), 1.0, volume=1.0)


def test_moduli_by_name_step_and_direction(capsys):
    # nu = (3K - 2μ)/(2(3K + μ)); bcc iron by [Nye1957] of S along (1, 1, 0).
    assert main(["advise", "--K", ".1", "--mu", "1", "--spacing", "1", "--step", "100"]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "nu = -0.653846, auxetic: it widens when it is pulled" in out
    E, step = 0.6923077, float(out.split("cubic18, 1 m ")[1].split()[4])
    allowed = float(out.split("allows E up to ")[1].split()[0])
    assert allowed == pytest.approx(E * (step / 100) ** 2, rel=1e-2)
    assert main(["advise", "--identify", "--cubic", "231GPa", "135GPa", "116GPa"]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "E = 2.19461e+11 Pa, nu = -0.0540477 along (1, -1, 0) to 0.616002 along (0, 0, 1)" in out


def test_tolerances_are_relative_to_the_springs(tmp_path):
    """A lattice of micrometres has the same tensor."""
    body, k = piece("triangular", 4)
    length = 1e-6 * np.linalg.norm(body.vectors, axis=1)
    found = identify_files(written(tmp_path, 1e-6 * body.points, body.springs, k))
    np.testing.assert_allclose(found.tensor, closed_tensor(LATTICES["triangular"]()), atol=1e-9)
    files = written(tmp_path, 1e-6 * body.points, body.springs, k, rest_length=1.001 * length)
    with refused("m is not the distance"):
        identify_files(files)


@pytest.mark.parametrize(("name", "thickness"), [("triangular", 0.2), ("cubic18", None)])
def test_masses_of_a_density(name, thickness, tmp_path):
    """Mass of the volume of a piece; Gershgorin's bound for a periodic sample."""
    body, k = piece(name, 4)
    density = 3.0 * (thickness or 1.0)
    found = identify_files(written(tmp_path, body.points, body.springs, k), None, 3.0, thickness)
    mass = density * np.prod(np.ptp(body.points, axis=0))
    assert found.network.mass.sum() == pytest.approx(mass, rel=0.02)
    assert found.whose == "this body, nothing held, 3 kg/m³"
    sample = repeat_cell(LATTICES[name](), 3)
    k, edges = sample.stiffness(constants_of(LATTICES[name]())), SPACING * np.array(sample.size)
    files = written(tmp_path, SPACING * sample.points, sample.springs, k)
    found = identify_files(files, tuple(edges), 3.0, thickness)
    row = np.bincount(sample.springs.ravel(), np.repeat(k, 2)).max()
    mass = density * np.prod(edges) / len(sample.points)
    assert found.omega == pytest.approx(np.sqrt(2 * row / mass), rel=1e-9)
    (tmp_path / "cells.csv").touch()
    with refused("cells.csv: a periodic sample is of springs alone"):
        identify_files(files, tuple(edges))


@pytest.mark.parametrize(("off", "axes"), [(0.5e-4, 1), (2e-4, 3)])
def test_points_are_on_a_line_within_a_part_of_its_length(off, axes):
    x = np.array([7.0, 8.0, 9.0]) + np.outer([0.0, 3.0, 1.0, -2.0], [0.6, 0.0, 0.8])
    x[2, 1] += 3 * off
    own = _own_axes(x)
    assert own.shape == (4, axes)
    if axes == 1:
        np.testing.assert_allclose(own[:, 0], [0, 3, 1, -2], atol=1e-9)
    flat = np.array([[0.0, 0, 2], [1, 0, 2], [0, 1, 2]])
    np.testing.assert_array_equal(_own_axes(flat), flat[:, :2])


def test_edges_of_a_sample_exceed_its_span(tmp_path):
    sample = repeat_cell(LATTICES["square"](), 3)
    files = written(tmp_path, sample.points, sample.springs, sample.stiffness((2.0, 1.0)))
    with refused("--period: 2.0001 m where points span 2 m"):
        identify_files(files, (3.0, 2.0001))
    assert identify_files(files, (3.0, 2.0003)).solid
    pairs = np.append(sample.springs, [[0, 0]], axis=0)
    files = written(tmp_path, sample.points, pairs, 1.0)
    with refused("springs.csv: a spring to its own image; count in image_x, image_y"):
        identify_files(files, (3.0, 3.0))
    with refused(f"springs.csv: row {len(pairs)} joins a point to itself"):
        identify_files(files)


def test_the_command_identifies(tmp_path, capsys):
    words = "advise --identify --lattice square --k1 2N/mm --k2 1e3 --kappa -.5e3 --spacing 2mm"
    assert main(words.split()) == 0
    assert " xx yy xy 2500 500 0 500 2500 0 0 0 1000 " in " ".join(capsys.readouterr().out.split())
    sample = repeat_cell(LATTICES["square"](), 3)
    k = sample.stiffness((2.0, 1.0))
    files = written(
        tmp_path, sample.points, sample.springs, k, mass=np.full(len(sample.points), 1.0)
    )
    assert main(["advise", "--identify", str(files), "--period", "300cm", "3"]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "isotropic E = 2.66666667 N/m, nu = 0.333333333" in out
    assert "of any wave at most step leapfrog and Euler-Cromer" in out
