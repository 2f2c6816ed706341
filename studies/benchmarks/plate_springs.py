"""Thick plate by springs: how near do they come, and what keeps them away (NAFEMS LE10)?

Question   σ_yy at (2, 0, 0.6) m of the plate of `thick_plate`, and how far the hole's side sinks;
           first with the rim held all over, which has a limit, then with its line held.
Candidate  Cubes cut to the plate, 18 neighbours, with volume energy (nu = 0.3).
Reference  Quadratic hexahedra with cells graded towards the edges of the rim that is held. For the
           line, -5.38 MPa [NAFEMS1990].
Expected   A support holds every point of the cells that the rim runs through. They stand as a wall
           (|cos t| + |sin t|)/2 spacings deep where the rim's normal is at t from an axis, 2/π in
           the mean: so the lattice's plate has its rim as much further out. The wall has steps of
           the size of a cell, and what resists is nearer to their tips than to their mean: an error
           of order 1, beside that of order 2 by which cells bend too stiffly, of the same sign.
           A quartic fit for the stress takes 140 points, an eighth of a ball six cells in radius:
           with four layers more than the plate is thick.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import pandas as pd

import reference_fem
from msvalidate import kit
from msvalidate.springs.lattice import patterns
from msvalidate.springs.lattice.cut import CutLattice, cut_lattice
from msvalidate.springs.statics.stress import fitted_stress, interior_points
from reference_fem import Solution
from reference_fem.elasticity import elastic_tensor

from . import cases, curved, thick_plate
from .shapes import OUTER, THICKNESS, clamped_plate
from .thick_plate import FACE, LINE, MEGA, MIDDLE, NU, PLACE, PRESSURE

MATERIAL = kit.Isotropic(E=thick_plate.MODULUS, nu=NU, state="solid")
LAYERS, QUICK_LAYERS = (4, 6, 8), (4, 6)
"""Of cubes through the thickness; an even number, so that points lie on the line's level."""
LINES, QUICK_LINES = LAYERS, (4,)
"""The same of the plates whose line is held."""
ELEMENTS, QUICK_ELEMENTS = (4, 6), (2, 3)
"""n of the graded meshes of elements: the last is the limit, the change to it its uncertainty."""
OUTLINE = 8
"""n of the mesh that lattices are cut to: its outline is off by 1e-6 m."""
DEEP = 2 / np.pi
"""Depth of the wall of held cells in spacings, mean over all directions."""
FIT = (4, 140)
"""Degree of the polynomial that stresses are read off, and points: four a coefficient."""
BETWEEN = 1.5
"""Order by which the sinking is extrapolated: its error is a sum of orders 1 and 2."""
FEM, SPRINGS = "FEM H2", "springs + volume energy, cut cubic18"
STRESS, SINKING = "σyy at (2, 0, 0.6)", "sinking at (2, 0, 0.3)"
OWN = "FEM H2 of this study, graded"


def _extrapolated(order: float, rows: pd.DataFrame) -> float:
    """What the last two lattices extrapolate to, over the limit by elements."""
    values = extrapolated(tuple(rows["cells"]), tuple(rows["value"]), order)
    return values / float(rows["limit"].iloc[0])


