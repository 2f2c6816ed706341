"""Three-point bending: a beam under a load in the middle of its span, supported or clamped.

Question   Deflection of the axis at midspan: of a beam whose ends are free to turn, and of one held
           on both end faces, which is the report's beam.
Candidate  Linear equilibrium of square cells, springs shared.
Reference  Finite elements at vanishing spacing, and beam theory as the accepted value,
           PL³/(48EI) + PL/(4κGA) and PL³/(192EI) + PL/(4κGA) with κ = 5/6, for a load spread over
           a part of the top. A displacement under a point load grows with every refinement: so
           load and reactions are spread, and the deflection is that of the axis. The supported
           beam's reactions are shear tractions on its end faces; its supports carry nothing.
Expected   Order 2 where nothing is singular; twice the exponent of the clamped corner where the
           ends are held, with a part of order 2 beside it. Beam theory leaves out what the load
           does to the beam below it, a part of order (height/length)² as shear is.
"""

from __future__ import annotations

from functools import partial

import numpy as np
import pandas as pd

import reference_fem
from msvalidate.judging.candidate import DisplacementSolver, solve_springs
from msvalidate.judging.compare import farthest_value
from msvalidate.judging.evidence import Evidence, Observed, Tolerance, by_quantity
from msvalidate.judging.singularity import clamped_free_exponent
from msvalidate.judging.sweep import FULL, Setting
from msvalidate.lattice import square
from msvalidate.problem import Box, Isotropic, Problem, Region, Segment, Support, Traction
from reference_fem.elasticity import elastic_tensor

from . import cases, models

LENGTH, HEIGHT, LOADED, LOAD, MODULUS = 8.0, 1.0, 1.0, 100.0, 1e5
"""m, m, m of the top, N and Pa, one metre thick; the answer is linear."""
BEAM = Box((LENGTH, HEIGHT))
INERTIA, SHAPE_FACTOR = HEIGHT**3 / 12, 5 / 6
"""κ of a rectangular section in shear [Reissner1945]."""
MIDSPAN = np.array([[LENGTH / 2, HEIGHT / 2]])
SIZES, QUICK_SIZES = (4, 8, 16, 32), (4, 8, 16)
"""Cells through the height."""
COARSEST, GRADING, ACCURACY, QUICK_ACCURACY = 4, 2.0, 1e-4, 4e-4
"""Of the mesh for the limit, drawn to corners and to the ends of the load."""
RATIOS, QUICK_RATIOS = (1 / 3, 0.45), (1 / 3,)
KINDS = ("supported", "clamped")
TOLERANCES = (
    Tolerance(
        "three-point bending, supported: order of the springs' deflection, finest pair", 0.15, "1",
        "the ends of the load are no worse than a jump of traction, far from the axis: order 2, "
        "and a term of two powers more that moves a pair by 0.1 if as large as the first at one "
        "cell",
    ),
    Tolerance(
        "three-point bending, clamped: order of the springs, part of the way from 2λ to 2",
        0.5, "1",
        "bending, of order 2, and the clamps' corners, of order 2λ, have the same sign: the order "
        "is somewhere between theirs, and this holds it from both sides",
    ),
    Tolerance(
        "three-point bending, supported: FEM against beam theory, relative", 0.01, "1",
        "what the load does to the beam below it: for a point load and nu = 0.3 the exact series "
        "(Timoshenko and Goodier 1970) is 1 + 2.85 (h/L)² - 0.84 (h/L)³ where shear alone makes it "
        "1 + 3.12 (h/L)², 0.6 % less here; as much again for another load and nu",
    ),
    Tolerance(
        "three-point bending, clamped: FEM against beam theory, relative", 0.03, "1",
        "the same of a deflection a quarter as large: 2.4 %, and a quarter more for sections that "
        "clamps keep from contracting",
    ),
    Tolerance(
        "three-point bending: uncertainty of FEM, relative", QUICK_ACCURACY, "1",
        "what the question asks of it, a tenth of the springs' difference at 16 cells; the full "
        "form asks for a quarter of this",
    ),
)  # fmt: skip


def run(candidate: DisplacementSolver = solve_springs, setting: Setting = FULL) -> Evidence:
    """Compare the candidate's beams with finite elements and beam theory."""
    sizes = QUICK_SIZES if setting.quick else SIZES
    rows: list[dict[str, object]] = []
    accuracy = QUICK_ACCURACY if setting.quick else ACCURACY
    for nu in QUICK_RATIOS if setting.quick else RATIOS:
        for kind in KINDS:
            quantity, meshes = reference(kind, nu, accuracy)
            rows += cases.rows(quantity, "FEM Q2", *meshes)
            found = setting.sweep(partial(spring_deflection, candidate, kind, nu), sizes, kind)
            rows += cases.rows(quantity, models.method("square", nu), sizes, found)
    table = pd.DataFrame(rows)
    return Evidence(
        tables={"three_point": table},
        observed=observe(table),
        tolerances=TOLERANCES,
        columns=cases.COLUMNS,
        figures={
            "three_point": cases.drawing(
                "three_point", "Three-point bending", "cells through the height (1)"
            )
        },
        findings=(
            f"Three-point bending against beam theory: {cases.describe(cases.of_springs(table))}.",
        ),
    )


