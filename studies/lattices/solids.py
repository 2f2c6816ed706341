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

from functools import partial

import numpy as np
import pandas as pd
from scipy.optimize import minimize

from msvalidate import kit
from msvalidate.springs.constants.stiffness import (
    ALIKE,
    CAUCHY,
    cubic_part,
    is_same_tensor,
    isotropic_part,
    moduli,
)
from msvalidate.springs.constants.waves import highest_frequency
from msvalidate.springs.lattice import Constants, Pattern, repeat_cell

from . import cases, loading, surfaces, theory
from .cases import Case, Solid

REPEATED = {2: 3, 3: 2}
"""Cells along each axis of the repeated cell, by the number of axes."""
CLOSED = 1e-10
"""Of a tensor from its closed form, relative."""
NUDGE = 1e-4
"""Strain of the differences: what they leave out is of order 1e-8, what rounding does, of 1e-12."""
FORCE_LEFT = 1e-6
"""On a point of a strained cell, per spring constant and nudge; its square is left of energy."""


def run(tables: dict[str, pd.DataFrame]) -> kit.Evidence:
    """Judge the tensors, their constants and frequencies."""
    solid = tables["solids"]
    drawn = set(solid["axes"][solid["strains"] == "every strain"])
    return kit.Evidence(
        tables=tables,
        tolerances=RULES,
        figures={name: draw for axes, (name, draw) in surfaces.FIGURES.items() if axes in drawn},
        columns=kit.columns(__file__),
        findings=findings(solid),
    )


def solid_tables(solid: Solid, setting: kit.Setting) -> dict[str, pd.DataFrame]:
    """The tables `solids` and `tensors`."""
    all_found = setting.sweep(partial(measure, solid), cases.all_cases(), "solids")
    return {
        "solids": pd.DataFrame([row for row, _ in all_found]),
        "tensors": pd.DataFrame([entry for _, own in all_found for entry in own]),
    }


def measure(solid: Solid, case: Case) -> tuple[dict[str, object], list[dict[str, object]]]:
    """Rows of the tables `solids` and `tensors` of one lattice under one rule."""
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
        "above_bound": max(0.0, float(-np.linalg.eigvalsh(affine - C)[0] / largest)),
    }
    return row, entries(case, C, affine, closed)


def difference(found: kit.Array, reference: kit.Array, largest: float) -> float:
    """Largest entry of the difference, relative."""
    return float(np.abs(found - reference).max() / largest)


def constants(C: kit.Array, strains: str) -> tuple[float | str, float | str, float | str]:
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


def is_cubic(C: kit.Array) -> bool:
    """Whether a tensor is that of a square or cubic lattice along the axes: three constants."""
    return is_same_tensor(C, cubic_part(C))


def is_isotropic(C: kit.Array) -> bool:
    """Whether a tensor is the isotropic one nearest to it."""
    try:
        return is_same_tensor(C, isotropic_part(C))
    except kit.ProblemError:  # some strain costs no energy
        return False


def entries(
    case: Case, C: kit.Array, affine: kit.Array, closed: kit.Array | None
) -> list[dict[str, object]]:
    """Rows of the table `tensors`: the entries on and above the diagonal that are not zero."""
    axes = [f"{'xyz'[a]}{'xyz'[b]}" for a, b in kit.VOIGT[case.pattern.dim]]
    rows = []
    for i, j in zip(*np.triu_indices(len(C)), strict=True):
        if np.abs(affine[i, j]) > cases.STIFF * np.abs(affine).max():
            entry = "none" if closed is None else float(closed[i, j])
            row: dict[str, object] = {"row": axes[i], "column": axes[j], "closed_form": entry}
            rows.append(case.head | row | {"numerical": C[i, j], "affine": affine[i, j]})
    return rows


def by_energy(pattern: Pattern, k: Constants) -> kit.Array:
    """Voigt tensor of one cell, spacing 1 m, by differences of its least energy."""
    size = len(kit.VOIGT[pattern.dim])
    C = np.zeros((size, size))
    unit = NUDGE * np.eye(size)

    def both(strain: kit.Array) -> float:
        return least_energy(pattern, k, strain) + least_energy(pattern, k, -strain)

    alone = [both(strain) for strain in unit]
    for i, j in zip(*np.triu_indices(size), strict=True):
        together = both(unit[i] + unit[j])
        C[i, j] = C[j, i] = (together - alone[i] - alone[j]) / (2 * NUDGE**2)
    return C


