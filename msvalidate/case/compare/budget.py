"""Contributions to the difference of springs from elasticity, and their tables."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd

from msvalidate.case.compare.comparison import Comparison
from msvalidate.case.compare.quantities import difference_row
from msvalidate.case.file.case import LAWS
from msvalidate.case.file.fracture import break_table
from msvalidate.case.springs.lattice_springs import SpringAnswer
from msvalidate.linear_algebra.norms import max_abs, max_length
from msvalidate.problem import AXES, Array
from msvalidate.springs.constants.stiffness import UNIT
from reference_fem.converged import Reference

PARTS = {
    "spacing": "what finer lattices take away",
    "support": "that no line of the lattice runs along, as at a curve; finer lattices take it too",
    "boundary": "what stays though the material is right: springs and loads at the sides",
    "boundary or law": "what stays; the law that the springs are at finite strain is not known",
    "material": "the material that the springs are, beside the one asked for",
    "boundary or material": "what stays; the material that the springs are is not known",
}
"""Contributions to the difference, in words."""


def budget(found: Comparison) -> pd.DataFrame:
    """Contributions to the largest difference, relative to the largest displacement.

    They are components along that difference, at its point.

    Columns: part, value (1), uncertainty (1), meaning. The first ones add up to the total, the law
    at finite strain among them where the case is nonlinear; what stands below it is no part of it:
    what linear answers leave out, and how far rest and reference may be off.
    """
    total = found.displacement - found.reference.displacement.value
    at = int(np.linalg.norm(total, axis=1).argmax())
    size, length = found.size, float(np.linalg.norm(total[at]))
    along = total[at] / (length or 1.0)

    def part(field: Array) -> float:
        return float(field[at] @ along) / size + 0.0

    limit, large = found.limit.displacement, found.nonlinear
    (change, springs), (linear_reference, law) = (
        (large.target, large.springs),
        _large_rows(found, part),
    )
    target, own = found.first_order, found.own_material
    error, known = found.limit.uncertainty / size, found.reference.error
    nonlinear = found.case.geometry == "nonlinear"
    stays, full = "boundary", own
    if nonlinear and change is not None:
        stays = "boundary" if springs else "boundary or law"
        full = own + (springs or change)[0]
    rows = []
    if math.isfinite(error):
        values = {"spacing": (part(found.displacement - limit), error)}
        if found.support.any():
            values["spacing"] = (part(found.displacement - limit - found.support), error + known)
            values["support"] = (part(found.support), known)
        if math.isfinite(found.material_off) or math.isinf(known):
            values[stays] = (part(limit - full), error + known)
            values["material"] = (part(own - target), known)
        else:
            values["boundary or material"] = (part(limit - full + own - target), error + known)
        rows = [(name, *value, PARTS[name]) for name, value in values.items()]
        rows += [law] if nonlinear and springs else []
    rows.append(
        ("total", length / size, known, f"springs - elasticity, both {found.case.geometry}")
    )
    rows += [linear_reference] if nonlinear else [linear_reference, law]
    rest = found.springs[0].rest
    moving = float(rest.error) * max_abs(rest.displacement) / size
    rows.append(("rest", 0.0, moving, "solver and rounding of the springs"))
    rows.append(("reference", 0.0, found.reference.error, "elasticity's own error"))
    return pd.DataFrame(rows, columns=["part", "value", "uncertainty", "meaning"])


def _large_rows(
    found: Comparison, part: Callable[[Array], float]
) -> list[tuple[str, float, float, str]]:
    """Rows "linear reference" and "law"."""
    size, large, law = found.size, found.nonlinear, LAWS[found.case.law]
    why = f"; none: {large.why}" if large.why else ""
    (target, off), (own, own_off) = (
        (math.nan, math.nan) if each is None else (part(each[0]), each[1] / size)
        for each in (large.target, large.springs)
    )
    said = f"elements in full - to first order, of {law} law: what linear elasticity leaves out"
    beside = f"springs' law at finite strain, homogenised, beside {law}, beyond the linear part"
    return [
        ("linear reference", target, off, said + why * math.isnan(target)),
        ("law", own - target, off + own_off, beside + why),
    ]


def tables(found: Comparison) -> dict[str, pd.DataFrame]:
    """Tables of a comparison, by name."""
    rows = pd.DataFrame([difference_row(row) for row in found.rows])
    return (
        {
            "quantities": rows,
            "constants": _constant_table(found),
            "budget": budget(found),
            "lattices": _lattice_table(found),
            "meshes": pd.DataFrame(mesh_rows(found)),
            "compared": point_table(found.points, found.displacement, found.reference),
        }
        | ({"mesh_springs": found.on_mesh.table} if found.on_mesh else {})
        | contact_table(found)
        | break_table(found.springs[0].growth)
    )


def contact_table(found: Comparison) -> dict[str, pd.DataFrame]:
    """Places that may touch (m), force (N), gap (m) and pressure (Pa) of springs, if any may."""
    answer = found.springs[0]
    if answer.contact is None:
        return {}
    (one,) = answer.contact.contacts
    at = answer.lattice.points[one.points]
    columns = dict(zip(AXES, at.T, strict=False))
    columns |= {"force": one.force, "gap": one.gap, "pressure": one.pressure}
    return {"contact": pd.DataFrame(columns)}


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
        "difference": max_length(away) / found.size,
        "seconds": answer.seconds,
    }


def _lattice_table(found: Comparison) -> pd.DataFrame:
    """Lattices from coarse to fine, then what they close in on, if that is known."""
    wanted = found.reference.displacement.value
    rows = [lattice_row(found, answer, found.points, wanted) for answer in found.springs]
    if math.isfinite(found.limit.uncertainty):
        left = max_length(found.limit.displacement - wanted) / found.size
        rows.append({"spacing": 0.0, "difference": left})
    return pd.DataFrame(rows)


def mesh_rows(found: Comparison) -> list[dict[str, Any]]:
    """Meshes of elements from coarse to fine."""
    wanted, size = found.reference.displacement.value, found.size
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
