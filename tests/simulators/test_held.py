"""Controls of the protocol: a slab is the plane, one cell is one cell, and records are read."""

import json
from dataclasses import asdict

import numpy as np
import pytest
from msvalidate.studies.simulators import held as question
from msvalidate.studies.simulators.recorded import EXCLUDED as WRITTEN

from msvalidate.problem import SHAPES, Isotropic, ProblemError
from msvalidate.simulators.bodies.blocks import frozen_case, request_of
from simulators import held
from simulators.jobs import EXCLUDED, JOBS
from simulators.one_cell import PLACES, one_cell
from tests.table import table

ROUNDED = 1e-12
"""Of the largest displacement or force: some tens of roundings in one small solve."""


@table(
    "name, stress",
    [
        ("block_pull_plane_strain", np.diag([1e4, 0, 0.45e4])),
        ("block_shear_plane_strain", [[0, 5e3, 0], [5e3, 0, 0], [0, 0, 0]]),
    ],
)
def test_a_slab_bears_the_plane_s_stress_between_rollers(name, stress):
    asked, places, wanted, _ = held.body_of(name, 0.45, 3)
    mesh, free = asked.mesh, ~asked.held
    assert asked.mass.sum() == pytest.approx(0.5 * 0.375 * 0.125 * 1000)
    assert free[:, 2].sum() == 0
    assert np.abs(mesh.points[places, 2]).max() == 0
    assert len(places) == len(wanted) == 20
    # A stress that is the same everywhere puts stress times the cells' mean slopes on each node.
    corners = mesh.points[mesh.cells]
    sides = np.ptp(corners, axis=1)
    slopes = SHAPES["hexahedron"].slopes(PLACES).mean(axis=0)
    areas = slopes * (sides.prod(axis=1, keepdims=True) / sides)[:, None]
    expected = np.zeros_like(mesh.points)
    np.add.at(expected, mesh.cells, areas @ np.transpose(stress))
    left = np.abs(expected - asked.force)[free].max()
    assert left < ROUNDED * np.abs(expected).max()


def test_a_slab_is_of_quads_in_plane_strain():
    asked = held.pulled_lattice("square", 1e-3)
    with pytest.raises(ProblemError, match="plane_stress; give quad in plane_strain"):
        held.slab(asked)


def test_one_cell_is_exact_where_stress_is_uniform_and_stiff_where_it_bends():
    for name in ("cell_pull_space", "cell_shear_space"):
        case = frozen_case(name, "hex8", 0.3)
        material = Isotropic(case.E, 0.3, "solid", case.density)
        found = one_cell(request_of(case, material), material.E, material.nu)
        assert np.abs(found[case.named] - case.wanted).max() < ROUNDED * np.abs(case.wanted).max()
    case = frozen_case("cantilever_gravity_space", "hex8", 0.3)
    material = Isotropic(case.E, 0.3, "solid", case.density)
    found = one_cell(request_of(case, material), material.E, material.nu)
    assert np.abs(found[case.named]).max() < 0.3 * np.abs(case.wanted).max()


@table(
    "order, error, linear, difference, beyond",
    [
        (3, 1e-4, 0.1, 1e-9, []),
        (3, 6e-4, 0.1, 1e-9, [0]),
        (1, 4e-4, 0.1, 1e-9, [2]),
        (3, 1e-4, 0.1, 2e-6, [3]),
        (3, 1e-4, 5e-7, 1e-9, [4]),
    ],
)
def test_what_is_not_held_is_seen(order, error, linear, difference, beyond):
    elements = [
        {"case": "clamped_pull", "order": order, "error": error},
        {"case": "block_pull", "order": 3, "error": 1e-13},
    ]
    judged = question.judge(elements, [{"linear": linear, "difference": difference}])
    found = [i for i, one in enumerate(judged) if one.observed.value > one.limit]
    assert found == beyond


def test_what_is_excluded_is_written_by_the_program():
    written = json.loads(WRITTEN.read_text(encoding="utf-8"))
    assert written == [asdict(each) for each in EXCLUDED]
    assert len({job.name for job in JOBS}) == len(JOBS)