SUNK = {"method": SPRINGS, "quantity": f"{SINKING}, {FACE}"}
RULES = (
    kit.Rule(
        "LE10, rim held: sinking by springs, extrapolated at order 1.5, against elements, "
        "relative",
        0.03, "1",
        "errors of orders 1 and 2 and one sign, so the limit lies between what these orders "
        "extrapolate to: of 4 and 6 layers 6 % apart, and 1.5 is near the middle",
        layer="agreement", table="le10_springs", rows=SUNK, reference=1.0,
        value=partial(_extrapolated, BETWEEN),
    ),
    kit.Rule(
        "LE10, rim held: order of the sinking by springs, all lattices", 0.5, "1",
        "between 1, of the wall's steps, and 2, of cells that bend: about the middle",
        layer="agreement", table="le10_springs", rows=SUNK, value="against_limit",
        power_of=kit.Quotient(1, "cells"), reference=1.5,
    ),
    kit.Rule(
        "LE10, rim held: stress by springs, extrapolated at order 2, against elements, "
        "relative",
        0.04, "1",
        "order 2 takes the bending off and leaves the wall's steps: to a quarter of a cell "
        "(half a cell to none between tips and mean) with 4 and 6 layers 0.25 (6² 0.1 - 4² "
        "0.15)/20 m = 1.5 cm, and by elements a rim 1 cm further in takes 1.8 % off: 2.7 %; "
        "the quick elements' own error is 1 %",
        layer="agreement", table="le10_springs", reference=1.0,
        rows={"method": SPRINGS, "quantity": f"{STRESS}, {FACE}"},
        value=partial(_extrapolated, 2.0),
    ),
)  # fmt: skip
FIGURE = kit.series(
    "le10_read", title="NAFEMS LE10: stress by the same fit",
    x="layers", y={"springs": "springs", "elements": "elements"}, by="support",
    labels=("layers of cubes through the thickness (1)", "σyy at (2, 0, 0.6) m (MPa)"),
    size=(6.0, 3.8),
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Plate:
    """What a lattice tells: stress (MPa) by the fit, sinking (m), the points fitted and its layers.

    `points`: (p, 3) in m, those whole and within the plate, not beyond its rim.
    """

    stress: float
    sinking: float
    points: kit.Array


def run(
    candidate: kit.DisplacementSolver = kit.solve_springs, setting: kit.Setting = kit.FULL
) -> kit.Evidence:
    """Compare springs with elements where the rim is held, and with the published value."""
    sizes = QUICK_ELEMENTS if setting.quick else ELEMENTS
    solved = setting.sweep(elastic, sizes, "LE10 by graded elements")
    layers, lines = (QUICK_LAYERS, QUICK_LINES) if setting.quick else (LAYERS, LINES)
    on_face = setting.sweep(partial(spring_plate, candidate, FACE), layers, "LE10 by springs")
    on_line = setting.sweep(partial(spring_plate, candidate, LINE), lines, "LE10, line held")
    tables = {
        "le10_springs": pd.DataFrame(
            [*face_rows(sizes, solved, layers, on_face), *line_rows(lines, on_line)]
        ),
        "le10_read": pd.DataFrame(
            read_rows(FACE, layers, on_face, solved[-1])
            + read_rows(LINE, lines, on_line, solved[-1])
        ),
    }
    return kit.Evidence(
        tables=tables,
        tolerances=RULES,
        columns=kit.columns(__file__),
        figures={
            "le10_springs": cases.drawing(
                "le10_springs", "NAFEMS LE10 by springs", "cells through the thickness (1)"
            ),
            "le10_read": FIGURE,
        },
        findings=findings(tables),
    )


# Solved -------------------------------------------------------------------------------------------


def elastic(n: int) -> Solution:
    """The plate by elements, its rim held all over."""
    meshed = clamped_plate(n)
    body = reference_fem.make_discretisation(meshed.points, meshed.cells, "H2")
    return thick_plate.solve_plate(FACE, meshed, body)


def spring_plate(candidate: kit.DisplacementSolver, support: str, layers: int) -> Plate:
    """The plate by the candidate's lattice, its rim held in one of two ways."""
    problem, lattice, network = spring_model(support, layers)
    move = candidate(problem, network, "linear")
    there, weights = lattice.weights_at(MIDDLE)
    sinking = -float((weights * move[there, 2]).sum())
    x = lattice.points
    near = interior_points(lattice) & (np.square(x[:, :2] / OUTER).sum(axis=1) < 1)
    return Plate(read(x[near], move[near]), sinking, x[near])


def spring_model(support: str, layers: int) -> tuple[kit.Problem, CutLattice, kit.Network]:
    """The plate, its rim further out by the wall's depth; its lattice, and its network."""
    spacing = THICKNESS / layers
    problem = wider(DEEP * spacing)
    kind = patterns.cubic18()
    lattice = cut_lattice(kind, problem.domain, spacing)
    network, _ = curved.spring_model(problem, lattice, kind)
    return problem, lattice, network if support == FACE else on_line(network)


def wider(by: float) -> kit.Problem:
    """The plate with half-axes of its rim that are longer by so many metres, its rim held."""
    mesh = clamped_plate(OUTLINE, by).mesh
    held = kit.Support(mesh.side("rim"), (0.0, 0.0, 0.0))
    return kit.Problem(
        mesh,
        MATERIAL,
        (*curved.quarter_supports(mesh), held),
        (kit.Traction(mesh.side("upper"), (0.0, 0.0, -PRESSURE)),),
        name="NAFEMS LE10",
    )


def on_line(network: kit.Network) -> kit.Network:
    """Upwards held at the line's level only: of the wall's points, which the rim alone holds so."""
    held = network.fixed.copy()
    held[:, 2] &= np.abs(network.points[:, 2] - THICKNESS / 2) <= 1e-9 * THICKNESS
    return replace(network, fixed=held)


def read(points: kit.Array, move: kit.Array) -> float:
    """σ_yy (MPa) at the place that is asked for, by the polynomial through points near by."""
    degree, count = FIT
    stress = fitted_stress(
        points, move, PLACE, elastic_tensor(MATERIAL), degree=degree, count=count
    )
    return float(stress[0, 1] / MEGA)


# Tables -------------------------------------------------------------------------------------------


def face_rows(
    sizes: tuple[int, ...], solved: list[Solution], layers: tuple[int, ...], found: list[Plate]
) -> list[dict[str, object]]:
    """Rows of the plate whose rim is held all over, elements and springs."""
    stress = [float(each.stress(PLACE)[0, 1] / MEGA) for each in solved]
    sinking = [-float(each.at(MIDDLE)[0, 2]) for each in solved]
    rows = []
    for name, unit, exact, values in (
        (STRESS, "MPa", stress, [each.stress for each in found]),
        (SINKING, "m", sinking, [each.sinking for each in found]),
    ):
        uncertainty = abs(exact[-2] / exact[-1] - 1)
        about = (f"{name}, {FACE}", unit, exact[-1], OWN, NU, exact[-1], uncertainty)
        asked = cases.Quantity("NAFEMS LE10", *about)
        # The finest is the limit, and against itself it would be exact.
        rows += cases.rows(asked, FEM, [n + 2 for n in sizes[:-1]], exact[:-1])
        rows += cases.rows(asked, SPRINGS, layers, values)
    return rows


def line_rows(layers: tuple[int, ...], found: list[Plate]) -> list[dict[str, object]]:
    """Rows of the plate as it is posed."""
    value, source = thick_plate.PUBLISHED, thick_plate.SOURCE
    asked = cases.Quantity("NAFEMS LE10", STRESS, "MPa", value, source, NU)
    return cases.rows(asked, SPRINGS, layers, [each.stress for each in found])


def read_rows(
    support: str, layers: tuple[int, ...], found: list[Plate], solved: Solution
) -> list[dict[str, object]]:
    """Rows of `le10_read`: the stress by the same fit to springs and to elements."""
    rows: list[dict[str, object]] = []
    for i, (n, plate) in enumerate(zip(layers, found, strict=True)):
        row = {"support": support, "layers": n, "springs": plate.stress}
        row["elements"] = read(plate.points, solved.at(plate.points))
        row["extrapolated"] = "coarsest"
        if i:
            pair = found[i - 1].stress, plate.stress
            row["extrapolated"] = extrapolated(layers[i - 1 : i + 1], pair, 2.0)
        rows.append(row)
    return rows


def extrapolated(layers: tuple[int, ...], values: tuple[float, ...], order: float) -> float:
    """The limit of the last two values, if their errors fall with this power of the spacing."""
    finer = (layers[-1] / layers[-2]) ** order
    return float(values[-1] + (values[-1] - values[-2]) / (finer - 1))


def findings(tables: dict[str, pd.DataFrame]) -> tuple[str, ...]:
    """How near, what of it is the fit's, and what holding a line of points is worth."""
    read_off = dict(list(tables["le10_read"].groupby("support")))
    face = read_off[FACE].iloc[-1]
    goal = float(tables["le10_springs"]["limit"].iloc[0])
    line = read_off[LINE].iloc[-1]
    held = read_off[FACE].set_index("layers")["springs"][line["layers"]]
    near = (
        f"NAFEMS LE10 with its rim held is {goal:.2f} MPa by graded elements; springs of "
        f"{face['layers']} layers read {face['springs']:.2f} MPa and extrapolate at order 2 to "
        f"{face['extrapolated']:.2f} MPa. Elements read by the same fit, which reaches six cells "
        f"deep, are {face['elements']:.2f} MPa: that much is the reading's, not the network's."
    )
    away = line["springs"] / thick_plate.PUBLISHED - 1, line["springs"] / held - 1
    posed = (
        f"NAFEMS LE10 as posed, {line['layers']} layers: {line['springs']:.2f} MPa by springs, "
        f"{100 * away[0]:+.2g} % off the published value and {100 * away[1]:+.2g} % off springs "
        "with the rim held. The held line is a band of points as wide as a cell: what it is worth "
        "depends on the spacing, and the sinking there has no limit either."
    )
    return near, posed
