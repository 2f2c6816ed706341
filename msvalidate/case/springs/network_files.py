"""The springs of a case as files for other programs: tables that rebuild the network, and fields.

`points.csv`, `springs.csv` and `cells.csv` are the network as it was solved, in SI units, with all
digits, and `network.json` is these in one; `springs.vtu` and `cells.vtu` show it at rest.
docs/cases.md says what each column holds.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

import msgspec
import numpy as np
import pandas as pd

from msvalidate.bench.output.stored import csv_bytes
from msvalidate.bench.output.vtu import vtu_bytes
from msvalidate.case.file.case import Case
from msvalidate.case.springs.lattice_springs import SpringAnswer
from msvalidate.problem import AXES, SHAPES, VOIGT, Array, ProblemError
from msvalidate.springs.constants.zones import calibrate_zones, spring_shares
from msvalidate.springs.network import Configuration, Network
from msvalidate.springs.network.laws.volumes import dilatation
from msvalidate.springs.statics.stress import cell_stress

SHAPE_OF = {(shape.dim, len(shape.nodes)): shape.name for shape in SHAPES.values()}
"""Axes and corners of cells -> their shape's name, which is meshio's."""


class PointLists(msgspec.Struct, forbid_unknown_fields=True):
    """A row a point: where it is without load, what it weighs, is held by and carries."""

    position_m: list[list[float]]
    mass_kg: list[float]
    held: list[list[bool]]
    prescribed_displacement_m: list[list[float]]
    force_N: list[list[float]]
    displacement_at_rest_m: list[list[float]]


class SpringLists(msgspec.Struct, forbid_unknown_fields=True):
    """A row a spring: numbers of its two points from 0, its constants, its tension."""

    points: list[list[int]]
    kind: list[int]
    stiffness_N_per_m: list[float]
    rest_length_m: list[float]
    tension_at_rest_N: list[float]


class CellLists(msgspec.Struct, forbid_unknown_fields=True):
    """A row a cell that resists a change of volume: kappa and pressure N/m in the plane, or Pa."""

    points: list[list[int]]
    kappa_N_per_m_or_Pa: list[float]
    volume_m2_or_m3: list[float]
    pressure_at_rest_N_per_m_or_Pa: list[float]
    initial_pressure_N_per_m_or_Pa: list[float] | None = None


class NetworkFile(msgspec.Struct, forbid_unknown_fields=True):
    """A spring network at rest, to first order in the displacement or in full, in SI units."""

    schema: Literal[1]
    name: str
    lattice: str
    spacing_m: float
    points: PointLists
    springs: SpringLists
    cells: CellLists | None = None


def network_json(answer: SpringAnswer, case: Case) -> bytes:
    """A case's springs at rest as `NetworkFile` has them."""
    network, tables = answer.network, network_tables(answer)
    lists = [network.points, network.mass, network.fixed, network.displacement, network.force]
    points = PointLists(*(each.tolist() for each in [*lists, answer.rest.displacement]))
    last = tables["springs"].iloc[:, -4:].to_dict("list")
    springs = SpringLists(network.springs.tolist(), *last.values())
    cells = None
    if network.volumes is not None:
        table = tables["cells"]
        last = table.iloc[:, -3:].to_dict("list")
        cells = CellLists(network.resisting.tolist(), *last.values())
        if "initial_pressure" in table:
            cells.initial_pressure_N_per_m_or_Pa = table["initial_pressure"].tolist()
    about = NetworkFile(1, case.name, answer.lattice.name, answer.spacing, points, springs, cells)
    return msgspec.json.format(msgspec.json.encode(about), indent=0) + b"\n"


