"""Solids: which elastic solid is every lattice?

Question   The stiffness tensor of every lattice under each of its rules, its modulus, ratio and
           anisotropy, whether it is isotropic, and its highest frequency.
Candidate  The homogenised solid: of a cell repeated along every axis, its points at rest.
Reference  The closed form, the affine sum over the neighbours; Zener's ratio and the frequency on
           paper; and a third route that knows no stiffness matrix: the energy of one strained cell,
           the springs' lengths taken as they are, its points moved to where it is least, and
           differenced twice.
Expected   Equal. Where every point is a centre of symmetry, points held to the affine motion are at
           rest: the bound is reached. Elsewhere (honeycomb) they move, and give way to Poisson's
           ratios that central springs are said not to have. A repeated cell may find floppy
           motions, where lattices have too few springs, and nothing else.
"""

from __future__ import annotations

import math
from functools import partial
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.optimize import minimize

from msvalidate.constants.stiffness import (
    ALIKE,
    CAUCHY,
    cubic_part,
    is_same_tensor,
    isotropic_part,
    moduli,
)
from msvalidate.constants.waves import highest_frequency
from msvalidate.judging.compare import farthest_value
from msvalidate.judging.evidence import Evidence, Observed, Tolerance, by_quantity
from msvalidate.judging.sweep import Setting
from msvalidate.lattice import Constants, Pattern, repeat_cell
from msvalidate.problem import VOIGT, Array, ProblemError

from . import cases, loading, surfaces, theory
from .cases import Case, Solid

REPEATED = {2: 3, 3: 2}
"""Cells along each axis of the repeated cell, by the number of axes."""
NUDGE = 1e-4
"""Strain of the differences: what they leave out is of order 1e-8, what rounding does, of 1e-12."""
FORCE_LEFT = 1e-6
"""On a point of a strained cell, per spring constant and nudge; its square is left of energy."""
TOLERANCES = (
    Tolerance(
        "tensor against its closed form, relative", 1e-10, "1",
        "the same sum over springs, less what points release: none in these; left is rounding, "
        "and what the solution for the points makes of it",
    ),
    Tolerance(
        "tensor above the affine bound, relative", 1e-10, "1",
        "the affine motion is one of those among which the energy is least; left is rounding",
    ),
    Tolerance(
        "tensor against differences of energy, relative", 1e-6, "1",
        "fourth derivatives of the energy times the nudge squared, 1e-8 times numbers up to 10",
    ),
    Tolerance(
        "Zener's ratio against theory", 1e-10, "1",
        "a quotient of sums of a few terms: rounding",
    ),
    Tolerance(
        "lattices isotropic, or not, against theory", 0, "1",
        "Zener's ratio on paper is 1, or not",
    ),
    Tolerance(
        "Poisson's ratio of isotropic lattices against Cauchy's", 1e-10, "1",
        "central springs between points that follow the strain: C12 = C44, so isotropic means 1/3 "
        "in the plane and 1/4 in space",
    ),
    Tolerance(
        "highest frequency squared against theory, relative", 1e-10, "1",
        "the wave that theory names is one of those tried; left is rounding of an eigenvalue",
    ),
)  # fmt: skip
COLUMNS = {
    **cases.COLUMNS,
    "E": "modulus along x (N/m in the plane, Pa in space, at a spacing of 1 m)",
    "nu": 'Poisson\'s ratio along x, "none" where the solid gives way (1)',
    "A": 'Zener\'s ratio 2·C44/(C11 - C12) of a square or cubic tensor, "none" where the solid is '
    "neither or gives way (1)",
    "A_theory": 'the same on paper, or "none"',
    "isotropic": "whether the modulus is the same in every direction",
    "closed_form_error": "largest entry of tensor - closed form over the largest of the tensor, or "
    '"none" (1)',
    "energy_error": "the same of the tensor by differences of the energy, or "
    '"none" where the solid gives way (1)',
    "released": "the same of the affine bound: what the points release when let go (1)",
    "floppy": "motions of the repeated cell without stiffness, or "
    '"none" in a cell too large to count them',
    "springs_a_point": "springs with stiffness that meet at a point",
    "omega2_m": "highest frequency squared times the mass of a point (N/m)",
    "omega2_m_theory": 'the same on paper (N/m), or "none"',
    "row": "Voigt component of stress: xx, yy, xy, or xx, yy, zz, yz, xz, xy",
    "column": "Voigt component of strain",
    "closed_form": 'entry of the tensor in closed form (N/m or Pa at a spacing of 1 m), or "none"',
    "numerical": "entry of the tensor of the repeated cell, points at rest (N/m or Pa)",
    "affine": "entry of the affine bound (N/m or Pa)",
}


class Found(NamedTuple):
    """Rows of the tables `solids` and `tensors` of one case, and what is judged of them alone."""

    solid: dict[str, object]
    entries: list[dict[str, object]]
    above_bound: float


