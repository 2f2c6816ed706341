"""Square meshes of springs in tension, as Brisard published them: network, plate, framed plate."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import pandas as pd

import reference_fem
from msvalidate import kit
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.constants.homogenise import homogenise
from msvalidate.springs.lattice import fill, patterns
from reference_fem.body import nodal_forces

from . import framed_plate

PRINTED = {
    1: 4.8,
    2: 3.4285714285714284,
    4: 3.0300228871509,
    8: 2.8619379280855037,
    16: 2.7748131542266377,
    32: 2.72562591606945,
    64: 2.698019760598084,
    128: 2.6829903494073495,
}
"""Brisard's table at χ = 2: cells along an edge -> apparent stiffness (N/m)."""
CHI = 2.0
"""At which the lattice is isotropic."""
CLAIMED, WITHIN = 64, 0.01
"""The text names this mesh for an error of this size."""
FORMS: dict[int, Callable[[float], float]] = {
    1: lambda c: 4 * c * (c + 1) / (2 * c + 1),
    2: lambda c: 8 * c * (c + 1) * (c + 2) / (2 * c + 3) / (3 * c + 2),
    3: lambda c: float(
        144
        * c
        * (c + 1)
        * np.polyval((4, 24, 41, 24, 4), c)
        / np.polyval((480, 2888, 5616, 4771, 1800, 236), c)
    ),
}
"""Brisard's closed forms: cells along an edge -> apparent stiffness (N/m) of χ."""
RATIOS = (0.01, 0.1, 1.0, 2.0, 10.0, 100.0)
"""χ at which the closed forms are tried: the range of Brisard's figure."""
PART = 1 / 20
"""Of the lattice's own error, seen to be 1/(2 N²), that a framed plate's uncertainty may be."""
WEAK = 1e-6
"""EA (N) of bars whose effect on a plate of 1 m is of first order."""


def tension(cells: int, material: kit.Material) -> tuple[kit.Box, kit.Problem]:
    """A square of so many metres under a total force of 1 N on its left and right."""
    edge = float(cells)
    box = kit.Box((edge, edge))
    corners = kit.Region((0.0, 0.0)), kit.Region((edge, 0.0))
    return box, kit.Problem(
        box,
        material,
        (kit.Support(corners[0], (0.0, 0.0)), kit.Support(corners[1], (None, 0.0))),
        (
            kit.Traction(box.side("right"), (1 / edge, 0.0)),
            kit.Traction(box.side("left"), (-1 / edge, 0.0)),
        ),
        name="published mesh in tension",
    )


def elastic(chi: float = CHI) -> kit.Isotropic:
    """The plate that Brisard's homogenisation gives at χ = 2, where the lattice is isotropic."""
    return kit.Isotropic(chi * (chi + 2) / (chi + 1), 1 / (1 + chi))


def apparent_stiffness(
    candidate: kit.DisplacementSolver, cells: int, chi: float = CHI, weights: str = "equal"
) -> float:
    """Total force over mean elongation (N/m) of a square mesh: 1 N² over the work of 1 N.

    The loads weigh elongations as the table's mean does, corners by half.
    """
    pattern, constants = patterns.square(), (chi, 1.0)
    box, problem = tension(cells, kit.Anisotropic(homogenise(pattern, constants).tensor))
    mesh = fill(pattern, box, (cells, cells))
    network = lattice_network(problem, mesh, constants, weights=weights)
    return float(1 / (network.force * candidate(problem, network, "linear")).sum())


def bare_plate(cells: int) -> float:
    """The same of the elastic plate, by finite elements."""
    box, problem = tension(cells, elastic())
    mesh = reference_fem.box_discretisation(box, 4, "Q2")
    move = reference_fem.solve_problem(problem, mesh).displacement
    return float(1 / (nodal_forces(problem, mesh) * move).sum())


def mesh_row(candidate: kit.DisplacementSolver, cells: int) -> dict[str, float]:
    """One row of the table `published`."""
    found = apparent_stiffness(candidate, cells)
    shared = apparent_stiffness(candidate, cells, weights="shared")
    E, fem = elastic().E, bare_plate(cells)
    frame = framed_plate.work(*tension(cells, elastic()), CHI / 2, PART / (2 * cells**2) / E)
    work, uncertainty = float(frame.value[0]), float(frame.uncertainty[0])
    return {
        "cells": cells,
        "stiffness_printed": PRINTED[cells],
        "stiffness": found,
        "from_printed": found / PRINTED[cells] - 1,
        "stiffness_elastic": E,
        "stiffness_bars": E + leading() / cells,
        "stiffness_fem": fem,
        "from_fem": found / fem - 1,
        "stiffness_framed": 1 / work,
        "framed_uncertainty": uncertainty / work,
        "from_framed": found * work - 1,
        "stiffness_shared": shared,
        "from_elastic": shared / E - 1,
    }


def form_row(candidate: kit.DisplacementSolver, cells: int, chi: float) -> dict[str, float]:
    """One row of the table `published_forms`."""
    found, form = apparent_stiffness(candidate, cells, chi), FORMS[cells](chi)
    return {
        "cells": cells,
        "chi": chi,
        "stiffness_form": form,
        "stiffness": found,
        "from_form": found / form - 1,
    }


def claimed(candidate: kit.DisplacementSolver) -> pd.DataFrame:
    """The table `published_claim`: the mesh named for 1 %, the last beyond it and the first within.

    By halving: the error falls with every cell.
    """

    @cache
    def too_stiff(cells: int) -> float:
        return apparent_stiffness(candidate, cells) / elastic().E - 1

    beyond, within = 1, 2 * CLAIMED
    while within - beyond > 1:
        middle = (beyond + within) // 2
        if abs(too_stiff(middle)) <= WITHIN:
            within = middle
        else:
            beyond = middle
    return pd.DataFrame(
        {
            "cells": n,
            "too_stiff": too_stiff(n),
            "too_stiff_printed": PRINTED[n] / elastic().E - 1 if n in PRINTED else "not printed",
        }
        for n in (CLAIMED, beyond, within)
    )


def leading() -> float:
    """N (stiffness - E) of large N in closed form (N/m): χ(1 + nu²)."""
    return CHI * (1 + elastic().nu ** 2)


def weak_frame() -> float:
    """The same by finite elements: from bars too weak for more than a first effect."""
    work = framed_plate.work_on(*tension(1, elastic()), WEAK, framed_plate.COARSEST)
    return (1 / work - elastic().E) / WEAK * CHI / 2
