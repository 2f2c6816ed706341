"""What a case becomes for a simulator: the mass, the loads and the network that it had."""

from __future__ import annotations

import runpy
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from msvalidate.case.file.building import read_case
from msvalidate.case.file.case import Case, spacing_of
from msvalidate.case.springs.lattice_springs import solve_springs
from msvalidate.problem import (
    Box,
    Isotropic,
    Mesh,
    PointForce,
    Polygon,
    Problem,
    ProblemError,
    Region,
    Segment,
    Support,
    Traction,
    Weight,
    Zone,
)
from msvalidate.simulators.exchange.export import export_case, lumped_mass
from msvalidate.simulators.exchange.folders import write_request
from msvalidate.simulators.exchange.lammps import lammps_files
from msvalidate.springs.network import spring_network
from msvalidate.springs.statics.equilibrium import equilibrium
from tests.table import table

EXAMPLES = Path(__file__).parents[3] / "examples"
ADAPTER = EXAMPLES.parent / "simulators" / "adapters" / "exchange.py"
G = (0.5, -9.81)


def block(nu=0.25, dim=3, loads=(), **options):
    box = Box((2.0, 1.0, 1.0)[:dim])
    state = "solid" if dim == 3 else "plane_strain"
    thickness = 1.0 if dim == 3 else 0.3
    material = Isotropic(1e5, nu, state, 1200.0, thickness)
    held = (Support(box.side("left"), (0.0,) * dim),)
    return Case(Problem(box, material, held, tuple(loads)), **options)


def outline(corners, material, load, **options):
    """A polygon held along its side from (0, 0) to (1, 0)."""
    held = Support(Segment((0.0, 0.0), (1.0, 0.0)), (0.0, 0.0))
    return Case(Problem(Polygon(corners), material, (held,), (load,)), **options)


BOX = block(dim=2).problem.domain
PULLED = (
    Traction(Region((2.0, (0.25, 0.75))), (30.0, -4.0)),
    PointForce((2.0, 1.0), (0.0, 7.0)),
    Weight(G),
)


@table("shape", ["triangle", "quad"])
def test_mass_and_force_are_the_bodys(shape):
    case = block(dim=2, loads=PULLED)
    asked = export_case(case, cells=5, shape=shape)
    assert asked.mesh.shape == shape
    assert asked.mass.sum() == pytest.approx(1200.0 * 2.0 * 0.3)
    assert asked.gravity.tolist() == list(G)
    assert asked.force.sum(axis=0) == pytest.approx([30 * 0.5 * 0.3, -4 * 0.5 * 0.3 + 7])
    moment = (asked.mesh.points * asked.force[:, ::-1] * [1, -1]).sum()
    assert moment == pytest.approx(2 * (7 - 0.6) - 0.5 * 4.5 - 0 * 7)
    assert asked.held.sum() == 2 * (asked.mesh.points[:, 0] == 0).sum()


def test_masses_are_the_row_sums_of_bent_cells():
    # Of one quadrilateral, by integrals of x^a y^b over [0, 1]^2 by hand: det J = 2 + x.
    mesh = Mesh(np.array([[0, 0], [2, 0], [2, 1.5], [0, 1.0]]), np.array([[0, 1, 2, 3]]), "quad")
    assert mesh.volume == pytest.approx(2.5)
    # height 1 + ξ/2 at x = 2ξ, so det J = 2 + ξ: ∫∫ (1-ξ)(1-η)(2+ξ) = (7/6)/2 ...
    left, right = (2 - 1 + 1 / 2 - 1 / 3) / 2, (1 + 1 / 3) / 2
    assert lumped_mass(mesh, Isotropic(1.0, 0.0, density=1.0)) == pytest.approx(
        [left, right, right, left]
    )


@table("name", ["bracket", "plate", "ring"])
def test_a_mesh_file_is_asked_for_by_linear_cells(name):
    case = read_case(EXAMPLES / f"{name}.toml")
    body, coarse = case.problem.domain, export_case(case)
    assert coarse.mesh.shape == body.kind.straight.name
    assert len(coarse.mesh.cells) == len(body.cells)
    edge = np.linalg.norm(np.diff(body.points[body.cells[:, :2]], axis=1), axis=-1).mean()
    narrow = min(high - low for low, high in body.span)
    fine = export_case(case, cells=int(1.5 * narrow / edge))
    assert len(fine.mesh.cells) == 2**body.dim * len(body.cells)
    # The same total force, also on bent sides, and a volume that closes in on the body's.
    assert fine.force.sum(axis=0) == pytest.approx(coarse.force.sum(axis=0), rel=1e-6, abs=1e-9)
    material = case.problem.material
    whole = body.volume * material.density * material.thickness
    away = [abs(each.mass.sum() / whole - 1) for each in (coarse, fine)]
    assert away[1] < 0.3 * away[0] < 0.004