def network_files(answer: SpringAnswer, case: Case) -> dict[str, bytes]:
    """Tables and fields of a case's springs at rest: name -> content.

    cells.csv is there where cells resist a change of volume, cells.vtu where they have a stress or
    resist. Nothing in them is NaN.
    """
    points, network = answer.lattice.points, answer.network
    tables = network_tables(answer)
    moved = {"displacement": answer.rest.displacement}
    if answer.contact is not None:
        moved["contact_pressure"] = np.zeros(len(points))
        for one in answer.contact.contacts:
            moved["contact_pressure"][one.points] = one.pressure
    springs = {name: tables["springs"][name].to_numpy() for name in ("kind", "stiffness", "force")}
    springs["length"] = network.distance
    if answer.growth is not None:
        springs["broken"] = np.zeros(len(network.springs))
        springs["broken"][answer.growth.broken] = 1.0
        moved["displacement_broken"] = answer.growth.equilibrium.displacement
    files = {f"{name}.csv": csv_bytes(table) for name, table in tables.items()}
    files["springs.vtu"] = vtu_bytes(points, {"line": network.springs}, moved, springs)
    by_cell = dict(_cell_stress(answer, case))
    if network.volumes is not None:
        by_cell["kappa"] = network.volumes.stiffness
    if by_cell:
        cells = answer.lattice.cells
        shape = SHAPE_OF[points.shape[1], cells.shape[1]]
        files["cells.vtu"] = vtu_bytes(points, {shape: cells}, moved, by_cell)
    return files


def network_tables(answer: SpringAnswer) -> dict[str, pd.DataFrame]:
    """Tables points, springs and, where cells resist a change of volume, cells; a row each, by id.

    Lengths in m, masses in kg, forces in N, stiffness in N/m; of cells, κ, its volume and its
    pressure -κ (V/V0 - 1): N/m, m² and N/m in the plane, Pa, m³ and Pa in space. Of cells under
    pressure before they are loaded, that too, and λ for κ. To first order in the displacement, or
    in full, as the answer is.
    """
    network, u = answer.network, answer.rest.displacement
    axes, volumes = AXES[: network.dim], network.volumes
    by_axis = {"": network.points, "held_": network.fixed.astype(int)}
    by_axis |= {"move_": network.displacement, "force_": network.force, "u": u}
    columns = {
        f"{what}{axis}": values[:, i]
        for what, values in by_axis.items()
        for i, axis in enumerate(axes)
    }
    points = pd.DataFrame(columns)
    points.insert(network.dim, "mass", network.mass)
    i, j = network.springs.T
    springs = {"i": i, "j": j, "kind": answer.lattice.kind, "stiffness": network.stiffness}
    rest_length = network.rest_length * network.law.rests  # 0 of springs that rest at none
    springs |= {"rest_length": rest_length, "force": tension(network, u, answer.geometry)}
    tables = {"points": points, "springs": pd.DataFrame(springs)}
    if volumes is not None:
        cells = {f"p{k}": corner for k, corner in enumerate(volumes.cells.T)}
        if volumes.slope.any():
            cells["initial_pressure"] = -volumes.slope
        cells |= {"kappa": volumes.stiffness, "volume": volumes.rest_volume}
        linear = answer.geometry == "linear"
        grown = dilatation(volumes, u, linear=linear)
        change = volumes.law.change(*volumes.coefficients, grown)
        cells["pressure"] = -(volumes.slope + (volumes.curvature * grown if linear else change))
        tables["cells"] = pd.DataFrame(cells)
    return {name: table.reset_index(names="id") for name, table in tables.items()}


def tension(network: Network, displacement: Array, geometry: str = "linear") -> Array:
    """Tension (m,) in N of each spring, in full or to first order in a displacement (n, d) in m."""
    i, j = network.springs.T
    if geometry == "nonlinear":
        at = Configuration(network, displacement)
        return np.asarray(at.force_density * at.length)
    along = ((displacement[j] - displacement[i]) * network.vector).sum(axis=1) / network.distance
    return np.asarray(network.pull_at_rest * network.distance + network.axial_stiffness * along)


def _cell_stress(answer: SpringAnswer, case: Case) -> Mapping[str, Array]:
    """Stress (c,) in Pa of each cell by component, to first order.

    None where springs run from cell to cell, or displacements are large.
    """
    if case.geometry == "nonlinear":
        return {}
    lattice, problem = answer.lattice, answer.problem
    parts = None
    if problem.zones:
        each = calibrate_zones(problem, lattice, route=case.route)
        parts = spring_shares(problem, lattice, each)
    try:
        stress = cell_stress(
            answer.network, lattice, answer.rest, thickness=problem.material.thickness, parts=parts
        )
    except ProblemError:
        return {}
    pairs = np.array(list(AXES))[np.array(VOIGT[lattice.points.shape[1]])]
    return {f"stress_{a}{b}": part for (a, b), part in zip(pairs, stress.T, strict=True)}
