"""Springs as files: they rebuild the network, other code finds its rest from them; exports."""

from __future__ import annotations

import io
import json
from pathlib import Path

import meshio
import msgspec
import numpy as np
import pandas as pd
import pytest

from examples import springs_from_files
from msvalidate.case.compare.body_advice import advise_body, body_lines
from msvalidate.case.file.building import read_case
from msvalidate.case.file.case import Case, make_lattice, spacing_of
from msvalidate.case.judge.matching import match
from msvalidate.case.judge.results import read_result
from msvalidate.case.springs.lattice_springs import solve_springs
from msvalidate.case.springs.network_files import NetworkFile, network_files
from msvalidate.cli.program import main
from msvalidate.problem import Box, Isotropic, Mesh, Problem, Region, Support, Traction
from msvalidate.springs.lattice import fill, patterns
from reference_fem.first_mesh import first_mesh
from tests.table import table

THICK = 0.2
BOX = Path(__file__).parents[4] / "examples" / "box.toml"


def meshed(box, cells, keep):
    """Cells of a grid whose middles are kept, as a mesh."""
    grid = fill(patterns.cubic18() if len(cells) == 3 else patterns.square(), box, cells)
    kept = grid.cells[[keep(*middle) for middle in grid.points[grid.cells].mean(axis=1)]]
    used, number = np.unique(kept, return_inverse=True)
    shape = "quad" if len(cells) == 2 else "hexahedron"
    return Mesh(grid.points[used], number.reshape(kept.shape), shape)


HOLES = meshed(Box((0.04, 0.02)), (8, 4), lambda x, y: abs(y - 0.0075) > 0.003 or 0.01 < x < 0.03)
BRACKET = meshed(Box((0.3, 0.3, 0.1)), (3, 3, 1), lambda x, y, _: x < 0.1 or y < 0.1)


def case_of(body, nu, load, size=0.0, **options):
    """A body held at its left, pulled by a load (Pa) at its right, which is moved up by a size."""
    d, state = body.dim, "solid" if body.dim == 3 else "plane_stress"
    left, right = (Region((x, None, None)[:d]) for x in body.span[0])
    held = [Support(left, (0.0,) * d), Support(right, (None, size, None)[:d])]
    law = Isotropic(70e9, nu, state, 1e3, THICK if d == 2 else 1.0)
    pulled = Traction(right, (load, 0.0, 0.0)[:d])
    return Case(Problem(body, law, tuple(held[: 1 + bool(size)]), (pulled,)), **options)


BAR = Box((2.0, 1.0, 1.0))
UNDER = {"lattice": "mesh edges", "route": "neo-Hookean"}
CASES = {  # case, whether cells resist, whether they have a stress
    "two holes": (case_of(HOLES, 0.4, 1e6, spacing=0.0015), True, True),
    "bracket": (case_of(BRACKET, 0.33, 1e6, 1e-10, spacing=0.05), True, True),
    "springs alone": (case_of(HOLES, 1 / 3, 1e6, spacing=0.0015), False, True),
    "0.3 strain": (case_of(Box((0.37, 0.1)), 0.49, 2e10, spacing=0.37 / 15), True, True),
    "bcc": (case_of(BAR, 0.3, 1.0, lattice="bcc", spacing=0.5), True, False),
    "fcc": (case_of(BAR, 0.25, 1.0, lattice="fcc", spacing=0.5), False, False),
    "edges": (case_of(HOLES, 1 / 3, 1e6, lattice="mesh edges"), False, True),
    "edges under tension": (case_of(HOLES, 0.45, 1e6, **UNDER, spacing=0.002), True, True),
    "tension in space": (case_of(BRACKET, 0.45, 1e6, 1e-10, **UNDER), True, True),
}
for name, size in {"triangular": (4.0, 3**0.5), "honeycomb": (4 * 3**0.5, 6.0)}.items():
    case = case_of(Box(size), 0.5 - 0.1 * (name == "triangular"), 1.0, lattice=name, spacing=0.5)
    CASES[name] = (case, name == "triangular", False)


