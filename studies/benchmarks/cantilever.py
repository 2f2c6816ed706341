"""Cantilever: Timoshenko and Goodier's beam under a parabolic shear at its end.

Question   Deflection of the end's middle, and where the field is farthest from the exact one.
Candidate  Linear equilibrium of square cells, springs shared.
Reference  The exact field ([TimoshenkoGoodier1970], art. 21; in the form of
           [AugardeDeeks2008]), prescribed where the beam is held, so that no corner is singular.
           With y from the beam's axis and P downward

               u_x =  P y/(6EI) ((6L - 3x) x + (2 + nu)(y² - D²/4)),
               u_y = -P/(6EI) (3 nu y² (L - x) + (4 + 5 nu) D² x/4 + (3L - x) x²),

           which is PL³/(3EI) + (4 + 5 nu) P D² L/(24EI) at the end.
Expected   The field is smooth: order 2 for springs and for linear elements. Quadratic ones would
           have 4; the deflection's own influence function, a beam held at its root, is singular
           at the root's corners and leaves them between 3 and 4.

Lattices take a traction as linear along each facet: of this parabola the sum would be short by
1/N². The springs' traction is the parabola plus a constant, h²/12 of its second derivative less,
which makes those forces the consistent ones.
"""

from __future__ import annotations

from functools import partial

import numpy as np
import pandas as pd

import reference_fem
from msvalidate import kit
from msvalidate.springs.lattice import square

from . import cases, models

LENGTH, DEPTH, LOAD, MODULUS = 48.0, 12.0, 1000.0, 3e7
INERTIA = DEPTH**3 / 12
BEAM = kit.Box((LENGTH, DEPTH))
END = (LENGTH, DEPTH / 2)
RATIOS, QUICK_RATIOS = (0.0, 0.3, 1 / 3, 0.49), (0.3, 1 / 3)
SIZES, QUICK_SIZES = (4, 8, 16, 32), (4, 8, 16)
"""Cells through the depth."""
ELEMENTS = ("Q1", "Q2")
SOURCE = "Timoshenko and Goodier 1970, art. 21"
judged = partial(cases.judged, table="cantilever")
RULES = (
    judged(
        "cantilever: order of the end's deflection, springs and Q1", 0.15,
        value=cases.orders, reference=2.0,
        rows={"method": ("FEM Q1", *(models.method("square", nu) for nu in RATIOS))},
        because="the exact field is smooth: the next term has two powers of the spacing more, 1/64 "
        "of the first at 8 cells, and moves a pair's order by 0.03 if as large as the first",
    ),
    judged(
        "cantilever: deflection of the end by Q2, finest mesh, relative", 1e-6, layer="regression",
        value="against_limit", rows={"method": "FEM Q2"},
        because="order 3 at least, on a cubic field: 1e-5, measured at 4 cells, is 2e-7 at 16",
    ),
)  # fmt: skip


def run(
    candidate: kit.DisplacementSolver = kit.solve_springs, setting: kit.Setting = kit.FULL
) -> kit.Evidence:
    """Compare the candidate's beams and finite elements with the exact field."""
    sizes = QUICK_SIZES if setting.quick else SIZES
    rows: list[dict[str, object]] = []
    for nu in QUICK_RATIOS if setting.quick else RATIOS:
        end = cases.Quantity(
            "Timoshenko cantilever", "end deflection", "m", deflection(nu), SOURCE, nu
        )
        for element in ELEMENTS:
            found = setting.sweep(partial(elastic_end, element, nu), sizes, f"cantilever {element}")
            rows += cases.rows(end, f"FEM {element}", sizes, found)
        found = setting.sweep(partial(spring_end, candidate, nu), sizes, "cantilever of springs")
        rows += cases.rows(end, models.method("square", nu), sizes, found)
    table = pd.DataFrame(rows)
    return kit.Evidence(
        tables={"cantilever": table},
        tolerances=RULES,
        columns=kit.columns(__file__),
        figures={
            "cantilever": cases.drawing(
                "cantilever", "Timoshenko's cantilever", "cells through the depth (1)"
            )
        },
        findings=(
            f"Timoshenko's cantilever, end deflection: {cases.describe(cases.of_springs(table))}.",
        ),
    )


def deflection(nu: float) -> float:
    """Exact deflection (m, downward) of the middle of the end."""
    bending = LOAD * LENGTH**3 / (3 * MODULUS * INERTIA)
    return bending + (4 + 5 * nu) * LOAD * DEPTH**2 * LENGTH / (24 * MODULUS * INERTIA)


def exact(nu: float, points: kit.Array) -> kit.Array:
    """Exact displacement (n, 2) in m at points (n, 2).

    Source: [TimoshenkoGoodier1970], article 21; [AugardeDeeks2008].
    """
    x, y = points[:, 0], points[:, 1] - DEPTH / 2
    along = y * ((6 * LENGTH - 3 * x) * x + (2 + nu) * (y**2 - DEPTH**2 / 4))
    down = 3 * nu * y**2 * (LENGTH - x) + (4 + 5 * nu) * DEPTH**2 * x / 4 + (3 * LENGTH - x) * x**2
    return LOAD / (6 * MODULUS * INERTIA) * np.column_stack([along, -down])


def problem(nu: float, spacing: float = 0.0) -> kit.Problem:
    """The exact displacement on the left end, the exact traction on the right one.

    `spacing` (m) of facets along which the traction is taken as linear; 0 where it is integrated.
    """

    def shear(points: kit.Array) -> kit.Array:
        y = points[:, 1] - DEPTH / 2
        parabola = DEPTH**2 / 4 - y**2 + spacing**2 / 6
        return np.column_stack([0 * y, -LOAD / (2 * INERTIA) * parabola])

    held = tuple(lambda points, a=a: exact(nu, points)[:, a] for a in range(2))
    return kit.Problem(
        BEAM,
        kit.Isotropic(E=MODULUS, nu=nu),
        (kit.Support(BEAM.side("left"), held),),
        (kit.Traction(BEAM.side("right"), shear),),
        name="Timoshenko cantilever",
    )


def elastic_end(element: str, nu: float, cells: int) -> float:
    """Deflection (m, downward) of the end's middle by finite elements."""
    mesh = reference_fem.box_discretisation(BEAM, (4 * cells, cells), element)
    return -float(reference_fem.solve_problem(problem(nu), mesh).at(np.array([END]))[0, 1])


def spring_end(candidate: kit.DisplacementSolver, nu: float, cells: int) -> float:
    """Deflection (m, downward) of the end's middle of the candidate's network."""
    asked = problem(nu, DEPTH / cells)
    network = models.network_of(asked, square(BEAM, (4 * cells, cells)))
    move = candidate(asked, network, "linear")
    middle = (np.abs(network.points - END) <= BEAM.tolerance).all(axis=1)
    return -float(move[middle, 1][0])
