"""Incompressible: what ratio does it ask for in the plane, and what does k2 = 2 k1 give?

Question   The in-plane ratio of an incompressible body, the constants that would give it, what the
           report's k2 = 2 k1 gives instead, and how the ratio drifts with finite strain.
Candidate  Static equilibrium of a block of consistently weighted springs, linear and nonlinear.
Reference  Closed forms: the homogenised tensor; the exact stretch of one cell at finite strain.
Expected   1/2 in plane stress, 1 in plane strain. k2 = 2 k1 gives 2/3 along the axes. To first
           order the ratio drifts by nu (1 + nu)(3 nu - 1)/4 per strain: not at all at nu = 1/3.
"""

from __future__ import annotations

from functools import partial
from itertools import product

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from scipy.optimize import brentq

from msvalidate import kit
from msvalidate.springs.constants.directions import directional_ratio
from msvalidate.springs.constants.stiffness import moduli, square_tensor

from . import block
from .block import K1, RATIOS

CELLS = 5
STRAINS = (0.001, 0.01, 0.05)
NONE = "none"
"""The declared word where no constants exist."""
axial = partial(
    kit.Rule, limit=1e-9, unit="1", because="k2/(k1+k2), exact with shared springs",
    table="incompressible", value="nu_springs",
)  # fmt: skip
RULES = (
    kit.Rule(
        "finite strain: springs against the exact stretch of a cell", 1e-8, "1",
        "Newton's relative residual of 1e-11, over the smallest strain of 1e-3",
        table="drift", value="nu_springs", reference="nu_exact",
    ),
    kit.Rule(
        "drift per strain at the smallest strain", 2e-3, "1",
        "the next term of the series: the strain of 1e-3 times a factor of order 1",
        table="drift", rows={"strain": STRAINS[0]},
        value="drift_per_strain", reference="drift_predicted",
    ),
    axial("k2 = 2 k1, springs: 2/3 along the axes", rows={"k2_over_k1": 2.0}, reference=2 / 3),
    axial("k2 = k1, springs: 1/2 along the axes", rows={"k2_over_k1": 1.0}, reference=1 / 2),
)  # fmt: skip


def run(
    candidate: kit.DisplacementSolver = kit.solve_springs, setting: kit.Setting = kit.FULL
) -> kit.Evidence:
    """Say what incompressible asks for, and measure what the lattice gives."""
    cases = list(product(RATIOS, STRAINS))
    found = setting.sweep(partial(stretch_block, candidate), cases, "finite strain")
    drift = pd.DataFrame(
        drift_row(k2, strain, nu) for (k2, strain), nu in zip(cases, found, strict=True)
    )
    readings = pd.DataFrame(
        [
            reading(candidate, "plane stress, nu = 1/2", 0.5, 1.0),
            reading(candidate, "plane strain, nu = 1/2", 1.0, None),
            reading(candidate, "the report, k2 = 2 k1", 0.5, 2.0),
        ]
    )
    return kit.Evidence(
        tables={"incompressible": readings, "drift": drift},
        tolerances=RULES,
        figures={"drift": draw},
        columns=kit.columns(__file__),
        findings=findings(readings),
    )


def stretch_block(candidate: kit.DisplacementSolver, case: tuple[float, float]) -> float:
    """Ratio of a block of shared springs, ends sliding, at a finite strain."""
    k2, strain = case
    problem, network = block.spring_block("slide", k2, CELLS, "shared", strain)
    return block.ratio(network.points, candidate(problem, network, "nonlinear"), "edges")


def drift_row(k2: float, strain: float, nu: float) -> dict[str, float]:
    """One row: measured and predicted."""
    linear = k2 / (K1 + k2)
    return {
        "k1": K1,
        "k2": k2,
        "strain": strain,
        "nu_springs": nu,
        "nu_exact": exact_ratio(k2, strain),
        "nu_bulk_formula": linear,
        "drift_per_strain": (nu - linear) / strain,
        "drift_predicted": linear * (1 + linear) * (3 * linear - 1) / 4,
    }


