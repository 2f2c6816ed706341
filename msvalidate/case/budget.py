"""What makes up the difference of springs and elasticity, and the tables that show it."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd

from msvalidate.case.case import MESH_EDGES
from msvalidate.case.comparison import Comparison
from msvalidate.case.springs import SpringAnswer
from msvalidate.constants.stiffness import UNIT
from msvalidate.linear_algebra.norms import max_length
from msvalidate.problem import AXES, Array, ProblemError, SolverError, prescribed_displacements
from msvalidate.statics.equilibrium import equilibrium
from reference_fem.body import nodal_forces
from reference_fem.converged import Reference
from reference_fem.large_strain.by_cell import laws_of
from reference_fem.large_strain.equilibrium import deform
from reference_fem.large_strain.hyperelastic import st_venant_kirchhoff
from reference_fem.large_strain.solid import Solid

LARGE_NODES = 5_000
"""Nodes of the mesh on which large displacements are sought."""

PARTS = {
    "spacing": "what finer lattices take away",
    "support": "that no line of the lattice runs along, as at a curve; finer lattices take it too",
    "boundary": "what stays though the material is right: springs and loads at the sides",
    "material": "the material that the springs are, beside the one asked for",
    "boundary or material": "what stays; the material that the springs are is not known",
}
"""Parts that make up the difference, in words."""


def budget(found: Comparison) -> pd.DataFrame:
    """Parts of the difference where it is largest, along it, over the largest displacement.

    Columns: part, value (1), uncertainty (1), meaning. The first ones add up to the total; what
    stands below it is no part of it: large displacements, which linear answers leave out, and how
    far rest and reference may be off.
    """
    total = found.displacement - found.reference.displacement.value
    at = int(np.linalg.norm(total, axis=1).argmax())
    size, length = found.size or 1.0, float(np.linalg.norm(total[at]))
    along = total[at] / length if length else np.zeros(total.shape[1])

    def part(field: Array) -> float:
        return float(field[at] @ along) / size + 0.0

    target, limit = found.reference.displacement.value, found.limit.displacement
    own = target if found.homogenised is None else found.homogenised.displacement.value
    error, known = found.limit.uncertainty / size, found.reference.error
    rows = []
    if math.isfinite(error):
        values = {"spacing": (part(found.displacement - limit), error)}
        if found.support.any():
            values["spacing"] = (part(found.displacement - limit - found.support), error + known)
            values["support"] = (part(found.support), known)
        if math.isfinite(material_off(found)) or math.isinf(known):
            values["boundary"] = (part(limit - own), error + known)
            values["material"] = (part(own - target), known)
        else:
            values["boundary or material"] = (part(limit - target), error + known)
        rows = [(name, *value, PARTS[name]) for name, value in values.items()]
    rows.append(
        ("total", length / size, found.reference.error, "springs - elasticity, both linear")
    )
    rows.append(("large displacements", *_geometric(found, part)))
    elements = elements_in_full(found)
    if elements is not None:
        said = (
            "elements in full - to first order (St Venant and Kirchhoff's law), beside the springs'"
        )
        rows.append(("the same of elements", part(elements), 0.0, said))
    rows.append(("rest", 0.0, _rest(found), "solver and rounding of the springs"))
    rows.append(("reference", 0.0, found.reference.error, "elasticity's own error"))
    return pd.DataFrame(rows, columns=["part", "value", "uncertainty", "meaning"])


def material_off(found: Comparison) -> float:
    """How far the springs' material may take a displacement off, over the largest; or infinite."""
    case, wanted = found.case, found.reference.displacement.value
    if case.lattice == MESH_EDGES or (case.constants is not None and found.homogenised is None):
        return math.inf
    own = wanted if found.homogenised is None else found.homogenised.displacement.value
    return max_length(own - wanted) / (found.size or 1.0) + found.reference.error


def _rest(found: Comparison) -> float:
    rest = found.springs[0].rest
    return float(rest.error) * float(np.abs(rest.displacement).max()) / (found.size or 1.0)


def _geometric(found: Comparison, part: Callable[[Array], float]) -> tuple[float, float, str]:
    """Springs in full less springs to first order, at the same place and direction."""
    springs = found.springs[0]
    said = "springs in full - springs to first order: what linear answers leave out"
    try:
        full = equilibrium(springs.network, "nonlinear")
    except (ProblemError, SolverError) as error:
        return math.nan, math.nan, f"{said}; not found: {error}"
    moved = SpringAnswer(
        springs.spacing, springs.lattice, springs.network, full, springs.calibration, 0.0
    )
    return part(moved.at(found.points) - found.displacement), 0.0, said


def elements_in_full(found: Comparison) -> Array | None:
    """What elasticity's displacement (p, d) in m at the points changes by where it is large.

    On one mesh, with dead loads as the springs have; None in plane stress, where there is no such
    law here, of nearly incompressible bodies, and where no equilibrium is found.
    """
    problem = found.case.problem
    meshes = [each for each in found.reference.solutions if len(each.body.points) <= LARGE_NODES]
    states = {getattr(law, "state", "") for law in problem.materials}
    if not meshes or meshes[-1].pressure is not None or states - {"plane_strain", "solid"}:
        return None
    linear, law = meshes[-1], problem.material
    held, moved = prescribed_displacements(problem, linear.body.points)
    try:
        whole = laws_of(problem, linear.body, st_venant_kirchhoff)
        solid = Solid(linear.body, whole, held, law.thickness)
        full = deform(solid, moved, nodal_forces(problem, linear.body))
    except (ProblemError, SolverError):
        return None
    return np.asarray(full.at(found.points) - linear.at(found.points))


