"""Controls: faulty solvers, and the smallest fault of each kind that this study notices.

Question   Which faults of charges and forces make a tolerance fail, and how small may they be?
Candidate  The method of moments with a known fault.
Reference  The tolerances of `strips`, `edge`, `plates`, `virtual_work`, `in_air`, `field`,
           `models`, `shortcuts` and `nodes`.
Expected   What a fault changes grows in proportion to it, so the smallest fault noticed is a limit
           over what a small fault changes: some 1e-7 of forces, 5e-3 of potentials.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from msvalidate import kit
from msvalidate.dielectric.charges import Charges, Electrodes
from msvalidate.dielectric.charges.moments import Weighting
from msvalidate.dielectric.charges.patches import Patches
from msvalidate.dielectric.charges.report_model import ReportModel
from msvalidate.dielectric.kernels import charges as integrals

from . import strips, virtual_work
from .common import MOMENTS, VOLTAGES, ChargeSolver
from .shortcuts import halve_to_ends

PROBE = 0.01
"""Size of the fault from which the smallest noticed one is extrapolated."""
RULES = (
    kit.Rule(
        "smallest fault of charges and forces noticed, largest over the kinds", 0.01, "1",
        "capacitances are held to 1e-4 and a fault enters them with a lever of a tenth or more; a "
        "hundredth leaves a factor of ten",
        table="resolution", value="smallest_noticed",
    ),
)  # fmt: skip


def perturb_potentials(
    size: float,
    electrodes: Electrodes,
    voltages: Any = VOLTAGES,
    *,
    permittivity: float = 1.0,
    weighting: Weighting = "galerkin",
    neutral: bool = True,
) -> Charges:
    """Charges whose own potential is wrong by the part `size`; without neutrality if so asked."""
    right = MOMENTS.charges(electrodes, voltages, permittivity=permittivity, weighting=weighting)
    start, along = electrodes.lines
    mean = (
        integrals.means(start, along)
        if weighting == "galerkin"
        else integrals.seen(start + along / 2, start, along)
    )
    m = len(mean)
    # The part of an average segment's own distance, so that no unit of length comes in.
    mean[np.diag_indices(m)] += size * 1.5
    P = mean / (-2 * np.pi * permittivity)
    V = np.asarray(voltages)[electrodes.electrode]
    if not neutral:
        return replace(right, charge=np.linalg.solve(P, V))
    whole = np.ones((m + 1, m + 1))
    whole[:m, :m], whole[m, m] = P, 0.0
    solved = np.linalg.solve(whole, np.append(V, 0.0))
    return replace(right, charge=solved[:-1], floating=float(solved[-1]))


def drop_edge_forces(
    size: float, electrodes: Electrodes, voltages: Any = VOLTAGES, **how: Any
) -> Charges:
    """Charges without the part `size` of that on the first segment of every electrode."""
    right = MOMENTS.charges(electrodes, voltages, **how)
    first = np.unique(electrodes.electrode, return_index=True)[1]
    left = right.charge.copy()
    left[first] *= 1 - size
    return replace(right, charge=left)


def collocate_middles(charges: Charges) -> kit.Array:
    """Coulomb's law between middles of segments, half to each end."""
    electrodes = charges.moments.electrodes
    apart = electrodes.middle[:, None] - electrodes.middle
    square = (apart**2).sum(axis=2)
    np.fill_diagonal(square, np.inf)
    pair = np.outer(charges.charge, charges.charge) / square
    pulled = (pair[:, :, None] * apart).sum(axis=1) / (2 * np.pi * charges.moments.permittivity)
    total = np.zeros_like(electrodes.points)
    for end in electrodes.segments.T:
        np.add.at(total, end, 0.5 * pulled)
    return total


def interpolate_forces(
    size: float, faulty: Callable[[Charges], kit.Array], charges: Charges
) -> kit.Array:
    """Forces that are the part `size` of a faulty way's, and right for the rest."""
    return (1 - size) * MOMENTS.forces(charges) + size * faulty(charges)


