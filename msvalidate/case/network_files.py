"""The springs of a case as files for other programs: tables that rebuild the network, and fields.

`points.csv`, `springs.csv` and `cells.csv` are the network as it was solved, in SI units, with all
digits; `springs.vtu` and `cells.vtu` show it at rest. docs/cases.md says what each column holds.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd

from msvalidate.case.case import Case
from msvalidate.case.springs import SpringAnswer
from msvalidate.constants.zones import calibrate_zones, spring_shares
from msvalidate.network import Network
from msvalidate.network.laws.volumes import dilatation
from msvalidate.output.stored import csv_bytes
from msvalidate.output.vtu import vtu_bytes
from msvalidate.problem import AXES, SHAPES, VOIGT, Array, ProblemError
from msvalidate.statics.stress import cell_stress

SHAPE_OF = {(shape.dim, len(shape.nodes)): shape.name for shape in SHAPES.values()}
"""Axes and corners of cells -> their shape's name, which is meshio's."""


def network_files(answer: SpringAnswer, case: Case) -> dict[str, bytes]:
    """Tables and fields of a case's springs at rest: name -> content.

    cells.csv is there where cells resist a change of volume, cells.vtu where they have a stress or
    resist. Nothing in them is NaN.

    Parameters
    ----------
    answer, case
        Springs at rest, and the case that they are of.
    """
    points, network = answer.lattice.points, answer.network
    tables = network_tables(answer)
    moved = {"displacement": answer.rest.displacement}
    springs = {name: tables["springs"][name].to_numpy() for name in ("kind", "stiffness", "force")}
    springs["length"] = network.distance
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
    pressure -κ (V/V0 - 1): N/m, m² and N/m in the plane, Pa, m³ and Pa in space. To first order in
    the displacement, as the answer is.
    """
    network, u = answer.network, answer.rest.displacement
    axes, volumes = AXES[: network.dim], network.volumes
    by_axis = {"": network.points, "held_": network.held.astype(int)}
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
    springs |= {"rest_length": network.rest_length, "force": tension(network, u)}
    tables = {"points": points, "springs": pd.DataFrame(springs)}
    if volumes is not None:
        cells = {f"p{k}": corner for k, corner in enumerate(volumes.cells.T)}
        cells |= {"kappa": volumes.stiffness, "volume": volumes.rest_volume}
        cells["pressure"] = -volumes.stiffness * dilatation(volumes, u, linear=True)
        tables["cells"] = pd.DataFrame(cells)
    return {name: table.reset_index(names="id") for name, table in tables.items()}


def tension(network: Network, displacement: Array) -> Array:
    """Tension (m,) in N of each spring, to first order in a displacement (n, d) in m."""
    i, j = network.springs.T
    along = ((displacement[j] - displacement[i]) * network.vector).sum(axis=1) / network.distance
    return np.asarray(network.stiffness * (network.beyond_rest + along))


def _cell_stress(answer: SpringAnswer, case: Case) -> Mapping[str, Array]:
    """Stress (c,) in Pa of each cell by component; none where springs run from cell to cell."""
    lattice, problem = answer.lattice, case.problem
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