def least_energy(pattern: Pattern, k: Constants, strain: kit.Array) -> float:
    """Least energy (J) per area or volume of a cell under a Voigt strain, lengths taken exactly."""
    d, n = pattern.dim, len(pattern.points)
    turn = np.eye(d)
    for (a, b), value in zip(kit.VOIGT[d], strain, strict=True):
        turn[a, b] += value if a == b else value / 2
        turn[b, a] += 0 if a == b else value / 2
    i, j = pattern.springs.T
    vectors, stiffness = pattern.vectors, pattern.stiffness(k)
    rest, affine = np.linalg.norm(vectors, axis=1), vectors @ turn

    def energy(moved: kit.Array) -> tuple[float, kit.Array]:
        u = np.concatenate([np.zeros((1, d)), moved.reshape(n - 1, d)])
        now = affine + u[j] - u[i]
        length = np.linalg.norm(now, axis=1)
        pull = (stiffness * (length - rest) / length)[:, None] * now
        force = np.zeros((n, d))
        np.add.at(force, j, pull)
        np.add.at(force, i, -pull)
        return float(0.5 * stiffness @ (length - rest) ** 2), force[1:].ravel()

    def scaled(moved: kit.Array) -> tuple[float, kit.Array]:
        value, slope = energy(NUDGE * moved)
        return value / NUDGE**2, slope / NUDGE

    least = energy(np.zeros((n - 1) * d))[0]
    if n > 1:
        start = np.zeros((n - 1) * d)
        found = minimize(scaled, start, jac=True, method="BFGS", options={"gtol": FORCE_LEFT})
        least = min(least, float(found.fun) * NUDGE**2)
    return least / float(np.prod(pattern.size))


def _chosen(rows: pd.DataFrame, which: pd.Series) -> pd.DataFrame:
    """Rows that are judged; one of NaN, which fails, where there is none."""
    return rows[which] if which.any() else pd.DataFrame(np.nan, [0], rows.columns)


def _known(rows: pd.DataFrame) -> pd.DataFrame:
    return _chosen(rows, rows["A_theory"] != "none")


def _cauchy(rows: pd.DataFrame) -> pd.DataFrame:
    return _chosen(rows, rows["released"] < ALIKE)


def _frequency(rows: pd.DataFrame) -> pd.Series:
    known = _chosen(rows, rows["omega2_m_theory"] != "none")
    return known["omega2_m"] / known["omega2_m_theory"].astype(float)


solid_rule = partial(kit.Rule, unit="1", table="solids")
RULES = (
    solid_rule(
        "tensor against its closed form, relative", CLOSED,
        value=cases.numbers("closed_form_error"),
        because="the same sum over springs, less what points release: none in these; left is "
        "rounding, and what the solution for the points makes of it",
    ),
    solid_rule(
        "tensor above the affine bound, relative", 1e-10, value="above_bound",
        because="the affine motion is one of those among which the energy is least; left is "
        "rounding",
    ),
    solid_rule(
        "tensor against differences of energy, relative", 1e-6, value=cases.numbers("energy_error"),
        because="fourth derivatives of the energy times the nudge squared, 1e-8 times numbers up "
        "to 10",
    ),
    solid_rule(
        "Zener's ratio against theory", 1e-10,
        because="a quotient of sums of a few terms: rounding",
        value=lambda rows: pd.to_numeric(_known(rows)["A"], errors="coerce"),
        reference=lambda rows: _known(rows)["A_theory"],
    ),
    solid_rule(
        "lattices isotropic, or not, against theory", 0,
        because="Zener's ratio on paper is 1, or not",
        value=lambda rows: _known(rows)["isotropic"] == "yes",
        reference=lambda rows: (_known(rows)["A_theory"].astype(float) - 1).abs() < ALIKE,
    ),
    solid_rule(
        "Poisson's ratio of isotropic lattices against Cauchy's", 1e-10,
        because="central springs between points that follow the strain: C12 = C44, so isotropic "
        "means 1/3 in the plane and 1/4 in space", rows={"isotropic": "yes"},
        value=lambda rows: _cauchy(rows)["nu"],
        reference=lambda rows: _cauchy(rows)["axes"].map(CAUCHY),
    ),
    solid_rule(
        "highest frequency squared against theory, relative", 1e-10,
        because="the wave that theory names is one of those tried; left is rounding of an "
        "eigenvalue", value=_frequency, reference=1.0,
    ),
)  # fmt: skip


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
