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
from msvalidate import kit
from msvalidate.bench.judging.singularity import clamped_free_exponent
from msvalidate.springs.lattice import square
from reference_fem.elasticity import elastic_tensor

from . import cases, models

LENGTH, HEIGHT, LOADED, LOAD, MODULUS = 8.0, 1.0, 1.0, 100.0, 1e5
"""m, m, m of the top, N and Pa, one metre thick; the answer is linear."""
BEAM = kit.Box((LENGTH, HEIGHT))
INERTIA, SHAPE_FACTOR = HEIGHT**3 / 12, 5 / 6
"""κ of a rectangular section in shear [Reissner1945]."""
MIDSPAN = np.array([[LENGTH / 2, HEIGHT / 2]])
SIZES, QUICK_SIZES = (4, 8, 16, 32), (4, 8, 16)
"""Cells through the height."""
COARSEST, GRADING, ACCURACY, QUICK_ACCURACY = 4, 2.0, 1e-4, 4e-4
"""Of the mesh for the limit, drawn to corners and to the ends of the load."""
RATIOS, QUICK_RATIOS = (1 / 3, 0.45), (1 / 3,)
KINDS = ("supported", "clamped")
SPRINGS = tuple(models.method("square", nu) for nu in RATIOS)


def _from_corner(rows: pd.DataFrame) -> kit.Array:
    """Orders as part of the way from the corner's, twice the displacement's exponent, to 2."""
    tensors = [elastic_tensor(kit.Isotropic(E=1.0, nu=nu)) for nu in rows["nu"]]
    twice = 2 * np.array([clamped_free_exponent(tensor, np.pi / 2) for tensor in tensors])
    return np.asarray((cases.orders(rows) - twice) / (2.0 - twice))


judged = partial(cases.judged, table="three_point")
theory_of = partial(judged, value=kit.Quotient("limit", "accepted"), reference=1.0)
RULES = (
    judged(
        "three-point bending, supported: order of the springs' deflection, finest pair", 0.15,
        rows={"method": SPRINGS, "quantity": "midspan, supported"},
        value=cases.orders, reference=2.0,
        because="the ends of the load are no worse than a jump of traction, far from the axis: "
        "order 2, and a term of two powers more that moves a pair by 0.1 if as large as the first "
        "at one cell",
    ),
    judged(
        "three-point bending, clamped: order of the springs, part of the way from 2λ to 2", 0.5,
        rows={"method": SPRINGS, "quantity": "midspan, clamped"},
        value=_from_corner, reference=0.5,
        because="bending, of order 2, and the clamps' corners, of order 2λ, have the same sign: "
        "the order is somewhere between theirs, and this holds it from both sides",
    ),
    theory_of(
        "three-point bending, supported: FEM against beam theory, relative", 0.01,
        rows={"method": "FEM Q2", "quantity": "midspan, supported"},
        because="what the load does to the beam below it: for a point load and nu = 0.3 the exact "
        "series (Timoshenko and Goodier 1970) is 1 + 2.85 (h/L)² - 0.84 (h/L)³ where shear "
        "alone makes it 1 + 3.12 (h/L)², 0.6 % less here; as much again for another load and nu",
    ),
    theory_of(
        "three-point bending, clamped: FEM against beam theory, relative", 0.03,
        rows={"method": "FEM Q2", "quantity": "midspan, clamped"},
        because="the same of a deflection a quarter as large: 2.4 %, and a quarter more for "
        "sections that clamps keep from contracting",
    ),
    judged(
        "three-point bending: uncertainty of FEM, relative", QUICK_ACCURACY,
        value="limit_uncertainty",
        because="what the question asks of it, a tenth of the springs' difference at 16 cells; the "
        "full form asks for a quarter of this",
    ),
)  # fmt: skip


def run(
    candidate: kit.DisplacementSolver = kit.solve_springs, setting: kit.Setting = kit.FULL
) -> kit.Evidence:
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
    return kit.Evidence(
        tables={"three_point": table},
        tolerances=RULES,
        columns=kit.columns(__file__),
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


def problem(kind: str, nu: float) -> kit.Problem:
    """The beam under a load on the middle of its top."""
    middle = LENGTH / 2
    top = kit.Segment((middle + LOADED / 2, HEIGHT), (middle - LOADED / 2, HEIGHT))
    loads: tuple[kit.Traction, ...] = (kit.Traction(top, (0.0, -LOAD / LOADED)),)
    left, right = BEAM.side("left"), BEAM.side("right")
    material = kit.Isotropic(E=MODULUS, nu=nu)
    if kind == "clamped":
        held = tuple(kit.Support(side, (0.0, 0.0)) for side in (left, right))
        return kit.Problem(BEAM, material, held, loads, name="clamped beam")
    reaction = (0.0, LOAD / (2 * HEIGHT))
    loads += (kit.Traction(left, reaction), kit.Traction(right, reaction))
    held = (
        kit.Support(kit.Region((0.0, HEIGHT / 2)), (0.0, 0.0)),
        kit.Support(kit.Region((LENGTH, HEIGHT / 2)), (None, 0.0)),
    )
    return kit.Problem(BEAM, material, held, loads, name="supported beam")


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


def spring_deflection(candidate: kit.DisplacementSolver, kind: str, nu: float, cells: int) -> float:
    """Deflection (m, downward) of the axis at midspan of the candidate's network."""
    asked = problem(kind, nu)
    network = models.network_of(asked, square(BEAM, (int(LENGTH) * cells, cells)))
    move = candidate(asked, network, "linear")
    middle = (np.abs(network.points - MIDSPAN) <= BEAM.tolerance).all(axis=1)
    return -float(move[middle, 1][0])