def exact_ratio(k2: float, strain: float) -> float:
    """Ratio of a cell stretched by 1 + strain along x and free along y.

    A cell has one spring's worth of k1 along x and along y and two diagonals:
    W = k1(a - 1)²/2 + k1(b - 1)²/2 + k2(√(a² + b²) - √2)²; the free stretch b makes ∂W/∂b = 0.

    Source: closed form derived here.
    """
    a = 1 + strain

    def force(b: float) -> float:
        diagonal = np.hypot(a, b)
        return float(K1 * (b - 1) + 2 * k2 * (1 - np.sqrt(2) / diagonal) * b)

    return float((1 - brentq(force, 0.5, 1.0, xtol=1e-15, rtol=1e-15)) / strain)


def reading(
    candidate: kit.DisplacementSolver, name: str, wanted: float, k2: float | None
) -> dict[str, object]:
    """One row: the ratio a reading of "incompressible" wants, and what constants give."""
    if k2 is None:  # nu = k2/(k1 + k2) = 1 leaves k1 = 0, a lattice that shears for nothing
        columns = ("k2_over_k1", "nu_axis", "nu_diagonal", "zener", "nu_springs")
        given: dict[str, object] = dict.fromkeys(columns, NONE)
    else:
        tensor = square_tensor(K1, k2)
        problem, network = block.spring_block("slide", k2, CELLS, "shared")
        found = moduli(tensor)
        given = {
            "k2_over_k1": k2,
            "nu_axis": found.nu,
            "nu_diagonal": directional_ratio(tensor, np.pi / 4),
            "zener": found.zener,
            "nu_springs": block.ratio(
                network.points, candidate(problem, network, "linear"), "edges"
            ),
        }
    return {"reading": name, "nu_wanted": wanted} | given


def findings(readings: pd.DataFrame) -> tuple[str, ...]:
    """What k2 = 2 k1 is."""
    report = readings.iloc[2]
    finding = (
        f"k2 = 2k1 is not incompressible: its ratio is {report['nu_springs']:.4f} "
        f"along the axes and {report['nu_diagonal']:.4f} along the diagonals (Zener ratio "
        f"{report['zener']:.3g}). An incompressible sheet in plane stress has 1/2, which k2 = k1 "
        f"gives along the axes; plane strain asks for 1, where the axial springs would vanish."
    )
    return (finding,)


def draw(tables: kit.Tables) -> Figure:
    """Drift of the ratio against strain: exact curves, first order, the candidate's points."""
    figure, (axis,) = kit.figures.new_figure(size=(4.6, 3.9))
    strains = np.linspace(1e-4, 1.1 * STRAINS[-1], 40)
    for (_, rows), colour, marker in zip(
        tables["drift"].groupby("k2"), kit.figures.COLOURS, kit.figures.MARKERS, strict=False
    ):
        k2, linear, slope = rows[["k2", "nu_bulk_formula", "drift_predicted"]].iloc[0]
        curve = np.array([exact_ratio(k2, strain) for strain in strains]) - linear
        drift = rows["nu_springs"] - rows["nu_bulk_formula"]
        label = f"k2/k1 = {k2:g}, ratio {linear:.3f}"
        axis.plot(100 * strains, curve, color=colour, label=label)
        axis.plot(100 * strains, slope * strains, ":", color=colour)
        axis.plot(100 * rows["strain"], drift, marker, color=colour, mfc="white")
    for style, label in (("-", "one cell, exact"), (":", "first order"), ("o", "springs")):
        axis.plot([], [], style, color="grey", mfc="white", label=label)
    axis.set(xlabel="axial strain (%)", ylabel="drift of Poisson's ratio (1)")
    axis.set_title("Poisson's ratio drifts with the strain")
    kit.figures.add_shared_legend(figure, [axis], columns=2)
    return figure