@pytest.mark.parametrize(("case", "resists", "stressed"), CASES.values(), ids=CASES)
def test_files_rebuild_the_network_and_other_code_finds_its_rest(tmp_path, case, resists, stressed):
    found = solve_springs(case, spacing_of(case))
    files, network = network_files(found, case), found.network
    for name, content in files.items():
        (tmp_path / name).write_bytes(content)
    points, springs = (
        np.genfromtxt(tmp_path / f"{name}.csv", delimiter=",", names=True)
        for name in ("points", "springs")
    )
    assert ("cells.csv" in files, "cells.vtu" in files) == (resists, resists or stressed)
    fields = {name: meshio.read(tmp_path / name) for name in files if name.endswith("vtu")}
    for name, field in fields.items():
        every = [*field.point_data.values(), *(each for (each,) in field.cell_data.values())]
        assert all(np.isfinite(each).all() for each in every)
        assert ("stress_xx" in field.cell_data) == (name == "cells.vtu" and stressed)
    np.testing.assert_array_equal(springs["stiffness"], network.stiffness)
    rests = network.law.rests
    np.testing.assert_array_equal(springs["rest_length"], network.rest_length * rests)
    for name, values in {
        "": network.points,
        "force_": network.force,
        "held_": network.fixed,
    }.items():
        np.testing.assert_array_equal(points[f"{name}x"], values[:, 0])
    wanted = found.rest.displacement
    off = np.abs(springs_from_files.solve(tmp_path, move=False) - wanted).max()
    assert off <= 1e-9 * np.abs(wanted).max()
    if not rests:  # whose tension turns with them
        return
    # Tensions and pressures balance the loads where nothing is held.
    ends, left = np.stack([springs["i"], springs["j"]], 1).astype(int), network.force.copy()
    pulls = [(ends, -springs["force"])]
    if resists:
        pressure = np.genfromtxt(tmp_path / "cells.csv", delimiter=",", names=True)["pressure"]
        pulls.append((network.resisting, pressure))
    for nodes, by in pulls:
        slope = springs_from_files.measure(network.points[nodes], under=False)[1]
        np.add.at(left, nodes, by[:, None, None] * slope)
    assert np.abs(left[~network.fixed]).max() <= 1e-9 * np.abs(springs["force"]).max()


def export(folder, words, *changes):
    """Exit code of an export of the cantilever at ratio 0.4, of whose file texts are changed."""
    text = BOX.read_text(encoding="utf-8") + "[springs]\ncells = 4\n"
    for old, new in ((f"nu = {1 / 3}", "nu = 0.4"), *changes):
        assert old in text
        text = text.replace(old, new)
    (folder / "bar.toml").write_text(text, encoding="utf-8")
    given = ["case", "export", str(folder / "bar.toml"), str(folder / "out"), *words.split()]
    return main(given)


PULLED = (
    ("[0, -10]", "[5, 0]"),
    ('"plane_stress"', '"plane_stress"\nthickness = 0.2'),
    ('on = "left"', 'on = "left"\ncomponents = ["x"]\n[[support]]\nat = { x = 0, y = 0 }'),
)
REGION = ("[[support]]\non", "[[region]]\nbox = { x = [2, 4] }\nE = 1e6\nnu = 0.4\n[[support]]\non")


@table("changes", [(), (REGION, ("nu = 0.4", "nu = 0"))])
def test_stress_of_cells_is_in_pascal(tmp_path, changes):
    assert export(tmp_path, "--to json", *changes, *PULLED) == 0
    case = read_case(tmp_path / "bar.toml")
    content = network_files(solve_springs(case, 0.25), case)["cells.vtu"]
    (tmp_path / "cells.vtu").write_bytes(content)
    field = meshio.read(tmp_path / "cells.vtu")
    for name, value in {"xx": 5.0, "yy": 0.0, "xy": 0.0}.items():
        assert field.cell_data[f"stress_{name}"][0] == pytest.approx(value, abs=1e-9)


def test_numbers_of_points_are_those_of_the_table(tmp_path):
    # A cut lattice has points outside, which the table lists and no comparison counts.
    case, _, _ = CASES["two holes"]
    content = network_files(solve_springs(case, case.spacing), case)["points.csv"]
    given, inside = pd.read_csv(io.BytesIO(content)), make_lattice(case, case.spacing).inside
    wanted = given.loc[inside, ["x", "y", "ux", "uy"]].to_numpy()
    assert len(wanted) < len(given)
    for name, columns in {"by_place": given.columns[1:], "by_id": ["ux", "id", "uy"]}.items():
        shuffled = given[[*columns]].sample(frac=1, random_state=1)
        shuffled.to_csv(tmp_path / f"{name}.csv", index=False)
        result = read_result(tmp_path / f"{name}.csv", 2)
        found = match(case, result, 1.0, first_mesh(case.problem))
        rows = np.c_[found.places, found.displacement]
        np.testing.assert_allclose(rows[np.lexsort(rows.T[:2])], wanted[np.lexsort(wanted.T[:2])])
        assert len(found.outside) == len(given) - len(wanted)
        assert not len(found.missing)


def test_json_is_what_its_schema_says(tmp_path):
    assert export(tmp_path, "--to json") == 0
    content = (tmp_path / "out" / "network.json").read_bytes()
    read, case = msgspec.json.decode(content, type=NetworkFile), read_case(tmp_path / "bar.toml")
    network = solve_springs(case, read.spacing_m).network
    np.testing.assert_array_equal(read.points.position_m, network.points)
    np.testing.assert_array_equal(read.springs.stiffness_N_per_m, network.stiffness)
    np.testing.assert_array_equal(read.cells.kappa_N_per_m_or_Pa, network.volumes.stiffness)
    schema = msgspec.json.schema(NetworkFile)["$defs"]["NetworkFile"]
    assert schema["properties"].keys() == json.loads(content).keys()