def test_an_outline_has_nodes_where_its_loads_end():
    corners = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.4, 1.0), (0.0, 0.5))
    pulled = Traction(Segment((1.0, 0.31), (1.0, 0.77)), (5.0, 0.0))
    case = outline(corners, Isotropic(1.0, 0.3), pulled)
    asked = export_case(case)
    assert asked.force.sum(axis=0) == pytest.approx([5 * 0.46, 0])
    with pytest.raises(ProblemError, match="an outline is cut into triangles"):
        export_case(case, shape="quad")


@table("nu,dim", [(0.25, 3), (0.25, 2)])
def test_the_network_is_our_own(tmp_path, nu, dim):
    loads = (Weight((0.5, 0.0, -9.81)[3 - dim :]), *PULLED[:1][: 3 - dim])
    case = block(nu, dim, loads, cells=4)
    folder = tmp_path / f"{dim}"
    write_request(export_case(case, springs=True), folder)
    asked = runpy.run_path(str(ADAPTER))["read_request"](folder)
    springs = asked.springs
    again = spring_network(
        asked.points,
        springs.ends,
        springs.stiffness,
        rest_length=springs.length,
        mass=asked.mass,
        fixed=asked.held,
        displacement=asked.value,
        force=asked.force + asked.mass[:, None] * asked.gravity,
    )
    own = solve_springs(case, spacing_of(case)).rest.displacement
    assert np.abs(equilibrium(again).displacement - own).max() <= 1e-13 * np.abs(own).max()


def test_springs_of_a_body_cut_to_its_outline_are_our_own():
    corners = ((0.0, 0.0), (1.0, 0.0), (0.8, 1.0), (0.0, 1.0))
    case = outline(corners, Isotropic(1e5, 1 / 3), Weight(G), cells=8)
    asked = export_case(case, springs=True)
    network = solve_springs(case, spacing_of(case)).network
    assert np.array_equal(asked.springs.stiffness, network.stiffness)
    total = asked.force + asked.mass[:, None] * asked.gravity
    assert total == pytest.approx(network.force, rel=1e-14)


def with_zone(case):
    zone = Zone(Region(((0.0, 1.0), None, None)), Isotropic(1.0, 0.25, "solid"))
    return replace(case, problem=replace(case.problem, zones=(zone,)))


REFUSED = [
    (with_zone(block()), {}, "several materials"),
    (block(0.4), {"springs": True}, "at ratio 0.4 the cubic18 lattice has cells that resist"),
    (block(), {"springs": True, "shape": "tetra"}, "--shape: with --springs"),
    (block(lattice="bcc"), {"springs": True, "cells": 4}, "corners of no cell"),
    (block(), {"shape": "quad"}, "--shape: 'quad'; choose tetra or hexahedron"),
    (block(), {"cells": 0}, "--cells: 0; give a whole number"),
    (block(), {"cells": 5000}, "points, and the most is"),
    (read_case(EXAMPLES / "ring.toml"), {"shape": "triangle"}, "cells are quad; leave it out"),
    (read_case(EXAMPLES / "ring.toml"), {"cells": 10_000}, "halved"),
]


@table(("case", "options", "words"), REFUSED)
def test_what_cannot_be_asked_is_told(case, options, words):
    with pytest.raises(ProblemError) as found:
        export_case(case, **options)
    assert words in str(found.value)


def test_bonds_of_lammps_join_the_springs_ends_counted_from_one():
    held = np.array([[True, True], [True, True], [False, False]])
    force = np.array([[0.0, 0.0], [0.0, 0.0], [1e-3, 0.0]])
    points, springs = np.array([[0.0, 0], [1, 0], [0, 1]]), np.array([[0, 2], [1, 2]])
    net = spring_network(points, springs, np.array([1.0, 2.0]), fixed=held, force=force)
    lines = lammps_files(net, equilibrium(net), "two")["springs.data"].decode().splitlines()
    first = lines.index("Bonds") + 2
    assert lines[first : first + 2] == ["1 1 1 3", "2 2 2 3"]
