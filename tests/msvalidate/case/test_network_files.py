"""Springs as files: they rebuild the network, its rest is found from them by other code."""

from __future__ import annotations

import io
from dataclasses import replace

import meshio
import numpy as np
import pandas as pd
import pytest

from examples import springs_from_files
from msvalidate.case.case import Case, make_lattice
from msvalidate.case.matching import match
from msvalidate.case.network_files import network_files
from msvalidate.case.results import read_result
from msvalidate.case.springs import solve_springs
from msvalidate.lattice import fill, patterns
from msvalidate.problem import (
    Box,
    Isotropic,
    Mesh,
    Polygon,
    Problem,
    Region,
    Segment,
    Support,
    Traction,
    Zone,
)
from reference_fem.converged import first_mesh
from tests.table import table

THICK = 0.2


def meshed(box, cells, keep):
    """Cells of a grid whose middles are kept, as a mesh."""
    grid = fill(patterns.cubic18() if len(cells) == 3 else patterns.square(), box, cells)
    kept = grid.cells[[keep(*middle) for middle in grid.points[grid.cells].mean(axis=1)]]
    used, number = np.unique(kept, return_inverse=True)
    shape = "quad" if len(cells) == 2 else "hexahedron"
    return Mesh(grid.points[used], number.reshape(kept.shape), shape)


HOLES = meshed(Box((0.04, 0.02)), (8, 4), lambda x, y: abs(y - 0.0075) > 0.003 or 0.01 < x < 0.03)
BRACKET = meshed(Box((0.3, 0.3, 0.1)), (3, 3, 1), lambda x, y, z: z and (x < 0.1 or y < 0.1))
DRAWN = Polygon(((0.0, 0.0), (2.0, 0.0), (2.0, 1.4), (0.0, 0.8)))
ENDS = Segment((0.0, 0.8), (0.0, 0.0)), Segment((2.0, 0.0), (2.0, 1.4))


def case_of(body, nu, load, size=0.0, ends=None, **options):
    """A body held at its left, pulled by `load` (Pa) at its right, which moves sideways by size."""
    d = body.dim
    left, right = ends or (Region((x, None, None)[:d]) for x in body.span[0])
    law = (
        Isotropic(70e9, nu, "solid") if d == 3 else Isotropic(70e9, nu, "plane_stress", 1e3, THICK)
    )
    held = [Support(left, (0.0,) * d)]
    if size:
        held.append(Support(right, (None, size, None)[:d]))
    return Case(
        Problem(body, law, tuple(held), (Traction(right, (load, 0.0, 0.0)[:d]),)), **options
    )


HONEY = Box((4 * 3**0.5, 6.0))
CASES = {
    "two holes": (case_of(HOLES, 0.4, 1e6, spacing=0.0015), True, True),
    "bracket": (case_of(BRACKET, 0.33, 1e6, 1e-10, spacing=0.04), True, True),
    "drawn": (case_of(DRAWN, 1 / 3, 1e4, ends=ENDS, spacing=0.2), False, True),
    "0.3 strain": (case_of(Box((0.37, 0.1)), 0.49, 2e10, cells=4), True, True),
    "triangular": (
        case_of(Box((4.0, 3**0.5)), 0.4, 10.0, lattice="triangular", spacing=0.5),
        True,
        0,
    ),
    "honeycomb": (case_of(HONEY, 0.5, 10.0, lattice="honeycomb", spacing=0.5), False, False),
    "bcc": (case_of(Box((2.0, 1.0, 1.0)), 0.3, 10.0, lattice="bcc", spacing=0.5), True, False),
    "fcc": (case_of(Box((2.0, 1.0, 1.0)), 0.25, 10.0, lattice="fcc", spacing=0.5), False, False),
    "edges": (case_of(HOLES, 1 / 3, 1e6, lattice="mesh edges"), False, True),
}
"""Case, whether cells resist, and whether they have a stress."""


def write(folder, files):
    for name, content in files.items():
        (folder / name).write_bytes(content)


@pytest.mark.parametrize(("case", "resists", "stressed"), CASES.values(), ids=CASES)
def test_files_rebuild_the_network_and_other_code_finds_its_rest(tmp_path, case, resists, stressed):
    found = solve_springs(case, case.spacing or 0.025)
    files, network = network_files(found, case), found.network
    write(tmp_path, files)
    tables = {
        n: np.genfromtxt(tmp_path / n, delimiter=",", names=True) for n in files if "csv" in n
    }
    points, springs = tables["points.csv"], tables["springs.csv"]
    assert ("cells.csv" in files, "cells.vtu" in files) == (resists, bool(resists or stressed))
    for name in ("springs.vtu", "cells.vtu")[: 1 + ("cells.vtu" in files)]:
        field = meshio.read(tmp_path / name)
        every = [*field.point_data.values(), *(each for (each,) in field.cell_data.values())]
        assert all(np.isfinite(each).all() for each in every)
        assert ("stress_xx" in field.cell_data) == (name == "cells.vtu" and bool(stressed))
    for name in ("stiffness", "rest_length"):
        np.testing.assert_array_equal(springs[name], getattr(network, name))
    for column, values in {
        "x": network.points,
        "force_x": network.force,
        "held_x": network.held,
    }.items():
        np.testing.assert_array_equal(points[column], values[:, 0])
    moved = springs_from_files.solve(tmp_path, move=False)
    wanted = found.rest.displacement
    assert np.abs(moved - wanted).max() <= 1e-9 * np.abs(wanted).max()
    # Tensions and pressures balance the loads where nothing is held.
    ends = np.stack([springs["i"], springs["j"]], 1).astype(int)
    pull = springs_from_files.measure(network.points, ends)[1].T @ -springs["force"]
    if resists:
        cells = tables["cells.csv"]
        slopes = springs_from_files.measure(network.points, network.volumes.cells)[1]
        pull = pull + slopes.T @ cells["pressure"]
    left = (pull + network.force.ravel())[~network.held.ravel()]
    assert np.abs(left).max() <= 1e-9 * np.abs(springs["force"]).max()


@table("nu,zoned", [(0.4, False), (0.0, True)])
def test_stress_of_cells_is_in_pascal(tmp_path, nu, zoned):
    body = Box((0.4, 0.1))
    law = Isotropic(70e9, nu, "plane_stress", 1e3, THICK)
    zones = (Zone(Region(((0.2, 0.4), None)), replace(law, E=7e9)),) if zoned else ()
    held = Support(body.side("left"), (0.0, None)), Support(body.side("bottom"), (None, 0.0))
    problem = Problem(body, law, held, (Traction(body.side("right"), (5e6, 0.0)),), zones=zones)
    case = Case(problem, cells=4)
    write(tmp_path, network_files(solve_springs(case, 0.025), case))
    field = meshio.read(tmp_path / "cells.vtu")
    for name, value in {"xx": 5e6, "yy": 0.0, "xy": 0.0}.items():
        assert field.cell_data[f"stress_{name}"][0] == pytest.approx(value, abs=0.05)


def test_numbers_of_points_are_those_of_the_table(tmp_path):
    # A cut lattice has points outside, which the table lists and no comparison counts.
    case = CASES["drawn"][0]
    content = network_files(solve_springs(case, 0.2), case)["points.csv"]
    given = pd.read_csv(io.BytesIO(content))
    inside = make_lattice(case, 0.2).inside
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