VOLUME = ("cells = 4", "cells = 4\nconstants = [1e6, 1e6]\nvolume = 1e5")
SOFT = ("[0, -10]", "[0, -1e-12]")
REFUSED = [  # options, changes, what is said, options and changes that do
    ("--to csv --springs", (), "--springs: is of --to simulator", "--to csv", ()),
    ("--to lammps", (VOLUME,), "volume that takes cells", "--to lammps", (("volume = 1e5", ""),)),
    ("--to lammps", (REGION,), f"nu = {1 / 3}", "--to lammps", (("nu = 0.4", f"nu = {1 / 3}"),)),
    ("--to lammps", (REGION,), "case export --to csv", "--to csv", ()),
    ("--to lammps", (SOFT,), "multiply loads", "--to lammps", (("-1e-12", "-1"),)),
    ("--springs", (), "within 0.01 of 0.333333", "--springs", (("nu = 0.4", "nu = 0.33"),)),
]


@table("words,changes,said,others,mends", REFUSED)
def test_the_remedy_of_a_refusal_works(capsys, tmp_path, words, changes, said, others, mends):
    place = tmp_path / f"{len([*tmp_path.iterdir()])}"
    place.mkdir()
    assert export(place, words, *changes) == 2
    assert said in capsys.readouterr().err
    assert not (place / "out").exists()
    assert export(place, others, *changes, *mends) == 0


def test_another_ratio_has_its_price(capsys, tmp_path):
    # In plane strain between walls a bar is pulled out by (1 - 2 nu)(1 + nu)/(1 - nu)/E.
    walls = "".join(
        f'[[support]]\non = "{side}"\ncomponents = ["y"]\n' for side in ("top", "bottom")
    )
    changes = PULLED[0], ('"plane_stress"', '"plane_strain"'), ("[[load]]", f"{walls}[[load]]")
    slides = ('on = "left"', 'on = "left"\ncomponents = ["x"]')
    assert export(tmp_path, "--to lammps", *changes, slides) == 0
    own, other = ((1 - 2 * nu) * (1 + nu) / (1 - nu) for nu in (0.4, 0.25))
    said = capsys.readouterr().err
    assert "springs alone have ratio 0.25 in plane strain, the case 0.4" in said
    assert f" {100 * (other / own - 1):.2g} % of the largest" in said
    (tmp_path / "out" / "mine.txt").touch()
    assert export(tmp_path, "--to json") == 2
    assert "'mine.txt', which no case left there" in capsys.readouterr().err


def test_files_of_large_displacements_balance():
    case = case_of(Box((2.0, 1.0)), 0.4, 5e9, cells=6, geometry="nonlinear")
    answer = solve_springs(case, 1 / 6)
    files = network_files(answer, case)
    points, springs, cells = (
        pd.read_csv(io.BytesIO(files[f"{name}.csv"])) for name in ("points", "springs", "cells")
    )
    x = points[["x", "y"]].to_numpy() + points[["ux", "uy"]].to_numpy()
    force = points[["force_x", "force_y"]].to_numpy().copy()
    i, j = springs[["i", "j"]].to_numpy().T
    pull = (springs["force"].to_numpy() / np.linalg.norm(x[j] - x[i], axis=1))[:, None]
    np.add.at(force, i, pull * (x[j] - x[i]))
    np.add.at(force, j, -pull * (x[j] - x[i]))
    corners = cells[["p0", "p1", "p2", "p3"]].to_numpy()
    across = x[np.roll(corners, -1, axis=1)] - x[np.roll(corners, 1, axis=1)]
    swelling = np.stack([across[..., 1], -across[..., 0]], axis=2) / 2  # of the area, by corner
    np.add.at(force, corners, cells["pressure"].to_numpy()[:, None, None] * swelling)
    free = points["held_x"].to_numpy() == 0
    assert np.abs(points["ux"]).max() > 0.05
    assert np.abs(force[free]).max() <= 1e-9 * np.abs(force[~free]).max()
    assert b"stress_xx" not in files["cells.vtu"]


def test_springs_under_tension_say_so_in_their_files(tmp_path):
    # A part with a hole, 5 mm thick, its cells cut in two: springs of no rest length.
    cells = np.concatenate([HOLES.cells[:, (0, 1, 2)], HOLES.cells[:, (0, 2, 3)]])
    body = Mesh(HOLES.points, cells, "triangle")
    case = case_of(body, 0.45, 1e6, lattice="mesh edges", route="neo-Hookean")
    answer = solve_springs(case, spacing_of(case))
    files = network_files(answer, case)
    springs, inside = (pd.read_csv(io.BytesIO(files[f"{n}.csv"])) for n in ("springs", "cells"))
    assert not springs["rest_length"].any()
    mu = 70e9 / 2 / 1.45 * THICK
    np.testing.assert_allclose(inside["initial_pressure"], mu, rtol=1e-12)
    assert "springs of no rest length" in " ".join(body_lines(advise_body(case, answer)))
    for name, content in files.items():
        (tmp_path / name).write_bytes(content)
    moved, wanted = springs_from_files.solve(tmp_path, move=False), answer.rest.displacement
    assert np.abs(moved - wanted).max() <= 1e-9 * np.abs(wanted).max()