def tables(found: Comparison) -> dict[str, pd.DataFrame]:
    """Tables of a comparison, by name."""
    rows = pd.DataFrame([vars(row) for row in found.rows])
    return {
        "quantities": rows,
        "constants": _constant_table(found),
        "budget": budget(found),
        "lattices": _lattice_table(found),
        "meshes": pd.DataFrame(mesh_rows(found)),
        "compared": point_table(found.points, found.displacement, found.reference),
    }


def _constant_table(found: Comparison) -> pd.DataFrame:
    """A row a kind of spring, and κ of cells, of each material."""
    rows = []
    for number, each in enumerate(found.advice):
        own = {"material": number}
        rows += [own | vars(kind) | {"unit": "N/m"} for kind in each.kinds]
        if each.volume:
            kappa = {"name": "κ", "along": "", "constant": each.volume, "length": math.nan}
            kappa |= {"formula": each.volume_formula, "unit": UNIT[each.material.dim]}
            rows.append(own | kappa)
    return pd.DataFrame(rows)


def lattice_row(
    found: Comparison, answer: SpringAnswer, points: Array, wanted: Array
) -> dict[str, Any]:
    """A lattice, and its largest difference from elasticity's displacement (p, d) at points."""
    away = answer.at(points) - wanted
    return {
        "spacing": answer.spacing,
        "points": len(answer.lattice.points),
        "springs": len(answer.lattice.springs),
        "difference": max_length(away) / (found.size or 1.0),
        "seconds": answer.seconds,
    }


def _lattice_table(found: Comparison) -> pd.DataFrame:
    """Lattices from coarse to fine, then what they close in on, if that is known."""
    wanted = found.reference.displacement.value
    rows = [lattice_row(found, answer, found.points, wanted) for answer in found.springs]
    if math.isfinite(found.limit.uncertainty):
        left = max_length(found.limit.displacement - wanted) / (found.size or 1.0)
        rows.append({"spacing": 0.0, "difference": left})
    return pd.DataFrame(rows)


def mesh_rows(found: Comparison) -> list[dict[str, Any]]:
    """Meshes of elements from coarse to fine."""
    wanted, size = found.reference.displacement.value, found.size or 1.0
    reference = found.reference
    return [
        {
            "element": solution.body.element.name,
            "nodes": len(solution.body.points),
            "difference": max_length(moved - wanted) / size,
            "seconds": seconds,
        }
        for solution, seconds, moved in zip(
            reference.solutions, reference.seconds, reference.by_mesh, strict=True
        )
    ]


def point_table(points: Array, displacement: Array, reference: Reference) -> pd.DataFrame:
    """Places and displacements of a candidate and of elasticity (m), and their difference (1)."""
    wanted = reference.displacement.value
    axes = AXES[: points.shape[1]]
    away = np.linalg.norm(displacement - wanted, axis=1) / (max_length(wanted) or 1.0)
    columns = dict(zip(axes, points.T, strict=True))
    columns |= {f"u{axis}": u for axis, u in zip(axes, displacement.T, strict=True)}
    columns |= {f"elastic_u{axis}": u for axis, u in zip(axes, wanted.T, strict=True)}
    return pd.DataFrame(columns | {"difference": away})


COLUMNS = {
    "quantity": "what is compared",
    "unit": "of the two sizes",
    "springs": "largest of the springs, or of the result (or root mean square, where said)",
    "elasticity": "the same of converged elasticity",
    "difference": "of springs, or of the result, and elasticity, over elasticity's (1)",
    "uncertainty": "how far it may be off (1)",
    "verdict": "agrees or differs within the band, whatever the uncertainty; else not resolved",
    "part": "of the difference, where it is largest",
    "value": "along the difference there, over the largest displacement (1)",
    "meaning": "what the part is",
    "spacing": "side of the lattice's cells (m); 0 is what the lattices close in on",
    "points": "of the lattice",
    "seconds": "that its answer took",
    "element": "of the mesh: Q2, P2 in the plane, H2, T2 in space are quadratic",
    "nodes": "of the mesh",
    **dict.fromkeys(AXES, "place (m)"),
    **{f"u{axis}": "displacement of the springs, or of the result (m)" for axis in AXES},
    **{f"elastic_u{axis}": "the same of elasticity (m)" for axis in AXES},
    "material": "0, the body's own, or the number of a region",
    "along": "where springs of the kind run",
    "constant": "stiffness of a spring inside the body, or of a cell",
    "length": "of a spring at rest (m)",
    "formula": "in μ, λ (λ′ in plane stress), the thickness t and the spacing h",
    "name": "of the cause",
    "said": "what the field would be",
    "left": "largest difference that it leaves, over elasticity's largest displacement (1)",
}
OWN = {
    "constants": {
        "name": "of the kind of spring, or κ: what resists a cell's change of volume",
    },
    "lattices": {"springs": "of the lattice"},
    "meshes": {"difference": "of this mesh and the finest, over the largest displacement (1)"},
    "causes": {"value": "of what was fitted, if anything was"},
}
"""Table -> columns that hold something else there."""