def theory(kind: str, nu: float) -> float:
    """Deflection (m, downward) of midspan by beam theory, the load spread evenly.

    Of a unit force at a < L/2: a (3L² - 4a²)/(48EI) where the ends may turn, a² (3L - 4a)/(48EI)
    where they are held; and a/(2κGA) by shear. Their means over the loaded part.

    Source: bending of beams, with the shear coefficient of [Reissner1945]; closed form derived
    here.
    """
    first, last = (LENGTH - LOADED) / 2, LENGTH / 2
    a = np.polynomial.Polynomial([0.0, 1.0])
    bent = a * (3 * LENGTH**2 - 4 * a**2) if kind == "supported" else a**2 * (3 * LENGTH - 4 * a)
    shear = MODULUS / (2 * (1 + nu))
    each = bent / (48 * MODULUS * INERTIA) + a / (2 * SHAPE_FACTOR * shear * HEIGHT)
    whole = each.integ()
    return float(LOAD * (whole(last) - whole(first)) / (last - first))


def problem(kind: str, nu: float) -> Problem:
    """The beam under a load on the middle of its top."""
    middle = LENGTH / 2
    top = Segment((middle + LOADED / 2, HEIGHT), (middle - LOADED / 2, HEIGHT))
    loads: tuple[Traction, ...] = (Traction(top, (0.0, -LOAD / LOADED)),)
    left, right = BEAM.side("left"), BEAM.side("right")
    material = Isotropic(E=MODULUS, nu=nu)
    if kind == "clamped":
        held = tuple(Support(side, (0.0, 0.0)) for side in (left, right))
        return Problem(BEAM, material, held, loads, name="clamped beam")
    reaction = (0.0, LOAD / (2 * HEIGHT))
    loads += (Traction(left, reaction), Traction(right, reaction))
    held = (
        Support(Region((0.0, HEIGHT / 2)), (0.0, 0.0)),
        Support(Region((LENGTH, HEIGHT / 2)), (None, 0.0)),
    )
    return Problem(BEAM, material, held, loads, name="supported beam")


def reference(
    kind: str, nu: float, accuracy: float
) -> tuple[cases.Quantity, tuple[tuple[int, ...], tuple[float, ...]]]:
    """The deflection's limit by finite elements, and what its meshes give."""
    seen: dict[int, float] = {}
    size = theory(kind, nu)

    def refined(cells: int) -> float:
        seen[cells] = elastic_deflection(kind, nu, cells)
        return seen[cells] / size

    estimate = reference_fem.refine(refined, COARSEST, accuracy)
    parts = "48" if kind == "supported" else "192"
    quantity = cases.Quantity(
        "three-point bending",
        f"midspan, {kind}",
        "m",
        size,
        f"beam theory, PL³/({parts}EI) + PL/(4κGA)",
        nu,
        limit=float(estimate.value[0]) * size,
        limit_uncertainty=float(estimate.uncertainty[0] / estimate.value[0]),
    )
    meshes = tuple(seen)[:-1]  # the finest is the limit itself
    return quantity, (meshes, tuple(seen[n] for n in meshes))


def elastic_deflection(kind: str, nu: float, cells: int) -> float:
    """Deflection (m, downward) of the axis at midspan by finite elements."""
    middle = LENGTH / 2
    through: tuple[tuple[float, ...], ...] = (
        (middle - LOADED / 2, middle + LOADED / 2),
        (HEIGHT / 2,),
    )
    mesh = reference_fem.box_discretisation(
        BEAM, (int(LENGTH) * cells, cells), "Q2", GRADING, through=through
    )
    return -float(reference_fem.solve_problem(problem(kind, nu), mesh).at(MIDSPAN)[0, 1])


def spring_deflection(candidate: DisplacementSolver, kind: str, nu: float, cells: int) -> float:
    """Deflection (m, downward) of the axis at midspan of the candidate's network."""
    asked = problem(kind, nu)
    network = models.network_of(asked, square(BEAM, (int(LENGTH) * cells, cells)))
    move = candidate(asked, network, "linear")
    middle = (np.abs(network.points - MIDSPAN) <= BEAM.tolerance).all(axis=1)
    return -float(move[middle, 1][0])


def corner_order(nu: float) -> float:
    """Twice the displacement's exponent at a corner between a held edge and a free one."""
    tensor = elastic_tensor(Isotropic(E=1.0, nu=nu))
    return float(2 * clamped_free_exponent(tensor, np.pi / 2))


def observe(table: pd.DataFrame) -> dict[str, Observed]:
    """The judged quantities."""
    last = cases.finest(table)
    fem = last["method"] == "FEM Q2"
    supported = last["quantity"] == "midspan, supported"
    clamped = last[~fem & ~supported]
    twice = np.array([corner_order(nu) for nu in clamped["nu"]])
    values = (
        farthest_value(cases.orders(last[~fem & supported]), 2.0),
        farthest_value((cases.orders(clamped) - twice) / (2.0 - twice), 0.5),
        farthest_value(last[fem & supported]["limit"] / last[fem & supported]["accepted"], 1.0),
        farthest_value(last[fem & ~supported]["limit"] / last[fem & ~supported]["accepted"], 1.0),
        farthest_value(last["limit_uncertainty"], 0.0),
    )
    return by_quantity(TOLERANCES, values)
