"""Comparison of a field with its network: equilibrium and homogenised solid."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import KDTree

from msvalidate.case.advise.identify import Identified, moduli_rows
from msvalidate.case.advise.identify_files import identify_files
from msvalidate.case.judge.judgement import RATIO_NODES, Judged, judge_result
from msvalidate.case.judge.matching import placement_tolerance
from msvalidate.case.judge.results import Result
from msvalidate.linear_algebra.norms import max_length
from msvalidate.problem import (
    Anisotropic,
    Array,
    ProblemError,
    SolverError,
    prescribed_displacements,
)
from msvalidate.problem.records import dataclass, replace
from msvalidate.springs.constants.stiffness import AXES_OF
from msvalidate.springs.network import Network
from msvalidate.springs.statics.equilibrium import equilibrium
from msvalidate_check.causes import Cause
from msvalidate_check.text import percent
from reference_fem.body import solve_problem

CONVERGED = 0.01
"""Largest relative difference of a converged field from its network's equilibrium."""
SENTENCES = {
    "identified": "network: {solid}; elasticity of this solid differs from the case's material by "
    "{solid_difference}",
    "not equilibrium": "the field is not the equilibrium of its network: it differs by "
    "{own_difference}, so the solver has not converged, or solves other equations",
    "equilibrium": "the field is the equilibrium of its network, to {own_difference}",
    "no equilibrium": "the equilibrium of the network is not compared: {reason}",
    "another solid": "the network is another solid than the case's: change its spring constants",
    "same solid": "the network is the case's material inside: a difference is due to spacing, "
    "boundary weights, masses, loads or the solver",
    "unresolved solid": "the bounds of the network's solid, its mean ± {error}, may contain the "
    "case's material: only a larger network decides",
    "cause": "cause in the network itself ({left} left): {cause}",
}
"""Kind -> template of its sentence."""


@dataclass(frozen=True, eq=False)
class OwnNetwork:
    """Network of a field: its homogenised solid and its equilibrium.

    Parameters
    ----------
    identified
        The solid.
    solid_difference
        Largest difference of elasticity of this solid from that of the case's material, relative to
        the largest displacement of the latter; NaN if the network is no solid.
    field_difference
        The same, of the field from elasticity of this solid.
    own_difference
        Largest difference of the field from the network's equilibrium, relative to the largest
        displacement of that; NaN if it is not known.
    reason
        Why the equilibrium is not compared.
    causes
        Causes of the difference of the network's equilibrium from elasticity.
    kinds
        Keys of `SENTENCES`.
    """

    identified: Identified
    solid_difference: float
    field_difference: float
    own_difference: float
    reason: str
    causes: tuple[Cause, ...]
    kinds: tuple[str, ...]


def judge_network(judged: Judged, folder: Path) -> OwnNetwork:
    """Compare a judged field with a network in points.csv and springs.csv.

    Supports and forces are those of the columns held_x, move_x, force_x; without them the case's
    supports serve if it has no loads.

    Raises
    ------
    ProblemError
        If a file is not there or is wrong, the network has other axes than the case, or the case
        has obstacles or large displacements.
    """
    case = judged.case
    if case.problem.contacts or case.geometry == "nonlinear":
        raise ProblemError(
            "--network: networks are compared to first order and without obstacles; leave it out"
        )
    identified = identify_files(folder / "springs.csv")
    network = identified.network
    dim = case.problem.domain.dim
    if network is None or AXES_OF[len(identified.tensor)] != dim:
        raise ProblemError(f"--network: points.csv is not of the case's {dim} axes; give its own")
    causes, reason = judged.verdict.causes, ""
    kinds, solid, field, own = ["identified"], math.nan, math.nan, math.nan
    try:
        at_rest = _equilibrium(judged, network)
        own = _difference(judged, network.points, at_rest)
        kinds.append("equilibrium" if own <= CONVERGED else "not equilibrium")
        if own > CONVERGED:
            result = Result("network", at_rest, network.points, None, 0.0)
            causes = judge_result(case, result).verdict.causes
    except (ProblemError, SolverError) as error:
        reason = str(error)
        kinds.append("no equilibrium")
    if identified.solid:
        u = _elasticity(judged, identified.tensor)
        solid = max_length(u - judged.reference.displacement.value) / judged.size
        field = max_length(judged.matched.displacement - u) / judged.size
        near = "same solid" if identified.error <= case.band else "unresolved solid"
        kinds.append(near if solid <= case.band + identified.error else "another solid")
    return OwnNetwork(identified, solid, field, own, reason, causes, tuple(kinds))


def _elasticity(judged: Judged, tensor: Array) -> Array:
    """Elasticity of a tensor (N/m or Pa) at the compared points (m, d) in m.

    It is the case's elasticity and the change on a coarser mesh.
    """
    problem, reference, places = judged.case.problem, judged.reference, judged.matched.places
    thickness = problem.material.thickness
    law = Anisotropic(tensor / thickness, problem.material.density, thickness)
    plain = reference.solutions_up_to(RATIO_NODES)[-1]
    other = solve_problem(replace(problem, material=law, zones=()), plain.body)
    return np.asarray(reference.displacement.value + other.at(places) - plain.at(places))


def _equilibrium(judged: Judged, network: Network) -> Array:
    """Displacement (n, d) in m of a network under the supports and loads of its file or the case.

    Raises `ProblemError` if loads are not known.
    """
    problem = judged.case.problem
    if problem.loads and not network.force.any():
        raise ProblemError("points.csv has no force_x ..: add the forces of the case in N")
    if not network.fixed.any():
        fixed, value = prescribed_displacements(problem, network.points)
        network = replace(network, fixed=fixed, displacement=value)
    return equilibrium(network).displacement


def _difference(judged: Judged, points: Array, displacement: Array) -> float:
    """Largest difference of the field from displacements at points, relative to their largest.

    Raises `ProblemError` if no compared point is one of the points.
    """
    distance, number = KDTree(points).query(judged.matched.places)
    near = distance <= placement_tolerance(judged.case)
    if not near.any():
        raise ProblemError("no point of the field is a point of the network; give its own points")
    away = judged.matched.displacement[near] - displacement[number[near]]
    return max_length(away) / max_length(displacement)


def network_record(judged: OwnNetwork) -> dict[str, Any]:
    """Numbers, kinds, causes and sentences for verdict.json."""
    found = judged.identified
    record: dict[str, Any] = {n: x for n, x in vars(judged).items() if n.endswith("difference")}
    record |= {"error": found.error}
    shown = {name: percent(value) for name, value in record.items()}
    rows = dict(moduli_rows(found)) if found.solid else {}
    solid = next((f"{name} {text}" for name, text in rows.items() if "otropic" in name), "")
    shown |= {"solid": solid or found.stable, "reason": judged.reason}
    lines = [SENTENCES[kind].format(**shown) for kind in judged.kinds]
    for first in judged.causes[: "not equilibrium" in judged.kinds]:
        lines.append(SENTENCES["cause"].format(left=percent(first.left), cause=first))
    return record | {
        "tensor": found.tensor.tolist(),
        "solid": rows,
        "kinds": judged.kinds,
        "causes": [each.row() for each in judged.causes],
        "sentences": lines,
    }