def run(tables: dict[str, pd.DataFrame], above_bound: float) -> Evidence:
    """Judge the tensors, their constants and frequencies."""
    solid = tables["solids"]
    drawn = set(solid["axes"][solid["strains"] == "every strain"])
    return Evidence(
        tables=tables,
        observed=by_quantity(TOLERANCES, observe(solid, above_bound)),
        tolerances=TOLERANCES,
        figures={name: draw for axes, (name, draw) in surfaces.FIGURES.items() if axes in drawn},
        columns=COLUMNS,
        findings=findings(solid),
        rounding={"closed_form_error": 1e-12, "energy_error": 1e-6, "released": 1e-12}
        | dict.fromkeys(("numerical", "affine", "closed_form", "A", "nu"), 1e-12),
    )


def solid_tables(solid: Solid, setting: Setting) -> tuple[dict[str, pd.DataFrame], float]:
    """The tables `solids` and `tensors`, and how far a tensor is above its bound, relative."""
    all_found = setting.sweep(partial(measure, solid), cases.all_cases(), "solids")
    tables = {
        "solids": pd.DataFrame([one.solid for one in all_found]),
        "tensors": pd.DataFrame([row for one in all_found for row in one.entries]),
    }
    return tables, max(one.above_bound for one in all_found)


def measure(solid: Solid, case: Case) -> Found:
    """One lattice under one rule."""
    pattern, k = case.pattern, case.constants
    cell = repeat_cell(pattern, REPEATED[pattern.dim])
    numerical = solid(cell, k, 1.0)
    C, affine = numerical.tensor, numerical.affine
    closed = pattern.tensor(k) if pattern.tensor else None
    largest = float(np.abs(affine).max())
    strains = cases.resists_shear(C)
    row = case.head | {
        "k": ", ".join(f"{value:.4g}" for value in k),
        "axes": pattern.dim,
        "strains": strains,
        "body": cases.body(solid, case),
        **dict(zip(("E", "nu", "A"), constants(C, strains), strict=True)),
        "A_theory": theory.zener(pattern.name, k),
        "isotropic": "yes" if is_isotropic(C) else "no",
        "closed_form_error": "none" if closed is None else difference(C, closed, largest),
        "energy_error": "none"
        if strains == "gives way"  # under compression its points fold away from the strain
        else difference(C, by_energy(pattern, k), largest),
        "released": difference(affine, C, largest),
        "floppy": "none" if numerical.floppy is None else numerical.floppy,
        "springs_a_point": cases.springs_a_point(case),
        "omega2_m": highest_frequency(pattern, k),
        "omega2_m_theory": theory.frequency(pattern.name, k),
    }
    above = float(-np.linalg.eigvalsh(affine - C)[0] / largest)
    return Found(row, entries(case, C, affine, closed), above)


def difference(found: Array, reference: Array, largest: float) -> float:
    """Largest entry of the difference, relative."""
    return float(np.abs(found - reference).max() / largest)


def constants(C: Array, strains: str) -> tuple[float | str, float | str, float | str]:
    """E (unit of the tensor), nu and A along the axes; words where a pull finds no resistance."""
    if strains == "every strain":
        S = loading.compliances(C)
        E, nu, zener = from_compliance(S[0, 0], S[1, 0], S[-1, -1])
        return E, nu, zener if is_cubic(C) else "none"
    if strains == "gives way":
        return 0.0, "none", "none"
    found = moduli(C)
    return found.E, found.nu, found.zener if is_cubic(C) else "none"


def from_compliance(pulled: float, across: float, sheared: float) -> tuple[float, float, float]:
    """E, nu and A from strains per stress: along a pull, across it, and of shear."""
    return 1 / pulled, -across / pulled, 2 * (pulled - across) / sheared


def is_cubic(C: Array) -> bool:
    """Whether a tensor is that of a square or cubic lattice along the axes: three constants."""
    return is_same_tensor(C, cubic_part(C))


def is_isotropic(C: Array) -> bool:
    """Whether a tensor is the isotropic one nearest to it."""
    try:
        return is_same_tensor(C, isotropic_part(C))
    except ProblemError:  # some strain costs no energy
        return False


def entries(case: Case, C: Array, affine: Array, closed: Array | None) -> list[dict[str, object]]:
    """Rows of the table `tensors`: the entries on and above the diagonal that are not zero."""
    axes = [f"{'xyz'[a]}{'xyz'[b]}" for a, b in VOIGT[case.pattern.dim]]
    rows = []
    for i, j in zip(*np.triu_indices(len(C)), strict=True):
        if np.abs(affine[i, j]) > cases.STIFF * np.abs(affine).max():
            entry = "none" if closed is None else float(closed[i, j])
            row: dict[str, object] = {"row": axes[i], "column": axes[j], "closed_form": entry}
            rows.append(case.head | row | {"numerical": C[i, j], "affine": affine[i, j]})
    return rows