def with_forces(faulty: Callable[[Charges], kit.Array], size: float) -> ChargeSolver:
    """The method of moments with forces that are partly a faulty way's."""
    return MOMENTS._replace(forces=partial(interpolate_forces, size, faulty))


def without_permittivity(charges: Charges) -> kit.Array:
    """Forces of the same charges in empty space."""
    return MOMENTS.forces(charges) * charges.moments.permittivity


def shift_forces(charges: Charges) -> kit.Array:
    """The tangent with the rows of the first electrode twice as large."""
    tangent = MOMENTS.tangent(charges).copy()
    tangent[: 2 * len(tangent) // 4] *= 2
    return tangent


def plates_with(size: float, patches: Patches) -> float:
    """Capacitance by potentials that are too large by the part `size`."""
    return MOMENTS.plates(patches) / (1 + size)


def other_ratio(size: float, faces: Any, *, ratio: float, **options: float) -> Any:
    """A slab in air with the part `size` of its bound charge left out, by its ratio."""
    return MOMENTS.in_air(faces, ratio=ratio - size * (ratio - 1), **options)


def other_depth(size: float, electrodes: Electrodes, *, depth: float = 1.0, **how: Any) -> Any:
    """The report's model with rectangles less deep by the part `size`."""
    return MOMENTS.report(electrodes, depth=(1 - size) * depth, **how)


def collocation(electrodes: Electrodes, voltages: Any = VOLTAGES, **how: Any) -> Charges:
    """Collocation's charges whatever is asked for."""
    return MOMENTS.charges(electrodes, voltages, **{**how, "weighting": "collocation"})


def galerkins_tangent(charges: Charges) -> kit.Array:
    """That of Galerkin's charges whatever charges are given: collocation's have none."""
    moments = charges.moments
    meant = MOMENTS.charges(moments.electrodes, charges.voltages, permittivity=moments.permittivity)
    return MOMENTS.tangent(meant)


class OfPoints(Charges):
    """Charges whose field is that of line charges in the middles of their segments."""

    def field(self, points: ArrayLike) -> kit.Array:
        """Field (n, 2) in V/m at points (n, 2) in m, nothing from a charge at the point itself."""
        apart = np.asarray(points)[:, None] - self.moments.electrodes.middle
        square = (apart**2).sum(axis=2)
        square[square == 0] = np.inf
        pulled = (self.charge / square)[..., None] * apart
        field: kit.Array = pulled.sum(axis=1) / (2 * np.pi * self.moments.permittivity)
        return field


def of_points(electrodes: Electrodes, voltages: Any = VOLTAGES, **how: Any) -> Charges:
    """The right charges, seen as points."""
    right = MOMENTS.charges(electrodes, voltages, **how)
    return OfPoints(right.moments, right.voltages, right.charge, right.floating, right.error)


class TakenForSymmetric(ReportModel):
    """The report's model whose equations, which are not symmetric, serve as their own transpose."""

    def solve(self, potential: kit.Array, *, adjoint: bool = False) -> kit.Array:
        """Charges (k, ...) in C/m at potentials of their seats (V), whether transposed or not."""
        del adjoint  # the fault
        return super().solve(potential)


def use_space_kernel(electrodes: Electrodes, **how: Any) -> ReportModel:
    """The report's model with the kernel of space whatever is asked for."""
    return MOMENTS.report(electrodes, **{**how, "kernel": "report"})


FAULTY: dict[str, tuple[str, dict[str, Any]]] = {
    "charges that need not add up to nothing": (
        "strips", {"charges": partial(perturb_potentials, 0.0, neutral=False)},
    ),
    "a segment's own potential 1 % off": ("strips", {"charges": partial(perturb_potentials, 0.01)}),
    "half of the charge lost at the first segment of an electrode": (
        "edge", {"charges": partial(drop_edge_forces, 0.5)},
    ),
    "potentials of patches 0.1 % too large": ("plates", {"plates": partial(plates_with, 1e-3)}),
    "Coulomb's law between middles": ("virtual_work", {"forces": collocate_middles}),
    "half of a segment's force to each end": ("virtual_work", {"forces": halve_to_ends}),
    "permittivity forgotten in the field": ("virtual_work", {"forces": without_permittivity}),
    "tangent of one electrode doubled": ("virtual_work", {"tangent": shift_forces}),
    "collocation in Galerkin's place": (
        "virtual_work", {"charges": collocation, "tangent": galerkins_tangent},
    ),
    "no bound charge on bare faces": ("in_air", {"in_air": partial(other_ratio, 1.0)}),
    "a tenth of the permittivity's jump missing": ("field", {"in_air": partial(other_ratio, 0.1)}),
    "rectangles 1 % less deep": ("models", {"report": partial(other_depth, 0.01)}),
    "half of the charge lost at edges, on both faces": (
        "shortcuts", {"charges": partial(drop_edge_forces, 0.5)},
    ),
    "segments seen as points": ("shortcuts", {"charges": of_points}),
    "halves along half a strip": ("shortcuts", {"forces": halve_to_ends}),
    "the kernel of space in the plane's place": ("nodes", {"report": use_space_kernel}),
    "equations taken for symmetric": ("nodes", {"report": TakenForSymmetric}),
}  # fmt: skip
"""Fault -> the question that notices it, and what of the solver has it."""
FAULTS: dict[str, dict[str, Any]] = {
    name: {"candidate": MOMENTS._replace(**fault), "questions": (question,)}
    for name, (question, fault) in FAULTY.items()
}
"""Negative controls: arguments of `run` under which a tolerance must fail. One question that
notices is enough, so the rest is left out."""

CAPACITANCE = strips.RULES[0]
DERIVATIVE = virtual_work.RULES[0]
RATIO, SEGMENTS = 6.0, 160
WAVY = ("wavy", "galerkin", 8)


def capacitance_error(solver: ChargeSolver) -> float:
    """Of facing strips, over its tolerance."""
    row = strips.strip_rows(solver, (RATIO, "cosine", "galerkin", SEGMENTS))
    return float(str(row["capacitance_error"])) / CAPACITANCE.limit


def force_error(solver: ChargeSolver) -> float:
    """Of wavy electrodes, over its tolerance."""
    row = virtual_work.compare_with_energy(solver, WAVY)
    return float(str(row["force_error"])) / DERIVATIVE.limit


KINDS: dict[str, tuple[Callable[[float], ChargeSolver], Callable[[ChargeSolver], float], str]] = {
    "own potential of segments": (
        lambda size: MOMENTS._replace(charges=partial(perturb_potentials, size)),
        capacitance_error,
        CAPACITANCE.quantity,
    ),
    **{
        name: (partial(with_forces, way), force_error, DERIVATIVE.quantity)
        for name, way in (
            ("Coulomb's law between middles", collocate_middles),
            ("halves of a segment's force to its ends", halve_to_ends),
            ("permittivity forgotten in the field", without_permittivity),
        )
    },
}
"""Fault -> the solver that has it in some size, what notices it over its limit, and in words."""


def run() -> kit.Evidence:
    """State the smallest fault of each kind that the study notices."""
    table = pd.DataFrame([smallest(kind) for kind in KINDS])
    said = ", ".join(f"{row.fault} by {row.smallest_noticed:.1g}" for row in table.itertuples())
    return kit.Evidence(
        tables={"resolution": table},
        tolerances=RULES,
        columns=kit.columns(__file__),
        findings=(f"Smallest faults that this study notices, as parts: {said}.",),
    )


def smallest(kind: str) -> dict[str, object]:
    """The smallest size that fails its tolerance, by a straight line from none to `PROBE`."""
    faulty, error, quantity = KINDS[kind]
    none, some = error(MOMENTS), error(faulty(PROBE))
    left = 1 - none if some > none else 1 + none
    return {
        "fault": kind,
        "smallest_noticed": PROBE * left / abs(some - none),
        "noticed_by": quantity,
    }