def by_energy(pattern: Pattern, k: Constants) -> Array:
    """Voigt tensor of one cell, spacing 1 m, by differences of its least energy."""
    size = len(VOIGT[pattern.dim])
    C = np.zeros((size, size))
    unit = NUDGE * np.eye(size)

    def both(strain: Array) -> float:
        return least_energy(pattern, k, strain) + least_energy(pattern, k, -strain)

    alone = [both(strain) for strain in unit]
    for i, j in zip(*np.triu_indices(size), strict=True):
        together = both(unit[i] + unit[j])
        C[i, j] = C[j, i] = (together - alone[i] - alone[j]) / (2 * NUDGE**2)
    return C


def least_energy(pattern: Pattern, k: Constants, strain: Array) -> float:
    """Least energy (J) per area or volume of a cell under a Voigt strain, lengths taken exactly."""
    d, n = pattern.dim, len(pattern.points)
    turn = np.eye(d)
    for (a, b), value in zip(VOIGT[d], strain, strict=True):
        turn[a, b] += value if a == b else value / 2
        turn[b, a] += 0 if a == b else value / 2
    i, j = pattern.springs.T
    vectors, stiffness = pattern.vectors, pattern.stiffness(k)
    rest, affine = np.linalg.norm(vectors, axis=1), vectors @ turn

    def energy(moved: Array) -> tuple[float, Array]:
        u = np.concatenate([np.zeros((1, d)), moved.reshape(n - 1, d)])
        now = affine + u[j] - u[i]
        length = np.linalg.norm(now, axis=1)
        pull = (stiffness * (length - rest) / length)[:, None] * now
        force = np.zeros((n, d))
        np.add.at(force, j, pull)
        np.add.at(force, i, -pull)
        return float(0.5 * stiffness @ (length - rest) ** 2), force[1:].ravel()

    def scaled(moved: Array) -> tuple[float, Array]:
        value, slope = energy(NUDGE * moved)
        return value / NUDGE**2, slope / NUDGE

    least = energy(np.zeros((n - 1) * d))[0]
    if n > 1:
        start = np.zeros((n - 1) * d)
        found = minimize(scaled, start, jac=True, method="BFGS", options={"gtol": FORCE_LEFT})
        least = min(least, float(found.fun) * NUDGE**2)
    return least / float(np.prod(pattern.size))


def observe(solid: pd.DataFrame, above_bound: float) -> list[Observed]:
    """What the tolerances judge, in their order."""
    known = solid[solid["A_theory"] != "none"]
    isotropic = known["isotropic"] == "yes"
    on_paper = (known["A_theory"].astype(float) - 1).abs() < ALIKE
    cauchy = solid[(solid["isotropic"] == "yes") & (solid["released"] < ALIKE)]
    waves = solid[solid["omega2_m_theory"] != "none"]
    closed, energy = solid["closed_form_error"], solid["energy_error"]
    return [
        _worst(closed[closed != "none"].astype(float), 0.0),
        Observed(max(above_bound, 0.0)),
        _worst(energy[energy != "none"].astype(float), 0.0),
        _worst(pd.to_numeric(known["A"], errors="coerce"), known["A_theory"].astype(float)),
        Observed(float((isotropic != on_paper).sum())),
        _worst(cauchy["nu"].astype(float), cauchy["axes"].map(CAUCHY)),
        _worst(waves["omega2_m"] / waves["omega2_m_theory"].astype(float), 1.0),
    ]


def _worst(values: pd.Series, references: pd.Series | float) -> Observed:
    """The farthest from its reference; NaN, which fails, where none is left to compare."""
    return farthest_value(values, references) if len(values) else Observed(math.nan)


def findings(solid: pd.DataFrame) -> tuple[str, ...]:
    """Which are isotropic, and which resist no shear."""
    isotropic = solid[solid["isotropic"] == "yes"]
    told = ", ".join(
        f"{row.lattice} ({row.rule}, nu = {row.nu:.3g})" for row in isotropic.itertuples()
    )
    free = ", ".join(solid["lattice"][solid["strains"] == "shears freely"])
    said = [f"Isotropic are: {told}. Other constants give nu along the axes only."]
    moving = isotropic[isotropic["released"] >= ALIKE]
    if len(moving):
        beyond = ", ".join(
            f"{row.nu:.3g} ({row.lattice}, {row.rule})" for row in moving.itertuples()
        )
        said.append(
            "Cauchy's 1/3 and 1/4 bind lattices whose points are centres of symmetry. Where points "
            f"move inside a cell, isotropic solids of central springs have other ratios: {beyond}."
        )
    if free:
        said.append(f"Without springs across their cells these shear freely: {free}.")
    return tuple(said)
